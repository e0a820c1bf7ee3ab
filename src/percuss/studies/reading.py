"""Study files to studies; every fault of a file is found in one reading."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from percuss.errors import StudyError
from percuss.io.record import load_record
from percuss.model.faults import draft
from percuss.model.start import Start
from percuss.studies.faults import Path, StudyFault, StudyFaults, shown, unknown_key, unknown_value
from percuss.studies.model_tables import read_model
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
    StudyTable,
    keys_of,
    raw_table,
    read,
    values_of,
)

_RESULTS = (".nc", ".csv", ".png", ".svg")
_MOST_SYNTAX_FAULTS = 20
# So many lines that are not TOML, and half of those that were read: it is another kind of file.
_OF_ANOTHER_KIND = 3
_TWICE = re.compile(r"cannot declare \((?P<path>.*)\) twice", re.IGNORECASE)
# A value that begins like a word, a fraction or a multiple of pi, and is none of TOML's words.
_UNQUOTED = re.compile(
    r"\s*(?P<key>[\w.-]+)\s*=\s*(?!(?:(?i:true|false)|[+-]?inf|[+-]?nan)\s*(?:#|$))"
    r"(?P<value>[+-]?(?:[^\W\d]|\d[\d.]*\s*[*/])[^\"'#]*?)\s*(?:#.*)?"
)
_PLACE = re.compile(r"\s*\(at (?:line (?P<line>\d+), column \d+|end of document)\)$")

# Tables and keys that files of all kinds may have.
_OF_ALL = ("study", "oscillator", "forcing", "save", "draw")
_SAVE, _DRAW = ("netcdf", "csv"), ("png", "svg", "length_unit", "time_unit")

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
        return parse_study(file.read_bytes().decode("utf-8-sig"), str(path))
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


def parse_study(text: str, name: str = "study") -> Study:
    r"""Return the study in a TOML text.

    Parameters
    ----------
    text
        The text of a study file.
    name
        Name of the file, for messages.

    Returns
    -------
    Study
        The study, with every number as it was given.

    Raises
    ------
    StudyError
        With all faults of the text: its syntax, unknown and missing keys, wrong types, and
        what the model cannot take; each with its line and its dotted path.

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
    study = build_study(document, faults)
    # A line that could not be read may hold what seems to be missing.
    certain = (f for f in faults.faults if not (syntax and f.reason.startswith("missing")))
    ordered = sorted(certain, key=lambda fault: (fault.line or 0, fault.path))
    if ordered or study is None:
        raise StudyError(ordered)
    return study


def build_study(document: RawTable, faults: StudyFaults) -> Study | None:
    """Return the study of a document, None if it has faults; add the faults to those found.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    faults
        The faults found so far.
    """
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
    oscillator, forcing, given = read_model(document, faults)
    if question is None:
        return None
    question = question.checked(StudyDraft(document, oscillator, forcing, draw, faults))
    if faults.faults:
        return None
    return Study(oscillator, forcing, question, head.title, save, draw, given, certify)


def known_keys(kind: type[Question] | None) -> dict[str, list[str]]:
    """Return the tables that files of a kind have besides the model, with their keys.

    Parameters
    ----------
    kind
        The kind; None: what files of all kinds have.
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
    """Return the question of a document, and add what is wrong with its shape."""
    given: dict[str, Any] = {}
    for name, info in kind.__pydantic_fields__.items():  # type: ignore[attr-defined]
        table = TABLES.get(name)
        if table is None or (table not in document and not info.is_required()):
            continue
        raw = raw_table(document, table)
        shape = StartTable if name == "start" else info.annotation
        # What the ranges and axes in [over] may be is a question to the model.
        value = dict(raw) if name == "over" else read(shape, raw, faults, (table,))
        given[name] = draft(Start, **values_of(value)) if name == "start" else value
    own = raw_table(document, kind.kind)
    known = [name for name in keys_of(kind) if name not in TABLES]
    return read(kind, own if known else {}, faults, (kind.kind,), known, given)


def _check_tables(document: RawTable, kind: type[Question] | None, faults: StudyFaults) -> None:
    """Add tables that are unknown, missing, or none."""
    known = [*_OF_ALL, *(_table_names(kind) if kind is not None else ())]
    of_some_kinds = {*TABLES.values(), *kind_names(), "certify"} - {"motion"}
    for name, table in document.items():
        if name in known or name == "record":
            if not isinstance(table, Mapping):
                faults.add((name,), "not a table", shown(table))
        elif kind is not None and name in of_some_kinds:
            reason = f"no table of this kind of study; its tables are {', '.join(known)}"
            faults.add((name,), reason)
        elif kind is not None:
            faults.add((name,), unknown_key(name, known))
    for name in ("oscillator", *(kind.needed if kind is not None else ())):
        if name not in document:
            faults.add((name,), f"missing; a table [{name}] is needed")


def _is_no_toml(lines: list[str], faults: list[StudyFault]) -> bool:
    """Return whether so many lines are not TOML that it is another kind of file."""
    if len(faults) < _OF_ANOTHER_KIND:
        return False
    # Lines with faults have been emptied, but for the last one where the reading ended there.
    last = faults[-1].line or 0
    right = sum(
        1 for line in lines[: last - 1] if line.strip() and not line.lstrip().startswith("#")
    )
    return len(faults) >= right


def _no_toml(name: str, first: StudyFault) -> StudyFault:
    reason = f'not a TOML file: {first.reason}; "percuss new" writes a study to begin with'
    return StudyFault(name, first.line, "", reason)


def _document(text: str, name: str) -> tuple[dict[str, object] | None, list[str], list[StudyFault]]:
    """Read a text, leaving out the lines that are not TOML; return it, its lines and faults.

    The document is None where what is left out may change the meaning of the rest.
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
    """Return what is wrong with a line that is not TOML, and what may have been meant."""
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
    """A walk over the tokens of a valid TOML text that notes where keys stand."""

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
        """Take a value, and note the lines of what is inside it."""
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
