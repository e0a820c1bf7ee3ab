"""Two inner functions of numba's, written so that they do the same in less time.

A quarter of the time to compile the kernels went into asking a configuration for each of its fifty
options through a property, 74,000 times, and into listing the variables of an expression through
an abstract base class, a million times (docs/decisions/012-hot-spots.md). They stand in for
numba's own only while a kernel compiles.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import Any

from numba.core import ir, targetconfig

OWN: tuple[Any, Any] = targetconfig.TargetConfig.values, ir.Inst._rec_list_vars


@contextlib.contextmanager
def hastened() -> Iterator[None]:
    """Let numba use the quicker two of its functions.

    Where several threads compile at once, the first that is done takes them away from all: that
    costs the others time and nothing else.
    """
    config: Any = targetconfig.TargetConfig
    instruction: Any = ir.Inst
    config.values, instruction._rec_list_vars = values, variables_in
    try:
        yield
    finally:
        config.values, instruction._rec_list_vars = OWN


def values(config: Any) -> dict[str, object]:
    """Return all options of a configuration: those that were set, and the defaults of the others."""
    kind: Any = type(config)
    return {**_defaults(kind), **config._values}


@functools.cache
def _defaults(kind: Any) -> dict[str, object]:
    return {name: option.default for name, option in kind.options.items()}


def variables_in(_: object, value: object) -> list[Any]:
    """Return the variables in a part of an instruction, in order."""
    found: list[Any] = []
    _gather(value, found)
    return found


def _gather(value: Any, found: list[Any]) -> None:
    kind = type(value)
    if kind is ir.Var:
        found.append(value)
    elif kind is tuple or kind is list:
        for part in value:
            _gather(part, found)
    elif kind is dict:
        for part in value.values():
            _gather(part, found)
    elif kind is not str and isinstance(value, ir.Inst):
        instruction: Any = value
        found.extend(instruction.list_vars())
