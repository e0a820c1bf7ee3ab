"""How a branch goes on where its orbits begin to meet a soft stop, or no longer meet it.

There the order of events changes. A soft stop's force begins with zero, so that the motion depends
smoothly enough on its start: beyond the graze there is one orbit as well, and it has the two
crossings of the stop's edge more, or less (docs/theory/grazing.md). At the graze itself these two
take no time; the equations are regular there (`Family.residual`), and the branch goes on from it.
A velocity of either sign into a soft stop is one motion, once in it after no time and once before:
the family turns at the graze and comes back formally. The special points before the graze lie
between it and the last point that meets the stop.
"""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.kernels import law as at
from percuss.kernels.law import EDGE, N_HARMONICS
from percuss.model.law import law
from percuss.numerics import norm
from percuss.orbits.bifurcations.family import Family
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    acceleration_at,
    grazing_contacts,
    without,
)
from percuss.orbits.bifurcations.n_fold import orbit_of_itinerary
from percuss.orbits.continuation.correct import WEAK, solved
from percuss.orbits.continuation.locate import Zero, changes_sign, locate
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["is_soft", "orbit_beyond", "start_beyond", "until_soft_graze"]


# Scaled steps off the graze that tell on which side a stop is not met, and the least one.
ASIDE, NEAREST, NEARER = 1e-4, 1e-8, 0.1
# Length of a step that tells which way the parameter goes, and what stands for that way.
OPENED, TINY = 1e-5, 1e-300
# Length of the first step beyond it.
FIRST = 1e-3


def orbit_beyond(family: Family, orbit: PeriodicOrbit, value: float) -> PeriodicOrbit | None:
    """Return an orbit a little beyond a graze of soft stops, with the events that it has there.

    None if there is none near; the arguments are those of `start_beyond`.
    """
    begun = start_beyond(family, orbit, value)
    if begun is None:
        return None
    other, z, tangent = begun
    found, _ = other.stepped_off(z, tangent, FIRST)
    return found


def start_beyond(
    family: Family, orbit: PeriodicOrbit, value: float
) -> tuple[Family, Floats, Floats] | None:
    """Return the family beyond a graze of soft stops, the graze as its point, and its tangent.

    Parameters
    ----------
    family
        The orbits up to the graze.
    orbit
        The one at the graze.
    value
        The parameter there.

    Returns
    -------
    tuple or None
        The unit tangent points away from the graze; None if there is none.
    """
    contacts = [touch for touch in grazing_contacts(orbit) if is_soft(orbit, touch)]
    met = [touch for touch in contacts if touch.events]
    if not contacts or len(met) not in (0, len(contacts)):
        return None
    try:
        if met:
            return _without_entries(family, without(orbit, met), value, met)
        return _with_entries(family, orbit, value, contacts)
    except PercussError:
        return None


def is_soft(orbit: PeriodicOrbit, touch: GrazingContact) -> bool:
    """Return whether a touch is one of a soft stop's edge."""
    table = law(orbit.oscillator, orbit.forcing)
    upper = touch.sign > 0.0
    return bool(table[touch.region, at.UPPER_KIND if upper else at.LOWER_KIND] == EDGE)


def _without_entries(
    family: Family, base: PeriodicOrbit, value: float, contacts: list[GrazingContact]
) -> tuple[Family, Floats, Floats] | None:
    """Return the family that meets the stops no more, on the side where it does not reach them."""
    simpler = Family(base, family.path, family.low, family.high)
    z = simpler.start(base, value)
    tangent = simpler.tangent(z, along_parameter(len(z)))
    part = ASIDE
    while part >= NEAREST:
        signs = []
        for sign in (-1.0, 1.0):
            try:
                beside = simpler.solution(simpler.corrected(z + sign * part * tangent, tangent))
            except PercussError:
                continue
            depths = [_depth(beside, touch) for touch in contacts]
            if all(depth < 0.0 for depth in depths):
                signs.append(sign)
            elif all(depth > 0.0 for depth in depths):
                signs.append(-sign)
        if signs and min(signs) == max(signs):
            return simpler, z, signs[0] * tangent
        part *= NEARER
    return None


