"""Many short runs of one oscillator, on arrays that are used again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.kernels import march as engine
from percuss.kernels import record as columns
from percuss.kernels.law import N_HARMONICS, Law, Table
from percuss.kernels.sample import evaluate
from percuss.kernels.tangent import neighbours
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate

__all__ = ["Propagator"]

# Room for the events of a run; one that has more, or a flight that is searched for long, is left
# to `simulate`, which has no limits.
CAPACITY = 512
PATIENCE = 20_000
MORE_IMPACTS = 1_000_000


@dataclass(slots=True)
class Propagator:
    """Runs of one oscillator: each `follow` replaces the record of the one before.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    law
        The kernels' table of both.
    """

    oscillator: Oscillator
    forcing: Forcing | None
    law: Law = field(init=False)
    _state: Table = field(init=False)
    _counters: columns.Integers = field(init=False)
    _scratch: tuple[Table, Table, Table] = field(init=False)
    _events: Table = field(init=False)
    _marks: columns.Integers = field(init=False)
    _grazes: Table = field(init=False)
    _record: tuple[Table, columns.Integers] = field(init=False)

    def __post_init__(self) -> None:
        self.law = law(self.oscillator, self.forcing)
        n = int(self.law[0, N_HARMONICS])
        self._state = np.zeros(columns.STATE_ENTRIES)
        self._counters = np.zeros(columns.COUNTERS, dtype=np.int64)
        self._scratch = (np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2)))
        self._events = np.empty((CAPACITY, columns.EVENT_COLUMNS))
        self._marks = np.empty((CAPACITY, columns.MARK_COLUMNS), dtype=np.int64)
        self._grazes = np.empty((16, columns.GRAZE_COLUMNS))
        self._record = self._events[:0], self._marks[:0]

    def follow(
        self, x: float, v: float, t0: float, *, t_end: float = math.inf, n_impacts: int = 0
    ) -> tuple[Table, columns.Integers]:
        """Follow a motion to t_end or to its n-th impact, and return its events and marks.

        Entries into soft stops count as impacts, as they do in `simulate`.
        """
        self._state[:] = 0.0
        self._counters[:] = 0
        self._state[columns.T], self._state[columns.X], self._state[columns.V] = t0, x, v
        phases, arrival, walker = self._scratch
        engine.begin(self.law, self._state, self._counters, phases, self._events, self._marks)
        status = engine.march(
            self.law,
            self._state,
            self._counters,
            phases,
            arrival,
            walker,
            self._events,
            self._marks,
            self._grazes,
            t_end,
            n_impacts or MORE_IMPACTS,
            PATIENCE,
        )
        if status in (columns.FULL, columns.SPENT):
            return self._simulated(x, v, t0, t_end, n_impacts)
        n = int(self._counters[columns.N_EVENTS])
        self._record = self._events[:n], self._marks[:n]
        return self._record

    def _simulated(
        self, x: float, v: float, t0: float, t_end: float, n_impacts: int
    ) -> tuple[Table, columns.Integers]:
        end = None if t_end == math.inf else t_end
        run = simulate(
            self.oscillator, self.forcing, x, v, t0, t_end=end, max_impacts=n_impacts or None
        )
        self._record = run._events, run._marks
        return self._record

    def state_at(self, x0: float, t: float) -> tuple[float, float]:
        """Return (x, v) of the last run at t; x0 is where it started."""
        motion = np.empty((2, 1))
        phases, arrival, _ = self._scratch
        events, marks = self._record
        evaluate(self.law, events, marks, x0, np.array([t]), True, phases, arrival, motion)
        return float(motion[0, 0]), float(motion[1, 0])

    def derivative_at(self, t: float, *, after: bool = True) -> Table:
        """Return the derivative of (x, v) at t by (x, v) at the start of the last run."""
        out = np.empty((1, 4))
        events, marks = self._record
        neighbours(self.law, events, marks, np.array([t]), after, self._scratch[0], out)
        return out.reshape(2, 2)
