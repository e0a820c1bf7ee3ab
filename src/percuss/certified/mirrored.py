"""Where the symmetry of orbits breaks: the mirrored map over half of them has a multiplier -1.

A system that is unchanged under (x, t) -> (-x, t + T/2) maps its motions to motions. The map from
an event to the mirror image of the one half an orbit later has symmetric orbits as its fixed
points. On a stretch of the parameter they are alone in a box, a smooth branch. Where the sign of
det(1 + derivative) differs at the ends, a multiplier goes through -1 between them, and the index
of the twice repeated map, det(1 - derivative) det(1 + derivative), changes its sign, as the first
factor does not: orbits that are not symmetric branch off (Krasnosel'skii 1964; for the kind of
breaking Swift & Wiesenfeld 1984).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from percuss.certified.admissible import admissible_of
from percuss.certified.branch import boxed, exact_ball, root_of, system_at, system_over
from percuss.certified.chain import Link
from percuss.certified.cloud import Matrix, times
from percuss.certified.law import law_of
from percuss.certified.orbits import shooting_of
from percuss.certified.shooting import Image, Shooting, States
from percuss.certified.system import System, system_of
from percuss.certified.undecided import Undecided
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.orbit.symmetry import is_symmetric_system

__all__ = ["HalfShooting", "half_of", "symmetry_breaking_of"]


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
        product: Matrix = (arb(1), arb(0)), (arb(0), arb(1))
        following = [*(t for t, _ in states[1:]), states[0][0] + self.period]
        images = self.images(states, ctx.prec)
        for image, (t, _), until in zip(images, states, following, strict=True):
            if not image.alone.contains(until - t):
                raise Undecided("precision", "a flight's root may be another one than the orbit's")
            product = times(image.derivative, product)
        (a, b), (c, d) = product
        return 1 + a + d + (a * d - b * c)


def half_of(system: System, chain: list[Link], n_periods: int) -> HalfShooting:
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


def _check_mirrored(system: System, chain: list[Link], n_periods: int) -> None:
    """Refuse an orbit whose events are not each other's mirror images."""
    half, odd = divmod(len(chain), 2)
    bounds, regions = len(system.bounds) - 1, len(system.regions) - 1
    if odd or not half or n_periods % 2 == 0:
        raise Undecided("symmetry", "the events do not come in two mirrored halves")
    for one, other in zip(chain[:half], chain[half:], strict=True):
        mirrored = bounds - one.bound, regions - one.before, regions - one.after
        if mirrored != (other.bound, other.before, other.after):
            raise Undecided("symmetry", "the events do not come in two mirrored halves")


def _check_parameter(system: System, path: str, value: Fraction) -> None:
    """Refuse a parameter that breaks the symmetry itself: at three values of it, exactly."""
    for part in (Fraction(0), Fraction(1, 10**6), Fraction(-1, 10**6)):
        there = system_at(system, path, value * (1 + part) if value else part)
        if not is_symmetric_system(there.oscillator, there.forcing):
            raise Undecided("symmetry", f"{path} takes the symmetry away from the system itself")
