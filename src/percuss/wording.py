"""How numbers and values stand in sentences."""

from __future__ import annotations

import math
from collections.abc import Iterable

# Characters of a value that a sentence shows.
MOST_SHOWN = 200


def counted(n: float, noun: str) -> str:
    """Return a number and the noun that it counts.

    Parameters
    ----------
    n
        A whole number, or infinity.
    noun
        In the singular; its plural ends in s.

    Returns
    -------
    str
        Both, in words for a sentence.

    Examples
    --------
    >>> counted(1, "impact"), counted(1200.0, "impact"), counted(float("inf"), "impact")
    ('1 impact', '1,200 impacts', 'inf impacts')
    """
    return f"{n:,.0f} {noun}" + ("" if n == 1 else "s")


def impacts_in_words(n_impacts: float) -> str:
    """Return a number of impacts in words; infinitely many are those of a sticking motion."""
    return "sticking" if math.isinf(n_impacts) else counted(n_impacts, "impact")


def counts_in_words(n_impacts: float, n_periods: int) -> str:
    """Return the impacts and forcing periods of an orbit in words."""
    periods = f" in {counted(n_periods, 'forcing period')}" if n_periods else ""
    return impacts_in_words(n_impacts) + periods


def closest(word: str, known: Iterable[str]) -> str | None:
    """Return the name that a misspelt word means, None where none is like it.

    Examples
    --------
    >>> closest("peroid", ["period", "multiplier"]), closest("depth", ["period", "multiplier"])
    ('period', None)
    """
    import difflib  # only where something is wrong

    return next(iter(difflib.get_close_matches(word, list(known), n=1)), None)


def shown(value: object) -> str:
    """Return a value as Python writes it, cut where that is long.

    Numbers of NumPy are shown as numbers, in tuples and lists, too.

    Examples
    --------
    >>> import numpy as np
    >>> shown("2.8"), len(shown("2" * 10_000)), shown((2, np.float64(0.5)))
    ("'2.8'", 224, '(2, 0.5)')
    """
    try:
        text = repr(_plain(value))
    except ValueError:  # a whole number of more digits than Python writes
        text = f"{type(value).__name__} of too many digits"
    if len(text) <= MOST_SHOWN:
        return text
    return f"{text[:MOST_SHOWN]} ... ({len(text):,} characters)"


def _plain(value: object) -> object:
    """Return a value with numbers and texts of Python in the place of those of NumPy."""
    if isinstance(value, dict):
        return {_plain(key): _plain(entry) for key, entry in value.items()}
    if type(value) in (tuple, list):
        return type(value)(map(_plain, value))  # type: ignore[call-arg, call-overload]
    # Arrays are shown as they are.
    if type(value).__module__ == "numpy" and type(value).__name__ != "ndarray":
        return value.item() if hasattr(value, "item") else value
    return value
