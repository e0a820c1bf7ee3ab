"""Choosing, computing and writing: `run_paper` and what it stands on."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr
from tests.paper.squares import square

from percuss.errors import OutputError, ParameterError
from percuss.io import load_record
from percuss.model.harmonic_forces import sine
from percuss.paper import run as run_module
from percuss.paper.collection import Item, choose, items
from percuss.paper.figure_files import draw_figure
from percuss.paper.processes import in_processes
from percuss.paper.result import INTERRUPTED
from percuss.paper.run import run_paper
from percuss.paper.sections import SECTIONS
from percuss.studies import Motion, load_study, parse_study


def test_names_select_figures_and_what_is_said_about_them() -> None:
    chosen = choose("fig9,table2")

    assert [item.name for item in chosen if item.kind == "figure"] == ["fig9"]
    statements = {item.name for item in chosen if item.kind == "statement"}
    assert {"table2", "table2-simulated", "fig9"} <= statements
    assert all("table2" in name or name == "fig9" for name in statements)


def test_an_equation_selects_all_statements_that_refer_to_it() -> None:
    assert {"eq12"} <= {item.name for item in choose("eq12")}


def test_every_module_of_a_section_holds_something() -> None:
    named = {module for section in SECTIONS for module in section.modules}

    assert named == {item.module for item in items()}
    assert {section.name for section in SECTIONS} == {item.section for item in items()}


def test_all_items_are_chosen_by_default() -> None:
    assert choose(None) == items()


def test_a_figure_is_written_four_times_and_can_be_read_again(tmp_path: Path) -> None:
    result = run_paper(tmp_path / "out", only="fig5", command="percuss paper --only fig5")

    names = {path.name for path in result.folder.iterdir()}
    assert names >= {"fig5.svg", "fig5.png", "fig5.nc", "fig5.csv", "index.html", "claims.json"}
    assert not [name for name in names if name.endswith(".part")]
    for suffix in (".svg", ".png", ".nc", ".csv"):
        record = load_record(result.folder / f"fig5{suffix}")
        assert record.command == "percuss paper --only fig5"
        assert 'name = "fig5"' in record.study
        assert dict(record.versions)["percuss"]
    with xr.open_dataset(result.folder / "fig5.nc", engine="h5netcdf") as data:
        gains = data.gain.values.tolist()
        assert data.attrs["caption"] == result.figures["fig5"].caption
    lines = (result.folder / "fig5.csv").read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [float(row["gain"]) for row in rows[:3]] == gains
    assert rows[3]["gain"] == ""
    assert gains == pytest.approx([4 / 3, 8 / 15, 12 / 35], rel=1e-12)


def test_claims_are_in_the_order_of_the_report(tmp_path: Path) -> None:
    result = run_paper(tmp_path, only="table1,eq2")

    records = json.loads((tmp_path / "claims.json").read_text())["records"]
    assert [record["id"] for record in records] == [item.name for item in result.items]
    assert {record["verdict"].split(" ")[0] for record in records} <= {"holds", "fails"}


def test_a_study_of_a_record_is_written_beside_the_page(tmp_path: Path) -> None:
    result = run_paper(tmp_path, only="fig9,eq24-other-root")
    shown = result.claims["fig9"]

    study = load_study(tmp_path / "studies" / "fig9.toml")
    assert study == parse_study(shown.finding.study)
    assert isinstance(study.question, Motion)
    assert study.question.start.v0 == "0.139"
    assert study.forcing is not None
    assert study.forcing.components() == sine(9).components()
    # The claim stands above it; a record without a motion has no file.
    text = (tmp_path / "studies" / "fig9.toml").read_text(encoding="utf-8")
    assert text.startswith("# Dyskin, Pasternak & Pelinovsky (2012), fig 9: For n = 9, V0 = 0.139")
    assert [file.name for file in (tmp_path / "studies").iterdir()] == ["fig9.toml"]
    records = json.loads((tmp_path / "claims.json").read_text())["records"]
    assert {record["id"]: record["study"] for record in records} == {
        "fig9": "studies/fig9.toml",
        "eq24-other-root": "",
    }


def test_an_interrupted_run_keeps_its_figures_and_says_what_is_missing(tmp_path: Path) -> None:
    result = run_paper(tmp_path, only="fig1,fig2,fig9", progress=lambda done, _: done < 1)

    assert result.is_interrupted
    assert list(result.figures) == ["fig1"]
    assert (tmp_path / "fig1.svg").exists()
    assert not (tmp_path / "fig9.svg").exists()
    page = (tmp_path / "index.html").read_text()
    assert f"<strong>fig9</strong>: {INTERRUPTED}" in page


def test_what_goes_wrong_with_one_figure_leaves_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(figure: object, folder: Path, command: str) -> object:
        if getattr(figure, "name", "") == "fig1":
            raise ValueError("out of ink")
        return draw_figure(figure, folder, command)  # type: ignore[arg-type]

    monkeypatch.setattr(run_module, "draw_figure", broken)
    result = run_paper(tmp_path, only="fig1,fig9")

    assert list(result.figures) == ["fig9"]
    assert [*result.missing.values()] == ["ValueError: out of ink"]
    assert not result.is_interrupted
    assert "ValueError: out of ink" in (tmp_path / "index.html").read_text()


def test_a_folder_that_is_not_empty_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("")

    with pytest.raises(OutputError, match="the folder is not empty; force=True"):
        run_paper(tmp_path, only="fig1")
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]

    run_paper(tmp_path, only="fig9", force=True)
    assert (tmp_path / "mine").exists()
    assert (tmp_path / "index.html").exists()


def test_a_folder_that_cannot_be_made_is_said_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def progress(done: float, total: float) -> bool:
        asked.append((done, total))
        return True

    def refuse(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(OutputError, match="out: the folder cannot be written: permission denied"):
        run_paper(tmp_path / "out", only="fig9", progress=progress)
    assert asked == []


def _nan(item: Item, reason: str) -> float:
    assert item.name == "end"
    assert "process" in reason
    return math.nan


def _always() -> bool:
    return True


def _items(*names: str) -> list[Item]:
    return [Item("statement", name, f"module {i % 3}", "") for i, name in enumerate(names)]


def test_two_processes_do_everything_once_and_survive_the_end_of_one() -> None:
    found = list(in_processes(square, _items("1", "2", "end", "4", "5"), 2, _always, _nan))

    assert sorted(value for value in found if not math.isnan(value)) == [1, 4, 16, 25]
    assert len(found) == 5


def test_a_stopped_run_begins_nothing_new() -> None:
    asked = iter([True, *[False] * 1000])
    stop: Callable[[], bool] = lambda: next(asked)

    found = list(in_processes(square, _items("1", "2", "3", "4"), 2, stop, _nan))

    assert 1 <= len(found) <= 2


@pytest.mark.parametrize("only", ["Fig9,eq12", "fig 9 , EQ12", "fig9 eq12", " FIG9,,eq12 "])
def test_names_are_taken_with_blanks_and_capitals(only: str) -> None:
    assert choose(only) == choose("fig9,eq12")


@pytest.mark.parametrize(
    ("only", "hint"),
    [
        ("fig1,nonsense", "such as"),
        ("fig99", 'did you mean "fig9'),
        ("figure9", 'did you mean "fig9'),
        ("zzz", "such as "),
        ("", "such as "),
        (" , ", "such as "),
    ],
)
def test_a_name_that_is_none_gets_a_hint_and_no_wall_of_names(only: str, hint: str) -> None:
    with pytest.raises(ParameterError) as caught:
        choose(only)

    assert hint in str(caught.value)
    assert len(str(caught.value)) < 200
