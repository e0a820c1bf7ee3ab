"""The exact place that a start is at."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from percuss.certified.system import System
from percuss.model.exact import as_fraction
from percuss.model.start import Start

__all__ = ["moved_in_words", "on_stop", "start_used"]


def on_stop(system: System, start: Start) -> Fraction:
    """Return the exact position of a start: of a float that a stop's place becomes, that place.

    `simulate` takes such a start as one on the stop. What is given as text or as a fraction is
    where it was given, by however little beside the stop.
    """
    x = as_fraction(start.x0)
    if isinstance(start.x0, float):
        for bound in system.bounds:
            if float(bound.at) == start.x0:
                return bound.at
    return x


def start_used(system: System, start: Start) -> Start:
    """Return the start that a proof is about.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.certified.system import system_of
    >>> start_used(system_of(pc.impact_oscillator(wall="0.3"), None), pc.Start(0.3, 1))
    Start(x0=Fraction(3, 10), v0=1, t0=0.0)
    """
    x = on_stop(system, start)
    return start if x == as_fraction(start.x0) else replace(start, x0=x)


def moved_in_words(used: Start, given: Start) -> str:
    """Return the end of a line that says that a start was moved to a stop; empty if it was not."""
    if used == given:
        return ""
    return f"; started on the stop, at x0 = {used.x0} for {given.x0}"
