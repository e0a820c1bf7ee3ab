"""What other people keep where a store is wanted is refused, told, and never removed."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.ensembles.studies import points_a_chunk
from typer.testing import CliRunner

import percuss as pc
from percuss.cli import app
from percuss.ensembles import store as store_module
from percuss.ensembles.lock import StoreLock
from percuss.progress import Report

OSC, FORCE = pc.impact_oscillator("0.8"), pc.cosine("2.5")
OVER = {"forcing.omega": [2.4, 2.5]}
STUDY = """[study]
kind = "sweep"
[oscillator]
stops = [{ type = "wall", at = 0, side = "below", restitution = "0.8" }]
[[forcing.harmonics]]
amplitude = 1
omega = "2.5"
[over]
"forcing.omega" = [2.4, 2.5]
[sweep]
measure = "period"
[save]
netcdf = false
[draw]
png = false
svg = false
"""
CALLS: dict[str, Callable[[Path], xr.Dataset]] = {
    "sweep": lambda path: pc.sweep("period", OSC, FORCE, over=OVER, store=path),
    "diagram": lambda path: pc.bifurcation_diagram(
        OSC, FORCE, over=OVER, transient=5, points=4, store=path
    ),
    "basins": lambda path: pc.basins(OSC, FORCE, x0=[0.0, 1.0], v0=[0.0], store=path),
    "fractions": lambda path: pc.basin_fractions(
        OSC, FORCE, over=OVER, x0=(0, 1), v0=(0, 1), n_starts=2, store=path
    ),
}


def foreign(path: Path) -> Path:
    """Write a Zarr group of somebody else's, without attributes, and a note in it."""
    xr.Dataset({"precious": ("x", np.arange(1000.0))}).to_zarr(
        path, zarr_format=3, consolidated=False
    )
    (path / "notes.txt").write_text("mine", encoding="utf-8")
    return path


def several(store: Path | None, progress: Report = None) -> xr.Dataset:
    """Return a sweep of four chunks, into a store."""
    over = {"forcing.omega": np.linspace(2.0, 3.0, 40)}
    with points_a_chunk(10):
        return pc.sweep(
            "period", OSC, FORCE, over=over, transient=5, store=store, progress=progress
        )


def files_in(path: Path) -> dict[str, bytes]:
    """Return all that is in a folder."""
    inside = (it for it in path.rglob("*") if it.is_file())
    return {str(it.relative_to(path)): it.read_bytes() for it in inside}


@pytest.mark.parametrize("call", CALLS)
def test_zarr_data_of_somebody_else_are_refused_and_stay(call: str, tmp_path: Path) -> None:
    path = foreign(tmp_path / "data.zarr")
    before = files_in(path)

    with pytest.raises(pc.OutputError, match="Zarr data that are no store of percuss"):
        CALLS[call](path)

    assert files_in(path) == before


def test_the_command_refuses_them_too_and_status_says_whose_they_are(tmp_path: Path) -> None:
    path = foreign(tmp_path / "data.zarr")
    before = files_in(path)
    (tmp_path / "s.toml").write_text(STUDY, encoding="utf-8")
    run = ["run", str(tmp_path / "s.toml"), "--out", str(tmp_path / "out"), "--store", str(path)]

    for command in (run, ["status", str(path)], ["export", str(path), str(tmp_path / "a.nc")]):
        result = CliRunner().invoke(app, command)
        assert result.exit_code == 2
        assert "Zarr data that are no store of percuss" in result.output

    assert files_in(path) == before


@pytest.mark.parametrize("text", ["{}", "[]", '{"attributes": []}', '{"node_type": "array"}'])
def test_a_description_of_any_other_form_is_somebody_elses(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.zarr").mkdir()
    (tmp_path / "a.zarr" / "zarr.json").write_text(text, encoding="utf-8")

    with pytest.raises(pc.OutputError, match="Zarr data that are no store of percuss"):
        several(tmp_path / "a.zarr")
    assert files_in(tmp_path / "a.zarr") == {"zarr.json": text.encode()}


def test_a_folder_of_stores_shows_those_that_are_percusss(tmp_path: Path) -> None:
    foreign(tmp_path / "data.zarr")
    with pytest.raises(pc.OutputError, match="no store there"):
        pc.status_of_store(tmp_path)
    CALLS["sweep"](tmp_path / "run.zarr")

    result = CliRunner().invoke(app, ["status", str(tmp_path)])

    assert result.exit_code == 0
    assert "run.zarr" in result.output
    assert "data.zarr" not in result.output


def test_a_diagram_does_not_settle_among_the_files_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "result.nc").write_text("mine", encoding="utf-8")

    with pytest.raises(pc.OutputError, match="exists and is no store of percuss; it is left"):
        CALLS["diagram"](tmp_path)

    assert files_in(tmp_path) == {"result.nc": b"mine"}


@pytest.mark.parametrize("made", ["folder", "marker", "array"])
def test_a_store_that_was_killed_while_it_was_made_is_made_by_the_same_call(
    made: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.zarr"
    before = CALLS["sweep"](tmp_path / "whole.zarr")

    class Killed(BaseException):
        """Ends the call where it is; nothing is tidied up that a kill would leave."""

    def die(*_: object) -> None:
        raise Killed

    if made == "folder":
        path.mkdir()
        (path / "zarr.json.123.part").write_text('{"zarr_fo', encoding="utf-8")
    else:
        if made == "marker":
            monkeypatch.setattr(StoreLock, "acquire", die)
        else:
            monkeypatch.setattr(store_module, "_make_array", die)
        with pytest.raises(Killed):
            CALLS["sweep"](path)
        monkeypatch.undo()
        assert set(files_in(path)) == {"zarr.json"}

    again = CALLS["sweep"](path)

    assert again.identical(before)


def test_a_marker_that_another_process_has_just_written_is_not_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.zarr"
    theirs = json.dumps({"zarr_format": 3, "node_type": "group", "attributes": {}})
    link = os.link

    def meanwhile(source: Path, target: Path) -> None:
        target.write_text(theirs, encoding="utf-8")
        link(source, target)

    monkeypatch.setattr("percuss.ensembles.store.os.link", meanwhile)
    with pytest.raises(pc.OutputError, match="Zarr data that are no store of percuss"):
        several(path)

    assert files_in(path) == {"zarr.json": theirs.encode()}


def test_files_of_others_inside_a_store_stay_and_the_store_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    several(path, progress=lambda now, total: False)  # noqa: ARG005
    for folder in (path, path / "period", path / "period" / "c", path / "done" / "c"):
        (folder / "notes.txt").write_text("mine", encoding="utf-8")

    assert several(path).identical(several(None))
    assert several(path).identical(several(None))

    assert sum(name.endswith("notes.txt") for name in files_in(path)) == 4
    assert pc.status_of_store(path)["points_done"] == 40


def test_a_folder_in_the_place_of_an_array_is_refused_and_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    CALLS["sweep"](path)
    (path / "period").rename(tmp_path / "aside")
    xr.Dataset({"precious": ("x", np.arange(3.0))}).to_zarr(
        path / "period", zarr_format=3, consolidated=False
    )
    before = files_in(path)

    with pytest.raises(pc.OutputError, match="holds a period that is no array"):
        CALLS["sweep"](path)

    assert files_in(path) == before
