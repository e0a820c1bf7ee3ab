"""The numbers among the evidence of a statement."""

from collections.abc import Sequence

from percuss.paper.evidence import Comparison, Deduction, Evidence


def numbers(items: Sequence[Evidence]) -> list[Comparison]:
    """Return what is a number, measured or certified."""
    return [item for item in items if not isinstance(item, Deduction)]


def difference(item: Comparison) -> float:
    """Return by how much a number differs from the one that is expected."""
    assert item.expected is not None
    return item.value - item.expected
