"""A job array: its parts merge to the same bits as one run, in any order and after any trouble."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.ensembles.studies import points_a_chunk

import percuss as pc
from percuss.ensembles.array_parts import PartOfJob, parts_of_array
from percuss.ensembles.stored import stores_in
from percuss.execution import ArrayPart

OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine("2.5")
DAMPED = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")

pytestmark = pytest.mark.filterwarnings("ignore:.* have no answer")


def sweep(**how: Any) -> xr.Dataset:
    # Some starts lie behind the wall: their reasons travel, too.
    over = {"start.x0": np.linspace(-0.1, 1.0, 23), "start.v0": [0.5, 1.0, 1.5]}
    return pc.sweep(
        ["period", "peak_impact_velocity"], OSC, FORCE, over=over, transient=20, periods=16, **how
    )


def diagram(**how: Any) -> xr.Dataset:
    over = {"forcing.omega": np.linspace(2.4, 2.8, 12)}
    return pc.bifurcation_diagram(OSC, FORCE, over=over, transient=20, points=8, **how)


def basins(**how: Any) -> xr.Dataset:
    x0, v0 = np.linspace(-3.4, 1.6, 8), np.linspace(-2.0, 2.0, 5)
    return pc.basins(DAMPED, pc.cosine("1.5"), x0=x0, v0=v0, **how)


def fractions(**how: Any) -> xr.Dataset:
    return pc.basin_fractions(
        DAMPED, pc.cosine("1.5"), n_starts=20, x0=(-4, 0.7), v0=(-4, 4),
        over={"oscillator.stops.0.at": [1.2, 1.7]}, **how,
    )  # fmt: skip


def compute(call: Callable[..., xr.Dataset], store: Path, count: int) -> list[xr.Dataset]:
    """Compute all parts, the last one first, as a queue may do."""
    return [call(store=store, part=(i, count)) for i in range(count, 0, -1)]


@pytest.mark.parametrize("call", [sweep, diagram, basins, fractions])
def test_parts_merge_to_the_bits_of_one_run(
    call: Callable[..., xr.Dataset], tmp_path: Path
) -> None:
    store = tmp_path / "run.zarr"

    parts = compute(call, store, 3)
    n_points = pc.merge_parts(store)
    merged = call(store=store)

    assert all(part.attrs["complete"] == 1 and not part.data_vars for part in parts)
    assert n_points == sum(part.attrs["points"] for part in parts)
    stores = stores_in(store)
    assert n_points == sum(pc.status_of_store(inner)["points"] for inner in stores)
    assert merged.identical(call())


@pytest.mark.parametrize("count", [7, pytest.param(100, marks=pytest.mark.nightly)])
def test_a_job_array_merges_to_the_files_of_one_run(count: int, tmp_path: Path) -> None:
    """Chunk for chunk, the store is that of one run, but for the times at which they were done."""
    with points_a_chunk(16):
        compute(sweep, tmp_path / "array.zarr", count)
        pc.merge_parts(tmp_path / "array.zarr")
        sweep(store=tmp_path / "one.zarr")

    def chunks(store: Path) -> dict[str, bytes]:
        return {
            file.relative_to(store).as_posix(): file.read_bytes()
            for file in store.glob("*/c/**/*")
            if file.is_file() and not file.relative_to(store).as_posix().startswith("done")
        }

    assert len(chunks(tmp_path / "one.zarr")) > 10
    assert chunks(tmp_path / "array.zarr") == chunks(tmp_path / "one.zarr")
    counts = [pc.status_of_store(tmp_path / f"{name}.zarr") for name in ("array", "one")]
    assert counts[0]["n_impacts"] == counts[1]["n_impacts"] > 0


@pytest.mark.parametrize(
    ("size", "usual", "count"), [(69, 8192, 100), (69, 8192, 3), (10**6, 8192, 100), (5, 1, 2)]
)
def test_each_point_belongs_to_one_part_and_all_have_about_as_many(
    size: int, usual: int, count: int
) -> None:
    class Whole:
        chunk = usual

    whole: Any = Whole()
    whole.size = size
    job = PartOfJob(whole, ArrayPart(1, count))
    spans = [(i, min(i + job.chunk, size)) for i in range(0, size, job.chunk)]
    shares = [sum(b - a for a, b in spans[part::count]) for part in range(count)]

    assert job.chunk <= usual
    assert sum(shares) == size
    assert max(shares) <= -(-size // count) + job.chunk


def test_a_part_that_was_stopped_goes_on_and_the_merge_names_it(tmp_path: Path) -> None:
    store = tmp_path / "run.zarr"
    with points_a_chunk(4):
        for number in (1, 2):
            sweep(store=store, part=(number, 3))
        begun = sweep(store=store, part=(3, 3), progress=lambda *_: False, n_workers=1)
        assert begun.attrs["complete"] == 0
        assert pc.status_of_store(parts_of_array(store)[2])["points_done"] == 4

        with pytest.raises(pc.OutputError, match="part 3 of 3 is not complete; the same commands"):
            pc.merge_parts(store)
        assert not store.exists()

        assert sweep(store=store, part=(3, 3)).attrs["complete"] == 1
        pc.merge_parts(store)
        assert sweep(store=store).identical(sweep())


def test_missing_parts_and_parts_of_other_arrays_are_named(tmp_path: Path) -> None:
    store = tmp_path / "run.zarr"
    with pytest.raises(pc.OutputError, match=r"run\.zarr\.parts: no parts there"):
        pc.merge_parts(store)
    sweep(store=store, part=(2, 9))
    sweep(store=store, part=(7, 9))
    with pytest.raises(pc.OutputError, match="parts 1, 3, 4, 5, 6 and 2 others of 9 are not"):
        pc.merge_parts(store)
    diagram(store=store, part=(1, 2))
    with pytest.raises(pc.OutputError, match="of several arrays, of 2 and 9 parts; remove"):
        pc.merge_parts(store)


def test_parts_of_different_studies_are_not_merged(tmp_path: Path) -> None:
    ours, theirs = tmp_path / "a.zarr", tmp_path / "b.zarr"
    compute(sweep, ours, 2)
    compute(fractions, theirs, 2)
    shutil.rmtree(parts_of_array(ours)[1])
    shutil.copytree(parts_of_array(theirs)[1], parts_of_array(ours)[0].with_name("2-of-2.zarr"))

    with pytest.raises(pc.OutputError, match="a part of another study than the others"):
        pc.merge_parts(ours)


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ((0, 3), "not a part from 1 to their number"),
        ((4, 3), "not a part from 1 to their number"),
        ((1.5, 3), "not a part from 1 to their number"),
        ("3", "not a part and their number, such as 3/100"),
        ((1, 2, 3), "not a part and their number, such as 3/100"),
    ],
)
def test_what_is_no_part_is_refused(part: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        sweep(store=tmp_path / "a.zarr", part=part)


def test_a_part_needs_a_store() -> None:
    with pytest.raises(pc.ParameterError, match="needs store=, where the parts are put together"):
        sweep(part=(1, 2))
