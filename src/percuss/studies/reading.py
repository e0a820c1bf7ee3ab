"""Study files to studies; every fault of a file is found in one reading."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from percuss.errors import StudyError
from percuss.io.reading import load_record
from percuss.studies.building import build
from percuss.studies.faults import StudyFault, shown
from percuss.studies.lines import key_lines
from percuss.studies.shape import Found
from percuss.studies.study import Study

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

__all__ = ["load_study", "parse_study"]


def load_study(path: Path | str) -> Study:
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
    file = Path(path)
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
    found = Found(name, key_lines("\n".join(lines)), list(syntax))
    study = build(document, found)
    # A line that could not be read may hold what seems to be missing.
    certain = (f for f in found.faults if not (syntax and f.reason.startswith("missing")))
    faults = sorted(certain, key=_place)
    if faults or study is None:
        raise StudyError(faults)
    return study


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


def _place(fault: StudyFault) -> tuple[int, str]:
    return fault.line or 0, fault.path


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
