"""Check a certificate of percuss, of an oscillator with stops.

Of a run, an orbit, a branch or a special point of one, a complete list, basins or chaos:

    python check_certificate.py certificate.json

The file says what is claimed; this program proves it anew or refuses it. It uses Python's integers and
fractions alone: no percuss, no library, no floating point. It prints the theorem and ends with status
0, or says in a sentence what is not proven and ends with status 1.

Between two stops the displacement obeys x'' + 2 a x' + K x = c + sum of A cos(w t + p), with rational
K, a, c, A, w: of unit mass. An interval is a pair of integers, numbers of units of 2^-bits; each
operation rounds outward. What is proven, and why it suffices, is section 11 of docs/theory/certified.md.

In order: arithmetic, flights and their first event, the reading of what could be misread, and the kinds
of certificates. Of these runs, lists, basins and chaos do not need one another; orbits and branches have
the same equations, and lists and basins have orbits.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from fractions import Fraction
from itertools import groupby, islice, pairwise
from math import ceil, floor, gcd, isqrt
from pathlib import Path
from typing import Any, NamedTuple

VERSION = 1
# Bits of all intervals, which `bits` changes; bits that suffice to tell which event comes next.
BITS = COARSE = 128
# Bits with which a run is tried.
RUN_BITS = (256, 512, 1024, 2048, 4096, 8192)
# A step in which nothing is met is not made shorter than this: a graze, or an interval too wide.
SHORTEST = Fraction(1, 2**40)
# The longest step, the longest flight, and parts into which a set of a chaos proof is divided.
LONGEST, FLIGHT, PARTS = Fraction(1, 2), 1000, 3000
# The shortest step of a set of states, as a part of its width.
FINE = Fraction(1, 256)
# Parts are made smaller until a derivative is known on each to within this part of its largest entry:
# the first of these that suffices.
NARROW = tuple(Fraction(1, n) for n in (12, 100, 400, 1600))
# Boxes of a complete list are not made smaller than this part of the region, and steps of flights in
# which some of them may have an impact not shorter than this.
SMALLEST_BOX, FINEST_STEP = Fraction(1, 2**24), Fraction(1, 64)
# Bits with which sets of motions of a basin are followed, the smallest part of a rectangle that is tried,
# and events after which they have come to their orbit.
SET_BITS, SMALLEST_PART, MOST_EVENTS = 64, Fraction(1, 2**10), 60
# Each half of a strip of a branch is divided into so many parts along its coordinate.
PARTS_OF_STRIP = (1, 3, 9, 27)
# A certificate has no numbers of more digits, whole numbers above that, lists of more impacts or periods.
DIGITS, COUNT, MOST_RETURNS = 2000, 10**9, 100
# States of flights that a proof may compute, those of many bits counted several times: some hours.
MOST_STATES = 10**8
# Arguments y of cos y, cosh y and e^y are no larger than the root of this.
LARGEST_ARGUMENT = 1 << 24
# How long before a touch x'' is to point off the wall: the first of these that suffices.
LIFTS = tuple(Fraction(1, n) for n in (4, 16, 64, 256, 1024))


class NotProvenError(Exception):
    """What is claimed is not proven."""


class TooLongError(Exception):
    """A proof takes more than is tried, which smaller parts would not change."""


class Work:
    """States of flights that have been computed."""

    states = 0

    @classmethod
    def goes_on(cls) -> None:
        cls.states += max(1, BITS // COARSE)
        if cls.states > MOST_STATES:
            raise TooLongError


class ContradictedError(NotProvenError):
    """What is claimed is wrong, which more bits would not change."""


@contextmanager
def bits(n: int) -> Iterator[None]:
    """Work with intervals of so many bits; those of other bits have no meaning meanwhile."""
    global BITS  # noqa: PLW0603
    before, BITS = BITS, n
    try:
        yield
    finally:
        BITS = before


class Interval(NamedTuple):
    """All real numbers from low to high, in units of 2^-BITS."""

    low: int
    high: int

    def __add__(self, other: Any) -> Any:
        if type(other) is not Interval:
            if isinstance(other, Dual):
                return NotImplemented
            other = of(other)
        return Interval(self[0] + other[0], self[1] + other[1])

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if type(other) is not Interval:
            if isinstance(other, Dual):
                return NotImplemented
            other = of(other)
        (p, q), (r, s) = self, other
        ends = p * r, p * s, q * r, q * s
        return Interval(min(ends) >> BITS, -(-max(ends) >> BITS))

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return NotImplemented
        low, high = divisor = of(other)
        if low <= 0 <= high:
            raise NotProvenError("a divisor may be zero")
        low = min((p << BITS) // q for p in self for q in divisor)
        return Interval(low, max(-((-p << BITS) // q) for p in self for q in divisor))

    def __rtruediv__(self, other: Any) -> Any:
        return of(other) / self

    @property
    def size(self) -> int:
        """The largest absolute value."""
        return max(-self.low, self.high)

    @property
    def least(self) -> int:
        """The smallest absolute value."""
        return max(self.low, -self.high, 0)

    @property
    def width(self) -> int:
        return self.high - self.low

    def middle(self) -> Interval:
        return Interval((self.low + self.high) // 2, (self.low + self.high) // 2)

    def fractions(self) -> tuple[Fraction, Fraction]:
        return Fraction(self.low, 1 << BITS), Fraction(self.high, 1 << BITS)

    def wider(self) -> Interval:
        return Interval(self.low - self.width // 8 - 1, self.high + self.width // 8 + 1)

    def holds(self, other: Interval) -> bool:
        return self.low <= other.low and other.high <= self.high


def of(low: Any, high: Fraction | int | None = None) -> Any:
    """Return the interval of a rational number, or of all between two; an interval as it is."""
    if isinstance(low, Interval | Dual):
        return low
    n, d = low.as_integer_ratio()
    p, q = (n, d) if high is None else high.as_integer_ratio()
    return Interval((n << BITS) // d, -((-p << BITS) // q))


class Dual(NamedTuple):
    """Values of a function of the parameter of a branch, and of its derivative by it."""

    value: Interval
    slope: Interval

    def __add__(self, other: Any) -> Any:
        value, slope = dual(other)
        return Dual(self.value + value, self.slope + slope)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.slope)

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        value, slope = dual(other)
        return Dual(self.value * value, self.slope * value + self.value * slope)

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __truediv__(self, other: Any) -> Any:
        value, slope = dual(other)
        quotient = self.value / value
        return Dual(quotient, (self.slope - quotient * slope) / value)

    def __rtruediv__(self, other: Any) -> Any:
        return dual(other) / self


def dual(number: Any) -> Dual:
    return number if isinstance(number, Dual) else Dual(of(number), of(0))


def cosine_series(z: Any) -> Any:
    """Return the two series of `_cosine_series`, with derivatives if z has one."""
    if not isinstance(z, Dual):
        return _cosine_series(z)
    c, s = _cosine_series(z.value)
    # C' = S/2, S' = (C - S)/2z = 1/6 + z/60 + ..., whose rest is below z^2/1600 for |z| <= 2.
    if z.value.least >= 1 << BITS:
        slope = (c - s) / (2 * z.value)
    elif z.value.size <= 2 << BITS:
        rest = z.value.size**2 // (1600 << BITS) + 1
        slope = Fraction(1, 6) + Fraction(1, 60) * z.value + Interval(-rest, rest)
    else:
        raise NotProvenError("an interval is too wide for a series")
    return Dual(c, Fraction(1, 2) * s * z.slope), Dual(s, slope * z.slope)


def _cosine_series(z: Interval) -> tuple[Interval, Interval]:
    """Return C(z) = sum of z^k/(2k)! and S(z) = sum of z^k/(2k+1)!.

    C(-y^2) = cos y, S(-y^2) = sin(y)/y, and cosh and sinh for positive z. At the middle m of z the
    sums end with a term of one unit at most, behind which each is less than a quarter of the one
    before. C' = S/2 and |S'| <= max(1, S)/6 carry them to all of z.
    """
    m, radius = (z.low + z.high) // 2, (z.width + 2) // 2
    if z.size > LARGEST_ARGUMENT << BITS:
        raise NotProvenError("an argument is too large for a series")
    sums = [1 << BITS, 1 << BITS]
    term, k = 1 << BITS, 0
    while True:
        k += 1
        even = term * m // ((1 << BITS) * (2 * k - 1) * (2 * k))
        sums[0] += even
        sums[1] += even // (2 * k + 1)
        if abs(even) <= 1 and abs(m) < (1 << BITS) * k * k:
            break
        term = even
    # Each of k terms is rounded by less than a unit, and passes that on to those behind it by factors
    # that sum to less than cosh(sqrt|m|); the rest is less than a third of the last term.
    error = (4 * k + 4) * int(3 ** (isqrt(abs(m) >> BITS) + 1))
    slope = max(1 << BITS, abs(sums[1]) + error)
    if z.high > 0:
        if radius >= 1 << BITS:
            raise NotProvenError("an interval is too wide for a series")
        # S grows by e^(r/6) at most on the way.
        slope += (slope * radius >> BITS) + 1
    c, s = error + (slope * radius >> (BITS + 1)) + 1, error + (slope * radius >> BITS) // 6 + 2
    return Interval(sums[0] - c, sums[0] + c), Interval(sums[1] - s, sums[1] + s)


def exponential(y: Any) -> Any:
    """Return e^y = C(y^2) + y S(y^2) at both ends, which it grows between."""
    if isinstance(y, Dual):
        power = exponential(y.value)
        return Dual(power, power * y.slope)

    def at(value: int) -> Any:
        point = Interval(abs(value), abs(value))
        c, s = _cosine_series(point * point)
        power = c + point * s
        return power if value >= 0 else of(1) / power

    return Interval(at(y.low).low, at(y.high).high)


def pi() -> Any:
    """Return pi = 16 arctan(1/5) - 4 arctan(1/239), whose series alternate."""
    if BITS not in PI:
        PI[BITS] = 16 * _arctan(5) - 4 * _arctan(239)
    return PI[BITS]


PI: dict[int, Interval] = {}


def _arctan(q: int) -> Interval:
    total, n, sign = 0, 0, 1
    while True:
        term = (1 << (BITS + 8)) // (q ** (2 * n + 1) * (2 * n + 1))
        total += sign * term
        n, sign = n + 1, -sign
        if term == 0:
            return Interval((total - n - 1) >> 8, -(-(total + n + 1) >> 8))


def angle(phase: tuple[Fraction, Fraction]) -> Any:
    """Return p pi + q of a pair (p, q)."""
    return of(phase[0]) * pi() + of(phase[1])


# Numbers of a law are fractions; on a branch those that change are intervals, or dual numbers.
class Tone(NamedTuple):
    omega: Any
    amplitude: Any
    phase: tuple[Fraction, Fraction]


class Region(NamedTuple):
    stiffness: Any
    damping: Any
    constant: Any
    lower: int | None
    upper: int | None


class Bound(NamedTuple):
    at: Any
    # None: the edge of soft stops, which motions cross.
    restitution: Any


class Law(NamedTuple):
    """What moves: regions from below to above, the places between them, and the force."""

    regions: tuple[Region, ...]
    bounds: tuple[Bound, ...]
    tones: tuple[Tone, ...]
    # The period of the force is 2 pi over this.
    base: Any
    # The same with dual numbers, where derivatives by the parameter are asked for.
    dual: Any = None

    def period(self) -> Any:
        if self.base is None:
            raise NotProvenError("the force has no period")
        return 2 * pi() / self.base

    def cycles(self, tone: Tone, t: Any) -> tuple[Any, Any]:
        """Return cos and sin of a tone's argument, by whole turns near zero."""
        argument, turn = tone.omega * t + angle(tone.phase), 2 * pi()
        y = argument.value if isinstance(argument, Dual) else argument
        y = y - round(Fraction(y.low + y.high, turn.low + turn.high)) * turn
        cos, sin = cosine_series(-(y * y))
        one = 1 << BITS
        cos, sin = (Interval(max(part.low, -one), min(part.high, one)) for part in (cos, y * sin))
        if isinstance(argument, Dual):
            return Dual(cos, -sin * argument.slope), Dual(sin, cos * argument.slope)
        return cos, sin


