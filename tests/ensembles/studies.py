"""A study of some seconds that runs in a process of its own, to be killed."""

from __future__ import annotations

import contextlib
import functools
import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import percuss as pc
from percuss.progress import Report


@contextlib.contextmanager
def points_a_chunk(n: int) -> Iterator[None]:
    """Cut sweeps into chunks of so many points: by themselves small studies are one."""
    module = importlib.import_module("percuss.ensembles.sweep")
    before = vars(module)["LARGEST_CHUNK"]
    module.LARGEST_CHUNK = n  # type: ignore[attr-defined]
    try:
        yield
    finally:
        module.LARGEST_CHUNK = before  # type: ignore[attr-defined]


def chart(store: str | None = None, engine: object = "threads", progress: Report = None):  # type: ignore[no-untyped-def]
    """Return two measures over 15 x 20 points, in seven chunks."""
    with points_a_chunk(49):
        return pc.sweep(
            ["period", "peak_impact_velocity"],
            pc.impact_oscillator(restitution="0.8"),
            pc.cosine(2.5),
            over={
                "forcing.omega": np.linspace(2.0, 3.0, 15),
                "oscillator.stops.0.restitution": np.linspace(0.7, 0.9, 20),
            },
            start=(0.0, 1.0),
            transient=6000,
            periods=32,
            store=store,
            engine=engine,
            progress=progress,
        )


@functools.cache
def whole_chart():  # type: ignore[no-untyped-def]
    """Return the chart of threads, without a store; computed once, not to be changed."""
    return chart()


def exponents(  # type: ignore[no-untyped-def]
    store: str | Path | None = None, size: int = 400, n_workers: int | None = None
):
    """Return the largest exponent over size x size points."""
    return pc.sweep(
        "largest_lyapunov_exponent",
        pc.impact_oscillator(restitution="0.8", side="above", damping="0.05"),
        pc.cosine(2.5),
        over={
            "forcing.omega": np.linspace(1.5, 4.5, size),
            "oscillator.stops.0.at": np.linspace(-0.2, 0.6, size),
        },
        start=(-0.3, 0.0),
        transient=100,
        periods=128,
        store=store,
        n_workers=n_workers,
    )


def slow_measure(osc: pc.Oscillator, force: pc.Forcing) -> float:
    """Return the speed of the 3000th impact: a hundredth of a second or so."""
    run = pc.simulate(osc, force, v0=1.0, max_impacts=3000)
    return float(run.impacts.v_after[-1])


def failing(osc: pc.Oscillator, force: pc.Forcing) -> float:
    """Raise at some points."""
    if float(force.frequency or 0) > 2.5:
        raise RuntimeError("no answer here")
    return float(osc.stiffness)


if __name__ == "__main__":
    (chart if sys.argv[2] == "chart" else exponents)(sys.argv[1])
