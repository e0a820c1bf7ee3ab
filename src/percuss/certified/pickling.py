"""Balls of python-flint that can be pickled and copied, which it brings no way for.

Midpoints stay as they are; radii are rounded up, in the last of 30 bits.
"""

from __future__ import annotations

import copyreg

from flint import acb, arb

__all__: list[str] = []

MantissaExponent = tuple[int, int]


def _parts(value: arb) -> MantissaExponent:
    mantissa, exponent = value.man_exp()
    return int(mantissa), int(exponent)


def _taken_apart(value: arb) -> tuple[object, tuple[object, ...]]:
    if value.is_finite():
        return arb, (_parts(value.mid()), _parts(value.rad()))
    if value == arb.pos_inf() or value == arb.neg_inf():
        return arb, ("inf" if value > 0 else "-inf",)
    return arb, ("nan",) if value.is_nan() else (0, "inf")


copyreg.pickle(arb, _taken_apart)  # type: ignore[arg-type]
copyreg.pickle(acb, lambda value: (acb, (value.real, value.imag)))
