"""Matrices of structures from files: tables of numbers, NumPy's files and Matrix Market."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from percuss.arrays import Floats

# A matrix as rows, or its diagonal alone.
MatrixOfFile: TypeAlias = "tuple[tuple[float, ...], ...] | tuple[float, ...]"
MARKS = ("#", "%")
# Names of arrays in one file, in lower case.
LETTERS = {"mass": "m", "damping": "c", "stiffness": "k"}
BANNER = "%%MatrixMarket matrix"
# Entries of the largest matrix that is read, as exact numbers of 100 bytes each.
MOST_ENTRIES = 4_000_000


def read_matrix(file: Path, name: str = "") -> MatrixOfFile:
    """Return the matrix in a file, a single row or column of several numbers as a diagonal.

    Parameters
    ----------
    file
        A table of numbers with commas, semicolons or blanks between them (``.csv``, ``.txt``); a
        file of NumPy (``.npy``), or of a sparse matrix of SciPy (``.npz``: csr, csc or coo); or a
        file of Matrix Market (``.mtx``). Lines of tables that begin with # or % are notes.
    name
        What it is, "mass", "damping" or "stiffness": of several arrays in one ``.npz`` the one of
        this name, or M, C or K.

    Returns
    -------
    tuple
        The rows, or the diagonal.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it holds no matrix of real, finite numbers; in one sentence.
    """
    suffix = file.suffix.lower()
    array = np.asarray(_arrays(file, name) if suffix == ".npz" else _READERS[suffix](file))
    if array.dtype.kind not in "biuf":
        raise ValueError(f"holds no real numbers, but values of type {array.dtype}")
    if array.ndim not in (1, 2) or array.size == 0:
        raise ValueError(f"no matrix: it is of shape {array.shape}")
    if array.size > MOST_ENTRIES:
        rows, columns = array.shape[0], array.shape[-1]
        raise ValueError(
            f"{rows:,} x {columns:,} entries; a structure has dense matrices: reduce it to its"
            " lowest modes first"
        )
    values = array.astype(np.float64)
    if not np.isfinite(values).all():
        place = tuple(int(i[0]) for i in np.nonzero(~np.isfinite(values)))
        raise ValueError(f"entry {'.'.join(map(str, place))} is {values[place]}, not finite")
    if values.ndim == 2 and values.shape[0] != values.shape[1] and 1 in values.shape:
        values = values.ravel()
    if values.ndim == 1:
        return tuple(values.tolist())
    return tuple(tuple(row) for row in values.tolist())


def _table(file: Path) -> Floats:
    rows: list[list[float]] = []
    for number, line in enumerate(_text(file).splitlines(), 1):
        if not line.strip() or line.lstrip().startswith(MARKS):
            continue
        # Between semicolons a comma is that of a decimal, as spreadsheets of some countries write.
        has_decimal_commas = sum(bool(cell.strip()) for cell in line.split(";")) > 1
        sign = ";" if has_decimal_commas else next((sign for sign in ",;" if sign in line), None)
        cells = [cell.strip() for cell in line.split(sign)]
        if has_decimal_commas:
            cells = [cell.replace(",", ".") for cell in cells]
        # A separator at the end of a line begins no column.
        cells = cells[:-1] if sign is not None and not cells[-1] else cells
        rows.append([_number(cell, number) for cell in cells])
        if len(rows[-1]) != len(rows[0]):
            counts = f"{len(rows[-1])} numbers, but {len(rows[0])} in the first row"
            raise ValueError(f"line {number}: {counts}")
    if not rows:
        raise ValueError("it holds no numbers")
    return np.array(rows)


def _number(cell: str, line: int) -> float:
    try:
        return float(cell)
    except ValueError:
        raise ValueError(f'line {line}: "{cell[:30]}" is no number') from None


def _text(file: Path) -> str:
    try:
        return file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("not a text in UTF-8") from None


def _array_file(file: Path) -> Any:
    try:
        return np.load(file, allow_pickle=False)
    except (ValueError, EOFError):
        raise ValueError("not a file of NumPy with an array of numbers") from None


def _arrays(file: Path, name: str) -> Floats:
    try:
        with np.load(file, allow_pickle=False) as parts:
            parts_by_name = {name: parts[name] for name in parts.files}
    except (ValueError, EOFError, zipfile.BadZipFile):
        raise ValueError("not a file of NumPy with arrays of numbers") from None
    if "format" not in parts_by_name:
        own = [key for key in parts_by_name if key.lower() in (name, LETTERS.get(name))]
        wanted = own if len(parts_by_name) > 1 else list(parts_by_name)
        if len(wanted) != 1:
            names = ", ".join(parts_by_name) or "none"
            which = f", or one named {LETTERS[name].upper()} or {name}," if name in LETTERS else ""
            raise ValueError(
                f"one array{which} is wanted, the file has {len(parts_by_name)}: {names}"
            )
        return np.asarray(parts_by_name[wanted[0]])
    layout = parts_by_name["format"].item()
    layout = layout.decode() if isinstance(layout, bytes) else str(layout)
    try:
        if layout == "coo":
            return _filled(
                parts_by_name["shape"],
                parts_by_name["row"],
                parts_by_name["col"],
                parts_by_name["data"],
            )
        if layout in ("csr", "csc"):
            outer = np.repeat(
                np.arange(len(parts_by_name["indptr"]) - 1), np.diff(parts_by_name["indptr"])
            )
            pair = (outer, parts_by_name["indices"])
            row, column = pair if layout == "csr" else pair[::-1]
            return _filled(parts_by_name["shape"], row, column, parts_by_name["data"])
    except (KeyError, IndexError):
        raise ValueError(f"a damaged sparse matrix of format {layout}") from None
    raise ValueError(f"a sparse matrix of format {layout}; csr, csc and coo are read")


def _filled(shape: Any, row: Any, column: Any, data: Any) -> Floats:
    """Return the dense matrix of entries; those of one place are added."""
    size = tuple(int(n) for n in shape)
    if math.prod(size) > MOST_ENTRIES:
        # The caller says so, without the memory for it.
        return np.broadcast_to(np.zeros(1), size)
    matrix = np.zeros(size)
    np.add.at(matrix, (np.asarray(row), np.asarray(column)), data)
    return matrix


def _matrix_market(file: Path) -> Floats:
    lines = _text(file).splitlines()
    words = lines[0].lower().split() if lines else []
    if len(words) != 5 or " ".join(words[:2]) != BANNER.lower():
        raise ValueError(f'its first line does not begin with "{BANNER}"')
    layout, field, symmetry = words[2:]
    kinds = (("coordinate", "array"), ("real", "integer", "pattern"),
             ("general", "symmetric", "skew-symmetric"))  # fmt: skip
    for word, known in zip((layout, field, symmetry), kinds, strict=True):
        if word not in known:
            raise ValueError(f'line 1: "{word}"; {", ".join(known[:-1])} and {known[-1]} are read')
    numbered = [
        (number, [_number(cell, number) for cell in line.split()])
        for number, line in enumerate(lines[1:], 2)
        if line.strip() and not line.startswith("%")
    ]
    width = 3 if layout == "coordinate" else 2
    if not numbered or len(numbered[0][1]) != width:
        raise ValueError(f"its line of sizes is missing; it has {width} numbers")
    size = (int(numbered[0][1][0]), int(numbered[0][1][1]))
    rows = numbered[1:]
    if layout == "coordinate":
        row, column, data = _entries(rows, size, is_pattern=field == "pattern")
        count = int(numbered[0][1][2])
    else:
        data = np.array([number for _, line in rows for number in line])
        row, column = _places(size, symmetry)
        count = len(row)
    if len(data) != count:
        raise ValueError(f"{len(data)} entries, but it says that there are {count}")
    matrix = _filled(size, row, column, data)
    if symmetry != "general" and math.prod(size) <= MOST_ENTRIES:
        other = row != column
        sign = 1.0 if symmetry == "symmetric" else -1.0
        np.add.at(matrix, (column[other], row[other]), sign * data[other])
    return matrix


def _entries(
    rows: list[tuple[int, list[float]]], size: tuple[int, int], *, is_pattern: bool
) -> tuple[Any, Any, Floats]:
    width = 2 if is_pattern else 3
    for number, line in rows:
        if len(line) != width:
            raise ValueError(f"line {number}: {len(line)} numbers, where {width} are needed")
        if not (1 <= line[0] <= size[0] and 1 <= line[1] <= size[1]):
            place = f"{line[0]:g}, {line[1]:g}"
            raise ValueError(f"line {number}: no place ({place}) in {size[0]} x {size[1]}")
    table = np.array([line for _, line in rows]).reshape(len(rows), width)
    places = table[:, :2].astype(np.int64) - 1
    data = np.ones(len(rows)) if is_pattern else table[:, 2]
    return places[:, 0], places[:, 1], data


def _places(size: tuple[int, int], symmetry: str) -> tuple[Any, Any]:
    """Return rows and columns of a dense file's entries: column by column, the lower part."""
    column, row = (part.ravel() for part in np.indices(size[::-1]))
    lower = {"general": row >= 0, "symmetric": row >= column, "skew-symmetric": row > column}
    return row[lower[symmetry]], column[lower[symmetry]]


# How a matrix is read, by the end of its file's name; of an .npz `_arrays` finds it.
_READERS: dict[str, Callable[[Path], Any]] = {
    ".csv": _table,
    ".txt": _table,
    ".npy": _array_file,
    ".mtx": _matrix_market,
}
