"""The states of the impact surface that lead to a grazing impact (zero normal velocity)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar, Literal, TypeAlias

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import backward as engine
from percuss.kernels import law_columns as at
from percuss.kernels.flight import constant_force
from percuss.kernels.law_columns import Law
from percuss.model.exact import as_float, real, whole
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, Wall, stops_in_words
from percuss.model.restitution import restitution_at_rest
from percuss.motion.tables import HasTable
from percuss.numerics import geometric, hypot
from percuss.orbits.orbit.itinerary import Entry, entry, row_of_region
from percuss.orbits.orbit.table_units import with_units
from percuss.orbits.surface.backward import BackwardMotions
from percuss.orbits.surface.grazing_intervals import grazing_intervals
from percuss.orbits.surface.maps import periodic_system
from percuss.pictures import HasPicture

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

CurveEnd: TypeAlias = Literal[
    "tangency",
    "zero_velocity",
    "no_acceleration",
    "longest",
    "no_restitution",
    "unresolved",
    "closed",
]

# Instants of grazes on an interval, before it is refined.
FIRST_POINTS = 512
# Between two instants nearer than this part of a period nothing is refined: a distance there is a
# jump, whose end is known to its square root, 1e-6.
FINEST = 1e-12
MOST_REFINEMENTS = 60
MOST_ITERATES = 1000
# An end with a velocity below this part of the largest one is at zero.
AT_ZERO = 1e-4


@dataclass(frozen=True, slots=True)
class CurveStretch:
    """One curve: states in a continuous row, by the instant of the graze that they lead to.

    Attributes
    ----------
    iterate
        Number of the impact before the graze, counted from 1.
    t, v
        (n,) arrays, instants [time] and velocities after the impact [length/time].
    graze
        (n,) array, instants of the grazes [time].
    n_between
        (n,) array, events between each state and its graze.
    begins, ends
        Why the curve begins and ends.
    """

    iterate: int
    t: Floats
    v: Floats
    graze: Floats
    n_between: Integers
    begins: CurveEnd
    ends: CurveEnd


@dataclass(slots=True)
class Tracer:
    """Follows grazes of one stop back to the impacts on the same or another one.

    Attributes
    ----------
    motions
        The oscillator's motions back in time.
    x
        Position of the grazed stop [length].
    grazed, stop
        Events of meeting the grazed stop and the stop of the impacts.
    n_hits
        Number of impacts of each motion.
    longest
        The longest time back [time].
    """

    motions: BackwardMotions
    x: float
    grazed: Entry
    stop: Entry
    n_hits: int
    longest: float

    def follow(self, graze: Floats) -> Floats:
        """Return (graze, status, then t, v, events of each hit) for each graze, one row each."""
        past = self.motions.follow(
            graze,
            self.x,
            np.zeros_like(graze),
            self.longest,
            region=self.motions.row(self.grazed.before),
            bound=self.stop.bound,
            sign=self.stop.sign,
            n_hits=self.n_hits,
        )
        hits = np.stack([past.t, past.v, past.n_between], axis=2).reshape(len(graze), -1)
        return np.column_stack([graze, past.status, hits])


def stretches(
    tracer: Tracer,
    interval: tuple[float, float],
    period: float,
    spacing: float,
    max_points: int,
) -> list[CurveStretch]:
    """Return the curves of the grazes in an interval of instants.

    Where neighbours are more distant than the spacing, or the motions have other events, one more
    graze is followed between them, until they are near enough or their instants are neighbours:
    there the curve has an end.

    Parameters
    ----------
    tracer
        Follows the grazes.
    interval
        Their first and last instant [time]; over a whole period the curve may close.
    period
        The forcing period [time].
    spacing
        Largest distance of neighbours, as a part of a period and of the largest velocity.
    max_points
        Grazes after which no more are followed: where motions back in time have no end, infinitely
        many curves accumulate.

    Returns
    -------
    list of CurveStretch
        Those of each iterate, by the instant of the graze.
    """
    low, high = interval
    whole = high - low >= period
    parts = np.linspace(0.0, 1.0, FIRST_POINTS + 1)
    if not whole:
        # The ends of the interval, where the acceleration of a graze vanishes, are refined first.
        fine = geometric(FINEST, 1.0 / FIRST_POINTS, 13)[:-1]
        parts = np.concatenate([fine, parts[1:-1], 1.0 - fine[::-1]])
    rows = tracer.follow(low + (high - low) * parts)
    scales = [_scale(rows, k) for k in range(tracer.n_hits)]
    for _ in range(MOST_REFINEMENTS):
        gaps = rows[1:, 0] - rows[:-1, 0]
        wide = np.zeros(len(gaps), dtype=np.bool_)
        for k, scale in enumerate(scales):
            wide |= _are_distant(rows, k, scale, period, spacing) | _differ_in_events(rows, k)
        wide &= gaps > FINEST * period
        if not wide.any() or len(rows) + wide.sum() > max_points:
            break
        middles = 0.5 * (rows[1:, 0] + rows[:-1, 0])[wide]
        rows = np.concatenate([rows, tracer.follow(middles)])
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
    curves: list[CurveStretch] = []
    for k, scale in enumerate(scales):
        cut = _are_distant(rows, k, scale, period, spacing)
        shifted = rows
        if whole and cut.any():
            # The first instant of a whole period is no end: the rows begin at a cut.
            shifted = _shifted(rows, int(np.flatnonzero(cut)[0]) + 1, period)
            cut = _are_distant(shifted, k, scale, period, spacing)
        curves += _split(shifted, k, cut, scale, FINEST * period, whole=whole)
    return curves


def _shifted(rows: Floats, first: int, period: float) -> Floats:
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


def _are_distant(rows: Floats, k: int, scale: float, period: float, spacing: float) -> Flags:
    """Return which neighbours are more distant than the spacing, or of different kinds."""
    t, v, _ = _columns(rows, k)
    known = np.isfinite(v)
    far = hypot(np.diff(t) / period, np.diff(v) / scale) > spacing
    return np.asarray(np.where(known[1:] & known[:-1], far, known[1:] != known[:-1]))


def _differ_in_events(rows: Floats, k: int) -> Flags:
    """Return between which neighbours an edge is grazed.

    The curve goes on there, but may turn so sharply that neighbours on both sides are near.
    """
    _, v, events = _columns(rows, k)
    known = np.isfinite(v)
    return np.asarray(known[1:] & known[:-1] & (events[1:] != events[:-1]))


def _split(
    rows: Floats, k: int, cut: Flags, scale: float, finest: float, *, whole: bool
) -> list[CurveStretch]:
    """Return the curves between the cuts."""
    t, v, events = _columns(rows, k)
    edges = [0, *(np.flatnonzero(cut) + 1).tolist(), len(rows)]
    curves = []
    for first, last in pairwise(edges):
        if not np.isfinite(v[first:last]).all() or last - first < 2:
            continue
        closed = whole and not cut.any()
        part = slice(first, last)
        begins, ends = (
            "closed" if closed else _reason(rows, v, pair, scale, finest, whole=whole)
            for pair in ((first, first - 1), (last - 1, last))
        )
        between = events[part].astype(np.int64)
        curves.append(CurveStretch(k + 1, t[part], v[part], rows[part, 0], between, begins, ends))
    return curves


def _reason(
    rows: Floats, v: Floats, ends: tuple[int, int], scale: float, finest: float, *, whole: bool
) -> CurveEnd:
    """Return why a curve ends at the first of two rows, beyond which lies the second, or none."""
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


# Forcing periods, or natural ones, over which a graze is followed back.
LONGEST = 20.0


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class SingularityCurve:
    """One curve of a singularity set: states by the instant of the graze that they lead to.

    Attributes
    ----------
    touched
        Index of the stop that is grazed.
    iterate
        n: the graze is the n-th next impact on the set's own stop, or, on another stop, lies
        between the (n - 1)-th and the n-th.
    cycle
        (n,) array, continuous along the curve; the first lies in [0, 1), others may leave it.
    v_after
        (n,) array, velocities after the impact, or into the soft stop [length/time].
    touch_cycle
        (n,) array, cycle of the graze, continuous; not less than that of the state.
    duration
        (n,) array, time from the state to the graze [time].
    n_between
        (n,) array, events between the state and the graze: impacts and crossings of edges.
    begins, ends
        Why the curve begins and ends there. "tangency": the motion grazes a second time;
        "zero_velocity": the impact is a graze itself; "no_acceleration": the force at the graze
        vanishes; "longest": the motion back in time is cut off; "no_restitution": it leads to an
        impact that leaves no velocity; "unresolved": `max_points` was too few; "closed": the curve
        returns to its first point.
    """

    touched: int
    iterate: int
    cycle: Floats
    v_after: Floats
    touch_cycle: Floats
    duration: Floats
    n_between: Integers
    begins: CurveEnd
    ends: CurveEnd

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.cycle)

    def __repr__(self) -> str:
        """Return the curve in a line."""
        return (
            f"<SingularityCurve: {len(self)} points, iterate {self.iterate}, touches stop "
            f"{self.touched}; begins at {self.begins}, ends at {self.ends}>"
        )


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class SingularitySet(HasPicture, HasTable):
    """Curves in the impact surface on which an impact map is singular; see `singularity_set`.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    stop
        Index of the stop whose impact surface it is.
    curves
        The curves.
    """

    picture: ClassVar = "plot_singularity_set"

    oscillator: Oscillator
    forcing: Forcing
    stop: int
    curves: tuple[SingularityCurve, ...] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of curves."""
        return len(self.curves)

    def __iter__(self) -> Iterator[SingularityCurve]:
        """Iterate over the curves."""
        return iter(self.curves)

    def __getitem__(self, i: int) -> SingularityCurve:
        """Return a curve."""
        return self.curves[i]

    def __repr__(self) -> str:
        """Return the set in a line."""
        points = sum(len(curve) for curve in self.curves)
        return f"<SingularitySet of stop {self.stop}: {len(self)} curves, {points} points>"

    def to_xarray(self) -> Dataset:
        """Return all points as one dataset, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            Along ``point``, with the number of the curve; quantities of whole curves along
            ``curve``.

        Examples
        --------
        >>> import percuss as pc
        >>> singular = pc.singularity_set(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> list(singular.to_xarray().sizes)
        ['point', 'curve']
        """
        import xarray

        def along(name: str) -> Floats:
            parts = [getattr(curve, name) for curve in self.curves]
            return np.concatenate(parts) if parts else np.empty(0)

        sizes = [len(curve) for curve in self.curves]
        names = ("cycle", "v_after", "touch_cycle", "duration", "n_between")
        curves: dict[str, tuple[str, object]] = {
            name: ("curve", np.array([getattr(curve, name) for curve in self.curves], dtype=kind))
            for name, kind in (("touched", int), ("iterate", int), ("begins", str), ("ends", str))
        }
        points = {name: ("point", along(name)) for name in names}
        number = {"number": ("point", np.repeat(np.arange(len(sizes)), sizes))}
        table = xarray.Dataset({**points, **number, **curves}, attrs={"stop": self.stop})
        return with_units(table, self)


