"""The derivative of a motion by parameters, and the tables of those of its events."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, Integers, row_of
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight_columns import (
    MOST_TERMS,
    PHASE_ENTRIES,
    SHARED_ENTRIES,
    ColumnWorkspace,
)
from percuss.kernels.law_columns import N_HARMONICS, Law
from percuss.kernels.sensitivity import VariedRecord
from percuss.model.exact import Exact, Phase, as_float, reals
from percuss.model.moved_law import MovedLaw, moved_number
from percuss.model.oscillator import Oscillator
from percuss.model.parameter_fields import is_tied
from percuss.model.start import Start
from percuss.model.system import System
from percuss.motion.extremes import Extrema, QuantityName
from percuss.motion.instants import check_limit
from percuss.motion.tables import HasEvents, Limit


class AnyMotion(HasEvents, Protocol):
    """A motion as its derivative reads it, of an oscillator or a structure."""

    @property
    def periods(self) -> Exact | None:
        """The periods of what drives it after which it ends, None where it ends otherwise."""
        ...

    @property
    def end(self) -> Phase:
        """The end as it was given."""
        ...

    def __call__(self, t: ArrayLike, limit: Limit = "after") -> tuple[Floats, Floats]:
        """Return x and v at times t."""
        ...


class AnyOscillatorMotion(AnyMotion, Protocol):
    """A motion of an oscillator as its derivative reads it, such as a `Trajectory`."""

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
    def record(self) -> tuple[Floats, Integers]:
        """Its events and marks."""
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


@dataclass(frozen=True, slots=True, eq=False)
class MovedGrazes:
    """The dependence of a motion on parameters at grazes of walls, which is like a square root.

    A parameter that grows by h takes the turning point further by ``reach`` h. Where that is
    positive there is an impact, with the speed ``speed`` sqrt(abs(h)); else there is none.

    Attributes
    ----------
    t
        (n_grazes,) array, the instants [time].
    stop
        (n_grazes,) array, index into the oscillator's `stops`.
    reach
        (n_grazes, n_parameters) array, derivatives of the distance by which the turning point would
        lie beyond the wall. NaN where the mass comes to rest on the wall by the graze, or
        is at rest on it without a force.
    speed
        (n_grazes, n_parameters) array, sqrt(2 abs(a) abs(reach)) with the acceleration a there.
    """

    t: Floats
    stop: Integers
    reach: Floats
    speed: Floats

    def __len__(self) -> int:
        """Return how many they are."""
        return len(self.t)

    @property
    def sides(self) -> Integers:
        """(n_parameters,): the sign of changes of each parameter without an impact, or 0.

        It is 0 where on either side there is one, and where the parameter moves no turning point.
        """
        sides = np.where(np.isnan(self.reach), 0.0, -np.sign(self.reach)).astype(np.int64)
        agree = (sides == sides[:1]).all(axis=0)
        return np.where(agree, sides[0], 0) if len(sides) else np.zeros(sides.shape[1], np.int64)

    def passed(self, jumps: Floats) -> Floats:
        """Return the jumps, of this shape, at grazes without an impact; NaN for sides of 0."""
        return np.broadcast_to(np.where(self.sides == 0, np.nan, 0.0), jumps.shape).copy()


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class MovedEvents:
    """The derivatives of the events of a motion by parameters.

    Attributes
    ----------
    paths
        The parameters, in their long form; the last axis of all arrays.
    impacts, crossings, contacts
        Derivatives of the events.
    grazes
        Where the motion is not differentiable, and how it goes from there on.
    """

    paths: tuple[str, ...]
    impacts: MovedImpacts
    crossings: MovedCrossings
    contacts: MovedContacts
    grazes: MovedGrazes

    @property
    def differentiable(self) -> bool:
        """Whether the whole motion has a derivative."""
        return len(self.grazes) == 0

    @property
    def reason(self) -> str:
        """Why not, empty if it has."""
        if self.differentiable:
            return ""
        sides = zip(self.paths, self.grazes.sides.tolist(), strict=True)
        free = [f"{path} {'grows' if side > 0 else 'falls'}" for path, side in sides if side]
        return (
            f"the motion grazes stop {self.grazes.stop[0]} at t = {self.grazes.t[0]:.10g}; from "
            "there on it goes like the square root of the change of a parameter that leads to an "
            "impact, and has a one-sided derivative where it leads to none"
            + (f": where {', '.join(free)}" if free else "")
        )

    def __repr__(self) -> str:
        """Return what it is the derivative by, in a line."""
        ends = f"; {self.reason}" if self.reason else ""
        return f"<Sensitivity: by {', '.join(self.paths)}{ends}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class MovedMotion(MovedEvents):
    """The derivative of a motion by parameters, called with times; see `Sensitivity`.

    Its attributes are told there.
    """

    run: AnyOscillatorMotion
    moved: MovedLaw
    varied: VariedRecord
    begin: Floats
    columns: Floats

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
        check_limit(limit)
        instants = self.run.within(reals("t", t))
        flat = row_of(instants)
        n = len(self.paths)
        motion = np.empty((2, len(flat), n))
        work = workspace_of(self.varied.record.law, n)
        engine.columns_at(self.varied, self.columns, flat, limit == "after", work, motion)
        shape = (*instants.shape, n)
        return motion[0].reshape(shape), motion[1].reshape(shape)


def moved_end(
    run: AnyMotion, paths: tuple[str, ...], begin: Floats, slowing: Callable[[], Floats]
) -> Floats | None:
    """Return the derivatives of a run's end; None where no parameter is known to move it.

    ``begin`` are those of its start, and ``slowing()`` those of the logarithm of the period of what
    drives it.
    """
    if run.periods is None:
        return moved_number(run.end, paths) if is_tied(run.end) else None
    # A parameter that leaves what drives it without a period leaves no run to compare with.
    slower = np.nan_to_num(slowing(), nan=0.0)
    more = moved_number(run.periods, paths) / as_float(run.periods)
    return np.asarray(begin + (run.t_end - run.t0) * (slower + more))


def workspace_of(law: Law, n_columns: int) -> ColumnWorkspace:
    """Return scratch for so many columns of the motion of a law."""
    n = int(law[0, N_HARMONICS])
    phases, arrival, scratch = np.zeros((3, n, 2))
    return ColumnWorkspace(
        phases,
        arrival,
        scratch,
        np.zeros(SHARED_ENTRIES),
        np.zeros((n, PHASE_ENTRIES)),
        np.zeros(MOST_TERMS),
        np.zeros((n_columns, 2)),
    )
