"""Runs at random, and the reference cases: digests of their events."""

from __future__ import annotations

import random
import warnings
from typing import Any

from tests.reference.measures import load_cases
from tests.reproducible.results import digest, ensembles, motions

import percuss as pc
from percuss.errors import PercussError

N_RUNS = 200


def system(seed: int) -> tuple[pc.Oscillator, pc.Forcing, dict[str, Any]]:
    """Return an oscillator, a force and a start, of which every regime has its part."""
    some = random.Random(seed)
    stops: list[pc.Wall | pc.SoftStop] = []
    for side, sign in (("above", 1.0), ("below", -1.0)):
        kind = some.choice(("none", "wall", "wall", "soft"))
        at = sign * round(some.uniform(0.1, 1.5), 3)
        if kind == "wall":
            stops.append(pc.Wall(at, side, some.choice((1, 0.9, "4/5", 0.5, 0.1, 0))))  # type: ignore[arg-type]
        elif kind == "soft":
            stops.append(pc.SoftStop(at, side, round(10 ** some.uniform(0, 4), 3),  # type: ignore[arg-type]
                                     some.choice((0.0, 0.2, 3.0))))  # fmt: skip
    stiffness = some.choice((1.0, 1.0, 4.0, 0.0, -0.3))
    damping = some.choice((0.0, 0.02, 0.1, 1.0, 2.5))
    omega = round(some.uniform(0.3, 4.0), 3)
    force = pc.fourier(
        omega,
        cos=tuple(round(some.uniform(-1, 1), 3) for _ in range(some.randint(1, 3))),
        constant=some.choice((0.0, 0.0, -0.4)),
    )
    start = {"x0": 0.0, "v0": round(some.uniform(-1, 1), 3), "t0": round(some.uniform(0, 2), 3)}
    return pc.Oscillator(stiffness, damping, tuple(stops)), force, start


def _events(run: pc.Trajectory) -> list[object]:
    tables = (run.impacts, run.crossings, run.contacts, run.grazes)
    return [*(table.to_xarray() for table in tables), run.t_end, run.outcome.value]


def at_random() -> dict[str, str]:
    """Return the events of runs at random."""
    found = {}
    for seed in range(N_RUNS):
        osc, force, start = system(seed)
        try:
            run = pc.simulate(osc, force, **start, periods=40, max_impacts=400)
        except PercussError as error:
            found[f"run {seed}"] = str(error)
        else:
            found[f"run {seed}"] = digest(_events(run))
    return found


def references() -> dict[str, str]:
    """Return the events of the reference cases."""
    found = {}
    for case in load_cases():
        x0, v0, t0 = case.start()
        run = pc.simulate(case.oscillator(), case.force(), x0, v0, t0, **case.limits())
        found[case.id] = digest(_events(run))
    return found


def over_grids() -> dict[str, str]:
    """Return observables and points of a sweep, a diagram and basins, on threads and processes."""
    found: dict[str, object] = dict(ensembles())
    osc, force = pc.impact_oscillator("0.8"), pc.cosine(2.66)
    over = {"forcing.harmonics.0.omega": [2.5, 2.6, 2.7, 2.8], "start.v0": [0.1, 0.5]}
    names = ("peak_impact_velocity", "impacts_per_period", "period", "largest_lyapunov_exponent")
    sweeps = {
        engine: pc.sweep(names, osc, force, over=over, transient=20, periods=60, engine=engine)
        for engine in ("threads", "processes")
    }
    found |= {f"sweep on {engine}": data for engine, data in sweeps.items()}
    return {name: digest(value) for name, value in found.items()}


def frozen() -> dict[str, str]:
    """Return all digests."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        named = {name: digest(value) for name, value in motions().items()}
        return {**references(), **at_random(), **named, **over_grids()}
