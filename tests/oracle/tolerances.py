"""How far rounding may move the events of a motion, from the flights that the oracle has flown.

Each flight of percuss rounds its end by ROUNDING of the sizes of its terms (docs/theory/
first-event.md), and the linear maps of the flights and events that follow carry that along. The
errors of an event are the sums of what all flights before it have added, each with the worst
sign: first order, so that they end where they would turn a velocity round.
"""

from __future__ import annotations

import math

import numpy as np
from tests.oracle.taylor_series import Event

from percuss.arrays import Floats

EPS = 2.0**-52
# Four times what the documents allow: here the sizes of the terms are only guessed at.
ROUNDING = 64 * EPS
# Velocities that rounding may change by more than this part are not compared, nor what follows.
LOST = 1e-2


class Tolerances:
    """The errors of instant and velocity of events that are handed in one by one."""

    def __init__(self, x0: float, v0: float) -> None:
        # At the start x and v are given, no velocity at a given place.
        self._begun = False
        self._columns = np.array([[EPS * abs(x0), 0.0], [0.0, EPS * abs(v0)]])
        self.lost = False
        self.gap = 0.0

    def pass_event(self, event: Event) -> tuple[float, float]:
        """Return the errors of an event's instant and of the velocity before it."""
        if event.kind == "rest":
            late = float(np.abs(self._columns[0]).sum())
            self._columns = np.zeros((2, 0))
            return late, 0.0
        if event.kind == "release":
            # The force, a sum of terms that cancel, falls to zero at this rate.
            rate = abs(event.bends[1])
            late = ROUNDING * event.flight[4] / rate if rate > 0.0 else math.inf
            self.lost = self.lost or late > LOST
            self._columns, self._begun = np.array([[late], [0.0]]), True
            return late, 0.0
        s, v0, stiffness, damping, load = event.flight
        v = float(event.v_before)
        columns = self._columns
        if self._begun:
            columns = np.array([-v0 * columns[0], columns[1] - event.bends[0] * columns[0]])
        columns = propagator(stiffness, damping, s) @ columns
        growth = math.exp(math.sqrt(max(0.0, -stiffness)) * s)
        reach = min(0.5 * s * s, s / math.sqrt(stiffness)) if stiffness > 0.0 else 0.5 * s * s
        size = (abs(v0) * s + load * reach) * growth + EPS
        speed = (abs(v0) + load * s) * growth + abs(v) + EPS
        columns = np.hstack([columns, ROUNDING * np.diag([size, speed])])
        self.gap = float(np.abs(columns[0]).sum())
        fast = float(np.abs(columns[1]).sum())
        if not (v != 0.0 and fast + abs(event.bends[1]) * self.gap / abs(v) <= LOST * abs(v)):
            self.lost = True
            return math.inf, math.inf
        late = -columns[0] / v
        columns = np.array([late, columns[1] + event.bends[1] * late])
        errors = float(np.abs(columns[0]).sum()), float(np.abs(columns[1]).sum())
        if event.kind == "impact":
            ratio = float(event.v_after) / v
            columns = np.array([columns[0], ratio * columns[1]])
        self._columns, self._begun = columns, True
        return errors


def propagator(stiffness: float, damping: float, s: float) -> Floats:
    """Return the map of (x, v) by the free equation: a power series, squared again and again."""
    size = s * max(math.sqrt(abs(stiffness)), 2.0 * damping, 1e-3)
    halvings = max(0, math.ceil(math.log2(size)) + 3) if size > 0.0 else 0
    h = s / 2**halvings
    # Columns: what begins with x = 1, and with v = 1.
    series = [[1.0, 0.0, 0.0, 1.0]]
    for n in range(1, 12):
        a, b, c, d = series[-1]
        series.append(
            [
                c * h / n,
                d * h / n,
                (-stiffness * a - 2.0 * damping * c) * h / n,
                (-stiffness * b - 2.0 * damping * d) * h / n,
            ]
        )
    a, b, c, d = (sum(parts) for parts in zip(*series, strict=True))
    for _ in range(halvings):
        a, b, c, d = a * a + b * c, b * (a + d), c * (a + d), d * d + b * c
    return np.array([[a, b], [c, d]])
