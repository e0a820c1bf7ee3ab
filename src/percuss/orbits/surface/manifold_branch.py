"""One half of a manifold, as points in a row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.orbits.surface.manifold_growth import GrowthEnd

ManifoldKind: TypeAlias = Literal["stable", "unstable"]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class ManifoldBranch:
    """One half of a manifold of one point of a saddle orbit.

    Attributes
    ----------
    kind
        "stable" or "unstable".
    saddle
        Index of the point, a row of `Manifolds.saddles`.
    side
        +1 or -1: which of both halves.
    points
        (n, 2) array, (x, v) or (cycle, v_after), from the saddle on; cycles lie in [0, 1). Of a
        structure (n, 2 n_coordinates), x and v.
    piece
        (n,) array, number of the continuous piece that each point belongs to. Between two
        pieces the manifold jumps: no line joins them.
    arclength
        (n,) array, length of the pieces so far, with the scale of `Manifolds` as units.
    end_reason
        Why it ends: "length"; "max_points"; "no_image": nothing leads on, as from a contact or,
        back in time, from an impact without restitution; "collapse": it has shrunk to a point;
        "interrupted".
    """

    kind: ManifoldKind
    saddle: int
    side: int
    points: Floats
    piece: Integers
    arclength: Floats
    end_reason: GrowthEnd

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        """Return the branch in a line."""
        return (
            f"<ManifoldBranch: {self.kind}, saddle {self.saddle}, side {self.side:+d}; "
            f"{len(self)} points in {len(self.pieces)} pieces; ends at {self.end_reason}>"
        )

    @property
    def pieces(self) -> list[Floats]:
        """The continuous pieces, arrays of the points of each."""
        return np.split(self.points, np.flatnonzero(np.diff(self.piece)) + 1)
