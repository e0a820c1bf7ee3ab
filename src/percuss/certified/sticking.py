"""Orbits with sticking: a contact that returns after whole periods.

In contact the mass is at the wall without velocity, and the forcing is periodic: a motion in
contact at an instant and again a whole number of periods later is periodic from there on,
exactly. All neighbours that reach the same contact follow the same motion after its release, so
both multipliers are zero.
"""

from __future__ import annotations

from fractions import Fraction

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.contact import Hold
from percuss.certified.march import Ending, MarchLimits, MarchRecord, march
from percuss.certified.numbers import ball
from percuss.certified.properties import Monodromy, Proof
from percuss.certified.shooting import OrbitEvent
from percuss.certified.system import BallSystem
from percuss.model.exact import pi_times
from percuss.model.start import Start
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["sticking_proof"]


def sticking_proof(system: BallSystem, orbit: PeriodicOrbit, digits: int) -> Proof:
    """Return the proof of an orbit with sticking.

    Raises
    ------
    Undecided
        If the motion from the middle of a contact is not proven to come back to it.
    """
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    if frequency is None or not law_of(system).has_exact_frequencies:
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
    after = pi_times(Fraction(2 * orbit.n_periods) / frequency) + middle
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
    return _proof(system, orbit, record, frequency)


def _proof(
    system: BallSystem, orbit: PeriodicOrbit, record: MarchRecord, frequency: Fraction
) -> Proof:
    zero = arb(0)
    bounds = {bound.wall: i for i, bound in enumerate(system.bounds)}
    events = [OrbitEvent(bounds[row.stop], 0, 0, row.stop, wall=True) for row in record.impacts]
    monodromy = Monodromy.of(((zero, zero), (zero, zero)), zero, conservative=False)
    release = record.contacts[0].release
    assert release is not None
    place = ball(system.bounds[bounds[record.contacts[0].stop]].at)
    period = 2 * orbit.n_periods * arb.pi() / ball(frequency)
    return Proof(
        events=events,
        states=[(row.t, row.v_after) for row in record.impacts],
        before=[row.v_before for row in record.impacts],
        period=period,
        monodromy=monodromy,
        admissible=True,
        start=(place, zero, release),
        sticking=True,
    )
