"""The names of a package: those that load when they are first used, and those that are shown."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, TypeAlias

Loaders: TypeAlias = tuple[Callable[[str], Any], Callable[[], list[str]]]


def lazy_names(package: str, modules: Mapping[str, str]) -> Loaders:
    """Return ``__getattr__`` and ``__dir__`` of a package from the module of each of its names.

    Examples
    --------
    >>> load, names = lazy_names("percuss", {"ParameterError": "errors"})
    >>> load("ParameterError").__name__, names()
    ('ParameterError', ['ParameterError'])
    """

    def load(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{modules[name]}"), name)

    return load, lambda: list(modules)


def public_names(package: str) -> Callable[[], list[str]]:
    """Return ``__dir__`` of a package or module: what a prompt completes, without its modules.

    Examples
    --------
    >>> import percuss.ensembles
    >>> public_names("percuss.ensembles")()[:3]
    ['LyapunovExponents', 'basin_fractions', 'basins']
    """

    def names() -> list[str]:
        members = vars(sys.modules[package])
        hidden = (ModuleType, type(annotations))
        shown = [
            name
            for name, value in members.items()
            if not (isinstance(value, hidden) or name.startswith("_") or value is public_names)
        ]
        return sorted(members.get("__all__", shown))

    return names
