"""The curves of states that lead to a touch, traced along the instant of the touch."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.kernels import backward as engine
from percuss.numerics import geometric, hypot
from percuss.orbits.orbit.chain import Entry
from percuss.orbits.surface.backward import BackwardMotions

__all__ = ["CurveEnd", "Stretch", "Tracer", "stretches"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
CurveEnd: TypeAlias = Literal[
    "tangency",
    "zero_velocity",
    "no_acceleration",
    "longest",
    "no_restitution",
    "unresolved",
    "closed",
]

# Instants of touches on an interval, before it is refined.
FIRST_POINTS = 512
# Two instants nearer than this part of a period are neighbours for good: what lies apart there
# is a jump, whose end is known to its square root, 1e-6.
FINEST = 1e-12
MOST_ROUNDS = 60
# An end with a velocity below this part of the largest one is at zero.
AT_ZERO = 1e-4


@dataclass(frozen=True, slots=True)
class Stretch:
    """One curve: states in a continuous row, along the touch that they lead to.

    Attributes
    ----------
    iterate
        Which impact before the touch they are, counted from 1.
    t, v
        (n,) arrays, instants [time] and velocities after the impact [length/time].
    touch
        (n,) array, instants of the touches [time].
    n_between
        (n,) array, events between each state and its touch.
    begins, ends
        Why there.
    """

    iterate: int
    t: Floats
    v: Floats
    touch: Floats
    n_between: Numbers
    begins: CurveEnd
    ends: CurveEnd


@dataclass(slots=True)
class Tracer:
    """Follows touches of one stop back to the impacts on another one, or on the same.

    Attributes
    ----------
    motions
        The oscillator's motions back in time.
    place
        Position of the touched stop.
    touched, stop
        Events of meeting the touched stop and the one whose impacts are looked for.
    n_hits
        How many impacts of each motion.
    longest
        How far back [time].
    """

    motions: BackwardMotions
    place: float
    touched: Entry
    stop: Entry
    n_hits: int
    longest: float

    def follow(self, touch: Floats) -> Floats:
        """Return (touch, status, then t, v, events of each hit) for each touch, one row each."""
        past = self.motions.follow(
            touch,
            self.place,
            np.zeros_like(touch),
            self.longest,
            region=self.motions.row(self.touched.before),
            bound=self.stop.bound,
            way=self.stop.way,
            n_hits=self.n_hits,
        )
        hits = np.stack([past.t, past.v, past.n_between], axis=2).reshape(len(touch), -1)
        return np.column_stack([touch, past.status, hits])


def stretches(
    tracer: Tracer,
    interval: tuple[float, float],
    period: float,
    spacing: float,
    max_points: int,
) -> list[Stretch]:
    """Return the curves of the touches in an interval of instants.

    Where neighbours lie apart by more than the spacing, one more touch is followed between them,
    until they lie near enough or their instants do: then the curve has an end.

    Parameters
    ----------
    tracer
        Follows the touches.
    interval
        Their first and last instant [time]; over a whole period the curve may close.
    period
        The forcing period [time].
    spacing
        Largest distance of neighbours, as a part of a period and of the largest velocity.
    max_points
        Touches after which no more are followed: where the way back is as long as one likes,
        curves without number accumulate.

    Returns
    -------
    list of Stretch
        Those of each iterate, along the touch.
    """
    low, high = interval
    whole = high - low >= period
    parts = np.linspace(0.0, 1.0, FIRST_POINTS + 1)
    if not whole:
        # Ends of the interval, where touches lose their acceleration, are looked at closely.
        fine = geometric(FINEST, 1.0 / FIRST_POINTS, 13)[:-1]
        parts = np.concatenate([fine, parts[1:-1], 1.0 - fine[::-1]])
    rows = tracer.follow(low + (high - low) * parts)
    scales = [_scale(rows, k) for k in range(tracer.n_hits)]
    for _ in range(MOST_ROUNDS):
        gaps = rows[1:, 0] - rows[:-1, 0]
        wide = np.zeros(len(gaps), dtype=np.bool_)
        for k, scale in enumerate(scales):
            wide |= _apart(rows, k, scale, period, spacing)
        wide &= gaps > FINEST * period
        if not wide.any() or len(rows) + wide.sum() > max_points:
            break
        middles = 0.5 * (rows[1:, 0] + rows[:-1, 0])[wide]
        rows = np.concatenate([rows, tracer.follow(middles)])
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
    found: list[Stretch] = []
    for k, scale in enumerate(scales):
        cut = _apart(rows, k, scale, period, spacing)
        turned = rows
        if whole and cut.any():
            # Begin at a cut: the first instant of a whole period is no end.
            turned = _turned(rows, int(np.flatnonzero(cut)[0]) + 1, period)
            cut = _apart(turned, k, scale, period, spacing)
        found += _split(turned, k, cut, scale, FINEST * period, whole=whole)
    return found


def _turned(rows: Floats, first: int, period: float) -> Floats:
    """Return the rows of a whole period from a row on; the last one is the first, later."""
    later = rows[1:first].copy()
    later[:, [0, *range(2, rows.shape[1], 3)]] += period
    return np.concatenate([rows[first:], later])


def _columns(rows: Floats, k: int) -> tuple[Floats, Floats, Floats]:
    t, v, events = rows[:, 2 + 3 * k], rows[:, 3 + 3 * k], rows[:, 4 + 3 * k]
    return t, v, events


def _scale(rows: Floats, k: int) -> float:
    speeds = np.abs(_columns(rows, k)[1])
    known = speeds[np.isfinite(speeds)]
    return float(known.max()) if known.size and known.max() > 0.0 else 1.0


def _apart(rows: Floats, k: int, scale: float, period: float, spacing: float) -> NDArray[np.bool_]:
    """Tell which neighbours lie apart, or are of different kinds."""
    t, v, _ = _columns(rows, k)
    known = np.isfinite(v)
    far = hypot(np.diff(t) / period, np.diff(v) / scale) > spacing
    return np.asarray(np.where(known[1:] & known[:-1], far, known[1:] != known[:-1]))


def _split(
    rows: Floats, k: int, cut: NDArray[np.bool_], scale: float, finest: float, *, whole: bool
) -> list[Stretch]:
    """Return the curves between the cuts."""
    t, v, events = _columns(rows, k)
    edges = [0, *(np.flatnonzero(cut) + 1).tolist(), len(rows)]
    found = []
    for first, last in pairwise(edges):
        if not np.isfinite(v[first:last]).all() or last - first < 2:
            continue
        closed = whole and not cut.any()
        part = slice(first, last)
        found.append(
            Stretch(
                iterate=k + 1,
                t=t[part],
                v=v[part],
                touch=rows[part, 0],
                n_between=events[part].astype(np.int64),
                begins="closed"
                if closed
                else _reason(rows, v, (first, first - 1), scale, finest, whole=whole),
                ends="closed"
                if closed
                else _reason(rows, v, (last - 1, last), scale, finest, whole=whole),
            )
        )
    return found


def _reason(
    rows: Floats, v: Floats, ends: tuple[int, int], scale: float, finest: float, *, whole: bool
) -> CurveEnd:
    """Tell why a curve ends at the first of two rows, beyond which is the second, or none."""
    last, beyond = ends
    if abs(v[last]) < AT_ZERO * scale:
        return "zero_velocity"
    if not 0 <= beyond < len(rows):
        return "tangency" if whole else "no_acceleration"
    if abs(rows[last, 0] - rows[beyond, 0]) > finest:
        return "unresolved"
    if np.isnan(v[beyond]):
        if rows[beyond, 1] == engine.AT_TIME:
            return "longest"
        if rows[beyond, 1] == engine.NO_RESTITUTION:
            return "no_restitution"
    return "tangency"
