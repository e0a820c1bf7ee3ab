"""An oscillator under a forcing as one value, and its law: where exact values become floats.

Every entry of the law is computed in exact rationals and rounded once, by the formulas of
`percuss.kernels.law_formulas`. Rates of phase are kept as pairs of floats, so that a phase after a
million periods has all its digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import NamedTuple, cast

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels import law_formulas
from percuss.kernels.law_columns import Law
from percuss.kernels.step import fill_steps
from percuss.model.exact import Exact, Phase, PiTimes, as_fraction, rational
from percuss.model.expression import parameters_in
from percuss.model.faults import Fault, raise_first
from percuss.model.force_record import ForceRecord
from percuss.model.forcing import Component, Forcing, Harmonic
from percuss.model.oscillator import Oscillator, Side, SoftStop, Wall, mass_of
from percuss.model.ratios import Ratio, exact, ratio_of
from percuss.model.restitution import (
    Restitution,
    RestitutionTable,
    restitution_at_rest,
    restitution_knots,
)
from percuss.model.start import late_problem

# The formulas of the rows, in exact rationals.
_turns_per_time = exact(law_formulas.turns_per_time)
_fill_harmonic = exact(law_formulas.fill_harmonic)
_bound_force = exact(law_formulas.bound_force)
_less_spring = exact(law_formulas.less_spring)
_fill_motion = exact(law_formulas.fill_motion)
_fill_steps_of_search = exact(law_formulas.fill_steps_of_search)
_fill_response = exact(law_formulas.fill_response)
_mark_simple = exact(law_formulas.mark_simple)


@dataclass(frozen=True)
class RegionBounds:
    """The bounds of the regions, upwards, and which stops lie at each.

    ``at[i]`` is None at infinity; ``wall[i]`` is the index of the wall there or None;
    ``edges[i]`` are the indices of the soft stops there.
    """

    at: tuple[Fraction | None, ...]
    wall: tuple[int | None, ...]
    edges: tuple[tuple[int, ...], ...]

    @cached_property
    def walls(self) -> Integers:
        """The index of the wall at each bound, -1 where there is none, as an (n_bounds,) array."""
        return np.array([-1 if wall is None else wall for wall in self.wall], dtype=np.int64)


class _SystemFields(NamedTuple):
    oscillator: Oscillator
    forcing: Forcing | None


class System(_SystemFields):
    """An oscillator and what drives it.

    Parameters
    ----------
    oscillator
        Mass, spring, dashpot and stops.
    forcing
        None for free motion.

    Examples
    --------
    >>> import percuss as pc
    >>> system = System(pc.impact_oscillator("0.8", wall=0), pc.cosine("2.8"))
    >>> round(system.period, 6), len(system.lines.at)
    (2.243995, 2)
    """

    def __getstate__(self) -> None:
        """Return that a pickle holds the two fields alone."""

    @classmethod
    def of(cls, osc: object, force: object) -> System:
        """Return the system of a caller's two arguments; ParameterError for another type."""
        raise_first(kind_faults(osc, force))
        assert isinstance(osc, Oscillator)
        assert force is None or isinstance(force, Forcing)
        return cls(osc, force)

    # To find the law of equal values by their hash takes as long as several impacts.
    @cached_property
    def law(self) -> Law:
        """The numbers of the equation of motion, each rounded once; made once for equal systems."""
        return law(self.oscillator, self.forcing)

    @cached_property
    def of_unit_mass(self) -> System:
        """The oscillator and the forcing divided by the mass; itself without one."""
        if self.oscillator.mass is None:
            return self
        return System(*_of_unit_mass(self.oscillator, self.forcing))

    @property
    def mass(self) -> float:
        """What forces per unit mass are multiplied by: the mass, or 1 without one."""
        return float(self.law[0, at.MASS])

    @cached_property
    def lines(self) -> RegionBounds:
        """The bounds of the regions between the stops."""
        return lines(self.oscillator)

    @property
    def period(self) -> float | None:
        """The period of the forcing [time]; None without one."""
        return None if self.forcing is None else self.forcing.period


# The functions that take one.
NO_STRUCTURE = (
    "this takes oscillators alone; structures are taken by simulate, gradient, fit, find_orbit, "
    "find_orbits, continue_orbit, continue_curve, switch_branch, response_curve, sweep, "
    "bifurcation_diagram, basins, basin_fractions, lyapunov_exponents and explore"
)


