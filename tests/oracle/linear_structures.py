"""Structures without stops, of every kind that mass, damping and stiffness can be of.

The motion is the exponential of the equation's matrix, by Arb's matrix exponential in balls: no
mode and no decomposition takes part.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx, fmpq
from tests.oracle.random_structures import chain_matrix

import percuss as pc
from percuss.arrays import Floats
from percuss.model import as_fraction

KINDS = (
    "proportional",
    "commuting",
    "critical",
    "overdamped",
    "gyroscopic",
    "strongly gyroscopic",
    "free masses",
    "free gyroscopic masses",
    "unstable",
    "equal frequencies",
    "nearly equal frequencies",
    "graded stiffness",
    "finite elements",
    "finite elements with a dashpot",
    "coupled critical",
    "coupled overdamped",
    "circulatory",
    "one large dashpot",
    "masses of any size",
    "defective",
)
Rows = list[list[Any]]


@dataclass(frozen=True)
class LinearMotion:
    """A structure and a start."""

    kind: str
    structure: pc.Structure
    x0: Floats
    v0: Floats

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """Return x and x' at t: those of the matrix exponential, rounded once."""
        n, structure = self.structure.n, self.structure
        before, ctx.prec = ctx.prec, 240
        try:
            mass, damping, stiffness = (
                arb_mat([[_ball(entry) for entry in row] for row in matrix])
                for matrix in (structure.mass, structure.damping, structure.stiffness)
            )
            back = mass.inv()
            pull, drag = back * stiffness, back * damping
            matrix = arb_mat(2 * n, 2 * n)
            for i in range(n):
                matrix[i, n + i] = 1
                for j in range(n):
                    matrix[n + i, j], matrix[n + i, n + j] = -pull[i, j], -drag[i, j]
            start = arb_mat([[e] for e in [*self.x0.tolist(), *self.v0.tolist()]])
            end = (matrix * arb(t)).exp() * start
            values = np.array([float(end[i, 0].mid()) for i in range(2 * n)])
        finally:
            ctx.prec = before
        return values[:n], values[n:]

    @property
    def quickest(self) -> float:
        """A bound of the rates of motion, up to a small factor [1/time]."""
        structure = self.structure
        back = np.linalg.inv(structure.mass_matrix)
        stiff, damped = back @ structure.stiffness_matrix, back @ structure.damping_matrix
        return float(np.sqrt(np.linalg.norm(stiff)) + np.linalg.norm(damped))


def linear_motion(seed: int) -> LinearMotion:
    """Return one motion of 2 to 12 coordinates, of each kind in turn."""
    rng = np.random.default_rng([23, seed])
    kind = KINDS[seed % len(KINDS)]
    mass, damping, stiffness = _matrices(rng, kind, int(rng.integers(2, 13)))
    structure = pc.Structure(mass, stiffness, damping)
    x0, v0 = rng.uniform(-1.0, 1.0, (2, structure.n))
    return LinearMotion(kind, structure, x0, v0)


def beam(n_elements: int) -> tuple[Floats, Floats]:
    """Return M and K of a clamped beam of Hermite elements, of length, EI and mass per length 1."""
    h = 1.0 / n_elements
    stiff = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
             [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]  # fmt: skip
    heavy = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
             [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]  # fmt: skip
    n = 2 * n_elements + 2
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n_elements):
        some = slice(2 * i, 2 * i + 4)
        stiffness[some, some] += np.array(stiff) / h**3
        mass[some, some] += np.array(heavy) * h / 420
    return _symmetric(mass[2:, 2:]), _symmetric(stiffness[2:, 2:])


def rayleigh(mass: Floats, stiffness: Floats, a: float, b: float) -> Rows:
    """Return a M + b K exactly."""
    return [
        [Fraction(a) * Fraction(m) + Fraction(b) * Fraction(k) for m, k in zip(*rows, strict=True)]
        for rows in zip(mass.tolist(), stiffness.tolist(), strict=True)
    ]


