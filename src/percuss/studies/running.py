"""Run a study and write what came out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from percuss.io.figures import write_figure
from percuss.io.files import OutputFiles, check_output
from percuss.io.netcdf import write_netcdf
from percuss.io.record import make_record
from percuss.io.table import write_csv
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
        How long the simulation took [s].
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
        All of ``motion.nc``, ``impacts.csv``, ``motion.png`` and ``motion.svg`` that the study
        asks for.
    """
    names = {
        "motion.nc": study.save.netcdf,
        "impacts.csv": study.save.csv,
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
    _write(run, study, files, command=command, force=force)
    return StudyResult(run, classify_impact_times(run), files, seconds)


def _write(
    run: Trajectory, study: Study, files: tuple[Path, ...], *, command: str | None, force: bool
) -> None:
    record = make_record(run, study=study.text(), command=command)
    with OutputFiles(*files, force=force) as parts:
        for file in files:
            if file.suffix == ".nc":
                write_netcdf(run, parts[file], record, samples=study.save.samples)
            elif file.suffix == ".csv":
                write_csv(run, parts[file], record)
        pictures = [file for file in files if file.suffix in (".png", ".svg")]
        if pictures:
            units = Units(study.draw.length_unit, study.draw.time_unit)
            figure = plot_motion(
                run, offscreen_figure(), title=study.title, window=study.window, units=units
            )
            for picture in pictures:
                write_figure(figure, parts[picture], picture.suffix, record)
