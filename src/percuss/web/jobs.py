"""Long answers in growing resolution: diagrams, response charts and basins."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.execution import Execution
from percuss.model.paths import replace_parameter
from percuss.orbits import Branch, PeriodicOrbit, continue_orbit, find_orbits
from percuss.orbits.bifurcations.branch import largest_velocities
from percuss.orbits.orbit.extremes import extremes_of
from percuss.studies.axes import axis_values
from percuss.studies.kinds.diagram import Diagram
from percuss.studies.kinds.response import Response
from percuss.studies.study import Study
from percuss.web.answer_cache import ANSWERS
from percuss.web.design_view import answer_design
from percuss.web.fit_view import answer_fit
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest, path_of, range_of, study_of
from percuss.web.view_study import check_size, study_of_view
from percuss.web.wording import plain

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

# What the points of a diagram have, at one section or another.
COLUMNS = ("x", "v", "cycle", "v_after")
# Each level has so many times the values of the one before.
FINER = 4
# Values of the first level of a diagram; starts along a side of the first level of basins.
FIRST_VALUES, FIRST_STARTS = 64, 48
# What the page, which computes charts of two parameters itself, does not.
NO_CHART = (
    "the page of percuss serve computes charts of motions under one harmonic whose numbers are "
    "plain; Files has picture, table and study of any other"
)
# The first families of a chart: at which parts of the range they are looked for, how far and how
# long each is followed [orbits each way, s], and their part of the work.
FIRST_PLACES = (0.5, 1 / 6, 5 / 6)
MOST_ORBITS = 200
PATIENCE = 8.0
FIRST_SHARE = 0.2
# Orbits of one kind are the same if their amplitudes differ by less than this part.
SAME = 0.03
# Without impacts the steps have to be small: no unknown tells how a resonance bends.
LARGEST_STEP, SMALL_STEP = 0.02, 0.005


def answer_job(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Return the frames of a long answer, each finer than the one before; the last says ``done``.

    Raises
    ------
    PercussError, BadRequest
        If there is no answer.
    """
    return JOBS[request.kind](request, running)


