"""The program that checks certificates, and certificates that are changed in one place."""

from __future__ import annotations

import copy
import importlib.util
import json
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from types import ModuleType
from typing import Any

CHECKER = Path(__file__).parents[2] / "tools" / "check_certificate.py"


def loaded() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_certificate", CHECKER)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


check: Any = loaded()


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in items:
        if isinstance(part, dict | list):
            yield from leaves(part, (*path, key))
        else:
            yield *path, key


def changed(claims: dict[str, Any], path: tuple[Any, ...]) -> str:
    """Return a certificate with another value in a place, so far off that no claim allows it."""
    other = copy.deepcopy(claims)
    parent: Any = other
    for key in path[:-1]:
        parent = parent[key]
    value = parent[path[-1]]
    if isinstance(value, int):
        parent[path[-1]] = value + 1
    elif value is None:
        parent[path[-1]] = 0
    elif value in ("asymptotic", "unstable"):
        parent[path[-1]] = "unstable" if value == "asymptotic" else "asymptotic"
    elif isinstance(value, str) and value[-1].isdigit():
        # The lower end of an interval goes up, the upper end down.
        parent[path[-1]] = str(Fraction(value) + (-1 if path[-1] == 1 else 1) * Fraction(3, 7))
    else:
        parent[path[-1]] = f"{value}?"
    return json.dumps(other)
