"""What the records find, each once in a process for all tests."""

from __future__ import annotations

from functools import cache

from percuss.paper.collection import items, statement_with_id
from percuss.paper.statement import Finding

RECORDS = {item.name: item for item in items() if item.kind == "statement"}


@cache
def finding(name: str) -> Finding:
    """Return what a record finds with what the article prints."""
    return statement_with_id(RECORDS[name]).find()
