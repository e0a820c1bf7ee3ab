"""Plain dictionaries to TOML text: the part of the format that studies use."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping

_BARE = re.compile(r"[A-Za-z0-9_-]+")

Scalar = str | bool | int | float
Table = Mapping[str, object]


def toml_text(document: Table) -> str:
    """Return a document of tables, arrays of tables, and lists of scalars as TOML text.

    Parameters
    ----------
    document
        Tables by name. None values are left out. A table inside a table stands on one line.

    Returns
    -------
    str
        The text; ``tomllib.loads`` gives the document back.

    Examples
    --------
    >>> print(toml_text({"run": {"t_end": 10.0}, "oscillator": {"stops": [{"at": "0.2"}]}}))
    [run]
    t_end = 10.0
    <BLANKLINE>
    [[oscillator.stops]]
    at = "0.2"
    <BLANKLINE>
    """
    blocks = [
        "\n".join(lines) + "\n"
        for name, table in document.items()
        for lines in _blocks(name, table)
    ]
    return "\n".join(blocks)


def _blocks(name: str, table: object) -> Iterator[list[str]]:
    """Give the lines of a table, then those of the tables inside it."""
    if not isinstance(table, Mapping):
        raise TypeError(f"{name} is not a table")
    values = {key: value for key, value in table.items() if not _is_nested(value)}
    nested = {key: value for key, value in table.items() if _is_nested(value)}
    if values or not nested:
        yield [f"[{name}]", *_entries(values)]
    for key, rows in nested.items():
        for row in rows:
            yield [f"[[{name}.{key}]]", *_entries(row)]


def _is_nested(value: object) -> bool:
    return isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value)


def _entries(table: Table) -> Iterable[str]:
    return (f"{_key(key)} = {_value(value)}" for key, value in table.items() if value is not None)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else toml_string(key)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float) and math.isfinite(value):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(_entries(value))}}}"
    raise TypeError(f"{value!r} has no place in a study file")


def toml_string(text: str) -> str:
    r"""Return a text as a TOML basic string, on one line.

    Examples
    --------
    >>> print(toml_string('a "quoted" word'))
    "a \"quoted\" word"
    """
    # JSON escapes what TOML does, but for DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
