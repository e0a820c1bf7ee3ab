"""Telling how far something long has come."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from typing import TypeAlias

__all__ = ["Progress", "Report", "Told"]

# ``progress=`` of a long call: a line on the error stream, or a function (done, total) -> bool.
Report: TypeAlias = bool | Callable[[float, float], bool] | None

# A line appears only for what takes longer than this [s], and is renewed this often.
PATIENCE = 2.0
RENEWED = 0.2


class Told:
    """Whoever wants to know how far a long call has come.

    Parameters
    ----------
    report
        True for a line on the error stream, a function (done, total) -> bool, or None.
    """

    def __init__(self, report: Report) -> None:
        self._report = report
        self._started = self._shown = time.monotonic()
        self._line = False

    def tell(self, done: float, total: float, text: Callable[[], str]) -> bool:
        """Tell how much is done, in a line with this text; False if the caller wants no more."""
        if callable(self._report):
            return self._report(done, total) is not False
        now = time.monotonic()
        if self._report and now - self._started > PATIENCE and now - self._shown > RENEWED:
            self._shown, self._line = now, True
            sys.stderr.write(f"\r{text()} ")
            sys.stderr.flush()
        return True

    def seconds(self) -> float:
        """Return how long it has taken so far [s]."""
        return time.monotonic() - self._started

    def close(self) -> None:
        """End the line, if there is one."""
        if self._line:
            sys.stderr.write("\n")


class Progress:
    """Reports (done, total): of the time to go, or of the impacts if these come sooner."""

    def __init__(self, report: Report, begin: float, end: float, limit: int) -> None:
        self._told = Told(report)
        self._begin, self._end, self._limit = begin, end, limit

    def go_on(self, t: float, n_impacts: int) -> bool:
        """Report where the run is; False if the caller wants it stopped."""
        by_time = 0.0
        if self._end < math.inf:
            by_time = (t - self._begin) / (self._end - self._begin)
        share = min(1.0, max(by_time, n_impacts / self._limit))

        def text() -> str:
            rate = n_impacts / self._told.seconds()
            done = f"{n_impacts:,} impacts and entries into soft stops, {rate:,.0f} a second"
            return f"{share:6.1%}  {done}"

        return self._told.tell(share, 1.0, text)

    def close(self) -> None:
        """End the line, if there is one."""
        self._told.close()
