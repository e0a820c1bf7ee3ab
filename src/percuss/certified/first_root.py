"""The first root of a function of time: polynomials with remainders on stretches of a flight."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

from flint import arb, ctx

from percuss.certified.ball_arithmetic import OpenGraze, Undecided
from percuss.certified.flight import SmoothFunction
from percuss.certified.numbers import Number, constant_of, largest_abs

# A float, or a ball.
Real: TypeAlias = Any
# A float or, in a search with balls, an exact arb.
Time: TypeAlias = Any

# Above the rounding of the float operations of a test, relative to its terms.
ROUNDING = 2.0**-44
UP = 1.0001
# With an error below this no sum of the tests is beyond the floats.
LARGEST = 1e280
ROWS = [[math.comb(n, j) for j in range(n + 1)] for n in range(16)]
# Degree of the polynomial; at the start it may lose one factor s for each order.
ORDER, START_ORDER = 5, 7
FACTORIALS = [math.factorial(i) for i in range(START_ORDER + 2)]
# Stretches of one flight.
MOST_STRETCHES = 200_000
# Those of a wide set, which can be divided.
SET_STRETCHES = 300
# How far stretches reach into the next, as a part of the time: more than the rounding of a sum;
# in balls as a part of their length, which is this much longer than the rounding at least.
OVERLAP = 2.0**-50
COARSEST = 2.0**8 / OVERLAP


class FloatStretch(NamedTuple):
    """A polynomial with float coefficients, their radii, and a remainder of ``rest h^power``."""

    mids: list[float]
    radii: list[float]

    @classmethod
    def of(cls, coefficients: list[Number]) -> FloatStretch:
        """Return the polynomial of some balls; the radii hold their rounding to floats."""
        mids, radii = [], []
        for value in coefficients:
            number = constant_of(value)
            mid = float(number)
            mids.append(mid)
            radii.append(UP * float(number.rad()) + abs(mid) * 2.0**-52 + 1e-300)
        return cls(mids, radii)

    def is_clear(self, rest: float, h: float, power: int) -> bool:
        """Return whether it is positive on [0, h] for certain."""
        error = self._error(self.mids, self.radii, h) + UP * rest * h**power
        return bool(min(_bernstein(self.mids, h)) > error)

    def falls_through(self, rest: float, slope_rest: float, h: float, power: int) -> bool:
        """Return whether it decreases all along, from above zero to below, for certain."""
        if not self.mids[0] > self.radii[0]:
            return False
        error = self._error(self.mids, self.radii, h) + UP * rest * h**power
        if not _value(self.mids, h) < -error:
            return False
        slopes = [-(k * value) for k, value in enumerate(self.mids)][1:]
        radii = [k * radius for k, radius in enumerate(self.radii)][1:]
        error = self._error(slopes, radii, h) + UP * slope_rest * h ** (power - 1)
        return bool(min(_bernstein(slopes, h)) > error)

    def fastest_fall(self, slope_rest: float, h: float, power: int) -> float:
        """Return a bound of the rate at which it decreases on [0, h]."""
        slopes = [k * value for k, value in enumerate(self.mids)][1:]
        radii = [k * radius for k, radius in enumerate(self.radii)][1:]
        error = self._error(slopes, radii, h) + UP * slope_rest * h ** (power - 1)
        fall = float(error - min(_bernstein(slopes, h)))
        return fall + 1e-15 * abs(fall)

    @staticmethod
    def _error(mids: list[float], radii: list[float], h: float) -> float:
        """Return a bound of what rounding and radii do to a value on [0, h]."""
        total, power = 0.0, 1.0
        for value, radius in zip(mids, radii, strict=True):
            total += (radius + ROUNDING * abs(value)) * power
            power *= h
        return UP * total if total < LARGEST else math.inf

    def root(self, h: float) -> float:
        """Return about where a decreasing polynomial is zero on [0, h]."""
        low, high = 0.0, h
        s = 0.5 * h
        for _ in range(60):
            value, slope = 0.0, 0.0
            for c in reversed(self.mids):
                slope = slope * s + value
                value = value * s + c
            if value > 0.0:
                low = s
            else:
                high = s
            step = s - value / slope if slope < 0.0 else math.inf
            moved = step if low < step < high else 0.5 * (low + high)
            if abs(moved - s) <= 1e-15 * moved:
                return moved
            s = moved
        return s


class BallStretch(NamedTuple):
    """A polynomial with balls as coefficients, and a remainder of ``rest h^power``."""

    balls: list[arb]

    @classmethod
    def of(cls, coefficients: list[Number]) -> BallStretch:
        """Return the polynomial of some balls."""
        return cls([constant_of(value) for value in coefficients])

    def is_clear(self, rest: float, h: float, power: int) -> bool:
        """Return whether it is positive on [0, h] for certain."""
        most = UP * arb(rest) * arb(h) ** power
        return all(value > most for value in _bernstein(self.balls, arb(h)))

    def falls_through(self, rest: float, slope_rest: float, h: float, power: int) -> bool:
        """Return whether it decreases all along, from above zero to below, for certain."""
        at = arb(h)
        most = UP * arb(rest) * at**power
        if not (self.balls[0] > 0 and _value(self.balls, at) < -most):
            return False
        slopes = [-(k * value) for k, value in enumerate(self.balls)][1:]
        most = UP * arb(slope_rest) * at ** (power - 1)
        return all(value > most for value in _bernstein(slopes, at))

    def fastest_fall(self, slope_rest: float, h: float, power: int) -> float:
        """Return a bound of the rate at which it decreases on [0, h]."""
        at = arb(h)
        slopes = [k * value for k, value in enumerate(self.balls)][1:]
        most = UP * arb(slope_rest) * at ** (power - 1)
        return max(
            math.nextafter(float((most - s).upper()), math.inf) for s in _bernstein(slopes, at)
        )

    def root(self, h: float) -> float:
        """Return about where a decreasing polynomial is zero on [0, h]."""
        return FloatStretch.of(list(self.balls)).root(h)


def _bernstein(coefficients: list[Real], h: Real) -> list[Real]:
    """Return the Bernstein coefficients of a polynomial on [0, h], between which it stays."""
    degree = len(coefficients) - 1
    bernstein: list[Real] = []
    power: Real = 1
    for value, binomial in zip(coefficients, ROWS[degree], strict=True):
        bernstein.append(value * power / binomial)
        power = power * h
    # Sums of neighbours, again and again.
    for i in range(1, degree + 1):
        for j in range(degree, i - 1, -1):
            bernstein[j] = bernstein[j] + bernstein[j - 1]
    return bernstein


def _value(coefficients: list[Real], h: Real) -> Real:
    total = coefficients[-1]
    for value in coefficients[-2::-1]:
        total = total * h + value
    return total


class Level(NamedTuple):
    """A level that the curve keeps on one side: sign * (curve - at) > 0 until the root."""

    bound: int
    sign: int
    at: Number


class Bracket(NamedTuple):
    """Where the first root is: between two exact times, at a level, and the only one there.

    Attributes
    ----------
    level
        The level.
    low, high
        Times between which there is no root but the first one.
    guess
        About its time.
    from_start
        Whether the stretch begins at the start of a curve on its level.
    far
        A time before which the root lies: the end of the stretch that was tested. It is later than
        ``high`` by what the stretch overlaps with the next one; the root may lie between them.
    """

    level: Level
    low: Time
    high: Time
    guess: Time
    from_start: bool
    far: Time

    def place_of(self, s: arb) -> int | None:
        """Return 1 for a time after the first root, 0 in the bracket, -1 before, for certain.

        A root in the bracket is the first one. None where the ball leaves it open.
        """
        if s > self.low and s < self.high:
            return 0
        if s > self.far:
            return 1
        return -1 if s < self.low else None


class Touch(NamedTuple):
    """Where some curves may have a root: at a level, between two times, no faster than a speed."""

    level: Level
    low: Time
    high: Time
    speed: float


class Search:
    """The search along one curve for its first crossing of several levels.

    Parameters
    ----------
    curve
        An `EnclosedFlight` or a `Push`; balls stand for all curves in them.
    levels
        The levels.
    started
        The level on which the curve starts, or None.
    order
        Order of the first derivative there that is not zero.
    width
        About how long a stretch can be.
    least
        Stretches shorter than this are undecided.
    sharp
        Whether to test in balls, beyond the rounding of floats.
    slow
        Stretches on which no curve comes nearer to a level as fast as this are passed over, whether
        there is a root or not: what is found is the first root of those curves that have no slower
        one before it. At 0 there are none.
    glancing
        Stretches on which no curve comes nearer as fast as this are passed over, too, where nothing
        else is decided on them; the roots that may lie there are noted in ``touches``.
    """

    def __init__(
        self,
        curve: SmoothFunction,
        levels: list[Level],
        started: Level | None,
        order: int,
        *,
        width: float,
        least: float,
        sharp: bool,
        slow: float = 0.0,
        glancing: float = 0.0,
    ) -> None:
        self.curve = curve
        self.levels = levels
        self.started, self.order = started, order
        self.width, self.longest, self.least = width, width, least
        self.sharp, self.slow, self.glancing = sharp, slow, glancing
        self.touches: list[Touch] = []
        self.kind: type[FloatStretch | BallStretch] = BallStretch if sharp else FloatStretch

    def first(self, end: float) -> Bracket | None:
        """Return where the first root up to ``end`` is, None if there is none."""
        left: Time = 0.0
        if self.started is not None:
            bracket, left = self._from_start(self.started)
            if bracket is not None:
                return bracket
        if self.sharp:
            left = arb(left)
        for _ in range(SET_STRETCHES if self.slow else MOST_STRETCHES):
            if not left < end:
                return None
            raw, size = self.curve.derivatives(arb(left), ORDER)
            if self.slow and any(level.sign * (raw[0] - level.at) < 0 for level in self.levels):
                # All curves have had a root on a stretch that was passed over.
                return None
            h = min(2.0 * self.width, self.curve.longest, float(end - left))
            h, bracket = self._stretch(left, raw, size, h)
            if bracket is not None:
                return bracket
            self.width = h
            left = (left + h).mid() if self.sharp else left + h
        reason = f"no event within so many stretches, up to {float(left):.6g} later"
        raise Undecided("no_event", reason, OpenGraze(left, left, self.levels[0].bound, math.inf))

    def _from_start(self, level: Level) -> tuple[Bracket | None, float]:
        """Search the first stretch of a curve that starts on its level."""
        n, m = START_ORDER, self.order
        if m > 4:
            raise Undecided("force", f"the first {m - 1} derivatives are zero at the start")
        c = self.curve.taylor(n)
        size = self.curve.size_at_start(n)
        deflated = self.kind.of([level.sign * value for value in c[m:]])
        others = [self.kind.of(_about(other, c)) for other in self.levels if other is not level]
        h = min(2.0 * self.width, self.curve.longest)
        while True:
            rest = self.curve.bound(n + 1, 0.0, h, size) / FACTORIALS[n + 1]
            free = all(other.is_clear(rest, h, n + 1) for other in others)
            if free and deflated.is_clear(rest, h, n + 1 - m):
                self.width = h
                return None, h
            # The remainder's quotient by s^m has R'/s^m - m R/s^(m+1) for a slope.
            slope_rest = (n + 1 + m) * rest
            if free and deflated.falls_through(rest, slope_rest, h, n + 1 - m):
                return Bracket(level, 0.0, h, deflated.root(h), from_start=True, far=h), h
            h *= 0.5
            if h < self.least:
                raise Undecided("graze", "whether the motion leaves its stop at the start is open")

    def _stretch(
        self, left: Time, raw: list[Number], size: float, h: float
    ) -> tuple[float, Bracket | None]:
        """Return the longest halving of h that is decided, and the root in it."""
        taylor = [value / FACTORIALS[k] if k > 1 else value for k, value in enumerate(raw)]
        stretches = [(level, self.kind.of(_about(level, taylor))) for level in self.levels]
        while True:
            # Beyond the rounding of left + h, where the next stretch begins.
            extra = OVERLAP * (h if self.sharp else left + h)
            over = h + extra
            rest = self.curve.bound(ORDER + 1, float(left), over, size) / FACTORIALS[ORDER + 1]
            pending = None
            for level, stretch in stretches:
                if stretch.is_clear(rest, over, ORDER + 1):
                    continue
                through = pending is None and stretch.falls_through(
                    rest, (ORDER + 1) * rest, over, ORDER + 1
                )
                if not through:
                    if self.slow and self._fall(stretch, rest, over) < self.slow:
                        continue
                    break
                # However these are rounded, one is before left + over and the other is not.
                end, guess = left + (h + 0.5 * extra), left + stretch.root(h)
                if self.sharp:
                    end, guess, far = end.mid(), guess.mid(), (left + over).upper()
                else:
                    far = math.nextafter(left + over, math.inf)
                pending = Bracket(level, left, end, guess, from_start=False, far=far)
            else:
                return h, pending
            h *= 0.5
            if h < self.least or left + h == left or self._is_rounding(h, left):
                touched = self._touched(left, stretches, size)
                if touched:
                    return touched, None
                raise _graze(level, left, 2.0 * over, taylor, rest)

    def _fall(self, stretch: FloatStretch | BallStretch, rest: float, over: float) -> float:
        return stretch.fastest_fall((ORDER + 1) * rest, over, ORDER + 1)

    def _touched(
        self, left: Time, stretches: list[tuple[Level, FloatStretch | BallStretch]], size: float
    ) -> float:
        """Note roots that may lie on a stretch, and return its length; 0 where they may be fast."""
        h = min(self.longest, self.curve.longest)
        while self.glancing and h >= self.least:
            over = h + OVERLAP * (h if self.sharp else left + h)
            rest = self.curve.bound(ORDER + 1, float(left), over, size) / FACTORIALS[ORDER + 1]
            touches = []
            for level, stretch in stretches:
                if stretch.is_clear(rest, over, ORDER + 1):
                    continue
                fall = self._fall(stretch, rest, over)
                if not fall < self.glancing:
                    break
                if not fall < self.slow:
                    touches.append(Touch(level, left, left + 2.0 * over, fall))
            else:
                for touch in touches:
                    self._note(touch)
                return h
            h *= 0.5
        return 0.0

    def _note(self, touch: Touch) -> None:
        """Note a touch, or make the last one longer that goes on in it."""
        for i, known in enumerate(self.touches):
            if known.level is touch.level and known.high >= touch.low:
                speed = max(known.speed, touch.speed)
                self.touches[i] = known._replace(high=touch.high, speed=speed)
                return
        self.touches.append(touch)

    def _is_rounding(self, h: float, left: Time) -> bool:
        """Return whether a stretch is too short for the working precision."""
        return self.sharp and not arb(h) > COARSEST * left * arb(2) ** -ctx.prec


def _graze(level: Level, left: Time, h: float, taylor: list[Number], rest: float) -> Undecided:
    """Return the question whether a curve touches a level between left and left + h."""
    sizes = [largest_abs(constant_of(c)) for c in _about(level, taylor)]
    near = 1.01 * (sum(size * h**k for k, size in enumerate(sizes)) + rest * h ** len(sizes))
    if not math.isfinite(near):
        reason = f"no event up to {float(left):.6g} later, where the motion is beyond all floats"
        return Undecided("no_event", reason, OpenGraze(left, left, level.bound, math.inf))
    reason = f"a turning point {float(left):.12g} after it is within {near:.3g} of a stop"
    return Undecided("graze", reason, OpenGraze(left, left + h, level.bound, near))


def _about(level: Level, coefficients: list[Number]) -> list[Number]:
    """Return the coefficients of the distance to a level."""
    distances = [level.sign * value for value in coefficients]
    distances[0] = level.sign * (coefficients[0] - level.at)
    return distances
