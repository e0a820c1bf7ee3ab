"""The points of a study of many motions: all combinations of the values of parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.job import Dimension
from percuss.ensembles.threads import check_wanted
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.model.exact import Phase, as_float, phase_problem, plain, whole
from percuss.model.expression import Expression
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.paths import long_form, moved_fields, replace_parameters
from percuss.model.start import Start, start_of
from percuss.model.system import law, region_rows, stop_rows
from percuss.model.units import FORCE, in_units

__all__ = [
    "POINTS", "Axis", "Grid", "Group", "make_grid", "units_of", "values_of", "walls_of", "whole",
]  # fmt: skip


_OF_START = ("x0", "v0", "t0")
_OWNERS = ("oscillator", "forcing", "start")
# Dimensions of parameters by the last word of their paths.
UNITS = {
    "mass": "mass",
    "stiffness": "1/time^2",
    "damping": "1/time",
    "at": "length",
    "restitution": "1",
    "speeds": "length/time",
    "values": "1",
    "amplitude": "length/time^2",
    "omega": "1/time",
    "phase": "rad",
    "constant": "length/time^2",
    "period": "time",
    "cos": "length/time^2",
    "sin": "length/time^2",
    "x0": "length",
    "v0": "length/time",
    "t0": "time",
}
# With a mass these are forces per length and per velocity, and forces.
_OF_OSCILLATOR = {"stiffness": "mass/time^2", "damping": "mass/time"}
_OF_FORCE = ("amplitude", "constant", "cos", "sin")
# Values that a range (low, high) stands for by default.
POINTS = 101


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
    """

    path: str
    given: tuple[Phase, ...]
    owners: tuple[str, ...] = ()
    units: str | None = None
    asked: str = ""

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


@dataclass(frozen=True, slots=True)
class Group:
    """The laws and starts of some points whose laws have one shape.

    Attributes
    ----------
    laws, which, starts
        As `follow_batch` takes them.
    rows
        (n,) array, their points, counted from the first one asked for.
    stops
        (n_laws, n_stops, columns) array, as `follow_batch` takes it; None where it is not needed.
    """

    laws: Floats
    which: Integers
    starts: Floats
    rows: Integers
    stops: Floats | None = None

    @property
    def is_forced(self) -> bool:
        """Whether the motions have a forcing with a period."""
        return bool(self.laws[0, 0, at.PERIOD] > 0.0)


