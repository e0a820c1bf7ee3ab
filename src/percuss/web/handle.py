"""A question in work, seen from both sides: how far it is, and whether it is still wanted."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Handle"]


@dataclass(slots=True)
class Handle:
    """How far the answer to a question is.

    Attributes
    ----------
    is_stopped
        Whether nobody wants the answer any more.
    share
        How much of it is done, from 0 to 1.
    """

    is_stopped: bool = False
    share: float = 0.0

    def part(self, begin: float, end: float) -> Part:
        """Return what a long call reports to, for its part of the whole."""
        return Part(self, begin, end)


@dataclass(frozen=True, slots=True)
class Part:
    """The progress of one of several calls: ``progress=`` of a long call."""

    handle: Handle
    begin: float
    end: float

    def __call__(self, done: float, total: float) -> bool:
        """Note how far the call is, and return whether to go on."""
        share = done / total if total else 1.0
        self.handle.share = self.begin + (self.end - self.begin) * share
        return not self.handle.is_stopped
