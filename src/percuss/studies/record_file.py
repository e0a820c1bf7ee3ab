"""``[forcing.record]`` of a study file: samples in the study, or in a table beside it."""

from __future__ import annotations

import csv
import io
import math
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, TypeAlias

from percuss.model.faults import draft
from percuss.model.force_record import ForceRecord
from percuss.model.units import Units
from percuss.studies.tables import Path, RawTable, StudyFaults, exact_phase, shown

__all__ = ["columns_of", "record_of"]

Samples: TypeAlias = tuple[tuple[Any, ...], tuple[Any, ...]]

PATH: Path = ("forcing", "record")
SEPARATORS = (",", ";", "\t")
# Lines of a table whose faults are told.
MOST_TOLD = 10
NO_PLACE = "a study that is no file has no files beside it; give t and f"


def record_of(
    table: RawTable,
    folder: FilePath | None,
    faults: StudyFaults,
    path: Path = PATH,
    *,
    units: Units | None = None,
    is_per_mass: bool = False,
) -> ForceRecord | None:
    """Return the record of a table, not checked by the model; None where it has no samples.

    Parameters
    ----------
    table
        The table ``[forcing.record]``.
    folder
        The folder of the study file, None for a study without one.
    faults
        The faults found so far.
    path
        Where the table stands.
    units
        Those of the model, which units in the heads of columns have to fit.
    is_per_mass
        Whether the force is an acceleration of a model with a mass.
    """
    samples = _samples(table, folder, faults, path)
    if samples is not None and "file" in table:
        _check_units(table, faults, path, units, is_per_mass)
    if samples is None:
        return None
    defaults = {"kind": "linear", "repeat": False, "outside": "end", "amplitude": 1, "omega": None}
    given = {name: table.get(name, value) for name, value in defaults.items()}
    return draft(ForceRecord, t=samples[0], f=samples[1], **given)


def _samples(
    table: RawTable, folder: FilePath | None, faults: StudyFaults, path: Path
) -> Samples | None:
    if "file" in table:
        for name in ("t", "f"):
            if name in table:
                faults.add((*path, name), "given together with file; give one of the two")
        if folder is None:
            faults.add((*path, "file"), NO_PLACE, shown(table["file"]))
        elif isinstance(table["file"], str):
            return _columns(folder / table["file"], table, faults, path)
        return None
    for name in ("t", "f"):
        if name not in table:
            faults.add((*path, name), "missing; give t and f, or a file")
    t, f = table.get("t"), table.get("f")
    if not isinstance(t, list) or not isinstance(f, list):
        return None
    return tuple(exact_phase(value) for value in t), tuple(f)


def _columns(file: FilePath, table: RawTable, faults: StudyFaults, path: Path) -> Samples | None:
    """Return the columns of a CSV file that a record names, or add all its faults as one."""
    names = table.get("time", "t"), table.get("force", "f")
    try:
        # Few studies need it.
        from percuss.fitting.data_file import text_of_file

        return columns_of(text_of_file(file), *map(str, names))
    except OSError as error:
        words = error.strerror or "not readable"
        faults.add((*path, "file"), words.lower(), shown(str(table["file"])))
    except ValueError as error:
        faults.add((*path, "file"), str(error), shown(str(table["file"])))
    return None


def _check_units(
    table: RawTable, faults: StudyFaults, path: Path, units: Units | None, is_per_mass: bool
) -> None:
    """Add the faults of units in the names of columns: no number of a record is converted."""
    force = "stop_force"
    if units is not None:
        force = "force" if units.mass and not is_per_mass else "acceleration"
    for key, quantity, factor in (("time", "t", "omega"), ("force", force, "amplitude")):
        title = str(table.get(key, ""))
        # Of phases, and of a force with a factor of its own, the size is the caller's.
        given = None if factor in table else units
        if not title.endswith((")", "]")):
            continue
        # Few files need it.
        from percuss.fitting.data_file import misfit_of_unit

        misfit = misfit_of_unit(title, quantity, given)
        if misfit and " is no unit of " in misfit and units is not None and units.mass:
            hint = "with per_mass = true it is an acceleration, without it a force"
            misfit = f"{misfit}; {hint}" if key == "force" else misfit
        if misfit:
            faults.add((*path, key), misfit, shown(title))


