"""Symbolic proofs for docs/theory/paper-harmonics.md."""

from __future__ import annotations

import importlib
from typing import Any

import pytest

# Without stubs: to mypy it is Any.
sp: Any = importlib.import_module("sympy")

t, V = sp.symbols("t V", real=True)
n, k = sp.symbols("n k", positive=True, integer=True)
SHARE = n / (n**2 - 1)


def slope(amplitude: Any, time: Any) -> Any:
    x = amplitude * sp.sin(t) - sp.sin(n * t) / (n**2 - 1)
    return sp.diff(x, t).subs(t, time)


def test_the_form_solves_the_equation_and_vanishes_on_the_eigenset() -> None:
    amplitude = sp.symbols("A")
    x = amplitude * sp.sin(t) - sp.sin(n * t) / (n**2 - 1)

    assert sp.simplify(sp.diff(x, t, 2) + x - sp.sin(n * t)) == 0
    assert x.subs(t, sp.pi * k) == 0


@pytest.mark.parametrize("parity", ["even", "odd"])
@pytest.mark.parametrize("flight", ["even", "odd"])
def test_amplitudes_and_velocities_on_flights_of_either_parity(parity: str, flight: str) -> None:
    j, i = sp.symbols("j i", positive=True, integer=True)
    number, index = 2 * j + int(parity == "odd"), 2 * i + int(flight == "odd")
    printed = (-1) ** k * (V + SHARE) if parity == "even" else (-1) ** k * V + SHARE
    gained = 2 * SHARE if parity == "even" else 0

    def value(expression: Any) -> Any:
        return sp.simplify(expression.subs({n: number, k: index}))

    assert value(slope(printed, sp.pi * k) - V) == 0
    assert value(-slope(printed, sp.pi * (k + 1)) - V - gained) == 0


@pytest.mark.parametrize("number", [3, 5, 7, 9, 11])
def test_the_shifted_flight_and_its_contact(number: int) -> None:
    xi = sp.symbols("xi", real=True)
    sign, share = (-1) ** ((number - 1) // 2), sp.Rational(number, number**2 - 1)
    wave = sp.Rational(sign, number**2 - 1)
    x = (share - V) * sp.sin(t) - sp.sin(number * t) / (number**2 - 1)
    first = (V - share) * sp.cos(xi) + wave * sp.cos(number * xi)
    second = (V - share) * sp.sin(xi) + number * wave * sp.sin(number * xi)

    shifted = x.subs(t, xi + 2 * sp.pi + 3 * sp.pi / 2)
    assert sp.simplify(sp.expand_trig(shifted - first)) == 0
    assert sp.simplify(sp.diff(first, xi) + second) == 0
    limit = (number - sign * sp.cos(number * xi) / sp.cos(xi)) / (number**2 - 1)
    assert sp.simplify(first.subs(V, limit)) == 0
    tilt = sp.sin(xi) * sp.cos(number * xi) - number * sp.sin(number * xi) * sp.cos(xi)
    # d(26)/d(xi) is (25), so its roots are the stationary points.
    stationary = sp.diff(limit, xi) * sp.cos(xi) ** 2 * (number**2 - 1) + sign * tilt
    assert sp.simplify(sp.expand_trig(stationary)) == 0


def test_the_critical_velocities_three_and_five_are_rational() -> None:
    y = sp.symbols("y", nonnegative=True)

    # sin(ns)/sin(s) is the Chebyshev polynomial U_(n-1)(cos s), a polynomial in y = cos(s)^2.
    for number, expected in ((3, sp.Rational(1, 2)), (5, sp.Rational(25, 96))):
        polynomial = sp.expand(sp.chebyshevu(number - 1, sp.sqrt(y)))
        least = sp.minimum(polynomial, y, sp.Interval(0, 1))
        assert (number - least) / (number**2 - 1) == expected
