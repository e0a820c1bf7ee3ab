"""Many motions at once through the compiled batch kernel, and what has become of each."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.threads import check_wanted, stop_flag
from percuss.kernels import batch, lockstep, survey
from percuss.kernels import record as columns
from percuss.kernels.flight import set_phases
from percuss.kernels.law import N_HARMONICS
from percuss.motion.reach import free_until

__all__ = [
    "BLOCKS",
    "MOST_IMPACTS",
    "BatchResult",
    "Plan",
    "drift_of",
    "exponents_of",
    "follow_batch",
    "reason_of",
    "tangent_plan",
]


# Searches of a motion before it is looked at one by one, and how often it is then.
PATIENCE = 20_000
MOST_LOOKS = 50
# BatchResult whose points are put in order at a time.
AT_ONCE = 256
# Impacts of a motion: one of a few hundred periods has hundreds. Elastic hops on a wall, or a
# fast motion against two walls, can be any number.
MOST_IMPACTS = 1_000_000


@dataclass(frozen=True, slots=True)
class Plan:
    """What is kept of each motion, and from when to when.

    Attributes
    ----------
    since, every, until
        (n,) arrays [time]: tallies and strobes begin at ``since``, strobes come every ``every``,
        the motion ends at ``until``.
    section
        `survey.NO_POINTS`, `survey.STROBES` or `survey.IMPACT_POINTS`.
    n_points
        The last so many points are kept, >= 1.
    surveyed
        Whether extremes of x and the work of the dashpots are wanted: it takes twice as long.
    max_impacts
        Impacts from the start after which a motion ends, >= 1.
    edges
        (n, m + 1) array [time], rising: of the stretches between them the greatest impact speeds
        are kept, also before ``since``; None keeps none.
    """

    since: Floats
    every: Floats
    until: Floats
    section: int = survey.NO_POINTS
    n_points: int = 1
    surveyed: bool = False
    max_impacts: int = MOST_IMPACTS
    edges: Floats | None = None


@dataclass(frozen=True, slots=True)
class BatchResult:
    """What is left of many motions.

    Attributes
    ----------
    status
        (n,) array, why each ended: the codes of `percuss.kernels.record`.
    state
        (n, entries) array: the last event's t, x, v, ...
    n_impacts
        (n,) array, impacts and entries into soft stops from the start on.
    tallies
        (n, `survey.TALLIES`) array.
    points
        (n, n_points, `survey.POINT_COLUMNS`) array, in order of time; NaN where there are fewer.
    peaks
        (n, m) array, the greatest impact speed in each stretch of the plan; 0 without any.
    """

    status: Integers
    state: Floats
    n_impacts: Integers
    tallies: Floats
    points: Floats
    peaks: Floats = field(default_factory=lambda: np.empty((0, 0)))


def follow_batch(laws: Floats, which: Integers, starts: Floats, plan: Plan) -> BatchResult:
    """Follow each motion to the end of its plan.

    The bits of a motion do not depend on which others are followed with it.

    Parameters
    ----------
    laws
        (n_laws, rows, columns) array: tables of `percuss.model.law.law`, stacked.
    which
        (n,) array, the number of each motion's law.
    starts
        (n, 3) array of x0 [length], v0 [length/time] and t0 [time].
    plan
        What to keep.

    Returns
    -------
    BatchResult
        What is left of each.
    """
    n = len(which)
    states = np.zeros((n, columns.STATE_ENTRIES))
    states[:, [columns.X, columns.V, columns.T]] = starts
    counters = np.zeros((n, columns.COUNTERS), dtype=np.int64)
    status = np.full(n, batch.NEW, dtype=np.int64)
    edges = np.empty((n, 0)) if plan.edges is None else plan.edges
    speeds = [np.zeros((n, 1)), edges, np.zeros((n, edges.shape[1] - 1))] if edges.size else []
    tallies = np.concatenate([np.zeros((n, survey.TALLIES)), *speeds], axis=1)
    points = np.full((n, plan.n_points, survey.POINT_COLUMNS), np.nan)
    plans = np.stack([plan.since, plan.every, plan.until], axis=1)
    laws, which = np.ascontiguousarray(laws), np.ascontiguousarray(which, dtype=np.int64)

    options = batch.Options(plan.max_impacts, plan.section, plan.surveyed, PATIENCE)

    def march(lanes: slice) -> None:
        those = batch.Batch(
            laws,
            which[lanes],
            states[lanes],
            counters[lanes],
            status[lanes],
            plans[lanes],
            tallies[lanes],
            points[lanes],
        )
        blocks = batch.Blocks(
            np.zeros((batch.BLOCKS, lockstep.ROWS * lockstep.SLOTS)),
            np.zeros(batch.BLOCKS * lockstep.SLOTS, dtype=np.int64),
        )
        batch.run_batch(those, _workspace(laws), options, blocks, stop_flag())
        check_wanted()

    march(slice(None))
    for i in np.flatnonzero(status == columns.SPENT):
        law = laws[which[i]]
        for _ in range(MOST_LOOKS):
            _look_far(law, states[i], counters[i], float(plan.until[i]))
            march(slice(i, i + 1))
            if status[i] != columns.SPENT:
                break
    _put_in_order(points, tallies)
    peaks = tallies[:, survey.EDGES + edges.shape[1] :]
    return BatchResult(
        status, states, counters[:, columns.N_IMPACTS].copy(), tallies, points, peaks
    )


def _workspace(laws: Floats) -> batch.Workspace:
    """Return the buffers that the lanes of one call share."""
    n = int(laws[0, 0, N_HARMONICS])
    return batch.Workspace(
        np.empty((batch.BUFFER, columns.EVENT_COLUMNS)),
        np.empty((batch.BUFFER, columns.MARK_COLUMNS), dtype=np.int64),
        np.empty((batch.GRAZES, columns.GRAZE_COLUMNS)),
        np.zeros((3, n, 2)),
    )


def _look_far(law: Floats, state: Floats, counters: Integers, until: float) -> None:
    """Move on the search of a flight that small steps do not get through, as `simulate` does."""
    searched = float(min(state[columns.FREE_BELOW], state[columns.FREE_ABOVE]))
    if counters[columns.TOUCHED] != 0 or searched == 0.0:
        return
    phases = np.zeros((int(law[0, N_HARMONICS]), 2))
    set_phases(law, state[columns.T], state[columns.T_LOW], phases)
    t, t_low, v, force = (
        float(state[entry]) for entry in (columns.T, columns.T_LOW, columns.V, columns.FORCE)
    )
    longest = until - t
    region = int(counters[columns.REGION])
    free = free_until(
        law, region, float(state[columns.X]), (t, t_low, v, force), phases, searched, longest
    )
    for side in (columns.FREE_BELOW, columns.FREE_ABOVE):
        state[side] = max(state[side], min(free, longest))


def _put_in_order(points: Floats, tallies: Floats) -> None:
    """Rotate ring buffers of points that have wrapped, so that the oldest comes first."""
    m = points.shape[1]
    written = tallies[:, survey.POINTS].astype(np.int64)
    turned = np.flatnonzero((written > m) & (written % m > 0))
    # A part at a time: with all points kept their copy would be large.
    for rows in np.split(turned, range(AT_ONCE, len(turned), AT_ONCE)):
        order = (written[rows, np.newaxis] + np.arange(m)) % m
        points[rows] = points[rows[:, np.newaxis], order]


def reason_of(status: int, plan: Plan) -> str | None:
    """Return why a motion has no answer, None where it came to its end.

    Parameters
    ----------
    status
        Its status.
    plan
        The plan it followed.

    Returns
    -------
    str or None
        A sentence.

    Examples
    --------
    >>> plan = Plan(np.zeros(1), np.ones(1), np.ones(1), max_impacts=10)
    >>> reason_of(columns.REACHED_LIMIT, plan)
    'more than 10 impacts before the end'
    """
    if status == columns.OVERFLOW:
        return "the motion grew beyond 1e150"
    if status == columns.REACHED_LIMIT and plan.until.size and plan.until.min() < math.inf:
        return f"more than {plan.max_impacts} impacts before the end"
    if status in (columns.SPENT, columns.NO_MORE, batch.NEW):
        return f"not at its end after {PATIENCE * (1 + MOST_LOOKS)} searches"
    return None


# Stretches of time whose means tell the error: long against the memory of a motion, and many
# enough to know their spread to a tenth.
BLOCKS = 64
# Halves that differ by more than so many standard errors of their difference do not by chance.
CHANCE = 3.0


def tangent_plan(period: Floats, t0: Floats, transient: int, periods: int) -> Plan:
    """Return the plan of motions whose exponents are wanted.

    Parameters
    ----------
    period, t0
        (n,) arrays [time]: what transient and periods are multiples of, and the starts.
    transient, periods
        What is left out, and what is measured.
    """
    since = t0 + transient * period
    every = periods / BLOCKS * period
    return Plan(
        since,
        every,
        since + BLOCKS * every,
        section=survey.TANGENTS,
        n_points=BLOCKS + 1,
    )


def exponents_of(result: BatchResult, plan: Plan) -> tuple[Floats, Floats, Floats, Floats]:
    """Return largest and smallest exponent, the standard error of either, and their sum.

    Parameters
    ----------
    result
        What is left of motions that followed a `tangent_plan`.
    plan
        That plan.

    Returns
    -------
    tuple of (n,) arrays
        In 1/time; -inf where there was a contact, with an error of 0.
    """
    logs = result.points[:, :, survey.FIRST]
    shrunk = result.points[:, :, survey.SECOND]
    with np.errstate(invalid="ignore"):
        rates = np.diff(logs, axis=1) / plan.every[:, np.newaxis]
        largest = (logs[:, -1] - logs[:, 0]) / (plan.until - plan.since)
        total = (shrunk[:, -1] - shrunk[:, 0]) / (plan.until - plan.since)
        error = rates.std(axis=1, ddof=1) / math.sqrt(BLOCKS)
    # Once all memory is lost the logarithm stays what it is.
    forgotten = np.isneginf(logs[:, -1])
    for values, there in ((largest, -np.inf), (total, -np.inf), (error, 0.0)):
        values[forgotten] = there
    smallest = np.where(forgotten, -np.inf, total - np.where(forgotten, 0.0, largest))
    return largest, smallest, error, total


def drift_of(result: BatchResult, plan: Plan) -> Floats:
    """Return by how much the largest exponent of the second half differs from that of the first.

    Means of blocks scatter little about a slow transient, so that their spread does not tell of
    it. Halves of equal worth differ by twice the standard error of the whole; 0 stands for what
    is within three times that.

    Parameters
    ----------
    result, plan
        As `exponents_of` takes them.

    Returns
    -------
    (n,) array
        In 1/time, >= 0.
    """
    logs = result.points[:, :, survey.FIRST]
    with np.errstate(invalid="ignore"):
        rates = np.diff(logs, axis=1) / plan.every[:, np.newaxis]
        error = rates.std(axis=1, ddof=1) / math.sqrt(BLOCKS)
        first, second = rates[:, : BLOCKS // 2], rates[:, BLOCKS // 2 :]
        drift = np.abs(second.mean(axis=1) - first.mean(axis=1))
        # After a contact there is nothing to drift.
        return np.where(drift > 2.0 * CHANCE * error, drift, 0.0)
