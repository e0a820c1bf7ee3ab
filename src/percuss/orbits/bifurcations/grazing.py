"""What a graze does to the motions near it: the discontinuity mapping, and what follows from it.

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
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import acceleration_and_jerk, constant_force, place, set_phases
from percuss.kernels.law import N_HARMONICS, Law
from percuss.kernels.tangent import neighbours
from percuss.model.exact import as_float
from percuss.model.law import law, lines
from percuss.model.paths import get_parameter
from percuss.numerics import atan2, determinant, power, sin
from percuss.orbits.bifurcations.family import Family, fastest
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    acceleration_at,
    grazing_contacts,
    merged,
    without,
)
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import multipliers_of

__all__ = ["GrazeAnalysis", "Scenario", "analysed_graze", "consequence"]


# Accelerations below this part of those of the orbit decide nothing.
FLAT = 1e-4
# Step of the central difference of the depth by the parameter, as a part of its value.
BESIDE = 1e-5


@dataclass(frozen=True, slots=True)
class GrazeAnalysis:
    """What happens where an orbit touches a stop without velocity.

    A motion near it that would pass the stop by a depth d is moved by the impact, or by the time
    in a soft stop, as if it jumped at the instant of the touch by ``coefficient * d**order``.

    Attributes
    ----------
    stop
        Index of the stop.
    t
        Instant of the touch [time].
    acceleration
        That of the orbit there, away from the stop [length/time^2], > 0.
    order
        0.5 at a wall; 1.5 at a soft stop, with or without a dashpot.
    coefficient
        (2,) array, the jump of (x, v) over d**order.
    monodromy
        (2, 2) array, derivative of (x, v) one period after the touch by (x, v) at it, without the
        touch; over half a period, and mirrored, where a symmetric orbit touches two stops.
    multipliers
        (2,) complex array, its eigenvalues.
    transfer
        Its entry that says how far towards the stop a velocity towards it leads, one period
        later [time].
    depth_rate
        Derivative by the parameter of how far the orbit without the touch passes the stop.
    impact_rate
        Derivative by the parameter of the impact velocity on the branch with the impact, where
        it starts; NaN at a soft stop, where that goes with the square root.
    impacting_side
        On which side of the parameter's value orbits of the same period meet the stop:
        "above" or "below".
    free_side
        On which side they do not.
    scenario
        "continuous", "jump" or "undecided": whether what attracts beyond grows from nothing.
    statement
        What follows, in words.
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
    """Return what a graze implies for the motions beside it.

    Parameters
    ----------
    orbit
        The orbit that touches a stop without velocity.
    path
        Path of the parameter that is changed.

    Returns
    -------
    GrazeAnalysis
        From closed forms; only the depth's derivative by the parameter is a central difference.

    Raises
    ------
    ParameterError
        If the orbit touches no stop, or several that do not mirror each other.
    ConvergenceError
        If there is no orbit without the touch.

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
        raise ParameterError("orbit", orbit, "it touches no stop without velocity")
    base = without(orbit, contacts)
    contacts = merged(contacts, base.period)
    touch = contacts[0]
    mirrored = len(contacts) == 2 and base.symmetric
    if len(contacts) > 1 and not mirrored:
        raise ParameterError("orbit", orbit, f"it touches stops {len(contacts)} times; one is told")
    table = law(orbit.oscillator, orbit.forcing)
    acceleration = -touch.sign * acceleration_at(table, touch)
    monodromy = _around(table, base, touch, half=mirrored)
    rate = _depth_rate(base, path, touch)
    order, coefficient = _jump(table, touch, acceleration)
    fixed = determinant(np.eye(2) - monodromy)
    is_wall = order == 0.5
    impact_rate = math.nan
    beyond = rate > 0.0
    if is_wall:
        impact_rate = rate * fixed / (-touch.sign * coefficient[1] / math.sqrt(2.0 * acceleration))
        impact_rate = float(impact_rate / monodromy[0, 1])
    scenario, statement = consequence(monodromy, is_wall=is_wall)
    if mirrored:
        statement = statement.replace("period", "half period")
    if acceleration < FLAT * fastest(base) / base.period:
        scenario = "undecided"
        statement = "the touch has no acceleration away from the stop: its contact begins or ends"
    impacting = impact_rate > 0.0 if is_wall else beyond
    return GrazeAnalysis(
        stop=_stop(orbit, touch),
        t=touch.t,
        acceleration=acceleration,
        order=order,
        coefficient=coefficient,
        monodromy=monodromy,
        multipliers=multipliers_of(monodromy, determinant(monodromy)),
        transfer=float(monodromy[0, 1]),
        depth_rate=rate,
        impact_rate=impact_rate,
        impacting_side="above" if impacting else "below",
        free_side="below" if beyond else "above",
        scenario=scenario,
        statement=statement,
    )


def _stop(orbit: PeriodicOrbit, touch: GrazingContact) -> int:
    layout = lines(orbit.oscillator)
    wall, edges = layout.wall[touch.bound], layout.edges[touch.bound]
    return edges[0] if wall is None else wall


def _jump(table: Law, touch: GrazingContact, acceleration: float) -> tuple[float, Floats]:
    """Return order and coefficient of the discontinuity mapping at the instant of the touch."""
    row = table[touch.region]
    upper = touch.sign > 0.0
    if row[at.UPPER_KIND if upper else at.LOWER_KIND] == at.WALL:
        restitution = float(row[at.UPPER_RESTITUTION if upper else at.LOWER_RESTITUTION])
        jump = (1.0 + restitution) * math.sqrt(2.0 * acceleration)
        return 0.5, np.array([0.0, -touch.sign * jump])
    beyond = table[touch.region + (1 if upper else -1) * (1 + int(table[0, N_HARMONICS]))]
    stiffness = float(beyond[at.STIFFNESS] - row[at.STIFFNESS])
    damping = float(beyond[at.DAMPING] - row[at.DAMPING])
    size = -touch.sign * (4.0 / 3.0) * math.sqrt(2.0 / acceleration)
    # Outside, the dashpot there acts on what the mass is behind.
    stiffness -= 4.0 * damping * float(row[at.DAMPING])
    return 1.5, size * np.array([2.0 * damping, stiffness])


def _around(table: Law, base: PeriodicOrbit, touch: GrazingContact, *, half: bool) -> Floats:
    """Return the derivative of (x, v) a period after the touch, or half of one and mirrored."""
    events, marks = base.record
    n = len(events) - 1
    t = base.t0 + (touch.t - base.t0) % base.period
    j = int(np.searchsorted(events[: n + 1, columns.EVENT_T], t, side="right")) - 1
    j = min(j, n - 1) if n else 0
    start = np.array([[t, 0.0, 0.0, 0.0]])
    begin = np.array([[columns.START, -1, marks[j, columns.NEXT_REGION]]], dtype=np.int64)
    again = events[1 : j + 1].copy()
    again[:, columns.EVENT_T] += base.period
    record = np.concatenate([start, events[j + 1 : n + 1], again])
    kinds = np.concatenate([begin, marks[j + 1 : n + 1], marks[1 : j + 1]])
    lasting = 0.5 * base.period if half else base.period
    phases, out = np.empty((int(table[0, N_HARMONICS]), 2)), np.empty((1, 4))
    until = record[:, columns.EVENT_T] < t + lasting
    kept = columns.MotionRecord(table, 0.0, record[until], np.ascontiguousarray(kinds[until]))
    neighbours(kept, np.array([t + lasting]), True, phases, out)
    matrix = out.reshape(2, 2)
    return np.asarray(-matrix if half else matrix)


def _depth_rate(base: PeriodicOrbit, path: str, touch: GrazingContact) -> float:
    """Return the derivative by the parameter of how far the orbit passes the stop."""
    value = as_float(get_parameter(base.oscillator, base.forcing, None, path))
    step = BESIDE * abs(value) or BESIDE
    family = Family(base, path, value - step, value + step)
    start = family.start(base, value)
    depths = []
    for part in (0.0, 1.0):
        guess = start.copy()
        guess[-1] = part
        try:
            z = family.corrected(guess, along_parameter(len(guess)))
            depths.append((part, _depth(family.solution(z), touch)))
        except PercussError:
            # On the edge of what the parameter can be: a difference from one side.
            depths.append((0.5, _depth(base, touch)))
    (one, below), (other, above) = depths
    if one == other:
        reason = f"no orbit without the touch beside {path} = {value:.12g}"
        raise ConvergenceError(reason, None, math.nan, "look at another parameter")
    return (above - below) / ((other - one) * 2.0 * step)


def _depth(orbit: PeriodicOrbit, touch: GrazingContact) -> float:
    """Return how far an orbit passes the bound at its turning point nearest to a touch."""
    table = law(orbit.oscillator, orbit.forcing)
    t = orbit.t0 + (touch.t - orbit.t0) % orbit.period
    run = orbit.trajectory(2)
    # Newton's method for the velocity's zero: the touch is near.
    for _ in range(8):
        x, v = run(t)
        phases = np.empty((int(table[0, N_HARMONICS]), 2))
        set_phases(table, t, 0.0, phases)
        position = place(table, touch.region, touch.bound)
        force = constant_force(table, touch.region, position)
        second, _ = acceleration_and_jerk(
            table, touch.region, force, phases, float(x) - position, float(v)
        )
        t -= float(v) / second
    return touch.sign * (float(run(t)[0]) - place(table, touch.region, touch.bound))


Scenario: TypeAlias = Literal["continuous", "jump", "undecided"]

# Multipliers as near as this are not told apart.
NEAR = 1e-9
# Between these values of the larger multiplier what follows a graze changes (docs/theory/grazing.md).
OVERLAP, CHAOS = 0.25, 2.0 / 3.0
# Of an impact's effect, when it turns towards the wall: depths at which that is felt are smaller
# than this squared, as a part of those at which the graze is felt at all.
FORGOTTEN = 1e-6


def consequence(monodromy: Floats, *, is_wall: bool) -> tuple[Scenario, str]:
    """Return what follows a graze, from the derivative of (x, v) around it without the touch.

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
what attracts beyond the graze is elsewhere
    """
    trace, area = float(np.trace(monodromy)), determinant(monodromy)
    discriminant = 0.25 * trace * trace - area
    if abs(trace) > 1.0 + area:
        return "undecided", "the orbit is unstable without the touch; what follows is not local"
    if not is_wall:
        words = "continuous: the map's correction is of order 3/2 in the depth, the multipliers "
        words += "change with its square root from those without the touch, and the orbit lives on"
        return "continuous", words
    transfer = float(monodromy[0, 1])
    if abs(transfer) < NEAR:
        words = "a velocity at the touch does not come back to the stop after a period: resonant"
        return "undecided", words
    if discriminant < -NEAR:
        return _of_complex(trace, area, transfer)
    larger = 0.5 * trace + np.sqrt(max(discriminant, 0.0)) * np.sign(trace)
    if larger <= 0.0 or transfer < 0.0:
        words = "a jump: an impact moves the mass so that it comes back to the wall faster, again "
        words += "and again; what attracts beyond the graze is elsewhere"
        return "jump", words
    return "continuous", _continuous(float(larger))


def _of_complex(trace: float, determinant: float, transfer: float) -> tuple[Scenario, str]:
    """Return what follows where neighbours turn round the orbit without the touch."""
    size = math.sqrt(determinant)
    part = min(max(0.5 * trace / size, -1.0), 1.0)
    angle = atan2(math.sqrt((1.0 - part) * (1.0 + part)), part)
    # How many periods after an impact its effect first is towards the wall, and how much is left.
    periods = 1 if transfer < 0.0 else int(np.pi // angle) + 1
    left = abs(power(size, periods - 1.0) * sin(periods * angle) / sin(angle))
    if left < FORGOTTEN:
        words = _continuous(float(size))
        return "continuous", f"{words} (the multipliers are complex, with an angle of {angle:.2g})"
    words = f"a jump: the multipliers are complex, so that {counted(periods)} after an impact the "
    words += "mass comes back to the wall faster; what attracts beyond the graze is elsewhere"
    return "jump", words


def counted(periods: int) -> str:
    """Return a number of periods in words."""
    return "one period" if periods == 1 else f"{periods} periods"


def _continuous(larger: float) -> str:
    """Return what grows from a graze with real positive multipliers, by the larger one."""
    words = "continuous, with impact velocities below a multiple of the square root of the "
    words += f"distance to the graze; the larger multiplier {larger:.4g} "
    if larger > CHAOS:
        return words + "is above 2/3: chaos from the graze on, without windows"
    if larger > OVERLAP:
        words += "lies between 1/4 and 2/3: orbits with one impact in ever more periods towards "
        return words + "the graze, with chaos between their windows"
    words += "is below 1/4: orbits with one impact in ever more periods towards the graze, "
    return words + "whose windows overlap"
