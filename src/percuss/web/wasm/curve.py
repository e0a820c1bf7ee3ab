"""A motion as the page shows it: points of its curve, forces, spectrum, from bare numbers.

`percuss.plotting.samples` and `percuss.web.explore` do the same with arrays of NumPy.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import cos_sin, hypotenuse
from percuss.kernels.compile import kernel
from percuss.kernels.fill_law import (
    GIVEN_DAMPING,
    GIVEN_STIFFNESS,
    GIVEN_STOPS,
    STOP_AT,
    STOP_DAMPING,
    STOP_IS_WALL,
    STOP_SIDE,
    STOP_STIFFNESS,
    given_number,
    per_mass,
)
from percuss.kernels.law_columns import FORCING_CONSTANT, MASS, STIFFNESS
from percuss.kernels.record import (
    CONTACT,
    CROSSING,
    EVENT_T,
    IMPACT,
    KIND,
    NEXT_REGION,
    RELEASE,
    MotionRecord,
)
from percuss.kernels.sample import drive, evaluate, flight_at
from percuss.kernels.triples import PI, add, divide, multiply, number, rounded

# As `percuss.plotting.samples` has them.
POINTS_PER_CYCLE, FEWEST_POINTS, MOST_POINTS = 64, 33, 4097
BUDGET = 1_000_000
FEWEST_IN_BUDGET = 5
LARGEST = 1e150


# Rows of three doubles each, for `instant`.
FREQUENCY, N_PERIODS, TIMES, PLUS, ANSWER = range(5)


@kernel
def instant(numbers: Floats) -> None:
    """Write the instant so many periods after a phase, times pi and plus, as a double."""
    time = add(multiply(given_number(numbers, TIMES, 0), PI), given_number(numbers, PLUS, 0))
    if numbers[N_PERIODS, 0] != 0.0:
        period = divide(multiply(number(2.0), PI), given_number(numbers, FREQUENCY, 0))
        time = add(time, multiply(given_number(numbers, N_PERIODS, 0), period))
    numbers[ANSWER, 0] = rounded(time)


@kernel
def cut(record: MotionRecord, low: float, high: float, cuts: Floats) -> int:
    """Write the ends of the smooth pieces of a motion in [low, high]; return how many."""
    events, marks = record.events, record.marks
    cuts[0] = low
    n = 1
    for i in range(events.shape[0]):
        kind = marks[i, KIND]
        ends = kind == IMPACT or kind == CROSSING or kind == CONTACT or kind == RELEASE  # noqa: PLR1714
        if ends and cuts[n - 1] < events[i, EVENT_T] < high:
            cuts[n] = events[i, EVENT_T]
            n += 1
    if high > cuts[n - 1]:
        cuts[n] = high
        n += 1
    return n


@kernel
def count_points(record: MotionRecord, omega: float, cuts: Floats, counts: Integers) -> int:
    """Write how many points each piece between two cuts gets; return their sum."""
    total = 0
    for k in range(cuts.shape[0] - 1):
        middle = 0.5 * (cuts[k] + cuts[k + 1])
        event = flight_at(record.events, middle, True)
        stiffness = record.law[int(record.marks[event, NEXT_REGION]), STIFFNESS]
        rate = max(math.sqrt(abs(stiffness)), omega)
        cycles = (cuts[k + 1] - cuts[k]) * rate / (2.0 * math.pi)
        count = min(max(math.ceil(cycles * POINTS_PER_CYCLE) + 1.0, 33.0), 4097.0)
        counts[k] = int(count)
        total += counts[k]
    if total > BUDGET:
        share = BUDGET / total
        total = 0
        for k in range(counts.shape[0]):
            counts[k] = max(int(counts[k] * share), FEWEST_IN_BUDGET)
            total += counts[k]
    return total


@kernel
def trace(
    record: MotionRecord,
    cuts: Floats,
    counts: Integers,
    phases: Floats,
    ends: Floats,
    curve: Floats,
    jumps: Integers,
) -> int:
    """Write t, x, v of the points of a curve into ``curve`` (3, n); return how many can be drawn.

    At the end of a piece the motion before the event stands, at the next one's start that after
    it; ``jumps`` (n,) is 1 where the velocity jumps to the next point. ``phases`` (2, n_harmonics,
    2) and ``ends`` (3, n_pieces) are scratch.
    """
    n = 0
    for k in range(counts.shape[0]):
        first, last = cuts[k], cuts[k + 1]
        for place in range(counts[k]):
            curve[0, n + place] = first + place / (counts[k] - 1) * (last - first)
            jumps[n + place] = 0
        n += counts[k]
        curve[0, n - 1] = last
        ends[0, k] = last
    evaluate(record, curve[0], True, phases[0], phases[1], curve[1:])
    evaluate(record, ends[0], False, phases[0], phases[1], ends[1:])
    event = 0
    at = -1
    for k in range(counts.shape[0]):
        at += counts[k]
        curve[1, at] = ends[1, k]
        curve[2, at] = ends[2, k]
        while event + 1 < record.events.shape[0] and record.events[event, EVENT_T] < ends[0, k]:
            event += 1
        look = event
        while look < record.events.shape[0] and record.events[look, EVENT_T] == ends[0, k]:
            if record.marks[look, KIND] == IMPACT and k + 1 < counts.shape[0]:
                jumps[at] = 1
            look += 1
    return drawable(curve, jumps)


@kernel
def drawable(curve: Floats, jumps: Integers) -> int:
    """Keep the points that are numbers a picture can hold, and the first; return how many."""
    kept = 0
    for i in range(curve.shape[1]):
        if i == 0 or (abs(curve[1, i]) < LARGEST and abs(curve[2, i]) < LARGEST):
            curve[0, kept] = curve[0, i]
            curve[1, kept] = min(max(curve[1, i], -LARGEST), LARGEST)
            curve[2, kept] = min(max(curve[2, i], -LARGEST), LARGEST)
            jumps[kept] = jumps[i]
            kept += 1
    return kept


@kernel
def without_rests(x: Floats, t: Floats, v: Floats, most: int, out: Floats) -> int:
    """Write the last t, x, v of a curve, less the insides of rests, into ``out`` (3, most).

    Return how many, from the first column on.
    """
    n = 0
    last = v.shape[0] - 1
    # From the end, so that the last ones are kept.
    for i in range(last, -1, -1):
        if n == most:
            break
        if 0 < i < last and v[i - 1] == 0.0 and v[i] == 0.0 and v[i + 1] == 0.0:
            continue
        out[0, n] = t[i]
        out[1, n] = x[i]
        out[2, n] = v[i]
        n += 1
    for row in range(3):
        for i in range(n // 2):
            out[row, i], out[row, n - 1 - i] = out[row, n - 1 - i], out[row, i]
    return n


@kernel
def to_columns(
    t: Floats, values: Floats, jumps: Integers, columns: int, most: int, out: Floats
) -> int:
    """Write the least and the greatest point of every pixel column into ``out`` (2, n).

    Columns are cut at jumps, too. Return how many; all of up to ``most`` points.
    """
    n = t.shape[0]
    if n <= most:
        for i in range(n):
            out[0, i] = t[i]
            out[1, i] = values[i]
        return n
    scale = columns / (t[n - 1] - t[0])
    kept = 0
    i = 0
    while i < n:
        column = math.floor((t[i] - t[0]) * scale)
        least = greatest = i
        end = i + 1
        while end < n and jumps[end - 1] == 0 and math.floor((t[end] - t[0]) * scale) == column:
            if values[end] < values[least]:
                least = end
            if values[end] > values[greatest]:
                greatest = end
            end += 1
        first = min(least, greatest)
        last = max(least, greatest)
        out[0, kept] = t[first]
        out[1, kept] = values[first]
        kept += 1
        if last > first:
            out[0, kept] = t[last]
            out[1, kept] = values[last]
            kept += 1
        i = end
    return kept


@kernel
def stop_forces(
    given: Floats,
    bounds: Integers,
    record: MotionRecord,
    phases: Floats,
    curve: Floats,
    out: Floats,
) -> None:
    """Write the force of each stop along a curve t, x, v (3, n) into ``out`` (n_stops + 1, n).

    A wall has one while it holds the mass; the last row is scratch. Times the mass, where there is
    one.
    """
    n_stops = int(given[0, GIVEN_STOPS])
    law, events, marks = record.law, record.events, record.marks
    mass = law[0, MASS]
    stiffness = rounded(per_mass(given, given_number(given, 0, GIVEN_STIFFNESS), 1.0))
    damping = rounded(per_mass(given, given_number(given, 0, GIVEN_DAMPING), 2.0))
    others = out[n_stops]
    drive(law, curve[0], phases, others)
    for k in range(curve.shape[1]):
        others[k] += law[0, FORCING_CONSTANT] - stiffness * curve[1, k]
        others[k] -= 2.0 * damping * curve[2, k]
    for i in range(n_stops):
        at = given[1 + i, STOP_AT]
        spring = rounded(per_mass(given, given_number(given, 1 + i, STOP_STIFFNESS), 1.0))
        drag = 2.0 * rounded(per_mass(given, given_number(given, 1 + i, STOP_DAMPING), 2.0))
        for k in range(curve.shape[1]):
            out[i, k] = 0.0
            depth = curve[1, k] - at
            if given[1 + i, STOP_IS_WALL] == 0.0 and depth * given[1 + i, STOP_SIDE] > 0.0:
                force = -spring * depth - drag * curve[2, k]
                out[i, k] = mass * force
                others[k] += force
    k = 0
    for row in range(events.shape[0]):
        if marks[row, KIND] != CONTACT:
            continue
        wall = bounds[wall_of(record, row, bounds)]
        release = events[row + 1, EVENT_T] if row + 1 < events.shape[0] else math.inf
        # Contacts come in the order of time, as the points do.
        while k < curve.shape[1] and curve[0, k] < events[row, EVENT_T]:
            k += 1
        while k < curve.shape[1] and curve[0, k] < release:
            out[wall, k] = -mass * others[k]
            k += 1


@kernel
def wall_of(record: MotionRecord, row: int, bounds: Integers) -> int:
    """Return the number of the bound of an event."""
    return min(max(int(record.marks[row, 1]), 0), bounds.shape[0] - 1)


@kernel
def spectrum(values: Floats, work: Floats) -> None:
    """Write the amplitudes of equidistant values under a Hann window into the same array.

    Their number n is a power of two; the first n / 2 + 1 entries are those of the frequencies from
    0 on. ``work`` (2, n) is scratch.
    """
    n = values.shape[0]
    bits = 0
    while (1 << bits) < n:
        bits += 1
    for i in range(n):
        back = 0
        for bit in range(bits):
            back |= ((i >> bit) & 1) << (bits - 1 - bit)
        window = 0.5 - 0.5 * cos_sin(1.0 / n, 0.0, float(i), 0.0)[0]
        work[0, back] = values[i] * window
        work[1, back] = 0.0
    half = 1
    while half < n:
        for k in range(half):
            cosine, sine = cos_sin(0.5 / half, 0.0, float(k), 0.0)
            for i in range(k, n, 2 * half):
                real = cosine * work[0, i + half] + sine * work[1, i + half]
                imaginary = cosine * work[1, i + half] - sine * work[0, i + half]
                work[0, i + half] = work[0, i] - real
                work[1, i + half] = work[1, i] - imaginary
                work[0, i] += real
                work[1, i] += imaginary
        half *= 2
    for i in range(n // 2 + 1):
        values[i] = hypotenuse(work[0, i], work[1, i]) * 4.0 / n
