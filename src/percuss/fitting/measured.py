"""Measurements: samples of quantities and instants of impacts, from arrays, tables and files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.fitting.data_file import columns_of_file
from percuss.kernels.segments import ACCELERATION, DISPLACEMENT, OF_STOP, VELOCITY
from percuss.kernels.structure.segments import OF_PLACE
from percuss.model.exact import reals
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.model.units import Units

QUANTITIES = {"displacement": DISPLACEMENT, "velocity": VELOCITY, "acceleration": ACCELERATION}
STOP_FORCE, IMPACT_TIMES = "stop_force", "impact_times"
DIMENSIONS = {
    "displacement": "length",
    "velocity": "length/time",
    "acceleration": "length/time^2",
    IMPACT_TIMES: "time",
}
# In place of a quantity's number: the instant of an impact.
OF_IMPACT = -1
# Estimates of noise by differences are no smaller than this part of the values.
LEAST_NOISE = 1e-9
# The first guess of that of impact times, in their distances: one that is too small would tear the
# motion off the samples beside them.
NOISE_OF_IMPACT = 1e-2
# The median of the magnitudes of a normal variable.
MEDIAN_OF_NORMAL = 0.6744897501960817


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredSamples:
    """Samples in the order of their instants.

    Attributes
    ----------
    t
        (n,) array, instants [time].
    values
        (n,) array; of an impact its instant.
    quantities
        (n,) array, the quantity of each (`kernels.segments`), -1 the instant of an impact; of
        structures and, times `OF_PLACE`, where.
    noise
        (n,) array, standard deviations, estimated where ``is_estimated``.
    is_estimated
        (n,) array of flags.
    reach
        How near to a jump a sample may be on the other side of it: a usual interval [time].
    """

    t: Floats
    values: Floats
    quantities: Integers
    noise: Floats
    is_estimated: Any
    reach: float = 0.0

    def __len__(self) -> int:
        """Return how many they are."""
        return len(self.t)

    @property
    def kinds(self) -> Integers:
        """The quantity of each, without its place."""
        return np.where(self.quantities < 0, self.quantities, self.quantities % OF_PLACE)

    def taken(self, rows: Any) -> MeasuredSamples:
        """Return some of them."""
        return MeasuredSamples(
            self.t[rows], self.values[rows], self.quantities[rows], self.noise[rows],
            self.is_estimated[rows], self.reach,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredRecord:
    """One measured motion.

    Attributes
    ----------
    samples
        The samples.
    impacts
        The instants of impacts that were measured.
    force
        Its forcing, or its loads.
    start
        Its start; None where that is unknown.
    """

    samples: MeasuredSamples
    impacts: MeasuredSamples
    force: Forcing | Loads | None
    start: Start | StructureStart | None

    @property
    def begin(self) -> float:
        """When the first sample was taken."""
        return min(float(some.t[0]) for some in (self.samples, self.impacts) if len(some))

    @property
    def end(self) -> float:
        """When the last sample was taken."""
        return max(float(some.t[-1]) for some in (self.samples, self.impacts) if len(some))

    def __len__(self) -> int:
        """Return the number of values."""
        return len(self.samples) + len(self.impacts)

    def is_same_motion(self, other: MeasuredRecord) -> bool:
        """Return whether it is the same measured motion, whatever noise is ascribed to it."""
        pairs = [(self.samples, other.samples), (self.impacts, other.impacts)]
        return (self.force, self.start) == (other.force, other.start) and all(
            np.array_equal(getattr(own, name), getattr(its, name))
            for own, its in pairs
            for name in ("t", "values", "quantities")
        )


def quantity_name(quantity: int, osc: Oscillator | Structure) -> str:
    """Return the name of a quantity, of a structure of several coordinates with its place."""
    if quantity == OF_IMPACT:
        return IMPACT_TIMES
    kind, place = quantity % OF_PLACE, quantity // OF_PLACE
    for name, number in QUANTITIES.items():
        if number == kind:
            if isinstance(osc, Oscillator) or (osc.n == 1 and place == 0):
                return name
            return f"{name}_{places_of(osc)[place]}"
    return STOP_FORCE if kind == OF_STOP else f"{STOP_FORCE}_{kind - OF_STOP}"


def read_samples(
    data: Any,
    noise: Any,
    osc: Oscillator | Structure,
    titles: Mapping[str, str] | None = None,
) -> tuple[MeasuredSamples, MeasuredSamples]:
    """Return the samples and the impact times of one record.

    Parameters
    ----------
    data
        As `fit` takes it.
    noise
        Standard deviations: a number, an array or a mapping of these by quantity; None where those
        of the data hold.
    osc
        The model, with its stops and places, and the units into which columns of a file that have
        some are converted.
    titles
        Names of the columns of a file by quantity.

    Returns
    -------
    tuple of MeasuredSamples
        The samples and the impacts, without values that are NaN.

    Raises
    ------
    ParameterError
        If there is nothing that can be read.
    """
    if titles is not None:
        _check_titles(titles, data, osc)
    columns, own_noise = _columns(data, osc.units, titles)
    names = [name for name in columns if name not in ("t", "noise")]
    if not names:
        raise ParameterError("data", sorted(columns), f"no column of {_known()}")
    parts: list[MeasuredSamples] = []
    for name in names:
        quantity = quantity_number(name, osc)
        given = _noise_of(name, names, noise, own_noise.get(name, columns.get("noise")))
        values = _numbers(name, columns[name])
        if quantity == OF_IMPACT:
            t = values
        elif "t" not in columns:
            raise ParameterError("data", name, 'without instants; give them as "t"')
        else:
            t = _numbers("t", columns["t"])
        parts.append(_samples(name, t, values, quantity, given))
    whole = _merged([part for part in parts if (part.quantities != OF_IMPACT).all()])
    impacts = _merged(
        [part for part in parts if (part.quantities == OF_IMPACT).all() and len(part)]
    )
    if len(whole) + len(impacts) == 0:
        raise ParameterError("data", names, "all values are NaN")
    return whole, impacts


def _known() -> str:
    return ", ".join([*QUANTITIES, STOP_FORCE, IMPACT_TIMES])


def measurable(osc: Oscillator) -> list[str]:
    """Return what the columns of a table may hold: instants, quantities of an oscillator, their noise."""
    forces = [f"{STOP_FORCE}_{i}" if i else STOP_FORCE for i in range(len(osc.stops))]
    return ["t", *QUANTITIES, *forces, IMPACT_TIMES, "noise"]


def quantity_dimensions(name: str) -> str:
    """Return the dimensions of a quantity by its name.

    Examples
    --------
    >>> quantity_dimensions("velocity_tip"), quantity_dimensions("stop_force_1")
    ('length/time', 'mass length/time^2')
    """
    # Of a structure the name goes on with a coordinate or a point.
    kind = name if name in DIMENSIONS else name.partition("_")[0]
    return DIMENSIONS.get(kind, "mass length/time^2")


def quantity_number(name: str, osc: Oscillator | Structure) -> int:
    """Return the number of a quantity of an oscillator, or of a structure at one of its places."""
    if name == IMPACT_TIMES:
        return OF_IMPACT
    if name in QUANTITIES and (isinstance(osc, Oscillator) or osc.n == 1):
        return int(QUANTITIES[name])
    stem, _, number = name.partition("_")
    if isinstance(osc, Structure) and stem in QUANTITIES:
        return int(QUANTITIES[stem]) + int(OF_PLACE) * _place(name, number, osc)
    stem, _, number = name.rpartition("_")
    which = (
        0 if name == STOP_FORCE else int(number) if stem == STOP_FORCE and number.isdigit() else -1
    )
    if which < 0:
        raise ParameterError("data", name, f"none of the quantities {_known()}")
    if which >= len(osc.stops):
        what = "oscillator" if isinstance(osc, Oscillator) else "structure"
        raise ParameterError(
            "data", name, f"of stop {which}, where the {what} has {len(osc.stops)}"
        )
    return int(OF_STOP) + which


def _place(name: str, place: str, structure: Structure) -> int:
    """Return the number of a place: the coordinates come first, then the named points."""
    places = places_of(structure)
    if place in places:
        return places.index(place)
    stem = name.partition("_")[0]
    known = ", ".join(f"{stem}_{one}" for one in places)
    reason = f"of which place? name it {known}" if not place else f"of no place; there are {known}"
    raise ParameterError("data", name, reason)


def places_of(structure: Structure) -> list[str]:
    """Return the names of what may be measured: coordinates by their numbers, and points."""
    return [*(str(i) for i in range(structure.n)), *(name for name, _ in structure.points)]


def directions_of(structure: Structure) -> Floats:
    """Return c of each place, (n_places, n)."""
    own = [np.eye(structure.n)]
    own += [structure.direction(name)[None, :] for name, _ in structure.points]
    return np.concatenate(own)


def _check_titles(titles: Mapping[str, str], data: Any, osc: Oscillator | Structure) -> None:
    """Refuse names of columns of what is no file, and of what is no quantity."""
    if not isinstance(data, str | PathLike):
        reason = f"names columns of a file, and data are {type(data).__name__}"
        raise ParameterError("columns", titles, reason)
    for name, title in titles.items():
        if name not in ("t", "noise"):
            quantity_number(name, osc)
        if not isinstance(title, str):
            raise ParameterError(f"columns.{name}", title, "not a text, the name of a column")


def _columns(
    data: Any, units: Units | None, titles: Mapping[str, str] | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the columns of data by their names, and the noise that stands with each."""
    if isinstance(data, str | PathLike):
        return _of_file(Path(data), units, titles), {}
    if isinstance(data, Mapping) and not hasattr(data, "data_vars"):
        return dict(data), {}
    if hasattr(data, "data_vars"):
        variables = {str(name): data[name] for name in data.data_vars}
        columns = {name: variable.values for name, variable in variables.items()}
        if "t" not in columns and "t" in data.coords:
            columns["t"] = data["t"].values
        return columns, _attributes(variables)
    if hasattr(data, "coords") and hasattr(data, "name"):
        name = str(data.name)
        columns = {name: data.values}
        if "t" in data.coords:
            columns["t"] = data["t"].values
        return columns, _attributes({name: data})
    if hasattr(data, "columns"):
        columns = {str(name): data[name].to_numpy() for name in data.columns}
        return {"t": data.index.to_numpy(), **columns}, {}
    if hasattr(data, "index") and hasattr(data, "to_numpy"):
        return {"t": data.index.to_numpy(), str(data.name): data.to_numpy()}, {}
    reason = "none of a Dataset, a DataFrame, a mapping of arrays and the path of a CSV file"
    raise ParameterError("data", type(data).__name__, reason)


