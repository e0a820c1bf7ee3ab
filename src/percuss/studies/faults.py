"""What is wrong with a study file, each fault with its line and its dotted path."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from percuss.model.exact import NOT_A_NUMBER, NOT_A_PHASE
from percuss.model.faults import Fault

__all__ = ["MISSING", "NO_NUMBER", "NO_PHASE", "Path", "StudyFault", "StudyFaults", "line_of",
           "shown", "unknown_key", "unknown_value", "words_of_file"]  # fmt: skip

# Keys, and indices into lists.
Path: TypeAlias = tuple[str | int, ...]

# In place of a key that is needed and has a fault already.
MISSING: Any = object()
NO_NUMBER = 'not a number; write 2.8, or "2.8" for that decimal, "1/3" for that fraction'
NO_PHASE = f'{NO_NUMBER}, "pi/2" for that multiple of pi'
# What the model says, and what it is called in a file.
_WORDS_OF_FILE = {NOT_A_NUMBER: NO_NUMBER, NOT_A_PHASE: NO_PHASE}
# Longer values are cut in messages: about what a line of a terminal holds beside the sentence.
_LONGEST_VALUE = 60


@dataclass(frozen=True, slots=True)
class StudyFault:
    """One thing that is wrong with a study file.

    Parameters
    ----------
    file
        Name of the file, as it was given.
    line
        Line, from 1; None where no line can be named.
    path
        Dotted path of the key; empty for a fault of the syntax.
    reason
        What is wrong, and what would be right.
    value
        What was given, as it is shown; empty if there is none.

    Examples
    --------
    >>> print(StudyFault("study.toml", 7, "run.t_end", "not after t0 = 0", "-1"))
    study.toml:7: run.t_end = -1: not after t0 = 0
    """

    file: str
    line: int | None
    path: str
    reason: str
    value: str = ""

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        path = _on_one_line(self.path)
        name = f"{path} = {self.value}" if self.value else path
        return ": ".join(part for part in (place, name, self.reason) if part)


@dataclass(slots=True)
class StudyFaults:
    """The faults of one file as they are collected, and the lines of its keys."""

    file: str
    lines: dict[Path, int]
    faults: list[StudyFault] = field(default_factory=list)

    def add(self, path: Path, reason: str, value: str = "") -> None:
        """Add a fault, unless this key, a key in it or the table around it has one already."""
        parts = [str(part) for part in path]
        dotted = ".".join(parts)
        around = {".".join(parts[:length]) for length in range(1, len(parts))}
        if not self.is_wrong(dotted) and not any(fault.path in around for fault in self.faults):
            line = line_of(self.lines, path)
            self.faults.append(StudyFault(self.file, line, dotted, reason, value))

    def add_from_model(self, faults: Iterable[Fault]) -> None:
        """Add faults that the model reports, in the words of a file."""
        for fault in faults:
            if fault.value is not MISSING:
                names = fault.name.split(".")
                path = tuple(int(name) if name.isdecimal() else name for name in names)
                self.add(path, words_of_file(fault.reason), shown(fault.value))

    def is_wrong(self, dotted: str) -> bool:
        """Return whether a key or a key in it has a fault already."""
        return any(
            fault.path == dotted or fault.path.startswith(f"{dotted}.") for fault in self.faults
        )


def line_of(lines: dict[Path, int], path: Sequence[str | int]) -> int | None:
    """Return the line of a path, or of the innermost table or list around it."""
    for length in range(len(path), 0, -1):
        line = lines.get(tuple(path[:length]))
        if line is not None:
            return line
    return None


def words_of_file(reason: str) -> str:
    """Return what the model says of a value in the words of a file."""
    return _WORDS_OF_FILE.get(reason, reason)


def unknown_key(key: object, known: list[str]) -> str:
    """Return which of the known keys another one may have been meant to be."""
    close = difflib.get_close_matches(str(key).lower(), known, n=1)
    if close:
        return f'unknown key; did you mean "{close[0]}"?'
    return f"unknown key; known here: {', '.join(known)}"


def unknown_value(value: object, known: list[str]) -> str:
    """Return which of the known values another one may have been meant to be."""
    close = difflib.get_close_matches(str(value).lower(), known, n=1)
    listed = f"{', '.join(known[:-1])} or {known[-1]}"
    return f'did you mean "{close[0]}"? There are {listed}' if close else f"not {listed}"


def shown(value: object) -> str:
    """Return a value as it is shown in a message.

    Examples
    --------
    >>> shown("0.5"), shown(True), shown(list(range(100)))[-5:]
    ('"0.5"', 'true', '1 ...')
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    return _on_one_line(f'"{value}"' if isinstance(value, str) else repr(value))


def _on_one_line(text: str) -> str:
    """Return a text without line ends and marks of control, cut where it is long."""
    text = text.encode("unicode_escape").decode("ascii") if not text.isprintable() else text
    return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 4]} ..."
