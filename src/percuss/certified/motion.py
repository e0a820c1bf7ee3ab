"""Position, velocity, forces and energy of a certified motion at given times."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
from flint import arb, ctx
from numpy.typing import ArrayLike

from percuss.certified.ball_arithmetic import Balls
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import BallPair, hull
from percuss.certified.contact import Hold, Hops
from percuss.certified.flight import Push
from percuss.certified.march import Ending, MarchRecord
from percuss.certified.numbers import between, order_of, precision, time_ball
from percuss.certified.pieces import Moment
from percuss.certified.step import Departure, state_in_flight
from percuss.certified.system import BallSystem
from percuss.errors import ParameterError
from percuss.model.exact import Phase, phase_problem, plain
from percuss.model.oscillator import SoftStop

FLOAT_BITS = 64
# Up to the very end that was asked for; the others end at an event or before a question.
TO_THE_END = (Ending.reached_t_end, Ending.at_rest)


def is_proven(record: MarchRecord, time: Phase) -> bool:
    """Return whether a time certainly lies within the proven motion."""
    if record.begin is not None and order_of(time, record.begin) < 0:
        return False
    if record.ending in TO_THE_END and record.end is not None:
        return order_of(time, record.end) <= 0
    with precision(max(FLOAT_BITS, ctx.prec)):
        # A float is exact here, however few bits were worked with. What follows an event may
        # have an event of its own within the radius.
        return bool(time_ball(time) <= record.until)


def state_at(system: BallSystem, record: MarchRecord, time: Phase) -> BallPair:
    """Return balls of x and v at a time; at an event, of both of its sides.

    Raises
    ------
    ParameterError
        If the time lies outside of what is proven.
    """
    t = time_ball(time)
    pieces = record.pieces
    if not pieces or t < pieces[0].start or not is_proven(record, time):
        first = pieces[0].start if pieces else record.until
        reason = f"outside of what is proven, {float(first):.12g} to {float(record.until):.12g}"
        raise ParameterError("t", time, reason)
    states = []
    latest = math.nextafter(float(t.upper()), math.inf)
    for i in range(bisect_right(record.earliest(), latest) - 1, -1, -1):
        if t < pieces[i].start:
            continue
        if i + 1 < len(pieces) and t > pieces[i + 1].start:
            break
        states.append(_on_piece(system, pieces[i].what, t))
    return hull(states)


def _on_piece(system: BallSystem, what: Departure | Hold | Hops, t: arb) -> BallPair:
    if isinstance(what, Hops):
        return what.x, what.v
    if isinstance(what, Hold):
        return law_of(system).places[what.bound], arb(0)
    return state_in_flight(system, what, t)


def states_as_balls(
    state: Callable[[Phase], BallPair], t: ArrayLike | Phase | Sequence[Phase], bits: int
) -> tuple[Balls, Balls]:
    """Return x and v at times, of the shape of these, with so many bits."""
    times, shape = exact_times(t)
    with precision(bits):
        states = [state(time) for time in times]
    return Balls.of((x for x, _ in states), shape), Balls.of((v for _, v in states), shape)


def exact_times(t: ArrayLike | Phase | Sequence[Phase]) -> tuple[list[Phase], tuple[int, ...]]:
    """Return times as a list, as exact as they were given, and their shape.

    Raises
    ------
    ParameterError
        If one is not a finite number.

    Examples
    --------
    >>> exact_times(["1/3", 0.5])
    (['1/3', 0.5], (2,))
    >>> exact_times("pi/2")
    (['pi/2'], ())
    """
    # As objects: NumPy would round fractions, and turn a list with a text into texts.
    array = np.asarray(t, dtype=object)
    times = []
    for value in array.reshape(-1):
        number = plain(value)
        problem = phase_problem(number)
        if problem is not None:
            raise ParameterError("t", number, problem)
        times.append(cast("Phase", number))
    return times, array.shape


def energy_of(system: BallSystem, state: BallPair) -> arb:
    """Return the kinetic energy and that of all springs."""
    x, v = state
    law = law_of(system)
    energy = (v * v + law.number("oscillator.stiffness") * x * x) / 2
    for i, stop in enumerate(system.oscillator.stops):
        if isinstance(stop, SoftStop):
            depth = _depth(system, i, x).max(arb(0))
            energy += law.number(f"oscillator.stops.{i}.stiffness") * depth * depth / 2
    return energy * law.mass


def forces_of(system: BallSystem, record: MarchRecord, time: Phase, state: BallPair) -> list[arb]:
    """Return spring, damping, forcing and the force of each stop."""
    x, v = state
    law, t = law_of(system), time_ball(time)
    spring = -law.number("oscillator.stiffness") * x
    damping = -2 * law.number("oscillator.damping") * v
    push = Push(law, 0, law.phasors_at(time), arb(0), 0)
    driving = sum((at for _, at, _ in push.drive), law.number("forcing.constant"))
    if law.record is not None:
        driving = driving + law.record.force_at(Moment.of(time))
    stops = [
        _soft(system, i, x, v) if isinstance(stop, SoftStop) else arb(0)
        for i, stop in enumerate(system.oscillator.stops)
    ]
    # A mass in contact does not accelerate: the wall's force balances all others.
    others = sum(stops, spring + damping + driving)
    for row in record.contacts:
        if t < row.start or (row.release is not None and t > row.release):
            continue
        sticks = t > row.start and (row.release is None or t < row.release)
        stops[row.stop] = -others if sticks else between(stops[row.stop], -others)
    return [force * law.mass for force in (spring, damping, driving, *stops)]


def _depth(system: BallSystem, stop: int, x: arb) -> arb:
    """Return the depth of the mass in a soft stop, negative outside of it."""
    depth = x - law_of(system).number(f"oscillator.stops.{stop}.at")
    return depth if system.oscillator.stops[stop].side == "above" else -depth


def _soft(system: BallSystem, stop: int, x: arb, v: arb) -> arb:
    """Return the force of a soft stop; of both sides where x may be on either."""
    depth = _depth(system, stop, x)
    if depth < 0:
        return arb(0)
    names = (f"oscillator.stops.{stop}.{name}" for name in ("at", "stiffness", "damping"))
    at, spring, drag = (law_of(system).number(name) for name in names)
    force = -spring * (x - at) - 2 * drag * v
    return force if depth > 0 else between(arb(0), force)
