"""Telling how far a row of equal pieces of work has come."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

__all__ = ["Teller"]

# A line appears only for what takes longer than this [s].
PATIENCE = 2.0


class Teller:
    """Reports (done, total) pieces; `stopped` once the caller wants no more."""

    def __init__(self, report: bool | Callable[[float, float], bool] | None, total: int) -> None:
        self._report, self._total = report, float(total)
        self._done, self.stopped = 0.0, False
        self._started, self._line = time.monotonic(), False

    def go_on(self, part: float) -> bool:
        """Report that a part of the next piece is done; False if no more is wanted."""
        done = self._done + min(part, 1.0)
        if callable(self._report):
            self.stopped = self.stopped or self._report(done, self._total) is False
        elif self._report and time.monotonic() - self._started > PATIENCE:
            self._line = True
            sys.stderr.write(f"\r{done / self._total:6.1%} ")
            sys.stderr.flush()
        return not self.stopped

    def finish_one(self) -> None:
        """Count a piece as done."""
        self._done += 1.0
        self.go_on(0.0)

    def close(self) -> None:
        """End the line, if there is one."""
        if self._line:
            sys.stderr.write("\n")
