"""The motions of graze_and_chatter.py by SciPy and by heyoka, as a careful user writes them."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]
Rate = Callable[[float, Floats], tuple[float, float]]

# In the chatter time no longer advances by then.
MOST_EVENTS = 500
T_END = 3.0
# Started on the wall itself, heyoka finds no impact at all.
HEYOKA_START = -1e-9


def results(
    amplitude: float, depth: float, graze_window: Floats, chatter_window: Floats
) -> dict[str, Any]:
    """Return what both make of the graze and of the chatter."""
    return {
        "scipy": {
            "version": importlib.metadata.version("scipy"),
            "graze": _scipy_graze(amplitude, depth, graze_window),
            "chatter": _scipy_chatter(chatter_window),
        },
        "heyoka": {
            "version": importlib.metadata.version("heyoka"),
            "graze": _heyoka_graze(amplitude, depth, graze_window),
            "chatter": _heyoka_chatter(chatter_window),
        },
    }


def _scipy_graze(amplitude: float, depth: float, window: Floats) -> dict[str, Any]:
    def rate(t: float, y: Floats) -> tuple[float, float]:
        return y[1], amplitude * math.cos(t) - 0.1 * y[1] - y[0]

    times, x = _scipy(rate, 1.0, (0.0, 0.0, 1 + depth), window)
    return {"first_impact": times[0] if times else None, "x": _short(x - 1.0)}


def _scipy_chatter(window: Floats) -> dict[str, Any]:
    def rate(t: float, y: Floats) -> tuple[float, float]:
        return y[1], math.cos(2.8 * t) - y[0]

    times, x = _scipy(rate, 0.0, (-0.2, 0.0, -0.032), window)
    return {"impacts": len(times), "last_impact": times[-1], "x": _short(x)}


def _scipy(
    rate: Rate, wall: float, start: tuple[float, float, float], window: Floats
) -> tuple[list[float], Floats]:
    """Return the impact times, and x in the window as far as the motion came."""

    def height(_: float, y: Floats) -> float:
        return float(y[0] - wall)

    height.terminal, height.direction = True, 1.0  # type: ignore[attr-defined]
    t, *y = start
    times: list[float] = []
    found: list[Floats] = []
    while t < T_END and len(times) < MOST_EVENTS:
        piece = solve_ivp(
            rate,
            (t, T_END),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            events=height,
            dense_output=True,
        )
        inside = window[(window >= t) & (window < piece.t[-1])]
        found.append(piece.sol(inside)[0] if len(inside) else np.empty(0))
        t, y = float(piece.t[-1]), [wall, -0.8 * piece.y[1, -1]]
        if piece.status == 1:
            times.append(t)
    return times, np.concatenate(found)


class _Bounce:
    """The callback of an impact."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def __call__(self, ta: Any, _: int) -> bool:
        self.times.append(ta.time)
        ta.state[1] *= -0.8
        return True

    def __deepcopy__(self, _: object) -> _Bounce:
        # heyoka copies its callbacks; the list must stay the same.
        return self


def _heyoka(
    acceleration: Any, wall: float, start: tuple[float, float, float], window: Floats
) -> tuple[list[float], Floats, float]:
    """Return the impact times, x in the window, and x at the end."""
    x, v = hy.make_vars("x", "v")
    bounce = _Bounce()
    event = hy.t_event(x - wall, callback=bounce, direction=hy.event_direction.positive)
    t, *y = start
    system = [(x, v), (v, acceleration(x, v))]
    ta = hy.taylor_adaptive(system, y, time=t, t_events=[event])
    if t < window[0]:
        ta.propagate_until(window[0])
    found = ta.propagate_grid(window)[-1][:, 0]
    ta.propagate_until(T_END)
    return bounce.times, found, float(ta.state[0])


def _heyoka_graze(amplitude: float, depth: float, window: Floats) -> dict[str, Any]:
    times, x, _ = _heyoka(
        lambda x, v: amplitude * hy.cos(hy.time) - 0.1 * v - x, 1.0, (0.0, 0.0, 1 + depth), window
    )
    return {"first_impact": times[0] if times else None, "x": _short(x - 1.0)}


def _heyoka_chatter(window: Floats) -> dict[str, Any]:
    times, x, last = _heyoka(
        lambda x, _: hy.cos(2.8 * hy.time) - x, 0.0, (-0.2, HEYOKA_START, -0.032), window
    )
    return {
        "impacts": len(times),
        "last_impact": times[-1],
        "x": _short(x),
        "x_at_3": last,
    }


def _short(values: Floats) -> list[float]:
    # A picture needs six digits.
    return [float(f"{value:.6g}") for value in values]
