"""The oscillator and its forcing in exact rationals, and the regions between the stops."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache

from percuss.errors import ParameterError
from percuss.model.exact import Exact, angle, as_fraction
from percuss.model.expression import Expression, parameters_in
from percuss.model.faults import raise_first
from percuss.model.force_record import ForceRecord
from percuss.model.forcing import Forcing, FourierTerm
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.restitution import RestitutionTable, restitution_knots
from percuss.model.system import System, kind_faults

Angle = tuple[Fraction, Fraction]
# (speed, restitution) in order.
RestitutionKnots = tuple[tuple[Fraction, Fraction], ...]
# Irrational places nearer than this part of their size are not told apart.
TOLD_APART = Fraction(1, 2**300)


@dataclass(frozen=True)
class Tone:
    """A harmonic of the forcing, amplitude cos(omega t + phase), by the paths of its numbers.

    Attributes
    ----------
    omega, amplitude
        Paths of the numbers.
    times
        Multiple of the base frequency that omega is.
    phase
        The phase as ``times * pi + plus``.
    phase_path
        Path of the phase; empty where it is not a parameter.
    """

    omega: str
    amplitude: str
    times: int
    phase: Angle
    phase_path: str = ""


@dataclass(frozen=True)
class Bound:
    """An end of a region: a wall, or the edge of soft stops."""

    path: str
    at: Fraction
    wall: int | None
    edges: tuple[int, ...]


@dataclass(frozen=True)
class Region:
    """A stretch of the line in which one linear equation holds; bounds are numbers of bounds."""

    active: tuple[int, ...]
    lower: int | None
    upper: int | None


@dataclass(frozen=True)
class BallSystem:
    """An oscillator and its forcing, every number exact.

    Attributes
    ----------
    oscillator, forcing
        As they were given.
    numbers
        The numbers by their paths; those of unit mass.
    tones
        The harmonics of the forcing.
    bounds, regions
        From below to above.
    moved
        The path of a number that stands for all values between two, and these; or None. What else
        depends on it, such as the order of the bounds, is that of ``numbers``.
    irrational
        Expressions that are no rational numbers, by their paths; ``numbers`` are next to them.
    record
        The record of the forcing, per unit mass, or None.
    tables
        Restitutions over the speed, by the numbers of their walls.
    """

    oscillator: Oscillator
    forcing: Forcing | None
    numbers: dict[str, Fraction] = field(repr=False)
    tones: tuple[Tone, ...]
    bounds: tuple[Bound, ...]
    regions: tuple[Region, ...]
    moved: tuple[str, Fraction, Fraction] | None = None
    irrational: dict[str, Expression] = field(default_factory=dict, repr=False)
    record: ForceRecord | None = None
    tables: dict[int, RestitutionKnots] = field(default_factory=dict, repr=False)

    @property
    def is_exact(self) -> bool:
        """Whether all its numbers are those of ``numbers``, exactly."""
        return self.moved is None and not self.irrational

    def frequency(self, tone: Tone) -> Fraction:
        """Return the exact angular frequency of a tone."""
        return tone.times * self.numbers[tone.omega]

    def strength(self, tone: Tone) -> Fraction:
        """Return the exact amplitude of a tone."""
        return self.numbers[tone.amplitude]

    def stiffness(self, region: Region) -> Fraction:
        """Return the stiffness of the oscillator and of the stops that act."""
        return self._sum(region, "stiffness")

    def damping(self, region: Region) -> Fraction:
        """Return the damping of the oscillator and of the stops that act."""
        return self._sum(region, "damping")

    def constant(self, region: Region) -> Fraction:
        """Return the constant force, with the force at x = 0 of the stops that act."""
        paths = (f"oscillator.stops.{i}" for i in region.active)
        springs = sum(self.numbers[f"{p}.stiffness"] * self.numbers[f"{p}.at"] for p in paths)
        return self.numbers["forcing.constant"] + springs

    def is_equilibrium(self, region: Region, x: Fraction) -> bool:
        """Return whether constant force and springs of a region cancel at a place, exactly."""
        return self.stiffness(region) * x == self.constant(region)

    def _sum(self, region: Region, name: str) -> Fraction:
        own = self.numbers[f"oscillator.{name}"]
        return own + sum(self.numbers[f"oscillator.stops.{i}.{name}"] for i in region.active)


def system_of(osc: Oscillator, force: Forcing | None) -> BallSystem:
    """Return the exact system of an oscillator under a forcing (None: free motion).

    Raises
    ------
    ParameterError
        If they are no oscillator and no forcing, irrational places of stops are not told apart, a
        number may be zero or not, or a sample of a record is an expression.
    """
    raise_first(kind_faults(osc, force))
    return _system_of(osc, force)


@lru_cache(maxsize=64)
def _system_of(osc: Oscillator, force: Forcing | None) -> BallSystem:
    parameters_in(osc, force)  # one name has one value
    unit, push = System(osc, force).of_unit_mass
    numbers = _Numbers(
        {
            "oscillator.stiffness": unit.stiffness,
            "oscillator.damping": unit.damping,
            "forcing.constant": push.constant if push is not None else 0,
        }
    )
    tables = {}
    for i, stop in enumerate(unit.stops):
        names = ["at", "restitution"] if isinstance(stop, Wall) else ["at", "stiffness", "damping"]
        if isinstance(stop, Wall) and isinstance(stop.restitution, RestitutionTable):
            tables[i] = restitution_knots(stop.restitution)
            names.remove("restitution")
        for name in names:
            numbers.add(f"oscillator.stops.{i}.{name}", getattr(stop, name))
    tones = _tones(push, numbers) if push is not None else ()
    record = None if push is None else _record(push, numbers)
    exact = numbers.exact
    _check_places(osc, numbers)
    bounds = _bounds(osc, exact)
    regions = _regions(osc, exact, bounds)
    return BallSystem(
        osc,
        force,
        exact,
        tones,
        bounds,
        regions,
        irrational=numbers.irrational,
        record=record,
        tables=tables,
    )


def check_told_apart(name: str, value: Exact, other: Exact) -> None:
    """Raise a ParameterError where balls cannot tell a place from another, and it is not the same."""
    x, y = as_fraction(value), as_fraction(other)
    inexact = any(isinstance(v, Expression) and not v.is_exact for v in (value, other))
    if inexact and value != other and abs(x - y) <= TOLD_APART * max(abs(x), abs(y)):
        raise ParameterError(name, value, f"not told from {other} by 300 bits; write both alike")


def _check_places(osc: Oscillator, numbers: _Numbers) -> None:
    if any(path.endswith(".at") for path in numbers.irrational):
        for (i, stop), (_, other) in itertools.combinations(enumerate(osc.stops), 2):
            check_told_apart(f"oscillator.stops.{i}.at", stop.at, other.at)


def _record(force: Forcing, numbers: _Numbers) -> ForceRecord | None:
    record = force.record
    if record is None:
        return None
    for name in ("t", "f"):
        for i, value in enumerate(getattr(record, name)):
            if isinstance(value, Expression):
                reason = "an expression; a proof needs samples that are numbers"
                raise ParameterError(f"forcing.record.{name}.{i}", value, reason)
    numbers.add("forcing.record.amplitude", record.amplitude)
    if record.omega is not None:
        numbers.add("forcing.record.omega", record.omega)
    return record


class _Numbers:
    """The numbers of a system by their paths, and which of them are irrational."""

    def __init__(self, given: dict[str, Exact]) -> None:
        self.exact: dict[str, Fraction] = {}
        self.irrational: dict[str, Expression] = {}
        for path, value in given.items():
            self.add(path, value)

    def add(self, path: str, value: Exact) -> None:
        """Add a number."""
        number = self.exact[path] = as_fraction(value)
        if not isinstance(value, Expression) or (value.is_exact and not value.angle()[0]):
            return
        if number == 0:
            raise ParameterError(path, value, "not told from 0 by 4800 bits")
        self.irrational[path] = value


def _tones(force: Forcing, numbers: _Numbers) -> tuple[Tone, ...]:
    tones = []
    if force.base is not None:
        numbers.add("forcing.omega", force.base)
    for i, part in enumerate(force.harmonics):
        if isinstance(part, FourierTerm):
            turns = {"cos": Fraction(0), "sin": Fraction(-1, 2)}
            for name, times in turns.items():
                path = f"forcing.{name}.{i}"
                numbers.add(path, getattr(part, name))
                # An expression that is 0 here need not be so where its parameter moves.
                if numbers.exact[path] != 0 or isinstance(getattr(part, name), Expression):
                    tones.append(Tone("forcing.omega", path, part.n, (times, Fraction(0))))
            continue
        path = f"forcing.harmonics.{i}"
        numbers.add(f"{path}.omega", part.omega)
        numbers.add(f"{path}.amplitude", part.amplitude)
        phase = f"{path}.phase"
        if isinstance(part.phase, Expression) and not part.phase.is_exact:
            numbers.irrational[phase] = part.phase
        tones.append(Tone(f"{path}.omega", f"{path}.amplitude", 1, angle(part.phase), phase))
    return tuple(tones)


def _bounds(osc: Oscillator, numbers: dict[str, Fraction]) -> tuple[Bound, ...]:
    places = [numbers[f"oscillator.stops.{i}.at"] for i in range(len(osc.stops))]
    walls = {stop.side: i for i, stop in enumerate(osc.stops) if isinstance(stop, Wall)}
    low = places[walls["below"]] if "below" in walls else None
    high = places[walls["above"]] if "above" in walls else None
    bounds = []
    for at in sorted(set(places)):
        if (low is not None and at < low) or (high is not None and at > high):
            continue
        wall = next((i for i in walls.values() if places[i] == at), None)
        edges = tuple(
            i for i, stop in enumerate(osc.stops) if isinstance(stop, SoftStop) and places[i] == at
        )
        stop = wall if wall is not None else edges[0]
        bounds.append(Bound(f"oscillator.stops.{stop}.at", at, wall, edges if wall is None else ()))
    return tuple(bounds)


def _regions(
    osc: Oscillator, numbers: dict[str, Fraction], bounds: tuple[Bound, ...]
) -> tuple[Region, ...]:
    walls = [i for i, bound in enumerate(bounds) if bound.wall is not None]
    sides = {i: osc.stops[bounds[i].wall or 0].side for i in walls}
    first = next((i for i in walls if sides[i] == "below"), None)
    last = next((i for i in walls if sides[i] == "above"), None)
    inner = [i for i, bound in enumerate(bounds) if bound.wall is None]
    ends: list[int | None] = [first, *inner, last]
    regions = []
    for lower, upper in itertools.pairwise(ends):
        active = tuple(
            i
            for i, stop in enumerate(osc.stops)
            if isinstance(stop, SoftStop)
            and _acts(stop, numbers[f"oscillator.stops.{i}.at"], bounds, lower, upper)
        )
        regions.append(Region(active, lower, upper))
    return tuple(regions)


def _acts(
    stop: SoftStop, at: Fraction, bounds: tuple[Bound, ...], lower: int | None, upper: int | None
) -> bool:
    """Return whether a soft stop acts in a region, which no edge of a stop divides."""
    if stop.side == "above":
        return lower is not None and bounds[lower].at >= at
    return upper is not None and bounds[upper].at <= at
