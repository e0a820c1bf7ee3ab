"""Families of orbits with sticking along a parameter.

After a release the motion does not depend on the past: an orbit that sticks is the motion from
its release, and is continued by following this motion to the same release again. There are no folds
and no period doublings; a graze between two contacts changes the number of impacts, and not the
release. The family ends where the duration of its last contact goes to zero, or where that contact
is never released. Where one of several contacts vanishes its hops are lost one by one, at grazes
that accumulate.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Literal, Self, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.paths import replace_parameters
from percuss.model.system import System
from percuss.orbits.bifurcations.branch import Branch, branch_of
from percuss.orbits.bifurcations.special_points import LOCATED, SpecialPoint, SpecialPointKind
from percuss.orbits.continuation.follow import STOPPED, Segment, StepLimits, follow
from percuss.orbits.continuation.locate import Sample, bracketed
from percuss.orbits.continuation.problem import Point
from percuss.orbits.finding.search_budget import check_length
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.sticking import sticking_orbit_near
from percuss.progress import Progress

# A bracket of the parameter, as a part of its range, that is as good as a point.
CLOSE = 1e-14
# A contact shorter than this part of the period has zero duration at the end of its family: it
# is a small power of the distance. An impact slower than this part of the fastest is a graze.
NO_TIME, NO_VELOCITY = 1e-3, 1e-3

# Grazes that are located in one step: towards a contact of zero duration there are infinitely many.
MOST_GRAZES = 8
# A last step may be this much longer, and is not one of next to nothing.
LAST = 1.5

# Of each contact its wall, and the stops that are met before the hops that lead to it.
StickingPattern: TypeAlias = tuple[tuple[int, tuple[int, ...]], ...]


class StickingFamily:
    """Orbits with sticking as a problem of continuation, whose only unknown is the parameter."""

    noun = "branch"
    cyclic = slice(0, 0)
    order = 1

    def __init__(self, orbit: PeriodicOrbit, path: str, low: float, high: float) -> None:
        self.paths: tuple[str, ...] = (path,)
        self.low, self.high, self.near, self.n_periods = low, high, orbit, orbit.n_periods

    def started(self, orbit: PeriodicOrbit, value: float) -> Point[Self]:
        """Return the point of an orbit."""
        part = np.array([(value - self.low) / (self.high - self.low)])
        return Point(part, np.ones(1), orbit, {}, self)

    def values(self, z: Floats) -> tuple[float, ...]:
        """Return the parameter of a point."""
        part = float(z[0])
        return (self.high if part == 1.0 else self.low + part * (self.high - self.low),)

    def corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:
        """Return the guess: the parameter alone determines the orbit."""
        del normal, near_others
        return guess

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit that continues the settled one.

        Raises
        ------
        ConvergenceError
            If there is none.
        ParameterError
            If the parameter cannot have the value.
        """
        near, changes = self.near, {self.paths[0]: self.values(z)[0]}
        osc, force, _ = replace_parameters(*near.system, None, changes)
        # Towards omega = 0 the period grows without bound.
        check_length(System(osc, force).law, 0, near.n_periods)
        orbit = sticking_orbit_near(System(osc, force), near)
        if orbit is None:
            raise ConvergenceError("no release comes back", z, math.nan, "take smaller steps")
        return orbit

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return the orbit at a value of the parameter as a point."""
        return Point(z, before.tangent, self.solution(z), {}, self)

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return the point itself."""
        return point

    def recentre(self, point: Point[Self]) -> None:
        """Make a point the centre of the neighbourhood in which the next are computed."""
        self.near = point.orbit

    def corrector_normal(self, tangent: Floats, step: float) -> Floats:  # noqa: ARG002
        """Return the normal of the hyperplane of Newton's correction."""
        return tangent

    def longest_step(self, point: Point[Self], largest: float) -> float:
        """Return the step; the last one may be longer."""
        part = float(point.z[0])
        left = 1.0 - part if point.tangent[0] > 0.0 else part
        return LAST * largest if left < LAST * largest else largest


StickingPoint: TypeAlias = Point[StickingFamily]
StickingRow: TypeAlias = tuple[StickingPoint, SpecialPoint | None]


