"""The fingerprint of an answer: of percuss' code, and of a user's function with its values."""

from __future__ import annotations

import dis
import functools
import hashlib
import inspect
import os
import sys
import sysconfig
import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from percuss.errors import ParameterError

PACKAGE = Path(__file__).resolve().parents[1]
# Folders of percuss whose code an answer depends on.
CODE = ("kernels", "model", "motion", "ensembles")
# Python, what has been installed, and percuss.
FOLDERS = (*map(sysconfig.get_path, ("stdlib", "platstdlib", "purelib", "platlib")), str(PACKAGE))
INSTALLED = tuple(f"{Path(folder).resolve()}{os.sep}" for folder in FOLDERS)
# Values whose representation is exact.
PLAIN = (bool, int, float, complex, str, bytes, range, slice, Fraction, Decimal, type(Path()),
         type(None), type(...))  # fmt: skip


def fingerprint(function: Callable[..., Any]) -> dict[str, str]:
    """Return hashes of a function's code and of each value that it reads.

    These are its defaults, the variables of the functions around it, those of its module that it
    names and what `functools.partial` has bound; functions among them count in the same way. What
    is installed counts by its name. The code is the compiled one: a text may be missing, as in a
    session, or be newer than what runs.

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
        If one of the values is not a number, a text, an array, a function, a value of percuss,
        or a collection of these.

    Examples
    --------
    >>> def make(k):
    ...     return lambda osc, force: k
    >>> three, again, five = (fingerprint(make(k)) for k in (3.0, 3.0, 5.0))
    >>> three == again, [key for key in three if three[key] != five[key]]
    (True, ['measure.k'])
    """
    hashes: dict[str, str] = {}
    name = "code"
    try:
        for name, value in _parts(function):
            # A name may occur twice, as a default and in a partial.
            content = (hashes.get(f"measure.{name}"), _content(value, [function]))
            hashes[f"measure.{name}"] = hashlib.sha256(repr(content).encode()).hexdigest()[:20]
    except (TypeError, ValueError, ImportError, RecursionError) as error:
        what = "is" if name == "code" else f"reads {name!r},"
        reason = (
            f"{what} {error}, of which a store cannot know whether it is the same when it goes "
            "on; use functions, numbers, texts and arrays, or leave out store="
        )
        shown = getattr(function, "__qualname__", type(function).__name__)
        raise ParameterError("measure", shown, reason) from error
    return hashes


def _parts(function: Any) -> Iterator[tuple[str, Any]]:
    """Yield the code of a function and the values that it reads, by name."""
    if isinstance(function, functools.partial):
        yield from _parts(function.func)
        yield from ((f"argument {i}", value) for i, value in enumerate(function.args))
        yield from sorted(function.keywords.items())
    elif isinstance(function, types.FunctionType):
        code, is_own = function.__code__, not _is_installed(function)
        yield "code", code if is_own else f"{function.__module__}.{function.__qualname__}"
        yield from zip(code.co_freevars, function.__closure__ or (), strict=True)
        if is_own:
            for parameter in inspect.signature(function, follow_wrapped=False).parameters.values():
                if parameter.default is not parameter.empty:
                    yield parameter.name, parameter.default
            yield from sorted(vars(function).items())
            steps = [step for inner in _codes(code) for step in dis.get_instructions(inner)]
            names = {
                step.argval for step in steps if "GLOBAL" in step.opname or "_NAME" in step.opname
            }
            imported = {step.argval for step in steps if step.opname == "IMPORT_NAME"}
            attributes = {name for inner in _codes(code) for name in inner.co_names}
            modules = {name: import_module(name) for name in imported}
            yield from _variables(imported, modules, attributes)
            yield from _variables(names, function.__globals__, attributes)
    else:
        yield "code", function


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Yield the code of a function and of those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _variables(
    names: set[str], of: Mapping[str, Any], attributes: set[str], path: str = ""
) -> Iterator[tuple[str, Any]]:
    """Yield the variables of these names; of a module of the user's those of the attributes."""
    for name in sorted(names & of.keys()):
        value = of[name]
        if isinstance(value, types.ModuleType) and not _is_installed(value):
            # Without its own name: two modules may import each other.
            inner = attributes - {name}
            yield from _variables(inner, vars(value), inner, f"{path}{name}.")
        else:
            yield path + name, value


def _content(value: Any, visited: list[Any]) -> object:
    """Return what a value consists of, with a representation that is the same in any process."""
    kind: Any = type(value)
    if kind in PLAIN:
        return kind, value
    if isinstance(value, types.FunctionType | functools.partial):
        if value in visited:
            return "visited", visited.index(value)
        visited.append(value)
        return kind, [(name, _content(part, visited)) for name, part in _parts(value)]
    if kind is types.CodeType:
        # Not the names of files and the numbers of lines: it may move in its file.
        names = value.co_names, value.co_varnames, value.co_freevars, value.co_cellvars
        counts = value.co_argcount, value.co_posonlyargcount, value.co_kwonlyargcount
        constants = _content(value.co_consts, visited)
        return value.co_code, value.co_exceptiontable, constants, names, counts, value.co_flags
    if kind is types.CellType:
        # An empty cell: the variable is named before it has a value.
        is_empty = value == types.CellType()
        return "empty" if is_empty else _content(value.cell_contents, visited)
    if kind in (tuple, list, dict, set, frozenset):
        items = [_content(item, visited) for item in (value.items() if kind is dict else value)]
        return kind, sorted(items, key=repr) if kind in (set, frozenset) else items
    if isinstance(value, np.generic) or kind is np.ndarray:
        if not value.dtype.hasobject:
            return kind, value.dtype, value.shape, value.tobytes()
    elif isinstance(value, types.ModuleType | type | types.BuiltinFunctionType | np.ufunc):
        if _is_installed(value) and isinstance(getattr(value, "__self__", sys), types.ModuleType):
            return value.__name__, getattr(value, "__module__", None)
    elif _is_installed(kind) and is_dataclass(value):
        return kind, [(field.name, _content(getattr(value, field.name), visited))
                      for field in fields(value)]  # fmt: skip
    elif _is_installed(kind) and hasattr(value, "py_func"):
        # A function that numba compiles.
        return _content(value.py_func, visited), value.targetoptions
    raise TypeError(f"a {kind.__qualname__}")


def _is_installed(value: Any) -> bool:
    """Return whether a function, class or module is Python's, a library's or percuss's."""
    if isinstance(value, types.FunctionType):
        file = value.__code__.co_filename
    else:
        is_module = isinstance(value, types.ModuleType)
        name = str(value.__name__ if is_module else getattr(value, "__module__", "builtins"))
        file = getattr(sys.modules.get(name), "__file__", None) or ""
        if not file:
            return name.partition(".")[0] in sys.stdlib_module_names
    # Python begins with modules that are in no file.
    return file.startswith("<frozen ") or str(Path(file).resolve()).startswith(INSTALLED)


@functools.cache
def code_hash() -> str:
    """Return a hash of the code of percuss that an answer depends on."""
    digest = hashlib.sha256()
    for file in sorted(file for folder in CODE for file in (PACKAGE / folder).rglob("*.py")):
        content = file.read_bytes()
        digest.update(f"{file.relative_to(PACKAGE).as_posix()} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()[:20]
