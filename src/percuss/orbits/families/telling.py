"""Telling how far a branch has been followed."""

from __future__ import annotations

from percuss.motion.progress import Report, Told

__all__ = ["Report", "Telling"]


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
        self._told, self._most, self._path = Told(report), most, path
        self._done = 0

    def go_on(self, value: float) -> bool:
        """Report one orbit more, at a value of the parameter; False to stop."""
        self._done += 1
        text = f"{self._done:,} orbits, {self._path} = {value:.6g}"
        return self._told.tell(float(self._done), float(self._most), lambda: text)

    def close(self) -> None:
        """End the line, if there is one."""
        self._told.close()
