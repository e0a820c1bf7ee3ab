"""Structures: masses on springs, dashpots and stops, as frozen values of their matrices."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats
from percuss.model.exact import (
    Exact,
    as_float,
    as_fraction,
    kept,
    operand,
    plain,
)
from percuss.model.faults import (
    LARGEST_SCALE,
    Fault,
    as_tuple,
    dotted,
    draft,
    faults,
    field_values,
    is_row,
    number_faults,
    raise_first,
    scale_faults,
)
from percuss.model.oscillator import On, Stop, Wall, faults_of_each_stop, plain_on, stops_faults
from percuss.model.units import Units
from percuss.numerics import cholesky
from percuss.wording import closest, counted

MatrixRows: TypeAlias = tuple[tuple[Exact, ...], ...]
MatrixLike: TypeAlias = ArrayLike | Sequence[Any] | Exact
_MATRICES = ("mass", "damping", "stiffness")
# Stops that a line tells each by its place.
MOST_NAMED = 3
# Numbers of a direction that are shown.
LONGEST_SHOWN = 4
# The stops that act are bits of one integer.
MOST_STOPS = 62


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Structure:
    """The structure M x'' + C x' + K x = loads + stops, of n coordinates x.

    A stop acts on y = c . x, one coordinate or a direction, along M^-1 c: an impact at a wall turns
    y' into -r y' by x' -> x' - (1 + r) y' M^-1 c / (c . M^-1 c), a soft stop is the force
    c (k_s (at - y) - c_s y') while y is beyond it. All is in engineers' units, as with
    `Oscillator.from_mass`: the ``damping`` of a soft stop is its full coefficient c_s.

    Parameters
    ----------
    mass
        (n, n) matrix M [mass], symmetric and positive definite; (n,) for its diagonal, a number for
        n = 1. Entries may be exact, as all numbers of a model: texts, fractions, parameters. Also
        an array, a sparse matrix of SciPy or a table of pandas.
    stiffness
        (n, n) matrix K [force/length]; any real one: singular where a mass is free, unsymmetric in
        rotors.
    damping
        (n, n) matrix C [force time/length], any real one: not proportional, gyroscopic, negative;
        0 for none.
    stops
        Walls and soft stops, each with ``on``; with one coordinate they need none. They keep their
        order, which is the ``stop`` index in results.
    units
        What the numbers are measured in: the labels of tables, files and pictures.
    points
        Named points, by name the direction whose y = c . x is the displacement there. Stops and
        loads take the name.

    Raises
    ------
    ParameterError
        If a value is outside its domain, sizes differ, the mass is not symmetric or not positive
        definite, a stop acts on nothing that there is, or two walls leave no room between them.

    Examples
    --------
    Two masses between springs, with a wall for the first and a soft stop between the two:

    >>> import percuss as pc
    >>> structure = pc.Structure(
    ...     mass=[1, 2],
    ...     stiffness=[[3, -1], [-1, 1]],
    ...     damping=[["0.03", "-0.01"], ["-0.01", "0.01"]],
    ...     stops=[
    ...         pc.Wall(at=1, side="above", restitution="0.8", on=0),
    ...         pc.SoftStop(at="0.5", side="below", stiffness=100, on=(1, -1)),
    ...     ],
    ... )
    >>> structure.n, structure.mass
    (2, ((1, 0), (0, 2)))
    >>> structure.stop_directions
    array([[ 1.,  0.],
           [ 1., -1.]])
    """

    mass: MatrixRows
    stiffness: MatrixRows
    damping: MatrixRows
    stops: tuple[Stop, ...] = ()
    units: Units | None = None
    points: tuple[tuple[str, tuple[Exact, ...]], ...] = field(default=())

    def __init__(
        self,
        mass: MatrixLike,
        stiffness: MatrixLike,
        damping: MatrixLike = 0,
        stops: Iterable[Stop] = (),
        units: Units | None = None,
        points: Mapping[str, Iterable[Exact]] | Iterable[tuple[str, Iterable[Exact]]] = (),
    ) -> None:
        given = structure_fields(mass, stiffness, damping, stops, units, points)
        for name, value in given.items():
            object.__setattr__(self, name, value)
        raise_first(faults(self, ""))

    @classmethod
    def from_modes(
        cls,
        frequencies: Iterable[Exact],
        damping_ratios: Exact | Iterable[Exact],
        shapes: Mapping[str, Iterable[Exact]],
        stops: Iterable[Stop] = (),
        *,
        units: Units | None = None,
    ) -> Structure:
        """Return the structure whose coordinates are the amplitudes of modes.

        Parameters
        ----------
        frequencies
            Angular natural frequencies w [1/time] of the n modes, >= 0; 0 is a free one.
        damping_ratios
            Fraction z of critical damping of each mode, or one number for all.
        shapes
            By the name of a point the amplitudes of the n modes there, of shapes that are
            normalised to a modal mass of 1.
        stops
            Stops, ``on`` a point by its name.
        units
            What the numbers are measured in.

        Returns
        -------
        Structure
            With M = 1, C = diag(2 z w), K = diag(w^2), exactly, and the points.

        Raises
        ------
        ParameterError
            If a value is outside its domain, or lengths differ.

        Examples
        --------
        >>> import percuss as pc
        >>> beam = Structure.from_modes(
        ...     frequencies=[1, 6], damping_ratios="0.01", shapes={"tip": [2, -2]},
        ...     stops=[pc.Wall(at="0.1", side="above", restitution="0.6", on="tip")],
        ... )
        >>> beam.damping_matrix.diagonal(), beam.direction("tip")
        (array([0.02, 0.12]), array([ 2., -2.]))
        """
        omegas = exact_numbers("frequencies", frequencies)
        for i, omega in enumerate(omegas):
            if as_float(omega) < 0.0:
                raise_first([Fault(f"frequencies.{i}", omega, "negative")])
        ratios = one_each("damping_ratios", damping_ratios, len(omegas), "the frequencies")
        pairs = zip(ratios, omegas, strict=True)
        return cls(
            (1,) * len(omegas),
            tuple(kept(operand(omega) ** 2) for omega in omegas),
            tuple(kept(2 * operand(ratio) * operand(omega)) for ratio, omega in pairs),
            stops,
            units,
            shapes,
        )

    def __repr__(self) -> str:
        """Return the structure in a line; `text` has all its numbers."""
        stops = _counted_stops(self.stops)
        if 0 < len(self.stops) <= MOST_NAMED:
            stops = ", ".join(map(_stop_in_words, self.stops))
        points = ", ".join(name for name, _ in self.points)
        damped = "damped" if any(map(any, self.damping)) else "undamped"
        size = f"{counted(self.n, 'coordinate')}, {damped}"
        parts = [size, stops, *([f"points {points}"] if points else [])]
        return f"<Structure: {'; '.join(parts)}>"

    def text(self) -> str:
        """Return the call that makes the structure, with every number as it was given.

        Returns
        -------
        str
            The call, in which numbers, stops and units are those of percuss.

        Examples
        --------
        >>> pair = Structure(mass=[1, 2], stiffness=[[3, -1], [-1, "1/3"]])
        >>> pair
        <Structure: 2 coordinates, undamped; no stops>
        >>> pair.text()
        "Structure(mass=((1, 0), (0, 2)), stiffness=((3, -1), (-1, '1/3')), \
damping=((0, 0), (0, 0)), stops=())"
        >>> eval(pair.text()) == pair
        True
        """
        # Fields that are empty are left out: stores know a study by this text.
        others = {"units": self.units, "points": self.points or None}
        more = "".join(f", {name}={value!r}" for name, value in others.items() if value is not None)
        own = f"mass={self.mass!r}, stiffness={self.stiffness!r}, damping={self.damping!r}"
        return f"Structure({own}, stops={self.stops!r}{more})"

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        return isinstance(other, Structure) and field_values(self) == field_values(other)

    def __hash__(self) -> int:
        # Each call that looks for what follows from a structure asks for it.
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(tuple(field_values(self).values()))

    def __getstate__(self) -> dict[str, object]:
        """Return the fields: the hash of a text differs from process to process."""
        return field_values(self)

    @cached_property
    def matrix_entries(self) -> Mapping[str, Exact]:
        """The entries of the matrices by their paths; kept, since many systems have one structure."""
        entries: dict[str, Exact] = {}
        for name in ("mass", "damping", "stiffness"):
            for i, row in enumerate(getattr(self, name)):
                # Of two equal entries of the mass one is the parameter.
                first = i if name == "mass" else 0
                for j in range(first, len(row)):
                    entries[f"structure.{name}.{i}.{j}"] = row[j]
        return entries

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.mass)

    @cached_property
    def mass_matrix(self) -> Floats:
        """M as an (n, n) array [mass], not to be written to."""
        return _array(self.mass)

    @cached_property
    def damping_matrix(self) -> Floats:
        """C as an (n, n) array [force time/length], not to be written to."""
        return _array(self.damping)

    @cached_property
    def stiffness_matrix(self) -> Floats:
        """K as an (n, n) array [force/length], not to be written to."""
        return _array(self.stiffness)

    @cached_property
    def stop_directions(self) -> Floats:
        """The directions c of the stops as an (n_stops, n) array, not to be written to."""
        return _array([self._exact_direction(stop.on) for stop in self.stops], self.n)

    def direction(self, on: On | None = None) -> Floats:
        """Return the direction c of y = c . x.

        Parameters
        ----------
        on
            A coordinate, a direction, or the name of a point; None for the only coordinate.

        Returns
        -------
        array
            (n,).

        Raises
        ------
        ParameterError
            If there is no such coordinate or point, or the direction has another length, or is
            zero.

        Examples
        --------
        >>> Structure(mass=[1, 1], stiffness=[1, 1]).direction(1)
        array([0., 1.])
        """
        on = plain_on(on)
        raise_first(on_faults(self, on, "on"))
        return np.array([as_float(number) for number in self._exact_direction(on)])

    def _exact_direction(self, on: On | None) -> tuple[Exact, ...]:
        """Return a direction without faults as the numbers that were given."""
        if isinstance(on, tuple):
            return on
        if isinstance(on, str):
            return dict(self.points)[on]
        return tuple(int(i == (on or 0)) for i in range(self.n))


def _counted_stops(stops: tuple[Stop, ...]) -> str:
    """Return how many stops of each kind there are."""
    walls = sum(isinstance(stop, Wall) for stop in stops)
    numbers = {"wall": walls, "soft stop": len(stops) - walls}
    return ", ".join(counted(n, name) for name, n in numbers.items() if n) or "no stops"


def _stop_in_words(stop: Stop) -> str:
    kind = "wall" if isinstance(stop, Wall) else "soft stop"
    is_long = isinstance(stop.on, tuple) and len(stop.on) > LONGEST_SHOWN
    where = "" if stop.on is None else " on a direction" if is_long else f" on {stop.on!r}"
    return f"{kind} {stop.side} {stop.at!s}{where}"


def structure_fields(
    mass: MatrixLike,
    stiffness: MatrixLike,
    damping: MatrixLike = 0,
    stops: Iterable[Stop] = (),
    units: Units | None = None,
    points: Mapping[str, Iterable[Exact]] | Iterable[tuple[str, Iterable[Exact]]] = (),
) -> dict[str, Any]:
    """Return the fields of a structure from what `Structure` takes, without a check, for `draft`.

    Examples
    --------
    >>> structure_fields([1, 2], [3, "4"])["stiffness"]
    ((3, 0), (0, '4'))
    """
    matrices = {"mass": mass, "stiffness": stiffness, "damping": damping}
    given = {name: _plain_matrix(value) for name, value in matrices.items()}
    n = _size(given.values())
    return {
        **{name: _full(value, n) for name, value in given.items()},
        "stops": as_tuple(stops),
        "units": units,
        "points": _plain_points(points),
    }


def _plain_points(points: Any) -> tuple[tuple[Any, Any], ...]:
    pairs: Any = tuple(points.items()) if isinstance(points, Mapping) else as_tuple(points)
    if not isinstance(pairs, tuple) or not all(
        isinstance(pair, tuple | list) and len(pair) == 2 for pair in pairs
    ):
        reason = 'not directions by their names, as in {"tip": [0, 1]}'
        raise_first([Fault("points", points, reason)])
    return tuple((name, plain_on(direction)) for name, direction in pairs)


def exact_numbers(name: str, values: object) -> tuple[Exact, ...]:
    """Return a sequence of numbers as it was given; a ParameterError names one that is none."""
    numbers = plain_on(values)
    if not isinstance(numbers, tuple):
        raise_first([Fault(name, values, "not a sequence of numbers")])
    raise_first(
        fault for i, number in enumerate(numbers) for fault in number_faults(f"{name}.{i}", number)
    )
    return cast("tuple[Exact, ...]", numbers)


def one_each(name: str, values: object, n: int, of: str) -> tuple[Exact, ...]:
    """Return n numbers; one alone, not in a sequence, is each of them."""
    numbers = plain_on(values)
    if not isinstance(numbers, tuple):
        raise_first(number_faults(name, numbers))
        return (numbers,) * n
    if len(numbers) != n:
        reason = f"{len(numbers)} numbers, but {n} are needed, one for each of {of}"
        raise_first([Fault(name, numbers, reason)])
    return exact_numbers(name, numbers)


def on_faults(structure: Structure, on: object, name: str) -> list[Fault]:
    """Return the fault of what a stop or a load acts on.

    Parameters
    ----------
    structure
        A structure whose matrices have no faults.
    on
        A coordinate, a direction, the name of a point or None.
    name
        Path of the value.
    """
    n = structure.n
    names = [point for point, _ in structure.points]
    if isinstance(on, tuple):
        return _direction_faults(on, n, name)
    if isinstance(on, str):
        if on in names:
            return []
        alike = closest(on, names)
        hint = (
            f"did you mean {alike}?"
            if alike
            else f"there are {', '.join(names)}"
            if names
            else "the structure has no named points; give a coordinate or a direction"
        )
        return [Fault(name, on, f"no such point; {hint}")]
    coordinates = "the only coordinate is 0" if n == 1 else f"the coordinates are 0 to {n - 1}"
    if on is None:
        if n == 1:
            return []
        points = f", or a point: {', '.join(names)}" if names else ""
        reason = f"not said on what it acts; {coordinates}; give one, or a direction{points}"
        return [Fault(name, on, reason)]
    if isinstance(on, bool) or not isinstance(on, int):
        reason = "neither a coordinate's index nor a direction's tuple nor a point's name"
        return [Fault(name, on, reason)]
    return [] if 0 <= on < n else [Fault(name, on, f"no such coordinate; {coordinates}")]


def _direction_faults(direction: tuple[object, ...], n: int, name: str) -> list[Fault]:
    if len(direction) != n:
        numbers, coordinates = counted(len(direction), "number"), counted(n, "coordinate")
        reason = f"{numbers} for {coordinates}; a direction has one for each"
        return [Fault(name, direction, reason)]
    problems = [
        fault for i, number in enumerate(direction) for fault in scale_faults(f"{name}.{i}", number)
    ]
    if not problems and not any(as_float(cast("Exact", number)) for number in direction):
        reason = "a direction of zeros; what acts on it moves nothing"
        return [Fault(name, direction, reason)]
    return problems


@faults.register
def _(value: Structure, prefix: str | None = None) -> list[Fault]:
    prefix = "structure" if prefix is None else prefix
    problems = _matrix_faults(value, prefix)
    if problems:
        return problems
    problems = _mass_faults(value, prefix) + _units_faults(value, prefix)
    points: tuple[Any, ...] = value.points
    for i, (name, direction) in enumerate(points):
        path = dotted(prefix, f"points.{name if isinstance(name, str) else i}")
        if not isinstance(name, str) or not name:
            problems.append(Fault(path, name, "not the name of a point"))
        elif name in [other for other, _ in points[:i]]:
            problems.append(Fault(path, direction, "the name of another point, too"))
        elif not isinstance(direction, tuple):
            problems.append(Fault(path, direction, f"not {value.n} numbers, one a coordinate"))
        else:
            problems += _direction_faults(direction, value.n, path)
    if not isinstance(value.stops, tuple):
        reason = "not a sequence of stops; of one alone it is [stop]"
        return [*problems, Fault(dotted(prefix, "stops"), value.stops, reason)]
    if len(value.stops) > MOST_STOPS:
        reason = f"more than the {MOST_STOPS} whose sets have a number each"
        return [*problems, Fault(dotted(prefix, "stops"), len(value.stops), reason)]
    # What stops act on needs points without faults.
    wrong = problems + faults_of_each_stop(
        value.stops, prefix, lambda on, name: [] if problems else on_faults(value, on, name)
    )
    return wrong or _line_faults(value, prefix)


def _matrix_faults(structure: Structure, prefix: str) -> list[Fault]:
    """Return the faults of the matrices' shapes and of their entries."""
    problems = []
    n = _size(getattr(structure, name) for name in ("mass", "stiffness", "damping"))
    if n == 0:
        return [Fault(dotted(prefix, "mass"), structure.mass, "empty; a structure has coordinates")]
    for name in _MATRICES:
        matrix, path = getattr(structure, name), dotted(prefix, name)
        if not isinstance(matrix, tuple):
            wrong = number_faults(path, matrix)
            reason = f"one number for {n} coordinates; give {n} for a diagonal, or the matrix"
            problems += wrong or [Fault(path, matrix, reason)]
            continue
        if not all(isinstance(row, tuple) for row in matrix):
            problems.append(Fault(path, matrix, "neither rows of a matrix nor its diagonal"))
            continue
        odd = next((len(row) for row in matrix if len(row) != len(matrix)), None)
        if odd is not None:
            reason = f"{len(matrix)} rows, of which one has {odd} entries; the matrix is not square"
            problems.append(Fault(path, _shape(matrix), reason))
        elif len(matrix) != n:
            size = f"{len(matrix)} x {len(matrix)}"
            reason = f"{size}, but the mass is {n} x {n}; all matrices have one size"
            problems.append(Fault(path, _shape(matrix), reason))
        else:
            problems += [
                fault
                for i, row in enumerate(matrix)
                for j, entry in enumerate(row)
                for fault in scale_faults(f"{path}.{i}.{j}", entry)
            ]
    return problems


def _mass_faults(structure: Structure, prefix: str) -> list[Fault]:
    """Return the fault of a mass that is not symmetric, not positive definite, or too small."""
    mass, path = structure.mass, dotted(prefix, "mass")
    matrix = _array(mass)
    for i, j in zip(*np.nonzero(matrix != matrix.T), strict=True):
        reason = f"not mass.{j}.{i} = {mass[j][i]}; a mass is symmetric, as (M + M.T) / 2 is"
        return [Fault(f"{path}.{i}.{j}", mass[i][j], reason)]
    lower, pivots = cholesky(matrix)
    if np.isnan(lower[-1, -1]):
        i = int(np.isfinite(pivots).sum()) - 1
        reason = "not positive"
        if mass[i][i] and as_float(mass[i][i]) > 0.0:
            reason = (
                f"the mass is not positive definite; {pivots[i]:.3g} of this entry is left after"
                " elimination of the coordinates before it"
            )
        return [Fault(f"{path}.{i}.{i}", mass[i][i], reason)]
    least = float(pivots.min())
    for name in ("damping", "stiffness"):
        largest = float(np.abs(_array(getattr(structure, name))).max())
        if largest / least > LARGEST_SCALE:
            reason = f"beyond {LARGEST_SCALE:g} times the least mass {least:g}; choose other units"
            return [Fault(dotted(prefix, name), largest, reason)]
    return []


def _units_faults(structure: Structure, prefix: str) -> list[Fault]:
    units: object = structure.units
    if units is None or isinstance(units, Units):
        return []
    return [Fault(dotted(prefix, "units"), units, 'not a Units; write Units("m", "s", "kg")')]


def _line_faults(structure: Structure, prefix: str) -> list[Fault]:
    """Return the faults of stops on one line that do not fit together, such as closed walls."""
    lines: dict[tuple[Fraction, ...], dict[int, Stop]] = {}
    scales: dict[tuple[Fraction, ...], Fraction] = {}
    for index, direction in enumerate(structure.stop_directions):
        exact = [Fraction(number) for number in direction.tolist()]
        own = next(number for number in exact if number)
        line = tuple(number / own for number in exact)
        # Places are told on the line of its first stop.
        scale = own / scales.setdefault(line, own)
        stop = structure.stops[index]
        if scale != 1:
            side = stop.side
            if scale < 0:
                side = "below" if side == "above" else "above"
            place = kept(as_fraction(stop.at) / scale)
            stop = draft(type(stop), **field_values(stop) | {"at": place, "side": side})
        lines.setdefault(line, {})[index] = stop
    problems = []
    for line, stops in lines.items():
        of = "x" if sum(number != 0 for number in line) == 1 else "y"
        problems += [
            dataclasses.replace(fault, value=_as_given(structure, fault.name))
            for fault in stops_faults(stops, prefix, of)
        ]
    return problems


def _as_given(structure: Structure, path: str) -> object:
    """Return the value of a field of a stop by its path."""
    _, index, name = path.rsplit(".", 2)
    return getattr(structure.stops[int(index)], name)


def _plain_matrix(value: Any) -> Any:
    """Return a matrix as a tuple of rows, a diagonal as a tuple, and a number as it is."""
    for convert in ("toarray", "to_numpy"):
        if hasattr(value, convert):
            value = getattr(value, convert)()
    value = plain(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if not is_row(value):
        return value
    return tuple(plain_on(row) for row in value)


def _size(values: Iterable[Any]) -> int:
    """Return the number of coordinates: that of the first matrix, 1 if all are numbers."""
    return next((len(value) for value in values if isinstance(value, tuple)), 1)


def _full(value: Any, n: int) -> Any:
    """Return the (n, n) matrix of a diagonal, or of a number where that is clear."""
    if isinstance(value, tuple):
        if any(isinstance(row, tuple) for row in value):
            return value
    elif n == 1 or value in (0, "0"):
        value = (value,) * n
    else:
        return value
    return tuple(
        tuple(entry if i == j else 0 for j in range(len(value))) for i, entry in enumerate(value)
    )


def _shape(matrix: tuple[tuple[object, ...], ...]) -> tuple[int, ...]:
    return len(matrix), len(matrix[0])


def _array(rows: Sequence[Sequence[Exact]], n: int | None = None) -> Floats:
    values = [[as_float(entry) for entry in row] for row in rows]
    array = np.array(values).reshape(len(rows), len(rows) if n is None else n)
    array.flags.writeable = False
    return array
