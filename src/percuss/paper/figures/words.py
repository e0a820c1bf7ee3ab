"""Numbers in the sentences of captions."""

from __future__ import annotations


def within(difference: float) -> str:
    """Return how closely two numbers agree, in words.

    Examples
    --------
    >>> within(2.34e-15), within(0.0)
    ('within 2.3e-15', 'to the last bit')
    """
    return f"within {difference:.1e}" if difference else "to the last bit"
