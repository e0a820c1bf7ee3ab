"""A run as points dense enough to draw, and few enough to look at."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.model.exact import as_float
from percuss.model.oscillator import SoftStop
from percuss.plotting.direction_view import DirectionView, Drawable

# A chord of 1/64 of a cycle stays within 0.12 % of the amplitude of its arc.
POINTS_PER_CYCLE = 64
FEWEST_POINTS, MOST_POINTS = 33, 4097
# More are evaluated only for their extremes; above this the pieces get fewer points each.
BUDGET = 1_000_000
# Above this a curve is reduced to what can be seen.
DRAWN_POINTS = 20_000
# Larger numbers are not drawn: a picture's arithmetic would overflow.
LARGEST = 1e150
# More dashed jumps than this would be a solid block.
MOST_JUMPS = 2000
# About one column for every pixel of an axes 7 inches wide at 200 dots per inch.
COLUMNS = 1500
# Dots a fortieth of an inch across, of which more lie on one another than beside one another.
MOST_DOTS = 20_000
DOT_COLUMNS = 500


def window_of(run: Drawable, window: tuple[float, float] | None) -> tuple[float, float]:
    """Return the first and the last time of a run in a window; by default of the whole run.

    Raises
    ------
    ParameterError
        If the window is no pair of increasing times, or lies outside the run.
    """
    if window is None:
        return run.t0, run.t_end
    if np.shape(window) != (2,):
        raise ParameterError("window", window, "not a pair of times (first, last)")
    first, last = (as_float(time) for time in window)
    if (first, last) == (run.t0, run.t_end):
        # One that was interrupted before its first step has no length.
        return first, last
    if first >= last:
        raise ParameterError("window", window, "the first time is not before the last")
    if first >= run.t_end or last <= run.t0:
        reason = f"outside the run, {run.t0!r} to {run.t_end!r}"
        raise ParameterError("window", window, reason)
    return max(first, run.t0), min(last, run.t_end)


def within(t: Floats, low: float, high: float) -> Flags:
    """Return which of the times lie in [low, high]."""
    return np.asarray((t >= low) & (t <= high), dtype=np.bool_)


@dataclass(frozen=True, slots=True)
class SampledMotion:
    """Points of a motion in the order of time; both limits at an impact.

    ``jumps`` is true where the velocity jumps between a point and the next.
    """

    t: Floats
    x: Floats
    v: Floats
    jumps: Flags


def sample_curve(run: Drawable, window: tuple[float, float] | None = None) -> SampledMotion:
    """Evaluate a run between its events and on both sides of each impact.

    There are at least 64 points a cycle of the fastest part of the motion, 33 between two events;
    fewer where these would be more than a million.
    """
    cuts = _cuts(run, *window_of(run, window))
    return _sampled(run, cuts[:-1], cuts[1:], _counts(run, cuts))


def sample_in_full(run: Drawable, window: tuple[float, float] | None = None) -> SampledMotion:
    """Evaluate a run so densely that each chord is true, however long it is.

    Where more than a million points were needed there are stretches of a cycle: half of them those
    that the run begins with, half spread evenly over it. What lies between two is marked as a jump.
    """
    cuts = _cuts(run, *window_of(run, window))
    counts = np.maximum(_cycles(run, cuts) * POINTS_PER_CYCLE + 1.0, FEWEST_POINTS)
    if counts.sum() > BUDGET:
        # Samples of a record are far closer than the motion is quick.
        slow = _cycles(run, cuts, of_record=False) * POINTS_PER_CYCLE + 1.0
        counts = np.maximum(slow, np.minimum(counts, MOST_POINTS))
    if counts.sum() <= BUDGET:
        return _sampled(run, cuts[:-1], cuts[1:], np.ceil(counts).astype(np.int64))
    parts = np.ceil((counts - 1.0) / POINTS_PER_CYCLE)
    until = np.cumsum(parts)
    half = BUDGET // (2 * POINTS_PER_CYCLE + 2)
    spread = np.floor(np.linspace(0.0, until[-1] - 1.0, half))
    chosen = np.unique(np.concatenate([np.arange(half, dtype=np.float64), spread]))
    piece = np.searchsorted(until, chosen, side="right")
    place = chosen - (until[piece] - parts[piece])
    length = np.diff(cuts)[piece] / parts[piece]
    first = cuts[piece] + place * length
    is_last = place + 1.0 == parts[piece]
    last = np.where(is_last, cuts[piece + 1], cuts[piece] + (place + 1.0) * length)
    points = np.ceil((counts - 1.0) / parts).astype(np.int64) + 1
    return _sampled(run, first, last, points[piece])


def _sampled(run: Drawable, first: Floats, last: Floats, counts: Integers) -> SampledMotion:
    """Evaluate a run on stretches, with so many points on each; what lies between two is a jump."""
    t, ends = _spread(first, last, counts)
    if counts.size == 0:
        t, ends = np.array([run.t0]), np.zeros(1, dtype=np.int64)
    x, v = (np.array(values, dtype=np.float64) for values in run(t))
    x[ends], v[ends] = run(t[ends], limit="before")
    jumps = np.zeros(t.size, dtype=np.bool_)
    jumps[ends] = np.isin(t[ends], run.impacts.t)
    jumps[ends[:-1]] |= first[1:] != last[:-1]
    # After the last point nothing follows, not even a jump.
    jumps[-1] = False
    shown = (np.abs(x) < LARGEST) & (np.abs(v) < LARGEST)
    shown[0] = True
    x, v = (np.clip(values[shown], -LARGEST, LARGEST) for values in (x, v))
    return SampledMotion(t[shown], x, v, jumps[shown])


def _cuts(run: Drawable, low: float, high: float) -> Floats:
    """Return the ends of the smooth pieces of the motion in [low, high]."""
    release = run.contacts.release
    times = np.concatenate(
        [run.impacts.t, run.crossings.t, run.contacts.start, release[np.isfinite(release)]]
    )
    return np.unique(np.concatenate([[low], times[within(times, low, high)], [high]]))


def _counts(run: Drawable, cuts: Floats) -> Integers:
    """Return how many points each piece between two cuts gets."""
    cycles = _cycles(run, cuts)
    counts = np.clip(np.ceil(cycles * POINTS_PER_CYCLE) + 1, FEWEST_POINTS, MOST_POINTS)
    if counts.sum() > BUDGET:
        counts = np.clip(counts * (BUDGET / counts.sum()), 5, None)
    return np.asarray(counts, dtype=np.int64)


def _cycles(run: Drawable, cuts: Floats, *, of_record: bool = True) -> Floats:
    """Return the cycles of the fastest part in each piece between two cuts."""
    cycles = np.diff(cuts) * _frequencies(run, cuts, of_record=of_record) / (2.0 * math.pi)
    return np.asarray(cycles)


def _frequencies(run: Drawable, cuts: Floats, *, of_record: bool) -> Floats:
    """Return the highest angular frequency in each piece: of the forcing or of the springs."""
    if isinstance(run, DirectionView):
        return np.full(cuts.size - 1, run.frequency())
    middle, _ = run(0.5 * (cuts[:-1] + cuts[1:]))
    oscillator = run.oscillator.of_unit_mass()
    stiffness = np.full(cuts.size - 1, as_float(oscillator.stiffness))
    for stop in oscillator.stops:
        if isinstance(stop, SoftStop):
            at = as_float(stop.at)
            beyond = middle < at if stop.side == "below" else middle > at
            stiffness[beyond] += as_float(stop.stiffness)
    harmonics = () if run.forcing is None else run.forcing.components()
    fastest = max((float(harmonic.omega) for harmonic in harmonics), default=0.0)
    if of_record and run.forcing is not None and run.forcing.record is not None:
        fastest = max(fastest, math.pi * run.forcing.record.rate)
    return np.asarray(np.maximum(np.sqrt(np.abs(stiffness)), fastest))


def _spread(first: Floats, last: Floats, counts: Integers) -> tuple[Floats, Integers]:
    """Return equally spaced times in each stretch, its ends included, and where each ends."""
    ends = np.cumsum(counts) - 1
    place = np.arange(counts.sum()) - np.repeat(ends - counts + 1, counts)
    share = place / np.repeat(counts - 1, counts)
    t = np.repeat(first, counts) + share * np.repeat(last - first, counts)
    t[ends] = last
    return t, ends


def separated(values: Floats, jumps: Flags) -> Floats:
    """Return values with a NaN at each jump, so that no line is drawn across it."""
    return np.insert(values, np.flatnonzero(jumps) + 1, np.nan)


def reduce_to_columns(
    t: Floats,
    values: Floats,
    jumps: Flags,
    *,
    columns: int | None = None,
    most: int | None = None,
) -> tuple[Floats, Floats, Flags]:
    """Return the least and the greatest point of every pixel column, for a curve over time.

    Parameters
    ----------
    t, values, jumps
        (n,) arrays, t increasing; `jumps` as in `SampledMotion`: columns are cut there, too.
    columns
        Number of columns of the picture; default: 1500.
    most
        Number of points up to which a curve is left as it is; default: 20,000.

    Returns
    -------
    tuple of array
        Times, values and jumps of the points that are left, in the order of time; the drawn curve
        is the same to one pixel.
    """
    # Defaults are looked up at the call: tests make them smaller.
    most = DRAWN_POINTS if most is None else most
    columns = COLUMNS if columns is None else columns
    if t.size <= most:
        return t, values, jumps
    column = np.floor((t - t[0]) * (columns / (t[-1] - t[0]))).astype(np.int64)
    stretch = np.concatenate([[0], np.cumsum(jumps[:-1])])
    starts = np.flatnonzero(np.diff(column, prepend=-1) | np.diff(stretch, prepend=-1))
    cell = np.repeat(np.arange(starts.size), np.diff(starts, append=t.size))
    kept = np.unique(
        np.concatenate(
            [_firsts(values, cell, of.reduceat(values, starts)) for of in (np.minimum, np.maximum)]
        )
    )
    left = np.zeros(kept.size, dtype=np.bool_)
    left[:-1] = stretch[kept[1:]] != stretch[kept[:-1]]
    return t[kept], values[kept], left


def _firsts(values: Floats, cell: Integers, wanted: Floats) -> Integers:
    """Return the index of the first value in each cell that is the one wanted there."""
    equal = np.flatnonzero(values == wanted[cell])
    return equal[np.diff(cell[equal], prepend=-1) > 0]


def reduce_to_pixels(curve: SampledMotion) -> tuple[Floats, Floats]:
    """Return the displacements and velocities of a phase portrait, less what lies on other parts.

    A NaN stands between parts that are not joined. Of the chords that start in one pixel and end
    in one pixel only the first is left; a curve of at most 20,000 points keeps all.
    """
    if curve.t.size <= DRAWN_POINTS:
        return separated(curve.x, curve.jumps), separated(curve.v, curve.jumps)
    pixel = _pixels(curve.x) * COLUMNS + _pixels(curve.v)
    chords = np.flatnonzero(~curve.jumps[:-1])
    codes = pixel[chords] * COLUMNS**2 + pixel[chords + 1]
    first = chords[np.sort(np.unique(codes, return_index=True)[1])]
    is_last = np.append(np.diff(first) > 1, True)
    kept = np.insert(first, np.flatnonzero(is_last) + 1, first[is_last] + 1)
    ends = np.zeros(kept.size, dtype=np.bool_)
    ends[np.flatnonzero(is_last) + np.arange(1, is_last.sum() + 1)] = True
    return separated(curve.x[kept], ends), separated(curve.v[kept], ends)


def distinct_jumps(places: Floats, before: Floats, after: Floats) -> Integers:
    """Return the indices of the jumps at impacts to draw in a phase portrait, of (n,) arrays.

    These are all of up to 2,000 jumps; of more, those no two of which share their pixels.
    """
    if places.size <= MOST_JUMPS:
        return np.arange(places.size)
    stop = np.unique(places, return_inverse=True)[1]
    # On one scale: on its own, each would be distinct down to its rounding.
    ends = _pixels(np.concatenate([before, after]))
    codes = (stop * COLUMNS + ends[: before.size]) * COLUMNS + ends[before.size :]
    return np.sort(np.unique(codes, return_index=True)[1])


def topmost(x: Floats, y: Floats) -> Integers:
    """Return the indices of the dots at (x, y) that are seen, each drawn over those before it.

    These are all of up to 20,000 dots; of more, the last one in each of 500 x 500 cells, half a
    dot wide.
    """
    if x.size <= MOST_DOTS:
        return np.arange(x.size)
    cells = _pixels(x, DOT_COLUMNS) * DOT_COLUMNS + _pixels(y, DOT_COLUMNS)
    return np.sort(x.size - 1 - np.unique(cells[::-1], return_index=True)[1])


def distinct_spans(first: Floats, last: Floats, places: Floats, width: float) -> Integers:
    """Return the indices of the spans of time to draw in a picture that is `width` of time wide.

    A span is drawn from `first` to `last` at the height `places`. These are all of up to 2,000
    spans; of more, those longer than a pixel, and the first of the others in each pixel column.
    """
    if first.size <= MOST_JUMPS:
        return np.arange(first.size)
    column = np.floor((first - first.min()) * (COLUMNS / width)).astype(np.int64)
    cells = np.unique(places, return_inverse=True)[1] * (COLUMNS + 1) + column
    shown = last - first > width / COLUMNS
    shown[np.unique(cells, return_index=True)[1]] = True
    return np.flatnonzero(shown)


def _pixels(values: Floats, columns: int | None = None) -> Integers:
    """Return the pixel, from 0 to columns - 1, of each value."""
    columns = COLUMNS if columns is None else columns
    low, high = values.min(), values.max()
    if high <= low:
        return np.zeros(values.size, dtype=np.int64)
    share = (values - low) / (high - low)
    return np.asarray(np.minimum(share * columns, columns - 1), dtype=np.int64)
