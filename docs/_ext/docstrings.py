"""Docstrings are written for a terminal; this is what a page wants otherwise."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

# |x| is a magnitude, not a substitution; a path of a page is a link to it.
MAGNITUDE = re.compile(r"\|(\w+)\|")
PAGE = re.compile(r"\bdocs((?:/[\w-]+)+)\.md")
# Fields of classes, as napoleon writes them: some lines describe several.
FIELD = re.compile(r":ivar ([\w, ]+): ?(.*)")


def rewrite(
    _app: Sphinx, _what: str, _name: str, _of: Any, _options: Any, lines: list[str]
) -> None:
    """Keep bars as they are, link pages, and list the fields of classes."""
    bars = [MAGNITUDE.sub(r"\\|\1\\|", line) for line in lines]
    lines[:] = _listed([PAGE.sub(r":doc:`\1`", line) for line in bars])


def without_own_parts(
    _app: Sphinx, what: str, _name: str, _of: Any, _options: Any, arguments: str | None, _back: Any
) -> tuple[str, None] | None:
    """Leave out how results are made that only percuss makes: they hold parts of their own."""
    if what == "class" and arguments is not None and re.search(r"[(,] ?_\w", arguments):
        return "", None
    return None


def setup(app: Sphinx) -> dict[str, Any]:
    """Make them known; napoleon comes first."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", rewrite, priority=900)
    app.connect("autodoc-process-signature", without_own_parts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _listed(lines: list[str]) -> list[str]:
    found: list[str] = []
    in_list = False
    for line in lines:
        field = FIELD.match(line)
        if field:
            if not in_list:
                found.append(":Attributes:")
            names = ", ".join(f"**{name.strip()}**" for name in field[1].split(","))
            found.append(f"    * {names} -- {field[2]}")
        else:
            in_fields = in_list and line.startswith(" ")
            found.append(f"    {line}" if in_fields else line)
        in_list = bool(field) or (in_list and line.startswith(" "))
    return found
