"""W3: a stiff bilinear oscillator at resonance, on 2^20 points of [0, 400]."""

from __future__ import annotations

import numpy as np

import percuss as pc
from benchmarks import references
from benchmarks.report import Report, installed
from benchmarks.timing import race

FORCE = pc.sine(1)
T, N = 400.0, 2**20
GRID = np.linspace(0.0, T, N)
# The reference takes 0.2 ms a point.
STEP = 32
# Rounding grows by up to 3e6 until t = 400, more or less by chance: one stiffness tells little.
STIFFNESSES = np.arange(17_000.0, 23_001.0, 250.0)
COARSE = 256


def run(report: Report) -> None:
    """Check the motion against 50 digits at two stiffnesses, and time it beside the peers."""
    report.section(
        "W3: a stiff bilinear oscillator",
        f"x'' + k x = sin t from rest, k = 1 above 0 and k- below, 0 <= t <= {T:g}, sampled at "
        f"2^20 points; errors at every {STEP}nd of them, where |x| is up to 6. Rounding grows by up to "
        "3e6, which one stiffness shows by chance: the quotient of errors is the geometric mean of "
        f"those for {len(STIFFNESSES)} values of k- from {STIFFNESSES[0]:,.0f} to "
        f"{STIFFNESSES[-1]:,.0f}.",
    )
    for stiffness, limit in ((2e4, 2e-9), (4e8, 1e-10)):
        error = np.abs(_percuss(stiffness)[::STEP] - _reference(stiffness)).max()
        assert error < limit, f"k- = {stiffness:g}: error {error:g}"
        report.below(f"percuss, largest error for k- = {stiffness:g}", float(error), limit, "")
    contenders = {"percuss": lambda: _percuss(2e4)}
    if installed("heyoka"):
        from benchmarks.heyoka_peer import Bilinear

        peer = Bilinear(2e4)
        contenders["heyoka"] = lambda: peer.positions(GRID)
    if installed("scipy"):
        from benchmarks import scipy_peer

        contenders["SciPy"] = lambda: scipy_peer.bilinear(2e4, GRID)
    taken = race(contenders)
    report.line("percuss, motion and sampling", f"{taken['percuss'] * 1e3:.0f} ms")
    for name in list(contenders)[1:]:
        error = np.abs(contenders[name]()[::STEP] - _reference(2e4)).max()
        report.line(f"{name}, largest error for k- = 20000", f"{error:.2g}")
        report.line(f"{name}, motion and sampling", f"{taken[name] * 1e3:.0f} ms")
        report.ratio(f"{name} : percuss", taken[name] / taken["percuss"])
    if installed("heyoka"):
        report.ratio("errors of heyoka : percuss", _quotient_of_errors(), 1.0)


def _quotient_of_errors() -> float:
    from benchmarks.heyoka_peer import Bilinear

    quotients = []
    for stiffness in STIFFNESSES:
        exact = _reference(stiffness, COARSE)
        peer = np.abs(Bilinear(stiffness).positions(GRID)[::COARSE] - exact).max()
        quotients.append(peer / np.abs(_percuss(stiffness)[::COARSE] - exact).max())
    return float(np.exp(np.mean(np.log(quotients))))


def _oscillator(stiffness: float) -> pc.Oscillator:
    return pc.bilinear_oscillator(stiffness_below=stiffness)


def _percuss(stiffness: float) -> references.Floats:
    x, _ = pc.simulate(_oscillator(stiffness), FORCE, t_end=T)(GRID)
    return np.asarray(x)


def _reference(stiffness: float, step: int = STEP) -> references.Floats:
    name = f"w3-{stiffness:g}-{step}"
    return references.positions(_oscillator(stiffness), FORCE, 0.0, GRID[::step], name)
