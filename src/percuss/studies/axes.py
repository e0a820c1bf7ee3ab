"""Parameters and where they go: the ranges and the values of a study."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Any, Literal, TypeAlias

from pydantic import ValidationError

from percuss.ensembles.job import too_large
from percuss.errors import ParameterError
from percuss.io.study_text import number
from percuss.model.exact import Phase, PiTimes, angle, as_float, phase_problem
from percuss.model.paths import get_parameter, long_form, replace_parameter
from percuss.model.start import Start
from percuss.numerics import exp, log
from percuss.studies.faults import shown
from percuss.studies.lines import Path
from percuss.studies.parts import Parts, exact_phase, reason_in_file
from percuss.studies.schema import Phase as PhaseShape
from percuss.studies.schema import Table
from percuss.studies.shape import unknown_key

__all__ = ["Axis", "Range", "Span", "axes_table", "axis_of", "axis_table", "axis_values", "own_axes", "ranges_of",
           "values_of"]  # fmt: skip

Spacing: TypeAlias = Literal["linear", "log"]
Range: TypeAlias = tuple[Phase, Phase]
MOST = 100_000_000
# Where faults leave it open no more which parameters the model has: in the values of keys.
LEAF = re.compile(
    r"oscillator\.((?!stop)\w+|stops\.\d+\.(?!type)\w+)"
    r"|forcing\.(constant|period|harmonics\.\d+\.\w+|(cos|sin)\.\d+)"
)


class SpanTable(Table):
    """``{from = 2, to = 3, count = 101}``."""

    to: PhaseShape
    count: int
    spacing: Spacing = "linear"


@dataclass(frozen=True, slots=True)
class Span:
    """Equally spaced values.

    Parameters
    ----------
    first, last
        The ends, both included.
    count
        How many values.
    spacing
        "linear": equal differences, exactly; "log": equal quotients.

    Examples
    --------
    >>> [str(value) for value in Span("0", "1", 3).values()]
    ['0', '1/2', '1']
    """

    first: Phase
    last: Phase
    count: int
    spacing: Spacing = "linear"

    def values(self) -> tuple[Phase, ...]:
        """Return the values; each is rounded once, when it becomes a float."""
        if self.spacing == "log":
            first, last = as_float(self.first), as_float(self.last)
            ratio = log(last / first) / (self.count - 1)
            inner = [first * exp(i * ratio) for i in range(1, self.count - 1)]
            return (self.first, *inner, self.last)
        (times, plus), (times_to, plus_to) = angle(self.first), angle(self.last)
        found: list[Phase] = []
        for i in range(self.count):
            part = Fraction(i, self.count - 1)
            turns, rest = times + part * (times_to - times), plus + part * (plus_to - plus)
            found.append(PiTimes(turns, rest) if turns else rest)
        return (self.first, *found[1:-1], self.last)


# A list of values as it was given, or a span.
Axis: TypeAlias = tuple[Phase, ...] | Span


def axis_values(axis: Axis) -> tuple[Phase, ...]:
    """Return the values of an axis."""
    return axis.values() if isinstance(axis, Span) else axis


def axis_table(axis: Axis | Range) -> object:
    """Return an axis as a study file holds it."""
    if not isinstance(axis, Span):
        return [number(value) for value in axis]
    table = {"from": number(axis.first), "to": number(axis.last), "count": axis.count}
    return table if axis.spacing == "linear" else {**table, "spacing": axis.spacing}


def axes_table(axes: Mapping[str, Axis] | Mapping[str, Range]) -> dict[str, object]:
    """Return axes as an ``[over]`` table."""
    return {path: axis_table(axis) for path, axis in axes.items()}


def ranges_of(parts: Parts, count: int, *, holds_own: bool = False) -> dict[str, Range]:
    """Return the ranges of ``[over]``, and add what is wrong with them.

    Parameters
    ----------
    parts
        The document and its model.
    count
        How many parameters there are to be.
    holds_own
        Whether the value of the model itself has to lie in the range.

    Returns
    -------
    dict
        First and last value by path; those without faults.
    """
    found: dict[str, Range] = {}
    for path, place, given in _counted(parts, count):
        if not isinstance(given, list) or len(given) != 2:
            reason = "not a range; write [first, last]"
            parts.found.add(place, reason, shown(given))
            continue
        ends = [exact_phase(end) for end in given]
        if not _numbers_are_right(parts, place, ends) or not _is_known(parts, path, place, None):
            continue
        if as_float(ends[0]) == as_float(ends[1]):
            parts.found.add(place, "an empty range", shown(given))
            continue
        if not _fit(parts, path, [(*place, 0), (*place, 1)], ends, None):
            continue
        own = as_float(get_parameter(parts.oscillator, parts.forcing, None, path))
        low, high = sorted(as_float(end) for end in ends)
        if holds_own and not low <= own <= high:
            reason = f"does not hold the model's own value {own:.12g}, where the branch begins"
            parts.found.add(place, reason, shown(given))
            continue
        found[path] = ends[0], ends[1]
    return found


def values_of(parts: Parts, count: int | None, start: Start | None) -> dict[str, Axis]:
    """Return the axes of ``[over]``, and add what is wrong with them.

    Parameters
    ----------
    parts
        The document and its model.
    count
        How many parameters there are to be; None for any number from one on.
    start
        The start, whose numbers may be among them.

    Returns
    -------
    dict
        The axes by path; those without faults.
    """
    found: dict[str, Axis] = {}
    entries = list(_counted(parts, count))
    axes = [axis_of(parts, place, given) for _, place, given in entries]
    if _is_too_large(parts, ("over",), axes):
        return found
    for (path, place, _), axis in zip(entries, axes, strict=True):
        if axis is None or not _is_known(parts, path, place, start):
            continue
        # With several axes a value may be right in some combinations: the sweep tells which.
        values = axis_values(axis)
        # The values of a span have no places of their own in the file.
        places = [place if isinstance(axis, Span) else (*place, i) for i in range(len(values))]
        if len(entries) == 1 and not _fit(parts, path, places, values, start):
            continue
        found[path] = axis
    return found


def own_axes(parts: Parts, table: str, names: tuple[str, ...]) -> dict[str, Axis]:
    """Return the axes that a table has under these keys, and add what is wrong with them."""
    given = parts.keys(table)
    axes = {name: axis_of(parts, (table, name), given[name]) for name in names if name in given}
    if _is_too_large(parts, (table,), list(axes.values())):
        return {}
    return {name: axis for name, axis in axes.items() if axis is not None}


def _is_too_large(parts: Parts, place: Path, axes: Sequence[Axis | None]) -> bool:
    """Tell whether all combinations are too many for this machine; note it if so."""
    counts = [
        1 if axis is None else axis.count if isinstance(axis, Span) else len(axis) for axis in axes
    ]
    # Whether there is a store is not known yet: what neither memory nor the disk holds is a fault.
    problem = too_large(counts, store=FilePath.cwd())
    if problem is not None:
        parts.found.add(place, problem, " x ".join(f"{count:,}" for count in counts))
    return problem is not None


def axis_of(parts: Parts, place: Path, given: Any) -> Axis | None:
    """Return an axis, None if it has faults."""
    if isinstance(given, Mapping):
        return _span(parts, place, given)
    if not isinstance(given, list):
        reason = "neither a list of values nor {from = 2, to = 3, count = 101}"
        parts.found.add(place, reason, shown(given))
        return None
    if not given:
        parts.found.add(place, "an axis without values", "[]")
        return None
    values = [exact_phase(value) for value in given]
    return tuple(values) if _numbers_are_right(parts, place, values) else None


def _span(parts: Parts, place: Path, given: Mapping[str, Any]) -> Span | None:
    rest = {key: value for key, value in given.items() if key != "from"}
    known = ["from", "to", "count", "spacing"]
    for key in given:
        if key not in known:
            parts.found.add((*place, key), unknown_key(key, known))
    for key in ("from", "to", "count"):
        if key not in given:
            parts.found.add((*place, key), "missing; write {from = 2, to = 3, count = 101}")
    try:
        SpanTable.model_validate({k: v for k, v in rest.items() if k in known})
    except ValidationError as error:
        for detail in error.errors(include_url=False):
            name = str(detail["loc"][0])
            if name in given:
                words = {"count": "not a whole number", "spacing": 'neither "linear" nor "log"'}
                reason = words.get(name, str(detail["msg"]))
                parts.found.add((*place, name), reason, shown(given[name]))
    if parts.found.is_wrong(".".join(map(str, place))):
        return None
    ends = {key: exact_phase(given[key]) for key in ("from", "to")}
    for key, end in ends.items():
        problem = phase_problem(end)
        if problem is not None:
            parts.found.add((*place, key), reason_in_file(problem), shown(given[key]))
    spacing = given.get("spacing", "linear")
    if not 2 <= given["count"] <= MOST:
        parts.found.add((*place, "count"), f"not from 2 to {MOST}", shown(given["count"]))
    if parts.found.is_wrong(".".join(map(str, place))):
        return None
    if as_float(ends["from"]) == as_float(ends["to"]):
        parts.found.add(place, "an empty range: from and to are the same")
        return None
    if spacing == "log" and not all(as_float(end) > 0.0 for end in ends.values()):
        parts.found.add((*place, "spacing"), "of values that are not all positive", '"log"')
        return None
    return Span(ends["from"], ends["to"], given["count"], spacing)


def _counted(parts: Parts, count: int | None) -> Iterator[tuple[str, Path, Any]]:
    """Give path, place and value of each entry of ``[over]``; see to it that they are so many."""
    entries = list(_entries(("over",), parts.table("over")))
    if "over" in parts.document and not parts.found.is_wrong("over"):
        wanted = {1: "one is needed", 2: "two are needed", None: "at least one is needed"}[count]
        if (count is not None and len(entries) != count) or not entries:
            given = "1 parameter" if len(entries) == 1 else f"{len(entries)} parameters"
            parts.found.add(("over",), f"{given}; {wanted}")
            return
    yield from entries


def _entries(place: Path, table: Mapping[str, Any]) -> Iterator[tuple[str, Path, Any]]:
    """Give the entries of a table, those of the tables that paths without quotes make too."""
    for key, value in table.items():
        inner = (*place, key)
        if isinstance(value, Mapping) and not {"from", "to", "count"} & set(value):
            yield from _entries(inner, value)
        else:
            yield ".".join(map(str, inner[1:])), inner, value


def _numbers_are_right(parts: Parts, place: Path, values: list[Any]) -> bool:
    for index, value in enumerate(values):
        problem = "not a number" if isinstance(value, bool) else phase_problem(value)
        if problem is not None:
            parts.found.add((*place, index), reason_in_file(problem), shown(value))
    return not parts.found.is_wrong(".".join(map(str, place)))


def _is_known(parts: Parts, path: str, place: Path, start: Start | None) -> bool:
    """Tell whether there is such a parameter, of a model that is right; note it if not."""
    if not all(LEAF.fullmatch(fault) for fault in _of_model(parts)):
        return False
    try:
        long_form(path, parts.oscillator, parts.forcing, start)
    except ParameterError as error:
        parts.found.add(place, error.reason)
        return False
    return parts.model_is_right


def _of_model(parts: Parts) -> list[str]:
    """Return the paths of the faults of the model."""
    owners = ("oscillator", "forcing")
    return [it.path for it in parts.found.faults if it.path.split(".")[0] in owners]


def _fit(
    parts: Parts,
    path: str,
    places: Sequence[Path],
    values: Sequence[Phase],
    start: Start | None,
) -> bool:
    """Tell whether the model can take values; note the first one that it cannot."""
    for place, value in zip(places, values, strict=True):
        try:
            replace_parameter(parts.oscillator, parts.forcing, start, path, value)
        except ParameterError as error:
            parts.found.add(place, reason_in_file(error.reason), shown(number(value)))
            return False
    return True
