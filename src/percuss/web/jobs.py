"""What takes long, in growing resolution: diagrams, response charts and basins."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from percuss.model.paths import long_form
from percuss.studies.study import Study
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.question import BadQuestion, Question, motion_of, study_of

__all__ = ["JOBS", "answer_job"]

Floats = NDArray[np.float64]

# Each level has so many times the values of the one before.
FINER = 4
# Of a diagram: the first level, the limits of a question, and forcing periods to settle in.
FIRST_VALUES, MOST_VALUES, MOST_POINTS = 64, 8192, 2_000_000
SETTLING = 200
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
    path = _path(question, study)
    low, high = _range(question, "low", "high")
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


def _response(question: Question, handle: Handle) -> Iterator[bytes]:
    """Yield the families of periodic orbits over a parameter."""
    from percuss.orbits.response import response_curve

    study = study_of(question.tables)
    path = _path(question, study)
    low, high = _range(question, "low", "high")
    if study.forcing is None:
        raise BadQuestion("a response chart needs a forcing")
    found = response_curve(
        study.oscillator,
        study.forcing,
        over={path: (low, high)},
        max_impacts=int(question.number("max_impacts", 3, 1, 6)),
        max_periods=int(question.number("max_periods", 2, 1, 6)),
        progress=handle.part(0.0, 1.0),
    )
    if handle.is_stopped:
        return
    families: list[dict[str, object]] = []
    arrays: dict[str, Floats] = {}
    for i, branch in enumerate(found.branches):
        families.append(
            {
                "n_impacts": branch[0].n_impacts,
                "n_periods": branch[0].n_periods,
                "special": [[p.kind, p.value, p.row] for p in branch.special_points],
            }
        )
        arrays |= {
            f"value{i}": branch.values,
            f"amplitude{i}": found.amplitude[i],
            f"speed{i}": found.impact_velocity[i],
            f"stable{i}": branch.is_stable.astype(np.float64),
            f"admissible{i}": branch.admissible.astype(np.float64),
        }
    header = {"path": path, "low": low, "high": high, "families": families}
    yield frame(_header(question, done=True, share=1.0) | header, arrays)


def _basins(question: Question, handle: Handle) -> Iterator[bytes]:
    """Yield which attractor each start goes to."""
    from percuss.ensembles.basins import basins

    study = study_of(question.tables)
    x_low, x_high = _range(question, "x_low", "x_high")
    v_low, v_high = _range(question, "v_low", "v_high")
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
                "n_periods": int(found.n_periods.values[k]),
                "n_impacts": float(found.n_impacts.values[k]),
                "x": float(found.x.values[k]),
                "v": float(found.v_strobe.values[k]),
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
            {"basin": found.basin.values.ravel()},
        )


JOBS: dict[str, Callable[[Question, Handle], Iterator[bytes]]] = {
    "diagram": _diagram,
    "response": _response,
    "basins": _basins,
}


def _header(question: Question, *, done: bool, share: float) -> dict[str, object]:
    return {"id": question.id, "kind": question.kind, "done": done, "share": share}


def _path(question: Question, study: Study) -> str:
    """Return the path of a parameter of the motion, in its long form."""
    path = question.options.get("path")
    if not isinstance(path, str):
        raise BadQuestion("the path is not a text")
    return long_form(path, study.oscillator, study.forcing)


def _range(question: Question, low: str, high: str) -> tuple[float, float]:
    ends = (question.number(low, 0.0, -1e6, 1e6), question.number(high, 1.0, -1e6, 1e6))
    if ends[0] >= ends[1]:
        raise BadQuestion(f"{low} = {ends[0]:g} is not below {high} = {ends[1]:g}")
    return ends


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
