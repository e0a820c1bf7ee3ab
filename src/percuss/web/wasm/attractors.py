"""The points of one attractor on a section, as a diagram shows them.

`percuss.ensembles` follows many motions at once; a motion has the same bits alone.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import kernel
from percuss.kernels.law_columns import PERIOD, Law
from percuss.kernels.linear_observables import Scratch
from percuss.kernels.members import Options, begin_member, follow
from percuss.kernels.observables import (
    EVERY,
    LEVEL,
    POINTS,
    SINCE,
    UNTIL,
    WAY,
    LoadSpace,
    Member,
)
from percuss.kernels.record import Run, T, V, X

# What is asked: which kind of points (`observables`), forcing periods that are left out and that
# are followed, the cycle of strobes (below 0: that of the start), and the displacement whose
# passages are kept with the sign of the velocity there.
ASKED_SECTION, ASKED_TRANSIENT, ASKED_PERIODS, ASKED_CYCLE, ASKED_LEVEL, ASKED_WAY = range(6)
ASKED_ENTRIES = 6
# Impacts after which a motion is abandoned, and searches.
MOST_IMPACTS, PATIENCE = 1_000_000, 1_000_000


@kernel
def plan_section(law: Law, t0: float, asked: Floats, plan: Floats) -> None:
    """Fill the plan of a motion from what is asked."""
    period = law[0, PERIOD]
    since = t0 + asked[ASKED_TRANSIENT] * period
    until = since + asked[ASKED_PERIODS] * period
    cycle = asked[ASKED_CYCLE]
    if cycle >= 0.0:
        # The motion ends at the cycle at which it began, after the last strobe.
        since = (math.ceil(since / period - cycle) + cycle) * period
        until += period
    plan[SINCE] = since
    plan[EVERY] = period
    plan[UNTIL] = until
    plan[LEVEL] = asked[ASKED_LEVEL]
    plan[WAY] = asked[ASKED_WAY]


@kernel
def attractor(
    run: Run,
    start: Floats,
    asked: Floats,
    kept: tuple[Floats, Floats, Floats],
    stops: Floats,
    loads: LoadSpace,
) -> int:
    """Follow a motion from (x0, v0, t0) and keep its points; return why it ended.

    ``kept`` are the plan, the observables and the ring of points, whose oldest one is not the
    first.
    """
    plan, values, points = kept
    plan_section(run.law, start[2], asked, plan)
    run.state[X] = start[0]
    run.state[V] = start[1]
    run.state[T] = start[2]
    options = Options(MOST_IMPACTS, int(asked[ASKED_SECTION]), False, False, False, False, PATIENCE)
    member = Member(run, plan, values, points, stops, loads)
    begin_member(member, options)
    return follow(member, options, False)


@kernel
def in_order(points: Floats, values: Floats, out: Floats) -> None:
    """Write the points of a ring into ``out``, the oldest one first; NaN where there are fewer."""
    m = points.shape[0]
    written = int(values[POINTS])
    first = written % m if written > m else 0
    for i in range(m):
        for column in range(points.shape[1]):
            out[i, column] = points[(first + i) % m, column] if i < written else math.nan


@kernel
def loads_of(law: Law, best: Floats, scratch: Floats) -> LoadSpace:
    """Return the arrays that loads would need; a diagram keeps none."""
    parts = Scratch(scratch[0], scratch[1], scratch[2], scratch[3], scratch[4])
    return LoadSpace(law, best, parts)


@kernel
def clear(state: Floats, counters: Integers) -> None:
    """Set the state and the counters of a run to 0."""
    for i in range(state.shape[0]):
        state[i] = 0.0
    for i in range(counters.shape[0]):
        counters[i] = 0
