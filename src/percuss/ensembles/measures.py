"""What can be asked of each motion of many, compiled: named numbers of an attractor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.grid import LanesOf, whole
from percuss.ensembles.lanes import Lanes, Plan, follow_lanes, reason_of
from percuss.ensembles.tangents import exponents_of, tangent_plan
from percuss.kernels import record as columns
from percuss.kernels import survey
from percuss.kernels.law import PERIOD
from percuss.motion.growth import fit_power_law
from percuss.numerics import geometric

__all__ = ["MEASURES", "Measure", "Window", "measure_lanes", "period_of"]

Floats = NDArray[np.float64]

# Strobes that differ by less than this part of the motion's size are the same.
SAME = 1e-6
# A round of p periods has strobes that differ by more than this many times that; what differs less
# is the end of a transient that turns by about 1/p.
SETTLED = 100.0
# Stretches of time, equal in its logarithm, whose fastest impacts an exponent is told from.
STRETCHES = 24


@dataclass(frozen=True, slots=True)
class Window:
    """When a motion is measured: after a transient, for a while; both in forcing periods.

    Attributes
    ----------
    transient
        Periods from the start on that are left out, >= 0.
    periods
        Periods that are measured, >= 1.
    """

    transient: int = 200
    periods: int = 64

    def __post_init__(self) -> None:
        object.__setattr__(self, "transient", whole("transient", self.transient, 0))
        object.__setattr__(self, "periods", whole("periods", self.periods, 1))


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of a motion.

    Attributes
    ----------
    units
        Its dimensions.
    meaning
        What it is, in a line.
    value
        From what is left of the lanes, and the window, their numbers.
    surveyed, strobed
        What has to be kept for it.
    """

    units: str
    meaning: str
    value: Callable[[Lanes, Window], Floats]
    surveyed: bool = False
    strobed: bool = False


