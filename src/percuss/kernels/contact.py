"""What a wall does: chatter summed to its end, contact, and its release."""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.doubled import later
from percuss.kernels.flight import force_and_slopes, force_derivative, set_phases
from percuss.kernels.law import DAMPING, FORCE_BOUND, LOWER, PERIOD, QUICKEST, UPPER, Law, Table

ULP = 2.220446049250313e-16
# Hops are listed until the rest of the chatter lasts this part of the time in which the force
# and the oscillator change, which makes its sum good to 1e-10 of itself ...
CHATTER_LIMIT = 1e-5
# ... and until they are slower than this part of the fastest impact of the run so far.
SLOW = 1e-6
# Force below which its sign is rounding, relative to the sum of its terms.
FORCE_ROUNDING = 8 * ULP
# The force's derivatives that are looked at before it counts as zero for ever.
LAST_ORDER = 11
# Steps towards a release before the search hands back.
RELEASE_STEPS = 4096


@kernel
def push(law: Law, force: float, phases: Table) -> float:
    """Return the first derivative of x that is not zero, at rest at the place of ``force``.

    Its sign is the direction in which the mass sets off; 0 if nothing ever moves it. The force's
    derivatives decide, for x^(m + 2) = f^(m) as long as all before it vanish.
    """
    for order in range(LAST_ORDER):
        value = force_derivative(law, phases, order)
        if order == 0:
            value += force
        if value != 0.0:
            return value
    return 0.0


@kernel
def chatter_time(
    law: Law,
    region: int,
    side: float,
    restitution: float,
    speed: float,
    fastest: float,
    force: float,
    phases: Table,
) -> tuple[float, float]:
    """Return (time left to the accumulation, error bound) of a chatter, (-1, 0) if it is none.

    With p the force towards the wall, q = speed / p and e = -(p' / p + a), hops last
    2 q (1 + 2 e q / 3) and send q to r q (1 + 4 e q / 3), to second order; the sum is

        T = tau (1 + e tau / 3),   tau = 2 q / (1 - r).

    It holds if over 2 tau the force keeps its sign, which its derivatives' bounds prove, and the
    first hop meets nothing else (docs/theory/chatter.md). ``side`` is -1 at a wall below and +1
    at one above.
    """
    if restitution >= 1.0 or speed > SLOW * fastest:
        return -1.0, 0.0
    harmonic, slope, _ = force_and_slopes(law, phases)
    pressing = side * (force + harmonic)
    if pressing <= 0.0:
        return -1.0, 0.0
    tau = 2.0 * speed / (pressing * (1.0 - restitution))
    change = side * slope / pressing
    pace = max(abs(change), math.sqrt(law[0, FORCE_BOUND + 2] / pressing))
    pace = max(pace, law[region, QUICKEST])
    room = law[region, UPPER] - law[region, LOWER]
    if tau * pace > CHATTER_LIMIT or speed * speed > pressing * room:
        return -1.0, 0.0
    tilt = -(change + law[region, DAMPING])
    error = tau * (tau * pace) ** 2 + 4.0 * ULP * tau
    # The force is a difference of terms that may be far larger.
    error += FORCE_ROUNDING * (abs(force) + law[0, FORCE_BOUND]) / pressing * tau
    return tau * (1.0 + tilt * tau / 3.0), error


@kernel
def release_time(
    law: Law,
    sign: float,
    force: float,
    instant: tuple[float, float],
    begin: float,
    longest: float,
    phases: Table,
) -> tuple[bool, float]:
    """Return (True, time) of a contact's release, or (False, time up to which there is none).

    The contact began at ``instant`` and is known to last up to ``begin``. Each step stays where
    the force towards the wall is positive by the bound of its second derivative. It releases
    where it changes sign, not where it touches zero. ``phases`` is scratch; ``sign`` is +1 for a
    wall below and -1 for one above.
    """
    bend = law[0, FORCE_BOUND + 2]
    tolerance = FORCE_ROUNDING * (abs(force) + law[0, FORCE_BOUND])
    if sign * force + law[0, FORCE_BOUND] <= tolerance:
        return False, math.inf
    s = begin
    for _ in range(RELEASE_STEPS):
        if s > longest:
            break
        if law[0, PERIOD] > 0.0 and s > 1.01 * law[0, PERIOD]:
            return False, math.inf
        t, t_low = later(instant[0], instant[1], s)
        set_phases(law, t, t_low, phases)
        harmonic, slope, curve = force_and_slopes(law, phases)
        pressing = -sign * (force + harmonic)
        slope = -sign * slope
        curve = -sign * curve
        # Where the force falls by more than the tolerance in one ulp of s, that ulp decides.
        if pressing > tolerance + abs(slope) * ULP * s:
            # Divided first: the squares of small forces would underflow.
            back = slope / bend
            s += back + math.sqrt(back * back + 2.0 * (pressing / bend))
            continue
        if slope < 0.0 and (curve <= 0.0 or pressing - 0.5 * slope * slope / curve < -tolerance):
            s = max(begin, s - pressing / slope)
            return True, s
        if pressing < -tolerance:
            return True, s
        # It touches zero, or leaves it upwards: on to where it is seen to be positive again.
        s += 2.0 * max(0.0, -slope) / bend + math.sqrt(8.0 * (tolerance / bend))
    return False, s
