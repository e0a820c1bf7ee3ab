"""The record in every file of results, from which its run can be repeated."""

from __future__ import annotations

import platform
import struct
import tomllib
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from percuss.errors import check_installed
from percuss.io.files import record_file
from percuss.io.results import kind_of
from percuss.io.study_text import toml_string
from percuss.version import __version__

_PACKAGES = ("numpy", "numba")


@dataclass(frozen=True, slots=True)
class Record:
    """The study of a file, and how and when it was made.

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
            Further entries about the file.

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
        Its study as TOML text; default: one written from the result itself, where there is one.
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


# The keys under which the metadata of pictures and NetCDF files hold the record.
PNG_KEYWORD = "percuss"
DUBLIN_CORE = "{http://purl.org/dc/elements/1.1/}"
NETCDF_ATTRIBUTE = "record"


def load_record(path: Path | str) -> Record:
    """Return the record of a NetCDF, CSV, PNG or SVG file written by percuss.

    The record of a CSV file is a second file; older versions wrote it at the beginning.

    Parameters
    ----------
    path
        The file; its suffix is the format.

    Returns
    -------
    Record
        The study, the command, the versions, the date and the outcome.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file holds no record, in one sentence.
    """
    file = Path(path)
    read = _READERS.get(file.suffix.lower())
    if read is None:
        known = ", ".join(sorted(_READERS))
        raise ValueError(f"{file}: not a result file; percuss writes {known}")
    if not file.exists():
        raise FileNotFoundError(f"{file}: no such file")
    try:
        return parse_record(read(file))
    except (ValueError, KeyError, OSError, struct.error, ElementTree.ParseError) as error:
        raise ValueError(f"{file}: holds no record of percuss") from error


def _from_netcdf(path: Path) -> str:
    check_installed("a NetCDF file", "netcdf", "h5netcdf", "h5py")
    import h5netcdf  # slow, and most files are of other formats

    with h5netcdf.File(path, "r") as file:
        return str(file.attrs[NETCDF_ATTRIBUTE])


def _from_csv(path: Path) -> str:
    record_path = record_file(path)
    if record_path.exists():
        return record_path.read_text(encoding="utf-8")
    lines = []
    with path.open(encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#"):
                break
            lines.append(line.rstrip("\n").removeprefix("#").removeprefix(" "))
    return "\n".join(lines) + "\n"


def _from_png(path: Path) -> str:
    data = path.read_bytes()
    position = 8
    while position + 8 <= len(data):
        length, kind = struct.unpack(">I4s", data[position : position + 8])
        body = data[position + 8 : position + 8 + length]
        keyword, _, rest = body.partition(b"\0")
        if keyword == PNG_KEYWORD.encode():
            if kind == b"tEXt":
                return rest.decode("latin-1")
            if kind == b"iTXt":
                text = rest[2:].split(b"\0", 2)[2]
                return (zlib.decompress(text) if rest[0] else text).decode()
        position += length + 12
    raise KeyError(PNG_KEYWORD)


def _from_svg(path: Path) -> str:
    for _, element in ElementTree.iterparse(path):
        if element.tag == f"{DUBLIN_CORE}description":
            return element.text or ""
    raise KeyError("description")


_READERS: dict[str, Callable[[Path], str]] = {
    ".nc": _from_netcdf,
    ".csv": _from_csv,
    ".png": _from_png,
    ".svg": _from_svg,
    ".toml": lambda path: path.read_text(encoding="utf-8"),
}