def _attributes(variables: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: variable.attrs["noise"]
        for name, variable in variables.items()
        if "noise" in variable.attrs
    }


def _of_file(path: Path, units: Units | None, titles: Mapping[str, str] | None) -> dict[str, Any]:
    """Return the columns of a file, missing values as NaN."""
    try:
        return dict(columns_of_file(path, units, titles))
    except OSError as error:
        raise ParameterError("data", str(path), (error.strerror or "not read").lower()) from None
    except ValueError as error:
        raise ParameterError("data", str(path), str(error)) from None


def _numbers(name: str, values: Any) -> Floats:
    try:
        numbers = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(f"data.{name}", type(values).__name__, "not numbers") from None
    if numbers.ndim != 1:
        raise ParameterError(f"data.{name}", numbers.shape, "not one row of numbers")
    return numbers


def _noise_of(name: str, names: Sequence[str], noise: Any, own: Any) -> Any:
    """Return the noise that holds for a column: what was given for it, else its own."""
    if isinstance(noise, Mapping):
        unknown = [key for key in noise if key not in names]
        if unknown:
            raise ParameterError("noise", unknown[0], f"none of the data's {', '.join(names)}")
        return noise.get(name, own)
    if noise is not None and len(names) > 1:
        raise ParameterError("noise", noise, f"of which? give a mapping by {', '.join(names)}")
    return own if noise is None else noise


