"""Both Lyapunov exponents of a motion, from exact propagators and saltation matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from percuss.arrays import Floats
from percuss.ensembles.batch import (
    BLOCKS,
    MOST_IMPACTS,
    BatchResult,
    Plan,
    drift_of,
    exponents_of,
    follow_batch,
    reason_of,
    tangent_plan,
)
from percuss.ensembles.grid import Group, make_grid, whole
from percuss.ensembles.repetition import period_of
from percuss.errors import ParameterError
from percuss.kernels import observables
from percuss.kernels import record as columns
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import Phase, as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.numerics import cos, dot, exp, expm1, log, sin

__all__ = ["LyapunovExponents", "lyapunov_exponents"]


# The longest period of an orbit that is considered, in forcing periods.
LONGEST = 16
# Periods of an orbit from which its exponents are taken, and the relative difference up to which
# areas shrink alike in them.
ORBIT_PERIODS, ALIKE = 3, 1e-6
# Impacts of a motion for each period; the default limit.
IMPACTS_OF_A_PERIOD = 100


@dataclass(frozen=True, slots=True)
class LyapunovExponents:
    """The exponents of a motion.

    Attributes
    ----------
    exponents
        (2,) array, the larger first [1/time]; both -inf where a contact has ended all memory.
    errors
        (2,) array, their errors [1/time]: the standard error from the means of blocks, and with it
        the difference between the two halves where this is more than chance. On a periodic orbit,
        whose multipliers give the exponents, the difference of two of its periods, times those that
        it still takes to die out.
    total
        Their sum by the sum rule [1/time]: -2 times the time-mean of the damping in force, and 2
        for each wall times its rate of impacts times ln r, over ``duration``.
    impact_rate
        Impacts, and entries into soft stops, in a unit of time.
    duration
        Time over which impacts and exponents were taken [time]; on a periodic orbit three of
        its periods.
    """

    exponents: Floats
    errors: Floats
    total: float
    impact_rate: float
    duration: float


def lyapunov_exponents(
    osc: Oscillator,
    force: Forcing | None,
    *,
    start: Start | Sequence[Phase] | None = None,
    transient: int = 1000,
    periods: int = 20_000,
    max_impacts: int | None = None,
) -> LyapunovExponents:
    """Return both exponents of the motion from a start.

    A perturbation is carried along each flight by the exact propagator and over each event by its
    saltation matrix, at the edges of soft stops as at impacts. Two perturbations span an area whose
    factor is known in closed form: it gives the sum of the exponents.

    Parameters
    ----------
    osc, force
        The oscillator and its forcing. Where the forcing has no period, a period below is
        2 pi / sqrt(stiffness), or without stiffness that of the slowest harmonic.
    start
        Where it starts: a `Start`, or x0 [length] and v0 [length/time]; default: at rest at 0.
    transient, periods
        Forcing periods that are left out, and that the exponents are taken over, >= 64.
    max_impacts
        Impacts after which the motion is abandoned, >= 1; default: a hundred for each period, and
        at least a million.

    Returns
    -------
    LyapunovExponents
        The exponents, their errors, and their sum by the sum rule.

    Raises
    ------
    ParameterError
        If there is neither a stiffness nor a harmonic, in whose period time could be counted; the
        start lies inside a wall; there are more impacts; or the motion does not come to its end.

    Examples
    --------
    A stable orbit with one impact a period: both are (omega / 2 pi) ln r.

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(restitution=0.8)
    >>> rates = pc.lyapunov_exponents(osc, pc.cosine(2.5), start=(0.0, 1.0))
    >>> rates.exponents.round(5)
    array([-0.08879, -0.08879])
    """
    transient, periods = whole("transient", transient, 0), whole("periods", periods, BLOCKS)
    most = max(MOST_IMPACTS, IMPACTS_OF_A_PERIOD * (transient + periods))
    if max_impacts is not None:
        most = whole("max_impacts", max_impacts, 1)
    grid = make_grid(osc, force, start, {})
    groups, faults = grid.groups(0, 1)
    if faults:
        raise ParameterError("start", grid.start, faults[0])
    (group,) = groups
    assert isinstance(group, Group)
    period = np.array([_period_of_time(osc, force)])
    plan = tangent_plan(period, group.starts[:, 2], transient, periods)
    plan = replace(plan, max_impacts=most)
    result = follow_batch(group.laws, group.which, group.starts, plan)
    reason = reason_of(int(result.status[0]), plan)
    if reason is not None:
        if result.status[0] == columns.REACHED_LIMIT:
            t = float(result.state[0, columns.T])
            reason = f"as many impacts come until t = {t:.6g}, the end is at {plan.until[0]:.6g}"
            raise ParameterError("max_impacts", most, f"{reason}; allow more, or fewer periods")
        raise ParameterError("start", grid.start, reason)
    is_periodic = force is not None and force.period is not None
    if is_periodic and np.isfinite(result.points[0, -1, observables.FIRST]):
        known = _of_orbit(group.laws, result, plan, transient + periods)
        if known is not None:
            return known
    duration = float(plan.until[0] - plan.since[0])
    largest, smallest, error, total = (value[0] for value in exponents_of(result, plan))
    error = math.hypot(error, drift_of(result, plan)[0])
    return LyapunovExponents(
        np.array([largest, smallest]),
        np.array([error, error]),
        float(total),
        float(result.values[0, observables.IMPACTS]) / duration,
        duration,
    )


def _period_of_time(osc: Oscillator, force: Forcing | None) -> float:
    """Return the unit of time: the period of the forcing, or else of the oscillator."""
    if force is not None and force.period is not None:
        return force.period
    stiffness = as_float(osc.of_unit_mass().stiffness)
    if stiffness > 0.0:
        return 2.0 * math.pi / math.sqrt(stiffness)
    components = force.components() if force is not None else ()
    if not components:
        reason = "without a harmonic and without a stiffness there is no period to count time in"
        raise ParameterError("forcing", force, f"{reason}; an exponent needs one of them")
    return 2.0 * math.pi / min(as_float(component.omega) for component in components)


def _of_orbit(
    laws: Floats, result: BatchResult, plan: Plan, periods: int
) -> LyapunovExponents | None:
    """Return the exponents of a periodic orbit, and all else over the same time; None without one.

    The vectors u, M u and M^2 u of the monodromy matrix M give its trace, for M^2 - tr M + det = 0.
    ``periods`` are the forcing periods since the start.
    """
    which = np.zeros(1, dtype=np.int64)
    period = laws[0, 0, PERIOD]
    end = np.column_stack([result.values[:, [observables.END_X, observables.END_V]], plan.until])
    t, step = end[:, 2].copy(), np.array([period])
    strobed = Plan(t, step, t + 2 * LONGEST * period, observables.STROBES, 2 * LONGEST + 1)
    strobes = follow_batch(laws, which, end, strobed).points[:, :, :2]
    n_periods = int(period_of(strobes, LONGEST)[0])
    if n_periods == 0:
        return None
    step = step * n_periods
    measured = Plan(t, step, t + ORBIT_PERIODS * step, observables.TANGENTS, ORBIT_PERIODS + 1)
    followed = follow_batch(laws, which, end, measured)
    points = followed.points[0]
    rates = np.array([_rates(points[k : k + 3]) for k in (0, 1)]) / step
    shrunk = np.diff(points[:, observables.SECOND])
    # An impact at the very end of a period can fall into either of two: then areas do not shrink
    # alike, and the periods are none.
    if not np.isfinite(rates).all() or np.ptp(shrunk) > ALIKE * np.abs(shrunk).max():
        return None
    duration = float(ORBIT_PERIODS * step[0])
    return LyapunovExponents(
        rates[1],
        np.abs(rates[1] - rates[0])
        * _steps_to_go(float(rates[1, 0] * step[0]), periods / n_periods),
        float(points[-1, observables.SECOND] - points[0, observables.SECOND]) / duration,
        float(followed.values[0, observables.IMPACTS]) / duration,
        duration,
    )


def _steps_to_go(log_multiplier: float, n_periods: float) -> float:
    """Return the remaining way to an orbit as a multiple of the last step.

    The approach is geometric: steps of m, m^2, ... times the last one follow, 1 / (1 - m) in all.
    Where |m| is 1 the distance falls as one over the number of periods, and the remaining way is
    the last step times that number.
    """
    left = -expm1(log_multiplier)
    return 1.0 / left if left * n_periods > 1.0 else max(1.0, n_periods)


def _rates(points: Floats) -> Floats:
    """Return the logarithms of the sizes of both multipliers, from three periods' points."""
    logs, angles = points[:, observables.FIRST], points[:, observables.THIRD]
    area = exp(float(points[1, observables.SECOND] - points[0, observables.SECOND]))
    size = exp(logs - logs[0])
    u, once, twice = np.stack([size * cos(angles), size * sin(angles)], axis=1)
    trace = dot(twice + area * u, once) / dot(once, once)
    half = 0.5 * trace
    below = half * half - area
    larger = abs(half) + math.sqrt(below) if below > 0.0 else math.sqrt(area)
    smaller = abs(area) / larger if below > 0.0 else larger
    return np.array([log(larger), log(smaller)])
