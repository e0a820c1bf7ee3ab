"""Which kernels the file of WebAssembly was made from: a hash of their text."""

from __future__ import annotations

import ast
import hashlib
import json
from importlib import resources
from importlib.resources.abc import Traversable

__all__ = ["KERNELS_FILE", "kept_hash", "sources_hash"]

KERNELS_FILE = "kernels.wasm"
# The custom section in which the file describes itself.
SECTION = "percuss"
FIRST = "percuss.web.wasm.entries"
# Its text does not change what a kernel computes.
LEFT_OUT = ("percuss.kernels.compile", "percuss.arrays")


def sources_hash() -> str:
    """Return the hash of all modules that the entries are compiled from.

    Comments and docstrings count for nothing.
    """
    digest = hashlib.sha256()
    for name, text in sorted(_texts().items()):
        digest.update(f"{name}\n{_bare(text)}\n".encode())
    return digest.hexdigest()[:20]


def kept_hash() -> str:
    """Return the hash that the file in the package was made with, empty where there is none."""
    file = _static() / KERNELS_FILE
    return str(description(file.read_bytes())["hash"]) if file.is_file() else ""


def description(data: bytes) -> dict[str, object]:
    """Return what a file of WebAssembly says of itself.

    Raises
    ------
    ValueError
        If it is none that ``make wasm`` has made.
    """
    at = 8
    while at < len(data):
        kind = data[at]
        size, at = _number(data, at + 1)
        length, begin = _number(data, at)
        if kind == 0 and data[begin : begin + length] == SECTION.encode():
            return dict(json.loads(data[begin + length : at + size]))
        at += size
    raise ValueError("the file of WebAssembly does not describe itself; make wasm makes it")


def _static() -> Traversable:
    return resources.files("percuss.web") / "static"


def _number(data: bytes, at: int) -> tuple[int, int]:
    """Return a number in LEB128, and where it ends."""
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at


def _texts() -> dict[str, str]:
    """Return the texts of the modules that the entries reach, by their names."""
    texts: dict[str, str] = {}
    waiting = [FIRST]
    while waiting:
        name = waiting.pop()
        if name in texts or name in LEFT_OUT or not name.startswith("percuss."):
            continue
        file = _file_of(name)
        if file is None:
            continue
        texts[name] = file.read_text("utf-8")
        for node in ast.walk(ast.parse(texts[name])):
            if isinstance(node, ast.ImportFrom) and node.module:
                waiting += [node.module, *(f"{node.module}.{it.name}" for it in node.names)]
    return texts


def _file_of(name: str) -> Traversable | None:
    *folders, last = name.split(".")[1:]
    place = resources.files("percuss")
    for folder in folders:
        place = place / folder
    file = place / f"{last}.py"
    return file if file.is_file() else None


def _bare(text: str) -> str:
    """Return a module without comments and docstrings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef):
            first = node.body[0] if node.body else None
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                node.body = node.body[1:] or [ast.Pass()]
    return ast.unparse(tree)
