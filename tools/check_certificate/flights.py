"""Flights between stops, and the event that comes first.

Proven here: between two stops, where x'' + 2 a x' + K x = c + sum of A cos(w t + p), all motions
from a box of states meet the same bound first and within the time that is found, and after it are
in a box with a derivative. Why that suffices is sections 11.3 (a flight) and 11.4 (the first event)
of docs/theory/certified.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import isqrt
from typing import Any, NamedTuple, TypeVar, cast

import arithmetic
from arithmetic import (
    Interval,
    Matrix,
    NotProvenError,
    Pair,
    angle,
    bits,
    cosine_and_sine,
    cosine_series,
    dual,
    exponential,
    of,
    pi,
    unit,
)
from words import told

T = TypeVar("T")

# Bits that suffice to tell which event comes next.
COARSE = 128
# The first step of a flight under a law without a spring, a dashpot and waves, and the part of a
# first step, or of this one if that is longer, that no step is shorter than: what then remains open
# is a graze, or an interval too wide.
FIRST, SHORTEST = Fraction(1, 2), Fraction(1, 2**39)
# The shortest step of a set of states, as a part of its width.
FINE = Fraction(1, 256)
# The most steps of a flight, those included that are too long.
MOST_STEPS = 10**4
# States of flights that a proof may compute, those of many bits counted several times: some hours.
MOST_STATES = 10**8


class TooLongError(Exception):
    """A proof takes more than is tried, which smaller parts would not change."""


class Work:
    """States of flights that have been computed."""

    states = 0

    @classmethod
    def goes_on(cls) -> None:
        cls.states += max(1, arithmetic.BITS // COARSE)
        if cls.states > MOST_STATES:
            raise TooLongError(f"not within {MOST_STATES} states of flights")


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


class Steps(NamedTuple):
    """The first step of a flight that is tried, the shortest one, and the longest."""

    first: Fraction
    shortest: Fraction
    longest: Fraction


class Numbers(NamedTuple):
    """The numbers of a region as intervals: K, a, c, K - a^2, and its bounds with -1 below, 1 above.

    At rest x is c/K; without a spring it drifts by c/2a a unit of time or, without damping, by c
    t/2. Of each tone its frequency, amplitude and phase, and the p and q of the motion p cos + q
    sin under it: None at resonance.
    """

    k: Any
    a: Any
    c: Any
    square: Any
    drift: Any
    sides: list[tuple[int, int, Any]]
    tones: list[tuple[Any, Any, Any, tuple[Any, Any] | None]]
    steps: Steps


@dataclass
class Law:
    """What moves, of unit mass: regions from below to above, the places between them, and the force."""

    regions: tuple[Region, ...]
    bounds: tuple[Bound, ...]
    tones: tuple[Tone, ...]
    # The period of the force is 2 pi over this.
    base: Any
    # The same with dual numbers, where derivatives by the parameter are asked for.
    dual: Law | None = None
    # `numbers` of a region with some bits.
    known: dict[tuple[int, int], Numbers] = field(default_factory=dict)

    def numbers(self, number: int) -> Numbers:
        if (number, arithmetic.BITS) not in self.known:
            self.known[number, arithmetic.BITS] = self._numbers(number)
        return self.known[number, arithmetic.BITS]

    def _numbers(self, number: int) -> Numbers:
        k, a, c, *_ = self.regions[number]
        tones = []
        for w, amplitude, phase in self.tones:
            first, second = k - w * w, 2 * a * w
            size = first * first + second * second
            wave = None
            if size != 0:
                wave = of(amplitude * first / size), of(amplitude * second / size)
            tones.append((of(w), of(amplitude), angle(phase), wave))
        sides = [(bound, sign, of(self.bounds[bound].at)) for bound, sign in self.sides(number)]
        drift = of(c / k if k != 0 else c / (2 * a) if a != 0 else c / 2)
        steps = _steps(of(k), [of(a), *(w for w, *_ in tones)])
        return Numbers(of(k), of(a), of(c), of(k - a * a), drift, sides, tones, steps)

    def period(self) -> Any:
        if self.base is None:
            raise NotProvenError("the force has no period")
        return 2 * pi() / self.base

    def sides(self, number: int) -> list[tuple[int, int]]:
        """Return the bounds of a region, and -1 for the lower and 1 for the upper one."""
        _, _, _, lower, upper = self.regions[number]
        return [(bound, sign) for bound, sign in ((lower, -1), (upper, 1)) if bound is not None]

    def rebound(self, number: int, bound: int, side: int) -> tuple[Any, int]:
        """Return what a bound keeps of a velocity, and the region after it."""
        restitution = self.bounds[bound].restitution
        return (1, number + side) if restitution is None else (of(-restitution), number)


def _steps(k: Any, rates: Sequence[Any]) -> Steps:
    """Return steps as long as sqrt K and some frequencies and rates ask for, in any unit of time.

    The longest is 1 to 2 over the fastest of them. It is only tried first: a step is halved until
    it proves something.
    """
    fastest = max(
        isqrt(dual(k).value.size << arithmetic.BITS), *(dual(rate).value.size for rate in rates)
    )
    longest = Fraction(2) ** (arithmetic.BITS + 1 - fastest.bit_length())
    first = longest if fastest else FIRST
    return Steps(first, min(first, FIRST) * SHORTEST, longest)


class State(NamedTuple):
    """Instants, places and velocities of motions that begin a flight."""

    t: Interval
    x: Any
    v: Interval


class Landing(NamedTuple):
    """A bound, its side, and between which tau it is passed."""

    bound: int
    side: int
    low: Fraction
    high: Fraction


def once(function: Callable[[Any, Interval], T]) -> Callable[[Any, Interval], T]:
    """Compute a function of tau once for each flight."""

    def remembered(self: Any, tau: Interval) -> T:
        key = function.__name__, tau
        if key not in self.known:
            self.known[key] = function(self, tau)
        return cast("T", self.known[key])

    return remembered


class Flight:
    """The motion in one region from states; tau is the time since the start."""

    def __init__(self, law: Law, number: int, start: State) -> None:
        self.law, self.number, self.start = law, number, start
        self.region = law.regions[number]
        self.numbers = law.numbers(number)
        self.known: dict[tuple[str, Interval], Any] = {}
        p, q = self._particular(of(0))
        self.free = start.x - p, start.v - q

    @once
    def cycles(self, tau: Interval) -> list[tuple[Any, Any]]:
        """Return cos and sin of the tones."""
        t = self.start.t + tau
        return [cosine_and_sine(w * t + phase) for w, _, phase, _ in self.numbers.tones]

    def _particular(self, tau: Interval) -> tuple[Any, Any]:
        """Return a motion under the force, and its velocity."""
        x, v = self.numbers.drift, of(0)
        if self.region.stiffness == 0:
            x, v = (x * tau, x) if self.region.damping != 0 else (x * tau * tau, 2 * x * tau)
        for tone, (cos, sin) in zip(self.numbers.tones, self.cycles(tau), strict=True):
            w, amplitude, _, wave = tone
            if wave is not None:
                p, q = wave
                x, v = x + p * cos + q * sin, v + w * (q * cos - p * sin)
            else:
                p = amplitude / (2 * w)
                x, v = x + p * tau * sin, v + p * (sin + w * tau * cos)
        return x, v

    @once
    def response(self, tau: Interval) -> tuple[Any, Any, Any, Any]:
        """Return x and v of free motion from (1, 0) and from (0, 1)."""
        k, a, _, square, *_ = self.numbers
        c, s = cosine_series(-(square * tau * tau))
        s = tau * s
        if self.region.damping == 0:
            return c, -(k * s), s, c
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

    @once
    def at(self, tau: Interval) -> tuple[Any, Any]:
        """Return x and v."""
        Work.goes_on()
        x_x, v_x, x_v, v_v = self.response(tau)
        x, v = self._particular(tau)
        p, q = self.free
        return x + p * x_x + q * x_v, v + p * v_x + q * v_v

    def force(self, tau: Interval) -> Any:
        force = self.numbers.c
        for (_, amplitude, *_), (cos, _) in zip(self.numbers.tones, self.cycles(tau), strict=True):
            force = force + amplitude * cos
        return force

    def acceleration(self, force: Interval, x: Interval, v: Interval) -> Any:
        return force - self.numbers.k * x - 2 * (self.numbers.a * v)

    def on_step(self, begin: Fraction, h: Fraction) -> tuple[Interval, Interval, Interval]:
        """Return x and v on a step, and what has the sign of x(s) - x(begin).

        That is the mean velocity since then. Where the velocity was 0, or had the sign of the mean
        acceleration, it is that.
        By Taylor's theorem, with x and v on all of the step in intervals that Picard's operator
        maps into themselves, and therefore hold the motion.
        """
        Work.goes_on()
        since, force = of(0, h), self.force(of(begin, begin + h))
        first_x, first_v = x, v = self.at(of(begin)) if begin else (self.start.x, self.start.v)
        for _ in range(12):
            a = self.acceleration(force, x, v)
            next_x, next_v = first_x + since * v, first_v + since * a
            if x.holds(next_x) and v.holds(next_v):
                mean = first_v + of(0, h / 2) * a
                sure = (first_v.low == 0 or a.high < 0) and (first_v.high == 0 or a.low > 0)
                return first_x + since * mean, next_v, a if sure else mean
            x, v = next_x.wider(), next_v.wider()
        raise NotProvenError("a step is too long")

    def landing(
        self, departed: int | None, *, may_settle: bool = False, until: Fraction | None = None
    ) -> Landing | None:
        """Return where all motions first meet a bound.

        On each step before, x keeps off both bounds; on the last one it passes the bound and v
        keeps its sign, so that each motion passes it once. ``departed`` is the bound of the start.
        None says that all motions are proven to meet no bound ``until`` then or, with
        ``may_settle``, any more.
        """
        begin, (h, shortest, longest) = Fraction(0), self.numbers.steps
        # Steps that are short beside the width of the states are of no use.
        wide = self._apart()
        for _ in range(MOST_STEPS):
            if until is not None:
                h = min(h, until - begin)
            try:
                met = self._met_on(begin, h, departed)
            except NotProvenError:
                h /= 2
                if h < max(shortest, wide * FINE):
                    raise NotProvenError(
                        f"which event comes next is open {told(begin)} after an event"
                    ) from None
                continue
            if met is not None:
                return Landing(*met, begin, begin + h)
            begin, h = begin + h, min(2 * h, longest)
            if begin == until or (may_settle and self._settles(begin)):
                return None
        raise NotProvenError(f"no event within {told(begin)}, {MOST_STEPS} steps")

    def _apart(self) -> Fraction:
        """Return about how much later some states are than others, at a speed of this flight."""
        t, x, v = self.start
        first = self.numbers.steps.first
        a = self.acceleration(self.force(of(0)), x, v)
        speed, apart = v.size + a.size * first, x.width + v.width * first
        return max(Fraction(t.width, unit()), Fraction(apart, speed) if speed else Fraction(0))

    def _settles(self, tau: Fraction) -> bool:
        """Return whether the norm of free motion and the waves keep x off the bounds from tau on.

        With K, a > 0 the norm (y^2 + y'^2/K)^(1/2) does not grow.
        """
        k, a, c = self.region[:3]
        x_x, v_x, x_v, v_v = self.response(of(tau))
        p, q = self.free
        y, dy = p * x_x + q * x_v, p * v_x + q * v_v
        reach = (y.square() + dy.square() / k).root()
        for w, amplitude, _ in self.law.tones:
            first, second = k - w * w, 2 * a * w
            reach = reach + of(amplitude**2 / (first * first + second * second)).root()
        return all((sign * (at - c / k) - reach).low > 0 for _, sign, at in self.numbers.sides)

    def _met_on(self, begin: Fraction, h: Fraction, departed: int | None) -> tuple[int, int] | None:
        """Return the bound that all motions meet on a step, and its side, or None if they meet none."""
        x, v, since = self.on_step(begin, h)
        near = []
        for bound, sign, at in self.numbers.sides:
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
    after: State
    v_before: Interval
    derivative: Matrix


def met(
    flight: Flight, departed: int | None, landing: Landing | None = None, enough: int = 0
) -> Event:
    """Return the next event of states, proven to be the first one, with interval Newton steps.

    Its derivative is by t and v after the event at the start or, where there was none, by x and v.
    ``landing`` is that of a set with these states, where it is known; an instant in ``enough``
    units need not be known better.
    """
    bound, side, low, high = landing or _landing(flight, departed)
    at = of(flight.law.bounds[bound].at)
    tau = of(low, high)
    while True:
        point = tau.middle()
        x, _ = flight.at(point)
        first, last = tau.fractions()
        _, v, _ = flight.on_step(first, last - first)
        newton = point - (x - at) / v
        new = tau.both(newton)
        if new.low > new.high:
            raise NotProvenError("an event has no instant: the arithmetic contradicts itself")
        done, tau = 4 * new.width >= 3 * tau.width or new.width <= enough, new
        if done:
            break
    _, v = flight.at(tau)
    a = flight.acceleration(flight.force(tau), at, v)
    (x_t, x_v), (v_t, v_v) = flight.by_start(tau, departed)
    # Later by dt, for which v dt is by how much x is short of the bound.
    t_t, t_v = -(x_t / v), -(x_v / v)
    kept, region = flight.law.rebound(flight.number, bound, side)
    derivative = (t_t, t_v), (kept * (v_t + a * t_t), kept * (v_v + a * t_v))
    return Event(bound, region, tau, State(flight.start.t + tau, at, kept * v), v, derivative)


def _landing(flight: Flight, departed: int | None) -> Landing:
    """Return `Flight.landing`, found with few bits."""
    # The numbers of a branch's law are intervals of all bits.
    shift = max(0, arithmetic.BITS - COARSE) if flight.law.dual is None else 0
    if shift > 0:
        few = State(*(Interval(low >> shift, -(-high >> shift)) for low, high in flight.start))
        with bits(COARSE):
            return _landing(Flight(flight.law, flight.number, few), departed)
    found = flight.landing(departed)
    assert found is not None
    return found


def departing(law: Law, number: int, bound: int, box: Pair, *, may_rest: bool = False) -> State:
    """Return the states that leave a bound of a region, into it, at these instants and velocities."""
    if number >= len(law.regions):
        raise NotProvenError(f"there is no region {number}")
    t, v = box
    least = next((-(sign * v).high for it, sign in law.sides(number) if it == bound), -1)
    if least < 0 or (least == 0 and not may_rest):
        raise NotProvenError("an event does not lead into its region")
    return State(t, of(law.bounds[bound].at), v)
