"""What the program that checks certificates computes holds what others compute."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import flint
import numpy as np
import pytest
from tests.certified.checker import (
    SOFT,
    WALL,
    run_of,
)

import percuss as pc
from arithmetic import Dual, cosine_and_sine, cosine_series, exponential, of, pi, unit
from flights import Flight, State, met
from lists import Returns
from percuss.certified import certificate
from reading import LAW, law_of, read


def test_dual_numbers_hold_the_derivatives_of_their_values() -> None:
    random = np.random.default_rng(2)
    one = of(1)
    for _ in range(60):
        point = Fraction(random.uniform(-6, 3))
        at, step = Dual(of(point), one), Fraction(1, 2**50)

        def functions(x: Any) -> tuple[Any, ...]:
            c, s = cosine_series(x)
            return c, s, exponential(x), 3 / (x * x + 2) - x / 7

        slopes = [part.slope for part in functions(at)]
        ahead, behind = (functions(of(point + sign * step)) for sign in (1, -1))
        for slope, high, low in zip(slopes, ahead, behind, strict=True):
            difference = float(sum((high - low).fractions()) / 2 / (2 * step))
            first, last = map(float, slope.fractions())
            # The slope of S near 0 is known to z^2/1600.
            assert last - first < 0.006
            assert first - 1e-8 <= difference <= last + 1e-8


def boxes_about(point: list[float], seed: int) -> list[list[list[Fraction]]]:
    """Return the opposite corners of some boxes, 1e-4 wide, about a point."""
    random = np.random.default_rng(seed)
    return [
        [[Fraction(value + random.uniform(-5e-5, 5e-5)) for value in point] for _ in range(2)]
        for _ in range(20)
    ]


def assert_mean_value(corners: list[list[Fraction]], values: list[Any], rows: Any) -> None:
    apart = [of(b) - of(a) for a, b in zip(*corners, strict=True)]
    for row, one, other in zip(rows, *values, strict=True):
        mean = sum((entry * way for entry, way in zip(row, apart, strict=True)), of(0))
        assert mean.low <= (other - one).low
        assert (other - one).high <= mean.high
        assert mean.width < unit() >> 13


@pytest.mark.parametrize("n", [1, 2])
def test_derivatives_of_returns_to_a_wall_hold_the_differences(n: int) -> None:
    law = law_of(read(certificate(run_of(WALL, pc.cosine("14/5"), v0=1, max_impacts=2))["law"],
                                  LAW))  # fmt: skip
    returns = Returns(law, n, n, (Fraction(1, 5), Fraction(3)))
    at = of(0)

    for corners in boxes_about([1.9, 0.8], n):
        starts = [State(of(t), at, of(v)) for t, v in corners]
        (t, v) = (of(min(pair), max(pair)) for pair in zip(*corners, strict=True))
        _, rows = returns.missed(State(t, at, v))
        assert_mean_value(corners, [returns.missed(it)[0] for it in starts], rows)


@pytest.mark.parametrize("departed", [0, None])
def test_derivatives_of_events_hold_the_differences(departed: int | None) -> None:
    """From a soft stop into its spring, and from between the stops at one instant."""
    law = law_of(read(certificate(run_of(SOFT, pc.cosine("11/10"), v0=1, t_end=3))["law"],
                                  LAW))  # fmt: skip
    region, place = (1, Fraction(1, 2)) if departed == 0 else (0, Fraction(1, 5))

    def state(first: Any, v: Any) -> Any:
        if departed is None:
            return State(of(1), first, v)
        return State(first, of(place), v)

    for corners in boxes_about([0.2 if departed is None else 1.0, 0.8], 7):
        ends = [met(Flight(law, region, state(*map(of, it))), departed) for it in corners]
        box = (of(min(pair), max(pair)) for pair in zip(*corners, strict=True))
        event = met(Flight(law, region, state(*box)), departed)
        values = [(it.after.t, it.after.v) for it in ends]
        assert_mean_value(corners, values, event.derivative)


@pytest.mark.parametrize("bits", [128, 512])
def test_series_hold_what_forty_digits_and_more_say(bits: int, monkeypatch: Any) -> None:
    monkeypatch.setattr("arithmetic.BITS", bits)
    random = np.random.default_rng(0)
    with flint.ctx.workprec(2 * bits):
        for value in (*random.uniform(-60, 60, 60).tolist(), 0.0, -1e-30, 1e-30, 1.0):
            z = flint.arb(value)
            root = abs(z).sqrt()
            c = root.cos() if value < 0 else root.cosh()
            s = (root.sin() if value < 0 else root.sinh()) / root if value else flint.arb(1)
            for ours, true in zip(cosine_series(of(Fraction(value))), (c, s), strict=True):
                scaled = true * flint.arb(2) ** bits
                assert ours.low <= scaled <= ours.high
                assert ours.width < 2**40
            y = value / 8
            scaled = flint.arb(y).exp() * flint.arb(2) ** bits
            ours = exponential(of(Fraction(y)))
            assert ours.low <= scaled <= ours.high
        scaled = flint.arb.pi() * flint.arb(2) ** bits
        assert pi().low <= scaled <= pi().high
        assert pi().width < 2**12


def test_series_of_intervals_hold_those_of_their_points() -> None:
    random = np.random.default_rng(1)
    for _ in range(200):
        z, width = random.uniform(-30, 5), random.uniform(0, 0.9)
        whole = cosine_series(of(Fraction(z), Fraction(z + width)))
        point = cosine_series(of(Fraction(z + width * random.random())))
        for a, b in zip(whole, point, strict=True):
            assert a.low <= b.low <= b.high <= a.high


def test_products_and_quotients_of_intervals_hold_those_of_their_ends() -> None:
    """Of all signs, exact ends rounded outward by less than a unit."""
    some = [Fraction(n, 7) for n in (-5, -2, 0, 1, 4)]
    sides = [(a, b) for a in some for b in some if a <= b]
    for (a, b), (c, d) in product(sides, sides):
        one, other = of(a, b), of(c, d)
        ends = [x * y for x in one.fractions() for y in other.fractions()]
        results = [(one * other, ends), (one.square(), [x * x for x in one.fractions()])]
        if c * d > 0:
            ends = [x / y for x in one.fractions() for y in other.fractions()]
            results.append((one / other, ends))
        if a <= 0 <= b:
            results[1][1].append(Fraction(0))
        for found, exact in results:
            low, high = found.fractions()
            assert low <= min(exact) < low + Fraction(1, unit())
            assert high - Fraction(1, unit()) < max(exact) <= high


@pytest.mark.parametrize("width", [0, 1e-9, 0.3])
def test_cosines_and_sines_of_intervals_hold_those_of_their_points(width: float) -> None:
    random = np.random.default_rng(4)
    for start in (*random.uniform(-30, 30, 60).tolist(), 0.0, 1e6):
        whole = cosine_and_sine(of(Fraction(start), Fraction(start) + Fraction(width)))
        with flint.ctx.workprec(300):
            y = flint.arb(start) + flint.arb(width * random.random())
            for ours, true in zip(whole, (y.cos(), y.sin()), strict=True):
                assert ours.low <= true * unit() <= ours.high
                assert ours.width <= (1.3 * width + 1e-30) * unit()
