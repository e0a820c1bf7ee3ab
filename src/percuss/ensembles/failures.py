"""What has no answer, and the one sentence that says so."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterable

__all__ = ["commonest", "warn_of_failures", "warn_of_some"]

# Reasons that differ in their numbers only are one.
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?")


def commonest(reasons: Iterable[str]) -> tuple[str, int, int]:
    """Return the commonest reason, of how many points it is one, and how many others there are.

    Parameters
    ----------
    reasons
        One for each point without an answer, at least one; of a traceback the last line counts.

    Returns
    -------
    tuple of str, int and int
        Reasons that differ in their numbers only are one; the first of them stands for all.

    Examples
    --------
    >>> commonest(["x0 = -1: below the wall", "x0 = -2: below the wall", "damping = -1: negative"])
    ('x0 = -1: below the wall', 2, 1)
    """
    lines = [(text.strip().splitlines() or [""])[-1] for text in reasons]
    kinds = [NUMBER.sub("#", line) for line in lines]
    (kind, count), *others = Counter(kinds).most_common()
    return lines[kinds.index(kind)], count, len(others)


def warn_of_some(
    those: str, reasons: Iterable[str], total: int, first: str, stacklevel: int = 3
) -> None:
    """Warn that some have no answer: how many of how many, where the first is, and why.

    Parameters
    ----------
    those
        What they are, in the plural.
    reasons
        One for each of them, at least one.
    total
        How many there are with the others.
    first
        The parameters of the first of them.
    stacklevel
        As in `warn_of_failures`.
    """
    given = list(reasons)
    what = f"{len(given):,} of {total:,} {those} have no answer, the first at {first}"
    warn_of_failures(what, given, stacklevel + 1)


def warn_of_failures(what: str, reasons: Iterable[str], stacklevel: int = 3) -> None:
    """Warn that there is no answer, with the commonest reason and its count.

    Parameters
    ----------
    what
        The beginning of the sentence: what has no answer, and for how many points.
    reasons
        One for each of them.
    stacklevel
        As `warnings.warn` takes it; by default whoever calls the function that calls this one.
    """
    given = list(reasons)
    reason, count, others = commonest(given)
    which = "the commonest reason" if others else "the reason"
    message = f"{what}; {which} ({count:,} of {len(given):,}): {reason}"
    warnings.warn(message, stacklevel=stacklevel)
