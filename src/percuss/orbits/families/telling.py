"""Telling how far a branch has been followed."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeAlias

__all__ = ["Report", "Telling"]

Report: TypeAlias = bool | Callable[[float, float], bool] | None

# A line appears only for what takes longer than this [s], and is renewed this often.
PATIENCE = 2.0
RENEWED = 0.2


class Telling:
    """Reports (orbits done, the most there can be).

    Parameters
    ----------
    report
        True for a line on the error stream, a function, or None.
    most
        How many orbits there can be.
    path
        Path of the parameter.
    """

    def __init__(self, report: Report, most: int, path: str) -> None:
        self._report, self._most, self._path = report, most, path
        self._started = self._shown = time.monotonic()
        self._line = False
        self._done = 0

    def go_on(self, value: float) -> bool:
        """Report one orbit more, at a value of the parameter; False to stop."""
        self._done += 1
        if self._report is None or self._report is False:
            return True
        if callable(self._report):
            return self._report(float(self._done), float(self._most)) is not False
        now = time.monotonic()
        if now - self._started > PATIENCE and now - self._shown > RENEWED:
            self._shown, self._line = now, True
            sys.stderr.write(f"\r{self._done:,} orbits, {self._path} = {value:.6g} ")
            sys.stderr.flush()
        return True

    def close(self) -> None:
        """End the line, if there is one."""
        if self._line:
            sys.stderr.write("\n")
