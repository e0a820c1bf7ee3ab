"""Orbits that meet no stop: the closed form of the steady motion inside a region."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from flint import acb, arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import BallLaw, coarse_bits, law_of
from percuss.certified.cloud import BallPair, Cloud
from percuss.certified.flight import EnclosedFlight, propagator
from percuss.certified.numbers import ball, constant_of, precision
from percuss.certified.pieces import Moment
from percuss.certified.properties import Monodromy, Proof, is_clear
from percuss.certified.shooting import region_of_row
from percuss.certified.step import (
    Departure,
    at_moment,
    levels_of,
    search_along,
    state_on,
    width_of,
)
from percuss.certified.system import BallSystem
from percuss.model.exact import as_fraction
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit


def steady_flight(
    law: BallLaw, region_number: int, place: Fraction | None = None
) -> EnclosedFlight:
    """Return the steady motion of a region, from t = 0.

    Without a spring its place is arbitrary: it starts at ``place``, if that is given.

    Raises
    ------
    Undecided
        If there is none, or no spring holds it.
    """
    region = law.regions[region_number]
    if not region.spring and (place is None or not constant_of(region.constant).is_zero()):
        raise Undecided("precision", "without a spring steady motion has no place of its own")
    if any(gain is None for gain in region.gains):
        raise Undecided("precision", "at resonance without damping there is no steady motion")
    flight = EnclosedFlight(law, region_number, law.phasors_at(0), arb(0), arb(0))
    x, v = flight.origin, arb(0)
    for omega, p, q, *_ in flight.waves:
        x, v = x + p, v + omega * q
    # The unforced part is zero exactly, or constant without a spring.
    rest = arb(0)
    if not region.spring and place is not None:
        rest = ball(place) - x
        x = ball(place)
    flight.x0, flight.v0 = x, v
    flight.y0, flight.z0 = rest, arb(0)
    flight.a0 = flight.acceleration(x, v, flight.force0)
    return flight


def steady_pieces(system: BallSystem, number: int, period: arb) -> list[tuple[Departure, arb]]:
    """Return the steady motion under a repeated record, as departures into its pieces and their ends.

    From t = 0 to a period later. It returns to its start z there: with the propagator P of a
    period and the end d of the motion from rest, z = P z + d.

    Raises
    ------
    Undecided
        If it is not alone, as at resonance without damping and without a spring.
    """
    by = propagator(law_of(system).regions[number], period)
    zero = arb(0)
    *_, (last, end) = _pieces_from(system, number, (zero, zero), period)
    (dx, dv), _ = state_on(system, last, end)
    one_minus = (1 - by.a11) * (1 - by.a22) - by.a12 * by.a21
    if one_minus.contains(0):
        reason = "whether there is one steady motion alone, without a spring or close to resonance"
        raise Undecided("precision", f"{reason}, is open")
    x = ((1 - by.a22) * dx + by.a12 * dv) / one_minus
    v = ((1 - by.a11) * dv + by.a21 * dx) / one_minus
    return _pieces_from(system, number, (x, v), period)


def _pieces_from(
    system: BallSystem, number: int, state: BallPair, period: arb
) -> list[tuple[Departure, arb]]:
    law, begin = law_of(system), Moment.of(0)
    start = Departure(number, Cloud.of(*state), None, 1, begin, law.piece_at(begin))
    pieces: list[tuple[Departure, arb]] = []
    while True:
        knot = law.next_knot(start.piece)
        assert knot is not None
        # A knot at the very end of the period need not be told from it: nothing is beyond it.
        if not knot.t < period:
            return [*pieces, (start, period)]
        pieces.append((start, knot.t))
        start, _ = at_moment(system, start, knot, start.piece + 1)


def steady_proof(system: BallSystem, orbit: PeriodicOrbit) -> Proof:
    """Return the proof of an orbit without events."""
    number = region_of_row(system, int(orbit.record[1][0, 2]))
    law = law_of(system)
    place = as_fraction(orbit.x0)
    period = law.period(1)
    if system.record is None:
        flight = steady_flight(law, number, place)
        x, v = flight.x0, flight.v0
    else:
        x, v = steady_pieces(system, number, period)[0][0].cloud.box()
    by = propagator(law.regions[number], period)
    matrix = (by.a11, by.a12), (by.a21, by.a22)
    region = law.regions[number]
    determinant = (-2 * region.damping * period).exp() if region.dashpot else arb(1)
    monodromy = Monodromy.of(matrix, determinant, conservative=not region.dashpot)
    one_minus = 1 - monodromy.trace + determinant
    isolated = bool(one_minus > 0 or one_minus < 0)
    admissible, reason = steady_admissible(system, number, period, place)
    if not law.regions[number].spring:
        # One multiplier is 1 exactly, since the place is arbitrary.
        multipliers = acb(1), acb(determinant)
        monodromy = replace(monodromy, multipliers=multipliers, stability="parabolic")
    return Proof(
        events=[],
        states=[],
        before=[],
        period=period,
        monodromy=monodromy,
        admissible=admissible,
        isolated=isolated,
        unique_within=math.inf if isolated else 0.0,
        reason=reason,
        start=(x, v, arb(0)),
    )


def steady_admissible(
    system: BallSystem, number: int, period: arb, place: Fraction | None = None
) -> tuple[bool | None, str]:
    """Return whether the steady motion stays inside its region for a period."""
    if system.record is not None:
        return _stays_inside(system, number, period)
    question = ""
    for coarse in sorted({coarse_bits(system), ctx.prec}):
        with precision(coarse):
            flight = steady_flight(law_of(system), number, place)
            levels = levels_of(system, number)
            inside = [level.sign * (flight.x0 - level.at) for level in levels]
            if any(gap < 0 for gap in inside):
                return False, "it starts beyond a stop"
            search = search_along(system, flight, levels, None, 1, width_of(system, flight))
            try:
                bracket = search.first(float(period.upper()) * 1.000001)
            except Undecided as open_question:
                question = open_question.reason
                continue
        return (True, "") if bracket is None else (False, "it passes through a stop")
    return None, question


def _stays_inside(system: BallSystem, number: int, period: arb) -> tuple[bool | None, str]:
    """Return whether the steady motion under a record stays inside its region, and what is open."""
    try:
        pieces = steady_pieces(system, number, period)
        x, _ = pieces[0][0].cloud.box()
        if any(level.sign * (x - level.at) < 0 for level in levels_of(system, number)):
            return False, "it starts beyond a stop"
        if all(is_clear(system, start, end) for start, end in pieces):
            return True, ""
    except Undecided as question:
        return None, question.reason
    return False, "it passes through a stop"
