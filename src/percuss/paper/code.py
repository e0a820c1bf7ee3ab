"""The function that computes the evidence of a statement: its name and its text."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any


@dataclass(frozen=True)
class Code:
    """A function as text.

    Parameters
    ----------
    name
        Its module and its name, as "percuss.paper.claims.harmonics:_find".
    text
        Its source; empty where there is no file of it.
    """

    name: str
    text: str


def code_of(function: Callable[..., Any]) -> Code:
    """Return the source of a function; of one with some arguments filled in, that function's.

    Examples
    --------
    >>> code_of(partial(code_of, code_of)).name
    'percuss.paper.code:code_of'
    """
    while isinstance(function, partial):
        function = function.func
    name = f"{function.__module__}:{function.__qualname__}"
    try:
        return Code(name, textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError):
        return Code(name, "")
