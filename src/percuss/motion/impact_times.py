"""Classification of impact times: the set that they form (Dyskin et al. 2012, sections 3 to 5)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import as_float, reals
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, Stop, Wall
from percuss.model.restitution import is_elastic
from percuss.model.system import System
from percuss.motion.eigenset import resonant_frequency
from percuss.motion.entries import entry_rows
from percuss.motion.growth import CERTAIN, Growth, fit_power_law
from percuss.motion.patterns import FEWEST, REPETITIONS, ROUNDINGS, TOLERANCE, find_pattern
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory

PatternKind: TypeAlias = Literal[
    "eigenset",
    "eigenset_subset",
    "periodic",
    "settling",
    "approaching_eigenset",
    "no_period_found",
    "too_few",
]


@dataclass(frozen=True, slots=True)
class ImpactTimes:
    """The kind of a set of impact times.

    Attributes
    ----------
    kind
        "eigenset": one impact at each multiple of the free oscillator's time between impacts;
        "eigenset_subset": at some of them only; "periodic"; "approaching_eigenset": not on it,
        but ever nearer to its intervals; "no_period_found"; "too_few".
    n_impacts, n_periods
        The smallest pattern that repeats, or that the times settle to: so many impacts in so
        many forcing periods; 0 where there is none, n_periods also where the forcing has no
        period.
    rate
        For "approaching_eigenset" the exponent p of the law t^-p that the distance of the
        intervals from the eigenset's spacing follows, by least squares as in `growth`; t is
        counted from the first impact. For "settling" the rate of the law exp(-rate t) that the
        distance from the pattern follows [1/time]: minus the logarithm of the largest multiplier
        of the orbit, over its period. NaN otherwise.
    deviation
        Largest difference between a repetition and the pattern [time]: of the times that repeat;
        for "settling" of the last repetition; for "approaching_eigenset" of the last intervals
        from the eigenset's. NaN without a pattern.
    n_used
        Number of times that the answer rests on: all, or the tail that repeats or settles.
    """

    kind: PatternKind
    n_impacts: int
    n_periods: int
    rate: float
    deviation: float
    n_used: int


def classify_impact_times(
    run: Trajectory | StructureTrajectory | ArrayLike,
    osc: Oscillator | None = None,
    force: Forcing | None = None,
) -> ImpactTimes:
    """Classify the set that the impact times of a run form.

    Without impacts, the entries into soft stops are taken; of a structure the times at all its
    stops, of which the free motion has no eigenset. A transient may come first: a period is
    believed if the last three repetitions agree, within 1e-8 of the mean interval or the rounding
    of the times. Before they do, and where there are losses, the pattern is named that the times
    settle to: the smallest whose deviations fall geometrically over twelve repetitions at least.
    Without losses no motion settles (areas of the phase plane are kept), so that deviations which
    neither vanish nor grow, as those of a quasi-periodic motion, are no pattern.

    Parameters
    ----------
    run
        A run, or (n,) array of increasing times [time].
    osc, force
        What moved; needed with an array, ignored with a run.

    Returns
    -------
    ImpactTimes
        The kind and the pattern.

    Raises
    ------
    ParameterError
        If an array comes without an oscillator, or does not increase.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.45, t_end=200.0)
    >>> classify_impact_times(run).kind
    'periodic'

    A motion that loses a factor of 0.8 in each of its last periods:

    >>> run = pc.simulate(pc.impact_oscillator(0.8), pc.cosine(2.1), v0=0.3, periods=40)
    >>> answer = classify_impact_times(run)
    >>> answer.kind, answer.n_impacts, answer.n_periods, round(answer.rate * 2 * np.pi / 2.1, 2)
    ('settling', 1, 1, 0.22)

    An absorber of a tenth of the mass strikes the walls of its cavity four times a period:

    >>> absorber = pc.vibro_impact_absorber(1, 1, "0.1", gap="0.5", restitution="0.6", damping="0.2")
    >>> run = pc.simulate(absorber, pc.Loads({0: pc.cosine(1, amplitude="0.3")}), periods=300)
    >>> answer = classify_impact_times(run)
    >>> answer.kind, answer.n_impacts, answer.n_periods
    ('periodic', 4, 1)
    """
    if isinstance(run, StructureTrajectory):
        times, period, spacing = _times_of(run), run.loads.period, None
        is_damped, stops = bool(run.structure.damping_matrix.any()), run.structure.stops
    else:
        if isinstance(run, Trajectory):
            osc, force, times = run.oscillator, run.forcing, _times_of(run)
        elif osc is None:
            raise ParameterError("osc", None, "an array of times needs the oscillator they are of")
        else:
            System.of(osc, force)  # which checks both
            times = reals("run", run)
            in_order = times.ndim == 1 and (np.diff(times) > 0.0).all()
            if not in_order or not np.isfinite(times).all():
                reason = "not one array of finite, increasing times"
                raise ParameterError("run", times.shape, reason)
        period, spacing = force.period if force is not None else None, _spacing(osc)
        is_damped, stops = as_float(osc.damping) != 0.0, osc.stops
    if len(times) < FEWEST:
        return ImpactTimes("too_few", 0, 0, np.nan, np.nan, len(times))
    on_eigenset = None if spacing is None else _eigenset(times, spacing, period)
    if on_eigenset is not None:
        return on_eigenset
    is_dissipative = is_damped or _change_areas(stops)
    # First, since late in an approach the intervals differ by less than any tolerance. A power of
    # the time belongs to conservative motion; with losses the deviations fall geometrically.
    approaching = None if spacing is None or is_dissipative else _approaching(times, spacing)
    if approaching is not None:
        return approaching
    pattern = find_pattern(times, period, is_dissipative=is_dissipative)
    if pattern is not None:
        return ImpactTimes(
            "settling" if pattern.is_settling else "periodic",
            pattern.n_impacts,
            pattern.n_periods,
            pattern.rate,
            pattern.deviation,
            pattern.n_used,
        )
    return ImpactTimes("no_period_found", 0, 0, np.nan, np.nan, len(times))


def _times_of(run: Trajectory | StructureTrajectory) -> Floats:
    """Return the times of the impacts, or without any those of the entries into soft stops."""
    times: Floats = run.impacts.t if len(run.impacts) else run.crossings.t[entry_rows(run)]
    return times


def _change_areas(stops: Iterable[Stop]) -> bool:
    """Return whether stops change areas of the phase plane: by dashpots or restitution."""
    return any(
        not is_elastic(stop.restitution) if isinstance(stop, Wall) else as_float(stop.damping) != 0
        for stop in stops
    )


def _spacing(osc: Oscillator) -> float | None:
    """Return the time between impacts of the free oscillator, None where it is not one number."""
    try:
        return 2.0 * np.pi / resonant_frequency(osc)
    except ParameterError:
        return None


def _eigenset(times: Floats, spacing: float, period: float | None) -> ImpactTimes | None:
    steps = (times - times[0]) / spacing
    nearest = np.round(steps)
    deviation = float(np.abs(steps - nearest).max() * spacing)
    gaps = np.diff(nearest)
    if deviation > TOLERANCE * spacing or (gaps < 1.0).any():
        return None
    n = _shortest_pattern(gaps)
    n_periods = _whole_periods(float(nearest[n] - nearest[0]) * spacing, period) if n else 0
    if (gaps == 1.0).all():
        # The least number of impacts that fill whole forcing periods.
        return ImpactTimes(
            "eigenset", *_commensurate(spacing, period), np.nan, deviation, len(times)
        )
    return ImpactTimes("eigenset_subset", n, n_periods, np.nan, deviation, len(times))


def _commensurate(spacing: float, period: float | None) -> tuple[int, int]:
    if period is None:
        return 1, 0
    for n in range(1, 65):
        whole = _whole_periods(n * spacing, period)
        if whole:
            return n, whole
    return 1, 0


def _shortest_pattern(gaps: Floats) -> int:
    """Return the length of the shortest sequence that repeats throughout, 0 if none does."""
    for n in range(1, len(gaps) // REPETITIONS + 1):
        if (gaps[n:] == gaps[:-n]).all():
            return n
    return 0


def _whole_periods(time: float, period: float | None) -> int:
    """Return how many forcing periods a time is, 0 if it is no whole number of them."""
    if period is None:
        return 0
    count = round(time / period)
    return count if abs(time - count * period) <= 10.0 * TOLERANCE * time else 0


def _approaching(times: Floats, spacing: float) -> ImpactTimes | None:
    """Return whether the intervals come ever nearer to the spacing, and by which law."""
    off = np.abs(np.diff(times) - spacing)
    quarter = len(off) // 4
    if quarter < FEWEST:
        return None
    second, third, last = (float(off[i * quarter : (i + 1) * quarter].max()) for i in (1, 2, 3))
    is_rounding = last < ROUNDINGS * np.spacing(np.abs(times).max())
    if is_rounding or not (last < third < second and last < 0.1 * spacing):
        return None
    law = _law_of_approach(times, off)
    if not law.exponent + CERTAIN * law.exponent_error < 0.0:
        return None
    return ImpactTimes("approaching_eigenset", 0, 0, -law.exponent, last, len(times))


def _law_of_approach(times: Floats, off: Floats) -> Growth:
    """Fit the larger of each two distances by a power of the time.

    In some motions every second distance is an order of magnitude smaller.
    """
    pairs = len(off) // 2
    largest = off[: 2 * pairs].reshape(-1, 2).max(axis=1)
    since = times[1 : 2 * pairs : 2] - times[0]
    used = (since >= 0.01 * since[-1]) & (largest > 0.0)
    return fit_power_law(since[used], largest[used])
