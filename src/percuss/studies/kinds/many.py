"""What studies of many motions share: their means, their files, what failed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from percuss.model.exact import Phase
from percuss.studies.axes import Axis, axis_values
from percuss.studies.question import Means

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["Whole", "ends_of", "failure_rows", "means_of", "over_of"]

# A whole number of at least 0.
Whole = Annotated[int, Field(ge=0)]
# The last part of a traceback tells most.
LONGEST = 160


def means_of(means: Means) -> dict[str, Any]:
    """Return the means as ensembles take them."""
    return {"store": means.store, "engine": means.engine, "progress": means.progress}


def over_of(over: dict[str, Axis]) -> dict[str, list[Phase]]:
    """Return axes as ensembles take them."""
    return {path: list(axis_values(axis)) for path, axis in over.items()}


def failure_rows(reasons: list[str], n_points: int) -> dict[str, str]:
    """Return how many points have no answer, and why."""
    if not reasons:
        return {}
    from percuss.ensembles.datasets import commonest

    reason, count, others = commonest(reasons)
    words = reason[:LONGEST]
    more = f"; other reasons: {others}" if others else ""
    return {"without answer": f"{len(reasons)} of {n_points}: {words} ({count}){more}"}


def ends_of(data: Dataset) -> str:
    """Return the axes with their ends."""
    return ", ".join(
        f"{dim} from {float(values.min()):.6g} to {float(values.max()):.6g} ({values.size})"
        for dim, values in ((dim, data[dim].values) for dim in data.coords)
        if values.dtype.kind == "f"
    )
