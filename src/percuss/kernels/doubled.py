"""Sums and products of doubles with their rounding errors kept (Dekker 1971, Knuth 1969).

An instant is a pair ``(t, t_low)`` whose exact sum is meant: at t = 2e6 one ulp of t alone is
4.7e-10, far more than the flights' own rounding. Rates in turns per time are pairs as well, so
that the phase of a harmonic comes out with 16 digits at any instant.
"""

from __future__ import annotations

from typing import TypeAlias

from percuss.kernels.compile import kernel

Pair: TypeAlias = tuple[float, float]

# Adding and subtracting 1.5 * 2**52 rounds a double below 2**51 to the nearest integer.
ROUNDER = 6755399441055744.0
# Splits a double into two halves of 26 bits (Veltkamp).
SPLITTER = 134217729.0


@kernel
def nearest(x: float) -> float:
    """Return the integer nearest to x, for abs(x) < 2**51."""
    return (x + ROUNDER) - ROUNDER


@kernel
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return a + b rounded, and the rounding error."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@kernel
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return a * b rounded, and the rounding error."""
    product = a * b
    split = SPLITTER * a
    a_high = split - (split - a)
    a_low = a - a_high
    split = SPLITTER * b
    b_high = split - (split - b)
    b_low = b - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


@kernel
def plus(a: Pair, b: Pair) -> Pair:
    """Return the sum of two pairs, to 2**-104 of the sizes of both."""
    total, error = two_sum(a[0], b[0])
    return two_sum(total, error + (a[1] + b[1]))


@kernel
def times(a: Pair, b: Pair) -> Pair:
    """Return the product of two pairs, to a relative 2**-102."""
    product, error = two_product(a[0], b[0])
    return two_sum(product, error + (a[0] * b[1] + a[1] * b[0]))


@kernel
def over(a: Pair, n: float) -> Pair:
    """Return a pair divided by a double, to a relative 2**-102."""
    quotient = a[0] / n
    product, error = two_product(quotient, n)
    return two_sum(quotient, (((a[0] - product) - error) + a[1]) / n)


@kernel
def later(t: float, t_low: float, s: float) -> tuple[float, float]:
    """Return the instant a time s after (t, t_low), as a pair."""
    total, error = two_sum(t, s)
    return two_sum(total, error + t_low)


@kernel
def turns(rate: float, rate_low: float, t: float, t_low: float) -> float:
    """Return (rate * t) mod 1 in [-1/2, 1/2], to a relative error of a few 1e-16.

    The whole turns are removed exactly before anything is rounded, so that a phase near a whole
    turn keeps its digits: the sine of it, near zero, does too.
    """
    product, error = two_product(rate, t)
    error += rate * t_low + rate_low * t
    part = (product - nearest(product)) + error
    return part - nearest(part)
