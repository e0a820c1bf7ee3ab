"""The events of a certified run as columns of balls."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from flint import arb
from numpy.typing import NDArray

from percuss.arrays import Integers
from percuss.certified.balls import Balls
from percuss.certified.march import MarchRecord
from percuss.certified.numbers import ball
from percuss.certified.system import BallSystem
from percuss.motion.tables import COLUMNS

if TYPE_CHECKING:
    # A second of import, and only the datasets need it.
    from xarray import Dataset

__all__ = [
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


@dataclass(frozen=True, slots=True, repr=False)
class CertifiedImpacts:
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

    def to_dataset(self) -> Dataset:
        """Return the columns over `impact`, with a ``_radius`` beside each column of balls.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
        >>> pc.certify(run).impacts.to_dataset().v_after.values
        array([0.5 , 0.25])
        """
        return _dataset(self, "impact")

    def __len__(self) -> int:
        """Return the number of impacts."""
        return len(self.t)

    def __repr__(self) -> str:
        """Tell how many there are, and how well they are known."""
        return _told("CertifiedImpacts", self.t)


@dataclass(frozen=True, slots=True, repr=False)
class CertifiedCrossings:
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

    t: Balls
    v: Balls
    stop: Integers
    direction: NDArray[np.str_]

    def to_dataset(self) -> Dataset:
        """Return the columns over `crossing`, with a ``_radius`` beside each column of balls."""
        return _dataset(self, "crossing")

    def __len__(self) -> int:
        """Return the number of crossings."""
        return len(self.t)

    def __repr__(self) -> str:
        """Tell how many there are, and how well they are known."""
        return _told("CertifiedCrossings", self.t)


@dataclass(frozen=True, slots=True, repr=False)
class CertifiedContacts:
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

    start: Balls
    release: Balls
    stop: Integers
    n_impacts: Integers

    def to_dataset(self) -> Dataset:
        """Return the columns over `contact`, with a ``_radius`` beside each column of balls."""
        return _dataset(self, "contact")

    def __len__(self) -> int:
        """Return the number of contacts."""
        return len(self.start)

    def __repr__(self) -> str:
        """Tell how many there are, and how well they are known."""
        return _told("CertifiedContacts", self.start)


@dataclass(frozen=True, slots=True, repr=False)
class CertifiedGrazes:
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

    t: Balls
    stop: Integers
    clearance: Balls

    def to_dataset(self) -> Dataset:
        """Return the columns over `graze`, with a ``_radius`` beside each column of balls."""
        return _dataset(self, "graze")

    def __len__(self) -> int:
        """Return 0 or 1."""
        return len(self.t)


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


def _dataset(table: object, dimension: str) -> Dataset:
    import xarray

    data: dict[str, object] = {}
    for name, meaning in COLUMNS[dimension].items():
        # What floats tell by an error bound is the radius here.
        if name == "error_bound":
            continue
        column = getattr(table, name)
        if not isinstance(column, Balls):
            data[name] = dimension, column, {"long_name": meaning}
            continue
        data[name] = dimension, column.mid(), {"long_name": meaning}
        about = {"long_name": f"radius of the {meaning}"}
        data[f"{name}_radius"] = dimension, column.radius(), about
    return xarray.Dataset(data)


def _told(name: str, t: Balls) -> str:
    if len(t) == 0:
        return f"<{name}: 0>"
    return f"<{name}: {len(t)}, {t.digits().min():.3g} digits of time or more>"
