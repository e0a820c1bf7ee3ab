"""Telling how far a search of many steps has come."""

from __future__ import annotations

from percuss.motion.progress import Report, Told

__all__ = ["Report", "Steps"]


class Steps:
    """Reports (done, total) steps; `stopped` once the caller wants no more."""

    def __init__(self, report: Report, total: int) -> None:
        self.total, self.done, self.stopped = total, 0, False
        self._told = Told(report)

    def go_on(self, what: str) -> bool:
        """Count a step, tell what is being done, and return whether to go on."""
        self.done += 1
        self.total = max(self.total, self.done)
        if not self.stopped:
            share = self.done / self.total
            text = f"{share:6.1%}  {what:<60.60}"
            self.stopped = not self._told.tell(self.done, self.total, lambda: text)
        return not self.stopped

    def close(self) -> None:
        """End the line, if there is one."""
        self._told.close()
