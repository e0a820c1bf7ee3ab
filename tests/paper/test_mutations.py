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


@pytest.mark.parametrize(
    ("record", "perturbed"),
    [pytest.param(record, find, id=f"{record}: {what}") for record, what, find in MUTATIONS],
)
def test_the_verdict_changes(record: str, perturbed: Callable[[], Finding]) -> None:
    assert verdict_kind(perturbed()) != verdict_kind(finding(record))


def test_every_record_is_perturbed_or_says_why_not() -> None:
    perturbed = {record for record, _, _ in MUTATIONS}

    assert not perturbed & UNMOVED.keys()
    assert perturbed | UNMOVED.keys() == RECORDS.keys()


def test_few_records_are_unmoved() -> None:
    assert len(UNMOVED) <= 5
