"""The points of a study of many motions: all combinations of the values of parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.ensembles.groups import AnyGroup, Group, StructureGroup, walls_of
from percuss.ensembles.job import Dimension
from percuss.ensembles.threads import check_wanted
from percuss.errors import ParameterError
from percuss.model.acting_sets import StructureSystem, within_walls
from percuss.model.dimensions import dimensions_of, dimensions_of_named
from percuss.model.exact import Phase, as_float, phase_problem, plain, real
from percuss.model.expression import Expression
from percuss.model.faults import check_mapping, is_row
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import On, Oscillator, Wall
from percuss.model.paths import long_form, moved_fields, replace_parameters
from percuss.model.start import BEHIND_A_WALL, MOST_PERIODS, Start, late_problem, start_of
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart, check_start, structure_start
from percuss.model.system import law, most_turns, stop_rows
from percuss.model.units import in_units
from percuss.wording import counted

_OF_START = ("x0", "v0", "t0")
_OWNERS = ("oscillator", "forcing", "start")
_OF_STRUCTURE = ("structure", "loads", "start")
# Name of the dimension of values that are taken together.
SAMPLE = "sample"
# Values that a range (low, high) stands for by default.
POINTS = 101
# What the parts of a grid that were made before may take in memory [bytes].
KEPT_BYTES = 64_000_000
# A start nearer to a wall than this part of its size is compared exactly.
NEARLY_AT = 1e-14


@dataclass(frozen=True, slots=True)
class Axis:
    """A parameter and its values.

    Attributes
    ----------
    path
        Its dotted path in the long form.
    given
        The values as they were given, exact ones included.
    owners
        The parts of a motion that the parameter changes, where it is not the one its path names.
    units
        Its dimension, empty where it is not known; default: that of the last word of the path.
    asked
        The path as it was asked for, which names the dimension; default: the long form.
    along
        The direction (x, v) in which a structure's start moves with it, in place of one number.
    """

    path: str
    given: tuple[Phase, ...]
    owners: tuple[str, ...] = ()
    units: str | None = None
    asked: str = ""
    along: tuple[float, ...] = ()

    @property
    def dimension(self) -> str:
        """Name of its dimension: what was asked for is what it is called."""
        return self.asked or self.path

    @property
    def values(self) -> Floats:
        """(n,) array, the values as floats."""
        return np.array([as_float(value) for value in self.given])

    @property
    def of_start(self) -> bool:
        """Whether it is a number of the start, on which the law does not depend."""
        return self.path.startswith("start.")

    def changes(self, owner: str) -> bool:
        """Return whether the parameter changes a part of a motion."""
        return owner in self.owners or self.path.startswith(f"{owner}.")


class MadeParts:
    """Laws or systems of the points of a grid that were made before, as many as there is room for.

    Each branch of a diagram asks for those of all values again. In another process there are none.
    """

    def __init__(self) -> None:
        self._parts: dict[int, Any] = {}
        self._room = KEPT_BYTES

    def __reduce__(self) -> tuple[type[MadeParts], tuple[()]]:
        return MadeParts, ()

    def get(self, key: int) -> Any:
        """Return what was made for the values with this number, None where it is not kept."""
        return self._parts.get(key)

    def keep(self, key: int, part: Any, size: int) -> None:
        """Keep what was made, where there is room for so many bytes."""
        if size <= self._room and self._parts.setdefault(key, part) is part:
            self._room -= size


def _bytes_of(made: StructureSystem | tuple[Floats, Floats]) -> int:
    """Return the memory that a law or a system takes; one meets a few sets of acting stops."""
    if isinstance(made, StructureSystem):
        return (1 + len(made.structure.stops)) * sum(array.nbytes for array in made.sets)
    return sum(array.nbytes for array in made)


@dataclass(frozen=True, slots=True)
class Grid:
    """All combinations of the values along the axes, the last axis the fastest.

    Attributes
    ----------
    osc, force, start
        The oscillator, forcing and start whose parameters vary; or the structure, its loads, and
        its start.
    axes
        The axes; without axes there is one point.
    on
        The direction c of a structure's displacement y = c . x that is observed.
    is_paired
        Whether the values are taken together in place of all combinations: the first of each axis,
        then the second of each.
    """

    osc: Oscillator | Structure
    force: Forcing | Loads | None
    start: Start | StructureStart
    axes: tuple[Axis, ...] = field(default=())
    on: tuple[float, ...] = ()
    is_paired: bool = False
    _made: MadeParts = field(default_factory=MadeParts, init=False, repr=False, compare=False)

    @property
    def owners(self) -> tuple[str, ...]:
        """What the paths of parameters begin with."""
        return _OF_STRUCTURE if isinstance(self.osc, Structure) else _OWNERS

    @property
    def start_paths(self) -> tuple[str, ...]:
        """The paths of the numbers of the start, in the order of the columns of starts."""
        if not isinstance(self.osc, Structure):
            return tuple(f"start.{name}" for name in _OF_START)
        numbers = [f"start.{name}.{i}" for name in ("x0", "v0") for i in range(self.osc.n)]
        return (*numbers, "start.t0")

    @property
    def direction(self) -> Floats:
        """(n,) array, the direction of a structure's displacement, zeros where none was given."""
        n = self.osc.n if isinstance(self.osc, Structure) else 0
        return np.array(self.on or (0.0,) * n)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each axis, or of samples."""
        counts = tuple(len(axis.given) for axis in self.axes)
        return counts[:1] if self.is_paired else counts

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def n_laws(self) -> int:
        """Number of points that differ in more than the start."""
        counts = [len(axis.given) for axis in self.axes if not axis.of_start]
        return math.prod(counts[:1] if self.is_paired else counts)

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes as the answer has them, or the samples with the parameters along them."""
        each = tuple(
            Dimension(
                axis.dimension,
                tuple(axis.values.tolist()),
                in_units(self.osc.units, self._dimensions_of(axis)),
            )
            for axis in self.axes
        )
        if not self.is_paired:
            return each
        return (Dimension(SAMPLE, tuple(range(self.size)), beside=each),)

    def _dimensions_of(self, axis: Axis) -> str:
        return dimensions_of(axis.path, self.osc, self.force) if axis.units is None else axis.units

    def point(self, i: int) -> tuple[Any, Any, Any]:
        """Return the oscillator, the forcing and the start of a point.

        Raises
        ------
        ParameterError
            If a value is outside its domain.
        """
        return Maker(self).point(self._where(i))

    def motion(self) -> dict[str, str]:
        """Return the oscillator, the forcing and the start in words."""
        parts = (self.osc, self.force, self.start)
        words = {
            name: part.text() if isinstance(part, Structure) else repr(part)
            for name, part in zip(self.owners, parts, strict=True)
        }
        return words | ({"on": repr(self.on)} if self.on else {})

    def identity(self) -> dict[str, object]:
        """Return the grid as JSON can hold it: what was given, exactly."""
        axes = {axis.path: [repr(value) for value in axis.given] for axis in self.axes}
        return {**self.motion(), "over": axes} | ({"paired": True} if self.is_paired else {})

    def words(self, i: int) -> str:
        """Return the values of the axes at a point, in words."""
        where = zip(self.axes, self._where(i), strict=True)
        return ", ".join(f"{axis.dimension} = {axis.given[k]!s}" for axis, k in where)

    def _where(self, i: int) -> tuple[int, ...]:
        return tuple(int(k) for k in self._indices(i))

    def _indices(self, points: int | Integers) -> tuple[Integers, ...]:
        """Return the indices of points along each axis."""
        if self.is_paired:
            return (np.asarray(points),) * len(self.axes)
        return np.unravel_index(points, self.shape) if self.axes else ()

    def groups(self, first: int, last: int) -> tuple[list[AnyGroup], dict[int, str]]:
        """Return the points from first to last in groups, and the faults of points without motion.

        The last is not included, and faults are counted from the first. A term of a Fourier sum
        that becomes zero changes the shape of the law: there is one group for each shape.
        """
        where = self._indices(np.arange(first, last))
        key = np.zeros(last - first, dtype=np.int64)
        paths, numbers = self.start_paths, _start_numbers(self.start)
        starts = np.empty((last - first, len(paths)))
        for column, number in enumerate(numbers):
            starts[:, column] = as_float(number)
        for axis, k in zip(self.axes, where, strict=True):
            if axis.of_start and not axis.along:
                starts[:, paths.index(axis.path)] = axis.values[k]
            elif not axis.along:
                key = k if self.is_paired else key * len(axis.given) + k
        for axis, k in zip(self.axes, where, strict=True):
            if axis.along:
                starts[:, :-1] += axis.values[k][:, np.newaxis] * np.array(axis.along)
        tied = [column for column, number in enumerate(numbers) if isinstance(number, Expression)]
        order = np.argsort(key, kind="stable")
        cuts = np.flatnonzero(np.diff(key[order])) + 1
        groups: dict[tuple[int, ...], list[tuple[Any, Integers]]] = {}
        faults: dict[int, str] = {}
        maker = Maker(self)
        for rows in np.split(order, cuts):
            check_wanted()
            number = int(key[rows[0]])
            made = None if tied else self._made.get(number)
            if made is None:
                try:
                    osc, force, start = maker.point(tuple(int(k[rows[0]]) for k in where))
                    made = _made_of(osc, force)
                    for column in tied:
                        starts[rows, column] = as_float(_start_numbers(start)[column])
                except ParameterError as error:
                    faults |= {int(row): str(error) for row in rows}
                    continue
                self._made.keep(number, made, _bytes_of(made))
            shape = made.shape if isinstance(made, StructureSystem) else made[0].shape
            groups.setdefault(shape, []).append((made, rows))
        joined = [self._group_of(group, starts, faults) for group in groups.values()]
        return [group for group in joined if len(group.rows)], faults

    def _group_of(
        self, group: list[tuple[Any, Integers]], starts: Floats, faults: dict[int, str]
    ) -> AnyGroup:
        """Return the motions of one shape, and add the faults of starts inside a wall."""
        rows = np.concatenate([rows for _, rows in group])
        which = np.repeat(np.arange(len(group)), [len(rows) for _, rows in group])
        if not isinstance(self.osc, Structure):
            laws = np.stack([own_law for (own_law, _), _ in group])
            stops = np.stack([own_stops for (_, own_stops), _ in group])
            inside = _between(laws, which, rows, starts, faults)
            inside &= _in_time(laws, which, rows, starts, faults)
            return Group(laws, which[inside], starts[rows[inside]], rows[inside], stops)
        systems = tuple(system for system, _ in group)
        inside = off_the_walls(systems, which, rows, starts, faults)
        own = starts[rows[inside]]
        return StructureGroup(systems, which[inside], own, rows[inside], self.direction)


