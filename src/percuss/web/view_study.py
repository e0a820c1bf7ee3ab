"""The study behind a view of the page: its motion, diagram, chart or basins."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from percuss.io.study_text import number
from percuss.studies.axes import Span
from percuss.studies.kinds.diagram import Diagram
from percuss.studies.link import CELLS, MEASURED, SETTLING
from percuss.studies.study import Study
from percuss.studies.tables import Certify, Draw
from percuss.web.design_view import design_tables
from percuss.web.fit_view import fit_tables
from percuss.web.request import (
    BadRequest,
    PageRequest,
    checked_study,
    digits_of,
    motion_of,
    path_of,
    range_of,
    study_of,
)

# What the page computes itself: values and points of a diagram, starts along a side of basins,
# the longest orbits of a chart.
MOST_VALUES, MOST_POINTS = 8192, 2_000_000
MOST_STARTS = 1024
MOST_IMPACTS, MOST_PERIODS = 6, 6
# Where the motion at a value of a diagram begins: at the start, or where that at the value before
# has ended.
DIRECTIONS: dict[str, tuple[str, ...]] = {
    "start": (),
    "forward": ("forward",),
    "backward": ("backward",),
    "both": ("forward", "backward"),
}
MODEL = ("parameters", "oscillator", "forcing")
NAMES = {
    "diagram": "a diagram needs",
    "response": "a response chart needs",
    "basins": "basins need",
    "sweep": "a chart of two parameters needs",
}


def study_of_view(request: PageRequest) -> Study:
    """Return the study whose answer a view shows.

    Parameters
    ----------
    request
        Request of one of the kinds in `VIEWS`, with the options of the view.

    Returns
    -------
    Study
        As `percuss run` takes it.

    Raises
    ------
    StudyError, BadRequest
        If there is no such study.

    Examples
    --------
    >>> from percuss.web.presets import presets
    >>> options = {"path": "forcing.omega", "low": 2, "high": 3, "values": 50, "points": 8}
    >>> study = study_of_view(PageRequest(0, "diagram", presets()[0].tables, options))
    >>> study.kind, study.question.points
    ('diagram', 8)
    """
    motion = study_of(request.tables)
    if request.kind == "motion":
        digits = digits_of(request)
        return motion if digits is None else replace(motion, certify=Certify(digits))
    force = motion.forcing
    at_section = request.kind == "diagram" and request.options.get("section") in (
        "place",
        "impacts",
    )
    needs_period = request.kind in NAMES and not at_section
    if (force is None or force.is_constant) and needs_period:
        raise BadRequest(f"{NAMES[request.kind]} a periodic force: add a harmonic in Explore")
    model = {name: request.tables[name] for name in MODEL if name in request.tables}
    tables = VIEWS[request.kind](request, motion)
    study = checked_study({"study": {"kind": request.kind}, **model, **tables})
    if isinstance(study.question, Diagram):
        study = replace(study, question=_with_all_values(request, study.question))
    has_manifolds = request.kind == "basins" and request.options.get("manifolds") is True
    return replace(study, draw=Draw(manifolds=True)) if has_manifolds else study


def check_size(request: PageRequest) -> None:
    """Refuse what is too large for the page to compute.

    Raises
    ------
    BadRequest
        If it is; its study may still go to `percuss run`.
    """
    if request.kind == "diagram":
        values = int(request.number("values", 2048, 2, MOST_VALUES))
        points = int(request.number("points", 128, 2, 1024))
        if values * points > MOST_POINTS:
            raise BadRequest(f"{values * points} points; {MOST_POINTS} are the most")
    elif request.kind == "basins":
        request.number("starts", 384, 16, MOST_STARTS)
    elif request.kind == "sweep":
        request.number("size", 96, *CELLS)
    elif request.kind == "response":
        request.number("max_impacts", 3, 1, MOST_IMPACTS)
        request.number("max_periods", 2, 1, MOST_PERIODS)


def _diagram(request: PageRequest, motion: Study) -> Mapping[str, Any]:
    low, high = range_of(request, "low", "high")
    start = motion_of(motion).start
    return {
        # Only the two ends are checked now; values without a motion are counted in the answer.
        "over": {path_of(request, motion): {"from": low, "to": high, "count": 2}},
        "diagram": {
            "section": _section(request),
            "starts": [[number(value) for value in (start.x0, start.v0, start.t0)]],
            "follow": list(DIRECTIONS[request.choice("follow", tuple(DIRECTIONS))]),
            "transient": SETTLING,
            "points": int(request.number("points", 128, 2, 1_000_000)),
        },
    }


def _section(request: PageRequest) -> object:
    """Return where the points of a diagram are taken, as a study file has it."""
    name = request.choice("section", ("strobes", "cycle", "place", "impacts"))
    if name == "cycle":
        return {"cycle": request.number("cycle", 0.0, 0.0, math.nextafter(1.0, 0.0))}
    if name == "place":
        direction = request.choice("direction", ("up", "down", "both"))
        return {"at": request.number("at", 0.0, -1e6, 1e6), "direction": direction}
    return "stroboscopic" if name == "strobes" else name


def _with_all_values(request: PageRequest, diagram: Diagram) -> Diagram:
    """Return a diagram with the requested number of values between its two ends."""
    ((path, axis),) = diagram.over.items()
    assert isinstance(axis, Span)
    count = int(request.number("values", 2048, 2, 1_000_000))
    return replace(diagram, over={path: replace(axis, count=count)})


def _response(request: PageRequest, motion: Study) -> Mapping[str, Any]:
    path = path_of(request, motion)
    if path.startswith("start."):
        raise BadRequest("periodic orbits do not depend on a start; choose another parameter")
    return {
        "over": {path: list(range_of(request, "low", "high"))},
        "response": {
            name: int(request.number(name, default, 1, 100))
            for name, default in (("max_impacts", 3), ("max_periods", 2))
        },
    }


def _sweep(request: PageRequest, motion: Study) -> Mapping[str, Any]:
    count = int(request.number("size", 96, 2, 1_000_000))
    measure = request.choice("of", tuple(MEASURED))
    start = motion_of(motion).start
    over = {
        path_of(request, motion, f"path{end}"): _cells(request, f"low{end}", f"high{end}", count)
        for end in ("", "2")
    }
    if len(over) == 1:
        raise BadRequest("the two parameters are the same; choose another one")
    return {
        "over": over,
        "start": {name: number(getattr(start, name)) for name in ("x0", "v0", "t0")},
        "sweep": {"measure": measure, "transient": SETTLING, "periods": MEASURED[measure]},
    }


def _cells(request: PageRequest, low: str, high: str, count: int) -> dict[str, object]:
    """Return the centres of cells between two ends, which the page takes."""
    first, last = range_of(request, low, high)
    half = 0.5 * (last - first) / count
    return {"from": first + half, "to": last - half, "count": count}


def _basins(request: PageRequest, motion: Study) -> Mapping[str, Any]:
    count = int(request.number("starts", 384, 2, 1_000_000))
    axes = {f"{name}0": _cells(request, f"{name}_low", f"{name}_high", count) for name in "xv"}
    return {"basins": axes | {"t0": number(motion_of(motion).start.t0)}}


VIEWS = {
    "diagram": _diagram,
    "response": _response,
    "basins": _basins,
    "sweep": _sweep,
    "design": design_tables,
    "fit": fit_tables,
}
