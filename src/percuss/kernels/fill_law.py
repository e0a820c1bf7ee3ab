"""The law of an oscillator from bare numbers, where there is no Python: in a browser.

`percuss.model.system` makes the same law of values of the model; each of its rows is filled by the
same formulas (`law_formulas`). Tables of restitution, records and Fourier sums are Python's.

The numbers are rows of ``GIVEN_COLUMNS`` doubles, each exact number three of them (`triples`):
row 0 for the oscillator, one for each stop, one for each harmonic.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import cosine_sine
from percuss.kernels.compile import kernel
from percuss.kernels.law_columns import (
    COSINE,
    EDGE,
    FIRST_HARMONIC,
    FORCING_CONSTANT,
    LOWER,
    LOWER_ENTRY,
    LOWER_FORCE,
    LOWER_KIND,
    LOWER_RESTITUTION,
    MASS,
    N_HARMONICS,
    N_REGIONS,
    NOTHING,
    NUMBER,
    OMEGA,
    ORIGIN,
    ORIGIN_FORCE,
    PERIOD,
    PERIOD_TURNS,
    PERIOD_TURNS_LOW,
    SINE,
    TURNS,
    TURNS_LOW,
    UPPER,
    UPPER_ENTRY,
    UPPER_FORCE,
    UPPER_KIND,
    UPPER_RESTITUTION,
    WALL,
    Law,
)
from percuss.kernels.law_formulas import (
    bound_force,
    fill_harmonic,
    fill_motion,
    fill_response,
    fill_steps_of_search,
    less_spring,
    mark_simple,
    period_of,
    phasor,
)
from percuss.kernels.step import fill_steps
from percuss.kernels.triples import Triple, add, divide, multiply, number, rounded

# Columns of row 0. Without a mass its number is 0, and all others are per unit mass; with one the
# damping is c and forces are those on the mass.
GIVEN_STIFFNESS, GIVEN_DAMPING, GIVEN_CONSTANT, GIVEN_MASS = 0, 3, 6, 9
GIVEN_STOPS, GIVEN_HARMONICS, GIVEN_PER_MASS = 12, 13, 14
# Columns of a stop: its position, stiffness and damping; 1 above and -1 below; a wall's
# restitution, and 1 for a wall.
STOP_AT, STOP_STIFFNESS, STOP_DAMPING = 0, 3, 6
STOP_SIDE, STOP_RESTITUTION, STOP_IS_WALL = 12, 13, 14
# Columns of a harmonic: frequency, amplitude, and phase as a multiple of pi and what is added to
# it; 1 where the phase is a double, whose cosine is taken as it is.
WAVE_OMEGA, WAVE_AMPLITUDE, WAVE_TIMES, WAVE_PLUS, WAVE_IS_DOUBLE = 0, 3, 6, 9, 12
GIVEN_COLUMNS = 15


@kernel
def given_number(given: Floats, row: int, column: int) -> Triple:
    """Return an exact number."""
    return given[row, column], given[row, column + 1], given[row, column + 2]


@kernel
def per_mass(given: Floats, value: Triple, times: float) -> Triple:
    """Return a number divided by so many masses where there is one."""
    if given[0, GIVEN_MASS] == 0.0:
        return value
    return divide(value, multiply(number(times), given_number(given, 0, GIVEN_MASS)))


@kernel
def force_per_mass(given: Floats, value: Triple) -> Triple:
    """Return a force divided by the mass, where it is not so already."""
    return value if given[0, GIVEN_PER_MASS] != 0.0 else per_mass(given, value, 1.0)


@kernel
def fill_law(given: Floats, bounds: Integers, law: Law) -> int:
    """Fill the rows of a law; return their number.

    ``law`` has rows for as many regions as there are stops and one more, all 0. ``bounds`` of
    (n_stops + 2,) entries receive the stop at each bound, upwards, -1 for none.
    """
    n_stops = int(given[0, GIVEN_STOPS])
    n = int(given[0, GIVEN_HARMONICS])
    n_regions = find_bounds(given, n_stops, bounds) - 1
    header = law[0]
    header[N_HARMONICS] = n
    header[N_REGIONS] = n_regions
    mass = rounded(given_number(given, 0, GIVEN_MASS))
    header[MASS] = mass if mass != 0.0 else 1.0
    constant = force_per_mass(given, given_number(given, 0, GIVEN_CONSTANT))
    header[FORCING_CONSTANT] = rounded(constant)
    quickest = 0.0
    for j in range(n):
        harmonic = law[FIRST_HARMONIC + j]
        fill_wave(given, 1 + n_stops + j, harmonic)
        bound_force(header, harmonic)
        if harmonic[COSINE] != 0.0 or harmonic[SINE] != 0.0:
            quickest = max(quickest, harmonic[OMEGA])
    if n == 1:
        # Of several harmonics the period is not known.
        header[PERIOD] = period_of(given_number(given, 1 + n_stops, WAVE_OMEGA))
        header[PERIOD_TURNS] = law[FIRST_HARMONIC, TURNS]
        header[PERIOD_TURNS_LOW] = law[FIRST_HARMONIC, TURNS_LOW]
    for region in range(n_regions):
        fill_region(given, bounds, law, region, constant, quickest)
    fill_steps(law)
    return FIRST_HARMONIC + n + n_regions * (1 + n)


@kernel
def find_bounds(given: Floats, n_stops: int, bounds: Integers) -> int:
    """Write the stop at each bound, upwards, -1 at infinity; return the number of bounds.

    Soft stops whose edges are the same double share a bound, that of the first.
    """
    bounds[0] = -1
    upper = -1
    count = 1
    for i in range(n_stops):
        if given[1 + i, STOP_IS_WALL] != 0.0:
            if given[1 + i, STOP_SIDE] < 0.0:
                bounds[0] = i
            else:
                upper = i
            continue
        edge = given[1 + i, STOP_AT]
        k = count
        while k > 1 and given[1 + bounds[k - 1], STOP_AT] >= edge:
            k -= 1
        if k < count and given[1 + bounds[k], STOP_AT] == edge:
            continue
        for later in range(count, k, -1):
            bounds[later] = bounds[later - 1]
        bounds[k] = i
        count += 1
    bounds[count] = upper
    return count + 1


@kernel
def fill_wave(given: Floats, row: int, harmonic: Floats) -> None:
    """Fill the row of a harmonic from its amplitude and phase."""
    amplitude = rounded(force_per_mass(given, given_number(given, row, WAVE_AMPLITUDE)))
    plus = given_number(given, row, WAVE_PLUS)
    if given[row, WAVE_IS_DOUBLE] != 0.0:
        cosine, sine = cosine_sine(plus[0])
    else:
        cosine, sine = phasor(given_number(given, row, WAVE_TIMES), plus)
    # Adding zero turns -0.0 into 0.0.
    cosine = amplitude * cosine + 0.0
    sine = -amplitude * sine + 0.0
    fill_harmonic(harmonic, given_number(given, row, WAVE_OMEGA), cosine, sine)


@kernel
def touches(given: Floats, bounds: Integers, stop: int, region: int) -> bool:
    """Return whether a soft stop is in touch in a region."""
    # Above the edge lie the regions whose lower bound is at it or above it.
    is_above_edge = region > 0 and given[1 + bounds[region], STOP_AT] >= given[1 + stop, STOP_AT]
    return is_above_edge if given[1 + stop, STOP_SIDE] > 0.0 else not is_above_edge


@kernel
def force_at(given: Floats, bounds: Integers, region: int, constant: Triple, x: Triple) -> float:
    """Return the constant force at x: a stop's share is exactly zero at its own edge."""
    stiffness = per_mass(given, given_number(given, 0, GIVEN_STIFFNESS), 1.0)
    force = less_spring(constant, stiffness, x, number(0.0))
    for i in range(int(given[0, GIVEN_STOPS])):
        if given[1 + i, STOP_IS_WALL] == 0.0 and touches(given, bounds, i, region):
            spring = per_mass(given, given_number(given, 1 + i, STOP_STIFFNESS), 1.0)
            force = less_spring(force, spring, x, given_number(given, 1 + i, STOP_AT))
    return rounded(force)


