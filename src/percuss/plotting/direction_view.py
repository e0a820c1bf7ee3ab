"""The motion of a structure along one direction, as the pictures of one displacement take it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels.structure.basis import QUICKEST
from percuss.model.exact import as_float
from percuss.model.oscillator import On, Stop
from percuss.model.structure import Structure
from percuss.model.units import Units
from percuss.motion.structures import StructureTrajectory
from percuss.motion.tables import Contacts, Crossings, Grazes, Impacts
from percuss.motion.trajectory import Trajectory
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.plotting.style import check_kind


@dataclass(frozen=True, slots=True)
class StopsSeen:
    """The stops on a line, at their places on it, and the units: all that pictures ask for."""

    stops: tuple[Stop, ...]
    units: Units | None


@dataclass(frozen=True)
class DirectionView:
    """A run of a structure seen along y = c . x; of its events those that concern y.

    Attributes
    ----------
    run
        The run.
    on
        The coordinate, direction or point.
    """

    run: StructureTrajectory
    on: On | None

    def __call__(
        self, t: ArrayLike, limit: Literal["after", "before"] = "after"
    ) -> tuple[Floats, Floats]:
        """Return y and its velocity at times t."""
        x, v = self.run(t, limit)
        return (x * self._c).sum(axis=-1), (v * self._c).sum(axis=-1)

    @property
    def _c(self) -> Floats:
        return self.run.structure.direction(self.on)

    @property
    def t0(self) -> float:
        """When the run begins."""
        return self.run.t0

    @property
    def t_end(self) -> float:
        """When it ends."""
        return self.run.t_end

    @cached_property
    def x0(self) -> float:
        """The displacement at the start."""
        return float((self.run.start.x * self._c).sum())

    @cached_property
    def v0(self) -> float:
        """The velocity at the start, before an impact there."""
        return float((self.run.start.v * self._c).sum())

    @cached_property
    def oscillator(self) -> StopsSeen:
        """The stops on the line of y."""
        return StopsSeen(tuple(stop for _, stop in self._parallel), self.run.structure.units)

    @cached_property
    def stop_numbers(self) -> list[int]:
        """The numbers in the structure of the stops on the line of y."""
        return [i for i, _ in self._parallel]

    @cached_property
    def _parallel(self) -> list[tuple[int, Stop]]:
        """The stops whose direction is a multiple of c, with their numbers, as stops of y."""
        structure: Structure = self.run.structure
        stops: list[tuple[int, Stop]] = []
        for i, stop in enumerate(structure.stops):
            own = structure.stop_directions[i]
            k = int(np.argmax(np.abs(self._c)))
            factor = float(own[k] / self._c[k])
            if factor == 0.0 or not np.allclose(own, factor * self._c, rtol=1e-12, atol=0.0):
                continue
            is_below = (stop.side == "below") == (factor > 0.0)
            place = as_float(stop.at) / factor
            side: Literal["below", "above"] = "below" if is_below else "above"
            stops.append((i, dataclasses.replace(stop, at=place, side=side, on=None)))
        return stops

    @cached_property
    def impacts(self) -> Impacts:
        """All impacts at which the velocity of y jumps, with its velocities."""
        every = self.run.impacts
        before, after = self(every.t, "before")[1], self(every.t, "after")[1]
        jumps = np.abs(after - before) > 1e-13 * np.abs(before).max(initial=0.0)
        return Impacts(
            every.t[jumps],
            before[jumps],
            after[jumps],
            self._number(every.stop[jumps]),
            every.cycle[jumps],
            every.intervals[jumps],
            None,
            every.units,
        )

    @cached_property
    def crossings(self) -> Crossings:
        """The crossings of edges on the line of y: elsewhere its motion stays smooth."""
        kept = self._concerned(self.run.crossings.stop)
        table = _rows(self.run.crossings, kept, self._number)
        return dataclasses.replace(table, v=self(table.t)[1])

    @cached_property
    def contacts(self) -> Contacts:
        """The contacts on the line of y."""
        kept = self._concerned(self.run.contacts.stop)
        return _rows(self.run.contacts, kept, self._number)

    @cached_property
    def grazes(self) -> Grazes:
        """The grazes on the line of y."""
        kept = self._concerned(self.run.grazes.stop)
        return _rows(self.run.grazes, kept, self._number)

    def frequency(self) -> float:
        """Return the quickest rate of the modes and the loads of all sets that were met."""
        return float(self.run.system.sets.of_set[:, QUICKEST].max())

    def _concerned(self, stops: Integers) -> Flags:
        return np.isin(stops, self.stop_numbers)

    def _number(self, stops: Integers) -> Integers:
        """Return the numbers of stops among those on the line, -1 for others."""
        numbers = np.full(len(self.run.structure.stops) + 1, -1, dtype=np.int64)
        numbers[self.stop_numbers] = np.arange(len(self.stop_numbers))
        return numbers[stops]


Events = TypeVar("Events", Crossings, Contacts, Grazes)
# A motion of one displacement.
Drawable = Trajectory | DirectionView


def _rows(table: Events, kept: Flags, number: Callable[[Integers], Integers]) -> Events:
    """Return the rows of a table of events that are kept."""
    columns = {
        field.name: getattr(table, field.name)[kept]
        for field in dataclasses.fields(table)
        if isinstance(getattr(table, field.name), np.ndarray)
    }
    changed: Any = columns | {"stop": number(columns["stop"])}
    return dataclasses.replace(table, **changed)


def view_of(
    run: Trajectory | StructureTrajectory | PeriodicOrbit | StructureOrbit, on: On | None = None
) -> Drawable:
    """Return what has one displacement: a run of an oscillator, or one of a structure along c.

    Without a direction that is the line of the structure's first stop. Of an orbit it is a period.

    Raises
    ------
    ParameterError
        If there is no such direction, or the run is one of an oscillator, which has none, or no
        run.
    """
    if isinstance(run, StructureOrbit):
        run = run.run
    if isinstance(run, StructureTrajectory):
        on = first_line(run.structure) if on is None else on
        run.structure.direction(on)
        return DirectionView(run, on)
    if on is not None:
        raise ParameterError(
            "on", on, "given for the run of an oscillator, which has one displacement"
        )
    if isinstance(run, PeriodicOrbit):
        return run.trajectory()
    check_kind("run", run, Trajectory)
    return run


def first_line(structure: Structure) -> On:
    """Return what pictures of one displacement show by default: the line of the first stop."""
    on = structure.stops[0].on if structure.stops else None
    return 0 if on is None else on


def shown_lines(
    structure: Structure, on: On | Sequence[On] | None, most: int, what: str
) -> list[On]:
    """Return the displacements in a picture of several: by default the points, or all coordinates.

    One coordinate or point may stand without a list.

    Raises
    ------
    ParameterError
        If there are none, or too many.
    """
    if on is None:
        shown: list[On] = [name for name, _ in structure.points] or list(range(structure.n))
    else:
        shown = (
            [cast("On", on)]
            if isinstance(on, str) or not isinstance(on, Iterable)
            else list(cast("Sequence[On]", on))
        )
    if not 0 < len(shown) <= most:
        reason = f"{len(shown)} {what}; give 1 to {most} coordinates, directions or points"
        raise ParameterError("on", on, reason)
    return shown


def line_in_words(structure: Structure, on: On) -> str:
    """Return a displacement in words: coordinate 0, the name of a point, or a combination."""
    structure.direction(on)
    if isinstance(on, str):
        return on
    return f"coordinate {on}" if isinstance(on, int) else f"${direction_name(structure, on)}$"


def names_of(run: Drawable) -> tuple[str, str]:
    """Return the labels of a displacement and its velocity on axes."""
    if isinstance(run, DirectionView):
        name = direction_name(run.run.structure, run.on)
        return f"${name}$", f"of ${name}$"
    return "$x$", "$v$"


def direction_name(structure: Structure, on: On | None) -> str:
    """Return y as a formula: x0, or a combination such as x0 - x1.

    Examples
    --------
    >>> import percuss as pc
    >>> pair = pc.Structure([1, 1], [1, 1])
    >>> direction_name(pair, 1), direction_name(pair, (1, -1))
    ('x_{1}', 'x_{0} - x_{1}')
    """
    if isinstance(on, str):
        # As it is written: an underscore there is no subscript.
        name = re.sub(r"([\\{}$])", r"\\\1", on)
        return rf"\text{{{name}}}"
    return combination(structure.direction(on).tolist())


def combination(numbers: Sequence[float]) -> str:
    """Return a sum of coordinates as a formula."""
    text = ""
    for i, c in enumerate(numbers):
        if c:
            size = "" if abs(c) == 1.0 else f"{_number(abs(c))}\\,"
            sign = (" - " if c < 0 else " + ") if text else ("-" if c < 0 else "")
            text += f"{sign}{size}x_{{{i}}}"
    return text


def _number(c: float) -> str:
    """Return a number to four digits as a formula."""
    mantissa, _, exponent = f"{c:.4g}".partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa
