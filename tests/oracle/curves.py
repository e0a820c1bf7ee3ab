"""Curves that solve a linear equation, with the Taylor coefficients and bounds of any order.

A flight is a sum of exponentials Re(sum alpha exp(z s)). Where exponents coincide (critical
damping, no stiffness, resonance) they are moved apart by far less than the digits asked for,
and the working precision pays for the cancellation: one formula serves every regime.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import mpmath
from mpmath import mp

# A real number of mpmath, which has no types.
Real = Any


@dataclass(frozen=True)
class Harmonic:
    """The force cos cos(omega t) + sin sin(omega t)."""

    omega: Real
    cos: Real
    sin: Real

    @property
    def amplitude(self) -> Real:
        """Largest value of the force."""
        return mpmath.hypot(self.cos, self.sin)


class Curve(Protocol):
    """What `roots.first_root` needs to know."""

    def value(self, s: Real) -> Real:
        """Return the curve at s."""

    def taylor(self, s: Real, order: int) -> list[Real]:
        """Return the Taylor coefficients at s up to s^order."""

    def bound(self, coefficients: list[Real], n: int, h: Real) -> Real:
        """Return a bound of the n-th derivative on [s, s + h], n <= order - 1."""


@dataclass(frozen=True)
class Force:
    """A constant, harmonics and a slope from t0 on, as a function of s = t - t0."""

    constant: Real
    harmonics: tuple[Harmonic, ...]
    t0: Real
    slope: Real = 0

    def value(self, s: Real) -> Real:
        """Return the force at s."""
        return self.taylor(s, 0)[0]

    def taylor(self, s: Real, order: int) -> list[Real]:
        """Return the Taylor coefficients of the force at s."""
        found = [self.constant + self.slope * s] + [mp.zero] * order
        if order > 0:
            found[1] = mp.zero + self.slope
        for h in self.harmonics:
            c, d = mpmath.cos_sin(h.omega * (self.t0 + s))
            now, slope = h.cos * c + h.sin * d, h.sin * c - h.cos * d
            factor = mp.one
            for n in range(order + 1):
                found[n] += factor * now
                now, slope = slope, -now
                factor *= h.omega / (n + 1)
        return found

    def bound(self, coefficients: list[Real], n: int, h: Real) -> Real:  # noqa: ARG002
        """Return a bound of the n-th derivative, n >= 1; it holds everywhere."""
        waves = mpmath.fsum(part.amplitude * part.omega**n for part in self.harmonics)
        return waves + abs(self.slope) if n == 1 else waves


class Flight:
    """The solution of x'' + 2 a x' + k x = force from (x, v) at s = 0."""

    def __init__(self, a: Real, k: Real, force: Force, x: Real, v: Real, digits: int) -> None:
        self.a, self.k, self.force = a, k, force
        nudge = mpmath.mpf(10) ** (-digits - 10) * (1 + abs(a) + mpmath.sqrt(abs(k)))
        root = mpmath.sqrt(mpmath.mpc(a * a - k))
        if abs(root) < nudge:
            root = mpmath.mpc(nudge)
        up, down = -a + root, -a - root
        terms = []
        for z, strength in self._drives(7 * nudge):
            apart = min(abs(z - up), abs(z - down)) >= nudge
            place = z if apart else z + 3 * nudge
            terms.append((place, strength / ((place - up) * (place - down))))
        x = x - mpmath.fsum(alpha.real for _, alpha in terms)
        v = v - mpmath.fsum((alpha * z).real for z, alpha in terms)
        own = (v - down * x) / (up - down)
        if root.imag:
            # Of two conjugate terms one is computed, and counts twice.
            terms.append((up, 2 * own))
        else:
            terms += [(up, own), (down, (up * x - v) / (up - down))]
        self._terms = terms
        self._known: dict[tuple[Real, int], tuple[Real, Real]] = {}

    def _drives(self, apart: Real) -> list[tuple[Real, Real]]:
        drives = [(mpmath.mpc(0), mpmath.mpc(self.force.constant))]
        if self.force.slope:
            # s is sinh(z s) / z as z goes to 0.
            half = mpmath.mpc(self.force.slope) / (2 * apart)
            drives += [(mpmath.mpc(apart), half), (mpmath.mpc(-apart), -half)]
        for h in self.force.harmonics:
            turn = mpmath.expj(h.omega * self.force.t0)
            drives.append((mpmath.mpc(0, h.omega), mpmath.mpc(h.cos, -h.sin) * turn))
        return drives

    def state(self, s: Real) -> tuple[Real, Real]:
        """Return (x, v) at s; searches ask for it several times."""
        asked = s, mp.prec
        if asked not in self._known:
            parts = [(z, alpha * mpmath.exp(z * s)) for z, alpha in self._terms]
            x = mpmath.fsum(part.real for _, part in parts)
            self._known[asked] = x, mpmath.fsum((z * part).real for z, part in parts)
        return self._known[asked]

    def value(self, s: Real) -> Real:
        """Return x at s."""
        return self.state(s)[0]

    def taylor(self, s: Real, order: int) -> list[Real]:
        """Return the Taylor coefficients of x at s, by the equation of motion."""
        return taylor_of_state(self.a, self.k, self.force, s, *self.state(s), order)

    def bound(self, coefficients: list[Real], n: int, h: Real) -> Real:
        """Return a bound of the n-th derivative of x on [s, s + h].

        With y = (rho x, v) and the right rho, the norm of y grows by no more than the force
        and by exp(|rho - k/rho| h / 2); derivatives of x obey the same equation.
        """
        rho = mpmath.sqrt(abs(self.k)) if self.k else mp.one
        rate = abs(rho - self.k / rho) / 2
        now = coefficients[n] * mpmath.factorial(n)
        slope = coefficients[n + 1] * mpmath.factorial(n + 1)
        start = mpmath.hypot(rho * now, slope)
        return (start + self.force.bound([], n, h) * h) * mpmath.exp(rate * h) / rho


def taylor_of_state(
    a: Real, k: Real, force: Force, s: Real, x: Real, v: Real, order: int
) -> list[Real]:
    """Return the Taylor coefficients of the flight that is at (x, v) at s."""
    if order < 2:
        return [x, v][: order + 1]
    drive = force.taylor(s, order)
    found = [x, v]
    for n in range(order - 1):
        pull = 2 * a * (n + 1) * found[n + 1] + k * found[n]
        found.append((drive[n] - pull) / ((n + 1) * (n + 2)))
    return found[: order + 1]
