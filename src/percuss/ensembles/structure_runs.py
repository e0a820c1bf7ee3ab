"""Observables that the batch of structures leaves out, from single runs of its motions."""

from __future__ import annotations

from collections.abc import Sequence

from percuss.arrays import Floats, Integers
from percuss.ensembles.batch import BatchResult, Plan, reason_of
from percuss.kernels import observables
from percuss.kernels.structure.run import StructureRun
from percuss.model.acting_sets import StructureSystem
from percuss.motion.extremes import jumps_in, window_at_jumps
from percuss.motion.follow_structure import followed
from percuss.motion.structure_means import mean_power_of_run, mean_square_of_run
from percuss.motion.structure_observables import extremes_of_run, passages_of_run


def needs_runs(plan: Plan) -> bool:
    """Return whether a plan asks for observables that the batch leaves out."""
    return plan.with_means or plan.section == observables.PASSAGES


def observe_runs(
    result: BatchResult,
    systems: Sequence[StructureSystem],
    which: Integers,
    starts: Floats,
    plan: Plan,
    on: Floats,
) -> None:
    """Write passages, means and accelerations of motions that came to their ends into a result.

    The arguments are those of `follow_structures`. The record of a run is the same, whichever way
    it is followed.
    """
    n = len(on)
    for i in range(len(which)):
        if reason_of(int(result.status[i]), plan) is not None:
            continue
        system, start = systems[int(which[i])], starts[i]
        begin = start[:n].copy(), start[n : 2 * n].copy(), float(start[2 * n])
        span = float(plan.since[i]), float(plan.until[i])
        run, _ = followed(system, begin, span[1], plan.max_impacts)
        if plan.with_means:
            _note_means(result.values[i], system, run, span, on)
        if plan.section == observables.PASSAGES:
            _note_passages(result, i, system, run, span, plan, on)


def _note_means(
    values: Floats,
    system: StructureSystem,
    run: StructureRun,
    span: tuple[float, float],
    on: Floats,
) -> None:
    duration = span[1] - span[0]
    values[observables.WORK] = duration * mean_power_of_run(system, run, span)
    if on.any():
        c = tuple(on.tolist())
        values[observables.SQUARE] = duration * mean_square_of_run(system, run, span, c)
        window = window_at_jumps(jumps_in(run.events, run.marks), span, span[1])
        extremes = extremes_of_run(system, run, window, "acceleration", 0, c)
        values[observables.PEAK_ACCELERATION] = max(abs(extremes.minimum), abs(extremes.maximum))


def _note_passages(
    result: BatchResult,
    i: int,
    system: StructureSystem,
    run: StructureRun,
    span: tuple[float, float],
    plan: Plan,
    on: Floats,
) -> None:
    """Write the last passages of a level, (cycle, y', -1)."""
    passages = passages_of_run(system, run, span[1], plan.level, tuple(on.tolist()))
    kept = (passages[:, 0] >= span[0]) & (plan.sign * passages[:, 1] >= 0.0)
    result.values[i, observables.POINTS] = kept.sum()
    t, v = passages[kept][-plan.n_points :].T
    every = plan.every if plan.timed is None else plan.timed
    points = result.points[i, : len(t)]
    points[:, observables.FIRST] = t / every[i] % 1.0
    points[:, observables.SECOND] = v
    points[:, observables.THIRD] = -1.0
