"""The derivative of a run by parameters, and of its measures."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.kernels import record as columns
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight import constant_force, force_and_slopes, place
from percuss.kernels.law_columns import FIRST_HARMONIC, N_HARMONICS, NUMBER, OMEGA
from percuss.kernels.record import MotionRecord
from percuss.kernels.restitution import restitution_at
from percuss.kernels.sample import flight_at
from percuss.kernels.sensitivity import VariedRecord
from percuss.model.moved_law import MovedLaw, moved_law, moved_period
from percuss.model.oscillator import Wall
from percuss.motion.accelerations import phases_at
from percuss.motion.moved_measures import MovedMeasure, MovedValue
from percuss.motion.moved_motion import (
    AnyOscillatorMotion,
    MovedContacts,
    MovedCrossings,
    MovedGrazes,
    MovedImpacts,
    MovedMotion,
    moved_end,
    workspace_of,
)
from percuss.motion.oscillator_measures import measure_and_derivative

# A difference below this part of its terms is rounding.
ROUNDED = 1e-14


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
        Where the motion is not differentiable, and how it goes from there on until a contact with a
        wall ends that.
    run
        The run.
    moved
        How the parameters move its law.
    varied, begin
        What the kernels took: the record with its change and grazes, and the (n_parameters, 3)
        derivatives of x, v and t of the start.
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
        return self.measured(measure)[1]

    def measured(self, measure: str) -> MovedValue:
        """Return a measure of the run and its derivatives; see `of`."""
        return measure_and_derivative(self, measure, self.longer)

    @property
    def longer(self) -> Floats | None:
        """The derivatives of the run's end; None where no parameter is known to move it."""
        return moved_end(self.run, self.paths, self.begin[:, 2], lambda: slowing_of(self))

    def one_sided(self) -> Sensitivity:
        """Return the derivative on the side on which no graze of a wall becomes an impact.

        Returns
        -------
        Sensitivity
            That for changes of each parameter with the sign in ``grazes.sides``; NaN from the first
            graze on where that is 0.

        Examples
        --------
        A start that is slower does not come to the wall:

        >>> import percuss as pc
        >>> osc = pc.Oscillator(stops=(pc.Wall(at=1, side="above", restitution=0.8),))
        >>> d = pc.simulate(osc, v0=1, t_end=4).sensitivity(["start.v0"])
        >>> d.grazes.sides, d(3.0)[0], d.one_sided()(3.0)[0].round(6)
        (array([-1]), array([nan]), array([0.14112]))
        """
        varied = self.varied._replace(jumps=self.grazes.passed(self.varied.jumps))
        return _carried(self.run, self.moved, varied, self.begin, self.grazes)

    def square_root(self) -> Sensitivity:
        """Return the coefficients of the square root on the side on which there is an impact.

        Returns
        -------
        Sensitivity
            What is added per square root of the change of a parameter, to first order: 0 before the
            first graze, NaN from the second one on.

        Examples
        --------
        A start that is faster by h meets the wall with sqrt(2 h), and leaves it as much slower:

        >>> import percuss as pc
        >>> osc = pc.Oscillator(stops=(pc.Wall(at=1, side="above", restitution=0.8),))
        >>> d = pc.simulate(osc, v0=1, t_end=4).sensitivity(["start.v0"])
        >>> d.square_root()(3.0)[0].round(6)
        array([-2.520109])
        """
        change = self.moved.change._replace(rows=np.zeros_like(self.moved.change.rows))
        stops = np.zeros_like(self.moved.stops)
        begin = np.zeros_like(self.begin)
        moved = MovedLaw(self.moved.paths, change, begin, stops)
        jumps = np.full_like(self.varied.jumps, np.nan)
        if len(jumps):
            jumps[0] = -_rebound(self.run, self.grazes) * self.grazes.speed[0]
        varied = self.varied._replace(change=change, jumps=jumps)
        return _carried(self.run, moved, varied, begin, self.grazes)


