"""Words that the reports of several kinds of studies share."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["counted", "ends_of", "failure_rows", "impacts_in_words", "intervals_in_words"]

# The last part of a traceback says most.
LONGEST = 160


def counted(n: float, thing: str) -> str:
    """Return a number and what it counts.

    Examples
    --------
    >>> counted(1, "impact"), counted(1200.0, "impact")
    ('1 impact', '1,200 impacts')
    """
    return f"{int(n):,} {thing}" + ("" if n == 1 else "s")


def impacts_in_words(n_impacts: float) -> str:
    """Return a number of impacts in words."""
    return "sticking" if math.isinf(n_impacts) else counted(n_impacts, "impact")


def intervals_in_words(intervals: Any) -> str:
    """Return intervals of a parameter in words."""
    return ", ".join(f"{low:.6g} to {high:.6g}" for low, high in intervals)


def failure_rows(reasons: list[str], n_points: int) -> dict[str, str]:
    """Return how many points have no answer, and why."""
    if not reasons:
        return {}
    from percuss.ensembles.datasets import commonest

    reason, count, others = commonest(reasons)
    more = f"; other reasons: {others}" if others else ""
    words = f"{len(reasons)} of {n_points}: {reason[:LONGEST]} ({count}){more}"
    return {"without answer": words}


def ends_of(data: Dataset) -> str:
    """Return the axes of a dataset with their ends."""
    return ", ".join(
        f"{dim} from {float(values.min()):.6g} to {float(values.max()):.6g} ({values.size})"
        for dim, values in ((dim, data[dim].values) for dim in data.coords)
        if values.dtype.kind == "f"
    )
