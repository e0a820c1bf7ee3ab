"""Oscillators, forcings and starts of every kind, drawn at random, and some at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import percuss as pc
from percuss.model import Side
from percuss.model.force_record import Outside, RecordKind


@dataclass(frozen=True)
class Motion:
    """What a call of `simulate` takes."""

    oscillator: pc.Oscillator
    forcing: pc.Forcing
    start: tuple[float, float, float]


def random_motion(seed: int) -> Motion:
    """Return one motion: any linear regime, up to two walls and two soft stops."""
    rng = np.random.default_rng(seed)
    k, a = [
        (1.0, 0.0),
        (rng.uniform(0.2, 9), rng.uniform(0, 0.5)),
        (4.0, 2.0),
        (rng.uniform(0.2, 4), rng.uniform(2.1, 4)),
        (0.0, 0.0),
        (0.0, rng.uniform(0, 0.5)),
        (-rng.uniform(0, 1), rng.uniform(0, 0.5)),
    ][rng.integers(0, 7)]
    low = -rng.uniform(0, 1.5) * rng.integers(0, 2)
    high = low + rng.uniform(0.3, 2)
    stops = _stops(rng, float(low), float(high))
    x = float(low + (high - low) * rng.uniform(0.05, 0.95))
    v = float(rng.uniform(-1.5, 1.5))
    if stops and rng.random() < 0.2:
        x = float(stops[0].at)
        v = v if rng.random() < 0.7 else 0.0
    t = rng.choice([0.0, rng.uniform(-3, 10)])
    return Motion(
        pc.Oscillator(float(k), float(a), tuple(stops)),
        _forcing(rng),
        (x, v, float(t)),
    )


def self_excited_motion(seed: int) -> Motion:
    """Return a motion with negative damping, of the oscillator, of soft stops or of both."""
    rng = np.random.default_rng([5, seed])
    motion = random_motion(seed + 2_000_000)
    k, a = [
        (1.0, rng.uniform(0.01, 0.3)),
        (rng.uniform(0.2, 9), rng.uniform(0, 0.5)),
        (0.25, 0.5),
        (rng.uniform(0.05, 0.3), rng.uniform(0.6, 0.8)),
        (0.0, rng.uniform(0.01, 0.5)),
        (-rng.uniform(0, 0.5), rng.uniform(0, 0.5)),
    ][rng.integers(0, 6)]
    stops = tuple(
        stop
        if isinstance(stop, pc.Wall) or rng.random() < 0.3
        else pc.SoftStop(stop.at, stop.side, stop.stiffness, -float(rng.uniform(0, 0.5)))
        for stop in motion.oscillator.stops
    )
    osc = pc.Oscillator(float(k), float(a if stops and rng.random() < 0.3 else -a), stops)
    return Motion(osc, motion.forcing, motion.start)


def _stops(rng: np.random.Generator, low: float, high: float) -> list[pc.Wall | pc.SoftStop]:
    stops: list[pc.Wall | pc.SoftStop] = []
    if rng.random() < 0.75:
        stops.append(pc.Wall(low, "below", float(rng.choice([0.0, 0.3, 0.6, 0.8, 0.9, 1.0]))))
    if rng.random() < 0.4:
        stops.append(pc.Wall(high, "above", float(rng.choice([0.0, 0.3, 0.6, 0.8, 1.0]))))
    for _ in range(rng.integers(0, 3)):
        # Some lie at the same place.
        part = rng.uniform(0.1, 0.9) if rng.random() < 0.8 else 0.5
        stiffness = rng.choice([rng.uniform(-1, 3), rng.uniform(5, 200)])
        damping = rng.choice([0.0, rng.uniform(0, 1)])
        side: Side = "below" if rng.random() < 0.5 else "above"
        at = low + (high - low) * float(part)
        stops.append(pc.SoftStop(at, side, float(stiffness), float(damping)))
    return [stops[i] for i in rng.permutation(len(stops))]


def _forcing(rng: np.random.Generator) -> pc.Forcing:
    parts = []
    for _ in range(rng.integers(0, 4)):
        omega = rng.uniform(0.5, 5) if rng.random() < 0.8 else rng.choice([1.0, 2.0, 3.0])
        quarter = pc.pi_times(int(rng.integers(-2, 3)), 2)
        phase = float(rng.uniform(-3, 3)) if rng.random() < 0.7 else quarter
        parts.append(pc.Harmonic(float(rng.uniform(0.2, 1.5)), float(omega), phase))
    return pc.Forcing(tuple(parts), constant=float(rng.choice([0.0, rng.uniform(-1, 1)])))


def with_tables(motion: Motion, seed: int) -> Motion:
    """Return a motion with restitutions that depend on the speed."""
    rng = np.random.default_rng([3, seed])

    def table() -> pc.model.RestitutionTable:
        n = int(rng.integers(1, 5))
        speeds = np.cumsum(rng.uniform(0.05, 0.8, n)) - (0.05 if rng.random() < 0.5 else 0.0)
        values = rng.uniform(0.2, 1.0, n)
        for i in range(1, n):
            # Not so steep that a faster impact leaves slower: both ends of each piece decide.
            share = float(speeds[i - 1] / speeds[i])
            values[i] = max(values[i], values[i - 1] * 0.5 * (1.0 + share))
            most = values[i - 1] * (1.0 + 0.9 * (1.0 - share) / share) if share > 0.0 else 1.0
            values[i] = min(values[i], most)
        return pc.restitution_table(speeds, values)

    stops = tuple(
        pc.Wall(stop.at, stop.side, table()) if isinstance(stop, pc.Wall) else stop
        for stop in motion.oscillator.stops
    )
    osc = pc.Oscillator(motion.oscillator.stiffness, motion.oscillator.damping, stops)
    return Motion(osc, motion.forcing, motion.start)


_SOFT, _WALL = pc.SoftStop(0.0, "below", 3.0), pc.Wall(0.0, "below", 0.5)
_SPRING, _NO_SPRING = 1.0, 0.0

# Starts at, or flights away from, a stop where no force acts: nothing must happen there twice.
FORCE_FREE = {
    f"{what}, k = {k:g}": Motion(pc.Oscillator(k, 0.0, (stop,)), pc.Forcing(), start)
    for k in (_SPRING, _NO_SPRING)
    for what, stop, start in (
        ("at rest on the edge of a soft stop", _SOFT, (0.0, 0.0, 0.0)),
        ("at rest on a wall", _WALL, (0.0, 0.0, 0.0)),
        ("away from a soft stop", _SOFT, (0.0, 1.0, 0.0)),
        ("away from a wall", _WALL, (0.0, 1.0, 0.0)),
        ("into a soft stop", _SOFT, (1.0, -1.0, 0.0)),
        ("into a wall", _WALL, (1.0, -1.0, 0.0)),
    )
}


def chattering_motion(seed: int) -> Motion:
    """Return a motion that is pressed to a wall for a part of the time: most come to rest there."""
    rng = np.random.default_rng([7, seed])
    k, a = [
        (1.0, 0.0),
        (1.0, 0.05),
        (float(rng.uniform(0.2, 6)), float(rng.uniform(0, 0.5))),
        (0.0, 0.0),
        (4.0, 2.0),
        (-0.3, 0.1),
    ][rng.integers(6)]
    wall = float(rng.choice([0.0, rng.uniform(-0.5, 0.5)]))
    omega = float(rng.uniform(0.5, 4))
    force = pc.cosine(omega, constant=float(rng.uniform(-1.5, -0.5)))
    if rng.random() < 0.4:
        force = force + pc.sine(2 * omega, amplitude=float(rng.uniform(0.2, 1)))
    restitution = float(rng.choice([0.0, 0.01, 0.2, 0.5, 0.7, 0.8, 0.9]))
    stops: list[pc.Wall | pc.SoftStop] = [pc.Wall(wall, "below", restitution)]
    if rng.random() < 0.3:
        stops.append(pc.SoftStop(wall + 0.5, "above", float(rng.uniform(1, 30)), 0.1))
    start = (wall + float(rng.uniform(0, 1)), float(rng.uniform(-1, 1)), 0.0)
    return Motion(pc.Oscillator(k, a, tuple(stops)), force, start)


def hard_motion(seed: int) -> Motion:
    """Return a motion of the kinds that are hard to follow, one in six of each.

    Grazing starts, two impacts a hair apart, resonance and its neighbourhood, critical damping
    and what lies beside it, starts at rest on a stop, and any other.
    """
    rng = np.random.default_rng([11, seed])
    motion = random_motion(seed + 1_000_000)
    osc, force, (x, v, t) = motion.oscillator, motion.forcing, motion.start
    kind = int(rng.integers(6))
    hair = float(10.0 ** rng.uniform(-14, -3) * rng.choice([-1.0, 1.0]))
    restitution = float(rng.choice([0.0, 1e-3, 0.8, 1.0]))
    if kind == 0:
        # x = cos t turns at -1, a hair before the wall or behind it.
        osc = pc.Oscillator(1.0, 0.0, (pc.Wall(-1.0 + hair, "below", restitution),))
        force, (x, v, t) = pc.cosine(float(rng.uniform(2, 4)), amplitude=1e-9), (1.0, 0.0, 0.0)
    elif kind == 1:
        # Two walls a hair apart, and a soft stop a hair before one of them.
        low = float(rng.uniform(-0.5, 0.5))
        stops = [pc.Wall(low, "below", restitution), pc.Wall(low + abs(hair), "above", 0.8)]
        if rng.random() < 0.5:
            stops = [pc.Wall(low, "below", restitution)]
            stops.append(pc.SoftStop(low + abs(hair), "below", float(rng.uniform(1, 50)), 0.1))  # type: ignore[arg-type]
        x = low + 0.5 * abs(hair)
        osc = pc.Oscillator(osc.stiffness, osc.damping, tuple(stops))
        v = v if abs(hair) > 1e-6 or len(osc.stops) == 2 else -abs(v)
    elif kind in (2, 3):
        omega = float(rng.uniform(0.5, 3))
        k, a = omega**2 * (1.0 + float(rng.choice([0.0, hair]))), float(rng.choice([0.0, 1e-9]))
        if kind == 3:
            a = math.sqrt(k) * (1.0 + float(rng.choice([0.0, hair])))
        osc = pc.Oscillator(k, a, osc.stops)
        force = pc.cosine(omega, constant=float(rng.choice([0.0, -0.5])))
    elif kind == 4 and osc.stops:
        x, v = float(osc.stops[0].at), 0.0
    return Motion(osc, force, (x, v, t))


def with_record(motion: Motion, seed: int) -> Motion:
    """Return a motion with a record added to its force, once or repeated, of any spacing."""
    rng = np.random.default_rng([13, seed])
    spacing = float(10.0 ** rng.uniform(-2.0, 0.5))
    n = int(rng.integers(2, 40))
    t = motion.start[2] + float(rng.uniform(-2, 3)) + np.cumsum(rng.exponential(spacing, n))
    f = rng.normal(size=n) * float(rng.choice([0.3, 1.0, 3.0]))
    if rng.random() < 0.3:
        # Plateaus, ramps that meet, and forces of exactly zero.
        f = np.round(f)
    kind: RecordKind = "linear" if rng.random() < 0.6 else "hold"
    repeat = bool(rng.random() < 0.3 and t[-1] - t[0] > 0.5)
    outside: Outside = "end" if rng.random() < 0.5 else "zero"
    record = pc.record(t - t[0] if repeat else t, f, kind, repeat, outside)
    force = motion.forcing if rng.random() < 0.5 else pc.Forcing()
    return Motion(motion.oscillator, force + record, motion.start)