class State(NamedTuple):
    """Instants, places and velocities of motions that begin a flight."""

    t: Interval
    x: Any
    v: Interval


Pair = tuple[Interval, Interval]
Matrix = tuple[Pair, Pair]
# A bound, its side, and between which tau it is passed.
Landing = tuple[int, int, Fraction, Fraction]


def product(a: Matrix, b: Matrix) -> Matrix:
    (p, q), (r, s) = a
    (e, f), (g, h) = b
    return (p * e + q * g, p * f + q * h), (r * e + s * g, r * f + s * h)


def applied(a: Matrix, b: Pair) -> Pair:
    (p, q), (r, s) = a
    return p * b[0] + q * b[1], r * b[0] + s * b[1]


def root(value: Interval) -> Interval:
    """Return a bound of the square root, from above and, so that it is one, from below by zero."""
    return Interval(0, isqrt(max(value.high, 0) << BITS) + 1)


class Flight:
    """The motion in one region from states; tau is the time since the start."""

    def __init__(self, law: Law, number: int, start: State) -> None:
        self.law, self.number, self.start = law, number, start
        self.region = law.regions[number]
        self.waves = [self._wave(tone) for tone in law.tones]
        p, q = self._particular(of(0), start.t)
        self.free = start.x - p, start.v - q

    def _wave(self, tone: Tone) -> tuple[Any, Any] | None:
        """Return p and q of the motion p cos + q sin under a tone, None at resonance."""
        w = tone.omega
        first, second = self.region.stiffness - w * w, 2 * self.region.damping * w
        size = first * first + second * second
        if size == 0:
            return None
        return of(tone.amplitude * first / size), of(tone.amplitude * second / size)

    def _particular(self, tau: Interval, t: Interval) -> tuple[Any, Any]:
        """Return a motion under the force, and its velocity."""
        k, a, c = self.region.stiffness, self.region.damping, self.region.constant
        if k != 0:
            x, v = of(c / k), of(0)
        elif a != 0:
            x, v = c / (2 * a) * tau, of(c / (2 * a))
        else:
            x, v = c / 2 * tau * tau, c * tau
        for tone, wave in zip(self.law.tones, self.waves, strict=True):
            cos, sin = self.law.cycles(tone, t)
            w = tone.omega
            if wave is not None:
                p, q = wave
                x, v = x + p * cos + q * sin, v + w * (q * cos - p * sin)
            else:
                p = of(tone.amplitude / (2 * w))
                x, v = x + p * tau * sin, v + p * (sin + w * tau * cos)
        return x, v

    def response(self, tau: Interval) -> tuple[Any, Any, Any, Any]:
        """Return x and v of free motion from (1, 0) and from (0, 1)."""
        k, a = self.region.stiffness, self.region.damping
        c, s = cosine_series(-(of(k - a * a) * tau * tau))
        s = tau * s
        if a != 0:
            decay = exponential(-(a * tau))
            c, s = decay * c, decay * s
        drag = a * s
        return c + drag, -(k * s), s, c - drag

    def by_start(self, tau: Interval, departed: int | None) -> Matrix:
        """Return the derivative of x and v by those of the start or, from a bound, by t and v there."""
        x_x, v_x, x_v, v_v = self.response(tau)
        if departed is None:
            return (x_x, x_v), (v_x, v_v)
        # A start later by dt is, at one instant, one that is moved by (-v, -a) dt.
        v, a = self.start.v, self.acceleration(self.force(of(0)), self.start.x, self.start.v)
        return (-(v * x_x + a * x_v), x_v), (-(v * v_x + a * v_v), v_v)

    def at(self, tau: Interval) -> tuple[Any, Any]:
        """Return x and v."""
        Work.goes_on()
        x_x, v_x, x_v, v_v = self.response(tau)
        x, v = self._particular(tau, self.start.t + tau)
        p, q = self.free
        return x + p * x_x + q * x_v, v + p * v_x + q * v_v

    def force(self, tau: Interval) -> Any:
        t, tones = self.start.t + tau, self.law.tones
        waves = (tone.amplitude * self.law.cycles(tone, t)[0] for tone in tones)
        return sum(waves, of(self.region.constant))

    def acceleration(self, force: Interval, x: Interval, v: Interval) -> Any:
        return force - self.region.stiffness * x - 2 * self.region.damping * v

    def on_step(self, begin: Fraction, h: Fraction) -> tuple[Interval, Interval, Interval]:
        """Return x and v on a step, and what has the sign of x(s) - x(begin).

        That is the mean velocity since then. Where the velocity was 0, or had the sign of the mean
        acceleration, it is that.
        By Taylor's theorem, with x and v on all of the step in intervals that Picard's operator maps
        into themselves, and therefore hold the motion.
        """
        Work.goes_on()
        since, force = of(0, h), self.force(of(begin, begin + h))
        first_x, first_v = x, v = self.at(of(begin)) if begin else (self.start.x, self.start.v)
        for _ in range(12):
            a = self.acceleration(force, x, v)
            next_x, next_v = first_x + since * v, first_v + since * a
            if x.holds(next_x) and v.holds(next_v):
                mean = first_v + Fraction(1, 2) * a * since
                sure = (first_v.low == 0 or a.high < 0) and (first_v.high == 0 or a.low > 0)
                return first_x + since * mean, next_v, a if sure else mean
            x, v = next_x.wider(), next_v.wider()
        raise NotProvenError("a step is too long")

    def landing(
        self, departed: int | None, *, may_settle: bool = False, until: Fraction | None = None
    ) -> Landing | None:
        """Return the bound that all motions meet first, its side, and between which tau.

        On each step before, x keeps off both bounds; on the last one it passes the bound and v keeps
        its sign, so that each motion passes it once. ``departed`` is the bound of the start. None says
        that all motions are proven to meet no bound ``until`` then or, with ``may_settle``, any more.
        """
        begin, h = Fraction(0), LONGEST
        # Steps that are short beside the width of the states are of no use.
        wide = Fraction(max(value.width for value in self.start), 1 << BITS)
        while begin < FLIGHT:
            if until is not None:
                h = min(h, until - begin)
            try:
                met = self._met_on(begin, h, departed)
            except NotProvenError:
                h /= 2
                if h < max(SHORTEST, wide * FINE):
                    raise NotProvenError(
                        f"which event comes next is open {_told(begin)} after an event"
                    ) from None
                continue
            if met is not None:
                return (*met, begin, begin + h)
            begin, h = begin + h, min(2 * h, LONGEST)
            if begin == until or (may_settle and self._settles(begin)):
                return None
        raise NotProvenError(f"no event within {FLIGHT}")

    def _settles(self, tau: Fraction) -> bool:
        """Return whether the norm of free motion and the waves keep x off the bounds from tau on.

        With K, a > 0 the norm (y^2 + y'^2/K)^(1/2) does not grow.
        """
        k, a, c, lower, upper = self.region
        x_x, v_x, x_v, v_v = self.response(of(tau))
        p, q = self.free
        y, dy = p * x_x + q * x_v, p * v_x + q * v_v
        reach = root(y * y + dy * dy / k)
        for tone in self.law.tones:
            first, second = k - tone.omega * tone.omega, 2 * a * tone.omega
            reach = reach + root(of(tone.amplitude**2 / (first * first + second * second)))
        return all(
            bound is None or (sign * (self.law.bounds[bound].at - of(c / k)) - reach).low > 0
            for bound, sign in ((lower, -1), (upper, 1))
        )

    def _met_on(self, begin: Fraction, h: Fraction, departed: int | None) -> tuple[int, int] | None:
        """Return the bound that all motions meet on a step, and its side, or None if they meet none."""
        x, v, since = self.on_step(begin, h)
        near = []
        for bound, sign in ((self.region.lower, -1), (self.region.upper, 1)):
            if bound is not None:
                at = of(self.law.bounds[bound].at)
                # At the start of a flight x is on the bound, and goes inwards.
                beyond = sign * (since if begin == 0 and bound == departed else x - at)
                if beyond.high >= 0:
                    near.append((bound, sign, at))
        if not near:
            return None
        bound, sign, at = near[0]
        last = sign * (self.at(of(begin + h))[0] - at)
        if begin == 0 or len(near) > 1 or last.low <= 0 or (sign * v).low <= 0:
            raise NotProvenError("a step is too long")
        return bound, sign


class Event(NamedTuple):
    """Where motions meet a bound: the state after, and its derivative by (t, v) at the start."""

    bound: int
    region: int
    tau: Interval
    t: Interval
    v_before: Interval
    v: Interval
    derivative: Matrix


def met(
    law: Law, number: int, start: State, departed: int | None, landing: Landing | None = None
) -> Event:
    """Return the next event of states, proven to be the first one, with interval Newton steps.

    Its derivative is by t and v after the event at the start or, where there was none, by x and v.
    ``landing`` is that of a set with these states, where it is known.
    """
    bound, sign, low, high = landing or _landing(law, number, start, departed)
    flight = Flight(law, number, start)
    at = of(law.bounds[bound].at)
    tau = of(low, high)
    while True:
        point = tau.middle()
        x, _ = flight.at(point)
        first, last = tau.fractions()
        _, v, _ = flight.on_step(first, last - first)
        newton = point - (x - at) / v
        new = Interval(max(tau.low, newton.low), min(tau.high, newton.high))
        if new.low > new.high:
            raise NotProvenError("an event has no instant: the arithmetic contradicts itself")
        done, tau = 4 * new.width >= 3 * tau.width, new
        if done:
            break
    _, v = flight.at(tau)
    a = flight.acceleration(flight.force(tau), at, v)
    (x_t, x_v), (v_t, v_v) = flight.by_start(tau, departed)
    # Later by dt, for which v dt is by how much x is short of the bound.
    t_t, t_v = -(x_t / v), -(x_v / v)
    kept, region = rebound(law, number, bound, sign)
    derivative = (t_t, t_v), (kept * (v_t + a * t_t), kept * (v_v + a * t_v))
    return Event(bound, region, tau, start.t + tau, v, kept * v, derivative)


def by_parameter(
    flight: Flight, departed: int, bound: int, tau: Interval
) -> tuple[Interval, Interval, Interval]:
    """Return the derivative of x - bound and v at an instant, and of what is kept, by the parameter."""
    law = flight.law.dual
    if law is None:
        return of(0), of(0), of(0)
    start = flight.start._replace(x=of(law.bounds[departed].at))
    x, v = Flight(law, flight.number, start).at(tau)
    at, restitution = law.bounds[bound]
    return dual(x - at).slope, dual(v).slope, -dual(restitution or 0).slope


def rebound(law: Law, number: int, bound: int, side: int) -> tuple[Any, int]:
    """Return what a bound keeps of a velocity, and the region after it."""
    restitution = law.bounds[bound].restitution
    return (of(1), number + side) if restitution is None else (of(-restitution), number)


def _landing(law: Law, number: int, start: State, departed: int | None) -> Landing:
    """Return `Flight.landing`, found with few bits."""
    # The numbers of a branch's law are intervals of all bits.
    shift = max(0, BITS - COARSE) if law.dual is None else 0
    few = State(*(Interval(value.low >> shift, -(-value.high >> shift)) for value in start))
    with bits(BITS - shift):
        found = Flight(law, number, few).landing(departed)
    assert found is not None
    return found


def after(law: Law, event: Event) -> State:
    return State(event.t, of(law.bounds[event.bound].at), event.v)


# How a certificate reads. Nothing else may stand in it, so that no claim is left unread.


