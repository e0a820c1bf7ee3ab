"""A periodic orbit as a value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from percuss.arrays import Complexes, Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import later
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.system import System
from percuss.motion.html_table import html_table
from percuss.motion.spectrum import line_spectrum
from percuss.motion.tables import Impacts
from percuss.motion.trajectory import Outcome, Trajectory
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.knots import with_knots
from percuss.orbits.orbit.moved_orbit import ClosedMotion, OrbitSensitivity, sensitivity_of_orbit
from percuss.orbits.orbit.stability import Stability
from percuss.orbits.orbit.symmetry import is_mirrored_state, is_symmetric_system
from percuss.orbits.orbit.turning_points import Passages, TurningPoints, turning_points_of
from percuss.pictures import HasPicture
from percuss.wording import counts_in_words

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class PeriodicOrbit(HasPicture):
    """A periodic motion with its stability; made by `find_orbit` and `find_orbits`.

    Attributes
    ----------
    oscillator, forcing
        What moves; the forcing is None for free motion.
    x0, v0, t0
        A point of the orbit: just after its first impact, or at t = 0 without impacts.
    impacts
        The impacts of one period, and entries into soft stops, whose velocity stays; the first
        one at t0. Of a chatter those that are listed one by one.
    n_impacts
        How many they are; `math.inf` with sticking.
    n_periods
        How many forcing periods the orbit lasts; 0 where there is no forcing period.
    period
        How long it lasts [time].
    monodromy
        (2, 2) array, derivative of (x, v) one period after t0 by (x, v) at t0.
    multipliers
        (2,) complex array, its eigenvalues, larger first; 0 with sticking. Free motion has one
        at 1.
    stability
        "asymptotic", "elliptic", "parabolic" or "unstable", to first order.
    admissible
        Whether the orbit passes through no stop; one that does is formal.
    grazing_margin
        Distance to a stop of the nearest turning point between two events [length], negative
        exactly where the orbit is not admissible; inf where there is none. With sticking the
        hops, which accumulate at the stop, are left out.
    passages
        Where and how deep a formal orbit passes through a stop.
    min_impact_speed
        Least speed of an impact [length/time]: 0 with sticking, NaN without impacts.
    isolated
        False if the orbit is one of a family in one and the same system.
    residual
        Largest error of the equations of the orbit [length, length/time, time].
    """

    picture: ClassVar = "plot_orbit"

    oscillator: Oscillator
    forcing: Forcing | None
    x0: float
    v0: float
    t0: float
    impacts: Impacts
    n_impacts: float
    n_periods: int
    period: float
    monodromy: Floats
    multipliers: Complexes
    stability: Stability
    admissible: bool
    grazing_margin: float
    passages: Passages
    min_impact_speed: float
    isolated: bool
    residual: float
    # The names of these fields are those in files.
    _events: Floats = field(repr=False)
    _marks: Integers = field(repr=False)
    _sequence: Integers = field(repr=False)
    _vector: Floats = field(repr=False)

    @property
    def system(self) -> System:
        """Its oscillator and forcing as one value."""
        return System(self.oscillator, self.forcing)

    @property
    def itinerary(self) -> Itinerary:
        """Its events with their instants and velocities; none without impacts or with sticking."""
        return Itinerary.of_vector(self._sequence, self._vector, self.n_periods)

    @property
    def record(self) -> tuple[Floats, Integers]:
        """Its events and marks as the kernels write them; the last event is the first again."""
        return self._events, self._marks

    @property
    def turning_points(self) -> TurningPoints:
        """Turning points between two events in a period; of a motion without events, in 1.5."""
        # The ends of a flight are no turning points of it.
        duration = self.period if len(self._sequence) else 1.5 * self.period
        return turning_points_of(self.system.law, *self.record, self.x0, self.t0 + duration)

    @property
    def is_stable(self) -> bool:
        """Whether neighbours approach the orbit: its stability is "asymptotic"."""
        return self.stability == "asymptotic"

    @property
    def symmetric(self) -> bool:
        """Whether it repeats itself mirrored, x -> -x, after half its period.

        For that the system must be so after half a forcing period: its stops mirror each other
        and its forcing has odd harmonics only.
        """
        even = self.n_periods > 0 and self.n_periods % 2 == 0
        if even or not is_symmetric_system(*self.system):
            return False
        run = self.trajectory(2)
        # In the middle of the longest flight: no event is near.
        ends = np.append(self._events[:, columns.EVENT_T], self.t0 + self.period)
        longest = int(np.argmax(np.diff(ends)))
        t = 0.5 * float(ends[longest] + ends[longest + 1])
        x, v = run([t, t + 0.5 * self.period])
        fastest = max(float(np.abs(self._events[:, columns.V_AFTER]).max()), float(np.abs(v).max()))
        scale = np.array([fastest * self.period, fastest])
        return is_mirrored_state((float(x[0]), float(v[0])), (float(x[1]), float(v[1])), scale)

    @property
    def sequence(self) -> tuple[int, ...]:
        """The stops that it meets, in order."""
        return tuple(int(stop) for stop in self.impacts.stop)

    def __repr__(self) -> str:
        """Return the orbit in a line."""
        counts = counts_in_words(self.n_impacts, self.n_periods)
        sizes = ", ".join(f"{abs(value):.4g}" for value in self.multipliers)
        formal = "" if self.admissible else "; formal, it passes through a stop"
        family = "" if self.isolated else "; one of a family"
        return (
            f"<PeriodicOrbit: {counts}, T = {self.period:.6g}, {self.stability}, "
            f"abs(multipliers) {sizes}{family}{formal}>"
        )

    def _repr_html_(self) -> str:
        columns = {
            name: getattr(self.impacts, name)
            for name in ("t", "v_before", "v_after", "stop", "cycle")
        }
        return html_table(repr(self)[1:-1], columns)

    @property
    def run(self) -> Trajectory:
        """The motion over one period of the orbit, as orbits of structures have it."""
        return self.trajectory()

    def trajectory(self, periods: int = 1) -> Trajectory:
        """Return the motion over whole periods of the orbit, from t0 on.

        It is put together from the orbit's own events, so that unstable orbits stay on it and
        formal ones pass through stops.

        Parameters
        ----------
        periods
            How many, >= 1.

        Returns
        -------
        Trajectory
            As `simulate` returns it; the impact at its end is the first one again.

        Raises
        ------
        ParameterError
            If the number is below 1.

        Examples
        --------
        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> run = orbit.trajectory()
        >>> x, v = run([run.t0, run.t_end])
        >>> bool(abs(v[1] - v[0]) < 1e-12)
        True
        """
        if periods < 1:
            raise ParameterError("periods", periods, "less than one")
        blocks_of_events, blocks_of_marks = [self._events[:1]], [self._marks[:1]]
        for k in range(periods):
            events = self._events[1:].copy()
            for row in events:
                instant = row[columns.EVENT_T], row[columns.EVENT_T_LOW]
                row[columns.EVENT_T], row[columns.EVENT_T_LOW] = later(*instant, k * self.period)
            blocks_of_events.append(events)
            blocks_of_marks.append(self._marks[1:])
        events, marks = np.concatenate(blocks_of_events), np.concatenate(blocks_of_marks)
        t_end = float(events[-1, columns.EVENT_T]) if len(events) > 1 else 0.0
        if len(self._events) == 1:
            t_end = self.t0 + periods * self.period
        events, marks = with_knots(self.system.law, events, marks, self.x0, t_end)
        record = (self.x0, self.v0), events, marks, np.empty((0, columns.GRAZE_COLUMNS))
        return Trajectory.of_record(self.system, record, t_end, Outcome.reached_t_end)

    def sensitivity(self, paths: Sequence[str]) -> OrbitSensitivity:
        """Return the derivative of the orbit by parameters, exact to rounding.

        Parameters
        ----------
        paths
            Paths of parameters of the oscillator and the forcing, in long or short form, and
            names of parameters in expressions.

        Returns
        -------
        OrbitSensitivity
            That of its start, period, impacts, motion, measures and multipliers.

        Raises
        ------
        ParameterError
            If there is no such parameter, or moved alone it leaves the forcing without a period.
        ConvergenceError
            If the orbit grazes a wall, is on a fold, or is one of a family.

        Examples
        --------
        With the wall at 0 all velocities grow as the force does, and no instant moves:

        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> moved = orbit.sensitivity(["forcing.amplitude"])
        >>> (moved.v0 / orbit.v0).round(9), moved.t0.round(9) + 0.0
        (array([1.]), array([0.]))
        """
        closed = ClosedMotion(
            self.trajectory(),
            self.impacts,
            self.period,
            self.n_periods,
            self.monodromy,
            self.multipliers,
            self.isolated,
        )
        return sensitivity_of_orbit(closed, paths)

    def spectrum(self, n_lines: int = 33) -> Dataset:
        """Return the Fourier coefficients of the displacement, exact to rounding.

        Parameters
        ----------
        n_lines
            How many lines, from the mean on, >= 1.

        Returns
        -------
        xarray.Dataset
            As `line_spectrum` returns it, line n at 2 pi n/period; phases are those of time.

        Raises
        ------
        ParameterError
            If the number is below 1.

        Examples
        --------
        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> round(float(orbit.spectrum(3).cosine[0]), 9)
        0.462199452
        """
        # One period more than are used, and another for the rounding of the ends.
        return line_spectrum(self.trajectory(3), self.period, n_lines)