def singularity_set(
    osc: Oscillator,
    force: Forcing,
    stop: int = 0,
    *,
    n_iterates: int = 1,
    touched: int | None = None,
    spacing: float = 0.005,
    longest: float | None = None,
    max_points: int = 20_000,
) -> SingularitySet:
    """Return the states of an impact surface that lead to a grazing impact (zero velocity).

    There the impact map jumps, and has a square root on one side. Each graze, at any instant at
    which the force leads the mass off the stop, or back into a soft stop whose edge it grazes from
    inside, is followed back in closed form to the impacts before it, the first of which is the
    state; no event of the motion back is missed. So a curve has no false parts. It ends where its
    motion grazes twice.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period.
    stop
        Index of the stop of the impact surface (cycle, v_after).
    n_iterates
        Grazes at up to the n-th next impact on that stop, >= 1.
    touched
        Index of the stop that is grazed; default: the stop itself, and any wall.
    spacing
        Largest distance of neighbouring points, with a cycle and the largest velocity as units,
        > 0. Pieces of a curve whose grazes all lie within 1/512 of a period may be missed.
    longest
        The longest time that a graze is followed back [time]; default: 20 forcing periods, or
        natural ones where these are longer.
    max_points
        Grazes of one stop after which no more are followed. Where motions back in time have no
        end, infinitely many curves accumulate; those that are too fine end "unresolved".

    Returns
    -------
    SingularitySet
        Its curves.

    Raises
    ------
    ParameterError
        If there is no such stop, the forcing has no period, a number is out of its range, or
        more than one iterate is asked for at a wall without restitution, where the velocity
        before an impact is unknown.

    Notes
    -----
    Singularity sets and what they do to attractors: Budd & Dux (1994), Phil. Trans. R. Soc. A
    347, 365. docs/theory/impact-surface.md explains the motion back in time.

    Examples
    --------
    The motion from a state of the set reaches the wall without velocity:

    >>> import percuss as pc
    >>> singular = pc.singularity_set(pc.impact_oscillator(0.8), pc.cosine(2.5))
    >>> curve = singular[0]
    >>> v = float(curve.v_after[50])
    >>> run = pc.simulate(singular.oscillator, singular.forcing, x0=0.0, v0=v,
    ...                   t0=float(curve.cycle[50]) * singular.forcing.period, t_end=20.0)
    >>> x, speed = run(run.t0 + float(curve.duration[50]))
    >>> bool(abs(x) < 1e-12), bool(abs(speed) < 1e-12)
    (True, True)
    """
    system = periodic_system(osc, force, "a singularity set")
    stop, n_iterates = whole("stop", stop, 0), whole("n_iterates", n_iterates, 1, MOST_ITERATES)
    spacing = real("spacing", spacing)
    longest = None if longest is None else real("longest", longest)
    max_points = whole("max_points", max_points, 1)
    met_stop = entry(osc, stop)
    if touched is not None:
        touched = whole("touched", touched, 0)
        if touched >= len(osc.stops):
            raise ParameterError("touched", touched, stops_in_words(osc))
    _check(osc, stop, n_iterates, spacing, longest)
    motions = BackwardMotions(system)
    period = float(motions.law[0, at.PERIOD])
    if longest is None:
        longest = LONGEST * max(period, _natural_period(motions.law))
    grazed = [k for k, other in enumerate(osc.stops) if isinstance(other, Wall) or k == stop]
    curves: list[SingularityCurve] = []
    for k in grazed if touched is None else [touched]:
        x = as_float(osc.stops[k].at)
        for met in _sides(osc, k):
            tracer = Tracer(motions, x, met, met_stop, n_iterates, longest)
            constant = constant_force(motions.law, row_of_region(motions.law, met.before), x)
            for interval in grazing_intervals(motions.law, constant, -met.sign):
                parts = stretches(tracer, interval, period, spacing, max_points)
                curves += [_curve(k, part, period) for part in parts]
    curves.sort(key=lambda curve: (curve.iterate, curve.touched))
    return SingularitySet(osc, force, stop, tuple(curves))