LEAVES = {
    "q": f"rational number p/q of at most {DIGITS} digits each",
    "n": f"whole number from 0 to {COUNT}",
    "z": f"whole number of at most {COUNT} in size",
    "l": "rational number, or a pair of them, a and b, for a + b p",
    "l?": "rational number, or a pair of them, or null",
    "n?": "whole number from 0, or null",
    "w": "word",
}
NUMBER = re.compile(f"-?[0-9]{{1,{DIGITS}}}(/[0-9]{{1,{DIGITS}}})?")
PAIR = ("q", "q")
# Numbers of the law of a branch may depend on its parameter p.
LAW = {
    "regions": [
        {"stiffness": "l", "damping": "l", "constant": "l", "lower": "n?", "upper": "n?"}
    ],
    "bounds": [{"at": "l", "restitution": "l?"}],
    "tones": [{"omega": "l", "amplitude": "l", "phase": PAIR}],
    "base": "l?",
}  # fmt: skip
# Orbits for all values of one coordinate, number ``along``, of the instants and velocities after the
# events and the parameter: within ``sizes`` of middle + tangent (value - middle of this coordinate).
# Next to a graze ``slow`` is the number of the event whose velocity goes to zero.
STRIP = {
    "along": "n", "begin": "q", "end": "q", "middle": ["q"], "tangent": ["q"], "sizes": ["q"],
    "stability": "w", "slow": "n?",
}  # fmt: skip
ORBIT = {
    "periods": "n",
    "events": [{"bound": "n", "region": "n", "t": PAIR, "v": PAIR}],
    "stability": "w",
}
FORMS: dict[str, dict[str, Any]] = {
    "run": {
        "start": {"x": "q", "v": "q", "t": PAIR},
        "events": [{"bound": "n", "t": PAIR, "v_before": PAIR, "v_after": PAIR}],
    },
    "orbit": ORBIT,
    "branch": {
        "curves": [
            {
                # A whole number, or a half of an odd one: after it the orbit is its mirror image.
                "periods": "q",
                "events": [{"bound": "n", "region": "n"}],
                "strips": [STRIP],
                "points": [{"kind": "w", "before": "n", "after": "n"}],
            }
        ]
    },
    "list": {
        "impacts": "n",
        "periods": "n",
        "speeds": PAIR,
        "cycle": PAIR,
        "orbits": [ORBIT],
        "boxes": [{"cycle": PAIR, "v": PAIR}],
    },
    "basins": {
        "t": PAIR,
        "orbits": [
            {
                "orbit": ORBIT,
                "traps": [{"event": "n", "axes": (PAIR, PAIR), "rounds": "n", "stages": ["q"]}],
            }
        ],
        "steady": ["n"],
        "cells": [{"x": PAIR, "v": PAIR, "to": "n"}],
    },
    "chaos": {
        "bound": "n",
        "region": "n",
        "sets": [{"center": PAIR, "unstable": PAIR, "stable": PAIR}],
        "transitions": [{"from": "n", "to": "n", "turns": "z", "at": "q", "half": "q"}],
        "growth": "q",
    },
}


def read(value: Any, form: Any) -> Any:
    """Return what stands in a certificate with numbers for their words, if it has the form."""
    if isinstance(form, dict):
        if not isinstance(value, dict) or value.keys() != form.keys():
            names = ", ".join(value) if isinstance(value, dict) else repr(value)[:60]
            raise ValueError(f"{', '.join(form)} should stand where {names} stands")
        return {key: read(value[key], part) for key, part in form.items()}
    if isinstance(form, list | tuple):
        if not isinstance(value, list) or (isinstance(form, tuple) and len(value) != len(form)):
            raise ValueError(f"{repr(value)[:60]} is no list of {repr(form)[:60]}")
        return tuple(read(part, form[i % len(form)]) for i, part in enumerate(value))
    if value is None and form.endswith("?"):
        return None
    if form[0] == "l" and isinstance(value, list):
        return read(value, PAIR)
    if form[0] in "ql" and isinstance(value, str) and NUMBER.fullmatch(value):
        return Fraction(value)
    # True is an int, too.
    least = -COUNT if form == "z" else 0
    if form[0] in "nz" and type(value) is int and least <= value <= COUNT:
        return value
    if form == "w" and isinstance(value, str):
        return value
    raise ValueError(f"{repr(value)[:60]} is no {LEAVES[form]}")


