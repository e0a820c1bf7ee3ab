"""Many motions of one system, followed back in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels import backward as engine
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import Law
from percuss.model.system import System
from percuss.orbits.orbit.itinerary import row_of_region

# No bound has this number.
NO_BOUND = -1
# Velocity beyond which a motion is given up [length/time].
FASTEST = 1e9


@dataclass(frozen=True, slots=True)
class Pasts:
    """The events before each of n states.

    Attributes
    ----------
    t
        (n, m) array, instants of the impacts on a stop before the state, the last one first
        [time]; NaN where there are no more.
    v
        (n, m) array, velocities after them [length/time].
    n_between
        (n, m) array, events between each of them and the state; -1 where there are no more.
    status
        (n,) array, why the motion back ended: the codes of `percuss.kernels.backward`.
    x_end, v_end
        (n,) arrays, the state at its end.
    """

    t: Floats
    v: Floats
    n_between: Integers
    status: Integers
    x_end: Floats
    v_end: Floats


@dataclass(frozen=True, slots=True)
class BackwardMotions:
    """Follows motions of one system back in time."""

    system: System

    @property
    def law(self) -> Law:
        """The law of the system."""
        return self.system.law

    def follow(
        self,
        t: Floats,
        x: Floats | float,
        v: Floats,
        longest: float,
        *,
        region: int | Integers | None = None,
        bound: int = NO_BOUND,
        sign: float = 0.0,
        n_hits: int = 1,
        fastest: float = FASTEST,
    ) -> Pasts:
        """Follow states back by ``longest``, or to an impact.

        Parameters
        ----------
        t, x, v
            (n,) arrays: instants, positions and velocities; where one of them is that of an
            event, the velocity before it.
        longest
            The longest time back [time].
        region
            Rows of the regions of the states just before; default: by position and velocity.
        bound
            Number of a bound; a motion ends at the ``n_hits``-th impact on it.
        sign
            Sign of the velocity with which a soft stop there is entered.
        n_hits
            Number of impacts on it, >= 1.
        fastest
            Velocity beyond which a motion is given up [length/time].

        Returns
        -------
        Pasts
            Impacts, status and end of each.
        """
        n = len(t)
        states = np.zeros((n, engine.STATE_ENTRIES))
        states[:, engine.T], states[:, engine.V], states[:, engine.PLACE] = t, v, x
        if region is None:
            region = self._regions(states[:, engine.PLACE], states[:, engine.V])
        rows = np.array(np.broadcast_to(region, n), dtype=np.int64)
        hits = np.full((n, n_hits, engine.HIT_COLUMNS), np.nan)
        ends = np.zeros((n, 2), dtype=np.int64)
        workspace = np.empty((2, int(self.law[0, at.N_HARMONICS]), 2))
        limits = (float(longest), float(fastest))
        engine.trace_batch(self.law, rows, states, (bound, sign), limits, hits, ends, workspace)
        met = np.arange(n_hits) < ends[:, 1:]
        between = np.where(met, hits[:, :, engine.HIT_EVENTS], -1.0).astype(np.int64)
        instants = hits[:, :, engine.HIT_T] + hits[:, :, engine.HIT_T_LOW]
        return Pasts(
            t=np.where(met, instants, np.nan),
            v=np.where(met, hits[:, :, engine.HIT_V], np.nan),
            n_between=between,
            status=ends[:, 0].copy(),
            x_end=states[:, engine.PLACE] + states[:, engine.Y],
            v_end=states[:, engine.V].copy(),
        )

    def row(self, number: int) -> int:
        """Return the row of a region of the law."""
        return row_of_region(self.law, number)

    def _regions(self, x: Floats, v: Floats) -> Integers:
        """Return the rows of the regions in which the states were just before."""
        n_regions = int(self.law[0, at.N_REGIONS])
        rows = np.array([row_of_region(self.law, i) for i in range(n_regions)])
        upper = self.law[rows[:-1], at.UPPER]
        inside = np.searchsorted(upper, x, side="left")
        # At an edge the state comes from the side against its velocity.
        on_edge = np.isin(x, upper) & (v < 0.0)
        return np.asarray(rows[inside + on_edge], dtype=np.int64)
