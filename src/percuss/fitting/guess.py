"""The nodes of a record and their first states, from the samples around each.

A window of a few samples without an impact is a flight, whose two unknowns follow from linear
least squares, whichever quantity was measured. A large misfit shows that an impact lies in it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.fitting.effort import Effort
from percuss.fitting.measured import MeasuredRecord, MeasuredSamples
from percuss.fitting.shooting import Layout, shoot
from percuss.kernels.law_columns import FIRST_HARMONIC, N_HARMONICS, OMEGA
from percuss.kernels.segments import DISPLACEMENT, VELOCITY
from percuss.model.exact import as_float
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.paths import replace_parameters
from percuss.model.system import System

# A window turns the fastest part of the motion by this phase, in radians, if it holds so many
# samples.
WINDOW_PHASE = 0.8
FEWEST, MOST = 5, 60
# Samples of a window where nothing makes the motion turn.
FREE = 16
# A window that misses its samples by more than this, as a mean square, has an impact in it.
WORST = 2.5
# At least this share of all windows is taken, the best ones.
SHARE = 0.3
# Samples of the shortest window that begins with the first one.
FEWEST_FIRST = 3
# A link counts as no more than this many standard errors where states are tried.
MOST_OF_LINK = 100.0
# A record of impacts ends after the last one, by this part of half a flight.
LITTLE = 0.2
# From node to node, in parts of the distance that was asked for.
NEAREST, FARTHEST = 0.5, 1.25


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Stretches of a record as flights without stops.

    Attributes
    ----------
    begin, t
        (n,) arrays, the first sample of each and its middle.
    first_states, states
        (n, 2) arrays, x and v at these.
    misfits
        (n,) array, squares of the residuals in standard deviations, per degree of freedom.
    errors
        (n, 2) array, standard errors of the states.
    cycle
        The period of the fastest part of the motion, infinite without one.
    start
        (2,) array, x and v at the first sample.
    """

    begin: Floats
    t: Floats
    first_states: Floats
    states: Floats
    misfits: Floats
    errors: Floats
    cycle: float
    start: Floats

    def good(self) -> Windows:
        """Return those without an impact."""
        known = np.isfinite(self.states).all(axis=1) & np.isfinite(self.errors).all(axis=1)
        if not known.any():
            return self.taken(np.asarray(known))
        limit = max(WORST, float(np.quantile(self.misfits[known], SHARE)))
        return self.taken(np.asarray(known & (self.misfits <= limit)))

    def taken(self, rows: Flags) -> Windows:
        """Return some of them."""
        of_each = ("begin", "t", "first_states", "states", "misfits", "errors")
        return dataclasses.replace(self, **{name: getattr(self, name)[rows] for name in of_each})


