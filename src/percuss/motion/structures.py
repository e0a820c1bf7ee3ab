"""The result of a run of a structure: its events, and the motion between them."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, Integers, row_of
from percuss.kernels import record as columns
from percuss.kernels.structure.run import StructureRun
from percuss.kernels.structure.sample import evaluate
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import Exact, Phase, as_float, reals, whole
from percuss.model.loads import Loads
from percuss.model.oscillator import On, SoftStop
from percuss.model.periods import require_period
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.energetics import force_in_run
from percuss.motion.extremes import Extrema, QuantityName, jumps_in, window_at_jumps
from percuss.motion.instants import check_limit, span_within, strobes, times_within
from percuss.motion.moved_structure_motion import scratch_run
from percuss.motion.run_dataset import run_dataset
from percuss.motion.sections import SectionDirection, section_of
from percuss.motion.structure_observables import (
    extremes_of_run,
    observable_at,
    passages_of_run,
)
from percuss.motion.structure_sensitivity import StructureSensitivity, structure_sensitivity_of
from percuss.motion.tables import Contacts, Crossings, EventColumn, Grazes, Impacts, Limit
from percuss.motion.trajectory import Outcome, beyond_record_of, happened
from percuss.numerics import matmul
from percuss.pictures import HasPicture
from percuss.wording import counted

if TYPE_CHECKING:
    from xarray import Dataset


def as_far_as_filled(run: StructureRun) -> StructureRun:
    """Return the run with the rows of its events and grazes that have been written."""
    n, n_grazes = (int(run.counters[i]) for i in (columns.N_EVENTS, columns.N_GRAZES))
    return run._replace(
        events=run.events[:n],
        marks=run.marks[:n],
        states=run.states[:n],
        grazes=run.grazes[:n_grazes],
    )


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureTrajectory(HasPicture):
    """One motion of a structure; made by `simulate`. Called with times, it gives the motion there.

    Attributes
    ----------
    structure, loads
        The structure and its loads.
    start
        The state in which it started.
    t0, t_end
        Times between which the motion is known [time].
    end
        The later one as it was given.
    outcome
        How the run ended.
    impacts, crossings, contacts, grazes
        The events, as columns. Velocities are those of y = c . x, the displacement of the stop.
    periods
        The number of periods of the loads after which it ends, with which its end moves; None where
        it ends otherwise.
    """

    structure: Structure
    loads: Loads
    start: StructureStart
    t0: float
    t_end: float
    outcome: Outcome
    impacts: StructureImpacts
    crossings: Crossings
    contacts: Contacts
    grazes: Grazes
    end: Phase = field(repr=False)
    _run: StructureRun = field(repr=False)
    periods: Exact | None = field(default=None, repr=False)

    picture: ClassVar = "plot_motion"

    @classmethod
    def of_run(
        cls,
        system: StructureSystem,
        start: StructureStart,
        run: StructureRun,
        end: Phase,
        outcome: Outcome,
        periods: Exact | None = None,
    ) -> StructureTrajectory:
        """Return the trajectory of a run, as the kernels left it."""
        run = as_far_as_filled(run)
        # The scratch of a result is its own: another run may go on with the same sets.
        run = run._replace(
            events=run.events.copy(),
            marks=run.marks.copy(),
            states=run.states.copy(),
            grazes=run.grazes.copy(),
        )
        if outcome is not Outcome.reached_t_end:
            end, periods = min(as_float(end), float(run.state[columns.T])), None
        return cls(
            structure=system.structure,
            loads=system.loads,
            start=start,
            t0=as_float(start.t0),
            t_end=as_float(end),
            outcome=outcome,
            impacts=_impacts(system, run),
            crossings=_crossings(system, run),
            contacts=_contacts(system, run),
            grazes=_grazes(system, run),
            end=end,
            _run=run,
            periods=periods,
        )

    @property
    def record(self) -> StructureRun:
        """Its events, marks and modes as the kernels wrote them."""
        return self._run

    @property
    def system(self) -> StructureSystem:
        """The structure and the loads as one value."""
        return StructureSystem.of(self.structure, self.loads)

    def __repr__(self) -> str:
        """Return what happened in a line."""
        return f"<StructureTrajectory: {counted(self.structure.n, 'coordinate')}, {happened(self)}>"

    @property
    def beyond_record(self) -> str:
        """What acts before and after the samples of the loads' records, if the run goes there.

        Empty where there is no record, and for a run within the samples of all.

        Examples
        --------
        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
        >>> loads = pc.Loads({1: pc.record([0.0, 1.0], [0.0, 1.0])})
        >>> pc.simulate(pair, loads, t_end=2).beyond_record
        'loads.0: the record lasts from t = 0 to 1, its end values hold beyond'
        """
        return beyond_record_of(self.loads, self.t0, self.t_end)

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
            x [length] and v [length/time], of t's shape + (n,).

        Raises
        ------
        ParameterError
            If a time lies outside the run by more than its rounding.

        Examples
        --------
        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
        >>> run = pc.simulate(pair, v0=[1, 0], t_end=10)
        >>> x, v = run(10.0)
        >>> round(float(v.sum()), 12)
        1.0
        """
        check_limit(limit)
        instants = reals("t", t)
        inside = times_within(instants, self.t0, self.t_end)
        flat = row_of(inside)
        place = np.empty((len(flat), self.structure.n, 2))
        evaluate(scratch_run(self._run), flat, limit == "after", place)
        shape = (*instants.shape, self.structure.n)
        return place[:, :, 0].reshape(shape), place[:, :, 1].reshape(shape)

    def displacement(self, on: On, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return y = c . x of a coordinate, direction or point, and its velocity, at times t.

        Examples
        --------
        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
        >>> run = pc.simulate(pair, v0=[1, 0], t_end=10)
        >>> y, _ = run.displacement((1, -1), run.impacts.t)
        >>> abs(y).round(12)
        array([0.5, 0.5, 0.5, 0.5, 0.5])
        """
        c = self.structure.direction(on)
        x, v = self(t)
        return (x * c).sum(axis=-1), (v * c).sum(axis=-1)

    def acceleration(self, on: On, t: ArrayLike) -> Floats:
        """Return y'' of a coordinate, direction or point at times t; impulses of walls are none.

        Parameters
        ----------
        on
            A coordinate, a direction or the name of a point.
        t
            Times in the run, of any shape [time].

        Returns
        -------
        array
            Of t's shape [length/time^2], after an event at its instant.

        Raises
        ------
        ParameterError
            If there is no such coordinate or point, or a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> two = pc.chain(masses=[1, 2], springs=[1, 1, 1])
        >>> run = pc.simulate(two, x0=[1, -1], t_end=9)
        >>> run.acceleration(1, 0.0), run.acceleration((1, -1), [0.0])
        (array(1.5), array([-4.5]))
        """
        times = reals("t", t)
        flat = row_of(times_within(times, self.t0, self.t_end))
        own = observable_at(self.system, scratch_run(self._run), flat, "acceleration", on=on)
        return own.reshape(times.shape)

    def energy(self, t: ArrayLike) -> Floats:
        """Return the kinetic energy and that of all springs, of soft stops in touch too.

        Of an unsymmetric stiffness only the symmetric part stores energy.

        Parameters
        ----------
        t
            Times in the run, of any shape [time].

        Returns
        -------
        array
            Of t's shape [mass length^2/time^2].
        """
        x, v = self(t)
        mass, stiffness = self.structure.mass_matrix, self.structure.stiffness_matrix
        flat_x, flat_v = x.reshape(-1, self.structure.n), v.reshape(-1, self.structure.n)
        energy = 0.5 * (matmul(flat_v, mass) * flat_v).sum(axis=1)
        energy = energy + 0.5 * (matmul(flat_x, stiffness) * flat_x).sum(axis=1)
        for stop, c in zip(self.structure.stops, self.structure.stop_directions, strict=True):
            if isinstance(stop, SoftStop):
                depth = (flat_x * c).sum(axis=1) - as_float(stop.at)
                is_pressed = depth > 0.0 if stop.side == "above" else depth < 0.0
                stored = 0.5 * as_float(stop.stiffness) * depth * depth
                energy = energy + np.where(is_pressed, stored, 0.0)
        return np.asarray(energy.reshape(x.shape[:-1]))

    def sample(self, n: int) -> Dataset:
        """Return x and v at n equidistant times, both ends included; at times of your own: `run(t)`.

        Parameters
        ----------
        n
            Number of points, >= 2.

        Returns
        -------
        xarray.Dataset
            x [length] and v [length/time] over (t, coordinate).

        Raises
        ------
        ParameterError
            If n is below 2.
        """
        n = whole("n", n, 2)
        times = np.linspace(self.t0, self.t_end, n)
        return self._dataset(times, "t")

    def stroboscopic(self, cycle: float | None = None) -> Dataset:
        """Return x and v once every period of the loads.

        Parameters
        ----------
        cycle
            The cycle of the instants, (t / period) mod 1, in [0, 1); default: that of t0.

        Returns
        -------
        xarray.Dataset
            `t` over `period`, their number from 0, and `x` and `v` over (period, coordinate); at
            the very instant of an impact v is that after it.

        Raises
        ------
        ParameterError
            If the loads have no common period, or the cycle is not in [0, 1).

        Examples
        --------
        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
        >>> run = pc.simulate(pair, pc.Loads({0: pc.cosine(2)}), t_end=10)
        >>> run.stroboscopic(cycle=0.5).t.values.round(3)
        array([1.571, 4.712, 7.854])
        """
        period = require_period(self.loads, "a stroboscopic view needs loads of one period")
        return self._dataset(strobes(period, self.t0, self.t_end, cycle), "period")

    def section(
        self, at: float, on: On | None = None, direction: SectionDirection = "both"
    ) -> Dataset:
        """Return the passages of a displacement y = c . x: a Poincaré section.

        None is missed: each flight is searched with the proof that holds for stops. The start is
        none, nor is a touch of the level that rounding cannot tell from a passage and back, and at
        a wall there is no passage.

        Parameters
        ----------
        at
            The displacement y [length].
        on
            A coordinate, a direction or the name of a point; not needed for one coordinate.
        direction
            "up" with y' > 0, "down" with y' < 0, or "both".

        Returns
        -------
        xarray.Dataset
            `t` [time], over `crossing`, and `x` [length] and `v` [length/time] over (crossing,
            coordinate).

        Raises
        ------
        ParameterError
            If the displacement is not a finite number, or there is no such direction.

        Examples
        --------
        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution=1)
        >>> run = pc.simulate(pair, v0=[1, 0], t_end=3)
        >>> run.section(at=0, on=(1, -1)).t.values
        array([1., 2.])
        """
        section = section_of({"at": at, "direction": direction})
        self.structure.direction(on)
        passages = passages_of_run(self.system, scratch_run(self._run), self.t_end, section.at, on)
        return self._dataset(passages[section.sign * passages[:, 1] >= 0.0, 0], "crossing")

    def extremes(
        self,
        of: QuantityName,
        stop: int = 0,
        on: On | None = None,
        between: Sequence[float] | None = None,
    ) -> Extrema:
        """Return the least and the largest value of a quantity, with their instants.

        Both are exact to rounding: inside a flight the zeros of the derivative are found with the
        proof that holds for impacts, and at an event both limits count. So the force of a stop
        with a dashpot has its value just after the entry, and a wall holds the structure with the
        force that `forces` gives. The impulses of impacts are no forces; `impacts` has them.

        Parameters
        ----------
        of
            "displacement" [length], "velocity" [length/time] or "acceleration" [length/time^2] of
            y = c . x; "spring_force", that of the stiffness, -c . K x, or "stop_force", along the
            c of the stop [mass length/time^2], with the sign of `forces`.
        stop
            Index of the stop whose force it is.
        on
            A coordinate, a direction c or the name of a point, of all but "stop_force"; not needed
            for one coordinate.
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
            If there is no such quantity, stop or direction, or the instants are not in the run.

        Examples
        --------
        >>> import percuss as pc
        >>> two = pc.chain(masses=[1, 1], springs=[1, 1, 1])
        >>> run = pc.simulate(two, x0=[1, -1], t_end=9)
        >>> round(run.extremes("velocity", on=0).maximum**2, 12)
        3.0
        """
        run, span = scratch_run(self._run), span_within(between, self.t0, self.t_end)
        span = window_at_jumps(jumps_in(run.events, run.marks), span, self.t_end)
        return extremes_of_run(self.system, run, span, of, stop, on)

    def sensitivity(self, paths: Sequence[str]) -> StructureSensitivity:
        """Return the derivative of the motion by parameters, exact to rounding.

        Flights by their power series, impacts, crossings, chatter and releases by the implicit
        function theorem (docs/theory/sensitivities.md). No difference is taken, and no derivative
        of a mode.

        Parameters
        ----------
        paths
            Paths of the parameters, in long or short form: of the structure, its loads and the
            start, and names of parameters in expressions.

        Returns
        -------
        StructureSensitivity
            With `impacts`, `crossings` and `contacts`; called with times it gives dx and dv. Where
            the motion grazes a wall it has no derivative, and says so.

        Raises
        ------
        ParameterError
            If there is no such parameter, one is named twice, or none at all.

        Examples
        --------
        The masses of a pair meet after the time gap / v0, and part with 0.8 of the velocity:

        >>> import percuss as pc
        >>> pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
        >>> d = pc.simulate(pair, v0=[1, 0], t_end=1).sensitivity(["start.v0.0"])
        >>> d.impacts.t[0], d.impacts.v_after[0]
        (array([-0.5]), array([0.8]))
        """
        return structure_sensitivity_of(self, paths)

    def forces(self, t: ArrayLike) -> Dataset:
        """Return the forces on the coordinates at times t.

        Parameters
        ----------
        t
            (n_times,) array of times in the run [time].

        Returns
        -------
        xarray.Dataset
            `spring`, `damping` and `loads` over (t, coordinate), -K x, -C v and what the loads
            push, and `stops` over (stop, t), the force of each stop along its c: that of a soft
            stop, and the reaction of a wall in contact (its impulses are in `impacts`) [mass
            length/time^2]. M x'' is the sum of all, those of the stops times their c.

        Raises
        ------
        ParameterError
            If a time lies outside the run.

        Examples
        --------
        >>> import percuss as pc
        >>> two = pc.chain(masses=[1, 1], springs=[1, 1, 1])
        >>> pc.simulate(two, x0=[1, -1], t_end=9).forces([0.0])["spring"].values
        array([[-3.,  3.]])
        """
        times = np.atleast_1d(reals("t", t))
        x, v = self(times)
        flat = row_of(times_within(times, self.t0, self.t_end))
        stiffness, damping = self.structure.stiffness_matrix, self.structure.damping_matrix
        loads = np.zeros_like(x)
        directions = self.loads.directions(self.structure)
        for c, forcing in zip(directions, self.loads.forcings, strict=True):
            loads += force_in_run(forcing, flat, self._run.events)[:, None] * c
        stops = np.zeros((len(self.structure.stops), len(flat)))
        scratch = scratch_run(self._run)
        for i in range(len(stops)):
            stops[i] = observable_at(self.system, scratch, flat, "stop_force", stop=i)
        data: dict[str, object] = {
            "spring": (("t", "coordinate"), -matmul(x, stiffness.T)),
            "damping": (("t", "coordinate"), -matmul(v, damping.T)),
            "loads": (("t", "coordinate"), loads),
            "stops": (("stop", "t"), stops),
        }
        coordinates: dict[str, object] = {
            "t": times,
            "coordinate": np.arange(self.structure.n),
            "stop": np.arange(len(stops)),
        }
        return self._labelled(data, coordinates)

    def _dataset(self, times: Floats, dimension: str) -> Dataset:
        x, v = self(times)
        data: dict[str, object] = {
            "x": ((dimension, "coordinate"), x),
            "v": ((dimension, "coordinate"), v),
        }
        coordinates: dict[str, object] = {"coordinate": np.arange(self.structure.n)}
        if dimension == "t":
            coordinates["t"] = times
        else:
            data = {"t": (dimension, times)} | data
            if dimension == "period":
                coordinates[dimension] = np.arange(len(times))
        return self._labelled(data, coordinates)

    def _labelled(self, data: dict[str, object], coordinates: dict[str, object]) -> Dataset:
        return run_dataset(data, coordinates, self.outcome.value, self.structure.units)


def _rows(run: StructureRun, kind: np.int64) -> Integers:
    return np.flatnonzero(run.marks[:, columns.KIND] == kind)


def _impacts(system: StructureSystem, run: StructureRun) -> StructureImpacts:
    rows = _rows(run, columns.IMPACT)
    stops = run.marks[rows, columns.BOUND]
    t = run.events[rows, columns.EVENT_T]
    # A clearance grows above a wall below, and falls with y below a wall above.
    signs = system.signs[stops]
    before, after = (signs * run.events[rows, k] for k in (columns.V_BEFORE, columns.V_AFTER))
    period = system.period
    cycle = np.full(len(t), np.nan) if period is None else t / period % 1.0
    # A rounding below a whole period is that period.
    cycle[cycle == 1.0] = 0.0
    intervals = np.diff(t, prepend=run.events[0, columns.EVENT_T])
    return StructureImpacts(
        t, before, after, stops, cycle, intervals, None, system.structure.units,
        effective_mass=system.effective_masses[stops],
    )  # fmt: skip


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureImpacts(Impacts):
    """The impacts on walls of a structure, in order; those of one instant one after another.

    Attributes
    ----------
    effective_mass
        (n,) array [mass], 1 / (c . M^-1 c) of the wall that is hit.
    """

    effective_mass: Floats = field(default_factory=lambda: np.empty(0))

    @property
    def impulse(self) -> Floats:
        """(n,) array, the wall's impulse along c, (v_after - v_before) / (c . M^-1 c)."""
        return (self.v_after - self.v_before) * self.effective_mass

    @property
    def _has_mass(self) -> bool:
        return True

    def _columns(self) -> Iterator[tuple[str, EventColumn, Any]]:
        yield from super(StructureImpacts, self)._columns()
        about = EventColumn("effective mass of the stop's direction", "mass")
        yield "effective_mass", about, self.effective_mass