def _matrices(rng: np.random.Generator, kind: str, n: int) -> tuple[Any, Any, Any]:
    mass, stiffness = np.diag(rng.uniform(0.3, 2.0, n)), chain_matrix(rng.uniform(0.5, 6.0, n + 1))
    damping: Any = float(rng.choice([0.0, 0.05])) * stiffness
    rates = rng.uniform(0.5, 8.0, n)
    if kind in ("proportional", "overdamped"):
        mass = _positive(rng, n)
        b = rng.uniform(0.0, 0.3) if kind == "proportional" else rng.uniform(1.0, 20.0)
        damping = rng.uniform(0.0, 1.0) * mass + b * stiffness
    elif kind == "commuting":
        mass, turn = np.eye(n), np.linalg.qr(rng.normal(size=(n, n)))[0]
        stiffness = _symmetric(turn.T @ np.diag(rates**2) @ turn)
        ratios = 2 * rates * rng.uniform(0.0, 1.5, n)
        damping = _symmetric(turn.T @ np.diag(ratios) @ turn)
    elif kind == "critical":
        mass, whole = np.eye(n), rng.integers(1, 6, n).astype(float)
        stiffness, damping = np.diag(whole**2), np.diag(2 * whole)
    elif kind in ("gyroscopic", "strongly gyroscopic"):
        damping = damping + _skew(rng, n, 1.0 if kind == "gyroscopic" else 30.0)
    elif kind == "free masses":
        joints = rng.uniform(0.5, 6.0, n + 1) * (rng.random(n + 1) < 0.5)
        joints[0] = joints[-1] = 0.0
        stiffness = chain_matrix(joints)
        damping = 0.1 * stiffness
        if rng.random() < 0.5:
            damping = damping + _symmetric(rng.uniform(0.0, 0.1, (n, n)))
    elif kind == "free gyroscopic masses":
        stiffness = np.diag(np.where(rng.random(n) < 0.5, 0.0, rng.uniform(0.0, 9.0, n)))
        damping = _skew(rng, n, 1.0)
    elif kind == "unstable":
        joints = rng.uniform(0.5, 6.0, n + 1)
        joints[0] = -rng.uniform(0.1, 3.0)
        stiffness = chain_matrix(joints)
        damping = 0.02 * stiffness + float(rng.choice([0.0, 0.2])) * np.diag(rng.random(n))
    elif kind in ("equal frequencies", "nearly equal frequencies"):
        mass, turn = np.eye(n), np.linalg.qr(rng.normal(size=(n, n)))[0]
        squares = rng.integers(1, 3, n).astype(float) ** 2
        if kind != "equal frequencies":
            squares += float(rng.choice([1e-13, 1e-10, 1e-7, 1e-4])) * np.arange(n)
        stiffness = _symmetric(turn.T @ np.diag(squares) @ turn)
        one = np.zeros((n, n))
        one[0, 0] = 0.3
        others = (one, _positive(rng, n) * float(rng.choice([1e-8, 1e-4, 0.1])), _skew(rng, n, 1.0))
        damping = others[int(rng.integers(3))]
    elif kind == "graded stiffness":
        mass, turn = np.eye(n), np.linalg.qr(rng.normal(size=(n, n)))[0]
        stiffness = _symmetric(turn.T @ np.diag(10.0 ** rng.uniform(0, 8, n)) @ turn)
        damping = rayleigh(mass, stiffness, float(rng.choice([0.0, 0.01, 1.0])), 1e-6)
    elif kind.startswith("finite elements"):
        mass, stiffness = beam(int(rng.integers(1, 7)))
        a, b = float(rng.choice([0.0, 0.1, 1.0])), float(rng.choice([0.0, 1e-5, 1e-3]))
        damping = rayleigh(mass, stiffness, a, b)
        if kind != "finite elements":
            damping[-2][-2] += Fraction(float(rng.choice([0.1, 10.0])))
    elif kind in ("coupled critical", "coupled overdamped"):
        sizes = [1.0, 3.0, 5.0] if kind == "coupled critical" else [20.0, 200.0]
        damping = _positive(rng, n) * float(rng.choice(sizes))
    elif kind == "circulatory":
        stiffness = stiffness + _skew(rng, n, 2.0)
        damping = 0.1 * np.diag(rng.random(n))
    elif kind == "one large dashpot":
        damping = damping.copy()
        damping[0, 0] += 10.0 ** rng.uniform(-2, 3)
    elif kind == "masses of any size":
        mass = np.diag(10.0 ** rng.uniform(-4, 4, n))
    elif kind == "defective":
        # Two equal frequencies that a follower force gives one shape, or nearly.
        mass, stiffness = np.eye(n), np.diag(rng.uniform(3.0, 9.0, n))
        stiffness[1, 1], stiffness[0, 1] = stiffness[0, 0], 1.0
        stiffness[1, 0] = float(rng.choice([0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2]))
        damping = float(rng.choice([0.0, 0.1])) * np.eye(n)
    return mass, damping, stiffness


def _ball(entry: Any) -> arb:
    number = as_fraction(entry)
    return arb(fmpq(number.numerator, number.denominator))


def _symmetric(matrix: Floats) -> Floats:
    return np.triu(matrix) + np.triu(matrix, 1).T


def _positive(rng: np.random.Generator, n: int) -> Floats:
    root = rng.normal(size=(n, n))
    return _symmetric(root @ root.T / n + 0.5 * np.eye(n))


def _skew(rng: np.random.Generator, n: int, size: float) -> Floats:
    upper = np.triu(rng.uniform(-size, size, (n, n)), 1)
    return upper - upper.T
