"""Symbolic proofs for docs/theory/paper-family.md."""

from __future__ import annotations

import importlib
from typing import Any

import pytest

# Without stubs: to mypy it is Any.
sp: Any = importlib.import_module("sympy")

t, A, V = sp.symbols("t A V", real=True)
m = sp.symbols("m", positive=True, integer=True)
M = m + 1
PHI = sp.pi / M
Q = 2 / M * sp.sin(PHI)
PRINTED = A * sp.sin(t) - sp.cos((2 * t + sp.pi) / M) + sp.cos(PHI)


def force(factor: Any) -> Any:
    return factor * sp.cos((2 * t + sp.pi) / M) + sp.cos(PHI)


def vanishes(expression: Any) -> bool:
    return bool(sp.simplify(sp.expand_trig(expression)) == 0)


def at(expression: Any, time: Any) -> Any:
    return expression.subs(t, time)


def after(x: Any, time: Any) -> Any:
    """Return the velocity after an elastic impact."""
    return -at(sp.diff(x, t), time)


def test_the_corrected_force_belongs_to_the_motion_and_the_printed_one_does_not() -> None:
    own = sp.diff(PRINTED, t, 2) + PRINTED

    assert vanishes(own - force((1 - m) * (m + 3) / M**2))
    residual = sp.simplify(own - force((3 - m) * (m + 5) / M**2))
    assert sp.simplify(residual + 12 / M**2 * sp.cos((2 * t + sp.pi) / M)) == 0


@pytest.mark.parametrize("number", range(2, 9))
def test_the_motion_vanishes_on_the_set_for_every_amplitude(number: int) -> None:
    x = PRINTED.subs(m, number)

    for time in (0, number, number + 1, 2 * number + 1):
        assert vanishes(at(x, time * sp.pi))


@pytest.mark.parametrize("number", range(2, 9))
def test_amplitudes_and_velocities_of_one_period(number: int) -> None:
    x, q = PRINTED.subs(m, number), Q.subs(m, number)
    long, short = V - q, -V + q * (1 + 2 * (-1) ** number)
    slope = sp.diff(x, t)

    assert vanishes(at(slope, 0).subs(A, long) - V)
    assert not vanishes(at(slope, 0).subs(A, V + q) - V)
    between = after(x.subs(A, long), number * sp.pi)
    assert vanishes(between - (V if number % 2 else 2 * q - V))
    assert vanishes(at(slope, number * sp.pi).subs(A, short) - between)
    last = after(x.subs(A, short), (number + 1) * sp.pi)
    assert vanishes(last - (V if number % 2 else 2 * q - V))


def test_the_free_part_is_a_product() -> None:
    free = sp.cos(PHI) - sp.cos((2 * t + sp.pi) / M)
    product = 2 * sp.sin(t / M) * sp.sin((t + sp.pi) / M)

    assert sp.simplify(sp.expand(free.rewrite(sp.exp) - product.rewrite(sp.exp))) == 0


def test_the_contact_system_without_its_amplitude_is_the_equation_of_the_contact_time() -> None:
    free = 2 * sp.sin(t / M) * sp.sin((t + sp.pi) / M)
    eliminated = free * sp.cos(t) - sp.diff(free, t) * sp.sin(t)
    ours = M * sp.cot(t) - sp.cot(t / M) - sp.cot((t + sp.pi) / M)

    ratio = free * sp.sin(t) / M * ours
    for number in (3, 5, 8):
        for time in (sp.Rational(7, 2), sp.Rational(9, 2), 6):
            difference = (eliminated - ratio).subs({m: number, t: time})
            assert abs(difference.evalf(40)) < 1e-35


def test_the_critical_velocities_three_and_five() -> None:
    third = sp.cos(PHI).subs(m, 3) + 1 + Q.subs(m, 3)
    assert vanishes(third - (1 + 3 * sp.sqrt(2) / 4))

    # Least ratio 4/3, to 35 digits.
    ratio = ((sp.cos(PHI) - sp.cos((2 * t + sp.pi) / M)) / -sp.sin(t)).subs(m, 5)
    tilt = sp.diff(ratio, t)
    root = sp.nsolve(tilt, t, 4.485, prec=40)
    assert abs((ratio.subs(t, root) - sp.Rational(4, 3)).evalf(40)) < 1e-35
    assert Q.subs(m, 5) == sp.Rational(1, 6)


def test_difference_of_two_flights_and_the_general_flight() -> None:
    start, x0 = sp.symbols("start x0", real=True)
    p = sp.Function("p")
    flight = (
        (V - sp.diff(p(start), start)) * sp.sin(t - start) - p(start) * sp.cos(t - start) + p(t)
    )

    assert vanishes(sp.diff(flight, t, 2) + flight - sp.diff(p(t), t, 2) - p(t))
    assert flight.subs(t, start) == 0
    slope = (sp.diff(flight - p(t), t)).subs(t, start) + sp.diff(p(start), start)
    assert vanishes(slope - V)
    printed = A * sp.sin(t) - x0 + p(t)
    assert vanishes(sp.diff(printed, t, 2) + printed - sp.diff(p(t), t, 2) - p(t) + x0)
