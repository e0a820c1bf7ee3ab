"""On which line of a TOML text each key stands: which tomllib does not return."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from percuss.studies.faults import Path

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
