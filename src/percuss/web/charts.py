"""A response chart in growing resolution: families of periodic orbits over a parameter."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from percuss.orbits import Response, response_curve
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.question import BadQuestion, Question, path_of, range_of, study_of

__all__ = ["MOST_IMPACTS", "MOST_PERIODS", "answer_response", "columns_of"]

Floats = NDArray[np.float64]

# The longest orbits that may be looked for.
MOST_IMPACTS, MOST_PERIODS = 6, 6
# How many values are searched in the first, rough chart and in the last, and its part of the time.
SEEDS = (2, 16)
ROUGH = 0.25


def answer_response(question: Question, handle: Handle) -> Iterator[bytes]:
    """Yield the families of periodic orbits over a parameter: a rough chart, then a careful one.

    Parameters
    ----------
    question
        With ``path``, ``low``, ``high``, ``max_impacts`` and ``max_periods``.
    handle
        As in `percuss.web.jobs.answer_job`.

    Yields
    ------
    bytes
        A frame: `families`, each with its special points; for the i-th of them arrays ``value{i}``,
        ``amplitude{i}``, ``speed{i}``, ``impacts{i}``, ``periods{i}``, ``stable{i}``,
        ``admissible{i}`` and a start on each orbit, ``x{i}``, ``v{i}``, ``t{i}``.

    Raises
    ------
    PercussError, BadQuestion
        If there is no answer.
    """
    study = study_of(question.tables)
    path = path_of(question, study)
    low, high = range_of(question, "low", "high")
    if study.forcing is None:
        raise BadQuestion("a response chart needs a forcing")
    ends = ((0.0, ROUGH), (ROUGH, 1.0))
    for n_seeds, (begin, end) in zip(SEEDS, ends, strict=True):
        found = response_curve(
            study.oscillator,
            study.forcing,
            over={path: (low, high)},
            max_impacts=int(question.number("max_impacts", 3, 1, MOST_IMPACTS)),
            max_periods=int(question.number("max_periods", 2, 1, MOST_PERIODS)),
            n_seeds=n_seeds,
            progress=handle.part(begin, end),
        )
        if handle.is_stopped:
            return
        families, arrays = columns_of(found)
        header = {
            "id": question.id,
            "kind": question.kind,
            "done": n_seeds == SEEDS[-1],
            "share": end,
            "path": path,
            "low": low,
            "high": high,
            "families": families,
            "n_missed": len(found.missed),
        }
        yield frame(header, arrays)


def columns_of(found: Response) -> tuple[list[dict[str, object]], dict[str, Floats]]:
    """Return the families of a chart and their columns, numbered."""
    families: list[dict[str, object]] = []
    arrays: dict[str, Floats] = {}
    for i, branch in enumerate(found.branches):
        families.append({"special": [[p.kind, p.value, p.row] for p in branch.special_points]})
        columns = {
            "value": branch.values,
            "amplitude": found.amplitude[i],
            "speed": found.impact_velocity[i],
            "stable": branch.is_stable,
            "admissible": branch.admissible,
            "impacts": [orbit.n_impacts for orbit in branch],
            "periods": [orbit.n_periods for orbit in branch],
            "x": [orbit.x0 for orbit in branch],
            "v": [orbit.v0 for orbit in branch],
            "t": [orbit.t0 for orbit in branch],
        }
        arrays |= {f"{name}{i}": np.asarray(column, float) for name, column in columns.items()}
    return families, arrays
