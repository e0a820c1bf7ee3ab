"""The result of a run: its events, and the motion between them in closed form."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, Integers, numbers_within, row_of
from percuss.kernels import record as columns
from percuss.kernels.law_columns import N_HARMONICS, N_KNOTS
from percuss.kernels.record import MotionRecord
from percuss.kernels.sample import evaluate, impact_columns
from percuss.model.exact import Exact, Phase, as_float, reals, whole
from percuss.model.faults import raise_first
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, mass_of
from percuss.model.periods import require_period
from percuss.model.start import Start, wall_faults
from percuss.model.system import System
from percuss.motion.energetics import energy_at, forces_at
from percuss.motion.error_bounds import ContactErrors
from percuss.motion.extremes import (
    Extrema,
    QuantityName,
    extremes_of_motion,
    jumps_at,
    level_crossings,
    window_at_jumps,
)
from percuss.motion.instants import check_limit, span_within, strobes, times_within
from percuss.motion.run_dataset import run_dataset
from percuss.motion.sections import SectionDirection, section_of
from percuss.motion.sensitivity import Sensitivity, sensitivity_of
from percuss.motion.tables import (
    Contacts,
    Crossings,
    EventTable,
    Grazes,
    HasEvents,
    Impacts,
    Limit,
    counts_in_words,
    no_contacts,
    no_crossings,
    no_grazes,
)
from percuss.pictures import HasPicture

if TYPE_CHECKING:
    # A second of import, and only `sample`, `stroboscopic` and `forces` need it.
    from xarray import Dataset


class Outcome(Enum):
    """The end of a run; the value is the sentence to show.

    Examples
    --------
    >>> Outcome.reached_t_end.value
    'the run reached t_end'
    """

    reached_t_end = "the run reached t_end"
    reached_max_impacts = "the run reached max_impacts (impacts and entries into soft stops)"
    at_rest = "the mass came to rest at a stop for good"
    no_more_impacts = "the motion provably meets no stop again, and there is no t_end to run to"
    overflow = "the motion grew beyond 1e150; the run holds what was before"
    interrupted = "the run was interrupted; it holds what was done"


class AnyRun(HasEvents, Protocol):
    """A run of an oscillator or a structure."""

    @property
    def outcome(self) -> Outcome:
        """How it ended."""

    @property
    def beyond_record(self) -> str:
        """What acts before and after the samples of a record, if it goes there."""


def happened(run: AnyRun) -> str:
    """Return span, numbers of events and end of a run in words; events that are none are left out.

    Impacts are always counted.
    """
    ends = "; ".join([run.outcome.value, *filter(None, [run.beyond_record])])
    counts = counts_in_words(
        impacts=run.impacts, crossings=run.crossings, contacts=run.contacts, grazes=run.grazes
    )
    return f"t = {run.t0:.6g} ... {run.t_end:.6g}, {counts}; {ends}"


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(HasPicture):
    """One motion; made by `simulate`. Called with times, it gives the motion there.

    Attributes
    ----------
    oscillator, forcing
        What moved; the forcing is None for free motion.
    x0, v0, t0
        Position [length], velocity [length/time] and time [time] of the start.
    start
        The same as it was given: ``v0="0.45"`` is 9/20 here.
    t_end
        Time up to which the motion is known [time].
    end
        The same as it was given: ``t_end="20*pi"`` is 20 pi here.
    outcome
        How the run ended.
    impacts, crossings, contacts, grazes
        The events, as columns.
    periods
        The number of forcing periods after which it ends, with which its end moves; None where it
        ends otherwise.
    """

    picture: ClassVar = "plot_motion"

    oscillator: Oscillator
    forcing: Forcing | None
    x0: float
    v0: float
    t0: float
    t_end: float
    outcome: Outcome
    impacts: Impacts
    crossings: Crossings
    contacts: Contacts
    grazes: Grazes
    start: Start = field(repr=False)
    end: Phase = field(repr=False)
    _events: Floats = field(repr=False)
    _marks: Integers = field(repr=False)
    periods: Exact | None = field(default=None, repr=False)

    @classmethod
    def of_record(
        cls,
        system: System,
        record: tuple[tuple[float, float], Floats, Integers, Floats],
        t_end: Phase,
        outcome: Outcome,
        start: Start | None = None,
        periods: Exact | None = None,
    ) -> Trajectory:
        """Return the trajectory of (x0, v0), events, marks and grazes, as the kernels wrote them.

        Without an exact start its floats are taken.
        """
        (x0, v0), events, marks, grazes = record
        t0 = float(events[0, columns.EVENT_T])
        start = Start(x0, v0, t0) if start is None else start
        units = system.oscillator.units
        # Mostly all events but the start are impacts.
        n = int(np.count_nonzero(marks[1:, columns.KIND] == columns.IMPACT))
        has_others = n + 1 < len(marks)
        return cls(
            oscillator=system.oscillator,
            forcing=system.forcing,
            x0=x0,
            v0=v0,
            t0=t0,
            t_end=as_float(t_end),
            outcome=outcome,
            impacts=_impacts(system, events, marks, n),
            crossings=_crossings(system, events, marks) if has_others else no_crossings(units),
            contacts=_contacts(system, start, events, marks) if has_others else no_contacts(units),
            grazes=_grazes(system, grazes),
            start=start,
            end=t_end,
            _events=events,
            _marks=marks,
            periods=periods,
        )

    @property
    def record(self) -> tuple[Floats, Integers]:
        """Its events and marks as the kernels wrote them."""
        return self._events, self._marks

    @property
    def system(self) -> System:
        """The oscillator and the forcing as one value."""
        return System(self.oscillator, self.forcing)

    def __repr__(self) -> str:
        """Return what happened in a line."""
        return f"<Trajectory: {happened(self)}>"

    def _repr_html_(self) -> str:
        """Return what happened, and the impacts or else the entries into soft stops."""
        has_impacts = len(self.impacts) > 0 or len(self.crossings) == 0
        table: EventTable = self.impacts if has_impacts else self.crossings
        return f"<p>{html.escape(repr(self)[1:-1])}</p>{table._repr_html_()}"

    @property
    def beyond_record(self) -> str:
        """What acts before and after the samples of a force's record, if the run goes there.

        Empty without a record, under one that is repeated, and for a run within its samples.

        Examples
        --------
        >>> import percuss as pc
        >>> push = pc.record([0.0, 1.0, 2.0], [0.0, 1.0, 0.5])
        >>> pc.simulate(pc.Oscillator(), push, t_end=5).beyond_record
        'the record lasts from t = 0 to 2, its end values hold beyond'
        """
        return beyond_record_of(self.forcing, self.t0, self.t_end)

    def __call__(self, t: ArrayLike, limit: Limit = "after") -> tuple[Floats, Floats]:
        """Return (x, v) at times t, from the closed form.

        Parameters
        ----------
        t
            Times in [t0, t_end], of any shape [time].
        limit
            Which velocity to give at the very instant of an impact.

        Returns
        -------
        tuple of arrays
            x [length] and v [length/time], of t's shape.

        Raises
        ------
        ParameterError
            If a time lies outside the run by more than the rounding of a time: four units in the
            last place of the later end. Within that the state at the end is given.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
        >>> [round(float(run(run.impacts.t[0], limit)[1]), 12) for limit in ("before", "after")]
        [-1.0, 0.5]
        """
        check_limit(limit)
        instants = self.within(reals("t", t))
        flat = row_of(instants)
        law = self.system.law
        n = int(law[0, N_HARMONICS])
        motion = np.empty((2, len(flat)))
        evaluate(
            self._motion_record,
            flat,
            limit == "after",
            np.empty((n, 2)),
            np.empty((n, 2)),
            motion,
        )
        return motion[0].reshape(instants.shape), motion[1].reshape(instants.shape)

    def sample(self, n: int) -> Dataset:
        """Return x and v at n equidistant times, both ends included; at times of your own: `run(t)`.

        Parameters
        ----------
        n
            Number of points, >= 2.

        Returns
        -------
        xarray.Dataset
            x [length] and v [length/time] over t [time], (n,) each.

        Raises
        ------
        ParameterError
            If n is below 2.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=3.0)
        >>> dict(run.sample(4).sizes)
        {'t': 4}
        """
        n = whole("n", n, 2)
        times = np.linspace(self.t0, self.t_end, n)
        x, v = self(times)
        return self._dataset({"x": ("t", x), "v": ("t", v)}, {"t": times})

    def stroboscopic(self, cycle: float | None = None) -> Dataset:
        """Return x and v once every forcing period.

        Parameters
        ----------
        cycle
            The cycle of the instants, (t / period) mod 1, in [0, 1); default: that of t0.

        Returns
        -------
        xarray.Dataset
            `t`, `x` and `v` over `period`, their number from 0; at the very instant of an impact
            v is that after it.

        Raises
        ------
        ParameterError
            If the forcing has no period, or the cycle is not in [0, 1).

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, t_end=20.0)
        >>> dict(run.stroboscopic().sizes)
        {'period': 10}
        >>> [round(float(t), 3) for t in run.stroboscopic(cycle=0.25).t[:3]]
        [0.524, 2.618, 4.712]
        """
        period = require_period(self.forcing, "a stroboscopic view needs a periodic forcing")
        times = strobes(period, self.t0, self.t_end, cycle)
        x, v = self(times)
        data = {"t": ("period", times), "x": ("period", x), "v": ("period", v)}
        number = np.arange(len(times))
        return self._dataset(data, {"period": number})

    def section(self, at: float, direction: SectionDirection = "both") -> Dataset:
        """Return the passages of a displacement: a Poincaré section.

        None is missed: each flight is searched with the proof that holds for stops. A touch of
        the level that rounding cannot tell from a passage and back is none. The start is none,
        nor are the hops in the summed tail of a chatter, and at a wall there is no passage.

        Parameters
        ----------
        at
            The displacement [length].
        direction
            "up" with v > 0, "down" with v < 0, or "both".

        Returns
        -------
        xarray.Dataset
            `t` [time], `x` [length] and `v` [length/time] over `crossing`.

        Raises
        ------
        ParameterError
            If the displacement is not a finite number or inside a wall, or there is no such
            direction.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=10.0)
        >>> run.section(at=0.5, direction="up").t.values.round(6)
        array([0.523599, 6.806784])
        """
        section = section_of({"at": at, "direction": direction})
        level = section.at
        raise_first(wall_faults(self.oscillator, "at", level))
        crossings = level_crossings(self.system, self._motion_record, level, self.t_end)
        t, v = crossings[section.sign * crossings[:, 1] >= 0.0].T
        data = {"t": ("crossing", t), "x": ("crossing", np.full(len(t), level)),
                "v": ("crossing", v)}  # fmt: skip
        return self._dataset(data, {})

    def extremes(
        self, of: QuantityName, stop: int = 0, between: Sequence[float] | None = None
    ) -> Extrema:
        """Return the least and the largest value of a quantity, with their instants.

        Both are exact to rounding: inside a flight the zeros of the derivative are found with the
        proof that holds for impacts, and at an event both limits count. So the force of a stop
        with a dashpot has its value just after the entry, and a wall holds a mass at rest with
        the force that `forces` gives. The impulses of impacts are no forces; `impacts` has them.
        In the summed tail of a chatter the first hops are as exact as the tail.

        Parameters
        ----------
        of
            "displacement" [length], "velocity" [length/time], "acceleration" [length/time^2],
            "stop_force" or "spring_force" [mass length/time^2], with the sign of `forces`; forces
            are per unit mass where the oscillator has no mass.
        stop
            Index of the stop whose force it is.
        between
            Two instants (first, last); default: the whole run [time]. An end within rounding of a
            jump of the force is at it, and has both of its limits; where the run ends, that before.

        Returns
        -------
        Extrema
            `minimum`, `t_minimum`, `maximum`, `t_maximum`; at a plateau its first instant.

        Raises
        ------
        ParameterError
            If there is no such quantity or stop, or the instants are not in the run.

        Examples
        --------
        A unit mass runs into a spring of 9 and a dashpot of 2 with speed 1: the force jumps to -2.

        >>> import percuss as pc
        >>> stop = pc.SoftStop(at=0, side="above", stiffness=9, damping=1)
        >>> run = pc.simulate(pc.Oscillator(stops=(stop,)), x0=-0.0, v0=1.0, t_end=3.0)
        >>> run.extremes("stop_force").minimum < -2.0
        True
        """
        record, span = self._motion_record, span_within(between, self.t0, self.t_end)
        if self.system.law[0, N_KNOTS] > 0.0:
            # A knot while a wall holds the mass is no row of the record.
            span = window_at_jumps(jumps_at(self.system.law, span), span, self.t_end)
        return extremes_of_motion(self.system, record, span, of, stop)

    def within(self, instants: Floats) -> Floats:
        """Return times moved into the run where only their rounding lies outside."""
        if instants.size and not (instants.min() >= self.t0 and instants.max() <= self.t_end):
            return times_within(instants, self.t0, self.t_end)
        return instants

    def sensitivity(self, paths: Sequence[str]) -> Sensitivity:
        """Return the derivative of the motion by parameters, exact to rounding.

        In one sweep over the events, whatever the number of parameters: flights in closed form or
        by their power series, impacts, crossings, chatter and releases by the implicit function
        theorem (docs/theory/sensitivities.md). No difference is taken.

        Parameters
        ----------
        paths
            Paths of the parameters, in long or short form: of the oscillator, the forcing and the
            start, and names of parameters in expressions.

        Returns
        -------
        Sensitivity
            With `impacts`, `crossings` and `contacts`; called with times it gives dx and dv. Where
            the motion grazes a wall it has no derivative, and says so.

        Raises
        ------
        ParameterError
            If there is no such parameter, one is named twice, or none at all.

        Examples
        --------
        A ball falls from x0 = 1 on the floor after a time sqrt(2 x0 / 2), and bounces:

        >>> import percuss as pc
        >>> floor = pc.Wall(at=0, side="below")
        >>> ball = pc.Oscillator(stiffness=0, stops=(floor,))
        >>> run = pc.simulate(ball, pc.Forcing(constant=-2), x0=1, max_impacts=2)
        >>> run.sensitivity(["start.x0"]).impacts.t[:, 0]
        array([0.5, 1.5])
        """
        return sensitivity_of(self, paths)

    @property
    def _motion_record(self) -> MotionRecord:
        return MotionRecord(self.system.law, self.x0, self._events, self._marks)

    def forces(self, t: ArrayLike) -> Dataset:
        """Return the forces on the mass at times t; per unit mass where there is no mass.

        Parameters
        ----------
        t
            (n,) array of times in the run [time].

        Returns
        -------
        xarray.Dataset
            `spring`, `damping`, `forcing` over t and `stops` over (stop, t) [mass
            length/time^2]: a soft stop's force, and a wall's reaction in contact (its impulses
            are in `impacts`). At the instant of an event they are those after it.

        Raises
        ------
        ParameterError
            If a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.bilinear_oscillator(stiffness_below=9.0), v0=1.0, t_end=4.0)
        >>> [float(abs(run.forces([0.5])[name].sum())) for name in ("damping", "stops")]
        [0.0, 0.0]
        """
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        x, v = self(times)
        data = forces_at(self.system, self.contacts, self.within(times), x, v, self.record)
        stops = np.arange(len(self.oscillator.stops))
        return self._dataset(data, {"t": times, "stop": stops})

    def acceleration(self, t: ArrayLike) -> Floats:
        """Return x'' at times t, the sum of all forces by the mass; impulses of walls are none.

        Parameters
        ----------
        t
            Times in the run, of any shape [time].

        Returns
        -------
        array
            Of t's shape [length/time^2]; 0 while a wall holds the mass.

        Raises
        ------
        ParameterError
            If a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.Oscillator(stiffness=4), x0=0.5, t_end=9.0)
        >>> run.acceleration(0.0)
        array(-2.)
        """
        times = np.asarray(t, dtype=np.float64)
        forces = self.forces(times.reshape(-1))
        whole = forces.spring + forces.damping + forces.forcing + forces.stops.sum("stop")
        return np.asarray(whole.values.reshape(times.shape) / self.system.mass)

    def energy(self, t: ArrayLike) -> Floats:
        """Return the mechanical energy at times t; per unit mass where there is no mass.

        Parameters
        ----------
        t
            Times in the run, of any shape [time].

        Returns
        -------
        array
            m v^2 / 2 + k x^2 / 2 and the springs of the soft stops [mass length^2/time^2], of t's
            shape.

        Raises
        ------
        ParameterError
            If a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(), v0=2.0, t_end=9.0)
        >>> run.energy([0.0, 4.0, 8.0])
        array([2., 2., 2.])
        """
        x, v = self(t)
        return energy_at(self.system, x, v)

    def _dataset(self, data: Mapping[str, object], coords: Mapping[str, object]) -> Dataset:
        return run_dataset(data, coords, self.outcome.value, self.oscillator.units)


def beyond_record_of(force: Forcing | Loads | None, t0: float, t_end: float) -> str:
    """Return what acts beyond the samples of a force's records, if a run goes there."""
    if isinstance(force, Loads):
        texts = (beyond_record_of(each, t0, t_end) for each in force.forcings)
        return "; ".join(f"loads.{i}: {text}" for i, text in enumerate(texts) if text)
    record = None if force is None else force.record
    if record is None or record.repeat:
        return ""
    pace = 1.0 if record.omega is None else as_float(record.omega)
    first, last = as_float(record.t[0]) / pace, as_float(record.t[-1]) / pace
    if first <= t0 and t_end <= last:
        return ""
    what = "its end values hold" if record.outside == "end" else "nothing acts"
    return f"the record lasts from t = {first:.6g} to {last:.6g}, {what} beyond"


