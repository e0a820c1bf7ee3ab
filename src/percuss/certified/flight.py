"""The motion between two events in closed form, as balls: values, derivatives, bounds.

With y the distance from what the forcing does alone, x(s) = y(s) + waves(s), where y obeys the
unforced equation and each harmonic makes one wave; exactly at resonance the wave grows with s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from flint import arb

from percuss.certified.law import BallLaw, LinearRegion, Number, constant_of
from percuss.certified.numbers import power, upper

__all__ = ["BallPropagator", "EnclosedFlight", "Push", "SmoothFunction", "Wave", "propagator"]

# More than the rounding of the few dozen float operations of a bound.
SLACK = 1.0 + 1e-12
# No stretch is longer, so that floats hold its powers; those of unstable motions have useless
# bounds beyond a part of their own time.
LONGEST, MOST_GROWTH = 1e38, 0.5


class Wave(NamedTuple):
    """A wave p cos(omega s) + q sin(omega s), times s where it is secular."""

    omega: Number
    p: Number
    q: Number
    size: float
    pace: float
    secular: bool


class BallPropagator(NamedTuple):
    """Derivative of (y, y') after a time by (y, y') before; a21 = -stiffness a12."""

    a11: Number
    a12: Number
    a21: Number
    a22: Number


class SmoothFunction(Protocol):
    """What the search for the first root needs of a curve."""

    longest: float

    def derivatives(self, s: arb, n: int) -> tuple[list[Number], float]:
        """Return the derivatives of order 0 to n at s, and the size that `bound` needs."""

    def bound(self, n: int, s: float, h: float, size: float) -> float:
        """Return a bound of the n-th derivative on [s, s + h], n >= 3."""

    def taylor(self, n: int) -> list[Number]:
        """Return the Taylor coefficients at 0 up to s^n."""

    def size_at_start(self, n: int) -> float:
        """Return the size that `bound` needs for the derivative of order n + 1 from 0 on."""


def propagator(region: LinearRegion, s: Number) -> BallPropagator:
    """Return the derivative of the motion after a time s by the motion before."""
    regime, k = region.regime, region.stiffness
    if regime == "oscillating":
        sine, c = (region.rate * s).sin_cos()
        d = sine / region.rate
    elif regime == "overdamped":
        angle = region.rate * s
        if isinstance(angle, arb):
            sine, c = angle.sinh_cosh()
        else:
            up = angle.exp()
            c, sine = (up + 1 / up) / 2, (up - 1 / up) / 2
        d = sine / region.rate
    else:
        c, d = arb(1), s
    if not region.dashpot:
        return BallPropagator(c, d, -(k * d), c)
    decay = (-(region.damping * s)).exp()
    ad = region.damping * d
    a12 = decay * d
    return BallPropagator(decay * (c + ad), a12, -(k * a12), decay * (c - ad))


def _waves_at(waves: Sequence[Wave], s: arb, out: list[Number]) -> None:
    """Add the derivatives of waves at s, of order 0 to len(out) - 1."""
    for omega, p, q, _, _, secular in waves:
        sine, cosine = (omega * s).sin_cos()
        u, z = p * cosine + q * sine, q * cosine - p * sine
        # Derivatives of u: u, omega z, -omega^2 u, -omega^3 z, ...
        turned = [u]
        factor = omega
        for order in range(1, len(out)):
            turned.append(factor * z if order % 2 else factor * u)
            factor = factor * omega
            if order % 4 >= 2:
                turned[-1] = -turned[-1]
        for order, value in enumerate(turned):
            if not secular:
                out[order] = out[order] + value
            else:
                out[order] = out[order] + s * value
                if order > 0:
                    out[order] = out[order] + order * turned[order - 1]


def _waves_bound(waves: Sequence[Wave], n: int, end: float) -> float:
    total = 0.0
    for _, _, _, size, pace, secular in waves:
        here = size * power(pace, n)
        if secular:
            here = here * end + n * size * power(pace, n - 1)
        total += here
    return total


class EnclosedFlight:
    """The motion from (x0, v0) under the forcing whose phases are given.

    Parameters
    ----------
    law, region
        The equation: number of the region.
    turns
        Cosine and sine of omega t0 for each harmonic.
    x0, v0
        The start; balls stand for all starts in them.
    order
        Order of the first derivative of x at the start that is not zero; those below are so
        exactly.
    """

    def __init__(
        self,
        law: BallLaw,
        region: int,
        turns: Sequence[tuple[arb, arb]],
        x0: Number,
        v0: Number,
        order: int = 1,
    ) -> None:
        self.region = law.regions[region]
        self.x0, self.v0, self.order = x0, v0, order
        self.drive: list[tuple[Number, Number, Number]] = []
        self.waves: list[Wave] = []
        self.strengths = list(zip(law.strength, law.paces, strict=True))
        here = self.region
        y, z = x0, v0
        force = here.constant
        for i, (cosine, sine) in enumerate(turns):
            omega, c, d = law.tones[i]
            at, slope = c * cosine + d * sine, d * cosine - c * sine
            force = force + at
            self.drive.append((omega, at, slope))
            gain = here.gains[i]
            secular = gain is None
            if gain is None:
                p, q = -slope / (2 * omega), at / (2 * omega)
                z = z - p
            else:
                p, q = at * gain[0] + slope * gain[1], slope * gain[0] - at * gain[1]
                y, z = y - p, z - omega * q
            size = SLACK * math.hypot(upper(constant_of(p)), upper(constant_of(q)))
            self.waves.append(Wave(omega, p, q, size, law.paces[i], secular))
        self.origin: Number = arb(0)
        self.slope: Number = arb(0)
        if here.spring:
            self.origin = here.constant / here.stiffness
            y = y - self.origin
        elif here.dashpot:
            self.slope = here.constant / (2 * here.damping)
            z = z - self.slope
        self.y0, self.z0 = y, z
        self.force0 = force
        # Not zero even where the order says so: the set holds starts beside that of the motion.
        self.a0 = self.acceleration(x0, v0, force)
        fastest = max(here.growth, 1e-5 * here.pace)
        self.longest = min(LONGEST, MOST_GROWTH / fastest) if fastest else LONGEST

    def acceleration(self, x: Number, v: Number, force: Number) -> Number:
        """Return the acceleration in a state under a force."""
        pulled = force - self.region.stiffness * x
        return pulled - 2 * self.region.damping * v if self.region.dashpot else pulled

    def derivatives(self, s: arb, n: int) -> tuple[list[Number], float]:
        """Return the derivatives of order 0 to n >= 1 at s, and the size that `bound` needs."""
        region = self.region
        by = propagator(region, s)
        own = [by.a11 * self.y0 + by.a12 * self.z0, by.a21 * self.y0 + by.a22 * self.z0]
        drag = 2 * region.damping if region.dashpot else None
        for _ in range(n):
            following = -(region.stiffness * own[-2])
            own.append(following if drag is None else following - drag * own[-1])
        out = own if region.near else own[: n + 1]
        size = self._size(own, n)
        if region.spring:
            out[0] = out[0] + self.origin
        elif region.dashpot:
            out[0] = out[0] + self.slope * s
            out[1] = out[1] + self.slope
        else:
            push = region.constant
            out[0] = out[0] + push * s * s / 2
            out[1] = out[1] + push * s
            if n >= 2:
                out[2] = out[2] + push
        _waves_at(self.waves, s, out)
        if region.near:
            return out[: n + 1], self._size(out, n)
        return out, size

    def _size(self, derivatives: list[Number], n: int) -> float:
        """Return the norm of the n-th derivative and the next."""
        here, following = (upper(constant_of(derivatives[k])) for k in (n, n + 1))
        return math.hypot(self.region.pace * here, following)

    def bound(self, n: int, s: float, h: float, size: float) -> float:
        """Return a bound of the n-th derivative on [s, s + h], from `derivatives` (s, n - 1).

        The norm (pace^2 y^2 + y'^2)^(1/2) of every derivative of y grows by no more than
        exp(growth h): not at all for K >= 0, whatever the damping. That of x grows by the force
        besides; it is taken where y and the waves nearly cancel.
        """
        if self.region.near:
            force = sum(size * power(pace, n - 1) for size, pace in self.strengths)
            rate = self.region.growth + 1e-5 * self.region.pace
            return SLACK * (size + h * force) * math.exp(rate * h)
        grown = size if self.region.growth == 0.0 else size * math.exp(self.region.growth * h)
        # The pace is above sqrt(K) by 1e-6, and so the norm may grow by that.
        own = grown * math.exp(1e-5 * self.region.pace * h)
        return SLACK * (own + _waves_bound(self.waves, n, s + h))

    def taylor(self, n: int) -> list[Number]:
        """Return the Taylor coefficients at the start, by the equation."""
        region = self.region
        found: list[Number] = [self.x0, self.v0]
        force = _taylor_of_force(self.force0, self.drive, max(0, n - 2))
        for k in range(n - 1):
            if k + 2 < self.order:
                found.append(arb(0))
                continue
            pull = region.stiffness * found[k]
            if region.dashpot:
                pull = pull + 2 * (k + 1) * region.damping * found[k + 1]
            found.append((force[k] - pull) / ((k + 1) * (k + 2)))
        return found

    def size_at_start(self, n: int) -> float:
        """Return the size that `bound` needs for the derivative of order n + 1 from 0 on."""
        if self.region.near:
            found = self.taylor(n + 1)
            return self._size([math.factorial(k) * c for k, c in enumerate(found)], n)
        own = [self.y0, self.z0]
        for _ in range(n):
            own.append(-(self.region.stiffness * own[-2]) - 2 * self.region.damping * own[-1])
        return self._size(own, n)

    def series_bound(self, n: int, h: float) -> arb:
        """Return a bound of the n-th derivative on [0, h], of any size: no float holds it for all n.

        As `bound`, from the start.
        """
        region = self.region
        if region.near:
            found = [arb(k).fac() * constant_of(c) for k, c in enumerate(self.taylor(n))]
            forces = (arb(size) * arb(pace) ** (n - 1) for size, pace in self.strengths)
            more = sum(forces, arb(0)) * h
        else:
            own = [self.y0, self.z0]
            for _ in range(n - 1):
                own.append(-(region.stiffness * own[-2]) - 2 * region.damping * own[-1])
            found = [constant_of(value) for value in own]
            more = arb(0)
        here, following = found[n - 1].abs_upper(), found[n].abs_upper()
        size = ((region.pace * here) ** 2 + following**2).sqrt() + more
        total = size * arb((region.growth + 1e-5 * region.pace) * h * SLACK).exp()
        if not region.near:
            for _, _, _, wide, pace, secular in self.waves:
                wave = arb(wide) * arb(pace) ** n
                total += wave * h + n * arb(wide) * arb(pace) ** (n - 1) if secular else wave
        return SLACK * total.abs_upper()

    def reach(self) -> tuple[float, float] | None:
        """Return bounds of x for ever, None where there are none."""
        if not self.region.spring or self.region.growth > 0.0:
            return None
        if any(wave.secular for wave in self.waves):
            return None
        pace = self.region.pace
        size = math.hypot(upper(constant_of(self.y0)), upper(constant_of(self.z0)) / pace * 1.00001)
        away = 1.00001 * (size + sum(wave.size for wave in self.waves))
        middle = float(constant_of(self.origin))
        away += 1e-9 * abs(middle) + upper(constant_of(self.origin).rad())
        return middle - away, middle + away


class Push:
    """The force that holds a mass at a place, as a curve of time."""

    longest = LONGEST

    def __init__(
        self, law: BallLaw, region: int, turns: Sequence[tuple[arb, arb]], x: Number, order: int
    ) -> None:
        here = law.regions[region]
        self.rest = here.constant - here.stiffness * x
        self.order = order
        self.drive: list[tuple[Number, Number, Number]] = []
        self.waves: list[Wave] = []
        for i, (cosine, sine) in enumerate(turns):
            omega, c, d = law.tones[i]
            at, slope = c * cosine + d * sine, d * cosine - c * sine
            self.drive.append((omega, at, slope))
            size = SLACK * math.hypot(upper(constant_of(at)), upper(constant_of(slope)))
            self.waves.append(Wave(omega, at, slope, size, law.paces[i], secular=False))

    def derivatives(self, s: arb, n: int) -> tuple[list[Number], float]:
        """Return the derivatives of order 0 to n at s, and the size that `bound` needs."""
        out: list[Number] = [self.rest, *(arb(0) for _ in range(n))]
        _waves_at(self.waves, s, out)
        return out, 0.0

    def bound(self, n: int, s: float, h: float, size: float) -> float:  # noqa: ARG002
        """Return a bound of the n-th derivative on [s, s + h]."""
        return SLACK * _waves_bound(self.waves, n, s + h)

    def taylor(self, n: int) -> list[Number]:
        """Return the Taylor coefficients at 0; those below the order are zero exactly."""
        total = self.rest
        for _, at, _ in self.drive:
            total = total + at
        found = _taylor_of_force(total, self.drive, n)
        return [arb(0) if k < self.order else value for k, value in enumerate(found)]

    def size_at_start(self, n: int) -> float:  # noqa: ARG002
        """Return what `bound` needs: nothing."""
        return 0.0


def _taylor_of_force(
    total: Number, drive: Sequence[tuple[Number, Number, Number]], n: int
) -> list[Number]:
    """Return the Taylor coefficients up to s^n of a force that is ``total`` at 0."""
    found: list[Number] = [total, *(arb(0) for _ in range(n))]
    for omega, at, slope in drive:
        now, following = slope, -at
        factor: Number = omega
        for k in range(1, n + 1):
            found[k] = found[k] + factor * now
            now, following = following, -now
            factor = factor * omega / (k + 1)
    return found
