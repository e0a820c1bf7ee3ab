"""Multiple shooting: a record cut into segments, each a run from a node with a state of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.fitting.effort import Effort
from percuss.fitting.measured import MeasuredRecord, MeasuredSamples
from percuss.fitting.structure_shooting import follow_records, new_results
from percuss.kernels import sensitivity as carried
from percuss.kernels.flight_columns import (
    Change,
)
from percuss.kernels.law_columns import COLUMNS
from percuss.kernels.record import new_run
from percuss.kernels.segments import (
    N_HITS,
    N_SEARCHES,
    PROGRESS_ENTRIES,
    Segments,
    SegmentSpace,
    follow_segments,
)
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.moved_law import MovedLaw, moved_law
from percuss.model.oscillator import Oscillator
from percuss.model.paths import replace_parameters
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.model.system import System, stop_rows
from percuss.motion.instants import times_within
from percuss.motion.moved_motion import workspace_of

# Events of one segment.
MOST_EVENTS = 4_000
# Numbers beyond this are those of motions that grow without end.
LARGEST = 1e60


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The segments of a record: their nodes, ends and samples.

    Attributes
    ----------
    record
        What was measured, and under which forcing.
    spans
        (n, 2) array, when each begins, at its node, and ends.
    first
        (n + 1,) array, the first sample of each segment, and the number of all.
    is_fixed
        Whether the first node is the start of the record, and no unknown.
    keys
        Of a structure, the sets of acting stops that were met so far: the next run may need them.
    """

    record: MeasuredRecord
    spans: Floats
    first: Integers
    is_fixed: bool
    keys: set[int] = field(default_factory=set)

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.spans)


@dataclass(frozen=True, slots=True, eq=False)
class Shots:
    """The runs of all segments of all records, one after the other, with their derivatives.

    A node has d numbers, x and v of each coordinate: d = 2 of an oscillator.

    Attributes
    ----------
    nodes
        (n, d) array, x and v at the nodes; those behind a wall are moved onto it.
    values, rows
        (n_samples, 2) and (n_samples, 2, n_parameters + d) arrays, what is measured and its
        derivatives, by the state of the segment's own node last; and the same on the other side of
        an event near by.
    away
        (n_samples,) array, how far that event is; infinite where there is none.
    ends, end_rows
        (n, d) and (n, d, n_parameters + d) arrays, of x and v at the ends of the segments.
    counts
        (n,) array, events of each segment; negative where it was not followed.
    hits
        (n_hits, 2 + n_parameters + d) array, the impacts and entries into soft stops: the segment,
        the instant, and its derivatives.
    """

    nodes: Floats
    values: Floats
    rows: Floats
    away: Floats
    ends: Floats
    end_rows: Floats
    counts: Integers
    hits: Floats

    @property
    def is_complete(self) -> bool:
        """Whether all segments were followed, to numbers whose products are numbers too."""
        has_event = np.isfinite(self.away)
        numbers = (
            self.values[:, 0], self.rows[:, 0], self.values[has_event, 1], self.rows[has_event, 1],
            self.ends, self.end_rows, self.hits,
        )  # fmt: skip
        # A comparison with NaN is false.
        sizes = [float(np.abs(some).max(initial=0.0)) for some in numbers]
        return bool((self.counts >= 0).all()) and all(size < LARGEST for size in sizes)


def shoot(
    osc: Oscillator | Structure,
    layouts: Sequence[Layout],
    values: Mapping[str, float],
    nodes: Floats,
    effort: Effort | None = None,
) -> Shots:
    """Follow all segments at a setting of the parameters.

    Parameters
    ----------
    osc
        The oscillator, or the structure.
    layouts
        The records with their nodes.
    values
        The parameters by their paths.
    nodes
        (n, d) array, the states of the nodes.
    effort
        What this may cost; default: as much as the first run of a fit.

    Returns
    -------
    Shots
        The runs. Where they cost too much the last ones are not followed.

    Raises
    ------
    ParameterError
        If the values make no model.
    """
    parts = []
    row = 0
    effort = Effort() if effort is None else effort
    effort.begin_run(len(nodes))
    for layout in layouts:
        record = layout.record
        moved_osc, force, start = replace_parameters(osc, record.force, record.start, values)
        own = nodes[row : row + len(layout)].copy()
        row += len(layout)
        if isinstance(moved_osc, Structure):
            loaded = StructureSystem.of(moved_osc, force)
            parts.append(_structure_shots(layout, loaded, start, list(values), own, effort))
            continue
        assert not isinstance(force, Loads)
        assert not isinstance(start, StructureStart)
        system = System(moved_osc, force)
        moved = moved_law(system, start, list(values)) if values else None
        parts.append(_record_shots(layout, system, start, moved, own, effort))
    shots = parts[0] if len(parts) == 1 else _joined(parts)
    effort.end_run(is_followed=bool((shots.counts >= 0).all()))
    return shots


def _structure_shots(
    layout: Layout,
    system: StructureSystem,
    start: Start | StructureStart | None,
    paths: Sequence[str],
    nodes: Floats,
    effort: Effort,
) -> Shots:
    """Return what comes of the segments of a structure's record."""
    assert not isinstance(start, Start)
    for key in layout.keys:
        system.add(key)
    fixed = start if layout.is_fixed else None
    samples = layout.record.samples
    results = follow_records(
        system, fixed, paths, layout.spans.copy(), nodes, samples, layout.first, effort
    )
    layout.keys.update(system.sets.keys.tolist())
    return Shots(nodes, **results._asdict())


