"""Answers in 40 and 50 digits, by the oracle of the tests; what takes long is kept in .cache."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mpmath
import numpy as np
from numpy.typing import NDArray
from tests.oracle.event_driven import simulate
from tests.oracle.from_model import problem_of

import percuss as pc

Floats = NDArray[np.float64]

FOLDER = Path(__file__).parent / ".cache"


def impacts(
    osc: pc.Oscillator,
    force: pc.Forcing,
    start: tuple[pc.model.Exact, pc.model.Exact],
    n: int,
    name: str,
) -> tuple[Floats, Floats]:
    """Return the times and the velocities before the first n impacts."""

    def compute() -> dict[str, Floats]:
        run = simulate(problem_of(osc, force), *start, max_impacts=n)
        v = np.array([float(v) for v in run.impacts.v_before])
        return {"t": np.array([float(t) for t in run.impacts.t]), "v": v}

    found = _kept(f"{name}-{n}", compute)
    return found["t"], found["v"]


def positions(osc: pc.Oscillator, force: pc.Forcing, v0: float, t: Floats, name: str) -> Floats:
    """Return x at the times t of the motion from (0, v0), in 50 digits."""

    def compute() -> dict[str, Floats]:
        run = simulate(problem_of(osc, force), 0, v0, t_end=mpmath.mpf(t[-1]), digits=50)
        return {"x": np.array([float(run(instant)[0]) for instant in t])}

    return _kept(name, compute)["x"]


def _kept(name: str, compute: Callable[[], dict[str, Floats]]) -> dict[str, Floats]:
    file = FOLDER / f"{name}.npz"
    if not file.exists():
        FOLDER.mkdir(exist_ok=True)
        (FOLDER / ".gitignore").write_text("*\n", encoding="utf-8")
        np.savez(file, **compute())
    with np.load(file) as data:
        return dict(data)
