"""Fits of records that another program has made: SciPy's solve_ivp, restarted at each impact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import percuss as pc
from benchmarks.report import Report
from benchmarks.timing import race

Floats = NDArray[np.float64]

GAP = "oscillator.stops.0.at"
RESTITUTION = "oscillator.stops.0.restitution"
DAMPING = "oscillator.damping"
TRUTH = (0.2, 0.8, 0.05)
TOLERANCES = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
SAMPLES, NOISE = 40, 0.02
# Quantity, frequency, periods, factors of the three guesses, the most runs, the most seconds.
CASES: list[tuple[str, float, int, tuple[float, float, float], int | None, float]] = [
    ("displacement", 2.0, 20, (2.0, 0.75, 2.0), 10, 0.02),
    ("displacement", 2.0, 60, (0.5, 0.5, 0.5), 10, 0.06),
    ("velocity", 2.0, 20, (2.0, 0.75, 2.0), None, 0.3),
    ("acceleration", 2.0, 20, (0.5, 0.5, 0.5), None, 0.3),
    ("displacement", 2.5, 5, (2.0, 0.5, 2.0), 20, 0.1),
    ("displacement", 2.5, 20, (0.98, 0.98, 0.98), None, 0.1),
    ("displacement", 2.5, 20, (1.1, 1.1, 1.1), None, 1.0),
    ("displacement", 2.5, 60, (0.98, 0.98, 0.98), None, 1.0),
    ("velocity", 2.5, 60, (1.02, 1.02, 1.02), None, 1.0),
]


def run(report: Report) -> None:
    """Fit gap, restitution and damping of a wall in regular and chaotic motion."""
    report.section(
        "Fits",
        f"x'' + 0.1 x' + x = cos w t with a wall at 0.2, restitution 0.8, {SAMPLES} samples a period with "
        f"{NOISE:.0%} noise from SciPy's solve_ivp; gap, restitution, damping and the start are unknown. "
        "At w = 2.5 the motion is chaotic. No peer that fits impacts is installed here.",
    )
    for quantity, omega, periods, factors, most_runs, seconds in CASES:
        data, noise = record(quantity, omega, periods)
        found = fitted(data, omega, factors, noise)
        name = f"{quantity}, w = {omega:g}, {periods} periods, guesses times {', '.join(map(str, factors))}"
        spread = 4.0 * math.sqrt(2.0 / len(data["t"]))
        assert found.converged, (name, found)
        assert abs(found.chi2 - 1.0) < max(0.1, spread), (name, found)
        if periods < 60:
            assert farthest(found) < 4.0, (name, found)
        taken = race({"fit": lambda d=data, w=omega, f=factors, s=noise: fitted(d, w, f, s)})["fit"]  # type: ignore[misc]
        report.below(name, taken * 1e3, seconds * 1e3, "ms")
        report.line("    chi2 per value, largest error in standard errors",
                    f"{found.chi2:.3f}, {farthest(found):.2f}")  # fmt: skip
        if most_runs is None:
            report.line("    runs", f"{found.n_runs}")
        else:
            report.below("    runs", found.n_runs, most_runs, "")


def fitted(
    data: dict[str, Floats], omega: float, factors: tuple[float, float, float], noise: float
) -> pc.Fit:
    """Return the fit from guesses that are so many times the truth."""
    at, restitution, damping = (a * b for a, b in zip(TRUTH, factors, strict=True))
    osc = pc.impact_oscillator(restitution, wall=at, side="above", damping=damping)
    free = {GAP: at, RESTITUTION: restitution, DAMPING: damping}
    return pc.fit(data, osc, pc.cosine(omega), free=free, noise=noise)


def farthest(found: pc.Fit) -> float:
    """Return the largest difference from the truth in standard errors."""
    rows = zip(found.values.values(), TRUTH, found.errors.values(), strict=True)
    return max(abs(value - true) / error for value, true, error in rows)


def record(quantity: str, omega: float, periods: int) -> tuple[dict[str, Floats], float]:
    """Return a record with noise, and that noise."""
    t = np.arange(SAMPLES * periods) * (2.0 * math.pi / omega / SAMPLES)
    x, v = motion(omega, t)
    values = {
        "displacement": x,
        "velocity": v,
        "acceleration": np.cos(omega * t) - x - 2.0 * TRUTH[2] * v,
    }[quantity]
    noise = NOISE * math.sqrt(float(np.mean(values**2)))
    noisy = values + noise * np.random.default_rng(0).standard_normal(len(t))
    return {"t": t, quantity: noisy}, noise


def motion(omega: float, t: Floats) -> tuple[Floats, Floats]:
    """Return x and v at times, integrated from impact to impact."""
    at, restitution, damping = TRUTH

    def rate(time: float, y: Floats) -> tuple[float, float]:
        return y[1], math.cos(omega * time) - y[0] - 2.0 * damping * y[1]

    def beyond(_: float, y: Floats) -> float:
        return float(y[0]) - at

    event: Any = beyond
    event.terminal, event.direction = True, 1
    found = np.empty((2, len(t)))
    begin, state = 0.0, (0.0, 0.5)
    while begin < t[-1]:
        flight = solve_ivp(
            rate, (begin, float(t[-1]) + 1e-9), state, events=event, dense_output=True, **TOLERANCES
        )
        end = float(flight.t[-1])
        there = (t >= begin) & (t <= end)
        found[:, there] = flight.sol(t[there])
        begin, state = end, (at, -restitution * float(flight.y[1, -1]))
    return found[0], found[1]