def _joined(parts: Sequence[Shots]) -> Shots:
    before = 0
    hits = []
    for part in parts:
        hits.append(part.hits.copy())
        hits[-1][:, 0] += before
        before += len(part.nodes)

    def joined(name: str) -> Any:
        return np.concatenate([getattr(part, name) for part in parts])

    return Shots(
        joined("nodes"), joined("values"), joined("rows"), joined("away"), joined("ends"),
        joined("end_rows"), joined("counts"), np.concatenate(hits),
    )  # fmt: skip


def _record_shots(
    layout: Layout,
    system: System,
    start: Start | None,
    moved: MovedLaw | None,
    nodes: Floats,
    effort: Effort,
) -> Shots:
    law, n, n_stops = system.law, len(layout), len(system.oscillator.stops)
    n_p = 0 if moved is None else len(moved.paths)
    # Two more columns, which move nothing of the law: those of the node's state.
    rows = np.zeros((n_p + 2, len(law) if moved is None else moved.change.rows.shape[1], COLUMNS))
    moved_stops = np.zeros((n_p + 2, n_stops, 3))
    begins = np.zeros((n, n_p + 2, 3))
    spans = layout.spans.copy()
    unit = law
    begins[:, n_p, carried.BEGIN_X] = 1.0
    begins[:, n_p + 1, carried.BEGIN_V] = 1.0
    if moved is not None:
        rows[:n_p], moved_stops[:n_p], unit = moved.change.rows, moved.stops, moved.change.unit
    if layout.is_fixed:
        assert start is not None
        begins[0] = 0.0
        if moved is not None:
            begins[0, :n_p] = moved.begin
        nodes[0] = as_float(start.x0), as_float(start.v0)
        spans[0, 0] = as_float(start.t0)
    samples = layout.record.samples
    segments = Segments(
        spans, nodes, begins, layout.first, samples.t, samples.quantities,
        samples.reach, stop_rows(system.oscillator), moved_stops,
    )  # fmt: skip
    results = new_results(len(samples.t), n, 2, n_p + 2)
    space, change = _space(law, n_p + 2), Change(rows, unit)
    progress = np.zeros(PROGRESS_ENTRIES, dtype=np.int64)
    while True:
        before = int(progress[N_SEARCHES])
        is_done = follow_segments(law, change, segments, space, results, progress)
        if not effort.spend(int(progress[N_SEARCHES]) - before) or is_done:
            break
    return Shots(nodes, **results._replace(hits=results.hits[: progress[N_HITS]])._asdict())


def _space(law: Floats, n_columns: int) -> SegmentSpace:
    return SegmentSpace(
        new_run(law, MOST_EVENTS),
        np.empty((MOST_EVENTS, n_columns, carried.SENSITIVITY_COLUMNS)),
        workspace_of(law, n_columns),
        np.zeros((n_columns, 3)),
        np.zeros(1),
        np.zeros((2, 1)),
        np.zeros((2, 1, n_columns)),
        np.zeros(0),
        np.zeros((0, n_columns)),
    )


def start_at(osc: Oscillator | Structure, node: Floats) -> Start | StructureStart:
    """Return a node, (1 + d,) with its instant first, as a start."""
    t0, *state = node.tolist()
    half = len(state) // 2
    if isinstance(osc, Structure):
        return StructureStart(tuple(state[:half]), tuple(state[half:]), t0)
    return Start(state[0], state[1], t0)


def motion_between(
    osc: Oscillator | Structure,
    force: Forcing | Loads | None,
    nodes: Floats,
    end: float,
    t: Floats,
    quantities: Sequence[int],
) -> Floats:
    """Return quantities of a motion at times, each from the node before it.

    Parameters
    ----------
    osc, force
        The model and the force on it.
    nodes
        (n, 1 + d) array, instant, displacements and velocities of each.
    end
        When the motion ends.
    t
        (n_times,) array of times.
    quantities
        Numbers of the quantities.

    Returns
    -------
    array
        (n_times, n_quantities).

    Raises
    ------
    ParameterError
        If a time lies outside.
    """
    order = np.argsort(t, kind="stable")
    times = times_within(t, float(nodes[0, 0]), end)[order]
    n = len(quantities)
    repeated = np.repeat(times, n)
    ones = np.ones(len(repeated))
    samples = MeasuredSamples(
        repeated, ones, np.tile(np.array(quantities, dtype=np.int64), len(times)), ones, ones > 0.0
    )
    first = np.searchsorted(repeated, nodes[:, 0], side="left")
    first[0] = 0
    spans = np.stack([nodes[:, 0], np.append(nodes[1:, 0], end)], axis=1)
    record = MeasuredRecord(samples, samples.taken(slice(0, 0)), force, None)
    layout = Layout(record, spans, np.append(first, len(repeated)), False)
    values = shoot(osc, (layout,), {}, nodes[:, 1:].copy()).values[:, 0]
    moved = np.empty((len(times), n))
    moved[order] = values.reshape(-1, n)
    return moved
