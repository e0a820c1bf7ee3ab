"""Units of the columns of orbits along a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.model.dimensions import dimensions_of
from percuss.model.units import in_units
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["with_units"]

DIMENSIONS = {
    "amplitude": "length",
    "attractor_amplitude": "length",
    "attractor_impact_velocity": "length/time",
    "grazing_margin": "length",
    "impact_velocity": "length/time",
    "largest_displacement": "length",
    "multiplier_imag": "1",
    "multiplier_real": "1",
    "period": "time",
}
# The parameter's own.
VALUES = "value", "special_value", "attractor_value"


def with_units(table: Dataset, path: str, orbit: PeriodicOrbit | StructureOrbit) -> Dataset:
    """Return a table of orbits over a parameter, one of which is given, with units of its columns.

    They are the attribute ``units``, as in a sweep: where the model has no units the dimensions.
    """
    if isinstance(orbit, StructureOrbit):
        units, of_path = orbit.structure.units, dimensions_of(path, orbit.structure, orbit.loads)
    else:
        units, of_path = (
            orbit.oscillator.units,
            dimensions_of(path, orbit.oscillator, orbit.forcing),
        )
    for name, dimension in (DIMENSIONS | dict.fromkeys(VALUES, of_path)).items():
        if name in table and dimension:
            table[name].attrs["units"] = in_units(units, dimension)
    return table
