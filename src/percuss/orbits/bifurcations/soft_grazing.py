"""Continuation through the grazing of a soft stop.

There the order of events changes. The force of a soft stop begins at zero, so that the motion
depends smoothly enough on its start: beyond the graze there is one orbit as well, with two
crossings of the stop's edge more, or less (docs/theory/grazing.md). At the graze itself the time
between these two is zero; the equations are regular there (`BranchEquations.residual`), and the
branch continues from it. Velocities of either sign into a soft stop belong to the same motion, with
positive and negative times in the stop: the family turns at the graze and returns formally. The
special points before the graze lie between it and the last point that meets the stop.
"""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import EDGE, N_HARMONICS
from percuss.numerics import norm
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    acceleration_at,
    grazing_contacts,
    without,
)
from percuss.orbits.bifurcations.multiple_covers import orbit_of_itinerary
from percuss.orbits.continuation.correct import WEAK, solved
from percuss.orbits.continuation.locate import Zero, changes_sign, locate
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.itinerary import entries_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

# First and least scaled step off the graze that shows on which side a stop is not met, and factor
# between two.
ASIDE, NEAREST, NEARER = 1e-4, 1e-8, 0.1
# Length of a step that shows the direction of the parameter, and a number that has its sign.
OPENED, TINY = 1e-5, 1e-300
# Length of the first step beyond the graze.
FIRST = 1e-3


def orbit_beyond(
    family: BranchEquations, orbit: PeriodicOrbit, value: float
) -> PeriodicOrbit | None:
    """Return an orbit a little beyond a graze of soft stops, with its events there.

    None if there is none near; the arguments are those of `start_beyond`.
    """
    start = start_beyond(family, orbit, value)
    if start is None:
        return None
    other, z, tangent = start
    new, _ = other.stepped_off(z, tangent, FIRST)
    return new


def start_beyond(
    family: BranchEquations, orbit: PeriodicOrbit, value: float
) -> tuple[BranchEquations, Floats, Floats] | None:
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
    contacts = [contact for contact in grazing_contacts(orbit) if is_soft(orbit, contact)]
    met = [contact for contact in contacts if contact.events]
    if not contacts or len(met) not in (0, len(contacts)):
        return None
    if not met and (np.diff(orbit.itinerary.instants) < 0.0).any():
        # Among formal flights of negative duration other events have no place.
        return None
    try:
        if met:
            return _without_entries(family, without(orbit, met), value, met)
        return _with_entries(family, orbit, value, contacts)
    except PercussError:
        return None


def is_soft(orbit: PeriodicOrbit, contact: GrazingContact) -> bool:
    """Return whether a grazing contact is one with the edge of a soft stop."""
    law = orbit.system.law
    upper = contact.sign > 0.0
    return bool(law[contact.region, at.UPPER_KIND if upper else at.LOWER_KIND] == EDGE)


def _without_entries(
    family: BranchEquations, base: PeriodicOrbit, value: float, contacts: list[GrazingContact]
) -> tuple[BranchEquations, Floats, Floats] | None:
    """Return the family that does not meet the stops, on the side where it does not reach them."""
    simpler = BranchEquations(base, family.path, family.low, family.high)
    z = simpler.start(base, value)
    tangent = simpler.tangent(z, along_parameter(len(z)))
    part = ASIDE
    while part >= NEAREST:
        signs = []
        for sign in (-1.0, 1.0):
            try:
                neighbour = simpler.solution(simpler.corrected(z + sign * part * tangent, tangent))
            except PercussError:
                continue
            depths = [_depth(neighbour, contact) for contact in contacts]
            if all(depth < 0.0 for depth in depths):
                signs.append(sign)
            elif all(depth > 0.0 for depth in depths):
                signs.append(-sign)
        if signs and min(signs) == max(signs):
            return simpler, z, signs[0] * tangent
        part *= NEARER
    return None


def _depth(orbit: PeriodicOrbit, contact: GrazingContact) -> float:
    """Return the depth of the turning point that continues a grazing contact."""
    turns = orbit.turning_points
    distances = (turns.t - contact.t) % orbit.period
    distances = np.minimum(distances, orbit.period - distances)
    distances[turns.bound != contact.bound] = math.inf
    if not len(distances) or not math.isfinite(distances.min()):
        return math.nan
    return -float(turns.clearance[int(np.argmin(distances))])


