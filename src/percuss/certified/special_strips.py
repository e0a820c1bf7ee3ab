"""Special points as the shortest of branches: strips about one, which its certificate has."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.branch import greatest_speed, parameter_size
from percuss.certified.fold import OrbitCurve, turn_of
from percuss.certified.graze_end import GrazeEnd, graze_about
from percuss.certified.grazing import turning_branch
from percuss.certified.numbers import ball, exact_value, precision
from percuss.certified.shooting import OrbitEvent, Vector, pairs, vector_of
from percuss.certified.special import CertifiedPoint, half_of_doubled
from percuss.certified.strips import Strip, StripEquations, StripWalk
from percuss.certified.system import system_of

# The strips before and after the one with the point, as parts of its length: so short that a sign
# is known on all of them.
PART = Fraction(1, 2**32)
# Sides of strips in a certificate, at least, as parts of their length.
LEAST_SIDE = Fraction(1, 1024)


class PointStrips(NamedTuple):
    """What is proven about a special point.

    Attributes
    ----------
    curve
        The orbits.
    strips
        One before the point, one with it and one after it; none at a graze.
    kind
        As of `Strip.points_before`.
    graze
        What leads to a graze, else None.
    """

    curve: OrbitCurve
    strips: list[Strip]
    kind: str
    graze: GrazeEnd | None


def strips_about(point: CertifiedPoint) -> PointStrips:
    """Return strips of motions about a special point that is proven.

    Raises
    ------
    Undecided
        If its orbits are formal, or no strips are proven, or a point of this kind has none.
    """
    if point.kind == "corner":
        reason = "a corner is the place of a stop, exactly; the orbit next to it has a certificate"
        raise Undecided("kind", reason)
    if point.is_formal:
        raise Undecided("kind", "its orbits pass through a stop")
    with precision(2 * point.precision):
        if point.kind == "grazing":
            return _about_graze(point)
        curve, along, ends, near = _about_fold(point) if point.kind == "fold" else _about(point)
        scale = _scale(point, curve, near)
        walk = StripWalk(StripEquations(curve), scale, 0.0)
        beside = (ends[1] - ends[0]) * PART
        cuts = [ends[0] - beside, *ends, ends[1] + beside]
        strips = []
        for low, high in pairwise(cuts):
            tube = walk.tube(along, low, high, near)
            strips.append(_wider(walk.proven(tube, high), scale))
        kind = point.kind
        if kind == "strong_resonance":
            kind = "fourth_root" if "fourth" in point.point.detail else "third_root"
        if kind not in strips[0].points_before(strips[-1]):
            raise Undecided("precision", f"that strips have a {point.kind} between them is open")
    if not all(strip.admissible for strip in strips):
        raise Undecided("graze", "its orbits are not proven to be motions")
    return PointStrips(curve, strips, kind, None)


def _wider(strip: Strip, scale: Vector) -> Strip:
    """Return a strip with sides that are no thin lines beside its length: plainer bounds prove it."""
    tube = strip.tube
    part = ball((tube.high - tube.low) * LEAST_SIDE).mid() / scale[tube.along]
    trial = [
        size if i == tube.along else size.max((part * scale[i]).mid())
        for i, size in enumerate(tube.trial)
    ]
    return replace(strip, tube=replace(tube, trial=trial))


def _about(point: CertifiedPoint) -> tuple[OrbitCurve, int, list[Fraction], Vector]:
    """Return the orbits of a point, the parameter's number and stretch, and the orbit in the middle."""
    orbit = point.point.orbit
    system = system_of(orbit.oscillator, orbit.forcing)
    events, guess, n_periods = half_of_doubled(point.point, system)
    mirrored = point.kind == "symmetry_breaking"
    curve = OrbitCurve(system, events, n_periods, point.path, mirrored=mirrored)
    if mirrored:
        guess = guess[: len(events) // 2]
    ends = [exact_value(end) for end in (point.value.arb.lower(), point.value.arb.upper())]
    middle = ball((ends[0] + ends[1]) / 2).mid()
    states = curve.equations(middle).newton(guess)
    return curve, 2 * len(states), ends, [*vector_of(states), middle]


def _about_fold(point: CertifiedPoint) -> tuple[OrbitCurve, int, list[Fraction], Vector]:
    """Return the same for a coordinate of the orbit along which the parameter turns."""
    turn = turn_of(point.point, point.path, point.wanted_digits)
    states, value = turn.curve.split(turn.orbit, ball(turn.middle).mid())
    ends = [turn.middle - turn.half, turn.middle + turn.half]
    return turn.curve, turn.curve.along, ends, [*states, value]


def _about_graze(point: CertifiedPoint) -> PointStrips:
    """Return the orbits with an impact at the turning point that touches the stop."""
    turning, orbit = turning_branch(point.point, point.path), point.point.orbit
    system, value = turning.branch.system, exact_value(point.value.arb.mid())
    bound = system.bounds[turning.bound]
    if bound.wall is None:
        raise Undecided(
            "kind", "a touch of a soft stop is no impact, by which the program follows it"
        )
    events, states, n_periods = list(turning.events), list(turning.guess), orbit.n_periods
    touch = OrbitEvent(turning.bound, turning.region, turning.region, bound.wall, wall=True)
    number, t = 0, arb(turning.s)
    if not states:
        # Motion without events repeats after one period.
        n_periods = 1
    else:
        _, states = turning.branch.solution(value, states)
        number, t = turning.flight + 1, states[turning.flight][0] + turning.s
    events.insert(number, touch)
    states.insert(number, (t, arb(0)))
    curve = OrbitCurve(system, events, n_periods, point.path)
    near = [*vector_of(states), ball(value).mid()]
    away = 1 if system.regions[turning.region].lower == turning.bound else -1
    graze = graze_about(curve, _scale(point, curve, near), near, number, away)
    return PointStrips(curve, [], point.kind, graze)


def _scale(point: CertifiedPoint, curve: OrbitCurve, near: Vector) -> Vector:
    """Return the sizes of the coordinates of orbits near a point."""
    states, value, orbit = pairs(near[:-1]), near[-1], point.point.orbit
    period = curve.equations(value).period
    # A motion that touches a stop and meets no other has no velocity there.
    fastest = max(abs(float(v)) for _, v in states) or greatest_speed(orbit)
    size = ball(parameter_size(orbit, point.path, exact_value(value.mid())))
    return [arb(float(period)), arb(fastest)] * len(states) + [size.mid()]
