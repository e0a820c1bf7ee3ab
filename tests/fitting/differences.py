"""Derivatives of the segments of a record against differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from percuss.arrays import Floats
from percuss.fitting.shooting import Shots


def assert_derivatives_are_those_of_differences(
    shots: Callable[[Floats, Floats], Shots], values: Floats, nodes: Floats, *, near: float
) -> None:
    """Compare with differences by each parameter and each number of the nodes, to a part ``near``."""
    found = shots(values, nodes)
    h, n = 1e-6, len(values)
    # Samples that an event passes within the step have no difference.
    apart = ~(found.away < 1e-3)
    beside = apart & np.isfinite(found.away)
    for p in range(n + nodes.shape[1]):
        ends = []
        for sign in (1, -1):
            moved, moved_nodes = values.copy(), nodes.copy()
            if p < n:
                moved[p] += sign * h
            else:
                moved_nodes[:, p - n] += sign * h
            ends.append(shots(moved, moved_nodes))
        rows, own = ((getattr(ends[0], name) - getattr(ends[1], name)) / (2 * h)
                     for name in ("values", "ends"))  # fmt: skip
        hits = (ends[0].hits[:, 1] - ends[1].hits[:, 1]) / (2 * h)
        scale = 1 + np.abs(rows[apart, 0]).max()
        np.testing.assert_allclose(
            found.rows[apart, 0, p], rows[apart, 0], rtol=0, atol=near * scale, err_msg=str(p)
        )
        np.testing.assert_allclose(
            found.rows[beside, 1, p], rows[beside, 1], rtol=0, atol=10 * near * scale
        )
        size = min(scale, 1 + np.abs(own).max())
        np.testing.assert_allclose(found.end_rows[:, :, p], own, rtol=0, atol=2e-5 * size)
        np.testing.assert_allclose(found.hits[:, 2 + p], hits, rtol=1e-4, atol=1e-4)
