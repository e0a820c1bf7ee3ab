"""The record back from any file that percuss wrote."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from percuss.io.record import Record, parse_record

# The words under which a picture's metadata hold the record.
PNG_KEYWORD = "percuss"
DUBLIN_CORE = "{http://purl.org/dc/elements/1.1/}"
NETCDF_ATTRIBUTE = "record"


def load_record(path: Path | str) -> Record:
    """Return the record of a NetCDF, CSV, PNG or SVG file written by percuss.

    That of a CSV file lies beside it; in those of older versions it stands at the beginning.

    Parameters
    ----------
    path
        The file; its suffix tells the format.

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
    import h5netcdf  # slow, and most readings are of other files

    with h5netcdf.File(path, "r") as file:
        return str(file.attrs[NETCDF_ATTRIBUTE])


def record_file(path: Path | str) -> Path:
    """Return the file beside a CSV file that holds its record.

    Examples
    --------
    >>> record_file("impacts.csv").name
    'impacts.csv.toml'
    """
    return Path(path).with_name(f"{Path(path).name}.toml")


def _from_csv(path: Path) -> str:
    beside = record_file(path)
    if beside.exists():
        return beside.read_text(encoding="utf-8")
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
