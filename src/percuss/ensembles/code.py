"""Which code an answer was computed with."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterator
from importlib import resources
from importlib.resources.abc import Traversable

__all__ = ["code_hash"]

# Folders whose code an answer depends on.
CODE = ("kernels", "model", "motion", "ensembles")


@functools.cache
def code_hash() -> str:
    """Return a hash of the code that an answer depends on."""
    digest = hashlib.sha256()
    root = resources.files("percuss")
    for folder in CODE:
        if root.joinpath(folder).is_dir():
            for name, content in _sources(root.joinpath(folder), folder):
                digest.update(f"{name} {len(content)}\n".encode())
                digest.update(content)
    return digest.hexdigest()[:20]


def _sources(folder: Traversable, name: str) -> Iterator[tuple[str, bytes]]:
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _sources(entry, f"{name}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{name}/{entry.name}", entry.read_bytes()
