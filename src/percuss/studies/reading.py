"""Studies from study files, with all faults of a file in one reading."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, TypeVar, cast

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag
from pydantic import ValidationError as ShapeError

from percuss.errors import ParameterError, StudyError
from percuss.io.record import load_record
from percuss.model.exact import as_float
from percuss.model.expression import Expression
from percuss.model.faults import (
    Fault,
    draft,
    number_faults,
    positive_faults,
    raise_first,
    scale_faults,
    unit_problem,
)
from percuss.model.faults import faults as model_faults
from percuss.model.force_record import ForceRecord, Outside, RecordKind
from percuss.model.forcing import Forcing, FourierTerm, Harmonic
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.restitution import RestitutionTable
from percuss.model.sea_state import SeaKind, sea_state
from percuss.model.start import Start
from percuss.model.units import Units
from percuss.studies.parameters import with_expressions
from percuss.studies.record_file import record_of
from percuss.studies.study import (
    TABLES,
    Question,
    Study,
    StudyDraft,
    kind_named,
    kind_names,
)
from percuss.studies.tables import (
    MISSING,
    Certify,
    Draw,
    NumberKey,
    Path,
    PhaseKey,
    RawTable,
    Save,
    StartTable,
    StudyFault,
    StudyFaults,
    StudyTable,
    exact_phase,
    keys_of,
    raw_table,
    read,
    sentence,
    shown,
    unknown_key,
    unknown_value,
    values_of,
)

_RESULTS = (".nc", ".csv", ".png", ".svg")
_MOST_SYNTAX_FAULTS = 20
# A file with so many lines that are not TOML, and no more that are, is of another kind.
_OF_ANOTHER_KIND = 3
_TWICE = re.compile(r"cannot declare \((?P<path>.*)\) twice", re.IGNORECASE)
# A value without quotes that begins like a word, a fraction or a multiple of pi.
_UNQUOTED = re.compile(
    r"\s*(?P<key>[\w.-]+)\s*=\s*(?!(?:(?i:true|false)|[+-]?inf|[+-]?nan)\s*(?:#|$))"
    r"(?P<value>[+-]?(?:[^\W\d]|\d[\d.]*\s*[*/])[^\"'#]*?)\s*(?:#.*)?"
)
_PLACE = re.compile(r"\s*\(at (?:line (?P<line>\d+), column \d+|end of document)\)$")

# Tables and keys of the files of all kinds.
_OF_ALL = ("study", "oscillator", "forcing", "save", "draw")
_SAVE, _DRAW = ("netcdf", "csv"), ("png", "svg", "length_unit", "time_unit")

ModelPart = TypeVar("ModelPart", Wall, SoftStop, Harmonic, RestitutionTable)

_FOURIER = ("omega", "cos", "sin")
_DAMPINGS = ("damping_coefficient", "damping_ratio")

__all__ = ["build_study", "known_keys", "load_study", "parse_study"]


def load_study(path: FilePath | str) -> Study:
    """Return the study in a study file, or in a result that percuss wrote.

    Parameters
    ----------
    path
        A TOML file, or a NetCDF, CSV, PNG or SVG file of an earlier run.

    Returns
    -------
    Study
        The study.

    Raises
    ------
    StudyError
        If the file cannot be read, or with all of its faults.
    """
    file = FilePath(path)
    try:
        if file.suffix.lower() in _RESULTS:
            return parse_study(load_record(file).study, str(path))
        text = file.read_bytes().decode("utf-8-sig")
        return parse_study(text, str(path), folder=file.parent)
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        reason = f"not UTF-8 text: byte {error.start} is 0x{error.object[error.start]:02x}"
        raise StudyError([StudyFault(str(path), line, "", reason)]) from error
    except OSError as error:
        words = (error.strerror or "no such file").lower()
        hint = '; "percuss new" writes one' if isinstance(error, FileNotFoundError) else ""
        raise StudyError([StudyFault(str(path), None, "", words + hint)]) from error
    except StudyError:
        raise
    except ValueError as error:
        raise StudyError([error]) from error


def parse_study(text: str, name: str = "study", *, folder: FilePath | None = None) -> Study:
    r"""Return the study in a TOML text.

    Parameters
    ----------
    text
        The text of a study file.
    name
        Name of the file, for messages.
    folder
        The folder of the file, where those that it names lie; None: it has none beside it.

    Returns
    -------
    Study
        The study, with every number as it was given.

    Raises
    ------
    StudyError
        With all faults of the text: its syntax, unknown and missing keys, wrong types, and values
        that the model cannot take; each with its line and its dotted path.

    Examples
    --------
    >>> try:
    ...     parse_study('[oscillator]\ndampnig = 0.1\n[start]\nx0 = 0\n[run]\nt_end = "10"')
    ... except StudyError as error:
    ...     print(error)
    study:2: oscillator.dampnig: unknown key; did you mean "damping"?
    study:3: start.v0: missing
    """
    document, lines, syntax = _document(text, name)
    if _is_no_toml(lines, syntax):
        raise StudyError([_no_toml(name, syntax[0])])
    if document is None:
        raise StudyError(syntax)
    faults = StudyFaults(name, key_lines("\n".join(lines)), list(syntax))
    study = build_study(document, faults, folder)
    # A key that seems to be missing may stand in a line that could not be read.
    certain = (f for f in faults.faults if not (syntax and f.reason.startswith("missing")))
    ordered = sorted(certain, key=lambda fault: (fault.line or 0, fault.path))
    if ordered or study is None:
        raise StudyError(ordered)
    return study


def build_study(
    document: RawTable, faults: StudyFaults, folder: FilePath | None = None
) -> Study | None:
    """Return the study of a document, None if it has faults; add these.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    faults
        The faults found so far.
    folder
        The folder of the file, None without one.
    """
    document = with_expressions(document, faults)
    name = raw_table(document, "study").get("kind", "motion")
    kind = kind_named(name) if name in kind_names() else None
    if kind is None and isinstance(name, str):
        faults.add(("study", "kind"), unknown_value(name, kind_names()), shown(name))
    _check_tables(document, kind, faults)
    known = known_keys(kind)
    head = read(StudyTable, raw_table(document, "study"), faults, ("study",))
    save = read(Save, raw_table(document, "save"), faults, ("save",), known["save"])
    draw = read(Draw, raw_table(document, "draw"), faults, ("draw",), known["draw"])
    certify = None
    if "certify" in known and "certify" in document:
        certify = read(Certify, raw_table(document, "certify"), faults, ("certify",))
    question = None if kind is None else _read_question(kind, document, faults)
    oscillator, forcing = read_model(document, faults, folder)
    _check_units(draw, oscillator, faults)
    # With a faulty parameter nothing is known of the numbers that follow from it.
    if question is None or faults.is_wrong("parameters"):
        return None
    question = question.checked(StudyDraft(document, oscillator, forcing, draw, faults))
    if faults.faults:
        return None
    return Study(oscillator, forcing, question, head.title, save, draw, certify)


def _check_units(draw: Draw, oscillator: Oscillator, faults: StudyFaults) -> None:
    """Add the faults of units of pictures, which fit no length, or not those of the oscillator."""
    for name in ("length", "time"):
        key = f"{name}_unit"
        value, own = getattr(draw, key, ""), getattr(oscillator.units, name, "")
        problem = unit_problem(name, value)
        if problem is None and value and own and value != own:
            problem = f"oscillator.units says {own}"
        if problem is not None and not faults.is_wrong(f"draw.{key}"):
            faults.add(("draw", key), problem, shown(value))


def known_keys(kind: type[Question] | None) -> dict[str, list[str]]:
    """Return the tables of the files of a kind besides the model, with their keys.

    Parameters
    ----------
    kind
        The kind; None: those of the files of all kinds.
    """
    if kind is None:
        return {"save": [*_SAVE], "draw": [*_DRAW]}
    own = {name: _table_keys(kind, name) for name in _table_names(kind)}
    return {"save": [*_SAVE, *kind.save_keys], "draw": [*_DRAW, *kind.draw_keys], **own}


def _table_names(kind: type[Question]) -> list[str]:
    """Return the tables of the files of a kind besides those of all kinds."""
    fields = keys_of(kind)
    own = [kind.kind] if set(fields) - set(TABLES) else []
    proof = ["certify"] if kind.is_certifiable else []
    return [*(TABLES[name] for name in TABLES if name in fields), *own, *proof]


def _table_keys(kind: type[Question], name: str) -> list[str]:
    """Return the keys of a table of the files of a kind; of ``[over]`` they are its paths."""
    if name == "certify":
        return keys_of(Certify)
    fields = kind.__pydantic_fields__  # type: ignore[attr-defined]
    own = [field for field in fields if field not in TABLES]
    if name == kind.kind and own:
        return own
    (field,) = (field for field, table in TABLES.items() if table == name)
    shape = StartTable if name == "start" else fields[field].annotation
    return [] if name == "over" else keys_of(shape)


def _read_question(kind: type[Question], document: RawTable, faults: StudyFaults) -> Question:
    """Return the question of a document, and add the faults of its shape."""
    given: dict[str, Any] = {}
    for name, info in kind.__pydantic_fields__.items():  # type: ignore[attr-defined]
        table = TABLES.get(name)
        if table is None or (table not in document and not info.is_required()):
            continue
        raw = raw_table(document, table)
        shape = StartTable if name == "start" else info.annotation
        # The ranges and axes in [over] are checked against the model.
        value = dict(raw) if name == "over" else read(shape, raw, faults, (table,))
        given[name] = draft(Start, **values_of(value)) if name == "start" else value
    own = raw_table(document, kind.kind)
    known = [name for name in keys_of(kind) if name not in TABLES]
    return read(kind, own if known else {}, faults, (kind.kind,), known, given)


def _check_tables(document: RawTable, kind: type[Question] | None, faults: StudyFaults) -> None:
    """Add tables that are unknown, missing or not tables."""
    known = [*_OF_ALL, *(_table_names(kind) if kind is not None else ())]
    meant: list[str] = []
    of_some_kinds = {*TABLES.values(), *kind_names(), "certify"} - {"motion"}
    for name, table in document.items():
        if name in known or name in ("record", "parameters"):
            if not isinstance(table, Mapping):
                faults.add((name,), "not a table", shown(table))
        elif kind is not None and name in of_some_kinds:
            reason = f"no table of this kind of study; its tables are {', '.join(known)}"
            faults.add((name,), reason)
        elif kind is not None:
            is_meant = difflib.get_close_matches(name.lower(), [*known, "parameters"], n=1)
            # A table that is there under another name is not missing as well.
            meant += is_meant
            faults.add((name,), unknown_key(name, is_meant or known))
    for name in ("oscillator", *(kind.needed if kind is not None else ())):
        if name not in document and name not in meant:
            faults.add((name,), f"missing; a table [{name}] is needed")


class _Shape(BaseModel):
    """The shape of a table of the model: its keys and their types; the model checks the numbers."""

    model_config = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)


class _TableShape(_Shape):
    speeds: list[NumberKey]
    values: list[NumberKey]


class _WallShape(_Shape):
    type: Literal["wall"]
    at: NumberKey
    side: Literal["above", "below"]
    restitution: Annotated[
        Annotated[NumberKey, Tag("number")] | Annotated[_TableShape, Tag("table")],
        Discriminator(lambda value: "table" if isinstance(value, Mapping) else "number"),
    ] = 1.0


class _SoftShape(_Shape):
    type: Literal["soft"]
    at: NumberKey
    side: Literal["above", "below"]
    stiffness: NumberKey
    damping: NumberKey = 0.0


class _UnitsShape(_Shape):
    length: str = ""
    time: str = ""
    mass: str = ""


class _OscillatorShape(_Shape):
    stiffness: NumberKey = 1.0
    damping: NumberKey = 0.0
    mass: NumberKey | None = None
    damping_coefficient: NumberKey | None = None
    damping_ratio: NumberKey | None = None
    units: _UnitsShape | None = None
    stops: list[Annotated[_WallShape | _SoftShape, Field(discriminator="type")]] = []


class _HarmonicShape(_Shape):
    amplitude: NumberKey
    omega: NumberKey
    phase: PhaseKey = 0.0


class _RecordShape(_Shape):
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


class _SeaShape(_Shape):
    hs: NumberKey
    tp: NumberKey
    kind: SeaKind = "jonswap"
    n: int = 40
    seed: int = 0
    amplitude: NumberKey = 1


class _ForcingShape(_Shape):
    constant: NumberKey = 0.0
    per_mass: bool = False
    period: PhaseKey | None = None
    harmonics: list[_HarmonicShape] = []
    omega: NumberKey | None = None
    cos: list[NumberKey] = []
    sin: list[NumberKey] = []
    record: _RecordShape | None = None
    sea_state: _SeaShape | None = None


_SHAPES: dict[str, type[_Shape]] = {"oscillator": _OscillatorShape, "forcing": _ForcingShape}
_STOPS: dict[object, type[_Shape]] = {"wall": _WallShape, "soft": _SoftShape}


def read_model(
    document: RawTable, faults: StudyFaults, folder: FilePath | None = None
) -> tuple[Oscillator, Forcing | None]:
    """Return the model of a document, and add its faults.

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
        The model; drafts where they have faults.
    """
    for name in _SHAPES:
        if isinstance(document.get(name), Mapping):
            _check_shape(name, document[name], faults)
    oscillator = _oscillator(raw_table(document, "oscillator"), faults)
    forcing = None
    if "forcing" in document:
        forcing = _forcing(raw_table(document, "forcing"), folder, faults)
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


def _check_shape(name: str, table: RawTable, faults: StudyFaults) -> None:
    """Add the faults of the shape of a table: unknown keys, missing keys, wrong types."""
    shape = _SHAPES[name]
    try:
        shape.model_validate(table)
    except ShapeError as error:
        for wrong in error.errors(include_url=False):
            place, kind, value = wrong["loc"], wrong["type"], wrong["input"]
            known = shape
            if place[:1] == ("stops",) and place[2:3] in (("wall",), ("soft",)):
                # pydantic puts the type of a stop into its path.
                known, place = _STOPS[place[2]], (*place[:2], *place[3:])
                if place[2:3] == ("restitution",):
                    # And whether it read a number or a table.
                    known, place = _TableShape, (*place[:3], *place[4:])
            elif place[:1] == ("harmonics",) and len(place) > 1:
                known = _HarmonicShape
            elif place[:1] == ("units",) and len(place) > 1:
                known = _UnitsShape
            elif place[:1] == ("record",) and len(place) > 1:
                known = _RecordShape
            elif place[:1] == ("sea_state",) and len(place) > 1:
                known = _SeaShape
            path = (name, *place)
            if kind == "extra_forbidden":
                faults.add(path, unknown_key(path[-1], list(known.model_fields)))
            elif kind == "union_tag_not_found":
                _add_missing_type(path, value, faults)
            elif kind == "union_tag_invalid":
                faults.add((*path, "type"), sentence(wrong), shown(value["type"]))
            elif kind == "missing":
                is_side = path[-1] == "side"
                faults.add(path, 'missing; "above" or "below"' if is_side else "missing")
            elif kind == "list_type" and path[-1] in ("stops", "harmonics"):
                reason = f"not a list; begin each of them with [[{'.'.join(map(str, path))}]]"
                faults.add(path, reason, shown(value))
            else:
                faults.add(path, sentence(wrong), shown(value))


def _add_missing_type(path: tuple[str | int, ...], stop: RawTable, faults: StudyFaults) -> None:
    """Add the faults of a stop without a type, whose other keys are not checked yet."""
    known = list(dict.fromkeys(key for shape in _STOPS.values() for key in shape.model_fields))
    for key in stop:
        if key not in known:
            faults.add((*path, key), unknown_key(key, known))
    faults.add((*path, "type"), 'missing; "wall" or "soft"')


def _oscillator(table: RawTable, faults: StudyFaults) -> Oscillator:
    stops = tuple(_stop(row) for row in _rows(table, "stops"))
    values = {"stiffness": 1.0, "damping": 0.0}
    values = {name: table.get(name, value) for name, value in values.items()}
    units = _units(table, faults)
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


def _units(table: RawTable, faults: StudyFaults) -> Units | None:
    """Return the units of an oscillator, None without any or with faults; add these."""
    given = table.get("units")
    if not isinstance(given, Mapping) or faults.is_wrong("oscillator.units"):
        return None
    for name, value in given.items():
        problem = unit_problem(name, value)
        if problem is not None:
            faults.add(("oscillator", "units", name), problem, shown(value))
    return None if faults.is_wrong("oscillator.units") else draft(Units, **given)


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


def _stop(row: Any) -> Wall | SoftStop:
    needed = {"at": MISSING, "side": MISSING}
    kind = row.get("type") if isinstance(row, Mapping) else None
    if kind == "soft":
        return _drafted(SoftStop, row, {**needed, "stiffness": MISSING, "damping": 0.0})
    # A stop of another type has a fault already; as a wall without a place it gets no second one.
    given = row.get("restitution") if isinstance(row, Mapping) else None
    if isinstance(given, Mapping):
        table = _drafted(RestitutionTable, given, {"speeds": MISSING, "values": MISSING})
        row = {**row, "restitution": table}
    return _drafted(Wall, row, {**needed, "restitution": 1.0})


def _forcing(table: RawTable, folder: FilePath | None, faults: StudyFaults) -> Forcing:
    constant, period = table.get("constant", 0.0), table.get("period")
    given = [name for name in _FOURIER if name in table]
    record = None
    if isinstance(table.get("record"), Mapping):
        record = record_of(table["record"], folder, faults)
    if not given:
        harmonics = tuple(_harmonic(row) for row in _rows(table, "harmonics"))
        harmonics += _sea(table, faults)
        own = {"harmonics": harmonics, "period": exact_phase(period), "record": record}
        forcing = draft(Forcing, **own, constant=constant, is_per_mass=_is_per_mass(table))
    else:
        for name in ("harmonics", "period", "sea_state"):
            if name in table:
                reason = f"given together with {given[0]}; omega, cos and sin stand alone"
                faults.add(("forcing", name), reason)
        if "omega" not in table:
            faults.add(("forcing", "omega"), "missing; cos and sin need the base frequency")
        forcing = _fourier(table, constant, record)
    faults.add_from_model(model_faults(forcing, "forcing"))
    return forcing


def _sea(table: RawTable, faults: StudyFaults) -> tuple[Harmonic, ...]:
    """Return the harmonics of ``[forcing.sea_state]``, none where it has faults; add these."""
    given = table.get("sea_state")
    if not isinstance(given, Mapping) or faults.is_wrong("forcing.sea_state"):
        return ()
    own = dict(given)
    factor = own.pop("amplitude", 1)
    try:
        sea = sea_state(**own)
        if not isinstance(factor, Expression):
            # As doubles: exact products of doubles have many digits, and round to the same.
            raise_first(number_faults("amplitude", factor))
            return tuple(
                Harmonic(as_float(factor) * as_float(part.amplitude), part.omega, part.phase)
                for part in cast("tuple[Harmonic, ...]", sea.harmonics)
            )
        sea = sea * factor
    except ParameterError as error:
        name = error.name if error.name in own else "amplitude"
        faults.add_from_model([Fault(f"forcing.sea_state.{name}", error.value, error.reason)])
        return ()
    # Plain harmonics, with neither a base nor a period.
    return cast("tuple[Harmonic, ...]", sea.harmonics)


def _is_per_mass(table: RawTable) -> bool:
    """Return whether a force is per unit mass; a value of another type has a fault already."""
    return table.get("per_mass", False) is True


def _harmonic(row: Any) -> Harmonic:
    given = dict(row) if isinstance(row, Mapping) else {}
    if "phase" in given:
        given["phase"] = exact_phase(given["phase"])
    return _drafted(Harmonic, given, {"amplitude": MISSING, "omega": MISSING, "phase": 0.0})


def _fourier(table: RawTable, constant: Any, record: ForceRecord | None) -> Forcing:
    cos, sin = _rows(table, "cos"), _rows(table, "sin")
    count = max(len(cos), len(sin))
    pairs = zip(*(values + [0.0] * (count - len(values)) for values in (cos, sin)), strict=True)
    terms = tuple(draft(FourierTerm, n=n, cos=c, sin=s) for n, (c, s) in enumerate(pairs, 1))
    base = table.get("omega", MISSING)
    own = {"harmonics": terms, "constant": constant, "base": base, "record": record}
    return draft(Forcing, **own, is_per_mass=_is_per_mass(table))


def _rows(table: RawTable, name: str) -> list[Any]:
    """Return a list in a table, empty where there is none."""
    rows = table.get(name, [])
    return rows if isinstance(rows, list) else []


def _drafted(kind: type[ModelPart], row: Any, defaults: RawTable) -> ModelPart:
    """Return a part of the model, not checked, from the keys of a row."""
    given = row if isinstance(row, Mapping) else {}
    return draft(kind, **{name: given.get(name, value) for name, value in defaults.items()})


def _is_no_toml(lines: list[str], faults: list[StudyFault]) -> bool:
    """Return whether too many lines are not TOML: it is another kind of file."""
    if len(faults) < _OF_ANOTHER_KIND:
        return False
    # Lines with faults have been emptied, except a last one at which the reading ended.
    last = faults[-1].line or 0
    right = sum(
        1 for line in lines[: last - 1] if line.strip() and not line.lstrip().startswith("#")
    )
    return len(faults) >= right


def _no_toml(name: str, first: StudyFault) -> StudyFault:
    reason = f'not a TOML file: {first.reason}; "percuss new" writes a study to begin with'
    return StudyFault(name, first.line, "", reason)


def _document(text: str, name: str) -> tuple[dict[str, object] | None, list[str], list[StudyFault]]:
    """Read a text without the lines that are not TOML; return it, its lines and the faults.

    The document is None where a line left out may change the meaning of the others.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    faults: list[StudyFault] = []
    while True:
        try:
            return tomllib.loads("\n".join(lines)), lines, faults
        except RecursionError:
            faults.append(StudyFault(name, None, "", "lists or tables are nested too deeply"))
            return None, lines, faults
        except ValueError as error:
            place = _PLACE.search(str(error))
            number = int(place["line"]) if place and place["line"] else len(lines)
            words = _PLACE.sub("", str(error))
            bad = lines[number - 1]
            faults.append(StudyFault(name, number, "", _syntax_reason(words, bad)))
            is_stuck = not bad.strip() or bad.lstrip().startswith(("[", "#"))
            if is_stuck or len(faults) == _MOST_SYNTAX_FAULTS:
                return None, lines, faults
            lines[number - 1] = ""


def _syntax_reason(words: str, line: str) -> str:
    """Return the fault of a line that is not TOML, and the correction that may be meant."""
    reason = f"{words[:1].lower()}{words[1:]}: {shown(line.strip())}"
    twice = _TWICE.search(words)
    if twice is not None:
        table = ".".join(part.strip(" '\"") for part in twice["path"].split(",")).strip(".")
        if table in ("oscillator.stops", "forcing.harmonics"):
            return f"[{table}] twice; begin each of them with [[{table}]]"
        return f"[{table}] twice; put its keys under one"
    unquoted = _UNQUOTED.fullmatch(line)
    if unquoted is not None:
        reason += f'; put it in quotes: {unquoted["key"]} = "{unquoted["value"]}"'
    return reason


_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}'
    r"|'''.*?'{3,5}"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'"
    r"|(?P<comment>#[^\n]*)"
    r"|(?P<space>[ \t\r]+)"
    r"|\n|[\[\]{}=,.]"
    r"|[^\s\[\]{}=,.#\"']+"
    r"|.",
    re.DOTALL,
)
_OPENING, _CLOSING = ("[", "{"), ("]", "}")


@dataclass(slots=True)
class _Scanner:
    """A pass over the tokens of a valid TOML text that notes the lines of keys."""

    tokens: list[tuple[str, int]]
    position: int = 0
    lines: dict[Path, int] = field(default_factory=dict)
    counts: dict[Path, int] = field(default_factory=dict)

    def peek(self) -> str:
        return self.tokens[self.position][0] if self.position < len(self.tokens) else ""

    def line(self) -> int:
        return self.tokens[min(self.position, len(self.tokens) - 1)][1]

    def take(self) -> str:
        token = self.peek()
        self.position += 1
        return token

    def skip_newlines(self) -> None:
        while self.peek() == "\n":
            self.position += 1

    def key(self) -> list[str]:
        """Take a key, dotted or not."""
        parts = [_unquoted(self.take())]
        while self.peek() == ".":
            self.position += 1
            parts.append(_unquoted(self.take()))
        return parts

    def header(self) -> Path:
        """Take the header of a table and return the path of the table."""
        line = self.line()
        self.position += 1
        is_array = self.peek() == "["
        if is_array:
            self.position += 1
        parts = self.key()
        path: Path = ()
        for part in parts[:-1]:
            path = self._entered((*path, part))
        path = (*path, parts[-1])
        if is_array:
            self.counts[path] = self.counts.get(path, -1) + 1
            self.lines.setdefault(path, line)
        path = self._entered(path)
        self.lines.setdefault(path, line)
        while self.peek() not in ("\n", ""):
            self.position += 1
        return path

    def _entered(self, path: Path) -> Path:
        """Return the path of a table, or of the last one of an array of tables."""
        return (*path, self.counts[path]) if path in self.counts else path

    def assignment(self, table: Path) -> None:
        """Take ``key = value`` below a table."""
        line = self.line()
        path = table
        for part in self.key():
            path = (*path, part)
            self.lines.setdefault(path, line)
        if self.peek() == "=":
            self.position += 1
        self.value(path)

    def value(self, path: Path) -> None:
        """Take a value, and note the lines of its items."""
        opening = self.peek()
        if opening not in _OPENING:
            while self.peek() not in ("\n", ",", *_CLOSING, ""):
                self.position += 1
            return
        self.position += 1
        index = 0
        while True:
            self.skip_newlines()
            if self.peek() in (*_CLOSING, ""):
                self.position += 1
                return
            if self.peek() == ",":
                self.position += 1
                continue
            if opening == "[":
                self.lines[(*path, index)] = self.line()
                self.value((*path, index))
                index += 1
            else:
                self.assignment(path)


def _unquoted(token: str) -> str:
    return token[1:-1] if token[:1] in ("'", '"') else token


def key_lines(text: str) -> dict[Path, int]:
    r"""Return the line, from 1, on which each key, table and list item of a TOML text stands.

    Parameters
    ----------
    text
        A text that `tomllib` reads.

    Returns
    -------
    dict
        Lines by path, a tuple of keys and of indices into lists.

    Examples
    --------
    >>> lines = key_lines("[oscillator]\nstops = [\n  {at = 1},\n  {at = 2},\n]")
    >>> lines["oscillator", "stops"], lines["oscillator", "stops", 1, "at"]
    (2, 4)
    """
    tokens, line = [], 1
    for match in _TOKEN.finditer(text):
        if not match["comment"] and not match["space"]:
            tokens.append((match[0], line))
        line += match[0].count("\n")
    scanner = _Scanner(tokens)
    table: Path = ()
    while scanner.position < len(tokens):
        scanner.skip_newlines()
        if scanner.peek() == "[":
            table = scanner.header()
        elif scanner.peek():
            scanner.assignment(table)
            # Nothing follows a value on its line; a text that is not TOML must not loop here.
            while scanner.peek() not in ("\n", ""):
                scanner.position += 1
    return scanner.lines
