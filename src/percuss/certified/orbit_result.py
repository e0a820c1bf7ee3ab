"""A certified orbit: what was proven of it, and its position and velocity at any time."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce

import numpy as np
from flint import acb, arb
from numpy.typing import ArrayLike

from percuss.certified.balls import Ball, Balls, ComplexBall
from percuss.certified.cloud import BallPair, Cloud
from percuss.certified.law import law_of, range_of
from percuss.certified.motion import states_as_balls
from percuss.certified.numbers import ball, between, precision, time_ball
from percuss.certified.properties import Monodromy, Proof
from percuss.certified.results import doubles_of, in_words
from percuss.certified.shooting import OrbitEvent, States, region_of_row
from percuss.certified.steady import steady_flight
from percuss.certified.step import Departure, flight_of
from percuss.certified.system import BallSystem
from percuss.certified.tables import CertifiedImpacts, cycles_of
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_fraction
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["CertifiedOrbit", "OrbitMotion", "orbit_of_proof", "unproven"]


@dataclass(frozen=True)
class OrbitMotion:
    """The events of an orbit, and what moves between them.

    Attributes
    ----------
    system, events, states, period
        Of the proof; no events for steady motion.
    orbit
        The float orbit.
    """

    system: BallSystem
    events: list[OrbitEvent]
    states: States
    period: arb
    orbit: PeriodicOrbit

    def at(self, time: Phase) -> BallPair:
        """Return x and v; at an event both sides are in the balls."""
        t = time_ball(time)
        if not self.states:
            number = region_of_row(self.system, int(self.orbit.record[1][0, 2]))
            steady = steady_flight(law_of(self.system), number, as_fraction(self.orbit.x0))
            (x, v), _ = steady.derivatives(t, 1)
            return x, v
        n = len(self.states)
        turns = ((t - self.states[0][0]) / self.period).mid().floor().mid()
        t = t - turns * self.period
        found: BallPair | None = None
        # The last flight may reach to the first event a period later, or earlier by the radius.
        for i, shift in ((n - 1, -1), *((i, 0) for i in range(n)), (0, 1)):
            begin = self.states[i][0] + shift * self.period
            end = self.states[(i + 1) % n][0] + (shift + (i + 1) // n) * self.period
            if t < begin or t > end:
                continue
            here = self._on_flight(i, t - begin)
            found = (
                here if found is None else (between(found[0], here[0]), between(found[1], here[1]))
            )
        assert found is not None
        return found

    def _on_flight(self, i: int, s: arb) -> BallPair:
        event = self.events[i]
        place = self.system.bounds[event.bound].at
        start = Departure(event.after, place, Cloud.of(*self.states[i]), event.bound)
        (x, v), _ = flight_of(self.system, start, whole=True).derivatives(s, 1)
        return x, v


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedOrbit:
    """A periodic orbit that is proven; made by `certify`.

    Attributes
    ----------
    oscillator, forcing
        What moves: the exact values that the proof is about.
    exists
        Whether a solution of the formal equations, those of its events, is proven to be there:
        a motion where `admissible` is True. If not, all balls are without numbers.
    x0, v0, t0
        A point of the orbit: just after its first impact, or at t = 0 without impacts.
    impacts
        The impacts of one period, and entries into soft stops.
    n_impacts, n_periods
        How many, and in how many forcing periods; `math.inf` with sticking.
    period
        How long it lasts [time].
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
        The number of the force, by its path, for all of whose values in a ball the proof holds;
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

        None for steady motion, and where the motion is not enclosed.
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
        """Tell in a line what is proven."""
        if not self.exists:
            return f"<CertifiedOrbit: not proven; {self.reason}>"
        known = {True: "admissible", False: "formal", None: "admissible or not is open"}
        alone = "alone with these events" if self.isolated else "one of a family"
        open_ = f"; {self.reason}" if self.reason else ""
        stability = "stability undecided" if self.stability == "undecided" else self.stability
        return (
            f"<CertifiedOrbit: {self.n_impacts:g} impacts in {self.n_periods} periods, "
            f"T = {self.period.text(12)}, {stability}, {known[self.admissible]}, {alone}{open_}"
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
            ball(system.bounds[proof.events[0].bound].at),
            proof.states[0][1],
            proof.states[0][0],
        )
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
        _motion=OrbitMotion(system, proof.events, proof.states, proof.period, orbit)
        if enclosed
        else None,
    )


def unproven(
    system: BallSystem, orbit: PeriodicOrbit, reason: str, digits: int, bits: int
) -> CertifiedOrbit:
    """Make the result of a proof that failed."""
    nan, complex_nan = arb.nan(), acb(arb.nan())
    monodromy = Monodromy(
        ((nan, nan), (nan, nan)),
        nan,
        nan,
        conservative=False,
        multipliers=(complex_nan, complex_nan),
        stability="undecided",
    )
    proof = Proof(
        events=[],
        states=[],
        before=[],
        period=nan,
        monodromy=monodromy,
        admissible=None,
        isolated=False,
        unique_within=0.0,
        reason=reason,
        start=(nan, nan, nan),
    )
    return orbit_of_proof(system, orbit, proof, digits, bits, exists=False)


def _impacts(system: BallSystem, proof: Proof) -> CertifiedImpacts:
    """Return the events that meet a stop; the interval before the first is that after the last."""
    met = [i for i, event in enumerate(proof.events) if event.stop is not None]
    instants = [proof.states[i][0] for i in met]
    earlier = [instants[-1] - proof.period, *instants[:-1]] if met else []
    return CertifiedImpacts(
        t=Balls.of(instants),
        v_before=Balls.of(proof.before[i] for i in met),
        v_after=Balls.of(proof.states[i][1] for i in met),
        stop=np.array([proof.events[i].stop for i in met], dtype=np.int64),
        cycle=cycles_of(system, instants),
        intervals=Balls.of(t - before for t, before in zip(instants, earlier, strict=True)),
    )
