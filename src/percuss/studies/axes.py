"""The axes of a study: parameters with their ranges or values."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema

from percuss.ensembles.job import too_large
from percuss.errors import ParameterError
from percuss.io.study_text import number
from percuss.model.exact import Phase, PiTimes, angle, as_float, number_problem, phase_problem
from percuss.model.paths import get_parameter, long_form, replace_parameter
from percuss.model.start import Start
from percuss.model.structure_start import StructureStart
from percuss.numerics import exp, log
from percuss.studies.study import StudyDraft
from percuss.studies.tables import (
    NO_PHASE,
    NUMBER_SCHEMA,
    Path,
    exact_phase,
    raw_table,
    shown,
    table_only,
    unknown_key,
    words_of_file,
)
from percuss.wording import counted

Spacing: TypeAlias = Literal["linear", "log"]
ParameterRange: TypeAlias = tuple[Phase, Phase]
MOST = 100_000_000
# Keys of the model whose faults concern a value only: the parameters of the model are known.
LEAF = re.compile(
    r"oscillator\.((?!stop)\w+|stops\.\d+\.(?!type)\w+)"
    r"|(forcing|loads\.\d+)"
    r"\.(constant|period|harmonics\.\d+\.\w+|record\.(amplitude|omega)|(cos|sin)\.\d+)"
    r"|structure\.(stops\.\d+\.(?!type|on)\w+|(mass|stiffness|damping)\.\d+\.\d+)"
)


@dataclass(frozen=True, slots=True)
class Span:
    """Equally spaced values.

    Parameters
    ----------
    first, last
        The ends, both included.
    count
        Number of values.
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
        values: list[Phase] = []
        for i in range(self.count):
            part = Fraction(i, self.count - 1)
            turns, rest = times + part * (times_to - times), plus + part * (plus_to - plus)
            values.append(PiTimes(turns, rest) if turns else rest)
        return (self.first, *values[1:-1], self.last)


# A list of values as it was given, or a span.
AxisValues: TypeAlias = tuple[Phase, ...] | Span


def axis_values(axis: AxisValues) -> tuple[Phase, ...]:
    """Return the values of an axis."""
    return axis.values() if isinstance(axis, Span) else axis


def over_of(over: Mapping[str, AxisValues]) -> dict[Any, list[Phase]]:
    """Return axes as the keyword ``over`` takes them, directions as tuples."""
    return {direction_of(path) or path: list(axis_values(axis)) for path, axis in over.items()}


def direction_of(path: str) -> tuple[Any, ...] | None:
    """Return the direction of starts that the key of an axis is; None where it is a path.

    Examples
    --------
    >>> direction_of("[1, 0, 0.5, 0]"), direction_of("start.x0.0")
    ((1, 0, 0.5, 0), None)
    """
    if not path.startswith("["):
        return None
    try:
        return tuple(tomllib.loads(f"direction = {path}")["direction"])
    except tomllib.TOMLDecodeError:
        return (path,)


def _axis_table(axis: AxisValues | ParameterRange | None) -> object:
    """Return an axis as a study file holds it."""
    if axis is None:
        return None
    if not isinstance(axis, Span):
        return [number(value) for value in axis]
    table = {"from": number(axis.first), "to": number(axis.last), "count": axis.count}
    return table if axis.spacing == "linear" else {**table, "spacing": axis.spacing}


def _axes_table(axes: Mapping[str, AxisValues] | Mapping[str, ParameterRange]) -> dict[str, object]:
    return {path: _axis_table(axis) for path, axis in axes.items()}


VALUES_SCHEMA: dict[str, Any] = {"type": "array", "items": NUMBER_SCHEMA, "minItems": 1}
SPAN_SCHEMA: dict[str, Any] = {
    "type": "object",
    "additionalProperties": False,
    "required": ["from", "to", "count"],
    "properties": {
        "from": NUMBER_SCHEMA,
        "to": NUMBER_SCHEMA,
        "count": {"type": "integer", "minimum": 2, "maximum": MOST},
        "spacing": {"enum": ["linear", "log"]},
    },
}
AXIS_SCHEMA: dict[str, Any] = {"anyOf": [VALUES_SCHEMA, SPAN_SCHEMA]}
# A path without quotes makes tables in tables.
INNER_SCHEMA: dict[str, Any] = {
    "type": "object",
    "not": {"anyOf": [{"required": [key]} for key in ("from", "to", "count")]},
}
OVER_SCHEMA: dict[str, Any] = {
    "type": "object",
    "additionalProperties": {"anyOf": [VALUES_SCHEMA, SPAN_SCHEMA, INNER_SCHEMA]},
}
RANGES_SCHEMA: dict[str, Any] = {
    "type": "object",
    "additionalProperties": {
        "anyOf": [{**VALUES_SCHEMA, "minItems": 2, "maxItems": 2}, INNER_SCHEMA]
    },
}
# Fields of questions; the values of the file become axes once the model is known.
OverAxes = Annotated[
    dict[str, AxisValues],
    PlainValidator(table_only),
    PlainSerializer(_axes_table),
    WithJsonSchema(OVER_SCHEMA),
]
OverRanges = Annotated[
    dict[str, ParameterRange],
    PlainValidator(table_only),
    PlainSerializer(_axes_table),
    WithJsonSchema(RANGES_SCHEMA),
]
StartAxis = Annotated[
    AxisValues | None,
    PlainValidator(lambda axis: axis),
    PlainSerializer(_axis_table),
    WithJsonSchema(AXIS_SCHEMA),
]


