"""The commands `percuss status` and `percuss export`."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.ensembles.studies import points_a_chunk
from typer.testing import CliRunner

import percuss as pc
from percuss.cli import app
from percuss.ensembles.store import write_chunk

RUNNER = CliRunner()
OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine(2.5)
OVER = {"forcing.omega": np.linspace(2.0, 2.9, 20), "start.v0": np.linspace(0.5, 1.0, 10)}


def sweep(path: Path, *, stop: bool = False) -> xr.Dataset:
    with points_a_chunk(16):
        found: xr.Dataset = pc.sweep(
            "peak_impact_velocity", OSC, FORCE, over=OVER, transient=20, periods=8, store=path,
            n_workers=1, progress=lambda *_: not stop,
        )  # fmt: skip
    return found


def test_status_shows_how_far_a_store_is(tmp_path: Path) -> None:
    path = tmp_path / "run.zarr"
    sweep(path, stop=True)
    begun = RUNNER.invoke(app, ["status", str(path)])
    sweep(path)
    done = RUNNER.invoke(app, ["status", str(path)])

    assert begun.exit_code == done.exit_code == 0
    assert (
        "peak_impact_velocity over forcing.harmonics.0.omega (20) x start.v0 (10)" in begun.output
    )
    assert "8.0%: 16 of 200 points, 1 of 13 chunks" in begun.output
    assert " ago" in begun.output
    assert "100.0%: 200 of 200 points" in done.output
    assert "none, it is complete" in done.output
    assert "a second" in done.output


def test_export_writes_what_the_call_returned(tmp_path: Path) -> None:
    path = tmp_path / "run.zarr"
    found = sweep(path)

    for name in ("a.nc", "a.csv"):
        result = RUNNER.invoke(app, ["export", str(path), str(tmp_path / name)])
        assert result.exit_code == 0, result.output
        assert "wrote" in result.output

    again = pc.load_netcdf(tmp_path / "a.nc")
    assert isinstance(again, xr.Dataset)
    np.testing.assert_array_equal(again.peak_impact_velocity, found.peak_impact_velocity)
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    rows = [line for line in lines if not line.startswith("#")]
    assert rows[0] == "forcing.omega,start.v0,peak_impact_velocity"
    assert len(rows) == 201
    assert float(rows[-1].split(",")[2]) == float(found.peak_impact_velocity[-1, -1])


def test_export_of_a_part_says_so(tmp_path: Path) -> None:
    path = tmp_path / "run.zarr"
    sweep(path, stop=True)

    result = RUNNER.invoke(app, ["export", str(path), str(tmp_path / "a.nc")])

    assert result.exit_code == 0, result.output
    assert "a part is not done yet" in result.output


def test_export_says_where_the_data_lie_for_other_programs(tmp_path: Path) -> None:
    path, file = tmp_path / "run.zarr", tmp_path / "a.nc"
    found = sweep(path)

    result = RUNNER.invoke(app, ["export", str(path), str(file)])

    assert f"percuss.load_netcdf and xarray.open_dataset({str(file)!r}) read it" in result.output
    with xr.open_dataset(file, engine="h5netcdf") as again:
        np.testing.assert_array_equal(again.peak_impact_velocity, found.peak_impact_velocity)


def test_status_shows_each_store_in_a_folder_by_itself(tmp_path: Path) -> None:
    sweep(tmp_path / "a.zarr", stop=True)
    sweep(tmp_path / "b.zarr")
    pc.bifurcation_diagram(
        OSC, FORCE, over={"forcing.omega": [2.5, 2.6]}, transient=5, points=4,
        store=tmp_path / "c.zarr",
    )  # fmt: skip

    result = RUNNER.invoke(app, ["status", str(tmp_path)])

    assert result.exit_code == 0, result.output
    first, second, diagram = result.output.split("\n\n")
    assert "a.zarr" in first
    assert "16 of 200 points" in first
    assert "b.zarr" in second
    assert "200 of 200 points" in second
    # Both parts of a diagram are one study.
    assert "6 of 6 points" in diagram
    with pytest.raises(pc.OutputError, match=r"holds a\.zarr, b\.zarr, c\.zarr; name one of them"):
        pc.load_store(tmp_path)


def test_status_shows_no_time_left_where_nothing_runs(tmp_path: Path) -> None:
    path = tmp_path / "run.zarr"
    with points_a_chunk(16):
        pc.sweep(
            "peak_impact_velocity", OSC, FORCE, over=OVER, transient=20, periods=8, store=path,
            n_workers=1, progress=lambda done, _: done < 80,
        )  # fmt: skip
    marks = sorted((path / "done" / "c").iterdir(), key=lambda mark: int(mark.name))
    now = time.time()
    outputs = []
    for ago in (1.0, 3600.0):
        for i, mark in enumerate(marks):
            write_chunk(mark, np.array([20, int(1e6 * (now - ago - i))]))
        outputs.append(RUNNER.invoke(app, ["status", str(path)]).output)

    assert "if it is running" in outputs[0]
    assert "time left" not in outputs[1]
    assert "not running as it seems; the rest would take" in " ".join(outputs[1].split())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["status", "nothing"], "nothing: no store there"),
        (["export", "nothing", "a.nc"], "nothing: no store there"),
        (["export", "nothing", "a.txt"], "neither .nc (NetCDF) nor .csv"),
        # The folder that one is in, and one without a name.
        (["merge", "."], ".parts: no parts there"),
        (["merge", "/"], ".parts: no parts there"),
    ],
)
def test_what_cannot_be_is_one_line_and_status_2(arguments: list[str], message: str) -> None:
    result = RUNNER.invoke(app, arguments)

    assert result.exit_code == 2
    assert message in result.output
    assert len(result.output.strip().splitlines()) == 1


def test_a_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    path, file = tmp_path / "run.zarr", tmp_path / "a.csv"
    sweep(path)
    file.write_text("mine", encoding="utf-8")

    refused = RUNNER.invoke(app, ["export", str(path), str(file)])
    kept = file.read_text(encoding="utf-8")
    forced = RUNNER.invoke(app, ["export", str(path), str(file), "--force"])

    assert (refused.exit_code, kept, forced.exit_code) == (2, "mine", 0)
    assert "--force replaces it" in refused.output
