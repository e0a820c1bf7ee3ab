"""What a graze does to the motions near it: the discontinuity mapping, and what follows from it.

Derived in docs/theory/grazing.md, after Nordmark (1991), Chin, Ott, Nusse & Grebogi (1994) and
di Bernardo, Budd, Champneys & Kowalczyk (2008), chapters 6 to 8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import acceleration_and_jerk, constant_force, set_phases
from percuss.kernels.law import N_HARMONICS, Law
from percuss.kernels.shooting import place
from percuss.kernels.tangent import neighbours
from percuss.model.exact import as_float
from percuss.model.law import law, lines
from percuss.model.paths import get_parameter
from percuss.numerics import determinant
from percuss.orbits.families.family import Family
from percuss.orbits.families.graze_statements import Scenario, consequence
from percuss.orbits.families.touches import (
    Touch,
    acceleration_at,
    fastest,
    merged,
    touches_of,
    without,
)
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import multipliers_of

__all__ = ["GrazeAnalysis", "analysed_graze"]

Floats = NDArray[np.float64]

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
    multipliers: NDArray[np.complex128] = field(compare=False)
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
    touches = touches_of(orbit)
    if not touches:
        raise ParameterError("orbit", orbit, "it touches no stop without velocity")
    base = without(orbit, touches)
    touches = merged(touches, base.period)
    touch = touches[0]
    mirrored = len(touches) == 2 and base.symmetric
    if len(touches) > 1 and not mirrored:
        raise ParameterError("orbit", orbit, f"it touches stops {len(touches)} times; one is told")
    table = law(orbit.oscillator, orbit.forcing)
    acceleration = -touch.way * acceleration_at(table, touch)
    monodromy = _around(table, base, touch, half=mirrored)
    rate = _depth_rate(base, path, touch)
    order, coefficient = _jump(table, touch, acceleration)
    fixed = determinant(np.eye(2) - monodromy)
    is_wall = order == 0.5
    impact_rate = math.nan
    beyond = rate > 0.0
    if is_wall:
        impact_rate = rate * fixed / (-touch.way * coefficient[1] / math.sqrt(2.0 * acceleration))
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


def _stop(orbit: PeriodicOrbit, touch: Touch) -> int:
    layout = lines(orbit.oscillator)
    wall, edges = layout.wall[touch.bound], layout.edges[touch.bound]
    return edges[0] if wall is None else wall


def _jump(table: Law, touch: Touch, acceleration: float) -> tuple[float, Floats]:
    """Return order and coefficient of the discontinuity mapping at the instant of the touch."""
    row = table[touch.region]
    upper = touch.way > 0.0
    if row[at.UPPER_KIND if upper else at.LOWER_KIND] == at.WALL:
        restitution = float(row[at.UPPER_RESTITUTION if upper else at.LOWER_RESTITUTION])
        jump = (1.0 + restitution) * math.sqrt(2.0 * acceleration)
        return 0.5, np.array([0.0, -touch.way * jump])
    beyond = table[touch.region + (1 if upper else -1) * (1 + int(table[0, N_HARMONICS]))]
    stiffness = float(beyond[at.STIFFNESS] - row[at.STIFFNESS])
    damping = float(beyond[at.DAMPING] - row[at.DAMPING])
    size = -touch.way * (4.0 / 3.0) * math.sqrt(2.0 / acceleration)
    # Outside, the dashpot there acts on what the mass is behind.
    stiffness -= 4.0 * damping * float(row[at.DAMPING])
    return 1.5, size * np.array([2.0 * damping, stiffness])


def _around(table: Law, base: PeriodicOrbit, touch: Touch, *, half: bool) -> Floats:
    """Return the derivative of (x, v) a period after the touch, or half of one and mirrored."""
    events, marks, n = base._events, base._marks, len(base._events) - 1
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
    kept = columns.Record(table, 0.0, record[until], np.ascontiguousarray(kinds[until]))
    neighbours(kept, np.array([t + lasting]), True, phases, out)
    matrix = out.reshape(2, 2)
    return np.asarray(-matrix if half else matrix)


def _depth_rate(base: PeriodicOrbit, path: str, touch: Touch) -> float:
    """Return the derivative by the parameter of how far the orbit passes the stop."""
    value = as_float(get_parameter(base.oscillator, base.forcing, None, path))
    step = BESIDE * abs(value) or BESIDE
    family = Family(base, path, value - step, value + step)
    start = family.start(base, value)
    held = np.append(np.zeros(len(start) - 1), 1.0)
    depths = []
    for part in (0.0, 1.0):
        guess = start.copy()
        guess[-1] = part
        try:
            depths.append((part, _depth(family.orbit(family.corrected(guess, held)), touch)))
        except PercussError:
            # On the edge of what the parameter can be: a difference from one side.
            depths.append((0.5, _depth(base, touch)))
    (one, below), (other, above) = depths
    if one == other:
        reason = f"no orbit without the touch beside {path} = {value:.12g}"
        raise ConvergenceError(reason, None, math.nan, "look at another parameter")
    return (above - below) / ((other - one) * 2.0 * step)


def _depth(orbit: PeriodicOrbit, touch: Touch) -> float:
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
    return touch.way * (float(run(t)[0]) - place(table, touch.region, touch.bound))
