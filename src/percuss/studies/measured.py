"""Keys that ensembles share: names of measures, and the section at which points are taken."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from percuss.ensembles.measures import MEASURES
from percuss.ensembles.sweep import NO_STROBES, SAME_NAME
from percuss.errors import ParameterError
from percuss.motion.sections import PoincareSection, section_of
from percuss.studies.study import StudyDraft
from percuss.studies.tables import MISSING, Path, Text, raw_table, shown, unknown_value


def _as_list(value: object) -> object:
    return [value] if isinstance(value, str) else [] if value is MISSING else value


NAME_SCHEMA: dict[str, Any] = {"type": "string"}
MeasureNames = Annotated[
    tuple[Text, ...],
    BeforeValidator(_as_list),
    WithJsonSchema({"anyOf": [NAME_SCHEMA, {"type": "array", "items": NAME_SCHEMA}]}),
]


def _section(value: object) -> PoincareSection:
    try:
        return section_of(value)
    except ParameterError as error:
        name = "" if error.name == "section" else f"{error.name} = {shown(error.value)}: "
        reason = name + in_words_of_file(error.reason)
        raise PydanticCustomError("section", "{reason}", {"reason": reason}) from None


SectionKey = Annotated[
    PoincareSection,
    PlainValidator(_section),
    PlainSerializer(lambda section: section_of(section).given),
    WithJsonSchema({"type": ["string", "object"]}),
]


def in_words_of_file(reason: str) -> str:
    """Return a sentence about sections with the braces of TOML in place of Python's."""
    reason = reason.replace("'cycle':", "cycle =").replace("'at':", "at =")
    reason = reason.replace("'direction': 'up'", 'direction = "up"')
    return reason.replace("'impacts'", '"impacts"')


def check_measures(
    names: tuple[str, ...], path: Path, over: dict[str, Any], study: StudyDraft
) -> None:
    """Add the faults of names of measures, and of paths in ``[over]`` of the same name."""
    known = list(MEASURES)
    is_one = isinstance(raw_table(study.document, str(path[0])).get(str(path[-1])), str)
    for index, name in enumerate(names):
        if name in over:
            study.faults.add(("over", name), SAME_NAME)
        if name not in MEASURES:
            place = path if is_one else (*path, index)
            study.faults.add(place, unknown_value(name, known), shown(name))


def check_section(
    section: PoincareSection, table: Literal["diagram", "sweep"], why: str, study: StudyDraft
) -> None:
    """Add the fault of a forcing without a period, or of strobes without a forcing."""
    # A default is not validated.
    section, force = section_of(section), study.force
    forces = study.model_tables[1]
    if study.faults.is_wrong(forces) or study.faults.is_wrong(f"{table}.section"):
        return
    if force is not None and not force.is_constant:
        study.needs_period(why)
    elif section.kind == "stroboscopic":
        place = (forces,) if "section" not in raw_table(study.document, table) else None
        reason = in_words_of_file(NO_STROBES)
        if place is None:
            study.faults.add((table, "section"), reason, shown(section.given))
        else:
            reason = reason.replace("give ", f"give {table}.section = ")
            study.faults.add(place, f"missing harmonics; {reason}")
