"""The impacts of an orbit, from the record of its events."""

from __future__ import annotations

import numpy as np

from percuss.kernels import record as columns
from percuss.kernels.law import PERIOD, Law, Table
from percuss.kernels.record import Integers
from percuss.kernels.sample import cycles
from percuss.model.oscillator import Oscillator
from percuss.motion.tables import Impacts
from percuss.orbits.orbit.chain import chain_of_record, entries_of

__all__ = ["impacts_of_record"]


def impacts_of_record(osc: Oscillator, table: Law, events: Table, marks: Integers) -> Impacts:
    """Return the impacts of one period, entries into soft stops among them.

    Parameters
    ----------
    osc
        The oscillator.
    table
        Its law.
    events, marks
        A record whose START is just after an impact and whose last event is that impact again.

    Returns
    -------
    Impacts
        The one at the START first.
    """
    kinds = marks[:, columns.KIND]
    chain = chain_of_record(marks)
    met = {
        i + 1: stop
        for i, stop in entries_of(osc, table, chain)
        if kinds[i + 1] in (columns.IMPACT, columns.CROSSING)
    }
    last = len(events) - 1
    rows = [last, *(i for i in met if i != last)]
    instants = [0, *rows[1:]]
    t = events[instants, columns.EVENT_T].copy()
    t_low = events[instants, columns.EVENT_T_LOW].copy()
    cycle = np.full(len(rows), np.nan)
    if table[0, PERIOD] > 0.0:
        cycles(table, t, t_low, cycle)
    before = np.roll(t, 1)
    before[0] -= events[last, columns.EVENT_T] - events[0, columns.EVENT_T]
    return Impacts(
        t=t,
        v_before=events[rows, columns.V_BEFORE].copy(),
        v_after=events[rows, columns.V_AFTER].copy(),
        stop=np.array([met[i] for i in rows], dtype=np.int64),
        cycle=cycle,
        intervals=t - before,
    )
