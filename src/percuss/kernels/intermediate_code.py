"""LLVM's intermediate code of kernels, made ahead and kept in the package.

Two thirds of a first compilation are numba's way from Python to LLVM's intermediate code, which is
the same on all machines of a kind. ``tools/precompile.py`` keeps the code of each part
(`percuss.kernels.parts`) in a file whose name carries the hash of the kernels' text. Where the file
is of these kernels, this version of numba and this kind of machine, parts are taken from it, and
LLVM alone is left to be waited for; elsewhere they are compiled
(docs/decisions/027-intermediate-code.md).
"""

from __future__ import annotations

import functools
import json
from collections.abc import Iterable
from importlib import resources
from typing import Any, NamedTuple, TypeAlias

import llvmlite.binding
import numba
from numba.core import types

from percuss.kernels.sources import sources_hash

# A type: its name, or that of the class of a tuple ("" for a plain one) with those of its members.
TypeText: TypeAlias = "str | list[Any]"

_NUMBERS = (types.float64, types.int64, types.complex128, types.boolean)
# Besides tuples, the types that a part may return. `percuss.kernels.vectors` adds its own.
TYPES: dict[str, Any] = {
    str(each): each
    for each in (
        types.none,
        *_NUMBERS,
        *(types.Array(of, n, "C") for of in _NUMBERS for n in (1, 2, 3)),
    )
}


class Part(NamedTuple):
    """What is kept of a function for certain types of its arguments.

    ``calls`` are the places of those that it calls in the list of all. Small functions of numba's
    own, which a part calls, have no name of a function here.
    """

    function: str
    arguments: list[str]
    returns: TypeText
    symbol: str
    calls: list[int]
    size: int


class KeptCode(NamedTuple):
    """The parts of a file: what is known of each, its intermediate code, and their places."""

    parts: list[Part]
    bitcode: list[bytes]
    places: dict[tuple[str, tuple[str, ...]], int]


def machine() -> dict[str, str]:
    """Return what intermediate code hangs on besides the kernels' text.

    Examples
    --------
    >>> sorted(machine())
    ['llvm', 'numba', 'triple']
    """
    return {
        # How functions are called may change from one minor version to the next.
        "numba": ".".join(numba.__version__.split(".")[:2]),
        "llvm": ".".join(map(str, llvmlite.binding.llvm_version_info)),
        "triple": llvmlite.binding.get_process_triple(),
    }


def code_file() -> Any:
    """Return the place of the file in the package, which may be of other kernels and not exist."""
    return resources.files(__package__) / f"intermediate-code-{sources_hash()}.xz"


def packed(parts: Iterable[tuple[Part, bytes]]) -> bytes:
    """Return the content of a file of parts.

    Parameters
    ----------
    parts
        Each with its intermediate code.

    Returns
    -------
    bytes
        Compressed: a line of JSON, and the code of all.
    """
    import lzma

    known, bitcode = zip(*parts, strict=True)
    head = json.dumps({"machine": machine(), "parts": known})
    return lzma.compress(f"{head}\n".encode() + b"".join(bitcode), preset=9)


def unpacked(data: bytes) -> tuple[dict[str, str], KeptCode]:
    """Return for which machines a file is, and what it has.

    Raises
    ------
    ImportError
        Where Python was built without `lzma`.
    ValueError
        If the content is none of `packed`, or cut off.
    """
    import lzma

    try:
        head, _, rest = lzma.decompress(data).partition(b"\n")
    except lzma.LZMAError as error:
        raise ValueError(f"no file of intermediate code: {error}") from None
    described = json.loads(head)
    parts = [Part(*each) for each in described["parts"]]
    bitcode, begin = [], 0
    for part in parts:
        bitcode.append(rest[begin : begin + part.size])
        begin += part.size
    places = {(part.function, tuple(part.arguments)): i for i, part in enumerate(parts)}
    return described["machine"], KeptCode(parts, bitcode, places)


@functools.cache
def code() -> KeptCode:
    """Return the code for this machine, once a process; without parts where there is none."""
    try:
        of, found = unpacked(code_file().read_bytes())
    except (ImportError, OSError, ValueError):
        return KeptCode([], [], {})
    return found if of == machine() else KeptCode([], [], {})


def part_of(function: Any, arguments: Iterable[Any]) -> tuple[KeptCode, int] | None:
    """Return where the code of a function is, for these types of its arguments; None without it.

    Parameters
    ----------
    function
        The Python function.
    arguments
        numba's types.

    Returns
    -------
    tuple of KeptCode and int, or None
        The parts of the file, and the place of this one.
    """
    place = code().places.get((full_name(function), tuple(map(str, arguments))))
    return None if place is None else (code(), place)


def full_name(function: Any) -> str:
    """Return the name of a function with its module's."""
    return f"{function.__module__}.{function.__qualname__}"


def type_as_text(of: Any) -> TypeText:
    """Return how a type is written into the file.

    Raises
    ------
    KeyError
        For a type that `type_of_text` does not know.

    Examples
    --------
    >>> type_as_text(types.UniTuple(types.float64, 2))
    ['', ['float64', 'float64']]
    """
    if isinstance(of, types.BaseTuple):
        whole = getattr(of, "instance_class", None)
        name = "" if whole is None else f"{whole.__module__}:{whole.__qualname__}"
        members: Any = of
        return [name, [type_as_text(each) for each in members]]
    return str(TYPES[str(of)])


def type_of_text(text: TypeText) -> Any:
    """Return the type that `type_as_text` has written."""
    if isinstance(text, str):
        return TYPES[text]
    name, members = text
    whole = tuple
    if name:
        module, _, qualified = name.partition(":")
        whole = getattr(__import__(module, fromlist=[qualified]), qualified)
    return types.BaseTuple.from_types([type_of_text(each) for each in members], whole)