def _sides(osc: Oscillator, stop: int) -> list[Entry]:
    """Return the events of grazing a stop: from its free side, and a soft one from inside."""
    met = entry(osc, stop)
    if isinstance(osc.stops[stop], Wall):
        return [met]
    return [met, replace(met, before=met.after, after=met.before, sign=-met.sign)]


def _check(
    osc: Oscillator, stop: int, n_iterates: int, spacing: float, longest: float | None
) -> None:
    if not spacing > 0.0:
        raise ParameterError("spacing", spacing, "not positive")
    if longest is not None and not longest > 0.0:
        raise ParameterError("longest", longest, "not a finite positive time")
    wall = osc.stops[stop]
    if n_iterates > 1 and isinstance(wall, Wall) and restitution_at_rest(wall.restitution) == 0.0:
        reason = "with restitution 0 nothing tells what came before an impact; at most 1"
        raise ParameterError("n_iterates", n_iterates, reason)


def _natural_period(law: Law) -> float:
    """Return the longest period of free motion in a region; 0 if none oscillates."""
    longest = 0.0
    for number in range(int(law[0, at.N_REGIONS])):
        row = row_of_region(law, number)
        if law[row, at.OVERDAMPED] == 0.0 and law[row, at.RATE] > 0.0:
            longest = max(longest, 2.0 * math.pi / float(law[row, at.RATE]))
    return longest


def _curve(touched: int, stretch: CurveStretch, period: float) -> SingularityCurve:
    whole = math.floor(stretch.t[0] / period)
    return SingularityCurve(
        touched=touched,
        iterate=stretch.iterate,
        cycle=stretch.t / period - whole,
        v_after=stretch.v,
        touch_cycle=stretch.graze / period - whole,
        duration=stretch.graze - stretch.t,
        n_between=stretch.n_between,
        begins=stretch.begins,
        ends=stretch.ends,
    )
