"""A digest of each of many results, to the bit; run with a setting of the machine, it prints them.

python -m tests.reproducible.results [quick]
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import percuss as pc

GEAR = pc.backlash_oscillator(gap=0.5, stiffness=10.0, damping=0.04, stop_damping=0.02)
COCO = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
TWO_WALLS = (pc.Wall(-1.0, "below", 0.7), pc.Wall(1.0, "above", 0.9))
SOFT = (pc.SoftStop(0.5, "above", 29.0, 0.3), pc.SoftStop(-0.5, "below", 5.0))
BOTH = pc.fourier(2.0, cos=(1.0, 0.2), sin=(0.3, 0.1), constant=0.1)

# Chatter and release; walls and soft stops; overdamped; unstable; resonance; chaos; soft gears.
RUNS: dict[str, tuple[Any, Any, float, float, float]] = {
    "chatter": (pc.impact_oscillator(0.3), pc.cosine(2.7, constant=-0.8), 0.0, 1.0, 60.0),
    "soft": (pc.Oscillator(1.0, 0.02, (*TWO_WALLS, *SOFT)), BOTH, 0.1, 2.0, 300.0),
    "overdamped": (pc.impact_oscillator(0.5, damping=3.0), pc.sine(1.0), 0.0, 1.0, 60.0),
    "unstable": (pc.Oscillator(-0.5, 0.01, TWO_WALLS), BOTH, 0.1, 0.0, 60.0),
    "resonance": (pc.impact_oscillator(0.9, damping="0.001"), pc.sine(1), 0.0, 0.5, 200.0),
    "chaos": (pc.impact_oscillator(0.8), pc.cosine(2.66), 0.0, 0.3, 2000.0),
    "gear": (GEAR, pc.cosine(1.9, amplitude=0.9, constant=0.4), 0.0, 0.1, 500.0),
}


def digest(value: object) -> str:
    """Return a digest of all numbers and words of a result."""
    hashed = hashlib.sha256()
    _feed(hashed.update, value)
    return hashed.hexdigest()[:16]


def _feed(update: Callable[[bytes], object], value: Any) -> None:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            _feed(update, getattr(value, field.name))
    elif isinstance(value, Mapping):
        for key in value:
            update(str(key).encode())
            _feed(update, value[key])
    elif isinstance(value, np.ndarray):
        if value.dtype == object:
            _feed(update, value.tolist())
        else:
            update(np.ascontiguousarray(value).tobytes())
    elif hasattr(value, "data_vars"):
        _feed(update, {name: value[name].values for name in value.variables})
    elif isinstance(value, tuple | list):
        for item in value:
            _feed(update, item)
    elif isinstance(value, float):
        update(np.float64(value).tobytes())
    else:
        update(repr(value).encode())


def motions() -> dict[str, object]:
    """Runs, sampled, with their spectra and growth."""
    found: dict[str, object] = {}
    for name, (osc, force, x0, v0, t_end) in RUNS.items():
        run = pc.simulate(osc, force, x0, v0, t_end=t_end)
        tables = run.impacts, run.crossings, run.contacts
        found[name] = [table.to_xarray() for table in tables]
        found[f"{name}, sampled"] = run(np.linspace(0.0, run.t_end, 500))
    chaos = RUNS["chaos"]
    run = pc.simulate(*chaos[:4], t_end=200.0)
    found["spectrum"] = pc.spectrum(run, omega=np.linspace(0.0, 6.0, 300))
    found["fast spectrum"] = pc.spectrum(run, method="fft", of="velocity")
    found["line spectrum"] = pc.line_spectrum(
        pc.simulate(COCO, pc.cosine(1.0), periods=60), 2.0 * np.pi, 9
    )
    found["growth"] = pc.growth(pc.simulate(pc.impact_oscillator(), pc.sine(1), periods=400))
    found["eigenset"] = pc.eigenset_motion("1/2", np.linspace(0.0, 20.0, 200))
    return found


def orbits() -> dict[str, object]:
    """Orbits, branches and their special points."""
    orbit = pc.find_orbit(GEAR, pc.cosine(1.9, amplitude=0.9, constant=0.4), 1)
    single = pc.find_orbit(COCO, pc.cosine(1.0))
    found: dict[str, object] = {"gear": orbit, "one impact": single}
    branch = pc.continue_orbit(single, over={"forcing.amplitude": (1.0, 0.05)})
    found["branch"] = [branch.values, [(p.kind, p.value) for p in branch.special_points]]
    return found


def more_orbits() -> dict[str, object]:
    """All orbits of a search, a curve, a cascade, a response, manifolds, a chart of singularities."""
    osc = pc.impact_oscillator(0.7, wall="1.45789", side="above", damping=0.05)
    found: dict[str, object] = {"search": pc.find_orbits(osc, pc.cosine("1.5"), 1, 2)}
    doubled = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    branch = pc.continue_orbit(doubled, over={"forcing.omega": (2.6, 2.7)})
    point = branch.special_points[0]
    curve = pc.continue_curve(
        point, over={"forcing.omega": (2.5, 2.8), "oscillator.stops.0.restitution": (0.75, 0.85)}
    )
    found["curve"] = curve
    found["switched"] = pc.switch_branch(point)
    found["velocity gap"] = pc.velocity_gap_curve(osc, pc.cosine("1.5"))
    found["singularities"] = pc.singularity_set(
        pc.impact_oscillator(0.8), pc.cosine(2.66), n_iterates=2
    )
    return found


def ensembles() -> dict[str, object]:
    """Sweeps, diagrams, basins and exponents."""
    wall, force = pc.impact_oscillator(0.8), pc.cosine(2.66)
    found: dict[str, object] = {}
    found["lyapunov"] = pc.lyapunov_exponents(wall, force, start=(0.0, 0.3), periods=500)
    found["lyapunov, gear"] = pc.lyapunov_exponents(
        *RUNS["gear"][:2], start=(0.0, 0.1), periods=300
    )
    found["diagram"] = pc.bifurcation_diagram(
        wall,
        force,
        over={"forcing.harmonics.0.omega": np.linspace(2.5, 2.8, 21)},
        transient=100,
        points=20,
    )
    found["basins"] = pc.basins(
        COCO, pc.cosine(1.0), x0=np.linspace(-1, 0.9, 8), v0=np.linspace(-1, 1, 8), periods=200
    )
    return found


QUICK = (motions, orbits)
ALL = (*QUICK, more_orbits, ensembles)

if __name__ == "__main__":
    parts = QUICK if "quick" in sys.argv else ALL
    results = {name: value for part in parts for name, value in part().items()}
    sys.stdout.write(json.dumps({name: digest(value) for name, value in results.items()}))