def columns_of(text: str, time: str = "t", force: str = "f") -> Samples:
    r"""Return instants and forces of a record in a table of separated values.

    Parameters
    ----------
    text
        The table: a line of names, then a line for each sample. Lines that begin with #, and those
        above the names, are notes. Commas separate the columns, or semicolons or tabs, with decimal commas as well.
    time, force
        Names of the columns.

    Returns
    -------
    tuple
        Instants and forces.

    Raises
    ------
    ValueError
        With all faults, in a sentence each with its line.

    Examples
    --------
    >>> columns_of("t;f\n0;1,5\n1;2.5\n")
    ((0.0, 1.0), (1.5, 2.5))
    """
    separator, numbered = _rows(text, {time, force})
    head = numbered[0][1] if numbered else []
    if time not in head or force not in head:
        raise ValueError(_no_columns([name for name in (time, force) if name not in head], head))
    at = [head.index(time), head.index(force)]
    wrong = []
    columns: list[list[float]] = [[], []]
    for line, row in numbered[1:]:
        cells = [row[i] if i < len(row) else "" for i in at]
        numbers = [_number(cell if separator == "," else cell.replace(",", ".")) for cell in cells]
        for name, cell, number, column in zip((time, force), cells, numbers, columns, strict=True):
            if not math.isfinite(number):
                wrong.append(f'line {line}: {name} = "{cell}" is no finite number')
            column.append(number)
        before = columns[0][-2] if len(columns[0]) > 1 else -math.inf
        if numbers[0] <= before:
            order = "is there twice" if numbers[0] == before else f"comes after {before!r}"
            wrong.append(f"line {line}: {time} = {numbers[0]!r} {order}; instants must rise")
    if not wrong and len(columns[0]) < 2:
        count = "1 sample" if columns[0] else "no samples"
        wrong.append(f"{count}; a record needs two at least")
    if len(columns[0]) > 1 and all(after < before for before, after in pairwise(columns[0])):
        wrong = ["the samples are in reverse order, the last one first; turn the lines round"]
    if wrong:
        more = [f"and {len(wrong) - MOST_TOLD} more"] if len(wrong) > MOST_TOLD else []
        raise ValueError("; ".join([*wrong[:MOST_TOLD], *more]))
    return tuple(columns[0]), tuple(columns[1])


def _rows(text: str, names: set[str]) -> tuple[str, list[tuple[int, list[str]]]]:
    """Return what separates the columns of a table, and its rows with the numbers of their lines."""
    found: list[tuple[int, str, list[tuple[int, list[str]]]]] = []
    for separator in SEPARATORS:
        try:
            read = list(csv.reader(io.StringIO(text), delimiter=separator))
        except csv.Error as error:
            raise ValueError(f"not a table of separated values: {error}") from error
        rows = [
            (line, [cell.strip() for cell in row])
            for line, row in enumerate(read, 1)
            if any(cell.strip() for cell in row) and not row[0].strip().startswith("#")
        ]
        # What stands above the names are notes of the instrument.
        head = next((i for i, (_, row) in enumerate(rows) if names.issubset(row)), 0)
        rows = rows[head:]
        found.append((len(names.intersection(rows[0][1])) if rows else 0, separator, rows))
    # Of equal ones the first.
    _, separator, rows = max(found, key=lambda one: one[0])
    return separator, rows


def _no_columns(missing: list[str], head: list[str]) -> str:
    """Return the sentence about a table that lacks columns, and why that may be."""
    listed = ", ".join(shown(name) for name in missing)
    if not head:
        return f"no column {listed}; it is empty"
    for sign in SEPARATORS[1:]:
        head = [name.strip() for cell in head for name in cell.split(sign)]
    if all(math.isfinite(_number(cell)) for cell in head):
        return f"no column {listed}: its first line holds numbers; write the names above them"
    return f"no column {listed}; its columns are {', '.join(head)}"


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan
