"""Structures, loads and starts of every kind, drawn at random, and walls that motions nearly graze."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

import percuss as pc
from percuss.arrays import Floats
from percuss.model import Side

KINDS = (
    "proportional damping",
    "damping of any kind",
    "free masses",
    "unstable stiffness",
    "gyroscopic",
    "circulatory",
    "coupled masses",
    "records",
    "pressed to a wall",
    "corner",
)


@dataclass(frozen=True)
class StructureMotion:
    """What a call of `simulate` takes, and until when."""

    kind: str
    structure: pc.Structure
    loads: pc.Loads
    x0: tuple[float, ...]
    v0: tuple[float, ...]
    t0: float
    t_end: float


def random_structure(seed: int) -> StructureMotion:
    """Return one motion of 2 to 10 masses, of each kind in turn."""
    rng = np.random.default_rng([17, seed])
    kind = KINDS[seed % len(KINDS)]
    n = int(rng.integers(2, 11))
    mass, damping, stiffness = _matrices(rng, kind, n)
    structure = pc.Structure(mass, stiffness, damping, _stops(rng, kind, n))
    x0 = rng.uniform(-0.02, 0.02, n)
    v0 = rng.uniform(-1.0, 1.0, n) * float(rng.choice([0.3, 1.0]))
    t0 = float(rng.choice([0.0, rng.uniform(-3, 10)]))
    return StructureMotion(
        kind, structure, _loads(rng, kind, n), tuple(x0.tolist()), tuple(v0.tolist()), t0, t0 + 12.0
    )


def _matrices(rng: np.random.Generator, kind: str, n: int) -> tuple[Floats, Floats, Floats]:
    masses = rng.uniform(0.3, 2.0, n)
    springs = rng.uniform(0.5, 6.0, n + 1)
    dashpots = 0.02 * springs
    if kind == "free masses":
        springs[:] = springs * (rng.random(n + 1) < 0.4)
        springs[0] = springs[-1] = 0.0
        dashpots[:] = 0.02 * springs
        if rng.random() < 0.5:
            # To the ground too, where no spring is.
            dashpots[:] = rng.uniform(0.0, 0.4, n + 1)
    elif kind == "unstable stiffness":
        springs[0] = -rng.uniform(0.1, 0.6)
        springs[-1] = 0.0
    elif kind != "proportional damping":
        dashpots = rng.uniform(0.0, 0.4, n + 1) * (rng.random(n + 1) < 0.6)
    mass, stiffness, damping = np.diag(masses), chain_matrix(springs), chain_matrix(dashpots)
    # Springs between any two masses.
    for _ in range(n // 3):
        i, j = rng.choice(n, 2, replace=False)
        stiffness += float(rng.uniform(0.2, 2.0)) * _between(n, int(i), int(j))
    if kind == "gyroscopic":
        skew = np.triu(rng.uniform(-0.8, 0.8, (n, n)), 1)
        damping += skew - skew.T
    elif kind == "circulatory":
        skew = np.triu(rng.uniform(-0.2, 0.2, (n, n)), 1)
        stiffness += skew - skew.T
    elif kind == "coupled masses":
        root = rng.normal(size=(n, n)) * 0.3
        # Exactly symmetric: products of the same doubles in the same order.
        mass = mass + np.array([[float((a * b).sum()) for b in root] for a in root])
        mass = np.triu(mass) + np.triu(mass, 1).T
    return mass, damping, stiffness


def chain_matrix(joints: Floats) -> Floats:
    n = len(joints) - 1
    matrix = np.diag(joints[:-1] + joints[1:])
    return matrix - np.diag(joints[1:n], 1) - np.diag(joints[1:n], -1)


def _between(n: int, i: int, j: int) -> Floats:
    row = np.zeros(n)
    row[i], row[j] = 1.0, -1.0
    return np.outer(row, row)


def _stops(rng: np.random.Generator, kind: str, n: int) -> list[pc.Wall | pc.SoftStop]:
    lines: list[Any] = [0, n - 1]
    lines += [tuple(_difference(n, i, i + 1)) for i in rng.choice(n - 1, min(2, n - 1), False)]
    if kind == "coupled masses":
        lines.append(tuple(float(c) for c in rng.uniform(-1.0, 1.0, n)))
    order = rng.permutation(len(lines))[: int(rng.integers(1, 4))]
    restitutions = [0.0, 0.3, 0.6, 0.8, 0.9, 1.0]
    if kind == "corner":
        # No impact ends the motion of one mass while another one's begins at the same instant.
        order, restitutions = np.arange(len(lines)), [0.5, 0.7]
    stops: list[pc.Wall | pc.SoftStop] = []
    for index in order:
        on = lines[index]
        side: Side = "below" if rng.random() < 0.5 else "above"
        sign = -1.0 if side == "below" else 1.0
        at = sign * float(rng.uniform(0.1, 0.3))
        if kind == "pressed to a wall":
            side, at, restitutions = "below", -0.1, [0.0, 0.2, 0.5, 0.7]
        if rng.random() < 0.6 or kind in ("pressed to a wall", "corner"):
            stops.append(pc.Wall(at, side, float(rng.choice(restitutions)), on=on))
        else:
            k = float(rng.choice([rng.uniform(1, 5), rng.uniform(20, 200)]))
            c = float(rng.choice([0.0, rng.uniform(0, 1)]))
            stops.append(pc.SoftStop(at, side, k, c, on=on))
        if rng.random() < 0.3:
            other: Side = "above" if side == "below" else "below"
            stops.append(pc.SoftStop(-at, other, float(rng.uniform(5, 50)), 0.1, on=on))
    return stops


def _difference(n: int, i: int, j: int) -> list[float]:
    row = [0.0] * n
    row[i], row[j] = 1.0, -1.0
    return row


def _loads(rng: np.random.Generator, kind: str, n: int) -> pc.Loads:
    loads: list[tuple[Any, pc.Forcing]] = []
    for _ in range(int(rng.integers(1, 4))):
        on: Any = int(rng.integers(n))
        if rng.random() < 0.3:
            on = tuple(float(c) for c in rng.uniform(-1.0, 1.0, n))
        force = pc.cosine(
            float(rng.uniform(0.5, 5.0)),
            float(rng.uniform(0.2, 1.5)),
            float(rng.uniform(-3.0, 3.0)),
            constant=float(rng.choice([0.0, rng.uniform(-0.5, 0.5)])),
        )
        if rng.random() < 0.4:
            force = force + pc.sine(float(rng.uniform(0.5, 5.0)), float(rng.uniform(0.2, 1.0)))
        loads.append((on, force))
    if kind == "pressed to a wall":
        loads.append((tuple([1.0] * n), pc.Forcing(constant=-float(rng.uniform(1.0, 2.0)))))
    if kind == "records":
        m = int(rng.integers(3, 20))
        t = np.cumsum(rng.exponential(0.6, m))
        f = rng.normal(size=m)
        style: Any = "linear" if rng.random() < 0.5 else "hold"
        repeat = bool(rng.random() < 0.5)
        loads.append((int(rng.integers(n)), pc.record(t, f, style, repeat)))
    return pc.Loads(loads)


@dataclass(frozen=True)
class NearGraze:
    """A motion of modes whose clearance to a wall nearly vanishes at one minimum.

    Before it the wall is farther. ``depth`` is how far the motion would pass the wall, negative
    where it misses it; ``amplitude`` the size of the motion at the wall; ``t`` the impact, or the
    instant of the minimum where there is none.
    """

    structure: pc.Structure
    loads: pc.Loads
    x0: tuple[float, ...]
    v0: tuple[float, ...]
    t_end: float
    place: float
    depth: mpf
    amplitude: float
    t: mpf

    @property
    def hits(self) -> bool:
        """Whether there is an impact up to a little after the minimum."""
        return bool(self.depth > 0)


def near_graze(seed: int) -> NearGraze:
    """Return a motion of 2 to 6 modes and a wall at a depth of 1e-13 to 1e-6 of the amplitude.

    Modes have M = 1 and diagonal C and K, so that the motion is a sum of closed forms: here at 50
    digits, of the same doubles. The wall is a double too, and the depth that which it leaves.
    """
    rng = np.random.default_rng([19, seed])
    n = int(rng.integers(2, 7))
    found = None
    while found is None:
        rates = rng.uniform(0.5, 8.0, n)
        k, c = rates**2, 2.0 * rates * rng.choice([0.0, 0.003, 0.05], n)
        shape = rng.uniform(-1.0, 1.0, n)
        x0, v0 = rng.uniform(-1.0, 1.0, n), rng.uniform(-1.0, 1.0, n) * rates
        drives = [
            (int(rng.integers(n)), float(rng.uniform(0.5, 8.0)), float(rng.uniform(0.2, 2.0)))
            for _ in range(int(rng.integers(0, 3)))
        ]
        closed = _Modes(k, c, shape, x0, v0, drives)
        found = _deepest(closed)
    t, amplitude = found
    with mpmath.workdps(50):
        for _ in range(8):
            _, slope, bend = closed.at(t)
            t -= slope / bend
        lowest = closed.at(t)[0]
        asked = float(amplitude * 10.0 ** rng.uniform(-13, -6) * rng.choice([-1.0, 1.0]))
        place = float(lowest + asked)
        depth = mpf(place) - lowest
        t_hit = _first_passage(closed, t, mpf(place), depth) if depth > 0 else t
    loads = pc.Loads([(i, pc.cosine(w, amplitude=size)) for i, w, size in drives])
    wall = pc.Wall(place, "below", 0.8, on=tuple(shape.tolist()))
    structure = pc.Structure([1.0] * n, k, c, [wall])
    end = float(t) + 1e-2 / float(rates.max())
    start = tuple(x0.tolist()), tuple(v0.tolist())
    return NearGraze(structure, loads, *start, end, place, depth, amplitude, t_hit)


class _Modes:
    """The closed form of y = shape . x of modes that start somewhere and are driven."""

    def __init__(self, k: Floats, c: Floats, shape: Floats, x0: Floats, v0: Floats,
                 drives: list[tuple[int, float, float]]) -> None:  # fmt: skip
        # Sums of size e^(rate t) cos or sin(omega t): rows rate, omega, cos, sin.
        self.terms: list[tuple[mpf, mpf, mpf, mpf]] = []
        with mpmath.workdps(50):
            for j, (kj, cj, sj, x, v) in enumerate(
                zip(*(a.tolist() for a in (k, c, shape, x0, v0)), strict=True)
            ):
                rest, speed = mpf(x), mpf(v)
                for i, w, size in drives:
                    if i != j:
                        continue
                    gap, drag = mpf(kj) - mpf(w) ** 2, mpf(cj) * mpf(w)
                    scale = mpf(size) / (gap**2 + drag**2)
                    cos, sin = scale * gap, scale * drag
                    self.terms.append((mpf(0), mpf(w), sj * cos, sj * sin))
                    rest -= cos
                    speed -= sin * mpf(w)
                decay = -mpf(cj) / 2
                turn = mpmath.sqrt(mpf(kj) - decay**2)
                self.terms.append((decay, turn, sj * rest, sj * (speed - decay * rest) / turn))
        self.floats = np.array([[float(e) for e in term] for term in self.terms])

    def at(self, t: Any) -> tuple[mpf, mpf, mpf]:
        """Return y, y' and y'' at the working precision."""
        y = slope = bend = mpf(0)
        for decay, turn, cos, sin in self.terms:
            size = mpmath.exp(decay * t)
            c, s = mpmath.cos_sin(turn * t)
            # Of the real part of (cos - i sin) e^(z t), z = decay + i turn, times z and z^2.
            a, b = size * (cos * c + sin * s), size * (cos * s - sin * c)
            y += a
            slope += decay * a - turn * b
            bend += (decay**2 - turn**2) * a - 2 * decay * turn * b
        return y, slope, bend

    def sampled(self, t: Floats) -> Floats:
        """Return y in doubles."""
        decay, turn, cos, sin = self.floats.T[:, :, None]
        waves = cos * np.cos(turn * t) + sin * np.sin(turn * t)
        return np.asarray((np.exp(decay * t) * waves).sum(axis=0))


def _deepest(closed: _Modes) -> tuple[Any, float] | None:
    """Return the instant of the least y up to t = 8 and the amplitude; None if it is no minimum.

    Before it y stays farther away by a ten-thousandth of the amplitude, more than the samples miss.
    """
    t = np.linspace(0.0, 8.0, 8001)
    y = closed.sampled(t)
    amplitude, i = float(np.abs(y).max()), int(y.argmin())
    minima = np.flatnonzero((y[1:-1] < y[:-2]) & (y[1:-1] <= y[2:])) + 1
    others = [y[0], *y[minima[minima < i]]]
    if i not in minima or min(others) < y[i] + 1e-4 * amplitude:
        return None
    return mpf(float(t[i])), amplitude


def _first_passage(closed: _Modes, t: Any, place: Any, depth: Any) -> Any:
    """Return the root before a minimum that lies a small depth below the wall."""
    bend = closed.at(t)[2]
    root = t - mpmath.sqrt(2 * depth / bend)
    for _ in range(60):
        y, slope, _ = closed.at(root)
        step = (y - place) / slope
        root -= step
        if abs(step) < mpf("1e-40"):
            return root
    raise RuntimeError("the passage of the wall was not found")
