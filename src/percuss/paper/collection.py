"""All statements and figures of the paper, in the order of its sections."""

from __future__ import annotations

import difflib
import importlib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

from percuss.errors import ParameterError
from percuss.paper.figure import Figure
from percuss.paper.sections import SECTIONS
from percuss.paper.statement import Statement

ItemKind = Literal["figure", "statement"]


@dataclass(frozen=True)
class Item:
    """One figure or statement, by name: what can be passed to another process.

    Parameters
    ----------
    kind
        "figure" or "statement".
    name
        The figure's name or the statement's id.
    module
        The module of `percuss.paper` that holds it.
    section
        Name of its section in the report.
    """

    kind: ItemKind
    name: str
    module: str
    section: str


@cache
def _figures(module: str) -> dict[str, Figure]:
    return {figure.name: figure for figure in _tuple(module, "FIGURES")}


@cache
def _statements(module: str) -> dict[str, Statement]:
    return {statement.id: statement for statement in _tuple(module, "STATEMENTS")}


def _tuple(module: str, what: str) -> Iterable[Any]:
    """Return what a module holds; many hold only figures or only statements."""
    return getattr(importlib.import_module(f"percuss.paper.{module}"), what, ())


@cache
def items() -> tuple[Item, ...]:
    """Return every figure and statement, in the order of the report.

    Returns
    -------
    tuple of Item
        Section by section, in each the figures first.

    Examples
    --------
    >>> [item.name for item in items()][:2]
    ['fig1', 'fig2']
    """
    items_of_sections = []
    for section in SECTIONS:
        for module in section.modules:
            items_of_sections += [
                Item("figure", name, module, section.name) for name in _figures(module)
            ]
        for module in section.modules:
            items_of_sections += [
                Item("statement", id, module, section.name) for id in _statements(module)
            ]
    return tuple(items_of_sections)


def figure_named(item: Item) -> Figure:
    """Return the figure of an item."""
    return _figures(item.module)[item.name]


def statement_with_id(item: Item) -> Statement:
    """Return the statement of an item."""
    return _statements(item.module)[item.name]


def choose(only: str | None) -> tuple[Item, ...]:
    """Return the items that a list of names selects.

    Parameters
    ----------
    only
        Names separated by commas or blanks, in capitals or not: of figures and statements, or of
        what a statement is about: "eq12" for (12), "table2", "fig14". None selects all.

    Returns
    -------
    tuple of Item
        In the order of the report.

    Raises
    ------
    ParameterError
        If a name is unknown; it tells the nearest ones.

    Examples
    --------
    >>> [item.name for item in choose("fig5, fig9") if item.kind == "figure"]
    ['fig5', 'fig9']
    """
    if only is None:
        return items()
    names = {item: _names(item) for item in items()}
    known = set().union(*names.values())
    wanted: set[str] = set()
    for text in only.split(",") if only.strip(", ") else [only]:
        wanted |= _names_in(text, known) if text.strip() or text is only else set()
    return tuple(item for item in items() if names[item] & wanted)


def _names_in(text: str, known: set[str]) -> set[str]:
    """Return the name that a text means, with blanks and capitals or without; or several.

    Raises
    ------
    ParameterError
        If it means none.
    """
    name = "".join(text.split()).lower()
    by_name = {word.lower(): word for word in known}
    if name in by_name:
        return {by_name[name]}
    several = text.lower().split()
    if several and by_name.keys() >= set(several):
        return {by_name[one] for one in several}
    close = difflib.get_close_matches(name, by_name, n=3)
    if close:
        meant = " or ".join(f'"{by_name[word]}"' for word in close)
        raise ParameterError("only", text, f"no figure or statement; did you mean {meant}?")
    some = ", ".join(sorted(known, key=_natural)[:: max(1, len(known) // 8)])
    reason = f"no figure or statement; there are {len(known)}, such as {some}"
    raise ParameterError("only", text, reason)


def _names(item: Item) -> set[str]:
    """Return the names under which an item can be asked for."""
    if item.kind == "figure":
        return {item.name}
    statement = statement_with_id(item)
    reference = statement.reference.lower()
    return {
        statement.id,
        *(f"eq{number.upper()}" for number in re.findall(r"\((a?\d+)\)", reference)),
        *(f"table{number}" for number in re.findall(r"table (\d+)", reference)),
        *(f"fig{number.upper()}" for number in re.findall(r"fig\.? (a?\d+)", reference)),
    }


def _natural(name: str) -> tuple[object, ...]:
    """Sort fig2 before fig10."""
    parts = re.split(r"(\d+)", name)
    return tuple((part.isdigit(), int(part) if part.isdigit() else part) for part in parts)
