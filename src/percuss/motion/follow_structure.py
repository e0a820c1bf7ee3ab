"""The motion of a structure, followed from event to event."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import cast

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels.structure import march as engine
from percuss.kernels.structure import run as state
from percuss.kernels.structure.run import StructureRun, new_run
from percuss.kernels.structure.sample import evaluate
from percuss.model.acting_sets import StructureSystem, within_walls
from percuss.model.exact import Exact, Phase, as_float, plain
from percuss.model.expression import parameters_in
from percuss.model.faults import raise_first
from percuss.model.parameter_fields import is_tied
from percuss.model.start import end_after_periods, limit_faults, periods_faults
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.model.system import check_phases
from percuss.motion.instants import last_moderate
from percuss.motion.structures import StructureTrajectory, as_far_as_filled
from percuss.motion.trajectory import Outcome
from percuss.progress import RunProgress

# Rows for events at first, and searches between two checks for Ctrl-C.
FIRST_CAPACITY = 4096
PATIENCE = 10_000
_OUTCOMES = {
    columns.REACHED_END: Outcome.reached_t_end,
    columns.REACHED_LIMIT: Outcome.reached_max_impacts,
    columns.OVERFLOW: Outcome.overflow,
}


def follow_structure(
    structure: Structure,
    loads: object,
    start: StructureStart,
    t_end: Phase | None,
    periods: Exact | None,
    max_impacts: int | None,
    most_impacts: int,
    progress: bool | Callable[[float, float], bool] | None,
) -> StructureTrajectory:
    """Follow one motion of a structure; the arguments are those of `simulate`."""
    system = StructureSystem.of(structure, loads)
    begin = as_float(start.t0)
    if periods is not None:
        raise_first(periods_faults(system.loads, periods, t_end))
        t_end = end_after_periods(system.loads, start.t0, periods)
    if t_end is None:
        reason = "needed for a structure, whose motion may meet no stop for ever"
        raise ParameterError("t_end", None, reason)
    raise_first(limit_faults(start.t0, t_end, max_impacts, periods))
    limit = most_impacts if max_impacts is None else min(int(max_impacts), 2**62)
    if is_tied(t_end) or is_tied(periods):
        parameters_in(structure, system.loads, start, t_end, periods)  # one name has one value
    end = as_float(t_end)
    check_phases(system.sets.law[0], begin, end)
    progress_of_run = RunProgress(progress, begin, end, limit)
    run, outcome = followed(system, (start.x, start.v, begin), end, limit, progress_of_run)
    lasts = None if periods is None else cast("Exact", plain(periods))
    given = cast("Phase", plain(t_end))
    return StructureTrajectory.of_run(system, start, run, given, outcome, lasts)


def followed(
    system: StructureSystem,
    start: tuple[Floats, Floats, float],
    end: float,
    limit: int,
    progress: RunProgress | None = None,
) -> tuple[StructureRun, Outcome]:
    """March from (x, v, t) to the limits, making sets of acting stops as they are met.

    What rounding has put behind a wall begins at it: from behind, another motion would follow.
    With progress Ctrl-C ends the run there, and what it holds is kept.
    """
    x, v, t = start
    x = within_walls(system.structure, np.concatenate([x, v]))[: len(x)]
    (number,) = system.numbers_of([system.key_at(x, v)])
    run = new_run(system.sets, min(limit + 8, FIRST_CAPACITY))
    run.counters[state.SET] = number
    run.state[columns.T] = t
    state.decompose(system.sets, number, np.stack([x, v], axis=1), run.begin)
    try:
        while True:
            status = engine.march(run, end, limit, PATIENCE)
            if status in _OUTCOMES:
                return _as_far_as_moderate(as_far_as_filled(run), _OUTCOMES[status], end)
            if status == state.NEW_SET:
                system.add(int(run.counters[state.WANTED]))
                run = run._replace(sets=system.sets)
            elif status == columns.FULL:
                run = _longer(run)
            if progress is None:
                continue
            searched = float(run.free.min(initial=math.inf))
            here = float(run.state[columns.T]) + (searched if searched < math.inf else 0.0)
            if not progress.reach_event(here, int(run.counters[columns.N_IMPACTS])):
                return as_far_as_filled(run), Outcome.interrupted
    except KeyboardInterrupt:
        # In the first compilation nothing is known yet, and of an orbit a part is of no use.
        if progress is None or run.counters[columns.N_EVENTS] == 0:
            raise
        return as_far_as_filled(run), Outcome.interrupted
    finally:
        if progress is not None:
            progress.close()


def _as_far_as_moderate(
    run: StructureRun, outcome: Outcome, end: float
) -> tuple[StructureRun, Outcome]:
    """Return a run that ends where its last flight grows beyond HUGE, and its outcome."""
    place = np.empty((1, len(run.begin), 2))

    def is_below(limit: float, t: float) -> bool:
        evaluate(run, np.array([t]), True, place)
        return bool((np.abs(place) < limit).all())

    if outcome is Outcome.reached_t_end:
        last = last_moderate(is_below, float(run.state[columns.T]), end)
        if last < end:
            run.state[columns.T] = last
            return run, Outcome.overflow
    return run, outcome


def _longer(run: StructureRun) -> StructureRun:
    """Return a run with room for as many events and grazes again."""
    return run._replace(
        events=np.concatenate([run.events, np.empty_like(run.events)]),
        marks=np.concatenate([run.marks, np.empty_like(run.marks)]),
        states=np.concatenate([run.states, np.empty_like(run.states)]),
        grazes=np.concatenate([run.grazes, np.empty_like(run.grazes)]),
    )
