"""What a march in balls writes down."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from typing import NamedTuple

from flint import arb

from percuss.certified.contact import Hold, Hops
from percuss.certified.step import Departure
from percuss.model.exact import Phase

__all__ = ["ContactRow", "CrossingRow", "Ending", "GrazeRow", "ImpactRow", "MarchRecord", "Piece"]


class Ending(Enum):
    """How a proof ended; the value is the sentence to show.

    Examples
    --------
    >>> Ending.graze.value
    'the proof ends at a touch that the balls cannot decide'
    """

    reached_t_end = "proven up to t_end"
    reached_max_impacts = "proven up to max_impacts (impacts and entries into soft stops)"
    at_rest = "the mass provably came to rest at a stop for good"
    impact_at_t_end = "proven up to t_end; the last event lies within its radius of it"
    graze = "the proof ends at a touch that the balls cannot decide"
    force = "the proof ends at rest on a stop, where the sign of the force is open"
    chatter = "the proof ends in a chatter whose end lies within the radius, or too far"
    no_event = "the proof ends in a flight in which no event was found"
    most_events = "the proof ends after the most events that are listed"
    interrupted = "the proof was interrupted; it holds what was done"
    precision = "the proof ends where the balls have grown too wide"


class ImpactRow(NamedTuple):
    """An impact."""

    t: arb
    v_before: arb
    v_after: arb
    stop: int


class CrossingRow(NamedTuple):
    """A crossing of the edge of a soft stop."""

    t: arb
    v: arb
    stop: int
    direction: str


class ContactRow(NamedTuple):
    """A contact; the release is None if it did not come."""

    start: arb
    release: arb | None
    stop: int
    n_impacts: int


class GrazeRow(NamedTuple):
    """A touch that the balls cannot decide."""

    t: arb
    stop: int
    clearance: arb


class Piece(NamedTuple):
    """A flight, a contact or the rest of a chatter, from an instant on."""

    start: arb
    what: Departure | Hold | Hops


@dataclass
class MarchRecord:
    """Events and pieces of a march, and how it ended.

    ``width`` is a time in which little changes: the scale of instants near 0. ``begin`` and ``end``
    are the times of start and limit where they are known exactly.
    """

    bits: int
    width: float = 1.0
    impacts: list[ImpactRow] = field(default_factory=list)
    crossings: list[CrossingRow] = field(default_factory=list)
    contacts: list[ContactRow] = field(default_factory=list)
    grazes: list[GrazeRow] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    until: arb = field(default_factory=lambda: arb(0))
    ending: Ending = Ending.reached_t_end
    reason: str = ""
    n_entries: int = 0
    begin: Phase | None = None
    end: Phase | None = None
    _earliest: list[float] = field(default_factory=list, repr=False)

    @property
    def accumulations(self) -> int:
        """How many chatters end."""
        return sum(isinstance(piece.what, Hops) for piece, _ in pairwise(self.pieces))

    def earliest(self) -> list[float]:
        """Return, for each piece, a float before which neither it nor a later one begins."""
        if len(self._earliest) != len(self.pieces):
            found, least = [], math.inf
            for piece in reversed(self.pieces):
                low = math.nextafter(float(piece.start.lower()), -math.inf)
                least = min(least, low)
                found.append(least)
            self._earliest = found[::-1]
        return self._earliest