def _impacts(system: System, events: Floats, marks: Integers, n: int) -> Impacts:
    out, bounds = np.empty((5, n)), np.empty(n, dtype=np.int64)
    impact_columns(system.law, events, marks, out, bounds)
    t, v_before, v_after, cycle, intervals = out
    return Impacts(
        t=t,
        v_before=v_before,
        v_after=v_after,
        stop=system.lines.walls[bounds],
        cycle=cycle,
        intervals=intervals,
        mass=mass_of(system.oscillator),
        units=system.oscillator.units,
    )


def _crossings(system: System, events: Floats, marks: Integers) -> Crossings:
    which, units = (
        np.flatnonzero(marks[:, columns.KIND] == columns.CROSSING),
        system.oscillator.units,
    )
    if len(which) == 0:
        return no_crossings(units)
    bounds = marks[which, columns.BOUND]
    edges = system.lines.edges
    stops = np.array([k for edge in edges for k in edge], dtype=np.int64)
    at_edge = np.array([len(edge) for edge in edges])
    first = np.cumsum(at_edge) - at_edge
    stop = first.take(bounds)
    if at_edge.max() > 1:
        # Stops that share an edge are crossed together, one line each.
        sharing = at_edge[bounds]
        stop = np.repeat(stop, sharing) + numbers_within(sharing)
        which = np.repeat(which, sharing)
    stop = stops.take(stop)
    above = np.array([at.side == "above" for at in system.oscillator.stops], dtype=bool)
    v = events[which, columns.V_AFTER]
    direction = np.array(["out", "in"]).take((v > 0.0) == above.take(stop))
    return Crossings(events[which, columns.EVENT_T], v, stop, direction, units)