@kernel
def fill_region(
    given: Floats, bounds: Integers, law: Law, region: int, constant: Triple, quickest: float
) -> None:
    """Fill the row of a region and those of its responses."""
    n_stops = int(given[0, GIVEN_STOPS])
    n = int(given[0, GIVEN_HARMONICS])
    first = FIRST_HARMONIC + n + region * (1 + n)
    row = law[first]
    row[NUMBER] = region
    fill_bound(given, bounds, row, region, -1.0)
    fill_bound(given, bounds, row, region + 1, 1.0)
    fill_forces(given, bounds, row, region, constant)
    stiffness = per_mass(given, given_number(given, 0, GIVEN_STIFFNESS), 1.0)
    damping = per_mass(given, given_number(given, 0, GIVEN_DAMPING), 2.0)
    for i in range(n_stops):
        if given[1 + i, STOP_IS_WALL] == 0.0 and touches(given, bounds, i, region):
            spring = per_mass(given, given_number(given, 1 + i, STOP_STIFFNESS), 1.0)
            dashpot = per_mass(given, given_number(given, 1 + i, STOP_DAMPING), 2.0)
            stiffness = add(stiffness, spring)
            damping = add(damping, dashpot)
    fill_motion(row, stiffness, damping)
    fill_steps_of_search(row, quickest)
    for j in range(n):
        omega = given_number(given, 1 + n_stops + j, WAVE_OMEGA)
        fill_response(law[first + 1 + j], stiffness, damping, omega)
    if n == 1:
        mark_simple(row, law[first + 1])


