"""The built-in measures: named numbers of motions, computed by the compiled kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from percuss.arrays import Floats
from percuss.ensembles.batch import (
    BatchResult,
    Plan,
    exponents_of,
    reason_of,
    tangent_plan,
)
from percuss.ensembles.groups import AnyGroup
from percuss.ensembles.repetition import impact_periods, period_of, repeat_times
from percuss.kernels import observables
from percuss.kernels import record as columns
from percuss.model.exact import whole
from percuss.model.oscillator import Oscillator
from percuss.model.start import MOST_PERIODS
from percuss.model.structure import Structure
from percuss.model.units import FORCE, in_units
from percuss.motion.growth import fit_power_law
from percuss.motion.sections import PoincareSection
from percuss.numerics import geometric

# Edges of intervals that are equal in the logarithm of time, as parts of the whole: the growth
# exponent is fitted to their fastest impacts.
INTERVALS = geometric(0.01, 1.0, 25)
# What is counted of motions without forcing.
FREE_COUNT = "a time of 2 pi / sqrt(k)"
FREE_PERIOD = "time after which the motion repeats itself; 0: no time up to half of that measured"
# What the kernels write at a section.
SECTIONS = {
    "stroboscopic": observables.STROBES,
    "impacts": observables.IMPACT_POINTS,
    "passages": observables.PASSAGES,
}
STROBOSCOPIC = PoincareSection("stroboscopic")


@dataclass(frozen=True, slots=True)
class Window:
    """The time in which a motion is measured, after a transient; both in forcing periods.

    Without a forcing they are counted as `counting_periods` says.

    Attributes
    ----------
    transient
        Periods from the start on that are left out, >= 0.
    periods
        Periods that are measured, >= 1.
    between
        Two instants [time] between which is measured, in place of both; None: no such instants.
    """

    transient: int = 200
    periods: int = 64
    between: tuple[float, float] | None = None

    def span(self, t0: Floats, every: Floats) -> tuple[Floats, Floats]:
        """Return when the measuring of motions begins and ends [time], from t0 and periods."""
        if self.between is not None:
            first, last = self.between
            return np.full(len(t0), first), np.full(len(t0), last)
        since = t0 + self.transient * every
        return since, since + self.periods * every

    def counted(self, plan: Plan) -> Floats | int:
        """Return the number of periods that are measured."""
        if self.between is None:
            return self.periods
        return np.asarray((plan.until - plan.since) / plan.every)

    def longest(self, every: Floats) -> Floats:
        """Return more than the whole time of motions whose periods are ``every`` [time]."""
        return np.asarray(2.0 * (self.transient + self.periods + 2) * every)

    def __post_init__(self) -> None:
        for name, least in (("transient", 0), ("periods", 1)):
            number = whole(name, getattr(self, name), least, MOST_PERIODS)
            object.__setattr__(self, name, number)


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of a motion.

    Attributes
    ----------
    units
        Its dimensions in length, time and mass.
    meaning
        Its meaning, in a line.
    value
        Returns the numbers of motions from their results, their plan and the window.
    of_structures, of_displacement
        Whether structures have it, and whether it is that of one displacement.
    needs_extremes, needs_work, needs_loads, needs_load_peaks, needs_strobes, needs_peaks,
    needs_tangent
        What the kernels must record for it: extremes; the work of dashpots; means over time, and
        with them peaks of forces; a strobe in each period; the fastest impacts of intervals of
        time; the growth of a perturbation.
    is_mean
        Whether structures need a run of its own for it: a mean over time, or an acceleration.
    without
        Why a motion that came to its end may have no such number.
    """

    units: str
    meaning: str
    value: Callable[[BatchResult, Plan, Window], Floats]
    of_structures: bool = True
    of_displacement: bool = False
    needs_extremes: bool = False
    needs_work: bool = False
    needs_loads: bool = False
    needs_load_peaks: bool = False
    needs_strobes: bool = False
    needs_peaks: bool = False
    needs_tangent: bool = False
    is_mean: bool = False
    without: str = ""

    @property
    def counts_periods(self) -> bool:
        """Whether it is taken over whole periods."""
        return self.needs_strobes or self.needs_tangent or self.needs_peaks

    def meaning_for(self, osc: Oscillator | Structure, *, free: bool = False) -> str:
        """Return its meaning for an oscillator, with a mass or without, forced or free."""
        meaning = self.meaning if osc.mass is None else self.meaning.replace(" per unit mass", "")
        if free and self.needs_strobes:
            return FREE_PERIOD
        return meaning.replace("a forcing period", FREE_COUNT) if free else meaning

    def dimensions_of(self, osc: Oscillator | Structure, *, free: bool = False) -> str:
        """Return its dimensions for an oscillator, with a mass or without, forced or free."""
        if free and self.needs_strobes:
            return "time"
        return self.units if osc.mass is not None else self.units.removeprefix("mass ")

    def unit_of(self, osc: Oscillator | Structure, *, free: bool = False) -> str:
        """Return its unit, or where an oscillator has no units its dimensions."""
        return in_units(osc.units, self.dimensions_of(osc, free=free))


