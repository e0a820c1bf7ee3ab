"""Tables of results as CSV files, each with its record in a second file."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from percuss.errors import OutputError, ParameterError
from percuss.io.column_units import Columns, units_of_columns
from percuss.io.files import OutputFiles, record_file, say_size
from percuss.io.record import Record, make_record
from percuss.io.results import kind_of, table_of
from percuss.model.exact import whole

# Rows converted to text at a time: one by one is slow, all at once takes much memory.
ROWS = 20_000
# Rows from which the size of a file is estimated.
SAMPLED_ROWS = 100


def save_csv(
    result: Any,
    path: Path | str,
    *,
    table: str | None = None,
    samples: int | None = None,
    decimal_comma: bool = False,
    study: str | None = None,
    command: str | None = None,
    force: bool = False,
) -> None:
    """Save a table of a result as CSV, as spreadsheets and pandas read it, and its record.

    The record is a second file, ``impacts.csv.toml`` for ``impacts.csv``: a study that repeats the
    result, where there is one.

    Parameters
    ----------
    result
        A run, an orbit, a list of orbits, a branch, a curve, a response, a design, a front, a fit
        or the dataset of an ensemble.
    path
        The file, with the suffix ``.csv``.
    table
        Which table: "impacts", "crossings" or "motion" (x, v and the forces of stops at
        equally spaced times) of a run;
        "impacts", "orbit" or "motion" of an orbit;
        "branch" or "special_points" of a branch; "searches" or "best" of a design;
        "parameters", "covariance", "residuals", "impacts" or "profiles" of a fit. Default: the
        first, or the only one.
    samples
        Number of times of a motion, at least 2; default 2001.
    decimal_comma
        Whether numbers have commas, and semicolons separate the columns, as spreadsheets of some
        countries read them.
    study, command
        As in `percuss.io.make_record`.
    force
        Whether files of these names may be replaced.

    Raises
    ------
    OutputError
        If the suffix is another one, a file exists and `force` is false, or cannot be written.
    ParameterError
        If it is no result of percuss, has no such table, or the number of samples is none.
    """
    check_suffix(path, ".csv")
    tables = kind_of(result).columns
    name = next(iter(tables)) if table is None else table
    if name not in tables:
        raise ParameterError("table", table, f"none of {', '.join(tables)}")
    if samples is not None:
        samples = whole("samples", samples, 2)
    record = make_record(result, study=study, command=command)
    record_path = record_file(path)
    with OutputFiles(path, record_path, force=force) as files:
        columns = table_of(result, name, samples)
        units = units_of_columns(result, columns)
        write_columns(
            columns,
            files[path],
            record,
            units=units,
            decimal_comma=decimal_comma,
            record_path=files[record_path],
        )


def write_columns(
    columns: Columns,
    path: Path,
    record: Record,
    *,
    units: Mapping[str, str] = MappingProxyType({}),
    has_header_units: bool = True,
    decimal_comma: bool = False,
    record_path: Path | None = None,
) -> None:
    """Write columns into the file `path`, and the record into the file `record_path`.

    The record names the unit of each column that has one, as ``t [s]``, and so may the header.
    """
    say_size(path, _size(columns))
    names = [f"{name} [{units[name]}]" if name in units else name for name in columns]
    text = record.text(columns=", ".join(names)) if units else record.text()
    (record_file(path) if record_path is None else record_path).write_text(text, encoding="utf-8")
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, delimiter=";" if decimal_comma else ",", lineterminator="\n")
        rows.writerow(names if has_header_units else columns)
        for block in _blocks(columns):
            rows.writerows(map(_with_commas, block) if decimal_comma else block)


def _with_commas(row: Iterable[Any]) -> list[Any]:
    """Return a row whose numbers have decimal commas."""
    return [str(cell).replace(".", ",") if isinstance(cell, float) else cell for cell in row]


def check_suffix(path: Path | str, suffix: str) -> None:
    """Raise an OutputError unless a file has the suffix of its format."""
    if Path(path).suffix.lower() != suffix:
        name = f"{Path(path).stem.rstrip('.') or 'result'}{suffix}"
        reason = f"not {suffix}, which is what is written; call it {name}"
        raise OutputError(str(path), reason)


def _size(columns: Columns) -> int:
    """Return an estimate of the size of a table in bytes, from some of its rows."""
    count = min(len(column) for column in columns.values()) if columns else 0
    step = max(1, count // SAMPLED_ROWS)
    some = [np.asarray(column)[:count:step].tolist() for column in columns.values()]
    lengths = [sum(len(str(value)) + 1 for value in row) for row in zip(*some, strict=True)]
    return sum(lengths) * count // max(1, len(lengths))


def _blocks(columns: Columns) -> Iterator[Iterator[tuple[Any, ...]]]:
    """Yield the rows in blocks."""
    arrays: list[NDArray[Any]] = [np.asarray(column) for column in columns.values()]
    count = len(arrays[0])
    for first in range(0, count, ROWS):
        # The text of a float is the shortest that reads back to the same bits.
        block = [array[first : first + ROWS].tolist() for array in arrays]
        yield zip(*block, strict=True)
