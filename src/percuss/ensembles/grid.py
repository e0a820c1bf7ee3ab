"""The points of a study of many motions: every combination of values along named axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.kernels import law as at
from percuss.model.exact import Phase, as_float, phase_problem, plain
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.paths import long_form, replace_parameters
from percuss.model.start import Start

__all__ = ["Axis", "Grid", "LanesOf", "check_whole", "make_grid", "walls_of"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

_OF_START = ("x0", "v0", "t0")


@dataclass(frozen=True, slots=True)
class Axis:
    """A parameter and its values.

    Attributes
    ----------
    path
        Its dotted path in the long form, which is the name of the dimension.
    given
        The values as they were given, exact ones included.
    """

    path: str
    given: tuple[Phase, ...]

    @property
    def values(self) -> Floats:
        """(n,) array, the values as floats."""
        return np.array([as_float(value) for value in self.given])

    @property
    def of_start(self) -> bool:
        """Whether it is a number of the start, which leaves the law as it is."""
        return self.path.startswith("start.")


@dataclass(frozen=True, slots=True)
class LanesOf:
    """The laws and starts of some points whose laws have one shape.

    Attributes
    ----------
    laws, which, starts
        As `follow_lanes` takes them.
    rows
        (n,) array, the points that they belong to, counted from the first asked for.
    """

    laws: Floats
    which: Numbers
    starts: Floats
    rows: Numbers


@dataclass(frozen=True, slots=True)
class Grid:
    """All combinations of the values along the axes, the last axis the fastest.

    Attributes
    ----------
    osc, force, start
        What the parameters replace numbers of.
    axes
        The axes; none is one point.
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

    def point(self, i: int) -> tuple[Oscillator, Forcing | None, Start]:
        """Return what moves at a point, and from where.

        Raises
        ------
        ParameterError
            If a value is outside its domain.
        """
        where = np.unravel_index(i, self.shape) if self.axes else ()
        changes = {axis.path: axis.given[k] for axis, k in zip(self.axes, where, strict=True)}
        osc, force, start = replace_parameters(self.osc, self.force, self.start, changes)
        return osc, force, start or self.start

    def lanes(self, first: int, last: int) -> tuple[list[LanesOf], dict[int, str]]:
        """Return the lanes of the points from first to last, and the faults of those without.

        The last is not included, and faults are counted from the first. Terms of a Fourier sum
        that become zero change the shape of a law: there is one entry for each shape.
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
        order = np.argsort(key, kind="stable")
        cuts = np.flatnonzero(np.diff(key[order])) + 1
        groups: dict[tuple[int, ...], list[tuple[Floats, Numbers]]] = {}
        faults: dict[int, str] = {}
        for rows in np.split(order, cuts):
            try:
                osc, force, _ = self.point(first + int(rows[0]))
                table = law(osc, force)
            except ParameterError as error:
                faults |= {int(row): str(error) for row in rows}
                continue
            wrong = _faults_of_starts(table, starts, rows)
            faults |= wrong
            right = np.array([row for row in rows if row not in wrong], dtype=np.int64)
            groups.setdefault(table.shape, []).append((table, right))
        return [_lanes_of(group, starts) for group in groups.values()], faults


def _lanes_of(group: list[tuple[Floats, Numbers]], starts: Floats) -> LanesOf:
    rows = np.concatenate([rows for _, rows in group])
    which = np.repeat(np.arange(len(group)), [len(rows) for _, rows in group])
    return LanesOf(np.stack([table for table, _ in group]), which, starts[rows], rows)


def walls_of(tables: Floats) -> tuple[Floats, Floats]:
    """Return where the walls of laws are, (n,) arrays, infinite where there is none.

    Parameters
    ----------
    tables
        (n, rows, columns) array of laws of one shape.
    """
    n = int(tables[0, 0, at.N_HARMONICS])
    lowest, highest = tables[:, at.FIRST_HARMONIC + n], tables[:, tables.shape[1] - 1 - n]
    low = np.where(lowest[:, at.LOWER_KIND] == at.WALL, lowest[:, at.LOWER], -np.inf)
    high = np.where(highest[:, at.UPPER_KIND] == at.WALL, highest[:, at.UPPER], np.inf)
    return low, high


def _faults_of_starts(table: Floats, starts: Floats, rows: Numbers) -> dict[int, str]:
    """Return what is wrong with some of the starts, by row."""
    (low,), (high,) = walls_of(table[np.newaxis])
    x0 = starts[rows, 0]
    found = {}
    for outside, side, wall in ((x0 < low, "below", low), (x0 > high, "above", high)):
        for i in np.flatnonzero(outside):
            found[int(rows[i])] = (
                f"x0 = {x0[i]}: {side} the wall at x = {wall}; use a SoftStop for a compliant one"
            )
    return found


def make_grid(
    osc: Oscillator,
    force: Forcing | None,
    start: Start | Sequence[Phase] | None,
    over: Mapping[str, object],
) -> Grid:
    """Return the grid of the parameters in ``over``, all faults of its axes seen to.

    Parameters
    ----------
    osc, force
        The oscillator and the forcing.
    start
        Where the motion starts: a `Start`, or x0, v0 and where wanted t0; None is x0 = v0 = 0.
    over
        Values by path; a path of the start may be among them.

    Returns
    -------
    Grid
        The points.

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
    """
    begin = start if isinstance(start, Start) else _start_of(start)
    axes: list[Axis] = []
    for path, values in over.items():
        name = long_form(path, osc, force, begin)
        if any(axis.path == name for axis in axes):
            raise ParameterError("over", path, f"named twice, also as {name}")
        axes.append(Axis(name, _values_of(path, values)))
    return Grid(osc, force, begin, tuple(axes))


def check_whole(name: str, value: object, least: int) -> None:
    """Raise a `ParameterError` unless a value is a whole number and large enough.

    Parameters
    ----------
    name
        What it is.
    value
        The value.
    least
        The least that is allowed.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ParameterError(name, value, f"not a whole number of at least {least}")


def _start_of(start: Sequence[Phase] | None) -> Start:
    numbers: tuple[object, ...] = (0.0, 0.0) if start is None else tuple(start)
    if not 2 <= len(numbers) <= 3:
        raise ParameterError("start", start, "not (x0, v0) or (x0, v0, t0)")
    return Start(*numbers)  # type: ignore[arg-type]  # Start checks them


def _values_of(path: str, values: object) -> tuple[Phase, ...]:
    if isinstance(values, str) or not hasattr(values, "__len__") or not hasattr(values, "__iter__"):
        raise ParameterError(path, values, "not a list of values")
    if isinstance(values, np.ndarray) and values.ndim != 1:
        raise ParameterError(path, values.shape, "not a list of values, but an array of this shape")
    given = tuple(plain(value) for value in values)
    if not given:
        raise ParameterError(path, (), "an axis without values")
    for value in given:
        problem = phase_problem(value)
        if problem is not None:
            raise ParameterError(path, value, problem)
    return given  # type: ignore[return-value]  # each was looked at
