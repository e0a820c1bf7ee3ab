"""Families of orbits with sticking along a parameter.

After a release the motion does not depend on the past: an orbit that sticks is the motion from
its release, and what goes on from one value of the parameter to the next is that this motion comes
back to the same release. Nothing folds or doubles; a graze between two contacts changes the number
of impacts, and not the release. The family ends where its last contact lasts no time, or is not
left. Where one of several lasts no time its hops are lost one by one, at grazes that accumulate.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from percuss.errors import ParameterError
from percuss.model.paths import replace_parameters
from percuss.orbits.families.branch import Branch
from percuss.orbits.families.special_points import LOCATED, Kind, SpecialPoint
from percuss.orbits.families.walk import STOPPED
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.sticking import sticking_orbit_near
from percuss.progress import Progress

__all__ = ["sticking_branch"]

# A bracket of the parameter, as a part of its range, that is as good as a point.
CLOSE = 1e-14
# A contact as short as this part of the period, or a flight, lasts no time where the family ends:
# its length is a small power of the distance. So slow, as a part of the fastest, is an impact of no velocity.
NO_TIME, NO_VELOCITY = 1e-3, 1e-3

# Grazes that are told in one step: towards a contact of no time there are infinitely many.
MOST_GRAZES = 8

# Of each contact: its wall, and the stops that are met before the hops that lead to it.
Pattern: TypeAlias = tuple[tuple[int, tuple[int, ...]], ...]


@dataclass(frozen=True, slots=True)
class _At:
    """An orbit at a value of the parameter, and what is special there."""

    value: float
    orbit: PeriodicOrbit
    special: SpecialPoint | None = None


def sticking_branch(
    orbit: PeriodicOrbit,
    path: str,
    value: float,
    ends: tuple[float, float],
    *,
    max_points: int,
    largest_step: float,
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
        Its range; the branch is told from the first to the second.
    max_points, largest_step
        The most steps each way, and their length as a part of the range.
    progress
        Is told of each orbit, and may end the branch.

    Returns
    -------
    Branch
        Of each orbit the velocity of its fastest impact: hops that accumulate have no number.
    """
    line = _Line(path, abs(ends[1] - ends[0]), max_points, largest_step)
    start = _At(value, orbit)
    ahead, why = line.along(start, ends[1], progress)
    behind: list[_At] = []
    if why != STOPPED and value != ends[0]:
        behind, why_behind = line.along(start, ends[0], progress)
        why = f"{why}; at the other end {why_behind}"
    rows = [*reversed(behind), start, *ahead]
    fastest = [(abs(row.orbit.impacts.v_before).max(),) for row in rows]
    orbits = tuple(row.orbit for row in rows)
    values = np.array([row.value for row in rows])
    return Branch(
        path=path,
        values=values,
        arclength=np.append(0.0, np.cumsum(np.abs(np.diff(values)) / line.width)),
        impact_velocity=np.array(fastest, dtype=np.float64),
        multipliers=np.array([it.multipliers for it in orbits]),
        stability=np.array([it.stability for it in orbits]),
        admissible=np.array([it.admissible for it in orbits]),
        grazing_margin=np.array([it.grazing_margin for it in orbits]),
        orbits=orbits,
        special_points=tuple(
            dataclasses.replace(row.special, row=k)
            for k, row in enumerate(rows)
            if row.special is not None
        ),
        end_reason=why,
    )


