"""Flights that almost touch a stop, or just do: the hardest first events.

A flight is built backwards from a turning point that lies a chosen height above or below a stop,
in doubles and for many flights at once, by Taylor series. What then is true, on the exact
doubles, is decided afterwards in 40 digits; only the few roundings of the construction lie
between the height asked for and the true one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

import percuss as pc
from tests.oracle.curves import Flight, Force, Harmonic

Floats = NDArray[np.float64]
# A row of drawn numbers for each flight.
Draws = dict[str, Any]

ORDER = 16
SAMPLES = 192
HARMONICS = 4
DIGITS = 40


@dataclass(frozen=True)
class Truth:
    """What a flight does at its turning point."""

    t: float
    clearance: float
    first_touch: float
    speed: float


@dataclass(frozen=True)
class Case:
    """A start whose first event, if there is one before ``t_end``, is a shallow touch."""

    oscillator: pc.Oscillator
    forcing: pc.Forcing
    start: tuple[float, float, float]
    t_end: float
    stop: int
    amplitude: float
    turn: float

    def truth(self) -> Truth:
        """Return the turning point and the first touch of the exact doubles, in 40 digits."""
        with mpmath.workdps(4 * DIGITS + 20):
            flight, inward = self._flight()
            level = mpmath.mpf(float(self.oscillator.stops[self.stop].at))
            s = mpmath.mpf(self.turn - self.start[2])
            for _ in range(7):
                _, v, half = flight.taylor(s, 2)
                s -= v / (2 * half)
            clearance = inward * (level - flight.value(s))
            touch, speed = mpmath.nan, mpmath.mpf(0)
            if clearance < 0:
                touch = s - mpmath.sqrt(-clearance / abs(half))
                for _ in range(9):
                    x, speed = flight.state(touch)
                    touch -= (x - level) / speed
            t0 = mpmath.mpf(self.start[2])
            return Truth(float(t0 + s), float(clearance), float(t0 + touch), float(abs(speed)))

    def _flight(self) -> tuple[Flight, int]:
        x, v, t0 = (mpmath.mpf(value) for value in self.start)
        a, k = mpmath.mpf(self.oscillator.damping), mpmath.mpf(self.oscillator.stiffness)
        constant = mpmath.mpf(self.forcing.constant)
        for stop in self.oscillator.stops:
            if isinstance(stop, pc.SoftStop) and (x - stop.at) * inward_of(stop) > 0:
                a += mpmath.mpf(stop.damping)
                k += mpmath.mpf(stop.stiffness)
                constant += mpmath.mpf(stop.stiffness) * mpmath.mpf(stop.at)
        parts = []
        for h in self.forcing.harmonics:
            c, s = mpmath.cos_sin(mpmath.mpf(h.phase))
            parts.append(Harmonic(mpmath.mpf(h.omega), h.amplitude * c, -h.amplitude * s))
        flight = Flight(a, k, Force(constant, tuple(parts), t0), x, v, DIGITS)
        return flight, inward_of(self.oscillator.stops[self.stop])


def inward_of(stop: pc.Wall | pc.SoftStop) -> int:
    """Return the direction of motion into a stop."""
    return 1 if stop.side == "above" else -1


def near_grazing_cases(n: int, seed: int) -> Iterator[Case]:
    """Yield n cases: every linear regime, up to four harmonics, soft stops, one or two walls."""
    rng = np.random.default_rng(seed)
    while n > 0:
        draws = _draw(rng, 512)
        kept = _kept(draws)
        for i in np.flatnonzero(kept["good"])[:n]:
            yield _case({name: column[i] for name, column in (draws | kept).items()}, rng)
            n -= 1


def _draw(rng: np.random.Generator, n: int) -> Draws:
    """Return laws and turning points for motion above a level, mirrored later."""
    kind = rng.integers(0, 6, n)
    k = np.choose(kind, [1.0, rng.uniform(0.2, 9, n), 4.0, 0.0, 0.0, rng.uniform(-1, -0.1, n)])
    light, heavy = rng.uniform(0, 0.5, n), rng.uniform(2.1, 4, n)
    a = np.choose(kind, [0.0, light, np.where(rng.random(n) < 0.5, 2.0, heavy), 0.0, light, light])
    active = np.arange(HARMONICS) < rng.integers(1, HARMONICS + 1, n)[:, None]
    size = np.where(active, rng.uniform(0.2, 1.5, (n, HARMONICS)), 0.0)
    return {
        "k": k,
        "a": a,
        "constant": rng.uniform(-1, 1, n),
        "size": size,
        "omega": rng.uniform(0.5, 5, (n, HARMONICS)),
        "phase": rng.uniform(-3, 3, (n, HARMONICS)),
        "soft_k": np.where(rng.random(n) < 0.3, rng.uniform(0.5, 20, n), 0.0),
        "soft_a": rng.uniform(0, 0.5, n) * rng.integers(0, 2, n),
        "soft_beyond": rng.uniform(0.1, 1, n),
        "level": rng.uniform(-2, 2, n) * rng.integers(0, 2, n),
        "turn": rng.uniform(2, 20, n) * np.where(rng.random(n) < 0.2, 50.0, 1.0),
        "back": rng.uniform(0.8, 2, n),
        "height": 10.0 ** rng.uniform(-15, -3, n) * rng.choice([-1.0, 1.0], n),
    }


def _kept(d: Draws) -> Draws:
    """Return the starts, and which flights have their only narrow pass at the turning point."""
    # The soft stop in which the whole flight lies acts below its place `soft_beyond` over all x.
    span = np.sum(d["size"], axis=1) + np.abs(d["constant"]) + 1.0
    height = d["height"] * span
    place = d["level"] + 40.0 * span + d["soft_beyond"]
    inside = d["soft_k"] > 0
    law = (
        d["a"] + np.where(inside, d["soft_a"], 0.0),
        d["k"] + d["soft_k"],
        d["constant"] + d["soft_k"] * place,
    )
    good = np.ones(len(span), dtype=bool)
    ends = []
    highest = np.zeros(len(span))
    for length in (-d["back"], np.full(len(span), 0.4)):
        x, v = d["level"] + height, np.zeros(len(span))
        h = length / SAMPLES
        for i in range(SAMPLES):
            c = _taylor(d, law, d["turn"] + i * h, x, v)
            near = np.abs(i * h) < 0.1
            clear = (x - d["level"] > 1e-3 * span) & (np.abs(2 * c[2]) < 60 * span)
            good &= np.where(near, 2 * c[2] > 0.2 * span, clear)
            highest = np.maximum(highest, np.abs(x - d["level"]))
            x, v = np.polyval(c[::-1], h), np.polyval((c * np.arange(ORDER)[:, None])[:0:-1], h)
        ends.append((x, v))
    # The place of the soft stop is beyond all of the flight.
    good &= highest < 39.0 * span
    (x, v), _ = ends
    return {"good": good, "x0": x, "v0": v, "place": place, "highest": highest}


def _taylor(d: Draws, law: tuple[Floats, Floats, Floats], t: Floats, x: Floats, v: Floats) -> Floats:
    """Return the Taylor coefficients of x, (ORDER, n)."""
    a, k, constant = law
    angle = d["omega"] * t[:, None] + d["phase"]
    c = np.zeros((ORDER, len(x)))
    c[0], c[1] = x, v
    turn = d["size"] * np.exp(1j * angle)
    for n in range(ORDER - 2):
        drive = np.sum(turn.real, axis=1) + (constant if n == 0 else 0.0)
        c[n + 2] = (drive - 2 * a * (n + 1) * c[n + 1] - k * c[n]) / ((n + 1) * (n + 2))
        turn = turn * 1j * d["omega"] / (n + 1)
    return c


def _case(row: Draws, rng: np.random.Generator) -> Case:
    """Return the case of a row, with its stops, mirrored at random."""
    mirror = int(rng.choice([-1, 1]))
    below, above = ("below", "above") if mirror == 1 else ("above", "below")
    level = float(mirror * row["level"])
    far = float(mirror * (row["level"] + row["highest"] + rng.uniform(0.01, 1)))
    inside = row["soft_k"] > 0
    place = float(mirror * row["place"])
    grazed: list[pc.Wall | pc.SoftStop] = [
        pc.Wall(level, below, float(rng.choice([0.0, 0.6, 1.0]))),
        pc.SoftStop(level, below, float(rng.uniform(-1, 50)), float(rng.uniform(0, 1))),
    ]
    stops = [grazed[int(rng.random() < 0.3)]]
    if inside:
        soft = pc.SoftStop(place, below, float(row["soft_k"]), float(row["soft_a"]))
        stops.insert(int(rng.integers(0, 2)), soft)
    elif rng.random() < 0.5:
        stops.append(pc.Wall(far, above, 0.8))
    elif rng.random() < 0.5:
        stops.insert(0, pc.SoftStop(far, above, 30.0, 0.1))
    number = next(i for i, stop in enumerate(stops) if stop.at == level)
    parts = tuple(
        pc.Harmonic(float(mirror * size), float(omega), float(phase))
        for size, omega, phase in zip(row["size"], row["omega"], row["phase"], strict=True)
        if size
    )
    return Case(
        pc.Oscillator(float(row["k"]), float(row["a"]), tuple(stops)),
        pc.Forcing(parts, constant=float(mirror * row["constant"])),
        (float(mirror * row["x0"]), float(mirror * row["v0"]), float(row["turn"] - row["back"])),
        float(row["turn"] + 0.4),
        number,
        float(abs(level) + row["highest"]),
        float(row["turn"]),
    )
