"""Answers that no machine holds are refused in a sentence, before anything is done."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import percuss as pc
from percuss.cli import app

OSC, FORCE = pc.impact_oscillator("0.8"), pc.cosine(2.5)
MANY = np.linspace(1.0, 2.0, 20_000)
CALLS: dict[str, tuple[Callable[[Path], object], str]] = {
    "sweep": (
        lambda path: pc.sweep(
            "period", OSC, FORCE, store=path,
            over={"forcing.omega": MANY, "start.x0": MANY, "start.v0": MANY},
        ),
        "8,000,000,000,000 points, whose answer takes 64,000 GB; this machine has",
    ),
    "periods": (
        lambda path: pc.sweep(
            "period", OSC, FORCE, over={"forcing.omega": [2.0]}, periods=10**25, store=path
        ),
        r"^periods = 1.*told from a strobe in each; 1 point, whose answer takes",
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


def test_a_study_of_too_many_points_is_a_fault_of_its_file(tmp_path: Path) -> None:
    study = tmp_path / "s.toml"
    axis = "{from = 1, to = 2, count = 2000000}"
    study.write_text(
        '[study]\nkind = "sweep"\n[[forcing.harmonics]]\namplitude = 1\nomega = 2\n'
        f'[over]\n"forcing.omega" = {axis}\n"start.x0" = {axis}\n[sweep]\nmeasure = "period"\n',
        encoding="utf-8",
    )

    found = CliRunner().invoke(app, ["run", str(study), "--out", str(tmp_path / "out")])

    assert found.exit_code == 2
    assert "2,000,000 x 2,000,000: 4,000,000,000,000 points, whose answer takes" in found.output