@dataclass(frozen=True, slots=True)
class Grid:
    """All combinations of the values along the axes, the last axis the fastest.

    Attributes
    ----------
    osc, force, start
        The oscillator, forcing and start whose parameters vary.
    axes
        The axes; without axes there is one point.
    """

    osc: Oscillator
    force: Forcing | None
    start: Start
    axes: tuple[Axis, ...] = field(default=())

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each axis."""
        return tuple(len(axis.given) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes as the answer has them."""
        return tuple(
            Dimension(
                axis.dimension,
                tuple(axis.values.tolist()),
                in_units(self.osc.units, self._dimensions_of(axis)),
            )
            for axis in self.axes
        )

    def _dimensions_of(self, axis: Axis) -> str:
        return units_of(axis.path, self.osc, self.force) if axis.units is None else axis.units

    def point(self, i: int) -> tuple[Oscillator, Forcing | None, Start]:
        """Return the oscillator, the forcing and the start of a point.

        Raises
        ------
        ParameterError
            If a value is outside its domain.
        """
        return Maker(self).point(self._where(i))

    def motion(self) -> dict[str, str]:
        """Return the oscillator, the forcing and the start in words."""
        return {
            "oscillator": repr(self.osc),
            "forcing": repr(self.force),
            "start": repr(self.start),
        }

    def identity(self) -> dict[str, object]:
        """Return the grid as JSON can hold it: what was given, exactly."""
        axes = {axis.path: [repr(value) for value in axis.given] for axis in self.axes}
        return {**self.motion(), "over": axes}

    def words(self, i: int) -> str:
        """Return the values of the axes at a point, in words."""
        where = zip(self.axes, self._where(i), strict=True)
        return ", ".join(f"{axis.dimension} = {axis.given[k]!s}" for axis, k in where)

    def _where(self, i: int) -> tuple[int, ...]:
        return tuple(int(k) for k in np.unravel_index(i, self.shape)) if self.axes else ()

    def groups(self, first: int, last: int) -> tuple[list[Group], dict[int, str]]:
        """Return the points from first to last in groups, and the faults of points without motion.

        The last is not included, and faults are counted from the first. A term of a Fourier sum
        that becomes zero changes the shape of the law: there is one group for each shape.
        """
        where = np.unravel_index(np.arange(first, last), self.shape) if self.axes else ()
        key = np.zeros(last - first, dtype=np.int64)
        starts = np.empty((last - first, 3))
        for column, name in enumerate(_OF_START):
            starts[:, column] = as_float(getattr(self.start, name))
        for axis, k in zip(self.axes, where, strict=True):
            if axis.of_start:
                starts[:, _OF_START.index(axis.path.removeprefix("start."))] = axis.values[k]
            else:
                key = key * len(axis.given) + k
        tied = [
            (column, name)
            for column, name in enumerate(_OF_START)
            if isinstance(getattr(self.start, name), Expression)
        ]
        order = np.argsort(key, kind="stable")
        cuts = np.flatnonzero(np.diff(key[order])) + 1
        groups: dict[tuple[int, ...], list[tuple[Floats, Floats, Integers]]] = {}
        faults: dict[int, str] = {}
        maker = Maker(self)
        for rows in np.split(order, cuts):
            check_wanted()
            try:
                osc, force, start = maker.point(self._where(first + int(rows[0])))
                own_law = law(osc, force)
                for column, name in tied:
                    starts[rows, column] = as_float(getattr(start, name))
            except ParameterError as error:
                faults |= {int(row): str(error) for row in rows}
                continue
            groups.setdefault(own_law.shape, []).append((own_law, stop_rows(osc), rows))
        joined = [_group_of(group, starts, faults) for group in groups.values()]
        return [group for group in joined if len(group.rows)], faults