def _contacts(system: System, start: Start, events: Floats, marks: Integers) -> Contacts:
    kind = marks[:, columns.KIND]
    which = np.flatnonzero(kind == columns.CONTACT)
    if len(which) == 0:
        return no_contacts(system.oscillator.units)
    released = np.flatnonzero(kind == columns.RELEASE)
    release = np.full(len(which), np.nan)
    # Nothing comes between a contact and its release; only the last contact may have none.
    release[: len(released)] = events[released, columns.EVENT_T]
    return Contacts(
        start=events[which, columns.EVENT_T],
        release=release,
        stop=system.lines.walls[marks[which, columns.BOUND]],
        n_impacts=np.cumsum(kind == columns.IMPACT)[which],
        _errors=ContactErrors(system, start, events, marks),
        units=system.oscillator.units,
    )


def _grazes(system: System, grazes: Floats) -> Grazes:
    if len(grazes) == 0:
        return no_grazes(system.oscillator.units)
    bounds = grazes[:, columns.GRAZE_BOUND].astype(np.int64)
    lines = system.lines
    stop = [
        wall if wall is not None else lines.edges[bound][0]
        for bound, wall in ((bound, lines.wall[bound]) for bound in bounds)
    ]
    return Grazes(
        t=grazes[:, columns.GRAZE_T],
        stop=np.array(stop, dtype=np.int64),
        clearance=grazes[:, columns.GRAZE_CLEARANCE],
        error_bound=grazes[:, columns.GRAZE_ERROR],
        units=system.oscillator.units,
    )
