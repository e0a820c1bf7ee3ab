"""Run a study and write what came out."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from percuss.io.figures import Figure, write_figure
from percuss.io.files import OutputFiles, check_output
from percuss.io.netcdf import write_netcdf
from percuss.io.record import Record, make_record
from percuss.io.table import TableName, write_csv
from percuss.model.oscillator import Oscillator
from percuss.model.stops import SoftStop
from percuss.motion.impact_times import ImpactTimes, classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.plotting.motion_figure import plot_motion
from percuss.plotting.style import Units, offscreen_figure
from percuss.studies.study import Study

Progress = Callable[[float, float], bool]


@dataclass(frozen=True, slots=True)
class StudyResult:
    """What came out of a study.

    Parameters
    ----------
    run
        The motion.
    impact_times
        The class of its impact times.
    files
        The files that were written.
    seconds
        How long the simulation took [s], the compiling of the engine not counted.
    """

    run: Trajectory
    impact_times: ImpactTimes
    files: tuple[Path, ...]
    seconds: float


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
        All of ``motion.nc``, ``impacts.csv``, ``crossings.csv`` (where there are soft stops),
        ``motion.png`` and ``motion.svg`` that the study asks for.
    """
    has_soft_stops = any(isinstance(stop, SoftStop) for stop in study.oscillator.stops)
    names = {
        "motion.nc": study.save.netcdf,
        "impacts.csv": study.save.csv,
        "crossings.csv": study.save.csv and has_soft_stops,
        "motion.png": study.draw.png,
        "motion.svg": study.draw.svg,
    }
    return tuple(Path(folder) / name for name, is_wanted in names.items() if is_wanted)


def run_study(
    study: Study,
    folder: Path | str,
    *,
    command: str | None = None,
    force: bool = False,
    progress: Progress | bool | None = None,
    on_write: Callable[[Path], None] | None = None,
) -> StudyResult:
    """Simulate the motion of a study and write its files, all of them or none.

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
    progress
        As in `percuss.simulate`; a run that is stopped is written as far as it came.
    on_write
        Called with each file before it is written.

    Returns
    -------
    StudyResult
        The run and its files.

    Raises
    ------
    OutputError
        Before the simulation, if the files exist or the folder cannot be written to; after it,
        if writing fails.
    """
    files = output_files(study, folder)
    check_output(files, force=force)
    # The first run of a process compiles the engine or loads it: no time of this motion.
    simulate(Oscillator(), t_end=1.0)
    began = time.perf_counter()
    start = study.start
    run = simulate(
        study.oscillator,
        study.forcing,
        start.x0,
        start.v0,
        start.t0,
        t_end=study.t_end,
        max_impacts=study.run.max_impacts,
        progress=progress,
    )
    seconds = time.perf_counter() - began
    record = make_record(run, study=study.text(), command=command)
    with OutputFiles(*files, force=force) as parts:
        _write(run, study, record, {file: parts[file] for file in files}, on_write)
    return StudyResult(run, classify_impact_times(run), files, seconds)


def _write(
    run: Trajectory,
    study: Study,
    record: Record,
    parts: Mapping[Path, Path],
    on_write: Callable[[Path], None] | None,
) -> None:
    """Write each file under its temporary name."""
    figure = None
    for file, part in parts.items():
        if on_write is not None:
            on_write(file)
        if file.suffix == ".nc":
            write_netcdf(run, part, record, samples=study.save.samples)
        elif file.suffix == ".csv":
            units = {"length_unit": study.draw.length_unit, "time_unit": study.draw.time_unit}
            table: TableName = "crossings" if file.stem == "crossings" else "impacts"
            write_csv(run, part, record, table=table, **units)
        else:
            figure = figure or _figure(run, study)
            write_figure(figure, part, file.suffix, record)


def _figure(run: Trajectory, study: Study) -> Figure:
    window = study.window
    # A run may end before the window begins: it was interrupted, or came to rest.
    if window is not None and not (window[0] < run.t_end and window[1] > run.t0):
        window = None
    units = Units(study.draw.length_unit, study.draw.time_unit)
    return plot_motion(run, offscreen_figure(), title=study.title, window=window, units=units)
