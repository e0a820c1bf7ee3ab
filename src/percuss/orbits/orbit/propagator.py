"""Many short runs of one system, in buffers that are used again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels import march as engine
from percuss.kernels import record as columns
from percuss.kernels.law_columns import Law
from percuss.kernels.sample import evaluate
from percuss.kernels.tangent import neighbours
from percuss.model.system import System
from percuss.motion.simulate import simulate

# Events of a run, and steps of the search in a flight: runs with more are left to `simulate`, which
# has no limits.
CAPACITY = 512
PATIENCE = 20_000
MORE_IMPACTS = 1_000_000


@dataclass(slots=True)
class Propagator:
    """Runs of one system: each `follow` replaces the record of the one before.

    Attributes
    ----------
    system
        Oscillator and forcing.
    law
        Their law.
    """

    system: System
    law: Law = field(init=False)
    _run: columns.Run = field(init=False)
    _record: tuple[Floats, Integers] = field(init=False)

    def __post_init__(self) -> None:
        self.law = self.system.law
        self._run = columns.new_run(self.law, CAPACITY)
        self._record = self._run.events[:0], self._run.marks[:0]

    def follow(
        self, x: float, v: float, t0: float, *, t_end: float = math.inf, n_impacts: int = 0
    ) -> tuple[Floats, Integers]:
        """Follow a motion to t_end or to its n-th impact, and return its events and marks.

        Entries into soft stops count as impacts, as they do in `simulate`.
        """
        run = self._run
        run.state[:] = 0.0
        run.counters[:] = 0
        run.state[columns.T], run.state[columns.X], run.state[columns.V] = t0, x, v
        status = engine.march(run, t_end, n_impacts or MORE_IMPACTS, PATIENCE)
        if status in (columns.FULL, columns.SPENT):
            return self._simulated(x, v, t0, t_end, n_impacts)
        n = int(run.counters[columns.N_EVENTS])
        self._record = run.events[:n], run.marks[:n]
        return self._record

    def _simulated(
        self, x: float, v: float, t0: float, t_end: float, n_impacts: int
    ) -> tuple[Floats, Integers]:
        end = None if t_end == math.inf else t_end
        run = simulate(*self.system, x, v, t0, t_end=end, max_impacts=n_impacts or None)
        self._record = run.record
        return self._record

    @property
    def record(self) -> tuple[Floats, Integers]:
        """Events and marks of the last run."""
        return self._record

    def state_at(self, x0: float, t: float) -> tuple[float, float]:
        """Return (x, v) of the last run at t; x0 is where it started."""
        motion = np.empty((2, 1))
        record = columns.MotionRecord(self.law, float(x0), *self._record)
        evaluate(record, np.array([t]), True, self._run.phases, self._run.arrival, motion)
        return float(motion[0, 0]), float(motion[1, 0])

    def derivative_at(self, t: float, *, after: bool = True) -> Floats:
        """Return the derivative of (x, v) at t by (x, v) at the start of the last run."""
        out = np.empty((1, 4))
        record = columns.MotionRecord(self.law, 0.0, *self._record)
        neighbours(record, np.array([t]), after, self._run.phases, out)
        return out.reshape(2, 2)