def ranges_over(
    study: StudyDraft, count: int, *, holds_own: bool = False
) -> dict[str, ParameterRange]:
    """Return the ranges of ``[over]``, and add their faults.

    Parameters
    ----------
    study
        The document and its model.
    count
        Required number of parameters.
    holds_own
        Whether the value of the model has to lie in the range.

    Returns
    -------
    dict
        First and last value by path; those without faults.
    """
    ranges: dict[str, ParameterRange] = {}
    for path, place, given in _counted(study, count):
        ends = _range(study, path, place, given, None)
        if ends is None:
            continue
        own = as_float(get_parameter(study.model, study.force, None, path))
        low, high = sorted(as_float(end) for end in ends)
        if holds_own and not low <= own <= high:
            reason = f"does not hold the model's own value {own:.12g}, where the branch begins"
            study.faults.add(place, reason, shown(given))
            continue
        ranges[path] = ends
    return ranges


def ranges_in(
    study: StudyDraft, place: Path, start: Start | StructureStart | None
) -> dict[str, ParameterRange]:
    """Return the ranges, from least to largest, of a table inside a table; add their faults.

    Parameters
    ----------
    study
        The document and its model.
    place
        The table, which `study.document` has.
    start
        The start, whose numbers may be parameters; None: they may not.
    """
    ranges: dict[str, ParameterRange] = {}
    names: dict[str, str] = {}
    table = raw_table(raw_table(study.document, str(place[0])), str(place[1]))
    for path, entry, given in _entries(place, table, len(place)):
        ends = _range(study, path, entry, given, start)
        if ends is None:
            continue
        if as_float(ends[0]) > as_float(ends[1]):
            study.faults.add(entry, "the least is above the largest", shown(given))
            continue
        _note_parameter(study, path, entry, start, names)
        ranges[path] = ends
    return ranges


def _note_parameter(
    study: StudyDraft,
    path: str,
    entry: Path,
    start: Start | StructureStart | None,
    names: dict[str, str],
) -> None:
    """Note a parameter by its long form, and add the fault of one that has been named before."""
    name = long_form(path, study.model, study.force, start)
    if name in names:
        study.faults.add(entry, f"the same parameter as {names[name]}")
    names[name] = path


def guesses_in(
    study: StudyDraft, place: Path, start: Start | StructureStart | None
) -> dict[str, Phase | ParameterRange]:
    """Return guesses and ranges of a table inside a table; add their faults.

    Parameters
    ----------
    study, place, start
        As in `ranges_in`.
    """
    guesses: dict[str, Phase | ParameterRange] = {}
    table = raw_table(raw_table(study.document, str(place[0])), str(place[1]))
    names: dict[str, str] = {}
    for path, entry, given in _entries(place, table, len(place)):
        if path.startswith("start.") and start is None:
            reason = "of a start that is unknown as a whole; give it in [start]"
            study.faults.add(entry, reason)
            continue
        ends: Phase | ParameterRange | None
        if isinstance(given, list):
            ends = pair = _range(study, path, entry, given, start)
            if pair is not None and as_float(pair[0]) > as_float(pair[1]):
                study.faults.add(entry, "the least is above the largest", shown(given))
        else:
            ends = _guess(study, path, entry, given, start)
        if ends is None:
            continue
        _note_parameter(study, path, entry, start, names)
        guesses[path] = ends
    return guesses


def _guess(
    study: StudyDraft, path: str, place: Path, given: Any, start: Start | StructureStart | None
) -> Phase | None:
    """Return a guess, None if it has faults; add these."""
    value = exact_phase(given)
    problem = "not a number" if isinstance(value, bool) else phase_problem(value)
    if problem is not None:
        reason = f"{words_of_file(problem)}; or a range, [least, largest]"
        study.faults.add(place, reason, shown(given))
        return None
    own = start if path.startswith("start.") else None
    is_right = _is_known(study, path, place, start) and _fit(study, path, [place], [value], own)
    return value if is_right else None


