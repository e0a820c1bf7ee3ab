"""What every kind of study has to say about itself: the one place where kinds meet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias

from percuss.model.faults import draft
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, start_faults
from percuss.model.stops import Stop
from percuss.progress import Report
from percuss.studies.faults import MISSING, StudyFaults
from percuss.studies.tables import (
    Certify,
    Draw,
    RawTable,
    StartTable,
    as_written,
    keys_of,
    raw_table,
    read,
    values_of,
)

if TYPE_CHECKING:
    from percuss.studies.study import Study

__all__ = ["AT_REST", "Execution", "Picture", "Question", "StudyDraft", "check_start",
           "known_walls", "read_question", "table_keys", "table_names", "titled_axes"]  # fmt: skip

# Draws a result of a study on an empty figure.
Picture: TypeAlias = "Callable[[Any, Study, Any], None]"

AT_REST = Start(0.0, 0.0)
# Fields of questions that are tables of their own in a file, in its order; the other fields stand
# in the table of the kind.
TABLES = {"start": "start", "limits": "run", "sought": "orbit", "over": "over", "steps": "branch"}
_PLACE = ("at", "side")


@dataclass(frozen=True, slots=True)
class Execution:
    """How a study is run, which changes nothing about its answer.

    Attributes
    ----------
    store
        Folder of a Zarr store that a long run goes into and is resumed from; or None.
    engine
        "threads", "processes" or the address of a Dask scheduler.
    progress
        As in `percuss.simulate`.
    """

    store: Path | None = None
    engine: str = "threads"
    progress: Report = None

    def of_ensemble(self) -> dict[str, Any]:
        """Return it as ensembles take it."""
        return {"store": self.store, "engine": self.engine, "progress": self.progress}


@dataclass(frozen=True, slots=True)
class StudyDraft:
    """A study while its file is read: what a question is checked against.

    Attributes
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    oscillator, forcing
        The model; drafts where they have faults.
    draw
        What is drawn.
    faults
        The faults found so far.
    """

    document: RawTable
    oscillator: Oscillator
    forcing: Forcing | None
    draw: Draw
    faults: StudyFaults

    @property
    def has_right_model(self) -> bool:
        """Whether the model has no faults."""
        return not (self.faults.is_wrong("oscillator") or self.faults.is_wrong("forcing"))

    def needs_period(self, why: str) -> None:
        """Add a forcing without a period, where one is needed."""
        if self.faults.is_wrong("forcing"):
            return
        if self.forcing is None or not self.forcing.harmonics:
            self.faults.add(("forcing",), f"missing harmonics; {why}")
        elif self.forcing.period is None:
            self.faults.add(("forcing", "period"), f"missing; {why}")


class Question(ABC):
    """What a study asks, with all it needs besides the model: a frozen table.

    Its fields are the keys of its file and the arguments of the library function that answers it.

    Attributes
    ----------
    kind
        Its name in ``[study]``.
    doing
        What is being done while it is answered, before a bar.
    stem
        Name of the NetCDF file, without suffix.
    is_ensemble
        Whether it is answered chunk by chunk, into a store and on an engine where wanted.
    is_certifiable
        Whether its file may ask for a proof.
    needed
        Tables without which there is no such file.
    save_keys, draw_keys
        Keys of ``[save]`` and ``[draw]`` beyond those of all kinds.
    columns
        The tables saved as CSV, by the stem of the file.
    """

    __slots__ = ()

    kind: ClassVar[str]
    doing: ClassVar[str]
    stem: ClassVar[str]
    is_ensemble: ClassVar[bool] = False
    is_certifiable: ClassVar[bool] = False
    needed: ClassVar[tuple[str, ...]] = ()
    save_keys: ClassVar[tuple[str, ...]] = ()
    draw_keys: ClassVar[tuple[str, ...]] = ()
    columns: ClassVar[Mapping[str, str]] = {}

    def tables(self) -> dict[str, object]:
        """Return the tables of its own in a study file."""
        keys = as_written(self)
        tables = {table: keys.pop(name) for name, table in TABLES.items() if name in keys}
        return {**tables, self.kind: keys} if keys else tables

    def arguments(self) -> dict[str, Any]:
        """Return its fields by name."""
        return values_of(self)

    def csv(self, study: Study) -> Mapping[str, str]:  # noqa: ARG002
        """Return the tables saved as CSV, by the stem of the file."""
        return self.columns

    @abstractmethod
    def pictures(self, study: Study) -> Mapping[str, Picture]:
        """Return what draws its pictures, by the stem of the file."""

    @abstractmethod
    def answer(self, study: Study, execution: Execution) -> Any:
        """Return the result."""

    @abstractmethod
    def report(self, result: Any) -> dict[str, str]:
        """Return what was found, in a few lines: words by what they are about."""

    @abstractmethod
    def checked(self, study: StudyDraft) -> Self:
        """Return the question as it is asked of a model, and add what is wrong with it there."""


def table_names(kind: type[Question]) -> list[str]:
    """Return the tables of the files of a kind besides those of all kinds."""
    fields = keys_of(kind)
    own = [kind.kind] if set(fields) - set(TABLES) else []
    proof = ["certify"] if kind.is_certifiable else []
    return [*(TABLES[name] for name in TABLES if name in fields), *own, *proof]


def table_keys(kind: type[Question], name: str) -> list[str]:
    """Return the keys of a table of the files of a kind; of ``[over]`` they are its paths."""
    if name == "certify":
        return keys_of(Certify)
    fields = kind.__pydantic_fields__  # type: ignore[attr-defined]
    own = [field for field in fields if field not in TABLES]
    if name == kind.kind and own:
        return own
    (field,) = (field for field, table in TABLES.items() if table == name)
    shape = StartTable if name == "start" else fields[field].annotation
    return [] if name == "over" else keys_of(shape)


def read_question(kind: type[Question], document: RawTable, faults: StudyFaults) -> Question:
    """Return the question of a document, and add what is wrong with its shape."""
    given: dict[str, Any] = {}
    for name, field in kind.__pydantic_fields__.items():  # type: ignore[attr-defined]
        table = TABLES.get(name)
        if table is None or (table not in document and not field.is_required()):
            continue
        raw = raw_table(document, table)
        shape = StartTable if name == "start" else field.annotation
        # What the ranges and axes in [over] may be is a question to the model.
        value = dict(raw) if name == "over" else read(shape, raw, faults, (table,))
        given[name] = draft(Start, **values_of(value)) if name == "start" else value
    own = raw_table(document, kind.kind)
    known = [name for name in keys_of(kind) if name not in TABLES]
    return read(kind, own if known else {}, faults, (kind.kind,), known, given)


def check_start(start: Start, study: StudyDraft) -> None:
    """Add what is wrong with a start without a limit of its own."""
    is_given = "start" in study.document
    walls = draft(Oscillator, stops=known_walls(study))
    place = "start" if is_given else None
    wrong = start_faults(walls, start.x0, start.v0, start.t0, max_impacts=1, start=place)
    if is_given:
        study.faults.add_from_model(wrong)
    elif wrong:
        study.faults.add(("start",), f"missing; the default x0 = 0 lies {wrong[0].reason}")


def known_walls(study: StudyDraft) -> tuple[Stop, ...]:
    """Return the stops whose place is known: only in such a wall can a start be."""
    return tuple(
        stop
        for index, stop in enumerate(study.oscillator.stops)
        if not any(study.faults.is_wrong(f"oscillator.stops.{index}.{name}") for name in _PLACE)
        and MISSING not in (stop.at, stop.side)
    )


def titled_axes(study: Study, figure: Any, width: float, height: float) -> Any:
    """Return the axes of an empty figure of this size [inch], with the title of a study."""
    figure.set_size_inches(width, height)
    figure.suptitle(study.title, parse_math=False)
    return figure.add_subplot()
