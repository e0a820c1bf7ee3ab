"""Progress of a run: its time or its impacts, whichever end comes sooner."""

from __future__ import annotations

import math

from percuss.progress import Progress, Report, rate_text

__all__ = ["RunProgress"]


class RunProgress(Progress):
    """The share of a run that is done.

    Parameters
    ----------
    report
        As ``progress`` of `percuss.simulate`.
    begin, end
        The instants between which it is followed; the end may be infinite.
    limit
        The most impacts.
    """

    def __init__(self, report: Report, begin: float, end: float, limit: int) -> None:
        super().__init__(report, 1.0)
        self._begin, self._end, self._limit = begin, end, limit

    def reach_event(self, t: float, n_impacts: int) -> bool:
        """Report where the run is; return whether to go on."""
        by_time = 0.0
        if self._end < math.inf:
            by_time = (t - self._begin) / (self._end - self._begin)

        def text() -> str:
            rate = rate_text(n_impacts / self.seconds())
            return f"{n_impacts:,} impacts and entries into soft stops, {rate} a second"

        return self.reach(min(1.0, max(by_time, n_impacts / self._limit)), text)
