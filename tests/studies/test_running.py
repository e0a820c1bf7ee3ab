"""Running a study writes what it asks for, all of it or nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.errors import OutputError
from percuss.io import load_netcdf, load_record
from percuss.io.results import table_of
from percuss.studies import (
    Draw,
    Limits,
    Motion,
    Save,
    Study,
    load_study,
    output_files,
    run_study,
    running,
)


def study_of(**options: Any) -> Study:
    motion = Motion(pc.Start(0, "0.51"), options.pop("limits", Limits(t_end="10*pi")))
    return Study(
        pc.impact_oscillator(), pc.cosine(3, phase="-pi/2"), motion, title="n = 3", **options
    )


TABLES = {"impacts.csv", "impacts.csv.toml", "motion.csv", "motion.csv.toml"}


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_all_files_of_a_study_are_written_and_hold_the_study(tmp_path: Path) -> None:
    study = study_of()

    result = run_study(study, tmp_path / "out", command="percuss run n3.toml")

    assert result.files == output_files(study, tmp_path / "out")
    assert names_in(tmp_path / "out") == {"motion.nc", "motion.png", "motion.svg", *TABLES}
    for file in result.files:
        assert load_study(file) == study
        assert load_record(file).command == "percuss run n3.toml"
    assert result.report["impact times"].startswith("the eigenset, within")


def test_a_study_is_repeated_from_any_of_its_files_to_the_bit(tmp_path: Path) -> None:
    first = run_study(study_of(), tmp_path / "a")

    again = run_study(load_study(first.files[0]), tmp_path / "b")

    np.testing.assert_array_equal(again.answer.impacts.t, first.answer.impacts.t)


def test_only_the_files_asked_for_are_written(tmp_path: Path) -> None:
    study = study_of(save=Save(csv=False, samples=11), draw=Draw(png=False, svg=False))

    run_study(study, tmp_path / "out")

    assert names_in(tmp_path / "out") == {"motion.nc"}
    assert load_netcdf(tmp_path / "out" / "motion.nc").to_dataset().sizes == {
        "sample": 11,
        "stop": 1,
    }


def test_results_are_not_overwritten_and_the_run_is_not_even_begun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "impacts.csv").write_text("precious")
    monkeypatch.setattr(Motion, "answer", lambda *_: pytest.fail("simulated"))

    with pytest.raises(OutputError, match=r"impacts\.csv: exists already"):
        run_study(study_of(), tmp_path)

    assert names_in(tmp_path) == {"impacts.csv"}


def test_force_replaces_its_own_files_and_touches_no_others(tmp_path: Path) -> None:
    study = study_of(draw=Draw(svg=False))
    for name in ("motion.nc", "impacts.csv", "motion.svg", "notes.txt"):
        (tmp_path / name).write_text("old")

    run_study(study, tmp_path, force=True)

    assert (tmp_path / "notes.txt").read_text() == "old"
    # This study draws no SVG, so the one that is there belongs to another.
    assert (tmp_path / "motion.svg").read_text() == "old"
    assert load_study(tmp_path / "impacts.csv") == study


def test_a_failure_while_writing_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(running, "write_figure", fail)

    with pytest.raises(OutputError, match="no space left"):
        run_study(study_of(), tmp_path / "out")

    assert names_in(tmp_path) == set()


def test_a_run_that_is_stopped_is_written_as_far_as_it_came(tmp_path: Path) -> None:
    # A hundred harmonics make each impact slow, and what is written short.
    force = pc.fourier("0.5", cos=(0.1,) * 100)
    study = replace(
        study_of(limits=Limits(max_impacts=5_000_000), draw=Draw(png=False, svg=False)),
        force=force,
    )

    result = run_study(study, tmp_path / "out", progress=lambda *_: False)

    assert result.answer.outcome.name == "interrupted"
    assert not result.is_whole
    assert 0 < len(result.answer.impacts) < 5_000_000
    saved = load_netcdf(tmp_path / "out" / "motion.nc")
    np.testing.assert_array_equal(saved["impacts"]["t"].to_numpy(), result.answer.impacts.t)
    assert load_record(tmp_path / "out" / "impacts.csv").outcome == result.answer.outcome.value
    assert load_study(tmp_path / "out" / "motion.nc") == study


def test_crossings_are_written_where_there_are_soft_stops(tmp_path: Path) -> None:
    study = Study(
        pc.backlash_oscillator(1, 25),
        pc.cosine(1, phase="-pi/2"),
        Motion(pc.Start(0, 1), Limits(periods=3)),
        draw=Draw(png=False, svg=False, length_unit="mm", time_unit="s"),
    )

    seen: list[Path] = []
    run_study(study, tmp_path / "out", on_write=seen.append)

    names = ["motion.nc", "impacts.csv", "crossings.csv", "motion.csv"]
    records = {f"{name}.toml" for name in names[1:]}
    assert names_in(tmp_path / "out") == {*names, *records}
    assert [path.name for path in seen] == names
    text = (tmp_path / "out" / "crossings.csv.toml").read_text()
    assert 'columns = "t [s], v [mm/s], stop, direction"' in text
    assert (
        (tmp_path / "out" / "motion.csv")
        .read_text()
        .startswith("t,x,v,stop_force_0,stop_force_1\n")
    )
    assert load_study(tmp_path / "out" / "crossings.csv") == study


def test_a_run_that_ends_before_its_window_is_drawn_whole(tmp_path: Path) -> None:
    limits = Limits(t_end=100, max_impacts=3)
    study = study_of(limits=limits, draw=Draw(svg=False, window=(50, 60)), save=Save(csv=False))

    result = run_study(study, tmp_path / "out")

    assert result.answer.t_end < 50.0
    assert names_in(tmp_path / "out") == {"motion.nc", "motion.png"}


def test_a_table_longer_than_a_spreadsheet_is_left_out_and_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "MOST_ROWS", 3)
    monkeypatch.setattr(running, "LARGE", 100.0)

    with pytest.warns(UserWarning, match="left out|the files take more than") as reported:
        result = run_study(study_of(draw=Draw(png=False, svg=False)), tmp_path)

    assert names_in(tmp_path) == {"motion.nc", "motion.csv", "motion.csv.toml"}
    assert {file.name for file in result.files} == names_in(tmp_path)
    words = [str(it.message) for it in reported]
    n_rows = len(result.answer.impacts)
    assert words[0].startswith(f"impacts.csv is left out: {n_rows} rows are more than the 3 of a ")
    assert "motion.nc has them" in words[0]
    assert words[1].startswith("the files take more than 0 MB")


def test_a_long_table_is_written_where_nothing_else_holds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "MOST_ROWS", 3)

    run_study(study_of(save=Save(netcdf=False), draw=Draw(png=False, svg=False)), tmp_path)

    assert names_in(tmp_path) == TABLES


def test_branches_that_are_none_are_an_empty_table() -> None:
    for name in ("curves", "branches", "orbits"):
        columns = table_of([], name)
        assert {len(column) for column in columns.values()} <= {0}
