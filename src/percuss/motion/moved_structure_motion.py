"""The derivative of a structure's motion by parameters, called with times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, row_of
from percuss.kernels.structure import sensitivity as engine
from percuss.kernels.structure.run import StructureRun, new_run
from percuss.kernels.structure.sensitivity import ColumnRecord, VariedRun
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import reals
from percuss.model.loads import Loads
from percuss.model.moved_structure import MovedStructure
from percuss.model.oscillator import On
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.extremes import Extrema, QuantityName
from percuss.motion.instants import check_limit, times_within
from percuss.motion.moved_motion import AnyMotion, MovedEvents
from percuss.motion.tables import Limit


class AnyStructureMotion(AnyMotion, Protocol):
    """A motion of a structure as its derivative reads it, such as a `StructureTrajectory`."""

    @property
    def system(self) -> StructureSystem:
        """The structure and its loads."""
        ...

    @property
    def structure(self) -> Structure:
        """The structure."""
        ...

    @property
    def loads(self) -> Loads:
        """What acts on it."""
        ...

    @property
    def start(self) -> StructureStart:
        """Its start."""
        ...

    @property
    def record(self) -> StructureRun:
        """Its events, marks and modes."""
        ...

    def extremes(self, of: QuantityName, stop: int = 0, on: On | None = None) -> Extrema:
        """Return the extreme values of a quantity."""
        ...


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class MovedStructureMotion(MovedEvents):
    """The derivative of a structure's motion by parameters; see `StructureSensitivity`.

    Its attributes are told there.
    """

    run: AnyStructureMotion
    moved: MovedStructure
    varied: VariedRun
    begin: Floats
    columns: ColumnRecord

    def __call__(self, t: ArrayLike, limit: Limit = "after") -> tuple[Floats, Floats]:
        """Return the derivatives of x and v at fixed times t.

        Parameters
        ----------
        t
            Times in the run, of any shape [time].
        limit
            Which side to take at the very instant of an event: there both jump.

        Returns
        -------
        tuple of arrays
            dx and dv, of t's shape + (n, n_parameters); NaN from a graze on.

        Raises
        ------
        ParameterError
            If a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
        >>> run = pc.simulate(pair, v0=[1, 0], t_end=10)
        >>> dx, dv = run.sensitivity(["start.v0.0"])(0.25)
        >>> dx[:, 0], dv[:, 0]
        (array([0.25, 0.  ]), array([1., 0.]))
        """
        check_limit(limit)
        instants = reals("t", t)
        inside = times_within(instants, self.run.t0, self.run.t_end)
        flat = row_of(inside)
        n, count = self.run.structure.n, len(self.paths)
        motion = np.empty((len(flat), 2, n, count))
        varied = scratch_of(self.varied)
        _, work = engine.new_columns(varied)
        engine.columns_at(varied, self.columns, flat, limit == "after", work, motion)
        shape = (*instants.shape, n, count)
        return motion[:, 0].reshape(shape), motion[:, 1].reshape(shape)


def scratch_run(run: StructureRun) -> StructureRun:
    """Return a run with arrays to write into: two threads may evaluate one result."""
    fresh = new_run(run.sets, 0, 0)
    return fresh._replace(events=run.events, marks=run.marks, states=run.states, grazes=run.grazes)


def scratch_of(varied: VariedRun) -> VariedRun:
    """Return a run with its change, with arrays to write into; see `scratch_run`."""
    return varied._replace(run=scratch_run(varied.run))


def rates_at(varied: VariedRun, t: float, *, after: bool = True) -> Floats:
    """Return velocities and accelerations at an instant, (2, n), on one side of an event there."""
    own = scratch_of(varied)
    out = np.empty((2, len(own.run.begin)))
    engine.rates_at(own.run, t, after, out)
    return out
