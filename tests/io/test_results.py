"""What is saved is read back to the bit, and says how to repeat it."""

from __future__ import annotations

import csv
import importlib
import importlib.metadata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import percuss as pc
from percuss.errors import OutputError
from percuss.execution import Execution
from percuss.io import (
    Record,
    load_netcdf,
    load_record,
    make_record,
    parse_record,
    save_csv,
    save_figure,
    save_netcdf,
)
from percuss.io.column_units import units_of_columns
from percuss.io.netcdf import TABLES
from percuss.io.results import table_of
from percuss.io.table import write_columns
from percuss.motion.tables import COLUMNS
from percuss.motion.trajectory import Trajectory
from percuss.plotting import offscreen_figure, plot_velocity
from percuss.studies import Limits, Motion, load_study, parse_study

Saver = Callable[..., None]


def save_picture(run: Trajectory, path: Path, **options: Any) -> None:
    figure = offscreen_figure(4.0, 3.0)
    plot_velocity(run, figure.add_subplot())
    save_figure(figure, path, run=run, **options)


SAVERS: dict[str, Saver] = {
    "run.nc": save_netcdf,
    "run.csv": save_csv,
    "run.png": save_picture,
    "run.svg": save_picture,
}


def test_netcdf_keeps_every_table_to_the_bit(run: Trajectory, tmp_path: Path) -> None:
    save_netcdf(run, tmp_path / "run.nc", samples=101)

    tree = load_netcdf(tmp_path / "run.nc")

    assert len(run.impacts) > 0
    assert len(run.crossings) > 0
    for name in TABLES:
        for column in COLUMNS[name.removesuffix("s")]:
            saved = tree[name][column].to_numpy()
            np.testing.assert_array_equal(saved, getattr(getattr(run, name), column))
    t = tree["t"].to_numpy()
    x, v = run(t)
    np.testing.assert_array_equal(tree["x"].to_numpy(), x)
    np.testing.assert_array_equal(tree["v"].to_numpy(), v)
    np.testing.assert_array_equal(tree["stop_force"].to_numpy(), run.forces(t).stops.to_numpy())
    assert tree["stop_force"].dims == ("stop", "sample")
    assert (t.size, t[0], t[-1]) == (101, run.t0, run.t_end)


def test_netcdf_keeps_a_run_without_any_event(tmp_path: Path) -> None:
    run = pc.simulate(pc.Oscillator(), x0=1.0, t_end=1.0)

    save_netcdf(run, tmp_path / "run.nc")

    tree = load_netcdf(tmp_path / "run.nc")
    assert [tree[name].to_dataset().sizes[name.removesuffix("s")] for name in TABLES] == [0] * 4


