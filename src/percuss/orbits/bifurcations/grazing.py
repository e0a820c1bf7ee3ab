"""The effect of a graze on the motions near it: the discontinuity mapping, and its consequences.

Derived in docs/theory/grazing.md, after Nordmark (1991), Chin, Ott, Nusse & Grebogi (1994) and
di Bernardo, Budd, Champneys & Kowalczyk (2008), chapters 6 to 8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.flight import acceleration_and_jerk, constant_force, place
from percuss.kernels.law_columns import N_HARMONICS, Law
from percuss.kernels.tangent import neighbours
from percuss.motion.accelerations import phases_at
from percuss.numerics import atan2, determinant, power, sin
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    acceleration_at,
    grazing_contacts,
    in_time_of,
    merged,
    without,
)
from percuss.orbits.bifurcations.parameter_ranges import own_value
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.over_period import fastest
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import multipliers_of
from percuss.wording import counted

# Accelerations below this part of those of the orbit decide nothing.
FLAT = 1e-4
# Step of the central difference of the depth by the parameter, as a part of its value.
STEP = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class GrazeAnalysis:
    """The effect of a graze, where an orbit touches a stop at zero velocity.

    The impact, or the time in a soft stop, acts on a nearby motion that would penetrate the stop by
    a depth d as a jump by ``coefficient * d**order`` at the instant of the graze.

    Attributes
    ----------
    stop
        Index of the stop.
    t
        Instant of the graze [time].
    acceleration
        Acceleration of the orbit there, away from the stop [length/time^2], > 0.
    order
        0.5 at a wall; 1.5 at a soft stop, with or without a dashpot.
    coefficient
        (2,) array, the jump of (x, v) over d**order.
    monodromy
        (2, 2) array, derivative of (x, v) one period after the graze by (x, v) at it, without its
        impact; over half a period, and mirrored, where a symmetric orbit grazes two stops.
    multipliers
        (2,) complex array, its eigenvalues.
    transfer
        Its entry of x by v: the displacement one period after a change of the velocity [time].
    depth_rate
        Derivative by the parameter of the depth by which the orbit without the impact penetrates
        the stop.
    impact_rate
        Derivative by the parameter of the impact velocity on the branch with the impact, where
        it starts; NaN at a soft stop, where it is infinite.
    impacting_side
        On which side of the parameter's value orbits of the same period meet the stop:
        "above" or "below".
    free_side
        On which side they do not.
    scenario
        "continuous", "jump" or "undecided": whether the attractor beyond grows from the orbit.
    statement
        The consequence in words.
    """

    stop: int
    t: float
    acceleration: float
    order: float
    coefficient: Floats = field(compare=False)
    monodromy: Floats = field(compare=False, repr=False)
    multipliers: Complexes = field(compare=False)
    transfer: float
    depth_rate: float
    impact_rate: float
    impacting_side: Literal["above", "below"]
    free_side: Literal["above", "below"]
    scenario: Scenario
    statement: str


def analysed_graze(orbit: PeriodicOrbit, path: str) -> GrazeAnalysis:
    """Return the effect of a graze on the motions near it.

    Parameters
    ----------
    orbit
        The orbit that grazes a stop.
    path
        Path of the parameter.

    Returns
    -------
    GrazeAnalysis
        From closed forms; only the depth's derivative by the parameter is a central difference.

    Raises
    ------
    ParameterError
        If the orbit grazes no stop, or several that do not mirror each other.
    ConvergenceError
        If there is no orbit without the impact.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    >>> grazing = pc.find_orbit(osc, pc.cosine(1.0, amplitude=0.1), 0)
    >>> graze = analysed_graze(grazing, "forcing.amplitude")
    >>> round(graze.acceleration, 9), graze.coefficient.round(9).tolist()
    (1.0, [0.0, -2.545584412])
    >>> graze.impacting_side, graze.free_side, graze.scenario
    ('below', 'below', 'jump')
    """
    contacts = grazing_contacts(orbit)
    if not contacts:
        raise ParameterError("orbit", orbit, "it grazes no stop")
    base = without(orbit, contacts)
    contacts = merged(in_time_of(base, orbit, contacts), base.period)
    contact = contacts[0]
    mirrored = len(contacts) == 2 and base.symmetric
    if len(contacts) > 1 and not mirrored:
        raise ParameterError(
            "orbit", orbit, f"it grazes stops {len(contacts)} times; an analysis is of one graze"
        )
    law = orbit.system.law
    acceleration = -contact.sign * acceleration_at(law, contact)
    monodromy = _around(law, base, contact, half=mirrored)
    rate = _depth_rate(base, path, contact)
    order, coefficient = _jump(law, contact, acceleration)
    fixed = determinant(np.eye(2) - monodromy)
    is_wall = order == 0.5
    impact_rate = math.nan
    deeper = rate > 0.0
    if is_wall:
        impact_rate = (
            rate * fixed / (-contact.sign * coefficient[1] / math.sqrt(2.0 * acceleration))
        )
        impact_rate = float(impact_rate / monodromy[0, 1])
    scenario, statement = consequence(monodromy, is_wall=is_wall)
    if mirrored:
        statement = statement.replace("period", "half period")
    if acceleration < FLAT * fastest(base) / base.period:
        scenario = "undecided"
        statement = "the graze has no acceleration away from the stop: a contact begins or ends"
    impacting = impact_rate > 0.0 if is_wall else deeper
    return GrazeAnalysis(
        stop=_stop(orbit, contact),
        t=contact.t,
        acceleration=acceleration,
        order=order,
        coefficient=coefficient,
        monodromy=monodromy,
        multipliers=multipliers_of(monodromy, determinant(monodromy)),
        transfer=float(monodromy[0, 1]),
        depth_rate=rate,
        impact_rate=impact_rate,
        impacting_side="above" if impacting else "below",
        free_side="below" if deeper else "above",
        scenario=scenario,
        statement=statement,
    )


def _stop(orbit: PeriodicOrbit, contact: GrazingContact) -> int:
    layout = orbit.system.lines
    wall, edges = layout.wall[contact.bound], layout.edges[contact.bound]
    return edges[0] if wall is None else wall


def _jump(law: Law, contact: GrazingContact, acceleration: float) -> tuple[float, Floats]:
    """Return order and coefficient of the discontinuity mapping at the instant of the graze."""
    row = law[contact.region]
    upper = contact.sign > 0.0
    if row[at.UPPER_KIND if upper else at.LOWER_KIND] == at.WALL:
        restitution = float(row[at.UPPER_RESTITUTION if upper else at.LOWER_RESTITUTION])
        jump = (1.0 + restitution) * math.sqrt(2.0 * acceleration)
        return 0.5, np.array([0.0, -contact.sign * jump])
    inside = law[contact.region + (1 if upper else -1) * (1 + int(law[0, N_HARMONICS]))]
    stiffness = float(inside[at.STIFFNESS] - row[at.STIFFNESS])
    damping = float(inside[at.DAMPING] - row[at.DAMPING])
    size = -contact.sign * (4.0 / 3.0) * math.sqrt(2.0 / acceleration)
    # The dashpot outside the stop acts on the delay that the stop causes.
    stiffness -= 4.0 * damping * float(row[at.DAMPING])
    return 1.5, size * np.array([2.0 * damping, stiffness])


def _around(law: Law, base: PeriodicOrbit, contact: GrazingContact, *, half: bool) -> Floats:
    """Return the derivative of (x, v) over a period from the graze; over a half, mirrored."""
    events, marks = base.record
    n = len(events) - 1
    t = base.t0 + (contact.t - base.t0) % base.period
    j = int(np.searchsorted(events[: n + 1, columns.EVENT_T], t, side="right")) - 1
    j = min(j, n - 1) if n else 0
    start = np.array([[t, 0.0, 0.0, 0.0]])
    begin = np.array([[columns.START, -1, marks[j, columns.NEXT_REGION]]], dtype=np.int64)
    next_period = events[1 : j + 1].copy()
    next_period[:, columns.EVENT_T] += base.period
    record = np.concatenate([start, events[j + 1 : n + 1], next_period])
    kinds = np.concatenate([begin, marks[j + 1 : n + 1], marks[1 : j + 1]])
    end = t + (0.5 * base.period if half else base.period)
    phases, out = np.empty((int(law[0, N_HARMONICS]), 2)), np.empty((1, 4))
    until = record[:, columns.EVENT_T] < end
    kept = columns.MotionRecord(law, 0.0, record[until], np.ascontiguousarray(kinds[until]))
    neighbours(kept, np.array([end]), True, phases, out)
    matrix = out.reshape(2, 2)
    return np.asarray(-matrix if half else matrix)


def _depth_rate(base: PeriodicOrbit, path: str, contact: GrazingContact) -> float:
    """Return the derivative by the parameter of the depth in the stop."""
    value = own_value(base, path)
    step = STEP * abs(value) or STEP
    family = BranchEquations(base, path, value - step, value + step)
    start = family.start(base, value)
    depths = []
    for part in (0.0, 1.0):
        guess = start.copy()
        guess[-1] = part
        try:
            z = family.corrected(guess, along_parameter(len(guess)))
            depths.append((part, _depth(family.solution(z), contact)))
        except PercussError:
            # At the edge of the parameter's domain: a difference from one side.
            depths.append((0.5, _depth(base, contact)))
    (one, below), (other, above) = depths
    if one == other:
        reason = f"no orbit without the graze near {path} = {value:.12g}"
        raise ConvergenceError(reason, None, math.nan, "look at another parameter")
    return (above - below) / ((other - one) * 2.0 * step)


def _depth(orbit: PeriodicOrbit, contact: GrazingContact) -> float:
    """Return the depth beyond the bound of the turning point nearest to a grazing contact."""
    law = orbit.system.law
    t = orbit.t0 + (contact.t - orbit.t0) % orbit.period
    run = orbit.trajectory(2)
    position = place(law, contact.region, contact.bound)
    force = constant_force(law, contact.region, position)
    # Newton's method for the zero of the velocity, which is near.
    for _ in range(8):
        x, v = run(t)
        y, phases = float(x) - position, phases_at(law, t)
        second, _ = acceleration_and_jerk(law, contact.region, force, phases, y, float(v))
        t -= float(v) / second
    return contact.sign * (float(run(t)[0]) - position)


Scenario: TypeAlias = Literal["continuous", "jump", "undecided"]

# Multipliers nearer than this are equal.
NEAR = 1e-9
# The values of the larger multiplier at which the scenario changes (docs/theory/grazing.md).
OVERLAP, CHAOS = 0.25, 2.0 / 3.0
# What is left of the effect of an impact when it turns towards the wall: it matters at depths below
# its square, as a part of those at which the graze matters.
FORGOTTEN = 1e-6


def consequence(monodromy: Floats, *, is_wall: bool) -> tuple[Scenario, str]:
    """Return the scenario of a graze, from the derivative over a period without its impact.

    Parameters
    ----------
    monodromy
        (2, 2) array.
    is_wall
        Whether the stop is a wall; at a soft one the derivative is continuous.

    Returns
    -------
    tuple of str
        The scenario, and a sentence.

    Examples
    --------
    >>> consequence(np.array([[0.5, 0.3], [0.0, 0.2]]), is_wall=True)[0]
    'continuous'
    >>> print(consequence(np.array([[0.5, -0.3], [0.0, 0.2]]), is_wall=True)[1])
    a jump: an impact moves the mass so that it comes back to the wall faster, again and again; \
