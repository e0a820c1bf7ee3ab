"""A rectangle is divided until something is proven on each of its parts.

Proven here: the parts on which something is proven are together all of the rectangle, edges
included, since both halves of a part have the cut between them. What is to be proven, and why it
suffices to prove it on parts, is said where it is asked for. Section 11.8 of
docs/theory/certified.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import TypeVar

from arithmetic import HopelessError, NotProvenError
from words import told

Side = tuple[Fraction, Fraction]
Rectangle = tuple[Side, Side]
Proven = TypeVar("Proven")


def proven_on_parts(
    whole: Rectangle,
    proven: Callable[[Rectangle], Proven | None],
    said: str,
    smallest: Fraction,
    lengths: tuple[Fraction, Fraction] | None = None,
) -> Iterator[Proven]:
    """Yield what is proven on parts of a rectangle: of each the half, while it is None or not proven.

    The longer side is halved: in units of that of the whole, unless their ``lengths`` are said. A
    part of which both sides are below ``smallest``, in units of those of the whole, is not divided:
    that is an error, which says where.
    """
    sizes = [high - low for low, high in whole]
    parts = [whole]
    while parts:
        part, reason = parts.pop(), ""
        try:
            found = proven(part)
        except NotProvenError as error:
            found, reason = None, f": {error}"
        if found is not None:
            yield found
            continue
        ratios = [(high - low) / size for (low, high), size in zip(part, sizes, strict=True)]
        first, second = part
        middles = [(low + high) / 2 for low, high in part]
        if max(ratios) < smallest:
            raise HopelessError(f"{said}, at {told(middles[0])}, {told(middles[1])}{reason}")
        if lengths is not None:
            ratios = [ratio * length for ratio, length in zip(ratios, lengths, strict=True)]
        if ratios[0] >= ratios[1]:
            halves = (first[0], middles[0]), (middles[0], first[1])
            parts += [(half, second) for half in halves]
        else:
            halves = (second[0], middles[1]), (middles[1], second[1])
            parts += [(first, half) for half in halves]
