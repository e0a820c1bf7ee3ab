"""A periodic orbit proven: that it is there, alone, admissible, and how stable."""

from __future__ import annotations

import math

from flint import arb, ctx

from percuss.certified.balls import Undecided
from percuss.certified.branch import equations_at, system_at
from percuss.certified.cloud import BallMatrix, times
from percuss.certified.families import family_orbit
from percuss.certified.law import Over, coarse_bits, law_of, system_for, too_wide
from percuss.certified.numbers import precision, upper
from percuss.certified.orbit_result import CertifiedOrbit, orbit_of_proof, unproven
from percuss.certified.properties import Monodromy, Proof, admissible_of, monodromy_of
from percuss.certified.shooting import (
    Residual,
    Shooting,
    States,
    chain_of,
    krawczyk,
    pairs,
    unique_in,
)
from percuss.certified.steady import steady_proof
from percuss.certified.sticking import sticking_proof
from percuss.certified.system import BallSystem, system_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["certify_orbit", "monodromy_over", "shooting_of"]

FIRST_MARGIN = 60
# Half-widths of boxes in which uniqueness is tried, as parts of period and speed.
WIDTHS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)


def certify_orbit(
    orbit: PeriodicOrbit,
    digits: int,
    most_bits: int,
    bits: int | None,
    over: Over | None = None,
) -> CertifiedOrbit:
    """Prove an orbit; see `percuss.certify`."""
    system = system_for(system_of(orbit.oscillator, orbit.forcing), over)
    work = bits or math.ceil(digits / math.log10(2)) + FIRST_MARGIN
    before = -math.inf
    while True:
        try:
            with precision(work):
                proof = _proof(system, orbit, digits)
            # Of all values of a range bits give no more digits.
            no_more = system.moved is not None and proof.digits() < before + 1.0
            if bits is not None or proof.digits() >= digits or work >= most_bits or no_more:
                return orbit_of_proof(system, orbit, proof, digits, work)
            before = proof.digits()
            reason = f"{proof.digits():.1f} digits"
        except Undecided as question:
            reason = question.reason
            if bits is not None or work >= most_bits:
                if bits is None:
                    reason += too_wide(system)
                return unproven(system, orbit, reason, digits, work)
        work = min(most_bits, 2 * work)


def _proof(system: BallSystem, orbit: PeriodicOrbit, digits: int) -> Proof:
    if math.isinf(orbit.n_impacts):
        return sticking_proof(system, orbit, digits)
    if len(orbit.itinerary) == 0:
        return steady_proof(system, orbit)
    if not orbit.isolated or not orbit.n_periods:
        if system.moved is not None:
            reason = "the closed form of a family is of exact numbers, and one is a ball here"
            raise Undecided("precision", reason)
        return family_orbit(system, orbit)
    return _isolated(system, orbit)


def shooting_of(system: BallSystem, orbit: PeriodicOrbit) -> tuple[Shooting, States]:
    """Return the equations of an orbit, and the floats that solve them nearly.

    Raises
    ------
    Undecided
        If the period is not known exactly.
    """
    chain = chain_of(system, orbit)
    n = len(chain)
    period = law_of(system).period(orbit.n_periods)
    unknowns = [float(value) for value in orbit.itinerary.vector]
    t = arb(unknowns[0])
    states = []
    for i in range(n):
        states.append((t, arb(unknowns[1 + n + i])))
        t = t + arb(unknowns[1 + i])
    return Shooting(system, chain, period), states


def _isolated(system: BallSystem, orbit: PeriodicOrbit) -> Proof:
    equations, guess = shooting_of(system, orbit)
    solution = _middle(equations, orbit).newton(guess)
    point = [value for state in solution for value in state]
    coarse = coarse_bits(system)

    residual = Residual(lambda z: equations.images(pairs(z), coarse))
    solved = krawczyk(residual.value, residual.derivative, point)
    states = pairs(solved.box)
    monodromy, images = monodromy_over(equations, states)
    admissible, reason = admissible_of(equations, states)
    # Of the true period and greatest velocity, none of which is larger than these.
    scales = upper(equations.period), max(upper(v) for _, v in states)
    unique = 0.0
    for width in WIDTHS:
        sizes = [arb(width * scale) for _ in states for scale in scales]
        holds = (abs(x - z) < size for x, z, size in zip(solved.box, point, sizes, strict=True))
        if all(holds) and unique_in(residual.derivative, residual.value, point, sizes):
            unique = width
            break
    return Proof(
        chain=equations.chain,
        states=states,
        before=images,
        period=equations.period,
        monodromy=monodromy,
        admissible=admissible,
        isolated=True,
        unique_within=unique,
        reason=reason,
    )


def _middle(equations: Shooting, orbit: PeriodicOrbit) -> Shooting:
    """Return the equations for the middle of a range, these themselves where there is none."""
    system = equations.system
    if system.moved is None:
        return equations
    path, low, high = system.moved
    return equations_at(system_at(system, path, (low + high) / 2), equations.chain, orbit.n_periods)


def monodromy_over(equations: Shooting, states: States) -> tuple[Monodromy, list[arb]]:
    """Return the derivative over one orbit, and the velocities before the events.

    Raises
    ------
    Undecided
        If the flights' roots may be others than the events of the orbit.
    """
    product: BallMatrix | None = None
    n = len(states)
    before = [arb(0)] * n
    durations = []
    for i, state in enumerate(states):
        following = (i + 1) % n
        until = states[following][0] + (equations.period if following == 0 else arb(0))
        there = equations.arrival(i, state, until, ctx.prec)
        if not there.alone.contains(until - state[0]):
            raise Undecided("precision", "a flight's root may be another one than the orbit's")
        before[following] = there.box[1]
        kept = equations.chain[following].kept(equations.system)
        by_t, by_v = there.derivative
        block: BallMatrix = by_t, (kept * by_v[0], kept * by_v[1])
        product = block if product is None else times(block, product)
        durations.append(until - state[0])
    assert product is not None
    return monodromy_of(equations.system, equations.chain, durations, product), before
