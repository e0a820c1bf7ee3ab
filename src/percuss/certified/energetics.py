"""Forces and energy of a certified motion, as balls."""

from __future__ import annotations

from flint import arb

from percuss.certified.cloud import Pair
from percuss.certified.flight import Push
from percuss.certified.law import law_of
from percuss.certified.numbers import between, time_ball
from percuss.certified.record import MarchRecord
from percuss.certified.system import System
from percuss.model.exact import Phase
from percuss.model.stops import SoftStop

__all__ = ["energy_of", "forces_of"]


def energy_of(system: System, state: Pair) -> arb:
    """Return the kinetic energy and that of all springs, per unit mass."""
    x, v = state
    law = law_of(system)
    energy = (v * v + law.number("oscillator.stiffness") * x * x) / 2
    for i, stop in enumerate(system.oscillator.stops):
        if isinstance(stop, SoftStop):
            # Zero where x is not beyond it, and continuous there.
            beyond = _depth(system, i, x).max(arb(0))
            energy += law.number(f"oscillator.stops.{i}.stiffness") * beyond * beyond / 2
    return energy


def forces_of(system: System, record: MarchRecord, time: Phase, state: Pair) -> list[arb]:
    """Return spring, damping, forcing and the force of each stop, per unit mass."""
    x, v = state
    law, t = law_of(system), time_ball(time)
    spring = -law.number("oscillator.stiffness") * x
    damping = -2 * law.number("oscillator.damping") * v
    push = Push(law, 0, law.turns_at(time), arb(0), 0)
    driving = sum((at for _, at, _ in push.drive), law.number("forcing.constant"))
    stops = [
        _soft(system, i, x, v) if isinstance(stop, SoftStop) else arb(0)
        for i, stop in enumerate(system.oscillator.stops)
    ]
    # A mass that is held does not accelerate: the wall takes what all others leave.
    others = sum(stops, spring + damping + driving)
    for row in record.contacts:
        if t < row.start or (row.release is not None and t > row.release):
            continue
        held = t > row.start and (row.release is None or t < row.release)
        stops[row.stop] = -others if held else between(stops[row.stop], -others)
    return [spring, damping, driving, *stops]


def _depth(system: System, stop: int, x: arb) -> arb:
    """Return how far beyond a stop's edge the mass is."""
    depth = x - law_of(system).number(f"oscillator.stops.{stop}.at")
    return depth if system.oscillator.stops[stop].side == "above" else -depth


def _soft(system: System, stop: int, x: arb, v: arb) -> arb:
    """Return the force of a soft stop; of both sides where x may be on either."""
    depth = _depth(system, stop, x)
    if depth < 0:
        return arb(0)
    names = (f"oscillator.stops.{stop}.{name}" for name in ("at", "stiffness", "damping"))
    at, spring, drag = (law_of(system).number(name) for name in names)
    force = -spring * (x - at) - 2 * drag * v
    return force if depth > 0 else between(arb(0), force)
