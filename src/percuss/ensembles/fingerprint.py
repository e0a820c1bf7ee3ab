"""What makes a function the function that it is: its code, and the values that it stands on."""

from __future__ import annotations

import builtins
import dis
import functools
import hashlib
import inspect
import json
import os
import sys
import sysconfig
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from percuss.errors import ParameterError

__all__ = ["fingerprint"]

# Of a class these change with the interpreter and not with the class.
NOT_OF_A_CLASS = {
    *("__module__", "__dict__", "__weakref__", "__doc__", "__annotations__", "_abc_impl"),
    *("__abstractmethods__", "__firstlineno__", "__static_attributes__", "__annotate_func__"),
    *("__annotations_cache__", "__conditional_annotations__", "__dataclass_fields__"),
    *("__dataclass_params__", "__slotnames__"),
}
# What dataclasses write themselves, from fields that are seen as it is.
WRITTEN = "<string>"
# What has no value of its own to tell.
PLAIN = (bool, int, str, bytes, type(None), type(Ellipsis), type(NotImplemented))


class UnknownError(Exception):
    """Something has no representation that lasts."""


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
    teller = _Teller()
    found = {"measure.code": f"Python {sys.version_info[0]}.{sys.version_info[1]}"}
    for name, value in _parts_of(teller, function):
        key = f"measure.{name}" if name else "measure.code"
        try:
            told = json.dumps(value() if callable(value) else value)
        except (UnknownError, RecursionError) as error:
            what = f"{name!r}, " if name else ""
            reason = (
                f"stands on {what}{error}, of which a store cannot tell whether it is the same "
                "when it goes on; give it numbers, texts or arrays, or leave out store="
            )
            shown = getattr(function, "__qualname__", type(function).__name__)
            raise ParameterError("measure", shown, reason) from error
        found[key] = hashlib.sha256((found.get(key, "") + told).encode()).hexdigest()[:20]
    return found


def _parts_of(teller: _Teller, function: Any) -> Iterator[tuple[str, Any]]:
    """Give what a function consists of by name, the code itself under none."""
    if isinstance(function, functools.partial):
        yield from _parts_of(teller, function.func)
        for i, value in enumerate(function.args):
            yield f"argument {i}", functools.partial(teller.tell, value)
        for key, value in sorted(function.keywords.items()):
            yield key, functools.partial(teller.tell, value)
    elif isinstance(function, types.FunctionType) and not _is_installed(function):
        yield "", _code(function.__code__)
        for name, value in _values_of(function):
            yield name, functools.partial(teller.tell, value)
    else:
        yield "", functools.partial(teller.tell, function)


class _Teller:
    """Tells values as JSON can hold them, each the same in every process."""

    def __init__(self) -> None:
        self._open: dict[int, int] = {}
        # With the value, whose number another could have after it.
        self._known: dict[int, tuple[Any, Any]] = {}

    def tell(self, value: Any) -> Any:
        """Return a value as JSON can hold it."""
        if isinstance(value, PLAIN) and type(value) in PLAIN:
            return [type(value).__name__, repr(value)]
        if type(value) in (float, complex):
            return [type(value).__name__, repr(value)]
        if id(value) in self._open:
            return ["again", len(self._open) - self._open[id(value)]]
        if id(value) not in self._known:
            self._open[id(value)] = len(self._open)
            told = json.dumps(self._told(value))
            del self._open[id(value)]
            self._known[id(value)] = hashlib.sha256(told.encode()).hexdigest(), value
        return self._known[id(value)][0]

    def _told(self, value: Any) -> Any:
        kind = type(value)
        if kind in (tuple, list):
            return [kind.__name__, [self.tell(one) for one in value]]
        if kind in (set, frozenset):
            return [kind.__name__, sorted(json.dumps(self.tell(one)) for one in value)]
        if kind is dict:
            pairs = [[json.dumps(self.tell(k)), self.tell(v)] for k, v in value.items()]
            return ["dict", sorted(pairs, key=lambda pair: str(pair[0]))]
        if isinstance(value, np.ndarray | np.generic) and value.dtype.kind != "O":
            array = np.ascontiguousarray(value)
            digest = hashlib.sha256(array.tobytes()).hexdigest()
            return [kind.__name__, repr(array.dtype), list(np.shape(value)), digest]
        return self._told_of_code(value)

    def _told_of_code(self, value: Any) -> Any:
        if isinstance(value, types.ModuleType):
            return ["module", value.__name__, _text_of(value)]
        if isinstance(value, types.FunctionType):
            return self._function(value)
        if isinstance(value, types.MethodType):
            return ["method", self.tell(value.__func__), self.tell(value.__self__)]
        if isinstance(value, types.BuiltinFunctionType | np.ufunc):
            of = getattr(value, "__self__", None)
            own = None if of is None or isinstance(of, types.ModuleType) else self.tell(of)
            return ["builtin", str(getattr(value, "__module__", "")), value.__name__, own]
        if isinstance(value, type):
            return self._class(value)
        if isinstance(value, staticmethod | classmethod):
            return [type(value).__name__, self.tell(value.__func__)]
        if isinstance(value, property):
            return ["property", *(self.tell(one) for one in (value.fget, value.fset, value.fdel))]
        if isinstance(value, functools.cached_property):
            return ["cached_property", self.tell(value.func)]
        if isinstance(value, types.MemberDescriptorType | types.GetSetDescriptorType):
            return ["member", value.__name__]
        # What numba has compiled, and what functools has wrapped.
        inner = getattr(value, "py_func", None) or getattr(value, "__wrapped__", None)
        if inner is not None and callable(value):
            return ["wrapped", type(value).__qualname__, self.tell(inner)]
        return self._object(value)

    def _function(self, function: types.FunctionType) -> Any:
        name = [function.__module__, function.__qualname__]
        if _is_installed(function):
            cells = [self.tell(value) for _, value in _cells_of(function)]
            return ["installed", *name, cells]
        values = [[name, self.tell(value)] for name, value in _values_of(function)]
        return ["function", function.__qualname__, _code(function.__code__), values]

    def _class(self, kind: type) -> Any:
        if _is_installed(kind):
            return ["installed", kind.__module__, kind.__qualname__]
        members = [
            [name, self.tell(value)]
            for name, value in sorted(vars(kind).items())
            if name not in NOT_OF_A_CLASS and not _is_written(kind, name, value)
        ]
        return ["class", kind.__qualname__, [self.tell(base) for base in kind.__bases__], members]

    def _object(self, value: Any) -> Any:
        """Tell an object as it would be pickled, its class as what it is."""
        try:
            reduced = value.__reduce_ex__(4)
        except Exception as error:
            raise UnknownError(f"a {type(value).__qualname__}") from error
        if isinstance(reduced, str):
            # The name that it has in its module.
            if getattr(value, "__module__", None) is None or not _is_installed(value):
                raise UnknownError(f"a {type(value).__qualname__}")
            return ["installed", value.__module__, reduced]
        make, arguments, *rest = reduced
        state, items, pairs = ([*rest, None, None, None])[:3]
        return [
            "object",
            self.tell(type(value)),
            self.tell(make),
            self.tell(tuple(arguments)),
            self.tell(state),
            self.tell(None if items is None else list(items)),
            self.tell(None if pairs is None else [tuple(pair) for pair in pairs]),
        ]