class _Line:
    """The steps along such a family."""

    def __init__(self, path: str, width: float, max_points: int, step: float) -> None:
        self.path, self.width, self.max_points, self.step = path, width, max_points, step

    def along(self, start: _At, end: float, progress: Progress) -> tuple[list[_At], str]:
        """Go one way; return the rows after the start, and why they end."""
        rows: list[_At] = []
        here = start
        while here.value != end:
            if len(rows) >= self.max_points:
                return rows, f"max_points = {self.max_points} reached"
            way = math.copysign(self.step * self.width, end - here.value)
            value = here.value + way
            # Not a last step of next to nothing.
            value = end if abs(end - value) < 0.5 * abs(way) or way * (end - value) < 0.0 else value
            found = self.orbit_at(value, here.orbit)
            last = here if found is None else _At(value, found)
            rows += self._changes(here, last) if found is not None else []
            if found is None:
                near, beyond = self._parted(here, value, lambda _: True)
                rows += self._changes(here, near)
                at, why = self._end(near, beyond.value)
                return [*rows, at], why
            rows.append(last)
            here = last
            if not progress.advance(text=f"{self.path} = {here.value:.6g}"):
                return rows, STOPPED
        return rows, f"{self.path} = {end:.12g} reached"

    def orbit_at(self, value: float, near: PeriodicOrbit) -> PeriodicOrbit | None:
        """Return the orbit that goes on from another one, None if there is none."""
        try:
            osc, force, _ = replace_parameters(
                near.oscillator, near.forcing, None, {self.path: value}
            )
            return None if force is None else sticking_orbit_near(osc, force, near)
        except ParameterError:
            return None

    def _parted(
        self, here: _At, value: float, goes_on: Callable[[PeriodicOrbit], bool]
    ) -> tuple[_At, _At]:
        """Return the last orbit of a kind before a value, and what comes after it, by halving."""
        low, high, after = here, value, here.orbit
        while abs(high - low.value) > CLOSE * self.width:
            middle = 0.5 * (low.value + high)
            if middle in (low.value, high):
                break
            orbit = self.orbit_at(middle, low.orbit)
            if orbit is not None and goes_on(orbit):
                low = _At(middle, orbit)
            else:
                high, after = middle, after if orbit is None else orbit
        return low, _At(high, after)

    def _changes(self, one: _At, other: _At) -> list[_At]:
        """Return the grazes, and the contacts that begin or end, between two orbits, in order."""
        walls = _walls(one.orbit)
        if walls == _walls(other.orbit):
            return self._grazes(one, other)
        low, high = self._parted(one, other.value, lambda orbit: _walls(orbit) == walls)
        detail = "a contact begins or ends: it lasts no time"
        special = self._special(low, high, "chatter", detail)
        return [*self._grazes(one, low), special, *self._changes(high, other)]

    def _grazes(self, one: _At, other: _At) -> list[_At]:
        found: list[_At] = []
        here, last = one, _pattern(other.orbit)
        for _ in range(MOST_GRAZES):
            if _pattern(here.orbit) == last or here.value == other.value:
                break
            low, high = self._parted(here, other.value, _has(_pattern(here.orbit)))
            here = high if high.orbit is not here.orbit else other
            detail = _graze(low.orbit, here.orbit)
            if detail:
                found.append(self._special(low, here, "grazing", detail))
        return found

    def _special(self, low: _At, high: _At, kind: Kind, detail: str) -> _At:
        first, last = sorted((low.value, high.value))
        exact = last - first <= LOCATED * max(1.0, abs(last))
        status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
        special = SpecialPoint(
            kind, self.path, low.value, (first, last), status, low.orbit, -1, detail
        )
        return _At(low.value, low.orbit, special)

    def _end(self, near: _At, beyond: float) -> tuple[_At, str]:
        """Return the last orbit of the family, and why it is the last."""
        at = f"{self.path} = {near.value:.12g}"
        contacts = near.orbit.trajectory().contacts
        lasting = contacts.release - contacts.start
        if float(np.min(lasting)) < NO_TIME * near.orbit.period:
            stop = int(contacts.stop[int(np.argmin(lasting))])
            detail = f"the contact with stop {stop} lasts no time"
            row = self._special(near, _At(beyond, near.orbit), "chatter", detail)
            return row, f"at {at} {detail}: beyond, the force lets go before the impacts end"
        n = near.orbit.n_periods
        longest = int(np.argmax(lasting))
        if lasting[longest] > (1.0 - NO_TIME) * near.orbit.period / n:
            stop = int(contacts.stop[longest])
            return near, f"beyond {at} the force lets go of stop {stop} no more"
        periods = "a forcing period" if n == 1 else f"{n} forcing periods"
        return near, f"beyond {at} no release comes back after {periods}"


def _contacts(orbit: PeriodicOrbit) -> list[tuple[int, slice]]:
    """Return of each contact its wall and the impacts before the hops that lead to it."""
    contacts, impacts = orbit.trajectory().contacts, orbit.impacts
    found, first = [], 0
    for start, wall in zip(contacts.start.tolist(), contacts.stop.tolist(), strict=True):
        last = int(np.searchsorted(impacts.t, start, side="right"))
        speeds, hop = np.abs(impacts.v_before), last
        while hop > first and impacts.stop[hop - 1] == wall:
            if hop < last and speeds[hop - 1] <= speeds[hop]:
                break
            hop -= 1
        found.append((wall, slice(first, hop)))
        first = last
    return found


def _pattern(orbit: PeriodicOrbit) -> Pattern:
    """Return what tells an orbit from one beyond a graze: hops that accumulate have no number."""
    stops = orbit.impacts.stop
    found = [(wall, tuple(stops[before].tolist())) for wall, before in _contacts(orbit)]
    # Whichever contact the orbit is told from.
    return min(tuple(found[k:] + found[:k]) for k in range(len(found)))


def _has(pattern: Pattern) -> Callable[[PeriodicOrbit], bool]:
    return lambda orbit: _pattern(orbit) == pattern


def _walls(orbit: PeriodicOrbit) -> tuple[int, ...]:
    return tuple(wall for wall, _ in _pattern(orbit))


def _graze(one: PeriodicOrbit, other: PeriodicOrbit) -> str:
    """Return what an impact that one of two neighbours has loses, "" if it is none of no velocity.

    Two impacts of one velocity, neither of them slow, make another pattern, too.
    """
    slowest, stop = math.inf, -1
    for orbit in (one, other):
        speeds = np.abs(orbit.impacts.v_before)
        for _, before in _contacts(orbit):
            for k in range(before.start, before.stop):
                if speeds[k] < slowest * speeds.max():
                    slowest, stop = float(speeds[k] / speeds.max()), int(orbit.impacts.stop[k])
    return f"an impact on stop {stop} has no velocity" if slowest < NO_VELOCITY else ""
