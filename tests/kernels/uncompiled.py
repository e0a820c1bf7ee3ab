"""The plain Python behind a kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

P = ParamSpec("P")
R = TypeVar("R")


def python_of(function: Callable[P, R]) -> Callable[P, R]:
    """Give the function as it was written, of a kernel compiled or not."""
    return cast("Callable[P, R]", getattr(function, "py_func", function))
