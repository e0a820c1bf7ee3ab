"""The units of the columns of tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from numpy.typing import NDArray

from percuss.ensembles.measures import outcome_dimensions
from percuss.model.dimensions import dimensions_of
from percuss.model.units import Units, is_unit
from percuss.orbits.orbit.table_units import OF_ORBITS

Columns: TypeAlias = Mapping[str, NDArray[Any]]

# Dimensions of columns by their names without digits at the end: what datasets of orbits do not have.
DIMENSIONS = OF_ORBITS | {
    "t": "time",
    "t0": "time",
    "v0": "length/time",
    "v_before": "length/time",
    "impulse": "mass length/time",
    "effective_mass": "mass",
    "start": "time",
    "release": "time",
    "error_bound": "time",
    "impact_velocity_": "length/time",
    "amplitude_": "length",
    "min_impact_speed": "length/time",
    "x0": "length",
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
    parts = list(_first_parts(result))
    model, force = _system_of(parts)
    units = getattr(model, "units", None) or units
    if units is None:
        return {}
    has_mass = getattr(model, "mass", None) is not None
    units_by_name = {}
    outcomes, paths = _dimensions_of_outcomes(result), _paths_of(parts)
    for name in columns:
        dimensions = DIMENSIONS.get(name, DIMENSIONS.get(name.rstrip("0123456789").rstrip("_"), ""))
        dimensions = outcomes.get(name, dimensions)
        # A parameter with a name of its own is shown without a unit.
        if name in paths and "." in name:
            dimensions = dimensions_of(name, model, force)
        unit = units.of(dimensions if has_mass else dimensions.removeprefix("mass "))
        if is_unit(unit):
            units_by_name[name] = unit
    return units_by_name


def _first_parts(result: Any) -> Iterator[Any]:
    """Yield a result, the first of what it consists of, the first of that, and so on."""
    while True:
        yield result
        names = ("designs", "branches", "orbits")
        inner = next(filter(None, (getattr(result, name, None) for name in names)), result)
        if not isinstance(inner, list | tuple) or not inner:
            return
        result = inner[0]


def _system_of(parts: Sequence[Any]) -> tuple[Any, Any]:
    """Return what moves in a result and what forces it, None where it has neither."""
    for part in parts:
        if hasattr(part, "structure"):
            return part.structure, part.loads
        if hasattr(part, "oscillator"):
            return part.oscillator, part.forcing
    return None, None


def _paths_of(parts: Sequence[Any]) -> tuple[str, ...]:
    """Return the paths of the parameters of a design, a branch or a curve."""
    for part in parts:
        if type(part).__name__ == "Design":
            return tuple(part.values)
        if hasattr(part, "path"):
            return (part.path,)
        if hasattr(part, "paths"):
            return tuple(part.paths)
    return ()


def _dimensions_of_outcomes(result: Any) -> dict[str, str]:
    """Return the dimensions of the outcomes of a design or a front, by their names."""
    (first, *_) = getattr(result, "designs", (result,))
    if type(first).__name__ != "Design":
        return {}
    names = (first.outcome, *first.outcomes, *getattr(result, "outcomes", ()))
    return {name: outcome_dimensions(name, first.oscillator) for name in names}
