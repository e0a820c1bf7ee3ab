"""Impacts as a CSV table that begins with the record of its run."""

from __future__ import annotations

import csv
from pathlib import Path

from percuss.io.files import OutputFiles
from percuss.io.record import Record, make_record
from percuss.motion.trajectory import Trajectory

COLUMNS = ("t", "v_before", "v_after", "stop", "cycle", "impulse")


def save_csv(
    run: Trajectory,
    path: Path | str,
    *,
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
        write_csv(run, files[path], make_record(run, study=study, command=command))


def write_csv(run: Trajectory, path: Path, record: Record) -> None:
    """Write the impacts under the name `path`; floats read back to the same bits."""
    columns = [getattr(run.impacts, name).tolist() for name in COLUMNS]
    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {line}".rstrip() + "\n" for line in record.text().splitlines())
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        rows.writerows(zip(*columns, strict=True))
