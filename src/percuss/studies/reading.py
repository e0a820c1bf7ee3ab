"""Studies from study files, with all faults of a file in one reading."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, get_args

from percuss.errors import StudyError
from percuss.io.record import load_record
from percuss.model.faults import draft, unit_problem
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.studies.model_tables import read_oscillator
from percuss.studies.parameters import UNUSED, with_expressions
from percuss.studies.study import (
    TABLES,
    Question,
    Study,
    StudyDraft,
    kind_named,
    kind_names,
)
from percuss.studies.tables import (
    Certify,
    Draw,
    RawTable,
    Save,
    StartTable,
    StructureStartTable,
    StudyFault,
    StudyFaults,
    StudyTable,
    keys_of,
    raw_table,
    read,
    shown,
    unknown_key,
    unknown_value,
    values_of,
)
from percuss.studies.toml_lines import (
    fault_of_other_format,
    is_other_format,
    key_lines,
    read_document,
)
from percuss.wording import closest

_RESULTS = (".nc", ".csv", ".png", ".svg")

# Tables and keys of the files of all kinds: those of the model, and others.
_OF_OSCILLATOR, _OF_STRUCTURE = ("oscillator", "forcing"), ("structure", "loads")
_OF_ALL = ("save", "draw")
_SAVE = ("netcdf", "csv", "decimal_comma")
_DRAW = ("png", "svg", "length_unit", "time_unit")


def load_study(path: FilePath | str, *, changes: Sequence[str] = ()) -> Study:
    """Return the study in a study file, or in a result that percuss wrote.

    Parameters
    ----------
    path
        A TOML file, or a NetCDF, CSV, PNG or SVG file of an earlier run.
    changes
        Values in place of those of the file, such as ``"oscillator.damping=0.1"``.

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
            return parse_study(load_record(file).study, str(path), changes=changes)
        text = file.read_bytes().decode("utf-8-sig")
        return parse_study(text, str(path), folder=file.parent, changes=changes)
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


def parse_study(
    text: str,
    name: str = "study",
    *,
    folder: FilePath | None = None,
    changes: Sequence[str] = (),
) -> Study:
    r"""Return the study in a TOML text.

    Parameters
    ----------
    text
        The text of a study file.
    name
        Name of the file, for messages.
    folder
        The folder of the file, where those that it names lie; None: it has none beside it.
    changes
        As `load_study` takes them.

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
    ...     parse_study('[oscillator]\ndampnig = 0.1\n[start]\nx0 = 0\n[run]\nt_end = "-1"')
    ... except StudyError as error:
    ...     print(error)
    study:2: oscillator.dampnig: unknown key; did you mean "damping"?
    study:6: run.t_end = "-1": not after t0 = 0.0
    """
    document, lines, syntax = read_document(text, name)
    if is_other_format(lines, syntax):
        raise StudyError([fault_of_other_format(name, syntax[0])])
    if document is None:
        raise StudyError(syntax)
    faults = StudyFaults(name, key_lines("\n".join(lines)), list(syntax))
    if changes:
        from percuss.studies.changes import changed_document

        document = changed_document(document, changes, faults)
    study = build_study(document, faults, folder)
    # A key that seems to be missing may stand in a line that could not be read.
    unread = [text.split("\n")[fault.line - 1] for fault in syntax if fault.line]
    certain = (f for f in faults.faults if f in syntax or not _may_follow(f.reason, unread))
    ordered = sorted(certain, key=lambda fault: (fault.line or 0, fault.path))
    if ordered or study is None:
        raise StudyError(ordered)
    return study


