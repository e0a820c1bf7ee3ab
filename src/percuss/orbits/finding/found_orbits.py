"""The orbits that a search has found, and how many it has probably not seen."""

from __future__ import annotations

import math
from collections.abc import Iterable

from percuss.numerics import log
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["FoundOrbits", "estimate_unseen"]

# The estimate is of what a search with so many times the samples would show.
SAMPLES = 6.0


class FoundOrbits(list[PeriodicOrbit]):
    """The list of the periodic orbits that `find_orbits` has found.

    Parameters
    ----------
    orbits
        The orbits.
    unseen_estimate
        How many orbits of the kinds that were looked for have not been found, estimated from how
        often the others were (`estimate_unseen`); 0 where closed forms give all, NaN where the search
        gives no estimate (free motion, or too few starts).
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
    """Return about how many kinds are unseen, from how often each of the others was seen.

    The larger of two estimates. With f1 kinds seen once and f2 seen twice there are at least
    f1^2 / (2 f2) more on average (Chao 1984, Scand. J. Statist. 11, 265); without any seen twice,
    f1 (f1 + 1) / 2. That bound is low where kinds are seen at rates of many orders, as orbits are
    by their multipliers: then each doubling of the samples shows as many new kinds as the last
    one did, which is the sum of 2^-n over the kinds, n being how often each was seen. The second
    estimate is what six times as many samples would show at this pace.

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
    >>> round(estimate_unseen([1, 1, 1, 2, 30]), 2), round(estimate_unseen([2, 3, 27, 400]), 2)
    (4.52, 0.97)
    """
    seen = list(counts)
    once, twice = seen.count(1), seen.count(2)
    least = once**2 / (2.0 * twice) if twice else 0.5 * once * (once + 1)
    pace = math.fsum(0.5**n for n in seen)
    return max(least, pace * log(SAMPLES) / log(2.0))
