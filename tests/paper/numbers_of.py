"""The numbers among the evidence of a statement."""

import re
from collections.abc import Sequence
from pathlib import Path

from percuss.paper.evidence import Comparison, Deduction, Evidence


def numbers(items: Sequence[Evidence]) -> list[Comparison]:
    """Return what is a number, measured or certified."""
    return [item for item in items if not isinstance(item, Deduction)]


def difference(item: Comparison) -> float:
    """Return by how much a number differs from the one that is expected."""
    assert item.expected is not None
    return item.value - item.expected


def numbers_in_theory(name: str) -> list[tuple[int, str]]:
    """Return the rows of a table of whole numbers and their values in a page of docs/theory."""
    page = Path(__file__).parents[2] / "docs" / "theory" / name
    rows = re.findall(r"^\| (\d+) \| ([\d.]+) \|$", page.read_text("utf-8"), flags=re.MULTILINE)
    return [(int(n), digits) for n, digits in rows]