def kind_faults(osc: object, force: object) -> list[Fault]:
    """Return the faults of arguments that are no oscillator and no forcing."""
    # By its name: the module of structures is loaded where there are some.
    if type(osc).__name__ == "Structure":
        return [Fault("osc", "a structure", NO_STRUCTURE)]
    if not isinstance(osc, Oscillator):
        return [Fault("osc", osc, "not an Oscillator; impact_oscillator() makes one")]
    if force is None or isinstance(force, Forcing):
        return []
    if isinstance(force, Harmonic):
        return [Fault("force", force, "not a Forcing; give Forcing((harmonic,))")]
    return [Fault("force", force, "not a Forcing; cosine(2) makes one, and forcings can be added")]


@lru_cache(maxsize=256)
def lines(oscillator: Oscillator) -> RegionBounds:
    """Return the bounds at which the oscillator's stops cut the line."""
    lower: tuple[Fraction | None, int | None] = (None, None)
    upper: tuple[Fraction | None, int | None] = (None, None)
    edges: dict[Fraction, list[int]] = {}
    for i, stop in enumerate(oscillator.stops):
        at = as_fraction(stop.at)
        if isinstance(stop, SoftStop):
            # Stops that become the same double, as "0.2" and 0.2 do, share an edge.
            same = [edge for edge in edges if float(edge) == float(at)]
            edges.setdefault(same[0] if same else at, []).append(i)
        elif stop.side == "below":
            lower = (at, i)
        else:
            upper = (at, i)
    inner = sorted(edges)
    return RegionBounds(
        at=(lower[0], *inner, upper[0]),
        wall=(lower[1], *(None for _ in inner), upper[1]),
        edges=((), *(tuple(edges[at]) for at in inner), ()),
    )


