"""Entries into soft stops: those that share an edge are entered once."""

from __future__ import annotations

import numpy as np

from percuss.arrays import Integers
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory


def entry_rows(run: Trajectory | StructureTrajectory) -> Integers:
    """Return the rows of `run.crossings` that count as entries.

    Soft stops of an oscillator that share an edge are entered together: the table has a row for
    each of them, and the first one counts, as in ``max_impacts``, in `sweep` and in the impacts of
    an orbit. Of a structure the entry into each stop counts.

    Examples
    --------
    >>> import percuss as pc
    >>> spring = pc.SoftStop(at=0, side="below", stiffness=3)
    >>> run = pc.simulate(pc.Oscillator(1, 0, [spring, spring]), v0=1, t_end=6)
    >>> run.crossings.direction.tolist(), entry_rows(run).tolist()
    (['in', 'in', 'out', 'out'], [0])
    """
    rows = np.flatnonzero(run.crossings.direction == "in")
    if isinstance(run, StructureTrajectory):
        return rows
    edges = np.empty(len(run.oscillator.stops), dtype=np.int64)
    for number, stops in enumerate(run.system.lines.edges):
        edges[list(stops)] = number
    edge, t = edges.take(run.crossings.stop[rows]), run.crossings.t[rows]
    is_next = np.ones(len(rows), dtype=bool)
    is_next[1:] = (edge[1:] != edge[:-1]) | (t[1:] != t[:-1])
    return rows[is_next]
