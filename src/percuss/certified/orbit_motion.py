"""Position and velocity on a proven orbit at a time, as balls."""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb

from percuss.certified.chain import Link, region_of_row
from percuss.certified.cloud import Cloud, Pair
from percuss.certified.law import law_of
from percuss.certified.numbers import between, time_ball
from percuss.certified.shooting import States
from percuss.certified.steady import steady_flight
from percuss.certified.step import Departure, flight_of
from percuss.certified.system import System
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_fraction
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Motion", "motion_on"]


@dataclass(frozen=True)
class Motion:
    """The events of an orbit, and what moves between them.

    Attributes
    ----------
    system, chain, states, period
        Of the proof; no events for steady motion.
    orbit
        The float orbit.
    """

    system: System
    chain: list[Link]
    states: States
    period: arb
    orbit: PeriodicOrbit

    def at(self, time: Phase) -> Pair:
        """Return x and v; at an event both sides are in the balls."""
        t = time_ball(time)
        if not self.states:
            number = region_of_row(self.system, int(self.orbit.record[1][0, 2]))
            steady = steady_flight(law_of(self.system), number, as_fraction(self.orbit.x0))
            (x, v), _ = steady.derivatives(t, 1)
            return x, v
        n = len(self.states)
        turns = ((t - self.states[0][0]) / self.period).mid().floor().mid()
        t = t - turns * self.period
        found: Pair | None = None
        # The last flight may reach to the first event a period later, or earlier by the radius.
        for i, shift in ((n - 1, -1), *((i, 0) for i in range(n)), (0, 1)):
            begin = self.states[i][0] + shift * self.period
            end = self.states[(i + 1) % n][0] + (shift + (i + 1) // n) * self.period
            if t < begin or t > end:
                continue
            here = self._on_flight(i, t - begin)
            found = (
                here if found is None else (between(found[0], here[0]), between(found[1], here[1]))
            )
        assert found is not None
        return found

    def _on_flight(self, i: int, s: arb) -> Pair:
        link = self.chain[i]
        place = self.system.bounds[link.bound].at
        start = Departure(link.after, place, Cloud.of(*self.states[i]), link.bound)
        (x, v), _ = flight_of(self.system, start, whole=True).derivatives(s, 1)
        return x, v


def motion_on(motion: Motion | None, time: Phase) -> Pair:
    """Return x and v on an orbit at a time.

    Raises
    ------
    ParameterError
        If the orbit is not proven, or its flights are not those of a list.
    """
    if motion is None:
        reason = "of an orbit that is not proven, or has contacts, no motion is enclosed"
        raise ParameterError("t", time, reason)
    return motion.at(time)