def _may_follow(reason: str, unread: Sequence[str]) -> bool:
    """Return whether a fault may be none, since it tells of a key in a line that is not read."""
    names = [line.partition("=")[0].strip() for line in unread]
    named = (re.search(rf"\.{re.escape(name)}\b", reason) for name in names if name)
    return bool(unread and reason.startswith("missing")) or any(named)


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
    document, unused = with_expressions(document, faults)
    name = raw_table(document, "study").get("kind", "motion")
    of_structure = "structure" in document
    kind = kind_named(name) if name in kind_names() else None
    if kind is None and isinstance(name, str):
        faults.add(("study", "kind"), unknown_value(name, kind_names()), shown(name))
    _check_tables(document, kind, faults)
    known_here = known_keys(kind, of_structure=of_structure)
    head = read(StudyTable, raw_table(document, "study"), faults, ("study",))
    save = read(Save, raw_table(document, "save"), faults, ("save",), known_here["save"])
    draw = read(Draw, raw_table(document, "draw"), faults, ("draw",), known_here["draw"])
    certify = None
    if "certify" in known_here and "certify" in document:
        certify = read(Certify, raw_table(document, "certify"), faults, ("certify",))
    question = None if kind is None else _read_question(kind, document, faults)
    model: Oscillator | Structure
    force: Forcing | Loads | None
    if of_structure:
        from percuss.studies.structure_tables import read_structure

        model, force = read_structure(document, faults, folder)
    else:
        model, force = read_oscillator(document, faults, folder)
    _check_units(draw, model, faults)
    # With a faulty parameter nothing is known of the numbers that follow from it.
    if question is None or faults.is_wrong("parameters"):
        return None
    question = question.checked(StudyDraft(document, model, force, draw, faults, folder))
    for name in unused:
        faults.add(("parameters", name), UNUSED)
    if faults.faults:
        return None
    return Study(model, force, question, head.title, save, draw, certify)


def _check_units(draw: Draw, model: Oscillator | Structure, faults: StudyFaults) -> None:
    """Add the faults of units of pictures, which fit no length, or not those of the model."""
    owner = "structure" if isinstance(model, Structure) else "oscillator"
    for name in ("length", "time"):
        key = f"{name}_unit"
        value, own = getattr(draw, key, ""), getattr(model.units, name, "")
        problem = unit_problem(name, value)
        if problem is None and value and own and value != own:
            problem = f"{owner}.units says {own}"
        if problem is not None and not faults.is_wrong(f"draw.{key}"):
            faults.add(("draw", key), problem, shown(value))


def known_keys(kind: type[Question] | None, *, of_structure: bool = False) -> dict[str, list[str]]:
    """Return the tables of the files of a kind besides the model, with their keys.

    Parameters
    ----------
    kind
        The kind; None: those of the files of all kinds.
    of_structure
        Whether the model is a structure.
    """
    if kind is None:
        return {"save": [*_SAVE], "draw": [*_DRAW]}
    own = {
        name: _table_keys(kind, name, of_structure=of_structure)
        for name in _table_names(kind, of_structure=of_structure)
    }
    draw = [*_DRAW, *(kind.draw_keys_of_structures if of_structure else kind.draw_keys)]
    return {"save": [*_SAVE, *kind.save_keys], "draw": draw, **own}


def _fields_of(kind: Any, *, of_structure: bool) -> list[str]:
    """Return the fields of a table that files about an oscillator, or a structure, may have."""
    others = kind.of_oscillators if of_structure else kind.of_structures
    return [name for name in keys_of(kind) if name not in others]


def _table_names(kind: type[Question], *, of_structure: bool) -> list[str]:
    """Return the tables of the files of a kind besides those of all kinds."""
    fields = _fields_of(kind, of_structure=of_structure)
    own = [kind.kind] if set(fields) - set(TABLES) else []
    proof = ["certify"] if kind.is_certifiable and not of_structure else []
    return [*(TABLES[name] for name in TABLES if name in fields), *own, *proof]


def _table_keys(kind: type[Question], name: str, *, of_structure: bool) -> list[str]:
    """Return the keys of a table of the files of a kind; of ``[over]`` they are its paths."""
    if name == "certify":
        return keys_of(Certify)
    fields = kind.__pydantic_fields__  # type: ignore[attr-defined]
    own = [field for field in _fields_of(kind, of_structure=of_structure) if field not in TABLES]
    if name == kind.kind and own:
        return own
    (field,) = (field for field, table in TABLES.items() if table == name)
    shape = shape_of(field, fields[field], of_structure=of_structure)
    if hasattr(shape, "of_structures"):
        return _fields_of(shape, of_structure=of_structure)
    return [] if name == "over" else keys_of(shape)


