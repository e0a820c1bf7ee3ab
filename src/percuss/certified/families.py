"""Orbits that are not alone: families by a closed form that holds exactly.

Let K > 0, no damping, and let a flight start and end at its region's equilibrium G/K, under
harmonics of odd multiples n >= 3 of sqrt(K). After pi/sqrt(K) what the forcing does alone has
turned its sign, and so has the rest: x - G/K has. The flight is back at its bound with its
velocity reversed, whatever its instant and velocity were, and an elastic impact or a crossing
leaves that speed. So all neighbours are periodic as well: the derivative is the identity
(Dyskin et al. 2012, section 4, for one harmonic). On one wall flights may also be shorter and
the motion still be one of a family: `reflections` has that closed form.
"""

from __future__ import annotations

import math
from fractions import Fraction

from flint import acb, arb

from percuss.certified.admissible import admissible_of
from percuss.certified.chain import Link, chain_of
from percuss.certified.multipliers import Monodromy
from percuss.certified.numbers import ball
from percuss.certified.proof import Proof
from percuss.certified.reflections import Rounds
from percuss.certified.shooting import Shooting, States
from percuss.certified.system import System
from percuss.certified.undecided import Undecided
from percuss.model.exact import as_fraction
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["family_orbit", "odd_root", "returns_reversed"]


def odd_root(ratio: Fraction) -> int | None:
    """Return the odd whole number whose square this is, None if it is none.

    Examples
    --------
    >>> odd_root(Fraction(9)), odd_root(Fraction(4)), odd_root(Fraction(2))
    (3, None, None)
    """
    if ratio.denominator != 1 or ratio < 1:
        return None
    root = math.isqrt(ratio.numerator)
    return root if root * root == ratio.numerator and root % 2 else None


def returns_reversed(system: System, region_number: int, bound: int) -> bool:
    """Tell whether all flights of a region from a bound to it reverse their velocity, exactly."""
    region = system.regions[region_number]
    k, a = system.stiffness(region), system.damping(region)
    if a != 0 or not k > 0:
        return False
    if not system.is_equilibrium(region, system.bounds[bound].at):
        return False
    roots = [odd_root(system.frequency(tone) ** 2 / k) for tone in system.tones]
    return all(root is not None and root >= 3 for root in roots)


def family_orbit(system: System, orbit: PeriodicOrbit) -> Proof:
    """Return the proof that an orbit, started exactly at its floats, is one of a family.

    Raises
    ------
    Undecided
        If the closed form above does not hold.
    """
    chain = chain_of(system, orbit)
    if _on_one_wall(system, chain) and not _fits(system, chain, orbit):
        return _round_orbit(system, orbit, chain)
    for link, following in zip(chain, [*chain[1:], chain[0]], strict=True):
        elastic = (
            not following.wall
            or system.numbers[f"oscillator.stops.{following.stop}.restitution"] == 1
        )
        if not (
            elastic
            and link.bound == following.bound
            and returns_reversed(system, link.after, link.bound)
        ):
            raise Undecided("precision", "no closed form is known for orbits that are not alone")
    if orbit.n_periods and not _fits(system, chain, orbit):
        raise Undecided("precision", "the flights do not add up to whole periods exactly")
    equations, states, before = _laid_out(system, chain, orbit)
    admissible, reason = admissible_of(equations, states)
    return _parabolic(chain, states, before, equations.period, admissible, reason)


def _on_one_wall(system: System, chain: list[Link]) -> bool:
    """Tell whether there is one elastic wall alone, from which flights may return reversed."""
    return (
        len(system.bounds) == 1
        and all(link.wall for link in chain)
        and system.numbers["oscillator.stops.0.restitution"] == 1
        and returns_reversed(system, 0, 0)
    )


def _round_orbit(system: System, orbit: PeriodicOrbit, chain: list[Link]) -> Proof:
    """Return the proof for an orbit with flights of less than half a natural period."""
    n = len(chain)
    t, v = (
        arb(float(orbit.itinerary.vector[0])),
        ball(as_fraction(float(orbit.itinerary.vector[1 + n]))),
    )
    rounds = Rounds(system, t, v)
    states: States = []
    before = [arb(0)] * n
    for i in range(n):
        states.append((rounds.t, rounds.v))
        before[(i + 1) % n] = rounds.fly()
    if not rounds.is_closed:
        raise Undecided("precision", "no closed form is known for orbits that are not alone")
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    k = system.stiffness(system.regions[0])
    if frequency is None or (rounds.turns * frequency) ** 2 != 4 * orbit.n_periods**2 * k:
        raise Undecided("precision", "the flights do not add up to whole periods exactly")
    return _parabolic(chain, states, before, rounds.turns * rounds.half, True, "")


def _parabolic(
    chain: list[Link],
    states: States,
    before: list[arb],
    period: arb,
    admissible: bool | None,
    reason: str,
) -> Proof:
    """Return the proof of an orbit all of whose neighbours are periodic as well."""
    one, zero = arb(1), arb(0)
    identity = (one, zero), (zero, one)
    return Proof(
        chain=chain,
        states=states,
        before=before,
        period=period,
        monodromy=Monodromy(
            identity,
            arb(2),
            one,
            conservative=True,
            multipliers=(acb(1), acb(1)),
            stability="parabolic",
        ),
        admissible=admissible,
        isolated=False,
        unique_within=0.0,
        reason=reason,
    )


def _fits(system: System, chain: list[Link], orbit: PeriodicOrbit) -> bool:
    """Tell whether the half periods add up to the forcing periods, exactly."""
    stiffnesses = {system.stiffness(system.regions[link.after]) for link in chain}
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    if frequency is None or len(stiffnesses) != 1:
        return False
    k = stiffnesses.pop()
    return len(chain) ** 2 * frequency**2 == 4 * orbit.n_periods**2 * k


def _laid_out(
    system: System, chain: list[Link], orbit: PeriodicOrbit
) -> tuple[Shooting, States, list[arb]]:
    """Return the events of the orbit that starts exactly at the floats of another."""
    n = len(chain)
    t, v = (
        arb(float(orbit.itinerary.vector[0])),
        ball(as_fraction(float(orbit.itinerary.vector[1 + n]))),
    )
    start = t
    states: States = []
    before = [arb(0)] * n
    for i, link in enumerate(chain):
        states.append((t, v))
        following = chain[(i + 1) % n]
        k = system.stiffness(system.regions[link.after])
        t = t + arb.pi() / ball(k).sqrt()
        before[(i + 1) % n] = -v
        v = following.kept(system) * -v
    return Shooting(system, chain, t - start), states, before
