"""Telling how far a search of many steps has come."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

__all__ = ["Report", "Steps"]

Report = bool | Callable[[float, float], bool] | None

# A line appears only for what takes longer than this [s], and is renewed this often.
PATIENCE = 2.0
RENEWED = 0.2


class Steps:
    """Reports (done, total) steps; `stopped` once the caller wants no more."""

    def __init__(self, report: Report, total: int) -> None:
        self.total, self.done, self.stopped = total, 0, False
        self._report = report
        self._started = self._shown = time.monotonic()
        self._line = False

    def go_on(self, what: str) -> bool:
        """Count a step, tell what is being done, and return whether to go on."""
        self.done += 1
        self.total = max(self.total, self.done)
        if callable(self._report):
            self.stopped = self.stopped or self._report(self.done, self.total) is False
        elif self._report:
            self._show(what)
        return not self.stopped

    def close(self) -> None:
        """End the line, if there is one."""
        if self._line:
            sys.stderr.write("\n")

    def _show(self, what: str) -> None:
        now = time.monotonic()
        if now - self._started > PATIENCE and now - self._shown > RENEWED:
            self._shown, self._line = now, True
            sys.stderr.write(f"\r{self.done / self.total:6.1%}  {what:<60.60}")
            sys.stderr.flush()
