"""The tables of an oscillator and its forcing: keys and types; the model checks the numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, TypeVar, cast

from pydantic import BaseModel, ConfigDict, Discriminator, Tag
from pydantic import Field as KeyField
from pydantic import ValidationError as ShapeError

from percuss.errors import ParameterError
from percuss.model.exact import as_float
from percuss.model.expression import Expression
from percuss.model.faults import (
    Fault,
    draft,
    number_faults,
    positive_faults,
    scale_faults,
    unit_problem,
)
from percuss.model.faults import faults as model_faults
from percuss.model.force_record import ForceRecord, Outside, RecordKind
from percuss.model.forcing import Forcing, FourierTerm, Harmonic
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.restitution import RestitutionTable
from percuss.model.sea_state import SeaKind, sea_faults, sea_state
from percuss.model.units import Units
from percuss.studies.record_file import record_of
from percuss.studies.tables import (
    MISSING,
    NumberKey,
    Path,
    PhaseKey,
    RawTable,
    StudyFaults,
    exact_phase,
    raw_table,
    sentence,
    shown,
    unknown_key,
)

ModelPart = TypeVar("ModelPart", Wall, SoftStop, Harmonic, RestitutionTable)

_FOURIER = ("omega", "cos", "sin")
_DAMPINGS = ("damping_coefficient", "damping_ratio")


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
                if place[2:3] == ("restitution",) and len(place) > 3:
                    # And whether it read a number or a table.
                    known, place = TableShape, (*place[:3], *place[4:])
            elif len(place) > 1:
                known = shapes.inner.get(place[0], known)
            _add_fault_of_shape(kind, (*path, *place), value, known, wrong, shapes, faults)


def _add_fault_of_shape(
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


def read_oscillator(
    document: RawTable, faults: StudyFaults, folder: FilePath | None = None
) -> tuple[Oscillator, Forcing | None]:
    """Return the oscillator of a document and the force on it, and add their faults.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them.
    faults
        The faults found so far.
    folder
        The folder of the file, None without one.

    Returns
    -------
    Oscillator, Forcing or None
        Drafts where they have faults.
    """
    for name, shapes in (("oscillator", OSCILLATOR), ("forcing", FORCING)):
        if isinstance(document.get(name), Mapping):
            check_shape(shapes, document[name], (name,), faults)
    oscillator = _oscillator(raw_table(document, "oscillator"), faults)
    forcing = None
    if "forcing" in document:
        forcing = forcing_of(
            raw_table(document, "forcing"), ("forcing",), folder, faults, units=oscillator.units
        )
    if forcing is not None and not (faults.is_wrong("oscillator") or faults.is_wrong("forcing")):
        _check_quotient(oscillator, forcing, faults)
    return oscillator, forcing


def _check_quotient(oscillator: Oscillator, forcing: Forcing, faults: StudyFaults) -> None:
    """Add the fault of a force that has left the range of floats after its division by the mass."""
    try:
        forcing.acceleration_of(oscillator.mass)
    except ParameterError as error:
        reason = f"after the division by it, forcing.{error.name} is {error.reason}"
        faults.add(("oscillator", "mass"), reason, shown(oscillator.mass))


def _oscillator(table: RawTable, faults: StudyFaults) -> Oscillator:
    stops = tuple(stop_of(row) for row in list_of(table, "stops"))
    values = {"stiffness": 1.0, "damping": 0.0}
    values = {name: table.get(name, value) for name, value in values.items()}
    units = units_of_table(table, "oscillator", faults)
    oscillator = draft(Oscillator, **values, stops=stops, units=None)
    faults.add_from_model(model_faults(oscillator, "oscillator"))
    dampings = {name: table[name] for name in _DAMPINGS if name in table}
    if "mass" in table:
        return _with_mass(table, dampings, oscillator, units, faults)
    for name in dampings:
        faults.add(("oscillator", name), "needs oscillator.mass; mass = 1 leaves all else as it is")
    if units is not None and units.mass:
        reason = "a unit of mass, where there is no oscillator.mass"
        faults.add(("oscillator", "units", "mass"), reason, shown(units.mass))
    return draft(Oscillator, **values, stops=stops, units=units)


def units_of_table(table: RawTable, owner: str, faults: StudyFaults) -> Units | None:
    """Return the units of an oscillator or a structure, None without any or with faults."""
    given = table.get("units")
    if not isinstance(given, Mapping) or faults.is_wrong(f"{owner}.units"):
        return None
    for name, value in given.items():
        problem = unit_problem(name, value)
        if problem is not None:
            faults.add((owner, "units", name), problem, shown(value))
    return None if faults.is_wrong(f"{owner}.units") else draft(Units, **given)


def _with_mass(
    table: RawTable,
    dampings: Mapping[str, Any],
    oscillator: Oscillator,
    units: Units | None,
    faults: StudyFaults,
) -> Oscillator:
    """Return the oscillator with its mass and its damping, and add the faults of these."""
    faults.add_from_model(positive_faults("oscillator.mass", table["mass"]))
    for name, value in dampings.items():
        faults.add_from_model(scale_faults(f"oscillator.{name}", value))
    if "stiffness" not in table:
        faults.add(("oscillator", "stiffness"), "missing; with a mass it has no default")
    if "damping" in table:
        reason = "given together with mass; give damping_coefficient or damping_ratio"
        faults.add(("oscillator", "damping"), reason, shown(table["damping"]))
    if units is not None and not units.mass and (units.length or units.time):
        faults.add(("oscillator", "units", "mass"), "missing; the oscillator has a mass")
    if faults.is_wrong("oscillator"):
        return oscillator
    try:
        return Oscillator.from_mass(
            table["mass"], table["stiffness"], **dampings, stops=oscillator.stops, units=units
        )
    except ParameterError as error:
        name = f"oscillator.{error.name}"
        reason = error.reason.replace("it, ", "it, oscillator.", 1)
        reason = reason if error.name == "mass" else error.reason
        faults.add_from_model([Fault(name, error.value, reason)])
        return oscillator


def stop_of(row: Any) -> Wall | SoftStop:
    """Return a stop as a draft from its table, with what it acts on where that is given."""
    needed = {"at": MISSING, "side": MISSING, "on": None}
    kind = row.get("type") if isinstance(row, Mapping) else None
    if kind == "soft":
        return _drafted(SoftStop, row, {**needed, "stiffness": MISSING, "damping": 0.0})
    # A stop of another type has a fault already; as a wall without a place it gets no second one.
    given = row.get("restitution") if isinstance(row, Mapping) else None
    if isinstance(given, Mapping):
        table = _drafted(RestitutionTable, given, {"speeds": MISSING, "values": MISSING})
        row = {**row, "restitution": table}
    return _drafted(Wall, row, {**needed, "restitution": 1.0})


def forcing_of(
    table: RawTable,
    path: Path,
    folder: FilePath | None,
    faults: StudyFaults,
    *,
    units: Units | None = None,
) -> Forcing:
    """Return a force as a draft from its table, whose path is given, and add its faults."""
    constant, period = table.get("constant", 0.0), table.get("period")
    given = [name for name in _FOURIER if name in table]
    record = None
    if isinstance(table.get("record"), Mapping):
        record = record_of(
            table["record"],
            folder,
            faults,
            (*path, "record"),
            units=units,
            is_per_mass=_is_per_mass(table),
        )
    if not given:
        harmonics = tuple(_harmonic(row) for row in list_of(table, "harmonics"))
        harmonics += _sea(table, path, faults)
        own = {"harmonics": harmonics, "period": exact_phase(period), "record": record}
        forcing = draft(Forcing, **own, constant=constant, is_per_mass=_is_per_mass(table))
    else:
        for name in ("harmonics", "period", "sea_state"):
            if name in table:
                reason = f"given together with {given[0]}; omega, cos and sin stand alone"
                faults.add((*path, name), reason)
        if "omega" not in table:
            faults.add((*path, "omega"), "missing; cos and sin need the base frequency")
        forcing = _fourier(table, constant, record)
    faults.add_from_model(model_faults(forcing, ".".join(map(str, path))))
    return forcing


def _sea(table: RawTable, path: Path, faults: StudyFaults) -> tuple[Harmonic, ...]:
    """Return the harmonics of ``[forcing.sea_state]``, none where it has faults; add these."""
    given, dotted = table.get("sea_state"), ".".join(map(str, (*path, "sea_state")))
    if not isinstance(given, Mapping):
        return ()
    # In place of a key that is missing or has a fault already, one without fault is checked.
    own: dict[str, Any] = {"hs": 1, "tp": 1, "kind": "jonswap", "n": 40, "seed": 0}
    own |= {key: value for key, value in given.items() if not faults.is_wrong(f"{dotted}.{key}")}
    factor = own.pop("amplitude", 1)
    wrong = [*sea_faults(**own), *number_faults("amplitude", factor)]
    faults.add_from_model(replace(fault, name=f"{dotted}.{fault.name}") for fault in wrong)
    if wrong or faults.is_wrong(dotted):
        return ()
    sea = sea_state(**own)
    # Plain harmonics, with neither a base nor a period.
    if any(isinstance(value, Expression) for value in (factor, own["hs"], own["tp"])):
        return cast("tuple[Harmonic, ...]", (sea * factor).harmonics)
    # As doubles: exact products of doubles have many digits, and round to the same.
    return tuple(
        Harmonic(as_float(factor) * as_float(part.amplitude), part.omega, part.phase)
        for part in cast("tuple[Harmonic, ...]", sea.harmonics)
    )


def _is_per_mass(table: RawTable) -> bool:
    """Return whether a force is per unit mass; a value of another type has a fault already."""
    return table.get("per_mass", False) is True


def _harmonic(row: Any) -> Harmonic:
    given = dict(row) if isinstance(row, Mapping) else {}
    if "phase" in given:
        given["phase"] = exact_phase(given["phase"])
    return _drafted(Harmonic, given, {"amplitude": MISSING, "omega": MISSING, "phase": 0.0})


def _fourier(table: RawTable, constant: Any, record: ForceRecord | None) -> Forcing:
    cos, sin = list_of(table, "cos"), list_of(table, "sin")
    count = max(len(cos), len(sin))
    pairs = zip(*(values + [0.0] * (count - len(values)) for values in (cos, sin)), strict=True)
    terms = tuple(draft(FourierTerm, n=n, cos=c, sin=s) for n, (c, s) in enumerate(pairs, 1))
    base = table.get("omega", MISSING)
    own = {"harmonics": terms, "constant": constant, "base": base, "record": record}
    return draft(Forcing, **own, is_per_mass=_is_per_mass(table))


def list_of(table: RawTable, name: str) -> list[Any]:
    """Return a list in a table, empty where there is none."""
    rows = table.get(name, [])
    return rows if isinstance(rows, list) else []


def _drafted(kind: type[ModelPart], row: Any, defaults: RawTable) -> ModelPart:
    """Return a part of the model, not checked, from the keys of a row."""
    given = row if isinstance(row, Mapping) else {}
    return draft(kind, **{name: given.get(name, value) for name, value in defaults.items()})
