"""What takes long, in growing resolution: diagrams, response charts and basins."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats
from percuss.execution import Execution
from percuss.studies.axes import axis_values
from percuss.studies.kinds.diagram import Diagram
from percuss.web.asked import asked_study, check_size
from percuss.web.charts import answer_response
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.kept import KEPT
from percuss.web.question import PageQuestion, range_of
from percuss.web.wording import plain

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

__all__ = ["JOBS", "answer_job"]


# Each level has so many times the values of the one before.
FINER = 4
# Of a diagram: the values of the first level. Of basins: the starts along a side.
FIRST_VALUES, FIRST_STARTS = 64, 48


def answer_job(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
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


def _diagram(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
    """Yield the points of the attractors over a parameter: x and v once a forcing period."""
    check_size(question)
    asked = asked_study(question)
    own = asked.question
    assert isinstance(own, Diagram)
    ((path, axis),) = own.over.items()
    values = axis_values(axis)
    low, high = range_of(question, "low", "high")
    origin = 0.5 * (low + high)
    header = {"path": path, "n_points": own.points, "low": low, "high": high, "origin": origin}
    done, parts, failed, reason = 0, [], 0, ""
    for level in levels_of(np.arange(len(values)), FIRST_VALUES):
        begin, done = done / len(values), done + len(level)
        share = done / len(values)
        some = replace(own, over={path: tuple(values[i] for i in level)})
        found = some.answer(asked, Execution(progress=handle.part(begin, share)))
        if handle.is_stopped:
            return
        parts.append(found)
        reasons = [str(text) for text in found["reason"].values.ravel() if text]
        failed, reason = failed + len(reasons), reason or next(iter(reasons), "")
        told = {"failed": failed, "reason": plain(reason)}
        arrays = {
            "value": found[path].values - origin,
            "period": found["period"].values[0],
            **{name: found[name].values[0].ravel() for name in ("x", "v")},
        }
        if done == len(values):
            KEPT.put(asked, _joined(parts, path))
        yield frame(
            _header(question, done=done == len(values), share=share) | header | told, arrays
        )


def _joined(parts: list[Dataset], path: str) -> Dataset:
    """Return the levels of a diagram as one."""
    import xarray

    whole = xarray.concat(parts, dim=path).sortby(path)
    for name in ("n_impacts", "failed"):
        whole.attrs[name] = sum(part.attrs[name] for part in parts)
    return whole


def _basins(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
    """Yield which attractor each start goes to."""
    check_size(question)
    x_low, x_high = range_of(question, "x_low", "x_high")
    v_low, v_high = range_of(question, "v_low", "v_high")
    edges = {"x_low": x_low, "x_high": x_high, "v_low": v_low, "v_high": v_high}
    finest = int(question.number("starts", 384, 16, 1e9))
    sizes = [finest]
    while sizes[0] > FIRST_STARTS:
        sizes.insert(0, max(FIRST_STARTS, sizes[0] // 2))
    whole, done = sum(size * size for size in sizes), 0
    for size in sizes:
        begin, done = done / whole, done + size * size
        asked = asked_study(replace(question, options={**question.options, "starts": size}))
        found = asked.question.answer(asked, Execution(progress=handle.part(begin, done / whole)))
        if handle.is_stopped:
            return
        if size == finest:
            KEPT.put(asked, found)
        yield frame(
            _header(question, done=size == finest, share=done / whole)
            | {"size": size, "attractors": _attractors(found)}
            | edges,
            {"basin": found.basin.values.ravel(), **_points(found)},
        )


def _attractors(found: Dataset) -> list[dict[str, object]]:
    return [
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


def _points(found: Dataset) -> dict[str, Floats]:
    """Return the points of each attractor, seen once a forcing period."""
    points: dict[str, Floats] = {}
    for k in range(found.sizes["attractor"]):
        x, v = found.attractor_x0.values[k], found.attractor_v0.values[k]
        there = np.isfinite(x) & np.isfinite(v)
        points |= {f"x{k}": x[there], f"v{k}": v[there]}
    return points


JOBS: dict[str, Callable[[PageQuestion, Handle], Iterator[bytes]]] = {
    "diagram": _diagram,
    "response": answer_response,
    "basins": _basins,
}


def _header(question: PageQuestion, *, done: bool, share: float) -> dict[str, object]:
    return {"id": question.id, "kind": question.kind, "done": done, "share": share}


def levels_of(values: NDArray[np.generic], first: int) -> list[NDArray[np.generic]]:
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
