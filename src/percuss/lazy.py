"""Names of a package whose modules load when they are first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, TypeAlias

__all__ = ["lazy_names"]

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
