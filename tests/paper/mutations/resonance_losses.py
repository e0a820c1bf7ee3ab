"""The statements on resonances with losses, with a number of each perturbed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from percuss.paper.claims import resonance_losses
from percuss.paper.statement import Finding

STATEMENTS = resonance_losses.STATEMENTS
FIND: dict[str, Callable[..., Finding]] = {one.id: one.find for one in STATEMENTS}
MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    (f"losses-{id}", what, partial(FIND[f"losses-{id}"], **inputs))
    for id, what, inputs in (
        ("curve", "a factor of 1.000001", {"factor": 1.000001}),
        ("peaks", "a factor of 1.05", {"factor": 1.05}),
        ("half", "lambda^2/8 to lambda^2/9", {"end": 1.0 / 9.0}),
        ("saddles", "a factor of 1.05", {"factor": 1.05}),
        ("survive", "the half-harmonic among them", {"survivors": ("1", "2", "4", "6")}),
        ("bilinear", "a factor of 1.05", {"factor": 1.05}),
    )
]
UNMOVED: dict[str, str] = {}