def sticking_branch(
    orbit: PeriodicOrbit,
    path: str,
    value: float,
    ends: tuple[float, float],
    steps: StepLimits,
    progress: Progress,
) -> Branch:
    """Follow an orbit with sticking along a parameter, both ways.

    Parameters
    ----------
    orbit
        Where to begin.
    path, value
        Path of the parameter, and its value in the orbit's system.
    ends
        Its range; the branch goes from the first to the second.
    steps
        Their number each way at most, and their length as a part of the range.
    progress
        Counts the orbits, and may end the branch.

    Returns
    -------
    Branch
        With the velocity of the fastest impact of each orbit: accumulating hops have no number.
    """
    family = StickingFamily(orbit, path, min(ends), max(ends))
    # All steps are of one length: the parameter is the only unknown, and nothing bends.
    steps = StepLimits(steps.max_points, steps.largest, steps.largest, 0.5 * steps.largest)
    start, detector = family.started(orbit, value), StickingDetector(steps.largest)
    towards = math.copysign(1.0, ends[1] - ends[0])
    ahead, why, _ = follow(start, towards, detector, steps, progress=progress)
    behind: list[StickingRow] = []
    if why != STOPPED and value != ends[0]:
        behind, why_behind, _ = follow(start, -towards, detector, steps, progress=progress)
        why = f"{why}; at the other end {why_behind}"
    rows = [*reversed(behind), (start, None), *ahead]
    fastest = [[abs(point.orbit.impacts.v_before).max()] for point, _ in rows]
    return branch_of(rows, np.array(fastest, dtype=np.float64), why)


class StickingDetector:
    """Finds grazes, and contacts that begin or end, between orbits with sticking."""

    def __init__(self, largest_step: float) -> None:
        self.largest_step = largest_step

    def between(
        self, here: StickingPoint, new: StickingPoint
    ) -> Segment[StickingFamily, SpecialPoint]:
        """Return the special points between two orbits."""
        return Segment(_changes(here, new))

    def stopped(
        self,
        here: StickingPoint,
        reason: str,  # noqa: ARG002
    ) -> Segment[StickingFamily, SpecialPoint]:
        """Return the last orbit of the family, and why it is the last."""
        step = here.problem.longest_step(here, self.largest_step)
        last, beyond = _parted(here, np.clip(here.z + step * here.tangent, 0.0, 1.0), _exists)
        row, why = _end(last, beyond)
        try:
            here.problem.solution(beyond.z)
        except ParameterError as error:
            # The domain of the parameter ends, or the longest orbits do; the family does not.
            no_system = "" if error.name == "n_periods" else "there is no such system: "
            row, why = (last, None), f"beyond {last.text} {no_system}{error.reason}"
        except ConvergenceError:
            pass
        return Segment([*_changes(here, last), row], why)


def _exists(orbit: PeriodicOrbit) -> bool:  # noqa: ARG001
    return True


def _parted(
    here: StickingPoint, end: Floats, is_same_kind: Callable[[PeriodicOrbit], bool]
) -> tuple[StickingPoint, StickingPoint]:
    """Return the last orbit of a kind before a value, and the next one after it."""
    family = here.problem
    family.recentre(here)
    after = here.orbit

    def at(part: float) -> Sample:
        nonlocal after
        z = here.z + part * (end - here.z)
        try:
            orbit = family.solution(z)
        except PercussError:
            return Sample(part, -1.0, z)
        if is_same_kind(orbit):
            family.near = orbit
            return Sample(part, 1.0, z)
        after = orbit
        return Sample(part, -1.0, z)

    ends = Sample(0.0, 1.0, here.z), Sample(1.0, -1.0, end)
    low, high, _, _ = bracketed(at, ends, CLOSE / float(np.abs(end - here.z).max()))
    last = dataclasses.replace(here, z=low.z, orbit=family.near)
    return last, dataclasses.replace(here, z=high.z, orbit=after)


def _changes(one: StickingPoint, other: StickingPoint) -> list[StickingRow]:
    """Return the grazes, and the contacts that begin or end, between two orbits, in order."""
    walls = _walls(one.orbit)
    if walls == _walls(other.orbit):
        return _grazes(one, other)
    low, high = _parted(one, other.z, lambda orbit: _walls(orbit) == walls)
    special = _special(low, high, "chatter", "a contact begins or ends: its duration is zero")
    return [*_grazes(one, low), special, *_changes(high, other)]


