"""What befalls the files of a store: it is seen, and what is lost is done again."""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr
from tests.ensembles.studies import failing, points_a_chunk
from typer.testing import CliRunner

import percuss as pc
from percuss.cli import app
from percuss.ensembles import store as store_module

RUNNER = CliRunner()
ROOT = Path(__file__).parents[2]
OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine(2.5)


def small(path: Path, chunks: int | None = None) -> xr.Dataset:
    """Sweep over 200 points in 13 chunks, or stop after some."""
    count = itertools.count(1)
    over = {"forcing.omega": np.linspace(2.0, 2.9, 20), "start.v0": np.linspace(0.5, 1.0, 10)}
    with points_a_chunk(16):
        found: xr.Dataset = pc.sweep(
            ["period", "peak_impact_velocity"], OSC, FORCE, over=over, transient=20, periods=8,
            store=path, n_workers=1, progress=lambda *_: chunks is None or next(count) < chunks,
        )  # fmt: skip
    return found


def status_and_load(path: Path) -> tuple[int, int]:
    """Return how many points are done by `status`, and how many are in what is loaded."""
    found = pc.load_store(path)
    assert np.array_equal(np.isfinite(found.period), np.isfinite(found.peak_impact_velocity))
    return pc.status_of_store(path)["points_done"], int(np.isfinite(found.period).sum())


def flip(file: Path, at: int) -> None:
    content = bytearray(file.read_bytes())
    content[at] ^= 4
    file.write_bytes(bytes(content))


