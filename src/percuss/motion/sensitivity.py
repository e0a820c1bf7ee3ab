"""The derivative of a run by parameters, and of its measures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats
from percuss.kernels import record as columns
from percuss.kernels import sensitivity as engine
from percuss.model.moved_law import moved_law
from percuss.motion.moved_measures import MovedMeasure, measure_and_derivative
from percuss.motion.moved_motion import (
    AnyMotion,
    MovedContacts,
    MovedCrossings,
    MovedImpacts,
    MovedMotion,
    varied_record,
    workspace_of,
)

__all__ = ["Sensitivity", "sensitivity_of"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sensitivity(MovedMotion):
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
        return measure_and_derivative(self, measure)[1]


def sensitivity_of(
    run: AnyMotion, paths: Sequence[str], begin: Floats | None = None
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
    varied = varied_record(run, moved)
    events, marks = run.record
    out = np.empty((len(events), len(moved.paths), engine.SENSITIVITY_COLUMNS))
    engine.carry(varied, moved.begin if begin is None else begin, workspace_of(varied), out)
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
        grazes=np.unique(np.concatenate([varied.touches, landings])),
        run=run,
        moved=moved,
        columns=out,
    )


def _crossing_rows(run: AnyMotion) -> list[int]:
    """Return the row of each crossing: stops that share an edge are crossed together."""
    marks, edges = run.record[1], run.system.lines.edges
    rows = np.flatnonzero(marks[:, columns.KIND] == columns.CROSSING).tolist()
    return [row for row in rows for _ in edges[int(marks[row, columns.BOUND])]]
