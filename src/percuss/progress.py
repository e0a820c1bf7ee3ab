"""Progress of a long call: a line on the error stream, or calls of a function of the caller."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from typing import TypeAlias

# ``progress=`` of a long call: a line on the error stream, or a function (done, total) -> bool.
Report: TypeAlias = bool | Callable[[float, float], bool] | None

# A line appears only for what takes longer than this [s]. A terminal and a notebook, where a line
# can be written over, get a new one this often [s]; a log gets one more line.
PATIENCE = 2.0
RENEWED, RENEWED_IN_A_LOG = 0.2, 10.0
# A function is called at least this often while nothing new is done [s].
CALLED = 1.0
BAR, WIDTH = 20, 90


class Progress:
    """The progress of a long call, and whether its caller wants it to go on.

    Parameters
    ----------
    report
        As ``progress`` of a long call: True for a line on the error stream, a function
        ``(done, total) -> bool`` that returns False to stop the call, or None.
    total
        How much there is to do.
    units
        What is counted, in the plural; where nothing is said the line shows a share only.
    done
        How much was done before.
    is_bound
        Whether ``total`` is only the most that there can be: the line shows no share of it.

    Attributes
    ----------
    done, total
        How much is done, and how much there is to do.
    is_stopped
        Whether the caller has asked to stop.

    Examples
    --------
    >>> progress = Progress(lambda done, total: done < 2, total=3)
    >>> progress.advance(), progress.advance(), progress.is_stopped
    (True, False, True)
    """

    def __init__(
        self,
        report: Report,
        total: float,
        units: str = "",
        done: float = 0.0,
        *,
        is_bound: bool = False,
    ) -> None:
        self._report, self._units, self._is_bound = report, units, is_bound
        self.done, self.total, self.is_stopped = done, total, False
        self._started = self._reported = time.monotonic()
        # When the first piece was done and how much that was: it may have had to compile.
        self._first: tuple[float, float] | None = None
        self._can_rewrite = bool(report) and _can_rewrite()
        self._has_line = False

    def advance(self, n: float = 1.0, text: str | Callable[[], str] = "") -> bool:
        """Count what has been done and report it.

        Parameters
        ----------
        n
            How much has been done since the last call.
        text
            The end of the line, or a function that makes it, which is called when it is shown.

        Returns
        -------
        bool
            Whether to go on.
        """
        return self.reach(self.done + n, text)

    def reach(self, done: float, text: str | Callable[[], str] = "") -> bool:
        """Report how much is done in all; return whether to go on."""
        now = time.monotonic()
        self.done, self.total = done, max(done, self.total)
        if self._first is None:
            self._first = now, done
        return self._show(now, text)

    def tick(self, text: str | Callable[[], str] = "") -> bool:
        """Report by the clock while nothing new is done; return whether to go on."""
        now = time.monotonic()
        if callable(self._report) and now - self._reported < CALLED:
            return not self.is_stopped
        return self._show(now, text)

    def seconds(self) -> float:
        """Return how long the call has taken so far [s]."""
        return time.monotonic() - self._started

    def since_first(self) -> float:
        """Return the time since the first piece was done [s], 0 before."""
        return 0.0 if self._first is None else time.monotonic() - self._first[0]

    def seconds_left(self) -> float:
        """Return how long the rest takes at the rate since the first piece [s]; NaN before it."""
        since = self.since_first()
        if self._first is None or since <= 0.0 or self.done <= self._first[1]:
            return math.nan
        return since * (self.total - self.done) / (self.done - self._first[1])

    def close(self) -> None:
        """End the line, if there is one."""
        if self._has_line and self._can_rewrite:
            sys.stderr.write("\n")
            sys.stderr.flush()
        self._has_line = False

    def _show(self, now: float, text: str | Callable[[], str]) -> bool:
        if callable(self._report):
            self._reported = now
            if not self.is_stopped:
                self.is_stopped = self._report(self.done, self.total) is False
            return not self.is_stopped
        pause = RENEWED if self._can_rewrite else RENEWED_IN_A_LOG
        is_due = now - self._reported > pause or not self._has_line
        if self._report and now - self._started > PATIENCE and is_due:
            self._reported, self._has_line = now, True
            self._write(self._line(text if isinstance(text, str) else text()))
        return True

    def _line(self, text: str) -> str:
        if self._is_bound:
            return f"{self.done:,.0f} {self._units}{', ' if text else ''}{text}"
        share = self.done / self.total if self.total else 1.0
        bar = "━" * round(BAR * share) + "·" * (BAR - round(BAR * share))
        counted = f"  {self.done:,.0f} of {self.total:,.0f} {self._units}" if self._units else ""
        left = self.seconds_left()
        ending = f", {duration_text(left)} left" if math.isfinite(left) else ""
        separator = ", " if counted else "  "
        return f"{bar} {share:6.1%}{counted}{separator if text else ''}{text}{ending}"

    def _write(self, line: str) -> None:
        # Blanks hide the end of a longer line before.
        sys.stderr.write(f"\r{line:<{WIDTH}}" if self._can_rewrite else f"{line}\n")
        sys.stderr.flush()


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


def _can_rewrite() -> bool:
    """Return whether the error stream understands a carriage return."""
    # A notebook's stream is no terminal but understands it; its module tells it from others.
    return sys.stderr.isatty() or type(sys.stderr).__module__.startswith("ipykernel")


def rate_text(value: float) -> str:
    """Return a rate in words.

    Examples
    --------
    >>> rate_text(1234.0), rate_text(2e6)
    ('1,234', '2 million')
    """
    for size, name in ((1e9, " billion"), (1e6, " million")):
        if value >= size:
            return f"{value / size:.3g}{name}"
    return f"{value:,.0f}"


def duration_text(seconds: float) -> str:
    """Return a duration in words.

    Examples
    --------
    >>> duration_text(41.2), duration_text(1000.0), duration_text(1e4), duration_text(1e6)
    ('42 s', '17 min', '2.8 h', '11.6 days')
    """
    if seconds < 90.0:
        return f"{math.ceil(seconds)} s"
    minutes = seconds / 60.0
    if minutes < 90.0:
        return f"{minutes:.0f} min"
    hours = minutes / 60.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"
