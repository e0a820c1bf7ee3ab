"""Studies as TOML text, without losing a digit."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias, cast

import numpy as np

from percuss.model.exact import Phase, PiTimes, plain
from percuss.model.expression import Expression, expressions_in, parameters_in
from percuss.model.force_record import ForceRecord
from percuss.model.forcing import Forcing, FourierTerm, Harmonic
from percuss.model.loads import Loads
from percuss.model.oscillator import On, Oscillator, Stop, Wall
from percuss.model.restitution import Restitution, RestitutionTable
from percuss.model.start import Start
from percuss.model.structure import MatrixRows, Structure
from percuss.model.structure_start import StructureStart
from percuss.model.units import Units
from percuss.motion.entries import entry_rows

if TYPE_CHECKING:
    # Reading a study needs no engine.
    from percuss.motion.structures import StructureTrajectory
    from percuss.motion.trajectory import Trajectory
    from percuss.orbits.bifurcations.branch import Branch
    from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
    from percuss.orbits.responses.response import Response

_BARE = re.compile(r"[A-Za-z0-9_-]+")

TomlTable: TypeAlias = dict[str, object]


def toml_text(document: Mapping[str, object]) -> str:
    """Return a document of tables, arrays of tables, and lists of scalars as TOML text.

    Parameters
    ----------
    document
        Tables by name, or lists of tables. None values are left out. A table inside a table stands
        on one line.

    Returns
    -------
    str
        The text; ``tomllib.loads`` gives the document back.

    Examples
    --------
    >>> print(toml_text({"run": {"t_end": 10.0}, "oscillator": {"stops": [{"at": "0.2"}]}}))
    [run]
    t_end = 10.0
    <BLANKLINE>
    [[oscillator.stops]]
    at = "0.2"
    <BLANKLINE>
    """
    blocks = [
        "\n".join(lines) + "\n"
        for name, table in document.items()
        for lines in _blocks(name, table)
    ]
    return "\n".join(blocks)


def _blocks(name: str, table: object) -> Iterator[list[str]]:
    """Yield the lines of a table, then those of the tables inside it."""
    if isinstance(table, list):
        for row in table:
            (_, *lines), *inner = _blocks(name, row)
            yield [f"[[{name}]]", *lines]
            yield from inner
        return
    if not isinstance(table, Mapping):
        raise TypeError(f"{name} is not a table")
    values = {key: value for key, value in table.items() if not _is_nested(value)}
    nested = {key: value for key, value in table.items() if _is_nested(value)}
    if values or not nested:
        yield [f"[{name}]", *_entries(values)]
    for key, rows in nested.items():
        for row in rows:
            yield [f"[[{name}.{key}]]", *_entries(row)]


def _is_nested(value: object) -> bool:
    return isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value)


def _entries(table: Mapping[str, object]) -> Iterable[str]:
    return (f"{_key(key)} = {_value(value)}" for key, value in table.items() if value is not None)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else toml_string(key)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(_entries(value))}}}"
    raise TypeError(f"{value!r} has no place in a study file")


def toml_string(text: str) -> str:
    r"""Return a text as a TOML basic string, on one line.

    Examples
    --------
    >>> print(toml_string('a "quoted" word'))
    "a \"quoted\" word"
    """
    # JSON escapes what TOML does, but for DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


# Part of its width by which a range is extended at a fold, so that the branch turns inside it.
EXTENSION = 0.01


def number(value: Phase) -> int | float | str:
    """Return a number as a study file holds it: floats bare, exact numbers as quoted texts.

    Examples
    --------
    >>> exact = Fraction(1, 3), Decimal("2.80"), PiTimes(Fraction(3, 4))
    >>> number(0.5), *map(number, exact)
    (0.5, '1/3', '2.80', '3*pi/4')
    """
    if isinstance(value, Fraction):
        return f"{value.numerator}/{value.denominator}"
    if isinstance(value, Decimal):
        return str(value)
    if isinstance(value, PiTimes):
        return _pi_text(value)
    if isinstance(value, Expression):
        return str(value)
    return cast("int | float | str", plain(value))


def _pi_text(value: PiTimes) -> str:
    times, plus = value.times, value.plus
    if times == 0:
        return str(plus)
    text = {1: "pi", -1: "-pi"}.get(times.numerator, f"{times.numerator}*pi")
    text = text if times.denominator == 1 else f"{text}/{times.denominator}"
    return text if plus == 0 else f"{text} + {plus}"


def stop_table(stop: Stop) -> TomlTable:
    """Return a stop as a ``[[oscillator.stops]]`` or ``[[structure.stops]]`` table."""
    if isinstance(stop, Wall):
        law: TomlTable = {"restitution": _restitution(stop.restitution)}
    else:
        law = {"stiffness": number(stop.stiffness), "damping": number(stop.damping)}
    kind = "wall" if isinstance(stop, Wall) else "soft"
    return {"type": kind, "on": numbers(stop.on), "at": number(stop.at), "side": stop.side, **law}


def numbers(value: Phase | On | tuple[Phase, ...] | None) -> object:
    """Return a number, or a list of them, as a study file holds it, a name or None unchanged."""
    if isinstance(value, tuple):
        return [number(item) for item in value]
    return number(value)  # type: ignore[arg-type]  # a name and None come back as they are


def structure_table(structure: Structure, loads: Loads | None = None) -> TomlTable:
    """Return a structure as a ``[structure]`` table of its matrices, whatever it was made of."""
    period = None if loads is None else loads.given_period
    points = {name: [number(value) for value in row] for name, row in structure.points}
    return {
        "mass": _matrix(structure.mass),
        "stiffness": _matrix(structure.stiffness),
        "damping": _matrix(structure.damping),
        "points": points or None,
        "units": None if structure.units is None else units_table(structure.units),
        "loads_period": None if period is None else number(period),
        "stops": [stop_table(stop) for stop in structure.stops] or None,
    }


def _matrix(rows: MatrixRows) -> list[object]:
    """Return a matrix as rows, or as the numbers of its diagonal where the others are whole 0."""
    others = (entry for i, row in enumerate(rows) for j, entry in enumerate(row) if i != j)
    if all(type(entry) is int and entry == 0 for entry in others):
        return [number(row[i]) for i, row in enumerate(rows)]
    return [[number(entry) for entry in row] for row in rows]


def loads_tables(loads: Loads) -> list[TomlTable]:
    """Return loads as ``[[loads]]`` tables, in their order."""
    return [{"on": numbers(on), **forcing_table(force)} for on, force in loads.items]


def _restitution(value: Restitution) -> object:
    if not isinstance(value, RestitutionTable):
        return number(value)
    return {name: numbers(getattr(value, name)) for name in ("speeds", "values")}


def oscillator_table(oscillator: Oscillator) -> TomlTable:
    """Return an oscillator as an ``[oscillator]`` table."""
    of_mass = oscillator.mass is not None
    units = oscillator.units
    return {
        "mass": number(oscillator.mass) if oscillator.mass is not None else None,
        "stiffness": number(oscillator.stiffness),
        "damping_coefficient" if of_mass else "damping": number(oscillator.damping),
        "units": None if units is None else units_table(units),
        "stops": [stop_table(stop) for stop in oscillator.stops] or None,
    }


def units_table(units: Units) -> TomlTable:
    """Return units as a table of a study."""
    names = {"length": units.length, "time": units.time, "mass": units.mass}
    return {name: unit for name, unit in names.items() if unit}


def forcing_table(forcing: Forcing) -> TomlTable:
    """Return a forcing as a ``[forcing]`` table, a Fourier sum by its coefficients."""
    table: TomlTable = {"constant": number(forcing.constant)}
    if forcing.is_per_mass:
        table["per_mass"] = True
    if forcing.record is not None:
        table["record"] = record_table(forcing.record)
    if forcing.base is not None:
        terms = {part.n: part for part in forcing.harmonics if isinstance(part, FourierTerm)}
        row = [terms.get(n, FourierTerm(n)) for n in range(1, max(terms, default=0) + 1)]
        return {
            **table,
            "omega": number(forcing.base),
            "cos": [number(term.cos) for term in row],
            "sin": [number(term.sin) for term in row],
        }
    harmonics = [
        {
            "amplitude": number(part.amplitude),
            "omega": number(part.omega),
            "phase": number(part.phase),
        }
        for part in forcing.harmonics
        if isinstance(part, Harmonic)
    ]
    period = None if forcing.given_period is None else number(forcing.given_period)
    return {**table, "period": period, "harmonics": harmonics or None}


def record_table(record: ForceRecord) -> TomlTable:
    """Return a record as a ``[forcing.record]`` table that holds its samples."""
    return {
        "kind": record.kind,
        "repeat": record.repeat,
        "outside": record.outside,
        "amplitude": number(record.amplitude),
        "omega": None if record.omega is None else number(record.omega),
        "t": [number(value) for value in record.t],
        "f": [number(value) for value in record.f],
    }


def model_tables(
    model: Oscillator | Structure, force: Forcing | Loads | None, *others: object
) -> TomlTable:
    """Return what moves and the force on it as tables of a study, with all parameters.

    The others are what else stands in the study and may be expressions.
    """
    tables: TomlTable = {}
    if any(value.names for value in expressions_in(model, force, *others)):
        parameters = parameters_in(model, force, *others)
        tables |= {"parameters": {name: number(value) for name, value in parameters.items()}}
    if isinstance(model, Structure):
        loads = force if isinstance(force, Loads) else None
        tables["structure"] = structure_table(model, loads)
        return tables | ({"loads": loads_tables(loads)} if loads else {})
    tables["oscillator"] = oscillator_table(model)
    if isinstance(force, Forcing):
        tables["forcing"] = forcing_table(force)
    return tables


def start_table(start: Start | StructureStart) -> TomlTable:
    """Return a start as a ``[start]`` table."""
    return {name: numbers(getattr(start, name)) for name in ("x0", "v0", "t0")}


def motion_text(run: Trajectory | StructureTrajectory) -> str:
    """Return a study that repeats a run, as TOML text.

    Parameters
    ----------
    run
        The run.

    Returns
    -------
    str
        A study with every number of model and start as it was given, up to the end of the run.
    """
    structure = getattr(run, "structure", None)
    limit: TomlTable = {"t_end": number(run.end)}
    if run.outcome.name == "reached_max_impacts" or run.t_end <= run.t0:
        limit = {"max_impacts": max(len(run.impacts) + len(entry_rows(run)), 1)}
        # A structure's run needs an end; this one comes after the last impact.
        limit |= {"t_end": run.t_end + 1.0} if structure is not None else {}
    if structure is not None:
        tables = model_tables(structure, run.loads, run.start, run.end)  # type: ignore[union-attr]
    else:
        tables = model_tables(run.oscillator, run.forcing, run.start, run.end)  # type: ignore[union-attr]
    return toml_text(
        {
            "study": {"kind": "motion"},
            **tables,
            "start": start_table(run.start),
            "run": limit,
        }
    )


def orbit_text(orbit: PeriodicOrbit) -> str:
    """Return a study of kind orbit that finds an orbit again, its first impact the guess."""
    return toml_text({"study": {"kind": "orbit"}, **_orbit_tables(orbit)})


def branch_text(branch: Branch) -> str:
    """Return a study of kind branch that follows a branch again from its first physical orbit."""
    row = int(np.argmax(branch.admissible))
    lowest, highest = int(np.argmin(branch.values)), int(np.argmax(branch.values))
    low, high = float(branch.values[lowest]), float(branch.values[highest])
    # Where the branch turns, its range went on.
    extension = EXTENSION * (high - low)
    low -= extension if 0 < lowest < len(branch) - 1 else 0.0
    high += extension if 0 < highest < len(branch) - 1 else 0.0
    ends = [low, high] if branch.values[0] <= branch.values[-1] else [high, low]
    return toml_text(
        {
            "study": {"kind": "branch"},
            **_orbit_tables(branch.orbits[row]),
            "over": {branch.path: ends},
        }
    )


def response_text(response: Response) -> str:
    """Return a study of kind response that finds a response again; empty without an orbit."""
    if not response.branches:
        return ""
    orbit = response.branches[0].orbits[0]
    own: TomlTable = {"max_impacts": response.max_impacts, "max_periods": response.max_periods}
    if response.on is not None:
        own["on"] = numbers(response.on)
    is_oscillator = hasattr(orbit, "oscillator")
    model = (orbit.oscillator, orbit.forcing) if is_oscillator else (orbit.structure, orbit.loads)
    return toml_text(
        {
            "study": {"kind": "response"},
            **model_tables(*model),
            "over": {response.path: [response.low, response.high]},
            "response": own,
        }
    )


def _orbit_tables(orbit: PeriodicOrbit) -> TomlTable:
    table: TomlTable = {
        "impacts": "inf" if math.isinf(orbit.n_impacts) else int(orbit.n_impacts),
        "periods": max(orbit.n_periods, 1),
    }
    if len(orbit.impacts) and not math.isinf(orbit.n_impacts):
        table["sequence"] = list(orbit.sequence)
        if orbit.n_periods:
            table["cycle"] = float(orbit.impacts.cycle[0])
            table["v_after"] = float(orbit.impacts.v_after[0])
    return {**model_tables(orbit.oscillator, orbit.forcing), "orbit": table}
