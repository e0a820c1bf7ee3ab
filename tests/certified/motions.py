"""Motions that several tests prove."""

from __future__ import annotations

import percuss as pc

ELASTIC = pc.impact_oscillator()


def chaotic(n: int) -> pc.Trajectory:
    """Return the chaotic motion of so many impacts."""
    osc = pc.impact_oscillator("0.8", side="above")
    return pc.simulate(osc, pc.cosine("2.8"), v0=-1, max_impacts=n)