class Maker:
    """Makes the oscillators, forcings and starts of a grid, each different one once."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._made: dict[tuple[str, tuple[int, ...]], Any] = {}

    def point(self, where: tuple[int, ...]) -> tuple[Oscillator, Forcing | None, Start]:
        """Return the oscillator, the forcing and the start at these indices of the axes."""
        return (
            self._part("oscillator", where),
            self._part("forcing", where),
            self._part("start", where),
        )

    def _part(self, owner: str, where: tuple[int, ...]) -> Any:
        grid = self._grid
        own = [i for i, axis in enumerate(grid.axes) if axis.changes(owner)]
        key = owner, tuple(where[i] for i in own)
        if key not in self._made:
            changes = {grid.axes[i].path: grid.axes[i].given[where[i]] for i in own}
            all_parts = replace_parameters(grid.osc, grid.force, grid.start, changes)
            self._made[key] = all_parts[_OWNERS.index(owner)]
        return self._made[key]


def _group_of(
    group: list[tuple[Floats, Floats, Integers]], starts: Floats, faults: dict[int, str]
) -> Group:
    """Return the motions whose laws have one shape, and add the faults of starts inside a wall."""
    rows = np.concatenate([rows for *_, rows in group])
    which = np.repeat(np.arange(len(group)), [len(rows) for *_, rows in group])
    laws = np.stack([own_law for own_law, *_ in group])
    stops = np.stack([own_stops for _, own_stops, _ in group])
    low, high = (walls[which] for walls in walls_of(laws))
    x0 = starts[rows, 0]
    for outside, side, wall in ((x0 < low, "below", low), (x0 > high, "above", high)):
        for i in np.flatnonzero(outside):
            faults[int(rows[i])] = (
                f"x0 = {x0[i]}: {side} the wall at x = {wall[i]}; "
                "use a SoftStop for a compliant one"
            )
    inside = ~((x0 < low) | (x0 > high))
    return Group(laws, which[inside], starts[rows[inside]], rows[inside], stops)


def walls_of(laws: Floats) -> tuple[Floats, Floats]:
    """Return the places of the walls of laws, (n,) arrays, infinite where there is none.

    Parameters
    ----------
    laws
        (n, rows, columns) array of laws of one shape.
    """
    rows = region_rows(laws[0])
    lowest, highest = laws[:, rows[0]], laws[:, rows[-1]]
    low = np.where(lowest[:, at.LOWER_KIND] == at.WALL, lowest[:, at.LOWER], -np.inf)
    high = np.where(highest[:, at.UPPER_KIND] == at.WALL, highest[:, at.UPPER], np.inf)
    return low, high


def make_grid(
    osc: Oscillator,
    force: Forcing | None,
    start: Start | Sequence[Phase] | None,
    over: Mapping[str, object],
    points: int = POINTS,
) -> Grid:
    """Return the grid of the parameters in ``over``, with all its axes checked.

    Parameters
    ----------
    osc, force
        The oscillator and the forcing.
    start
        Where the motion starts: a `Start`, or x0, v0 and optionally t0; None is x0 = v0 = 0.
    over
        By path, a range (low, high) or values; a path of the start may be among them. A tuple of
        two numbers is a range, any other sequence are values.
    points
        Number of equally spaced values of a range; its ends are kept as they were given.

    Raises
    ------
    ParameterError
        If there is no such path, one is named twice, or an axis is empty or not finite.

    Examples
    --------
    >>> from percuss.model import cosine, impact_oscillator
    >>> grid = make_grid(impact_oscillator(), cosine(2), (0, 1), {"forcing.omega": (2, 2.5, 3)})
    >>> grid.shape, grid.axes[0].path
    ((3,), 'forcing.harmonics.0.omega')
    >>> make_grid(impact_oscillator(), cosine(2), (0, 1), {"forcing.omega": (2, 3)}).shape
    (101,)
    """
    if not isinstance(over, Mapping):
        raise ParameterError("over", over, "not {path: values} or {path: (low, high)}")
    if not isinstance(osc, Oscillator):
        raise ParameterError("osc", osc, "no oscillator, such as pc.impact_oscillator() returns")
    if force is not None and not isinstance(force, Forcing):
        raise ParameterError("force", force, "no forcing, such as pc.cosine(2.5), nor None")
    begin = start_of(start)
    axes: list[Axis] = []
    for path, values in over.items():
        name = long_form(path, osc, force, begin)
        if any(axis.path == name for axis in axes):
            first = next(key for key in over if long_form(key, osc, force, begin) == name)
            raise ParameterError("over", (first, path), "the same parameter, named twice")
        axis = _axis(osc, force, begin, name, values_of(path, values, points))
        axes.append(replace(axis, asked=path))
    return Grid(osc, force, begin, tuple(axes))


def _axis(
    osc: Oscillator, force: Forcing | None, start: Start, name: str, values: tuple[Phase, ...]
) -> Axis:
    """Return the axis of a parameter; one in expressions has the dimension of what it alone is."""
    if "." in name:
        return Axis(name, values)
    moved = moved_fields(osc, force, start, name).fields
    alone = (field for field, value in moved.items() if value.is_parameter)
    field = next(alone, None)
    owners = tuple({field.split(".")[0] for field in moved})
    return Axis(name, values, owners, "" if field is None else units_of(field, osc, force))


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
    if isinstance(values, str) or not hasattr(values, "__len__") or not hasattr(values, "__iter__"):
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


def units_of(path: str, osc: Oscillator | None = None, force: Forcing | None = None) -> str:
    """Return the dimensions of a parameter in length, time, mass and radians, from its path.

    Examples
    --------
    >>> units_of("oscillator.stops.0.at"), units_of("forcing.cos.0")
    ('length', 'length/time^2')
    >>> units_of("oscillator.stiffness", Oscillator.from_mass(2, 50))
    'mass/time^2'
    """
    words = [word for word in path.split(".") if not word.isdigit()]
    name = words[-1]
    record = None if force is None else force.record
    if words[-2:] == ["record", "amplitude"] and record is not None and record.omega is None:
        # The factor of samples, which have their own units.
        return "1"
    if osc is not None and osc.mass is not None:
        if name in _OF_OSCILLATOR:
            return _OF_OSCILLATOR[name]
        if name in _OF_FORCE and force is not None and not force.is_per_mass:
            return FORCE
    return UNITS[name]
