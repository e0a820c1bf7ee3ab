"""Numbers and equations in words.

Nothing is proven here, and nothing that is proven depends on it: it is how a theorem is said, and
of what. Decimals are rounded down, as the theorem says. What theorems say is section 11.1 of
docs/theory/certified.md.
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor
from typing import Any

# Numbers of a certificate have no more digits, and can therefore be printed.
DIGITS = 2000


def told(value: Fraction, digits: int = 9) -> str:
    """Return a number with some digits, rounded down."""
    sign, whole = ("-", -value) if value < 0 else ("", value)
    if whole >= 10**DIGITS:
        return f"{sign}10^{DIGITS} and more"
    number, unit = floor(whole * 10**digits), 10**digits
    return f"{sign}{number // unit}.{number % unit:0{digits}d}".rstrip("0").rstrip(".")


def near(pair: tuple[Fraction, Fraction]) -> str:
    """Return two numbers with as many digits as tell them apart."""
    digits = max(9, len(str(ceil(1 / (pair[1] - pair[0]))))) if pair[0] < pair[1] else 9
    return f"{told(pair[0], digits)}... and {told(pair[1], digits)}..."


def counted(n: int, one: str, several: str = "") -> str:
    return f"{n} {one if n == 1 else several or one + 's'}"


def phase_in_words(pair: tuple[Fraction, Fraction]) -> str:
    times, plus = pair
    return f"{times} pi + {plus}" if times else str(plus)


def equation(law: Any) -> str:
    """Return what moves, as a certificate says it."""
    force = " + ".join(
        f"{_said(tone['amplitude'])} cos({_said(tone['omega'])} t + {phase_in_words(tone['phase'])})"
        for tone in law["tones"]
    )
    lines, bounds = [], law["bounds"]
    for region in law["regions"]:
        low = "-oo" if region["lower"] is None else _said(bounds[region["lower"]]["at"])
        high = "oo" if region["upper"] is None else _said(bounds[region["upper"]]["at"])
        drag = _said(region["damping"], 2)
        spring, constant = _said(region["stiffness"]), _said(region["constant"])
        lines.append(
            f"  for {low} < x < {high}: x'' + {drag} x' + {spring} x = "
            f"{constant}{f' + {force}' if force else ''}"
        )
    for i, bound in enumerate(bounds):
        if bound["restitution"] is not None:
            r = _said(bound["restitution"])
            lines.append(f"  at x = {_said(bound['at'])} (bound {i}): x' becomes -{r} x'")
    return "\n".join(lines)


def _said(number: Any, times: int = 1) -> str:
    if not isinstance(number, tuple):
        return str(times * number)
    a, b = (times * part for part in number)
    return "p" if (a, b) == (0, 1) else f"({a} + {b} p)"