def _diagram(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the points of the attractors over a parameter, on the section that is asked for."""
    check_size(request)
    study = study_of_view(request)
    diagram = study.question
    assert isinstance(diagram, Diagram)
    ((path, axis),) = diagram.over.items()
    values = axis_values(axis)
    low, high = range_of(request, "low", "high")
    origin = 0.5 * (low + high)
    header = {"path": path, "n_points": diagram.points, "low": low, "high": high, "origin": origin}
    n_done, levels, n_failed, reason = 0, [], 0, ""
    # A motion that is followed goes through all values in their order.
    branches = diagram.follow or ("start 0",)
    first = len(values) if diagram.follow else FIRST_VALUES
    for level in levels_of(np.arange(len(values)), first):
        begin, n_done = n_done / len(values), n_done + len(level)
        share, is_last = n_done / len(values), n_done == len(values)
        part = replace(diagram, over={path: tuple(values[i] for i in level)})
        data = part.answer(study, Execution(progress=running.progress(begin, share)))
        if running.is_cancelled:
            return
        levels.append(data)
        shown = [data.sel(branch=name) for name in branches]
        reasons = [str(text) for part in shown for text in part["reason"].values if text]
        n_failed, reason = n_failed + len(reasons), reason or next(iter(reasons), "")
        arrays = {
            "value": data[path].values - origin,
            "period": shown[0]["period"].values,
        }
        for suffix, of_branch in zip(("", "_backward"), shown, strict=False):
            columns = [name for name in COLUMNS if name in of_branch]
            arrays |= {f"{name}{suffix}": of_branch[name].values.ravel() for name in columns}
        if is_last:
            ANSWERS.put(study, _joined(levels, path))
        header |= {"failed": n_failed, "reason": plain(reason)}
        yield frame(_header(request, done=is_last, share=share) | header, arrays)


def _joined(levels: list[Dataset], path: str) -> Dataset:
    """Return the levels of a diagram as one."""
    import xarray

    whole = xarray.concat(levels, dim=path).sortby(path)
    for name in ("n_impacts", "failed"):
        whole.attrs[name] = sum(level.attrs[name] for level in levels)
    return whole


def _response(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the families of periodic orbits over a parameter: the first one by one, then all.

    `percuss.response_curve` has no families before its end: those that a search at a few values
    finds are followed first, and shown as they come.

    Parameters
    ----------
    request
        With ``path``, ``low``, ``high``, ``max_impacts`` and ``max_periods``.
    running
        State of the answer.

    Yields
    ------
    bytes
        A frame: `origin`, from which values are counted; `families`, each with its special points;
        for the i-th of them arrays ``value{i}``, ``amplitude{i}``, ``speed{i}``, ``impacts{i}``,
        ``periods{i}``, ``stable{i}``, ``admissible{i}`` and a start on each orbit, ``x{i}``,
        ``v{i}``, ``t{i}``.

    Raises
    ------
    PercussError, BadRequest
        If there is no answer.
    """
    check_size(request)
    study = study_of_view(request)
    low, high = range_of(request, "low", "high")
    path = path_of(request, study_of(request.tables))
    origin = 0.5 * (low + high)
    header = {"path": path, "low": low, "high": high, "origin": origin}
    branches: list[Branch] = []
    for branch, share in _first_families(study, path, (low, high), running):
        branches.append(branch)
        families, arrays = _columns(branches, origin)
        header["families"] = families
        yield frame(_header(request, done=False, share=share) | header, arrays)
    if running.is_cancelled:
        return
    chart = study.question.answer(study, Execution(progress=running.progress(FIRST_SHARE, 1.0)))
    if running.is_cancelled:
        return
    ANSWERS.put(study, chart)
    families, arrays = _columns(chart.branches, origin, chart.amplitude)
    header |= {"families": families, "n_missed": len(chart.missed)}
    yield frame(_header(request, done=True, share=1.0) | header, arrays)


def _first_families(
    study: Study, path: str, ends: tuple[float, float], running: RunningRequest
) -> Iterator[tuple[Branch, float]]:
    """Yield families through the orbits at a few values, each with the share of the work done."""
    question = study.question
    assert isinstance(question, Response)
    until = running.seconds() + PATIENCE
    branches: list[Branch] = []

    def go_on(_done: float, _total: float) -> bool:
        return running.checkpoint() and running.seconds() < until

    for k, part in enumerate(FIRST_PLACES):
        value = ends[0] + part * (ends[1] - ends[0])
        osc, force, _ = replace_parameter(study.oscillator, study.forcing, None, path, value)
        for orbit in find_orbits(osc, force, question.max_impacts, question.max_periods):
            if not go_on(0.0, 1.0):
                return
            is_known = any(_contains(branch, orbit, value) for branch in branches)
            if is_known or math.isinf(orbit.n_impacts):
                continue
            step = LARGEST_STEP if orbit.n_impacts else SMALL_STEP
            try:
                branch = continue_orbit(
                    orbit, {path: ends}, max_points=MOST_ORBITS, largest_step=step, progress=go_on
                )
            except PercussError:
                # The complete chart reports what cannot be followed.
                continue
            branches.append(branch)
            yield branch, FIRST_SHARE * (k + 0.5) / len(FIRST_PLACES)


def _contains(branch: Branch, orbit: PeriodicOrbit, value: float) -> bool:
    """Return whether an orbit is one of a branch, judged by its counts and, with impacts, amplitude."""
    offset = branch.values - value
    wanted = extremes_of(orbit).amplitude
    for k in np.flatnonzero(offset[:-1] * offset[1:] <= 0.0).tolist():
        if (branch[k].n_impacts, branch[k].n_periods) != (orbit.n_impacts, orbit.n_periods):
            continue
        sizes = [extremes_of(branch[i]).amplitude for i in (k, k + 1)]
        steps = branch.values[k + 1] - branch.values[k]
        share = (value - branch.values[k]) / steps if steps else 0.0
        amplitude = sizes[0] + share * (sizes[1] - sizes[0])
        if orbit.n_impacts == 0 or abs(amplitude - wanted) <= SAME * wanted:
            return True
    return False


def _columns(
    branches: Sequence[Branch], origin: float, amplitudes: Sequence[Floats] | None = None
) -> tuple[list[dict[str, object]], dict[str, Floats]]:
    """Return the families of a chart, and their numbered columns with values from an origin."""
    families: list[dict[str, object]] = []
    arrays: dict[str, Floats] = {}
    for i, branch in enumerate(branches):
        families.append({"special": [[p.kind, p.value, p.row] for p in branch.special_points]})
        columns = {
            "value": branch.values - origin,
            "amplitude": amplitudes[i] if amplitudes else _amplitudes(branch),
            "speed": largest_velocities(branch),
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


def _amplitudes(branch: Branch) -> list[float]:
    return [extremes_of(orbit).amplitude for orbit in branch]


def _basins(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield which attractor each start goes to."""
    check_size(request)
    x_low, x_high = range_of(request, "x_low", "x_high")
    v_low, v_high = range_of(request, "v_low", "v_high")
    edges = {"x_low": x_low, "x_high": x_high, "v_low": v_low, "v_high": v_high}
    finest = int(request.number("starts", 384, 16, 1e9))
    sizes = [finest]
    while sizes[0] > FIRST_STARTS:
        sizes.insert(0, max(FIRST_STARTS, sizes[0] // 2))
    n_starts, n_done = sum(size * size for size in sizes), 0
    for size in sizes:
        begin, n_done = n_done / n_starts, n_done + size * size
        share = n_done / n_starts
        study = study_of_view(replace(request, options={**request.options, "starts": size}))
        data = study.question.answer(study, Execution(progress=running.progress(begin, share)))
        if running.is_cancelled:
            return
        if size == finest:
            ANSWERS.put(study, data)
        header = _header(request, done=size == finest, share=share) | edges
        header |= {"size": size, "attractors": _attractors(data)}
        yield frame(header, {"basin": data.basin.values.ravel(), **_points(data)})


def _attractors(data: Dataset) -> list[dict[str, object]]:
    return [
        {
            "kind": str(data.kind.values[k]),
            "name": str(data.name.values[k]),
            "n_periods": int(data.n_periods.values[k]),
            "n_impacts": float(data.n_impacts.values[k]),
            "fraction": float(data.fraction.values[k]),
            "error": float(data.fraction_error.values[k]),
        }
        for k in range(data.sizes["attractor"])
    ]


def _points(data: Dataset) -> dict[str, Floats]:
    """Return the points of each attractor, one a forcing period."""
    points: dict[str, Floats] = {}
    for k in range(data.sizes["attractor"]):
        x, v = data.attractor_x0.values[k], data.attractor_v0.values[k]
        finite = np.isfinite(x) & np.isfinite(v)
        points |= {f"x{k}": x[finite], f"v{k}": v[finite]}
    return points


def _fit(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the parameters fitted to a record."""
    yield from answer_fit(study_of_view(request), request, running)


def _design(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the best setting, or a front."""
    yield from answer_design(study_of_view(request), request, running)


def _sweep(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:  # noqa: ARG001
    """Refuse a chart of two parameters: the kernels in the page compute it, not the server."""
    yield from ()
    check_size(request)
    study_of_view(request)
    raise BadRequest(NO_CHART)


JOBS: dict[str, Callable[[PageRequest, RunningRequest], Iterator[bytes]]] = {
    "diagram": _diagram,
    "response": _response,
    "basins": _basins,
    "design": _design,
    "fit": _fit,
    "sweep": _sweep,
}


def _header(request: PageRequest, *, done: bool, share: float) -> dict[str, object]:
    return {"id": request.id, "kind": request.kind, "done": done, "share": share}


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
