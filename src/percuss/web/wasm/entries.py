"""The exports of the file of WebAssembly: kernels, with the types of their arguments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from percuss.arrays import Floats, Integers
from percuss.kernels import fill_law as law_filling
from percuss.kernels import march as engine
from percuss.kernels import sample
from percuss.kernels.record import MotionRecord, Run
from percuss.web.wasm import attractors, basins, curve, exponents
from percuss.web.wasm.basins import Space

# The arguments of each entry: f and i are a double and an integer, F1, F2, F3 and I1, I2 arrays of
# them with so many dimensions, C-contiguous; what stands in brackets is one tuple in Python.
SPACE = "F2 F1 I1 F3 F2 I2 F2 F1 F1 F2 F2 F2 F2 F2 F2 F1 F3 F1 F1 F2 I2"
SIGNATURES = {
    "fill_law": "F2 I1 F2",
    "march": "F2 F1 I1 F2 F2 F2 F2 I2 F2 f i i",
    "cycles": "F2 F1 F1 F1",
    "evaluate": "F2 f F2 I2 F1 F2 F2 F2",
    "instant": "F2",
    "cut": "F2 f F2 I2 f f F1",
    "count_points": "F2 f F2 I2 f F1 I1",
    "trace": "F2 f F2 I2 F1 I1 F3 F2 F2 I1",
    "without_rests": "F1 F1 F1 i F2",
    "to_columns": "F1 F1 I1 i i F2",
    "stop_forces": "F2 I1 F2 f F2 I2 F2 F2 F2",
    "spectrum": "F1 F2",
    "attractor": "F2 F1 I1 F3 F2 I2 F2 F1 F1 F1 F1 F2 F2 F1 F3 F2",
    "classify": f"{SPACE} F1 F2 F2",
    "label": f"{SPACE} F1 F2 I1 F2 F2",
    "exponent": f"{SPACE} F1 F1",
}


def fill_law(given: Floats, bounds: Integers, law: Floats) -> int:
    """Fill the law."""
    return law_filling.fill_law(given, bounds, law)


def march(
    law: Floats,
    state: Floats,
    counters: Integers,
    phases: Floats,
    arrival: Floats,
    walker: Floats,
    events: Floats,
    marks: Integers,
    grazes: Floats,
    t_end: float,
    max_impacts: int,
    patience: int,
) -> int:
    """Follow a motion."""
    run = Run(law, state, counters, phases, arrival, walker, events, marks, grazes)
    return engine.march(run, t_end, max_impacts, patience)


def cycles(law: Floats, t: Floats, t_low: Floats, out: Floats) -> int:
    """Write the cycles of instants."""
    sample.cycles(law, t, t_low, out)
    return 0


def evaluate(
    law: Floats,
    x0: float,
    events: Floats,
    marks: Integers,
    instants: Floats,
    phases: Floats,
    arrival: Floats,
    motion: Floats,
) -> int:
    """Evaluate a motion, at events after them."""
    record = MotionRecord(law, x0, events, marks)
    sample.evaluate(record, instants, True, phases, arrival, motion)
    return 0


def instant(numbers: Floats) -> int:
    """Write an instant."""
    curve.instant(numbers)
    return 0


def cut(
    law: Floats, x0: float, events: Floats, marks: Integers, low: float, high: float, cuts: Floats
) -> int:
    """Write the ends of the pieces of a motion."""
    return curve.cut(MotionRecord(law, x0, events, marks), low, high, cuts)


def count_points(
    law: Floats,
    x0: float,
    events: Floats,
    marks: Integers,
    omega: float,
    cuts: Floats,
    counts: Integers,
) -> int:
    """Count the points of each piece."""
    return curve.count_points(MotionRecord(law, x0, events, marks), omega, cuts, counts)


def trace(
    law: Floats,
    x0: float,
    events: Floats,
    marks: Integers,
    cuts: Floats,
    counts: Integers,
    phases: Floats,
    ends: Floats,
    drawn: Floats,
    jumps: Integers,
) -> int:
    """Write the points of a curve."""
    record = MotionRecord(law, x0, events, marks)
    return curve.trace(record, cuts, counts, phases, ends, drawn, jumps)


def without_rests(t: Floats, x: Floats, v: Floats, most: int, out: Floats) -> int:
    """Write the end of a curve for a portrait."""
    return curve.without_rests(x, t, v, most, out)


def to_columns(
    t: Floats, values: Floats, jumps: Integers, columns: int, most: int, out: Floats
) -> int:
    """Reduce a curve to what a picture of some width shows."""
    return curve.to_columns(t, values, jumps, columns, most, out)


def stop_forces(
    given: Floats,
    bounds: Integers,
    law: Floats,
    x0: float,
    events: Floats,
    marks: Integers,
    phases: Floats,
    drawn: Floats,
    out: Floats,
) -> int:
    """Write the forces of stops along a curve."""
    record = MotionRecord(law, x0, events, marks)
    curve.stop_forces(given, bounds, record, phases, drawn, out)
    return 0


def spectrum(values: Floats, work: Floats) -> int:
    """Write the amplitudes of equidistant values."""
    curve.spectrum(values, work)
    return 0


def attractor(
    law: Floats,
    state: Floats,
    counters: Integers,
    phases: Floats,
    events: Floats,
    marks: Integers,
    grazes: Floats,
    start: Floats,
    asked: Floats,
    plan: Floats,
    values: Floats,
    points: Floats,
    stops: Floats,
    best: Floats,
    scratch: Floats,
    out: Floats,
) -> int:
    """Follow a motion, and write its points on a section."""
    attractors.clear(state, counters)
    run = Run(law, state, counters, phases[0], phases[1], phases[2], events, marks, grazes)
    loads = attractors.loads_of(law, best, scratch)
    status = attractors.attractor(run, start, asked, (plan, values, points), stops, loads)
    attractors.in_order(points, values, out)
    return status


def classify(space: Space, rules: Floats, starts: Floats, classes: Floats) -> int:
    """Write the classes of starts."""
    return basins.classify_starts(space, rules, starts, classes)


def label(
    space: Space,
    rules: Floats,
    classes: Floats,
    labels: Integers,
    found: Floats,
    drawn: Floats,
) -> int:
    """Write the number of each start's attractor, and the attractors."""
    return basins.label(space, rules, classes, labels, found, drawn)


def exponent(space: Space, start: Floats, out: Floats) -> int:
    """Write the largest exponent of a motion; return 1 where there is one."""
    return 1 if exponents.largest_exponent(space, start, out) else 0


ENTRIES: dict[str, Callable[..., Any]] = {
    entry.__name__: entry
    for entry in (
        fill_law,
        march,
        cycles,
        evaluate,
        instant,
        cut,
        count_points,
        trace,
        without_rests,
        to_columns,
        stop_forces,
        spectrum,
        attractor,
        classify,
        label,
        exponent,
    )
}
