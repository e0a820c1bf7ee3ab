"""The derivative of a structure's run by parameters, and of its measures."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.restitution import restitution_at
from percuss.kernels.sample import flight_at
from percuss.kernels.structure import sensitivity as engine
from percuss.kernels.structure.basis import wall_of
from percuss.kernels.structure.sensitivity import ColumnRecord, VariedRun
from percuss.model.moved_law import moved_period
from percuss.model.moved_structure import MovedStructure, moved_sets, moved_structure
from percuss.model.oscillator import On, Wall
from percuss.motion.moved_measures import MovedMeasure, MovedValue
from percuss.motion.moved_motion import (
    MovedContacts,
    MovedCrossings,
    MovedGrazes,
    MovedImpacts,
    moved_end,
)
from percuss.motion.moved_structure_motion import (
    AnyStructureMotion,
    MovedStructureMotion,
    rates_at,
    scratch_of,
)
from percuss.motion.structure_measures import structure_measure_and_derivative

# A difference below this part of its terms is rounding.
ROUNDED = 1e-14


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StructureSensitivity(MovedStructureMotion):
    """The derivative of a structure's motion by parameters; made by `StructureTrajectory.sensitivity`.

    Called with times, it gives the derivatives of x and v there, of shape t.shape + (n,
    n_parameters).

    Attributes
    ----------
    paths
        The parameters, in their long form; the last axis of all arrays.
    impacts, crossings, contacts
        Derivatives of the events; velocities are those of y = c . x.
    grazes
        Where the motion is not differentiable, and how it goes from there on.
    run
        The run.
    moved
        How the parameters move its equation.
    varied, begin
        What the kernels took: the record with its change and grazes, and the (2 n + 1,
        n_parameters) derivatives of x, v and t of the start.
    columns
        The columns of all events, as the kernels wrote them.
    """

    def of(self, measure: MovedMeasure, on: On | None = None) -> Floats:
        """Return the derivative of a measure of the run.

        Parameters
        ----------
        measure
            A name as `Sensitivity.of` takes it.
        on
            A coordinate, a direction c or the name of a point, of measures of a displacement or an
            acceleration; not needed for one coordinate.

        Returns
        -------
        (n_parameters,) array
            The derivatives; NaN if the motion grazes a wall before.

        Raises
        ------
        ParameterError
            If there is no such measure or direction, or it has no derivative.

        Examples
        --------
        >>> import percuss as pc
        >>> two = pc.chain(masses=[1, 1], springs=[1, 1, 1])
        >>> run = pc.simulate(two, x0=[0, 0], v0=[3, -3], t_end=2)
        >>> run.sensitivity(["start.v0.0"]).of("max_displacement", on=(1, -1)).round(9)
        array([0.57735027])
        """
        return self.measured(measure, on)[1]

    def measured(self, measure: str, on: On | None = None) -> MovedValue:
        """Return a measure of the run and its derivatives; see `of`."""
        return structure_measure_and_derivative(self, measure, on, self.longer)

    @property
    def longer(self) -> Floats | None:
        """The derivatives of the run's end; None where no parameter is known to move it."""
        return moved_end(self.run, self.paths, self.begin[-1], lambda: structure_slowing_of(self))

    def one_sided(self) -> StructureSensitivity:
        """Return the derivative on the side on which no graze of a wall becomes an impact.

        Returns
        -------
        StructureSensitivity
            That for changes of each parameter with the sign in ``grazes.sides``; NaN from the first
            graze on where that is 0.
        """
        varied = self.varied._replace(jumps=self.grazes.passed(self.varied.jumps))
        return _carried(self.run, self.moved, varied, self.begin, self.grazes)

    def square_root(self) -> StructureSensitivity:
        """Return the coefficients of the square root on the side on which there is an impact.

        Returns
        -------
        StructureSensitivity
            What is added per square root of the change of a parameter, to first order: 0 before the
            first graze, NaN from the second one on.
        """
        given = self.varied.moved
        still = {name: np.zeros_like(value) for name, value in given._asdict().items()}
        change = given._replace(**{**still, "units": given.units})
        jumps = np.full_like(self.varied.jumps, np.nan)
        if len(jumps):
            stop = int(self.grazes.stop[0])
            region, bound = wall_of(self.varied.run.sets, stop)
            law = self.varied.run.sets.walls[stop]
            jumps[0] = (1.0 + restitution_at(law, region, bound, 0.0)) * self.grazes.speed[0]
        varied = self.varied._replace(moved=change, jumps=jumps)
        return _carried(self.run, self.moved, varied, np.zeros_like(self.begin), self.grazes)


def structure_sensitivity_of(
    run: AnyStructureMotion, paths: Sequence[str], begin: Floats | None = None
) -> StructureSensitivity:
    """Return the derivative of a structure's run by parameters.

    Parameters
    ----------
    run
        The run.
    paths
        The parameters; see `StructureTrajectory.sensitivity`.
    begin
        (2 n + 1, n_parameters) array, the derivatives of x, v and t of the start, where they are
        not those of the paths.

    Returns
    -------
    StructureSensitivity
        The derivative.
    """
    system = run.system
    moved = moved_structure(
        system, run.start if begin is None else None, paths, (run.end, run.periods)
    )
    own = np.ascontiguousarray(moved.begin.T) if begin is None else begin
    record = run.record
    stops = _touched(run)
    graze_times = run.grazes.t[stops >= 0]
    jumps = np.full((len(graze_times), len(moved.paths)), np.nan)
    graze_stops = stops[stops >= 0]
    varied = VariedRun(
        record, moved_sets(system, moved, record.sets), graze_times, graze_stops, jumps
    )
    none = MovedGrazes(graze_times, graze_stops, jumps, jumps)
    carried = _carried(run, moved, varied, own, none)
    if len(graze_times) or _landed(carried).any():
        passing = varied._replace(jumps=np.zeros_like(jumps))
        grazes = _grazes(_carried(run, moved, passing, own, none))
        return dataclasses.replace(carried, grazes=grazes)
    return carried


