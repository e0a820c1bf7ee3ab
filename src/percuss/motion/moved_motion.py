"""The derivative of a motion by parameters, and the tables of those of its events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight_columns import (
    MOST_TERMS,
    PHASE_ENTRIES,
    SHARED_ENTRIES,
    ColumnWorkspace,
)
from percuss.kernels.law_columns import N_HARMONICS
from percuss.kernels.record import MotionRecord
from percuss.kernels.sensitivity import VariedRecord
from percuss.model.exact import reals
from percuss.model.moved_law import MovedLaw
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.start import Start
from percuss.model.system import System
from percuss.motion.extremes import Extrema, QuantityName
from percuss.motion.tables import Contacts, Crossings, Grazes, Impacts, Limit

__all__ = [
    "AnyMotion", "MovedContacts", "MovedCrossings", "MovedImpacts", "MovedMotion", "varied_record",
    "workspace_of",
]  # fmt: skip


class AnyMotion(Protocol):
    """What a derivative reads of a motion, as a `Trajectory` has it."""

    @property
    def system(self) -> System:
        """Oscillator and forcing."""
        ...

    @property
    def oscillator(self) -> Oscillator:
        """What moves."""
        ...

    @property
    def start(self) -> Start:
        """Its start."""
        ...

    @property
    def x0(self) -> float:
        """Where it starts."""
        ...

    @property
    def t0(self) -> float:
        """When it starts."""
        ...

    @property
    def t_end(self) -> float:
        """When it ends."""
        ...

    @property
    def record(self) -> tuple[Floats, Integers]:
        """Its events and marks."""
        ...

    @property
    def impacts(self) -> Impacts:
        """Its impacts."""
        ...

    @property
    def crossings(self) -> Crossings:
        """Its crossings."""
        ...

    @property
    def contacts(self) -> Contacts:
        """Its contacts."""
        ...

    @property
    def grazes(self) -> Grazes:
        """Its grazes."""
        ...

    def __call__(self, t: ArrayLike, limit: Limit = "after") -> tuple[Floats, Floats]:
        """Return x and v at times t."""
        ...

    def within(self, instants: Floats) -> Floats:
        """Return instants that lie in the motion."""
        ...

    def extremes(self, of: QuantityName, stop: int = 0) -> Extrema:
        """Return the extreme values of a quantity."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class MovedImpacts:
    """The derivatives of the impacts of a run.

    Attributes
    ----------
    t, v_before, v_after
        (n_impacts, n_parameters) arrays, of the columns of `Impacts` of the same names.
    """

    t: Floats
    v_before: Floats
    v_after: Floats


@dataclass(frozen=True, slots=True, eq=False)
class MovedCrossings:
    """The derivatives of the crossings of edges of soft stops.

    Attributes
    ----------
    t, v
        (n_crossings, n_parameters) arrays, of the columns of `Crossings` of the same names.
    """

    t: Floats
    v: Floats


@dataclass(frozen=True, slots=True, eq=False)
class MovedContacts:
    """The derivatives of the contacts with walls.

    Attributes
    ----------
    start, release
        (n_contacts, n_parameters) arrays, of the columns of `Contacts` of the same names: where a
        chatter accumulates, and where the wall lets go. NaN where there is none.
    """

    start: Floats
    release: Floats


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class MovedMotion:
    """The derivative of a motion by parameters.

    Called with times, it gives the derivatives of x and v there.

    Attributes
    ----------
    paths
        The parameters, in their long form; the last axis of all arrays.
    impacts, crossings, contacts
        Derivatives of the events.
    grazes
        (n,) array, the instants from which on the motion is not differentiable: at a graze of a
        wall it goes like the square root of the parameter, on the side on which there is an impact
        [time]. A contact with a wall ends that.
    run
        The run.
    moved
        How the parameters move its law.
    columns
        (n_events, n_parameters, 6) array, as the kernels wrote it.
    """

    paths: tuple[str, ...]
    impacts: MovedImpacts
    crossings: MovedCrossings
    contacts: MovedContacts
    grazes: Floats
    run: AnyMotion
    moved: MovedLaw
    columns: Floats

    @property
    def differentiable(self) -> bool:
        """Whether the whole motion has a derivative."""
        return len(self.grazes) == 0

    @property
    def reason(self) -> str:
        """Why not, empty if it has."""
        if self.differentiable:
            return ""
        return (
            f"the motion grazes a wall at t = {self.grazes[0]:.10g}; from there on it goes like the "
            "square root of the parameter on the side on which there is an impact"
        )

    def __repr__(self) -> str:
        """Return what it is the derivative by, in a line."""
        ends = f"; {self.reason}" if self.reason else ""
        return f"<Sensitivity: by {', '.join(self.paths)}{ends}>"

    def __call__(self, t: ArrayLike, limit: Limit = "after") -> tuple[Floats, Floats]:
        """Return the derivatives of x and v at times t, which stay.

        Parameters
        ----------
        t
            Times in the run, of any shape [time].
        limit
            Which side to take at the very instant of an event: there both jump.

        Returns
        -------
        tuple of arrays
            dx and dv, of t's shape + (n_parameters,); NaN from a graze on.

        Raises
        ------
        ParameterError
            If a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=2.0)
        >>> dx, dv = run.sensitivity(["start.v0"])([0.5, 1.0])
        >>> dx[:, 0].round(6)
        array([0.479426, 0.841471])
        """
        if limit not in ("after", "before"):
            raise ParameterError("limit", limit, 'neither "after" nor "before"')
        instants = self.run.within(reals("t", t))
        flat = np.ascontiguousarray(instants).reshape(-1)
        n = len(self.paths)
        motion = np.empty((2, len(flat), n))
        varied = varied_record(self.run, self.moved)
        engine.columns_at(
            varied, self.columns, flat, limit == "after", workspace_of(varied), motion
        )
        shape = (*instants.shape, n)
        return motion[0].reshape(shape), motion[1].reshape(shape)


def varied_record(run: AnyMotion, moved: MovedLaw) -> VariedRecord:
    """Return what the kernels take: the record, the change of the law and the grazes of walls."""
    stops = run.oscillator.stops
    at_wall = [isinstance(stops[int(stop)], Wall) for stop in run.grazes.stop]
    touches = run.grazes.t[np.array(at_wall, dtype=bool)]
    return VariedRecord(MotionRecord(run.system.law, run.x0, *run.record), moved.change, touches)


def workspace_of(varied: VariedRecord) -> ColumnWorkspace:
    """Return scratch for columns."""
    n = int(varied.record.law[0, N_HARMONICS])
    phases, arrival, scratch = np.zeros((3, n, 2))
    return ColumnWorkspace(
        phases,
        arrival,
        scratch,
        np.zeros(SHARED_ENTRIES),
        np.zeros((n, PHASE_ENTRIES)),
        np.zeros(MOST_TERMS),
        np.zeros((len(varied.change.rows), 2)),
    )
