"""The tables of a study file as values, checked and written by pydantic; and their faults."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, time
from typing import Annotated, Any, Literal, TypeAlias, TypeVar, dataclass_transform

from pydantic import (
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    TypeAdapter,
    WithJsonSchema,
)
from pydantic import ValidationError as ShapeError
from pydantic.dataclasses import dataclass as pydantic_dataclass
from pydantic_core import PydanticCustomError

from percuss.errors import ParameterError
from percuss.io.results import SAMPLES
from percuss.io.study_text import number, numbers, start_table
from percuss.model import exact
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
from percuss.model.oscillator import On, plain_on
from percuss.model.start import NO_COMMON_PERIOD, Start
from percuss.model.structure_start import StructureStart
from percuss.model.units import Units
from percuss.wording import closest

# Keys, and indices into lists.
Path: TypeAlias = tuple[str | int, ...]

# In place of a required key that has a fault already.
MISSING: Any = object()
NO_NUMBER = 'not a number; write 2.8, or "2.8" for that decimal, "1/3" for that fraction'
# What the names of files of matrices end with.
MATRIX_FILES = (".csv", ".txt", ".npy", ".npz", ".mtx")
NO_DIRECTION = 'neither a coordinate, such as 0, nor a direction, [1, -1], nor a point, "tip"'
NO_PHASE = f'{NO_NUMBER}, "pi/2" for that multiple of pi'
# Faults of the model in the words of a study file.
_WORDS_OF_FILE = {
    NOT_A_NUMBER: NO_NUMBER,
    NOT_A_PHASE: NO_PHASE,
    NO_COMMON_PERIOD: NO_COMMON_PERIOD.replace("loads.period", "structure.loads_period"),
}
# Longer values are cut in messages, so that value and sentence fit into a line.
_LONGEST_VALUE = 60
RawTable: TypeAlias = Mapping[str, Any]
T = TypeVar("T")

# As `percuss.certify` takes them.
MOST_DIGITS = 1000
# Samples of a motion in a file: more take over two gigabytes.
MOST_SAMPLES = 100_000_000

DrawnQuantity: TypeAlias = Literal[
    "impact_velocity", "grazing_margin", "multiplier", "period", "amplitude"
]

# Our sentences for the errors of pydantic; {} stands for their context.
_REASONS = {
    "bool_type": "neither true nor false",
    "int_type": "not a whole number",
    "float_type": "not a number; write 2.8, without quotes",
    "finite_number": "not finite",
    "string_type": "not a text; put it in quotes",
    "list_type": "not a list",
    "tuple_type": "not a list",
    "model_type": "not a table",
    "model_attributes_type": "not a table",
    "dataclass_type": "not a table",
    "dict_type": "not a table",
    "literal_error": "not {expected}",
    "union_tag_invalid": 'neither "wall" nor "soft"',
    "greater_than": "not more than {gt}",
    "greater_than_equal": "less than {ge}",
    "less_than_equal": "more than {le}",
    "too_short": "{actual_length} values; {min_length} are needed",
    "too_long": "{actual_length} values; {max_length} are needed",
}


@dataclass(frozen=True, slots=True)
class StudyFault:
    """One thing that is wrong with a study file.

    Parameters
    ----------
    file
        Name of the file, as it was given.
    line
        Line, from 1; None where no line can be named.
    path
        Dotted path of the key; empty for a fault of the syntax.
    reason
        What is wrong, and what would be right.
    value
        What was given, as it is shown; empty if there is none.

    Examples
    --------
    >>> print(StudyFault("study.toml", 7, "run.t_end", "not after t0 = 0", "-1"))
    study.toml:7: run.t_end = -1: not after t0 = 0
    """

    file: str
    line: int | None
    path: str
    reason: str
    value: str = ""

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        path = _on_one_line(self.path)
        name = f"{path} = {self.value}" if self.value else path
        return ": ".join(part for part in (place, name, self.reason) if part)


@dataclass(slots=True)
class StudyFaults:
    """The faults of one file while they are collected, and the lines of its keys."""

    file: str
    lines: dict[Path, int]
    faults: list[StudyFault] = field(default_factory=list)

    def add(self, path: Path, reason: str, value: str = "") -> None:
        """Add a fault, unless this key, a key in it or the table around it has one already."""
        parts = [str(part) for part in path]
        dotted = ".".join(parts)
        around = {".".join(parts[:length]) for length in range(1, len(parts))}
        if not self.is_wrong(dotted) and not any(fault.path in around for fault in self.faults):
            line = line_of(self.lines, path)
            self.faults.append(StudyFault(self.file, line, dotted, reason, value))

    def add_from_model(self, faults: Iterable[Fault]) -> None:
        """Add faults of the model, in the words of a file."""
        for fault in faults:
            if fault.value is not MISSING:
                names = fault.name.split(".")
                path = tuple(int(name) if name.isdecimal() else name for name in names)
                value = "" if fault.value is None else shown(fault.value)
                self.add(path, words_of_file(fault.reason), value)

    def is_wrong(self, dotted: str) -> bool:
        """Return whether a key or a key in it has a fault already."""
        return any(
            fault.path == dotted or fault.path.startswith(f"{dotted}.") for fault in self.faults
        )


def line_of(lines: dict[Path, int], path: Sequence[str | int]) -> int | None:
    """Return the line of a path, or of the innermost table or list around it.

    The line of what does not stand in the file is 0 there, and None here.
    """
    for length in range(len(path), 0, -1):
        line = lines.get(tuple(path[:length]))
        if line is not None:
            return line or None
    return None


def words_of_file(reason: str) -> str:
    """Return a sentence of the model in the words of a file."""
    return _WORDS_OF_FILE.get(reason, reason)


def unknown_key(key: object, known: list[str]) -> str:
    """Return the sentence about an unknown key, with the known key that resembles it."""
    if "study" in known and key in ("kind", "title"):
        return "unknown key; it belongs to the table [study]"
    close = closest(str(key).lower(), known)
    if close:
        return f'unknown key; did you mean "{close}"?'
    return f"unknown key; known here: {', '.join(known)}"


def unknown_value(value: object, known: list[str]) -> str:
    """Return the sentence about an unknown value, with the known value that resembles it."""
    close = closest(str(value).lower(), known)
    listed = f"{', '.join(known[:-1])} or {known[-1]}"
    return f'did you mean "{close}"? There are {listed}' if close else f"not {listed}"


def shown(value: object) -> str:
    """Return a value as messages show it.

    Examples
    --------
    >>> shown("0.5"), shown(True), shown(list(range(100)))[-5:]
    ('"0.5"', 'true', '1 ...')
    >>> shown({"at": 0.3, "direction": "left"})
    '{at = 0.3, direction = "left"}'
    """
    return _on_one_line(_written(value))


def _written(value: object) -> str:
    """Return a value as a file holds it on one line; Python's braces and dates are no TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, exact.Computed):
        return f'"{value}"' + ("" if value.problem() else f" = {float(value):.6g}")
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key} = {_written(inner)}' for key, inner in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_written, value))}]"
    return str(value) if isinstance(value, date | time) else repr(value)


