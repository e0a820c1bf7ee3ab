"""A study: one question to percuss, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from percuss.io.study_text import model_tables, number
from percuss.io.toml import toml_text
from percuss.model.exact import PI, Exact, Phase, angle, as_float, as_fraction
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start


@dataclass(frozen=True, slots=True)
class Limits:
    """How long a motion is followed.

    Parameters
    ----------
    t_end
        Time of the end [time]; or None.
    periods
        Number of forcing periods from the start, in place of `t_end`; or None.
    max_impacts
        Number of impacts after which to stop; or None.
    """

    t_end: Phase | None = None
    periods: Exact | None = None
    max_impacts: int | None = None


@dataclass(frozen=True, slots=True)
class Save:
    """Which files a study writes.

    Parameters
    ----------
    netcdf
        Whether to write the run as NetCDF.
    csv
        Whether to write the impacts as CSV.
    samples
        Number of equally spaced times in the NetCDF file.
    """

    netcdf: bool = True
    csv: bool = True
    samples: int = 2001


@dataclass(frozen=True, slots=True)
class Draw:
    """Which pictures a study draws.

    Parameters
    ----------
    png, svg
        Whether to write the picture in this format.
    window
        First and last time that are drawn; default: the whole run.
    length_unit, time_unit
        Units on the axes; empty for dimensionless ones.
    """

    png: bool = True
    svg: bool = True
    window: tuple[Phase, Phase] | None = None
    length_unit: str = ""
    time_unit: str = ""


@dataclass(frozen=True, slots=True)
class Study:
    """One motion to simulate, and what to keep of it.

    Parameters
    ----------
    oscillator, forcing, start
        What is moving, under what force (None: free), and from where.
    run
        How long.
    title
        A line about it.
    save, draw
        Files and pictures.
    kind
        What is asked; so far always one motion.

    Examples
    --------
    >>> from percuss.model import impact_oscillator, sine
    >>> study = Study(impact_oscillator(), sine(3), Start(0, "0.51"), Limits(periods=10))
    >>> study.t_end
    20.943951023931955
    """

    oscillator: Oscillator
    forcing: Forcing | None
    start: Start
    run: Limits
    title: str = ""
    save: Save = Save()
    draw: Draw = Draw()
    kind: Literal["motion"] = "motion"

    @property
    def t_end(self) -> float | None:
        """Time of the end [time], None if only the number of impacts limits the run."""
        return end_time(self.run, self.forcing, self.start.t0)

    @property
    def window(self) -> tuple[float, float] | None:
        """First and last time that are drawn, None for all."""
        if self.draw.window is None:
            return None
        first, last = self.draw.window
        return as_float(first), as_float(last)

    def text(self) -> str:
        """Return the study as TOML text, in which `parse_study` finds the same numbers."""
        return study_text(self)


def end_time(run: Limits, forcing: Forcing | None, t0: Exact) -> float | None:
    """Return the time at which a run ends; None without `t_end` and without periods."""
    if run.t_end is not None:
        return as_float(run.t_end)
    if run.periods is None or forcing is None or forcing.period is None:
        return None
    # From the exact frequency where there is one: 2 pi rounds once, not once a period.
    if forcing.frequency is not None:
        period = 2 * PI / forcing.frequency
    else:
        times, plus = angle(forcing.period)
        period = times * PI + plus
    return float(as_fraction(t0) + as_fraction(run.periods) * period)


def study_text(study: Study) -> str:
    """Return a study as TOML text, with every number exactly as it was given.

    Parameters
    ----------
    study
        The study.

    Returns
    -------
    str
        The text of a study file.
    """
    run, save, draw = study.run, study.save, study.draw
    limits = {
        "t_end": None if run.t_end is None else number(run.t_end),
        "periods": None if run.periods is None else number(run.periods),
        "max_impacts": run.max_impacts,
    }
    window = None if draw.window is None else [number(time) for time in draw.window]
    return toml_text(
        {
            "study": {"kind": study.kind, "title": study.title},
            **model_tables(study.oscillator, study.forcing, study.start),
            "run": limits,
            "save": {"netcdf": save.netcdf, "csv": save.csv, "samples": save.samples},
            "draw": {
                "png": draw.png,
                "svg": draw.svg,
                "window": window,
                "length_unit": draw.length_unit,
                "time_unit": draw.time_unit,
            },
        }
    )
