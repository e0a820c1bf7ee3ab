"""Many motions of structures at once through the compiled kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.batch import MOST_SEARCHES, NO_MODES, BatchResult, Plan, put_in_order
from percuss.ensembles.structure_runs import needs_runs, observe_runs
from percuss.ensembles.threads import check_wanted, stop_flag
from percuss.errors import ConvergenceError
from percuss.kernels import observables
from percuss.kernels import record as columns
from percuss.kernels.structure import basis as at
from percuss.kernels.structure import batch
from percuss.kernels.structure import run as state
from percuss.kernels.structure.basis import Sets
from percuss.kernels.structure.perturbations import TangentSpace
from percuss.kernels.structure.run import new_run
from percuss.kernels.structure.views import Views
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.oscillator import SoftStop
from percuss.numerics import matmul

# Rows of the buffers of events, at first, and of grazes, which are only counted; and searches of a
# motion before control returns.
BUFFER, GRAZES, PATIENCE = 128, 4, 20_000


def follow_structures(
    systems: Sequence[StructureSystem], which: Integers, starts: Floats, plan: Plan, on: Floats
) -> BatchResult:
    """Follow each motion to the end of its plan, as `follow_batch` does.

    Parameters
    ----------
    systems
        Structures of equal numbers of coordinates, under their loads.
    which
        (n_motions,) array, the number of each motion's system.
    starts
        (n_motions, 2 n + 1) array of x [length], v [length/time] and t [time].
    plan
        The window of each motion, and the observables that are recorded.
    on
        (n,) direction c of the displacement y = c . x that is observed.
    """
    k, n = len(which), systems[0].structure.n
    n_stops = len(systems[0].structure.stops)
    c = plan.n_tangents if plan.section == observables.TANGENTS else 0
    width = max(2 * n, batch.IMPACT_COLUMNS, c + 1)
    every = np.stack([plan.since, plan.every, plan.until, *np.zeros((2, k))], axis=1)
    members = batch.StructureMembers(
        starts=np.ascontiguousarray(starts),
        keys=np.zeros(k, dtype=np.int64),
        plans=every,
        status=np.full(k, batch.NEW, dtype=np.int64),
        state=np.zeros((k, state.STATE_ENTRIES)),
        counters=np.zeros((k, state.COUNTERS), dtype=np.int64),
        begin=np.zeros((k, n, 2)),
        order=np.zeros((k, n_stops)),
        free=np.zeros((k, n_stops)),
        clearances=np.zeros((k, n_stops)),
        values=plan.empty_values(),
        points=np.full((k, plan.n_points, width), np.nan),
        ends=np.full((k, 2 * n), np.nan),
        tangents=np.broadcast_to(_directions(n, c), (k, 2, n, c)).copy(),
        logs=np.zeros((k, c)),
    )
    is_seen = plan.with_extremes or plan.with_loads
    options = batch.StructureOptions(
        plan.max_impacts, plan.section, plan.of_stop, is_seen, PATIENCE
    )
    order = np.argsort(which, kind="stable")
    is_in_order = bool((which[1:] >= which[:-1]).all())
    cuts = np.flatnonzero(np.diff(which[order])) + 1
    for first, last in zip([0, *cuts.tolist()], [*cuts.tolist(), k], strict=True) if k else ():
        # Motions that stand side by side are followed where they are.
        rows = slice(first, last) if is_in_order else order[first:last]
        own = batch.StructureMembers(*(cast("Any", array[rows]) for array in members))
        _follow(systems[int(which[order[first]])], own, options, on)
        if not is_in_order:
            for whole, part in zip(members, own, strict=True):
                whole[rows] = part
    put_in_order(members.points, members.values)
    points = _points(members.points, systems, which, plan, on, c)
    result = BatchResult(
        members.status,
        members.state,
        members.counters[:, columns.N_IMPACTS].copy(),
        members.values,
        points,
        plan.peaks_of(members.values),
        np.ones(k),
        members.points[:, :, : 2 * n],
        members.ends,
        members.points[:, :, :c],
    )
    if needs_runs(plan):
        observe_runs(result, systems, which, starts, plan, on)
    return result


def _follow(
    system: StructureSystem,
    members: batch.StructureMembers,
    options: batch.StructureOptions,
    on: Floats,
) -> None:
    """Follow the motions of one system, making sets of acting stops as they are met."""
    n = system.structure.n
    members.keys[:] = system.keys_at(members.starts[:, :n], members.starts[:, n : 2 * n])
    wanted = set(members.keys.tolist())
    searches = 0
    rows = BUFFER
    while True:
        for key in sorted(wanted):
            try:
                system.add(key)
            except ConvergenceError:
                waits = members.status == state.NEW_SET
                lost = np.where(waits, members.counters[:, state.WANTED], members.keys) == key
                members.status[lost & (waits | (members.status == batch.NEW))] = NO_MODES
        if (members.status == NO_MODES).all():
            return
        run = new_run(system.sets, rows, GRAZES)
        # Views have arrays of their own, and more rows than there are clearances.
        viewer = new_run(system.sets, 0, 0)._replace(
            events=run.events, marks=run.marks, states=run.states,
            values=np.zeros(len(run.values) + 1), order=np.zeros(len(run.values) + 1),
            scratch=np.zeros((8, run.scratch.shape[1] + 1, run.scratch.shape[2])),
        )  # fmt: skip
        c = members.logs.shape[1]
        space = TangentSpace(
            np.empty((2, n, c)), np.empty((n, 2, c)), np.empty((2, 2, n)), np.empty(c)
        )
        views = views_of(system, on)
        batch.follow_members(members, run, viewer, views, space, options, stop_flag())
        check_wanted()
        waits = members.status == state.NEW_SET
        wanted = set(members.counters[waits, state.WANTED].tolist())
        spent = members.status == columns.SPENT
        searches += int(spent.any())
        # The events of one instant did not fit.
        is_short = bool((members.status == columns.FULL).any())
        rows = 2 * rows if is_short else rows
        if not (wanted or is_short or spent.any()) or searches > MOST_SEARCHES:
            return


def _directions(n: int, c: int) -> Floats:
    """Return c orthonormal directions (2, n, c): those of one displacement for n = 1."""
    columns = np.zeros((2 * n, c))
    for i in range(min(c, 2 * n)):
        # Mirrored at a plane across which no axis lies.
        normal = np.full(2 * n, -3.0)
        normal[0] = 1.0
        axis = np.zeros(2 * n)
        axis[i] = 1.0
        columns[:, i] = axis - 2.0 * normal[i] / float((normal * normal).sum()) * normal
    return columns.reshape(2, n, c)


def views_of(system: StructureSystem, on: Floats) -> Views:
    """Return what is seen of the motions of a system beside its clearances, in all its sets.

    Parameters
    ----------
    system
        The system.
    on
        (n,) direction c of y = c . x, the first view.
    """
    sets = system.sets
    b, n_stops, n = sets.guard.shape[:3]
    shape = (b, n_stops + 1)
    views = Views(
        np.zeros((*shape, n, at.GUARD_ENTRIES)),
        np.zeros((*shape, at.LEVEL_COLUMNS)),
        np.zeros((*shape, *sets.feed.shape[2:])),
        np.zeros((*shape, sets.record_feed.shape[2])),
    )
    views.guard[:, 0, :, :2] = (sets.shape * on).sum(axis=-1)
    views.levels[:, 0, at.CONSTANT] = matmul(sets.offset, on)
    views.levels[:, 0, at.IS_ON] = 1.0
    views.guard[:, 1:, :, :2] = sets.guard[:, :, :, :2]
    views.levels[:, 1:] = sets.levels
    views.feed[:, 1:] = sets.feed
    views.record_feed[:, 1:] = sets.record_feed
    for i, stop in enumerate(system.structure.stops):
        views.levels[:, 1 + i, at.IS_ON] = sets.keys >> i & 1
        if isinstance(stop, SoftStop):
            _set_force(views, sets, i, as_float(stop.stiffness), as_float(stop.damping))
    return views


def _set_force(views: Views, sets: Sets, i: int, spring: float, dashpot: float) -> None:
    """Turn the view of a depth into that of the soft stop's force."""
    of_u, of_w = sets.guard[:, i, :, at.OF_U], sets.guard[:, i, :, at.OF_W]
    slow, fast = -sets.modes[:, :, at.SPRING] * of_w, of_u - sets.modes[:, :, at.DRAG] * of_w
    views.guard[:, 1 + i, :, at.OF_U] = spring * of_u + dashpot * slow
    views.guard[:, 1 + i, :, at.OF_W] = spring * of_w + dashpot * fast
    views.levels[:, 1 + i, at.CONSTANT] *= spring