def _on_one_line(text: str) -> str:
    """Return a text without line ends and control characters, cut where it is long."""
    text = text.encode("unicode_escape").decode("ascii") if not text.isprintable() else text
    return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 4]} ..."


def sentence(error: Any) -> str:
    """Return an error of pydantic in our words."""
    words = _REASONS.get(error["type"])
    if error["type"] == "missing":
        return "missing"
    if words is None:
        message = str(error["msg"])
        return message[:1].lower() + message[1:]
    return words.format(**error.get("ctx", {})).replace("'", '"')


@dataclass_transform(frozen_default=True, field_specifiers=(Field,))
def table(kind: type[T]) -> type[T]:
    """Make a class a frozen table: its fields are the keys, their types the checks.

    A value that pydantic refuses is a `ParameterError` in Python, and a fault in a file (`read`).
    """
    config = ConfigDict(arbitrary_types_allowed=True)
    made: Any = pydantic_dataclass(frozen=True, slots=True, config=config)(kind)
    construct = made.__init__

    @functools.wraps(construct)
    def checked(self: Any, *values: Any, **named: Any) -> None:
        if len(values) <= len(keys_of(made)):
            # Named, so that the error of pydantic has the name of the field.
            values, named = (), dict(zip(keys_of(made), values, strict=False)) | named
        try:
            construct(self, *values, **named)
        except ShapeError as error:
            wrong = error.errors(include_url=False)[0]
            path = ".".join([made.__name__.lower(), *map(str, wrong["loc"])])
            raise ParameterError(path, wrong["input"], sentence(wrong)) from error

    made.__init__ = checked
    return made  # type: ignore[no-any-return]


def keys_of(kind: type) -> list[str]:
    """Return the names of the fields of a table."""
    return list(kind.__pydantic_fields__)  # type: ignore[attr-defined]


def values_of(made: Any) -> dict[str, Any]:
    """Return the fields of a table by name, as they are."""
    return {name: getattr(made, name) for name in keys_of(type(made))}


def as_written(made: Any) -> dict[str, Any]:
    """Return a table as a study file holds it."""
    return dict(made.__pydantic_serializer__.to_python(made))


