"""Basins as a browser computes them: the kind of each start, and whose attractor it goes to.

`percuss.ensembles` follows many motions at once; a motion has the same bits alone, and what
decides are the same kernels (`percuss.ensembles.decisions`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats, Integers
from percuss.ensembles.attractors import (
    AGAIN,
    FILLING,
    LATE,
    LONG,
    MOST_FAILURES,
    MOST_ORBITS,
    MOST_TRANSIENTS,
    SETTLING,
)
from percuss.ensembles.attractors import COMPARED as COMPARED_IN_CELLS
from percuss.ensembles.basins import DRAWN
from percuss.ensembles.classification import (
    COMPARED,
    LONGEST,
    LONGEST_OF_ALL,
    PERIODS_OF_AN_EXPONENT,
    STAGE,
)
from percuss.ensembles.decisions import (
    BLOCKS,
    CHAOTIC,
    ERROR,
    LARGEST,
    LEAST_SHARE,
    NO_START,
    PERIODIC,
    REST,
    UNBOUNDED,
    UNDECIDED,
    agree,
    exponents_of_points,
    fill_cells,
    fraction_of,
    has_settled,
    is_chaotic,
    is_near,
    kind_of,
    period_of_points,
    share_in_cells,
)
from percuss.kernels.arithmetic import nearest
from percuss.kernels.compile import kernel
from percuss.kernels.law_columns import (
    FIRST_HARMONIC,
    LOWER,
    LOWER_KIND,
    N_HARMONICS,
    N_REGIONS,
    PERIOD,
    UPPER,
    UPPER_KIND,
    WALL,
)
from percuss.kernels.members import Options, begin_member, follow
from percuss.kernels.observables import (
    CONTACTS,
    END_V,
    END_X,
    EVERY,
    IMPACTS,
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    Member,
)
from percuss.kernels.record import AT_REST, SPENT, Run, T, V, X
from percuss.web.wasm.attractors import MOST_IMPACTS, PATIENCE, clear, in_order, loads_of

# The rules of a basin: when starts begin, the periods after which one stays undecided, and where a
# motion is unbounded.
RULES_T0, RULES_PERIODS, RULES_ESCAPE, RULES_ENTRIES = range(4)
# The class of a start: its kind and period, a strobe, the largest exponent and its error.
CLASS_KIND, CLASS_PERIODS, CLASS_X, CLASS_V, CLASS_EXPONENT, CLASS_ERROR, CLASS_ENTRIES = range(7)
# An attractor: its kind, periods and impacts, the first start that goes there, the number of points
# of it that are drawn and the first of them, and the part of the starts with its error.
(
    FOUND_KIND,
    FOUND_PERIODS,
    FOUND_IMPACTS,
    FOUND_START,
    FOUND_POINTS,
    FOUND_FIRST,
    FOUND_FRACTION,
    FOUND_ERROR,
    FOUND_ENTRIES,
) = range(9)
# As many as are told apart, those of a few places of rest, and one of all unbounded motions.
MOST_FOUND = MOST_ORBITS + MOST_TRANSIENTS + 20
MOST_POINTS = LONGEST_OF_ALL * MOST_ORBITS + DRAWN * MOST_TRANSIENTS + MOST_FOUND
# Strobes of a motion that are kept at most.
MOST_STROBES = FILLING
# The label of a start while it is left over.
LEFT = -3
# What a call returns where Python is needed.
NEEDS_PYTHON = -1


class Space(NamedTuple):
    """Arrays that motions are followed in, one after another, as the page gives them.

    Those of a run, of which ``phases`` (3, n, 2) are three, and of loads, ``best`` and ``scratch``.
    ``ring`` and ``points`` (MOST_STROBES, 3) are those that are written and those in order,
    ``strobes`` (MOST_STROBES, 2) x and v of these, ``last`` of those before, ``cloud`` those of an
    attractor; ``rates`` (BLOCKS,) and ``exponents`` are of perturbations, ``frame`` (2, 2) and
    ``cells`` (SIDE, SIDE) of the plane of an attractor.
    """

    law: Floats
    state: Floats
    counters: Integers
    phases: Floats
    events: Floats
    marks: Integers
    grazes: Floats
    plan: Floats
    values: Floats
    ring: Floats
    points: Floats
    strobes: Floats
    last: Floats
    cloud: Floats
    stops: Floats
    best: Floats
    scratch: Floats
    rates: Floats
    exponents: Floats
    frame: Floats
    cells: Integers


@kernel
def copy(points: Floats, n: int, to: Floats, first: int) -> None:
    """Write x and v of the first n points from a row on."""
    for k in range(n):
        for column in range(2):
            to[first + k, column] = points[k, column]


@kernel
def follow_from(
    space: Space, x: float, v: float, t: float, times: tuple[float, float, float], section: int
) -> int:
    """Follow a motion from a start; return why it ended, with its points and strobes in order.

    ``times`` are when the points begin, the time between two, and the end.
    """
    phases, plan, values = space.phases, space.plan, space.values
    run = Run(
        space.law, space.state, space.counters, phases[0], phases[1], phases[2], space.events,
        space.marks, space.grazes,
    )  # fmt: skip
    loads = loads_of(space.law, space.best, space.scratch)
    since, every, until = times
    n_points = int(nearest((until - since) / every)) + 1
    clear(run.state, run.counters)
    run.state[X] = x
    run.state[V] = v
    run.state[T] = t
    plan[SINCE] = since
    plan[EVERY] = every
    plan[UNTIL] = until
    options = Options(MOST_IMPACTS, section, False, False, False, False, PATIENCE)
    member = Member(run, plan, values, space.ring[:n_points], space.stops, loads)
    begin_member(member, options)
    status = follow(member, options, False)
    in_order(space.ring[:n_points], values, space.points[:n_points])
    copy(space.points, n_points, space.strobes, 0)
    return status


@kernel
def stage(space: Space, x: float, v: float, t: float, until: float, compared: int) -> int:
    """Follow a motion to the end of a stage, whose last strobes are compared."""
    period = space.law[0, PERIOD]
    return follow_from(space, x, v, t, (until - compared * period, period, until), STROBES)


@kernel
def exponent(space: Space, x: float, v: float, t: float, periods: int) -> int:
    """Find the exponents of a motion over so many periods."""
    every = periods / BLOCKS * space.law[0, PERIOD]
    until = t + BLOCKS * every
    status = follow_from(space, x, v, t, (t, every, until), TANGENTS)
    exponents_of_points(space.points, until - t, every, space.rates, space.exponents)
    return status


@kernel
def classify_starts(space: Space, rules: Floats, starts: Floats, classes: Floats) -> int:
    """Write the classes of starts (n, 2); return 0, or NEEDS_PYTHON."""
    for i in range(starts.shape[0]):
        if classify(space, rules, starts[i, 0], starts[i, 1], classes[i]) == SPENT:
            return NEEDS_PYTHON
    return 0


@kernel
def classify(space: Space, rules: Floats, x: float, v: float, out: Floats) -> int:
    """Write the class of a start; return why its motion ended."""
    law = space.law
    period = law[0, PERIOD]
    for column in range(CLASS_ENTRIES):
        out[column] = math.nan
    out[CLASS_KIND] = UNDECIDED
    out[CLASS_PERIODS] = 0.0
    first = FIRST_HARMONIC + int(law[0, N_HARMONICS])
    last = first + (int(law[0, N_REGIONS]) - 1) * (1 + int(law[0, N_HARMONICS]))
    below = law[first, LOWER_KIND] == WALL and x < law[first, LOWER]
    above = law[last, UPPER_KIND] == WALL and x > law[last, UPPER]
    if below or above:
        out[CLASS_KIND] = NO_START
        return AT_REST
    t = rules[RULES_T0]
    for k in range(-(-int(rules[RULES_PERIODS]) // STAGE)):
        until = rules[RULES_T0] + ((k + 1) * STAGE) * period
        status = stage(space, x, v, t, until, COMPARED)
        if status == SPENT or is_decided(space, status, rules[RULES_ESCAPE], COMPARED, out):
            return status
        x, v, t = space.values[END_X], space.values[END_V], until
        if not (math.isfinite(x) and math.isfinite(v)):
            return status
    status = exponent(space, x, v, t, PERIODS_OF_AN_EXPONENT)
    if is_chaotic(space.exponents[LARGEST], space.exponents[ERROR], period):
        out[CLASS_KIND] = CHAOTIC
        out[CLASS_X] = x
        out[CLASS_V] = v
        out[CLASS_EXPONENT] = space.exponents[LARGEST]
        out[CLASS_ERROR] = space.exponents[ERROR]
        return status
    until = t + 2 * LONGEST_OF_ALL * period
    status = stage(space, x, v, t, until, 2 * LONGEST_OF_ALL)
    is_decided(space, status, rules[RULES_ESCAPE], 2 * LONGEST_OF_ALL, out)
    return status


@kernel
def is_decided(space: Space, status: int, escape: float, compared: int, out: Floats) -> bool:
    """Write the class of a motion after a stage; return whether it has one."""
    values, strobes = space.values, space.strobes[: compared + 1]
    space.exponents[0] = values[END_X]
    space.exponents[1] = values[END_V]
    period = space.law[0, PERIOD]
    kind, n_periods = kind_of(status, space.exponents[:2], strobes, period, escape)
    if kind == UNDECIDED:
        return False
    out[CLASS_KIND] = kind
    out[CLASS_PERIODS] = n_periods
    if kind == PERIODIC:
        out[CLASS_X] = strobes[compared, 0]
        out[CLASS_V] = strobes[compared, 1]
    elif kind == REST:
        # The strobe of a mass at rest is its place.
        out[CLASS_X] = space.state[X]
        out[CLASS_V] = space.state[V]
    return True


@kernel
def settle(space: Space, t0: float, x: float, v: float, longest: int) -> tuple[int, int, float]:
    """Follow a motion until it has settled on a periodic orbit.

    Return periods, 0 where it does not, of its first strobes that come again, which lie in
    ``cloud``; periods of those that are nearest to the orbit, in ``last``; and impacts in one.
    """
    law, values = space.law, space.values
    period = law[0, PERIOD]
    since = t0 + SETTLING * period
    until = since + 2 * longest * period
    n_first = 0
    n_last = 0
    n_impacts = math.nan
    for _ in range(AGAIN):
        follow_from(space, x, v, t0, (since, period, until), STROBES)
        strobes = space.strobes[: 2 * longest + 1]
        for k in range(strobes.shape[0]):
            for column in range(2):
                if math.isnan(strobes[k, column]):
                    strobes[k, column] = 0.0
        x, v = strobes[2 * longest, 0], strobes[2 * longest, 1]
        n_periods = period_of_points(strobes, longest, period)
        if n_periods == 0:
            continue
        n_last = n_periods
        copy(strobes, n_last, space.last, 0)
        if n_first == 0:
            n_first = n_periods
            copy(strobes, n_first, space.cloud, 0)
            n_impacts = nearest(values[IMPACTS] * n_first / (2 * longest))
            if values[CONTACTS] > 0.0:
                n_impacts = math.inf
        if has_settled(strobes, n_periods, period):
            break
    return n_first, n_last, n_impacts


@kernel
def cover(space: Space, t0: float, x: float, v: float) -> tuple[float, float, bool]:
    """Follow a chaotic motion until its strobes cover its attractor.

    Return its exponent, the error, and whether it is chaotic still. The strobes lie in ``cloud``,
    and ``cells`` are those of its plane.
    """
    period = space.law[0, PERIOD]
    times = (t0, period, t0 + (FILLING - 1) * period)
    follow_from(space, x, v, t0, times, STROBES)
    copy(space.strobes, FILLING, space.cloud, 0)
    fill_cells(space.cloud[:FILLING], space.frame, space.cells)
    exponent(space, x, v, t0, LONG)
    largest, error = space.exponents[LARGEST], space.exponents[ERROR]
    x, v = space.cloud[FILLING - 1, 0], space.cloud[FILLING - 1, 1]
    late = 0.0
    if math.isfinite(x) and math.isfinite(v):
        exponent(space, x, v, t0, LATE)
        late = space.exponents[LARGEST]
    persists = is_chaotic(largest, error, period) and is_chaotic(late, 0.0, period)
    return largest, error, persists


@kernel
def is_among(space: Space, t0: float, start: Floats, largest: float, error: float) -> bool:
    """Return whether a chaotic motion is on the attractor that another one has covered."""
    x, v = start[CLASS_X], start[CLASS_V]
    period = space.law[0, PERIOD]
    times = (t0, period, t0 + (COMPARED_IN_CELLS - 1) * period)
    follow_from(space, x, v, t0, times, STROBES)
    if share_in_cells(space.strobes[:COMPARED_IN_CELLS], space.frame, space.cells) <= LEAST_SHARE:
        return False
    if agree(start[CLASS_EXPONENT], start[CLASS_ERROR], largest, error):
        return True
    # A longer run decides: of many short ones some differ beyond their errors by chance.
    exponent(space, x, v, t0, LONG)
    return agree(space.exponents[LARGEST], space.exponents[ERROR], largest, error)


@kernel
def label(
    space: Space, rules: Floats, classes: Floats, labels: Integers, found: Floats, drawn: Floats
) -> int:
    """Write the number of each start's attractor, and the attractors; return how many there are.

    ``classes`` (n, CLASS_ENTRIES) are those of the starts, ``labels`` (n,) their attractors in the
    order of their first starts, UNDECIDED or NO_START; ``found`` (MOST_FOUND, FOUND_ENTRIES) the
    attractors, and ``drawn`` (MOST_POINTS, 2) their points.
    """
    n = classes.shape[0]
    for row in range(n):
        # What is left has a number below those that are known.
        labels[row] = NO_START if classes[row, CLASS_KIND] == NO_START else LEFT
    n_found = 0
    n_drawn = 0
    for kind in range(PERIODIC, UNBOUNDED + 1):
        n_failures = 0
        before = n_found
        for row in range(n):
            if labels[row] != LEFT or classes[row, CLASS_KIND] != kind:
                continue
            most = MOST_FAILURES if kind == PERIODIC else MOST_TRANSIENTS
            if n_failures >= most or (kind == PERIODIC and n_found - before >= MOST_ORBITS):
                break
            if n_found == found.shape[0]:
                return NEEDS_PYTHON
            out = found[n_found]
            out[FOUND_KIND] = kind
            out[FOUND_START] = row
            out[FOUND_FIRST] = n_drawn
            if not gather(space, rules[RULES_T0], classes, labels, row, n_found, out):
                # A long transient: it stays undecided.
                labels[row] = UNDECIDED
                n_failures += 1
                continue
            points = int(out[FOUND_POINTS])
            copy(space.cloud, points, drawn, n_drawn)
            n_drawn += points
            n_found += 1
    finish(labels, found[:n_found])
    return n_found


@kernel
def gather(
    space: Space, t0: float, classes: Floats, labels: Integers, row: int, number: int, out: Floats
) -> bool:
    """Give the attractor of a start a number, and all that go there; return whether it is one."""
    kind = int(classes[row, CLASS_KIND])
    x, v = classes[row, CLASS_X], classes[row, CLASS_V]
    period = space.law[0, PERIOD]
    out[FOUND_PERIODS] = 0.0
    out[FOUND_IMPACTS] = math.nan
    out[FOUND_POINTS] = 0.0
    largest = 0.0
    error = 0.0
    n_last = 0
    if kind == PERIODIC:
        longest = LONGEST_OF_ALL if classes[row, CLASS_PERIODS] > LONGEST else LONGEST
        n_first, n_last, n_impacts = settle(space, t0, x, v, longest)
        begun = classes[row, CLASS_X : CLASS_V + 1]
        if n_first == 0 or not is_near(begun, space.last[:n_last], period):
            return False
        out[FOUND_PERIODS] = n_first
        out[FOUND_IMPACTS] = n_impacts
        out[FOUND_POINTS] = n_first
    elif kind == CHAOTIC:
        largest, error, persists = cover(space, t0, x, v)
        if not persists:
            return False
        out[FOUND_POINTS] = DRAWN
    elif kind == REST:
        space.cloud[0, 0] = x
        space.cloud[0, 1] = 0.0
        out[FOUND_POINTS] = 1.0
    for other in range(row, labels.shape[0]):
        if labels[other] != LEFT or classes[other, CLASS_KIND] != kind:
            continue
        own = classes[other]
        same = True
        if kind == PERIODIC:
            same = is_near(own[CLASS_X : CLASS_V + 1], space.last[:n_last], period)
        elif kind == CHAOTIC and other != row:
            same = is_among(space, t0, own, largest, error)
        elif kind == REST:
            same = own[CLASS_X] == x
        if same:
            labels[other] = number
    return True


@kernel
def finish(labels: Integers, found: Floats) -> None:
    """Give attractors the numbers of their first starts in order, and count their starts."""
    n = 0
    for row in range(labels.shape[0]):
        if labels[row] == LEFT:
            labels[row] = UNDECIDED
        n += 1 if labels[row] != NO_START else 0
    # By insertion: those of one kind are in order.
    for k in range(found.shape[0]):
        found[k, FOUND_FRACTION] = 0.0
        found[k, FOUND_ERROR] = k
    for k in range(1, found.shape[0]):
        i = k
        while i > 0 and found[i - 1, FOUND_START] > found[i, FOUND_START]:
            for column in range(FOUND_ENTRIES):
                kept = found[i, column]
                found[i, column] = found[i - 1, column]
                found[i - 1, column] = kept
            i -= 1
    renumber(labels, found)
    for k in range(found.shape[0]):
        part, error = fraction_of(int(found[k, FOUND_FRACTION]), n)
        found[k, FOUND_FRACTION] = part
        found[k, FOUND_ERROR] = error


@kernel
def renumber(labels: Integers, found: Floats) -> None:
    """Count the starts of each attractor, and give them its new number."""
    for row in range(labels.shape[0]):
        if labels[row] >= 0:
            labels[row] = new_number(found, labels[row])
            found[labels[row], FOUND_FRACTION] += 1.0


@kernel
def new_number(found: Floats, number: int) -> int:
    """Return the place of the attractor that had a number."""
    k = 0
    while found[k, FOUND_ERROR] != number:
        k += 1
    return k
