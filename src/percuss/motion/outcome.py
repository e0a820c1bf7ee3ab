"""How a run ended."""

from __future__ import annotations

from enum import Enum

__all__ = ["Outcome"]


class Outcome(Enum):
    """How a run ended; the value is the sentence to show.

    Examples
    --------
    >>> Outcome.reached_t_end.value
    'the run reached t_end'
    """

    reached_t_end = "the run reached t_end"
    reached_max_impacts = "the run reached max_impacts (impacts and entries into soft stops)"
    at_rest = "the mass came to rest at a stop for good"
    no_more_impacts = "the motion provably meets no stop again, and there is no t_end to run to"
    overflow = "the motion grew beyond 1e150; the run holds what was before"
    interrupted = "the run was interrupted; it holds what was done"
