"""The segments of a structure's record: each a run from a node with a state of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from percuss.arrays import Floats
from percuss.fitting.effort import Effort
from percuss.fitting.measured import MeasuredSamples, directions_of
from percuss.kernels.segments import (
    N_HITS,
    N_SEARCHES,
    PROGRESS_ENTRIES,
    SEGMENT,
    SegmentResults,
)
from percuss.kernels.structure import sensitivity as carried
from percuss.kernels.structure.run import new_run
from percuss.kernels.structure.segments import (
    SegmentScratch,
    StructureSegments,
    follow_structure_segments,
)
from percuss.kernels.structure.sensitivity import VariedRun
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.moved_structure import MovedStructure, more_columns, moved_sets, moved_structure
from percuss.model.oscillator import SoftStop, Wall
from percuss.model.structure_start import StructureStart

# Events of one segment, and impacts that are kept for each.
MOST_EVENTS = 1_000
HITS_A_SEGMENT = 64


def follow_records(
    system: StructureSystem,
    start: StructureStart | None,
    paths: Sequence[str],
    spans: Floats,
    nodes: Floats,
    samples: MeasuredSamples,
    first: np.ndarray,
    effort: Effort,
) -> SegmentResults:
    """Follow the segments of one record of a structure.

    Parameters
    ----------
    system
        The structure and its loads.
    start
        The start that the first node is; None where that is unknown.
    paths
        The parameters.
    spans
        (n, 2) array, when each segment begins and ends.
    nodes
        (n, 2 n_x) array, the states of the nodes; those behind a wall are moved onto it.
    samples, first
        What was measured, and the first sample of each segment, with the number of all last.
    effort
        What this may cost; segments beyond it are not followed.

    Returns
    -------
    SegmentResults
        The samples and ends, with a column for each parameter, then for each number of the node.
    """
    structure, n = system.structure, len(spans)
    n_x, n_p = structure.n, len(paths)
    d = 2 * n_x
    moved = moved_structure(system, start, paths) if paths else _unmoved(system)
    begins = np.zeros((n, d + 1, n_p + d))
    begins[:, np.arange(d), n_p + np.arange(d)] = 1.0
    if start is not None:
        begins[0] = 0.0
        begins[0, :, :n_p] = moved.begin.T
        nodes[0] = np.concatenate([start.x, start.v])
        spans[0, 0] = as_float(start.t0)
    keys = _prepare_nodes(system, moved, nodes, begins)
    own_sets = np.array(system.numbers_of(keys), dtype=np.int64)
    width = n_p + d
    results = new_results(len(samples), n, d, width)
    places = np.ascontiguousarray(np.stack([nodes[:, :n_x], nodes[:, n_x:]], axis=2))
    stops = _stop_rows(system)
    moved_stops = np.zeros((width, len(structure.stops), 3))
    moved_stops[:n_p] = moved.stops
    segments = StructureSegments(
        spans, places, own_sets, begins, first, samples.t, samples.quantities, samples.reach,
        directions_of(structure), stops, moved_stops, system.signs,
        np.ascontiguousarray(structure.stop_directions).reshape(-1, n_x),
    )  # fmt: skip
    progress = np.zeros(PROGRESS_ENTRIES, dtype=np.int64)
    varied, scratch = _space(system, moved, n_p)
    while progress[SEGMENT] < n:
        before = int(progress[N_SEARCHES])
        wanted = follow_structure_segments(varied, segments, scratch, results, progress)
        if not effort.spend(int(progress[N_SEARCHES]) - before):
            break
        if wanted >= 0:
            system.add(int(wanted))
            varied, scratch = _space(system, moved, n_p)
    return results._replace(hits=results.hits[: progress[N_HITS]])


def new_results(n_samples: int, n: int, d: int, n_columns: int) -> SegmentResults:
    """Return what comes of n segments of states of d numbers, before any is followed."""
    return SegmentResults(
        np.full((n_samples, 2), np.nan),
        np.full((n_samples, 2, n_columns), np.nan),
        np.full(n_samples, np.inf),
        np.full((n, d), np.nan),
        np.full((n, d, n_columns), np.nan),
        np.empty((HITS_A_SEGMENT * n, 2 + n_columns)),
        np.full(n, -1, dtype=np.int64),
    )


def _unmoved(system: StructureSystem) -> MovedStructure:
    """Return the derivatives by no parameter."""
    n, s = system.structure.n, len(system.structure.stops)
    none = np.zeros((0, n, n))
    walls = np.zeros((0, *system.sets.walls.shape))
    return MovedStructure(
        (), none, none, none, np.zeros((0, s, 3)), walls, (), np.zeros((0, 2 * n + 1))
    )


def _space(
    system: StructureSystem, moved: MovedStructure, n_p: int
) -> tuple[VariedRun, SegmentScratch]:
    """Return a run with its change by the parameters and, last, by none for the node's numbers."""
    sets, n_x = system.sets, system.structure.n
    change = more_columns(moved_sets(system, moved, sets), 2 * n_x)
    width = n_p + 2 * n_x
    run = new_run(sets, MOST_EVENTS)
    none = np.zeros(0)
    varied = VariedRun(run, change, none, none.astype(np.int64), np.zeros((0, width)))
    record, work = carried.new_columns(varied)
    scratch = SegmentScratch(
        record, work, np.zeros((n_x, 2)), np.zeros((1, n_x, 2)), np.zeros(1),
        np.zeros((1, 2, n_x, width)), np.zeros((n_x, width)), np.zeros(n_x),
    )  # fmt: skip
    return varied, scratch


def _stop_rows(system: StructureSystem) -> Floats:
    """Return place, stiffness and damping of each stop, (n_stops, 3)."""
    stops = system.structure.stops
    rows = np.zeros((len(stops), 3))
    for row, stop in zip(rows, stops, strict=True):
        row[0] = as_float(stop.at)
        if isinstance(stop, SoftStop):
            row[1:] = as_float(stop.stiffness), as_float(stop.damping)
    return rows


def _prepare_nodes(
    system: StructureSystem, moved: MovedStructure, nodes: Floats, begins: Floats
) -> list[int]:
    """Move nodes out of walls, with their columns, and return the soft stops that press there.

    A node is moved along M^-1 c, by which it comes onto the wall wherever that is.
    """
    structure, n_x, n_p = system.structure, system.structure.n, len(moved.paths)
    sets = system.sets
    for i, stop in enumerate(structure.stops):
        if not isinstance(stop, Wall):
            continue
        normal, along = sets.normals[i], sets.impulses[i]
        level = system.signs[i] * as_float(stop.at)
        depth = level - (nodes[:, :n_x] * normal).sum(axis=1)
        for k in np.flatnonzero(depth > 0.0).tolist():
            nodes[k, :n_x] += along * depth[k]
            deeper = -(normal[:, None] * begins[k, :n_x]).sum(axis=0)
            deeper[:n_p] += system.signs[i] * moved.stops[:, i, 0]
            begins[k, :n_x] += along[:, None] * deeper
    keys = system.keys_at(nodes[:, :n_x], nodes[:, n_x:]).tolist()
    for key in sorted(set(keys)):
        system.add(int(key))
    return [int(key) for key in keys]
