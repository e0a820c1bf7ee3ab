"""Where the trace of the orbits of a branch goes through a value: doubling and resonance.

On a stretch of the parameter all orbits lie in one box, in which each is alone: they make a
smooth branch. If the function 1 + trace + determinant (or that of a resonance) has different
signs at its ends, it is zero between them.
"""

from __future__ import annotations

from fractions import Fraction

from flint import arb

from percuss.certified.admissible import admissible_of
from percuss.certified.branch import boxed, equations_over, exact_ball, root_of, solution_at
from percuss.certified.chain import Link
from percuss.certified.orbits import monodromy_over, shooting_of
from percuss.certified.shooting import Shooting, States
from percuss.certified.system import System, system_of
from percuss.certified.undecided import Undecided
from percuss.orbits.bifurcations.special_points import SpecialPoint

__all__ = ["crossing_of"]


def crossing_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which the trace goes through its value.

    And whether the orbits at all values in it pass through no stop, None where that is open.
    """
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    equations, guess = shooting_of(system, point.orbit)
    chain, n_periods = equations.chain, point.orbit.n_periods
    if _goes_round_twice(point):
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
    system: System,
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


def _goes_round_twice(point: SpecialPoint) -> bool:
    return point.kind == "period_doubling" and "twice" in point.detail


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
