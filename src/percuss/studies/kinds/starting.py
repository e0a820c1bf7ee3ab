"""Starts of studies without a limit of their own."""

from __future__ import annotations

from percuss.model.faults import draft
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, start_faults
from percuss.studies.kinds.motion import right_walls, start_of
from percuss.studies.parts import Parts, add_faults

__all__ = ["AT_REST", "checked_start"]

AT_REST = Start(0.0, 0.0)


def checked_start(parts: Parts) -> Start:
    """Return the start of a document, at rest at 0 where it has none; add what is wrong."""
    if "start" not in parts.document:
        start, place = AT_REST, None
    else:
        start, place = start_of(parts), "start"
    walls = draft(Oscillator, stops=right_walls(parts.oscillator, parts.found))
    wrong = start_faults(walls, start.x0, start.v0, start.t0, max_impacts=1, start=place)
    if place is not None:
        add_faults(wrong, parts.found)
    elif wrong:
        parts.found.add(("start",), f"missing; the default x0 = 0 lies {wrong[0].reason}")
    return start
