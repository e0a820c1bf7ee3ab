"""The events of a certified run as columns of balls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from flint import arb
from numpy.typing import NDArray

from percuss.arrays import Integers
from percuss.certified.balls import Balls
from percuss.certified.march import MarchRecord
from percuss.certified.numbers import ball
from percuss.certified.system import BallSystem
from percuss.motion.tables import COLUMNS, EventTable

__all__ = [
    "BallTable",
    "CertifiedContacts",
    "CertifiedCrossings",
    "CertifiedGrazes",
    "CertifiedImpacts",
    "contacts_of",
    "crossings_of",
    "cycles_of",
    "grazes_of",
    "impacts_of",
]


class BallTable(EventTable):
    """The certified events of one kind; a column is `Balls`, or an array of what needs none.

    In its dataset each column of balls has a column of radii beside it, ``t_radius`` and so on.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
    >>> pc.certify(run).impacts.to_dataset().v_after.values
    array([0.5 , 0.25])
    """

    __slots__ = ()

    def _columns(self) -> Iterator[tuple[str, str, Any]]:
        for name, meaning in COLUMNS[self.dimension].items():
            # The error bound of a float run is the radius here.
            if name == "error_bound":
                continue
            column = getattr(self, name)
            if isinstance(column, Balls):
                yield name, meaning, column.mid()
                yield f"{name}_radius", f"radius of the {meaning}", column.radius()
            else:
                yield name, meaning, column

    def __repr__(self) -> str:
        """Return the number of events, and the fewest digits of their instants."""
        digits = f", {self._instants().digits().min():.3g} digits of time or more" if self else ""
        return f"<{type(self).__name__}: {len(self)}{digits}>"


@dataclass(frozen=True, slots=True, repr=False)
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
        (t / period) mod 1, in [0, 1) up to the radius; no numbers without a period.
    intervals
        Flight times [time]: from the impact before, the first from the start.
    """

    dimension: ClassVar[str] = "impact"
    t: Balls
    v_before: Balls
    v_after: Balls
    stop: Integers
    cycle: Balls
    intervals: Balls

    @property
    def impulse(self) -> Balls:
        """The wall's impulse per unit mass, v_after - v_before [length/time]."""
        return Balls.of(
            after - before
            for after, before in zip(self.v_after.arbs, self.v_before.arbs, strict=True)
        )


@dataclass(frozen=True, slots=True, repr=False)
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


@dataclass(frozen=True, slots=True, repr=False)
class CertifiedContacts(BallTable):
    """The times of contact: the mass is held at a wall.

    Attributes
    ----------
    start
        Where chatter accumulates, or a touchdown [time].
    release
        Where the force lets go [time]; no number where that does not come.
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


@dataclass(frozen=True, slots=True, repr=False)
class CertifiedGrazes(BallTable):
    """The touch at which a proof has ended, or none.

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


def impacts_of(system: BallSystem, record: MarchRecord) -> CertifiedImpacts:
    """Return the impacts of a record."""
    rows = record.impacts
    instants = [row.t for row in rows]
    first = record.pieces[0].start if record.pieces else arb(0)
    return CertifiedImpacts(
        t=Balls.of(instants),
        v_before=Balls.of(row.v_before for row in rows),
        v_after=Balls.of(row.v_after for row in rows),
        stop=_numbers(row.stop for row in rows),
        cycle=cycles_of(system, instants),
        intervals=Balls.of(later - earlier for earlier, later in pairwise([first, *instants])),
    )


def cycles_of(system: BallSystem, instants: list[arb]) -> Balls:
    """Return instants in forcing periods, modulo 1; no numbers without an exact period."""
    force = system.forcing
    if force is None or force.frequency is None:
        return Balls.of([arb.nan()] * len(instants))
    turns = [t * ball(force.frequency) / (2 * arb.pi()) for t in instants]
    return Balls.of(turn - turn.mid().floor().mid() for turn in turns)


def crossings_of(record: MarchRecord) -> CertifiedCrossings:
    """Return the crossings of a record."""
    return CertifiedCrossings(
        t=Balls.of(row.t for row in record.crossings),
        v=Balls.of(row.v for row in record.crossings),
        stop=_numbers(row.stop for row in record.crossings),
        direction=np.array([row.direction for row in record.crossings], dtype="<U3"),
    )


def contacts_of(record: MarchRecord) -> CertifiedContacts:
    """Return the contacts of a record."""
    nan = arb.nan()
    return CertifiedContacts(
        start=Balls.of(row.start for row in record.contacts),
        release=Balls.of(nan if row.release is None else row.release for row in record.contacts),
        stop=_numbers(row.stop for row in record.contacts),
        n_impacts=_numbers(row.n_impacts for row in record.contacts),
    )


def grazes_of(record: MarchRecord) -> CertifiedGrazes:
    """Return the touch at which a record ends, or none."""
    return CertifiedGrazes(
        t=Balls.of(row.t for row in record.grazes),
        stop=_numbers(row.stop for row in record.grazes),
        clearance=Balls.of(row.clearance for row in record.grazes),
    )


def _numbers(values: Iterable[int]) -> Integers:
    return np.array(list(values), dtype=np.int64)
