"""The hash of the kernels' text from which the file of WebAssembly was made.

``python -m percuss.web.wasm.sources`` tells whether the file is that of the kernels as they are.
"""

from __future__ import annotations

import ast
import copy
import functools
import hashlib
import json
import sys
from importlib import resources
from importlib.resources.abc import Traversable

KERNELS_FILE = "kernels.wasm"
# The custom section in which the file describes itself.
SECTION = "percuss"
FIRST = "percuss.web.wasm.entries"
# Its text does not change what a kernel computes.
LEFT_OUT = ("percuss.kernels.compile", "percuss.arrays")


def sources_hash() -> str:
    """Return the hash of all functions and constants that the entries are compiled from.

    Comments, docstrings, annotations and what no entry uses count for nothing.
    """
    digest = hashlib.sha256()
    for name, text in sorted(_reached().items()):
        digest.update(f"{name}\n{text}\n".encode())
    return digest.hexdigest()[:20]


def kept_hash() -> str:
    """Return the hash that the file in the package was made with, empty where there is none."""
    file = _static() / KERNELS_FILE
    return str(description(file.read_bytes())["hash"]) if file.is_file() else ""


def description(data: bytes) -> dict[str, object]:
    """Return the description that a file of WebAssembly holds of itself.

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


def _reached() -> dict[str, str]:
    """Return the texts of all definitions that the entries reach, by their full names."""
    texts: dict[str, str] = {}
    waiting = [(FIRST, name) for name in _definitions(FIRST)]
    while waiting:
        module, name = waiting.pop()
        node = _definitions(module).get(name)
        if node is None or f"{module}.{name}" in texts:
            continue
        if isinstance(node, ast.ImportFrom):
            waiting += [(f"{node.module}", _original(node, name))]
            continue
        bare = _bare(node)
        texts[f"{module}.{name}"] = ast.unparse(bare)
        for used in ast.walk(bare):
            if isinstance(used, ast.Name):
                waiting.append((module, used.id))
            elif isinstance(used, ast.Attribute) and isinstance(used.value, ast.Name):
                # A function of a module that is imported by its name.
                whole = _definitions(module).get(used.value.id)
                if isinstance(whole, ast.ImportFrom):
                    inner = f"{whole.module}.{_original(whole, used.value.id)}"
                    waiting.append((inner, used.attr))
    return texts


def _original(node: ast.ImportFrom, name: str) -> str:
    """Return the name under which a module has what is imported as another name."""
    return next(alias.name for alias in node.names if name in (alias.asname, alias.name))


@functools.cache
def _definitions(module: str) -> dict[str, ast.stmt]:
    """Return the statements of a module of percuss by the names that they define."""
    file = _file_of(module) if module.startswith("percuss.") and module not in LEFT_OUT else None
    definitions: dict[str, ast.stmt] = {}
    if file is None:
        return definitions
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            definitions[node.name] = node
        elif isinstance(node, ast.ImportFrom):
            definitions |= {item.asname or item.name: node for item in node.names}
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [item for target in targets for item in ast.walk(target)]
            definitions |= {item.id: node for item in names if isinstance(item, ast.Name)}
    return definitions


def _file_of(name: str) -> Traversable | None:
    *folders, last = name.split(".")[1:]
    place = resources.files("percuss")
    for folder in folders:
        place = place / folder
    file = place / f"{last}.py"
    return file if file.is_file() else None


def _bare(node: ast.stmt) -> ast.stmt:
    """Return the text of a definition without comments, docstrings and annotations."""
    bare = copy.deepcopy(node)
    for part in ast.walk(bare):
        if isinstance(part, ast.arg):
            part.annotation = None
        if isinstance(part, ast.FunctionDef):
            part.returns = None
        if isinstance(part, ast.FunctionDef | ast.ClassDef):
            first = part.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                part.body = part.body[1:] or [ast.Pass()]
    return bare


def main() -> int:
    """Return 1, and say so, where the file was made from other kernels."""
    if kept_hash() == sources_hash():
        return 0
    sys.stderr.write(f"{KERNELS_FILE} is not that of the kernels as they are\n")
    return 1


if __name__ == "__main__":
    sys.exit(main())
