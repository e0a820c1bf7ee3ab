"""The orbits that a search has found, and how many it has probably not seen."""

from __future__ import annotations

import math
from collections.abc import Iterable

from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["FoundOrbits", "estimate_unseen"]


class FoundOrbits(list[PeriodicOrbit]):
    """The list of the periodic orbits that `find_orbits` has found.

    Parameters
    ----------
    orbits
        The orbits.
    unseen_estimate
        How many orbits of the kinds that were looked for have not been found, estimated from how
        often the others were (Chao 1984); 0 where closed forms give all, NaN where the search
        gives no estimate (free motion).
    n_searches
        From how many starts was searched.
    """

    def __init__(
        self,
        orbits: Iterable[PeriodicOrbit] = (),
        unseen_estimate: float = math.nan,
        n_searches: int = 0,
    ) -> None:
        super().__init__(orbits)
        self.unseen_estimate, self.n_searches = unseen_estimate, n_searches

    def __repr__(self) -> str:
        """Tell the orbits, one a line, and how complete they are."""
        return "\n".join([*map(repr, self), self.completeness()])

    def completeness(self) -> str:
        """Return in words how many orbits were found and how many may be missing."""
        n = len(self)
        found = f"{n} periodic orbit" + ("" if n == 1 else "s")
        if self.n_searches == 0:
            return f"{found} from closed forms"
        found += f" from {self.n_searches:,} starts"
        if math.isnan(self.unseen_estimate):
            return found
        return f"{found}; some {self.unseen_estimate:.2g} more are estimated to be unseen"


def estimate_unseen(counts: Iterable[int]) -> float:
    """Return how many kinds are unseen, estimated from how often each of the others was seen.

    With f1 kinds seen once and f2 seen twice there are f1^2 / (2 f2) more at least on average
    (Chao 1984, Scand. J. Statist. 11, 265); without any seen twice f1 (f1 + 1) / 2 is returned,
    so that a single kind seen once counts.

    Parameters
    ----------
    counts
        In how many independent samples each kind was seen, >= 1.

    Returns
    -------
    float
        The estimate, >= 0.

    Examples
    --------
    >>> estimate_unseen([1, 1, 2, 7, 30]), estimate_unseen([1, 5]), estimate_unseen([9, 8])
    (2.0, 1.0, 0.0)
    """
    seen = list(counts)
    once, twice = seen.count(1), seen.count(2)
    return once**2 / (2.0 * twice) if twice else 0.5 * once * (once + 1)
