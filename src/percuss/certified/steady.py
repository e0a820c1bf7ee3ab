"""Orbits that meet no stop: the closed form of the steady motion inside a region."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from flint import acb, arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import BallLaw, coarse_bits, constant_of, law_of
from percuss.certified.flight import EnclosedFlight, propagator
from percuss.certified.numbers import ball, precision
from percuss.certified.properties import Monodromy, Proof
from percuss.certified.shooting import region_of_row
from percuss.certified.step import levels_of, search_along, width_of
from percuss.certified.system import BallSystem
from percuss.model.exact import as_fraction
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["steady_admissible", "steady_flight", "steady_proof"]


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


def steady_proof(system: BallSystem, orbit: PeriodicOrbit) -> Proof:
    """Return the proof of an orbit without events."""
    number = region_of_row(system, int(orbit.record[1][0, 2]))
    law = law_of(system)
    place = as_fraction(orbit.x0)
    flight = steady_flight(law, number, place)
    period = law.period(1)
    by = propagator(flight.region, period)
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
        start=(flight.x0, flight.v0, arb(0)),
    )


def steady_admissible(
    system: BallSystem, number: int, period: arb, place: Fraction | None = None
) -> tuple[bool | None, str]:
    """Return whether the steady motion stays inside its region for a period."""
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
