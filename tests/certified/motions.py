"""Motions that several tests prove."""

from __future__ import annotations

import functools

import percuss as pc

ELASTIC = pc.impact_oscillator()


def chaotic(n: int) -> pc.Trajectory:
    """Return the chaotic motion of so many impacts."""
    osc = pc.impact_oscillator("0.8", side="above")
    return pc.simulate(osc, pc.cosine("2.8"), v0=-1, max_impacts=n)


@functools.cache
def backlash() -> pc.PeriodicOrbit:
    """Return an unstable orbit that enters both stops of a gap."""
    osc = pc.backlash_oscillator(gap=1, stiffness="26.7", damping="0.1")
    orbits = pc.find_orbits(osc, pc.cosine("1.2", amplitude="1.2"), max_impacts=2, max_periods=2)
    return next(o for o in orbits if o.n_impacts == 2 and o.stability == "unstable")


@functools.cache
def corner_of_two_stops() -> pc.SpecialPoint:
    """Return where one of two soft stops comes to the place 1.1 of the other."""
    stops = pc.SoftStop("1.1", "above", 4), pc.SoftStop("1.2", "above", 9)
    orbit = pc.find_orbit(pc.Oscillator(1, "0.05", stops), pc.cosine("1.5", amplitude=4), 2, 1)
    branch = pc.continue_orbit(orbit, over={"oscillator.stops.1.at": (1.5, 0.9)})
    return next(point for point in branch.special_points if point.kind == "corner")
