"""The events of a run of percuss, or of an oracle that has the same tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

# Slower impacts belong to a chatter's tail, which the oracles list further than percuss.
SLOW = 1e-3


class Told(NamedTuple):
    """An event, with the velocity before an impact; an instant is of the type of its table."""

    t: Any
    kind: str
    stop: int
    v: Any


def events_of(run: Any, *, slowest: float = 0.0) -> Iterator[Told]:
    """Yield the events of a run, kind by kind, without impacts below a speed."""
    impacts, crossings, contacts = run.impacts, run.crossings, run.contacts
    for t, stop, v in zip(impacts.t, impacts.stop, impacts.v_before, strict=True):
        if abs(v) >= slowest:
            yield Told(t, "impact", int(stop), v)
    columns = crossings.t, crossings.direction, crossings.stop, crossings.v
    for t, direction, stop, v in zip(*columns, strict=True):
        yield Told(t, str(direction), int(stop), v)
    for kind, times in (("rest", contacts.start), ("release", contacts.release)):
        for t, stop in zip(times, contacts.stop, strict=True):
            if not math.isnan(t):
                yield Told(t, kind, int(stop), 0.0)
