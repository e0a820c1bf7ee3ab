"""The special points of a kind."""

from __future__ import annotations

from percuss.orbits import Branch, SpecialPoint


def points(branch: Branch, kind: str) -> list[SpecialPoint]:
    return [point for point in branch.special_points if point.kind == kind]