def _is_written(kind: type, name: str, value: Any) -> bool:
    """Tell whether dataclasses have written a method, from the fields."""
    code = getattr(value, "__code__", None)
    return (
        "__dataclass_fields__" in vars(kind)
        and name.startswith("__")
        and (code is None or code.co_filename in (WRITTEN, _REPRS))
    )


# Where the representation of a dataclass that may hold itself is written.
_REPRS = getattr(sys.modules.get("reprlib"), "__file__", WRITTEN)


def _values_of(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    """Give what a function stands on besides its code, by name."""
    parameters = list(inspect.signature(function, follow_wrapped=False).parameters.values())
    for parameter in parameters:
        if parameter.default is not parameter.empty:
            yield f"{parameter.name}", parameter.default
    yield from _cells_of(function)
    yield from sorted(vars(function).items())
    yield from _globals_of(function.__code__, function.__globals__)


def _cells_of(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        try:
            yield name, cell.cell_contents
        except ValueError:
            # Named before it is given a value.
            yield name, NotImplemented


def _globals_of(code: types.CodeType, space: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Give the module's own variables that code names; of a module what is taken from it."""
    seen: set[str] = set()
    for inner in _codes(code):
        steps = list(dis.get_instructions(inner))
        for i, step in enumerate(steps):
            if step.opname not in ("LOAD_GLOBAL", "LOAD_NAME") or step.argval not in space:
                # Python's own, or not given a value yet.
                continue
            name, value = str(step.argval), space[step.argval]
            for after in steps[i + 1 :]:
                # PUSH_NULL and the like stand between in some versions.
                if after.opname in ("PUSH_NULL", "CACHE", "NOP"):
                    continue
                taken = after.opname in ("LOAD_ATTR", "LOAD_METHOD")
                if not (taken and isinstance(value, types.ModuleType)):
                    break
                name = f"{name}.{after.argval}"
                # What an installed module holds counts by its name.
                known = _is_installed(value)
                value = name if known else getattr(value, str(after.argval), NotImplemented)
            if name not in seen:
                seen.add(name)
                yield name, value


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Give the code of a function and of those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _code(code: types.CodeType) -> Any:
    """Return what code does, wherever it stands in its file."""
    constants = [
        _code(one) if isinstance(one, types.CodeType) else _Teller().tell(one)
        for one in code.co_consts
    ]
    names = [code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars]
    return [code.co_name, code.co_code.hex(), constants, [list(one) for one in names]]


def _text_of(module: types.ModuleType) -> str:
    """Return a hash of the text of a module of the user's own."""
    file = getattr(module, "__file__", None)
    if _is_installed(module) or file is None:
        return ""
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError:
        return ""


@functools.cache
def _installed() -> tuple[str, ...]:
    """Return the folders of Python, of what has been installed, and of percuss."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    found = {Path(sysconfig.get_paths()[name]) for name in names}
    return tuple(f"{one.resolve()}{os.sep}" for one in (*found, Path(__file__).parents[1]))


def _is_installed(value: Any) -> bool:
    """Tell whether a function, class or module is Python's, a library's or percuss's."""
    name = value.__name__ if isinstance(value, types.ModuleType) else str(value.__module__)
    if isinstance(value, types.FunctionType):
        file: str | None = value.__code__.co_filename
    elif name == builtins.__name__:
        return True
    else:
        module = sys.modules.get(name)
        file = getattr(module, "__file__", None)
        if module is not None and file is None and name != "__main__":
            return True
    return file is not None and str(Path(file).resolve()).startswith(_installed())
