"""The maps that turn a motion into a sequence of points, with exact derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import turns
from percuss.kernels.law_columns import (
    N_KNOTS,
    PERIOD,
    PERIOD_TURNS,
    PERIOD_TURNS_LOW,
)
from percuss.kernels.shooting import factor_of_error
from percuss.model.exact import as_float, real, reals, whole
from percuss.model.faults import raise_first
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, Wall, stops_in_words
from percuss.model.periods import require_period
from percuss.model.start import start_faults, wall_faults
from percuss.model.system import System
from percuss.motion.accelerations import acceleration_in
from percuss.motion.extremes import level_crossings
from percuss.motion.sections import PoincareSection, SectionDirection, section_of
from percuss.numerics import matmul
from percuss.orbits.orbit.itinerary import entry
from percuss.orbits.orbit.propagator import Propagator

# A quantity of what follows an instant with a velocity.
OfInstant: TypeAlias = Callable[[Propagator, float, float], ArrayLike]

# Impacts on other stops before the next one on the stop of the map.
MOST_IMPACTS = 4096

# Forcing periods in which the next passage of a section is looked for: the first, and then these.
LOOKED_FOR = (1, 16, 256, 4096)

# The derivative where there is no next impact.
UNDEFINED = np.full((2, 2), np.nan)


@dataclass(frozen=True, slots=True)
class ImpactMap:
    """From one impact on a stop to the next one on it; made by `impact_map`.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    stop
        Index of the stop.
    """

    oscillator: Oscillator
    forcing: Forcing
    stop: int

    def __call__(self, cycle: ArrayLike, v_after: ArrayLike) -> tuple[Floats, Floats]:
        """Return cycle and velocity after the next impact; NaN where there is none.

        None within 4096 impacts on other stops, and under a record within 4096 forcing periods,
        counts as none.

        Parameters
        ----------
        cycle
            Cycles of impacts, (t / period) mod 1, of any shape.
        v_after
            Velocities after them, off a wall or into a soft stop, of the same shape or one that
            broadcasts with it [length/time]. With 0 at a wall that holds the mass, the motion
            goes on from its release.

        Returns
        -------
        tuple of arrays
            Cycle in [0, 1) and velocity [length/time], of the common shape.

        Raises
        ------
        ParameterError
            If a number is not finite, or a velocity has the other sign.
        """
        images = self._each(cycle, v_after, self._next)
        return images[..., 0], images[..., 1]

    def jacobian(self, cycle: ArrayLike, v_after: ArrayLike) -> Floats:
        """Return the derivative of (cycle, v_after) at the next impact by that at this one.

        After contact with a wall it is zero: the release does not depend on the past.

        Parameters
        ----------
        cycle, v_after
            As for the map itself.

        Returns
        -------
        array
            Of the common shape and (2, 2); NaN where there is no next impact.

        Raises
        ------
        ParameterError
            As for the map itself.
        """
        return _as_matrices(self._each(cycle, v_after, self._derivative))

    def _each(self, cycle: ArrayLike, v_after: ArrayLike, quantity: OfInstant) -> Floats:
        cycles, speeds = _finite_pairs(cycle=cycle, v_after=v_after)
        stop = self.oscillator.stops[self.stop]
        off = -1.0 if stop.side == "above" else 1.0
        sign = off if isinstance(stop, Wall) else -off
        wrong = speeds[sign * speeds < 0.0]
        if wrong.size:
            where = "into the wall" if isinstance(stop, Wall) else "out of the stop"
            reason = f"{where}; a velocity after an impact there is {'+' if sign > 0 else '-'}"
            raise ParameterError("v_after", float(wrong.flat[0]), reason)
        return _at_each(System(self.oscillator, self.forcing), cycles, speeds, quantity)

    def _follow(self, runs: Propagator, t: float, v: float) -> tuple[Floats, Integers] | None:
        """Return the record up to the next impact, None if there is none."""
        at = as_float(self.oscillator.stops[self.stop].at)
        bound = entry(self.oscillator, self.stop).bound
        # Under harmonics the kernels prove that no impact comes any more, not past the knots of a
        # record.
        end = math.inf
        if runs.law[0, N_KNOTS] > 0.0:
            end = t + LOOKED_FOR[-1] * float(runs.law[0, PERIOD])
        n = 1
        while n <= MOST_IMPACTS:
            events, marks = runs.follow(at, v, t, t_end=end, n_impacts=n)
            kinds = marks[:, columns.KIND]
            impacts = (kinds == columns.IMPACT) | (kinds == columns.CROSSING)
            hits = np.flatnonzero(impacts & (marks[:, columns.BOUND] == bound))
            hits = hits[self._enters(events[hits], kinds[hits])]
            if hits.size:
                return events[: hits[0] + 1], marks[: hits[0] + 1]
            if impacts.sum() < n:
                return None
            n *= 4
        return None

    def _enters(self, events: Floats, kinds: Integers) -> Flags:
        """Return which events at the bound of the stop are impacts on it."""
        sign = 1.0 if self.oscillator.stops[self.stop].side == "above" else -1.0
        into = sign * events[:, columns.V_BEFORE] > 0.0
        return np.asarray((kinds == columns.IMPACT) | into)

    def _next(self, runs: Propagator, t: float, v: float) -> tuple[float, float]:
        record = self._follow(runs, t, v)
        if record is None:
            return math.nan, math.nan
        last = record[0][-1]
        cycle = _cycle(runs, last[columns.EVENT_T], last[columns.EVENT_T_LOW])
        return cycle, float(last[columns.V_AFTER])

    def _derivative(self, runs: Propagator, t: float, v: float) -> Floats:
        record = self._follow(runs, t, v)
        if record is None:
            return UNDEFINED.reshape(-1)
        events, marks = record
        runs._record = events[:-1], marks[:-1]
        until = float(events[-1, columns.EVENT_T])
        matrix = runs.derivative_at(until, after=False)
        at = as_float(self.oscillator.stops[self.stop].at)
        first, last = int(marks[0, columns.NEXT_REGION]), int(marks[-2, columns.NEXT_REGION])
        before = float(events[-1, columns.V_BEFORE])
        instant = until, float(events[-1, columns.EVENT_T_LOW])
        pull = acceleration_in(runs.law, last, at, before, *instant)
        kept = factor_of_error(runs.law, last, int(marks[-1, columns.BOUND]), before)
        return _between(runs, first, matrix, (at, v, t), (before, kept, pull))


@dataclass(frozen=True, slots=True)
class SectionMap:
    """From one passage of a displacement to the next one; made by `section_map`.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    section
        The displacement, and the direction of the passages.
    """

    oscillator: Oscillator
    forcing: Forcing
    section: PoincareSection

    def __call__(self, cycle: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """Return cycle and velocity at the next passage; NaN where there is none.

        None within 4096 forcing periods counts as none.

        Parameters
        ----------
        cycle
            Cycles of passages, (t / period) mod 1, of any shape.
        v
            Velocities there in the direction of the section, not 0, of the same shape or one that
            broadcasts with it [length/time].

        Returns
        -------
        tuple of arrays
            Cycle in [0, 1) and velocity [length/time], of the common shape.

        Raises
        ------
        ParameterError
            If a number is not finite, or a velocity is 0 or has the other sign.
        """
        images = self._each(cycle, v, self._next)
        return images[..., 0], images[..., 1]

    def jacobian(self, cycle: ArrayLike, v: ArrayLike) -> Floats:
        """Return the derivative of (cycle, v) at the next passage by that at this one.

        After contact with a wall it is zero: the release does not depend on the past.

        Parameters
        ----------
        cycle, v
            As for the map itself.

        Returns
        -------
        array
            Of the common shape and (2, 2); NaN where there is no next passage.

        Raises
        ------
        ParameterError
            As for the map itself.
        """
        return _as_matrices(self._each(cycle, v, self._derivative))

    def _each(self, cycle: ArrayLike, v: ArrayLike, quantity: OfInstant) -> Floats:
        cycles, speeds = _finite_pairs(cycle=cycle, v=v)
        sign = self.section.sign
        wrong = speeds[(speeds == 0.0) | (sign * speeds < 0.0)]
        if wrong.size:
            reason = f"no velocity of a passage {self.section.label}"
            raise ParameterError("v", float(wrong.flat[0]), reason)
        return _at_each(System(self.oscillator, self.forcing), cycles, speeds, quantity)

    def _follow(self, runs: Propagator, t: float, v: float) -> tuple[float, float] | None:
        """Return (t, v) of the next passage, None if there is none."""
        period, level = float(runs.law[0, PERIOD]), self.section.at
        for periods in LOOKED_FOR:
            end = t + periods * period
            events, marks = runs.follow(level, v, t, t_end=end)
            record = columns.MotionRecord(runs.law, level, events, marks)
            passages = level_crossings(runs.system, record, level, end)
            passages = passages[self.section.sign * passages[:, 1] >= 0.0]
            if len(passages):
                return float(passages[0, 0]), float(passages[0, 1])
        return None

    def _next(self, runs: Propagator, t: float, v: float) -> tuple[float, float]:
        passage = self._follow(runs, t, v)
        if passage is None:
            return math.nan, math.nan
        return _cycle(runs, passage[0], 0.0), passage[1]

    def _derivative(self, runs: Propagator, t: float, v: float) -> Floats:
        passage = self._follow(runs, t, v)
        if passage is None:
            return UNDEFINED.reshape(-1)
        until, speed = passage
        events, marks = runs.record
        last = int(np.searchsorted(events[:, columns.EVENT_T], until)) - 1
        regions = (int(marks[row, columns.NEXT_REGION]) for row in (0, last))
        first, last = regions
        matrix = runs.derivative_at(until, after=False)
        pull = acceleration_in(runs.law, last, self.section.at, speed, until)
        return _between(runs, first, matrix, (self.section.at, v, t), (speed, 1.0, pull))


@dataclass(frozen=True, slots=True)
class StroboscopicMap:
    """From one instant to that one period later; made by `stroboscopic_map`.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    cycle
        Cycle of the instants.
    """

    oscillator: Oscillator
    forcing: Forcing
    cycle: float

    def __call__(self, x: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """Return (x, v) one period later.

        Parameters
        ----------
        x, v
            Positions [length], not inside a wall, and velocities [length/time], of any shapes
            that broadcast.

        Returns
        -------
        tuple of arrays
            x and v of the common shape.

        Raises
        ------
        ParameterError
            If a number is not finite, or a position inside a wall.
        """
        images = self._each(x, v, derivative=False)
        return images[..., 0], images[..., 1]

    def jacobian(self, x: ArrayLike, v: ArrayLike) -> Floats:
        """Return the derivative of (x, v) one period later by (x, v).

        Zero after contact with a wall; at a graze that of the motion without an impact.

        Parameters
        ----------
        x, v
            As for the map itself.

        Returns
        -------
        array
            Of the common shape and (2, 2).

        Raises
        ------
        ParameterError
            As for the map itself.
        """
        return _as_matrices(self._each(x, v, derivative=True))

    def _each(self, x: ArrayLike, v: ArrayLike, *, derivative: bool) -> Floats:
        places, speeds = np.broadcast_arrays(reals("x", x), reals("v", v))
        _check_finite("v", speeds)
        for extreme in (places.min(), places.max()) if places.size else ():
            raise_first(start_faults(self.oscillator, float(extreme), 0.0, t_end=1.0))
        runs = Propagator(System(self.oscillator, self.forcing))
        period = float(runs.law[0, PERIOD])
        begin = self.cycle * period
        end = begin + period
        values = []
        for place, speed in zip(places.flat, speeds.flat, strict=True):
            runs.follow(float(place), float(speed), begin, t_end=end)
            if derivative:
                values.append(runs.derivative_at(end).reshape(-1))
            else:
                values.append(np.array(runs.state_at(float(place), end)))
        return np.array(values, dtype=np.float64).reshape(*places.shape, -1)


def impact_map(osc: Oscillator, force: Forcing, stop: int = 0) -> ImpactMap:
    """Return the map from one impact on a stop to the next one on it.

    It is (cycle, v_after) -> (cycle, v_after), for walls and for entries into soft stops,
    whatever the motion meets in between: other stops, chatter, contact. One call follows a
    motion to the very next impact, so that in a chatter each hop is a step.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period.
    stop
        Index of the stop in ``osc.stops``.

    Returns
    -------
    ImpactMap
        A function of (cycle, v_after), arrays allowed, with `jacobian`.

    Raises
    ------
    ParameterError
        If there is no such stop, or the forcing has no period.

    Examples
    --------
    The impact of COCO's example (Dankowicz & Schilder 2013, example 15.2) is a fixed point:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    >>> cycle, v = impact_map(osc, pc.cosine(1.0))(0.012088, -1.3565863)
    >>> round(float(cycle), 5), round(float(v), 5)
    (0.01209, -1.35659)
    """
    periodic_system(osc, force, "an impact map")
    stop = whole("stop", stop, 0)
    if stop >= len(osc.stops):
        reason = stops_in_words(osc)
        raise ParameterError("stop", stop, reason)
    return ImpactMap(osc, force, stop)


def section_map(
    osc: Oscillator, force: Forcing, *, at: float, direction: SectionDirection = "both"
) -> SectionMap:
    """Return the map from one passage of a displacement to the next: a Poincaré map.

    It is (cycle, v) -> (cycle, v), through impacts, crossings, chatter and contact. The passages
    are those of `Trajectory.section`, which takes the same arguments.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period.
    at
        The displacement [length], between the walls.
    direction
        "up" with v > 0, "down" with v < 0, or "both".

    Returns
    -------
    SectionMap
        A function of (cycle, v), arrays allowed, with `jacobian`.

    Raises
    ------
    ParameterError
        If the displacement is not finite or in a wall, there is no such direction, or the forcing
        has no period.

    Examples
    --------
    >>> import percuss as pc
    >>> osc, force = pc.impact_oscillator(0.8, damping=0.1), pc.sine(3)
    >>> cycle, v = section_map(osc, force, at=0.2, direction="up")(0.5, 1.0)
    >>> run = pc.simulate(osc, force, x0=0.2, v0=1.0, t0=force.period / 2, t_end=20)
    >>> abs(float(v) - float(run.section(at=0.2, direction="up").v[0])) < 1e-14
    True
    """
    periodic_system(osc, force, "a section map")
    section = section_of({"at": at, "direction": direction})
    raise_first(wall_faults(osc, "at", section.at))
    return SectionMap(osc, force, section)


def stroboscopic_map(osc: Oscillator, force: Forcing, *, cycle: float = 0.0) -> StroboscopicMap:
    """Return the map over one forcing period.

    It is (x, v) -> (x, v), through impacts, crossings, chatter and contact.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period.
    cycle
        Cycle of the instants, (t / period) mod 1.

    Returns
    -------
    StroboscopicMap
        A function of (x, v), arrays allowed, with `jacobian`.

    Raises
    ------
    ParameterError
        If the forcing has no period, or the cycle is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import percuss as pc
    >>> strobe = stroboscopic_map(pc.impact_oscillator(0.8, damping=0.1), pc.sine(3))
    >>> matrix = strobe.jacobian(0.5, -1.0)
    >>> round(float(np.linalg.det(matrix) / np.exp(-0.2 * 2 * np.pi / 3) / 0.8**2), 9)
    1.0
    """
    periodic_system(osc, force, "a stroboscopic map")
    return StroboscopicMap(osc, force, real("cycle", cycle))


def periodic_system(osc: Oscillator, force: Forcing | None, what: str) -> System:
    """Return the system of two arguments; ParameterError if the forcing has no period."""
    system = System.of(osc, force)
    require_period(system.forcing, f"{what} needs a periodic forcing")
    return system


def _finite_pairs(**both: ArrayLike) -> list[Floats]:
    """Return two arguments, by their names, as arrays of one shape; all numbers are finite."""
    arrays = np.broadcast_arrays(*(reals(name, values) for name, values in both.items()))
    for name, array in zip(both, arrays, strict=True):
        _check_finite(name, array)
    return list(arrays)


def _at_each(system: System, cycles: Floats, speeds: Floats, quantity: OfInstant) -> Floats:
    """Return a quantity's numbers for each pair, along a last axis."""
    runs = Propagator(system)
    period = float(runs.law[0, PERIOD])
    instants = zip(cycles.flat, speeds.flat, strict=True)
    values = [quantity(runs, c * period, v) for c, v in instants]
    return np.array(values, dtype=np.float64).reshape(*cycles.shape, -1)


