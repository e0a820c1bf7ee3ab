"""The text of a study file: its tables, the lines that are not TOML, and the line of each key."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field

from percuss.studies.tables import Path, StudyFault, shown

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


def is_other_format(lines: list[str], faults: list[StudyFault]) -> bool:
    """Return whether too many lines are not TOML: it is another kind of file."""
    if len(faults) < _OF_ANOTHER_KIND:
        return False
    # Lines with faults have been emptied, except a last one at which the reading ended.
    last = faults[-1].line or 0
    right = sum(
        1 for line in lines[: last - 1] if line.strip() and not line.lstrip().startswith("#")
    )
    return len(faults) >= right


def fault_of_other_format(name: str, first: StudyFault) -> StudyFault:
    """Return the fault of a file that is of another kind, from that of its first line."""
    reason = f'not a TOML file: {first.reason}; "percuss new" writes a study to begin with'
    return StudyFault(name, first.line, "", reason)


def read_document(
    text: str, name: str
) -> tuple[dict[str, object] | None, list[str], list[StudyFault]]:
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
