"""What every file says about itself, so that its run can be repeated."""

from __future__ import annotations

import platform
import tomllib
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

from percuss.io.results import kind_of
from percuss.io.toml import toml_string
from percuss.version import __version__

_PACKAGES = ("numpy", "numba")


@dataclass(frozen=True, slots=True)
class Record:
    """The study a file came from, and how and when it was made.

    Parameters
    ----------
    study
        The study as TOML text; `percuss.studies.parse_study` reads it.
    command
        The command or call that made the file, empty if unknown.
    date
        Date and time, ISO 8601, UTC.
    outcome
        Why the run stopped, as shown to the user.
    versions
        Pairs of a package (or ``python``) and its version.
    """

    study: str
    command: str
    date: str
    outcome: str
    versions: tuple[tuple[str, str], ...]

    def text(self, **more: str) -> str:
        """Return the record as a TOML text that is itself a study file.

        Parameters
        ----------
        **more
            What else to tell about the file.

        Returns
        -------
        str
            A ``[record]`` table, which a study ignores, and the study.
        """
        facts = {
            "command": self.command,
            "date": self.date,
            "outcome": self.outcome,
            **{f"{package}_version": version for package, version in self.versions},
            **more,
        }
        lines = [f"{key} = {toml_string(value)}" for key, value in facts.items()]
        return "\n".join(["[record]", *lines, "", self.study])


def make_record(result: Any, *, study: str | None = None, command: str | None = None) -> Record:
    """Return the record of a result that has just been made.

    Parameters
    ----------
    result
        A run, an orbit, a branch or anything else that can be saved.
    study
        Its study as TOML text; default: one written from the result itself, where it tells it.
    command
        The command or call that made it.

    Returns
    -------
    Record
        The record, dated now.

    Raises
    ------
    ParameterError
        If it is no result of percuss.
    """
    kind = kind_of(result)
    versions = [(package, metadata.version(package)) for package in _PACKAGES]
    return Record(
        study=kind.study(result) if study is None else study,
        command=command or "",
        date=datetime.now(UTC).isoformat(timespec="seconds"),
        outcome=kind.outcome(result),
        versions=(("percuss", __version__), ("python", platform.python_version()), *versions),
    )


def parse_record(text: str) -> Record:
    """Return the record that `Record.text` wrote.

    Parameters
    ----------
    text
        The text found in a file.

    Returns
    -------
    Record
        The record.

    Raises
    ------
    ValueError
        If the text is not a record.
    """
    try:
        facts = tomllib.loads(text)["record"]
        head, gap, study = text.partition("\n\n")
        versions = tuple(
            (key.removesuffix("_version"), str(value))
            for key, value in facts.items()
            if key.endswith("_version")
        )
        record = Record(study, facts["command"], facts["date"], facts["outcome"], versions)
    except (tomllib.TOMLDecodeError, KeyError, AttributeError) as error:
        raise ValueError("no record of percuss") from error
    if not gap or not head.startswith("[record]"):
        raise ValueError("no record of percuss at its beginning")
    return record
