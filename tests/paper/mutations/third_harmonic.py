"""Statements on the third harmonic with their velocities, exponents and ends perturbed."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial

from percuss.paper.claims import third_harmonic_family, third_harmonic_lines
from percuss.paper.statement import Finding

STATEMENTS = (*third_harmonic_family.STATEMENTS, *third_harmonic_lines.STATEMENTS)
FIND: dict[str, Callable[..., Finding]] = {one.id: one.find for one in STATEMENTS}
MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    (f"periodicity-{id}", what, partial(FIND[f"periodicity-{id}"], **inputs))
    for id, what, inputs in (
        ("fig6b-times", "0.45 to 0.55", {"v0": Fraction("0.55")}),
        ("fig6b-lost", "0.45 to 0.495, where six impacts do not return", {"v0": Fraction("0.495")}),
        ("outside-range", "the lower end by 1e-6", {"ends": (0.1357243, 0.4892767)}),
        ("fig6b-bilinear", "a change of the intervals below 1 counts as none", {"allowed": 1.0}),
        ("fig8a-regular", "0.51 to 0.45", {"v0": "0.45"}),
        ("fig8b-irregular", "0.45 to 0.51", {"v0": "0.51"}),
        ("fig8b-slower", "w^-2 to w^-3", {"law": -3.0}),
    )
]
UNMOVED: dict[str, str] = {}
