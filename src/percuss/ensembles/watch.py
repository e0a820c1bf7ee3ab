"""Telling how far many motions have come: a line in a terminal, in a notebook, or in a log."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

__all__ = ["Report", "Watch", "tell_of_stopping"]

Report: TypeAlias = bool | Callable[[float, float], bool] | None

# A line appears only for what takes longer than this [s]. In a terminal and a notebook, which know
# how to go back to its beginning, it is renewed; a log gets a new one so often [s], also where no
# chunk has been done since.
PATIENCE = 2.0
RENEWED, RENEWED_IN_A_LOG = 0.2, 10.0
# What takes longer is told once where no progress was asked for [s].
LONG = 600.0
# A function is called so often while no chunk is finished [s].
CALLED = 1.0
BAR = 20


class Watch:
    """Tells how far a job has come.

    Parameters
    ----------
    report
        True shows a line on the error stream; a function ``(done, total) -> bool`` is called
        with numbers of points after each chunk, and by the clock while none is finished.
    size, todo
        Points in all, and those that are still to be done.
    what
        What a point of the job is called, in the plural.
    """

    def __init__(self, report: Report, size: int, todo: int, what: str = "points") -> None:
        self._what = what
        self._report, self._size, self._before = report, size, size - todo
        self._done = self._impacts = 0
        self._started = self._shown = time.monotonic()
        # When the first chunk was done, and what had been until then: it may have had to compile.
        self._first: tuple[float, int, int] | None = None
        self._renews = _goes_back()
        self._open = self._is_long = False

    def tick(self) -> bool:
        """Tell by the clock that nothing new is done; False if the caller wants it stopped."""
        if callable(self._report) and time.monotonic() - self._shown < CALLED:
            return True
        return self._tell(time.monotonic())

    def go_on(self, points: int, n_impacts: int) -> bool:
        """Count what is done; False if the caller wants it stopped."""
        now = time.monotonic()
        self._done += points
        self._impacts += n_impacts
        if self._first is None:
            self._first = now, self._done, self._impacts
        if self._report is None:
            self._tell_once_of_long_work(now, *self._first)
        return self._tell(now)

    def _tell_once_of_long_work(self, now: float, began: float, points: int, _: int) -> None:
        if self._is_long or now - began <= PATIENCE or self._done <= points:
            return
        left = (now - began) * (self._size - self._before - self._done) / (self._done - points)
        if left > LONG:
            self._is_long = True
            sys.stderr.write(
                f"{in_words(left)} left for {self._size:,} points at the rate of the first chunks; "
                "progress=True shows how far it is, store= keeps what is done\n"
            )
            sys.stderr.flush()

    def _tell(self, now: float) -> bool:
        if self._report is None or self._report is False:
            return True
        if callable(self._report):
            self._shown = now
            return self._report(self._before + self._done, self._size) is not False
        patience = RENEWED if self._renews else RENEWED_IN_A_LOG
        first = not self._open
        if now - self._started > PATIENCE and (first or now - self._shown > patience):
            self._shown = now
            self._show(now, *(self._first or (now, self._done, self._impacts)))
        return True

    def _show(self, now: float, began: float, points: int, impacts: int) -> None:
        done = self._before + self._done
        share = done / self._size
        bar = "━" * round(BAR * share) + "·" * (BAR - round(BAR * share))
        text = f"{bar} {share:6.1%}  {done:,} of {self._size:,} {self._what}"
        if self._done > points and now > began:
            left = (now - began) * (self._size - done) / (self._done - points)
            rate = (self._impacts - impacts) / (now - began)
            text += f", {_rate(rate)} impacts/s, {in_words(left)} left"
        self._open = True
        if self._renews:
            # Blanks hide the end of a longer line before.
            sys.stderr.write(f"\r{text:<90}")
        else:
            sys.stderr.write(f"{text}\n")
        sys.stderr.flush()

    def tell_of_interruption(self, done: int, store: str | Path | None) -> None:
        """Say what an interruption has left: so many points, in a store or in hand."""
        what = f"interrupted; {done:,} of {self._size:,} {self._what} are done"
        kept = f"kept in {store}: the same call goes on from there" if store else "returned"
        begin = "\n" if self._open and self._renews else ""
        sys.stderr.write(f"{begin}{what} and {kept}\n")
        sys.stderr.flush()
        self._open = False

    def close(self) -> None:
        """End the line, if there is one."""
        if self._open and self._renews:
            sys.stderr.write("\n")
            sys.stderr.flush()


def tell_of_stopping() -> None:
    """Say at once that Ctrl-C was heard: chunks that are at work may take a while."""
    sys.stderr.write("\nstopping after the chunks at work; Ctrl-C again drops them\n")
    sys.stderr.flush()


def _goes_back() -> bool:
    """Tell whether what reads the error stream understands a carriage return."""
    # A notebook's stream is no terminal, but does; its kernel says so by its module.
    return sys.stderr.isatty() or type(sys.stderr).__module__.startswith("ipykernel")


def _rate(value: float) -> str:
    for size, name in ((1e9, " billion"), (1e6, " million")):
        if value >= size:
            return f"{value / size:.3g}{name}"
    return f"{value:,.0f}"


def in_words(seconds: float) -> str:
    """Return a time as one reads it.

    Examples
    --------
    >>> in_words(41.2), in_words(1000.0), in_words(1e4), in_words(1e6)
    ('42 s', '17 min', '2.8 h', '11.6 days')
    """
    if seconds < 90.0:
        return f"{math.ceil(seconds)} s"
    minutes = seconds / 60.0
    if minutes < 90.0:
        return f"{minutes:.0f} min"
    hours = minutes / 60.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"