def _grazes(one: StickingPoint, other: StickingPoint) -> list[StickingRow]:
    rows: list[StickingRow] = []
    here, last = one, _pattern(other.orbit)
    for _ in range(MOST_GRAZES):
        if _pattern(here.orbit) == last or (here.z == other.z).all():
            break
        low, high = _parted(here, other.z, _has(_pattern(here.orbit)))
        here = high if high.orbit is not here.orbit else other
        detail = _graze(low.orbit, here.orbit)
        if detail:
            rows.append(_special(low, here, "grazing", detail))
    return rows


def _special(
    low: StickingPoint, high: StickingPoint, kind: SpecialPointKind, detail: str
) -> StickingRow:
    family, orbit = low.problem, low.orbit
    (value,), (beyond,) = family.values(low.z), family.values(high.z)
    first, last = sorted((value, beyond))
    exact = last - first <= LOCATED * max(family.high - family.low, abs(last))
    status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
    path = family.paths[0]
    return low, SpecialPoint(kind, path, value, (first, last), status, orbit, -1, detail)


def _end(last: StickingPoint, beyond: StickingPoint) -> tuple[StickingRow, str]:
    """Return the last orbit of the family, and why it is the last."""
    at, orbit = last.text, last.orbit
    contacts = orbit.trajectory().contacts
    durations = contacts.release - contacts.start
    if float(np.min(durations)) < NO_TIME * orbit.period:
        stop = int(contacts.stop[int(np.argmin(durations))])
        detail = f"the contact with stop {stop} has zero duration"
        row = _special(last, beyond, "chatter", detail)
        return row, f"at {at} {detail}: beyond it the release precedes the end of the impacts"
    n = orbit.n_periods
    longest = int(np.argmax(durations))
    if durations[longest] > (1.0 - NO_TIME) * orbit.period / n:
        stop = int(contacts.stop[longest])
        return (last, None), f"beyond {at} the force never releases the mass from stop {stop}"
    periods = "a forcing period" if n == 1 else f"{n} forcing periods"
    return (last, None), f"beyond {at} no release comes back after {periods}"


def _contacts(orbit: PeriodicOrbit) -> list[tuple[int, slice]]:
    """Return of each contact its wall and the impacts before the hops that lead to it."""
    contacts, impacts = orbit.trajectory().contacts, orbit.impacts
    pattern, first = [], 0
    for start, wall in zip(contacts.start.tolist(), contacts.stop.tolist(), strict=True):
        last = int(np.searchsorted(impacts.t, start, side="right"))
        speeds, hop = np.abs(impacts.v_before), last
        while hop > first and impacts.stop[hop - 1] == wall:
            if hop < last and speeds[hop - 1] <= speeds[hop]:
                break
            hop -= 1
        pattern.append((wall, slice(first, hop)))
        first = last
    return pattern


def _pattern(orbit: PeriodicOrbit) -> StickingPattern:
    """Return the stops that are met between the contacts; hops that accumulate do not count."""
    stops = orbit.impacts.stop
    pattern = [(wall, tuple(stops[before].tolist())) for wall, before in _contacts(orbit)]
    # The same for every contact with which the orbit may begin.
    return min(tuple(pattern[k:] + pattern[:k]) for k in range(len(pattern)))


def _has(pattern: StickingPattern) -> Callable[[PeriodicOrbit], bool]:
    return lambda orbit: _pattern(orbit) == pattern


def _walls(orbit: PeriodicOrbit) -> tuple[int, ...]:
    return tuple(wall for wall, _ in _pattern(orbit))


def _graze(one: PeriodicOrbit, other: PeriodicOrbit) -> str:
    """Return in words the graze at which one of two neighbours loses an impact, "" if it is none.

    Two impacts of equal velocity, neither of them slow, change the pattern, too.
    """
    slowest, stop = math.inf, -1
    for orbit in (one, other):
        speeds = np.abs(orbit.impacts.v_before)
        for _, before in _contacts(orbit):
            for k in range(before.start, before.stop):
                if speeds[k] < slowest * speeds.max():
                    slowest, stop = float(speeds[k] / speeds.max()), int(orbit.impacts.stop[k])
    return f"an impact on stop {stop} has no velocity" if slowest < NO_VELOCITY else ""
