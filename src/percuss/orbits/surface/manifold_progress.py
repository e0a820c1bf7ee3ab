"""Telling how far a row of equal pieces of work has come."""

from __future__ import annotations

from percuss.motion.progress import Report, Told

__all__ = ["Teller"]


class Teller:
    """Reports (done, total) pieces; `stopped` once the caller wants no more."""

    def __init__(self, report: Report, total: int) -> None:
        self._told, self._total = Told(report), float(total)
        self._done, self.stopped = 0.0, False

    def go_on(self, part: float) -> bool:
        """Report that a part of the next piece is done; False if no more is wanted."""
        done = self._done + min(part, 1.0)
        if not self.stopped:
            text = f"{done / self._total:6.1%}"
            self.stopped = not self._told.tell(done, self._total, lambda: text)
        return not self.stopped

    def finish_one(self) -> None:
        """Count a piece as done."""
        self._done += 1.0
        self.go_on(0.0)

    def close(self) -> None:
        """End the line, if there is one."""
        self._told.close()