def sensitivity_of(
    run: AnyOscillatorMotion, paths: Sequence[str], begin: Floats | None = None
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
    moved = moved_law(
        run.system, run.start if begin is None else None, paths, (run.end, run.periods)
    )
    stops = run.oscillator.stops
    at_wall = [isinstance(stops[int(stop)], Wall) for stop in run.grazes.stop]
    graze_times = run.grazes.t[np.array(at_wall, dtype=bool)]
    record = MotionRecord(run.system.law, run.x0, *run.record)
    n = len(moved.paths)
    jumps = np.full((len(graze_times), n), np.nan)
    varied = VariedRecord(record, moved.change, graze_times, jumps)
    none = MovedGrazes(graze_times, np.zeros(len(graze_times), np.int64), jumps, jumps)
    begin = moved.begin if begin is None else begin
    carried = _carried(run, moved, varied, begin, none)
    if len(graze_times) or _unheld(carried).any():
        passing = varied._replace(jumps=np.zeros_like(jumps))
        grazes = _grazes(_carried(run, moved, passing, begin, none))
        return dataclasses.replace(carried, grazes=grazes)
    return carried


def slowing_of(d: MovedMotion) -> Floats:
    """Return the derivatives of the logarithm of the forcing's period; see `moved_period`."""
    law = d.run.system.law
    rows = slice(FIRST_HARMONIC, FIRST_HARMONIC + int(law[0, N_HARMONICS]))
    # The row of a record has the derivative of the logarithm itself.
    omegas = law[rows, OMEGA]
    rates = d.moved.change.rows[:, rows, OMEGA] / np.where(omegas > 0.0, omegas, 1.0)
    return moved_period(rates.T, *d.run.system, d.paths)


def _carried(
    run: AnyOscillatorMotion,
    moved: MovedLaw,
    varied: VariedRecord,
    begin: Floats,
    grazes: MovedGrazes,
) -> Sensitivity:
    """Return the derivative with its columns, as the kernel carries them over the record."""
    events, marks = run.record
    out = np.empty((len(events), len(moved.paths), engine.SENSITIVITY_COLUMNS))
    engine.carry(varied, begin, workspace_of(varied.record.law, len(begin)), out)
    kinds = marks[:, columns.KIND]
    is_impact = kinds == columns.IMPACT
    # Mostly all events but the start are impacts: those need no copy.
    impacts = out[1:] if is_impact[1:].all() and not is_impact[0] else out[is_impact]
    crossings = out[_crossing_rows(run)]
    started, released = (
        out[kinds == kind, :, engine.DT] for kind in (columns.CONTACT, columns.RELEASE)
    )
    release = np.full_like(started, np.nan)
    release[: len(released)] = released
    return Sensitivity(
        paths=moved.paths,
        impacts=MovedImpacts(
            impacts[..., engine.DT],
            impacts[..., engine.DV_BEFORE],
            impacts[..., engine.DV_AFTER],
        ),
        crossings=MovedCrossings(crossings[..., engine.DT], crossings[..., engine.DV_AFTER]),
        contacts=MovedContacts(started, release),
        grazes=grazes,
        run=run,
        moved=moved,
        varied=varied,
        begin=begin,
        columns=out,
    )


def _unheld(d: Sensitivity) -> Flags:
    """Return which events leave the mass on a wall within rounding, or with nothing to hold it."""
    kinds = d.run.record[1][:, columns.KIND]
    unknown = np.isnan(d.columns[..., engine.SPEED]).any(axis=1)
    return np.asarray((kinds == columns.SLOW_LANDING) | ((kinds == columns.CONTACT) & unknown))


def _grazes(passing: Sensitivity) -> MovedGrazes:
    """Return how the grazes of walls depend on the parameters, from columns that pass them."""
    run, moved = passing.run, passing.moved
    events, marks = run.record
    landed = _unheld(passing)
    instants = np.concatenate([passing.varied.graze_times, events[landed, columns.EVENT_T]])
    order = np.argsort(instants, kind="stable")
    n = len(passing.varied.graze_times)
    walls = run.system.lines.wall
    graze_stops = run.grazes.stop[np.isin(run.grazes.t, passing.varied.graze_times)][:n]
    of_landings = [walls[bound] for bound in marks[landed, columns.BOUND].tolist()]
    stop = np.concatenate([graze_stops, np.array(of_landings, dtype=np.int64)]).astype(np.int64)
    reach = np.full((len(instants), len(passing.paths)), np.nan)
    speed = reach.copy()
    for k in range(n):
        t = float(instants[k])
        into, push, _ = _at_graze(run, t, int(stop[k]))
        dx, dv = passing(t)
        away = moved.stops[:, stop[k], 0]
        reach[k] = into * (dx - away)
        # What rounding, of the instant too, leaves of a parameter that moves wall and motion alike.
        terms = np.abs(dx) + np.abs(away) + max(abs(t), t - run.t0) * np.abs(dv)
        reach[k, np.abs(reach[k]) <= ROUNDED * terms] = 0.0
        speed[k] = np.sqrt(2.0 * np.maximum(-push, 0.0) * np.abs(reach[k]))
    return MovedGrazes(instants[order], stop[order], reach[order], speed[order])


def _at_graze(run: AnyOscillatorMotion, t: float, stop: int) -> tuple[float, float, float]:
    """Return the direction of a wall, the acceleration towards it, and its restitution."""
    law, (events, marks) = run.system.law, run.record
    region = int(marks[flight_at(events, t, True), columns.NEXT_REGION])
    bound = run.system.lines.wall.index(stop)
    into = -1.0 if bound == int(law[region, NUMBER]) else 1.0
    force = constant_force(law, region, place(law, region, bound))
    force += force_and_slopes(law, phases_at(law, t))[0]
    return into, into * force, restitution_at(law, region, bound, 0.0)


def _rebound(run: AnyOscillatorMotion, grazes: MovedGrazes) -> float:
    """Return how much an impact at the first graze changes the velocity, per speed."""
    into, _, restitution = _at_graze(run, float(grazes.t[0]), int(grazes.stop[0]))
    return into * (1.0 + restitution)


def _crossing_rows(run: AnyOscillatorMotion) -> list[int]:
    """Return the row of each crossing: stops that share an edge are crossed together."""
    marks, edges = run.record[1], run.system.lines.edges
    rows = np.flatnonzero(marks[:, columns.KIND] == columns.CROSSING).tolist()
    return [row for row in rows for _ in edges[int(marks[row, columns.BOUND])]]
