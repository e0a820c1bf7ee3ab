"""Units of the columns of tables of orbits, and of what is made of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from percuss.model.dimensions import dimensions_of
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.units import in_units
from percuss.orbits.orbit.structure_orbit import StructureOrbit

if TYPE_CHECKING:
    from xarray import Dataset

# Dimensions of the columns of tables of orbits, by their names.
OF_ORBITS = {
    "amplitude": "length",
    "attractor_amplitude": "length",
    "attractor_impact_velocity": "length/time",
    "cycle": "1",
    "duration": "time",
    "grazing_margin": "length",
    "impact_velocity": "length/time",
    "largest_displacement": "length",
    "multiplier_imag": "1",
    "multiplier_real": "1",
    "period": "time",
    "touch_cycle": "1",
    "v": "length/time",
    "v_after": "length/time",
    "x": "length",
}
# The parameter's own.
VALUES = "value", "special_value", "attractor_value"


class _OfOscillator(Protocol):
    """What has an oscillator and its force, as its orbits have."""

    @property
    def oscillator(self) -> Oscillator: ...
    @property
    def forcing(self) -> Forcing | None: ...


def with_units(table: Dataset, of: _OfOscillator | StructureOrbit, *paths: str) -> Dataset:
    """Return a table with units of its columns, of what moves, over parameters by their paths.

    They are the attribute ``units``, as in a sweep: where the model has no units the dimensions.
    Of several parameters they are the coordinate ``unit`` along ``parameter``.
    """
    model, force = (
        (of.structure, of.loads) if isinstance(of, StructureOrbit) else (of.oscillator, of.forcing)
    )
    of_paths = [dimensions_of(path, model, force) for path in paths]
    of_values = dict.fromkeys(VALUES, of_paths[0]) if len(paths) == 1 else {}
    for name, dimension in (OF_ORBITS | of_values).items():
        if name in table and dimension:
            table[name].attrs["units"] = in_units(model.units, dimension)
    if len(paths) > 1:
        units = [in_units(model.units, dimension) for dimension in of_paths]
        table = table.assign_coords(unit=("parameter", units))
    return table
