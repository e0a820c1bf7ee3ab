"""Means over time of a structure's run: of squares of displacements, and of the loads' power."""

from __future__ import annotations

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.law_columns import FIRST_HARMONIC, OMEGA
from percuss.kernels.record import EVENT_T
from percuss.kernels.structure import basis as at
from percuss.kernels.structure.run import StructureRun
from percuss.model.acting_sets import StructureSystem
from percuss.model.oscillator import On
from percuss.motion.energetics import force_at
from percuss.motion.structure_observables import observable_at
from percuss.numerics import gauss_points, panels

# Nodes of Gauss's rule on a piece, and the phase of the quickest rate over it: squares of sines
# then have an error of 1e-18.
NODES, PHASE = 10, 2.0
# Pieces that are evaluated at a time.
AT_ONCE = 8192


def mean_square_of_run(
    system: StructureSystem, run: StructureRun, span: tuple[float, float], on: On | None
) -> float:
    """Return the mean of y^2 over a span of time, y = c . x.

    Between two events the motion is a closed form, and is integrated by Gauss's rule on pieces so
    short that its error is rounding.
    """
    total = 0.0
    for times, weights in _nodes(run, span):
        y = observable_at(system, run, times, "displacement", on=on)
        total += float((weights * y * y).sum())
    return total / (span[1] - span[0])


def mean_power_of_run(
    system: StructureSystem, run: StructureRun, span: tuple[float, float]
) -> float:
    """Return the mean power of all loads over a span of time, that of f c along c . x'."""
    loads = system.loads
    directions = loads.directions(system.structure)
    total = 0.0
    for times, weights in _nodes(run, span):
        for c, forcing in zip(directions, loads.forcings, strict=True):
            v = observable_at(system, run, times, "velocity", on=tuple(c.tolist()))
            total += float((weights * force_at(forcing, times) * v).sum())
    return total / (span[1] - span[0])


def _nodes(run: StructureRun, span: tuple[float, float]) -> list[tuple[Floats, Floats]]:
    """Return times and weights of an integral over a span, in parts."""
    instants = run.events[:, EVENT_T]
    inside = instants[(instants > span[0]) & (instants < span[1])]
    edges = np.concatenate([[span[0]], inside, [span[1]]])
    widths = np.diff(edges)
    m = run.sets.turns.shape[2]
    omegas = run.sets.law[:, FIRST_HARMONIC : FIRST_HARMONIC + m, OMEGA]
    quickest = max(
        float(run.sets.of_set[:, at.QUICKEST].max()), float(np.abs(omegas).max(initial=0.0))
    )
    counts = np.maximum(np.ceil(widths * quickest / PHASE), 1.0).astype(np.int64)
    counts[widths == 0.0] = 0
    begins, each = panels(edges[:-1], edges[1:], counts)
    parts = (slice(first, first + AT_ONCE) for first in range(0, len(begins), AT_ONCE))
    return [gauss_points(begins[part], each[part], NODES) for part in parts]