# Dimensions of the outcomes of a design that are no measures of runs.
_OF_ORBITS = {"period": "time", "multiplier": "1", "grazing_margin": "length"}


def outcome_dimensions(name: str, osc: Oscillator | Structure) -> str:
    """Return the dimensions of an outcome of `percuss.design` for an oscillator or a structure.

    Examples
    --------
    >>> outcome_dimensions("peak_stop_force", Oscillator.from_mass(2, 50))
    'mass length/time^2'
    >>> outcome_dimensions("period", Oscillator())
    'time'
    """
    if name not in MEASURES and name not in _OF_ORBITS:
        # Of a structure the name goes on with a coordinate or a point.
        name = next(known for known in MEASURES if name.startswith(f"{known}_"))
    return _OF_ORBITS.get(name) or MEASURES[name].dimensions_of(osc)


def periods_at(result: BatchResult, plan: Plan, periods: int, longest: int) -> Floats:
    """Return the period of each motion from its points on a section, 0 where it has none.

    Parameters
    ----------
    result, plan
        Results of motions, with points, and their plan.
    periods, longest
        Periods over which the points were kept, and the longest one considered of strobes.

    Returns
    -------
    (n,) array
        In forcing periods; of motions without forcing, whose points are timed, in time.
    """
    if plan.timed is not None:
        return repeat_times(result.points, plan.timed)
    if plan.section == observables.STROBES:
        return period_of(result.strobes, longest, plan.every).astype(np.float64)
    # Of impacts on one stop alone, those are counted.
    counted = result.values[:, observables.POINTS]
    return impact_periods(result.points, counted, periods).astype(np.float64)