def _samples(name: str, t: Floats, values: Floats, quantity: int, noise: Any) -> MeasuredSamples:
    if len(t) != len(values):
        reason = f"{len(values)} values at {len(t)} instants"
        raise ParameterError(f"data.{name}", len(values), reason)
    is_estimated = noise is None
    sizes = np.full(len(t), math.nan) if is_estimated else reals(f"noise.{name}", noise)
    if sizes.ndim == 0:
        sizes = np.full(len(t), float(sizes))
    if sizes.shape != t.shape:
        raise ParameterError(f"noise.{name}", len(sizes), f"of {len(t)} values")
    is_given = np.isfinite(values)
    if not np.isfinite(t[is_given]).all():
        wrong = t[is_given & ~np.isfinite(t)]
        raise ParameterError("data.t", float(wrong[0]), "an instant is no finite number")
    is_size = np.isfinite(sizes) & (sizes > 0.0)
    if not is_estimated and not is_size[is_given].all():
        wrong = sizes[is_given & ~is_size]
        raise ParameterError(f"noise.{name}", float(wrong[0]), "no finite number above 0")
    order = np.argsort(t[is_given], kind="stable")
    t, values, sizes = t[is_given][order], values[is_given][order], sizes[is_given][order]
    if is_estimated:
        sizes = np.full(len(t), _rough_noise(t, values, quantity))
    return MeasuredSamples(
        t, values, np.full(len(t), quantity, dtype=np.int64), sizes,
        np.full(len(t), is_estimated),
    )  # fmt: skip