the attractor beyond the graze is elsewhere
    """
    trace, area = float(np.trace(monodromy)), determinant(monodromy)
    discriminant = 0.25 * trace * trace - area
    if abs(trace) > 1.0 + area:
        return (
            "undecided",
            "the orbit is unstable without the graze; the consequences are not local",
        )
    if not is_wall:
        words = "continuous: the map's correction is of order 3/2 in the depth, the multipliers "
        words += "change with its square root from those without the graze, and the orbit persists"
        return "continuous", words
    transfer = float(monodromy[0, 1])
    if abs(transfer) < NEAR:
        words = "a velocity at the graze does not come back to the stop after a period: resonant"
        return "undecided", words
    if discriminant < -NEAR:
        return _of_complex(trace, area, transfer)
    larger = 0.5 * trace + np.sqrt(max(discriminant, 0.0)) * np.sign(trace)
    if larger <= 0.0 or transfer < 0.0:
        words = "a jump: an impact moves the mass so that it comes back to the wall faster, again "
        words += "and again; the attractor beyond the graze is elsewhere"
        return "jump", words
    return "continuous", _continuous(float(larger))


def _of_complex(trace: float, determinant: float, transfer: float) -> tuple[Scenario, str]:
    """Return the scenario where the multipliers of the orbit without the impact are complex."""
    size = math.sqrt(determinant)
    part = min(max(0.5 * trace / size, -1.0), 1.0)
    angle = atan2(math.sqrt((1.0 - part) * (1.0 + part)), part)
    # The periods until the effect of an impact is towards the wall, and what is left of it.
    periods = 1 if transfer < 0.0 else int(np.pi // angle) + 1
    left = abs(power(size, periods - 1.0) * sin(periods * angle) / sin(angle))
    if left < FORGOTTEN:
        words = _continuous(float(size))
        return "continuous", f"{words} (the multipliers are complex, with an angle of {angle:.2g})"
    words = f"a jump: the multipliers are complex, so that {counted(periods, 'period')} after an impact the "
    words += "mass comes back to the wall faster; the attractor beyond the graze is elsewhere"
    return "jump", words


def _continuous(larger: float) -> str:
    """Return the attractor that grows from a graze, by the larger of its real multipliers."""
    words = "continuous, with impact velocities below a multiple of the square root of the "
    words += f"distance to the graze; the larger multiplier {larger:.4g} "
    if larger > CHAOS:
        return words + "is above 2/3: chaos from the graze on, without windows"
    if larger > OVERLAP:
        words += "lies between 1/4 and 2/3: orbits with one impact in ever more periods towards "
        return words + "the graze, with chaos between their windows"
    words += "is below 1/4: orbits with one impact in ever more periods towards the graze, "
    return words + "whose windows overlap"