def _crossings(system: StructureSystem, run: StructureRun) -> Crossings:
    rows = _rows(run, columns.CROSSING)
    stops = run.marks[rows, columns.BOUND]
    inwards = run.events[rows, columns.V_AFTER] < 0.0
    # A guard falls through zero: the clearance on the way in, the depth on the way out.
    v = run.events[rows, columns.V_BEFORE] * system.signs[stops] * np.where(inwards, 1.0, -1.0)
    direction = np.where(inwards, "in", "out")
    t = run.events[rows, columns.EVENT_T]
    return Crossings(t, v, stops, direction, system.structure.units)


def _contacts(system: StructureSystem, run: StructureRun) -> Contacts:
    rows = _rows(run, columns.CONTACT)
    stops = run.marks[rows, columns.BOUND]
    start = run.events[rows, columns.EVENT_T]
    release = np.full(len(rows), np.nan)
    held = np.array([int(key) for key in run.sets.keys], dtype=np.int64)
    # Of impacts at one instant only the set after all of them counts.
    instants = run.events[:, [columns.EVENT_T, columns.EVENT_T_LOW]]
    is_last = np.append((instants[1:] != instants[:-1]).any(axis=1), True)
    last = np.flatnonzero(is_last)[np.cumsum(is_last) - is_last]
    sets = run.marks[last, columns.NEXT_REGION]
    for k, row in enumerate(rows.tolist()):
        # It ends with the first set without it: by its own release, or by an impact elsewhere.
        free = held[sets[row:]] >> stops[k] & 1 == 0
        if free.any():
            release[k] = run.events[row + int(np.argmax(free)), columns.EVENT_T]
    listed = np.cumsum(run.marks[:, columns.KIND] == columns.IMPACT)[rows]
    errors = run.events[rows, columns.CONTACT_ERROR].copy()
    # No lambda, which is not pickled.
    bounds = functools.partial(np.asarray, errors)
    return Contacts(start, release, stops, listed, bounds, system.structure.units)


def _grazes(system: StructureSystem, run: StructureRun) -> Grazes:
    t, _, stop, clearance, error = (run.grazes[:, i] for i in range(5))
    units = system.structure.units
    return Grazes(t, stop.astype(np.int64), clearance, error, units)