def test_a_loaded_file_is_closed_and_may_be_replaced(run: Trajectory, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    save_netcdf(run, path)
    tree = load_netcdf(path)

    save_netcdf(run, path, force=True)
    path.unlink()

    np.testing.assert_array_equal(tree["impacts"]["t"].to_numpy(), run.impacts.t)


def test_csv_with_decimal_commas_is_that_with_points(run: Trajectory, tmp_path: Path) -> None:
    save_csv(run, tmp_path / "point.csv")
    save_csv(run, tmp_path / "comma.csv", decimal_comma=True)

    texts = [(tmp_path / f"{name}.csv").read_text(encoding="utf-8") for name in ("point", "comma")]
    assert "," in texts[1]
    assert "." not in texts[1].split("\n", 1)[1]
    assert texts[1].replace(",", ".").replace(";", ",") == texts[0]


def test_csv_holds_the_impacts_to_the_bit(run: Trajectory, tmp_path: Path) -> None:
    save_csv(run, tmp_path / "run.csv")

    with (tmp_path / "run.csv").open() as file:
        rows = list(csv.DictReader(file))

    for column in ("t", "v_before", "v_after", "stop", "cycle", "impulse"):
        saved = [float(row[column]) for row in rows]
        np.testing.assert_array_equal(saved, getattr(run.impacts, column))


@pytest.mark.parametrize("name", SAVERS)
def test_every_file_says_how_to_repeat_the_run(name: str, run: Trajectory, tmp_path: Path) -> None:
    path = tmp_path / name
    SAVERS[name](run, path, command='percuss run "a b.toml"')

    record = load_record(path)
    study = load_study(path)
    again = study.question.answer(study, Execution())

    assert record.command == 'percuss run "a b.toml"'
    assert record.outcome == run.outcome.value
    versions = dict(record.versions)
    assert versions["percuss"] == pc.__version__
    assert versions["numba"] == importlib.metadata.version("numba")
    assert set(versions) == {"percuss", "python", "numpy", "numba"}
    np.testing.assert_array_equal(again.impacts.t, run.impacts.t)
    np.testing.assert_array_equal(again.crossings.t, run.crossings.t)


@pytest.mark.parametrize("name", SAVERS)
def test_a_study_given_by_the_caller_is_kept_word_for_word(
    name: str, run: Trajectory, tmp_path: Path
) -> None:
    study = '[study]\ntitle = "Größe <&> \\"x\\" # no comment"\n\n[run]\nt_end = 1.0\n'

    SAVERS[name](run, tmp_path / name, study=study)

    assert load_record(tmp_path / name).study == study


@pytest.mark.parametrize("name", SAVERS)
def test_no_format_overwrites_without_force(name: str, run: Trajectory, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text("precious")

    with pytest.raises(OutputError, match="exists already"):
        SAVERS[name](run, path)
    assert path.read_text() == "precious"

    SAVERS[name](run, path, force=True)
    assert load_record(path).outcome == run.outcome.value


def test_a_run_that_ended_at_its_impact_limit_is_repeated_by_that_limit() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, max_impacts=7)

    question = parse_study(make_record(run).study).question

    assert isinstance(question, Motion)
    assert question.limits == Limits(max_impacts=7)


def test_another_picture_format_is_refused(run: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"neither \.png nor \.svg"):
        save_picture(run, tmp_path / "run.jpg")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", [*SAVERS, "run.txt"])
def test_a_foreign_file_is_reported_in_one_sentence(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(b"# nothing of ours\n\x00\x01")

    with pytest.raises(ValueError, match=r"no record of percuss|not a result file") as caught:
        load_record(path)

    assert str(caught.value).startswith(f"{path}: ")


words = st.text(st.characters(exclude_categories=["Cs"]), max_size=30)


@given(words, words, words)
def test_a_record_is_read_back_whatever_its_words(command: str, date: str, outcome: str) -> None:
    versions = (("percuss", "0.1"), ("python", "3"))
    record = Record("[run]\nt_end = 1\n\n[start]\nx0 = 0\n", command, date, outcome, versions)

    assert parse_record(record.text()) == record


def test_csv_of_crossings_holds_them_to_the_bit_and_names_their_units(
    run: Trajectory, tmp_path: Path
) -> None:
    path = tmp_path / "crossings.csv"
    record = make_record(run, command="c")
    columns = table_of(run, "crossings")
    units = units_of_columns(run, columns, pc.Units("mm", "s"))
    write_columns(columns, path, record, units=units)

    lines = path.read_text().splitlines()
    rows = list(csv.DictReader(lines))
    assert lines[0] == "t [s],v [mm/s],stop,direction"
    np.testing.assert_array_equal([float(row["t [s]"]) for row in rows], run.crossings.t)
    np.testing.assert_array_equal([float(row["v [mm/s]"]) for row in rows], run.crossings.v)
    assert [row["direction"] for row in rows] == run.crossings.direction.tolist()
    assert load_record(path) == record


def test_pandas_and_spreadsheets_find_the_header_first(run: Trajectory, tmp_path: Path) -> None:
    save_csv(run, tmp_path / "run.csv", table="motion")
    save_csv(run, tmp_path / "few.csv", table="motion", samples=3)

    # What xarray brings along, untyped.
    pandas: Any = importlib.import_module("pandas")
    # Its versions before 3.1 round decimals in their own way.
    found = pandas.read_csv(tmp_path / "run.csv", dtype=str).astype(float)

    assert list(found.columns) == ["t", "x", "v", "stop_force_0", "stop_force_1"]
    sample = run.sample(2001)
    for name in "txv":
        np.testing.assert_array_equal(found[name], sample[name])
    forces = run.forces(sample.t.values).stops
    np.testing.assert_array_equal(found[["stop_force_0", "stop_force_1"]].T, forces)
    assert len(pandas.read_csv(tmp_path / "few.csv")) == 3
    with pytest.raises(pc.ParameterError, match="samples = 1: not a whole number of at least 2"):
        save_csv(run, tmp_path / "none.csv", table="motion", samples=1)


def test_the_record_in_a_csv_file_of_an_older_version_is_read(
    run: Trajectory, tmp_path: Path
) -> None:
    record = make_record(run, command="c")
    lines = [f"# {line}".rstrip() for line in record.text().splitlines()]
    (tmp_path / "old.csv").write_text("\n".join([*lines, "t,v", "1,2", ""]))

    assert load_record(tmp_path / "old.csv") == record


@pytest.mark.parametrize("name", ["run.xlsx", "run.txt", "run", "run.nc.gz"])
def test_a_wrong_suffix_is_refused_before_anything_is_written(
    name: str, run: Trajectory, tmp_path: Path
) -> None:
    for save, suffix in ((save_csv, ".csv"), (save_netcdf, ".nc"), (save_picture, ".png")):
        with pytest.raises(OutputError, match=rf"run.*: (not|neither) \{suffix}"):
            save(run, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_neither_table_nor_record_is_replaced_without_force(
    run: Trajectory, tmp_path: Path
) -> None:
    (tmp_path / "run.csv.toml").write_text("precious")

    with pytest.raises(OutputError, match=r"run\.csv\.toml: exists already"):
        save_csv(run, tmp_path / "run.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["run.csv.toml"]


def test_a_run_limited_by_entries_into_soft_stops_is_repeated_by_that_limit() -> None:
    run = pc.simulate(pc.backlash_oscillator(1, 25), pc.sine(1), v0=1.0, max_impacts=7)

    assert run.outcome.name == "reached_max_impacts"
    question = parse_study(make_record(run).study).question
    assert isinstance(question, Motion)
    assert question.limits.max_impacts == 7


def test_what_cannot_be_loaded_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text("no NetCDF")

    with pytest.raises(FileNotFoundError, match=r"none\.nc: no such file$"):
        load_netcdf(tmp_path / "none.nc")
    with pytest.raises(OSError, match=r"a\.nc: not a NetCDF file"):
        load_netcdf(tmp_path / "a.nc")


def test_a_file_opens_at_its_root(run: Trajectory, tmp_path: Path) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.6)})
    data = pc.sweep("period", orbit.oscillator, orbit.forcing, over={"forcing.omega": [2.5, 2.6]})
    results = {"run": run, "orbit": orbit, "orbits": [orbit, orbit], "branch": branch, "data": data}
    names = {"run": "x", "orbit": "v", "orbits": "period", "branch": "arclength", "data": "period"}

    for name, result in results.items():
        file = tmp_path / f"{name}.nc"
        save_netcdf(result, file)
        with xr.open_dataset(file) as opened:
            assert names[name] in opened, name
            assert "record" in opened.attrs

    again = load_netcdf(tmp_path / "data.nc")
    assert again.attrs == data.attrs
    xr.testing.assert_identical(again.period, data.period)
    np.testing.assert_array_equal(load_netcdf(tmp_path / "branch.nc").arclength, branch.arclength)
