"""What an answer depends on: the code of percuss, and a function of the user's with its values."""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
import os
import sys
import sysconfig
import types
from collections.abc import Callable, Iterator
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from percuss.errors import ParameterError

__all__ = ["code_hash", "fingerprint"]

# Folders of percuss whose code an answer depends on.
CODE = ("kernels", "model", "motion", "ensembles")
# Values whose representation is exact.
PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis), type(NotImplemented))
# What wraps a function, and under what name it keeps it.
WRAPPED = ("py_func", "__wrapped__", "__func__", "func")


class UnknownError(Exception):
    """A value has no representation that is the same in every process."""


def fingerprint(function: Callable[..., Any]) -> dict[str, str]:
    """Return hashes of a function's code and of each value that it stands on.

    These are its defaults, the variables of the functions around it, the module's own variables
    that it names, what `functools.partial` has bound, and the state of a callable object; functions
    and classes among them count in the same way. What is installed counts by its name alone.

    Parameters
    ----------
    function
        The function.

    Returns
    -------
    dict
        Hashes, by words for what they are of.

    Raises
    ------
    ParameterError
        If one of the values cannot be told from another, such as an open file.

    Examples
    --------
    >>> def make(k):
    ...     return lambda osc, force: k
    >>> three, again, five = (fingerprint(make(k)) for k in (3.0, 3.0, 5.0))
    >>> three == again, [key for key in three if three[key] != five[key]]
    (True, ['measure.k'])
    """
    describe = _Description()
    found = {"measure.code": _hash(f"Python {sys.version_info[0]}.{sys.version_info[1]}")}
    for name, value in _parts_of(function):
        key = f"measure.{name or 'code'}"
        try:
            found[key] = _hash([found.get(key), describe(value)])
        except (UnknownError, RecursionError) as error:
            what = f"{name!r}, " if name else ""
            reason = (
                f"stands on {what}{error}, of which a store cannot tell whether it is the same "
                "when it goes on; give it numbers, texts or arrays, or leave out store="
            )
            shown = getattr(function, "__qualname__", type(function).__name__)
            raise ParameterError("measure", shown, reason) from error
    return found


def _hash(described: object) -> str:
    return hashlib.sha256(json.dumps(described).encode()).hexdigest()[:20]


def _parts_of(function: Any) -> Iterator[tuple[str, Any]]:
    """Yield what a function consists of by name, its code under none."""
    if isinstance(function, functools.partial):
        yield from _parts_of(function.func)
        yield from ((f"argument {i}", value) for i, value in enumerate(function.args))
        yield from sorted(function.keywords.items())
    elif isinstance(function, types.FunctionType) and not _is_installed(function):
        yield "", function.__code__
        yield from _values_of(function)
    else:
        yield "", function


