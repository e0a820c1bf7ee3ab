"""Faults of the shape of a study file, in words."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel, ValidationError

from percuss.studies.faults import StudyFault, shown
from percuss.studies.lines import Path, line_of
from percuss.studies.schema import Document, SoftTable, WallTable

_STOPS: dict[str, type[BaseModel]] = {"wall": WallTable, "soft": SoftTable}

# Tables that studies of some kinds have.
OF_SOME_KINDS = (
    "start", "run", "over", "orbit", "orbits", "branch", "curve", "response", "sweep", "diagram",
    "basins", "lyapunov", "certify",
)  # fmt: skip

# What pydantic calls an error, and what we say; {} stands for its context.
_REASONS = {
    "bool_type": "neither true nor false",
    "int_type": "not a whole number",
    "float_type": "not a number; write 2.8, without quotes",
    "finite_number": "not finite",
    "string_type": "not a text; put it in quotes",
    "list_type": "not a list",
    "model_type": "not a table",
    "model_attributes_type": "not a table",
    "dict_type": "not a table",
    "literal_error": "not {expected}",
    "union_tag_invalid": 'neither "wall" nor "soft"',
    "greater_than": "not more than {gt}",
    "greater_than_equal": "less than {ge}",
    "less_than_equal": "more than {le}",
    "too_short": "{actual_length} values; {min_length} are needed",
    "too_long": "{actual_length} values; {max_length} are needed",
}


@dataclass(slots=True)
class Found:
    """The faults found so far in one file, and where its keys stand."""

    file: str
    lines: dict[Path, int]
    faults: list[StudyFault] = field(default_factory=list)

    def add(self, path: Path, reason: str, value: str = "") -> None:
        """Note a fault, unless this key, a part of it or what it is part of has one already."""
        parts = [str(part) for part in path]
        dotted = ".".join(parts)
        around = {".".join(parts[:length]) for length in range(1, len(parts))}
        if not self.is_wrong(dotted) and not any(fault.path in around for fault in self.faults):
            line = line_of(self.lines, path)
            self.faults.append(StudyFault(self.file, line, dotted, reason, value))

    def is_wrong(self, dotted: str) -> bool:
        """Return whether a key or a part of it has a fault already."""
        return any(
            fault.path == dotted or fault.path.startswith(f"{dotted}.") for fault in self.faults
        )


def shape_faults(document: Mapping[str, object], shape: type[Document], found: Found) -> None:
    """Add the faults of the shape of a document: unknown keys, missing keys, wrong types."""
    try:
        shape.model_validate(document)
    except ValidationError as error:
        for detail in error.errors(include_url=False):
            path = _path(detail["loc"])
            if detail["type"] == "extra_forbidden":
                found.add(path, _unknown(path, document, shape))
            elif detail["type"] == "union_tag_not_found":
                _add_missing_type(path, _value(document, path), found)
            elif detail["type"] == "missing":
                found.add(path, _missing(path))
            else:
                path = (*path, "type") if detail["type"] == "union_tag_invalid" else path
                found.add(path, _reason(detail, path), shown(_value(document, path)))


def _path(location: tuple[int | str, ...]) -> Path:
    """Return a place in the document: pydantic puts the type of a stop into its path."""
    is_stop = location[:2] == ("oscillator", "stops") and location[3:4] in (("wall",), ("soft",))
    return (*location[:3], *location[4:]) if is_stop else location


def _reason(detail: Any, path: Path) -> str:
    if detail["type"] == "list_type" and path[-1] in ("stops", "harmonics"):
        return f"not a list; begin each of them with [[{'.'.join(map(str, path))}]]"
    words = _REASONS.get(detail["type"])
    if words is None:
        message = str(detail["msg"])
        return message[:1].lower() + message[1:]
    return words.format(**detail.get("ctx", {})).replace("'", '"')


def _add_missing_type(path: Path, stop: object, found: Found) -> None:
    """Add what is wrong with a stop without a type, whose other keys nobody has looked at."""
    known = list(dict.fromkeys(key for table in _STOPS.values() for key in table.model_fields))
    for key in stop if isinstance(stop, Mapping) else ():
        if key not in known:
            found.add((*path, key), unknown_key(key, known))
    found.add((*path, "type"), 'missing; "wall" or "soft"')


def _missing(path: Path) -> str:
    if path[-1] == "side":
        return 'missing; "above" or "below"'
    return f"missing; a table [{path[0]}] is needed" if len(path) == 1 else "missing"


def _value(document: object, path: Path) -> object:
    for part in path:
        document = document[part]  # type: ignore[index]
    return document


def _unknown(path: Path, document: Mapping[str, object], shape: type[Document]) -> str:
    """Say what a key that is unknown may have been meant to be."""
    known = _known_keys(path[:-1], document, shape)
    if len(path) == 1 and str(path[0]) in OF_SOME_KINDS:
        return f"no table of this kind of study; its tables are {', '.join(known)}"
    return unknown_key(path[-1], known)


def unknown_key(key: object, known: list[str]) -> str:
    """Say which of the known keys another one may have been meant to be."""
    close = difflib.get_close_matches(str(key).lower(), known, n=1)
    if close:
        return f'unknown key; did you mean "{close[0]}"?'
    return f"unknown key; known here: {', '.join(known)}"


def unknown_value(value: object, known: list[str]) -> str:
    """Say which of the known values another one may have been meant to be."""
    close = difflib.get_close_matches(str(value).lower(), known, n=1)
    listed = f"{', '.join(known[:-1])} or {known[-1]}"
    return f'did you mean "{close[0]}"? There are {listed}' if close else f"not {listed}"


def _known_keys(table: Path, document: Mapping[str, object], shape: type[Document]) -> list[str]:
    """Return the keys of a table, by walking the schema along its path."""
    if table[:2] == ("oscillator", "stops"):
        stop = _value(document, table)
        kind = stop.get("type") if isinstance(stop, Mapping) else None
        return list(_STOPS[str(kind)].model_fields)
    fields = shape.model_fields
    for part in table:
        if isinstance(part, str):
            fields = _table_of(fields[part].annotation).model_fields
    return [name for name in fields if name != "record"]


def _table_of(annotation: Any) -> type[BaseModel]:
    """Return the table in ``Table``, ``Table | None`` or ``list[Table]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    candidates = (_table_of(part) for part in annotation.__args__ if part is not type(None))
    return next(candidates)
