"""What decides about motions: their period, kind and exponents, and which attractor is whose.

Kernels for one motion each, so that Python and the page (`percuss.web.wasm`) decide alike, and
those that Python applies to many.
"""

from __future__ import annotations

import math

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels.arithmetic import (
    ULP,
    cosine_sine,
    exponential,
    exponential_less_one,
    hypotenuse,
    logarithm,
)
from percuss.kernels.compile import kernel
from percuss.kernels.observables import FIRST, SECOND, THIRD
from percuss.kernels.record import AT_REST, OVERFLOW, REACHED_END

# Kinds of long-term motion, as they are stored, and those of a start without a decision and of one
# inside a wall.
PERIODIC, CHAOTIC, REST, UNBOUNDED = range(4)
UNDECIDED, NO_START = -1, -2

# Strobes that differ by less than this part of the motion's size are the same.
SAME = 1e-6
# The strobes of an orbit of p periods differ by more than 100 times that; smaller differences are
# the end of a transient that turns by about 1/p.
SETTLED = 100.0
# A motion has settled on its orbit where its strobes come again to this part of its size.
CLOSE = 1e-9


@kernel
def weight(column: int, n_columns: int, period: float) -> float:
    """Return the factor that makes a column of a strobe a length, displacements before velocities.

    1 for displacements, period / (2 pi) for velocities: what they move in a radian of the forcing.
    In every unit of time the same strobes are the same.
    """
    return 1.0 if 2 * column < n_columns else period / (2.0 * math.pi)


@kernel
def size_of(points: Floats, period: float) -> float:
    """Return the largest length in strobes (m, 2 d), NaN where one is no number."""
    size = 0.0
    for i in range(points.shape[0]):
        for column in range(points.shape[1]):
            if math.isnan(points[i, column]):
                return math.nan
            size = max(size, weight(column, points.shape[1], period) * abs(points[i, column]))
    return size


