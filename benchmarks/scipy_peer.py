"""scipy.integrate.solve_ivp, DOP853 at 1e-12, restarted at every event."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]

TOLERANCES = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


def _solve(
    acceleration: Callable[[float, float], float],
    span: tuple[float, float],
    state: tuple[float, float],
    direction: int,
    **options: Any,
) -> Any:
    """Return the solution up to the first passage of x through 0 in a direction."""

    def rate(t: float, y: Floats) -> tuple[float, float]:
        return y[1], acceleration(t, y[0])

    def height(_: float, y: Floats) -> float:
        return float(y[0])

    height.terminal = True  # type: ignore[attr-defined]
    height.direction = direction  # type: ignore[attr-defined]
    return solve_ivp(rate, span, state, events=height, **TOLERANCES, **options)


def impacts(
    n: int,
    omega: float,
    phase: float,
    restitution: float,
    start: tuple[float, float],
    t_end: float = math.inf,
) -> tuple[Floats, Floats]:
    """Return times and velocities before the first n impacts of a cosine-driven motion."""
    times: list[float] = []
    speeds: list[float] = []
    t, (x, v) = 0.0, start
    while len(times) < n and t < t_end:
        until = min(t + 50.0, t_end)
        found = _solve(lambda t, x: math.cos(omega * t + phase) - x, (t, until), (x, v), -1)
        t, x, v = found.t[-1], found.y[0, -1], found.y[1, -1]
        if found.status == 1:
            times.append(t)
            speeds.append(v)
            x, v = 0.0, -restitution * v
    return np.array(times), np.array(speeds)


def first_event(omega: float, start: tuple[float, float, float], t_end: float) -> float | None:
    """Return the time of the first fall through 0 of cos(omega t) driven motion."""
    x, v, t = start
    found = _solve(lambda t, x: math.cos(omega * t) - x, (t, t_end), (x, v), -1)
    return float(found.t[-1]) if found.status == 1 else None


def bilinear(stiffness_below: float, t: Floats) -> Floats:
    """Return x at the times t of x'' + k(x) x = sin t from rest, k = 1 above 0."""
    positions = np.empty(len(t))
    now, state, above, done = 0.0, (0.0, 0.0), True, 0
    while done < len(t):
        k = 1.0 if above else stiffness_below
        found = _solve(
            lambda t, x, k=k: math.sin(t) - k * x,
            (now, t[-1]),
            state,
            -1 if above else 1,
            dense_output=True,
        )
        now = found.t[-1]
        upto = len(t) if found.status == 0 else int(np.searchsorted(t, now, side="right"))
        if upto > done:
            positions[done:upto] = found.sol(t[done:upto])[0]
        done, state, above = upto, (0.0, found.y[1, -1]), not above
    return positions
