"""Orbits with one impact, in closed form: one harmonic, a wall.

A flight from the wall and back to it after n forcing periods obeys, with U the velocity before
the impact, -r U that after it, and (p, q) the force's part in phase and in quadrature at the
impact, p^2 + q^2 = A^2,

    0 = -r U S + g D + p Re Q + q Im Q,
    U = -r U (c - a S) + g S + p (S - w Im Q) + q w Re Q,

at s = 2 pi n/w (notation of `percuss.kernels.flight`). That is linear in p, q and U: solved
for p and q it leaves one quadratic equation for U, whose roots are the two orbits (Shaw & Holmes
1983; Whiston 1987; Budd & Dux 1994).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels.flight import constant_force, free_response, harmonic_response, place
from percuss.kernels.law_columns import Law
from percuss.kernels.shooting import factor
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.restitution import RestitutionTable
from percuss.model.system import System
from percuss.numerics import atan2, directions, dot, matmul, solve_linear
from percuss.orbits.orbit.itinerary import Itinerary, entry, events_of_stops, row_of_region
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import Solution, orbit_of_solution, solve

# Below this part of the larger one, a singular value of the two equations is rounding.
SINGULAR = 1e-12
# Entries of the equations below this part of their terms are rounding: omega is a float.
ROUNDING = 1e-14


@dataclass(frozen=True, slots=True, eq=False)
class SingleImpact:
    """All motions with one impact on a wall in n forcing periods, as roots of a quadratic.

    The velocity U before the impact obeys ``c2 U^2 + c1 U + c0 = 0``; `roots` are (cycle of the
    impact, U), the greater ``way U`` first. Roots with ``way U <= 0`` are formal: they would
    come out of the wall.

    Attributes
    ----------
    stop
        Index of the wall.
    n_periods
        Forcing periods between impacts.
    way
        Sign of a velocity into the wall.
    coefficients
        (3,) array, c2, c1, c0; NaN where the oscillator returns after n periods whatever the
        phase, so that the velocity follows from the momentum alone.
    discriminant
        c1^2 - 4 c2 c0: there are two roots, one (a fold) or none.
    roots
        (k, 2) array, k = 0, 1 or 2.
    """

    stop: int
    n_periods: int
    way: float
    coefficients: Floats
    discriminant: float
    roots: Floats


def has_closed_form(system: System, stop: int) -> bool:
    """Return whether `single_impact` has a formula for impacts on a stop."""
    osc, force = system
    if force is None or force.record is not None or len(force.components()) != 1:
        return False
    wall = osc.stops[stop]
    return isinstance(wall, Wall) and not isinstance(wall.restitution, RestitutionTable)


def single_impact(
    osc: Oscillator, force: Forcing, n_periods: int = 1, stop: int = 0
) -> SingleImpact:
    """Return the motions with one impact on a wall in n forcing periods, admissible or not.

    Parameters
    ----------
    osc
        The oscillator. Its other stops are disregarded.
    force
        One harmonic, and a constant.
    n_periods
        Forcing periods between impacts, >= 1.
    stop
        Index of the wall.

    Returns
    -------
    SingleImpact
        The quadratic equation and its roots.

    Raises
    ------
    ParameterError
        If the stop is no wall, or the forcing not one harmonic.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    >>> single_impact(osc, pc.cosine(1.0)).roots.round(6)
    array([[ 0.012088,  1.695733],
           [ 0.480213, -1.68751 ]])
    """
    system, sign = System(osc, force), entry(osc, stop).sign
    if not has_closed_form(system, stop):
        raise ParameterError("stop", stop, "no wall, or the forcing is not one harmonic")
    amplitude = float(system.law[at.FIRST_HARMONIC, at.AMPLITUDE])
    equations = equations_of(system, n_periods, stop)
    points, coefficients, discriminant = _on_circle(*equations, amplitude)
    roots = [(cycle_of(system.law, p, q), u) for p, q, u in points]
    roots.sort(key=lambda root: -sign * root[1])
    table = np.array(roots).reshape(-1, 2)
    return SingleImpact(stop, n_periods, sign, coefficients, discriminant, table)


def equations_of(system: System, n_periods: int, stop: int) -> tuple[Floats, Floats, Floats]:
    """Return M, b and d of the equations M (p, q) = b + d U."""
    law, met = system.law, entry(system.oscillator, stop)
    bound, region = met.bound, row_of_region(law, met.before)
    kept = factor(law, region, bound, 0.0)
    period = n_periods * float(law[0, at.PERIOD])
    impulse, even, rise = free_response(law, region, period)
    # After whole periods the force is what it was, exactly.
    to_cos, to_sin = harmonic_response(law, region, 0, period, impulse, even, (1.0, 0.0))
    omega = law[at.FIRST_HARMONIC, at.OMEGA]
    force = constant_force(law, region, place(law, region, bound))
    drag = law[region, at.DAMPING] * impulse
    matrix = np.array([[to_cos, to_sin], [impulse - omega * to_sin, omega * to_cos]])
    # Where the free motion returns by itself the force leaves nothing but rounding.
    response = law[region + 1]
    gain = math.hypot(response[at.GAIN_RE], response[at.GAIN_IM])
    most = 0.5 * period * period if gain == 0.0 else min(0.5 * period * period, 2.0 * gain)
    matrix[np.abs(matrix) < ROUNDING * most * np.array([[1.0], [omega]])] = 0.0
    of_one = np.array([-force * rise, -force * impulse])
    of_velocity = np.array([-kept * impulse, 1.0 - kept * (even - drag)])
    return matrix, of_one, of_velocity


Points = list[tuple[float, float, float]]


def _on_circle(
    matrix: Floats, of_one: Floats, of_velocity: Floats, amplitude: float
) -> tuple[Points, Floats, float]:
    """Return all (p, q, U) with M (p, q) = b + d U on the circle, and the quadratic for U."""
    sizes, right = directions(matrix)
    unknown = np.full(3, np.nan)
    if sizes[0] == 0.0:
        return [], unknown, -math.inf
    if sizes[1] > SINGULAR * sizes[0]:
        one, slope = solve_linear(matrix, of_one), solve_linear(matrix, of_velocity)
        c2, c1 = dot(slope, slope), 2.0 * dot(one, slope)
        c0 = dot(one, one) - amplitude * amplitude
        points = [(*(one + slope * u), u) for u in _real_roots(c2, c1, c0)]
        return points, np.array([c2, c1, c0]), float(c1 * c1 - 4.0 * c2 * c0)
    # In the direction out of the range of M the equations give U; one coordinate of (p, q) is free.
    onto = matmul(matrix, right[0]) / sizes[0]
    across = np.array([-onto[1], onto[0]])
    of_u = dot(across, of_velocity)
    if of_u == 0.0:
        return [], unknown, -math.inf
    u = -dot(across, of_one) / of_u
    fixed = dot(onto, of_one + of_velocity * u) / float(sizes[0])
    free = amplitude * amplitude - fixed * fixed
    others = _real_roots(1.0, 0.0, -free)
    points = [(*(fixed * right[0] + other * right[1]), u) for other in others]
    return points, unknown, 4.0 * free


def _real_roots(c2: float, c1: float, c0: float) -> list[float]:
    """Return the real roots of a quadratic with c2 > 0, without cancellation."""
    below = c1 * c1 - 4.0 * c2 * c0
    if below < 0.0:
        return []
    q = -0.5 * (c1 + math.copysign(math.sqrt(below), c1))
    if q == 0.0:
        return [0.0]
    first, second = q / c2, c0 / q
    return [first] if first == second else [first, second]


def cycle_of(law: Law, p: float, q: float) -> float:
    """Return the cycle at which the force's part in phase is p and in quadrature q."""
    row = law[at.FIRST_HARMONIC]
    # p + i q = (C + i S) exp(-i w t).
    angle = atan2(float(row[at.SINE]), float(row[at.COSINE])) - atan2(float(q), float(p))
    cycle = (angle / (2.0 * math.pi)) % 1.0
    return cycle if cycle < 1.0 else 0.0


