"""Statements 6. (a) to (f): what the paper says in words of periodicity, resonance and chaos."""

from __future__ import annotations

from percuss.paper.claims import (
    divergence,
    impact_time_sets,
    poincare,
    third_harmonic_family,
    third_harmonic_lines,
)
from percuss.paper.claims.half_harmonic_growth import SUBHARMONIC_STATEMENTS
from percuss.paper.statement import Statement

STATEMENTS: tuple[Statement, ...] = (
    *third_harmonic_family.STATEMENTS,
    *third_harmonic_lines.STATEMENTS,
    *impact_time_sets.STATEMENTS,
    *SUBHARMONIC_STATEMENTS,
    *divergence.STATEMENTS,
    *poincare.STATEMENTS,
)
