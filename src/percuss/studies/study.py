"""A study: one question to percuss, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from percuss.io.study_text import forcing_table, model_tables, number, stop_table
from percuss.io.toml import toml_text
from percuss.model.exact import Exact, Phase, as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, end_after_periods
from percuss.model.stops import Stop


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
        Number of impacts and entries into soft stops after which to stop; or None.
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
        Whether to write the impacts, and the crossings of soft stops, as CSV.
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
class EngineersModel:
    """An oscillator and its forcing in engineers' units, before they are divided by the mass.

    Parameters
    ----------
    mass, stiffness, damping_coefficient, damping_ratio, stops
        As `Oscillator.from_mass` takes them.
    forcing
        The force on the mass [force]; or None.

    Examples
    --------
    >>> from percuss.model import cosine
    >>> model = EngineersModel(mass=2.0, stiffness=50.0, forcing=cosine(3.0, amplitude=5.0))
    >>> model.oscillator().stiffness, model.forcing_per_mass().harmonics[0].amplitude
    (25.0, 2.5)
    """

    mass: Exact
    stiffness: Exact
    damping_coefficient: Exact | None = None
    damping_ratio: Exact | None = None
    stops: tuple[Stop, ...] = ()
    forcing: Forcing | None = None

    def oscillator(self) -> Oscillator:
        """Return the oscillator of unit mass."""
        return Oscillator.from_mass(
            self.mass, self.stiffness, self.damping_coefficient, self.damping_ratio, self.stops
        )

    def forcing_per_mass(self) -> Forcing | None:
        """Return the forcing divided by the mass."""
        return None if self.forcing is None else self.forcing.per_mass(self.mass)

    def tables(self) -> dict[str, object]:
        """Return the model as the tables of a study."""
        names = ("mass", "stiffness", "damping_coefficient", "damping_ratio")
        given = {name: getattr(self, name) for name in names}
        row = {name: number(value) for name, value in given.items() if value is not None}
        stops = [stop_table(stop) for stop in self.stops] or None
        tables: dict[str, object] = {"oscillator": {**row, "stops": stops}}
        if self.forcing is not None:
            tables["forcing"] = forcing_table(self.forcing)
        return tables


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
    given
        The model in the engineers' units of the study file, if it names a mass; `oscillator` and
        `forcing` are then those of unit mass that follow from it.

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
    given: EngineersModel | None = None

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


def end_time(run: Limits, forcing: Forcing | None, t0: Phase) -> float | None:
    """Return the time at which a run ends; None without `t_end` and without periods."""
    if run.t_end is not None:
        return as_float(run.t_end)
    if run.periods is None or forcing is None or forcing.period is None:
        return None
    return end_after_periods(forcing, t0, run.periods)


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
    model = model_tables(study.oscillator, study.forcing, study.start)
    if study.given is not None:
        model |= study.given.tables()
    return toml_text(
        {
            "study": {"kind": study.kind, "title": study.title},
            **model,
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