def _with_entries(
    family: BranchEquations, orbit: PeriodicOrbit, value: float, contacts: list[GrazingContact]
) -> tuple[BranchEquations, Floats, Floats]:
    """Return the family that meets the grazed stops, from zero time in them on."""
    law = orbit.system.law
    step = 1 + int(law[0, N_HARMONICS])
    instants, events, opening = [], [], [(0.0, 0.0)] * len(orbit.itinerary)
    for contact in contacts:
        inside = contact.region + int(contact.sign) * step
        instants += [orbit.t0 + (contact.t - orbit.t0) % orbit.period] * 2
        events += [[contact.bound, contact.region, inside], [contact.bound, inside, contact.region]]
        short = 2.0 / abs(acceleration_at(law, contact))
        opening += [(short, contact.sign), (0.0, -contact.sign)]
    added = np.array(events, dtype=np.int64)
    first = int(np.argmin(instants))
    if len(orbit.itinerary) == 0 and not entries_of(orbit.system, added[first : first + 1]):
        # An orbit inside a stop leaves it first; an itinerary begins with an entry.
        instants[first] += orbit.period
    itinerary, order = orbit.itinerary.inserted(np.array(instants), added, orbit.period)
    grazing = orbit_of_itinerary(orbit, itinerary)
    other = BranchEquations(grazing, family.path, family.low, family.high)
    # The rates at which durations and velocities grow.
    opened = np.concatenate([[0.0], np.array(opening)[order].T.ravel()])
    direction = np.append(opened / other.scale, 0.0)
    direction /= norm(direction)
    z = other.corrected(other.start(grazing, value), direction, near_others=True)
    # Of several grazed stops each may be met alone: then a singular value is small.
    matrix = np.vstack([other.derivatives(z), direction])
    tangent = solved(matrix, along_parameter(len(z)), WEAK)
    # The parameter changes with the square of the velocity: of its component the sign is left.
    tangent[-1] = 0.0
    tangent /= norm(tangent)
    neighbour = other.corrected(z + OPENED * tangent, tangent, near_others=True)
    tangent[-1] = math.copysign(TINY, neighbour[-1] - z[-1])
    return other, z, tangent


# Soft stops whose grazes are nearer than this part of a chord are grazed together.
TOGETHER = 1e-6
# Length of a step that shows the direction of the parameter at the graze.
BEFORE = 1e-5
# Clearances below this part of the scale are zero at the grazing contact.
GRAZED = 1e-9


def until_soft_graze(
    a: Point[BranchEquations], b: Point[BranchEquations]
) -> tuple[Point[BranchEquations], list[tuple[str, Zero]]]:
    """Return the end of the stretch on which all stops are met, and the zeros at the graze there.

    If every soft stop is met at both points the end is the second of them.
    """
    family, zeros = a.problem, []
    for name, before in a.tests.items():
        after = b.tests.get(name, math.nan)
        if family.enters_soft_stop(name) and changes_sign(before, after):
            # Where two stops are grazed together each may be met or not, formally: families cross.
            zero = locate(a, b, partial(family.test, name=name), (before, after))
            if zero is not None:
                zeros.append((name, zero))
    if not zeros:
        return b, []
    zeros.sort(key=lambda named: named[1].part)
    first = zeros[0][1]
    met = [(name, zero) for name, zero in zeros if zero.part - first.part < TOGETHER]
    tests = family.tests(first.orbit)
    for name, _ in met:
        tests[name] = 0.0
    if abs(tests["clearance"]) < GRAZED * float(family.rows[0]):
        del tests["clearance"]
    tangent = _incoming(family, first, b.z - a.z)
    end = Point(first.z, tangent, first.orbit, tests, family)
    return end, [(name, dataclasses.replace(zero, part=1.0)) for name, zero in met]


def _incoming(family: BranchEquations, zero: Zero, chord: Floats) -> Floats:
    """Return the unit vector of the chord, with the sign of the parameter's change to the graze."""
    along = chord / norm(chord)
    try:
        before = family.corrected(zero.z - BEFORE * along, along, near_others=True)
        sign = float(zero.z[-1] - before[-1])
    except PercussError:
        sign = 0.0
    tangent = along.copy()
    tangent[-1] = math.copysign(TINY, sign) if sign else 0.0
    return np.asarray(tangent)
