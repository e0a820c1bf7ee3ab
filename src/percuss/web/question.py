"""What a client asks, checked: the same tables as a study file, and limits on their size."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from percuss.errors import StudyError
from percuss.model.exact import as_float
from percuss.model.paths import long_form
from percuss.studies.kinds.motion import Motion
from percuss.studies.reading import build_study
from percuss.studies.study import Study
from percuss.studies.tables import StudyFaults

__all__ = [
    "MOST_BYTES",
    "MOST_DIGITS",
    "BadQuestion",
    "PageQuestion",
    "digits_of",
    "motion_of",
    "path_of",
    "range_of",
    "read_question",
    "study_of",
]

# Of a message, of stops and harmonics, of forcing periods: what a hand sets is far below.
MOST_BYTES = 65_536
MOST_STOPS, MOST_HARMONICS = 16, 64
MOST_PERIODS = 20_000
# Digits that the page certifies a motion to.
MOST_DIGITS = 100
# What the fields of options are called on the page.
FIELDS = {
    "low": "from",
    "high": "to",
    "x_low": "x from",
    "x_high": "x to",
    "v_low": "v from",
    "v_high": "v to",
    "points": "points at each",
    "starts": "starts along a side",
    "max_impacts": "impacts up to",
    "max_periods": "periods up to",
}
# The tables of a study that the page knows.
TABLES = ("oscillator", "forcing", "start", "run")


class BadQuestion(Exception):  # noqa: N818 - no error of the program, but of the question
    """A message that is no question; its text is a sentence for the client."""


@dataclass(frozen=True, slots=True)
class PageQuestion:
    """One message of a client.

    Parameters
    ----------
    id
        What the client calls it; the answer carries it back.
    kind
        What is asked.
    tables
        The tables of the study.
    options
        The rest of the message.
    """

    id: int
    kind: str
    tables: Mapping[str, Any]
    options: Mapping[str, Any]

    def number(self, name: str, default: float, low: float, high: float) -> float:
        """Return an option that is a number between two others.

        Raises
        ------
        BadQuestion
            If it is none.
        """
        value = self.options.get(name, default)
        called = FIELDS.get(name, name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise BadQuestion(f"{called} is not a number")
        if not low <= value <= high:
            # A whole number may have more digits than a float can hold.
            shown = f"{value:g}" if isinstance(value, float) else f"{value}"[:20]
            raise BadQuestion(f"{called} = {shown} is not between {low:g} and {high:g}")
        return float(value)

    def choice(self, name: str, choices: tuple[str, ...]) -> str:
        """Return an option that is one of several words, by default the first.

        Raises
        ------
        BadQuestion
            If it is none of them.
        """
        value = self.options.get(name, choices[0])
        if value not in choices:
            raise BadQuestion(f"{name} is none of {', '.join(choices)}")
        return str(value)


def read_question(text: str | bytes, kinds: tuple[str, ...]) -> PageQuestion:
    """Return the question in a message.

    Parameters
    ----------
    text
        The message, in JSON.
    kinds
        The kinds of questions that are answered.

    Returns
    -------
    Question
        The question.

    Raises
    ------
    BadQuestion
        If it is none.

    Examples
    --------
    >>> read_question('{"id": 1, "kind": "cancel"}', ("cancel",)).kind
    'cancel'
    """
    if len(text) > MOST_BYTES:
        raise BadQuestion(f"a message of {len(text)} bytes; {MOST_BYTES} are the most")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadQuestion("the message is not JSON") from error
    if not isinstance(message, dict):
        raise BadQuestion("the message is not a JSON object")
    number, kind = message.pop("id", 0), message.pop("kind", "")
    if isinstance(number, bool) or not isinstance(number, int) or abs(number) > 2**53:
        raise BadQuestion("the id is not a whole number")
    if kind not in kinds:
        raise BadQuestion(f"the kind is none of {', '.join(kinds)}")
    tables = message.pop("study", {})
    if not isinstance(tables, dict):
        raise BadQuestion("the study is not a JSON object")
    return PageQuestion(number, kind, tables, message)


def study_of(tables: Mapping[str, Any]) -> Study:
    """Return the study that a page asks about.

    Parameters
    ----------
    tables
        Those of a study file of kind motion.

    Returns
    -------
    Study
        The study.

    Raises
    ------
    StudyError
        With all faults, each with its path.
    BadQuestion
        If it is larger than the page allows.
    """
    unknown = [name for name in tables if name not in TABLES]
    if unknown:
        raise BadQuestion(f"the study has a table that the page does not know: {unknown[0]!r:.40}")
    for table, rows, most in (
        ("oscillator", "stops", MOST_STOPS),
        ("forcing", "harmonics", MOST_HARMONICS),
    ):
        part = tables.get(table)
        given = part.get(rows) if isinstance(part, dict) else None
        if isinstance(given, list) and len(given) > most:
            raise BadQuestion(f"{len(given)} {rows}; the page takes {most} at most")
    try:
        study = _parsed(tables)
    except (RecursionError, OverflowError) as error:
        raise BadQuestion("the study cannot be read") from error
    periods = motion_of(study).limits.periods
    if periods is not None and as_float(periods) > MOST_PERIODS:
        raise BadQuestion(f"{as_float(periods):g} periods; the page follows {MOST_PERIODS} at most")
    return study


def motion_of(study: Study) -> Motion:
    """Return what a study of the page asks: where a motion starts, and how long it is followed."""
    assert isinstance(study.question, Motion)
    return study.question


def _parsed(tables: Mapping[str, Any]) -> Study:
    faults = StudyFaults("study", {})
    study = build_study(tables, faults)
    if study is None:
        raise StudyError(faults.faults)
    return study


def digits_of(question: PageQuestion) -> int | None:
    """Return to how many digits a motion is to be certified, None if it is not."""
    if question.options.get("digits") is None:
        return None
    return int(question.number("digits", 12, 1, MOST_DIGITS))


def path_of(question: PageQuestion, study: Study) -> str:
    """Return the path of a parameter of the motion or of its start, in its long form."""
    path = question.options.get("path")
    if not isinstance(path, str):
        raise BadQuestion("the path is not a text")
    return long_form(path, study.oscillator, study.forcing, motion_of(study).start)


def range_of(question: PageQuestion, low: str, high: str) -> tuple[float, float]:
    """Return a range, given by two options."""
    ends = (question.number(low, 0.0, -1e6, 1e6), question.number(high, 1.0, -1e6, 1e6))
    if ends[0] >= ends[1]:
        below, above = FIELDS[low], FIELDS[high]
        raise BadQuestion(f"{below} = {ends[0]:.16g} is not below {above} = {ends[1]:.16g}")
    return ends
