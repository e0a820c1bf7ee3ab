"""A request of a client: the tables of a study, checked; and the state of its answer."""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from percuss.errors import StudyError
from percuss.model.exact import as_float
from percuss.model.paths import long_form
from percuss.studies.kinds.motion import Motion
from percuss.studies.reading import build_study
from percuss.studies.study import Study
from percuss.studies.tables import StudyFaults
from percuss.web.scheduler import Task

# Limits of a message, of stops and harmonics, of forcing periods: far above what a hand sets.
MOST_BYTES = 65_536
# Of a message with a file, and which these are.
MOST_RECORD_BYTES, WITH_RECORDS = 1_000_000, ("measured", "fit", "record", "study_file")
MOST_STOPS, MOST_HARMONICS = 16, 64
MOST_PERIODS = 20_000
# Parameters that may be free at once.
MOST_FREE = 12
# Digits that the page certifies a motion to.
MOST_DIGITS = 100
# What the fields of options are called on the page.
FIELDS = {
    "low": "from",
    "high": "to",
    "low2": "and from",
    "high2": "and to",
    "size": "cells along a side",
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
TABLES = ("parameters", "oscillator", "forcing", "start", "run")


class BadRequest(Exception):  # noqa: N818 - no error of the program, but of the request
    """A request that cannot be answered; its text is a sentence for the client."""


@dataclass(frozen=True, slots=True)
class PageRequest:
    """A message of a client.

    Parameters
    ----------
    id
        Number that the client gave it; the answer carries it back.
    kind
        Kind of answer: "explore", "facts", "diagram", ...
    tables
        Tables of the study.
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
        BadRequest
            If it is none.
        """
        value = self.options.get(name, default)
        label = FIELDS.get(name, name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise BadRequest(f"{label} is not a number")
        if not low <= value <= high:
            # A whole number may have more digits than a float can hold.
            shown = f"{value:g}" if isinstance(value, float) else f"{value}"[:20]
            raise BadRequest(f"{label} = {shown} is not between {low:g} and {high:g}")
        return float(value)

    def choice(self, name: str, choices: tuple[str, ...]) -> str:
        """Return an option that is one of several words, by default the first.

        Raises
        ------
        BadRequest
            If it is none of them.
        """
        value = self.options.get(name, choices[0])
        if value not in choices:
            raise BadRequest(f"{name} is none of {', '.join(choices)}")
        return str(value)

    def free_parameters(self, without: str, does: str) -> dict[str, Any]:
        """Return what is given of the free parameters; on the page each is a row of its table.

        Raises
        ------
        BadRequest
            If there is none, which is told in these words, or more than the page takes.
        """
        free = self.options.get("free")
        if not isinstance(free, Mapping) or not free:
            raise BadRequest(without)
        if len(free) > MOST_FREE:
            reason = f"{len(free)} free parameters; the page {does} {MOST_FREE} at most"
            raise BadRequest(reason)
        return {str(path).removeprefix("parameters."): given for path, given in free.items()}


@dataclass(slots=True)
class RunningRequest:
    """The state of an answer that is being computed.

    Attributes
    ----------
    is_cancelled
        Whether the client does not wait for the answer any more.
    share
        Part of the answer that is done, from 0 to 1.
    """

    is_cancelled: bool = False
    share: float = 0.0
    _task: Task | None = None
    _spent: float = 0.0
    _began: float = field(default_factory=time.monotonic)

    def progress(self, begin: float, end: float, seconds: float = math.inf) -> PartialProgress:
        """Return the progress of a call that takes the share from `begin` to `end`.

        The call is ended after so much computing time [s], too.
        """
        return PartialProgress(self, begin, end, self.seconds() + seconds)

    def seconds(self) -> float:
        """Return the computing time so far, without waits for other requests [s]."""
        if self._task is not None:
            return self._spent + self._task.seconds()
        return self._spent or time.monotonic() - self._began

    def checkpoint(self) -> bool:
        """Let other requests run once a slice is used up; return whether the answer is wanted."""
        if self._task is not None and not self._task.checkpoint():
            self.is_cancelled = True
        return not self.is_cancelled

    @contextmanager
    def in_task(self, task: Task) -> Iterator[None]:
        """Compute within a task of a scheduler."""
        self._task = task
        try:
            yield
        finally:
            self._task = None
            self._spent += task.seconds()


@dataclass(frozen=True, slots=True)
class PartialProgress:
    """The progress of one of several calls: ``progress=`` of a long call."""

    running: RunningRequest
    begin: float
    end: float
    until: float = math.inf

    def __call__(self, done: float, total: float) -> bool:
        """Note how far the call is, and return whether to go on."""
        share = done / total if total else 1.0
        self.running.share = self.begin + (self.end - self.begin) * share
        return self.running.checkpoint() and self.running.seconds() < self.until


def read_request(text: str | bytes, kinds: tuple[str, ...]) -> PageRequest:
    """Return the request in a message in JSON, if it is of one of some kinds.

    Raises
    ------
    BadRequest
        If the message is none.

    Examples
    --------
    >>> read_request('{"id": 1, "kind": "cancel"}', ("cancel",)).kind
    'cancel'
    """
    if len(text) > MOST_RECORD_BYTES:
        raise BadRequest(f"a message of {len(text)} bytes; {MOST_RECORD_BYTES} are the most")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadRequest("the message is not JSON") from error
    if not isinstance(message, dict):
        raise BadRequest("the message is not a JSON object")
    number, kind = message.pop("id", 0), message.pop("kind", "")
    if isinstance(number, bool) or not isinstance(number, int) or abs(number) > 2**53:
        raise BadRequest("the id is not a whole number")
    if kind not in kinds:
        raise BadRequest(f"the kind is none of {', '.join(kinds)}")
    if len(text) > MOST_BYTES and kind not in WITH_RECORDS:
        raise BadRequest(f"a message of {len(text)} bytes; {MOST_BYTES} are the most")
    tables = message.pop("study", {})
    if not isinstance(tables, dict):
        raise BadRequest("the study is not a JSON object")
    return PageRequest(number, kind, tables, message)


def study_of(tables: Mapping[str, Any]) -> Study:
    """Return the study of a motion in the tables of a page.

    Raises
    ------
    StudyError
        With all faults, each with its path.
    BadRequest
        If it is larger than the page allows.
    """
    unknown = [name for name in tables if name not in TABLES]
    if unknown:
        raise BadRequest(f"the study has a table that the page does not know: {unknown[0]!r:.40}")
    limits = (("oscillator", "stops", MOST_STOPS), ("forcing", "harmonics", MOST_HARMONICS))
    for name, rows, most in limits:
        table = tables.get(name)
        given = table.get(rows) if isinstance(table, dict) else None
        if isinstance(given, list) and len(given) > most:
            raise BadRequest(f"{len(given)} {rows}; the page takes {most} at most")
    try:
        study = checked_study(tables)
    except (RecursionError, OverflowError) as error:
        raise BadRequest("the study cannot be read") from error
    periods = motion_of(study).limits.periods
    if periods is not None and as_float(periods) > MOST_PERIODS:
        raise BadRequest(f"{as_float(periods):g} periods; the page follows {MOST_PERIODS} at most")
    return study


def motion_of(study: Study) -> Motion:
    """Return the question of the study of a motion: its start, and how long it is followed."""
    assert isinstance(study.question, Motion)
    return study.question


def checked_study(tables: Mapping[str, Any]) -> Study:
    """Return the study in some tables, or raise all its faults as a `StudyError`."""
    faults = StudyFaults("study", {})
    study = build_study(_without_unused(tables), faults)
    if study is None:
        raise StudyError(faults.faults)
    return study


def _without_unused(tables: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return tables without parameters that nothing uses: a slider may have replaced the last."""
    parameters = tables.get("parameters")
    if not isinstance(parameters, Mapping):
        return tables
    rest = {name: table for name, table in tables.items() if name != "parameters"}
    words = set(re.findall(r"\w+", json.dumps(rest, default=str)))
    used = {name: value for name, value in parameters.items() if name in words}
    return {"parameters": used, **rest} if used else rest


def digits_of(request: PageRequest) -> int | None:
    """Return to how many digits a motion is to be certified, None if it is not."""
    if request.options.get("digits") is None:
        return None
    return int(request.number("digits", 12, 1, MOST_DIGITS))


def path_of(request: PageRequest, study: Study, name: str = "path") -> str:
    """Return the path of a parameter of the motion or of its start, in its long form."""
    path = request.options.get(name)
    if not isinstance(path, str):
        raise BadRequest("the path is not a text")
    # On the page a parameter is a row of its table.
    path = path.removeprefix("parameters.")
    return long_form(path, study.oscillator, study.forcing, motion_of(study).start)


def range_of(request: PageRequest, low: str, high: str) -> tuple[float, float]:
    """Return a range, given by two options."""
    ends = (request.number(low, 0.0, -1e6, 1e6), request.number(high, 1.0, -1e6, 1e6))
    if ends[0] >= ends[1]:
        below, above = FIELDS[low], FIELDS[high]
        raise BadRequest(f"{below} = {ends[0]:.16g} is not below {above} = {ends[1]:.16g}")
    return ends