def _points(
    points: Floats,
    systems: Sequence[StructureSystem],
    which: Integers,
    plan: Plan,
    on: Floats,
    c: int,
) -> Floats:
    """Return points as those of one displacement, (y, y', -1) or (cycle, v after, stop).

    Of c perturbations they have the logarithms of the first, and of the volume.
    """
    n = len(on)
    out = np.full((*points.shape[:2], observables.POINT_COLUMNS), np.nan)
    if plan.section == observables.STROBES:
        out[:, :, 0] = (points[:, :, :n] * on).sum(axis=-1)
        out[:, :, 1] = (points[:, :, n : 2 * n] * on).sum(axis=-1)
        out[:, :, 2] = np.where(np.isnan(out[:, :, 0]), np.nan, -1.0)
    if plan.section == observables.TANGENTS:
        out[:, :, observables.FIRST] = points[:, :, 0]
        out[:, :, observables.SECOND] = points[:, :, c]
    if plan.section == observables.IMPACT_POINTS:
        signs = np.stack([system.signs for system in systems])
        stops = np.nan_to_num(points[:, :, 2]).astype(np.int64)
        every = plan.every if plan.timed is None else plan.timed
        out[:, :, 0] = points[:, :, 0] / every[:, np.newaxis] % 1.0
        out[:, :, 1] = points[:, :, 1] * np.take_along_axis(signs[which], stops, axis=1)
        out[:, :, 2] = points[:, :, 2]
    return out