def shape_of(field: str, info: Any, *, of_structure: bool) -> Any:
    """Return the type of a field that is a table of its own, also of one that may be None."""
    if field == "start":
        return StructureStartTable if of_structure else StartTable
    kinds = [kind for kind in get_args(info.annotation) if kind is not type(None)]
    return kinds[0] if len(kinds) == 1 else info.annotation


def _read_question(kind: type[Question], document: RawTable, faults: StudyFaults) -> Question:
    """Return the question of a document, and add the faults of its shape."""
    of_structure = "structure" in document
    fields = _fields_of(kind, of_structure=of_structure)
    given: dict[str, Any] = {}
    for name, info in kind.__pydantic_fields__.items():  # type: ignore[attr-defined]
        table = TABLES.get(name)
        if table is None or name not in fields:
            continue
        if table not in document and not info.is_required():
            continue
        raw = raw_table(document, table)
        shape = shape_of(name, info, of_structure=of_structure)
        known = (
            _fields_of(shape, of_structure=of_structure)
            if hasattr(shape, "of_structures")
            else None
        )
        # The ranges and axes in [over] are checked against the model.
        value = dict(raw) if name == "over" else read(shape, raw, faults, (table,), known)
        if name == "start":
            value = draft(StructureStart if of_structure else Start, **values_of(value))
        given[name] = value
    own = raw_table(document, kind.kind)
    keys = [name for name in fields if name not in TABLES]
    return read(kind, own if keys else {}, faults, (kind.kind,), keys, given)


def _check_tables(document: RawTable, kind: type[Question] | None, faults: StudyFaults) -> None:
    """Add tables that are unknown, missing or not tables."""
    of_structure = "structure" in document
    model, other = _OF_OSCILLATOR, _OF_STRUCTURE
    if of_structure:
        model, other = other, model
    own = () if kind is None else _table_names(kind, of_structure=of_structure)
    known = ["study", *model, *_OF_ALL, *own]
    meant: list[str] = []
    of_some_kinds = {*TABLES.values(), *kind_names(), "certify"} - {"motion"}
    for name, table in document.items():
        if name in known or name in ("record", "parameters"):
            if name == "loads":
                _check_list_of_loads(table, faults)
            elif not isinstance(table, Mapping):
                faults.add((name,), "not a table", shown(table))
        elif name in other and (of_structure or name == "loads"):
            faults.add((name,), _of_the_other_model(name))
        elif kind is not None and name in of_some_kinds:
            tables = ", ".join([*known, "parameters"])
            reason = f"no table of this kind of study; its tables are {tables}"
            faults.add((name,), reason)
        elif kind is not None:
            is_meant = closest(name.lower(), [*known, "parameters"])
            # A table that is there under another name is not missing as well.
            meant += [is_meant] if is_meant else []
            faults.add((name,), unknown_key(name, [is_meant] if is_meant else known))
    needed: tuple[str, ...] = ()
    if kind is not None:
        needed = kind.needed_of_structures if of_structure else kind.needed
    for name in (model[0], *needed):
        if name not in document and name not in meant:
            faults.add((name,), f"missing; a table [{name}] is needed")


def _check_list_of_loads(table: object, faults: StudyFaults) -> None:
    """Add the fault of loads that are no list of tables."""
    if not isinstance(table, list) or not all(isinstance(row, Mapping) for row in table):
        faults.add(("loads",), "not a list; begin each of them with [[loads]]", shown(table))


def _of_the_other_model(name: str) -> str:
    """Return why a table does not fit the model of a study."""
    return {
        "oscillator": "given together with [structure]; a study has one of the two",
        "forcing": "a force on one mass; those on a structure begin with [[loads]]",
        "loads": "forces on a structure, of which there is none; [forcing] acts on an oscillator",
    }[name]
