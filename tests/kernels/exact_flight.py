"""The responses of an oscillator at rest, in closed form and at as many digits as asked for."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
from mpmath import mp

import percuss as pc
from percuss.kernels.law_columns import FIRST_HARMONIC, Law
from percuss.model.exact import as_fraction
from percuss.model.system import law as law_of

# mpmath has no types.
Real = Any

# Twice the digits of the largest cancellation in these tests (detunings of 1e-16, K of 1e-30).
DIGITS = 120


def number(value: object) -> Real:
    """Return an exact value at the working precision."""
    fraction = as_fraction(value)  # type: ignore[arg-type]
    return mpmath.mpf(fraction.numerator) / fraction.denominator


@dataclass(frozen=True)
class Rest:
    """x'' + 2 a x' + K x = force, with the table the kernels read for it."""

    stiffness: float | Fraction
    damping: float | Fraction
    omega: float | Fraction = 1.0

    @property
    def law(self) -> Law:
        """The kernels' table, of one region and one harmonic cos(omega t)."""
        return law_of(pc.Oscillator(self.stiffness, self.damping), pc.cosine(self.omega))

    @property
    def region(self) -> int:
        """The row of the one region."""
        return FIRST_HARMONIC + 1

    @property
    def rate(self) -> Real:
        """sqrt(abs(K - a^2)): a frequency, or half the difference of two real roots."""
        return mpmath.sqrt(abs(number(self.stiffness) - number(self.damping) ** 2))

    @property
    def slowest(self) -> Real:
        """The rate of the slowest decay, or of the growth."""
        a = number(self.damping)
        if number(self.stiffness) >= a * a:
            return a
        return abs(number(self.stiffness)) / (a + self.rate)

    def free(self, s: float) -> tuple[Real, Real, Real]:
        """Return S, c and D at s."""
        K, a, s = number(self.stiffness), number(self.damping), mpmath.mpf(s)
        root = mpmath.sqrt(mpmath.mpc(a * a - K))
        shrink = mpmath.exp(-a * s)
        S = shrink * (mpmath.sinh(root * s) / root if root != 0 else s)
        c = shrink * mpmath.cosh(root * s)
        if K != 0:
            D = (1 - c - a * S) / K
        elif a != 0:
            D = (s - S) / (2 * a)
        else:
            D = s * s / 2
        return mp.re(S), mp.re(c), mp.re(D)

    def harmonic(self, s: float) -> Real:
        """Return Q at s: the complex response to exp(i w t)."""
        K, a, w = number(self.stiffness), number(self.damping), number(self.omega)
        S, c, _ = self.free(s)
        turn = mpmath.expj(w * mpmath.mpf(s))
        stiffness = K - w * w + 2j * a * w
        if stiffness == 0:
            return (s * turn - S) / (2j * w)
        return (turn - c - a * S - 1j * w * S) / stiffness
