"""The orbits that a search for all has found, and how many it may have missed."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TypeVar

from percuss.errors import ParameterError
from percuss.numerics import log
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.wording import counted

# Batches of a search for all orbits, at an effort of 1; it ends early when fewer orbits than this
# are estimated to be unseen. The estimate is no bound: of 60 systems at random those that stopped
# just below one orbit lacked up to four.
FEWEST_BATCHES, MOST_BATCHES = 4, 16
ENOUGH = 0.25
LEAST_EFFORT, MOST_EFFORT = 0.1, 100.0
# The estimate of unseen orbits is of what a search with so many times the samples would show.
SAMPLES = 6.0

Found = TypeVar("Found", bound=PeriodicOrbit | StructureOrbit)


def check_effort(effort: float) -> tuple[int, int]:
    """Return the fewest and the most batches of an effort.

    Raises
    ------
    ParameterError
        If it is out of range.
    """
    if not LEAST_EFFORT <= effort <= MOST_EFFORT:
        reason = f"outside {LEAST_EFFORT:g} to {MOST_EFFORT:g}; 1 is the usual effort"
        raise ParameterError("effort", effort, reason)
    return max(1, round(effort * FEWEST_BATCHES)), max(1, round(effort * MOST_BATCHES))


class FoundOrbits(list[Found]):
    """The periodic orbits that `find_orbits` has found.

    Parameters
    ----------
    orbits
        The orbits.
    unseen_estimate
        How many orbits of these kinds have not been found, estimated from how often the others were
        (`estimate_unseen`); 0 where closed forms give all, NaN where the search gives no estimate
        (free motion, or too few starts).
    n_searches
        The number of starts of the search.
    """

    def __init__(
        self,
        orbits: Iterable[Found] = (),
        unseen_estimate: float = math.nan,
        n_searches: int = 0,
    ) -> None:
        super().__init__(orbits)
        self.unseen_estimate, self.n_searches = unseen_estimate, n_searches

    def __repr__(self) -> str:
        """Return the orbits, one a line, and how complete they are."""
        return "\n".join([*map(repr, self), self.completeness()])

    def completeness(self) -> str:
        """Return in words how many orbits were found and how many may be missing."""
        text = counted(len(self), "periodic orbit")
        if self.n_searches == 0:
            return f"{text} from closed forms"
        text += f" from {self.n_searches:,} starts"
        if math.isnan(self.unseen_estimate):
            return text
        more = (
            "fewer than 0.01" if self.unseen_estimate < 0.01 else f"some {self.unseen_estimate:.2g}"
        )
        return f"{text}; {more} more are estimated to be unseen"


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
