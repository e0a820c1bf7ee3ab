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
from tests.oracle.curves import Flight, Force, Harmonic
from tests.oracle.event_driven import Soft, Wall, number
from tests.oracle.from_model import problem_of

import percuss as pc
from percuss.arrays import Floats
from percuss.model import Side

# A row of drawn numbers for each flight.
Draws = dict[str, Any]

# docs/theory/first-event.md: what rounding can do to a clearance, relative to the amplitude.
ROUNDING = 1e-13

ORDER = 12
SAMPLES = 128
HARMONICS = 4
DIGITS = 40


@dataclass(frozen=True)
class Truth:
    """What a flight does at its turning point."""

    t: float
    clearance: float
    first_root: float
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
        problem = problem_of(self.oscillator, self.forcing)
        x, v, t0 = (number(value) for value in self.start)
        a, k, constant = map(number, (problem.damping, problem.stiffness, problem.constant))
        for stop in problem.stops:
            if isinstance(stop, Soft) and (x - number(stop.at)) * inward_of(stop) > 0:
                a += number(stop.damping)
                k += number(stop.stiffness)
                constant += number(stop.stiffness) * number(stop.at)
        parts = tuple(Harmonic(number(h.omega), h.cos, h.sin) for h in problem.harmonics)
        flight = Flight(a, k, Force(constant, parts, t0), x, v, DIGITS)
        return flight, inward_of(problem.stops[self.stop])


def inward_of(stop: Wall | Soft) -> int:
    """Return the direction of motion into a stop."""
    return 1 if stop.side == "above" else -1


def near_grazing_cases(n: int, seed: int, *, self_excited: bool = False) -> Iterator[Case]:
    """Yield n cases: every linear regime, up to four harmonics, soft stops, one or two walls.

    Self-excited ones have negative damping, as far as they have any; real roots are slow then,
    since what grows by many powers of ten has no digits left of its start.
    """
    rng = np.random.default_rng(seed)
    while n > 0:
        draws = _draw(rng, 2048)
        if self_excited:
            slow = np.where(draws["a"] > 1.0, 0.1, 1.0)
            draws["k"], draws["a"] = slow**2 * draws["k"], -slow * draws["a"]
            draws["soft_a"] = -draws["soft_a"]
        bounces = _bounces(draws, draws["turn"], draws["level"])
        draws = {name: column[bounces] for name, column in draws.items()}
        kept = _flown_back(draws)
        for i in np.flatnonzero(kept.pop("good"))[:n]:
            yield _case({name: column[i] for name, column in (draws | kept).items()}, rng)
            n -= 1


def _draw(rng: np.random.Generator, n: int) -> Draws:
    """Return laws and turning points, for motion above a level; a case may mirror them."""
    kind = rng.integers(0, 6, n)
    light, heavy = rng.uniform(0, 0.5, n), rng.uniform(2.1, 4, n)
    critical = rng.random(n) < 0.5
    active = np.arange(HARMONICS) < rng.integers(1, HARMONICS + 1, n)[:, None]
    inside = rng.random(n) < 0.3
    return {
        "k": np.choose(kind, [1.0, rng.uniform(0.2, 9, n), 4.0, 0.0, 0.0, rng.uniform(-1, 0, n)]),
        "a": np.choose(kind, [0.0, light, np.where(critical, 2.0, heavy), 0.0, light, light]),
        # Of the soft stop in which the whole flight lies.
        "soft_k": np.where(inside, rng.uniform(0.5, 20, n), 0.0),
        "soft_a": np.where(inside, rng.uniform(0, 0.5, n) * rng.integers(0, 2, n), 0.0),
        "constant": rng.uniform(-1, 1, n),
        "size": np.where(active, rng.uniform(0.2, 1.5, (n, HARMONICS)), 0.0),
        "omega": rng.uniform(0.5, 5, (n, HARMONICS)),
        "phase": rng.uniform(-3, 3, (n, HARMONICS)),
        "level": rng.uniform(-2, 2, n) * rng.integers(0, 2, n),
        "turn": rng.uniform(2, 20, n) * np.where(rng.random(n) < 0.2, 50.0, 1.0),
        "back": rng.uniform(0.8, 2, n),
        "height": 10.0 ** rng.uniform(-15, -3, n) * rng.choice([-1.0, 1.0], n),
    }


def _bounces(d: Draws, t: Floats, x: Floats) -> NDArray[np.bool_]:
    """Tell where the force on a body at rest turns it back clearly."""
    bounces: NDArray[np.bool_] = _taylor(d, t, x, np.zeros(len(x)), 3)[2] > 0.1 * _span(d)
    return bounces


def _span(d: Draws) -> Floats:
    span: Floats = np.sum(d["size"], axis=1) + np.abs(d["constant"]) + 1.0
    return span


