"""The derivatives of measures of a motion, from those of its events and quantities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple, Protocol, TypeAlias, get_args

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.errors import ParameterError
from percuss.model.oscillator import SoftStop, Wall
from percuss.motion.extremes import Extrema, QuantityName
from percuss.motion.moved_motion import MovedCrossings, MovedImpacts
from percuss.motion.tables import HasEvents
from percuss.numerics import gauss_legendre

MovedMeasure = Literal[
    "max_displacement",
    "min_displacement",
    "peak_displacement",
    "peak_acceleration",
    "peak_stop_force",
    "peak_impact_velocity",
    "rms_displacement",
    "mean_power",
    "contact_share",
]
# Nodes of Gauss's rule on a part of a flight, and the phase of the fastest motion in a part: its
# error is below 1e-16.
NODES, PHASE = 16, 3.0

# Why the force of rigid walls is no outcome.
RIGID = (
    "a rigid wall has impulses in place of a force, and all stops are rigid; ask for "
    "peak_impact_velocity"
)
# A value and its derivatives.
MovedValue: TypeAlias = tuple[float, Floats]


class MovedStretch(NamedTuple):
    """The part of a flight in a mean: the integral, its derivative, and the values at both ends.

    The derivative is that between instants that stay.
    """

    total: float
    moved: Floats
    first: float
    last: float


class MovedRun(Protocol):
    """The derivative of a motion, with the motion."""

    @property
    def paths(self) -> tuple[str, ...]:
        """The parameters."""
        ...

    @property
    def run(self) -> HasEvents:
        """The motion."""
        ...

    @property
    def impacts(self) -> MovedImpacts:
        """The derivatives of its impacts."""
        ...

    @property
    def crossings(self) -> MovedCrossings:
        """The derivatives of its crossings."""
        ...


class MeasuredMotion(Protocol):
    """A motion and its derivative, as measures read them."""

    @property
    def derivative(self) -> MovedRun:
        """The derivative."""
        ...

    @property
    def stops(self) -> Sequence[Wall | SoftStop]:
        """The stops."""
        ...

    @property
    def instants(self) -> tuple[Floats, Floats]:
        """The instants of all events and of the end, and their derivatives."""
        ...

    @property
    def in_contact(self) -> Flags:
        """Which events begin a flight in touch with a stop."""
        ...

    def extremes(self, of: QuantityName, stop: int) -> Extrema:
        """Return the extreme values of a quantity."""
        ...

    def values_at(self, of: QuantityName, stop: int, t: float) -> list[MovedValue]:
        """Return a quantity at an instant, at an event on both its sides, which move with it."""
        ...

    def stretch(self, of: str, row: int, span: tuple[float, float]) -> MovedStretch:
        """Return the integral of the square of x, or of the power, over the flight of an event."""
        ...

    def from_unit_mass(self, mean: MovedValue) -> MovedValue:
        """Return the power of the whole motion from that per unit mass."""
        ...


def has_rigid_stops(stops: Sequence[Wall | SoftStop]) -> bool:
    """Return whether there are stops, and all of them rigid."""
    return len(stops) > 0 and all(isinstance(stop, Wall) for stop in stops)


# Squares, and derivatives of instants by the smallest numbers, may be beyond all floats.
@np.errstate(over="ignore", invalid="ignore")
def moved_measure(d: MeasuredMotion, measure: str) -> MovedValue:
    """Return a measure of a motion and its derivatives; see `Sensitivity.of`."""
    if measure not in get_args(MovedMeasure):
        known = ", ".join(get_args(MovedMeasure))
        raise ParameterError("measure", measure, f"none of those that have a derivative: {known}")
    if measure == "peak_impact_velocity":
        return _of_fastest_impact(d)
    if measure == "contact_share":
        return _of_contact_share(d)
    if measure in ("rms_displacement", "mean_power"):
        return _of_mean(d, measure)
    if measure == "peak_acceleration":
        return _of_peak(d, "acceleration")
    if measure == "peak_stop_force":
        peaks = [d.extremes("stop_force", stop).peak for stop in range(len(d.stops))]
        if not peaks or max(peaks) == 0.0:
            if has_rigid_stops(d.stops):
                raise ParameterError("measure", measure, RIGID)
            return 0.0, np.zeros(len(d.derivative.paths))
        return _of_peak(d, "stop_force", int(np.argmax(peaks)))
    if measure == "peak_displacement":
        return _of_peak(d, "displacement")
    ends = d.extremes("displacement", 0)
    if measure == "max_displacement":
        return _of_value(d, "displacement", 0, ends.maximum, ends.t_maximum)
    return _of_value(d, "displacement", 0, ends.minimum, ends.t_minimum)


def _of_peak(d: MeasuredMotion, of: QuantityName, stop: int = 0) -> MovedValue:
    ends = d.extremes(of, stop)
    if ends.maximum >= -ends.minimum:
        return _of_value(d, of, stop, ends.maximum, ends.t_maximum)
    value, moved = _of_value(d, of, stop, ends.minimum, ends.t_minimum)
    return -value, -moved


def _of_value(d: MeasuredMotion, of: QuantityName, stop: int, value: float, t: float) -> MovedValue:
    """Return an extreme value of a quantity, which it has at t, and its derivatives."""
    moved = d.values_at(of, stop, t)
    return value, min(moved, key=lambda pair: abs(pair[0] - value))[1]


def _of_fastest_impact(d: MeasuredMotion) -> MovedValue:
    moved_events = d.derivative
    impacts, crossings = moved_events.run.impacts, moved_events.run.crossings
    into = crossings.direction == "in"
    speeds = np.concatenate([impacts.v_before, crossings.v[into]])
    moved = np.concatenate([moved_events.impacts.v_before, moved_events.crossings.v[into]])
    if len(speeds) == 0:
        return 0.0, np.zeros(len(moved_events.paths))
    fastest = int(np.argmax(np.abs(speeds)))
    speed = float(speeds[fastest])
    return abs(speed), np.asarray(math.copysign(1.0, speed) * moved[fastest])


def _of_contact_share(d: MeasuredMotion) -> MovedValue:
    (instants, moved), in_contact = d.instants, d.in_contact
    whole, longer = instants[-1] - instants[0], moved[-1] - moved[0]
    share = float(np.diff(instants)[in_contact].sum()) / whole
    held = np.diff(moved, axis=0)[in_contact].sum(axis=0)
    return share, np.asarray((held - share * longer) / whole)


def _of_mean(d: MeasuredMotion, measure: str) -> MovedValue:
    """Return the root of the mean of x^2, or the mean of the force times v, and its derivatives."""
    instants, moved = d.instants
    total, column = 0.0, np.zeros(len(d.derivative.paths))
    for row in range(len(instants) - 1):
        begin, end = float(instants[row]), float(instants[row + 1])
        if not end > begin and np.array_equal(moved[row], moved[row + 1]):
            continue
        part = d.stretch(measure, row, (begin, end))
        total += part.total
        # A flight of no length, as before an impact at the start, has one state that may last longer.
        first = part.first if end > begin else part.last
        column += part.moved + part.last * moved[row + 1] - first * moved[row]
    whole, longer = instants[-1] - instants[0], moved[-1] - moved[0]
    mean = total / whole
    column = (column - mean * longer) / whole
    if measure == "rms_displacement":
        root = math.sqrt(mean)
        return root, np.asarray(column / (2.0 * root) if root > 0.0 else column)
    return d.from_unit_mass((mean, column))


def nodes_of(
    span: tuple[float, float], rate: float, *, fades: float = math.inf, slow_rate: float = 0.0
) -> tuple[Floats, Floats]:
    """Return the nodes and the weights of an integral over a stretch without events.

    Parameters
    ----------
    span
        Where it begins and ends.
    rate
        The largest rate of the motion.
    fades
        The time after which nothing is left of a fast decay.
    slow_rate
        The largest rate from then on.
    """
    begin, end = span
    nodes, weights = gauss_legendre(NODES)
    faded = min(begin + fades, end)
    edges = _edges(begin, faded, rate)
    if faded < end:
        edges = np.concatenate([edges[:-1], _edges(faded, end, slow_rate)])
    middles, halves = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    t = (middles[:, np.newaxis] + halves[:, np.newaxis] * nodes).reshape(-1)
    return t, (halves[:, np.newaxis] * weights).reshape(-1)


def _edges(begin: float, end: float, rate: float) -> Floats:
    """Return where a stretch is cut so that each part has the phase of one rule."""
    return np.linspace(begin, end, max(1, math.ceil((end - begin) * rate / PHASE)) + 1)
