"""The page's scripts as texts: a notebook cell has no address to import them from."""

from __future__ import annotations

import re
from importlib import resources

__all__ = ["modules_in_order", "text_of"]

_IMPORT = re.compile(r'from "(\.{1,2}/[\w./]+)"')


def text_of(name: str) -> str:
    """Return the text of a static file."""
    return (resources.files("percuss.web") / "static" / name).read_text("utf-8")


def modules_in_order(first: str = "js/main.js") -> list[list[str]]:
    """Return the page's modules as [name, text], each after those that it imports.

    The widget makes an address for each text in turn, and puts them in place of the names.

    Examples
    --------
    >>> [name for name, _ in modules_in_order()][-1]
    'js/main.js'
    """
    order: list[list[str]] = []
    seen: set[str] = set()

    def visit(name: str) -> None:
        if name in seen:
            return
        seen.add(name)
        text = text_of(name)
        for imported in _IMPORT.findall(text):
            visit(_resolved(name, imported))
        named = _IMPORT.sub(lambda match: f'from "percuss:{_resolved(name, match[1])}"', text)
        order.append([name, named])

    visit(first)
    return order


def _resolved(name: str, imported: str) -> str:
    """Return the name of a module that another one imports by a relative one."""
    parts = name.split("/")[:-1]
    for part in imported.split("/"):
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)
