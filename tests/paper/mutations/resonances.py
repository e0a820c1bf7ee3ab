"""The statements on which frequencies resonate, with a number or an exponent perturbed."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial

from percuss.paper.claims import resonances
from percuss.paper.claims.resonances import OTHERS, V
from percuss.paper.statement import Finding

STATEMENTS = resonances.STATEMENTS
FIND: dict[str, Callable[..., Finding]] = {one.id: one.find for one in STATEMENTS}
MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    (id, what, partial(FIND[id], **inputs))
    for id, what, inputs in (
        ("resonance-even", "2n/(n^2-1) to n/(n^2-1)", {"printed": lambda n: n / (n * n - 1)}),
        ("resonance-half", "1/2 to 1/pi", {"rate": 0.3183}),
        ("resonance-odd", "a gain of a part in a thousand", {"kept": 1.001 * V}),
        ("resonance-order", "V^(2-q) to V^(1-q)", {"less": 1}),
        ("resonance-strength", "a factor of 1.001", {"factor": 1.001}),
        ("resonance-phase", "q - 2 to q - 1", {"less": 1.0}),
        ("resonance-twist", "V^-6 to V^-4", {"power": -4.0}),
        ("resonance-subharmonics", "m = 7 among those with growth", {"closed": (8, 9)}),
        ("subharmonic-only", "3, which does not resonate, in place of 4/3", {"others": ("3",)}),
        ("resonance-others", "2/3 among them", {"frequencies": (*OTHERS, Fraction(2, 3))}),
    )
]
UNMOVED: dict[str, str] = {}
