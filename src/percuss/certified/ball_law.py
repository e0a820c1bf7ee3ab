"""The law of a system in balls: exact parameters, and ranges of them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from typing import NamedTuple, TypeAlias, cast

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Ball, Undecided
from percuss.certified.numbers import (
    Number,
    ball,
    constant_of,
    cos_sin,
    exact_value,
    in_balls,
    is_exact,
    largest_abs,
    ratio_of,
    time_ball,
)
from percuss.certified.pieces import BallRecord, Moment, Ramp
from percuss.certified.system import BallSystem, Region, Tone
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, PiTimes, angle, as_fraction, pi_times, two_of
from percuss.model.expression import Expression
from percuss.model.paths import long_form, moved_in_law, replace_parameter

# By path: all values of a ball, or all between two numbers.
Over: TypeAlias = Mapping[str, Ball | tuple[Exact, Exact]]
# Real and imaginary part of 1 / (K - omega^2 + 2 i A omega); None exactly at resonance.
Gain: TypeAlias = tuple[Number, Number] | None

# Bits lost beyond which parts of the motion count as nearly cancelling.
FEW_BITS = 12
TINY = 1e-300
# Bits of what needs only the size of a set: derivatives, and the search for the first root.
COARSE = 64
# Laws by the identity of their systems and the working precision.
_LAWS: dict[tuple[int, int], tuple[BallSystem, BallLaw]] = {}
MOST_LAWS = 64


def system_for(system: BallSystem, over: Over | None) -> BallSystem:
    """Return the system with one number of its force replaced by all of a range.

    Raises
    ------
    ParameterError
        If it is no number of the force that may be a ball, not one path, or an empty range.
    """
    if over is None:
        return system
    given: object = over
    if not isinstance(given, Mapping) or len(given) != 1:
        raise ParameterError("over", over, "not one parameter and its values, {path: (low, high)}")
    ((name, values),) = over.items()
    path = long_form(name, system.oscillator, system.forcing)
    allowed = ["forcing.constant", *(tone.amplitude for tone in system.tones)]
    allowed += ["forcing.record.amplitude"] if system.record is not None else []
    moved = moved_in_law(system.oscillator, system.forcing, path).fields
    if path.startswith(("oscillator.", "forcing.")):
        if system.forcing is None or path not in allowed:
            reason = f"no number of the force that may be a ball; these may: {', '.join(allowed)}"
            raise ParameterError("over", name, reason)
    elif any(field.endswith((".at", ".restitution")) for field in moved):
        reason = "no parameter that may be a ball: the place or restitution of a stop depends on it"
        raise ParameterError("over", name, reason)
    low, high = _ends(path, values)
    if "." not in path:
        for end in (low, high):
            replace_parameter(system.oscillator, system.forcing, None, path, end)
    return dataclasses.replace(system, moved=(path, low, high))


def range_of(system: BallSystem) -> tuple[str, Ball] | None:
    """Return the number that a proof holds for all values of, and these; None for none."""
    if system.moved is None:
        return None
    path, low, high = system.moved
    return path, Ball(ball(low).union(ball(high)))


def too_wide(system: BallSystem) -> str:
    """Return the end of a reason why more bits do not help; empty without a range."""
    if system.moved is None:
        return ""
    path, low, high = system.moved
    if low == high:
        return ""
    return f"; the range of {path} is too wide, by its radius of {float(high - low) / 2:.2g}"


def _ends(path: str, values: Ball | tuple[Exact, Exact]) -> tuple[Fraction, Fraction]:
    if isinstance(values, Ball):
        if not values.arb.is_finite():
            raise ParameterError(f"over[{path!r}]", values, "a ball without a number")
        middle, radius = exact_value(values.arb), exact_value(values.arb.rad())
        return middle - radius, middle + radius
    low, high = two_of(as_fraction, f"over[{path!r}]", values, "neither a ball nor two numbers")
    if not low <= high:
        raise ParameterError(f"over[{path!r}]", values, "the first value is above the second")
    return low, high


@dataclass(frozen=True)
class LinearRegion:
    """x'' + 2 damping x' + stiffness x = constant + harmonics, and how it moves of itself.

    Attributes
    ----------
    regime
        "oscillating", "critical", "overdamped" or "free" (neither spring nor dashpot).
    rate
        Frequency of the free oscillation, or half the distance of the two rates of decay.
    spring
        Whether the stiffness is not zero.
    pace
        A float not below sqrt(abs(stiffness)).
    growth
        A float not below the rate at which the norm of `Flight.bound` can grow.
    lost
        Bits that are lost where large parts of the motion cancel: close to resonance, or to no
        spring at all.
    """

    damping: Number
    stiffness: Number
    constant: Number
    regime: str
    rate: Number
    spring: bool
    dashpot: bool
    pace: float
    growth: float
    gains: tuple[Gain, ...]
    lost: int

    @property
    def cancels(self) -> bool:
        """Whether waves and free motion nearly cancel, as close to resonance."""
        return self.lost > FEW_BITS


class Rebound(NamedTuple):
    """What an impact makes of a velocity.

    Attributes
    ----------
    after
        The velocity after it.
    restitution
        Restitution at this speed.
    kept
        Derivative of the speed after by that before.
    at_knot
        Whether the speed may be that of a knot of a table: the two are then of both sides.
    """

    after: Number
    restitution: Number
    kept: Number
    at_knot: bool = False


class BallLaw:
    """All numbers of a system at the working precision, one of them replaced where asked for.

    Parameters
    ----------
    system
        The exact system.
    path, value
        A parameter that is not the system's but this ball, or series: with a series all that
        depends on it has its derivative, by the chain rule.
    """

    def __init__(self, system: BallSystem, path: str | None = None, value: Number | None = None):
        self.system = system
        # What is no exact number of the system, by path.
        self._values = {field: in_balls(number, {}) for field, number in system.irrational.items()}
        if path is not None and value is not None:
            name, moved = moved_in_law(system.oscillator, system.forcing, path)
            if any(".restitution." in field for field in moved):
                reason = "an entry of a table of restitutions, over which nothing is proven"
                raise ParameterError("path", path, reason)
            self._values |= {
                field: in_balls(number, {name: value}) for field, number in moved.items()
            }
        self.mass = self._mass(path, value)
        self.tones = [self._tone(tone) for tone in system.tones]
        self.omegas = [omega for omega, _, _ in self.tones]
        self.strength = [
            largest_abs(constant_of(c)) + largest_abs(constant_of(d)) for _, c, d in self.tones
        ]
        self.paces = [largest_abs(constant_of(omega)) for omega in self.omegas]
        self.places = [self.number(bound.path) for bound in system.bounds]
        self.record = self._record()
        self.regions = [self._region(region) for region in system.regions]

    def _record(self) -> BallRecord | None:
        record = self.system.record
        if record is None:
            return None
        amplitude, omega = "forcing.record.amplitude", "forcing.record.omega"
        return BallRecord(
            record,
            self.number(amplitude),
            None if record.omega is None else self.number(omega),
            exact_amplitude=amplitude not in self._values,
            exact_pace=omega not in self._values,
        )

    def ramp(self, piece: int, moment: Moment) -> Ramp | None:
        """Return force and slope of a piece of the record at an instant; None without a record."""
        return None if self.record is None else self.record.ramp(piece, moment)

    def next_knot(self, piece: int) -> Moment | None:
        """Return the end of a piece of the record, None where there is none."""
        return None if self.record is None else self.record.next_knot(piece)

    def piece_at(self, moment: Moment) -> int:
        """Return the number of the record's piece at an instant; 0 without a record."""
        return 0 if self.record is None else self.record.piece_at(moment)

    def rebound(self, stop: int, v: Number) -> Rebound:
        """Return what an impact on a wall makes of a velocity."""
        table = self.system.tables.get(stop)
        if table is None:
            path = f"oscillator.stops.{stop}.restitution"
            # An irrational number is not 0, whatever its ball holds.
            r = self.number(path) if self.system.numbers[path] else arb(0)
            return Rebound(-r * v, r, r)
        speed = v if constant_of(v) > 0 else -v
        u = constant_of(speed)
        restitutions, kept = [], []
        for low, high, slope, base in _lines(table):
            if (low is None or not u < ball(low)) and (high is None or not u > ball(high)):
                restitutions.append(ball(base) + ball(slope) * speed if slope else ball(base))
                kept.append(ball(base) + 2 * ball(slope) * speed if slope else ball(base))
        if len(kept) == 1:
            return Rebound(-restitutions[0] * v, restitutions[0], kept[0])
        r, slopes = (_hull([constant_of(value) for value in some]) for some in (restitutions, kept))
        return Rebound(-r * v, r, slopes, at_knot=True)

    def slow_restitution(self, stop: int, speed: arb) -> arb:
        """Return a ball that holds the restitution of all impacts up to a speed."""
        table = self.system.tables.get(stop)
        if table is None:
            return self.number(f"oscillator.stops.{stop}.restitution")
        fastest = speed.abs_upper()
        # Linear in between, it is least and largest at the ends and at the knots.
        values = [ball(r) for u, r in table if not fastest < ball(u)]
        ends = (self.rebound(stop, fastest).restitution, ball(table[0][1]))
        return _hull([*ends, *values])

    def is_plastic(self, stop: int) -> bool:
        """Return whether impacts on a wall leave no velocity, exactly."""
        return self.system.numbers.get(f"oscillator.stops.{stop}.restitution") == 0

    def period(self, n: int) -> Number:
        """Return the length of n periods of the forcing.

        Raises
        ------
        Undecided
            If the period is not known exactly.
        """
        force = self.system.forcing
        if self.record is not None:
            return n * self._period_of_record(self.record)
        frequency = None if force is None else force.frequency
        if frequency is None:
            raise Undecided("precision", "the period of the forcing is not known exactly")
        omegas = {tone.omega for tone in self.system.tones}
        if not omegas.isdisjoint(self._values):
            if len(omegas) > 1:
                raise Undecided("precision", "with this frequency the forcing has no period")
            omega = omegas.pop()
            # A period that was given may hold several of the harmonic.
            turns = int(self.system.numbers[omega] / frequency)
            return 2 * n * turns * arb.pi() / self.number(omega)
        return 2 * n * arb.pi() / ball(frequency)

    def _period_of_record(self, record: BallRecord) -> Number:
        """Return the period of a forcing with a record: one that is exactly one of all its parts."""
        force = self.system.forcing
        exact = None if force is None else force.exact_period
        unknown = Undecided("precision", "the period of the forcing is not known exactly")
        own = record.record.period
        if force is None or exact is None or own is None:
            raise unknown
        turns = ratio_of(angle(exact), angle(own))
        if turns is None or turns.denominator != 1:
            raise unknown
        wave = record.record.omega
        for tone in self.system.tones:
            if record.exact_pace and tone.omega not in self._values:
                times, plus = angle(exact)
                whole = self.system.frequency(tone) * times / 2
                if plus or whole.denominator != 1:
                    raise unknown
                continue
            omega = self.system.irrational.get(tone.omega)
            if record.exact_pace and _makes_turns(omega, tone, exact):
                continue
            times, plus = (turns * part for part in record.length)
            by = self._multiple(omega, wave)
            if by is None or plus or (by * tone.times * times / 2).denominator != 1:
                raise unknown
        length = time_ball(PiTimes(*record.length)) * turns.numerator
        return length if record.pace is None else length / record.pace

    def _multiple(self, omega: Expression | None, wave: Exact | None) -> Fraction | None:
        """Return the rational by which an irrational frequency is that of the record, or None."""
        if omega is None or not isinstance(wave, Expression):
            return None
        if omega == wave:
            return Fraction(1)
        are_numbers = omega.is_exact and wave.is_exact and self.system.moved is None
        return ratio_of(angle(omega), angle(wave)) if are_numbers else None

    def _mass(self, path: str | None, value: Number | None) -> Number:
        """Return the mass by which forces per unit mass are multiplied; 1 without one."""
        mass = 1 if self.system.oscillator.mass is None else self.system.oscillator.mass
        if path == "oscillator.mass" and value is not None:
            return value
        if isinstance(mass, Expression):
            known = {} if path is None or value is None else {path: value}
            return in_balls(mass, known)
        return ball(as_fraction(mass))

    def exact_period(self) -> PiTimes | None:
        """Return the period of the forcing where it is a number known exactly, not by a ball."""
        force = self.system.forcing
        if force is None:
            return None
        if self.record is not None:
            try:
                self._period_of_record(self.record)
            except Undecided:
                return None
            return force.exact_period if self.record.exact_pace else None
        if force.frequency is None:
            return None
        balls = [tone for tone in self.system.tones if tone.omega in self._values]
        if not balls:
            # One that was given need not be exactly one of the harmonics.
            return pi_times(2 / force.frequency)
        period = cast("PiTimes", force.exact_period)
        whole = self.system.moved is None and all(
            _makes_turns(self.system.irrational.get(tone.omega), tone, period)
            for tone in self.system.tones
        )
        return period if whole else None

    def number(self, path: str) -> Number:
        """Return a number by its path."""
        if path in self._values:
            return self._values[path]
        return ball(self.system.numbers[path])

    def phasors_at(self, time: Phase) -> list[tuple[arb, arb]]:
        """Return cosine and sine of omega t for each harmonic at an exact time."""
        if not is_exact(time):
            return self.phasors(time_ball(time))
        times, plus = angle(time)
        if self._values:
            return self.phasors(arb.pi() * ball(times) + ball(plus))
        omegas = (self.system.frequency(tone) for tone in self.system.tones)
        return [cos_sin(omega * times, omega * plus) for omega in omegas]

    def phasors(self, time: arb) -> list[tuple[arb, arb]]:
        """Return cosine and sine of omega t for each harmonic."""
        return [(omega * time).sin_cos()[::-1] for omega in self.omegas]

    def drive(self, phasors: Sequence[tuple[arb, arb]]) -> list[tuple[Number, Number, Number]]:
        """Return omega, value and slope / omega of each harmonic at phasors."""
        return [
            (omega, c * cosine + d * sine, d * cosine - c * sine)
            for (omega, c, d), (cosine, sine) in zip(self.tones, phasors, strict=True)
        ]

    def _tone(self, tone: Tone) -> tuple[Number, Number, Number]:
        """Return omega and the coefficients of cos(omega t) and sin(omega t)."""
        omega, amplitude = self.number(tone.omega), self.number(tone.amplitude)
        if tone.times != 1:
            omega = omega * tone.times
        if tone.phase_path in self._values:
            sine, cosine = self._values[tone.phase_path].sin_cos()
            return omega, amplitude * cosine, -(amplitude * sine)
        cosine, sine = cos_sin(*tone.phase)
        return omega, amplitude * cosine, -(amplitude * sine)

    def _region(self, region: Region) -> LinearRegion:
        stiffness, damping, constant = self._sums(region)
        regime, rate = self._regime(region, stiffness, damping)
        pace = largest_abs(constant_of(stiffness)) ** 0.5 * 1.000001
        growth = (pace * pace - float(constant_of(stiffness).lower())) / (2.0 * pace) * 1.0001
        # Negative damping makes the norm grow by exp(2 abs(a) s) at most.
        growth += max(0.0, -2.0 * float(constant_of(damping).lower())) * 1.0001
        gains = tuple(
            self._gain(tone, omega, region, stiffness, damping)
            for tone, omega in zip(self.system.tones, self.omegas, strict=True)
        )
        return LinearRegion(
            damping=damping,
            stiffness=stiffness,
            constant=constant,
            regime=regime,
            rate=rate,
            spring=self._moved("stiffness", region) or self.system.stiffness(region) != 0,
            dashpot=self._moved("damping", region) or self.system.damping(region) != 0,
            pace=pace,
            # So little is allowed for in `Flight.bound` anyway.
            growth=growth if growth > 5e-6 * pace else 0.0,
            gains=gains,
            lost=self._lost(gains, constant, stiffness, damping),
        )

    def _sums(self, region: Region) -> tuple[Number, Number, Number]:
        """Return stiffness, damping and constant force, of rationals as long as none is moved."""
        parts = [f"oscillator.stops.{i}" for i in region.active]
        paths = ["oscillator.stiffness", "oscillator.damping", "forcing.constant"]
        if not any(
            field.startswith((*paths, *(f"{part}." for part in parts))) for field in self._values
        ):
            system = self.system
            sums = system.stiffness(region), system.damping(region), system.constant(region)
            return ball(sums[0]), ball(sums[1]), ball(sums[2])
        stiffness, damping, push = (self.number(path) for path in paths)
        for path in parts:
            spring = self.number(f"{path}.stiffness")
            stiffness = stiffness + spring
            push = push + spring * self.number(f"{path}.at")
            damping = damping + self.number(f"{path}.damping")
        return stiffness, damping, push

    def _lost(
        self, gains: tuple[Gain, ...], constant: Number, stiffness: Number, damping: Number
    ) -> int:
        sizes = [1.0]
        pace = largest_abs(constant_of(stiffness))
        if self.system.record is not None and pace > TINY:
            # A ramp under a weak spring: parts of the size of its slope over stiffness squared.
            drag = 2.0 * largest_abs(constant_of(damping))
            scale = max([pace, self.system.record.rate**2, drag**2, *(w * w for w in self.paces)])
            sizes.append((scale / pace) * (scale / pace))
        for gain, omega, strength in zip(gains, self.paces, self.strength, strict=True):
            if gain is not None and strength > TINY:
                size = largest_abs(constant_of(gain[0])) + largest_abs(constant_of(gain[1]))
                sizes.append(size * (omega * omega + pace))
        fastest = max([pace, *(omega * omega for omega in self.paces)])
        if pace > TINY and not constant_of(constant).is_zero():
            sizes.append(fastest / pace)
        return math.ceil(math.log2(min(max(sizes), 1e300)))

    def _moved(self, name: str, region: Region) -> bool:
        """Return whether the replaced number is part of a region's stiffness or damping."""
        parts = {f"oscillator.{name}", *(f"oscillator.stops.{i}.{name}" for i in region.active)}
        return not parts.isdisjoint(self._values)

    def _regime(self, region: Region, stiffness: Number, damping: Number) -> tuple[str, Number]:
        if not (self._moved("stiffness", region) or self._moved("damping", region)):
            a, k = self.system.damping(region), self.system.stiffness(region)
            if k == a * a:
                return ("critical" if a else "free"), ball(Fraction(0))
            return ("oscillating" if k > a * a else "overdamped"), ball(abs(k - a * a)).sqrt()
        discriminant = stiffness - damping * damping
        sign = constant_of(discriminant)
        if not (sign > 0 or sign < 0):
            raise Undecided("precision", "the parameter may be that of critical damping")
        oscillating = bool(sign > 0)
        size = discriminant if oscillating else -discriminant
        return ("oscillating" if oscillating else "overdamped"), size.sqrt()

    def _gain(
        self, tone: Tone, omega: Number, region: Region, stiffness: Number, damping: Number
    ) -> Gain:
        moved = (
            self._moved("stiffness", region)
            or self._moved("damping", region)
            or tone.omega in self._values
        )
        k, a = self.system.stiffness(region), self.system.damping(region)
        if not moved:
            # In rationals: however close to resonance, nothing cancels.
            w = self.system.frequency(tone)
            if a == 0:
                return None if k == w * w else (1 / ball(k - w * w), ball(Fraction(0)))
            detuning, drag = ball(k - w * w), ball(2 * a * w)
        else:
            detuning, drag = stiffness - omega * omega, 2 * damping * omega
        size = detuning * detuning + drag * drag
        if constant_of(size).contains(0):
            raise Undecided("precision", "a harmonic may be at the natural frequency")
        return detuning / size, -(drag / size)


