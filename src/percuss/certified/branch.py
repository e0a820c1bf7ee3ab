"""Orbits along a parameter: exact systems at its values, balls over a stretch of it."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import coarse_bits, law_of
from percuss.certified.numbers import ball, exact_value
from percuss.certified.properties import admissible_of
from percuss.certified.shooting import (
    Residual,
    Shooting,
    States,
    check_inside,
    krawczyk,
    pairs,
    vector_of,
)
from percuss.certified.system import BallSystem, system_of
from percuss.model.dimensions import dimensions_of
from percuss.model.exact import as_float
from percuss.model.paths import moved_in_law, replace_parameter
from percuss.model.units import exponents_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

MOST_STEPS = 60
# The first step of the secant method, as a part of the size of the parameter.
STEP = Fraction(1, 10**9)
# The size of a parameter is at least this part of what the orbit makes of its dimensions, whose
# greatest speed so many samples show well enough.
NEXT_TO_ZERO, SAMPLES = Fraction(1, 10**3), 65
# Bits of derivatives beyond those of runs: sizes of boxes are divided by their differences.
MORE = 64


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
    moved = moved_in_law(middle.oscillator, middle.forcing, path).fields
    is_own = path.startswith(("oscillator.", "forcing."))
    # Phases are numbers of tones.
    known = {*middle.numbers, *(tone.phase_path for tone in middle.tones if not is_own)}
    if not moved.keys() <= known:
        raise Undecided("precision", f"{path} is no number that can be a ball here")
    if any(_layout(system_at(system, path, end)) != _layout(middle) for end in (low, high)):
        reason = f"stops change their order, or a part of the forcing goes, where {path} moves"
        raise Undecided("precision", reason)
    system = dataclasses.replace(middle, moved=(path, low, high))
    if not is_own and not _are_ordered(system):
        raise Undecided("precision", f"stops may change their order where {path} moves")
    return system


def _are_ordered(system: BallSystem) -> bool:
    """Return whether the bounds keep their order: expressions may turn between the ends."""
    return all(low < high for low, high in itertools.pairwise(law_of(system).places))


def _layout(system: BallSystem) -> tuple[object, ...]:
    """Return the parts of a system, without their numbers."""
    tones = [(tone.omega, tone.amplitude, tone.times) for tone in system.tones]
    bounds = [(bound.path, bound.wall, bound.edges) for bound in system.bounds]
    return tones, bounds, system.regions


@dataclass(frozen=True)
class ParameterBranch:
    """The orbits of one sequence of events along a parameter.

    Attributes
    ----------
    system, path
        The system, and the path of the parameter in it.
    equations
        The equations of the orbits in a system.
    size
        Of the parameter, as of `parameter_size`.
    """

    system: BallSystem
    path: str
    equations: Callable[[BallSystem], Shooting]
    size: Fraction

    def at(self, value: Fraction) -> Shooting:
        """Return the equations at a value of the parameter."""
        return self.equations(system_at(self.system, self.path, value))

    def over(self, low: Fraction, high: Fraction) -> Shooting:
        """Return the equations of the orbits at all values between two."""
        return self.equations(system_over(self.system, self.path, low, high))

    def solution(self, value: Fraction, guess: States) -> tuple[Shooting, States]:
        """Return equations and solution at a value of the parameter, near a guess."""
        equations = self.at(value)
        return equations, equations.newton(guess)

    def enclosed_zero(
        self,
        function: Callable[[Shooting, States], arb],
        value: Fraction,
        guess: States,
        digits: int,
    ) -> tuple[arb, bool | None]:
        """Return a ball of the parameter in which a function of the orbits is zero.

        Returns
        -------
        tuple
            The ball; and whether the orbits at all values in it are admissible, None where that
            is open.

        Raises
        ------
        Undecided
            If no change of sign is proven near a value of the parameter.
        """

        def test(value: Fraction) -> arb:
            nonlocal guess
            equations, guess = self.solution(value, guess)
            return function(equations, guess)

        zero = root_of(test, value, self.size)
        low, high = stretch_around(zero, self.size, digits)
        over = self.over(low, high)
        _, middle = self.solution(zero, guess)
        box, trial = boxed(over, middle)
        signs = []
        for end in (low, high):
            equations, states = self.solution(end, middle)
            inner, _ = boxed(equations, states)
            check_inside(vector_of(trial), vector_of(inner))
            signs.append(is_positive(function(equations, inner)))
        if signs[0] == signs[1]:
            raise Undecided("precision", "the test function is not proven to change its sign")
        return ball(low).union(ball(high)), admissible_of(over, box)[0]


def boxed(equations: Shooting, point: States) -> tuple[States, States]:
    """Return boxes with exactly one solution for every value of the parameter.

    All of them lie in the first box, and in the second there are no others.
    """
    coarse = min(ctx.prec, coarse_bits(equations.system) + MORE)
    residual = Residual(lambda z: equations.images(pairs(z), coarse))
    solved = krawczyk(residual.value, residual.derivative, vector_of(point))
    return pairs(solved.box), pairs(solved.trial)


def is_positive(value: arb) -> bool:
    """Return whether a test function is positive."""
    if not (value > 0 or value < 0):
        raise Undecided("precision", "the sign of the test function at an end is open")
    return bool(value > 0)


def parameter_size(orbit: PeriodicOrbit, path: str, value: Fraction) -> Fraction:
    """Return the size of a parameter near a value, in whatever units its numbers are.

    It is that of the value or, next to zero, a part of what has the dimensions of the parameter and
    is of the orbit: its period, how fast it is and, where there is one, the mass.
    """
    osc = orbit.oscillator
    mass, length, time = exponents_of(dimensions_of(path, osc, orbit.forcing))
    # A radian of the period; products of floats may be beyond the greatest one.
    pace = Fraction(float(orbit.period) / (2.0 * math.pi))
    unit = (Fraction(greatest_speed(orbit)) * pace) ** length * pace**time
    if osc.mass is not None:
        unit *= Fraction(as_float(osc.mass)) ** mass
    return max(abs(value), unit * NEXT_TO_ZERO) or Fraction(1)


def greatest_speed(orbit: PeriodicOrbit) -> float:
    """Return about how fast an orbit gets."""
    _, v = orbit.trajectory()(orbit.t0 + orbit.period * np.linspace(0.0, 1.0, SAMPLES))
    return float(np.max(np.abs(v)))


def stretch_around(zero: Fraction, size: Fraction, digits: int) -> tuple[Fraction, Fraction]:
    """Return the ends of a stretch of a parameter that is narrow enough for so many digits."""
    width = size / 10 ** (digits + 2)
    return zero - width, zero + width


def root_of(function: Callable[[Fraction], arb], start: Fraction, size: Fraction) -> Fraction:
    """Return about where a function of a parameter of some size is zero, by the secant method."""
    a, b = start, start + size * STEP
    fa, fb = function(a).mid(), function(b).mid()
    for _ in range(MOST_STEPS):
        if fa == fb:
            break
        move = (fb * (ball(b) - ball(a)) / (fb - fa)).mid()
        following = exact_value(ball(b) - move)
        a, fa = b, fb
        b = following
        # What is left after it is a power 1.6 of it.
        if abs(move) < ball(size / 2 ** (5 * ctx.prec // 8)):
            return b
        fb = function(b).mid()
    raise Undecided("precision", "the secant method finds no zero along the branch")
