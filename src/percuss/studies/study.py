"""A study: one question to percuss, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.errors import ParameterError
from percuss.io.study_text import forcing_table, model_tables, number, stop_table
from percuss.io.toml import toml_text
from percuss.model.exact import Exact, Phase
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Stop
from percuss.studies.question import Question
from percuss.studies.schema import MOST_DIGITS

__all__ = ["Certify", "Draw", "EngineersModel", "Save", "Study", "study_text"]


@dataclass(frozen=True, slots=True)
class Save:
    """Which files a study writes.

    Parameters
    ----------
    netcdf
        Whether to write the result as NetCDF.
    csv
        Whether to write its tables as CSV.
    samples
        Number of equally spaced times in the NetCDF file of a motion or an orbit.
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
        First and last time of a motion that are drawn; default: the whole run.
    length_unit, time_unit
        Units on the axes; empty for dimensionless ones.
    quantity
        What of a branch is drawn over its parameter, as in `percuss.plotting.plot_branch`.
    manifolds
        Whether the stable manifolds of saddles are drawn into basins.
    """

    png: bool = True
    svg: bool = True
    window: tuple[Phase, Phase] | None = None
    length_unit: str = ""
    time_unit: str = ""
    quantity: str | None = None
    manifolds: bool = False


@dataclass(frozen=True, slots=True)
class Certify:
    """To how many digits the answer of a study is proven in ball arithmetic.

    Parameters
    ----------
    digits
        As `percuss.certify` takes them: 1 to 1000.

    Raises
    ------
    ParameterError
        If they are fewer or more.
    """

    digits: int = 12

    def __post_init__(self) -> None:
        if not 1 <= self.digits <= MOST_DIGITS:
            reason = f"not a whole number from 1 to {MOST_DIGITS}"
            raise ParameterError("certify.digits", self.digits, reason)


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
    """A model, what is asked about it, and what to keep of the answer.

    Parameters
    ----------
    oscillator, forcing
        What is moving, under what force (None: free).
    question
        What is asked: a value of `percuss.studies.kinds`, such as `Motion`.
    title
        A line about it.
    save, draw
        Files and pictures.
    given
        The model in the engineers' units of the study file, if it names a mass; `oscillator` and
        `forcing` are then those of unit mass that follow from it.
    certify
        To how many digits the answer is proven, of a motion, an orbit or a branch; None: not.

    Examples
    --------
    >>> from percuss.model import Start, impact_oscillator, sine
    >>> from percuss.studies import Limits, Motion
    >>> study = Study(impact_oscillator(), sine(3), Motion(Start(0, "0.51"), Limits(periods=10)))
    >>> study.kind
    'motion'
    """

    oscillator: Oscillator
    forcing: Forcing | None
    question: Question
    title: str = ""
    save: Save = Save()
    draw: Draw = Draw()
    given: EngineersModel | None = None
    certify: Certify | None = None

    @property
    def kind(self) -> str:
        """The kind of question."""
        return self.question.kind

    def text(self) -> str:
        """Return the study as TOML text, in which `parse_study` finds the same numbers."""
        return study_text(self)


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
    save, draw = study.save, study.draw
    window = None if draw.window is None else [number(time) for time in draw.window]
    model = model_tables(study.oscillator, study.forcing)
    if study.given is not None:
        model |= study.given.tables()
    samples = save.samples if save.samples != Save().samples else None
    return toml_text(
        {
            "study": {"kind": study.kind, "title": study.title},
            **model,
            **study.question.tables(),
            **({} if study.certify is None else {"certify": {"digits": study.certify.digits}}),
            "save": {"netcdf": save.netcdf, "csv": save.csv, "samples": samples},
            "draw": {
                "png": draw.png,
                "svg": draw.svg,
                "window": window,
                "length_unit": draw.length_unit,
                "time_unit": draw.time_unit,
                "quantity": draw.quantity,
                "manifolds": draw.manifolds or None,
            },
        }
    )
