"""What is wrong with a study file, each fault with its line and its dotted path."""

from __future__ import annotations

from dataclasses import dataclass

# Longer values are cut in messages.
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
