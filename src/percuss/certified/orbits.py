"""The proof of a periodic orbit: existence, isolation, admissibility and stability."""

from __future__ import annotations

import math

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import Over, coarse_bits, system_for, too_wide
from percuss.certified.branch import system_at
from percuss.certified.families import family_orbit
from percuss.certified.numbers import precision, upper
from percuss.certified.orbit_result import CertifiedOrbit, orbit_of_proof, unproven
from percuss.certified.properties import Proof, admissible_of, monodromy_of
from percuss.certified.shooting import (
    Residual,
    Shooting,
    krawczyk,
    pairs,
    shooting_of,
    unique_in,
    vector_of,
)
from percuss.certified.steady import steady_proof
from percuss.certified.sticking import sticking_proof
from percuss.certified.system import BallSystem, system_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["certify_orbit"]

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
            # Over a range of values more bits give no more digits.
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
        if not system.is_exact:
            reason = "the closed form of a family is of exact numbers, and one is a ball here"
            raise Undecided("precision", reason)
        return family_orbit(system, orbit)
    return _isolated(system, orbit)


def _isolated(system: BallSystem, orbit: PeriodicOrbit) -> Proof:
    equations, guess = shooting_of(system, orbit)
    solution = _middle(equations, orbit).newton(guess)
    point, coarse = vector_of(solution), coarse_bits(system)
    residual = Residual(lambda z: equations.images(pairs(z), coarse))
    solved = krawczyk(residual.value, residual.derivative, point)
    states = pairs(solved.box)
    monodromy, before = monodromy_of(equations, states)
    admissible, reason = admissible_of(equations, states)
    # Bounds of the period and the greatest velocity.
    scales = upper(equations.period), max(upper(v) for _, v in states)
    unique = 0.0
    for width in WIDTHS:
        sizes = [arb(width * scale) for _ in states for scale in scales]
        holds = (abs(x - z) < size for x, z, size in zip(solved.box, point, sizes, strict=True))
        if all(holds) and unique_in(residual.derivative, residual.value, point, sizes):
            unique = width
            break
    return Proof(
        events=equations.events,
        states=states,
        before=before,
        period=equations.period,
        monodromy=monodromy,
        admissible=admissible,
        unique_within=unique,
        reason=reason,
    )


def _middle(equations: Shooting, orbit: PeriodicOrbit) -> Shooting:
    """Return the equations for the middle of a range, these themselves where there is none."""
    system = equations.system
    if system.moved is None:
        return equations
    path, low, high = system.moved
    middle = system_at(system, path, (low + high) / 2)
    return Shooting.of(middle, equations.events, orbit.n_periods)