@lru_cache(maxsize=256)
def law(oscillator: Oscillator, forcing: Forcing | None) -> Law:
    """Return the law of an oscillator under a forcing (None: free motion)."""
    # One name has one value, in each of them and in both.
    own, others = _parameters_of(oscillator), _parameters_of(forcing)
    if own and others:
        parameters_in(oscillator, forcing)
    mass = mass_of(oscillator)
    oscillator, forcing = _of_unit_mass(oscillator, forcing)
    components = forcing.components() if forcing is not None else ()
    record = forcing.record if forcing is not None else None
    constant = as_fraction(forcing.constant) if forcing is not None else Fraction(0)
    bounds = lines(oscillator)
    n, n_regions = len(components) + (record is not None), len(bounds.at) - 1
    walls = [stop for stop in oscillator.stops if isinstance(stop, Wall)]
    tables = {wall.side: wall.restitution for wall in walls if _has_table(wall)}
    first_of_tables = at.FIRST_HARMONIC + n + n_regions * (1 + n)
    first_of_record = first_of_tables + sum(
        len(restitution_knots(restitution)) for restitution in tables.values()
    )
    n_knots = 0 if record is None else len(record.t) - record.repeat
    rows = np.zeros((first_of_record + -(-n_knots // at.KNOTS_A_ROW), at.COLUMNS))
    forced = _forcing_rows(forcing)
    rows[: len(forced)] = forced
    rows[0, at.N_REGIONS] = n_regions
    rows[0, at.MASS] = 1.0 if mass is None else mass
    rows[0, at.FORCING_CONSTANT] = float(constant)
    if record is not None:
        rows[0, at.N_HARMONICS], rows[0, at.FIRST_KNOT] = n, first_of_record
        _fill_record(rows, record)
    places = _fill_tables(rows, tables, first_of_tables)
    # A harmonic of zero amplitude does not shorten the step.
    quickest = max((float(c.omega) for c in components if c.cos or c.sin), default=0.0)
    for number in range(n_regions):
        first = at.FIRST_HARMONIC + n + number * (1 + n)
        row, stiffness, damping = _region_row(oscillator, constant, number)
        rows[first] = row
        for kind, column, wall in _WALLS:
            if wall in places and row[kind] == at.WALL:
                rows[first, column] = places[wall]
        _fill_steps_of_search(rows[first], quickest)
        if record is not None and rows[first, at.STEP] == 0.0:
            # No rate sets a step: the motion is a cubic on each piece.
            rows[first, at.STEP] = 1.0 / record.rate
        for j, component in enumerate(components):
            fill_response(rows[first + 1 + j], stiffness, damping, component.omega)
        if record is None and n == 1:
            _mark_simple(rows[first], rows[first + 1])
    fill_steps(rows)
    return rows


def turns_of(law: Law) -> tuple[list[float], list[float]]:
    """Return the turns in a unit of time of the free motion in each region, and of the force.

    Those of the force are of each harmonic and of a repeated record.

    Examples
    --------
    >>> from percuss.model import sine
    >>> [2 * math.pi * turns for (turns,) in turns_of(law(Oscillator(4), sine(3)))]
    [2.0, 3.0]
    """
    n, rows = int(law[0, at.N_HARMONICS]), region_rows(law)
    # As a slice the rows are no copy.
    halves = law[rows.start : rows.stop : rows.step, at.HALF_TURNS]
    driven = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n, at.TURNS].tolist()
    repeat = float(law[0, at.REPEAT])
    if repeat > 0.0:
        driven.append(1.0 / repeat)
    return [2.0 * half for half in halves.tolist()], driven


def most_turns(law: Law) -> float:
    """Return the most turns in a unit of time, of free motion or of the force."""
    free, driven = turns_of(law)
    return max(free + driven)


def check_phases(law: Law, t0: float, t_end: float) -> float:
    """Return the most turns in a unit of time, where phases have digits left at both times.

    Raises
    ------
    ParameterError
        If they have none at one of them.
    """
    fastest = most_turns(law)
    for name, time in (("t0", t0), ("t_end", t_end)):
        problem = late_problem(time, fastest) if abs(time) < math.inf else None
        if problem is not None:
            raise ParameterError(name, time, problem)
    return fastest


@lru_cache(maxsize=256)
def _parameters_of(part: Oscillator | Forcing | None) -> dict[str, Phase]:
    return parameters_in(part)


def _of_unit_mass(
    oscillator: Oscillator, forcing: Forcing | None
) -> tuple[Oscillator, Forcing | None]:
    force = None if forcing is None else forcing.acceleration_of(oscillator.mass)
    return oscillator.of_unit_mass(), force


def region_rows(rows: Law) -> range:
    """Return the rows of the regions of a law, upwards."""
    n, n_regions = int(rows[0, at.N_HARMONICS]), int(rows[0, at.N_REGIONS])
    first = at.FIRST_HARMONIC + n
    return range(first, first + n_regions * (1 + n), 1 + n)


def _fill_record(rows: Law, record: ForceRecord) -> None:
    """Fill the row of a record and its knots (`kernels.pieces`)."""
    samples = _exact_samples(record)
    knots = _knots(record, samples)
    header = rows[0]
    header[at.N_KNOTS] = len(knots)
    if not record.repeat and record.outside == "end":
        header[at.OUTSIDE_FORCE] = knots[0, at.KNOT_FORCE]
    if record.repeat:
        (first, _), (last, _) = samples[0], samples[-1]
        length = Fraction(*last) - Fraction(*first)
        header[at.REPEAT], header[at.REPEAT_LOW] = _pair(length.numerator, length.denominator)
    behind = int(header[at.FIRST_KNOT])
    for k in range(at.KNOTS_A_ROW):
        some = knots[k :: at.KNOTS_A_ROW]
        columns = slice(at.KNOT_ENTRIES * k, at.KNOT_ENTRIES * (k + 1))
        rows[behind : behind + len(some), columns] = some
    row = rows[at.FIRST_HARMONIC + int(header[at.N_HARMONICS]) - 1]
    row[at.COSINE], row[at.OMEGA] = 1.0, at.RECORD_OMEGA
    # A linear force is largest at the ends of its pieces.
    row[at.AMPLITUDE] = max(abs(f[0] / f[1]) for _, f in samples)
    header[at.FORCE_BOUND] += row[at.AMPLITUDE]
    header[at.FORCE_BOUND + 1] += np.abs(knots[:, at.KNOT_SLOPE]).max()


def _exact_samples(record: ForceRecord) -> list[tuple[Ratio, Ratio]]:
    """Return instants and forces of a record, exactly."""
    pace = Fraction(1) if record.omega is None else as_fraction(record.omega)
    amplitude = as_fraction(record.amplitude)
    (a, b), (c, d) = pace.as_integer_ratio(), amplitude.as_integer_ratio()
    return [((p * b, q * a), (m * c, n * d)) for (p, q), (m, n) in record.exact_samples]


def _knots(record: ForceRecord, samples: list[tuple[Ratio, Ratio]]) -> Floats:
    """Return instant, its low part, force and slope of each knot, (n, 4), each rounded once."""
    knots = np.zeros((len(samples), at.KNOT_ENTRIES))
    for knot, (t, f) in zip(knots, samples, strict=True):
        knot[at.KNOT_T], knot[at.KNOT_T_LOW] = _pair(*t)
        knot[at.KNOT_FORCE] = f[0] / f[1]
    if record.kind == "linear":
        for knot, ((p, q), (m, d)), ((p1, q1), (m1, d1)) in zip(
            knots[:-1], samples[:-1], samples[1:], strict=True
        ):
            knot[at.KNOT_SLOPE] = (m1 * d - m * d1) * q * q1 / ((p1 * q - p * q1) * d * d1)
    if record.repeat:
        return knots[:-1]
    if record.outside == "zero":
        knots[-1, at.KNOT_FORCE] = 0.0
    return knots


def _pair(numerator: int, denominator: int) -> tuple[float, float]:
    """Return a rational as the sum of two floats, each rounded once.

    Division of integers is correctly rounded in Python, whatever they have in common: without
    the reduction to lowest terms that a `Fraction` makes this takes a tenth of the time.
    """
    high = numerator / denominator
    p, q = high.as_integer_ratio()
    return high, (numerator * q - p * denominator) / (denominator * q)


def turns_per_time(value: Fraction, halves: int) -> tuple[float, float]:
    """Return a rate over so many times pi as the sum of two floats."""
    high, low = _turns_per_time(ratio_of(value), float(halves))
    return high, low


@lru_cache(maxsize=256)
def stop_rows(oscillator: Oscillator) -> Floats:
    """Return the stops of an oscillator as the loads take them, (n_stops, columns), per unit mass."""
    unit, bounds = oscillator.of_unit_mass(), lines(oscillator)
    rows = np.zeros((len(unit.stops), at.STOP_COLUMNS))
    for i, stop in enumerate(unit.stops):
        row = rows[i]
        row[at.STOP_AT] = float(as_fraction(stop.at))
        # No region; a soft stop acts on one side of its edge.
        row[at.STOP_FIRST], row[at.STOP_LAST] = 1.0, 0.0
        row[at.STOP_BOUND] = -1.0 if isinstance(stop, SoftStop) else float(bounds.wall.index(i))
        if isinstance(stop, SoftStop):
            row[at.STOP_STIFFNESS] = float(as_fraction(stop.stiffness))
            row[at.STOP_DRAG] = 2.0 * float(as_fraction(stop.damping))
            acting = [k for k in range(len(bounds.at) - 1) if i in touching_stops(oscillator, k)]
            row[at.STOP_FIRST], row[at.STOP_LAST] = acting[0], acting[-1]
    return rows


@dataclass(frozen=True, slots=True)
class _Region:
    """One region: the oscillator, the stops in touch, and the K and a of them together."""

    number: int
    oscillator: Oscillator
    touched: tuple[SoftStop, ...]
    stiffness: Fraction
    damping: Fraction

    def force_at(self, constant: Fraction, x: Fraction) -> float:
        """Return the constant force at x: a stop's share is exactly zero at its own edge."""
        force, place = ratio_of(constant), ratio_of(x)
        force = _less_spring(force, _given(self.oscillator.stiffness), place, (0, 1))
        for stop in self.touched:
            force = _less_spring(force, _given(stop.stiffness), place, _given(stop.at))
        return float(force[0] / force[1])


def _given(value: Exact) -> Ratio:
    return ratio_of(as_fraction(value))


@lru_cache(maxsize=256)
def _region_row(
    oscillator: Oscillator, constant: Fraction, number: int
) -> tuple[Floats, Fraction, Fraction]:
    """Return what a region's row holds whatever the harmonics are, and its K and a."""
    bounds = lines(oscillator)
    region = _region(oscillator, number)
    row = np.zeros(at.COLUMNS)
    _fill_bounds(row, oscillator, bounds, number)
    _fill_forces(row, region, bounds, constant)
    fill_motion(row, region.stiffness, region.damping)
    return row, region.stiffness, region.damping


def _region(oscillator: Oscillator, number: int) -> _Region:
    stops = [oscillator.stops[k] for k in touching_stops(oscillator, number)]
    touched = [stop for stop in stops if isinstance(stop, SoftStop)]
    stiffness = sum((as_fraction(s.stiffness) for s in touched), as_fraction(oscillator.stiffness))
    damping = sum((as_fraction(s.damping) for s in touched), as_fraction(oscillator.damping))
    return _Region(number, oscillator, tuple(touched), stiffness, damping)


def touching_stops(oscillator: Oscillator, number: int) -> tuple[int, ...]:
    """Return the indices of the soft stops that are in touch in a region, by its number."""
    return tuple(
        k
        for i, edges in enumerate(lines(oscillator).edges)
        for k in edges
        if (number >= i if oscillator.stops[k].side == "above" else number < i)
    )


@lru_cache(maxsize=256)
def _forcing_rows(forcing: Forcing | None) -> Floats:
    """Return what the header and the rows of harmonics have of a forcing, whatever it acts on."""
    components = () if forcing is None else forcing.components()
    rows = np.zeros((at.FIRST_HARMONIC + len(components), at.COLUMNS))
    header, harmonics = rows[0], rows[at.FIRST_HARMONIC :]
    for row, component in zip(harmonics, components, strict=True):
        fill_harmonic(row, component)
    header[at.N_HARMONICS] = len(harmonics)
    with np.errstate(over="ignore"):
        for harmonic in harmonics:
            _bound_force(header, harmonic)
    if forcing is not None:
        _fill_period(header, forcing)
    return rows


def _fill_period(row: Floats, forcing: Forcing) -> None:
    period = forcing.period
    if period is None:
        return
    row[at.PERIOD] = period
    frequency = forcing.frequency
    if frequency is None and forcing.record is not None:
        whole = rational(cast("PiTimes", forcing.exact_period))
        row[at.PERIOD_TURNS], row[at.PERIOD_TURNS_LOW] = _pair(whole.denominator, whole.numerator)
    elif frequency is None:
        p, q = period.as_integer_ratio()
        row[at.PERIOD_TURNS], row[at.PERIOD_TURNS_LOW] = _pair(q, p)
    else:
        row[at.PERIOD_TURNS], row[at.PERIOD_TURNS_LOW] = turns_per_time(frequency, 2)


def fill_harmonic(row: Floats, component: Component) -> None:
    """Fill the row of a harmonic."""
    _fill_harmonic(row, ratio_of(component.omega), component.cos, component.sin)


def _fill_bounds(row: Floats, oscillator: Oscillator, bounds: RegionBounds, number: int) -> None:
    columns = (
        (number, at.LOWER, at.LOWER_KIND, at.LOWER_RESTITUTION, -math.inf),
        (number + 1, at.UPPER, at.UPPER_KIND, at.UPPER_RESTITUTION, math.inf),
    )
    entries = ((number, at.LOWER_ENTRY, "below"), (number + 1, at.UPPER_ENTRY, "above"))
    for i, entry, side in entries:
        row[entry] = any(oscillator.stops[k].side == side for k in bounds.edges[i])
    row[at.NUMBER] = number
    for i, place, kind, restitution, infinity in columns:
        position, wall = bounds.at[i], bounds.wall[i]
        row[place] = infinity if position is None else float(position)
        row[kind] = at.NOTHING if position is None else at.EDGE
        if wall is not None:
            stop = oscillator.stops[wall]
            row[kind] = at.WALL
            row[restitution] = (
                restitution_at_rest(stop.restitution) if isinstance(stop, Wall) else 0
            )


def _has_table(wall: Wall) -> bool:
    return isinstance(wall.restitution, RestitutionTable)


# Of the walls of a region: what kind of bound it is, the row of its table, and its side.
_WALLS: tuple[tuple[int, int, Side], ...] = (
    (at.LOWER_KIND, at.LOWER_TABLE, "below"),
    (at.UPPER_KIND, at.UPPER_TABLE, "above"),
)


def _fill_tables(rows: Floats, tables: Mapping[Side, Restitution], knot: int) -> dict[Side, int]:
    """Fill the knots of tables of restitution, from a row on; return the first row of each."""
    places: dict[Side, int] = {}
    for side, table in tables.items():
        places[side] = knot
        knots = restitution_knots(table)
        for i, (speed, value) in enumerate(knots):
            rows[knot, at.KNOT_SPEED], rows[knot, at.KNOT_RESTITUTION] = float(speed), float(value)
            rows[knot, at.KNOTS_LEFT] = len(knots) - 1 - i
            knot += 1
    return places


def _fill_forces(row: Floats, region: _Region, bounds: RegionBounds, constant: Fraction) -> None:
    low, high = bounds.at[region.number], bounds.at[region.number + 1]
    # The point nearest to 0: a far bound would cost the digits of the force here.
    origin = max(Fraction(0), low) if low is not None else Fraction(0)
    origin = min(origin, high) if high is not None else origin
    row[at.ORIGIN], row[at.ORIGIN_FORCE] = float(origin), region.force_at(constant, origin)
    if low is not None:
        row[at.LOWER_FORCE] = region.force_at(constant, low)
    if high is not None:
        row[at.UPPER_FORCE] = region.force_at(constant, high)


def fill_motion(row: Floats, stiffness: Fraction, damping: Fraction) -> None:
    """Fill the rates of the free motion x'' + 2 (damping) x' + (stiffness) x = 0."""
    _fill_motion(row, ratio_of(stiffness), ratio_of(damping))


def fill_response(row: Floats, stiffness: Fraction, damping: Fraction, omega: Fraction) -> None:
    """Fill the row of the response of a free motion to a harmonic."""
    _fill_response(row, ratio_of(stiffness), ratio_of(damping), ratio_of(omega))
