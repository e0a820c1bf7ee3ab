"""A response chart while it grows: families of periodic orbits over a parameter."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.execution import Execution
from percuss.model.paths import replace_parameter
from percuss.orbits import Branch, PeriodicOrbit, continue_orbit, find_orbits
from percuss.orbits.orbit.extremes import extremes_of
from percuss.studies.kinds.response import Response
from percuss.studies.study import Study
from percuss.web.asked import asked_study, check_size
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.kept import KEPT
from percuss.web.question import PageQuestion, path_of, range_of, study_of

__all__ = ["answer_response"]


# The first families: at which parts of the range they are looked for, how far and how long each
# is followed [orbits each way, s], and their part of the work.
SEEN_AT = (0.5, 1 / 6, 5 / 6)
MOST_ORBITS = 200
PATIENCE = 8.0
ROUGH = 0.2
# Orbits of one kind are the same if their amplitudes differ by less than this part.
SAME = 0.03
# Without impacts the steps have to be small: no unknown tells how a resonance bends.
LARGEST_STEP, SMALL_STEP = 0.02, 0.005


def answer_response(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
    """Yield the families of periodic orbits over a parameter: the first one by one, then all.

    `percuss.response_curve` has no families before its end: those that a search at a few values
    finds are followed first, and shown as they come.

    Parameters
    ----------
    question
        With ``path``, ``low``, ``high``, ``max_impacts`` and ``max_periods``.
    handle
        As in `percuss.web.jobs.answer_job`.

    Yields
    ------
    bytes
        A frame: `origin`, which values are counted from; `families`, each with its special points; for the i-th of them arrays ``value{i}``,
        ``amplitude{i}``, ``speed{i}``, ``impacts{i}``, ``periods{i}``, ``stable{i}``,
        ``admissible{i}`` and a start on each orbit, ``x{i}``, ``v{i}``, ``t{i}``.

    Raises
    ------
    PercussError, BadQuestion
        If there is no answer.
    """
    check_size(question)
    asked = asked_study(question)
    low, high = range_of(question, "low", "high")
    path = path_of(question, study_of(question.tables))
    origin = 0.5 * (low + high)
    header = {"id": question.id, "kind": question.kind, "path": path, "low": low, "high": high}
    header["origin"] = origin
    branches: list[Branch] = []
    for branch, share in _first_families(asked, path, (low, high), handle):
        branches.append(branch)
        families, arrays = _columns(branches, origin)
        yield frame({**header, "done": False, "share": share, "families": families}, arrays)
    if handle.is_stopped:
        return
    found = asked.question.answer(asked, Execution(progress=handle.part(ROUGH, 1.0)))
    if handle.is_stopped:
        return
    KEPT.put(asked, found)
    families, arrays = _columns(found.branches, origin, found.amplitude)
    told = {"families": families, "n_missed": len(found.missed)}
    yield frame({**header, "done": True, "share": 1.0, **told}, arrays)


def _first_families(
    asked: Study, path: str, ends: tuple[float, float], handle: Handle
) -> Iterator[tuple[Branch, float]]:
    """Yield families that are found at a few values, and how far that is."""
    own = asked.question
    assert isinstance(own, Response)
    until = handle.seconds() + PATIENCE
    found: list[Branch] = []

    def go_on(_done: float, _total: float) -> bool:
        return handle.go_on() and handle.seconds() < until

    for k, part in enumerate(SEEN_AT):
        value = ends[0] + part * (ends[1] - ends[0])
        osc, force, _ = replace_parameter(asked.oscillator, asked.forcing, None, path, value)
        for orbit in find_orbits(osc, force, own.max_impacts, own.max_periods):
            if not go_on(0, 1):
                return
            if math.isinf(orbit.n_impacts) or any(_holds(it, orbit, value) for it in found):
                continue
            step = LARGEST_STEP if orbit.n_impacts else SMALL_STEP
            try:
                branch = continue_orbit(
                    orbit, {path: ends}, max_points=MOST_ORBITS, largest_step=step, progress=go_on
                )
            except PercussError:
                # The search that follows says what cannot be followed.
                continue
            found.append(branch)
            yield branch, ROUGH * (k + 0.5) / len(SEEN_AT)


def _holds(branch: Branch, orbit: PeriodicOrbit, value: float) -> bool:
    """Return whether an orbit is one of a branch, as far as its counts and its amplitude tell."""
    off = branch.values - value
    wanted = extremes_of(orbit).amplitude
    for k in np.flatnonzero(off[:-1] * off[1:] <= 0.0).tolist():
        near = branch[k]
        if (near.n_impacts, near.n_periods) != (orbit.n_impacts, orbit.n_periods):
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
    """Return the families of a chart and their columns, numbered; values from an origin."""
    families: list[dict[str, object]] = []
    arrays: dict[str, Floats] = {}
    for i, branch in enumerate(branches):
        families.append({"special": [[p.kind, p.value, p.row] for p in branch.special_points]})
        speeds = np.nan_to_num(branch.impact_velocity, nan=-np.inf).max(axis=1, initial=-np.inf)
        columns = {
            "value": branch.values - origin,
            "amplitude": amplitudes[i] if amplitudes else _amplitudes(branch),
            "speed": np.where(np.isfinite(speeds), speeds, np.nan),
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
