"""The shapes of a model's tables in a study file: keys and types; the model checks the numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Tag
from pydantic import Field as KeyField
from pydantic import ValidationError as ShapeError

from percuss.model.force_record import Outside, RecordKind
from percuss.model.sea_state import SeaKind
from percuss.studies.tables import (
    NumberKey,
    Path,
    PhaseKey,
    RawTable,
    StudyFaults,
    sentence,
    shown,
    unknown_key,
)

__all__ = [
    "FORCING", "OSCILLATOR", "ForcingShape", "RestitutionKey", "Shape", "Shapes", "SoftShape", "TableShape",
    "UnitsShape", "WallShape", "check_shape",
]  # fmt: skip


class Shape(BaseModel):
    """The shape of a table of the model: its keys and their types; the model checks the numbers."""

    model_config = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)


class TableShape(Shape):
    """A coefficient of restitution over speeds."""

    speeds: list[NumberKey]
    values: list[NumberKey]


# A coefficient of restitution, or a table of it over the speed of impacts.
RestitutionKey = Annotated[
    Annotated[NumberKey, Tag("number")] | Annotated[TableShape, Tag("table")],
    Discriminator(lambda value: "table" if isinstance(value, Mapping) else "number"),
]


class WallShape(Shape):
    """A rigid stop."""

    type: Literal["wall"]
    at: NumberKey
    side: Literal["above", "below"]
    restitution: RestitutionKey = 1.0


class SoftShape(Shape):
    """A soft stop."""

    type: Literal["soft"]
    at: NumberKey
    side: Literal["above", "below"]
    stiffness: NumberKey
    damping: NumberKey = 0.0


class UnitsShape(Shape):
    """Names of units."""

    length: str = ""
    time: str = ""
    mass: str = ""


class OscillatorShape(Shape):
    """The keys of ``[oscillator]``."""

    stiffness: NumberKey = 1.0
    damping: NumberKey = 0.0
    mass: NumberKey | None = None
    damping_coefficient: NumberKey | None = None
    damping_ratio: NumberKey | None = None
    units: UnitsShape | None = None
    stops: list[Annotated[WallShape | SoftShape, KeyField(discriminator="type")]] = []


class HarmonicShape(Shape):
    """A harmonic of a force."""

    amplitude: NumberKey
    omega: NumberKey
    phase: PhaseKey = 0.0


class RecordShape(Shape):
    """A force by its samples."""

    file: str | None = None
    time: str = "t"
    force: str = "f"
    t: list[PhaseKey] = []
    f: list[NumberKey] = []
    kind: RecordKind = "linear"
    repeat: bool = False
    outside: Outside = "end"
    amplitude: NumberKey = 1
    omega: NumberKey | None = None


class SeaShape(Shape):
    """An irregular sea."""

    hs: NumberKey
    tp: NumberKey
    kind: SeaKind = "jonswap"
    n: int = 40
    seed: int = 0
    amplitude: NumberKey = 1


class ForcingShape(Shape):
    """The keys of ``[forcing]``."""

    constant: NumberKey = 0.0
    per_mass: bool = False
    period: PhaseKey | None = None
    harmonics: list[HarmonicShape] = []
    omega: NumberKey | None = None
    cos: list[NumberKey] = []
    sin: list[NumberKey] = []
    record: RecordShape | None = None
    sea_state: SeaShape | None = None


@dataclass(frozen=True, slots=True)
class Shapes:
    """The shape of a table, and those of the tables in it, for messages about their keys.

    Attributes
    ----------
    own
        That of the table.
    inner
        By the key of a table, or of a list of tables.
    stops
        By the type of a stop.
    """

    own: type[Shape]
    inner: Mapping[object, type[Shape]] = field(default_factory=dict)
    stops: Mapping[object, type[Shape]] = field(default_factory=dict)


OSCILLATOR = Shapes(OscillatorShape, {"units": UnitsShape}, {"wall": WallShape, "soft": SoftShape})
FORCING = Shapes(
    ForcingShape,
    {"harmonics": HarmonicShape, "record": RecordShape, "sea_state": SeaShape},
)


def check_shape(shapes: Shapes, table: RawTable, path: Path, faults: StudyFaults) -> None:
    """Add the faults of the shape of a table: unknown keys, missing keys, wrong types."""
    try:
        shapes.own.model_validate(table)
    except ShapeError as error:
        for wrong in error.errors(include_url=False):
            place, kind, value = wrong["loc"], wrong["type"], wrong["input"]
            known = shapes.own
            if place[:1] == ("stops",) and place[2:3] in (("wall",), ("soft",)):
                # pydantic puts the type of a stop into its path.
                known, place = shapes.stops[place[2]], (*place[:2], *place[3:])
                if place[2:3] == ("restitution",):
                    # And whether it read a number or a table.
                    known, place = TableShape, (*place[:3], *place[4:])
            elif len(place) > 1:
                known = shapes.inner.get(place[0], known)
            _add(kind, (*path, *place), value, known, wrong, shapes, faults)


def _add(
    kind: str,
    path: Path,
    value: Any,
    known: type[Shape],
    wrong: Any,
    shapes: Shapes,
    faults: StudyFaults,
) -> None:
    """Add one fault of a shape in our words."""
    if kind == "extra_forbidden":
        faults.add(path, unknown_key(path[-1], list(known.model_fields)))
    elif kind == "union_tag_not_found":
        _add_missing_type(path, value, shapes, faults)
    elif kind == "union_tag_invalid":
        faults.add((*path, "type"), sentence(wrong), shown(value["type"]))
    elif kind == "missing":
        is_side = path[-1] == "side"
        faults.add(path, 'missing; "above" or "below"' if is_side else "missing")
    elif kind == "list_type" and path[-1] in ("stops", "harmonics"):
        names = ".".join(part for part in path if isinstance(part, str))
        faults.add(path, f"not a list; begin each of them with [[{names}]]", shown(value))
    else:
        faults.add(path, sentence(wrong), shown(value))


def _add_missing_type(path: Path, stop: RawTable, shapes: Shapes, faults: StudyFaults) -> None:
    """Add the faults of a stop without a type, whose other keys are not checked yet."""
    keys = (key for shape in shapes.stops.values() for key in shape.model_fields)
    known = list(dict.fromkeys(keys))
    for key in stop:
        if key not in known:
            faults.add((*path, key), unknown_key(key, known))
    faults.add((*path, "type"), 'missing; "wall" or "soft"')
