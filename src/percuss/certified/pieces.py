"""A record in balls: the instants of its knots, and the force of the pieces between them.

Piece number i begins at knot number i. A record that repeats has pieces of all whole numbers; one
that does not has piece -1 before its first sample, and its last piece from the last sample on.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from fractions import Fraction
from functools import cached_property, reduce
from typing import NamedTuple

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.numbers import (
    Number,
    ball,
    constant_of,
    is_exact,
    order_of,
    ratio_of,
    time_ball,
)
from percuss.certified.system import Angle
from percuss.model.exact import Phase, PiTimes, angle, as_float, as_fraction
from percuss.model.force_record import ForceRecord


class Moment(NamedTuple):
    """One instant: as a ball and, where it is a rational and a multiple of pi, exactly."""

    t: Number
    time: Phase | None = None

    @classmethod
    def of(cls, time: Phase) -> Moment:
        """Return a given time."""
        return cls(time_ball(time), time if is_exact(time) else None)


class Ramp(NamedTuple):
    """The force of a piece at an instant, and its slope; None where that is zero exactly."""

    force: Number
    slope: Number | None

    def upper_slope(self) -> arb:
        """Return a bound of the size of the slope."""
        if self.slope is None:
            return arb(0)
        return constant_of(self.slope).abs_upper()


class BallRecord:
    """A record at the working precision.

    Parameters
    ----------
    record
        The record, per unit mass.
    amplitude
        Its factor.
    pace
        The angular frequency of a wave; None where the samples are instants.
    exact_amplitude, exact_pace
        Whether they are the rational numbers of the record.
    """

    def __init__(
        self,
        record: ForceRecord,
        amplitude: Number,
        pace: Number | None,
        *,
        exact_amplitude: bool,
        exact_pace: bool,
    ) -> None:
        self.record = record
        self.amplitude, self.pace = amplitude, pace
        self.exact_amplitude, self.exact_pace = exact_amplitude, exact_pace
        self.count = len(record.t) - 1
        self._rational_pace = Fraction(1)
        if record.omega is not None:
            self._rational_pace = as_fraction(record.omega)
        self._knots: dict[int, Moment] = {}

    @cached_property
    def _floats(self) -> list[float]:
        return [as_float(t) for t in self.record.t]

    def _sample(self, number: int) -> tuple[int, int]:
        """Return turn and sample of a knot."""
        return divmod(number, self.count) if self.record.repeat else (0, number)

    def _angle(self, number: int) -> Angle:
        """Return the instant of a knot, or its phase, as a multiple of pi and a rational."""
        turn, k = self._sample(number)
        times, plus = angle(self.record.t[k])
        if turn:
            length = self.length
            times, plus = times + turn * length[0], plus + turn * length[1]
        return times, plus

    @cached_property
    def length(self) -> Angle:
        """The record from its first sample to its last, in instants or phases."""
        (times, plus), (last, more) = angle(self.record.t[0]), angle(self.record.t[-1])
        return last - times, more - plus

    def knot(self, number: int) -> Moment:
        """Return the instant of a knot."""
        known = self._knots.get(number)
        if known is None:
            times, plus = self._angle(number)
            if self.pace is None or self.exact_pace or not (times or plus):
                times, plus = times / self._rational_pace, plus / self._rational_pace
                exact = PiTimes(times, plus)
                known = Moment(time_ball(exact), exact)
            else:
                known = Moment(time_ball(PiTimes(times, plus)) / self.pace)
            self._knots[number] = known
        return known

    def next_knot(self, piece: int) -> Moment | None:
        """Return the end of a piece, None for the last one."""
        if self.record.repeat or piece < self.count:
            return self.knot(piece + 1)
        return None

    def piece_at(self, moment: Moment) -> int:
        """Return the number of the piece at an instant; at a knot that after it.

        Raises
        ------
        Undecided
            If the ball leaves it open.
        """
        guess = self._guess(float(constant_of(moment.t)))
        for number in (guess, guess - 1, guess + 1):
            if self._has_begun(number, moment) and not self._has_begun(number + 1, moment):
                return number
        raise Undecided(
            "precision",
            f"whether t = {float(constant_of(moment.t)):.12g} is before a knot of the record is open",
        )

    def _guess(self, t: float) -> int:
        phase = t * float(self._rational_pace)
        floats, turn = self._floats, 0
        if self.record.repeat:
            length = floats[-1] - floats[0]
            turn = math.floor((phase - floats[0]) / length)
            phase -= turn * length
        number = bisect_right(floats, phase) - 1
        return turn * self.count + number

    def _has_begun(self, number: int, moment: Moment) -> bool:
        if not self.record.repeat and not 0 <= number <= self.count:
            return number < 0
        knot = self.knot(number)
        if knot.time is not None and moment.time is not None:
            return order_of(moment.time, knot.time) >= 0
        t, at = constant_of(moment.t), constant_of(knot.t)
        if t >= at or t < at:
            return bool(t >= at)
        reason = "whether an event comes before or after the knot of the record at "
        reason += f"t = {float(at):.12g} is open, by {float((t - at).abs_upper()):.2g}"
        raise Undecided("precision", reason)

    def forces(self, piece: int) -> tuple[Fraction, Fraction]:
        """Return the force at both ends of a piece, as parts of the amplitude."""
        _, k = self._sample(piece)
        f, record = self.record.f, self.record
        if not 0 <= k < self.count:
            outer = as_fraction(f[max(0, k)]) if record.outside == "end" else Fraction(0)
            return outer, outer
        first = as_fraction(f[k])
        return first, as_fraction(f[k + 1]) if record.kind == "linear" else first

    def _duration(self, piece: int) -> Angle:
        (times, plus), (last, more) = self._angle(piece), self._angle(piece + 1)
        return last - times, more - plus

    def ramp(self, piece: int, moment: Moment) -> Ramp:
        """Return the force of a piece at an instant, and its slope."""
        first, last = self.forces(piece)
        if first == last:
            return Ramp(self.amplitude * ball(first), None)
        slope = self.amplitude * ball(last - first) / time_ball(PiTimes(*self._duration(piece)))
        if self.pace is not None:
            slope = slope * self.pace
        part = self._part(piece, moment.time)
        if part is not None:
            return Ramp(self.amplitude * ball(first + part * (last - first)), slope)
        since = moment.t - self.knot(piece).t
        return Ramp(self.amplitude * ball(first) + slope * since, slope)

    def force_at(self, moment: Moment) -> arb:
        """Return a ball of the force at an instant; of both sides where it may be at a knot."""
        try:
            return self.ramp(self.piece_at(moment), moment).force
        except Undecided:
            guess = self._guess(float(moment.t))
            pieces = range(guess - 1, guess + 2)
            if not self.record.repeat:
                pieces = range(max(-1, guess - 1), min(self.count, guess + 1) + 1)
            near = [
                self.ramp(i, moment).force
                for i in pieces
                if (i < 0 or not self.knot(i).t > moment.t)
                and not ((end := self.next_knot(i)) is not None and end.t < moment.t)
            ]
            return reduce(arb.union, near)

    def rational(self, piece: int, time: Phase, order: int) -> Fraction | None:
        """Return the force, or a derivative of it, at an exact time as a rational, None if it is none.

        Of a piece, at its ends too.
        """
        first, last = self.forces(piece)
        if not (self.exact_amplitude and self.exact_pace):
            return None
        amplitude = as_fraction(self.record.amplitude)
        if first == last or order > 1:
            return amplitude * first if order == 0 else Fraction(0)
        if order == 1:
            times, plus = self._duration(piece)
            return None if times else amplitude * (last - first) * self._rational_pace / plus
        part = self._part(piece, time)
        return None if part is None else amplitude * (first + part * (last - first))

    def _part(self, piece: int, time: Phase | None) -> Fraction | None:
        """Return the part of a piece that has passed at a time, where it is surely rational."""
        if time is None:
            return None
        knot = self.knot(piece).time
        if knot is None:
            return None
        (times, plus), (at, more) = angle(time), angle(knot)
        length, rest = (value / self._rational_pace for value in self._duration(piece))
        return ratio_of((times - at, plus - more), (length, rest))

    @cached_property
    def extremes(self) -> arb:
        """A ball that holds all forces of the record."""
        forces = [as_fraction(f) for f in self.record.f]
        if not self.record.repeat and self.record.outside == "zero":
            forces.append(Fraction(0))
        amplitude = constant_of(self.amplitude)
        return (amplitude * ball(min(forces))).union(amplitude * ball(max(forces)))
