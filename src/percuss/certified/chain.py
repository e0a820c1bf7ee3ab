"""The events of an orbit in exact terms: bounds and regions by their numbers in a `System`."""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb

from percuss.certified.law import law_of
from percuss.certified.system import System
from percuss.certified.undecided import Undecided
from percuss.kernels.law import FIRST_HARMONIC, N_HARMONICS
from percuss.model.law import law, lines
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Link", "chain_of", "region_of_row"]


@dataclass(frozen=True, slots=True)
class Link:
    """One event of an orbit.

    Attributes
    ----------
    bound
        Number of the bound.
    before, after
        Numbers of the regions before and after it.
    stop
        The stop that is met, None where soft stops are left.
    wall
        Whether it is an impact on a wall.
    """

    bound: int
    before: int
    after: int
    stop: int | None
    wall: bool

    def kept(self, system: System) -> arb:
        """Return the velocity after the event as a part of that before."""
        if not self.wall:
            return arb(1)
        return -law_of(system).number(f"oscillator.stops.{self.stop}.restitution")


def region_of_row(system: System, row: int) -> int:
    """Return the number of the region of a row of the kernels' law."""
    n = int(law(system.oscillator, system.forcing)[0, N_HARMONICS])
    return (row - FIRST_HARMONIC - n) // (1 + n)


def chain_of(system: System, orbit: PeriodicOrbit) -> list[Link]:
    """Return the events of an orbit, the first one that of its start.

    Raises
    ------
    Undecided
        If stops that are one as floats are not one exactly.
    """
    layout = lines(system.oscillator)
    shift = 1 if layout.at[0] is None else 0
    if len(system.bounds) != sum(at is not None for at in layout.at):
        raise Undecided("precision", "stops that are at one place as floats are not so exactly")
    found = []
    for bound_, before_, after_ in orbit.itinerary.events.tolist():
        bound = int(bound_) - shift
        before, after = region_of_row(system, int(before_)), region_of_row(system, int(after_))
        here = system.bounds[bound]
        stop = here.wall
        if stop is None:
            side = "above" if after > before else "below"
            stops = system.oscillator.stops
            stop = next((i for i in here.edges if stops[i].side == side), None)
        found.append(Link(bound, before, after, stop, here.wall is not None))
    return found
