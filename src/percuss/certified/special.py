"""Special points of branches: doubling and resonance, broken symmetry, and the proof for each kind."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import cast

from flint import arb, ctx

from percuss.certified.balls import Ball, Undecided
from percuss.certified.branch import (
    boxed,
    equations_over,
    exact_ball,
    root_of,
    solution_at,
    system_at,
    system_over,
)
from percuss.certified.cloud import BallMatrix, times
from percuss.certified.fold import fold_of
from percuss.certified.law import law_of
from percuss.certified.numbers import ball, precision
from percuss.certified.orbits import certify_orbit, monodromy_over, shooting_of
from percuss.certified.properties import admissible_of
from percuss.certified.shooting import Image, Link, Shooting, States
from percuss.certified.system import BallSystem, system_of
from percuss.certified.touch import touch_of
from percuss.model.exact import Exact, as_float, as_fraction
from percuss.model.paths import get_parameter, long_form
from percuss.orbits.bifurcations.special_points import TWO_FOLD, SpecialPoint
from percuss.orbits.orbit.symmetry import is_symmetric_system

__all__ = [
    "CertifiedPoint",
    "HalfShooting",
    "certify_point",
    "crossing_of",
    "half_of",
    "symmetry_breaking_of",
]


def crossing_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which the trace goes through its value.

    And whether the orbits at all values in it pass through no stop, None where that is open.
    """
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    equations, guess = shooting_of(system, point.orbit)
    chain, n_periods = equations.chain, point.orbit.n_periods
    if _is_two_fold_cover(point):
        half = len(chain) // 2
        chain, guess, n_periods = chain[:half], guess[:half], n_periods // 2

    def test(value: Fraction) -> arb:
        nonlocal guess
        there, guess = solution_at(system, chain, n_periods, path, value, guess)
        return _function(point, there, guess)

    value = Fraction(point.value)
    zero = root_of(test, value, (abs(value) + 1) / 10**9)
    return _enclosed(point, system, chain, n_periods, path, zero, guess, digits)


def _enclosed(
    point: SpecialPoint,
    system: BallSystem,
    chain: list[Link],
    n_periods: int,
    path: str,
    zero: Fraction,
    guess: States,
    digits: int,
) -> tuple[arb, bool | None]:
    width = max(abs(zero), Fraction(1, 10**3)) / 10 ** (digits + 2)
    low, high = zero - width, zero + width
    all_ = equations_over(system, chain, n_periods, path, low, high)
    _, middle = solution_at(system, chain, n_periods, path, zero, guess)
    box, trial = boxed(all_, middle)
    signs = []
    for end in (low, high):
        there, states = solution_at(system, chain, n_periods, path, end, middle)
        inside, _ = boxed(there, states)
        if not all(
            b.contains(s) for outer, inner in zip(trial, inside, strict=True)
            for b, s in zip(outer, inner, strict=True)
        ):  # fmt: skip
            raise Undecided("precision", "the ends of the branch lie outside of its box")
        found = _function(point, there, inside)
        if not (found > 0 or found < 0):
            raise Undecided("precision", "the sign at an end of the stretch is open")
        signs.append(bool(found > 0))
    if signs[0] == signs[1]:
        raise Undecided("precision", "the trace does not go through its value on the stretch")
    return exact_ball(low).union(exact_ball(high)), admissible_of(all_, box)[0]


def _is_two_fold_cover(point: SpecialPoint) -> bool:
    return point.kind == "period_doubling" and TWO_FOLD in point.detail


def _function(point: SpecialPoint, equations: Shooting, states: States) -> arb:
    """Return the function whose zero is the special point."""
    monodromy, _ = monodromy_over(equations, states)
    trace = monodromy.trace
    if point.kind == "period_doubling":
        return 1 + trace + monodromy.determinant
    if not monodromy.conservative:
        raise Undecided("precision", "a strong resonance is of conservative families only")
    # Third roots of 1 have trace -1, fourth roots 0.
    return 1 + trace if "third" in point.detail else trace


