"""The hash of the kernels' text, by which what was compiled from other text is told."""

from __future__ import annotations

import functools
import hashlib
from importlib import resources


@functools.cache
def sources_hash() -> str:
    """Hash the names and contents of all Python files of kernels, once a process.

    Returns
    -------
    str
        Twenty hexadecimal digits.

    Examples
    --------
    >>> len(sources_hash())
    20
    """
    digest = hashlib.sha256()
    folders = [resources.files(__package__)]
    for folder in folders:
        for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
            if entry.name.endswith(".py"):
                content = entry.read_bytes()
                digest.update(f"{entry.name} {len(content)}\n".encode())
                digest.update(content)
            elif entry.is_dir() and entry.name != "__pycache__":
                folders.append(entry)
    return digest.hexdigest()[:20]
