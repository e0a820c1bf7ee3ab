"""A certified orbit as a value."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from percuss.certified.balls import Ball, Balls, ComplexBall
from percuss.certified.chain import Link
from percuss.certified.multipliers import Monodromy
from percuss.certified.numbers import ball, precision
from percuss.certified.system import System
from percuss.certified.tables import CertifiedImpacts, cycles_of
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["CertifiedOrbit", "Proof", "orbit_of_proof", "unproven"]


@dataclass(frozen=True)
class Proof:
    """What is proven of an orbit, at the working precision.

    Attributes
    ----------
    chain, states, before
        The events, instants and velocities after them, and velocities before.
    period
        How long it lasts.
    monodromy
        Its derivative.
    admissible
        Whether it passes through no stop; None where that is open.
    isolated
        Whether it is alone.
    unique_within
        Part of period and speed within which it is proven to be the only one.
    reason
        What is open.
    start
        (x, v, t) of an orbit without events.
    """

    chain: list[Link]
    states: list[tuple[arb, arb]]
    before: list[arb]
    period: arb
    monodromy: Monodromy
    admissible: bool | None
    isolated: bool
    unique_within: float
    reason: str
    start: tuple[arb, arb, arb] | None = None
    sticking: bool = False

    def digits(self) -> float:
        """Return the fewest decimal digits of the events, as parts of the period and the speed."""
        with precision(64):
            fastest = max((abs(v) for _, v in self.states), key=float, default=arb(1))
            errors = [t.rad() / self.period for t, _ in self.states]
            errors += [v.rad() / fastest for _, v in self.states]
            if self.start is not None:
                x, v, _ = self.start
                errors += [x.rad() / abs(x).max(abs(v)), v.rad() / abs(v).max(abs(x))]
            worst = max((float(error.abs_upper()) for error in errors), default=0.0)
        return math.inf if worst == 0.0 else -math.log10(worst)


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedOrbit:
    """A periodic orbit that is proven; made by `certify`.

    Attributes
    ----------
    oscillator, forcing
        What moves: the exact values that the proof is about.
    exists
        Whether an orbit is proven to be there. If not, all balls are without numbers.
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
        Its eigenvalues, the larger first where that is known.
    stability
        What is proven: "asymptotic", "elliptic" (determinant 1 and abs(trace) < 2), "parabolic",
        "unstable", or "undecided".
    admissible
        Whether it passes through no stop: True and False are proven, None is open.
    isolated
        Whether it is proven to be the only one nearby; a family is not.
    unique_within
        No other orbit with these events has all its instants and velocities after impacts within
        this part of the period, and of the greatest of those velocities, of this orbit's.
    reason
        What is open, and why.
    wanted_digits, precision
        The digits that were asked for, and the bits that were worked with.
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
    _proof: Proof | None = field(repr=False)

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
        if not speeds:
            return Ball(arb.nan())
        least = speeds[0]
        for speed in speeds[1:]:
            least = least.min(speed)
        return Ball(least)

    def __repr__(self) -> str:
        """Tell in a line what is proven."""
        if not self.exists:
            return f"<CertifiedOrbit: not proven; {self.reason}>"
        known = {True: "admissible", False: "formal", None: "admissible or not is open"}
        alone = "alone" if self.isolated else "one of a family"
        open_ = f"; {self.reason}" if self.reason else ""
        return (
            f"<CertifiedOrbit: {self.n_impacts:g} impacts in {self.n_periods} periods, "
            f"T = {self.period.text(12)}, {self.stability}, {known[self.admissible]}, {alone}{open_}>"
        )


def orbit_of_proof(
    system: System, orbit: PeriodicOrbit, proof: Proof, digits: int, bits: int
) -> CertifiedOrbit:
    """Make the result of a proof."""
    start = proof.start
    with precision(bits):
        impacts = _impacts(system, proof)
        if start is None:
            place = ball(system.bounds[proof.chain[0].bound].at)
            start = place, proof.states[0][1], proof.states[0][0]
    first, second = proof.monodromy.multipliers
    count: float = len(impacts)
    return CertifiedOrbit(
        oscillator=orbit.oscillator,
        forcing=orbit.forcing,
        exists=True,
        x0=Ball(start[0]),
        v0=Ball(start[1]),
        t0=Ball(start[2]),
        impacts=impacts,
        n_impacts=math.inf if proof.sticking else count,
        n_periods=orbit.n_periods,
        period=Ball(proof.period),
        trace=Ball(proof.monodromy.trace),
        determinant=Ball(proof.monodromy.determinant),
        multipliers=(ComplexBall(first), ComplexBall(second)),
        stability=proof.monodromy.stability,
        admissible=proof.admissible,
        isolated=proof.isolated,
        unique_within=proof.unique_within,
        reason=proof.reason,
        wanted_digits=digits,
        precision=bits,
        _proof=proof,
    )


def unproven(
    system: System, orbit: PeriodicOrbit, reason: str, digits: int, bits: int
) -> CertifiedOrbit:
    """Make the result of a proof that failed."""
    nothing = Ball(arb.nan())
    none = ComplexBall(acb(arb.nan()))
    empty = Balls(())
    no_stops: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    return CertifiedOrbit(
        oscillator=system.oscillator,
        forcing=system.forcing,
        exists=False,
        x0=nothing,
        v0=nothing,
        t0=nothing,
        impacts=CertifiedImpacts(empty, empty, empty, no_stops, empty, empty),
        n_impacts=orbit.n_impacts,
        n_periods=orbit.n_periods,
        period=nothing,
        trace=nothing,
        determinant=nothing,
        multipliers=(none, none),
        stability="undecided",
        admissible=None,
        isolated=False,
        unique_within=0.0,
        reason=reason,
        wanted_digits=digits,
        precision=bits,
        _proof=None,
    )


def _impacts(system: System, proof: Proof) -> CertifiedImpacts:
    """Return the events that meet a stop; the interval before the first is that after the last."""
    met = [i for i, link in enumerate(proof.chain) if link.stop is not None]
    instants = [proof.states[i][0] for i in met]
    earlier = [instants[-1] - proof.period, *instants[:-1]] if met else []
    return CertifiedImpacts(
        t=Balls.of(instants),
        v_before=Balls.of(proof.before[i] for i in met),
        v_after=Balls.of(proof.states[i][1] for i in met),
        stop=np.array([proof.chain[i].stop for i in met], dtype=np.int64),
        cycle=cycles_of(system, instants),
        intervals=Balls.of(t - before for t, before in zip(instants, earlier, strict=True)),
    )