def _rough_noise(t: Floats, values: Floats, quantity: int) -> float:
    """Return the noise by third differences of neighbours, which smooth motions hardly have.

    Of instants that are there more than once the first counts.
    """
    t, firsts = np.unique(t, return_index=True)
    values = values[firsts]
    size = math.sqrt(float(np.mean(values * values))) if len(values) else 1.0
    if quantity == OF_IMPACT:
        return NOISE_OF_IMPACT * float(np.median(np.diff(t))) if len(t) > 1 else 1.0
    if len(t) < 8 or size == 0.0:
        return 1e-2 * size or 1.0
    near = np.lib.stride_tricks.sliding_window_view(t, 4)
    gaps = near[:, :, None] - near[:, None, :] + np.eye(4)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = 1.0 / gaps.prod(axis=2)
        weights /= np.sqrt((weights * weights).sum(axis=1))[:, None]
    differences = (weights * np.lib.stride_tricks.sliding_window_view(values, 4)).sum(axis=1)
    sizes = np.abs(differences[np.isfinite(differences)])
    noise = float(np.median(sizes)) / MEDIAN_OF_NORMAL if len(sizes) else 0.0
    return max(noise, LEAST_NOISE * size)


def _merged(parts: Sequence[MeasuredSamples]) -> MeasuredSamples:
    """Return samples of several quantities in order of their instants."""
    if not parts:
        none = np.zeros(0)
        return MeasuredSamples(none, none, none.astype(np.int64), none, none.astype(bool))
    whole = MeasuredSamples(
        np.concatenate([part.t for part in parts]),
        np.concatenate([part.values for part in parts]),
        np.concatenate([part.quantities for part in parts]),
        np.concatenate([part.noise for part in parts]),
        np.concatenate([part.is_estimated for part in parts]),
    )
    intervals = np.diff(np.sort(whole.t))
    reach = float(np.median(intervals[intervals > 0.0])) if (intervals > 0.0).any() else 0.0
    return replace(whole, reach=reach).taken(np.argsort(whole.t, kind="stable"))
