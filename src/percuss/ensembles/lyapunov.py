"""Both Lyapunov exponents of a motion, from exact propagators and saltation matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from percuss.arrays import Floats
from percuss.ensembles.batch import (
    MOST_IMPACTS,
    BatchResult,
    Plan,
    drift_of,
    exponents_of,
    follow_batch,
    reason_of,
    tangent_plan,
)
from percuss.ensembles.decisions import (
    BLOCKS,
    CHANCE,
    ORBIT_PERIODS,
    ROUNDINGS,
    orbit_exponents,
    rounding_of,
    steps_to_go,
)
from percuss.ensembles.grid import make_grid
from percuss.ensembles.groups import StructureGroup
from percuss.ensembles.repetition import period_of
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels import observables
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import ULP
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import as_float, whole
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.start import MOST_PERIODS, Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.numerics import hypot, log
from percuss.orbits.orbit.structure_orbit import multipliers_of_matrix, period_map

# The longest period of an orbit that is considered, in forcing periods.
LONGEST = 16
# Impacts of a motion for each period; the default limit.
IMPACTS_OF_A_PERIOD = 100


@dataclass(frozen=True, slots=True, eq=False)
class LyapunovExponents:
    """The exponents of a motion.

    Attributes
    ----------
    exponents
        (2,) array, the larger first [1/time]; both -inf where a contact has ended all memory, the
        second where impacts have no restitution. Of a structure of n coordinates (2 n,), two of
        them -inf for each wall that has held it.
    errors
        (2,) array, (2 n,) of a structure, their errors [1/time]: the standard error from the means
        of blocks, and with it the difference between the two halves where this is more than chance.
        On a periodic orbit, whose multipliers give the exponents, the difference of two of its
        periods, times those that it still takes to die out. Both with the rounding of each event;
        of two multipliers that it leaves equal with its root.
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
    osc: Oscillator | Structure,
    force: Forcing | Loads | None = None,
    *,
    start: Start | StructureStart | Sequence[Any] | None = None,
    transient: int = 1000,
    periods: int = 20_000,
    max_impacts: int | None = None,
) -> LyapunovExponents:
    """Return both exponents of the motion from a start; all 2 n of a structure's.

    A perturbation is carried along each flight by the exact propagator and over each event by its
    saltation matrix, at the edges of soft stops as at impacts. Two perturbations span an area whose
    factor is known in closed form: it gives the sum of the exponents. Of a structure 2 n
    perturbations are carried, made orthogonal again and again (Benettin et al. 1980); the volume's
    factor gives their sum.

    Parameters
    ----------
    osc, force
        The oscillator and its forcing, or a structure and its loads. Where the forcing has no
        period, a period below is 2 pi / sqrt(stiffness), or without stiffness that of the slowest
        harmonic.
    start
        Where it starts: a `Start`, or x0 [length] and v0 [length/time]; of a structure with a
        number for each coordinate; default: at rest at 0.
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
    transient = whole("transient", transient, 0, MOST_PERIODS)
    periods = whole("periods", periods, BLOCKS, MOST_PERIODS)
    most = max(MOST_IMPACTS, IMPACTS_OF_A_PERIOD * (transient + periods))
    if max_impacts is not None:
        most = whole("max_impacts", max_impacts, 1)
    grid = make_grid(osc, force, start, {})
    groups, faults = grid.groups(0, 1)
    if faults:
        raise ParameterError("start", grid.start, faults[0])
    (group,) = groups
    if isinstance(group, StructureGroup):
        return _of_structure(group, transient, periods, most)
    period = np.array([_period_of_time(cast("Oscillator", osc), cast("Forcing | None", force))])
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
    largest, smallest, error, total = (float(value[0]) for value in exponents_of(result, plan))
    impacts = float(result.values[0, observables.IMPACTS])
    error = hypot(error, float(drift_of(result, plan)[0]))
    if math.isfinite(largest):
        size = float(np.abs(result.points[0, [0, -1], observables.FIRST]).max())
        error += rounding_of(2.0 * impacts, size) / duration
    # Two that are equal but for their rounding are in order as well.
    both = np.array([max(largest, smallest), min(largest, smallest)])
    return LyapunovExponents(both, np.array([error, error]), total, impacts / duration, duration)


def _of_structure(
    group: StructureGroup, transient: int, periods: int, most: int
) -> LyapunovExponents:
    """Return the 2 n exponents of a motion of a structure."""
    period, start = group.periods, group.starts
    count = start.shape[1] - 1
    plan = tangent_plan(period, start[:, -1], transient, periods)
    plan = replace(plan, max_impacts=most, n_tangents=count)
    result = group.follow(plan)
    reason = reason_of(int(result.status[0]), plan)
    if reason is not None:
        raise ParameterError("start", tuple(start[0].tolist()), reason)
    duration = float(plan.until[0] - plan.since[0])
    logs = result.logs[0]
    with np.errstate(invalid="ignore"):
        exponents = (logs[-1] - logs[0]) / duration
        rates = np.diff(logs, axis=0) / plan.every[0]
        errors = rates.std(axis=0, ddof=1) / math.sqrt(BLOCKS)
        halves = rates[: BLOCKS // 2].mean(axis=0) - rates[BLOCKS // 2 :].mean(axis=0)
    drift = np.where(np.abs(halves) > 2.0 * CHANCE * errors, np.abs(halves), 0.0)
    # What a contact has taken was lost before or within the time that is measured.
    forgotten = np.isneginf(logs[-1])
    shrunk = result.points[0, :, observables.SECOND]
    lost = bool(forgotten.any())
    total = -math.inf if lost else float(shrunk[-1] - shrunk[0]) / duration
    exponents = np.where(forgotten, -np.inf, exponents)
    impacts = float(result.values[0, observables.IMPACTS])
    sizes = np.where(forgotten, 0.0, np.abs(logs[[0, -1]]).max(axis=0))
    rounding = count * np.array([rounding_of(2.0 * impacts, size) for size in sizes]) / duration
    errors = np.where(forgotten, 0.0, np.sqrt(errors * errors + drift * drift) + rounding)
    known = _of_structure_orbit(group, result, plan, int(forgotten.sum()), transient + periods)
    if known is not None:
        exponents, errors = known
    order = np.argsort(-exponents, kind="stable")
    return LyapunovExponents(
        exponents[order],
        errors[order],
        total,
        float(result.values[0, observables.IMPACTS]) / duration,
        duration,
    )


def _of_structure_orbit(
    group: StructureGroup,
    result: BatchResult,
    plan: Plan,
    n_lost: int,
    periods: int,
) -> tuple[Floats, Floats] | None:
    """Return the exponents of a periodic orbit from its multipliers, and errors; None without one.

    None, too, where a long flight has left less of a multiplier than the matrix is rounded by.
    ``n_lost`` multipliers are 0, and ``periods`` those of the loads since the start.
    """
    system = group.systems[0]
    if system.period is None:
        return None
    # The map over a period begins at time 0, with the phases of each whole period.
    last = math.ceil(float(plan.until[0]) / system.period) * system.period
    begin = np.column_stack([result.ends, plan.until])
    since, step = np.array([last]), np.array([system.period])
    strobed = Plan(since, step, since + 2 * LONGEST * step, observables.STROBES, 2 * LONGEST + 1)
    strobes = group.beginning(np.zeros(1, dtype=np.int64), begin).follow(strobed).strobes
    n_periods = int(period_of(np.nan_to_num(strobes), LONGEST, step)[0])
    if n_periods == 0:
        return None
    try:
        here = period_map(system, strobes[0, -1], n_periods)
        mapped = period_map(system, here.image, n_periods)
        found = [multipliers_of_matrix(step_map.derivative) for step_map in (here, mapped)]
    except (ConvergenceError, ParameterError):
        return None
    length = n_periods * system.period
    rate = float(result.values[0, observables.IMPACTS]) / float(plan.until[0] - plan.since[0])
    relative = ROUNDINGS * ULP * len(strobes[0, -1]) * (1.0 + 2.0 * rate * length)
    rates = []
    for step_map, multipliers in zip((here, mapped), found, strict=True):
        sizes = hypot(multipliers.real, multipliers.imag)
        n_kept = len(sizes) - n_lost
        if not (sizes[:n_kept] > relative * _norm_of(step_map.derivative)).all():
            return None
        sizes[n_kept:] = 0.0
        with np.errstate(divide="ignore"):
            rates.append(np.where(sizes > 0.0, log(np.where(sizes > 0.0, sizes, 1.0)), -np.inf))
    with np.errstate(invalid="ignore"):
        moved = np.abs(rates[1] - rates[0]) / length
    to_go = steps_to_go(float(rates[1][0]), periods / n_periods)
    errors = moved * to_go + _rounding_of(mapped.derivative, relative) / length
    return rates[1] / length, np.where(np.isneginf(rates[1]), 0.0, errors)


def _rounding_of(matrix: Floats, relative: float) -> Floats:
    """Return what a relative rounding of a matrix makes of the logarithms of its multipliers.

    A multiplier is moved by the rounding of the matrix, one that equals another by its root.
    """
    multipliers = multipliers_of_matrix(matrix)
    size = _norm_of(matrix)
    doubt = relative * size
    apart = np.abs(multipliers[:, None] - multipliers) + np.diag(np.full(len(multipliers), np.inf))
    near = apart.min(axis=1) <= math.sqrt(doubt * size)
    moved = np.where(near, math.sqrt(doubt * size), doubt)
    sizes = hypot(multipliers.real, multipliers.imag)
    return moved / np.maximum(sizes, doubt)


def _norm_of(matrix: Floats) -> float:
    """Return the root of the sum of the squares of all entries."""
    return float(np.sqrt((matrix * matrix).sum()))


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

    ``periods`` are the forcing periods since the start.
    """
    which = np.zeros(1, dtype=np.int64)
    period = laws[0, 0, PERIOD]
    end = np.column_stack([result.values[:, [observables.END_X, observables.END_V]], plan.until])
    t, step = end[:, 2].copy(), np.array([period])
    strobed = Plan(t, step, t + 2 * LONGEST * period, observables.STROBES, 2 * LONGEST + 1)
    strobes = follow_batch(laws, which, end, strobed).points[:, :, :2]
    n_periods = int(period_of(strobes, LONGEST, step)[0])
    if n_periods == 0:
        return None
    step = step * n_periods
    measured = Plan(t, step, t + ORBIT_PERIODS * step, observables.TANGENTS, ORBIT_PERIODS + 1)
    followed = follow_batch(laws, which, end, measured)
    points, exponents = np.ascontiguousarray(followed.points[0]), np.empty(4)
    # An entry into a soft stop has its exit.
    n_events = 2.0 * float(followed.values[0, observables.IMPACTS]) / ORBIT_PERIODS
    if not orbit_exponents(points, float(step[0]), periods / n_periods, n_events, exponents):
        return None
    duration = float(ORBIT_PERIODS * step[0])
    return LyapunovExponents(
        exponents[:2],
        exponents[2:],
        float(points[-1, observables.SECOND] - points[0, observables.SECOND]) / duration,
        float(followed.values[0, observables.IMPACTS]) / duration,
        duration,
    )
