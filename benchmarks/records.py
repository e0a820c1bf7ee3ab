"""A force by its samples: a record of 100,000 knots, with SciPy on the interpolated force beside it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

import percuss as pc
from benchmarks.report import Report
from benchmarks.timing import race

Floats = NDArray[np.float64]

DAMPING = 0.02
FREE = pc.Oscillator(damping=DAMPING)
WALL = pc.impact_oscillator(0.8, wall=0.5, side="above", damping=DAMPING)
SOFT = pc.Oscillator(
    damping=DAMPING,
    stops=(
        pc.Wall(at=-1.0, side="below", restitution=0.8),
        pc.SoftStop(at=0.3, side="above", stiffness=5.0, damping=0.1),
    ),
)
# Knots of the long record, and of those that SciPy and 40 digits follow.
N, SHORT = 100_000, 2_000


def run(report: Report) -> None:
    """Time a knot: free, beside a wall, and between a wall and a soft stop."""
    report.section(
        "Records",
        "x'' + 0.04 x' + x = a force that is linear between random samples, three a unit of time; "
        "SciPy: DOP853 with the interpolated force, no stop. Least processor time of seven turns.",
    )
    t, f = samples(N)
    short = t[:SHORT], f[:SHORT]
    exact = free_motion(*short)
    size = max(abs(x) for x in exact)
    ours = pc.simulate(FREE, pc.record(*short), t_end=short[0][-1])(short[0])[0]
    error = max(abs(float(x) - y) for x, y in zip(exact, ours, strict=True))
    assert error < 1e-13 * float(size)
    report.line("percuss, error against 40 digits", f"{error:.1e}")

    long = pc.record(t, f)
    for name, osc in (("free", FREE), ("a wall", WALL), ("a wall and a soft stop", SOFT)):
        taken = race(
            {name: lambda osc=osc: pc.simulate(osc, long, t_end=t[-1])}, of_processor=True
        )[name]
        report.below(f"percuss, a knot, {name}", taken / N * 1e6, 1.0, "us")

    try:
        from scipy.integrate import solve_ivp
    except ImportError:
        return
    tight, loose = (_scipy(solve_ivp, short, rtol) for rtol in (1e-12, 1e-6))
    taken = race(
        {
            "percuss": lambda: pc.simulate(FREE, pc.record(*short), t_end=short[0][-1]),
            "SciPy at 1e-12": tight,
            "SciPy at 1e-6": loose,
        },
        of_processor=True,
    )
    for name, follow in (("SciPy at 1e-12", tight), ("SciPy at 1e-6", loose)):
        off = max(abs(float(x) - y) for x, y in zip(exact, follow(), strict=True))
        report.line(f"{name}, largest error", f"{off:.1e}")
        report.ratio(f"{name} : percuss, 2,000 knots", taken[name] / taken["percuss"])


def samples(n: int) -> tuple[Floats, Floats]:
    """Return n random instants, in order, and forces there."""
    draw = np.random.default_rng(11)
    return np.cumsum(draw.uniform(0.1, 0.5, n)), draw.normal(size=n)


def free_motion(t: Floats, f: Floats) -> Sequence[Any]:
    """Return x at each sample, from rest at 0 at t = 0, to 40 digits."""
    with mpmath.workdps(40):
        a, x, v = mpmath.mpf(DAMPING), mpmath.mpf(0), mpmath.mpf(0)
        w = mpmath.sqrt(1 - a * a)
        instants = [mpmath.mpf(0), *map(mpmath.mpf, t.tolist())]
        forces = [mpmath.mpf(f[0].item()), *map(mpmath.mpf, f.tolist())]
        found = []
        for i in range(len(t)):
            h = instants[i + 1] - instants[i]
            slope = (forces[i + 1] - forces[i]) / h
            # The particular solution is level + slope s.
            level = forces[i] - 2 * a * slope
            y, z = x - level, v - slope
            cosine, sine = mpmath.cos_sin(w * h)
            decay, b = mpmath.exp(-a * h), (z + a * y) / w
            x = level + slope * h + decay * (y * cosine + b * sine)
            v = slope + decay * ((b * w - a * y) * cosine - (y * w + a * b) * sine)
            found.append(x)
        return found


def _scipy(solve_ivp: Any, record: tuple[Floats, Floats], rtol: float) -> Any:
    """Return a function that follows the record by steps, and returns x at its samples."""
    t, f = record

    def rate(at: float, y: Floats) -> tuple[float, float]:
        return y[1], float(np.interp(at, t, f)) - 2.0 * DAMPING * y[1] - y[0]

    def follow() -> Floats:
        span, start = (0.0, float(t[-1])), (0.0, 0.0)
        options = {"method": "DOP853", "rtol": rtol, "atol": rtol, "t_eval": t}
        found: Floats = solve_ivp(rate, span, start, **options).y[0]
        return found

    return follow
