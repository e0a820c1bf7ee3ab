"""A record with another printed input."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeAlias

from percuss.paper.collection import items, statement_with_id
from percuss.paper.statement import Finding, Statement

# The record, what is perturbed, and the evidence that is found then.
Mutation: TypeAlias = tuple[str, str, Callable[[], Finding]]


@cache
def record(name: str) -> Statement:
    (item,) = (one for one in items() if one.kind == "statement" and one.name == name)
    return statement_with_id(item)


def perturbed(name: str, what: str, **printed: Any) -> Mutation:
    """Return a mutation: the printed inputs by name, and what they become."""
    find: Any = record(name).find
    return name, what, lambda: find(**printed)