def _hull(balls: list[arb]) -> arb:
    return reduce(arb.union, balls)


def _makes_turns(omega: Expression | None, tone: Tone, period: PiTimes) -> bool:
    """Return whether a frequency that is a multiple of pi makes whole turns in a rational period."""
    if omega is None or not omega.is_exact or period.times:
        return False
    times, plus = omega.angle()
    return not plus and (tone.times * times * period.plus / 2).denominator == 1


def _lines(
    table: tuple[tuple[Fraction, Fraction], ...],
) -> Iterator[tuple[Fraction | None, Fraction | None, Fraction, Fraction]]:
    """Yield the lines of a table: from and to which speed, slope, and value at zero speed."""
    yield None, table[0][0], Fraction(0), table[0][1]
    for (u0, r0), (u1, r1) in pairwise(table):
        slope = (r1 - r0) / (u1 - u0)
        yield u0, u1, slope, r0 - slope * u0
    yield table[-1][0], None, Fraction(0), table[-1][1]


def coarse_bits(system: BallSystem) -> int:
    """Return the bits that are enough for derivatives and the search for the first root.

    No more than the working precision.
    """
    return min(ctx.prec, COARSE + lost_bits(system))


def lost_bits(system: BallSystem) -> int:
    """Return the bits that are lost where large parts of the motion cancel; 0 for a few."""
    lost = max(region.lost for region in law_of(system).regions)
    return lost if lost > FEW_BITS else 0


def law_of(system: BallSystem) -> BallLaw:
    """Return the law of a system at the working precision."""
    key = id(system), ctx.prec
    known = _LAWS.get(key)
    if known is None or known[0] is not system:
        if len(_LAWS) > MOST_LAWS:
            _LAWS.clear()
        path, values = range_of(system) or (None, None)
        known = _LAWS[key] = system, BallLaw(system, path, None if values is None else values.arb)
    return known[1]