def _flown_back(d: Draws) -> Draws:
    """Return the starts, and which flights have their only narrow pass at the turning point.

    Samples are so close that the flight cannot reach the level between two of them, but near
    the turning point, where it is convex.
    """
    span = _span(d)
    good = np.ones(len(span), dtype=bool)
    highest = np.zeros(len(span))
    for length in (np.full(len(span), 0.4), -d["back"]):
        x, v = d["level"] + d["height"] * span, np.zeros(len(span))
        h = length / SAMPLES
        for i in range(SAMPLES + 1):
            c = _taylor(d, d["turn"] + i * h, x, v, ORDER)
            bend = 2 * c[2] / span
            clear = (x - d["level"] > 1e-3 * span) & (np.abs(bend) < 30)
            good &= np.where(np.abs(i * h) < 0.1, bend > 0.2, clear)
            highest = np.maximum(highest, np.abs(x - d["level"]))
            if i < SAMPLES:
                x, v = np.polyval(c[::-1], h), np.polyval((c.T * np.arange(ORDER)).T[:0:-1], h)
    return {"good": good, "x0": x, "v0": v, "highest": highest}


def _taylor(d: Draws, t: Floats, x: Floats, v: Floats, order: int) -> Floats:
    """Return the Taylor coefficients of x below an order, (order, n)."""
    a, k = d["a"] + d["soft_a"], d["k"] + d["soft_k"]
    turn = d["size"] * np.exp(1j * (d["omega"] * t[:, None] + d["phase"]))
    c = np.zeros((order, len(x)))
    c[0], c[1] = x, v
    for n in range(order - 2):
        drive = np.sum(turn.real, axis=1) + (d["constant"] if n == 0 else 0.0)
        c[n + 2] = (drive - 2 * a * (n + 1) * c[n + 1] - k * c[n]) / ((n + 1) * (n + 2))
        turn = turn * 1j * d["omega"] / (n + 1)
    return c


def _case(row: Draws, rng: np.random.Generator) -> Case:
    """Return the case of a row, with stops around its flight, mirrored at random."""
    mirror = rng.choice([-1.0, 1.0])
    below: Side = "below" if mirror == 1 else "above"
    above: Side = "above" if mirror == 1 else "below"
    level = float(mirror * row["level"])
    far = float(mirror * (row["level"] + row["highest"] + rng.uniform(0.01, 1)))
    constant = float(mirror * row["constant"])
    soft = bool(rng.random() < 0.3)
    grazed: pc.Wall | pc.SoftStop = (
        pc.SoftStop(level, below, float(rng.uniform(-1, 50)), float(rng.uniform(0, 1)))
        if soft
        else pc.Wall(level, below, float(rng.choice([0.0, 0.6, 1.0])))
    )
    stops: list[pc.Wall | pc.SoftStop] = [grazed]
    if row["soft_k"]:
        stops.append(pc.SoftStop(far, below, float(row["soft_k"]), float(row["soft_a"])))
        # What the stop adds is taken from the force, so that the flight is as it was built.
        constant -= float(row["soft_k"]) * far
    else:
        others: list[pc.Wall | pc.SoftStop | None]
        others = [pc.Wall(far, above, 0.8), pc.SoftStop(far, above, 30.0, 0.1), None]
        other = others[int(rng.integers(0, 3))]
        stops += [] if other is None else [other]
    if rng.random() < 0.5:
        stops.reverse()
    parts = tuple(
        pc.Harmonic(float(mirror * size), float(omega), float(phase))
        for size, omega, phase in zip(row["size"], row["omega"], row["phase"], strict=True)
        if size
    )
    return Case(
        oscillator=pc.Oscillator(float(row["k"]), float(row["a"]), tuple(stops)),
        forcing=pc.Forcing(parts, constant=constant),
        start=(
            float(mirror * row["x0"]),
            float(mirror * row["v0"]),
            float(row["turn"] - row["back"]),
        ),
        t_end=float(row["turn"] + 0.4),
        stop=stops.index(grazed),
        amplitude=float(abs(level) + row["highest"]),
        turn=float(row["turn"]),
    )


def faults_of(case: Case) -> list[str]:
    """Return what is wrong with the run of a case, rounding excused where it is listed."""
    truth = case.truth()
    run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=case.t_end, max_impacts=1)
    events = run.impacts if len(run.impacts) else run.crossings
    grazes = run.grazes
    wrong = []
    if (len(events) > 0) != (truth.clearance < 0):
        listed = any(
            row == case.stop and abs(clearance) <= bound
            for row, clearance, bound in zip(
                grazes.stop, grazes.clearance, grazes.error_bound, strict=True
            )
        )
        if abs(truth.clearance) > ROUNDING * case.amplitude or not listed:
            wrong.append(f"{case}: {len(events)} events, but the clearance is {truth.clearance}")
    elif len(events):
        # The height's rounding over the speed, and half an ulp of the time.
        late = abs(events.t[0] - truth.first_root) * truth.speed
        allowed = ROUNDING * case.amplitude + math.ulp(case.t_end) * truth.speed
        if events.stop[0] != case.stop or late > allowed:
            wrong.append(f"{case}: event at {events.t[0]}, not {truth.first_root}")
    for clearance, bound in zip(grazes.clearance, grazes.error_bound, strict=True):
        if not abs(clearance - truth.clearance) <= bound:
            wrong.append(f"{case}: clearance {clearance} +- {bound}, not {truth.clearance}")
    return wrong
