"""The derivative of a motion, and of what is read off it, by parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight_columns import MOST_TERMS, PHASE_ENTRIES, SHARED_ENTRIES, Workspace
from percuss.kernels.law_columns import N_HARMONICS
from percuss.kernels.record import MotionRecord
from percuss.kernels.sensitivity import Study
from percuss.model.exact import reals
from percuss.model.moved_law import MovedLaw, moved_law
from percuss.model.oscillator import Wall
from percuss.motion.moved_measures import MovedMeasure, moved_measure

if TYPE_CHECKING:
    from percuss.motion.trajectory import Limit, Trajectory

__all__ = [
    "MovedContacts", "MovedCrossings", "MovedImpacts", "Sensitivity", "sensitivity_of",
]  # fmt: skip


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
class Sensitivity:
    """The derivative of a motion by parameters; made by `Trajectory.sensitivity`.

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
    run: Trajectory
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
        study = _study(self.run, self.moved)
        engine.columns_at(study, self.columns, flat, limit == "after", _workspace(study), motion)
        shape = (*instants.shape, n)
        return motion[0].reshape(shape), motion[1].reshape(shape)

    def of(self, measure: MovedMeasure) -> Floats:
        """Return the derivative of a measure of the run.

        Parameters
        ----------
        measure
            A name as in sweeps, taken over the whole run: "max_displacement", "min_displacement",
            "peak_displacement", "peak_acceleration", "peak_stop_force", "peak_impact_velocity",
            "rms_displacement", "mean_power", "contact_share". Those that count have none.

        Returns
        -------
        (n_parameters,) array
            The derivatives; inside a flight those of an extreme value are at its instant, at an
            event they move with it. NaN if the motion grazes a wall before.

        Raises
        ------
        ParameterError
            If there is no such measure, or it has no derivative.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.Oscillator(stiffness=4), v0=1.0, t_end=2.0)
        >>> run.sensitivity(["start.v0"]).of("max_displacement")
        array([0.5])
        """
        return moved_measure(self, measure)


def sensitivity_of(
    run: Trajectory, paths: Sequence[str], begin: Floats | None = None
) -> Sensitivity:
    """Return the derivative of a run by parameters.

    Parameters
    ----------
    run
        The run.
    paths
        The parameters; see `Trajectory.sensitivity`.
    begin
        (n_parameters, 3) array, the derivatives of x, v and t of the start, where they are not
        those of the paths.

    Returns
    -------
    Sensitivity
        The derivative.
    """
    moved = moved_law(run.system, run.start if begin is None else None, paths)
    study = _study(run, moved)
    events, marks = run.record
    out = np.empty((len(events), len(moved.paths), engine.SENSITIVITY_COLUMNS))
    engine.carry(study, moved.begin if begin is None else begin, _workspace(study), out)
    kinds = marks[:, columns.KIND]
    impacts = out[kinds == columns.IMPACT]
    crossings = out[_crossing_rows(run)]
    started, released = (
        out[kinds == kind, :, engine.DT] for kind in (columns.CONTACT, columns.RELEASE)
    )
    release = np.full_like(started, np.nan)
    release[: len(released)] = released
    landings = events[kinds == columns.SLOW_LANDING, columns.EVENT_T]
    return Sensitivity(
        paths=moved.paths,
        impacts=MovedImpacts(
            impacts[..., engine.DT],
            impacts[..., engine.DV_BEFORE],
            impacts[..., engine.DV_AFTER],
        ),
        crossings=MovedCrossings(crossings[..., engine.DT], crossings[..., engine.DV_AFTER]),
        contacts=MovedContacts(started, release),
        grazes=np.unique(np.concatenate([study.touches, landings])),
        run=run,
        moved=moved,
        columns=out,
    )


def _crossing_rows(run: Trajectory) -> list[int]:
    """Return the row of each crossing: stops that share an edge are crossed together."""
    marks, edges = run.record[1], run.system.lines.edges
    rows = np.flatnonzero(marks[:, columns.KIND] == columns.CROSSING).tolist()
    return [row for row in rows for _ in edges[int(marks[row, columns.BOUND])]]


def _study(run: Trajectory, moved: MovedLaw) -> Study:
    stops = run.oscillator.stops
    at_wall = [isinstance(stops[int(stop)], Wall) for stop in run.grazes.stop]
    touches = run.grazes.t[np.array(at_wall, dtype=bool)]
    return Study(MotionRecord(run.system.law, run.x0, *run.record), moved.change, touches)


def _workspace(study: Study) -> Workspace:
    n = int(study.record.law[0, N_HARMONICS])
    phases, arrival, scratch = np.zeros((3, n, 2))
    return Workspace(
        phases,
        arrival,
        scratch,
        np.zeros(SHARED_ENTRIES),
        np.zeros((n, PHASE_ENTRIES)),
        np.zeros(MOST_TERMS),
        np.zeros((len(study.change.rows), 2)),
    )