def _made_of(osc: Any, force: Any) -> StructureSystem | tuple[Floats, Floats]:
    """Return the system of a structure, or the law of an oscillator and the rows of its stops."""
    if isinstance(osc, Structure):
        return StructureSystem(osc, loads_of(osc, force))
    return law(osc, force), stop_rows(osc)


class Maker:
    """Makes the oscillators, forcings and starts of a grid, each different one once."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._made: dict[tuple[str, tuple[int, ...]], Any] = {}

    def point(self, where: tuple[int, ...]) -> tuple[Any, Any, Any]:
        """Return the oscillator, the forcing and the start at these indices of the axes."""
        first, second, third = (self._part(owner, where) for owner in self._grid.owners)
        return first, second, third

    def _part(self, owner: str, where: tuple[int, ...]) -> Any:
        grid = self._grid
        own = [i for i, axis in enumerate(grid.axes) if axis.changes(owner)]
        if not own:
            return (grid.osc, grid.force, grid.start)[grid.owners.index(owner)]
        key = owner, tuple(where[i] for i in own)
        if key not in self._made:
            changes = {
                grid.axes[i].path: grid.axes[i].given[where[i]]
                for i in own
                if not grid.axes[i].along
            }
            all_parts = replace_parameters(grid.osc, grid.force, grid.start, changes)
            self._made[key] = all_parts[grid.owners.index(owner)]
        return self._made[key]


def _start_numbers(start: Start | StructureStart) -> tuple[Phase, ...]:
    """Return the numbers of a start, in the order of its paths."""
    if isinstance(start, Start):
        return start.x0, start.v0, start.t0
    return (*start.x0, *start.v0, start.t0)


def _between(
    laws: Floats, which: Integers, rows: Integers, starts: Floats, faults: dict[int, str]
) -> Flags:
    """Return which starts lie between the walls of their laws, and add the faults of the others."""
    low, high = (walls[which] for walls in walls_of(laws))
    x0 = starts[rows, 0]
    for outside, side, wall in ((x0 < low, "below", low), (x0 > high, "above", high)):
        for i in np.flatnonzero(outside):
            reason = f"{side} the wall at x = {wall[i]}; {BEHIND_A_WALL}"
            faults[int(rows[i])] = f"x0 = {x0[i]}: {reason}"
    return np.asarray(~((x0 < low) | (x0 > high)))


def _in_time(
    laws: Floats, which: Integers, rows: Integers, starts: Floats, faults: dict[int, str]
) -> Flags:
    """Return which starts are no later than phases are exact, and add the faults of the others."""
    t0 = starts[rows, 2]
    if not t0.any():
        return np.ones(len(rows), dtype=np.bool_)
    fastest = np.array([most_turns(own_law) for own_law in laws])[which]
    late = np.abs(t0) * fastest > MOST_PERIODS
    for i in np.flatnonzero(late):
        faults[int(rows[i])] = f"t0 = {t0[i]}: {late_problem(t0[i], fastest[i])}"
    return np.asarray(~late)


def off_the_walls(
    systems: Sequence[StructureSystem],
    which: Integers,
    rows: Integers,
    starts: Floats,
    faults: dict[int, str],
) -> Flags:
    """Return which starts lie behind no wall of their systems, and add the faults of the others.

    Those that rounding has put behind a wall are moved to it, as `simulate` does.
    """
    inside = np.ones(len(rows), dtype=np.bool_)
    for k, system in enumerate(systems):
        structure = system.structure
        own = np.flatnonzero(which == k)
        x = starts[rows[own], : structure.n]
        near = np.zeros(len(own), dtype=np.bool_)
        for i, stop in enumerate(structure.stops):
            if isinstance(stop, Wall):
                c, place = structure.stop_directions[i], as_float(stop.at)
                clearance = system.signs[i] * ((x * c).sum(axis=1) - place)
                # What may be rounding is told exactly.
                size = (np.abs(x) * np.abs(c)).sum(axis=1) + abs(place)
                near |= clearance <= NEARLY_AT * size
        for i in own[near].tolist():
            numbers = starts[rows[i]].tolist()
            n = structure.n
            try:
                check_start(structure, numbers[:n], numbers[n : 2 * n], numbers[2 * n])
            except ParameterError as error:
                inside[i] = False
                faults[int(rows[i])] = str(error)
                continue
            starts[rows[i], : 2 * n] = within_walls(structure, starts[rows[i], : 2 * n])
    return inside


def make_grid(
    osc: Oscillator | Structure,
    force: Forcing | Loads | None,
    start: object,
    over: Mapping[str, object],
    points: int = POINTS,
    on: On | None = None,
    *,
    paired: bool = False,
) -> Grid:
    """Return the grid of the parameters in ``over``, with all its axes checked.

    Parameters
    ----------
    osc, force
        The oscillator and the forcing.
    start
        Where the motion starts: a `Start`, or x0, v0 and optionally t0; None is x0 = v0 = 0.
    over
        By path, a range (low, high) or values; a path of the start may be among them, and a tuple
        of 2 n numbers, along which the x0 and v0 of a structure move. As values, a tuple of two
        numbers is a range, any other sequence are values.
    points
        Number of equally spaced values of a range; its ends are kept as they were given.
    on
        The coordinate, direction or point of a structure whose displacement is observed; None for
        the only coordinate, or where none is asked for.
    paired
        Whether the values are taken together, in place of all combinations.

    Raises
    ------
    ParameterError
        If there is no such path, one is named twice, an axis is empty or not finite, or axes that
        are taken together differ in their numbers of values.

    Examples
    --------
    >>> from percuss.model import cosine, impact_oscillator
    >>> grid = make_grid(impact_oscillator(), cosine(2), (0, 1), {"forcing.omega": (2, 2.5, 3)})
    >>> grid.shape, grid.axes[0].path
    ((3,), 'forcing.harmonics.0.omega')
    >>> make_grid(impact_oscillator(), cosine(2), (0, 1), {"forcing.omega": (2, 3)}).shape
    (101,)
    """
    check_mapping("over", over, "{path: values} or {path: (low, high)}")
    begin: Start | StructureStart
    direction: tuple[float, ...] = ()
    if isinstance(osc, Structure):
        force, begin = loads_of(osc, force), structure_start(osc, start, inside=True)
        if on is not None or osc.n == 1:
            direction = tuple(osc.direction(on).tolist())
    else:
        check_driven(osc, force)
        if on is not None:
            raise ParameterError("on", on, "given for an oscillator, which has one displacement")
        begin = start_of(start)
    axes: list[Axis] = []
    for path, values in over.items():
        if isinstance(path, tuple):
            axes.append(_axis_along(osc, path, values_of(str(path), values, points)))
            continue
        name = long_form(path, osc, force, begin)
        if any(axis.path == name for axis in axes):
            first = next(axis.asked for axis in axes if axis.path == name)
            raise ParameterError("over", (first, path), "the same parameter, named twice")
        axis = _axis(osc, force, begin, name, values_of(path, values, points))
        axes.append(replace(axis, asked=path))
    if paired:
        _check_pairs(axes)
    return Grid(osc, force, begin, tuple(axes), direction, paired)


def _check_pairs(axes: Sequence[Axis]) -> None:
    """Raise unless axes that are taken together are there, and are of one length."""
    if not axes:
        raise ParameterError("over", {}, "no parameter, whose values could be taken together")
    first = axes[0]
    for axis in axes:
        if axis.dimension == SAMPLE:
            reason = "the name of the dimension of samples; give the parameter another name"
            raise ParameterError("over", SAMPLE, reason)
        if len(axis.given) != len(first.given):
            reason = (
                f"{counted(len(axis.given), 'value')}, and {first.dimension} has "
                f"{len(first.given)}; paired, each has as many"
            )
            raise ParameterError("over", axis.dimension, reason)


def check_driven(osc: object, force: object) -> None:
    """Raise a `ParameterError` unless these are an oscillator and its forcing, or a structure."""
    if isinstance(osc, Structure):
        return
    if not isinstance(osc, Oscillator):
        raise ParameterError("osc", osc, "no oscillator, such as pc.impact_oscillator() returns")
    if force is not None and not isinstance(force, Forcing):
        raise ParameterError("force", force, "no forcing, such as pc.cosine(2.5), nor None")


def _axis_along(osc: object, direction: tuple[Any, ...], values: tuple[Phase, ...]) -> Axis:
    """Return the axis of starts along a direction of a structure's displacements and velocities."""
    n = osc.n if isinstance(osc, Structure) else 0
    if len(direction) != 2 * n:
        reason = (
            f"{len(direction)} numbers; a direction of starts has {2 * n}, of x0 and v0"
            if n
            else "a direction of starts, which only a structure has; give paths"
        )
        raise ParameterError("over", direction, reason)
    along = tuple(real(f"over.{i}", number) for i, number in enumerate(direction))
    if not any(along):
        raise ParameterError("over", direction, "a direction of zeros; no start moves along it")
    name = str(direction)
    return Axis(f"start.{name}", values, ("start",), "", name, along)