def _period(result: BatchResult, plan: Plan, window: Window) -> Floats:
    return periods_at(result, plan, window.periods, max(1, window.periods // 2))


def _peak_displacement(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    lowest, highest = result.values[:, observables.LOWEST], result.values[:, observables.HIGHEST]
    # A mass in contact with a wall all the time.
    still = ~np.isfinite(lowest)
    return np.where(still, np.abs(result.state[:, columns.X]), np.maximum(-lowest, highest))


def _min_displacement(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    lowest = result.values[:, observables.LOWEST]
    return np.where(np.isfinite(lowest), lowest, result.state[:, columns.X])


def _max_displacement(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    highest = result.values[:, observables.HIGHEST]
    return np.where(np.isfinite(highest), highest, result.state[:, columns.X])


def _peak_impact_velocity(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    return result.values[:, observables.PEAK_SPEED].copy()


def _impacts(result: BatchResult, plan: Plan, window: Window) -> Floats:
    return np.asarray(result.values[:, observables.IMPACTS] / window.counted(plan))


def _dissipated(result: BatchResult, plan: Plan, window: Window) -> Floats:
    lost = result.values[:, observables.LOST] + result.values[:, observables.DRAGGED]
    return np.asarray(result.masses * lost / window.counted(plan))


def _peak_stop_force(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    return np.asarray(result.masses * result.values[:, observables.PEAK_FORCE])


def _peak_acceleration(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    return result.values[:, observables.PEAK_ACCELERATION].copy()


def _rms_displacement(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    square = result.values[:, observables.SQUARE] / (plan.until - plan.since)
    return np.asarray(np.sqrt(square))


def _contact_share(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    # The durations of all stretches may add up to more than the whole by their rounding.
    share = result.values[:, observables.IN_TOUCH] / (plan.until - plan.since)
    return np.asarray(np.minimum(share, 1.0))


def _mean_power(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    work = result.values[:, observables.WORK]
    return np.asarray(result.masses * work / (plan.until - plan.since))


def _largest(result: BatchResult, plan: Plan, window: Window) -> Floats:  # noqa: ARG001
    return exponents_of(result, plan)[0]


def _growth(result: BatchResult, plan: Plan, window: Window) -> Floats:
    """Fit a power law to the fastest impacts of intervals equal in log t."""
    duration = (plan.until - plan.since) * (window.transient + window.periods) / window.periods
    middle = np.sqrt(INTERVALS[1:] * INTERVALS[:-1])
    exponents = np.full(len(duration), np.nan)
    for i, peaks in enumerate(result.peaks):
        hit = peaks > 0.0
        exponents[i] = fit_power_law(middle[hit] * duration[i], peaks[hit]).exponent
    return exponents


MEASURES: dict[str, Measure] = {
    "peak_displacement": Measure(
        "length",
        "largest distance from 0",
        _peak_displacement,
        of_displacement=True,
        needs_extremes=True,
    ),
    "min_displacement": Measure(
        "length",
        "least displacement",
        _min_displacement,
        of_displacement=True,
        needs_extremes=True,
    ),
    "max_displacement": Measure(
        "length",
        "largest displacement",
        _max_displacement,
        of_displacement=True,
        needs_extremes=True,
    ),
    "peak_impact_velocity": Measure(
        "length/time",
        "largest speed just before an impact, or at the entry into a soft stop; 0 without any",
        _peak_impact_velocity,
    ),
    "impacts_per_period": Measure(
        "1",
        "impacts, and entries into soft stops, in a forcing period",
        _impacts,
    ),
    "period": Measure(
        "1",
        "forcing periods after which the motion repeats itself; 0: after none of up to half of "
        "those measured",
        _period,
        needs_strobes=True,
    ),
    "dissipated_energy": Measure(
        "mass length^2/time^2",
        "energy per unit mass that impacts and dashpots take in a forcing period",
        _dissipated,
        of_structures=False,
        needs_work=True,
    ),
    "peak_stop_force": Measure(
        FORCE,
        "largest magnitude of the force per unit mass of a stop: of a soft one while it is touched, "
        "of a wall that holds the mass; an impulse is no force",
        _peak_stop_force,
        needs_loads=True,
        needs_load_peaks=True,
    ),
    "peak_acceleration": Measure(
        "length/time^2",
        "largest magnitude of the acceleration, both limits at a jump, impacts left out",
        _peak_acceleration,
        of_displacement=True,
        needs_loads=True,
        needs_load_peaks=True,
        is_mean=True,
    ),
    "rms_displacement": Measure(
        "length",
        "square root of the mean of x^2 over time",
        _rms_displacement,
        of_displacement=True,
        needs_loads=True,
        is_mean=True,
    ),
    "contact_share": Measure(
        "1",
        "share of the time in which a soft stop is touched or a wall holds the mass",
        _contact_share,
        needs_loads=True,
    ),
    "mean_power": Measure(
        "mass length^2/time^3",
        "mean power per unit mass of the forcing",
        _mean_power,
        needs_loads=True,
        is_mean=True,
    ),
    "largest_lyapunov_exponent": Measure(
        "1/time",
        "largest exponent, from exact propagators and saltation matrices; -inf after a contact",
        _largest,
        needs_tangent=True,
    ),
    "growth_exponent": Measure(
        "1",
        "exponent of the power of time with which the largest impact speed grows, over the last "
        "99 % of the time",
        _growth,
        needs_peaks=True,
        without="too few impacts to tell an exponent from",
    ),
}


def measure_group(
    names: Sequence[str],
    group: AnyGroup,
    window: Window,
    max_impacts: int,
    section: PoincareSection = STROBOSCOPIC,
) -> tuple[dict[str, Floats], dict[int, str], int]:
    """Return the measures of motions, the reasons of those without, and the number of impacts.

    Parameters
    ----------
    names
        Keys of `MEASURES`.
    group
        The motions.
    window
        When they are measured.
    max_impacts
        Impacts after which a motion is abandoned.
    section
        Where a period is found; motions without forcing have no strobes.

    Returns
    -------
    tuple
        (n,) arrays by name; reasons by the motion's place in the group; the number of impacts.
    """
    n = len(group.which)
    values = {name: np.full(n, np.nan) for name in names}
    reasons: dict[int, str] = {}
    n_impacts = 0
    for together in _together(names):
        plan = _plan(together, group, window, max_impacts, section)
        result = group.follow(plan)
        n_impacts += int(result.n_impacts.sum())
        lost = _reasons(result, plan)
        reasons |= lost
        for name in together:
            measure = MEASURES[name]
            values[name] = measure.value(result, plan, window)
            values[name][list(lost)] = np.nan
            if measure.without:
                for i in np.flatnonzero(np.isnan(values[name])).tolist():
                    reasons.setdefault(i, measure.without)
    return values, reasons, n_impacts


def _together(names: Sequence[str]) -> list[list[str]]:
    """Return the measures in groups that are taken from the same run of the kernel.

    Strobes and perturbations are both recorded as points: next to a period, the largest exponent
    has a run of its own.
    """
    if not any(MEASURES[name].needs_strobes for name in names):
        return [list(names)]
    alone = [name for name in names if MEASURES[name].needs_tangent]
    rest = [name for name in names if name not in alone]
    return [rest, alone] if alone else [rest]


def _plan(
    names: Sequence[str],
    group: AnyGroup,
    window: Window,
    max_impacts: int,
    section: PoincareSection,
) -> Plan:
    period = group.periods
    t0 = group.starts[:, -1]
    measures = [MEASURES[name] for name in names]
    since, until = window.span(t0, period)
    plan = Plan(since, period, until)
    if any(measure.needs_strobes for measure in measures):
        plan = replace(
            plan,
            section=SECTIONS[section.kind],
            n_points=window.periods + 1,
            level=section.at,
            sign=section.sign,
            timed=None if group.is_forced else window.longest(period),
        )
    elif any(measure.needs_tangent for measure in measures):
        plan = tangent_plan(period, t0, window.transient, window.periods)
    edges = None
    if any(measure.needs_peaks for measure in measures):
        duration = (window.transient + window.periods) * period
        edges = t0[:, np.newaxis] + duration[:, np.newaxis] * INTERVALS
    return replace(
        plan,
        with_extremes=any(measure.needs_extremes for measure in measures),
        with_work=any(measure.needs_work for measure in measures),
        with_loads=any(measure.needs_loads for measure in measures),
        with_load_peaks=any(measure.needs_load_peaks for measure in measures),
        with_means=any(measure.is_mean for measure in measures),
        max_impacts=max_impacts,
        edges=edges,
    )


def _reasons(result: BatchResult, plan: Plan) -> dict[int, str]:
    reasons: dict[int, str] = {}
    for status in np.unique(result.status):
        reason = reason_of(int(status), plan)
        if reason is not None:
            reasons |= {int(i): reason for i in np.flatnonzero(result.status == status)}
    return reasons
