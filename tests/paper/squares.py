"""Work for other processes, in a module that they import at once."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.paper.collection import Item


def square(item: Item) -> float:
    """Return the square of an item's name, or end the process."""
    if item.name == "end":
        os._exit(3)
    return float(item.name) ** 2