def _axis(osc: Any, force: Any, start: Any, name: str, values: tuple[Phase, ...]) -> Axis:
    """Return the axis of a parameter; one in expressions has the dimension of what it alone is."""
    if "." in name:
        return Axis(name, values)
    moved = moved_fields(osc, force, start, name).fields
    owners = tuple({field.split(".")[0] for field in moved})
    return Axis(name, values, owners, dimensions_of_named(moved, osc, force))


def values_of(path: str, values: object, points: int = POINTS) -> tuple[Phase, ...]:
    """Return the values of an axis from a range (low, high) or from the values themselves.

    Parameters
    ----------
    path
        The path of the parameter, for messages.
    values
        A tuple of two numbers is a range; any other sequence are values.
    points
        Number of equally spaced values of a range.

    Returns
    -------
    tuple
        The values; given ones are kept exactly.

    Raises
    ------
    ParameterError
        If there are no values, or some are not finite.
    """
    if not is_row(values) or not hasattr(values, "__len__"):
        raise ParameterError(path, values, "not a list of values, nor a range (low, high)")
    if isinstance(values, np.ndarray) and values.ndim != 1:
        raise ParameterError(path, values.shape, "not a list of values, but an array of this shape")
    given = tuple(plain(value) for value in values)
    if not given:
        raise ParameterError(path, (), "an axis without values")
    for value in given:
        problem = phase_problem(value)
        if problem is not None:
            raise ParameterError(path, value, problem)
    if not (isinstance(values, tuple) and len(values) == 2):
        return given  # type: ignore[return-value]  # each is checked above
    return _spread(path, given, points)  # type: ignore[arg-type]  # the same


def _spread(path: str, ends: tuple[Phase, ...], points: int) -> tuple[Phase, ...]:
    low, high = (as_float(end) for end in ends)
    if low == high:
        raise ParameterError(path, ends, "a range without width; give one value as [value]")
    between = (float(value) for value in np.linspace(low, high, points)[1:-1])
    return (ends[0], *between, ends[1])