def _depth(orbit: PeriodicOrbit, touch: GrazingContact) -> float:
    """Return the depth of the turning point that a touch has become."""
    turns = orbit.turning_points
    apart = (turns.t - touch.t) % orbit.period
    apart = np.minimum(apart, orbit.period - apart)
    apart[turns.bound != touch.bound] = math.inf
    if not len(apart) or not math.isfinite(apart.min()):
        return math.nan
    return -float(turns.clearance[int(np.argmin(apart))])


def _with_entries(
    family: Family, orbit: PeriodicOrbit, value: float, contacts: list[GrazingContact]
) -> tuple[Family, Floats, Floats]:
    """Return the family that meets the stops which an orbit touches, from no time in them on."""
    table = law(orbit.oscillator, orbit.forcing)
    step = 1 + int(table[0, N_HARMONICS])
    instants, events, opening = [], [], [(0.0, 0.0)] * len(orbit.itinerary)
    for touch in contacts:
        beyond = touch.region + int(touch.sign) * step
        instants += [orbit.t0 + (touch.t - orbit.t0) % orbit.period] * 2
        events += [[touch.bound, touch.region, beyond], [touch.bound, beyond, touch.region]]
        short = 2.0 / abs(acceleration_at(table, touch))
        opening += [(short, touch.sign), (0.0, -touch.sign)]
    itinerary, order = orbit.itinerary.inserted(
        np.array(instants), np.array(events, dtype=np.int64), orbit.period
    )
    touching = orbit_of_itinerary(orbit, itinerary)
    other = Family(touching, family.path, family.low, family.high)
    # How flights and velocities open.
    opened = np.concatenate([[0.0], np.array(opening)[order].T.ravel()])
    direction = np.append(opened / other.scale, 0.0)
    direction /= norm(direction)
    z = other.corrected(other.start(touching, value), direction, beside_others=True)
    # Where several stops are touched each may be met alone: the equations hold that weakly.
    matrix = np.vstack([other.derivatives(z), direction])
    tangent = solved(matrix, along_parameter(len(z)), WEAK)
    # The parameter goes with the square of the velocity: what is left of it is a sign.
    tangent[-1] = 0.0
    tangent /= norm(tangent)
    beside = other.corrected(z + OPENED * tangent, tangent, beside_others=True)
    tangent[-1] = math.copysign(TINY, beside[-1] - z[-1])
    return other, z, tangent


# Soft stops that are left at parts of a chord nearer than this are left together.
TOGETHER = 1e-6
# Length of a step that tells how the parameter comes to the graze.
BEFORE = 1e-5
# Distances to a stop below this part of the scale are those of the touch.
TOUCHED = 1e-9


def until_soft_graze(
    a: Point[Family], b: Point[Family]
) -> tuple[Point[Family], list[tuple[str, Zero]]]:
    """Return the end of the stretch on which all stops are met, and the zeros at the graze there.

    Without a soft stop that is left between the two points the end is the second of them.
    """
    family, found = a.problem, []
    for name, before in a.tests.items():
        after = b.tests.get(name, math.nan)
        if family.enters_soft_stop(name) and changes_sign(before, after):
            # Where two stops are left together each may be met or formally not: families cross.
            zero = locate(a, b, partial(family.test, name=name), (before, after))
            if zero is not None:
                found.append((name, zero))
    if not found:
        return b, []
    found.sort(key=lambda it: it[1].part)
    first = found[0][1]
    met = [(name, zero) for name, zero in found if zero.part - first.part < TOGETHER]
    tests = family.tests(first.orbit)
    for name, _ in met:
        tests[name] = 0.0
    if abs(tests["passage"]) < TOUCHED * float(family.rows[0]):
        del tests["passage"]
    tangent = _coming(family, first, b.z - a.z)
    end = Point(first.z, tangent, first.orbit, tests, family)
    return end, [(name, dataclasses.replace(zero, part=1.0)) for name, zero in met]


def _coming(family: Family, zero: Zero, chord: Floats) -> Floats:
    """Return the unit direction of the chord, with the sign of the parameter's way to the graze."""
    along = chord / norm(chord)
    try:
        before = family.corrected(zero.z - BEFORE * along, along, beside_others=True)
        sign = float(zero.z[-1] - before[-1])
    except PercussError:
        sign = 0.0
    tangent = along.copy()
    tangent[-1] = math.copysign(TINY, sign) if sign else 0.0
    return np.asarray(tangent)
