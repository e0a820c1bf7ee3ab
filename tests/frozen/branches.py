"""Branches and curves of every kind: their values, special points and ends, as numbers."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from tests.frozen.motions import system

import percuss as pc
from percuss.errors import PercussError

OMEGA, AMPLITUDE, CONSTANT = "forcing.omega", "forcing.amplitude", "forcing.constant"
WALL, OTHER, RESTITUTION = (
    "oscillator.stops.0.at",
    "oscillator.stops.1.at",
    "oscillator.stops.0.restitution",
)
COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
SOFT = pc.Oscillator(1.0, "0.05", (pc.SoftStop(1.0, "above", 9.0),))
MIRRORED = pc.Oscillator(1.0, 0.02, (pc.Wall(-1.0, "below", 0.7), pc.Wall(1.0, "above", 0.7)))
TWO_WALLS = pc.Oscillator(1, 0.05, (pc.Wall(-0.2, "below", 0.3), pc.Wall(0.3, "above", 0.2)))
GEAR = pc.backlash_oscillator(gap=0.5, stiffness=10.0, damping=0.04, stop_damping=0.02)
BILINEAR = pc.bilinear_oscillator(stiffness_above=1.0, stiffness_below=27.7, damping=0.069)

Results = Iterator[tuple[str, Any]]


def _coco() -> Results:
    branch = pc.continue_orbit(pc.find_orbit(COCO, pc.cosine(1)), over={AMPLITUDE: (1, 0.05)})
    yield "branch", branch
    plane = {OMEGA: (0.7, 1.3), AMPLITUDE: (0.01, 1.2)}
    for point in branch.special_points:
        yield f"curve of {point.kind}", pc.continue_curve(point, plane)
    graze = next(point for point in branch.special_points if point.kind == "grazing")
    yield "switched at the graze", pc.switch_branch(graze)
    gaps = pc.find_orbit(COCO, pc.cosine(1, amplitude="0.5"))
    yield "over the gap", pc.continue_orbit(gaps, over={WALL: (1.0, 9.0)})


def _doublings() -> Results:
    osc = pc.impact_oscillator(0.8)
    branch = pc.continue_orbit(pc.find_orbit(osc, pc.cosine(2.6)), over={OMEGA: (2.6, 2.75)})
    yield "single", branch
    doubled = pc.switch_branch(branch.special_points[0])
    yield "doubled", pc.continue_orbit(doubled, over={OMEGA: (2.65, 2.7)})
    plane = {OMEGA: (2.5, 2.8), RESTITUTION: (0.75, 0.85)}
    yield "curve", pc.continue_curve(branch.special_points[0], plane)
    above = pc.find_orbit(pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05"),
                          pc.cosine("2.8"))  # fmt: skip
    yield "above", pc.continue_orbit(above, over={OMEGA: (2.6, 3.2)})


def _soft() -> Results:
    orbit = pc.find_orbit(SOFT, pc.cosine("1.5", amplitude=3))
    branch = pc.continue_orbit(orbit, over={AMPLITUDE: (4.0, 0.5)})
    yield "branch", branch
    plane = {OMEGA: (1.3, 1.7), AMPLITUDE: (0.5, 4.0)}
    for k, point in enumerate(branch.special_points):
        if point.kind in ("fold", "grazing"):
            yield f"{point.kind} {k}", pc.continue_curve(point, plane, max_points=60)
    inside = pc.backlash_oscillator(gap=1.0, stiffness=9.0, damping=0.1, stiffness_inside=1.0)
    calm = pc.find_orbit(inside, pc.cosine(1.5, amplitude=0.5), 0)
    yield "backlash", pc.continue_orbit(calm, over={AMPLITUDE: (0.2, 6.0)})
    bent = pc.bilinear_oscillator(1.0, stiffness_below=4.0, damping=0.05)
    aside = pc.find_orbit(bent, pc.cosine(1.2, constant=3.0), 0)
    yield "bilinear", pc.continue_orbit(aside, over={OMEGA: (0.3, 3.0)})


def _mirrored() -> Results:
    orbit = pc.find_orbit(MIRRORED, pc.cosine(1.5), 2, 1)
    branch = pc.continue_orbit(orbit, over={AMPLITUDE: (0.05, 2.0)})
    yield "branch", branch
    for point in branch.special_points:
        if point.kind == "symmetry_breaking":
            asymmetric = pc.switch_branch(point)
            yield "broken", pc.continue_orbit(asymmetric, over={AMPLITUDE: (1.5, 2.0)})
            yield "curve", pc.continue_curve(point, {OMEGA: (1.4, 1.6), AMPLITUDE: (0.1, 2.0)})
    yield "a wall that moves", pc.continue_orbit(orbit, over={OTHER: (1.5, 0.8)})


def _conservative() -> Results:
    osc = pc.impact_oscillator(1, wall=-0.5)
    orbit = pc.find_orbit(osc, pc.cosine(2.6))
    yield "strong resonances", pc.continue_orbit(orbit, over={OMEGA: (2.2, 3.8)})


def _sticking() -> Results:
    for osc, omega, over in (
        (pc.impact_oscillator(0.3, damping=0.05), 0.8, {OMEGA: (0.2, 2.0)}),
        (pc.impact_oscillator(0.0, damping=0.05), 0.8, {WALL: (-2.0, 1.5)}),
        (TWO_WALLS, 0.5, {OMEGA: (0.2, 2.0)}),
        (pc.impact_oscillator(0.3, wall=0.2, damping=0.05), 0.8, {WALL: (-2.0, 1.5)}),
    ):
        orbit = pc.find_orbit(osc, pc.cosine(omega), math.inf)
        yield f"{osc.stops[0]!r} over {next(iter(over))}", pc.continue_orbit(orbit, over=over)


def _grazes() -> Results:
    orbit = pc.find_orbit(pc.impact_oscillator(0.5, wall=-0.3), pc.cosine(1.3))
    yield "through grazes", pc.continue_orbit(orbit, over={OMEGA: (1.3, 0.6)})
    dead = pc.find_orbit(pc.impact_oscillator(0, wall="0.2"), pc.cosine("2.5"))
    yield "dead wall", pc.continue_orbit(dead, over={OMEGA: (2, 4)})
    fast = pc.find_orbit(pc.impact_oscillator("0.8", wall=0.5, side="above", damping="0.02"),
                         pc.cosine("2.9"), 1, 2)  # fmt: skip
    yield "two periods", pc.continue_orbit(fast, over={OMEGA: (1.5, 6)})
    together = pc.find_orbit(pc.impact_oscillator(0.7, wall=0.113, damping=0.05),
                             pc.cosine(3.409, 1.694, phase=0.7), 2, 2)  # fmt: skip
    yield "impacts together", pc.continue_orbit(together, over={WALL: (-1.0, 1.0)})


def _gears() -> Results:
    orbit = pc.find_orbit(GEAR, pc.cosine(1.9, amplitude=0.9, constant=0.4), 1)
    yield "gear", pc.continue_orbit(orbit, over={OMEGA: (1.5, 2.5)})
    stiff = pc.find_orbits(
        BILINEAR, pc.cosine(1.96, amplitude=0.71, constant=-0.46), max_impacts=2, max_periods=2
    )[0]
    yield "stiff", pc.continue_orbit(stiff, over={OMEGA: (1.5, 2.5)})
    unstable = pc.Oscillator("-0.3", 0, (pc.Wall(-1, "below", 0.8), pc.Wall(1, "above", 0.8)))
    rest = pc.find_orbit(unstable, pc.cosine("0.952", amplitude="0.496"), 0)
    yield "saddle", pc.continue_orbit(rest, over={CONSTANT: (-0.18, 0.18)})


def _others() -> Results:
    osc = pc.impact_oscillator(0.8)
    yield (
        "cascade",
        pc.follow_cascade(pc.find_orbit(osc, pc.cosine(2.6)), over={OMEGA: (2.6, 2.75)}),
    )
    yield "velocity gap", pc.velocity_gap_curve(COCO, pc.cosine("1.5"))
    yield "singularities", pc.singularity_set(osc, pc.cosine(2.66), n_iterates=2)
    yield "response", pc.response_curve(COCO, pc.cosine(1), over={OMEGA: (0.8, 1.2)})
    force = pc.cosine("2.8")
    above = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    yield "search", pc.find_orbits(above, force, max_periods=4)


def _at_random() -> Results:
    """Orbits of random systems, each followed over one of two parameters."""
    for seed in range(40):
        osc, force, _ = system(1000 + seed)
        found = pc.find_orbits(osc, force, max_impacts=2, max_periods=2)
        yield f"orbits of {seed}", found
        for orbit in found[:1]:
            path, value = (
                (OMEGA, 2 * math.pi / (force.period or 1.0)) if seed % 2 else (CONSTANT, 0.0)
            )
            over = {path: (value - 0.2, value + 0.2)}
            try:
                branch = pc.continue_orbit(orbit, over=over, max_points=100)
            except PercussError as error:
                yield f"branch of {seed}", str(error)
            else:
                yield f"branch of {seed}", branch


PARTS: tuple[Callable[[], Results], ...] = (
    _coco, _doublings, _soft, _mirrored, _conservative, _sticking, _grazes, _gears, _others,
    _at_random,
)  # fmt: skip


def _plain(result: Any) -> Any:
    """Return the numbers and words of a result."""
    if isinstance(result, pc.PeriodicOrbit):
        start = [result.t0, result.x0, result.v0, result.period, result.residual < 1e-6]
        return [start, result.n_impacts, result.n_periods, result.stability,
                _plain(np.asarray(result.multipliers))]  # fmt: skip
    if isinstance(result, pc.Branch | pc.Curve):
        values = [[p.kind, _plain(np.asarray(getattr(p, "values", getattr(p, "value", None))))]
                  for p in result.special_points]  # fmt: skip
        ends = [_plain(result.values[0]), _plain(result.values[-1])]
        middle = _plain(result.orbits[len(result) // 2])
        return [len(result), ends, values, result.end_reason, middle]
    if isinstance(result, pc.FoundOrbits | list | tuple):
        return [_plain(item) for item in result]
    if isinstance(result, np.ndarray):
        if np.iscomplexobj(result):
            return [_plain(result.real), _plain(result.imag)]
        return result.tolist()
    if hasattr(result, "to_xarray"):
        data = result.to_xarray()
        return {str(name): _sum_of(data[name].values) for name in data.variables}
    if isinstance(result, str | int | float):
        return result
    names = ("values", "end_reason", "omega", "amplitude", "gap", "velocity", "centre", "shape")
    return [_plain(getattr(result, name)) for name in names if hasattr(result, name)]


def _sum_of(values: Any) -> Any:
    """Return shape and sum, which tell a large table well enough."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        return list(array.shape)
    whole = array[np.isfinite(array)].astype(float)
    return [list(array.shape), float(np.abs(whole).sum())]


def frozen() -> dict[str, Any]:
    """Return all numbers."""
    found: dict[str, Any] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for part in PARTS:
            try:
                for name, result in part():
                    found[f"{part.__name__}, {name}"] = _plain(result)
            except PercussError as error:
                found[f"{part.__name__}, the rest"] = str(error)
    return found
