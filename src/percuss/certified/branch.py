"""Orbits along a parameter: exact systems at its values, balls over a stretch of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from fractions import Fraction

from flint import arb, ctx

from percuss.certified.balls import Undecided
from percuss.certified.law import coarse_bits, law_of
from percuss.certified.numbers import ball
from percuss.certified.shooting import Link, Residual, Shooting, States, krawczyk, pairs
from percuss.certified.system import BallSystem, system_of
from percuss.model.paths import replace_parameter

__all__ = [
    "boxed",
    "equations_at",
    "equations_over",
    "exact_value",
    "root_of",
    "solution_at",
    "system_at",
    "system_over",
]

MOST_STEPS = 60
# Bits of derivatives beyond those of runs: sizes of boxes are divided by their differences.
MORE = 64


def exact_value(value: arb) -> Fraction:
    """Return the midpoint of a ball as a fraction."""
    mantissa, exponent = value.mid().man_exp()
    number = Fraction(int(mantissa))
    return number * Fraction(2) ** int(exponent)


def system_at(system: BallSystem, path: str, value: Fraction) -> BallSystem:
    """Return the exact system at a value of a parameter."""
    osc, force, _ = replace_parameter(system.oscillator, system.forcing, None, path, value)
    return system_of(osc, force)


def system_over(system: BallSystem, path: str, low: Fraction, high: Fraction) -> BallSystem:
    """Return the systems at all values of a parameter between two.

    Raises
    ------
    Undecided
        If the parameter cannot be a ball, or stops change their order, or a part of the forcing
        comes or goes, between the two: then what holds at one value is not so at all.
    """
    middle = system_at(system, path, (low + high) / 2)
    if path not in middle.numbers:
        raise Undecided("precision", f"{path} is no number that can be a ball here")
    if any(_layout(system_at(system, path, end)) != _layout(middle) for end in (low, high)):
        reason = f"stops change their order, or a part of the forcing goes, where {path} moves"
        raise Undecided("precision", reason)
    return dataclasses.replace(middle, moved=(path, low, high))


def _layout(system: BallSystem) -> tuple[object, ...]:
    """Return the parts of a system, without their numbers."""
    tones = [(tone.omega, tone.amplitude, tone.times) for tone in system.tones]
    bounds = [(bound.path, bound.wall, bound.edges) for bound in system.bounds]
    return tones, bounds, system.regions


def equations_at(system: BallSystem, chain: list[Link], n_periods: int) -> Shooting:
    """Return the equations of an orbit in a system."""
    return Shooting(system, chain, law_of(system).period(n_periods))


def equations_over(
    system: BallSystem, chain: list[Link], n_periods: int, path: str, low: Fraction, high: Fraction
) -> Shooting:
    """Return the equations of the orbits at all values of a parameter between two."""
    return equations_at(system_over(system, path, low, high), chain, n_periods)


def solution_at(
    system: BallSystem, chain: list[Link], n_periods: int, path: str, value: Fraction, guess: States
) -> tuple[Shooting, States]:
    """Return equations and solution at a value of the parameter, near a guess."""
    equations = equations_at(system_at(system, path, value), chain, n_periods)
    return equations, equations.newton(guess)


def boxed(equations: Shooting, point: States) -> tuple[States, States]:
    """Return boxes with exactly one solution for every value of the parameter.

    All of them lie in the first box, and in the second there are no others.
    """
    coarse = min(ctx.prec, coarse_bits(equations.system) + MORE)

    residual = Residual(lambda z: equations.images(pairs(z), coarse))
    solved = krawczyk(residual.value, residual.derivative, [x for state in point for x in state])
    return pairs(solved.box), pairs(solved.trial)


def root_of(function: Callable[[Fraction], arb], start: Fraction, step: Fraction) -> Fraction:
    """Return about where a function of a parameter is zero, by the secant method.

    Raises
    ------
    Undecided
        If it does not converge.
    """
    a, b = start, start + step
    fa, fb = function(a).mid(), function(b).mid()
    for _ in range(MOST_STEPS):
        if fa == fb:
            break
        move = (fb * (exact_ball(b) - exact_ball(a)) / (fb - fa)).mid()
        following = exact_value(exact_ball(b) - move)
        a, fa = b, fb
        b = following
        if abs(move) < exact_ball(Fraction(1, 2 ** (ctx.prec // 2))) * (1 + abs(exact_ball(b))):
            return b
        fb = function(b).mid()
    raise Undecided("precision", "the secant method finds no zero along the branch")


def exact_ball(value: Fraction) -> arb:
    """Return a ball around a fraction."""
    return ball(value)
