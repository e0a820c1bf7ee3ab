"""How often the kernels are compiled."""

from __future__ import annotations

import importlib
import pkgutil
from typing import Any

import percuss as pc
import percuss.kernels
from benchmarks.report import Report


def run(report: Report) -> None:
    """Run 1-8 harmonics with 0-4 stops, then count the compiled forms of every kernel."""
    report.section("Compilation", "After runs with 1 to 8 harmonics, each with 0 to 4 stops.")
    walls = (pc.Wall(-2.0, "below", 0.9), pc.Wall(2.0, "above", 0.9))
    softs = (pc.SoftStop(-1.0, "below", 3.0), pc.SoftStop(1.0, "above", 3.0, 0.1))
    stops = (*walls, *softs)
    for harmonics in range(1, 9):
        parts = tuple(pc.Harmonic(0.3, 1.0 + n, 0.1 * n) for n in range(harmonics))
        for n in range(len(stops) + 1):
            osc = pc.Oscillator(1.0, 0.01, stops[:n])
            motion = pc.simulate(osc, pc.Forcing(parts), v0=1.0, t_end=30.0)
            assert motion(15.0)[0] == motion(motion.t_end / 2)[0]
    forms = {name: len(kernel.signatures) for name, kernel in _kernels()}
    most = max(forms.values())
    assert most == 1, {name: count for name, count in forms.items() if count > 1}
    report.line("compiled forms of a kernel, at most", str(most), "1", met=most <= 1)


def _kernels() -> list[tuple[str, Any]]:
    found = {}
    for module in pkgutil.iter_modules(percuss.kernels.__path__, "percuss.kernels."):
        for name, value in vars(importlib.import_module(module.name)).items():
            if hasattr(value, "signatures") and hasattr(value, "py_func"):
                found[f"{value.py_func.__module__}.{name}"] = value
    return sorted(found.items())