@pytest.mark.parametrize("size", [0, 4, 8, 19, 21])
def test_a_mark_that_is_cut_or_longer_is_none(size: int, tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    whole = small(path)
    os.truncate(path / "done" / "c" / "4", size)

    assert status_and_load(path) == (184, 184)
    assert small(path).identical(whole)
    assert status_and_load(path) == (200, 200)


@pytest.mark.parametrize("size", [0, 100])
@pytest.mark.parametrize("chunks", [5, None])
def test_a_cut_chunk_counts_as_not_done(size: int, chunks: int | None, tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    whole = small(tmp_path / "b.zarr")
    small(path, chunks)
    before, _ = status_and_load(path)
    os.truncate(path / "period" / "c" / "0", size)

    assert status_and_load(path) == (before - 16, before - 16)
    status = RUNNER.invoke(app, ["status", str(path)])
    assert f"{before - 16} of 200 points" in status.output
    export = RUNNER.invoke(app, ["export", str(path), str(tmp_path / "a.csv")])
    assert "a part is not done yet" in export.output
    assert small(path).identical(whole)


@pytest.mark.parametrize("at", [0, 63, 127, -1])
def test_a_flipped_bit_is_seen_by_us_and_by_zarr(at: int, tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    whole = small(path)
    flip(path / "period" / "c" / "3", at)

    with pytest.raises(ValueError, match="checksum"):
        zarr.open_array(str(path / "period"), mode="r")[:]
    assert np.isnan(pc.load_store(path).period).sum() == 16
    assert small(path).identical(whole)
    np.testing.assert_array_equal(
        zarr.open_array(str(path / "period"), mode="r")[:], whole.period.values.ravel()
    )


@pytest.mark.filterwarnings("ignore:.* have no answer")
def test_damaged_reasons_are_found(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    over = {"forcing.omega": np.linspace(2.0, 3.0, 40)}
    whole = pc.sweep(failing, OSC, FORCE, over=over, store=path)
    flip(path / "reasons" / "c" / "2" / "0", 30)

    assert pc.load_store(path).attrs["complete"] == 0
    assert pc.sweep(failing, OSC, FORCE, over=over, store=path).identical(whole)
    assert pc.load_store(path).identical(whole)


def test_a_cut_description_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    small(path, 2)
    os.truncate(path / "zarr.json", 300)

    for call in (pc.status_of_store, pc.load_store, small):
        with pytest.raises(pc.OutputError, match=r"its zarr\.json.*put a copy of that file back"):
            call(path)


def test_a_cut_result_is_reported_and_written_again(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"

    def found() -> xr.Dataset:
        over = {"forcing.omega": [2.5, 2.6]}
        return pc.bifurcation_diagram(OSC, FORCE, over=over, transient=5, points=4, store=path)

    whole = found()
    os.truncate(path / "result.nc", 1000)

    with pytest.raises(pc.OutputError, match=r"result\.nc is damaged; remove that file"):
        pc.load_store(path)
    (path / "result.nc").unlink()
    assert found().identical(whole)
    assert pc.load_store(path).attrs == whole.attrs


def test_a_copy_has_the_rate_of_what_it_was_copied_from(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    small(path)
    shutil.copytree(path, tmp_path / "b.zarr", copy_function=shutil.copyfile)

    one, other = (pc.status_of_store(tmp_path / name) for name in ("a.zarr", "b.zarr"))

    assert one["impacts_per_second"] == other["impacts_per_second"]
    assert one["impacts_per_second"] > 0.0


def test_a_store_that_was_killed_while_it_was_made_is_reported_as_begun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.zarr"

    def die(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(store_module, "_make_array", die)
    with pytest.raises(KeyboardInterrupt):
        small(path)
    monkeypatch.undo()

    status = RUNNER.invoke(app, ["status", str(path)])
    assert (status.exit_code, "0.0%: 0 of 200 points" in status.output) == (0, True), status.output
    with pytest.raises(pc.OutputError, match="was begun, and holds nothing yet; the same command"):
        pc.load_store(path)
    assert small(path).identical(small(tmp_path / "b.zarr"))


def test_a_group_without_attributes_is_somebody_elses(tmp_path: Path) -> None:
    zarr.create_group(str(tmp_path / "a.zarr"))

    with pytest.raises(pc.OutputError, match="Zarr data that are no store of percuss"):
        pc.status_of_store(tmp_path / "a.zarr")


def test_the_checksum_costs_little_against_the_file(tmp_path: Path) -> None:
    """A chunk of the usual size, to which another ten would not be noticed."""
    from google_crc32c import value

    content = np.random.default_rng(1).normal(size=8192).tobytes()
    rounds, took = 200, {"write": 0.0, "sum": 0.0}
    for _ in range(rounds):
        began = time.process_time()
        (tmp_path / "a").write_bytes(content)
        took["write"] += time.process_time() - began
        began = time.process_time()
        value(content)
        took["sum"] += time.process_time() - began

    assert took["sum"] < took["write"]


@pytest.mark.skipif(os.name != "posix", reason="limits of a process are POSIX's")
def test_a_full_disk_under_the_results_is_a_sentence(tmp_path: Path) -> None:
    """With a limit on the size of files, as a disk that is full after so many bytes."""
    program = (
        "import resource, signal, sys\n"
        "from percuss.cli import app\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, resource.RLIM_INFINITY))\n"
        "app(sys.argv[1:])\n"
    )
    small(tmp_path / "a.zarr")
    command = [sys.executable, "-c", program, "export", "a.zarr", "a.nc"]

    process = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)

    assert process.returncode == 2, process.stderr
    assert "ile too large" in process.stderr
    assert not [file for file in tmp_path.iterdir() if file.name != "a.zarr"]


def test_results_are_written_though_a_cluster_was_lost(tmp_path: Path) -> None:
    """Whoever loses a Dask cluster is left with its scheduler as the one that xarray asks for."""
    dask = pytest.importorskip("dask")
    pytest.importorskip("distributed")
    over = {"forcing.omega": [2.5]}
    with dask.config.set(scheduler="dask.distributed"):
        pc.bifurcation_diagram(
            OSC, FORCE, over=over, transient=5, points=4, store=tmp_path / "a.zarr"
        )

    assert pc.load_store(tmp_path / "a.zarr").attrs["complete"] == 1
