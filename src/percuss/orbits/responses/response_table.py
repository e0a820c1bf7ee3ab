"""The columns of a response chart as one table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from percuss.orbits.families.branch import Branch
from percuss.orbits.responses.response_search import SeenAttractor

__all__ = ["attractor_rows_of", "kinds_of", "rows_of", "special_rows_of"]

Floats = NDArray[np.float64]


def kinds_of(branch: Branch) -> NDArray[np.int64]:
    """Return (forcing periods, impacts) of each row: at soft stops impacts come and go."""
    return np.array([(orbit.n_periods, orbit.n_impacts) for orbit in branch], dtype=np.int64)


def rows_of(
    path: str, branches: Sequence[Branch], quantities: Mapping[str, Sequence[Floats]]
) -> dict[str, Any]:
    """Return the columns of all rows of all branches."""
    counts = [len(branch) for branch in branches]

    def joined(parts: Iterable[NDArray[Any]], kind: type) -> NDArray[Any]:
        return np.concatenate([np.empty(0, dtype=kind), *parts])

    each = {
        "branch": joined((np.full(n, k) for k, n in enumerate(counts)), int),
        "n_impacts": joined((kinds_of(b)[:, 1] for b in branches), int),
        "n_periods": joined((kinds_of(b)[:, 0] for b in branches), int),
        "value": joined((b.values for b in branches), float),
        **{name: joined(columns, float) for name, columns in quantities.items()},
        "stability": joined((b.stability.astype(str) for b in branches), str),
        "admissible": joined((b.admissible for b in branches), bool),
    }
    found: dict[str, Any] = {name: ("point", column) for name, column in each.items()}
    found["value"] = ("point", each["value"], {"long_name": path})
    return found


def special_rows_of(branches: Sequence[Branch]) -> dict[str, Any]:
    """Return the columns of the special points."""
    points = [(k, point) for k, b in enumerate(branches) for point in b.special_points]
    return {
        "special_branch": ("special_point", np.array([k for k, _ in points], dtype=int)),
        "special_kind": ("special_point", np.array([p.kind for _, p in points], dtype=str)),
        "special_value": ("special_point", np.array([p.value for _, p in points], dtype=float)),
        "special_row": ("special_point", np.array([p.row for _, p in points], dtype=int)),
    }


def attractor_rows_of(seen: Sequence[SeenAttractor]) -> dict[str, Any]:
    """Return the columns of the attractors."""
    on = [-1 if it.branch is None else it.branch for it in seen]
    return {
        "attractor_value": ("attractor", np.array([it.value for it in seen], dtype=float)),
        "attractor_n_impacts": ("attractor", np.array([it.n_impacts for it in seen], dtype=float)),
        "attractor_n_periods": ("attractor", np.array([it.n_periods for it in seen], dtype=int)),
        "attractor_branch": ("attractor", np.array(on, dtype=int), {"none": -1}),
        "attractor_amplitude": (
            "attractor",
            np.array([it.extremes.amplitude for it in seen], dtype=float),
        ),
        "attractor_impact_velocity": (
            "attractor",
            np.array([it.impact_speed for it in seen], dtype=float),
        ),
    }
