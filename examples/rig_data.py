"""Write rig.csv, the record that fit.toml fits: an impacting rig integrated by SciPy, with noise.

    python examples/rig_data.py

Nothing of percuss is used: 2 kg on a spring of 8 N/mm and a dashpot of 6 N s/m, shaken with 40 N at
14 Hz, meet a stop of steel at 1.2 mm that returns 0.72 of the speed. A laser reads the displacement
each millisecond, with a noise of 0.03 mm; the clock of the logger starts somewhere in the cycle.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

MASS, STIFFNESS, DASHPOT = 2.0, 8000.0, 6.0  # kg, N/m, N s/m
FORCE, OMEGA, PHASE = 40.0, 2.0 * np.pi * 14.0, 0.7  # N, rad/s, rad
GAP, RESTITUTION = 1.2e-3, 0.72  # m
NOISE = 3e-5  # m
T_END, STEP = 0.8, 1e-3  # s


def slope(t: float, state: np.ndarray) -> list[float]:
    x, v = state
    force = FORCE * np.cos(OMEGA * t + PHASE) - STIFFNESS * x - DASHPOT * v
    return [v, force / MASS]


def distance(_: float, state: np.ndarray) -> float:
    return state[0] - GAP


distance.terminal, distance.direction = True, 1.0  # type: ignore[attr-defined]


def displacement(times: np.ndarray) -> np.ndarray:
    """Return the displacement at times, flight by flight."""
    t, state, parts = 0.0, [0.0, 0.05], []
    while t < times[-1]:
        flight = solve_ivp(
            slope, (t, times[-1]), state, events=distance, rtol=1e-10, atol=1e-13, dense_output=True
        )
        inside = (times >= t) & (times < flight.t[-1])
        if flight.status == 0:
            inside |= times == times[-1]
        parts.append(flight.sol(times[inside])[0])
        t, state = flight.t[-1], [GAP, -RESTITUTION * flight.y[1, -1]]
    return np.concatenate(parts)


if __name__ == "__main__":
    times = np.arange(round(T_END / STEP) + 1) * STEP
    measured = displacement(times) + NOISE * np.random.default_rng(7).standard_normal(len(times))
    lines = [
        f"{1e3 * t:.0f};{1e3 * x:.3f}".replace(".", ",")
        for t, x in zip(times, measured, strict=True)
    ]
    head = ["Logger of the rig, channel 2", "", "Time (ms);Laser [mm]"]
    path = Path(__file__).with_name("rig.csv")
    path.write_text("\n".join([*head, *lines]) + "\n", encoding="utf-8")
    print(path)
