"""Telling how far a long run has come."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable

__all__ = ["Progress"]

# A line appears only for what takes longer than this [s], and is renewed this often.
PATIENCE = 2.0
RENEWED = 0.2


class Progress:
    """Reports (done, total): of the time to go, or of the impacts if these come sooner."""

    def __init__(
        self,
        report: bool | Callable[[float, float], bool] | None,
        begin: float,
        end: float,
        limit: int,
    ) -> None:
        self._report = report
        self._begin, self._end, self._limit = begin, end, limit
        self._started = self._shown = time.monotonic()
        self._line = False

    def go_on(self, t: float, n_impacts: int) -> bool:
        """Report where the run is; False if the caller wants it stopped."""
        if self._report is None or self._report is False:
            return True
        by_time = 0.0
        if self._end < math.inf:
            by_time = (t - self._begin) / (self._end - self._begin)
        share = min(1.0, max(by_time, n_impacts / self._limit))
        if callable(self._report):
            return self._report(share, 1.0) is not False
        now = time.monotonic()
        if now - self._started > PATIENCE and now - self._shown > RENEWED:
            self._shown, self._line = now, True
            rate = n_impacts / (now - self._started)
            done = f"{n_impacts:,} impacts and entries into soft stops, {rate:,.0f} a second"
            sys.stderr.write(f"\r{share:6.1%}  {done} ")
            sys.stderr.flush()
        return True

    def close(self) -> None:
        """End the line, if there is one."""
        if self._line:
            sys.stderr.write("\n")
