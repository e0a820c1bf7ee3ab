"""A study as a frozen value: a model, a question of some kind, and what is kept of the answer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias, cast

from percuss.execution import Execution
from percuss.io.study_text import model_tables, toml_text
from percuss.model.faults import draft
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, Stop
from percuss.model.periods import period_in_common
from percuss.model.start import Start, start_faults
from percuss.model.structure import Structure
from percuss.model.units import Units, in_units, is_unit
from percuss.studies.tables import (
    DRAW_ALL,
    MISSING,
    SAVE_ALL,
    Certify,
    Draw,
    RawTable,
    Save,
    StudyFaults,
    as_written,
    values_of,
)

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.motion.extremes import Extrema
    from percuss.plotting.animation import Film

# Draws the result of a study on an empty figure.
Picture: TypeAlias = "Callable[[Any, Study, Any], None]"

AT_REST = Start(0.0, 0.0)
# The order in which messages name them; each has a module and a class of its name.
_KINDS = (
    "motion",
    "orbit",
    "orbits",
    "branch",
    "curve",
    "response",
    "sweep",
    "diagram",
    "basins",
    "lyapunov",
    "design",
    "fit",
)
# Fields of questions that are tables of their own in a file, in its order; the other fields stand
# in the table of the kind.
TABLES = {"start": "start", "limits": "run", "sought": "orbit", "over": "over", "steps": "branch"}
_PLACE = ("at", "side")
# The last part of a traceback says most.
LONGEST_REASON = 160


class OneModel:
    """The model of a study and the force on it, under the names of both kinds of models."""

    __slots__ = ()

    model: Oscillator | Structure
    force: Forcing | Loads | None

    @property
    def structure(self) -> Structure | None:
        """The structure; None where it is an oscillator."""
        return self.model if isinstance(self.model, Structure) else None

    @property
    def oscillator(self) -> Oscillator:
        """The oscillator.

        Raises
        ------
        TypeError
            If it is a structure.
        """
        if isinstance(self.model, Structure):
            raise TypeError("a study of a structure, which is `model`, has no oscillator")
        return self.model

    @property
    def forcing(self) -> Forcing | None:
        """The force on the oscillator.

        Raises
        ------
        TypeError
            If there are loads of a structure.
        """
        if isinstance(self.force, Loads):
            raise TypeError("the loads of a structure, which are `force`, are no forcing")
        return self.force


@dataclass(frozen=True, slots=True)
class StudyDraft(OneModel):
    """A study while its file is read, against which its question is checked.

    Attributes
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    model, force
        The oscillator and the force on it, or the structure and its loads; drafts where they have
        faults.
    draw
        The pictures.
    faults
        The faults found so far.
    folder
        The folder of its file, where those that it names lie; None without one.
    """

    document: RawTable
    model: Oscillator | Structure
    force: Forcing | Loads | None
    draw: Draw
    faults: StudyFaults
    folder: FilePath | None = None

    @property
    def model_tables(self) -> tuple[str, str]:
        """The names of the tables of what moves and of what acts on it."""
        return ("oscillator", "forcing") if self.structure is None else ("structure", "loads")

    @property
    def has_right_model(self) -> bool:
        """Whether the model has no faults."""
        return not any(map(self.faults.is_wrong, self.model_tables))

    def needs_period(self, why: str) -> None:
        """Add a force without a period, where one is needed."""
        table = self.model_tables[1]
        if self.faults.is_wrong(table):
            return
        if self.force is None or self.force.is_constant:
            self.faults.add((table,), f"missing harmonics; {why}")
        elif self.force.period is None and self.structure is not None:
            reason = f"missing, as the loads have no common period; {why}"
            self.faults.add(("structure", "loads_period"), reason)
        elif self.force.period is None:
            found = period_in_common(self.force)
            instead = "" if found is None else f'; the harmonics have "{found}" in common'
            self.faults.add(("forcing", "period"), f"missing; {why}{instead}")


class Question(ABC):
    """The question of a study, with all it needs besides the model: a frozen table.

    Its fields are the keys of its file and the arguments of the library function that answers it.

    Attributes
    ----------
    kind
        Its name in ``[study]``: that of the class, in lower case.
    doing
        What is done while it is answered, before a progress bar.
    stem
        Name of the NetCDF file, without suffix; default: the kind.
    is_ensemble
        Whether it is computed in chunks, for which there are stores and engines.
    takes_store
        Whether its search is kept in a file, so that it can be resumed.
    is_certifiable
        Whether its file may ask for a proof.
    needed, needed_of_structures
        Tables that its file must have, and that of a structure.
    of_oscillators, of_structures
        Fields that only the files of an oscillator, or of a structure, have.
    save_keys, draw_keys, draw_keys_of_structures
        Keys of ``[save]`` and ``[draw]`` beyond those of all kinds.
    columns
        The tables saved as CSV, by the stem of the file.
    """

    __slots__ = ()

    kind: ClassVar[str]
    doing: ClassVar[str]
    stem: ClassVar[str]
    is_ensemble: ClassVar[bool] = False
    takes_store: ClassVar[bool] = False
    is_certifiable: ClassVar[bool] = False
    needed: ClassVar[tuple[str, ...]] = ()
    needed_of_structures: ClassVar[tuple[str, ...]] = ()
    of_oscillators: ClassVar[tuple[str, ...]] = ()
    of_structures: ClassVar[tuple[str, ...]] = ()
    save_keys: ClassVar[tuple[str, ...]] = ()
    draw_keys: ClassVar[tuple[str, ...]] = ()
    draw_keys_of_structures: ClassVar[tuple[str, ...]] = ()
    columns: ClassVar[Mapping[str, str]] = {}

    def __init_subclass__(cls) -> None:
        cls.kind = cls.__name__.lower()
        cls.stem = cls.__dict__.get("stem", cls.kind)

    def tables(self) -> dict[str, object]:
        """Return the tables of the question in a study file."""
        keys = as_written(self)
        tables = {table: keys.pop(name) for name, table in TABLES.items() if name in keys}
        tables = {table: own for table, own in tables.items() if own is not None}
        return {**tables, self.kind: keys} if keys else tables

    def arguments(self) -> dict[str, Any]:
        """Return its fields by name, without those that are what its function takes by itself."""
        fields = values_of(self).items()
        return {name: value for name, value in fields if value is not None and value is not AT_REST}

    def csv(self, study: Study) -> Mapping[str, str]:  # noqa: ARG002
        """Return the tables saved as CSV, by the stem of the file."""
        return self.columns

    def pictures(self, study: Study) -> Mapping[str, Picture]:  # noqa: ARG002
        """Return what draws its pictures, by the stem of the file."""
        return {self.stem: self.draw}

    def draw(self, result: Any, study: Study, figure: Any) -> None:
        """Draw the picture that most kinds have on an empty figure."""
        raise NotImplementedError

    def film(self, result: Any, study: Study) -> Film:
        """Return the film of a motion; its file is the only one that may ask for one."""
        raise NotImplementedError

    @abstractmethod
    def answer(self, study: Study, execution: Execution) -> Any:
        """Return the result."""

    @abstractmethod
    def report(self, result: Any) -> dict[str, str]:
        """Return the results in a few lines: words by their names."""

    @abstractmethod
    def checked(self, study: StudyDraft) -> Self:
        """Return the question with what depends on the model, and add its faults there."""


def check_start(start: Start, study: StudyDraft) -> None:
    """Add the faults of a start of an oscillator."""
    is_given = "start" in study.document
    walls = draft(Oscillator, stops=known_walls(study))
    place = "start" if is_given else None
    wrong = start_faults(walls, start.x0, start.v0, start.t0, max_impacts=1, start=place)
    if is_given:
        study.faults.add_from_model(wrong)
    elif wrong:
        study.faults.add(("start",), f"missing; the default x0 = 0 lies {wrong[0].reason}")


def known_walls(study: StudyDraft) -> tuple[Stop, ...]:
    """Return the stops whose place is known: only in these walls can a start lie."""
    return tuple(
        stop
        for index, stop in enumerate(study.oscillator.stops)
        if not any(study.faults.is_wrong(f"oscillator.stops.{index}.{name}") for name in _PLACE)
        and MISSING not in (stop.at, stop.side)
    )


def only_axes(figure: Any, width: float, height: float) -> Any:
    """Return the axes of an empty figure of this size [inch]."""
    figure.set_size_inches(width, height)
    return figure.add_subplot()


def with_unit(value: float, unit: str, digits: int = 10) -> str:
    """Return a number with its unit; dimensions are left out.

    Examples
    --------
    >>> with_unit(0.5, "m/s"), with_unit(0.5, "length/time")
    ('0.5 m/s', '0.5')
    """
    return f"{value:.{digits}g} {unit}" if is_unit(unit) else f"{value:.{digits}g}"


def ends_in_words(extrema: Extrema, units: Units | None, dimensions: str) -> str:
    """Return the least and the largest value of a quantity with their instants."""
    unit, time = in_units(units, dimensions), in_units(units, "time")
    low, high = (with_unit(value, unit) for value in (extrema.minimum, extrema.maximum))
    first, last = (with_unit(t, time) for t in (extrema.t_minimum, extrema.t_maximum))
    return f"{low} at t = {first} to {high} at t = {last}"


def span_in_words(t0: float, t_end: float, units: Units | None) -> str:
    """Return from when to when a run lasts.

    Examples
    --------
    >>> span_in_words(0.0, 30.0, Units("m", "s")), span_in_words(0.0, 30.0, None)
    ('t = 0 to 30 s', 't = 0 to 30')
    """
    return f"t = {t0:.10g} to {with_unit(t_end, in_units(units, 'time'))}"


def multiplier_text(value: complex) -> str:
    """Return a multiplier as a report shows it."""
    return f"{value.real:.6g}" if value.imag == 0.0 else f"{value.real:.6g}{value.imag:+.6g}i"


def intervals_in_words(intervals: Any) -> str:
    """Return intervals of a parameter in words."""
    return ", ".join(_interval_in_words(low, high) for low, high in intervals)


def _interval_in_words(low: float, high: float) -> str:
    """Return both ends with as many digits as tell them apart, six at least."""
    for digits in range(6, 17):
        ends = f"{low:.{digits}g}", f"{high:.{digits}g}"
        if ends[0] != ends[1]:
            return " to ".join(ends)
    return f"{low:.6g}"


def failure_rows(reasons: list[str], n_points: int) -> dict[str, str]:
    """Return how many points have no answer, and why."""
    if not reasons:
        return {}
    from percuss.ensembles.datasets import commonest

    reason, count, others = commonest(reasons)
    more = f"; other reasons: {others}" if others else ""
    words = f"{len(reasons)} of {n_points}: {reason[:LONGEST_REASON]} ({count}){more}"
    return {"without answer": words}


def interruption_rows(data: Dataset) -> dict[str, str]:
    """Return that many motions were interrupted, where they were."""
    words = "interrupted; what was not done is left empty"
    return {} if data.attrs.get("complete", 1) else {"outcome": words}


def ends_of(data: Dataset) -> str:
    """Return the axes of a dataset with their ends."""
    return ", ".join(
        f"{dim} from {float(values.min()):.6g} to {float(values.max()):.6g} ({values.size})"
        for dim, values in ((dim, data[dim].values) for dim in data.coords)
        if values.dtype.kind == "f"
    )


@dataclass(frozen=True, slots=True)
class Study(OneModel):
    """A model, a question about it, and what is kept of the answer.

    Parameters
    ----------
    model, force
        The oscillator and the force on it (None: free), which are also `oscillator` and `forcing`;
        or a structure and its loads.
    question
        The question: a value of `percuss.studies.kinds`, such as `Motion`.
    title
        A line for reports and pictures.
    save, draw
        The files and pictures.
    certify
        The digits to which a motion, an orbit or a branch is proven; None: no proof.

    Examples
    --------
    >>> from percuss.model import Start, impact_oscillator, sine
    >>> from percuss.studies import Limits, Motion
    >>> study = Study(impact_oscillator(), sine(3), Motion(Start(0, "0.51"), Limits(periods=10)))
    >>> study.kind
    'motion'
    """

    model: Oscillator | Structure
    force: Forcing | Loads | None
    question: Question
    title: str = ""
    save: Save = SAVE_ALL
    draw: Draw = DRAW_ALL
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
    certify = {} if study.certify is None else {"certify": as_written(study.certify)}
    return toml_text(
        {
            "study": {"kind": study.kind, "title": study.title},
            **model_tables(study.model, study.force, study.question),
            **_tables_of(study),
            **certify,
            "save": as_written(study.save),
            "draw": as_written(study.draw),
        }
    )


def _tables_of(study: Study) -> dict[str, Any]:
    """Return the tables of the question without the keys that only other models have."""
    question, tables = study.question, study.question.tables()
    is_other = "of_oscillators" if study.structure is not None else "of_structures"
    others: Any = getattr(question, is_other)
    left = {question.kind: others}
    sought = getattr(question, "sought", None)
    if sought is not None:
        left["orbit"] = getattr(sought, is_other)
    names = {TABLES.get(name) for name in others}
    return {
        table: {key: value for key, value in keys.items() if key not in left.get(table, ())}
        for table, keys in cast("dict[str, dict[str, Any]]", tables).items()
        if table not in names
    }


def kind_names() -> list[str]:
    """Return the names of the kinds."""
    return list(_KINDS)


def kind_named(name: str) -> type[Question]:
    """Return the questions of a kind by its name, that of its module and its class."""
    kind: type[Question] = getattr(import_module(f"percuss.studies.kinds.{name}"), name.title())
    return kind
