"""Derivatives of a motion by five parameters, against finite differences of runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

import percuss as pc
from benchmarks.report import Report, installed
from benchmarks.timing import race

Floats = NDArray[np.float64]

DAMPING, WALL, RESTITUTION, OMEGA, AMPLITUDE, V0 = 0.05, 0.2, 0.8, 2.0, 1.0, 0.5
PATHS = (
    "oscillator.damping",
    "oscillator.stops.0.at",
    "oscillator.stops.0.restitution",
    "forcing.omega",
    "forcing.amplitude",
)
VALUES = (DAMPING, WALL, RESTITUTION, OMEGA, AMPLITUDE)
# Impacts of the timed runs, and of those that 40 digits follow.
N, SHORT = 3_000, 50
# The best step of a central difference is some cube root of a rounding.
STEP = 1e-5


def run(report: Report) -> None:
    """Time all five derivatives, and differences; compare both with 40 digits."""
    report.section(
        "Sensitivities",
        f"x'' + 0.1 x' + x = cos 2 t with a wall at 0.2, restitution 0.8: {N:,} impacts, and the "
        "derivatives of all of them by five parameters. diffrax, where it is installed (pip install "
        "diffrax): Dopri8 at 1e-11, events by Newton's method, forward derivatives.",
    )
    short = motion(VALUES, SHORT)
    found = short.sensitivity(PATHS).impacts.t
    ours = theirs = 0.0
    for p in range(len(PATHS)):
        wanted = exact(short, p)
        size = max(abs(value) for value in wanted)
        ours = max(ours, max(abs(a - b) for a, b in zip(found[:, p], wanted, strict=True)) / size)
        rough = difference(p, SHORT)
        theirs = max(theirs, max(abs(a - b) for a, b in zip(rough, wanted, strict=True)) / size)
    assert ours < 1e-10
    report.line(f"percuss, {SHORT} impacts, error against 40 digits", f"{ours:.1e}")
    report.line("central differences of percuss's own runs, error", f"{theirs:.1e}")

    if installed("diffrax"):
        _add_diffrax(report, short)

    for n in (N, SHORT):
        taken = race(contenders(n), of_processor=True)
        ratio = taken["all"] / taken["run"]
        report.below(f"five derivatives, {n:,} impacts, in runs", ratio, 2.0, "runs")
        report.line(f"five derivatives, an impact of {n:,}", f"{taken['all'] / n * 1e6:.3g} us")
        name = f"central differences : percuss, {n:,} impacts"
        report.ratio(name, taken["differences"] / taken["all"])


def _add_diffrax(report: Report, short: pc.Trajectory) -> None:
    """Compare with diffrax: the same instants, and the cost and the error of its derivatives."""
    from benchmarks.diffrax_peer import MovedImpacts

    peer = MovedImpacts(SHORT, V0)
    np.testing.assert_allclose(peer.run(VALUES), short.impacts.t, atol=1e-9)
    ours = short.sensitivity(PATHS).impacts.t
    wrong = np.abs(peer.derivatives(VALUES) - ours).max(axis=0) / np.abs(ours).max(axis=0)
    assert wrong.max() < 1e-6
    report.line(f"diffrax, {SHORT} impacts, error", f"{wrong.max():.1e}")
    taken = race(
        {
            "diffrax": lambda: peer.derivatives(VALUES),
            "percuss": lambda: motion(VALUES, SHORT).sensitivity(PATHS),
        }
    )
    report.line(f"diffrax, an impact of {SHORT}", f"{taken['diffrax'] / SHORT * 1e6:.3g} us")
    report.ratio("diffrax : percuss with its run", taken["diffrax"] / taken["percuss"])


def contenders(n: int) -> dict[str, Callable[[], object]]:
    """Return a run, its derivatives by all parameters, and central differences of them."""
    done = motion(VALUES, n)
    return {
        "run": lambda: motion(VALUES, n),
        "all": lambda: done.sensitivity(PATHS),
        "differences": lambda: [difference(p, n) for p in range(len(PATHS))],
    }


def motion(values: tuple[float, ...], n: int) -> pc.Trajectory:
    """Return the run with so many impacts."""
    damping, at, restitution, omega, amplitude = values
    osc = pc.impact_oscillator(restitution, wall=at, side="above", damping=damping)
    return pc.simulate(osc, pc.cosine(omega, amplitude=amplitude), v0=V0, max_impacts=n)


def difference(p: int, n: int) -> Floats:
    """Return the central difference of the impacts' instants by a parameter."""
    ahead, behind = (
        motion(tuple(v + step * (i == p) for i, v in enumerate(VALUES)), n)
        for step in (STEP, -STEP)
    )
    found: Floats = (ahead.impacts.t - behind.impacts.t) / (2.0 * STEP)
    return found


def exact(run: pc.Trajectory, p: int) -> list[float]:
    """Return that difference of the same motion in 40 digits, to some twenty."""
    with mpmath.workdps(40):
        h = mpmath.mpf(10) ** -12
        ahead, behind = (
            instants(run, [mpmath.mpf(v) + step * (i == p) for i, v in enumerate(VALUES)])
            for step in (h, -h)
        )
        return [float((a - b) / (2 * h)) for a, b in zip(ahead, behind, strict=True)]


def instants(run: pc.Trajectory, values: list[Any]) -> list[Any]:
    """Return the instants of the impacts by Newton's method from those of a run."""
    a, wall, r, omega, amplitude = values
    gain = amplitude / (1 - omega**2 + 2j * a * omega)
    w = mpmath.sqrt(1 - a * a)
    x, v, begin, found = mpmath.mpf(0), mpmath.mpf(V0), mpmath.mpf(0), []

    def forced(t: Any) -> tuple[Any, Any]:
        wave = gain * mpmath.expj(omega * t)
        return wave.real, -omega * wave.imag

    for guess in run.impacts.t.tolist():
        steady, rate = forced(begin)
        y, z = x - steady, v - rate
        t = mpmath.mpf(guess)
        for _ in range(4):
            s = t - begin
            cosine, sine = mpmath.cos_sin(w * s)
            decay, b = mpmath.exp(-a * s), (z + a * y) / w
            steady, rate = forced(t)
            x = steady + decay * (y * cosine + b * sine)
            v = rate + decay * ((b * w - a * y) * cosine - (y * w + a * b) * sine)
            t -= (x - wall) / v
        found.append(t)
        x, v, begin = wall, -r * v, t
    return found
