"""A curve in two parameters as a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

__all__ = ["Curve", "CurveKind", "CurvePoint", "CurvePointKind"]

Floats = NDArray[np.float64]
CurveKind: TypeAlias = Literal["fold", "period_doubling", "symmetry_breaking", "grazing"]
CurvePointKind: TypeAlias = Literal[
    "cusp",
    "fold_grazing",
    "period_doubling_grazing",
    "symmetry_breaking_grazing",
    "resonant_grazing",
    "double_grazing",
    "degenerate_grazing",
]


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """A point of codimension two: on a curve, and fulfilling one condition more.

    Attributes
    ----------
    kind
        "cusp" (two curves of folds meet and end), "fold_grazing", "period_doubling_grazing" and
        "symmetry_breaking_grazing" (an orbit with a multiplier of 1 or -1 touches a stop),
        "resonant_grazing" (a neighbour of the grazing orbit comes back to the stop as fast as it
        went off, to first order: the square root in the return map has no effect),
        "double_grazing" (two touches in one orbit), "degenerate_grazing" (a touch without
        acceleration).
    paths, values
        The two parameters and their values there.
    intervals
        For either parameter, values between which it lies.
    status
        "located" if the intervals are below 1e-10 of the values, or of 1 for smaller ones, and
        what changes sign goes through zero; otherwise "bracketed".
    orbit
        The orbit there.
    row
        Its row in the curve.
    detail
        What happens there, in words.
    codimension
        How many conditions it fulfils: 2.
    """

    kind: CurvePointKind
    paths: tuple[str, str]
    values: tuple[float, float]
    intervals: tuple[tuple[float, float], tuple[float, float]]
    status: Literal["located", "bracketed"]
    orbit: PeriodicOrbit = field(repr=False)
    row: int
    detail: str
    codimension: int = 2


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Curve:
    """Special points along a curve in two parameters, made by `continue_curve`; one row a point.

    Attributes
    ----------
    kind
        "fold", "period_doubling", "symmetry_breaking" or "grazing".
    paths
        Paths of the two parameters.
    values
        (n, 2) array, their values in each row.
    arclength
        (n,) array, distance along the curve, with the ranges of the parameters, the period and
        the largest velocity of the first orbit as units.
    multipliers
        (n, 2) complex array; of a grazing orbit those without the touch.
    stability
        (n,) array of texts, as in `PeriodicOrbit`; of a grazing orbit without the touch.
    admissible
        (n,) array, whether the orbit passes through no stop and meets each from its free side.
    orbits
        The orbits.
    special_points
        The points of codimension two found, in order; each is a row of the table.
    end_reason
        Why the curve ends where it does.
    """

    kind: CurveKind
    paths: tuple[str, str]
    values: Floats
    arclength: Floats
    multipliers: NDArray[np.complex128]
    stability: NDArray[np.str_]
    admissible: NDArray[np.bool_]
    orbits: tuple[PeriodicOrbit, ...] = field(repr=False)
    special_points: tuple[CurvePoint, ...]
    end_reason: str

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.values)

    def __iter__(self) -> Iterator[PeriodicOrbit]:
        """Go through the orbits."""
        return iter(self.orbits)

    def __getitem__(self, row: int) -> PeriodicOrbit:
        """Return the orbit of a row."""
        return self.orbits[row]

    def __repr__(self) -> str:
        """Tell the curve in a line."""
        kinds: dict[str, int] = {}
        for point in self.special_points:
            kinds[point.kind] = kinds.get(point.kind, 0) + 1
        special = ", ".join(f"{n} {kind}" for kind, n in kinds.items()) or "none"
        ends = [f"({row[0]:.6g}, {row[1]:.6g})" for row in self.values[[0, -1]]]
        return (
            f"<Curve of {self.kind}: {len(self)} orbits, ({', '.join(self.paths)}) from {ends[0]} "
            f"to {ends[1]}; special points: {special}; {self.end_reason}>"
        )

    def to_xarray(self) -> Dataset:
        """Return the table as a dataset, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            Along ``point``; the points of codimension two along ``special_point``.

        Examples
        --------
        >>> import percuss as pc
        >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
        >>> calm = pc.find_orbit(osc, pc.cosine(1.3, amplitude=0.1), n_impacts=0)
        >>> branch = pc.continue_orbit(calm, over={"forcing.amplitude": (0.1, 1.0)})
        >>> ranges = {"forcing.omega": (1.2, 1.4), "forcing.amplitude": (0.1, 1.0)}
        >>> data = pc.continue_curve(branch.special_points[0], over=ranges).to_xarray()
        >>> data.value.dims, data.attrs["kind"]
        (('point', 'parameter'), 'grazing')
        """
        import xarray

        special = self.special_points
        values = np.array([point.values for point in special]).reshape(-1, 2)
        return xarray.Dataset(
            {
                "value": (("point", "parameter"), self.values),
                "arclength": ("point", self.arclength),
                "multiplier_real": (("point", "multiplier"), self.multipliers.real),
                "multiplier_imag": (("point", "multiplier"), self.multipliers.imag),
                "stability": ("point", self.stability),
                "admissible": ("point", self.admissible),
                "special_kind": ("special_point", np.array([p.kind for p in special], dtype=str)),
                "special_value": (("special_point", "parameter"), values),
                "special_row": ("special_point", np.array([p.row for p in special], dtype=int)),
                "special_status": (
                    "special_point",
                    np.array([p.status for p in special], dtype=str),
                ),
            },
            coords={"parameter": list(self.paths)},
            attrs={"kind": self.kind, "end_reason": self.end_reason},
        )
