"""Run a study and write its results."""

from __future__ import annotations

import logging
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from percuss.errors import OutputError, ParameterError
from percuss.execution import ArrayPart, Execution, folder_of_parts
from percuss.io.column_units import Columns, units_of_columns
from percuss.io.figures import write_figure
from percuss.io.files import OutputFiles, check_output, record_file
from percuss.io.netcdf import OF_NETCDF, check_netcdf, write_netcdf
from percuss.io.record import Record, make_record
from percuss.io.results import table_of
from percuss.io.table import write_columns
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.plotting.style import offscreen_figure, style, title_figure
from percuss.progress import Progress, Report
from percuss.studies.proving import STEM, ProofOfStudy, check_certify, draw_proof, proof_of
from percuss.studies.study import Study

LOG = logging.getLogger(__name__)

# Rows of a spreadsheet, header included: longer tables are not written as CSV.
MOST_ROWS = 2**20
# Size of the files from which on a warning comes before they are written [bytes].
LARGE = 1e8


@dataclass(frozen=True, slots=True)
class StudyResult:
    """The results of a study.

    Parameters
    ----------
    answer
        The result: a run, an orbit, a branch, a dataset, as the function of that kind returns it.
    report
        The results in a few lines: words by their names.
    files
        The written files; none where a run into a store was interrupted.
    seconds
        The time of the computation [s], without compiling the kernels.
    is_whole
        False where it was stopped before its end.
    proven
        The result of `percuss.certify`, of a branch a tuple of those of its special points; None
        where no proof was asked for.
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
        Those that the study asks for, such as ``motion.nc``, ``impacts.csv`` with its
        record ``impacts.csv.toml``, ``motion.csv``, ``crossings.csv`` (where there are soft
        stops), ``motion.png`` and ``motion.svg``; also ``certified.csv`` and ``certified.png``
        where the answer is to be proven.
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
        for stem in [*question.pictures(study), *(proven if question.is_certifiable else [])]
        for suffix, is_wanted in suffixes.items()
        if is_wanted
    ]
    if study.draw.animation is not None:
        names.append(f"{question.stem}.{study.draw.animation}")
    return tuple(Path(folder) / name for name in names)


def run_study(
    study: Study,
    folder: Path | str,
    *,
    command: str | None = None,
    force: bool = False,
    store: Path | str | None = None,
    engine: str = "threads",
    part: ArrayPart | None = None,
    progress: Report | bool | None = None,
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
        As in `percuss.sweep`; for studies of many motions. The store of a fit is a file, as
        `percuss.fit` has it.
    part
        The part of a job array that is computed; its data stay in the store, and no file is
        written.
    progress
        As in `percuss.simulate`. The part that is done when it is stopped is written; with a store
        no file is written, and the same call goes on.
    on_write
        Called with each file before it is written.

    Returns
    -------
    StudyResult
        The answer and its files.

    Warns
    -----
    UserWarning
        If a table is left out because a spreadsheet could not hold it, and if files are large.

    Raises
    ------
    OutputError
        Before the work, if the files exist or the folder cannot be written to; after it, if
        writing fails.
    ParameterError
        If a store or an engine is given for a study that is not one of many motions, or a proof is
        asked for that there is not.
    MissingExtraError
        If a proof, a NetCDF file or a store is asked for, and what it needs is not installed.
    """
    _check_execution(study, store, engine, part)
    if part is not None and store is not None:
        return _part(study, Execution(Path(store), engine, progress=progress, part=part))
    if study.certify is not None:
        check_certify(study)
    if study.save.netcdf and not all(map(find_spec, OF_NETCDF)):
        check_netcdf()
    files = output_files(study, folder)
    check_output(files, force=force)
    if study.draw.animation is not None:
        from percuss.plotting.animation import check_format

        check_format(files[-1])
    # The first run of a process compiles or loads the kernels, which is not counted.
    simulate(Oscillator(), t_end=1.0)
    LOG.info("%s: computing", study.title or study.kind)
    began = time.perf_counter()
    place = None if store is None else Path(store)
    answer, proof, is_whole = _answered(study, place, engine, progress)
    seconds = time.perf_counter() - began
    report = study.question.report(answer) | _proof_rows(study, proof)
    if store is not None and not is_whole:
        return StudyResult(answer, report, (), seconds, is_whole)
    if study.certify is not None and proof is None:
        files = tuple(file for file in files if file.name.partition(".")[0] != STEM)
    tables = _tables(answer, study, proof)
    files = _without_long_tables(files, tables, study)
    record = make_record(answer, study=study.text(), command=command)
    with OutputFiles(*files, force=force) as parts:
        paths = {file: parts[file] for file in files}
        _write(answer, study, proof, tables, record, paths, on_write, progress)
    LOG.info("computed in %.3g s; wrote %s", seconds, ", ".join(map(str, files)) or "no files")
    return StudyResult(answer, report, files, seconds, is_whole, proof and proof.result)


