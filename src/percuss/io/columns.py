"""Results as columns of equal length, for CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

    from percuss.orbits.bifurcations.branch import Branch
    from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Columns", "branch_columns", "columns_along", "dataset_columns", "orbit_columns"]

Columns: TypeAlias = Mapping[str, NDArray[Any]]

# What the columns of runs and orbits are measured in; digits at their ends do not count.
MEASURES = {
    "t": "time",
    "period": "time",
    "v": "velocity",
    "v_before": "velocity",
    "v_after": "velocity",
    "impulse": "velocity",
    "impact_velocity_": "velocity",
    "min_impact_speed": "velocity",
    "x": "length",
    "grazing_margin": "length",
}


def orbit_columns(orbits: Sequence[PeriodicOrbit]) -> Columns:
    """Return orbits as a table, one row an orbit."""
    names = (
        "n_impacts",
        "n_periods",
        "period",
        "t0",
        "x0",
        "v0",
        "min_impact_speed",
        "grazing_margin",
        "stability",
        "admissible",
        "isolated",
        "residual",
    )
    found = {name: np.array([getattr(orbit, name) for orbit in orbits], dtype=object)
             for name in names}  # fmt: skip
    multipliers = np.array([orbit.multipliers for orbit in orbits]).reshape(-1, 2)
    found |= _of_multipliers(multipliers)
    stops = [" ".join(map(str, orbit.sequence)) for orbit in orbits]
    return found | {"stops": np.array(stops, dtype=object)}


def branch_columns(branch: Branch) -> Columns:
    """Return a branch as a table, one row an orbit."""
    special = np.full(len(branch), "", dtype=object)
    for point in branch.special_points:
        special[point.row] = point.kind
    velocities = {
        f"impact_velocity_{i}": column for i, column in enumerate(branch.impact_velocity.T)
    }
    return {
        branch.path: branch.values,
        "arclength": branch.arclength,
        **velocities,
        **_of_multipliers(branch.multipliers),
        "stability": branch.stability,
        "admissible": branch.admissible,
        "grazing_margin": branch.grazing_margin,
        "special_point": special,
    }


def _of_multipliers(multipliers: NDArray[np.complex128]) -> dict[str, NDArray[Any]]:
    return {
        f"multiplier_{i}_{part}": np.asarray(getattr(multipliers[:, i], part))
        for i in range(2)
        for part in ("real", "imag")
    }


def columns_along(data: Dataset, dim: str) -> Columns:
    """Return the variables of one dimension as a table."""
    found = {dim: np.arange(data.sizes[dim])}
    one = {str(name): it.values for name, it in data.data_vars.items() if it.dims == (dim,)}
    return found | one


def dataset_columns(data: Dataset) -> Columns:
    """Return the variables of the most dimensions as a table, one row a point of them all.

    Variables of fewer dimensions are repeated along the others; those of none of these are left
    out, as the coordinates without numbers are.
    """
    widest = max((variable for variable in data.data_vars.values()), key=lambda it: it.size)
    dims = widest.dims
    shape = widest.shape
    found: dict[str, NDArray[Any]] = {}
    for i, dim in enumerate(dims):
        values = data[dim].values if dim in data.coords else np.arange(shape[i])
        along = values.reshape([-1 if k == i else 1 for k in range(len(dims))])
        found[str(dim)] = np.broadcast_to(along, shape).ravel()
    for name, variable in data.data_vars.items():
        if variable.dims and set(variable.dims) <= set(dims):
            wide = variable.broadcast_like(widest).transpose(*dims)
            found[str(name)] = wide.values.ravel()
    return found