@kernel
def period_of_points(points: Floats, longest: int, period: float) -> int:
    """Return the period of a motion in forcing periods, 0 where it does not repeat itself.

    ``points`` (m, 2 d) are its strobes, displacements before velocities, ``longest`` < m is the
    longest period considered, and ``period`` that of the forcing [time].
    """
    size = size_of(points, period)
    if math.isnan(size):
        return 0
    same = SAME * size
    last = points.shape[0] - 1
    for p in range(1, longest + 1):
        # A motion that repeats itself does so at the end, and has done so from the beginning.
        hopeful = are_same(points[last - p], points[last], same, period)
        if not hopeful or not repeats(points, p, same, period):
            continue
        # The first period that fits decides, if only that there is none.
        for q in range(1, p // 2 + 1):
            if p % q == 0 and repeats(points, q, SETTLED * same, period):
                return 0
        return p
    return 0


@kernel
def are_same(one: Floats, other: Floats, most: float, period: float) -> bool:
    """Return whether two strobes are the same up to a length ``most``."""
    for column in range(one.shape[0]):
        if not weight(column, one.shape[0], period) * abs(other[column] - one[column]) <= most:
            return False
    return True


@kernel
def repeats(points: Floats, p: int, most: float, period: float) -> bool:
    """Return whether all strobes are the same as those p later, up to a length ``most``."""
    same = True
    for i in range(points.shape[0] - p):
        same = same and are_same(points[i], points[i + p], most, period)
    return same


@kernel
def has_settled(points: Floats, p: int, period: float) -> bool:
    """Return whether strobes that come again after p periods are those of the orbit itself."""
    return repeats(points, p, CLOSE * size_of(points, period), period)


@kernel
def periods_of_motions(points: Floats, longest: int, every: Floats, periods: Integers) -> None:
    """Write the periods of motions, whose strobes are (n, m, 2 d), one in each of ``every`` (n,)."""
    for i in range(points.shape[0]):
        periods[i] = period_of_points(points[i], longest, every[i])


@kernel
def kind_of(
    status: int, end: Floats, points: Floats, period: float, escape: float
) -> tuple[int, int]:
    """Return kind and period of a motion after a stage, UNDECIDED and 0 where it shows none.

    ``end`` (2 d,) are displacements and velocities at the end, ``points`` (m, 2 d) the last m
    strobes, of which half could be a period, and a motion beyond ``escape`` is unbounded.
    """
    if status == AT_REST:
        return REST, 0
    if status == OVERFLOW:
        return UNBOUNDED, 0
    if status != REACHED_END:
        return UNDECIDED, 0
    d = end.shape[0] // 2
    far = 0.0
    for i in range(d):
        # At a strobe x may be near 0 while the speed is large.
        far = max(far, abs(end[i]), weight(d + i, 2 * d, period) * abs(end[d + i]))
    if far > escape:
        return UNBOUNDED, 0
    n_periods = period_of_points(points, (points.shape[0] - 1) // 2, period)
    return (PERIODIC, n_periods) if n_periods > 0 else (UNDECIDED, 0)


@kernel
def kinds_of_motions(
    status: Integers,
    ends: Floats,
    points: Floats,
    periods: Floats,
    escape: float,
    kinds: Integers,
    n_periods: Integers,
) -> None:
    """Write kinds and periods of motions."""
    for i in range(status.shape[0]):
        kinds[i], n_periods[i] = kind_of(status[i], ends[i], points[i], periods[i], escape)


# Blocks of time whose means give the standard error: long compared with the memory of a motion, and
# enough to know their spread to a tenth.
BLOCKS = 64
# Columns of exponents, in 1/time: the largest and the smallest, the standard error, their sum.
LARGEST, SMALLEST, ERROR, TOTAL = range(4)
EXPONENT_COLUMNS = 4
# A motion is chaotic where its largest exponent exceeds 0 by three standard errors, and by 1e-3 in
# a forcing period.
CERTAIN, LEAST_EXPONENT = 3.0, 1e-3
# Exponents differ if they are farther apart than so many standard errors.
AGREED = 6.0


@kernel
def exponents_of_points(
    points: Floats, duration: float, every: float, rates: Floats, out: Floats
) -> None:
    """Write exponents from the points of a perturbation at the ends of blocks of time.

    -inf where there was a contact, with an error of 0. ``rates`` (BLOCKS,) is scratch.
    """
    first, last = points[0], points[BLOCKS]
    if last[FIRST] == -math.inf:
        # After a contact no perturbation is left, and the logarithm stays there.
        out[LARGEST] = out[SMALLEST] = out[TOTAL] = -math.inf
        out[ERROR] = 0.0
        return
    for k in range(BLOCKS):
        rates[k] = (points[k + 1, FIRST] - points[k, FIRST]) / every
    mean = sum_of(rates) / BLOCKS
    for k in range(BLOCKS):
        rates[k] = (rates[k] - mean) * (rates[k] - mean)
    out[LARGEST] = (last[FIRST] - first[FIRST]) / duration
    out[TOTAL] = (last[SECOND] - first[SECOND]) / duration
    out[ERROR] = math.sqrt(sum_of(rates) / (BLOCKS - 1)) / math.sqrt(BLOCKS)
    out[SMALLEST] = out[TOTAL] - out[LARGEST]


@kernel
def sum_of(rates: Floats) -> float:
    """Return the sum of 16, 24, ... up to 128 numbers, in the order in which NumPy adds them."""
    pairs = 0.0
    fours = 0.0
    total = 0.0
    for lane in range(8):
        part = rates[lane]
        for k in range(8 + lane, rates.shape[0], 8):
            part += rates[k]
        pairs = pairs + part if lane % 2 == 1 else part
        if lane % 4 == 3:
            fours = fours + pairs
            total = total + fours if lane == 7 else fours
        elif lane % 4 == 1:
            fours = pairs
    return total


@kernel
def many_exponents(
    points: Floats, durations: Floats, every: Floats, rates: Floats, out: Floats
) -> None:
    """Write the exponents of motions."""
    for i in range(points.shape[0]):
        exponents_of_points(points[i], durations[i], every[i], rates, out[i])


# A difference of halves beyond so many of its standard errors is not chance.
CHANCE = 3.0


@kernel
def drift_of_points(points: Floats, every: float, rates: Floats) -> float:
    """Return the difference of the largest exponents of both halves [1/time], 0 within chance.

    The spread of block means does not show a slow transient, about which they scatter little. The
    halves of a stationary motion differ by about twice the standard error of the whole; three times
    that counts as chance. ``rates`` (BLOCKS,) is scratch.
    """
    for k in range(BLOCKS):
        rates[k] = (points[k + 1, FIRST] - points[k, FIRST]) / every
    half = BLOCKS // 2
    drift = abs(sum_of(rates[half:]) / half - sum_of(rates[:half]) / half)
    mean = sum_of(rates) / BLOCKS
    for k in range(BLOCKS):
        rates[k] = (rates[k] - mean) * (rates[k] - mean)
    error = math.sqrt(sum_of(rates) / (BLOCKS - 1)) / math.sqrt(BLOCKS)
    # After a contact there is nothing to drift: these are no numbers.
    return drift if drift > 2.0 * CHANCE * error else 0.0


# Roundings of a perturbation in a flight and over the event at its end.
ROUNDINGS = 16.0


@kernel
def rounding_of(n_events: float, size: float) -> float:
    """Return a bound of the rounding of a logarithm that has grown to a size over some events."""
    return ULP * (ROUNDINGS * (n_events + BLOCKS) + size)


# Periods of an orbit from which its exponents are taken, and the relative difference up to which
# areas shrink alike in them.
ORBIT_PERIODS, ALIKE = 3, 1e-6


@kernel
def orbit_exponents(
    points: Floats, step: float, n_periods: float, n_events: float, out: Floats
) -> bool:
    """Write the exponents of an orbit and their errors; return False where the motion is on none.

    ``points`` (ORBIT_PERIODS + 1, columns) are those of a perturbation once a period of ``step``,
    ``n_periods`` those that the motion has taken to the orbit, ``n_events`` the events in one,
    ``out`` (4,) the larger exponent, the smaller one and their errors.
    """
    least = math.inf
    most = -math.inf
    for k in range(ORBIT_PERIODS):
        shrunk = points[k + 1, SECOND] - points[k, SECOND]
        least = min(least, shrunk)
        most = max(most, shrunk)
    relative = ROUNDINGS * ULP * (1.0 + n_events)
    larger, smaller, _ = orbit_rates(points[:3], relative)
    larger_1, smaller_1, rounding = orbit_rates(points[1:4], relative)
    sum_of_rates = larger + smaller + larger_1 + smaller_1
    # An impact at the very end of a period can fall into either of two: then areas do not shrink
    # alike, and the periods are none.
    if not math.isfinite(sum_of_rates) or most - least > ALIKE * max(abs(most), abs(least)):
        return False
    out[0] = larger_1 / step
    out[1] = smaller_1 / step
    to_go = steps_to_go(out[0] * step, n_periods)
    out[2] = abs(out[0] - larger / step) * to_go + rounding / step
    out[3] = abs(out[1] - smaller / step) * to_go + rounding / step
    return True


@kernel
def orbit_rates(points: Floats, relative: float) -> tuple[float, float, float]:
    """Return the logarithms of the sizes of both multipliers, from the points at three strobes.

    The vectors u, M u and M^2 u of the monodromy matrix M give its trace: M^2 - tr M + det = 0. The
    third number is what a relative rounding of these makes of the logarithms; of multipliers that
    are equal to within it, its root.
    """
    area = exponential(points[1, SECOND] - points[0, SECOND])
    u_x, u_v = cosine_sine(points[0, THIRD])
    size = exponential(points[1, FIRST] - points[0, FIRST])
    cosine, sine = cosine_sine(points[1, THIRD])
    once_x = size * cosine
    once_v = size * sine
    size = exponential(points[2, FIRST] - points[0, FIRST])
    cosine, sine = cosine_sine(points[2, THIRD])
    twice_x = size * cosine + area * u_x
    twice_v = size * sine + area * u_v
    trace = (twice_x * once_x + twice_v * once_v) / (once_x * once_x + once_v * once_v)
    half = 0.5 * trace
    below = half * half - area
    larger = abs(half) + math.sqrt(below) if below > 0.0 else math.sqrt(area)
    smaller = abs(area) / larger if below > 0.0 else larger
    doubt = relative * (half * half + abs(area))
    moved = 0.0
    if abs(below) <= doubt:
        moved = math.sqrt(doubt)
    elif below > 0.0:
        moved = doubt / math.sqrt(below)
    return logarithm(larger), logarithm(smaller), relative + moved / larger


@kernel
def steps_to_go(log_multiplier: float, n_periods: float) -> float:
    """Return the remaining way to an orbit as a multiple of the last step.

    The approach is geometric: steps of m, m^2, ... times the last one follow, less than
    1 / (1 - m) in all.
    Where |m| is 1 the distance falls as one over the number of periods, and the remaining way is
    the last step times that number.
    """
    left = -exponential_less_one(log_multiplier)
    return 1.0 / left if left * n_periods > 1.0 else max(1.0, n_periods)


# So many standard errors are no chance for the exponent of one motion; and neighbours that separate
# by a power of the time, t^2 at most, seem to have the exponent 2 ln(n) / n in n periods.
DISTINCT, POWER = 5.0, 2.0


@kernel
def sign_of_exponent(value: float, error: float, n_periods: float, period: float) -> int:
    """Return 1 where neighbours part, -1 where they meet, 0 where neither is sure.

    An exponent and its error [1/time], over so many forcing periods [time].
    """
    growth = POWER * logarithm(n_periods) / (n_periods * period) if n_periods > 1.0 else 0.0
    least = max(DISTINCT * error, growth)
    if value > least:
        return 1
    return -1 if value < -least else 0


@kernel
def is_chaotic(largest: float, error: float, period: float) -> bool:
    """Return whether an exponent is that of chaos."""
    return largest > CERTAIN * error and largest > LEAST_EXPONENT / period


@kernel
def agree(one: float, error: float, other: float, other_error: float) -> bool:
    """Return whether two exponents may be the same."""
    return abs(one - other) <= AGREED * hypotenuse(error, other_error)


# Largest distance between strobes of the same periodic orbit, relative to its size: motions that
# are classified as periodic repeat themselves to 1e-6 from one period to the next, and one that
# spirals around its orbit may be a hundred times as far from it.
NEAR = 3e-4


@kernel
def is_near(strobe: Floats, orbit: Floats, period: float) -> bool:
    """Return whether a strobe is one of an orbit's (n, 2 d), where the forcing has this period."""
    size = size_of(orbit, period)
    most = NEAR * (size if size > 0.0 else 1.0)
    near = False
    for k in range(orbit.shape[0]):
        near = near or are_same(strobe, orbit[k], most, period)
    return near


@kernel
def near_orbit(strobes: Floats, rows: Integers, orbit: Floats, period: float, near: Flags) -> None:
    """Write which strobes, by their rows, are those of an orbit."""
    for i in range(rows.shape[0]):
        near[i] = is_near(strobes[rows[i]], orbit, period)


# Cells along each axis in which chaotic motions are compared, with more on all sides: places
# outside fall into the outermost, which are empty.
CELLS = 50
SIDE = CELLS + 5
# The least share of the strobes of a motion on the attractor in or next to its cells.
LEAST_SHARE = 0.95


@kernel
def fill_cells(cloud: Floats, frame: Floats, full: Integers) -> None:
    """Mark the cells of a plane that contain an attractor, and their neighbours.

    ``cloud`` (n, 2) are its strobes, ``frame`` (2, 2) is given the least place and the size of a
    cell along each axis, ``full`` (SIDE, SIDE) a 1 for each of them.
    """
    for column in range(2):
        low = math.inf
        high = -math.inf
        for k in range(cloud.shape[0]):
            if math.isfinite(cloud[k, 0]) and math.isfinite(cloud[k, 1]):
                low = min(low, cloud[k, column])
                high = max(high, cloud[k, column])
        width = high - low
        frame[0, column] = low
        frame[1, column] = (width if width > 0.0 else 1.0) / CELLS
    for i in range(SIDE):
        for j in range(SIDE):
            full[i, j] = 0
    for k in range(cloud.shape[0]):
        if not (math.isfinite(cloud[k, 0]) and math.isfinite(cloud[k, 1])):
            continue
        i = cell_of(cloud[k, 0], frame, 0)
        j = cell_of(cloud[k, 1], frame, 1)
        for di in range(-1, 2):
            for dj in range(-1, 2):
                full[i + di, j + dj] = 1


@kernel
def cell_of(place: float, frame: Floats, column: int) -> int:
    """Return the number of the cell of a place along an axis."""
    cell = (place - frame[0, column]) / frame[1, column]
    if cell >= -1.0:
        return math.floor(cell) + 2 if cell < CELLS + 2.0 else CELLS + 4
    # What is no number is outside, too.
    return 0


@kernel
def share_in_cells(places: Floats, frame: Floats, full: Integers) -> float:
    """Return the share of places (m, 2) that lie in the cells."""
    count = 0
    for k in range(places.shape[0]):
        count += full[cell_of(places[k, 0], frame, 0), cell_of(places[k, 1], frame, 1)]
    return float(count / places.shape[0])


@kernel
def shares_in_cells(places: Floats, frame: Floats, full: Integers, shares: Floats) -> None:
    """Write the shares of motions, whose places are (n, m, 2)."""
    for i in range(places.shape[0]):
        shares[i] = share_in_cells(places[i], frame, full)


@kernel
def fraction_of(count: int, n: int) -> tuple[float, float]:
    """Return the part that a count is of n starts, and its standard error if they were drawn."""
    part = count / max(n, 1)
    return part, math.sqrt(part * (1.0 - part) / max(n, 1))