@dataclass(frozen=True)
class HalfShooting(Shooting):
    """The equations of half a symmetric orbit; the chain is all of it, the period its half."""

    def images(self, states: States, coarse: int) -> list[Image]:
        """Return the images of the states, the last mirrored, and their derivatives."""
        found = []
        for i, state in enumerate(states):
            closes = i + 1 == len(states)
            until = states[0][0] + self.period if closes else states[i + 1][0]
            there = self.arrival(i, state, until, coarse)
            kept = self.chain[i + 1].kept(self.system) * (-1 if closes else 1)
            by_t, by_v = there.derivative
            t, v = there.box
            derivative = by_t, (kept * by_v[0], kept * by_v[1])
            image = t - (self.period if closes else 0), kept * v
            found.append(Image(image, derivative, there.lasts, there.alone))
        return found

    def breaking(self, states: States) -> arb:
        """Return 1 + trace + determinant of the mirrored map over half an orbit.

        Raises
        ------
        Undecided
            If the flights' roots may be others than the events of the orbit.
        """
        product: BallMatrix = (arb(1), arb(0)), (arb(0), arb(1))
        following = [*(t for t, _ in states[1:]), states[0][0] + self.period]
        images = self.images(states, ctx.prec)
        for image, (t, _), until in zip(images, states, following, strict=True):
            if not image.alone.contains(until - t):
                raise Undecided("precision", "a flight's root may be another one than the orbit's")
            product = times(image.derivative, product)
        (a, b), (c, d) = product
        return 1 + a + d + (a * d - b * c)


def half_of(system: BallSystem, chain: list[Link], n_periods: int) -> HalfShooting:
    """Return the equations of half a symmetric orbit."""
    return HalfShooting(system, chain, law_of(system).period(n_periods) / 2)


def symmetry_breaking_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which symmetric orbits lose their symmetry.

    And whether the orbits at all values in it pass through no stop, None where that is open.
    """
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    equations, guess = shooting_of(system, point.orbit)
    chain, n_periods = equations.chain, point.orbit.n_periods
    _check_mirrored(system, chain, n_periods)
    _check_parameter(system, path, Fraction(point.value))
    guess = guess[: len(chain) // 2]

    def at(value: Fraction, near: States) -> tuple[HalfShooting, States]:
        there = half_of(system_at(system, path, value), chain, n_periods)
        return there, there.newton(near)

    def test(value: Fraction) -> arb:
        nonlocal guess
        there, guess = at(value, guess)
        return there.breaking(guess)

    value = Fraction(point.value)
    zero = root_of(test, value, (abs(value) + 1) / 10**9)
    width = max(abs(zero), Fraction(1, 10**3)) / 10 ** (digits + 2)
    low, high = zero - width, zero + width
    all_ = half_of(system_over(system, path, low, high), chain, n_periods)
    middle = at(zero, guess)[1]
    box, trial = boxed(all_, middle)
    signs = [_sign(*at(end, middle), trial) for end in (low, high)]
    if signs[0] == signs[1]:
        raise Undecided("precision", "no multiplier goes through -1 on the stretch")
    return exact_ball(low).union(exact_ball(high)), admissible_of(all_, box)[0]


def _sign(equations: HalfShooting, states: States, trial: States) -> bool:
    """Return the sign of the test function at an end of the stretch."""
    inside, _ = boxed(equations, states)
    for outer, inner in zip(trial, inside, strict=True):
        if not all(b.contains(s) for b, s in zip(outer, inner, strict=True)):
            raise Undecided("precision", "the ends of the branch lie outside of its box")
    found = equations.breaking(inside)
    if not (found > 0 or found < 0):
        raise Undecided("precision", "the sign at an end of the stretch is open")
    return bool(found > 0)


def _check_mirrored(system: BallSystem, chain: list[Link], n_periods: int) -> None:
    """Refuse an orbit whose events are not each other's mirror images."""
    half, odd = divmod(len(chain), 2)
    bounds, regions = len(system.bounds) - 1, len(system.regions) - 1
    if odd or not half or n_periods % 2 == 0:
        raise Undecided("symmetry", "the events do not come in two mirrored halves")
    for one, other in zip(chain[:half], chain[half:], strict=True):
        mirrored = bounds - one.bound, regions - one.before, regions - one.after
        if mirrored != (other.bound, other.before, other.after):
            raise Undecided("symmetry", "the events do not come in two mirrored halves")


def _check_parameter(system: BallSystem, path: str, value: Fraction) -> None:
    """Refuse a parameter that breaks the symmetry itself: at three values of it, exactly."""
    for part in (Fraction(0), Fraction(1, 10**6), Fraction(-1, 10**6)):
        there = system_at(system, path, value * (1 + part) if value else part)
        if not is_symmetric_system(there.oscillator, there.forcing):
            raise Undecided("symmetry", f"{path} takes the symmetry away from the system itself")


