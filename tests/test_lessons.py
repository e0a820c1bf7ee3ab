"""The lessons run from the first cell to the last, and their solutions are right."""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import nbformat
import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "lessons"


def cells_of(name: str) -> list[Any]:
    notebook: Any = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)  # type: ignore[no-untyped-call]
    nbformat.validate(notebook)
    return list(notebook.cells)


def check_doubling(end: dict[str, Any]) -> None:
    x = end["after"].x
    assert abs(x[-1] - x[-3]) < 1e-9 < abs(x[-1] - x[-2])
    assert end["branch"].special_points[0].kind == "period_doubling"
    assert end["doublings"][0] > end["branch"].special_points[0].value
    assert end["signs"]["2.5"] < 0.0 < end["signs"]["2.8"]


def check_grazing(end: dict[str, Any]) -> None:
    assert len(end["below"].impacts) == 0 < len(end["above"].impacts)
    assert end["counts"]["0.1"] < 10 < end["counts"]["0.11"]
    assert abs(end["slope"] - 0.5) < 0.01
    kinds = [point.kind for point in end["branch"].special_points]
    assert {"fold", "grazing", "period_doubling"} <= set(kinds)
    # One over the speed, over ten decades of it.
    products = end["largest"] * end["speeds_of_two"]
    assert end["largest"][0] / end["largest"][1] > 1e9
    assert 0.5 < products[0] / products[1] < 2.0


def check_chatter(end: dict[str, Any]) -> None:
    assert abs(end["thrown"].contacts.start[0] - end["by_hand"]) < 1e-12
    assert abs(end["push"]) < 1e-9
    assert end["contacts"]["0.6"] >= 40 > end["contacts"]["0.9"]


LESSONS = {"period_doubling": check_doubling, "grazing": check_grazing, "chatter": check_chatter}


def test_each_lesson_has_exercises_with_solutions() -> None:
    assert {file.stem for file in FOLDER.glob("*.ipynb")} == set(LESSONS)
    for name in LESSONS:
        cells = cells_of(name)
        text = "\n".join(cell.source for cell in cells)
        solutions = [cell for cell in cells if "solution" in cell.metadata.get("tags", ())]
        assert text.count("**Exercise") == len(solutions) >= 3
        # Seen by those who ask only.
        assert all(cell.metadata["jupyter"]["source_hidden"] for cell in solutions)
        assert not any(cell.get("outputs") for cell in cells)


@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_runs_and_its_solutions_are_right(name: str) -> None:
    mpl.use("agg")

    end: dict[str, Any] = {}
    for cell in cells_of(name):
        if cell.cell_type == "code":
            exec(compile(cell.source, name, "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT), end)  # noqa: S102  our own text
    check: Callable[[dict[str, Any]], None] = LESSONS[name]
    check(end)


@pytest.mark.nightly
@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_runs_in_a_notebook_with_one_picture_a_cell(name: str) -> None:
    from tests.notebooks import executed

    for cell in executed(cell.source for cell in cells_of(name) if cell.cell_type == "code"):
        pictures = [out for out in cell.outputs if "image/png" in out.get("data", {})]
        assert len(pictures) == (1 if "plot" in cell.source and "import" not in cell.source else 0)
