"""The JSON schema of study files, for editors: from the tables as pydantic checks them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import GenerateJsonSchema

from percuss.studies.model_tables import ForcingShape, OscillatorShape
from percuss.studies.reading import known_keys, shape_of
from percuss.studies.structure_tables import LoadShape, StructureShape
from percuss.studies.study import TABLES, Question, kind_named, kind_names
from percuss.studies.tables import NUMBER_SCHEMA, Certify, Draw, Save, StudyTable

DRAFT = "http://json-schema.org/draft-07/schema#"
PLACES = "#/definitions/{model}"
# Of a docstring of NumPy's form: "name, other" or "name", and the lines that explain it.
SECTION = re.compile(r"\n\s*Parameters\n\s*-+\n(.*?)(?:\n\s*\n\s*\w+\n\s*-+\n|\Z)", re.DOTALL)
OF_MODEL = (("oscillator", OscillatorShape), ("forcing", ForcingShape))


class _Generator(GenerateJsonSchema):
    """Leaves out the defaults that JSON has no form for, as a start or an infinite number."""

    def default_schema(self, schema: Any) -> dict[str, Any]:
        inner = self.generate_inner(schema["schema"])
        value = schema.get("default")
        is_plain = isinstance(value, bool | int | str) or (
            isinstance(value, float) and math.isfinite(value)
        )
        if not is_plain:
            return inner
        return (
            {"allOf": [inner], "default": value} if "$ref" in inner else {**inner, "default": value}
        )


def study_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 7) of study files.

    It knows the tables of each kind, their keys and the types of these. What depends on the numbers
    themselves, such as a start inside a wall, only `parse_study` finds.

    Returns
    -------
    dict
        The schema.

    Examples
    --------
    >>> schema = study_schema()
    >>> schema["properties"]["study"]["properties"]["kind"]["enum"][:3]
    ['motion', 'orbit', 'orbits']
    """
    definitions: dict[str, Any] = {}
    names = kind_names()
    head = _table_schema(StudyTable, definitions)
    head["properties"]["kind"] = {
        "enum": names,
        "default": "motion",
        "description": "The question.",
    }
    return {
        "$schema": DRAFT,
        "title": "A study of percuss",
        "type": "object",
        "properties": {"study": head},
        "allOf": [_of_kind(name, kind_named(name), definitions) for name in names],
        "definitions": definitions,
    }


def _of_kind(name: str, kind: type[Question], definitions: dict[str, Any]) -> dict[str, Any]:
    """Return what holds for the files of one kind: if it is of that kind, then these tables."""
    is_this = {
        "properties": {"study": {"properties": {"kind": {"const": name}}, "required": ["kind"]}},
        "required": ["study"],
    }
    condition: dict[str, Any] = is_this
    if name == "motion":
        # The default.
        no_kind = {"not": {"properties": {"study": {"required": ["kind"]}}, "required": ["study"]}}
        condition = {"anyOf": [is_this, no_kind]}
    then = {
        "if": {"required": ["structure"]},
        "then": _files_of(kind, definitions, of_structure=True),
        "else": _files_of(kind, definitions, of_structure=False),
    }
    return {"if": condition, "then": then}


def _files_of(
    kind: type[Question], definitions: dict[str, Any], *, of_structure: bool
) -> dict[str, Any]:
    """Return the schema of the files of a kind about an oscillator, or about a structure."""
    tables: dict[str, Any] = {
        "study": {},
        # What a file of results says of itself; a study ignores it.
        "record": {"type": "object"},
        "parameters": {"type": "object", "additionalProperties": NUMBER_SCHEMA},
    }
    if of_structure:
        tables["structure"] = _table_schema(StructureShape, definitions)
        loads = _table_schema(LoadShape, definitions)
        tables["loads"] = {"type": "array", "items": loads}
    else:
        tables |= {name: _table_schema(shape, definitions) for name, shape in OF_MODEL}
    shapes = _shapes_of(kind, of_structure=of_structure)
    for name, keys in known_keys(kind, of_structure=of_structure).items():
        tables[name] = _table_schema(shapes[name], definitions, keys or None)
    needed = kind.needed_of_structures if of_structure else kind.needed
    model = "structure" if of_structure else "oscillator"
    return {
        "required": [model, *needed],
        "properties": tables,
        "additionalProperties": False,
    }


def _shapes_of(kind: type[Question], *, of_structure: bool) -> dict[str, Any]:
    """Return the types of the tables of a kind besides the model."""
    fields = kind.__pydantic_fields__  # type: ignore[attr-defined]
    own = {
        table: shape_of(name, fields[name], of_structure=of_structure)
        for name, table in TABLES.items()
        if name in fields and table != "over"
    }
    over = {"over": (kind, "over")} if "over" in fields else {}
    return {"save": Save, "draw": Draw, "certify": Certify, kind.kind: kind, **own, **over}


def _table_schema(
    shape: Any, definitions: dict[str, Any], keys: list[str] | None = None
) -> dict[str, Any]:
    """Return the schema of a table, or of one field of it; of some of its keys alone."""
    shape, field = shape if isinstance(shape, tuple) else (shape, "")
    made = TypeAdapter(shape).json_schema(ref_template=PLACES, schema_generator=_Generator)
    for name, inner in made.pop("$defs", {}).items():
        definitions[name] = _told(inner)
    if field:
        return dict(made["properties"][field])
    words = _words_of(shape)
    kept = made["properties"].keys() if keys is None else [*keys]
    properties = {name: _told(made["properties"][name], words.get(name, "")) for name in kept}
    return {
        "type": "object",
        "description": _first_line(shape),
        "properties": properties,
        "required": [name for name in made.get("required", ()) if name in properties],
        "additionalProperties": False,
    }


def _told(schema: Mapping[str, Any], words: str = "") -> dict[str, Any]:
    """Return a schema without the titles that pydantic makes of names, and with our words."""
    described = {key: value for key, value in schema.items() if key != "title"}
    if isinstance(described.get("properties"), Mapping):
        described["properties"] = {
            name: _told(inner) for name, inner in described["properties"].items()
        }
    return {**described, "description": words} if words else described


def _first_line(shape: Any) -> str:
    return str(shape.__doc__ or "").strip().partition("\n")[0].replace("`", "")


def _words_of(shape: Any) -> dict[str, str]:
    """Return what a docstring says of each key."""
    if isinstance(shape, type) and issubclass(shape, BaseModel):
        return {}
    section = SECTION.search(shape.__doc__ or "")
    if section is None:
        return {}
    lines = section[1].split("\n")
    least = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    words: dict[str, str] = {}
    names: list[str] = []
    for line in lines:
        if line.strip() and len(line) - len(line.lstrip()) == least:
            names = [name.strip() for name in line.split(",")]
        else:
            for name in names:
                words[name] = f"{words.get(name, '')} {line.strip()}".strip().replace("`", "")
    return words
