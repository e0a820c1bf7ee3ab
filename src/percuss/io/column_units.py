"""The units of the columns of tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from numpy.typing import NDArray

from percuss.ensembles.measures import outcome_dimensions
from percuss.model.dimensions import dimensions_of
from percuss.model.units import Units, is_unit

__all__ = ["Columns", "units_of_columns"]

Columns: TypeAlias = Mapping[str, NDArray[Any]]

# Dimensions of the columns of runs and orbits, by their names without digits at the end.
DIMENSIONS = {
    "t": "time",
    "t0": "time",
    "period": "time",
    "v": "length/time",
    "v0": "length/time",
    "v_before": "length/time",
    "v_after": "length/time",
    "impulse": "mass length/time",
    "effective_mass": "mass",
    "start": "time",
    "release": "time",
    "error_bound": "time",
    "impact_velocity_": "length/time",
    "amplitude": "length",
    "amplitude_": "length",
    "largest_displacement": "length",
    "impact_velocity": "length/time",
    "min_impact_speed": "length/time",
    "x": "length",
    "x0": "length",
    "grazing_margin": "length",
    "stop_force": "mass length/time^2",
}


def units_of_columns(result: Any, columns: Columns, units: Units | None = None) -> dict[str, str]:
    """Return the units of columns by their names; nothing where they are not known.

    Parameters
    ----------
    result
        What the columns are of: a run, an orbit or a branch, several of them, or a dataset.
    columns
        The columns.
    units
        Units that hold where the oscillator has none.
    """
    if hasattr(result, "data_vars"):
        own = {str(name): str(result[name].attrs.get("units", "")) for name in result.variables}
        return {name: own[name] for name in columns if is_unit(own.get(name, ""))}
    model, force = _system_of(result)
    units = getattr(model, "units", None) or units
    if units is None:
        return {}
    has_mass = getattr(model, "mass", None) is not None
    units_by_name = {}
    outcomes = _dimensions_of_outcomes(result)
    for name in columns:
        dimensions = DIMENSIONS.get(name, DIMENSIONS.get(name.rstrip("0123456789").rstrip("_"), ""))
        dimensions = outcomes.get(name, dimensions)
        if "." in name:
            # A parameter by its path; one with a name of its own is shown without a unit.
            dimensions = dimensions_of(name, model, force)
        unit = units.of(dimensions if has_mass else dimensions.removeprefix("mass "))
        if is_unit(unit):
            units_by_name[name] = unit
    return units_by_name


def _dimensions_of_outcomes(result: Any) -> dict[str, str]:
    """Return the dimensions of the outcomes of a design or a front, by their names."""
    (first, *_) = getattr(result, "designs", (result,))
    if type(first).__name__ != "Design":
        return {}
    names = (first.outcome, *first.outcomes, *getattr(result, "outcomes", ()))
    return {name: outcome_dimensions(name, first.oscillator) for name in names}


def _system_of(result: Any) -> tuple[Any, Any]:
    """Return what moves in a result, or in the first of several, and what forces it; or None."""
    while not (hasattr(result, "oscillator") or hasattr(result, "structure")):
        names = ("orbits", "branches", "designs")
        inner = next(filter(None, (getattr(result, name, None) for name in names)), result)
        if not isinstance(inner, list | tuple) or not inner:
            return None, None
        result = inner[0]
    if hasattr(result, "structure"):
        return result.structure, result.loads
    return result.oscillator, result.forcing
