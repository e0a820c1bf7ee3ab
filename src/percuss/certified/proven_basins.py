"""Basins of attraction whose cells are proven, all starts of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from dataclasses import dataclass, field
from fractions import Fraction
from multiprocessing import get_context
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import arb

from percuss.arrays import Floats, Integers
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.certify import certify
from percuss.certified.cloud import Cloud
from percuss.certified.numbers import between, exact_range, largest_abs, precision
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.pieces import Moment
from percuss.certified.set_flight import SlowEvents, next_passage, search_set
from percuss.certified.shooting import region_of_row
from percuss.certified.step import (
    Departure,
    began,
    flight_of,
    levels_of,
    never_reaches,
    state_in_flight,
    width_of,
)
from percuss.certified.system import BallSystem, system_of
from percuss.certified.trapping import Trap, traps_about
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, real, whole
from percuss.model.force_record import refuse_record
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    from xarray import Dataset

BITS = 64
# Labels of cells that are open, and of those beyond a wall.
OPEN, NO_START = -1, -2
# Stretches of flights shorter than this part of the time by which starts of a cell differ are not
# tried.
SHORTEST = 2.0**-8
# Forcing periods in which the next event is looked for, at once and in all.
LOOKED_FOR, MOST_PERIODS = 2, 60
# How far a flight without events is followed, as a part of the time in which it is known to have
# none.
WITHIN = 0.99
# Points of the outline of a set in which motions stay.
OUTLINE = 61
# How long other processes are waited for before progress is reported [s].
WAITED = 0.2


class _Cell(NamedTuple):
    """A rectangle of starts (x, v); its floats are exact numbers."""

    x_low: float
    x_high: float
    v_low: float
    v_high: float

    def quarters(self) -> list[_Cell]:
        x, v = 0.5 * (self.x_low + self.x_high), 0.5 * (self.v_low + self.v_high)
        return [
            _Cell(*xs, *vs)
            for xs in ((self.x_low, x), (x, self.x_high))
            for vs in ((self.v_low, v), (v, self.v_high))
        ]

    @property
    def area(self) -> float:
        return (self.x_high - self.x_low) * (self.v_high - self.v_low)


class _Row(NamedTuple):
    """What is proven of a row of cells: labels, areas of each label, and proven parts of open cells."""

    labels: list[int]
    areas: dict[int, float]
    parts: list[tuple[int, _Cell]]


@dataclass(frozen=True)
class _Fates:
    """Where the motions from cells settle.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    t0
        Time of all starts.
    traps
        Sets about the impacts of attractors, and the number of the attractor of each.
    steady
        Numbers of the regions in which a steady motion attracts, and the number of that attractor.
    depth
        How often a cell that is open is divided into four.
    most_impacts
        Events that are followed.
    """

    oscillator: Oscillator
    forcing: Forcing
    t0: Phase
    traps: tuple[tuple[Trap, int], ...]
    steady: tuple[tuple[int, int], ...]
    depth: int
    most_impacts: int

    def row(self, cells: Sequence[_Cell], go_on: Callable[[], bool] = lambda: True) -> _Row:
        """Return the labels of cells, and what is proven of parts of those that are open.

        All are open that are left when ``go_on``, asked before each, is False.
        """
        system = system_of(self.oscillator, self.forcing)
        row = _Row([], {}, [])
        with precision(BITS):
            for cell in cells:
                parts = list(self._parts(system, cell, self.depth)) if go_on() else [(OPEN, cell)]
                for label, part in parts:
                    row.areas[label] = row.areas.get(label, 0.0) + part.area
                labels = {label for label, _ in parts}
                # A part beyond the wall has no motions.
                inside = labels - {NO_START} or {NO_START}
                row.labels.append(inside.pop() if len(inside) == 1 else OPEN)
                if len(labels) > 1:
                    row.parts.extend((label, part) for label, part in parts if label >= 0)
        return row

    def _parts(self, system: BallSystem, cell: _Cell, depth: int) -> Iterator[tuple[int, _Cell]]:
        try:
            label = self._label(system, cell)
        except Undecided:
            label = OPEN
        if label == OPEN and depth:
            for quarter in cell.quarters():
                yield from self._parts(system, quarter, depth - 1)
        else:
            yield label, cell

    def _label(self, system: BallSystem, cell: _Cell) -> int:
        """Return the attractor of all starts of a cell.

        Raises
        ------
        Undecided
            If it is not proven that all have one.
        """
        places = law_of(system).places
        begin, end = arb(cell.x_low), arb(cell.x_high)
        for number, region in enumerate(system.regions):
            low = None if region.lower is None else places[region.lower]
            high = None if region.upper is None else places[region.upper]
            if low is not None and end <= low:
                if number == 0:
                    return NO_START
                continue
            if high is not None and begin >= high:
                if number == len(system.regions) - 1:
                    return NO_START
                continue
            if (low is None or begin > low) and (high is None or end < high):
                x, v = between(begin, end), between(arb(cell.v_low), arb(cell.v_high))
                start = Departure(number, Cloud.of(x, v), None, 1, Moment.of(self.t0))
                return self._settles(system, start)
        raise Undecided("precision", "a cell lies across a stop")

    def _settles(self, system: BallSystem, start: Departure) -> int:
        period = law_of(system).period(1)
        slow = SlowEvents(finest=SHORTEST * _apart(system, start))
        n_periods = 0
        for _ in range(self.most_impacts):
            search = search_set(system, start, LOOKED_FOR * float(period), slow)
            passage = next_passage(system, start, search)
            if passage is None:
                n_periods += LOOKED_FOR
                start = _later(system, start, LOOKED_FOR * float(period))
                label = self._stays_away(system, start)
                if label is not None:
                    return label
                if n_periods > MOST_PERIODS:
                    break
                continue
            start = passage.following
            for trap, label in self.traps:
                if trap.holds(passage.event, start.cloud, period):
                    return label
        raise Undecided("most_events", "the motions have not settled")

    def _stays_away(self, system: BallSystem, start: Departure) -> int | None:
        """Return the steady motion that attracts motions that are proven to meet no stop again."""
        for region, label in self.steady:
            if start.region == region:
                whole_ = flight_of(system, start, whole=True)
                if never_reaches(whole_, levels_of(system, region), start):
                    return label
        return None


def _apart(system: BallSystem, start: Departure) -> float:
    """Return about how much later some starts are than others, at a speed of their flights."""
    whole = flight_of(system, start, whole=True)
    width, ((x, v, a), _) = width_of(system, whole), whole.derivatives(arb(0), 2)
    speed = largest_abs(v) + largest_abs(a) * width
    return 2.0 * float(x.rad() + v.rad() * width) / speed


def _later(system: BallSystem, start: Departure, duration: float) -> Departure:
    """Return the states, at one instant, of flights that have no events for some time after each begins.

    Raises
    ------
    Undecided
        If some have not begun by then.
    """
    first = began(start, whole=True)
    t = (first.lower() + WITHIN * duration).mid()
    if not t > first:
        raise Undecided("precision", "the starts of a set of flights are too far apart")
    x, v = state_in_flight(system, start, t)
    return Departure(start.region, Cloud.of(x, v), None, 1, Moment(t))


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedBasins:
    """Cells of a plane of starts with the attractor of all starts of each, proven; of `prove_basins`.

    Attributes
    ----------
    oscillator, forcing
        The exact values that the proof is about.
    attractors
        The certified orbits.
    x0, v0
        Edges of the cells [length], [length/time], exact numbers.
    t0
        Time of the starts.
    labels
        (len(x0) - 1, len(v0) - 1) array: the number of the attractor that all motions from the cell
        approach, -1 where that is open, -2 beyond a wall.
    areas
        Area of the proven basin of each attractor in the plane [length^2/time], with parts of
        cells.
    open_area
        Area of which nothing is proven.
    parts
        (n, 4) array: ends of x0 and of v0 of the proven parts of cells that are open.
    labels_of_parts
        (n,) array: the numbers of their attractors.
    traps
        For each attractor arrays (n, 2) of (cycle, v): outlines of sets after its impacts into
        which motions come and which they never leave.
    fates
        These sets as their proof has them, and the regions in which motions without impacts
        attract.
    """

    oscillator: Oscillator
    forcing: Forcing
    attractors: tuple[CertifiedOrbit, ...]
    x0: Floats = field(repr=False)
    v0: Floats = field(repr=False)
    t0: Phase
    labels: Integers = field(repr=False)
    areas: tuple[float, ...]
    open_area: float
    parts: Floats = field(repr=False)
    labels_of_parts: Integers = field(repr=False)
    traps: tuple[tuple[Floats, ...], ...] = field(repr=False)
    fates: tuple[tuple[Trap, ...] | int, ...] = field(repr=False)

    @property
    def decided(self) -> float:
        """Part of the area of the starts that is decided."""
        total = sum(self.areas) + self.open_area
        return sum(self.areas) / total if total else 1.0

    def __repr__(self) -> str:
        """Return in a line what is proven."""
        n = int((self.labels != NO_START).sum())
        total = (sum(self.areas) + self.open_area) or 1.0
        parts = ", ".join(f"{100.0 * area / total:.1f} %" for area in self.areas)
        return (
            f"<CertifiedBasins: {n} cells, proven basins of {parts} of the area, "
            f"{100.0 * self.open_area / total:.1f} % open>"
        )

    def to_xarray(self) -> Dataset:
        """Return the labels over the middles of the cells.

        Returns
        -------
        xarray.Dataset
            ``basin`` over ``x0`` and ``v0``, with ``area`` over ``attractor``, and ``open_area``.
        """
        import xarray

        middles = [0.5 * (edges[1:] + edges[:-1]) for edges in (self.x0, self.v0)]
        return xarray.Dataset(
            {
                "basin": (("x0", "v0"), self.labels),
                "area": ("attractor", np.array(self.areas), {"units": "length^2/time"}),
                "open_area": ((), self.open_area, {"units": "length^2/time"}),
            },
            coords={
                "x0": ("x0", middles[0], {"units": "length"}),
                "v0": ("v0", middles[1], {"units": "length/time"}),
            },
        )


def prove_basins(
    attractors: PeriodicOrbit | Sequence[PeriodicOrbit],
    *,
    x0: tuple[Exact, Exact],
    v0: tuple[Exact, Exact],
    t0: Phase = 0,
    cells: int | tuple[int, int] = 100,
    depth: int = 2,
    most_impacts: int = 60,
    n_workers: int = 1,
    progress: Report = None,
) -> CertifiedBasins:
    """Prove for cells of starts that all motions from each of them approach one attractor.

    About the impacts of each attractor an ellipse is proven to be mapped into itself by the return
    map, smaller by a factor at least, so that all motions in it approach the orbit. The cells, all
    of their starts at once, are followed from impact to impact until they lie inside of one; a cell
    through which a grazing motion or a boundary passes is divided, and in the end left open
    (docs/theory/certified.md, section 13).

    Parameters
    ----------
    attractors
        One or several asymptotically stable orbits of one oscillator and forcing, without contacts;
        that without impacts may be one of them.
    x0, v0
        Ranges of the starts [length], [length/time].
    t0
        Time of all starts [time].
    cells
        Number of cells along each of the two, or along x0 and v0.
    depth
        How often an open cell is divided into four.
    most_impacts
        Impacts after which a cell that has not settled is open.
    n_workers
        Processes. With more than one a script needs ``if __name__ == "__main__":``.
    progress
        True shows a line on the error stream; a function ``(done, total) -> bool`` is called after
        each row of cells, and each second before and between, and ends the proof by returning
        False: the other cells are open.

    Returns
    -------
    CertifiedBasins

    Raises
    ------
    ParameterError
        If an attractor is not proven to be asymptotically stable, or is of another system; if no
        set is found in which motions stay; if the range is empty or the forcing has a record.
    MissingExtraError
        If python-flint is not installed.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.certified import prove_basins
    >>> orbit = pc.find_orbit(pc.impact_oscillator("0.7"), pc.cosine("2.3"))
    >>> basins = prove_basins(orbit, x0=("0.1", "0.2"), v0=("0.4", "0.5"), cells=3)
    >>> basins.labels.tolist(), basins.decided
    ([[0, 0, 0], [0, 0, 0], [0, 0, 0]], 1.0)
    """
    given: object = [attractors] if isinstance(attractors, PeriodicOrbit) else attractors
    orbits: list[PeriodicOrbit] = list(given) if isinstance(given, Iterable) else []
    if not orbits or not all(isinstance(orbit, PeriodicOrbit) for orbit in orbits):
        raise ParameterError("attractors", attractors, "neither an orbit nor a list of orbits")
    osc, force = orbits[0].oscillator, orbits[0].forcing
    if force is None or any((o.oscillator, o.forcing) != (osc, force) for o in orbits):
        reason = "not orbits of one oscillator under one forcing"
        raise ParameterError("attractors", attractors, reason)
    refuse_record(force, "a proof of basins")
    real("t0", t0)
    counts = tuple(cells) if isinstance(cells, Iterable) else (cells, cells)
    if len(counts) != 2:
        raise ParameterError("cells", cells, "neither a whole number nor two of them")
    nx, nv = (whole("cells", n, 1) for n in counts)
    depth, most_impacts = whole("depth", depth, 0), whole("most_impacts", most_impacts, 1)
    n_workers = whole("n_workers", n_workers, 1)
    edges = _edges("x0", x0, nx), _edges("v0", v0, nv)
    reported = Progress(progress, nx, "rows of cells")
    proven = [_certified(orbit) for orbit in orbits]
    traps, steady = _sets_of(system_of(osc, force), orbits, proven, reported)
    fates = _Fates(osc, force, t0, tuple(traps), tuple(steady), depth, most_impacts)
    rows = [
        [_Cell(a, b, c, d) for c, d in zip(edges[1], edges[1][1:], strict=False)]
        for a, b in zip(edges[0], edges[0][1:], strict=False)
    ]
    labels = np.full((nx, nv), OPEN)
    areas: dict[int, float] = {}
    done, pieces = 0, list[tuple[int, _Cell]]()
    for i, row in enumerate(_each(fates, rows, n_workers, reported)):
        labels[i] = row.labels
        pieces += row.parts
        done = i + 1
        for label, area in row.areas.items():
            areas[label] = areas.get(label, 0.0) + area
        if not reported.advance():
            break
    reported.close()
    left = sum(cell.area for row in rows[done:] for cell in row)
    period = float(force.period or 1.0)
    return CertifiedBasins(
        oscillator=osc,
        forcing=force,
        attractors=tuple(proven),
        x0=np.array(edges[0]),
        v0=np.array(edges[1]),
        t0=t0,
        labels=labels,
        areas=tuple(areas.get(k, 0.0) for k in range(len(orbits))),
        open_area=areas.get(OPEN, 0.0) + left,
        parts=np.array([part for _, part in pieces], dtype=float).reshape(-1, 4),
        labels_of_parts=np.array([label for label, _ in pieces], dtype=int),
        traps=tuple(
            tuple(_outline(trap, period) for trap, label in traps if label == k)
            for k in range(len(orbits))
        ),
        fates=tuple(
            next(
                (region for region, label in steady if label == k),
                tuple(trap for trap, label in traps if label == k),
            )
            for k in range(len(orbits))
        ),
    )


def _each(
    fates: _Fates, rows: list[list[_Cell]], n_workers: int, reported: Progress
) -> Iterator[_Row]:
    """Yield what is proven of rows of cells in their order, until the caller wants no more."""
    if reported.is_stopped:
        return
    if n_workers == 1:
        yield from (fates.row(row, reported.tick) for row in rows)
        return
    with ProcessPoolExecutor(n_workers, get_context("spawn")) as pool:
        try:
            for future in [pool.submit(_row, fates, row) for row in rows]:
                while not wait([future], WAITED).done:
                    if not reported.tick():
                        return
                yield future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _row(fates: _Fates, cells: list[_Cell]) -> _Row:
    return fates.row(cells)


def _edges(name: str, given: tuple[Exact, Exact], n: int) -> list[float]:
    """Return the ends of n cells, floats."""
    low, high = exact_range(name, given)
    return [float(low + (high - low) * Fraction(k, n)) for k in range(n + 1)]


def _certified(orbit: PeriodicOrbit) -> CertifiedOrbit:
    if math.isinf(orbit.n_impacts):
        reason = "it sticks, and there is no set about it in which motions are proven to stay"
        raise ParameterError("attractors", orbit, reason)
    proven = certify(orbit)
    if proven.stability != "asymptotic":
        reason = f"not proven to be asymptotically stable: {proven.reason or proven.stability}"
        raise ParameterError("attractors", orbit, reason)
    return proven


def _sets_of(
    system: BallSystem,
    orbits: Sequence[PeriodicOrbit],
    proven: Sequence[CertifiedOrbit],
    reported: Progress,
) -> tuple[list[tuple[Trap, int]], list[tuple[int, int]]]:
    """Return the sets about all attractors, each with the number of its attractor.

    Those that are known when the caller wants no more.
    """

    def go_on() -> bool:
        return reported.tick(f"the set about attractor {k + 1} of {len(orbits)}")

    traps: list[tuple[Trap, int]] = []
    steady: list[tuple[int, int]] = []
    with precision(BITS):
        for k, (orbit, certified) in enumerate(zip(orbits, proven, strict=True)):
            if not len(orbit.itinerary):
                steady.append((region_of_row(system, int(orbit.record[1][0, 2])), k))
                continue
            try:
                traps += [(trap, k) for trap in traps_about(system, certified, go_on)]
            except Undecided as question:
                if reported.is_stopped:
                    break
                raise ParameterError("attractors", orbit, question.reason) from None
    return traps, steady


def _outline(trap: Trap, period: float) -> Floats:
    angles = [arb(2 * k) / (OUTLINE - 1) for k in range(OUTLINE)]
    points = [(float(angle.cos_pi()), float(angle.sin_pi())) for angle in angles]
    return np.array(trap.outline(points)) / [period, 1.0]