def windows_of(osc: Oscillator, record: MeasuredRecord, values: Mapping[str, float]) -> Windows:
    """Return the windows of a record, as flights at a setting of the parameters.

    Parameters
    ----------
    osc
        The oscillator.
    record
        What was measured.
    values
        The parameters by their paths.

    Returns
    -------
    Windows
        Overlapping ones; of impact times the flights between them.
    """
    osc, force, _ = replace_parameters(osc, record.force, record.start, values)
    assert not isinstance(force, Loads)
    bare = dataclasses.replace(osc, stops=())
    law = System(bare, force).law
    rates = law[FIRST_HARMONIC : FIRST_HARMONIC + int(law[0, N_HARMONICS]), OMEGA].tolist()
    fastest = max([0.0, *rates, math.sqrt(abs(as_float(osc.of_unit_mass().stiffness)))])
    cycle = 2.0 * math.pi / fastest if fastest > 0.0 else math.inf
    samples = record.samples
    if len(samples) >= FEWEST:
        step = float(np.median(np.diff(samples.t))) or 1.0
        m = FEWEST
        if fastest > 0.0:
            m = max(FEWEST, min(MOST, int(min(WINDOW_PHASE / fastest / step, MOST)) + 1))
        m = min(m if fastest > 0.0 else FREE, len(samples))
        begin = np.arange(0, len(samples) - m + 1, max(1, m // 4))
    else:
        samples, m = _impacts_as_displacements(osc, record), 2
        begin = np.arange(max(len(samples) - 1, 0))
    rows = begin[:, None] + np.arange(m)
    chosen = samples.taken(rows.ravel())
    t = chosen.t.reshape(-1, m)
    middle = 0.5 * (t[:, 0] + t[:, -1])
    spans = np.stack([t[:, 0], middle], axis=1)
    first = np.arange(0, len(chosen) + 1, m)
    none = samples.taken(slice(0, 0))
    layout = Layout(MeasuredRecord(chosen, none, force, None), spans, first, False)
    shots = shoot(bare, (layout,), {}, np.zeros((len(begin), 2)))
    j = (shots.rows[:, 0] / chosen.noise[:, None]).reshape(-1, m, 2)
    r = ((chosen.values - shots.values[:, 0]) / chosen.noise).reshape(-1, m)
    if not j[..., 0].any() and (chosen.kinds == VELOCITY).any():
        j, r = _with_places(osc, samples, t[:, 0], j, r)
    at_first, covariance, misfits = _least_squares(j, r)
    to_end = shots.end_rows
    states = shots.ends + (to_end * at_first[:, None, :]).sum(axis=2)
    with np.errstate(invalid="ignore"):
        moved = (to_end[:, :, :, None] * covariance[:, None, :, :]).sum(axis=2)
        errors = np.sqrt((moved * to_end).sum(axis=2))
    start = _first_state(j[:1], r[:1])
    return Windows(t[:, 0], middle, at_first, states, misfits, errors, cycle, start)


def _with_places(
    osc: Oscillator, samples: MeasuredSamples, begin: Floats, j: Floats, r: Floats
) -> tuple[Floats, Floats]:
    """Return systems (n, m, 2) of windows with the place at the first sample as another value.

    Where no spring pulls velocities do not tell it. It is their integral, moved to where the motion
    turns at the stops.
    """
    of_velocity = samples.kinds == VELOCITY
    t, v = samples.t[of_velocity], samples.values[of_velocity]
    path = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    ends = {"above": float(path.max()), "below": float(path.min())}
    shifts = [as_float(stop.at) - ends[stop.side] for stop in osc.stops]
    places = np.interp(begin, t, path) + (sum(shifts) / len(shifts) if shifts else 0.0)
    # An impact between two samples moves it by no more than a usual step.
    error = float(np.median(np.diff(t))) * float(np.std(v)) or 1.0
    row = np.zeros((len(j), 1, 2))
    row[..., 0] = 1.0 / error
    return np.concatenate([row, j], axis=1), np.concatenate([places[:, None] / error, r], axis=1)


def _first_state(j: Floats, r: Floats) -> Floats:
    """Return x and v at the first sample, of the longest window from there that is a flight.

    An impact may come after few samples.
    """
    state = np.zeros(2)
    for m in range(min(FEWEST_FIRST, j.shape[1]), j.shape[1] + 1):
        solution, _, misfits = _least_squares(j[:, :m], r[:, :m])
        if not np.isfinite(solution).all() or (m > FEWEST_FIRST and misfits[0] > WORST):
            break
        state = solution[0]
    return state


def _impacts_as_displacements(osc: Oscillator, record: MeasuredRecord) -> MeasuredSamples:
    """Return impact times as samples of the displacement: the place of the first stop."""
    impacts = record.impacts
    place = as_float(osc.stops[0].at) if osc.stops else 0.0
    return MeasuredSamples(
        impacts.t,
        np.full(len(impacts), place),
        np.full(len(impacts), DISPLACEMENT, dtype=np.int64),
        np.full(len(impacts), 1e-3 * (abs(place) or 1.0)),
        impacts.is_estimated,
    )


def _least_squares(j: Floats, r: Floats) -> tuple[Floats, Floats, Floats]:
    """Solve (n, m, 2) systems of two unknowns; return solutions, covariances, misfits."""
    xx, xv, vv = ((j[..., a] * j[..., b]).sum(axis=1) for a, b in ((0, 0), (0, 1), (1, 1)))
    bx, bv = ((j[..., a] * r).sum(axis=1) for a in (0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        det = xx * vv - xv * xv
        solution = np.stack([vv * bx - xv * bv, xx * bv - xv * bx], axis=1) / det[:, None]
        covariance = np.stack([vv, -xv, -xv, xx], axis=1).reshape(-1, 2, 2) / det[:, None, None]
        rest = r - (j * solution[:, None, :]).sum(axis=2)
    return solution, covariance, (rest * rest).sum(axis=1) / max(j.shape[1] - 2, 1)


def extremes_of(windows: Windows) -> tuple[float, float]:
    """Return the least and the largest displacement of windows without an impact."""
    x = np.concatenate([windows.first_states[:, 0], windows.states[:, 0]])
    return float(x.min()), float(x.max())


def lay_out(
    osc: Oscillator,
    record: MeasuredRecord,
    windows: Windows,
    cycles: float,
) -> tuple[Layout, Floats]:
    """Return the nodes of a record, and their first states.

    Parameters
    ----------
    osc
        The oscillator, whose walls nodes keep away from.
    record
        What was measured.
    windows
        Its windows.
    cycles
        From node to node, in periods of the fastest part of the motion.

    Returns
    -------
    Layout and (n, 2) array
        One node, that at the start, where no window is known.
    """
    good = windows.good()
    is_fixed = record.start is not None
    if not len(record.samples):
        return _between_impacts(record, good)
    begin = record.begin
    if record.start is not None:
        begin = min(as_float(record.start.t0), begin)
    chosen = _chosen(osc, good, begin, record.end, cycles)
    t = np.concatenate([[begin], good.t[chosen]])
    first_state = np.zeros((1, 2)) if is_fixed else windows.start[None, :]
    states = np.concatenate([first_state, good.states[chosen]])
    ends = np.append(t[1:], record.end)
    spans = np.stack([t, ends], axis=1)
    first = np.searchsorted(record.samples.t, t, side="left")
    first[0] = 0
    return Layout(record, spans, np.append(first, len(record.samples)), is_fixed), states


def best_start(
    osc: Oscillator,
    layout: Layout,
    k: int,
    values: Mapping[str, float],
    states: Floats,
    scales: tuple[Floats, float],
    links: tuple[Floats | None, Floats | None],
    effort: Effort,
) -> tuple[Floats, Floats]:
    """Return the state of a node that fits its segment best, of several, and that at its end.

    Parameters
    ----------
    osc, layout, values
        The oscillator, the record's nodes, and the parameters.
    k
        The segment.
    states
        (n, 2) array, the states that are tried.
    scales
        Standard errors of a node, (2,) array, and the most that a residual counts.
    links
        Where the segment before ends, and the node after it; None where there is none.
    effort
        What this may cost.

    Returns
    -------
    tuple of arrays
        The state, and that at the segment's end.
    """
    some = layout.record.samples.taken(slice(int(layout.first[k]), int(layout.first[k + 1])))
    n, m = len(states), len(some)
    many = some.taken(np.tile(np.arange(m), n))
    spans = np.tile(layout.spans[k], (n, 1))
    record = dataclasses.replace(layout.record, samples=many)
    own = Layout(record, spans, np.arange(n + 1) * m, False)
    shots = shoot(osc, (own,), values, states, effort)
    residuals = ((many.values - shots.values[:, 0]) / many.noise).reshape(n, m)
    errors, most = scales
    costs = _capped(residuals, most)
    for state, wanted in ((states, links[0]), (shots.ends, links[1])):
        if wanted is not None:
            costs += _capped((state - wanted) / errors, MOST_OF_LINK)
    best = int(np.argmin(costs))
    return shots.nodes[best], shots.ends[best]


def _capped(residuals: Floats, most: float) -> Floats:
    """Return sums of squares along the last axis, none of them larger than the square of ``most``."""
    squares = np.square(np.where(np.isfinite(residuals), residuals, most))
    return np.asarray(np.minimum(squares, most * most).sum(axis=-1))


def _between_impacts(record: MeasuredRecord, good: Windows) -> tuple[Layout, Floats]:
    """Return nodes in the middle of all flights, where impact times alone were measured.

    Without a known start the motion begins at its first impact.
    """
    t, states, is_fixed = good.t, good.states, record.start is not None
    if record.start is not None:
        t = np.concatenate([[as_float(record.start.t0)], t])
        states = np.concatenate([np.zeros((1, 2)), states])
    else:
        later = slice(1, None)
        record = dataclasses.replace(record, impacts=record.impacts.taken(later))
    spans = np.stack([t, np.append(t[1:], record.end + LITTLE * (record.end - t[-1]))], axis=1)
    return Layout(record, spans, np.zeros(len(t) + 1, dtype=np.int64), is_fixed), states


def _chosen(osc: Oscillator, good: Windows, begin: float, end: float, cycles: float) -> list[int]:
    """Return the windows whose middles are nodes: in each stretch that farthest from the walls."""
    if not len(good.t):
        return []
    clearance = np.full(len(good.t), math.inf)
    for stop in osc.stops:
        if isinstance(stop, Wall):
            away = as_float(stop.at) - good.states[:, 0]
            clearance = np.minimum(clearance, away if stop.side == "above" else -away)
    if not np.isfinite(clearance).all():
        clearance = -good.misfits
    width = float(np.median(good.t - good.begin))
    length = max(cycles * good.cycle, 4.0 * width)
    if not length < math.inf:
        length = 8.0 * width
    chosen: list[int] = []
    last = begin
    # An impact soon after the start has a segment of its own.
    early = np.flatnonzero(good.t <= begin + NEAREST * length)
    if good.begin[0] > begin and len(early):
        chosen = [int(early[np.argmax(clearance[early])])]
        last = float(good.t[chosen[0]])
    while True:
        after = np.flatnonzero(good.t >= last + NEAREST * length)
        if not len(after):
            return chosen
        # Where there is no window for long, the next one that there is.
        until = max(last + FARTHEST * length, float(good.t[after[0]]))
        rows = after[good.t[after] <= until]
        best = int(rows[np.argmax(clearance[rows])])
        last = float(good.t[best])
        if last >= end:
            return chosen
        chosen.append(best)
