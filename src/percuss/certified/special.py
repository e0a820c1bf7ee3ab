"""Special points of branches proven: the parameter of a fold, a period doubling or a graze."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from flint import arb

from percuss.certified.balls import Ball
from percuss.certified.crossing import crossing_of
from percuss.certified.fold import fold_of
from percuss.certified.numbers import precision
from percuss.certified.touch import touch_of
from percuss.certified.undecided import Undecided
from percuss.model.paths import long_form
from percuss.orbits.families.special_points import SpecialPoint

__all__ = ["CertifiedPoint", "certify_point"]

FIRST_MARGIN = 80


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedPoint:
    """A special point whose parameter is enclosed; made by `certify`.

    Attributes
    ----------
    kind, path
        Those of the point.
    exists
        Whether it is proven to be there.
    value
        The parameter: without a number if it is not proven.
    statement
        What is proven, in words.
    reason
        What is open, and why.
    wanted_digits, precision
        The digits that were asked for, and the bits that were worked with.
    """

    kind: str
    path: str
    exists: bool
    value: Ball
    statement: str
    reason: str
    wanted_digits: int
    precision: int
    point: SpecialPoint = field(repr=False)

    def __repr__(self) -> str:
        """Tell in a line what is proven."""
        if not self.exists:
            return f"<CertifiedPoint: {self.kind} not proven; {self.reason}>"
        return f"<CertifiedPoint: {self.kind} at {self.path} = {self.value.text()}>"


def certify_point(
    point: SpecialPoint, digits: int, most_bits: int, bits: int | None
) -> CertifiedPoint:
    """Prove a special point; see `percuss.certify`."""
    path = long_form(point.path, point.orbit.oscillator, point.orbit.forcing)
    work = bits or math.ceil(digits / math.log10(2)) + FIRST_MARGIN
    while True:
        try:
            with precision(work):
                value, statement = _proof(point, path, digits)
        except Undecided as question:
            if bits is not None or 2 * work > most_bits:
                nothing = Ball(arb.nan())
                return CertifiedPoint(
                    point.kind, path, False, nothing, "", question.reason, digits, work, point
                )
            work *= 2
            continue
        return CertifiedPoint(point.kind, path, True, value, statement, "", digits, work, point)


def _proof(point: SpecialPoint, path: str, digits: int) -> tuple[Ball, str]:
    if point.kind == "fold":
        return Ball(fold_of(point, path, digits)), (
            "on a smooth curve of orbits, along which the parameter is extremal in the ball, a "
            "multiplier goes through 1 there"
        )
    if point.kind in ("period_doubling", "strong_resonance"):
        return Ball(crossing_of(point, path, digits)), (
            "on a smooth branch of orbits over the ball, the trace goes through the value of a "
            f"{point.kind.replace('_', ' ')} there"
        )
    if point.kind == "grazing":
        return Ball(touch_of(point, path, digits)), (
            "on a smooth branch of orbits over the ball, a turning point passes the stop there"
        )
    raise Undecided("precision", f"no proof is known here for a {point.kind.replace('_', ' ')}")
