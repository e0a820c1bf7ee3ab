"""What is asked of a run as labelled arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from percuss.model.units import FORCE, Units

if TYPE_CHECKING:
    # A second of import, and only `run_dataset` needs it.
    from xarray import Dataset

# Dimensions of the variables of a run's datasets.
DIMENSIONS = {
    "t": "time",
    "x": "length",
    "v": "length/time",
    **dict.fromkeys(("spring", "damping", "forcing", "loads", "stops"), FORCE),
}


def run_dataset(
    data: Mapping[str, object], coords: Mapping[str, object], outcome: str, units: Units | None
) -> Dataset:
    """Return a dataset of a run that ended so; variables name their units where there are units."""
    import xarray

    dataset = xarray.Dataset(data, coords=coords, attrs={"outcome": outcome})
    if units is not None:
        for name in dataset.variables:
            dimensions = DIMENSIONS.get(str(name).removesuffix("_radius"))
            if dimensions is not None:
                dataset[name].attrs["units"] = units.of(dimensions)
    return dataset
