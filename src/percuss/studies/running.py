"""Run a study and write what came out."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from percuss.errors import ParameterError
from percuss.io.figures import write_figure
from percuss.io.files import OutputFiles, check_output
from percuss.io.netcdf import write_netcdf
from percuss.io.reading import record_file
from percuss.io.record import Record, make_record
from percuss.io.results import table_of
from percuss.io.table import write_columns, write_csv
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.plotting.style import offscreen_figure, style
from percuss.studies.proving import STEM, Proof, check_certify, draw_proof, is_drawn, proof_of
from percuss.studies.question import Means, Progress
from percuss.studies.study import Study

# A table of more rows is no help to anybody as CSV: spreadsheets hold so many, header included.
MOST_ROWS = 2**20
# Files that are told of before they are written [bytes].
LARGE = 1e8

__all__ = ["StudyResult", "output_files", "run_study"]


@dataclass(frozen=True, slots=True)
class StudyResult:
    """What came out of a study.

    Parameters
    ----------
    answer
        The result: a run, an orbit, a branch, a dataset, as the function of that kind returns it.
    report
        What was found, in a few lines: words by what they are about.
    files
        The files that were written; none where a run into a store was interrupted.
    seconds
        How long it took [s], the compiling of the engine not counted.
    is_whole
        False where it was stopped before its end.
    proven
        What `percuss.certify` returned, of a branch a tuple of those of its special points; None
        where nothing was to be proven.
    """

    answer: Any
    report: Mapping[str, str]
    files: tuple[Path, ...]
    seconds: float
    is_whole: bool
    proven: Any = None


def output_files(study: Study, folder: Path | str) -> tuple[Path, ...]:
    """Return the files that a study writes into a folder.

    Parameters
    ----------
    study
        The study.
    folder
        The folder.

    Returns
    -------
    tuple of Path
        Those of its kind that the study asks for, such as ``motion.nc``, ``impacts.csv``
        with its record ``impacts.csv.toml``, ``motion.csv``, ``crossings.csv`` (where there are soft stops), ``motion.png`` and ``motion.svg``; also
        ``certified.csv`` and ``certified.png`` where the answer is to be proven.
    """
    question = study.question
    names = [f"{question.stem}.nc"] if study.save.netcdf else []
    proven = [STEM] if study.certify is not None else []
    if study.save.csv:
        tables = [f"{stem}.csv" for stem in [*question.csv(study), *proven]]
        names += [name for table in tables for name in (table, record_file(table).name)]
    suffixes = {".png": study.draw.png, ".svg": study.draw.svg}
    names += [
        f"{stem}{suffix}"
        for stem in [*question.pictures(study), *([STEM] if is_drawn(study) else [])]
        for suffix, is_wanted in suffixes.items()
        if is_wanted
    ]
    return tuple(Path(folder) / name for name in names)


def run_study(
    study: Study,
    folder: Path | str,
    *,
    command: str | None = None,
    force: bool = False,
    store: Path | str | None = None,
    engine: str = "threads",
    progress: Progress | bool | None = None,
    on_write: Callable[[Path], None] | None = None,
) -> StudyResult:
    """Answer a study and write its files, all of them or none.

    Parameters
    ----------
    study
        The study.
    folder
        Where to write; made if it is missing.
    command
        The command or call, for the record in each file.
    force
        Whether files of the same names may be replaced. Other files are never touched.
    store, engine
        As in `percuss.sweep`; for studies of many motions.
    progress
        As in `percuss.simulate`. What is stopped is written as far as it came, unless it is in a
        store: then no file is, and the same call goes on with it.
    on_write
        Called with each file before it is written.

    Returns
    -------
    StudyResult
        The answer and its files.

    Warns
    -----
    UserWarning
        If a table is left out that a spreadsheet could not hold, and if the files are large.

    Raises
    ------
    OutputError
        Before the work, if the files exist or the folder cannot be written to; after it, if
        writing fails.
    ParameterError
        If a store or an engine is given, and it is no study of many motions; or if an answer is
        to be certified that cannot be.
    MissingExtraError
        If one is to be certified, and python-flint is not there.
    """
    question = study.question
    for name, value in (("store", store), ("engine", engine if engine != "threads" else None)):
        if value is not None and not question.is_ensemble:
            reason = f"for studies of many motions; this one is of kind {question.kind}"
            raise ParameterError(name, str(value), reason)
    check_certify(study)
    files = output_files(study, folder)
    check_output(files, force=force)
    # The first run of a process compiles the engine or loads it: no time of this study.
    simulate(Oscillator(), t_end=1.0)
    watched = _Watched(progress)
    means = Means(None if store is None else Path(store), engine, watched.report)
    began = time.perf_counter()
    answer = question.answer(study, means)
    proof = None
    if study.certify is not None and not watched.is_stopped:
        proof = proof_of(study, answer, watched.report)
    seconds = time.perf_counter() - began
    is_whole = not watched.is_stopped and getattr(answer, "attrs", {}).get("complete", 1) == 1
    if store is not None and not is_whole:
        return StudyResult(answer, question.report(answer), (), seconds, is_whole=False)
    record = make_record(answer, study=study.text(), command=command)
    if study.certify is not None and proof is None:
        files = tuple(file for file in files if file.name.partition(".")[0] != STEM)
    files = _without_long_tables(files, answer, study)
    with OutputFiles(*files, force=force) as parts:
        _write(answer, study, record, {file: parts[file] for file in files}, on_write, proof)
    report = question.report(answer) | _proven_rows(study, proof)
    result = None if proof is None else proof.result
    return StudyResult(answer, report, files, seconds, is_whole, result)


def _without_long_tables(files: tuple[Path, ...], answer: Any, study: Study) -> tuple[Path, ...]:
    """Return the files without the tables that are too long, and tell of these and of the size."""
    tables = study.question.csv(study)
    left_out: set[Path] = set()
    size = 0
    for file in files:
        if file.suffix != ".csv" or file.stem not in tables or tables[file.stem] == "motion":
            continue
        columns = [np.asarray(it) for it in table_of(answer, tables[file.stem]).values()]
        size += sum(column.nbytes for column in columns)
        n_rows = len(columns[0])
        if n_rows > MOST_ROWS and study.save.netcdf:
            left_out |= {file, record_file(file)}
            name = f"{study.question.stem}.nc"
            warnings.warn(
                f"{file.name} is left out: {n_rows:,} rows are more than the {MOST_ROWS:,} of a "
                f"spreadsheet; {name} has them, percuss.load_netcdf reads it",
                stacklevel=3,
            )
    if size > LARGE:
        warnings.warn(f"the files take more than {size / 1e6:,.0f} MB", stacklevel=3)
    return tuple(file for file in files if file not in left_out)


def _proven_rows(study: Study, proof: Proof | None) -> dict[str, str]:
    if proof is not None:
        return proof.report
    return {} if study.certify is None else {"certified": "nothing, the study was interrupted"}


class _Watched:
    """A progress function that remembers whether it has stopped the work."""

    def __init__(self, progress: Progress | bool | None) -> None:
        self._progress = progress
        self.is_stopped = False

    @property
    def report(self) -> Progress | bool | None:
        """What to give to the work."""
        return self._call if callable(self._progress) else self._progress

    def _call(self, done: float, total: float) -> bool:
        goes_on = not callable(self._progress) or self._progress(done, total) is not False
        # What is done cannot be stopped any more.
        self.is_stopped = not goes_on and done < total
        return goes_on


def _write(
    answer: Any,
    study: Study,
    record: Record,
    parts: Mapping[Path, Path],
    on_write: Callable[[Path], None] | None,
    proof: Proof | None,
) -> None:
    """Write each file under its temporary name."""
    tables, pictures = study.question.csv(study), study.question.pictures(study)
    units = {"length_unit": study.draw.length_unit, "time_unit": study.draw.time_unit}
    figures: dict[str, Any] = {}
    for file, part in parts.items():
        if file.suffix == ".toml":
            # Written with the table that it lies beside.
            continue
        if on_write is not None:
            on_write(file)
        if file.suffix == ".nc":
            write_netcdf(answer, part, record, samples=study.save.samples)
        elif file.suffix == ".csv" and file.stem == STEM and proof is not None:
            write_columns(proof.columns, part, record, **units, beside=parts[record_file(file)])
        elif file.suffix == ".csv":
            write_csv(
                answer,
                part,
                record,
                table=tables[file.stem],
                **units,
                beside=parts[record_file(file)],
                samples=getattr(study.save, "samples", None),
            )
        else:
            if file.stem not in figures:
                figures[file.stem] = offscreen_figure()
                with style():
                    if file.stem == STEM and proof is not None:
                        draw_proof(proof, study, figures[file.stem])
                    else:
                        pictures[file.stem](answer, study, figures[file.stem])
            write_figure(figures[file.stem], part, file.suffix, record)
