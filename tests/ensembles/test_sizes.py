"""Answers that no machine holds are refused in a sentence, before anything is done."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import percuss as pc
from percuss.cli import app
from percuss.ensembles import job, run_job

OSC, FORCE = pc.impact_oscillator("0.8"), pc.cosine(2.5)
MANY = np.linspace(1.0, 2.0, 20_000)
CALLS: dict[str, tuple[Callable[[Path], object], str]] = {
    "sweep": (
        lambda path: pc.sweep(
            "period", OSC, FORCE, store=path,
            over={"forcing.omega": MANY, "start.x0": MANY, "start.v0": MANY},
        ),
        "8,000,000,000,000 points, whose answer takes 64,000 GB in a store and as much beside",
    ),
    "sweep without a store": (
        lambda _: pc.sweep(
            "period", OSC, FORCE,
            over={"forcing.omega": MANY, "start.x0": MANY, "start.v0": MANY},
        ),
        "64,000 GB; this machine has .* of memory to be had; with store= it is kept on disk",
    ),
    "periods": (
        lambda path: pc.sweep(
            "period", OSC, FORCE, over={"forcing.omega": [2.0]}, periods=10**14, store=path
        ),
        r"^periods = 1.*found from a strobe in each; 1 point, whose answer takes",
    ),
    "diagram": (
        lambda path: pc.bifurcation_diagram(
            OSC, FORCE, over={"forcing.omega": [2.0, 2.5]}, points=10**13, store=path
        ),
        "^points = 10000000000000: 10,000,000,000,000 at each of 6 points, whose answer takes",
    ),
    "basins": (
        lambda path: pc.basins(
            OSC, FORCE, x0=np.linspace(0, 1, 100_000), v0=np.linspace(0, 1, 100_000), store=path
        ),
        "10,000,000,000 points, whose answer takes",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", CALLS)
def test_what_no_machine_holds_is_a_sentence(what: str, tmp_path: Path) -> None:
    call, message = CALLS[what]

    with pytest.raises(pc.ParameterError, match=message):
        call(tmp_path / "a.zarr")

    assert not (tmp_path / "a.zarr").exists()


def test_an_answer_beyond_memory_needs_a_store_and_is_read_from_its_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    over = {"forcing.omega": MANY[::200], "start.v0": [0.5, 1.0]}
    expected = pc.sweep("impacts_per_period", OSC, FORCE, over=over, transient=5, periods=5)
    monkeypatch.setattr(job, "memory", lambda: 1000)

    with pytest.raises(
        pc.ParameterError, match=r"200 points.*1\.6e-06 GB; .*with store= it is kept"
    ):
        pc.sweep("impacts_per_period", OSC, FORCE, over=over, transient=5, periods=5)
    data = pc.sweep(
        "impacts_per_period", OSC, FORCE, over=over, transient=5, periods=5, store=tmp_path / "a"
    )

    assert data.identical(expected)
    assert isinstance(data.impacts_per_period.values.base, np.memmap)
    # The room beside the chunks goes with the answer.
    assert {entry.name for entry in (tmp_path / "a").iterdir()} == {
        "zarr.json", "done", "reasons", "impacts_per_period",
    }  # fmt: skip
    assert pc.load_store(tmp_path / "a").identical(expected)


def test_a_large_answer_is_announced_before_the_work(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(run_job, "LARGE", 1000)
    over = {"forcing.omega": MANY[::200], "start.v0": [0.5, 1.0]}

    pc.sweep("impacts_per_period", OSC, FORCE, over=over, transient=5, periods=5)
    (reported,) = caplog.messages
    assert re.fullmatch(r"200 points in chunks of \d.*, whose answer takes 1.6e-06 GB .*", reported)
    caplog.clear()
    pc.sweep("impacts_per_period", OSC, FORCE, over=over, transient=5, periods=5, progress=False)
    assert caplog.messages == []


def test_memory_is_what_is_to_be_had_and_not_what_is_built_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built_in = job.memory()
    for name, text in (
        ("AVAILABLE", "MemTotal: 999 kB\nMemAvailable: 100 kB\n"),
        ("GROUP_MOST", "60000\n"),
        ("GROUP_TAKEN", "20000\n"),
    ):
        (tmp_path / name).write_text(text, encoding="ascii")
        monkeypatch.setattr(job, name, tmp_path / name)

    assert job.memory() == 40_000
    (tmp_path / "GROUP_MOST").write_text("max\n", encoding="ascii")
    assert job.memory() == 102_400 < built_in


def test_a_study_of_too_many_points_is_a_fault_of_its_file(tmp_path: Path) -> None:
    study = tmp_path / "s.toml"
    axis = "{from = 1, to = 2, count = 2000000}"
    study.write_text(
        '[study]\nkind = "sweep"\n[[forcing.harmonics]]\namplitude = 1\nomega = 2\n'
        f'[over]\n"forcing.omega" = {axis}\n"start.x0" = {axis}\n[sweep]\nmeasure = "period"\n',
        encoding="utf-8",
    )

    result = CliRunner().invoke(app, ["run", str(study), "--out", str(tmp_path / "out")])

    assert result.exit_code == 2
    assert "2,000,000 x 2,000,000: 4,000,000,000,000 points, whose answer takes" in result.output
