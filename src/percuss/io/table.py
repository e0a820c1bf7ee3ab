"""Impacts and crossings as CSV tables that begin with the record of their run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal, TypeAlias

from percuss.io.files import OutputFiles
from percuss.io.record import Record, make_record
from percuss.motion.trajectory import Trajectory

TableName: TypeAlias = Literal["impacts", "crossings"]

# The columns of each table, and what they are measured in.
COLUMNS: dict[TableName, dict[str, str]] = {
    "impacts": {
        "t": "time",
        "v_before": "velocity",
        "v_after": "velocity",
        "stop": "",
        "cycle": "",
        "impulse": "velocity",
    },
    "crossings": {"t": "time", "v": "velocity", "stop": "", "direction": ""},
}
# Rows turned into text at a time: fewer calls than one a row, less memory than all.
ROWS = 20_000


def save_csv(
    run: Trajectory,
    path: Path | str,
    *,
    table: TableName = "impacts",
    study: str | None = None,
    command: str | None = None,
    force: bool = False,
) -> None:
    """Save the impacts of a run as CSV; lines that begin with ``#`` hold the record.

    Parameters
    ----------
    run
        The run.
    path
        The file.
    table
        "crossings" saves those of soft stops instead.
    study, command
        As in `percuss.io.make_record`.
    force
        Whether a file of that name may be replaced.

    Raises
    ------
    OutputError
        If the file exists and `force` is false, or cannot be written.
    """
    with OutputFiles(path, force=force) as files:
        record = make_record(run, study=study, command=command)
        write_csv(run, files[path], record, table=table)


def write_csv(
    run: Trajectory,
    path: Path,
    record: Record,
    *,
    table: TableName = "impacts",
    length_unit: str = "",
    time_unit: str = "",
) -> None:
    """Write a table under the name `path`; floats read back to the same bits."""
    facts = {"columns": _columns(table, length_unit, time_unit)} if length_unit or time_unit else {}
    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {line}".rstrip() + "\n" for line in record.text(**facts).splitlines())
        file.write(",".join(COLUMNS[table]) + "\n")
        file.writelines(_blocks(run, table))


def _columns(table: TableName, length_unit: str, time_unit: str) -> str:
    """Return the columns with their units, for the record."""
    units = {"time": time_unit, "velocity": length_unit}
    if time_unit:
        units["velocity"] = f"{length_unit or '1'}/{time_unit}"
    return ", ".join(
        f"{column} [{units[measure]}]" if units.get(measure) else column
        for column, measure in COLUMNS[table].items()
    )


def _blocks(run: Trajectory, table: TableName) -> Iterator[str]:
    """Give the rows as text, many at a time."""
    events = getattr(run, table)
    columns = [getattr(events, name) for name in COLUMNS[table]]
    for first in range(0, len(events), ROWS):
        block = [column[first : first + ROWS].tolist() for column in columns]
        # repr gives the shortest text that reads back to the same bits; directions are words.
        texts = (map(str, values) for values in block)
        yield "".join(f"{row}\n" for row in map(",".join, zip(*texts, strict=True)))