@kernel
def fill_bound(given: Floats, bounds: Integers, row: Floats, bound: int, side: float) -> None:
    """Fill what a region's row has of one of its bounds, the upper one for a side of 1."""
    place, kind, restitution, entry = UPPER, UPPER_KIND, UPPER_RESTITUTION, UPPER_ENTRY
    if side < 0.0:
        place, kind, restitution, entry = LOWER, LOWER_KIND, LOWER_RESTITUTION, LOWER_ENTRY
    stop = bounds[bound]
    if stop < 0:
        row[place] = side * math.inf
        row[kind] = NOTHING
        return
    row[place] = rounded(given_number(given, 1 + stop, STOP_AT))
    if given[1 + stop, STOP_IS_WALL] != 0.0:
        row[kind] = WALL
        row[restitution] = given[1 + stop, STOP_RESTITUTION]
        return
    row[kind] = EDGE
    for i in range(int(given[0, GIVEN_STOPS])):
        is_here = given[1 + i, STOP_AT] == given[1 + stop, STOP_AT]
        if given[1 + i, STOP_IS_WALL] == 0.0 and is_here and given[1 + i, STOP_SIDE] == side:
            row[entry] = 1.0


@kernel
def fill_forces(
    given: Floats, bounds: Integers, row: Floats, region: int, constant: Triple
) -> None:
    """Fill the constant forces of a region at its bounds, and at its point nearest to 0.

    A far bound would cost the digits of the force there.
    """
    origin = number(0.0)
    lower = bounds[region]
    upper = bounds[region + 1]
    if lower >= 0:
        low = given_number(given, 1 + lower, STOP_AT)
        row[LOWER_FORCE] = force_at(given, bounds, region, constant, low)
        if low[0] > 0.0:
            origin = low
    if upper >= 0:
        high = given_number(given, 1 + upper, STOP_AT)
        row[UPPER_FORCE] = force_at(given, bounds, region, constant, high)
        if high[0] < origin[0]:
            origin = high
    row[ORIGIN] = rounded(origin)
    row[ORIGIN_FORCE] = force_at(given, bounds, region, constant, origin)