def default(function: Callable[..., Any], name: str) -> Any:
    """Return the default of a parameter of a function."""
    return inspect.signature(function).parameters[name].default


def read(
    kind: type[T],
    raw: RawTable,
    faults: StudyFaults,
    path: Path,
    known: list[str] | None = None,
    given: RawTable | None = None,
) -> T:
    """Return the table of raw values, and add their faults.

    Parameters
    ----------
    kind
        The table.
    raw
        The keys as `tomllib` reads them. A wrong one counts as left out; a required one is then
        `MISSING`.
    faults
        The faults found so far.
    path
        Where the table stands in the file.
    known
        The keys that this file may have; default: all of the table.
    given
        Fields that do not stand in the table of the file.
    """
    known = keys_of(kind) if known is None else known
    for key in raw:
        if key not in known:
            faults.add((*path, key), unknown_key(key, known))
    rest = {key: value for key, value in raw.items() if key in known} | dict(given or {})
    while True:
        try:
            return TypeAdapter(kind).validate_python(rest)
        except ShapeError as error:
            for wrong in error.errors(include_url=False):
                reason, value = sentence(wrong), wrong["input"]
                is_missing = wrong["type"] == "missing"
                faults.add((*path, *wrong["loc"]), reason, "" if is_missing else shown(value))
                name = str(wrong["loc"][0])
                rest.pop(name, None)
                rest |= {name: MISSING} if is_missing else {}


def raw_table(document: RawTable, name: str) -> RawTable:
    """Return a table of a document, empty where there is none."""
    table = document.get(name, {})
    return table if isinstance(table, Mapping) else {}


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


def is_matrix_file(value: object) -> bool:
    """Return whether a text names a file of a matrix, by its end."""
    return isinstance(value, str) and value.lower().endswith(MATRIX_FILES)


def _is_number(value: object) -> bool:
    # The model decides whether a text is a number; true is an int in Python only.
    is_given = isinstance(value, str) or hasattr(value, "__float__") or value is MISSING
    return is_given and not isinstance(value, bool)


def _number(value: object) -> object:
    if not _is_number(value):
        raise PydanticCustomError("number", NO_NUMBER)
    return value


def _phase(value: object) -> object:
    if not _is_number(value):
        raise PydanticCustomError("number", NO_PHASE)
    return exact_phase(value)


