"""The proof of a periodic orbit: existence, isolation, admissibility and stability."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import Over, coarse_bits, law_of, system_for, too_wide
from percuss.certified.branch import system_at
from percuss.certified.contact import Hold
from percuss.certified.families import family_orbit
from percuss.certified.march import Ending, MarchLimits, MarchRecord, march
from percuss.certified.numbers import largest_abs, precision
from percuss.certified.orbit_result import CertifiedOrbit, orbit_of_proof, unproven
from percuss.certified.properties import Monodromy, Proof, admissible_of, monodromy_of
from percuss.certified.shooting import (
    OrbitEvent,
    Residual,
    Shooting,
    krawczyk,
    pairs,
    shooting_of,
    unique_in,
    vector_of,
)
from percuss.certified.steady import steady_proof
from percuss.certified.system import BallSystem, system_of
from percuss.model.exact import PiTimes
from percuss.model.start import Start
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

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
    work = bits or min(most_bits, math.ceil(digits / math.log10(2)) + FIRST_MARGIN)
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
        return _sticking(system, orbit, digits)
    if len(orbit.itinerary) == 0:
        return steady_proof(system, orbit)
    if orbit.isolated and not orbit.n_periods:
        reason = (
            "the period of a limit cycle is an unknown; certify(orbit.trajectory()) proves a run"
        )
        raise Undecided("precision", reason)
    if not orbit.isolated:
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
    scales = largest_abs(equations.period), max(largest_abs(v) for _, v in states)
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


def _sticking(system: BallSystem, orbit: PeriodicOrbit, digits: int) -> Proof:
    """Return the proof of an orbit with sticking: a contact that returns after whole periods.

    In contact the mass is at the wall without velocity, and the forcing is periodic: a motion in
    contact at an instant and again a whole number of periods later is periodic from there on,
    exactly. All neighbours that reach the same contact follow the same motion after its release,
    so both multipliers are zero.

    Raises
    ------
    Undecided
        If the motion from the middle of a contact is not proven to come back to it.
    """
    period = law_of(system).exact_period()
    if period is None:
        raise Undecided("precision", "the period of the forcing is not known exactly")
    contacts = orbit.trajectory(2).contacts
    rows = [
        (start, end, stop)
        for start, end, stop in zip(contacts.start, contacts.release, contacts.stop, strict=True)
        if end > start
    ]
    if not rows:
        raise Undecided("precision", "the motion from the orbit has no contact")
    begin, end, stop = max(rows, key=lambda row: float(row[1] - row[0]))
    # Any instant of the contact, exactly.
    middle = float(0.5 * (begin + end))
    start = Start(orbit.oscillator.stops[int(stop)].at, 0, middle)
    n = orbit.n_periods
    after = PiTimes(n * period.times, n * period.plus) + middle
    finest = Fraction(1, 2 * 10**digits)
    record = march(system, start, MarchLimits(after, None, finest))
    ends = [record.pieces[0].what, record.pieces[-1].what] if record.pieces else [None]
    sticks = all(isinstance(piece, Hold) for piece in ends)
    if record.ending is not Ending.reached_t_end or not sticks:
        raise Undecided(
            "precision", record.reason or "the motion does not come back to its contact"
        )
    first, last = record.contacts[0], record.contacts[-1]
    if first.stop != last.stop or len(record.contacts) < 2:
        raise Undecided("precision", "the motion comes back to another contact")
    return _proof_of_contact(system, orbit, record)


def _proof_of_contact(system: BallSystem, orbit: PeriodicOrbit, record: MarchRecord) -> Proof:
    zero = arb(0)
    bounds = {bound.wall: i for i, bound in enumerate(system.bounds)}
    events = [OrbitEvent(bounds[row.stop], 0, 0, row.stop, wall=True) for row in record.impacts]
    monodromy = Monodromy.of(((zero, zero), (zero, zero)), zero, conservative=False)
    release = record.contacts[0].release
    assert release is not None
    law = law_of(system)
    place = law.places[bounds[record.contacts[0].stop]]
    return Proof(
        events=events,
        states=[(row.t, row.v_after) for row in record.impacts],
        before=[row.v_before for row in record.impacts],
        period=law.period(orbit.n_periods),
        monodromy=monodromy,
        admissible=True,
        start=(place, zero, release),
        sticking=True,
    )
