"""A question in work, seen from both sides: how far it is, and whether it is still wanted."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from percuss.web.turns import Turn

__all__ = ["Handle", "Part"]


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
    _turn: Turn | None = None
    _spent: float = 0.0
    _began: float = field(default_factory=time.monotonic)

    def part(self, begin: float, end: float, seconds: float = math.inf) -> Part:
        """Return what a long call reports to, for its part of the whole.

        It ends the call after so much time of work [s], too.
        """
        return Part(self, begin, end, self.seconds() + seconds)

    def seconds(self) -> float:
        """Return how long the answer has been in work, without waits for others [s]."""
        if self._turn is not None:
            return self._spent + self._turn.seconds()
        return self._spent or time.monotonic() - self._began

    def go_on(self) -> bool:
        """Let others go first where it is their turn; return whether the answer is wanted."""
        if self._turn is not None and not self._turn.pause():
            self.is_stopped = True
        return not self.is_stopped

    @contextmanager
    def during(self, turn: Turn) -> Iterator[None]:
        """Work in a turn."""
        self._turn = turn
        try:
            yield
        finally:
            self._turn = None
            self._spent += turn.seconds()


@dataclass(frozen=True, slots=True)
class Part:
    """The progress of one of several calls: ``progress=`` of a long call."""

    handle: Handle
    begin: float
    end: float
    until: float = math.inf

    def __call__(self, done: float, total: float) -> bool:
        """Note how far the call is, and return whether to go on."""
        share = done / total if total else 1.0
        self.handle.share = self.begin + (self.end - self.begin) * share
        return self.handle.go_on() and self.handle.seconds() < self.until
