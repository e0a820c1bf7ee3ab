"""Which events an orbit has, in order: from the stops that it meets to the kernels' chain."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from percuss.errors import ParameterError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import Law
from percuss.kernels.record import Integers
from percuss.kernels.shooting import CHAIN_COLUMNS
from percuss.model.law import lines
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall

__all__ = ["Entry", "chain_of_record", "chain_of_stops", "entries_of", "entry", "row_of_region"]


@dataclass(frozen=True, slots=True)
class Entry:
    """The event of meeting a stop.

    Attributes
    ----------
    stop
        Index of the stop.
    bound
        Number of the bound at which it lies.
    before, after
        Numbers of the regions before and after the event.
    way
        Sign of the velocity before it.
    """

    stop: int
    bound: int
    before: int
    after: int
    way: float


def row_of_region(table: Law, number: int) -> int:
    """Return the row of a region of a law."""
    return _row(int(table[0, at.N_HARMONICS]), number)


def _row(n_harmonics: int, number: int) -> int:
    return at.FIRST_HARMONIC + n_harmonics + number * (1 + n_harmonics)


def entry(osc: Oscillator, stop: int) -> Entry:
    """Return the event of meeting a stop from where the mass is free of it.

    Parameters
    ----------
    osc
        The oscillator.
    stop
        Index into its stops.

    Returns
    -------
    Entry
        Bound and regions.

    Raises
    ------
    ParameterError
        If there is no such stop.

    Examples
    --------
    >>> import percuss as pc
    >>> entry(pc.backlash_oscillator(gap=1.0, stiffness=9.0), 1)
    Entry(stop=1, bound=2, before=1, after=2, way=1.0)
    """
    if not 0 <= stop < len(osc.stops):
        reason = f"the oscillator has {len(osc.stops)} stops, counted from 0"
        raise ParameterError("stop", stop, reason)
    layout = lines(osc)
    above = osc.stops[stop].side == "above"
    edges = zip(layout.wall, layout.edges, strict=True)
    bound = next(i for i, (wall, edge) in enumerate(edges) if wall == stop or stop in edge)
    before = bound - 1 if above else bound
    after = before
    if not isinstance(osc.stops[stop], Wall):
        after = bound if above else bound - 1
    return Entry(stop, bound, before, after, 1.0 if above else -1.0)


def chain_of_stops(osc: Oscillator, table: Law, stops: Sequence[int]) -> Integers:
    """Return the events of a motion that meets these stops in turn, and then the first again.

    Between two of them it leaves the soft stops that lie on its way.

    Parameters
    ----------
    osc
        The oscillator.
    table
        Its law.
    stops
        Indices of the stops, in the order in which they are met; at least one.

    Returns
    -------
    array
        (n, 3), a chain of `percuss.kernels.shooting`.

    Raises
    ------
    ParameterError
        If there is no such stop, or another one lies on the way.
    """
    entries = [entry(osc, stop) for stop in stops]
    chain: list[tuple[int, int, int]] = []
    for this, following in zip(entries, [*entries[1:], entries[0]], strict=True):
        chain.append((this.bound, this.before, this.after))
        now = this.after
        while now != following.before:
            up = following.before > now
            row = row_of_region(table, now)
            if table[row, at.UPPER_ENTRY if up else at.LOWER_ENTRY] == 1.0:
                reason = f"between stops {this.stop} and {following.stop} another one is met"
                raise ParameterError("sequence", tuple(stops), reason)
            step = 1 if up else -1
            chain.append((now + 1 if up else now, now, now + step))
            now += step
    rows = [[b, row_of_region(table, i), row_of_region(table, j)] for b, i, j in chain]
    return np.array(rows, dtype=np.int64).reshape(-1, CHAIN_COLUMNS)


def chain_of_record(marks: Integers) -> Integers:
    """Return the chain of the impacts and crossings in a record of `march`, less its START."""
    before = marks[:-1, columns.NEXT_REGION]
    rows = np.column_stack([marks[1:, columns.BOUND], before, marks[1:, columns.NEXT_REGION]])
    return np.ascontiguousarray(rows, dtype=np.int64)


@lru_cache(maxsize=64)
def _meetings(osc: Oscillator, n_harmonics: int) -> dict[tuple[int, int, int], int]:
    """Return the stop that each event in a chain meets, of those that meet one."""
    met = {}
    for stop in reversed(range(len(osc.stops))):
        it = entry(osc, stop)
        met[it.bound, _row(n_harmonics, it.before), _row(n_harmonics, it.after)] = stop
    return met


def entries_of(osc: Oscillator, table: Law, chain: Integers) -> list[tuple[int, int]]:
    """Return (row of the chain, stop) of the events that meet a stop; others leave one."""
    met = _meetings(osc, int(table[0, at.N_HARMONICS]))
    events: Iterable[tuple[int, int, int]] = map(tuple, chain.tolist())
    return [(i, met[event]) for i, event in enumerate(events) if event in met]


def is_wall(table: Law, chain: Integers) -> list[bool]:
    """Tell which events of a chain are impacts on walls."""
    kinds: list[bool] = []
    for bound, before, _ in chain:
        lower = bound == int(table[before, at.NUMBER])
        kinds.append(bool(table[before, at.LOWER_KIND if lower else at.UPPER_KIND] == at.WALL))
    return kinds
