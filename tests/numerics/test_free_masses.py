"""Modes of masses that no spring holds, with dashpots: roots 0, which are no double ones."""

from __future__ import annotations

import numpy as np
import pytest

from percuss.arrays import Floats
from percuss.numerics import Wide
from percuss.numerics.modes import mode_pairs


def residual(stiffness: Floats, damping: Floats) -> float:
    """Return by how much both parts of each pair miss x'' + C x' + K x = 0."""
    pairs = mode_pairs(Wide.of(stiffness), Wide.of(damping))
    # Columns: the velocity of P u + Q w is (-k Q) u + (P - d Q) w, and once more the acceleration.
    p, q = pairs.of_u.rounded, pairs.of_w.rounded
    p1, q1 = -q * pairs.spring, p - q * pairs.drag
    p2, q2 = -q1 * pairs.spring, p1 - q1 * pairs.drag
    misses = (a + damping @ b + stiffness @ c for a, b, c in ((p2, p1, p), (q2, q1, q)))
    whole = np.vstack([np.stack([p, q], axis=2).reshape(len(p), -1),
                       np.stack([p1, q1], axis=2).reshape(len(p), -1)])  # fmt: skip
    back = pairs.inverse.rounded
    return max(
        float(np.abs(whole @ back - np.eye(2 * len(p))).max()),
        *(float(np.abs(miss).max()) for miss in misses),
    )


def test_two_gears_in_mesh_turn_freely_in_their_bearings() -> None:
    """One root 0 beside a slow decay, from the dashpots of the bearings."""
    mesh = np.array([[1.0, -1.0], [-1.0, 1.0]])

    assert residual(400.0 * mesh, 0.4 * mesh + np.diag([0.02, 0.01])) < 1e-12


@pytest.mark.parametrize("n", [2, 3, 5])
@pytest.mark.parametrize("seed", range(5))
def test_free_masses_with_dashpots_rest_anywhere(seed: int, n: int) -> None:
    """No spring but one between the last two: n - 1 of the roots are 0."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(n, n))
    stiffness = np.zeros((n, n))
    stiffness[-2:, -2:] = [[1.0, -1.0], [-1.0, 1.0]]
    damping = 0.1 * (root @ root.T + np.eye(n))

    assert residual(stiffness, damping) < 1e-11
    rests = mode_pairs(Wide.of(stiffness), Wide.of(damping)).spring == 0.0
    assert int(rests.sum()) >= n - 1
