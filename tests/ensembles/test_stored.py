"""What a store tells of itself, finished or not, whole or damaged."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.ensembles.studies import points_a_chunk

import percuss as pc
from percuss.ensembles.stored import rates_of

OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine(2.5)
ROOT = Path(__file__).parents[2]


def small(path: Path, **keywords: object) -> xr.Dataset:
    """Sweep over 200 points in 13 chunks."""
    over = {"forcing.omega": np.linspace(2.0, 2.9, 20), "start.v0": np.linspace(0.5, 1.0, 10)}
    with points_a_chunk(16):
        found: xr.Dataset = pc.sweep(
            ["period", "peak_impact_velocity"],
            OSC,
            FORCE,
            over=over,
            transient=20,
            periods=8,
            store=path,
            **keywords,  # type: ignore[arg-type]
        )
    return found


class stop_after:  # noqa: N801  called like a function
    """Watch a study, and stop it after some chunks."""

    def __init__(self, chunks: int) -> None:
        self._chunks = chunks
        self.done: list[float] = []

    def __call__(self, done: float, total: float) -> bool:
        assert done <= total
        self.done.append(done)
        return len(self.done) < self._chunks


@pytest.mark.filterwarnings("ignore:.* have no answer")
@pytest.mark.parametrize("kind", ["sweep", "diagram", "basins"])
def test_a_finished_store_gives_back_what_the_call_returned(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    over = {"forcing.omega": [2.5, 2.6, 1e200]}
    if kind == "sweep":
        found = pc.sweep(["period"], OSC, FORCE, over=over, transient=5, periods=4, store=path)
    elif kind == "diagram":
        found = pc.bifurcation_diagram(OSC, FORCE, over=over, transient=5, points=4, store=path)
    else:
        found = pc.basins(OSC, FORCE, x0=[0.0, 0.5], v0=[1.0, -0.5], periods=40, store=path)

    loaded = pc.load_store(path)

    assert loaded.attrs == found.attrs
    for name in found.variables:
        np.testing.assert_array_equal(loaded[name].values, found[name].values)


def test_a_store_that_is_not_finished_gives_what_is_done(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    small(path, progress=stop_after(4), n_workers=1)

    part, status = pc.load_store(path), pc.status_of_store(path)
    whole = small(path)

    done = np.isfinite(part.period.values)
    assert part.attrs["complete"] == 0
    assert done.sum() == status["points_done"] == 64
    np.testing.assert_array_equal(part.period.values[done], whole.period.values[done])
    assert part["start.v0"].equals(whole["start.v0"])
    assert part.peak_impact_velocity.attrs["units"] == "length/time"
    assert pc.load_store(path).attrs["complete"] == 1


def test_an_unfinished_diagram_can_be_loaded(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    over = {"forcing.omega": np.linspace(2.5, 2.6, 40)}

    pc.bifurcation_diagram(
        OSC, FORCE, over=over, transient=5, points=4, store=path, progress=stop_after(1),
        n_workers=1,
    )  # fmt: skip

    status, part = pc.status_of_store(path), pc.load_store(path)
    assert (status["points"], status["points_done"]) == (120, 40)
    assert part.branch.values.tolist() == ["forward", "backward", "start 0"]
    assert np.isfinite(part.points.sel(branch="forward")).all()
    assert np.isnan(part.points.sel(branch="start 0")).all()


def test_rates_are_those_of_the_last_chunks_without_the_pauses() -> None:
    # Two a second, a night, two a second.
    times = np.concatenate([np.arange(10) * 0.5, 40_000 + np.arange(10) * 0.5])
    points, impacts = np.full(20, 100), np.full(20, 3000)

    per_second = np.array(rates_of(times, points, impacts), dtype=np.float64)

    np.testing.assert_allclose(per_second, [200.0, 6000.0])
    assert rates_of(times[:1], points[:1], impacts[:1]) == (None, None)


def test_a_chunk_that_was_cut_off_is_done_again_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    whole = small(path)
    files = sorted((path / "period" / "c").iterdir(), key=lambda file: int(file.name))
    files[3].write_bytes(files[3].read_bytes()[:5])
    files[7].unlink()
    count = stop_after(1000)

    again = small(path, progress=count)

    assert again.identical(whole)
    # 16 points each.
    assert count.done == [184.0, 200.0]


def test_a_store_that_lost_a_part_is_reported_and_mended_by_the_same_call(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    whole = small(tmp_path / "b.zarr")
    small(path, progress=stop_after(2))
    (path / "period" / "zarr.json").unlink()

    for look in (pc.status_of_store, pc.load_store):
        with pytest.raises(pc.OutputError, match=r"lost its period/zarr\.json; the command that"):
            look(path)
    assert small(path).identical(whole)


@pytest.mark.parametrize("what", ["cut", "other format", "not ours"])
def test_a_store_of_another_version_is_refused(what: str, tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    small(path, progress=stop_after(1))
    meta = path / "zarr.json"
    content = json.loads(meta.read_text(encoding="utf-8"))
    if what == "other format":
        content["attributes"]["percuss"] |= {"format": 1, "version": "0.0.9"}
    elif what == "not ours":
        content["attributes"] = {"other": 1}
    text = json.dumps(content)
    meta.write_text(text[: len(text) // 2] if what == "cut" else text, encoding="utf-8")
    message = {
        "cut": "damaged store",
        "other format": r"a store of format 1, written by percuss 0\.0\.9; this is percuss",
        "not ours": "no store of percuss",
    }[what]

    for call in (small, pc.status_of_store, pc.load_store):
        with pytest.raises(pc.OutputError, match=message):
            call(path)


def test_a_diagram_does_not_go_into_the_store_of_a_sweep(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    small(path, progress=stop_after(1))

    with pytest.raises(pc.OutputError, match="no diagram"):
        pc.bifurcation_diagram(OSC, FORCE, over={"forcing.omega": [2.5]}, store=path)


@pytest.mark.filterwarnings("ignore:.* have no answer")
@pytest.mark.skipif(os.name != "posix", reason="limits of a process are POSIX's")
def test_a_disk_that_takes_no_more_leaves_what_was_finished(tmp_path: Path) -> None:
    """With a limit on the size of files, which a chunk of sixteen points reaches at once."""
    path = tmp_path / "a.zarr"
    program = (
        "import sys, resource, numpy as np, percuss as pc\n"
        "from tests.ensembles.studies import points_a_chunk\n"
        "def go_on(done, total):\n"
        "    if done > 0:\n"
        "        resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))\n"
        "    return True\n"
        "with points_a_chunk(16):\n"
        "  pc.sweep(['period', 'peak_impact_velocity'], pc.impact_oscillator('0.8'),\n"
        "    pc.cosine(2.5), over={'forcing.omega': np.linspace(2.0, 2.9, 20),\n"
        "    'start.v0': np.linspace(0.5, 1.0, 10)}, transient=20, periods=8,\n"
        "    store=sys.argv[1], progress=go_on, n_workers=1)\n"
    )
    command = [sys.executable, "-c", program, str(path)]

    process = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)

    assert "OutputError" in process.stderr
    assert process.stderr.strip().splitlines()[-1].endswith("what was finished is kept")
    assert pc.status_of_store(path)["done"] == 1
    assert small(path).attrs["complete"] == 1
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY
