"""``[forcing.record]`` of a study file: samples in the study, or in a table beside it."""

from __future__ import annotations

import csv
import math
from pathlib import Path as FilePath
from typing import Any

from percuss.model.faults import draft
from percuss.model.force_record import ForceRecord
from percuss.studies.tables import RawTable, StudyFaults, exact_phase, shown

__all__ = ["record_of"]

PATH = ("forcing", "record")
# Lines of a table whose faults are told.
MOST_TOLD = 10
NO_PLACE = "a study that is no file has no files beside it; give t and f"


def record_of(table: RawTable, folder: FilePath | None, faults: StudyFaults) -> ForceRecord | None:
    """Return the record of a table, not checked by the model; None where it has no samples.

    Parameters
    ----------
    table
        The table ``[forcing.record]``.
    folder
        The folder of the study file, None for a study without one.
    faults
        The faults found so far.
    """
    samples = _samples(table, folder, faults)
    if samples is None:
        return None
    defaults = {"kind": "linear", "repeat": False, "outside": "end", "amplitude": 1, "omega": None}
    given = {name: table.get(name, value) for name, value in defaults.items()}
    return draft(ForceRecord, t=samples[0], f=samples[1], **given)


def _samples(
    table: RawTable, folder: FilePath | None, faults: StudyFaults
) -> tuple[tuple[Any, ...], tuple[Any, ...]] | None:
    if "file" in table:
        for name in ("t", "f"):
            if name in table:
                faults.add((*PATH, name), "given together with file; give one of the two")
        if folder is None:
            faults.add((*PATH, "file"), NO_PLACE, shown(table["file"]))
        elif isinstance(table["file"], str):
            return _columns(folder / table["file"], table, faults)
        return None
    for name in ("t", "f"):
        if name not in table:
            faults.add((*PATH, name), "missing; give t and f, or a file")
    t, f = table.get("t"), table.get("f")
    if not isinstance(t, list) or not isinstance(f, list):
        return None
    return tuple(exact_phase(value) for value in t), tuple(f)


def _columns(
    file: FilePath, table: RawTable, faults: StudyFaults
) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Return the columns of a CSV file that a record names, or add all its faults as one."""
    names = [table.get("time", "t"), table.get("force", "f")]
    try:
        with file.open(encoding="utf-8-sig", newline="") as lines:
            rows = list(csv.reader(lines))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        words = getattr(error, "strerror", None) or "not a table in UTF-8"
        faults.add((*PATH, "file"), words.lower(), shown(str(table["file"])))
        return None
    wrong = []
    found: list[list[float]] = [[], []]
    at: list[int] = []
    for line, row in enumerate(rows, 1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or cells[0].startswith("#"):
            continue
        if not at:
            missing = [name for name in names if name not in cells]
            if missing:
                listed = ", ".join(shown(name) for name in missing)
                wrong.append(f"no column {listed}; its columns are {', '.join(cells)}")
                break
            at = [cells.index(str(name)) for name in names]
            continue
        numbers = [_number(cells[i] if i < len(cells) else "") for i in at]
        for name, i, number, column in zip(names, at, numbers, found, strict=True):
            if not math.isfinite(number):
                cell = cells[i] if i < len(cells) else ""
                wrong.append(f'line {line}: {name} = "{cell}" is no finite number')
            column.append(number)
        before = found[0][-2] if len(found[0]) > 1 else -math.inf
        if numbers[0] <= before:
            order = "is there twice" if numbers[0] == before else f"comes after {before!r}"
            wrong.append(f"line {line}: {names[0]} = {numbers[0]!r} {order}; instants must rise")
    if not wrong and len(found[0]) < 2:
        wrong.append(f"{len(found[0])} samples; a record needs two at least")
    if wrong:
        more = [f"and {len(wrong) - MOST_TOLD} more"] if len(wrong) > MOST_TOLD else []
        reason = "; ".join([*wrong[:MOST_TOLD], *more])
        faults.add((*PATH, "file"), reason, shown(str(table["file"])))
        return None
    return tuple(found[0]), tuple(found[1])


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan
