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


def run(report: Report) -> None:
    """Check the motion against 50 digits at two stiffnesses, and time it beside the peers."""
    report.section(
        "W3: a stiff bilinear oscillator",
        f"x'' + k x = sin t from rest, k = 1 above 0 and k- below, 0 <= t <= {T:g}, sampled at "
        f"2^20 points; errors at every {STEP}nd of them, where |x| is up to 6.",
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


def _oscillator(stiffness: float) -> pc.Oscillator:
    return pc.bilinear_oscillator(stiffness_below=stiffness)


def _percuss(stiffness: float) -> references.Floats:
    x, _ = pc.simulate(_oscillator(stiffness), FORCE, t_end=T)(GRID)
    return np.asarray(x)


def _reference(stiffness: float) -> references.Floats:
    name = f"w3-{stiffness:g}-{STEP}"
    return references.positions(_oscillator(stiffness), FORCE, 0.0, GRID[::STEP], name)
