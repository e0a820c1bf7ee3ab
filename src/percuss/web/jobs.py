"""What takes long, in growing resolution: diagrams, response charts and basins."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from percuss.web.asked import SETTLING
from percuss.web.charts import answer_response
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.question import (
    BadQuestion,
    Question,
    motion_of,
    path_of,
    range_of,
    study_of,
)

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

__all__ = ["JOBS", "answer_job"]

Floats = NDArray[np.float64]

# Each level has so many times the values of the one before.
FINER = 4
# Of a diagram: the first level, and the limits of a question.
FIRST_VALUES, MOST_VALUES, MOST_POINTS = 64, 8192, 2_000_000
# Of basins: starts along an axis of the first level, and the most.
FIRST_STARTS, MOST_STARTS = 48, 1024


def answer_job(question: Question, handle: Handle) -> Iterator[bytes]:
    """Return the frames of a long answer, each finer than the one before.

    Parameters
    ----------
    question
        Of one of the kinds in `JOBS`.
    handle
        Where progress is told, and where the client's change of mind is seen.

    Returns
    -------
    iterator of bytes
        Frames; the last one says ``done``.

    Raises
    ------
    PercussError, BadQuestion
        If there is no answer.
    """
    return JOBS[question.kind](question, handle)


def _diagram(question: Question, handle: Handle) -> Iterator[bytes]:
    """Yield the points of the attractors over a parameter: x and v once a forcing period."""
    from percuss.ensembles.diagram import bifurcation_diagram

    study = study_of(question.tables)
    path = path_of(question, study)
    low, high = range_of(question, "low", "high")
    values = int(question.number("values", 2048, 2, MOST_VALUES))
    points = int(question.number("points", 128, 2, 1024))
    if values * points > MOST_POINTS:
        raise BadQuestion(f"{values * points} points; {MOST_POINTS} are the most")
    levels = levels_of(np.linspace(low, high, values), FIRST_VALUES)
    done = 0
    for level in levels:
        begin, done = done / values, done + len(level)
        found = bifurcation_diagram(
            study.oscillator,
            study.forcing,
            over={path: level},
            starts=[motion_of(study).start],
            follow=[],
            transient=SETTLING,
            points=points,
            progress=handle.part(begin, done / values),
        )
        if handle.is_stopped:
            return
        rows = {name: found[name].values[0] for name in ("x", "v")}
        header = {"path": path, "n_points": points, "low": low, "high": high}
        arrays = {
            "value": level,
            "period": found["period"].values[0],
            **{name: row.ravel() for name, row in rows.items()},
        }
        yield frame(_header(question, done=done == values, share=done / values) | header, arrays)


def _basins(question: Question, handle: Handle) -> Iterator[bytes]:
    """Yield which attractor each start goes to."""
    from percuss.ensembles.basins import basins

    study = study_of(question.tables)
    x_low, x_high = range_of(question, "x_low", "x_high")
    v_low, v_high = range_of(question, "v_low", "v_high")
    finest = int(question.number("starts", 384, 16, MOST_STARTS))
    sizes = [finest]
    while sizes[0] > FIRST_STARTS:
        sizes.insert(0, max(FIRST_STARTS, sizes[0] // 2))
    whole, done = sum(size * size for size in sizes), 0
    for size in sizes:
        begin, done = done / whole, done + size * size
        found = basins(
            study.oscillator,
            study.forcing,
            x0=centres(x_low, x_high, size),
            v0=centres(v_low, v_high, size),
            t0=motion_of(study).start.t0,
            progress=handle.part(begin, done / whole),
        )
        if handle.is_stopped:
            return
        attractors = [
            {
                "kind": str(found.kind.values[k]),
                "name": str(found.name.values[k]),
                "n_periods": int(found.n_periods.values[k]),
                "n_impacts": float(found.n_impacts.values[k]),
                "fraction": float(found.fraction.values[k]),
                "error": float(found.fraction_error.values[k]),
            }
            for k in range(found.sizes["attractor"])
        ]
        header = {"size": size, "attractors": attractors}
        edges = {"x_low": x_low, "x_high": x_high, "v_low": v_low, "v_high": v_high}
        last = size == finest
        yield frame(
            _header(question, done=last, share=done / whole) | header | edges,
            {"basin": found.basin.values.ravel(), **_points(found)},
        )


def _points(found: Dataset) -> dict[str, Floats]:
    """Return the points of each attractor, seen once a forcing period."""
    points: dict[str, Floats] = {}
    for k in range(found.sizes["attractor"]):
        x, v = found.attractor_x0.values[k], found.attractor_v0.values[k]
        there = np.isfinite(x) & np.isfinite(v)
        points |= {f"x{k}": x[there], f"v{k}": v[there]}
    return points


JOBS: dict[str, Callable[[Question, Handle], Iterator[bytes]]] = {
    "diagram": _diagram,
    "response": answer_response,
    "basins": _basins,
}


def _header(question: Question, *, done: bool, share: float) -> dict[str, object]:
    return {"id": question.id, "kind": question.kind, "done": done, "share": share}


def levels_of(values: Floats, first: int) -> list[Floats]:
    """Return values in levels, each of which fills the gaps of those before.

    Examples
    --------
    >>> [level.tolist() for level in levels_of(np.arange(9.0), 3)]
    [[0.0, 4.0, 8.0], [1.0, 2.0, 3.0, 5.0, 6.0, 7.0]]
    """
    steps = [1]
    while len(values) / steps[0] > first:
        steps.insert(0, steps[0] * FINER)
    levels, taken = [], np.zeros(len(values), dtype=bool)
    for step in steps:
        level = np.zeros(len(values), dtype=bool)
        level[::step] = True
        level &= ~taken
        taken |= level
        if level.any():
            levels.append(values[level])
    return levels


def centres(low: float, high: float, size: int) -> Floats:
    """Return the centres of so many equal cells between two ends."""
    return low + (high - low) * (np.arange(size) + 0.5) / size
