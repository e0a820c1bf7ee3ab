"""A store goes on where it was, with the same bits, whatever has happened to it."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pytest
from tests.children import begun
from tests.ensembles.studies import chart, exponents, failing, whole_chart

import percuss as pc
from percuss.ensembles import store as store_module
from percuss.ensembles.job import Block
from percuss.ensembles.store import REASON_BYTES, reasons_as_bytes

ROOT = Path(__file__).parents[2]


def chunks(path: Path) -> int:
    found = pc.status_of_store(path)["chunks"]
    assert isinstance(found, int)
    return found


def done(path: Path) -> int:
    try:
        found = pc.status_of_store(path)["done"]
    except pc.OutputError:
        return 0
    assert isinstance(found, int)
    return found


def kill_again_and_again(study: str, path: Path, kills: int) -> list[int]:
    """Run a study in processes of their own, killed each time they have got on; tell how far."""
    seen = []
    for _ in range(kills):
        before = done(path)
        with begun(
            [sys.executable, "-m", "tests.ensembles.studies", str(path), study], cwd=ROOT
        ) as process:
            while process.poll() is None and done(path) <= before:
                time.sleep(0.01)
        seen.append(done(path))
    # It was killed while it had work left, and never lost any.
    assert seen == sorted(seen)
    assert 0 < seen[0] < chunks(path)
    return seen


@pytest.mark.parametrize("kills", [1, pytest.param(3, marks=pytest.mark.nightly)])
def test_killed_again_and_again_it_ends_with_the_same_bits(kills: int, tmp_path: Path) -> None:
    path = tmp_path / "chart.zarr"
    seen = kill_again_and_again("chart", path, kills)
    points = pc.status_of_store(path)["points_done"]
    calls: set[float] = set()

    def count(now: float, total: float) -> bool:  # noqa: ARG001
        # By the clock it is called besides, with what was done before.
        calls.update([now] if now > points else [])
        return True

    resumed = chart(str(path), progress=count)

    assert resumed.identical(whole_chart())
    assert len(calls) == chunks(path) - seen[-1]
    assert resumed.attrs["complete"] == 1


@pytest.mark.nightly
def test_a_large_chart_killed_ten_times_has_the_bits_of_one_go(tmp_path: Path) -> None:
    """The largest exponent over 400 x 400 points."""
    path = tmp_path / "exponents.zarr"
    seen = kill_again_and_again("exponents", path, 10)

    resumed = exponents(str(path))

    assert len(set(seen)) == 10
    assert resumed.identical(exponents())


def test_a_chunk_without_its_mark_is_done_again(tmp_path: Path) -> None:
    path = tmp_path / "chart.zarr"
    whole = chart(str(path))
    chunk = next(iter(sorted((path / "period" / "c").iterdir())))
    chunk.unlink()
    (path / "done" / "c" / chunk.name).unlink()

    again = chart(str(path))

    assert again.identical(whole)
    assert chunk.exists()


def test_a_store_of_another_study_is_refused(tmp_path: Path) -> None:
    path = str(tmp_path / "a.zarr")
    osc, force = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)
    keywords = {"transient": 5, "periods": 5, "store": path}
    pc.sweep("period", osc, force, over={"forcing.omega": [2.0, 2.5]}, **keywords)  # type: ignore[arg-type]

    with pytest.raises(pc.OutputError, match="another study, which differs in over"):
        pc.sweep("period", osc, force, over={"forcing.omega": [2.0, 2.6]}, **keywords)  # type: ignore[arg-type]
    with pytest.raises(pc.OutputError, match="another study, which differs in measure"):
        pc.sweep(
            "impacts_per_period",
            osc,
            force,
            over={"forcing.omega": [2.0, 2.5]},
            **keywords,  # type: ignore[arg-type]
        )


def test_a_store_of_other_code_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = str(tmp_path / "a.zarr")
    chart(path, progress=lambda now, _: now == 0)
    monkeypatch.setattr(store_module, "code_hash", lambda: "other")

    with pytest.raises(pc.OutputError, match="begun by other code"):
        chart(path)


def test_what_is_no_store_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "text").write_text("mine", encoding="utf-8")

    with pytest.raises(pc.OutputError, match="no store of percuss"):
        chart(str(tmp_path / "notes"))
    (tmp_path / "rig.fit").write_bytes(b"")
    with pytest.raises(
        pc.OutputError, match="a file and no store; if a fit keeps its search there"
    ):
        pc.status_of_store(tmp_path / "rig.fit")
    with pytest.raises(pc.OutputError, match="no store there"):
        pc.status_of_store(tmp_path / "nothing")
    assert (tmp_path / "notes" / "text").read_text(encoding="utf-8") == "mine"


def test_a_lost_description_is_reported_and_mended_by_the_same_call(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    chart(str(path), progress=lambda now, _: now == 0)
    (path / "period" / "zarr.json").write_text("{", encoding="utf-8")

    with pytest.raises(pc.OutputError, match=r"period/zarr\.json is cut off.*mends that"):
        pc.status_of_store(path)
    assert chart(str(path)).identical(whole_chart())
    assert pc.status_of_store(path)["points_done"] == 300


def test_a_full_disk_is_reported_and_what_was_finished_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.zarr"
    write = store_module.Store.write
    written: list[int] = []

    def fail(self: store_module.Store, number: int, block: Block) -> None:
        if len(written) == 2:
            with store_module.store_faults(self.path):
                raise OSError(28, "No space left on device")
        written.append(number)
        write(self, number, block)

    monkeypatch.setattr(store_module.Store, "write", fail)
    with pytest.raises(pc.OutputError, match="No space left on device; what was finished is kept"):
        chart(str(path))
    monkeypatch.undo()

    assert done(path) == 2
    assert chart(str(path)).identical(whole_chart())


def test_reasons_come_back_from_a_store(tmp_path: Path) -> None:
    osc, force = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)
    over = {"forcing.omega": np.linspace(2.0, 3.0, 40)}

    with pytest.warns(UserWarning, match="20 of 40 points have no answer"):
        kept = pc.sweep(failing, osc, force, over=over, store=str(tmp_path / "a.zarr"))

    with pytest.warns(UserWarning, match="20 of 40 points have no answer"):
        assert kept.identical(pc.sweep(failing, osc, force, over=over))
    assert len(kept.reason) == 20


def test_reasons_that_do_not_fit_are_cut() -> None:
    long = {i: f"{i} " + "x" * 10_000 for i in range(1000)}

    assert len(reasons_as_bytes(long)) == REASON_BYTES
