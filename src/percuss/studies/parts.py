"""What the tables of a study are built with: reading a table, drafting a part, noting faults."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from percuss.errors import ParameterError
from percuss.model.exact import (
    NOT_A_NUMBER,
    NOT_A_PHASE,
    PiTimes,
    angle,
    as_fraction,
    number_problem,
    phase_problem,
)
from percuss.model.faults import Fault, draft
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.studies.faults import shown
from percuss.studies.schema import NO_NUMBER, NO_PHASE
from percuss.studies.shape import Found

__all__ = [
    "MISSING",
    "Parts",
    "Table",
    "add_faults",
    "drafted",
    "exact_phase",
    "rows_of",
    "table_of",
]

Table: TypeAlias = Mapping[str, Any]
Part = TypeVar("Part")

# In place of a key that is missing, which is a fault already.
MISSING: Any = object()
# What the model says, and what it is called in a file.
_REASONS = {NOT_A_NUMBER: NO_NUMBER, NOT_A_PHASE: NO_PHASE}


@dataclass(frozen=True, slots=True)
class Parts:
    """What a question is built from.

    Attributes
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    oscillator, forcing
        The model; drafts where they have faults.
    found
        The faults found so far.
    """

    document: Table
    oscillator: Oscillator
    forcing: Forcing | None
    found: Found

    @property
    def model_is_right(self) -> bool:
        """Whether the model has no faults."""
        return not (self.found.is_wrong("oscillator") or self.found.is_wrong("forcing"))

    def table(self, name: str) -> Table:
        """Return a table, empty where there is none."""
        return table_of(self.document, name)

    def keys(self, name: str) -> dict[str, Any]:
        """Return the keys of a table that have no fault."""
        table = self.table(name)
        return {key: value for key, value in table.items()
                if not self.found.is_wrong(f"{name}.{key}")}  # fmt: skip

    def refuse(self, name: str, error: ParameterError) -> None:
        """Note what is wrong with a key."""
        self.found.add(tuple(name.split(".")), error.reason, shown(error.value))

    def needs_period(self, why: str) -> None:
        """Note a forcing without a period, where one is needed."""
        if self.found.is_wrong("forcing"):
            return
        if self.forcing is None or not self.forcing.harmonics:
            self.found.add(("forcing",), f"missing harmonics; {why}")
        elif self.forcing.period is None:
            self.found.add(("forcing", "period"), f"missing; {why}")


def table_of(document: Table, name: str) -> Table:
    """Return a table of a document, empty where there is none."""
    table = document.get(name, {})
    return table if isinstance(table, Mapping) else {}


def rows_of(table: Table, name: str) -> list[Any]:
    """Return a list in a table, empty where there is none."""
    rows = table.get(name, [])
    return rows if isinstance(rows, list) else []


def drafted(kind: type[Part], table: Any, defaults: Table) -> Part:
    """Return a part of the model from the keys of a table that it has, not checked."""
    given = table if isinstance(table, Mapping) else {}
    return draft(kind, **{name: given.get(name, value) for name, value in defaults.items()})


def add_faults(wrong: Iterable[Fault], found: Found) -> None:
    """Add the faults that the model found."""
    for fault in wrong:
        if fault.value is MISSING:
            continue
        path = tuple(int(part) if part.isdecimal() else part for part in fault.name.split("."))
        found.add(path, _REASONS.get(fault.reason, fault.reason), shown(fault.value))


def reason_in_file(reason: str) -> str:
    """Return what the model says of a value in the words of a file."""
    return _REASONS.get(reason, reason)


def exact_phase(value: Any) -> Any:
    """Return ``"pi/2 + 1/3"`` as the exact phase it means; anything else unchanged.

    Examples
    --------
    >>> exact_phase("-pi/2 + 0.25"), exact_phase("pi/2")
    (pi_times(-1, 2) + 0.25, 'pi/2')
    """
    if not isinstance(value, str) or value.count("+") != 1 or "pi" not in value:
        return value
    multiple, _, rest = value.partition("+")
    if phase_problem(multiple) is not None or number_problem(rest) is not None:
        return value
    times, _ = angle(multiple)
    return PiTimes(times, as_fraction(rest))
