"""A branch of periodic orbits as a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Complexes, Flags, Floats
from percuss.motion.html_table import html_table
from percuss.motion.tables import HasTable
from percuss.numerics import norm
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.continuation.follow import special_points_of
from percuss.orbits.continuation.problem import P, Point
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.table_units import with_units
from percuss.pictures import HasPicture

if TYPE_CHECKING:
    # A second of import.
    from pandas import DataFrame
    from xarray import Dataset

# A periodic orbit of an oscillator, or of a structure.
O = TypeVar("O")


class OrbitRows(Generic[O]):
    """The common part of branches and curves: rows of orbits."""

    __slots__ = ()

    values: Floats
    orbits: tuple[O, ...]
    special_points: tuple[Any, ...]
    end_reason: str

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.values)

    def __iter__(self) -> Iterator[O]:
        """Iterate over the orbits."""
        return iter(self.orbits)

    def __getitem__(self, row: int) -> O:
        """Return the orbit of a row."""
        return self.orbits[row]

    def _line(self, name: str, ends: str) -> str:
        """Return the table in a line, from its name and the ends of its values."""
        counts = Counter(point.kind for point in self.special_points)
        special = ", ".join(f"{n} {kind}" for kind, n in counts.items()) or "none"
        # A column of one class, and a property of another.
        n_formal = int(np.count_nonzero(~cast("Any", self).admissible))
        formal = f", {'all' if n_formal == len(self) else n_formal} formal" if n_formal else ""
        return (
            f"<{name}: {len(self)} orbits{formal}, {ends}; special points: {special}; "
            f"{self.end_reason}>"
        )


class BranchRows(OrbitRows[O], HasPicture):
    """The common part of branches: orbits along one parameter."""

    __slots__ = ()

    picture: ClassVar = "plot_branch"

    path: str

    def __repr__(self) -> str:
        """Return the branch in a line."""
        ends = f"{self.path} from {self.values.min():.6g} to {self.values.max():.6g}"
        return self._line(type(self).__name__, ends)

    def _repr_html_(self) -> str:
        points = self.special_points
        columns = {
            "special point": np.array([point.kind for point in points], dtype=object),
            self.path: np.array([point.value for point in points]),
            "status": np.array([point.status for point in points], dtype=object),
        }
        return html_table(repr(self)[1:-1], columns)


class CurveRows(OrbitRows[O], HasPicture):
    """The common part of curves: special points in two parameters."""

    __slots__ = ()

    picture: ClassVar = "plot_curves"

    kind: Any
    paths: tuple[str, str]

    def __repr__(self) -> str:
        """Return the curve in a line."""
        first, last = (f"({row[0]:.6g}, {row[1]:.6g})" for row in self.values[[0, -1]])
        ends = f"({', '.join(self.paths)}) from {first} to {last}"
        return self._line(f"{type(self).__name__} of {self.kind}", ends)


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Branch(BranchRows[PeriodicOrbit], HasTable):
    """Periodic orbits along one parameter, made by `continue_orbit`; one row an orbit.

    Attributes
    ----------
    path
        Path of the parameter.
    values
        (n,) array, its value in each row; it turns back at a fold.
    arclength
        (n,) array, distance along the branch, with the range of the parameter, the period and
        the largest velocity of the first orbit as units.
    impact_velocity
        (n, m) array, velocity into the stop of each impact and each entry into a soft stop
        [length/time]; negative ones are formal, out of the stop. NaN where an orbit has fewer than
        others of the branch.
    multipliers
        (n, 2) complex array.
    stability
        (n,) array of texts, as in `PeriodicOrbit`.
    admissible
        (n,) array, whether the orbit passes through no stop and meets each from its free side.
    grazing_margin
        (n,) array, distance to a stop of the nearest turning point between two events [length].
    orbits
        The orbits.
    special_points
        Those found, in order; each is a row of the table.
    end_reason
        Why the branch ends where it does.
    """

    path: str
    values: Floats
    arclength: Floats
    impact_velocity: Floats
    multipliers: Complexes
    stability: NDArray[np.str_]
    admissible: Flags
    grazing_margin: Floats
    orbits: tuple[PeriodicOrbit, ...] = field(repr=False)
    special_points: tuple[SpecialPoint, ...]
    end_reason: str

    @property
    def is_stable(self) -> Flags:
        """Whether neighbours approach each orbit, (n,)."""
        return np.asarray(self.stability == "asymptotic")

    @property
    def period(self) -> Floats:
        """Period of each orbit [time], (n,) array: of limit cycles an unknown of their own."""
        return np.array([orbit.period for orbit in self.orbits])

    def to_xarray(self) -> Dataset:
        """Return the table as a dataset, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            Along ``point``; the special points along ``special_point``.

        Examples
        --------
        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.8)})
        >>> data = branch.to_xarray()
        >>> str(data.special_kind.values[0]), round(float(data.special_value[0]), 9)
        ('period_doubling', 2.653347728)
        """
        import xarray

        special = self.special_points
        row = ("point", "impact")
        table = xarray.Dataset(
            {
                "value": ("point", self.values, {"long_name": self.path}),
                "period": ("point", self.period),
                "arclength": ("point", self.arclength),
                "impact_velocity": (row, self.impact_velocity),
                "multiplier_real": (("point", "multiplier"), self.multipliers.real),
                "multiplier_imag": (("point", "multiplier"), self.multipliers.imag),
                "stability": ("point", self.stability),
                "admissible": ("point", self.admissible),
                "grazing_margin": ("point", self.grazing_margin),
                "special_kind": ("special_point", np.array([p.kind for p in special], dtype=str)),
                "special_value": ("special_point", np.array([p.value for p in special])),
                "special_row": ("special_point", np.array([p.row for p in special], dtype=int)),
                "special_status": (
                    "special_point",
                    np.array([p.status for p in special], dtype=str),
                ),
            },
            attrs={"path": self.path, "end_reason": self.end_reason},
        )
        return with_units(table, self.orbits[0], self.path)

    def to_pandas(self) -> DataFrame:
        """Return the orbits as a pandas.DataFrame, a row for each.

        Examples
        --------
        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.8)})
        >>> len(branch.to_pandas()) == len(branch)
        True
        """
        table = self.to_xarray().drop_dims("special_point")
        frame = table.drop_dims(["impact", "multiplier"]).to_dataframe()
        for name in ("impact_velocity", "multiplier_real", "multiplier_imag"):
            for i, column in enumerate(table[name].values.T):
                frame[f"{name}_{i}"] = column
        return frame


def largest_velocities(branch: Branch) -> Floats:
    """Return the largest velocity into a stop of each orbit of a branch, NaN without one."""
    speeds = np.nan_to_num(branch.impact_velocity, nan=-np.inf).max(axis=1, initial=-np.inf)
    return np.asarray(np.where(np.isfinite(speeds), speeds, np.nan))


def branch_of(
    rows: Sequence[tuple[Point[P], SpecialPoint | None]], impact_velocity: Floats, end_reason: str
) -> Branch:
    """Return points in order, with the special points among them, as a branch.

    Parameters
    ----------
    rows
        In order.
    impact_velocity
        As the branch has it.
    end_reason
        Why it ends.
    """
    points = [point for point, _ in rows]
    orbits = tuple(point.orbit for point in points)
    admissible = np.array([orbit.admissible for orbit in orbits])
    return Branch(
        path=points[0].problem.paths[0],
        values=np.array([point.problem.values(point.z)[0] for point in points]),
        arclength=np.append(0.0, np.cumsum([_distance(*pair) for pair in pairwise(points)])),
        impact_velocity=impact_velocity,
        multipliers=np.array([orbit.multipliers for orbit in orbits]),
        stability=np.array([orbit.stability for orbit in orbits]),
        admissible=admissible & ~(impact_velocity <= 0.0).any(axis=1),
        grazing_margin=np.array([orbit.grazing_margin for orbit in orbits]),
        orbits=orbits,
        special_points=special_points_of(rows),
        end_reason=end_reason,
    )


def _distance(one: Point[P], other: Point[P]) -> float:
    """Return the distance of two points; by the parameter where their events differ."""
    if one.problem is other.problem:
        return norm(other.z - one.z)
    return abs(float(other.z[-1] - one.z[-1]))
