"""A certified orbit: what was proven of it, and its position and velocity at any time."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from itertools import zip_longest

from flint import arb
from numpy.typing import ArrayLike

from percuss.certified.ball_arithmetic import Ball, Balls, ComplexBall
from percuss.certified.ball_law import law_of, range_of
from percuss.certified.cloud import BallPair, hull
from percuss.certified.march import ImpactRow
from percuss.certified.motion import states_as_balls
from percuss.certified.numbers import precision, time_ball
from percuss.certified.properties import Monodromy, Proof
from percuss.certified.results import doubles_of, in_words
from percuss.certified.shooting import OrbitEvent, Shooting, States, region_of_row
from percuss.certified.steady import steady_flight, steady_pieces
from percuss.certified.step import Departure, state_in_flight
from percuss.certified.system import BallSystem
from percuss.certified.tables import CertifiedImpacts, impacts_of
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_fraction
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.wording import counted


@dataclass(frozen=True)
class OrbitMotion:
    """The motion on an orbit, between the states after its events; none for steady motion."""

    equations: Shooting
    states: States
    orbit: PeriodicOrbit

    def at(self, time: Phase) -> BallPair:
        """Return x and v; at an event the balls hold both sides."""
        system, period, states = self.equations.system, self.equations.period, self.states
        t = time_ball(time)
        if not states:
            number = region_of_row(system, int(self.orbit.record[1][0, 2]))
            if system.record is not None:
                t = t - (t / period).mid().floor().mid() * period
                steady = steady_pieces(system, number, period)
                return hull(_states_on(system, [start for start, _ in steady], t))
            flight = steady_flight(law_of(system), number, as_fraction(self.orbit.x0))
            (x, v), _ = flight.derivatives(t, 1)
            return x, v
        n = len(states)
        t = t - ((t - states[0][0]) / period).mid().floor().mid() * period
        at_time = []
        # The last flight may reach to the first event a period later, or earlier by the radius.
        for i, shift in ((n - 1, -1), *((i, 0) for i in range(n)), (0, 1)):
            begin = states[i][0] + shift * period
            end = self.equations.end_of_flight(i, states) + shift * period
            if t < begin or t > end:
                continue
            pieces = [start for start, _ in self.equations.pieces_of_flight(i, states)]
            at_time += _states_on(system, pieces, t - shift * period)
        return hull(at_time)


def _states_on(system: BallSystem, pieces: list[Departure], t: arb) -> list[BallPair]:
    """Return the states of a flight at an instant, on all pieces that may have begun."""
    states = []
    for start, following in zip_longest(pieces, pieces[1:]):
        if start.moment is not None and start.moment.t > t:
            break
        if following is None or following.moment is None or not following.moment.t < t:
            states.append(state_in_flight(system, start, t))
    return states


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedOrbit:
    """A periodic orbit that is proven; made by `certify`.

    Attributes
    ----------
    oscillator, forcing
        The exact values that the proof is about.
    exists
        Whether a solution of the formal equations, those of its events, is proven to exist: a
        motion where `admissible` is True. If not, all balls are without numbers.
    x0, v0, t0
        A point of the orbit: just after its first impact, or at t = 0 without impacts.
    impacts
        The impacts of one period, and entries into soft stops.
    n_impacts, n_periods
        Numbers of impacts, `math.inf` with sticking, and of forcing periods.
    period
        The duration of the orbit [time].
    trace, determinant
        Of the derivative over one period.
    multipliers
        Its eigenvalues, the larger first where that is known. These, trace and determinant are of
        the formal map, which is that of neighbouring motions where `admissible` is True.
    stability
        What is proven: "asymptotic", "elliptic" (determinant 1 and abs(trace) < 2), "parabolic",
        "unstable", or "undecided"; always that unless `admissible` is True, as neighbours of an
        orbit that grazes, or passes through a stop, follow another map.
    admissible
        Whether it passes through no stop: True and False are proven, None is open.
    isolated
        Whether it is proven to be the only one nearby with these events; a family is not.
    unique_within
        No other orbit with these events has all its instants and velocities after impacts within
        this part of the period, and of the greatest of those velocities, of this orbit's.
    reason
        What is open, and why.
    wanted_digits, precision
        The digits that were asked for, and the bits that were worked with.
    over
        A number of the force, by its path, and the ball for all values in which the proof holds;
        None where all numbers are exact.
    """

    oscillator: Oscillator
    forcing: Forcing | None
    exists: bool
    x0: Ball
    v0: Ball
    t0: Ball
    impacts: CertifiedImpacts
    n_impacts: float
    n_periods: int
    period: Ball
    trace: Ball
    determinant: Ball
    multipliers: tuple[ComplexBall, ComplexBall]
    stability: str
    admissible: bool | None
    isolated: bool
    unique_within: float
    reason: str
    wanted_digits: int
    precision: int
    over: tuple[str, Ball] | None
    _motion: OrbitMotion | None = field(repr=False)

    @property
    def events(self) -> list[tuple[OrbitEvent, BallPair]]:
        """The events of one period, each with its instant and the velocity after it.

        Empty where half of a symmetric orbit was proven, and without events.
        """
        motion = self._motion
        if motion is None or motion.equations.mirrored or not motion.states:
            return []
        return list(zip(motion.equations.events, motion.states, strict=True))

    def __call__(self, t: ArrayLike | Phase) -> tuple[Balls, Balls]:
        """Return (x, v) on the orbit at times t.

        Parameters
        ----------
        t
            Times of any shape, each taken exactly: a float is that double, ``"1/3"`` and
            ``"20*pi"`` are these numbers. At an impact the velocities of both sides are in the
            ball.

        Returns
        -------
        tuple of Balls
            x [length] and v [length/time], of t's shape.

        Raises
        ------
        ParameterError
            If the orbit is not proven or sticks; certify its `trajectory` then.

        Examples
        --------
        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
        >>> x, v = pc.certify(orbit)([0.5, 0.5 + 2.0 * orbit.period])
        >>> bool(abs(x.mid()[0] - x.mid()[1]) < 1e-14), bool(x.radius().max() < 1e-12)
        (True, True)
        """
        if self._motion is None:
            reason = "the motion on an orbit is enclosed where it is proven and has no contacts"
            raise ParameterError("t", t, reason)
        return states_as_balls(self._motion.at, t, self.precision)

    @property
    def doubles(self) -> tuple[str, ...]:
        """Numbers given as floats that are not the decimals they print as: taken as doubles."""
        return doubles_of(self.oscillator, self.forcing)

    @property
    def event_times(self) -> Balls:
        """The instants of all events of one period, exits from soft stops among them.

        Empty for steady motion, and where the motion is not enclosed.
        """
        return Balls.of(t for t, _ in self._motion.states) if self._motion else Balls(())

    @property
    def is_drawable(self) -> bool:
        """Whether its motion is enclosed: proven, and without contacts."""
        return self._motion is not None

    @property
    def is_stable(self) -> bool:
        """Whether neighbours provably approach the orbit: its stability is "asymptotic"."""
        return self.stability == "asymptotic"

    @property
    def sequence(self) -> tuple[int, ...]:
        """The stops that it meets, in order."""
        return tuple(int(stop) for stop in self.impacts.stop)

    @property
    def min_impact_speed(self) -> Ball:
        """Least speed of an impact [length/time]."""
        speeds = [abs(v) for v in self.impacts.v_before.arbs]
        return Ball(reduce(arb.min, speeds) if speeds else arb.nan())

    def __repr__(self) -> str:
        """Return in a line what is proven."""
        if not self.exists:
            return f"<CertifiedOrbit: not proven; {self.reason}>"
        known = {True: "admissible", False: "formal", None: "admissible or not is open"}
        isolated = "alone with these events" if self.isolated else "one of a family"
        open_ = f"; {self.reason}" if self.reason else ""
        stability = "stability undecided" if self.stability == "undecided" else self.stability
        return (
            f"<CertifiedOrbit: {counted(self.n_impacts, 'impact')} in {counted(self.n_periods, 'period')}, "
            f"T = {self.period.text(12)}, {stability}, {known[self.admissible]}, {isolated}{open_}"
            f"{in_words(self.doubles)}>"
        )


def orbit_of_proof(
    system: BallSystem,
    orbit: PeriodicOrbit,
    proof: Proof,
    digits: int,
    bits: int,
    *,
    exists: bool = True,
) -> CertifiedOrbit:
    """Make the result of a proof, or of one that failed."""
    with precision(bits):
        impacts = _impacts(system, proof)
        x0, v0, t0 = proof.start or (
            law_of(system).places[proof.events[0].bound],
            proof.states[0][1],
            proof.states[0][0],
        )
    equations = Shooting(system, proof.events, proof.period)
    enclosed = exists and not proof.sticking
    first, second = proof.monodromy.multipliers
    return CertifiedOrbit(
        oscillator=orbit.oscillator,
        forcing=orbit.forcing,
        exists=exists,
        x0=Ball(x0),
        v0=Ball(v0),
        t0=Ball(t0),
        impacts=impacts,
        n_impacts=len(impacts) if enclosed else orbit.n_impacts,
        n_periods=orbit.n_periods,
        period=Ball(proof.period),
        trace=Ball(proof.monodromy.trace),
        determinant=Ball(proof.monodromy.determinant),
        multipliers=(ComplexBall(first), ComplexBall(second)),
        stability=proof.monodromy.stability if proof.admissible else "undecided",
        admissible=proof.admissible,
        isolated=proof.isolated,
        unique_within=proof.unique_within,
        reason=proof.reason,
        wanted_digits=digits,
        precision=bits,
        over=range_of(system),
        _motion=OrbitMotion(equations, proof.states, orbit) if enclosed else None,
    )


def unproven(
    system: BallSystem, orbit: PeriodicOrbit, reason: str, digits: int, bits: int
) -> CertifiedOrbit:
    """Make the result of a proof that failed."""
    nan = arb.nan()
    monodromy = Monodromy.of(((nan, nan), (nan, nan)), nan, conservative=False)
    proof = Proof([], [], [], nan, monodromy, None, False, 0.0, reason, (nan, nan, nan))
    return orbit_of_proof(system, orbit, proof, digits, bits, exists=False)


def _impacts(system: BallSystem, proof: Proof) -> CertifiedImpacts:
    """Return the events that meet a stop; the first interval is that after the last event."""
    rows = [
        ImpactRow(t, before, after, event.stop)
        for event, (t, after), before in zip(proof.events, proof.states, proof.before, strict=True)
        if event.stop is not None
    ]
    return impacts_of(system, rows, rows[-1].t - proof.period if rows else arb(0))