def period_of(points: Floats, longest: int) -> NDArray[np.int64]:
    """Return after how many forcing periods each motion repeats itself, 0 where it does not.

    Parameters
    ----------
    points
        (n, m, 2) array of (x, v), one a period.
    longest
        The longest period looked for, in forcing periods, below m.

    Returns
    -------
    (n,) array
        The least period p at which all strobes agree with those p later to 1e-6 of the motion's
        size, where those of a shorter one that divides it are apart by more than 1e-4.

    Examples
    --------
    >>> alternating = np.array([[[1.0, 0.0], [2.0, 0.0]] * 4])
    >>> period_of(alternating, 4)
    array([2])
    """
    size = np.abs(points).max(axis=(1, 2))
    # What repeats itself does so at the end: a look at one pair of strobes spares most others.
    last = np.abs(points[:, -1:] - points[:, -1 - longest : -1]).max(axis=2)[:, ::-1]
    hopeful = last <= SAME * size[:, np.newaxis]
    found = np.zeros(len(points), dtype=np.int64)
    for p in (1 + np.flatnonzero(hopeful.any(axis=0))).tolist():
        rows = np.flatnonzero(hopeful[:, p - 1])
        rows = rows[_apart(points[rows], p) <= SAME * size[rows]]
        if len(rows) == 0:
            continue
        # The first period that fits decides, if only that there is none.
        hopeful[rows] = False
        distinct = np.ones(len(rows), dtype=np.bool_)
        for q in (q for q in range(1, p // 2 + 1) if p % q == 0):
            distinct &= _apart(points[rows], q) > SETTLED * SAME * size[rows]
        found[rows[distinct]] = p
    return found


def _apart(points: Floats, p: int) -> Floats:
    """Return by how much strobes differ from those p periods later, at most."""
    return np.asarray(np.abs(points[:, p:] - points[:, :-p]).max(axis=(1, 2)))


def _period(lanes: Lanes, window: Window) -> Floats:
    strobes = lanes.points[:, :, [survey.FIRST, survey.SECOND]]
    return period_of(strobes, max(1, window.periods // 2)).astype(np.float64)


def _peak_displacement(lanes: Lanes, window: Window) -> Floats:  # noqa: ARG001
    lowest, highest = lanes.tallies[:, survey.LOWEST], lanes.tallies[:, survey.HIGHEST]
    # A mass that is held at a wall all the time moves nowhere.
    still = ~np.isfinite(lowest)
    return np.where(still, np.abs(lanes.state[:, columns.X]), np.maximum(-lowest, highest))


def _tally(entry: int) -> Callable[[Lanes, Window], Floats]:
    return lambda lanes, window: lanes.tallies[:, entry].copy()  # noqa: ARG005


def _dissipated(lanes: Lanes, window: Window) -> Floats:
    lost = lanes.tallies[:, survey.LOST] + lanes.tallies[:, survey.DRAGGED]
    return np.asarray(lost / window.periods)


MEASURES: dict[str, Measure] = {
    "peak_displacement": Measure(
        "length", "largest distance from 0", _peak_displacement, surveyed=True
    ),
    "peak_impact_velocity": Measure(
        "length/time",
        "largest speed just before an impact, or at the entry into a soft stop; 0 without any",
        _tally(survey.PEAK_SPEED),
    ),
    "impacts_per_period": Measure(
        "1",
        "impacts, and entries into soft stops, in a forcing period",
        lambda lanes, window: np.asarray(lanes.tallies[:, survey.IMPACTS] / window.periods),
    ),
    "period": Measure(
        "1",
        "forcing periods after which the motion repeats itself; 0: after none of up to half of "
        "those measured",
        _period,
        strobed=True,
    ),
    "dissipated_energy": Measure(
        "length^2/time^2",
        "energy per unit mass that impacts and dashpots take in a forcing period",
        _dissipated,
        surveyed=True,
    ),
    "largest_lyapunov_exponent": Measure(
        "1/time",
        "largest exponent, from exact propagators and saltation matrices; -inf after a contact",
        # It has lanes of its own.
        lambda lanes, window: np.full(len(lanes.status), np.nan),  # noqa: ARG005
    ),
    "growth_exponent": Measure(
        "1",
        "exponent of the power of time with which the largest impact speed grows, over the last "
        "99 % of the time",
        # It has lanes of its own.
        lambda lanes, window: np.full(len(lanes.status), np.nan),  # noqa: ARG005
    ),
}


def measure_lanes(
    names: Sequence[str], group: LanesOf, window: Window, max_impacts: int
) -> tuple[dict[str, Floats], dict[int, str], int]:
    """Return the numbers of some lanes, why lanes have none, and how many impacts it took.

    Parameters
    ----------
    names
        Keys of `MEASURES`.
    group
        The lanes.
    window
        When they are measured.
    max_impacts
        Impacts after which a lane is given up.

    Returns
    -------
    tuple
        (n,) arrays by name; reasons by the lane's place in the group; the number of impacts.
    """
    period = group.laws[group.which, 0, PERIOD]
    since = group.starts[:, 2] + window.transient * period
    until = since + window.periods * period
    asked = [MEASURES[name] for name in names if name not in OF_THEIR_OWN]
    values: dict[str, Floats] = {}
    reasons: dict[int, str] = {}
    n_impacts = 0
    if asked:
        strobed = any(measure.strobed for measure in asked)
        plan = Plan(
            since,
            period,
            until,
            section=survey.STROBES if strobed else survey.NO_POINTS,
            n_points=window.periods + 1 if strobed else 1,
            surveyed=any(measure.surveyed for measure in asked),
            max_impacts=max_impacts,
        )
        lanes = follow_lanes(group.laws, group.which, group.starts, plan)
        n_impacts += int(lanes.n_impacts.sum())
        reasons = _reasons(lanes, plan)
        for name in names:
            values[name] = MEASURES[name].value(lanes, window)
            values[name][list(reasons)] = np.nan
    for name, function in OF_THEIR_OWN.items():
        if name in names:
            values[name], more, count = function(group, window, max_impacts)
            reasons |= more
            n_impacts += count
    return values, reasons, n_impacts


def _reasons(lanes: Lanes, plan: Plan) -> dict[int, str]:
    found: dict[int, str] = {}
    for status in np.unique(lanes.status):
        reason = reason_of(int(status), plan)
        if reason is not None:
            found |= {int(i): reason for i in np.flatnonzero(lanes.status == status)}
    return found


def _lyapunov(
    group: LanesOf, window: Window, max_impacts: int
) -> tuple[Floats, dict[int, str], int]:
    """Take the largest exponent of each lane."""
    t0 = group.starts[:, 2]
    plan = tangent_plan(group.laws, group.which, t0, window.transient, window.periods)
    plan = replace(plan, max_impacts=max_impacts)
    lanes = follow_lanes(group.laws, group.which, group.starts, plan)
    reasons = _reasons(lanes, plan)
    largest = exponents_of(lanes, plan)[0]
    largest[list(reasons)] = np.nan
    return largest, reasons, int(lanes.n_impacts.sum())


def _growth(group: LanesOf, window: Window, max_impacts: int) -> tuple[Floats, dict[int, str], int]:
    """Fit a power law to the fastest impacts of stretches equal in log t."""
    n = len(group.which)
    t0 = group.starts[:, 2]
    period = group.laws[group.which, 0, PERIOD]
    duration = (window.transient + window.periods) * period
    edges = geometric(0.01, 1.0, STRETCHES + 1)
    peaks = np.zeros((n, STRETCHES))
    reasons: dict[int, str] = {}
    n_impacts = 0
    for k in range(STRETCHES):
        plan = Plan(
            t0 + edges[k] * duration,
            duration,
            t0 + edges[k + 1] * duration,
            max_impacts=max_impacts,
        )
        lanes = follow_lanes(group.laws, group.which, group.starts, plan)
        peaks[:, k] = lanes.tallies[:, survey.PEAK_SPEED]
        if k == STRETCHES - 1:
            reasons, n_impacts = _reasons(lanes, plan), int(lanes.n_impacts.sum())
    middle = np.sqrt(edges[1:] * edges[:-1])
    exponents = np.full(n, np.nan)
    for i in range(n):
        hit = peaks[i] > 0.0
        exponents[i] = fit_power_law(middle[hit] * duration[i], peaks[i, hit]).exponent
        if np.isnan(exponents[i]):
            reasons.setdefault(i, "too few impacts to tell an exponent from")
    exponents[list(reasons)] = np.nan
    return exponents, reasons, n_impacts


# Measures whose lanes are followed for them alone.
OF_THEIR_OWN = {"largest_lyapunov_exponent": _lyapunov, "growth_exponent": _growth}