def _without_twice(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    if len(set(names)) < len(names):
        raise ValueError(f"a name stands twice in {', '.join(names)}")
    return dict(pairs)


# What is claimed.


def law_at(text: Any, p: Any = None) -> Law:
    """Return the law of a certificate at a parameter: a fraction, an interval or a dual number."""

    def number(given: Any) -> Any:
        if not isinstance(given, tuple):
            return given
        if p is None:
            raise NotProvenError("a number depends on a parameter, but this is no branch")
        return given[0] + given[1] * p

    def made(kind: Any, it: dict[str, Any]) -> Any:
        return kind(**{key: part if key == "phase" else number(part) for key, part in it.items()})

    regions = tuple(made(Region, it) for it in text["regions"])
    bounds = tuple(made(Bound, it) for it in text["bounds"])
    return Law(regions, bounds, tuple(made(Tone, it) for it in text["tones"]), number(text["base"]))


def law_of(text: Any, p: Fraction | None = None) -> Law:
    """Return the law of a certificate, whose parts fit each other."""
    law = law_at(text, p)
    regions, bounds, tones, base, _ = law
    inner = [region.upper for region in regions[:-1]]
    if not regions or inner != [region.lower for region in regions[1:]] or None in inner:
        raise NotProvenError("the regions do not lie side by side")
    ends = regions[0].lower, regions[-1].upper
    used = [bound for bound in (ends[0], *inner, ends[1]) if bound is not None]
    if used != list(range(len(bounds))):
        raise NotProvenError("the bounds are not those of the regions")
    if any(lower.at >= upper.at for lower, upper in pairwise(bounds)):
        raise NotProvenError("the bounds are not in order")
    for bound, (_, r) in enumerate(bounds):
        if (r is None) != (bound in inner) or (r is not None and not 0 <= r <= 1):
            raise NotProvenError(f"bound {bound} has a restitution of {r}")
    if any(tone.omega <= 0 for tone in tones):
        raise NotProvenError("a frequency is not above 0")
    if (base is None) != (not tones) or (base is not None and base <= 0):
        raise NotProvenError(f"the frequencies are not multiples of {base}")
    multiples = [tone.omega / base for tone in tones]
    if any(n.denominator != 1 for n in multiples):
        raise NotProvenError("the force does not repeat after its period")
    if tones and gcd(*(n.numerator for n in multiples)) != 1:
        raise NotProvenError("the force repeats before its period ends")
    edges = [bound.at for bound in bounds if bound.restitution is None]
    for at, (lower, upper) in zip(edges, pairwise(regions), strict=True):
        # A soft stop is a spring from its edge on: with it the force at rest there is the same.
        if lower.constant - lower.stiffness * at != upper.constant - upper.stiffness * at:
            raise NotProvenError("the force jumps at the edge of a stop")
    return law


def check_period(law: Law) -> None:
    """Prove that the period of a law is that of its force, which no shorter one is."""
    if not all(any(signs) for signs in _signs_of_waves(law).values()):
        raise NotProvenError("a tone has no amplitude, or those of one frequency may cancel")


def _signs_of_waves(law: Law) -> dict[Fraction, tuple[int, int]]:
    """Return, for each frequency, the signs of its tones' parts in phase with cos and with sin.

    A frequency with a part that is not zero is one of the force.
    """
    waves: dict[Fraction, list[Tone]] = {}
    for tone in law.tones:
        waves.setdefault(tone.omega / law.base, []).append(tone)
    signs = {}
    for multiple, tones in waves.items():
        # So that a small amplitude is no rounding error.
        unit = max(abs(tone.amplitude) for tone in tones) or 1
        parts = [
            tuple(tone.amplitude / unit * part for part in law.cycles(tone, of(0)))
            for tone in tones
        ]
        cos, sin = (_sign(sum(part, of(0))) for part in zip(*parts, strict=True))
        signs[multiple] = cos, sin
    return signs


def law_over(text: Any, p: Any) -> Law:
    """Return the law at an interval of the parameter, with dual numbers for its derivatives."""
    return law_at(text, p)._replace(dual=law_at(text, Dual(of(p), of(1))))


def proven_run(law: Law, text: Any) -> str:
    """Prove that a motion has these events and no others up to the last, each inside its intervals."""
    events, begin = text["events"], text["start"]
    if not events:
        raise NotProvenError("no event is claimed")
    for n in RUN_BITS:
        try:
            with bits(n):
                _check_events(law, begin, events)
        except ContradictedError:
            raise
        except NotProvenError:
            if n == RUN_BITS[-1]:
                raise
        else:
            break
    first, last = events[0]["t"], events[-1]["t"]
    return (
        f"The motion from x = {begin['x']}, v = {begin['v']} at t = {_phase(begin['t'])} meets the "
        f"stops at {len(events)} instants and no others up to the last of them, the first between "
        f"{_near(first)}, the last between {_near(last)}; each instant and the velocities before "
        f"and after lie in the intervals of the certificate."
    )


def _check_events(law: Law, begin: Any, events: Sequence[Any]) -> None:
    state, number, departed = _start(law, begin)
    for k, claim in enumerate(events, start=1):
        event = met(law, number, state, departed)
        if event.bound != claim["bound"]:
            raise ContradictedError(f"event {k} is at bound {event.bound}")
        for name, ours in (("t", event.t), ("v_before", event.v_before), ("v_after", event.v)):
            low, high = ours.fractions()
            least, most = claim[name]
            if high < least or low > most:
                raise ContradictedError(f"{name} of event {k} is {_told(low)}")
            if not (least <= low and high <= most):
                raise NotProvenError(f"{name} of event {k} is not known to the digits claimed")
        state, number, departed = after(law, event), event.region, event.bound


def _start(law: Law, begin: Any) -> tuple[State, int, int | None]:
    """Return the start of a run, its region and the bound that it departs from."""
    x, v = begin["x"], begin["v"]
    state = State(angle(begin["t"]), of(x), of(v))
    for number, region in enumerate(law.regions):
        low, high = (None if i is None else law.bounds[i].at for i in (region.lower, region.upper))
        if (low is not None and x < low) or (high is not None and x > high):
            continue
        departed = region.lower if x == low else region.upper if x == high else None
        flight = Flight(law, number, state)
        # From rest on a bound a motion goes where the force points, which is the same on both sides.
        away = flight.acceleration(flight.force(of(0)), state.x, state.v) if v == 0 else of(v)
        if departed is None or (away.low > 0 if x == low else away.high < 0):
            return state, number, departed
    raise NotProvenError("the start is beyond a wall, or stays on a stop")


def proven_orbit(law: Law, text: Any) -> str:
    """Prove by Krawczyk's operator that one periodic orbit, and one only, lies in the boxes."""
    claims, periods = text["events"], text["periods"]
    n = len(claims)
    if n == 0 or periods < 1:
        raise NotProvenError("an orbit has one event at least, and one period")
    if any(claim[name][0] >= claim[name][1] for claim in claims for name in "tv"):
        raise NotProvenError("an interval of the orbit is empty, or one point")
    boxes = [(of(*claim["t"]), of(*claim["v"])) for claim in claims]
    middles = [(t.middle(), v.middle()) for t, v in boxes]
    cycle = Cycle(law, claims, periods)
    shot, missed = shot_of(cycle, boxes), shot_of(cycle, middles).missed
    rows = [row[:-1] for row in shot.rows]
    widths = [
        Interval(-((box.width + 1) // 2) - 1, (box.width + 1) // 2 + 1)
        for pair in boxes
        for box in pair
    ]
    _check_inside(widths, contracted(_inverse(rows), rows, widths, missed))
    check_first(cycle, boxes)
    stability = _stability(shot.monodromy)
    if text["stability"] not in (stability, "undecided"):
        raise NotProvenError(f"the orbit is {stability}, not {text['stability']}")
    said = {"asymptotic": "Neighbouring motions approach it.", "unstable": "It is unstable."}.get(
        stability if text["stability"] == stability else "", "Nothing is claimed of its stability."
    )
    return (
        f"There is one periodic orbit, and one only, whose {n} events in {periods} periods of the force, "
        f"{2 * periods / (law.base or 1)} pi long, lie in the boxes of the certificate, the first at t "
        f"between {_near(claims[0]['t'])}; it meets the stops at these events and no others. {said}"
    )


class Leg(NamedTuple):
    """A flight of an orbit from event k to the next one, or its image under the symmetry of the law."""

    k: int
    following: int
    # The next event, where the flight comes to it.
    bound: int
    region: int
    # -1 if that is the image of the first event of the orbit, and what is later than it.
    sign: int
    later: Any


class Cycle(NamedTuple):
    """The events of an orbit, the last of which leads to the first after some periods.

    After half a period more than a whole number it leads to the mirror image of the first.
    """

    law: Law
    events: Sequence[Any]
    periods: Fraction | int

    def legs(self) -> Iterator[Leg]:
        if any(event["bound"] >= len(self.law.bounds) for event in self.events):
            raise NotProvenError("an event is at a bound that there is not")
        for k, following in enumerate([*range(1, len(self.events)), 0]):
            event = self.events[following]
            bound, region, sign, later = event["bound"], event["region"], 1, dual(0)
            if following == 0:
                later = dual(self.periods * (self.law.dual or self.law).period())
                if self.periods.denominator == 2:
                    bounds, regions = len(self.law.bounds) - 1, len(self.law.regions) - 1
                    bound, region, sign = bounds - bound, regions - region, -1
            yield Leg(k, following, bound, region, sign, later)


class Shot(NamedTuple):
    """Flights from all events of an orbit, at the instants of the next ones.

    By how much places and velocities miss these events; the derivative of that by all instants and
    velocities, and by the parameter; and that of the state after the last flight by the first one.
    """

    missed: list[Interval]
    rows: list[list[Interval]]
    monodromy: Matrix


def flights_of(
    cycle: Cycle, states: Sequence[Pair], slow: int | None
) -> Iterator[tuple[Leg, Flight, int, Interval]]:
    """Yield the flights from all events, the bounds they depart from, and how long they are.

    Event ``slow`` may have no velocity.
    """
    law, events, _ = cycle
    for leg in cycle.legs():
        bound, number, (t, v) = events[leg.k]["bound"], events[leg.k]["region"], states[leg.k]
        # A wall that keeps nothing leaves the mass at rest, whatever the interval of v.
        rests = law.bounds[bound].restitution == 0
        state = t, of(0) if rests else v
        start = departing(law, number, bound, state, may_rest=rests or leg.k == slow)
        tau = states[leg.following][0] + leg.later.value - t
        if tau.low <= 0:
            raise NotProvenError("an event does not come after the one before it")
        yield leg, Flight(law, number, start), bound, tau


def shot_of(cycle: Cycle, states: Sequence[Pair], slow: int | None = None) -> Shot:
    """Return by how much an orbit misses its events. Which bound is first is left to `check_first`.

    With an event ``slow`` the derivative of the state is that times its velocity, by which it would
    be divided; the equations have no divisor.
    """
    law, n, zero = cycle.law, len(cycle.events), of(0)
    missed: list[Interval] = []
    rows: list[list[Interval]] = []
    total = ((of(1), zero), (zero, of(1)))
    for leg, flight, departed, tau in flights_of(cycle, states, slow):
        kept, region = rebound(law, flight.number, leg.bound, leg.region - flight.number)
        if region != leg.region:
            raise NotProvenError("an event does not lead into its region")
        kept, (x, v) = leg.sign * kept, flight.at(tau)
        # Where x is, which is at the bound for the orbit alone.
        a = flight.acceleration(flight.force(tau), x, v)
        (x_t, x_v), (v_t, v_v) = flight.by_start(tau, departed)
        x_p, v_p, kept_p = by_parameter(flight, departed, leg.bound, tau)
        if law.bounds[departed].restitution == 0:
            x_v = v_v = zero
        missed += [x - of(law.bounds[leg.bound].at), kept * v - states[leg.following][1]]
        # As in `met`.
        ratio, times = (kept, kept * v) if leg.following == slow else (1 / v, of(1))
        t_t, t_v = -(x_t * ratio), -(x_v * ratio)
        by_v = kept * (times * v_t + a * t_t), kept * (times * v_v + a * t_v)
        total = product(((t_t, t_v), by_v), total)
        # The end is later with the next instant, and with the periods by the parameter.
        later = leg.later.slope
        place, speed = [zero] * (2 * n + 1), [zero] * (2 * n + 1)
        k, j = 2 * leg.k, 2 * leg.following
        for row, ends in (
            (place, ((k, x_t), (k + 1, x_v), (j, v), (-1, x_p + v * later))),
            (speed, ((k, v_t), (k + 1, v_v), (j, a), (-1, v_p + a * later))),
        ):
            for i, entry in ends:
                row[i] = row[i] + entry
        speed = [kept * entry for entry in speed]
        speed[j + 1] = speed[j + 1] - 1
        speed[-1] = speed[-1] + leg.sign * kept_p * v
        rows += [place, speed]
    return Shot(missed, rows, total)


def check_first(cycle: Cycle, states: Sequence[Pair], slow: int | None = None) -> None:
    """Prove that orbits with these events meet the stops at them and at no others."""
    for leg, flight, departed, tau in flights_of(cycle, states, slow):
        if leg.following == slow:
            _check_touch(flight, departed, leg.bound, tau)
            continue
        first = met(flight.law, flight.number, flight.start, departed)
        # There is one root where the first event is or this one may be: v keeps its sign.
        _, v = flight.at(_hull([first.tau, tau]))
        if (first.bound, first.region) != (leg.bound, leg.region) or v.least == 0:
            raise NotProvenError("the events of the orbit are not those claimed")


def _check_touch(flight: Flight, departed: int, bound: int, tau: Interval) -> None:
    """Prove that a flight which ends on a wall at tau with no or little speed meets nothing before.

    Shortly before, x'' points off the wall: by Taylor's theorem at the end, where the velocity is not
    off it, the motion is off it then.
    """
    lower, upper = flight.region.lower, flight.region.upper
    restitution = flight.law.bounds[bound].restitution
    if restitution is None or of(restitution).low <= 0:
        raise NotProvenError(
            "the event without velocity is on no wall, or on one that keeps nothing"
        )
    for lift in LIFTS:
        with suppress(NotProvenError):
            first, last = tau.fractions()
            until = first - lift
            if until <= 0 or flight.landing(departed, until=until) is not None:
                continue
            x, v, _ = flight.on_step(until, last - until)
            a = flight.acceleration(flight.force(of(until, last)), x, v)
            off = [
                (sign * (of(flight.law.bounds[other].at) - x)).low > 0
                for other, sign in ((lower, -1), (upper, 1))
                if other is not None and other != bound
            ]
            if all(off) and ((1 if bound == lower else -1) * a).low > 0:
                return
    raise NotProvenError("that the flight to a touch meets nothing before is open")


def contracted(
    inverse: Sequence[Sequence[Fraction]],
    rows: Sequence[Sequence[Interval]],
    widths: Sequence[Interval],
    missed: Sequence[Interval],
) -> list[Interval]:
    """Return (1 - C J) W - C missed: all zeros of equations in a box W about a point lie there."""
    n, moved = len(rows), []
    for i, c in enumerate(inverse):
        part = of(0)
        for j in range(n):
            entry = of(int(i == j)) - sum((c[k] * rows[k][j] for k in range(n)), of(0))
            part = part + entry * widths[j] - c[j] * missed[j]
        moved.append(part)
    return moved


def _check_inside(widths: Sequence[Interval], moved: Sequence[Interval]) -> None:
    """Prove that one zero, and one only, lies in a box (Krawczyk)."""
    for width, part in zip(widths, moved, strict=True):
        # By 3 units inside of the widened box: inside of what is claimed, which `of` rounded outward.
        if not Interval(width.low + 3, width.high - 3).holds(part):
            raise NotProvenError("the boxes are not proven to hold an orbit")


def departing(law: Law, number: int, bound: int, box: Pair, *, may_rest: bool = False) -> State:
    """Return the states that leave a bound of a region, into it, at these instants and velocities."""
    if number >= len(law.regions):
        raise NotProvenError(f"there is no region {number}")
    region, (t, v) = law.regions[number], box
    least = v.low if bound == region.lower else -v.high if bound == region.upper else -1
    if least < 0 or (least == 0 and not may_rest):
        raise NotProvenError("an event does not lead into its region")
    return State(t, of(law.bounds[bound].at), v)


def _inverse(rows: Sequence[Sequence[Interval]]) -> list[list[Fraction]]:
    """Return about the inverse of a matrix; what it is used for is checked."""
    n, unit = len(rows), 1 << 100
    wide = [
        [*(e.middle().fractions()[0] for e in row), *(Fraction(int(i == j)) for j in range(n))]
        for i, row in enumerate(rows)
    ]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(wide[i][k]))
        if wide[pivot][k] == 0:
            raise NotProvenError("the equations of the orbit are singular")
        wide[k], wide[pivot] = wide[pivot], wide[k]
        wide[k] = [Fraction(round(e / wide[k][k] * unit), unit) for e in wide[k]]
        for i in range(n):
            if i != k and wide[i][k]:
                factor = wide[i][k]
                pairs = zip(wide[i], wide[k], strict=True)
                wide[i] = [Fraction(round((a - factor * b) * unit), unit) for a, b in pairs]
    return [row[n:] for row in wide]


def _stability(m: Matrix) -> str:
    """Return what trace and determinant say of the multipliers."""
    (a, b), (c, d) = m
    trace, determinant, one = a + d, a * d - b * c, of(1)
    if trace.size < (one + determinant).low and determinant.size < one.low:
        return "asymptotic"
    if trace.least > (one + determinant).high or determinant.least > one.high:
        return "unstable"
    return "undecided"


POINTS = "fold", "period_doubling", "symmetry_breaking", "third_root", "fourth_root"
# Of a law that keeps areas, so that the determinant is 1.
ROOTS = {"third_root": "exp(2 pi i/3) and exp(-2 pi i/3)", "fourth_root": "i and -i"}
STABILITIES = {
    "asymptotic": "Neighbouring motions approach the orbits",
    "unstable": "The orbits are unstable",
}


class Strip:
    """Orbits for all values of one of their coordinates, near a tangent; proven when it is made."""

    def __init__(self, text: Any, curve: Any, claim: Any) -> None:
        self.text, self.curve, self.claim = text, curve, claim
        self.along, self.middle, self.tangent = claim["along"], claim["middle"], claim["tangent"]
        self.ends, self.slow = (claim["begin"], claim["end"]), claim["slow"]
        # The number of the parameter.
        self.n = 2 * len(curve["events"])
        self.widths = [of(-size, size) for i, size in enumerate(claim["sizes"]) if i != self.along]
        self.missed = self._shot([of(value) for value in self.middle])
        self.inverse = _inverse(self._others(self.missed.rows))
        for parts in PARTS_OF_STRIP:
            try:
                self._prove(parts)
            except NotProvenError as error:
                reason = error
            else:
                return
        raise NotProvenError(f"in the strip at p = {_told(self.middle[self.n])}: {reason}")

    def _prove(self, parts: int) -> None:
        """Prove the strip from its middle to both ends, by so many parts each."""
        zero, parts_of_curve = Fraction(0), []
        for end in self.ends:
            way = end - self.middle[self.along]
            cuts = [way * k / parts for k in range(parts + 1)]
            # By how much the tangent misses, first at the beginning of a part.
            missed = self.missed.missed
            for first, last in pairwise(cuts):
                eta = of(self.middle[self.along]) + of(min(first, last), max(first, last))
                shot = self._shot(self.around(eta, self.widths))
                slopes = [
                    sum((e * t for e, t in zip(row, self.tangent, strict=True)), of(0))
                    for row in shot.rows
                ]
                on_way = of(min(zero, last - first), max(zero, last - first))
                within = [e + slope * on_way for e, slope in zip(missed, slopes, strict=True)]
                part = contracted(self.inverse, self._others(shot.rows), self.widths, within)
                _check_inside(self.widths, part)
                missed = [
                    e + (last - first) * slope for e, slope in zip(missed, slopes, strict=True)
                ]
                parts_of_curve.append((eta, part))
        self.moved = [_hull(e) for e in zip(*(part for _, part in parts_of_curve), strict=True)]
        # Where the orbits are known to be is less than the strip.
        boxes = [self.around(*part) for part in parts_of_curve]
        for box in boxes:
            check_first(*self._at(box), self.slow)
        shots = [self._shot(box) for box in boxes]
        if self.slow is None:
            found = {_stability(shot.monodromy) for shot in shots}
            zeros = [_zero_at(shot.monodromy) for shot in shots]
            self.signs = {kind: {_sign(zero[kind]) for zero in zeros} for kind in POINTS}
        else:
            found = {self._stability_next_to_graze(*it) for it in zip(boxes, shots, strict=True)}
            self.signs = {kind: {0} for kind in POINTS}
        if self.claim["stability"] != "undecided" and found != {self.claim["stability"]}:
            raise NotProvenError(f"its orbits are {' or '.join(sorted(found))}")

    def _stability_next_to_graze(self, box: Sequence[Interval], shot: Shot) -> str:
        """Return what a trace above 2 says while the determinant is at most 1.

        Both are known times the slow velocity, without damping that drives.
        """
        (a, _), (_, d) = shot.monodromy
        regions = self._at(box)[0].law.regions
        is_damped = all(of(region.damping).low >= 0 for region in regions)
        is_above = (a + d).least > 2 * box[self.along].size
        return "unstable" if is_damped and is_above else "undecided"

    def _shot(self, point: Sequence[Interval]) -> Shot:
        return shot_of(*self._at(point), self.slow)

    def _at(self, point: Sequence[Interval]) -> tuple[Cycle, list[Pair]]:
        """Return the orbit, under the law of its parameter, and its states at a point."""
        law = law_over(self.text, point[-1])
        states = list(zip(point[:-1:2], point[1::2], strict=True))
        return Cycle(law, self.curve["events"], self.curve["periods"]), states

    def _others(self, rows: Sequence[Sequence[Interval]]) -> list[list[Interval]]:
        return [[e for i, e in enumerate(row) if i != self.along] for row in rows]

    def around(self, eta: Interval, widths: Sequence[Interval]) -> list[Interval]:
        """Return a box about the tangent for an interval of the coordinate."""
        shift = eta - of(self.middle[self.along])
        box = [p + slope * shift for p, slope in zip(self.middle, self.tangent, strict=True)]
        box[self.along] = eta
        others = [i for i in range(self.n + 1) if i != self.along]
        for i, width in zip(others, widths, strict=True):
            box[i] = box[i] + width
        return box

    def has_only(self, box: Sequence[Interval], coordinate: Fraction | None = None) -> bool:
        """Return whether an orbit in a box is one of its own: none is near it but these.

        ``coordinate`` is that of the strip where it is known exactly: a box is rounded outward.
        """
        eta = box[self.along]
        low, high = (coordinate, coordinate) if coordinate is not None else eta.fractions()
        if low < min(self.ends) or high > max(self.ends):
            return False
        tangent = self.around(eta, [of(0)] * self.n)
        apart = [
            e - t for i, (e, t) in enumerate(zip(box, tangent, strict=True)) if i != self.along
        ]
        return all(
            w.low + 3 < a.low and a.high < w.high - 3
            for a, w in zip(apart, self.widths, strict=True)
        )

    def goes_on_in(self, following: Strip, steps: int) -> bool:
        """Return whether the curve goes on in the next strip, by an orbit that both have.

        Those from a graze reach beyond the first orbit of the next strip; else it is that at their end.
        """
        return (self.slow is not None and following.begins_in(self, 0, steps)) or self.begins_in(
            following, 1, steps
        )

    def begins_in(self, other: Strip, end: int, steps: int) -> bool:
        """Return whether the orbit at one end is one of another strip."""
        is_known = self.along == other.along
        return other.has_only(self.orbit_at(end, steps), self.ends[end] if is_known else None)

    def orbit_at(self, end: int, steps: int = 0) -> list[Interval]:
        """Return a box with the orbit at its begin, 0, or end, 1; smaller after some steps."""
        eta, moved = of(self.ends[end]), self.moved
        for _ in range(steps):
            middles = [part.middle() for part in moved]
            widths = [part - middle for part, middle in zip(moved, middles, strict=True)]
            rows = self._others(self._shot(self.around(eta, moved)).rows)
            missed = self._shot(self.around(eta, middles)).missed
            found = contracted(_inverse(rows), rows, widths, missed)
            moved = [part + middle for part, middle in zip(found, middles, strict=True)]
        return self.around(eta, moved)


def _zero_at(m: Matrix) -> dict[str, Any]:
    """Return what is zero where 1, -1 or, of a law that keeps areas, a root of 1 is a multiplier."""
    (a, b), (c, d) = m
    trace, determinant = a + d, a * d - b * c
    doubling = 1 + trace + determinant
    return {
        "fold": 1 - trace + determinant,
        "period_doubling": doubling,
        "symmetry_breaking": doubling,
        "third_root": 1 + trace,
        "fourth_root": trace,
    }


def _sign(value: Interval) -> int:
    return (value.low > 0) - (value.high < 0)


def proven_branch(_: None, claims: Any) -> str:
    """Prove the strips of each curve, that each goes on in the next one, and the points on it."""
    if not claims["curves"]:
        raise NotProvenError("no curve is claimed")
    return "\n".join(_proven_curve(claims["law"], curve) for curve in claims["curves"])


def _proven_curve(text: Any, curve: Any) -> str:
    if not (curve["strips"] and curve["events"]):
        raise NotProvenError("a curve has no strips, or no events")
    if curve["periods"] <= 0 or curve["periods"].denominator > 2:
        raise NotProvenError("the periods of a curve are no whole number, nor a half of one")
    if any(claim["stability"] not in (*STABILITIES, "undecided") for claim in curve["strips"]):
        raise NotProvenError("a stability is none that can be claimed")
    _check_range(text, curve)
    sizes = [size for claim in curve["strips"] for size in claim["sizes"] if size > 0]
    # Bits to spare beyond those of the sides of the strips.
    enough = max((ceil(1 / size).bit_length() + 64 for size in sizes), default=0)
    with bits(min(max(COARSE, enough), RUN_BITS[-1])):
        strips = [Strip(text, curve, claim) for claim in curve["strips"]]
        for strip, following in pairwise(strips):
            if not any(strip.goes_on_in(following, steps) for steps in range(3)):
                at = _told(strip.orbit_at(1)[-1].fractions()[0])
                raise NotProvenError(f"at p = {at} the curve is not proven to go on")
        return _curve_in_words(text, curve, strips)


def _check_range(text: Any, curve: Any) -> None:
    """Prove that the law has a meaning for all parameters of a curve.

    What is to hold is linear in p, or quadratic: an identity at three values is one at all.
    """
    ranges = [_parameters(claim, 2 * len(curve["events"])) for claim in curve["strips"]]
    low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
    laws = [law_of(text, p) for p in (low, (low + high) / 2, high)]
    if len({tuple(tone.omega / law.base for tone in law.tones) for law in laws}) > 1:
        raise NotProvenError("the frequencies are not the same multiples of their base throughout")
    # What is linear in p has one sign between two values at which it has that.
    signs = [_signs_of_waves(law) for law in laws]
    for wave in signs[0]:
        if not any({s[wave][i] for s in signs} in ({1}, {-1}) for i in range(2)):
            raise NotProvenError("a tone may have no amplitude at some parameter")
    if curve["periods"].denominator == 2 and not all(_is_symmetric(law) for law in laws):
        raise NotProvenError("an orbit of half periods is of a law without the symmetry")


def _is_symmetric(law: Law) -> bool:
    """Return whether a law is unchanged under (x, t) -> (-x, t + half a period)."""
    n = len(law.bounds) - 1
    regions = [
        Region(k, a, -c, None if upper is None else n - upper, None if lower is None else n - lower)
        for k, a, c, lower, upper in reversed(law.regions)
    ]
    bounds = [Bound(-at, restitution) for at, restitution in reversed(law.bounds)]
    odd = all((tone.omega / law.base).numerator % 2 == 1 for tone in law.tones)
    return odd and regions == list(law.regions) and bounds == list(law.bounds)


def _parameters(claim: Any, n: int) -> tuple[Fraction, Fraction]:
    """Return numbers between which all parameters of a strip lie, whose parts fit each other."""
    along, sizes = claim["along"], claim["sizes"]
    if {len(claim[name]) for name in ("middle", "tangent", "sizes")} != {n + 1} or along > n:
        raise NotProvenError(f"a strip has not {n + 1} coordinates")
    if (claim["tangent"][along], sizes[along]) != (1, 0) or min(sizes) < 0:
        raise NotProvenError("the sides of a strip are not those of its coordinate")
    begin, end = claim["begin"], claim["end"]
    if claim["slow"] is not None and (along != 2 * claim["slow"] + 1 or along >= n):
        raise NotProvenError("a strip next to a graze is not along the velocity of its event")
    if begin == end or 2 * claim["middle"][along] != begin + end:
        raise NotProvenError("a strip has no length, or its middle is not there")
    p, slope = claim["middle"][n], claim["tangent"][n]
    low, high = sorted(p + slope * (value - claim["middle"][along]) for value in (begin, end))
    return low - sizes[n], high + sizes[n]


def _curve_in_words(text: Any, curve: Any, strips: Sequence[Strip]) -> str:
    n, periods = len(curve["events"]), curve["periods"]
    halves = ""
    if periods.denominator == 2:
        n, periods, halves = 2 * n, 2 * periods, ", its second half the mirror image of the first"
    begin, end = strips[0].orbit_at(0)[-1].fractions(), strips[-1].orbit_at(1)[-1].fractions()
    said = (
        f"The {len(strips)} strips of a curve hold, for each value of the coordinate of each, one "
        f"periodic orbit of {n} events in {periods} periods of the force{halves}, and one only; each "
        f"meets the stops at these events and no others. They form one smooth curve, which leads from a "
        f"parameter p between {_near(begin)} to one between {_near(end)}."
    )
    lines = [said]
    for stability, group in groupby(strips, lambda strip: strip.claim["stability"]):
        low, high = _parameters_of(list(group))
        said = STABILITIES.get(stability, "Nothing is claimed of the stability of orbits")
        lines.append(f"  {said}, on the part of the curve with p between {_near((low, high))}.")
    for point in curve["points"]:
        kind, i, j = point["kind"], point["before"], point["after"]
        if kind not in POINTS or not i < j < len(strips):
            raise NotProvenError(f"there is no {kind} between strips {i} and {j}")
        said = _point_said(text, kind, strips[i : j + 1], mirrored=bool(halves))
        if not said:
            raise NotProvenError(f"that there is a {kind} between strips {i} and {j} is not proven")
        lines.append(
            f"  On the way {said}, at p between {_near(_parameters_of(strips[i : j + 1]))}."
        )
    for strip in strips:
        for number, value in enumerate(strip.ends):
            if strip.slow is not None and value == 0:
                near = _near(strip.orbit_at(number, 3)[-1].fractions())
                lines.append(
                    f"  At the end with p between {near} event {strip.slow} has no velocity: the "
                    f"motion touches the wall there, and goes on as if it were not there; of the stability of "
                    f"this orbit nothing is claimed."
                )
    return "\n".join(lines)


def _point_said(text: Any, kind: str, strips: Sequence[Strip], *, mirrored: bool) -> str:
    """Return what lies between the first and the last of some strips, "" if it is not proven."""
    first, last = (strips[i].signs[kind] for i in (0, -1))
    if sorted([*first, *last]) != [-1, 1]:
        return ""
    if kind == "fold":
        return "p is extremal along the curve"
    if kind in ROOTS:
        keeps_areas = all(it["damping"] in (0, (0, 0)) for it in text["regions"]) and all(
            it["restitution"] in (None, 1, (1, 0)) for it in text["bounds"]
        )
        return f"the multipliers are {ROOTS[kind]}" if keeps_areas and not mirrored else ""
    # While 1 is no multiplier, the index of the map done twice changes its sign with det(M + 1).
    has_others = {sign for strip in strips for sign in strip.signs["fold"]} in ({1}, {-1})
    if kind == "period_doubling" and not mirrored:
        others = ", and orbits of twice the period branch off" if has_others else ""
        return f"a multiplier is -1{others}"
    if kind == "symmetry_breaking" and mirrored and has_others:
        return "a multiplier over half an orbit is -1, and orbits without the symmetry branch off"
    return ""


def _parameters_of(strips: Sequence[Strip]) -> tuple[Fraction, Fraction]:
    """Return numbers between which the parameters of all orbits of some strips lie."""
    ranges = [
        strip.around(of(min(strip.ends), max(strip.ends)), strip.moved)[-1].fractions()
        for strip in strips
    ]
    return min(low for low, _ in ranges), max(high for _, high in ranges)


class Returns:
    """The equations of motions that meet one wall n times in p periods and then come back.

    From (t, v) after an impact: x(t + p T) is the wall, and an impact there leaves with v again. The
    speeds after all impacts are between two.
    """

    def __init__(self, law: Law, n: int, p: int, speeds: tuple[Fraction, Fraction]) -> None:
        self.law, self.n, self.duration, self.period = law, n, p * law.period(), law.period()
        self.slow, self.fast = of(speeds[0]).low, of(speeds[1]).high
        self.at, self.r = of(law.bounds[0].at), law.bounds[0].restitution
        # The sign of velocities after an impact.
        self.off = 1 if law.regions[0].lower == 0 else -1

    def box(self, cycle: tuple[Fraction, Fraction], v: tuple[Fraction, Fraction]) -> State:
        """Return the states whose t over the period, and speed, lie between two numbers each."""
        return State(of(*cycle) * self.period, self.at, self.off * of(*v))

    def missed(self, start: State) -> tuple[list[Interval], list[list[Interval]]]:
        """Return by how much states fail to come back, and the derivative by t and v."""
        t, v0, total = start.t, start.v, ((of(1), of(0)), (of(0), of(1)))
        for _ in range(self.n - 1):
            event = met(self.law, 0, start, 0)
            total, start = product(event.derivative, total), after(self.law, event)
        flight, tau = Flight(self.law, 0, start), t + self.duration - start.t
        x, v = flight.at(tau)
        (a, b), (c, d) = product(flight.by_start(tau, 0), total)
        # The end is later by dt as well.
        a, c = a + v, c + flight.acceleration(flight.force(tau), x, v)
        return [x - self.at, -self.r * v - v0], [[a, b], [-self.r * c, -self.r * d - 1]]

    def excludes(self, box: State) -> bool:
        """Return whether no motion that is sought has an impact in a box."""
        with suppress(NotProvenError):
            if self.comes_to_nothing(box, 0, box):
                return True
        with suppress(NotProvenError):
            return self.has_no_zero(box)
        return False

    def has_no_zero(self, box: State) -> bool:
        """Return whether the mean value theorem shows that no state of a box comes back."""
        middle = State(box.t.middle(), self.at, box.v.middle())
        value, _ = self.missed(middle)
        _, rows = self.missed(box)
        spread = box.t - middle.t, box.v - middle.v
        whole = [
            e + row[0] * spread[0] + row[1] * spread[1] for e, row in zip(value, rows, strict=True)
        ]
        return any(part.least > 0 for part in whole)

    def zero(self, box: State) -> State:
        """Return a small box with the one zero of the equations in a box; prove that it is one."""
        found = box
        for _ in range(6):
            middle = State(found.t.middle(), self.at, found.v.middle())
            widths = [found.t - middle.t, found.v - middle.v]
            _, rows = self.missed(found)
            part = contracted(_inverse(rows), rows, widths, self.missed(middle)[0])
            if found is box:
                _check_inside(widths, part)
            found = State(middle.t + part[0], self.at, middle.v + part[1])
        return found

    def is_left_at(self, start: State) -> bool:
        """Return whether the motion from a small box is proven not to come back after n impacts."""
        state = start
        for _ in range(self.n):
            state = after(self.law, met(self.law, 0, state, 0))
        apart = state.t - start.t - self.duration, state.v - start.v
        return any(part.least > 0 for part in apart)

    def comes_to_nothing(self, start: State, k: int, begin: State) -> bool:
        """Return whether no motion from a box after k impacts comes back, by intervals alone.

        An impact that is too slow is none of a motion that is sought: the flight goes on, through the
        wall. Where an impact may be, what follows it is looked at, and the flight without it as well.
        """
        flight, end = Flight(self.law, 0, start), begin.t + self.duration
        if k == self.n - 1:
            x, v = flight.at(end - start.t)
            speed = -self.r * v * self.off
            apart = (x - self.at).least > 0 or (speed * self.off - begin.v).least > 0
            return bool(apart or speed.high < self.slow or speed.low > self.fast)
        tau, h = Fraction(0), LONGEST
        while (start.t + of(tau)).low <= end.high:
            try:
                x, v, since = flight.on_step(tau, h)
            except NotProvenError:
                h /= 2
                if h < SHORTEST:
                    return False
                continue
            inside = (since if tau == 0 else x - self.at) * self.off
            speed = -self.r * v * self.off
            if inside.low <= 0 and speed.high >= self.slow:
                if h > FINEST_STEP or tau == 0:
                    h /= 2
                    if h < SHORTEST:
                        return False
                    continue
                left = Interval(max(speed.low, self.slow), min(speed.high, self.fast))
                if left.low <= left.high:
                    state = State(start.t + of(tau, tau + h), self.at, left * self.off)
                    if not self.comes_to_nothing(state, k + 1, begin):
                        return False
                if ((flight.at(of(tau + h))[0] - self.at) * self.off).high < 0:
                    return True
            tau, h = tau + h, min(2 * h, LONGEST)
        return True


def proven_list(law: Law, claims: Any) -> str:
    """Prove that all orbits with some impacts in some periods are those of a list."""
    n, p, (slow, fast), cycle = (claims[key] for key in ("impacts", "periods", "speeds", "cycle"))
    if len(law.bounds) != 1 or law.bounds[0].restitution is None:
        raise NotProvenError("a list is checked for one wall and no other stop")
    if max(n, p) > MOST_RETURNS:
        raise NotProvenError(
            f"a list of more than {MOST_RETURNS} impacts or periods is not checked"
        )
    if n < 1 or p < 1 or not 0 < slow < fast or not 0 <= cycle[0] < cycle[1] <= 1:
        raise NotProvenError("the region of a list is empty, or reaches to speed 0")
    if any(it[key][0] >= it[key][1] for it in claims["boxes"] for key in ("cycle", "v")):
        raise NotProvenError("a box of the list is empty")
    returns = Returns(law, n, p, (slow, fast))
    said, events = [], []
    for orbit in claims["orbits"]:
        said.append(proven_orbit(law, orbit))
        rounds = Fraction(n, len(orbit["events"]))
        if rounds.denominator != 1 or rounds * orbit["periods"] != p:
            raise NotProvenError("an orbit has not the impacts and periods of the list")
        events += [(of(*event["t"]), of(*event["v"])) for event in orbit["events"]]
    _check_different(law, claims["orbits"])
    known = [returns.box(it["cycle"], it["v"]) for it in claims["boxes"]]
    for box in known:
        if not any(_holds_state(box, event, returns.period) for event in events) and not (
            returns.is_left_at(returns.zero(box))
        ):
            raise NotProvenError(f"the box at t = {_told(box.t.fractions()[0])} may hold an orbit")
        returns.zero(box)
    n_boxes = _check_region(returns, known, (cycle, (slow, fast)))
    head = (
        f"Whatever periodic motion meets the wall with {_counted(n, 'impact')} in "
        f"{_counted(p, 'period')} of the force, all of which it leaves with speeds of {slow} to {fast}, "
        f"one of them at a t over the period, modulo 1, between {cycle[0]} and {cycle[1]}, is among "
        f"{_counted(len(said), 'orbit')} (proven on {_counted(n_boxes, 'box', 'boxes')} of the region)"
    )
    return "\n".join([f"{head}{':' if said else ': there is none.'}", *said])


def _counted(n: int, one: str, several: str = "") -> str:
    return f"{n} {one if n == 1 else several or one + 's'}"


def _holds_state(box: State, state: tuple[Interval, Interval], period: Interval) -> bool:
    """Return whether a state lies in a box, whole periods earlier or later."""
    t, v = state
    turns = round(Fraction(box.t.middle().low - t.middle().low, period.low))
    return box.t.holds(t + turns * period) and box.v.holds(v)


def _check_region(returns: Returns, known: Sequence[State], region: Any) -> int:
    """Prove that a region has no motion sought but those of the known boxes; count the boxes."""
    stack, n_boxes = [region], 0
    whole = [side[1] - side[0] for side in region]
    while stack:
        cycle, v = stack.pop()
        n_boxes += 1
        box = returns.box(cycle, v)
        if any(_holds_state(one, (box.t, box.v), returns.period) for one in known):
            continue
        if returns.excludes(box):
            continue
        parts = [(side[1] - side[0]) / size for side, size in zip((cycle, v), whole, strict=True)]
        if max(parts) < SMALLEST_BOX:
            raise NotProvenError(
                f"at t / period = {_told(cycle[0])}, speed {_told(v[0])} an orbit may be missing"
            )
        middle = sum(cycle) / 2, sum(v) / 2
        if parts[0] >= parts[1]:
            stack += [((cycle[0], middle[0]), v), ((middle[0], cycle[1]), v)]
        else:
            stack += [(cycle, (v[0], middle[1])), (cycle, (middle[1], v[1]))]
    return n_boxes


class Carried(NamedTuple):
    """A set after an event: all of it lies in image + derivative spread, if 0 belongs to the spread."""

    event: Event
    image: Pair
    derivative: Matrix


def carried(
    law: Law,
    number: int,
    departed: int | None,
    middle: State,
    axes: Matrix,
    spread: Pair,
    settling: int | None = None,
) -> Iterator[Carried]:
    """Yield the events of all motions from the states middle + axes spread, the same for all.

    The states are t and v after an event at a bound or, where there was none, x and v at one instant.
    By the mean value theorem, with the derivatives on all of the set. It ends where all motions are
    proven to meet no bound any more in region ``settling``, or after the most events.
    """
    total, whole, point = axes, _around(middle, departed, applied(axes, spread)), middle
    for _ in range(MOST_EVENTS):
        landing = Flight(law, number, whole).landing(departed, may_settle=number == settling)
        if landing is None:
            return
        event = met(law, number, whole, departed, landing)
        alone = met(law, number, point, departed, (*landing[:2], *event.tau.fractions()))
        total = product(event.derivative, total)
        image = alone.t, alone.v
        yield Carried(event, image, total)
        near = applied(total, spread)
        t, v = (_both(x, p + d) for x, p, d in zip((event.t, event.v), image, near, strict=True))
        at = of(law.bounds[event.bound].at)
        whole, point = State(t, at, v), after(law, alone)
        number, departed = event.region, event.bound
    raise NotProvenError("the motions have not settled")


def _around(middle: State, departed: int | None, by: Pair) -> State:
    first, dv = by
    if departed is None:
        return State(middle.t, middle.x + first, middle.v + dv)
    return State(middle.t + first, middle.x, middle.v + dv)


def _both(one: Interval, other: Interval) -> Interval:
    """Return what is in both of two intervals that have a point in common."""
    return Interval(max(one.low, other.low), min(one.high, other.high))


class Trap(NamedTuple):
    """The states z + E w, abs(w) < 1, after events of a kind: z, in a box, is an event of an orbit."""

    bound: int
    region: int
    z: Pair
    inverse: Matrix

    def holds(self, law: Law, found: Carried, spread: Pair) -> bool:
        """Return whether all of a set lies inside, whole periods later or not."""
        event, (t, v), _ = found
        if (event.bound, event.region) != (self.bound, self.region):
            return False
        period = law.period()
        turns = round(Fraction(t.low - self.z[0].low, period.low))
        c, d = applied(self.inverse, (t - turns * period - self.z[0], v - self.z[1]))
        (e, f), (g, h) = product(self.inverse, found.derivative)
        # The norm is convex: it is largest at a corner.
        corners = [(p, q) for p in _ends(spread[0]) for q in _ends(spread[1])]
        norms = [_squared(c + e * p + f * q) + _squared(d + g * p + h * q) for p, q in corners]
        return all(norm.high < 1 << BITS for norm in norms)


def _ends(value: Interval) -> tuple[Interval, Interval]:
    return Interval(value.low, value.low), Interval(value.high, value.high)


def _squared(value: Interval) -> Interval:
    return Interval(0, (value * value).high)


Rectangle = tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]


def on_parts(whole: Rectangle, holds: Callable[[Rectangle], bool], said: str) -> int:
    """Prove what is to hold on all parts of a rectangle, smaller where need be; count them."""
    parts, done = [whole], 0
    least = (whole[0][1] - whole[0][0]) * SMALLEST_PART
    while parts:
        part = parts.pop()
        with suppress(NotProvenError):
            if holds(part):
                done += 1
                continue
        (a, b), (c, d) = part
        if b - a < least:
            raise NotProvenError(f"{said}, at {_told((a + b) / 2)}, {_told((c + d) / 2)}")
        x, y = (a + b) / 2, (c + d) / 2
        parts += [(first, second) for first in ((a, x), (x, b)) for second in ((c, y), (y, d))]
    return done


def _middle(part: Rectangle) -> tuple[Pair, Pair]:
    """Return the middle of a rectangle, and all vectors from there to its points."""
    (a, b), (c, d) = part
    x, y = (of((low - high) / 2, (high - low) / 2) for low, high in part)
    return (of((a + b) / 2), of((c + d) / 2)), (x, y)


def trap_of(law: Law, orbit: Any, claim: Any) -> Trap:
    """Return a set about an event of a proven orbit from which all motions approach the orbit.

    On parts of a parallelogram about the innermost ellipse the derivative of the map from an event to
    the same one some rounds of the orbit later makes all vectors shorter, by the norm of the ellipse.
    From each stage, a multiple of it, all motions come into the one before.
    """
    if claim["event"] >= len(orbit["events"]) or claim["rounds"] < 1:
        raise NotProvenError("a trap has no event of its orbit, or no rounds")
    event, ((a, b), (c, d)) = orbit["events"][claim["event"]], claim["axes"]
    kind, size = (event["bound"], event["region"]), a * d - b * c
    if size == 0:
        raise NotProvenError("the axes of a trap are parallel")
    axes = (of(a), of(b)), (of(c), of(d))
    inverse = (of(d / size), of(-b / size)), (of(-c / size), of(a / size))
    trap = Trap(*kind, (of(*event["t"]), of(*event["v"])), inverse)
    n = claim["rounds"] * sum((it["bound"], it["region"]) == kind for it in orbit["events"])
    middle = trap.z[0].middle(), trap.z[1].middle()
    off = applied(inverse, (trap.z[0] - middle[0], trap.z[1] - middle[1]))

    def carried_from(part: Rectangle, by: Matrix) -> tuple[Iterator[Carried], Pair]:
        center, spread = _middle(part)
        t, v = (p + q for p, q in zip(middle, applied(by, center), strict=True))
        start = departing(law, kind[1], kind[0], (t, v))
        return carried(law, kind[1], kind[0], start, by, spread), spread

    def shrinks(part: Rectangle) -> bool:
        of_kind = (
            found for found in carried_from(part, axes)[0]
            if (found.event.bound, found.event.region) == kind
        )  # fmt: skip
        (p, q), (r, s) = product(inverse, next(islice(of_kind, n - 1, None)).derivative)
        # Both singular values of a matrix are below 1 if (1 - s^2)(1 - S^2) > 0 and s S < 1.
        size, det = p * p + q * q + r * r + s * s, p * s - q * r
        least = det.least * det.least >> BITS
        return bool(size.high < (1 << BITS) + least and det.size < 1 << BITS)

    # The ellipse is about z, which is not the middle of its box.
    reach = 1 + Fraction(off[0].size + off[1].size, 1 << BITS)
    whole = ((-reach, reach), (-reach, reach))
    on_parts(whole, shrinks, "a trap is not proven to be mapped into itself")
    for stage in claim["stages"]:
        if stage < 1:
            raise NotProvenError(f"a stage of {stage} of a trap is below 1")
        wider = tuple((stage * p, stage * q) for p, q in axes)
        inner = trap

        def comes_in(part: Rectangle, by: Any = wider, inner: Trap = inner) -> bool:
            nearest = (max(low, -high, Fraction(0)) for low, high in part)
            if sum(x * x for x in nearest) > reach * reach:
                return True
            motions, spread = carried_from(part, by)
            return any(inner.holds(law, found, spread) for found in motions)

        on_parts(whole, comes_in, f"from stage {stage} of a trap motions are not proven to come in")
        (p, q), (r, s) = inverse
        trap = trap._replace(inverse=((p / stage, q / stage), (r / stage, s / stage)))
    return trap


def proven_basins(law: Law, claims: Any) -> str:
    """Prove of rectangles of starts that all motions from them approach the orbit that is claimed."""
    cells, orbits, steady = claims["cells"], claims["orbits"], claims["steady"]
    if not cells:
        raise NotProvenError("no cell is claimed")
    for it in cells:
        if it["x"][0] >= it["x"][1] or it["v"][0] >= it["v"][1]:
            raise NotProvenError(f"{_cell_said(it)} has no area")
        if it["to"] >= len(orbits) + len(steady):
            raise NotProvenError(f"{_cell_said(it)} goes to an orbit that is not there")
    _check_disjoint(cells)
    said = [proven_orbit(law, it["orbit"]) for it in orbits]
    _check_different(law, [it["orbit"] for it in orbits])
    for number in steady:
        if number >= len(law.regions) or steady.count(number) > 1:
            raise NotProvenError(f"region {number} is none, or stands twice")
        region = law.regions[number]
        if region.stiffness <= 0 or region.damping <= 0:
            raise NotProvenError(f"in region {number} motions do not decay")
        said.append(f"The motion in region {number} that repeats itself and meets no stop.")
    with bits(SET_BITS):
        traps = [[trap_of(law, it["orbit"], trap) for trap in it["traps"]] for it in orbits]
        fates: list[Any] = [*traps, *steady]
        n_parts = sum(_check_cell(law, claims["t"], it, fates[it["to"]]) for it in cells)
    areas = [Fraction(0)] * len(fates)
    for it in cells:
        (a, b), (c, d) = it["x"], it["v"]
        areas[it["to"]] += (b - a) * (d - c)
    head = (
        f"From all starts at t = {_phase(claims['t'])} in {_counted(len(cells), 'rectangle')} of the "
        f"plane of x and v, which share no area, motions approach the orbits that are said, whole periods "
        f"of the force later or not (proven on {_counted(n_parts, 'part')} of the rectangles). Nothing is "
        f"claimed of other starts."
    )
    lines = [head]
    for k, (orbit, area) in enumerate(zip(said, areas, strict=True)):
        own = [it for it in cells if it["to"] == k]
        if own:
            (a, b), (c, d) = (
                (_told(min(it[key][0] for it in own)), _told(max(it[key][1] for it in own)))
                for key in "xv"
            )
            lines.append(
                f"Orbit {k}: {orbit}\n  {_counted(len(own), 'rectangle')} with an area of {_told(area)}, "
                f"rounded down, from x = {a} to {b} and v = {c} to {d}, about, go to orbit {k}."
            )
    return "\n".join(lines)


def _cell_said(cell: Any) -> str:
    return f"the rectangle at x = {_told(cell['x'][0])}, v = {_told(cell['v'][0])}"


def _check_disjoint(cells: Sequence[Any]) -> None:
    open_ones: list[Any] = []
    for cell in sorted(cells, key=lambda it: it["x"][0]):
        open_ones = [it for it in open_ones if it["x"][1] > cell["x"][0]]
        for it in open_ones:
            if it["v"][0] < cell["v"][1] and cell["v"][0] < it["v"][1]:
                raise NotProvenError(f"{_cell_said(cell)} overlaps another one")
        open_ones.append(cell)


def _check_different(law: Law, orbits: Sequence[Any]) -> None:
    """Prove that no two orbits are one, whole periods later or not: one has an event of its own."""
    states = [[(of(*it["t"]), of(*it["v"])) for it in orbit["events"]] for orbit in orbits]
    for i, first in enumerate(states):
        for j in range(i):
            if any(_may_be_one(law.period(), first[0], other) for other in states[j]):
                raise NotProvenError(f"orbits {j} and {i} may be one")


def _may_be_one(period: Interval, one: Pair, other: Pair) -> bool:
    """Return whether two events may be the same, whole periods apart."""
    t, v = one[0] - other[0], one[1] - other[1]
    n = round(Fraction(t.low, period.low))
    is_wide = 2 * (one[0].width + other[0].width) > period.low
    return v.least == 0 and (is_wide or any((t - k * period).least == 0 for k in (n - 1, n, n + 1)))


def _check_cell(law: Law, instant: Any, cell: Any, fate: Any) -> int:
    """Prove where all motions from a rectangle go, by parts of it; count these."""
    (low, high), t = cell["x"], angle(instant)
    ends = [(law.bounds[i].at if i is not None else None) for it in law.regions for i in it[3:]]
    number = next(
        (
            k for k, (lower, upper) in enumerate(zip(ends[::2], ends[1::2], strict=True))
            if (lower is None or lower < low) and (upper is None or high < upper)
        ),
        None,
    )  # fmt: skip
    if number is None:
        raise NotProvenError(f"{_cell_said(cell)} lies on a stop or beyond a wall")
    region, is_steady = number, isinstance(fate, int)
    axes = (of(1), of(0)), (of(0), of(1))

    def goes_there(part: Rectangle) -> bool:
        (x, v), spread = _middle(part)
        settling = fate if is_steady else None
        motions = carried(law, region, None, State(t, x, v), axes, spread, settling)
        if is_steady:
            # They end where all motions settle.
            return all(True for _ in motions)
        return any(trap.holds(law, found, spread) for found in motions for trap in fate)

    said = f"the starts of {_cell_said(cell)} are not proven to go where it says"
    return on_parts((cell["x"], cell["v"]), goes_there, said)


class Set(NamedTuple):
    """A parallelogram of (t, v): center +- unstable +- stable."""

    center: tuple[Fraction, Fraction]
    unstable: tuple[Fraction, Fraction]
    stable: tuple[Fraction, Fraction]

    def box(
        self, u: tuple[Fraction, Fraction], s: tuple[Fraction, Fraction]
    ) -> tuple[Interval, Interval]:
        """Return the (t, v) of all points whose coordinates lie between two each."""
        t, v = (
            of(self.center[i]) + of(*u) * of(self.unstable[i]) + of(*s) * of(self.stable[i])
            for i in range(2)
        )
        return t, v

    def coordinates(self) -> Matrix:
        (a, c), (b, d) = self.unstable, self.stable
        size = a * d - b * c
        if size == 0:
            raise NotProvenError("the sides of a set are parallel")
        return (of(d / size), of(-b / size)), (of(-c / size), of(a / size))

    def axes(self) -> Matrix:
        (a, c), (b, d) = self.unstable, self.stable
        return (of(a), of(b)), (of(c), of(d))

    def reach(self, i: int) -> Fraction:
        return abs(self.unstable[i]) + abs(self.stable[i])


def proven_chaos(law: Law, text: Any) -> str:
    """Prove covering relations, that the sets are disjoint, and the growth of the number of walks."""
    sets, transitions = [Set(**it) for it in text["sets"]], text["transitions"]
    bound, number, growth, period = text["bound"], text["region"], text["growth"], law.period()
    for i, first in enumerate(sets):
        if 2 * first.reach(0) * (1 << BITS) >= period.low:
            raise NotProvenError(f"set {i} is longer than a period")
        with _told_of(f"of set {i}"):
            first.coordinates()
        for j in range(i):
            with _told_of(f"sets {j} and {i} are not proven to be apart"):
                if not _are_apart(period, sets[j], first):
                    raise NotProvenError("they may have points in common")
    if not sets or any(max(it["from"], it["to"]) >= len(sets) for it in transitions):
        raise NotProvenError(f"there are no sets, or a transition leads beyond the {len(sets)}")
    if growth <= 1:
        raise NotProvenError(f"a growth of {growth} is no chaos")
    _check_growth(len(sets), {(it["from"], it["to"]) for it in transitions}, growth)
    entropy = _logarithm(growth)
    if entropy == 0:
        raise NotProvenError(f"a growth of {_told(growth)} a step is too little to be told")
    for it in transitions:
        with _told_of(f"from set {it['from']} to set {it['to']}"):
            _check_covering(law, bound, number, sets, it)
    return (
        f"The map from one departure from bound {bound} into region {number} to the next, with t modulo "
        f"the period of the force, {2 / law.base} pi, is chaotic: for every endless walk along the "
        f"{len(transitions)} transitions between the {len(sets)} sets of the certificate, which are "
        f"disjoint, there is a motion that visits the sets in its order, and for every closed walk one "
        f"that is periodic. The topological entropy of the map on these motions is at least "
        f"{_told(entropy)} an impact."
    )


@contextmanager
def _told_of(what: str) -> Iterator[None]:
    """Say of what it is that something is not proven."""
    try:
        yield
    except NotProvenError as error:
        raise NotProvenError(f"{what}: {error}") from None


def _are_apart(period: Interval, one: Set, other: Set) -> bool:
    reach, distance = one.reach(0) + other.reach(0), one.center[0] - other.center[0]
    # Whole periods by which the instants of the other one may be moved to some of the first.
    (low, _), (_, high) = ((of(distance + by) / period).fractions() for by in (-reach, reach))
    first, last = ceil(low), floor(high)
    # Each is shorter than a period, so more are of a distance that is not known well.
    return last - first < 3 and all(
        _are_apart_by(one, other, n * period) for n in range(first, last + 1)
    )


def _are_apart_by(one: Set, other: Set, shift: Interval) -> bool:
    unit = 1 << BITS
    for a, b, sign in ((one, other, 1), (other, one, -1)):
        t = of(b.center[0] - a.center[0]) + sign * shift
        v = of(b.center[1] - a.center[1])
        to_a = a.coordinates()
        axes = product(to_a, b.axes())
        for k in range(2):
            middle = to_a[k][0] * t + to_a[k][1] * v
            if middle.least > unit + axes[k][0].size + axes[k][1].size:
                return True
    return False


def _check_covering(law: Law, bound: int, number: int, sets: Sequence[Set], claim: Any) -> None:
    """Prove that the image of a strip of one set lies across another."""
    first, second, at, half = sets[claim["from"]], sets[claim["to"]], claim["at"], claim["half"]
    if not (half > 0 and abs(at) + half <= 1):
        raise NotProvenError("the strip is not in its set")
    shift = claim["turns"] * law.period()
    to_second = second.coordinates()
    image, _ = _image(law, bound, number, first.box((at, at), (Fraction(0), Fraction(0))))
    t, v = image.t - shift - of(second.center[0]), image.v - of(second.center[1])
    u, s = (row[0] * t + row[1] * v for row in to_second)
    axes = product(first.axes(), ((of(half), of(0)), (of(0), of(1))))
    unit = 1 << BITS
    for narrow in NARROW:
        parts = [
            product(to_second, product(derivative, axes))
            for derivative in _derivatives(law, bound, number, first, (at, half), narrow)
        ]
        (u_by_u, u_by_s), (s_by_u, s_by_s) = (
            tuple(_hull([part[i][j] for part in parts]) for j in range(2)) for i in range(2)
        )
        # The unstable sides are carried to u +- u_by_u, and some way beside.
        beyond = u_by_u.least - u.size - u_by_s.size
        within = s.size + s_by_u.size + s_by_s.size
        if beyond > unit and within < unit:
            return
        if s.least >= unit or u_by_u.size <= unit + u.least:
            # No parts are small enough.
            break
    raise NotProvenError(
        f"the image reaches {_told(Fraction(beyond, unit))} along and "
        f"{_told(Fraction(within, unit))} across, which should be above and below 1"
    )


def _hull(values: Sequence[Interval]) -> Interval:
    return Interval(min(value.low for value in values), max(value.high for value in values))


def _image(
    law: Law, bound: int, number: int, box: tuple[Interval, Interval]
) -> tuple[Event, Matrix]:
    """Return the next event of the same kind, and the derivative of the map."""
    state, region, departed = departing(law, number, bound, box), number, bound
    total: Matrix | None = None
    for _ in range(64):
        event = met(law, region, state, departed)
        total = event.derivative if total is None else product(event.derivative, total)
        if event.bound == bound and event.region == number:
            return event, total
        state, region, departed = after(law, event), event.region, event.bound
    raise NotProvenError("64 events at other stops before the next one of the map")


def _derivatives(
    law: Law,
    bound: int,
    number: int,
    first: Set,
    strip: tuple[Fraction, Fraction],
    narrow: Fraction,
) -> Iterator[Matrix]:
    """Yield derivatives of the map that hold on parts of a strip, which together are all of it."""
    at, half = strip
    parts = [((at - half, at + half), (Fraction(-1), Fraction(1)))]
    n = 0
    while parts:
        u, s = parts.pop()
        n += 1
        try:
            _, derivative = _image(law, bound, number, first.box(u, s))
            entries = [entry for row in derivative for entry in row]
            wide = max(e.width for e in entries) > narrow * max(e.size for e in entries)
            if not wide or n + len(parts) > PARTS:
                yield derivative
                continue
        except NotProvenError:
            if n + len(parts) > PARTS:
                raise
        lengths = [
            (ends[1] - ends[0]) * max(abs(e) for e in axis)
            for ends, axis in ((u, first.unstable), (s, first.stable))
        ]
        if lengths[0] >= lengths[1]:
            middle = (u[0] + u[1]) / 2
            parts += [((u[0], middle), s), ((middle, u[1]), s)]
        else:
            middle = (s[0] + s[1]) / 2
            parts += [(u, (s[0], middle)), (u, (middle, s[1]))]


def _check_growth(n: int, transitions: set[tuple[int, int]], growth: Fraction) -> None:
    """Prove that the walks of k steps grow as growth^k at least.

    A vector y >= 0, not 0, with A y >= growth y for the matrix A of the graph gives that (Collatz and
    Wielandt); one is made by many steps from (1, ..., 1) with rounding, which the check forgives.
    """
    following: list[list[int]] = [[] for _ in range(n)]
    for i, j in transitions:
        following[i].append(j)
    y = [1 << 200] * n
    for _ in range(4000):
        moved = [sum(y[j] for j in row) + y[i] for i, row in enumerate(following)]
        top = max(moved)
        y = [(value << 200) // top for value in moved]
    if any(sum(y[j] for j in row) < growth * y[i] for i, row in enumerate(following)):
        raise NotProvenError(f"the walks are not proven to grow by {_told(growth)} a step")


def _logarithm(value: Fraction) -> Fraction:
    """Return a number, of six decimals, not above the natural logarithm."""
    low, high = 0, 10**6 * ceil(value).bit_length()
    while high - low > 1:
        middle = (low + high) // 2
        fits = exponential(of(Fraction(middle, 10**6))).high <= of(value).low
        low, high = (middle, high) if fits else (low, middle)
    return Fraction(low, 10**6)


def _told(value: Fraction, digits: int = 9) -> str:
    """Return a number with some digits, rounded down."""
    sign, whole = ("-", -value) if value < 0 else ("", value)
    if whole >= 10**DIGITS:
        return f"{sign}10^{DIGITS} and more"
    number, unit = floor(whole * 10**digits), 10**digits
    return f"{sign}{number // unit}.{number % unit:0{digits}d}".rstrip("0").rstrip(".")


def _near(pair: tuple[Fraction, Fraction]) -> str:
    """Return two numbers with as many digits as tell them apart."""
    digits = max(9, len(str(ceil(1 / (pair[1] - pair[0]))))) if pair[0] < pair[1] else 9
    return f"{_told(pair[0], digits)}... and {_told(pair[1], digits)}..."


def _phase(pair: tuple[Fraction, Fraction]) -> str:
    times, plus = pair
    return f"{times} pi + {plus}" if times else str(plus)


def equation(law: Any) -> str:
    """Return what moves, in words."""
    force = " + ".join(
        f"{_said(tone['amplitude'])} cos({_said(tone['omega'])} t + {_phase(tone['phase'])})"
        for tone in law["tones"]
    )
    lines, bounds = [], law["bounds"]
    for region in law["regions"]:
        low = "-oo" if region["lower"] is None else _said(bounds[region["lower"]]["at"])
        high = "oo" if region["upper"] is None else _said(bounds[region["upper"]]["at"])
        drag = _said(region["damping"], 2)
        spring, constant = _said(region["stiffness"]), _said(region["constant"])
        lines.append(
            f"  for {low} < x < {high}: x'' + {drag} x' + {spring} x = "
            f"{constant}{f' + {force}' if force else ''}"
        )
    for i, bound in enumerate(bounds):
        if bound["restitution"] is not None:
            r = _said(bound["restitution"])
            lines.append(f"  at x = {_said(bound['at'])} (bound {i}): x' becomes -{r} x'")
    return "\n".join(lines)


def _said(number: Any, times: int = 1) -> str:
    if not isinstance(number, tuple):
        return str(times * number)
    a, b = (times * part for part in number)
    return "p" if (a, b) == (0, 1) else f"({a} + {b} p)"


KINDS: dict[str, Callable[[Any, Any], str]] = {
    "run": proven_run,
    "orbit": proven_orbit,
    "branch": proven_branch,
    "list": proven_list,
    "basins": proven_basins,
    "chaos": proven_chaos,
}


def theorem(text: str) -> str:
    """Return the theorem of a certificate, proven; NotProvenError says why it is not."""
    try:
        certificate = json.loads(text, object_pairs_hook=_without_twice)
        version, kind = certificate["certificate"], certificate["kind"]
        if read(version, "n") != VERSION:
            raise NotProvenError(
                f"a certificate of version {version!r}; this program checks version {VERSION}"
            )
        if kind not in KINDS:
            raise NotProvenError(
                f"a certificate of {kind!r}; this program checks {', '.join(KINDS)}"
            )
        form = {"certificate": "n", "kind": "w", "law": LAW} | FORMS[kind]
        claims = read(certificate, form)
    except (ValueError, TypeError, KeyError, ZeroDivisionError, RecursionError) as error:
        raise NotProvenError(f"no certificate, or one cut off or changed: {error!r}") from None
    # The law of a branch is another one at each parameter.
    law = None if kind == "branch" else law_of(claims["law"])
    # A run has nothing to do with a period.
    if law is not None and kind != "run":
        check_period(law)
    Work.states = 0
    try:
        proven = KINDS[kind](law, claims)
    except TooLongError:
        raise NotProvenError(f"not within {MOST_STATES} states of flights") from None
    return f"{proven}\nWhat moves:\n{equation(claims['law'])}"


def main(arguments: Sequence[str]) -> int:
    if len(arguments) != 1:
        print("python check_certificate.py certificate.json", file=sys.stderr)
        return 2
    try:
        print(f"PROVEN. {theorem(Path(arguments[0]).read_text(encoding='utf-8'))}")
    except (OSError, UnicodeDecodeError, NotProvenError) as error:
        print(f"NOT PROVEN: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