def single_impact_orbits(
    osc: Oscillator, force: Forcing, n_periods: int = 1, stop: int = 0
) -> list[PeriodicOrbit]:
    """Return the orbits with one impact on a wall in n forcing periods, from the closed form.

    Parameters
    ----------
    osc, force, n_periods, stop
        As for `single_impact`.

    Returns
    -------
    list of PeriodicOrbit
        At most two, the faster first, formal ones too; none for a root of no velocity.

    Raises
    ------
    ParameterError
        As for `single_impact`.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.7, wall="1.45789", side="above", damping=0.05)
    >>> for orbit in single_impact_orbits(osc, pc.cosine("1.5")):
    ...     print(orbit.stability, orbit.min_impact_speed.__round__(9))
    asymptotic 3.715736428
    unstable 1.49258925
    """
    form = single_impact(osc, force, n_periods, stop)
    system = System(osc, force)
    orbits = (orbit_of_root(system, form, cycle, u) for cycle, u in form.roots.tolist())
    return [orbit for orbit in orbits if orbit is not None]


def orbit_of_root(
    system: System, form: SingleImpact, cycle: float, u: float
) -> PeriodicOrbit | None:
    """Return the orbit of a root, polished by Newton's method; None for one of zero velocity.

    That one grazes the wall: it is an orbit without impacts.
    """
    if u == 0.0:
        return None
    law, events = system.law, events_of_stops(system, (form.stop,))
    period = float(law[0, at.PERIOD])
    bound, before, _ = events[0].tolist()
    unknowns = np.array(
        [cycle * period, form.n_periods * period, factor(law, before, bound, u) * u]
    )
    guess = Itinerary.of_vector(events, unknowns, form.n_periods)
    solution = solve(system, guess)
    if not solution.converged:
        # The closed form is a solution: Newton's method only polishes it.
        solution = Solution(guess, solution.residual, converged=True, isolated=True)
    return orbit_of_solution(system, solution)
