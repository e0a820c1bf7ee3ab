"""What a view asks as a study of its own: the motion, a diagram, a response chart or basins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from percuss.errors import StudyError
from percuss.io.study_text import number
from percuss.studies.axes import Span
from percuss.studies.kinds.diagram import Diagram
from percuss.studies.reading import build_study
from percuss.studies.study import Study
from percuss.studies.tables import Certify, Draw, StudyFaults
from percuss.web.question import (
    BadQuestion,
    PageQuestion,
    digits_of,
    motion_of,
    path_of,
    range_of,
    study_of,
)

__all__ = [
    "ASKED",
    "MOST_IMPACTS",
    "MOST_PERIODS",
    "MOST_STARTS",
    "SETTLING",
    "asked_study",
    "check_size",
]

# Forcing periods in which the points of a diagram settle.
SETTLING = 200
# What the page computes itself: values and points of a diagram, starts along a side of basins,
# the longest orbits of a chart.
MOST_VALUES, MOST_POINTS = 8192, 2_000_000
MOST_STARTS = 1024
MOST_IMPACTS, MOST_PERIODS = 6, 6
MODEL = ("oscillator", "forcing")
NAMES = {
    "diagram": "a diagram needs",
    "response": "a response chart needs",
    "basins": "basins need",
}


def asked_study(question: PageQuestion) -> Study:
    """Return the study that makes what a view shows.

    Parameters
    ----------
    question
        Of one of the kinds in `ASKED`, with the options of the view.

    Returns
    -------
    Study
        As `percuss run` takes it.

    Raises
    ------
    StudyError, BadQuestion
        If there is no such study.

    Examples
    --------
    >>> from percuss.web.presets import presets
    >>> options = {"path": "forcing.omega", "low": 2, "high": 3, "values": 50, "points": 8}
    >>> asked = asked_study(Question(0, "diagram", presets()[0].tables, options))
    >>> asked.kind, asked.question.points
    ('diagram', 8)
    """
    motion = study_of(question.tables)
    if question.kind == "motion":
        digits = digits_of(question)
        return motion if digits is None else replace(motion, certify=Certify(digits))
    if not question.tables.get("forcing", {}).get("harmonics"):
        raise BadQuestion(f"{NAMES[question.kind]} a periodic force: add a harmonic in Explore")
    model = {name: question.tables[name] for name in MODEL if name in question.tables}
    faults = StudyFaults("study", {})
    document = {"study": {"kind": question.kind}, **model, **ASKED[question.kind](question, motion)}
    study = build_study(document, faults)
    if study is None:
        raise StudyError(faults.faults)
    if isinstance(study.question, Diagram):
        study = replace(study, question=_with_all_values(question, study.question))
    wants = question.kind == "basins" and question.options.get("manifolds") is True
    return replace(study, draw=Draw(manifolds=True)) if wants else study


def check_size(question: PageQuestion) -> None:
    """Refuse what is too large for the page to compute.

    Raises
    ------
    BadQuestion
        If it is; its study may still go to `percuss run`.
    """
    if question.kind == "diagram":
        values = int(question.number("values", 2048, 2, MOST_VALUES))
        points = int(question.number("points", 128, 2, 1024))
        if values * points > MOST_POINTS:
            raise BadQuestion(f"{values * points} points; {MOST_POINTS} are the most")
    elif question.kind == "basins":
        question.number("starts", 384, 16, MOST_STARTS)
    elif question.kind == "response":
        question.number("max_impacts", 3, 1, MOST_IMPACTS)
        question.number("max_periods", 2, 1, MOST_PERIODS)


def _diagram(question: PageQuestion, motion: Study) -> Mapping[str, Any]:
    low, high = range_of(question, "low", "high")
    start = motion_of(motion).start
    return {
        # Of its values the ends are checked now; what the others have no motion for is told later.
        "over": {path_of(question, motion): {"from": low, "to": high, "count": 2}},
        "diagram": {
            "starts": [[number(value) for value in (start.x0, start.v0, start.t0)]],
            "follow": [],
            "transient": SETTLING,
            "points": int(question.number("points", 128, 2, 1_000_000)),
        },
    }


def _with_all_values(question: PageQuestion, asked: Diagram) -> Diagram:
    """Return a diagram with as many values as are asked for between its two ends."""
    ((path, axis),) = asked.over.items()
    assert isinstance(axis, Span)
    count = int(question.number("values", 2048, 2, 1_000_000))
    return replace(asked, over={path: replace(axis, count=count)})


def _response(question: PageQuestion, motion: Study) -> Mapping[str, Any]:
    path = path_of(question, motion)
    if path.startswith("start."):
        raise BadQuestion("periodic orbits do not depend on a start; choose another parameter")
    return {
        "over": {path: list(range_of(question, "low", "high"))},
        "response": {
            name: int(question.number(name, default, 1, 100))
            for name, default in (("max_impacts", 3), ("max_periods", 2))
        },
    }


def _basins(question: PageQuestion, motion: Study) -> Mapping[str, Any]:
    count = int(question.number("starts", 384, 2, 1_000_000))
    axes: dict[str, object] = {}
    for name, ends in (("x0", ("x_low", "x_high")), ("v0", ("v_low", "v_high"))):
        low, high = range_of(question, *ends)
        # The page takes the centres of cells.
        half = 0.5 * (high - low) / count
        axes[name] = {"from": low + half, "to": high - half, "count": count}
    return {"basins": axes | {"t0": number(motion_of(motion).start.t0)}}


ASKED = {"diagram": _diagram, "response": _response, "basins": _basins}