def _digits(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST_DIGITS:
        raise PydanticCustomError("digits", f"not a whole number from 1 to {MOST_DIGITS}")
    return value


def table_only(value: object) -> object:
    """Return a value that is a table; its content is read once the model is known."""
    if not isinstance(value, Mapping):
        raise PydanticCustomError("dict_type", "not a table")
    return value


# How editors see these keys: texts are exact numbers, and expressions of parameters.
NUMBER_SCHEMA: dict[str, Any] = {"type": ["number", "string"]}
NUMBERS_SCHEMA: dict[str, Any] = {
    "anyOf": [NUMBER_SCHEMA, {"type": "array", "items": NUMBER_SCHEMA}]
}
ON_SCHEMA: dict[str, Any] = {
    "anyOf": [
        {"type": "integer", "minimum": 0},
        {"type": "string"},
        {"type": "array", "items": NUMBER_SCHEMA},
    ]
}
NumberKey = Annotated[
    exact.Exact, PlainValidator(_number), PlainSerializer(number), WithJsonSchema(NUMBER_SCHEMA)
]
# May be a multiple of pi.
PhaseKey = Annotated[
    exact.Phase, PlainValidator(_phase), PlainSerializer(number), WithJsonSchema(NUMBER_SCHEMA)
]
Whole = Annotated[int, Field(strict=True, ge=0)]
Count = Annotated[int, Field(strict=True, ge=1)]
Flag = Annotated[bool, Field(strict=True)]
Text = Annotated[str, Field(strict=True)]


@table
class StudyTable:
    """``[study]``: the kind of study and its title."""

    kind: Text = "motion"
    title: Text = ""


@table
class StartTable:
    """``[start]``: the state in which the motion begins, not checked yet."""

    x0: NumberKey = 0.0
    v0: NumberKey = 0.0
    t0: PhaseKey = 0.0


def _numbers(value: object) -> object:
    if isinstance(value, list | tuple) and all(map(_is_number, value)):
        return tuple(value)
    if not _is_number(value):
        raise PydanticCustomError("numbers", "not a list of numbers, one for each coordinate")
    return value


def _on(value: object) -> object:
    is_index = isinstance(value, int) and not isinstance(value, bool)
    is_direction = isinstance(value, list | tuple) and all(map(_is_number, value))
    if value is not None and not (is_index or is_direction or isinstance(value, str)):
        raise PydanticCustomError("on", NO_DIRECTION)
    return plain_on(value)


# Of each coordinate, or one number: 0, or that of the only coordinate.
NumbersKey = Annotated[
    tuple[exact.Exact, ...] | exact.Exact,
    PlainValidator(_numbers),
    PlainSerializer(numbers),
    WithJsonSchema(NUMBERS_SCHEMA),
]
# A coordinate, a direction or the name of a point.
OnKey = Annotated[
    On | None, PlainValidator(_on), PlainSerializer(numbers), WithJsonSchema(ON_SCHEMA)
]
OnKeys = Annotated[
    tuple[OnKey, ...] | None,
    PlainSerializer(lambda given: None if given is None else [numbers(on) for on in given]),
]


@table
class StructureStartTable:
    """``[start]`` of a structure, not checked yet: a number for each coordinate."""

    x0: NumbersKey = 0.0
    v0: NumbersKey = 0.0
    t0: PhaseKey = 0.0


def _start(value: Any) -> Start | StructureStart:
    if isinstance(value, Start | StructureStart):
        return value
    # Checked later, against the walls of the model: one fault, not two.
    return draft(Start, **values_of(TypeAdapter(StartTable).validate_python(value)))


# Of a structure a StructureStart: the model of the study decides.
StartState = Annotated[
    Any, PlainValidator(_start), PlainSerializer(start_table), WithJsonSchema({"type": "object"})
]


@table
class Save:
    """Which files a study writes.

    Parameters
    ----------
    netcdf
        Whether to write the result as NetCDF.
    csv
        Whether to write its tables as CSV.
    decimal_comma
        Whether their numbers have commas, and semicolons separate the columns.
    samples
        Number of equally spaced times in the NetCDF file of a motion or an orbit.
    """

    netcdf: Flag = True
    csv: Flag = True
    decimal_comma: Annotated[Flag, PlainSerializer(lambda is_on: is_on or None)] = False
    samples: Annotated[
        int,
        Field(strict=True, ge=2, le=MOST_SAMPLES),
        PlainSerializer(lambda n: None if n == SAMPLES else n),
    ] = SAMPLES


@table
class Limits:
    """The end of a motion.

    Parameters
    ----------
    t_end
        Time of the end [time]; or None.
    periods
        Number of forcing periods from the start, in place of `t_end`; or None.
    max_impacts
        Number of impacts and entries into soft stops after which to stop; or None.
    """

    t_end: PhaseKey | None = None
    periods: NumberKey | None = None
    max_impacts: Annotated[int, Field(strict=True)] | None = None


@table
class Draw:
    """Which pictures a study draws.

    Parameters
    ----------
    png, svg
        Whether to write the picture in this format.
    window
        First and last time of a motion that are drawn; default: the whole run.
    length_unit, time_unit
        Units on the axes; empty: those of the oscillator, or dimensionless ones.
    quantity
        The quantity of a branch drawn over its parameter, as in `percuss.plotting.plot_branch`.
    animation
        Format of a film of a motion, as `percuss.plotting.animate` makes it; default: no film.
    manifolds
        Whether the stable manifolds of saddles are drawn into basins.
    on
        Coordinates, directions and points of a structure whose motions are drawn; default: its
        points, or else all coordinates. Of a branch the one whose amplitude is drawn; default: the
        line of its first stop.
    coordinate
        In place of `on`, of a branch: the index of a coordinate.
    """

    png: Flag = True
    svg: Flag = True
    window: Annotated[tuple[PhaseKey, ...], Field(min_length=2, max_length=2)] | None = None
    length_unit: Text = ""
    time_unit: Text = ""
    quantity: DrawnQuantity | None = None
    animation: Literal["gif", "html", "mp4"] | None = None
    manifolds: Annotated[Flag, PlainSerializer(lambda is_on: is_on or None)] = False
    on: OnKeys = None
    coordinate: Whole | None = None

    def units(self) -> Units | None:
        """Return the units as plots take them; None: those of the oscillator."""
        if not (self.length_unit or self.time_unit):
            return None
        return Units(self.length_unit, self.time_unit)


@table
class Certify:
    """The digits to which the answer of a study is proven in ball arithmetic.

    Parameters
    ----------
    digits
        As `percuss.certify` takes them: 1 to 1000.

    Raises
    ------
    ParameterError
        If they are out of this range.
    """

    digits: Annotated[
        int,
        PlainValidator(_digits),
        WithJsonSchema({"type": "integer", "minimum": 1, "maximum": MOST_DIGITS}),
    ] = 12


SAVE_ALL, DRAW_ALL = Save(), Draw()