def _as_matrices(rows: Floats) -> Floats:
    return rows.reshape(*rows.shape[:-1], 2, 2)


def _check_finite(name: str, values: Floats) -> None:
    wrong = values[~np.isfinite(values)]
    if wrong.size:
        raise ParameterError(name, float(wrong.flat[0]), "not a finite number")


def _cycle(runs: Propagator, t: float, t_low: float) -> float:
    """Return the cycle of an instant, in [0, 1)."""
    pace = runs.law[0, PERIOD_TURNS], runs.law[0, PERIOD_TURNS_LOW]
    part = turns(*pace, t, t_low)
    part += 1.0 if part < 0.0 else 0.0
    return part if part < 1.0 else 0.0


def _between(
    runs: Propagator,
    region: int,
    matrix: Floats,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
) -> Floats:
    """Return the derivative of (cycle, v) at one place by that at another, four numbers.

    ``matrix`` is that of the motion between them at fixed times. ``start`` is (x, v, t) and the
    flight from there in ``region``; ``end`` is the velocity that arrives, the derivative of the
    velocity after by it, and the acceleration.
    """
    x, v, t = start
    before, kept, pull = end
    begin = np.array([[-v, 0.0], [-acceleration_in(runs.law, region, x, v, t), 1.0]])
    ends = np.array([[-1.0 / before, 0.0], [-kept * pull / before, kept]])
    period = float(runs.law[0, PERIOD])
    scale = np.array([[1.0, 1.0 / period], [period, 1.0]])
    return np.asarray(scale * matmul(matmul(ends, matrix), begin)).reshape(-1)
