"""A record notices a change of what it reads of the article: its verdict changes.

Each module of tests/paper/mutations has `MUTATIONS`, triples of a record, what is perturbed in it
(a digit, a sign, an index, an exponent) and the finding that this gives, and `UNMOVED`, records
that no perturbation moves, with the reason.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.paper.findings import RECORDS, finding

from percuss.paper.statement import Finding, verdict_kind

FAMILIES = sorted(path.stem for path in (Path(__file__).parent / "mutations").glob("[a-z]*.py"))
MODULES = [importlib.import_module(f"tests.paper.mutations.{name}") for name in FAMILIES]
MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    mutation for module in MODULES for mutation in module.MUTATIONS
]
UNMOVED: dict[str, str] = {id: why for module in MODULES for id, why in module.UNMOVED.items()}

# What takes half a second and more: of records that another perturbation moves too, or whose
# finding takes as long by itself.
SLOW = {
    ("eq9", "1.01 t"),
    ("eq10", "the gaps in the other order"),
    ("eq17", "period 2 pi of odd n to pi"),
    ("eq20", "n to 2n in the share"),
    ("eq23", "sign of the wave"),
    ("eq24", "sign of the wave"),
    ("eq26", "n^2 - 1 to n^2 + 1"),
    ("eq27", "restitution 0.999"),
    ("eq35-constant", "two starts that are nearly one"),
    ("fig9", "0.139 to 0.137"),
    ("fig10-accuracy", "the soft stop"),
    ("losses-bilinear", "a factor of 1.05"),
    ("losses-half", "lambda^2/8 to lambda^2/9"),
    ("losses-peaks", "a factor of 1.05"),
    ("losses-survive", "the half-harmonic among them"),
    ("resonance-odd", "a gain of a part in a thousand"),
    ("resonance-order", "V^(2-q) to V^(1-q)"),
    ("resonance-phase", "q - 2 to q - 1"),
    ("resonance-twist", "V^-6 to V^-4"),
    ("subharmonic-only", "3, which does not resonate, in place of 4/3"),
}


@pytest.mark.parametrize(
    ("record", "perturbed"),
    [
        pytest.param(
            record,
            find,
            id=f"{record}: {what}",
            marks=pytest.mark.nightly if (record, what) in SLOW else (),
        )
        for record, what, find in MUTATIONS
    ],
)
def test_the_verdict_changes(record: str, perturbed: Callable[[], Finding]) -> None:
    assert verdict_kind(perturbed()) != verdict_kind(finding(record))


def test_every_record_is_perturbed_or_says_why_not() -> None:
    perturbed = {record for record, _, _ in MUTATIONS}

    assert not perturbed & UNMOVED.keys()
    assert perturbed | UNMOVED.keys() == RECORDS.keys()


def test_what_is_slow_is_there() -> None:
    assert {(record, what) for record, what, _ in MUTATIONS} >= SLOW


def test_few_records_are_unmoved() -> None:
    assert len(UNMOVED) <= 5
