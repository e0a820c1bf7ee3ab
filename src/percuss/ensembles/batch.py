"""Many motions at once through the compiled batch kernel, and their exponents."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.decisions import (
    BLOCKS,
    EXPONENT_COLUMNS,
    drift_of_points,
    many_exponents,
)
from percuss.ensembles.threads import check_wanted, stop_flag
from percuss.kernels import batch, lockstep, members, observables
from percuss.kernels import record as columns
from percuss.kernels.law_columns import MASS, N_HARMONICS, PERIOD_TURNS, STOP_COLUMNS
from percuss.kernels.linear_observables import Scratch
from percuss.kernels.observables import LoadSpace
from percuss.motion.accelerations import phases_at
from percuss.motion.reach import free_until
from percuss.wording import counted

# Impacts after which a motion is abandoned: a few hundred periods have hundreds, but elastic hops
# on a wall, or a fast motion between two walls, have any number.
MOST_IMPACTS = 1_000_000


@dataclass(frozen=True, slots=True)
class Plan:
    """The times of motions, and what is recorded of them.

    Attributes
    ----------
    since, every, until
        (n,) arrays [time]: observables and strobes begin at ``since``, strobes come every
        ``every``, the motion ends at ``until``.
    section
        `observables.NO_POINTS`, `observables.STROBES`, `observables.IMPACT_POINTS` or
        `observables.PASSAGES`.
    n_points
        Number of points kept, the last ones, >= 1.
    with_extremes
        Whether extremes of x are recorded.
    with_work
        Whether the work of the dashpots is recorded: it takes several times as long.
    with_loads
        Whether means over time are recorded: it takes several times as long.
    with_load_peaks
        Whether beside them peaks of forces and accelerations are.
    with_means
        Whether means and accelerations of a structure are recorded, from runs of their own.
    max_impacts
        Impacts from the start after which a motion ends, >= 1.
    edges
        (n, m + 1) array [time], rising: the greatest impact speeds in the intervals between them
        are recorded, also before ``since``; None records none.
    level, sign
        The displacement [length] whose passages are kept, and the sign of the velocity there, 0
        for either.
    of_stop
        The stop of a structure whose impacts are kept as points, -1 for all.
    n_tangents
        How many perturbations of a structure are carried along, where points are of them.
    timed
        (n,) array [time], longer than the motion: a point's first number is t / timed mod 1, of
        motions without a period; None: the cycle. Motions of one law have one.
    """

    since: Floats
    every: Floats
    until: Floats
    section: int = observables.NO_POINTS
    n_points: int = 1
    with_extremes: bool = False
    with_work: bool = False
    with_loads: bool = False
    with_load_peaks: bool = False
    with_means: bool = False
    max_impacts: int = MOST_IMPACTS
    edges: Floats | None = None
    level: float = 0.0
    sign: float = 0.0
    of_stop: int = -1
    n_tangents: int = 1
    timed: Floats | None = None

    def empty_values(self) -> Floats:
        """Return zeros for the values of each motion: the observables; of intervals, edges and peaks."""
        n, edges = len(self.since), self.edges
        shown = np.zeros((n, observables.N_OBSERVABLES))
        if edges is None:
            return shown
        return np.hstack([shown, np.zeros((n, 1)), edges, np.zeros((n, edges.shape[1] - 1))])

    def peaks_of(self, values: Floats) -> Floats:
        """Return the greatest impact speed of each motion in each interval, from its values."""
        n_edges = 0 if self.edges is None else self.edges.shape[1]
        return values[:, observables.EDGES + n_edges :]


@dataclass(frozen=True, slots=True)
class BatchResult:
    """The results of many motions.

    Attributes
    ----------
    status
        (n,) array, why each motion ended: the codes of `percuss.kernels.record`.
    state
        (n, entries) array: t, x, v, ... of the last event.
    n_impacts
        (n,) array, impacts and entries into soft stops from the start on.
    values
        (n, `observables.N_OBSERVABLES`) array.
    points
        (n, n_points, `observables.POINT_COLUMNS`) array, in order of time; NaN where there are
        fewer.
    peaks
        (n, m) array, the greatest impact speed in each interval of the plan; 0 without any.
    masses
        (n,) array, the mass of each oscillator, 1 without one.
    strobes
        (n, n_points, 2 d) array, displacements and velocities of points that are strobes.
    ends
        (n, 2 d) array, displacements and velocities at the end, NaN before it.
    logs
        (n, n_points, c) array, of points that are of perturbations of a structure the logarithms
        of the growth of each, orthogonal to those before it.
    """

    status: Integers
    state: Floats
    n_impacts: Integers
    values: Floats
    points: Floats
    peaks: Floats = field(default_factory=lambda: np.empty((0, 0)))
    masses: Floats = field(default_factory=lambda: np.ones(1))
    strobes: Floats = field(default_factory=lambda: np.empty((0, 0, 2)))
    ends: Floats = field(default_factory=lambda: np.empty((0, 2)))
    logs: Floats = field(default_factory=lambda: np.empty((0, 0, 0)))


# Searches of a motion in the batch before it is treated alone, and how often that is repeated.
PATIENCE = 20_000
MOST_SEARCHES = 50
# Results whose points are put in order at a time.
AT_ONCE = 256
# A status beside those of the kernels: the modes of a structure under the stops that act.
NO_MODES = -3


def follow_batch(
    laws: Floats,
    which: Integers,
    starts: Floats,
    plan: Plan,
    stops: Floats | None = None,
) -> BatchResult:
    """Follow each motion to the end of its plan.

    The bits of a motion do not depend on the others.

    Parameters
    ----------
    laws
        (n_laws, rows, columns) array: tables of `percuss.model.system.law`, stacked.
    which
        (n,) array, the number of each motion's law.
    starts
        (n, 3) array of x0 [length], v0 [length/time] and t0 [time].
    plan
        When, and what is recorded.
    stops
        (n_laws, n_stops, columns) array: tables of `percuss.model.system.stop_rows`, stacked;
        needed for loads.
    """
    n = len(which)
    stops = np.zeros((len(laws), 0, STOP_COLUMNS)) if stops is None else stops
    states = np.zeros((n, columns.STATE_ENTRIES))
    states[:, [columns.X, columns.V, columns.T]] = starts
    counters = np.zeros((n, columns.COUNTERS), dtype=np.int64)
    status = np.full(n, batch.NEW, dtype=np.int64)
    values = plan.empty_values()
    points = np.full((n, plan.n_points, observables.POINT_COLUMNS), np.nan)
    level, sign = np.full(n, plan.level), np.full(n, plan.sign)
    plans = np.stack([plan.since, plan.every, plan.until, level, sign], axis=1)
    laws, which = np.ascontiguousarray(laws), np.ascontiguousarray(which, dtype=np.int64)
    if plan.timed is not None:
        laws = laws.copy()
        laws[which, 0, PERIOD_TURNS] = 1.0 / plan.timed

    options = members.Options(
        plan.max_impacts,
        plan.section,
        plan.with_extremes,
        plan.with_work,
        plan.with_loads,
        plan.with_load_peaks,
        PATIENCE,
    )

    def march(rows: slice) -> None:
        motions = batch.Batch(
            laws,
            which[rows],
            states[rows],
            counters[rows],
            status[rows],
            plans[rows],
            values[rows],
            points[rows],
            stops,
        )
        blocks = batch.Blocks(
            np.zeros((batch.BLOCKS, lockstep.ROWS * lockstep.SLOTS)),
            np.zeros(batch.BLOCKS * lockstep.SLOTS, dtype=np.int64),
        )
        batch.run_batch(motions, _workspace(laws), options, blocks, stop_flag())
        check_wanted()

    march(slice(None))
    for i in np.flatnonzero(status == columns.SPENT):
        law = laws[which[i]]
        for _ in range(MOST_SEARCHES):
            _search_far(law, states[i], counters[i], float(plan.until[i]))
            march(slice(i, i + 1))
            if status[i] != columns.SPENT:
                break
    put_in_order(points, values)
    n_impacts, masses = counters[:, columns.N_IMPACTS].copy(), laws[which, 0, MASS]
    ends = values[:, [observables.END_X, observables.END_V]]
    strobes = points[:, :, :2]
    return BatchResult(
        status, states, n_impacts, values, points, plan.peaks_of(values), masses, strobes, ends
    )


def _workspace(laws: Floats) -> batch.Workspace:
    """Return the buffers that the motions of one call share."""
    n = int(laws[0, 0, N_HARMONICS])
    scratch = Scratch(*np.zeros((5, n, 2)))
    return batch.Workspace(
        np.empty((batch.BUFFER, columns.EVENT_COLUMNS)),
        np.empty((batch.BUFFER, columns.MARK_COLUMNS), dtype=np.int64),
        np.empty((batch.GRAZES, columns.GRAZE_COLUMNS)),
        np.zeros((3, n, 2)),
        LoadSpace(np.empty_like(laws[0]), np.empty(4), scratch),
    )


def _search_far(law: Floats, state: Floats, counters: Integers, until: float) -> None:
    """Extend the search of a flight that is too long for small steps, as `simulate` does."""
    searched = float(min(state[columns.FREE_BELOW], state[columns.FREE_ABOVE]))
    if counters[columns.TOUCHED] != 0 or searched == 0.0:
        return
    t, t_low, v, force = (
        float(state[entry]) for entry in (columns.T, columns.T_LOW, columns.V, columns.FORCE)
    )
    phases = phases_at(law, t, t_low)
    longest = until - t
    region = int(counters[columns.REGION])
    free = free_until(
        law, region, float(state[columns.X]), (t, t_low, v, force), phases, searched, longest
    )
    for side in (columns.FREE_BELOW, columns.FREE_ABOVE):
        state[side] = max(state[side], min(free, longest))


def put_in_order(points: Floats, values: Floats) -> None:
    """Rotate the ring buffers of points, so that the oldest point comes first.

    Parameters
    ----------
    points
        (n, m, columns) array, changed.
    values
        (n, entries) array, the observables of the same motions.
    """
    m = points.shape[1]
    written = values[:, observables.POINTS].astype(np.int64)
    turned = np.flatnonzero((written > m) & (written % m > 0))
    # In parts: a copy of all points would be large.
    for rows in np.split(turned, range(AT_ONCE, len(turned), AT_ONCE)):
        order = (written[rows, np.newaxis] + np.arange(m)) % m
        points[rows] = points[rows[:, np.newaxis], order]


def reason_of(status: int, plan: Plan) -> str | None:
    """Return in a sentence why a motion has no answer, None where it came to its end.

    Examples
    --------
    >>> plan = Plan(np.zeros(1), np.ones(1), np.ones(1), max_impacts=10)
    >>> reason_of(columns.REACHED_LIMIT, plan)
    'more than 10 impacts before the end'
    """
    if status == columns.OVERFLOW:
        return "the motion grew beyond 1e150"
    if status == columns.REACHED_LIMIT and plan.until.size and plan.until.min() < math.inf:
        return f"more than {counted(plan.max_impacts, 'impact')} before the end"
    if status == NO_MODES:
        return "the stops that act hold it twice, or leave modes that cannot be told apart"
    if status in (columns.SPENT, columns.NO_MORE, batch.NEW):
        return f"not at its end after {PATIENCE * (1 + MOST_SEARCHES)} searches"
    return None


def tangent_plan(period: Floats, t0: Floats, transient: int, periods: int) -> Plan:
    """Return the plan of motions whose exponents are wanted.

    Parameters
    ----------
    period, t0
        (n,) arrays [time]: the period in which time is counted, and the starts.
    transient, periods
        Periods that are left out, and that are measured.
    """
    since = t0 + transient * period
    every = periods / BLOCKS * period
    return Plan(
        since,
        every,
        since + BLOCKS * every,
        section=observables.TANGENTS,
        n_points=BLOCKS + 1,
    )


def exponents_of(result: BatchResult, plan: Plan) -> tuple[Floats, Floats, Floats, Floats]:
    """Return largest and smallest exponent, the standard error of either, and their sum.

    Parameters
    ----------
    result, plan
        The results of motions under a `tangent_plan`, and that plan.

    Returns
    -------
    tuple of (n,) arrays
        In 1/time; -inf where there was a contact, with an error of 0, and the smallest and the sum
        where an impact had no restitution.
    """
    out = np.empty((len(result.points), EXPONENT_COLUMNS))
    points, durations = np.ascontiguousarray(result.points), plan.until - plan.since
    many_exponents(points, durations, plan.every, np.empty(BLOCKS), out)
    largest, smallest, error, total = out.T
    # An impact without restitution takes one direction, and with it the whole area.
    flat = np.isneginf(points[:, -1, observables.SECOND])
    smallest[flat] = total[flat] = -np.inf
    return largest, smallest, error, total


def drift_of(result: BatchResult, plan: Plan) -> Floats:
    """Return the difference of the largest exponents of both halves [1/time], 0 within chance.

    As `drift_of_points` tells it of one motion.
    """
    points, rates = np.ascontiguousarray(result.points), np.empty(BLOCKS)
    motions = zip(points, plan.every.tolist(), strict=True)
    return np.array([drift_of_points(own, every, rates) for own, every in motions])