def _check_execution(
    study: Study, store: Path | str | None, engine: str, part: ArrayPart | None
) -> None:
    """Raise an error if a store, an engine or a part is given without use or without the others."""
    given = {
        "store": store,
        "engine": engine if engine != "threads" else None,
        "part": part,
    }
    for name, value in given.items():
        of_fit = name == "store" and study.question.takes_store
        if value is not None and not (study.question.is_ensemble or of_fit):
            also = " and of fits" if name == "store" else ""
            reason = f"for studies of many motions{also}; this one is of kind {study.kind}"
            raise ParameterError(name, str(value), reason)
    if part is not None and store is None:
        raise ParameterError("part", str(part), "needs a store, where the parts are put together")
    if part is None and store is not None and not Path(store).exists():
        parts = folder_of_parts(Path(store))
        if parts.exists():
            reason = f"its parts lie in {parts}; percuss merge {store} puts them together first"
            raise OutputError(store, reason)


def _part(study: Study, execution: Execution) -> StudyResult:
    """Compute a part of a study of many motions into its store."""
    began = time.perf_counter()
    done = study.question.answer(study, execution)
    seconds = time.perf_counter() - began
    report = {
        "part": f"{execution.part}, {'complete' if done.attrs['complete'] else 'not complete'}",
        "points": f"{done.attrs['points']:,}",
        "impacts": f"{done.attrs['n_impacts']:,}",
    }
    return StudyResult(done, report, (), seconds, done.attrs["complete"] == 1)


def _answered(
    study: Study, store: Path | None, engine: str, report: Report
) -> tuple[Any, ProofOfStudy | None, bool]:
    """Return the answer, its proof if one is wanted, and whether both are complete."""
    progress = Progress(report if callable(report) else None, total=1.0)

    def reach(done: float, total: float) -> bool:
        progress.total = total
        return progress.reach(done)

    def is_stopped() -> bool:
        # Not where the stop came after the end.
        return progress.is_stopped and progress.done < progress.total

    reported = reach if callable(report) else report
    answer = study.question.answer(study, Execution(store, engine, progress=reported))
    wanted = study.certify is not None and not is_stopped()
    proof = proof_of(study, answer, reported) if wanted else None
    is_complete = getattr(answer, "attrs", {}).get("complete", 1) == 1
    return answer, proof, is_complete and not is_stopped()


def _proof_rows(study: Study, proof: ProofOfStudy | None) -> dict[str, str]:
    if proof is not None:
        return proof.report
    return {} if study.certify is None else {"certified": "nothing, the study was interrupted"}


def _tables(answer: Any, study: Study, proof: ProofOfStudy | None) -> dict[str, Columns]:
    """Return the tables saved as CSV, by the stem of the file."""
    if not study.save.csv:
        return {}
    names = study.question.csv(study)
    own = {stem: table_of(answer, name, study.save.samples) for stem, name in names.items()}
    return own if proof is None else {**own, STEM: proof.columns}


def _without_long_tables(
    files: tuple[Path, ...], tables: Mapping[str, Columns], study: Study
) -> tuple[Path, ...]:
    """Return the files without the tables that are too long; warn of those and of the size."""
    left_out: set[Path] = set()
    size = 0
    for file in files:
        # The study itself determines the length of a sampled motion and of a proof.
        if file.suffix != ".csv" or file.stem in ("motion", STEM):
            continue
        columns = [np.asarray(column) for column in tables[file.stem].values()]
        size += sum(column.nbytes for column in columns)
        n_rows = len(columns[0])
        if n_rows > MOST_ROWS and study.save.netcdf:
            left_out |= {file, record_file(file)}
            warnings.warn(
                f"{file.name} is left out: {n_rows:,} rows are more than the {MOST_ROWS:,} of a "
                f"spreadsheet; {study.question.stem}.nc has them, percuss.load_netcdf reads it",
                stacklevel=3,
            )
    if size > LARGE:
        warnings.warn(f"the files take more than {size / 1e6:,.0f} MB", stacklevel=3)
    return tuple(file for file in files if file not in left_out)


def _write(
    answer: Any,
    study: Study,
    proof: ProofOfStudy | None,
    tables: Mapping[str, Columns],
    record: Record,
    paths: Mapping[Path, Path],
    on_write: Callable[[Path], None] | None,
    progress: Report,
) -> None:
    """Write each file under its temporary name."""
    figures: dict[str, Any] = {}
    for file, path in paths.items():
        if file.suffix == ".toml":
            # Written together with its table.
            continue
        if on_write is not None:
            on_write(file)
        if file.suffix == ".nc":
            write_netcdf(answer, path, record, samples=study.save.samples)
        elif file.suffix == ".csv":
            record_path = paths[record_file(file)]
            columns = tables[file.stem]
            units = units_of_columns(answer, columns, study.draw.units())
            # Those of the pictures alone change no header.
            write_columns(
                columns,
                path,
                record,
                units=units,
                has_header_units=study.model.units is not None,
                decimal_comma=study.save.decimal_comma,
                record_path=record_path,
            )
        elif file.suffix == f".{study.draw.animation}":
            study.question.film(answer, study).render(path, file.suffix, progress)
        else:
            if file.stem not in figures:
                figures[file.stem] = draw_picture(file.stem, answer, study, proof)
            write_figure(figures[file.stem], path, file.suffix, record)


def draw_picture(stem: str, answer: Any, study: Study, proof: ProofOfStudy | None = None) -> Any:
    """Return one of the pictures of a study, with its title."""
    figure = offscreen_figure()
    with style():
        if stem == STEM and proof is not None:
            draw_proof(proof, study, figure)
        else:
            study.question.pictures(study)[stem](answer, study, figure)
        title_figure(figure, study.title)
    return figure
