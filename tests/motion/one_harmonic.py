"""Shallow dips below a wall at 0, and near misses, of x'' + x = cos(omega t): 4,000 cases."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats


@dataclass(frozen=True)
class Pass:
    """A flight whose lowest point, at time ``turn``, is ``height`` above the wall."""

    omega: float
    start: tuple[float, float, float]
    turn: float
    height: float
    half_width: float
    t_end: float


def passes(n: int, seed: int, sign: int) -> Iterator[Pass]:
    """Yield n flights that turn 1e-10 to 1e-3 above (sign 1) or below (sign -1) the wall."""
    rng = np.random.default_rng(seed)
    while n > 0:
        omega, exponent, turn = rng.uniform(1.5, 5), rng.uniform(-10, -3), rng.uniform(2, 20)
        push = math.cos(omega * turn)
        if push < 0.2:
            continue
        back = rng.uniform(0.8, 2.0)
        height = sign * 10.0**exponent
        half_width = math.sqrt(2 * abs(height) / (push - height))
        before = _flight(omega, turn, height, -np.linspace(0, back, 4001))
        after = _flight(omega, turn, height, np.linspace(0, 0.4, 2001))
        if all(_is_narrow_only_there(*leg, height, half_width) for leg in (before, after)):
            _, x, v = before
            start = (float(x[-1]), float(v[-1]), turn - back)
            yield Pass(omega, start, turn, height, half_width, turn + 0.4)
            n -= 1


def _flight(omega: float, turn: float, height: float, s: Floats) -> tuple[Floats, Floats, Floats]:
    """Return s, x and v around the turning point, by the closed form."""
    c = 1 / (1 - omega**2)
    x0, v0 = height - c * math.cos(omega * turn), c * omega * math.sin(omega * turn)
    angle = omega * (turn + s)
    x = x0 * np.cos(s) + v0 * np.sin(s) + c * np.cos(angle)
    v = -x0 * np.sin(s) + v0 * np.cos(s) - c * omega * np.sin(angle)
    return s, x, v


def _is_narrow_only_there(s: Floats, x: Floats, _: Floats, height: float, width: float) -> bool:
    away = np.abs(s) > 3 * width
    return bool(away.any() and (x[away] > 2 * abs(height)).all())


def is_right(case: Pass, event: float | None) -> bool:
    """Return whether the first event is the entry of a dip, or none for a near miss."""
    if event is None or case.height > 0:
        return event is None and case.height > 0
    return abs(event - (case.turn - case.half_width)) < 0.5 * case.half_width + 1e-7
