"""What ends a proof."""

from __future__ import annotations

from typing import Any, NamedTuple

__all__ = ["Touch", "Undecided"]


class Touch(NamedTuple):
    """Where a touch is that is open: between two times of a flight, at a bound, how near.

    The times are floats or exact arbs.
    """

    low: Any
    high: Any
    bound: int
    clearance: float


class Undecided(Exception):  # noqa: N818
    """A question that the balls leave open; caught inside `percuss.certified`.

    Parameters
    ----------
    kind
        Name of the `Ending` that it leads to if more bits do not help.
    reason
        What is open, in a sentence with its numbers.
    touch
        Where, for a touch in a flight.
    """

    def __init__(self, kind: str, reason: str, touch: Touch | None = None) -> None:
        super().__init__(kind, reason)
        self.kind = kind
        self.reason = reason
        self.touch = touch
