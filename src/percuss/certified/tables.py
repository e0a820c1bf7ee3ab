"""The events of a certified run as columns of balls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar, TypeVar

import numpy as np
from flint import arb
from numpy.typing import NDArray

from percuss.arrays import Integers
from percuss.certified.ball_arithmetic import Balls, Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.march import ContactRow, CrossingRow, GrazeRow, ImpactRow, MarchRecord
from percuss.certified.system import BallSystem
from percuss.model.oscillator import mass_of
from percuss.model.units import Units
from percuss.motion.tables import COLUMNS, EventColumn, EventTable

EventRow = TypeVar("EventRow", ImpactRow, CrossingRow, ContactRow, GrazeRow)
# Types of the columns that are no balls.
ARRAYS = {"stop": "i8", "n_impacts": "i8", "direction": "<U3"}


class BallTable(EventTable):
    """The certified events of one kind; a column is `Balls`, or an array of what needs none.

    In its dataset each column of balls has a column of radii beside it, ``t_radius`` and so on.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
    >>> pc.certify(run).impacts.to_xarray().v_after.values
    array([0.5 , 0.25])
    """

    __slots__ = ()

    def _columns(self) -> Iterator[tuple[str, EventColumn, Any]]:
        for name, about in COLUMNS[self.dimension].items():
            # The error bound of a float run is the radius here.
            if name == "error_bound":
                continue
            column = getattr(self, name)
            if isinstance(column, Balls):
                radius = about._replace(meaning=f"radius of the {about.meaning}")
                yield name, about, column.mid()
                yield f"{name}_radius", radius, column.radius()
            else:
                yield name, about, column

    def __repr__(self) -> str:
        """Return the number of events, and the fewest digits of their instants."""
        digits = f", {self._instants().digits().min():.3g} digits of time or more" if self else ""
        return f"<{type(self).__name__}: {len(self)}{digits}>"


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedImpacts(BallTable):
    """The impacts on walls, in order: each proven to be there, and to be the next.

    Attributes
    ----------
    t
        Instants [time].
    v_before, v_after
        Velocities just before and just after [length/time].
    stop
        (n,) array, index into the oscillator's `stops`.
    cycle
        (t / period) mod 1, in [0, 1) up to the radius; NaN without a period.
    intervals
        Flight times [time]: from the impact before, the first from the start.
    impulse
        The wall's impulse on the mass [mass length/time]; per unit mass without a mass.
    mass, units
        Those of the oscillator, or None.
    """

    dimension: ClassVar[str] = "impact"
    t: Balls
    v_before: Balls
    v_after: Balls
    stop: Integers
    cycle: Balls
    intervals: Balls
    impulse: Balls
    mass: float | None = None
    units: Units | None = None


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedCrossings(BallTable):
    """The crossings of the edges of soft stops, in order.

    Attributes
    ----------
    t, v
        Instants [time] and velocities [length/time].
    stop
        (n,) array, index into the oscillator's `stops`.
    direction
        (n,) array of "in" and "out".
    """

    dimension: ClassVar[str] = "crossing"
    t: Balls
    v: Balls
    stop: Integers
    direction: NDArray[np.str_]
    units: Units | None = None


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedContacts(BallTable):
    """The times of contact: the mass is held at a wall.

    Attributes
    ----------
    start
        The end of a chatter, or a touchdown [time].
    release
        The change of sign of the force [time]; NaN where none comes.
    stop
        (n,) array, index into the oscillator's `stops`.
    n_impacts
        (n,) array, how many of the run's impacts are listed before it.
    """

    dimension: ClassVar[str] = "contact"
    start: Balls
    release: Balls
    stop: Integers
    n_impacts: Integers
    units: Units | None = None


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedGrazes(BallTable):
    """The touch at which a proof ended, or no row.

    Attributes
    ----------
    t
        The instant of the touch, or of the last event before it [time].
    stop
        (n,) array, index into the oscillator's `stops`.
    clearance
        Distance to the stop [length]: a ball that holds zero.
    """

    dimension: ClassVar[str] = "graze"
    t: Balls
    stop: Integers
    clearance: Balls
    units: Units | None = None


def impacts_of(system: BallSystem, rows: list[ImpactRow], start: arb) -> CertifiedImpacts:
    """Return impacts as a table, the first interval from an instant on."""
    instants = [row.t for row in rows]
    force, period = system.forcing, _period_of(system)
    if force is None or period is None:
        cycles = [arb.nan()] * len(rows)
    else:
        periods = [t / period for t in instants]
        cycles = [number - number.mid().floor().mid() for number in periods]
    t, v_before, v_after, stop = _columns_of(ImpactRow, rows)
    intervals = (later - earlier for earlier, later in pairwise([start, *instants]))
    mass = law_of(system).mass
    impulses = (mass * (row.v_after - row.v_before) for row in rows)
    return CertifiedImpacts(
        t,
        v_before,
        v_after,
        stop,
        Balls.of(cycles),
        Balls.of(intervals),
        Balls.of(impulses),
        mass_of(system.oscillator),
        system.oscillator.units,
    )


def _period_of(system: BallSystem) -> arb | None:
    try:
        return law_of(system).period(1)
    except Undecided:
        return None


def crossings_of(system: BallSystem, record: MarchRecord) -> CertifiedCrossings:
    """Return the crossings of a record."""
    t, v, stop, direction = _columns_of(CrossingRow, record.crossings)
    return CertifiedCrossings(t, v, stop, direction, system.oscillator.units)


def contacts_of(system: BallSystem, record: MarchRecord) -> CertifiedContacts:
    """Return the contacts of a record."""
    start, release, stop, n_impacts = _columns_of(ContactRow, record.contacts)
    return CertifiedContacts(start, release, stop, n_impacts, system.oscillator.units)


def grazes_of(system: BallSystem, record: MarchRecord) -> CertifiedGrazes:
    """Return the touch at which a record ends, or none."""
    t, stop, clearance = _columns_of(GrazeRow, record.grazes)
    return CertifiedGrazes(t, stop, clearance, system.oscillator.units)


def _columns_of(kind: type[EventRow], rows: Sequence[EventRow]) -> Iterator[Any]:
    """Yield the fields of rows as columns: balls, with NaN for None, or arrays."""
    for name in kind._fields:
        values = [getattr(row, name) for row in rows]
        if name in ARRAYS:
            yield np.array(values, dtype=ARRAYS[name])
        else:
            yield Balls.of(arb.nan() if value is None else value for value in values)
