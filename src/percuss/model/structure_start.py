"""Starts of motions of structures."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from percuss.arrays import Floats
from percuss.model.exact import Exact, Phase, as_float, as_fraction
from percuss.model.faults import (
    Fault,
    dotted,
    faults,
    make_plain,
    number_faults,
    phase_faults,
    raise_first,
)
from percuss.model.oscillator import Wall, plain_on
from percuss.model.start import BEHIND_A_WALL
from percuss.model.structure import Structure
from percuss.wording import counted

# By how much a start on a wall may be behind it, as a part of its size: where a wall holds a
# structure, or is struck, the states of a run have the rounding of their modes.
ROUNDED = 1e-12


@dataclass(frozen=True, slots=True)
class StructureStart:
    """The state in which a motion of a structure starts.

    Parameters
    ----------
    x0
        (n,) coordinates [length].
    v0
        (n,) velocities [length/time].
    t0
        Time [time]; may be a multiple of pi.

    Raises
    ------
    ParameterError
        If a value is not a finite number, or the lengths differ.

    Examples
    --------
    >>> StructureStart(x0=[0, "0.1"], v0=[1, 0])
    StructureStart(x0=(0, '0.1'), v0=(1, 0), t0=0.0)
    """

    x0: tuple[Exact, ...]
    v0: tuple[Exact, ...]
    t0: Phase = 0.0

    def __post_init__(self) -> None:
        for name in ("x0", "v0"):
            object.__setattr__(self, name, plain_on(getattr(self, name)))
        make_plain(self, "t0")
        raise_first(faults(self, ""))

    @property
    def x(self) -> Floats:
        """The coordinates as an (n,) array [length]."""
        return np.array([as_float(number) for number in self.x0])

    @property
    def v(self) -> Floats:
        """The velocities as an (n,) array [length/time]."""
        return np.array([as_float(number) for number in self.v0])


def check_start(
    structure: Structure, x0: object = None, v0: object = None, t0: Phase = 0.0
) -> StructureStart:
    """Return the start of a motion of a structure, which lies inside no wall.

    Behind a wall by no more than the rounding of a run's states it is on the wall.

    Parameters
    ----------
    structure
        The structure.
    x0, v0
        (n,) coordinates [length] and velocities [length/time]; numbers for one coordinate, 0 or
        None for zeros.
    t0
        Time of the start [time].

    Returns
    -------
    StructureStart
        The start, as exact as it was given.

    Raises
    ------
    ParameterError
        If a value is not a finite number, there is not one for each coordinate, or the start is
        beyond a wall.

    Examples
    --------
    >>> import percuss as pc
    >>> pair = pc.impact_pair(masses=[1, 2], gap="0.5", restitution="0.7")
    >>> check_start(pair, v0=[1, 0])
    StructureStart(x0=(0.0, 0.0), v0=(1, 0), t0=0.0)
    >>> check_start(pair, x0=[0, 1])
    Traceback (most recent call last):
    ...
    percuss.errors.ParameterError: x0 = (0, 1): y = 1 is above the wall stops.1 at y = 0.5; ...
    """
    start = _start_at(structure, x0, v0, t0)
    raise_first(_wall_faults(structure, start))
    return start


def _start_at(structure: Structure, x0: object, v0: object, t0: Phase) -> StructureStart:
    """Return the start of what `check_start` takes, which may lie inside a wall."""
    n = structure.n
    both = []
    for name, given in (("x0", x0), ("v0", v0)):
        value = plain_on(given)
        if n == 1 and not isinstance(value, tuple) and value is not None:
            value = (value,)
        elif value is None or value == 0:
            value = (0.0,) * n
        if not isinstance(value, tuple):
            raise_first([Fault(name, value, f"not {n} numbers, one for each coordinate")])
        if len(value) != n:
            reason = (
                f"{counted(len(value), 'number')} for {counted(n, 'coordinate')}; give one for each"
            )
            raise_first([Fault(name, value, reason)])
        both.append(value)
    return StructureStart(both[0], both[1], t0)


def structure_start(
    structure: Structure,
    start: object = None,
    x0: object = None,
    v0: object = None,
    t0: Phase = 0.0,
    *,
    inside: bool = False,
) -> StructureStart:
    """Return the start of a motion of a structure from either form, checked against it.

    Parameters
    ----------
    structure
        The structure.
    start
        A `StructureStart`, (x0, v0) or (x0, v0, t0); None for the numbers that follow.
    x0, v0, t0
        As for `check_start`; the number 0.0 for a start at rest at 0.
    inside
        Whether it may lie inside a wall.

    Raises
    ------
    ParameterError
        If it is none of these, or not a start of this structure.

    Examples
    --------
    >>> import percuss as pc
    >>> pair = pc.impact_pair(masses=[1, 2], gap="0.5", restitution="0.7")
    >>> structure_start(pair, ([0, 0], [1, 0], "2*pi"))
    StructureStart(x0=(0, 0), v0=(1, 0), t0='2*pi')
    """
    if isinstance(start, StructureStart):
        x0, v0, t0 = start.x0, start.v0, start.t0
    elif start is not None:
        parts = plain_on(start)
        if not isinstance(parts, tuple) or len(parts) not in (2, 3):
            reason = "neither a StructureStart nor (x0, v0) nor (x0, v0, t0)"
            raise_first([Fault("start", start, reason)])
        x0, v0, t0 = (*parts, 0.0)[:3]
    x0, v0 = (None if isinstance(q, float) and q == 0.0 else q for q in (x0, v0))
    return _start_at(structure, x0, v0, t0) if inside else check_start(structure, x0, v0, t0)


@faults.register
def _(value: StructureStart, prefix: str | None = None) -> list[Fault]:
    prefix = "start" if prefix is None else prefix
    problems = phase_faults(dotted(prefix, "t0"), value.t0)
    for name in ("x0", "v0"):
        numbers, path = getattr(value, name), dotted(prefix, name)
        if not isinstance(numbers, tuple):
            problems.append(Fault(path, numbers, "not a tuple of numbers, one a coordinate"))
            continue
        for i, number in enumerate(numbers):
            problems += number_faults(f"{path}.{i}", number)
    if not problems and len(value.x0) != len(value.v0):
        reason = f"{len(value.v0)} velocities for {len(value.x0)} coordinates; give one for each"
        return [Fault(dotted(prefix, "v0"), value.v0, reason)]
    return problems


def _wall_faults(structure: Structure, start: StructureStart) -> list[Fault]:
    problems = []
    position = [as_fraction(number) for number in start.x0]
    for i, stop in enumerate(structure.stops):
        if not isinstance(stop, Wall):
            continue
        direction, at = structure.stop_directions[i].tolist(), as_float(stop.at)
        # Rounded once: a start at the wall is at it.
        y = float(sum(Fraction(c) * x for c, x in zip(direction, position, strict=True)))
        size = abs(at) + float(max(map(abs, position))) * sum(map(abs, direction))
        if (y - at) * (1.0 if stop.side == "above" else -1.0) > ROUNDED * size:
            reason = (
                f"y = {y:g} is {stop.side} the wall stops.{i} at y = {stop.at}; {BEHIND_A_WALL}"
            )
            problems.append(Fault("x0", start.x0, reason))
    return problems
