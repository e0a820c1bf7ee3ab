"""Values of a study file that are changed for one run: ``oscillator.damping=0.1``."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from percuss.studies.tables import Path, StudyFaults, shown, unknown_key

NO_CHANGE = "not path=value, such as oscillator.damping=0.1"


@dataclass(frozen=True, slots=True)
class ChangedValue:
    """A value that stands in place of that of the file.

    Attributes
    ----------
    path
        Keys, and indices into lists.
    value
        The value as `tomllib` reads it.
    text
        The text that says so.
    """

    path: Path
    value: Any
    text: str

    @classmethod
    def of(cls, text: str) -> ChangedValue | None:
        """Return the change that a text asks for; None if it is not ``path=value``.

        The value is TOML, as in the file; what is no TOML is a text: ``1/3`` is ``"1/3"``. New
        keys with dots stand in quotes: ``over."forcing.omega"=[1, 2]``.

        Examples
        --------
        >>> ChangedValue.of("oscillator.stops.0.at=1/3").path, ChangedValue.of("run.t_end = 10").value
        (('oscillator', 'stops', 0, 'at'), 10)
        """
        key, equals, value = _parted(text)
        value = value.strip()
        if not equals or not value:
            return None
        for written in (value, json.dumps(value, ensure_ascii=False)):
            try:
                document = tomllib.loads(f"{key.strip()} = {written}")
            except ValueError:
                continue
            path, inner = _leaf(document, key)
            return cls(path, inner, text)
        return None


def _parted(text: str) -> tuple[str, str, str]:
    """Return the key, the first equals sign outside quotes, and the value."""
    quote = ""
    for place, letter in enumerate(text):
        if letter in ("'", '"'):
            quote = "" if letter == quote else quote or letter
        elif letter == "=" and not quote:
            return text[:place], "=", text[place + 1 :]
    return text, "", ""


def _leaf(document: dict[str, Any], key: str) -> tuple[Path, Any]:
    """Return the path of the only key in nested tables, and its value."""
    # As many keys as the text has: the value may be a table itself.
    depth = _depth(tomllib.loads(f"{key.strip()} = 0"))
    path: list[str | int] = []
    inner: Any = document
    for _ in range(depth):
        ((name, inner),) = inner.items()
        path.append(int(name) if name.isdecimal() else name)
    return tuple(path), inner


def _depth(document: Any) -> int:
    return 1 + _depth(next(iter(document.values()))) if isinstance(document, dict) else 0


def changed_document(
    document: dict[str, Any], changes: Sequence[str], faults: StudyFaults
) -> dict[str, Any]:
    """Return a document with changed values, and add the faults of the changes.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them.
    changes
        Texts such as ``oscillator.damping=0.1``.
    faults
        The faults found so far. A value from a change stands in no line of the file.
    """
    for text in changes:
        change = ChangedValue.of(text)
        if change is None:
            faults.add((), f"--set {text}: {NO_CHANGE}")
            continue
        changed = _with_own_keys(document, change.path)
        document = _with(document, changed, change.value, (), faults)
        faults.lines[changed] = 0
        for path in [*faults.lines]:
            if len(path) > len(changed) and path[: len(changed)] == changed:
                del faults.lines[path]
    return document


def _with(table: Any, path: Path, value: Any, at: Path, faults: StudyFaults) -> Any:
    """Return a table or a list in which a value stands at a path."""
    if not path:
        return value
    key, here = path[0], (*at, path[0])
    if isinstance(table, list):
        if not isinstance(key, int):
            faults.add(
                at, f"--set names {key!r} of a list; name an element first, by its number from 0"
            )
            return table
        if key >= len(table):
            last = len(table) - 1
            places = f"there is none beyond {last}" if table else "the list is empty"
            faults.add(here, f"--set names an element that is not there; {places}")
            return table
        inner = _with(table[key], path[1:], value, here, faults)
        return [*table[:key], inner, *table[key + 1 :]]
    if not isinstance(table, dict):
        faults.add(at, f"--set names a key in what is no table but {shown(table)}")
        return table
    name = str(key)
    if name not in table and isinstance(key, int):
        faults.add(here, unknown_key(name, list(table)))
        return table
    if name not in table and path[1:] and isinstance(path[1], int):
        known = ", ".join(table)
        faults.add(here, f"--set names an element of a list that is not there; there are {known}")
        return table
    return {**table, name: _with(table.get(name, {}), path[1:], value, here, faults)}


def _with_own_keys(value: Any, path: Path) -> Path:
    """Return a path with the keys of the file that have dots, as those in ``[over]``, as one."""
    if isinstance(value, dict):
        for n in range(1, len(path) + 1):
            name = ".".join(map(str, path[:n]))
            if name in value:
                return (path[0] if n == 1 else name, *_with_own_keys(value[name], path[n:]))
    elif isinstance(value, list) and path and isinstance(path[0], int) and path[0] < len(value):
        return (path[0], *_with_own_keys(value[path[0]], path[1:]))
    return path