def structure_slowing_of(d: MovedStructureMotion) -> Floats:
    """Return the derivatives of the logarithm of the loads' period; see `moved_period`."""
    rates = np.array([loads.rates for loads in d.moved.loads])
    return moved_period(rates.T, d.run.structure, d.run.loads, d.paths)


def _touched(run: AnyStructureMotion) -> Integers:
    """Return the wall that each graze touches; -1 where it is none, or one that holds."""
    record = run.record
    stops = []
    for t, stop in zip(run.grazes.t.tolist(), run.grazes.stop.tolist(), strict=True):
        row = flight_at(record.events, t, True)
        key = int(record.sets.keys[record.marks[row, columns.NEXT_REGION]])
        is_wall = isinstance(run.structure.stops[stop], Wall)
        stops.append(stop if is_wall and not key >> stop & 1 else -1)
    return np.array(stops, dtype=np.int64)


def _carried(
    run: AnyStructureMotion,
    moved: MovedStructure,
    varied: VariedRun,
    begin: Floats,
    grazes: MovedGrazes,
) -> StructureSensitivity:
    """Return the derivative with its columns, as the kernel carries them over the record."""
    varied = scratch_of(varied)
    out, work = engine.new_columns(varied)
    engine.carry_columns(varied, begin, out, work)
    marks = varied.run.marks
    kinds, stops = marks[:, columns.KIND], marks[:, columns.BOUND]

    def rows(kind: np.int64) -> tuple[Integers, Floats]:
        numbers = np.flatnonzero(kinds == kind)
        # A clearance grows above a wall below, and falls with y below a wall above.
        return numbers, run.system.signs[stops[numbers], None]

    struck, signs = rows(columns.IMPACT)
    crossed, sides = rows(columns.CROSSING)
    contacts, _ = rows(columns.CONTACT)
    return StructureSensitivity(
        paths=moved.paths,
        impacts=MovedImpacts(
            out.instants[struck, engine.DT],
            signs * out.instants[struck, engine.DV_BEFORE],
            signs * out.instants[struck, engine.DV_AFTER],
        ),
        crossings=MovedCrossings(
            out.instants[crossed, engine.DT], sides * out.instants[crossed, engine.DV_BEFORE]
        ),
        contacts=MovedContacts(out.instants[contacts, engine.DT], _releases(run, contacts, out)),
        grazes=grazes,
        run=run,
        moved=moved,
        varied=varied,
        begin=begin,
        columns=out,
    )


def _releases(run: AnyStructureMotion, contacts: Integers, out: ColumnRecord) -> Floats:
    """Return how the ends of contacts move: with the event at which a contact ends."""
    releases = np.full((len(contacts), out.instants.shape[2]), np.nan)
    events = run.record.events
    for k in range(len(contacts)):
        t = float(run.contacts.release[k])
        if np.isnan(t):
            continue
        row = int(np.flatnonzero(events[:, columns.EVENT_T] == t)[-1])
        releases[k] = out.instants[row, engine.DT]
    return releases


def _landed(d: StructureSensitivity) -> Flags:
    """Return which events leave the structure on a wall within rounding."""
    return np.asarray(d.varied.run.marks[:, columns.KIND] == columns.SLOW_LANDING)


def _grazes(passing: StructureSensitivity) -> MovedGrazes:
    """Return how the grazes of walls depend on the parameters, from columns that pass them."""
    varied, record = passing.varied, passing.varied.run
    landed = _landed(passing)
    n = len(varied.graze_times)
    instants = np.concatenate([varied.graze_times, record.events[landed, columns.EVENT_T]])
    stop = np.concatenate([varied.graze_stops, record.marks[landed, columns.BOUND]])
    order = np.argsort(instants, kind="stable")
    reach = np.full((len(instants), len(passing.paths)), np.nan)
    speed = reach.copy()
    for k in range(n):
        t, normal = float(instants[k]), record.sets.normals[stop[k]]
        dx, dv = passing(t)
        away = varied.moved.levels[stop[k]]
        reach[k] = away - (normal[:, None] * dx).sum(axis=0)
        # What rounding, of the instant too, leaves of a parameter that moves wall and motion alike.
        terms = np.abs(normal[:, None] * dx).sum(axis=0) + np.abs(away)
        terms += max(abs(t), t - passing.run.t0) * np.abs(normal[:, None] * dv).sum(axis=0)
        reach[k, np.abs(reach[k]) <= ROUNDED * terms] = 0.0
        push = float((normal * rates_at(varied, t)[1]).sum())
        speed[k] = np.sqrt(2.0 * max(push, 0.0) * np.abs(reach[k]))
    return MovedGrazes(instants[order], stop[order], reach[order], speed[order])
