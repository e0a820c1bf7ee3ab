"""The motion between two events in closed form, as balls: values, derivatives, bounds.

x(s) = y(s) + waves(s) + polynomial(s): y obeys the unforced equation, each harmonic makes one wave,
which grows with s exactly at resonance, and the constant and a record's ramp make the polynomial.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from flint import arb

from percuss.certified.ball_law import BallLaw, LinearRegion
from percuss.certified.cloud import BallPair
from percuss.certified.numbers import Number, constant_of, largest_abs, power
from percuss.certified.pieces import Ramp

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
    """A function of time as the search for its first root needs it."""

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
        bound = size * power(pace, n)
        if secular:
            bound = bound * end + n * size * power(pace, n - 1)
        total += bound
    return total


class EnclosedFlight:
    """The motion from (x0, v0) under the forcing whose phases are given.

    Parameters
    ----------
    law, region
        The equation: number of the region.
    phasors
        Cosine and sine of omega t0 for each harmonic.
    x0, v0
        The start; balls stand for all starts in them.
    order
        Order of the first derivative of x at the start that is not zero; those below are so
        exactly.
    ramp
        Force and slope of a record at the start, whose piece lasts as long as the flight.
    """

    def __init__(
        self,
        law: BallLaw,
        region: int,
        phasors: Sequence[BallPair],
        x0: Number,
        v0: Number,
        order: int = 1,
        ramp: Ramp | None = None,
    ) -> None:
        self.region = law.regions[region]
        self.x0, self.v0, self.order = x0, v0, order
        self.drive = law.drive(phasors)
        self.waves: list[Wave] = []
        self.strengths = list(zip(law.strength, law.paces, strict=True))
        y, z = x0, v0
        constant, self.ramp = self.region.constant, None if ramp is None else ramp.slope
        if ramp is not None:
            constant = constant + ramp.force
        force = constant
        for (omega, at, slope), gain, pace in zip(
            self.drive, self.region.gains, law.paces, strict=True
        ):
            force = force + at
            if gain is None:
                p, q = -slope / (2 * omega), at / (2 * omega)
                z = z - p
            else:
                p, q = at * gain[0] + slope * gain[1], slope * gain[0] - at * gain[1]
                y, z = y - p, z - omega * q
            self.waves.append(Wave(omega, p, q, _amplitude(p, q), pace, gain is None))
        self.polynomial = _polynomial(self.region, constant, self.ramp)
        self.origin = self.polynomial.get(0, arb(0))
        y = y - self.origin
        if 1 in self.polynomial:
            z = z - self.polynomial[1]
        self.y0, self.z0 = y, z
        self.force0 = force
        # Not zero even where the order says so: the set holds other starts than the motion's.
        self.a0 = self.acceleration(x0, v0, force)
        fastest = max(self.region.growth, 1e-5 * self.region.pace)
        self.longest = min(LONGEST, MOST_GROWTH / fastest) if fastest else LONGEST

    def acceleration(self, x: Number, v: Number, force: Number) -> Number:
        """Return the acceleration in a state under a force."""
        pulled = force - self.region.stiffness * x
        return pulled - 2 * self.region.damping * v if self.region.dashpot else pulled

    def derivatives(self, s: arb, n: int) -> tuple[list[Number], float]:
        """Return the derivatives of order 0 to n >= 1 at s, and the size that `bound` needs."""
        region = self.region
        by = propagator(region, s)
        y, z = by.a11 * self.y0 + by.a12 * self.z0, by.a21 * self.y0 + by.a22 * self.z0
        free = self._free(y, z, n + 1)
        out = free if region.cancels else free[: n + 1]
        size = self._size(free, n)
        for power_, value in self.polynomial.items():
            term = value
            for order in range(power_, -1, -1):
                if order < len(out):
                    out[order] = out[order] + term
                term = term * s / (power_ - order + 1)
        _waves_at(self.waves, s, out)
        if region.cancels:
            return out[: n + 1], self._size(out, n)
        return out, size

    def _free(self, y: Number, z: Number, n: int) -> list[Number]:
        """Return the derivatives of the unforced motion up to order n from those of order 0 and 1."""
        free = [y, z]
        drag = 2 * self.region.damping if self.region.dashpot else None
        while len(free) <= n:
            pull = -(self.region.stiffness * free[-2])
            free.append(pull if drag is None else pull - drag * free[-1])
        return free

    def _size(self, derivatives: list[Number], n: int) -> float:
        """Return the norm of the n-th derivative and the next."""
        low, high = (largest_abs(constant_of(derivatives[k])) for k in (n, n + 1))
        return math.hypot(self.region.pace * low, high)

    def bound(self, n: int, s: float, h: float, size: float) -> float:
        """Return a bound of the n-th derivative, n >= 4, on [s, s + h], from `derivatives` (s, n - 1).

        The norm (pace^2 y^2 + y'^2)^(1/2) of every derivative of y grows by no more than
        exp(growth h): not at all for K >= 0, whatever the damping. The polynomial has no such
        derivative. Where y and the waves nearly
        cancel, the norm of x is taken, which the force makes grow too.
        """
        if self.region.cancels:
            force = sum(size * power(pace, n - 1) for size, pace in self.strengths)
            rate = self.region.growth + 1e-5 * self.region.pace
            return SLACK * (size + h * force) * math.exp(rate * h)
        grown = size if self.region.growth == 0.0 else size * math.exp(self.region.growth * h)
        # The pace is above sqrt(K) by 1e-6, and so the norm may grow by that.
        free = grown * math.exp(1e-5 * self.region.pace * h)
        return SLACK * (free + _waves_bound(self.waves, n, s + h))

    def taylor(self, n: int) -> list[Number]:
        """Return the Taylor coefficients at the start, by the equation."""
        region = self.region
        series: list[Number] = [self.x0, self.v0]
        force = _taylor_of_force(self.force0, self.ramp, self.drive, max(0, n - 2))
        for k in range(n - 1):
            if k + 2 < self.order:
                series.append(arb(0))
                continue
            pull = region.stiffness * series[k]
            if region.dashpot:
                pull = pull + 2 * (k + 1) * region.damping * series[k + 1]
            series.append((force[k] - pull) / ((k + 1) * (k + 2)))
        return series

    def size_at_start(self, n: int) -> float:
        """Return the size that `bound` needs for the derivative of order n + 1 from 0 on."""
        if self.region.cancels:
            series = self.taylor(n + 1)
            return self._size([math.factorial(k) * c for k, c in enumerate(series)], n)
        return self._size(self._free(self.y0, self.z0, n + 1), n)

    def series_bound(self, n: int, h: float) -> arb:
        """Return the bound of the n-th derivative on [0, h] as a ball: floats end before it does."""
        region, forced = self.region, arb(0)
        if region.cancels:
            derivatives = [arb(k).fac() * c for k, c in enumerate(self.taylor(n))]
            forces = (arb(size) * arb(pace) ** (n - 1) for size, pace in self.strengths)
            forced = sum(forces, arb(0)) * h
        else:
            derivatives = self._free(self.y0, self.z0, n)
        low, high = (constant_of(value).abs_upper() for value in derivatives[n - 1 : n + 1])
        size = ((region.pace * low) ** 2 + high**2).sqrt() + forced
        total = size * arb((region.growth + 1e-5 * region.pace) * h * SLACK).exp()
        if not region.cancels:
            for wave in self.waves:
                power_ = arb(wave.size) * arb(wave.pace) ** n
                slower = n * arb(wave.size) * arb(wave.pace) ** (n - 1)
                total += power_ * h + slower if wave.secular else power_
        return SLACK * total.abs_upper()

    def reach(self) -> tuple[float, float] | None:
        """Return the bounds between which x stays for ever, None where it has none."""
        if not self.region.spring or self.region.growth > 0.0 or self.ramp is not None:
            return None
        if any(wave.secular for wave in self.waves):
            return None
        pace = self.region.pace
        size = math.hypot(
            largest_abs(constant_of(self.y0)), largest_abs(constant_of(self.z0)) / pace * 1.00001
        )
        size = 1.00001 * (size + sum(wave.size for wave in self.waves))
        middle = float(constant_of(self.origin))
        size += 1e-9 * abs(middle) + largest_abs(constant_of(self.origin).rad())
        return middle - size, middle + size


class Push:
    """The force on a mass that is held at a place, as a function of time."""

    longest = LONGEST

    def __init__(
        self,
        law: BallLaw,
        region: int,
        phasors: Sequence[BallPair],
        x: Number,
        order: int,
        ramp: Ramp | None = None,
    ) -> None:
        self.rest = law.regions[region].constant - law.regions[region].stiffness * x
        self.slope = None if ramp is None else ramp.slope
        if ramp is not None:
            self.rest = self.rest + ramp.force
        self.order = order
        self.drive = law.drive(phasors)
        self.waves = [
            Wave(omega, at, slope, _amplitude(at, slope), pace, secular=False)
            for (omega, at, slope), pace in zip(self.drive, law.paces, strict=True)
        ]

    def derivatives(self, s: arb, n: int) -> tuple[list[Number], float]:
        """Return the derivatives of order 0 to n at s, and the size that `bound` needs."""
        out: list[Number] = [self.rest, *(arb(0) for _ in range(n))]
        if self.slope is not None:
            out[0] = out[0] + self.slope * s
            if n > 0:
                out[1] = out[1] + self.slope
        _waves_at(self.waves, s, out)
        return out, 0.0

    def bound(self, n: int, s: float, h: float, size: float) -> float:  # noqa: ARG002
        """Return a bound of the n-th derivative on [s, s + h], n >= 2."""
        return SLACK * _waves_bound(self.waves, n, s + h)

    def taylor(self, n: int) -> list[Number]:
        """Return the Taylor coefficients at 0; those below the order are zero exactly."""
        total = self.rest
        for _, at, _ in self.drive:
            total = total + at
        series = _taylor_of_force(total, self.slope, self.drive, n)
        return [arb(0) if k < self.order else value for k, value in enumerate(series)]

    def size_at_start(self, n: int) -> float:  # noqa: ARG002
        """Return the size that `bound` needs, which is none."""
        return 0.0


def _amplitude(p: Number, q: Number) -> float:
    """Return a float not below the amplitude of a wave."""
    return SLACK * math.hypot(largest_abs(constant_of(p)), largest_abs(constant_of(q)))


def _polynomial(region: LinearRegion, constant: Number, ramp: Number | None) -> dict[int, Number]:
    """Return the derivatives at 0, by their order, of a polynomial motion under constant + ramp s."""
    if region.spring:
        origin = constant / region.stiffness
        if ramp is None:
            return {0: origin}
        slope = ramp / region.stiffness
        if region.dashpot:
            origin = (constant - 2 * region.damping * slope) / region.stiffness
        return {0: origin, 1: slope}
    if region.dashpot:
        drag = 2 * region.damping
        if ramp is None:
            return {1: constant / drag}
        return {1: (constant - ramp / drag) / drag, 2: ramp / drag}
    return {2: constant} if ramp is None else {2: constant, 3: ramp}


def _taylor_of_force(
    total: Number, ramp: Number | None, drive: Sequence[tuple[Number, Number, Number]], n: int
) -> list[Number]:
    """Return the Taylor coefficients up to s^n of a force that is ``total`` at 0."""
    series: list[Number] = [total, *(arb(0) for _ in range(n))]
    if ramp is not None and n > 0:
        series[1] = series[1] + ramp
    for omega, at, slope in drive:
        even, odd = slope, -at
        factor: Number = omega
        for k in range(1, n + 1):
            series[k] = series[k] + factor * even
            even, odd = odd, -even
            factor = factor * omega / (k + 1)
    return series