def _values_of(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield what a function stands on besides its code, by name."""
    for parameter in inspect.signature(function, follow_wrapped=False).parameters.values():
        if parameter.default is not parameter.empty:
            yield parameter.name, parameter.default
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        # Named before it is given a value: no cell has contents then.
        yield name, cell.cell_contents if cell != types.CellType() else NotImplemented
    yield from sorted(vars(function).items())
    names, space = _names_in(function.__code__), function.__globals__
    for name in sorted(names & space.keys()):
        yield name, space[name]
        if isinstance(space[name], types.ModuleType) and not _is_installed(space[name]):
            yield from ((f"{name}.{it}", value) for it, value in sorted(vars(space[name]).items())
                        if it in names)  # fmt: skip


def _names_in(code: types.CodeType) -> set[str]:
    """Return the names of globals and attributes in a function and in those inside it."""
    inner = (_names_in(one) for one in code.co_consts if isinstance(one, types.CodeType))
    return set(code.co_names).union(*inner)


class _Description:
    """Describes values as JSON can hold them, each the same in every process."""

    def __init__(self) -> None:
        self._open: dict[int, int] = {}
        # With the value: after its end another could have its number.
        self._known: dict[int, tuple[str, Any]] = {}

    def __call__(self, value: Any) -> Any:
        if type(value) in PLAIN:
            return [type(value).__name__, repr(value)]
        if id(value) in self._open:
            return ["again", len(self._open) - self._open[id(value)]]
        if id(value) not in self._known:
            self._open[id(value)] = len(self._open)
            self._known[id(value)] = _hash(self._container(value)), value
            del self._open[id(value)]
        return self._known[id(value)][0]

    def _container(self, value: Any) -> Any:
        kind = type(value)
        if kind in (tuple, list):
            return [kind.__name__, [self(one) for one in value]]
        if kind in (set, frozenset):
            return [kind.__name__, sorted(json.dumps(self(one)) for one in value)]
        if kind in (dict, types.MappingProxyType):
            return ["dict", sorted([json.dumps(self(k)), self(v)] for k, v in value.items())]
        if isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
            content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
            return [kind.__name__, repr(value.dtype), list(np.shape(value)), content]
        return self._code(value)

    def _code(self, value: Any) -> Any:
        if isinstance(value, types.CodeType):
            # Not the names of files and the numbers of lines: it may move in its file.
            steps = value.co_code.hex(), value.co_exceptiontable.hex()
            names = value.co_names, value.co_varnames, value.co_freevars
            return ["code", value.co_name, steps, self(value.co_consts), names]
        if isinstance(value, types.ModuleType):
            return ["module", value.__name__]
        named = isinstance(value, types.FunctionType | types.BuiltinFunctionType | type | np.ufunc)
        if named and _is_installed(value):
            own = getattr(value, "__closure__", None) or getattr(value, "__self__", None)
            bound = None if own is None or isinstance(own, types.ModuleType) else self(own)
            return ["installed", _module_of(value), value.__qualname__, bound]
        if isinstance(value, types.FunctionType):
            return ["function", self(value.__code__), self(list(_values_of(value)))]
        if isinstance(value, types.CellType):
            return ["cell", self(value.cell_contents)]
        if isinstance(value, type):
            members = {k: v for k, v in vars(value).items() if _is_member(k, v)}
            return ["class", value.__qualname__, self(value.__bases__), self(members)]
        return self._object(value)

    def _object(self, value: Any) -> Any:
        inner = next((getattr(value, it) for it in WRAPPED if hasattr(value, it)), None)
        if inner is not None and not isinstance(value, functools.partial):
            bound = getattr(value, "__self__", None)
            return ["wrapped", type(value).__qualname__, self(inner), self(bound)]
        if isinstance(value, property):
            return ["property", self((value.fget, value.fset, value.fdel))]
        try:
            reduced = value.__reduce_ex__(4)
        except Exception as error:
            raise UnknownError(f"a {type(value).__qualname__}") from error
        if isinstance(reduced, str):
            # The name that it has in its module.
            if not _is_installed(value):
                raise UnknownError(f"a {type(value).__qualname__}")
            return ["installed", _module_of(value), reduced]
        make, arguments, *state = reduced
        listed = [list(one) if isinstance(one, Iterator) else one for one in state]
        return ["object", self(type(value)), self(make), self(tuple(arguments)), self(listed)]


def _is_member(name: str, value: Any) -> bool:
    """Return whether a member of a class is the class's own, and not Python's note about it."""
    is_note = name.startswith("__") and name.endswith("__") and name != "__slots__"
    is_of_slots = isinstance(value, types.MemberDescriptorType | types.GetSetDescriptorType)
    return not is_of_slots and name != "_abc_impl" and (not is_note or callable(value))


def _module_of(value: Any) -> str:
    return str(getattr(value, "__module__", None) or "builtins")


@functools.cache
def _installed() -> tuple[str, ...]:
    """Return the folders of Python, of what has been installed, and of percuss."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    found = {Path(sysconfig.get_paths()[name]) for name in names}
    return tuple(f"{one.resolve()}{os.sep}" for one in (*found, Path(__file__).parents[1]))


def _is_installed(value: Any) -> bool:
    """Return whether a function, class or module is Python's, a library's or percuss's."""
    if isinstance(value, types.FunctionType):
        file: str | None = value.__code__.co_filename
    else:
        name = value.__name__ if isinstance(value, types.ModuleType) else _module_of(value)
        module = sys.modules.get(name)
        file = getattr(module, "__file__", None)
        if module is not None and file is None:
            return name != "__main__"
    return file is not None and str(Path(file).resolve()).startswith(_installed())


@functools.cache
def code_hash() -> str:
    """Return a hash of the code of percuss that an answer depends on."""
    digest = hashlib.sha256()
    for folder in CODE:
        for name, content in _sources(resources.files("percuss").joinpath(folder), folder):
            digest.update(f"{name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:20]


def _sources(folder: Traversable, name: str) -> Iterator[tuple[str, bytes]]:
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _sources(entry, f"{name}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{name}/{entry.name}", entry.read_bytes()