def _range(
    study: StudyDraft, path: str, place: Path, given: Any, start: Start | StructureStart | None
) -> ParameterRange | None:
    """Return the ends of a range, None if it has faults; add these."""
    if not isinstance(given, list) or len(given) != 2:
        study.faults.add(place, "not a range; write [first, last]", shown(given))
        return None
    ends = [exact_phase(end) for end in given]
    if not _numbers_are_right(study, place, ends) or not _is_known(study, path, place, start):
        return None
    if as_float(ends[0]) == as_float(ends[1]):
        study.faults.add(place, "an empty range", shown(given))
        return None
    # A stop may be moved over the start where the start moves, too.
    own = start if path.startswith("start.") else None
    places = [(*place, 0), (*place, 1)]
    return (ends[0], ends[1]) if _fit(study, path, places, ends, own) else None


def values_over(
    study: StudyDraft,
    count: int | None,
    start: Start | StructureStart | None,
    *,
    paired: bool = False,
) -> dict[str, AxisValues]:
    """Return the axes of ``[over]``, and add their faults.

    Parameters
    ----------
    study
        The document and its model.
    count
        Required number of parameters; None: at least one.
    start
        The start, whose numbers may be parameters.
    paired
        Whether their values are taken together, each axis with as many.

    Returns
    -------
    dict
        The axes by path; those without faults.
    """
    right: dict[str, AxisValues] = {}
    entries = list(_counted(study, count))
    axes = [_axis_of(study, place, given) for _, place, given in entries]
    if _is_too_large(study, ("over",), axes[:1] if paired else axes):
        return right
    if paired:
        _check_pairs(study, entries, axes)
    for (path, place, _), axis in zip(entries, axes, strict=True):
        if axis is None or not _is_known(study, path, place, start):
            continue
        # With several axes a value may be right in some combinations; the sweep shows which.
        values = axis_values(axis)
        # The values of a span have no places of their own in the file.
        places = [place if isinstance(axis, Span) else (*place, i) for i in range(len(values))]
        is_path = direction_of(path) is None
        if is_path and len(entries) == 1 and not _fit(study, path, places, values, start):
            continue
        right[path] = axis
    return right


def _check_pairs(
    study: StudyDraft,
    entries: Sequence[tuple[str, Path, Any]],
    axes: Sequence[AxisValues | None],
) -> None:
    """Add the faults of axes that have not as many values as the first."""
    counts = [_count_of(axis) for axis in axes]
    for (_, place, _), axis, count in zip(entries, axes, counts, strict=True):
        if axis is not None and axes[0] is not None and count != counts[0]:
            reason = (
                f"{counted(count, 'value')}, and {entries[0][0]} has {counts[0]}; "
                "paired, each has as many"
            )
            study.faults.add(place, reason)


def _count_of(axis: AxisValues | None) -> int:
    """Return the number of values of an axis, 1 where it has faults."""
    return 1 if axis is None else axis.count if isinstance(axis, Span) else len(axis)


def axes_of(study: StudyDraft, table: str, given: Mapping[str, Any]) -> dict[str, AxisValues]:
    """Return the axes under keys of a table, and add their faults."""
    axes = {name: _axis_of(study, (table, name), raw) for name, raw in given.items()}
    if _is_too_large(study, (table,), list(axes.values())):
        return {}
    return {name: axis for name, axis in axes.items() if axis is not None}


def _is_too_large(study: StudyDraft, place: Path, axes: Sequence[AxisValues | None]) -> bool:
    """Return whether the grid is too large for this machine, and add that fault."""
    counts = [_count_of(axis) for axis in axes]
    # A store may be given later: the fault is a grid that neither memory nor the disk holds.
    problem = too_large(counts, store=FilePath.cwd())
    if problem is not None:
        study.faults.add(place, problem, " x ".join(f"{count:,}" for count in counts))
    return problem is not None


def _axis_of(study: StudyDraft, place: Path, given: Any) -> AxisValues | None:
    """Return an axis, None if it has faults; add these."""
    if isinstance(given, Mapping):
        return _span(study, place, given)
    if not isinstance(given, list):
        reason = "neither a list of values nor {from = 2, to = 3, count = 101}"
        study.faults.add(place, reason, shown(given))
        return None
    if not given:
        study.faults.add(place, "an axis without values", "[]")
        return None
    values = [exact_phase(value) for value in given]
    return tuple(values) if _numbers_are_right(study, place, values) else None