FIRST_MARGIN = 80
# Questions that no bits answer.
HOPELESS = ("kind", "symmetry")
WITHOUT_PROOF = {
    "branch_point": (
        "branches that cross without a symmetry part under an arbitrarily small change of any "
        "number, so that no ball, which holds such changes, can prove that they cross"
    ),
    "chatter": (
        "infinitely many impacts accumulate beside it, and the equations of an orbit are of "
        "finitely many"
    ),
}


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedPoint:
    """A special point whose parameter is enclosed; made by `certify`.

    Attributes
    ----------
    kind, path
        Those of the point.
    exists
        Whether it is proven to be there.
    value
        The parameter: without a number if it is not proven.
    statement
        What is proven, in words.
    reason
        What is open, and why.
    wanted_digits, precision
        The digits that were asked for, and the bits that were worked with.
    is_formal
        Whether the orbit there passes through a stop: then what is proven is about the formal
        equations, no motion. True and False are proven, of all orbits over the ball; None is open,
        as at a graze, where no ball tells a touch from a passage.
    """

    kind: str
    path: str
    exists: bool
    value: Ball
    statement: str
    reason: str
    wanted_digits: int
    precision: int
    is_formal: bool | None
    point: SpecialPoint = field(repr=False)

    def __repr__(self) -> str:
        """Tell in a line what is proven."""
        if not self.exists:
            return f"<CertifiedPoint: {self.kind} not proven; {self.reason}>"
        formal = {
            True: "; formal, the orbit passes through a stop",
            False: "",
            None: "; whether the orbit passes through a stop is open",
        }[self.is_formal]
        return f"<CertifiedPoint: {self.kind} at {self.path} = {self.value.text()}{formal}>"


def certify_point(
    point: SpecialPoint, digits: int, most_bits: int, bits: int | None
) -> CertifiedPoint:
    """Prove a special point; see `percuss.certify`."""
    path = long_form(point.path, point.orbit.oscillator, point.orbit.forcing)
    work = bits or math.ceil(digits / math.log10(2)) + FIRST_MARGIN

    def told(
        value: Ball, statement: str, reason: str, admissible: bool | None = None
    ) -> CertifiedPoint:
        exists = not reason
        formal = None if admissible is None else not admissible
        return CertifiedPoint(
            point.kind, path, exists, value, statement, reason, digits, work, formal, point
        )

    while True:
        try:
            with precision(work):
                value, admissible, statement = _proof(point, path, digits)
        except Undecided as question:
            if bits is not None or 2 * work > most_bits or question.kind in HOPELESS:
                return told(Ball(arb.nan()), "", question.reason or question.kind)
            work *= 2
            continue
        return told(Ball(value), statement, "", admissible)


def _proof(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None, str]:
    """Return the parameter, whether the orbits there pass through no stop, and what is proven."""
    if math.isinf(point.orbit.n_impacts):
        reason = "the orbit sticks: it has infinitely many impacts, its equations finitely many"
        raise Undecided("kind", reason)
    if point.kind == "fold":
        return *fold_of(point, path, digits), (
            "on a smooth curve of orbits, along which the parameter is extremal in the ball, a "
            "multiplier goes through 1 there"
        )
    if point.kind in ("period_doubling", "strong_resonance"):
        return *crossing_of(point, path, digits), (
            "on a smooth branch of orbits over the ball, the trace goes through the value of a "
            f"{point.kind.replace('_', ' ')} there"
        )
    if point.kind == "symmetry_breaking":
        return *symmetry_breaking_of(point, path, digits), (
            "on a smooth branch of symmetric orbits over the ball, a multiplier of the map over "
            "half of them goes through -1 there, and orbits without the symmetry branch off"
        )
    if point.kind == "grazing":
        return *touch_of(point, path, digits), (
            "on a smooth branch of orbits over the ball, a turning point passes the stop there"
        )
    if point.kind == "corner":
        return _corner(point, path, digits)
    reason = WITHOUT_PROOF.get(point.kind, f"no proof is known for a {point.kind}")
    raise Undecided("kind", reason)


def _corner(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None, str]:
    """Return the place of the stop that another is moved to, exactly, and what is proven beside."""
    orbit = point.orbit
    met = [orbit.oscillator.stops[i].at for i in set(orbit.sequence)]
    places = {as_fraction(at) for at in met if as_float(at) == point.value}
    moved = as_fraction(_place(point, path))
    others = places - {moved} or places
    if len(others) != 1:
        raise Undecided("kind", "which stops come to lie at one place is not told exactly")
    beside = certify_orbit(orbit, digits, 2**10, None)
    if not beside.exists:
        raise Undecided("kind", f"the orbit beside the corner is not proven; {beside.reason}")
    return (
        ball(others.pop()),
        beside.admissible,
        (
            "two stops that the orbit meets lie at one place there, exactly; what is proven of the "
            f"orbits is the one at {float(moved):.17g}, beside it"
        ),
    )


def _place(point: SpecialPoint, path: str) -> Exact:
    """Return the position of the stop that the parameter moves, as the orbit beside has it."""
    value = get_parameter(point.orbit.oscillator, point.orbit.forcing, None, path)
    return cast("Exact", value)
