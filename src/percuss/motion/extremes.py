"""The extremes of a motion and where it passes a level, exact from the closed form of its flights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels.arithmetic import Pair
from percuss.kernels.law_columns import Law
from percuss.kernels.linear_observables import (
    GREATEST,
    LEAST,
    PROGRESS_ENTRIES,
    T_GREATEST,
    T_LEAST,
    Observable,
    Scratch,
    derive_knots,
    derive_law,
    extremes_of_record,
    slope_weights,
    stop_weights,
)
from percuss.kernels.loads import SAME_INSTANT
from percuss.kernels.passages import crossings_of_level
from percuss.kernels.pieces import time_to_knot
from percuss.kernels.record import EVENT_T, KIND, KNOT, MotionRecord
from percuss.model.exact import as_float, whole
from percuss.model.oscillator import stops_in_words
from percuss.model.system import System, stop_rows

QuantityName = Literal["displacement", "velocity", "acceleration", "stop_force", "spring_force"]
# Searches of one call of the kernels, some 0.1 s, and crossings that it writes.
AT_ONCE = 100_000


@dataclass(frozen=True, slots=True)
class Extrema:
    """The least and the largest value of a quantity in a motion, and when it has them.

    Attributes
    ----------
    minimum, maximum
        In the units of the quantity: length, length/time, length/time^2 for accelerations, and
        mass length/time^2 for forces, per unit mass where there is no mass. With the sign that
        `Trajectory.forces` gives them.
    t_minimum, t_maximum
        Their instants, the first ones [time].
    """

    minimum: float
    t_minimum: float
    maximum: float
    t_maximum: float

    @property
    def peak(self) -> float:
        """The largest magnitude."""
        return max(abs(self.minimum), abs(self.maximum))


def observable_of(system: System, of: str, stop: int = 0) -> Observable:
    """Return a quantity of the motions of a system as the kernels take it, per unit mass.

    Raises
    ------
    ParameterError
        If there is no such quantity, or no such stop.
    """
    if of not in get_args(QuantityName):
        raise ParameterError("of", of, f"none of {', '.join(get_args(QuantityName))}")
    law, oscillator = system.law, system.of_unit_mass.oscillator
    reference, acts, bound = 0.0, (0, int(law[0, at.N_REGIONS]) - 1), -1
    weights = {
        "displacement": (1.0, 0.0, 0.0, 0.0),
        "velocity": (0.0, 1.0, 0.0, 0.0),
        "acceleration": (0.0, 0.0, 1.0, 0.0),
        "spring_force": (-as_float(oscillator.stiffness), 0.0, 0.0, 0.0),
    }.get(of, (0.0, 0.0, 0.0, 0.0))
    if of == "stop_force":
        number = whole("stop", stop, 0)
        if number >= len(oscillator.stops):
            reason = stops_in_words(oscillator)
            raise ParameterError("stop", stop, reason)
        row = stop_rows(system.oscillator)[number]
        reference, weights, bound = (
            float(row[at.STOP_AT]),
            stop_weights(row),
            int(row[at.STOP_BOUND]),
        )
        acts = int(row[at.STOP_FIRST]), int(row[at.STOP_LAST])
    derived = law.copy()
    derive_law(law, slope_weights(weights, bound), derived)
    derive_knots(law, slope_weights(weights, bound), derived)
    return Observable(reference, weights, acts, bound, derived)


def extremes_of_motion(
    system: System, record: MotionRecord, span: tuple[float, float], of: str, stop: int
) -> Extrema:
    """Return the extremes of a quantity between two instants; see `Trajectory.extremes`."""
    observable = observable_of(system, of, stop)
    best = np.array([math.inf, math.nan, -math.inf, math.nan])
    progress = np.zeros(PROGRESS_ENTRIES)
    scratch = _scratch(system)
    while not extremes_of_record(record, observable, span, progress, best, scratch, AT_ONCE):
        pass
    least, t_least, most, t_most = (float(best[i]) for i in (LEAST, T_LEAST, GREATEST, T_GREATEST))
    factor = system.mass if of.endswith("force") else 1.0
    t_least, t_most = (told_instant(record.events, span, t) for t in (t_least, t_most))
    return Extrema(factor * least, t_least, factor * most, t_most)


def window_at_jumps(jumps: Floats, span: Pair, t_end: float) -> Pair:
    """Return a window of a motion up to t_end whose ends are at jumps that are within rounding.

    Both limits at a jump of the force belong to a window that ends there, on whichever side of it
    the end was rounded. But a motion that ends at a jump has not come to it: only the limit before
    it counts. The instants of other events are those of the run itself, and exact.
    """
    first, last = span
    # By so much a stretch goes on behind a jump, or there is none.
    beyond = 2.0 * SAME_INSTANT
    at_first = jumps[np.abs(jumps - first) <= SAME_INSTANT * abs(first)]
    at_last = jumps[np.abs(jumps - last) <= SAME_INSTANT * abs(last)]
    if len(at_first):
        first = min(first, float(at_first[0]) - beyond * abs(first))
    if len(at_last):
        is_end = t_end - last <= SAME_INSTANT * abs(last)
        if is_end:
            last = min(last, math.nextafter(at_last[0], -math.inf))
        else:
            last = max(last, float(at_last[-1]) + beyond * abs(last))
    return (first, last) if first <= last else span


def jumps_in(events: Floats, marks: Integers) -> Floats:
    """Return the jumps, and other knots, of the force that are rows of a record."""
    return np.asarray(events[marks[:, KIND] == KNOT, EVENT_T])


def jumps_at(law: Law, instants: Sequence[float]) -> Floats:
    """Return the knots of the force that are within rounding of some instants, or come next."""
    found = []
    for t in instants:
        before = t - 2.0 * SAME_INSTANT * abs(t)
        found.append(before + time_to_knot(law, before, 0.0))
    return np.array(found)


def told_instant(events: Floats, span: tuple[float, float], t: float) -> float:
    """Return the instant of an event, or an end of the span, within rounding of t, else t.

    The end of a flight is its begin and its duration, which rounds otherwise than the event.
    """
    of_events = events[:, EVENT_T]
    instants = np.concatenate([of_events, span])
    nearest = float(instants[np.argmin(np.abs(instants - t))])
    begin = float(of_events[max(int(np.searchsorted(of_events, min(t, nearest))) - 1, 0)])
    return nearest if abs(nearest - t) <= SAME_INSTANT * max(abs(t), abs(begin)) else t


def level_crossings(system: System, record: MotionRecord, level: float, t_end: float) -> Floats:
    """Return (t, v) of each passage of a displacement up to t_end, (n, 2)."""
    progress = np.zeros(PROGRESS_ENTRIES)
    scratch = _scratch(system)
    parts = []
    while True:
        part = np.empty((AT_ONCE, 2))
        count = crossings_of_level(record, level, t_end, progress, part, scratch)
        parts.append(part[:count].copy())
        if count < AT_ONCE:
            return np.concatenate(parts)


def _scratch(system: System) -> Scratch:
    """Return the arrays that the kernels work in."""
    return Scratch(*np.zeros((5, int(system.law[0, at.N_HARMONICS]), 2)))