def _span(study: StudyDraft, place: Path, given: Mapping[str, Any]) -> Span | None:
    known = ["from", "to", "count", "spacing"]
    for key in given:
        if key not in known:
            study.faults.add((*place, key), unknown_key(key, known))
    for key in ("from", "to", "count"):
        if key not in given:
            study.faults.add((*place, key), "missing; write {from = 2, to = 3, count = 101}")
    ends = {key: exact_phase(given[key]) for key in ("from", "to") if key in given}
    for key, end in ends.items():
        problem = NO_PHASE if isinstance(end, bool) else phase_problem(end)
        if problem is not None:
            study.faults.add((*place, key), words_of_file(problem), shown(given[key]))
    count, spacing = given.get("count", 2), given.get("spacing", "linear")
    if isinstance(count, bool) or not isinstance(count, int):
        study.faults.add((*place, "count"), "not a whole number", shown(count))
    elif not 2 <= count <= MOST:
        study.faults.add((*place, "count"), f"not from 2 to {MOST}", shown(count))
    if spacing not in ("linear", "log"):
        study.faults.add((*place, "spacing"), 'neither "linear" nor "log"', shown(spacing))
    if study.faults.is_wrong(".".join(map(str, place))):
        return None
    if as_float(ends["from"]) == as_float(ends["to"]):
        study.faults.add(place, "an empty range: from and to are the same")
        return None
    if spacing == "log" and not all(as_float(end) > 0.0 for end in ends.values()):
        study.faults.add((*place, "spacing"), "of values that are not all positive", '"log"')
        return None
    return Span(ends["from"], ends["to"], count, spacing)


def _counted(study: StudyDraft, count: int | None) -> Iterator[tuple[str, Path, Any]]:
    """Yield path, place and value of each entry of ``[over]``; add the fault of a wrong number."""
    entries = list(_entries(("over",), raw_table(study.document, "over"), 1))
    if "over" in study.document and not study.faults.is_wrong("over"):
        wanted = {1: "one is needed", 2: "two are needed", None: "at least one is needed"}[count]
        if (count is not None and len(entries) != count) or not entries:
            study.faults.add(("over",), f"{counted(len(entries), 'parameter')}; {wanted}")
            return
    yield from entries


def _entries(place: Path, table: Mapping[str, Any], above: int) -> Iterator[tuple[str, Path, Any]]:
    """Yield the entries of a table, and of the inner tables that unquoted paths make.

    The first keys of the place, as many as `above`, are those of the table itself.
    """
    for key, value in table.items():
        inner = (*place, key)
        if isinstance(value, Mapping) and value and not {"from", "to", "count"} & set(value):
            yield from _entries(inner, value, above)
        else:
            yield ".".join(map(str, inner[above:])), inner, value


def _numbers_are_right(study: StudyDraft, place: Path, values: list[Any]) -> bool:
    for index, value in enumerate(values):
        problem = "not a number" if isinstance(value, bool) else phase_problem(value)
        if problem is not None:
            study.faults.add((*place, index), words_of_file(problem), shown(value))
    return not study.faults.is_wrong(".".join(map(str, place)))


def _is_known(
    study: StudyDraft, path: str, place: Path, start: Start | StructureStart | None
) -> bool:
    """Return whether a right model has this parameter; add the fault if it has none."""
    direction = direction_of(path)
    if direction is not None:
        return _is_direction(study, direction, place, start)
    if not all(LEAF.fullmatch(fault) for fault in _of_model(study)):
        return False
    try:
        long_form(path, study.model, study.force, start)
    except ParameterError as error:
        study.faults.add(place, error.reason)
        return False
    return study.has_right_model


def _is_direction(
    study: StudyDraft, direction: tuple[Any, ...], place: Path, start: object
) -> bool:
    """Return whether a structure's start has this direction; add the fault if it has not."""
    if not study.has_right_model:
        return False
    n = 0 if study.structure is None or start is None else study.structure.n
    reason = None
    if not n:
        reason = "a direction of starts, which this study has not; give paths"
    elif len(direction) != 2 * n:
        reason = f"{counted(len(direction), 'number')}; a direction has {2 * n}, of x0 and v0"
    elif any(number_problem(number) is not None for number in direction):
        reason = "not numbers alone; a direction is such as [1, 0, 0.5, 0]"
    elif not any(map(as_float, direction)):
        reason = "a direction of zeros; no start moves along it"
    if reason is not None:
        study.faults.add(place, reason)
    return reason is None


def _of_model(study: StudyDraft) -> list[str]:
    """Return the paths of the faults of the model."""
    owners = ("parameters", *study.model_tables)
    return [fault.path for fault in study.faults.faults if fault.path.split(".")[0] in owners]


def _fit(
    study: StudyDraft,
    path: str,
    places: Sequence[Path],
    values: Sequence[Phase],
    start: Start | StructureStart | None,
) -> bool:
    """Return whether the model can take all values; add the fault of the first that it cannot."""
    for place, value in zip(places, values, strict=True):
        try:
            replace_parameter(study.model, study.force, start, path, value)
        except ParameterError as error:
            reason = words_of_file(error.reason)
            # The value of a parameter is right; what depends on it is not.
            reason = reason if "." in path else f"there {error.name} = {error.value} is {reason}"
            study.faults.add(place, reason, shown(number(value)))
            return False
    return True
