"""Loads of a structure: forcings on coordinates, along directions or at points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Phase, PiTimes, angle, as_float, plain
from percuss.model.faults import (
    Fault,
    as_tuple,
    dotted,
    draft,
    faults,
    is_row,
    phase_faults,
    raise_first,
)
from percuss.model.forcing import Forcing
from percuss.model.oscillator import On, plain_on
from percuss.model.structure import Structure, on_faults
from percuss.numerics import matmul


@dataclass(frozen=True, slots=True, init=False, repr=False)
class Loads:
    """The forces on a structure, each a forcing on a coordinate, along a direction or at a point.

    Parameters
    ----------
    loads
        Forcings by what they act on: the index of a coordinate, a direction c as a tuple of n
        numbers, which is not normalised, or the name of a point. The load is c f(t). For one that
        is per unit mass, such as `base_excitation` makes, it is M c f(t).
    period
        A common period [time], > 0, of all loads that are not constant: it is not guessed, and
        without it loads of different periods have none. May be a multiple of pi.

    Attributes
    ----------
    items
        Pairs of what a load acts on and its forcing, in the order given, which is that of the paths
        ``loads.0``, ``loads.1``.
    given_period
        The period as it was given, or None; `period` is the one that holds.

    Raises
    ------
    ParameterError
        If a value is outside its domain, or the period does not fit a load.

    Examples
    --------
    >>> import percuss as pc
    >>> loads = pc.Loads({0: pc.cosine(2.0), (1.0, -1.0): pc.record([0, 1], [0, 3])})
    >>> loads.directions(pc.Structure(mass=[1, 1], stiffness=[1, 1]))
    array([[ 1.,  0.],
           [ 1., -1.]])
    """

    items: tuple[tuple[On, Forcing], ...]
    given_period: Phase | None = field(default=None, metadata={"given_as": "period"})

    def __init__(
        self,
        loads: Mapping[Any, Forcing] | Iterable[tuple[On, Forcing]] = (),
        period: Phase | None = None,
    ) -> None:
        items = tuple((plain_on(on), forcing) for on, forcing in _pairs(loads))
        object.__setattr__(self, "items", items)
        object.__setattr__(self, "given_period", plain(period))
        raise_first(faults(self))

    def __repr__(self) -> str:
        items = ", ".join(f"{on!r}: {forcing!r}" for on, forcing in self.items)
        more = "" if self.given_period is None else f", period={self.given_period!r}"
        return f"Loads({{{items}}}{more})"

    def __len__(self) -> int:
        return len(self.items)

    @property
    def forcings(self) -> tuple[Forcing, ...]:
        """The forcings, in their order."""
        return tuple(forcing for _, forcing in self.items)

    def directions(self, structure: Structure) -> Floats:
        """Return the directions c of the loads c f(t), those of loads per unit mass times M.

        Parameters
        ----------
        structure
            The structure.

        Returns
        -------
        array
            (n_loads, n).

        Raises
        ------
        ParameterError
            If a load acts on nothing that the structure has.
        """
        raise_first(_on_structure_faults(self, structure))
        rows = np.zeros((len(self.items), structure.n))
        for i, (on, forcing) in enumerate(self.items):
            direction = structure.direction(on)
            rows[i] = matmul(structure.mass_matrix, direction) if forcing.is_per_mass else direction
        return rows

    @property
    def is_constant(self) -> bool:
        """Whether all loads are constants."""
        return all(forcing.is_constant for forcing in self.forcings)

    @property
    def exact_period(self) -> PiTimes | None:
        """The period as the exact number that it is or was given as; None without one."""
        if self.given_period is not None:
            return PiTimes(*angle(self.given_period))
        periods = {force.exact_period for force in self.forcings if not force.is_constant}
        return periods.pop() if len(periods) == 1 else None

    @property
    def period(self) -> float | None:
        """Period [time]; None for constant loads, and for several periods without ``period=``."""
        exact = self.exact_period
        return None if exact is None else as_float(exact)


def _pairs(loads: Any) -> tuple[tuple[Any, Any], ...]:
    """Return the pairs of what is given, or say what loads are given as."""
    pairs = tuple(loads.items()) if isinstance(loads, Mapping) else as_tuple(loads)
    if not isinstance(pairs, tuple) or not all(is_row(p) and len(tuple(p)) == 2 for p in pairs):
        raise ParameterError("loads", loads, "not forces by what they act on, {0: pc.cosine(2)}")
    return pairs


def loads_of(structure: Structure, loads: object = None) -> Loads:
    """Return what acts on a structure as loads, checked against its coordinates.

    Parameters
    ----------
    structure
        The structure.
    loads
        Loads, or a mapping that gives them; for one coordinate a Forcing; None for none.

    Returns
    -------
    Loads
        The loads.

    Raises
    ------
    ParameterError
        If it is none of these, or a load acts on nothing that the structure has.

    Examples
    --------
    >>> import percuss as pc
    >>> loads_of(pc.Structure(mass=1, stiffness=4), pc.cosine(2.0)).items[0][0]
    0
    """
    if loads is None:
        return Loads()
    if isinstance(loads, Forcing):
        if structure.n > 1:
            reason = f"one force for {structure.n} coordinates; give Loads({{0: force}})"
            raise ParameterError("loads", loads, reason)
        return Loads({0: loads})
    if isinstance(loads, Mapping):
        loads = Loads(loads)
    if not isinstance(loads, Loads):
        raise ParameterError("loads", loads, "not Loads; give Loads({0: force})")
    raise_first(_on_structure_faults(loads, structure))
    return loads


def _on_structure_faults(loads: Loads, structure: Structure) -> list[Fault]:
    return [
        fault
        for i, (on, _) in enumerate(loads.items)
        for fault in on_faults(structure, on, f"loads.{i}")
    ]


@faults.register
def _(value: Loads, prefix: str | None = None) -> list[Fault]:
    prefix = "loads" if prefix is None else prefix
    problems = []
    for i, (on, forcing) in enumerate(value.items):
        name = dotted(prefix, f"{i}")
        if isinstance(on, bool) or not isinstance(on, int | str | tuple):
            reason = "neither a coordinate's index nor a direction's tuple nor a point's name"
            problems.append(Fault(name, on, reason))
        if isinstance(forcing, Forcing):
            problems += faults(forcing, name)
        else:
            reason = "not a Forcing; cosine(2) makes one, and forcings can be added"
            problems.append(Fault(name, forcing, reason))
    return problems or _period_faults(value, prefix)


def _period_faults(loads: Loads, prefix: str) -> list[Fault]:
    name, period = dotted(prefix, "period"), loads.given_period
    if period is None:
        return []
    problems = phase_faults(name, period)
    if not problems and loads.is_constant:
        return [Fault(name, period, "given for constant loads; there is nothing to repeat")]
    for i, forcing in enumerate(loads.forcings):
        if problems or forcing.is_constant:
            continue
        of_load = draft(
            Forcing,
            harmonics=forcing.harmonics,
            period=period,
            base=forcing.base,
            record=forcing.record,
        )
        problems += [
            Fault(name, period, f"for loads.{i}: {fault.reason}")
            for fault in faults(of_load, prefix)
        ]
    return problems
