"""What is seen of a structure's motion beside its clearances: a displacement, and the stops' forces.

Each is linear in modes and loads, as guards are. Its extremes are at the ends of flights, at the
nodes between which it is compared, and where it turns between two nodes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import Pair
from percuss.kernels.compile import kernel
from percuss.kernels.event_location import within_bracket
from percuss.kernels.observables import HIGHEST, IN_TOUCH, LOWEST, PEAK_FORCE
from percuss.kernels.record import NEXT_REGION
from percuss.kernels.structure.basis import IS_ON, QUICKEST, STEP_LENGTH, Basis, basis_with
from percuss.kernels.structure.flight import (
    SECOND,
    SPEED,
    VALUE,
    ModalFlight,
    arrive_in_rows,
    derivatives,
    move,
    see,
)
from percuss.kernels.structure.run import StructureRun, flight_with, value_of
from percuss.kernels.structure.sample import flight_after

# Phase of the quickest rate between two nodes at which what is seen is compared, in shortest steps;
# the nodes of a motion without any rate, a cubic; and steps to a turning point.
STEPS_OF_A_NODE = 2.0
NODES_OF_A_CUBIC = 16
TURNING_STEPS = 60


class Views(NamedTuple):
    """What is seen of a motion beside the clearances: y = c . x first, then the stops' forces.

    Each is linear in modes and loads, and the arrays are those of `Sets` for guards.
    """

    guard: Floats
    levels: Floats
    feed: Floats
    record_feed: Floats


@kernel
def observe_views(
    viewer: StructureRun, views: Views, row: int, span: tuple[float, float], values: Floats
) -> None:
    """Record the extremes of what is seen, and the time in touch, on a part of the flight of a row.

    Turning points are those between neighbouring nodes at which the slope has different signs, or
    between which it turns on the other side of zero.
    """
    b = viewer.marks[row, NEXT_REGION]
    left, right = span
    if viewer.sets.keys[b] != 0:
        values[IN_TOUCH] += max(0.0, right - left)
    flight_after(viewer, row)
    flight = seen_flight(viewer, views, b)
    n_views = views.levels.shape[1]
    seen = viewer.scratch[2, :n_views]
    seen1 = viewer.scratch[3, :n_views]
    modes = viewer.rows[0:2]
    rates = viewer.rows[4:9]
    for k in range(n_views):
        flight.values[k] = value_of(flight, k)
    arrive_in_rows(flight, left, modes)
    see(flight, modes, flight.arrival, left, rates, seen)
    note_views(flight.basis, seen, values)
    count = NODES_OF_A_CUBIC
    if flight.basis.of_set[QUICKEST] > 0.0:
        width = STEPS_OF_A_NODE * flight.basis.of_set[STEP_LENGTH]
        count = max(1, math.ceil((right - left) / width))
    step = (right - left) / count
    for node in range(count):
        s = left + node * step
        arrive_in_rows(flight, s + step, modes)
        see(flight, modes, flight.arrival, s + step, rates, seen1)
        note_views(flight.basis, seen1, values)
        for k in range(n_views):
            if flight.basis.levels[k, IS_ON] == 1.0:
                turns = seen[k, SPEED], seen[k, SECOND], seen1[k, SPEED], seen1[k, SECOND]
                note_turns(flight, k, (s, s + step), turns, values)
            seen[k, SPEED] = seen1[k, SPEED]
            seen[k, SECOND] = seen1[k, SECOND]


@kernel
def seen_flight(viewer: StructureRun, views: Views, b: int) -> ModalFlight:
    """Return the flight of the viewer whose guards are the views."""
    basis = basis_with(
        viewer.sets, b, views.guard[b], views.levels[b], views.feed[b], views.record_feed[b]
    )
    return flight_with(viewer, basis, viewer.values, viewer.order)


@kernel
def note_views(basis: Basis, seen: Floats, values: Floats) -> None:
    """Note what is seen at an instant."""
    for k in range(seen.shape[0]):
        if basis.levels[k, IS_ON] == 1.0:
            note_view(k, seen[k, VALUE], values)


@kernel
def note_view(k: int, value: float, values: Floats) -> None:
    """Note a value of the displacement, or of a stop's force."""
    if k == 0:
        values[LOWEST] = min(values[LOWEST], value)
        values[HIGHEST] = max(values[HIGHEST], value)
    else:
        values[PEAK_FORCE] = max(values[PEAK_FORCE], abs(value))


@kernel
def note_turns(
    flight: ModalFlight,
    k: int,
    span: Pair,
    slopes: tuple[float, float, float, float],
    values: Floats,
) -> None:
    """Note a view where it turns between two nodes; ``slopes`` are first and second derivatives."""
    left, right = span
    slope, bend, slope1, bend1 = slopes
    if slope == 0.0:
        slope = bend
    if slope * slope1 < 0.0:
        note_view(k, turning_value(flight, k, left, right, slope), values)
    elif slope * bend < 0.0 and slope1 * bend1 > 0.0:
        # It has slowed down and sped up: in between it may have gone the other way.
        s, least = slowest_at(flight, k, left, right, bend)
        if slope * least < 0.0:
            note_view(k, turning_value(flight, k, left, s, slope), values)
            note_view(k, turning_value(flight, k, s, right, least), values)


@kernel
def slowest_at(
    flight: ModalFlight, k: int, left: float, right: float, bend: float
) -> tuple[float, float]:
    """Return where the slope of a view turns, and the slope there.

    The second derivative has the sign of ``bend`` at the left, and another one at the right.
    """
    s = 0.5 * (left + right)
    slope = 0.0
    for _ in range(TURNING_STEPS):
        move(flight, s)
        _, slope, second, third, _, _ = derivatives(flight, k, s, False)
        if second * bend > 0.0:
            left = s
        else:
            right = s
        step = -second / third if third != 0.0 else 0.0
        if abs(second * step) <= 1e-16 * abs(slope) or not left < right:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    return s, slope


@kernel
def turning_value(flight: ModalFlight, k: int, left: float, right: float, slope: float) -> float:
    """Return a view where its slope vanishes, between two times at which its signs differ."""
    s = 0.5 * (left + right)
    value = 0.0
    for _ in range(TURNING_STEPS):
        move(flight, s)
        value, first, second, _, _, _ = derivatives(flight, k, s, False)
        if first * slope > 0.0:
            left = s
        else:
            right = s
        step = -first / second if second != 0.0 else 0.0
        if abs(first * step) <= 1e-16 * abs(value) or not left < right:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    return value
