"""Parameters by their dotted paths: list them, read them, replace them.

A path is the way to a number through the frozen values: ``oscillator.damping``,
``oscillator.stops.0.restitution``, ``forcing.constant``, ``forcing.harmonics.1.phase``,
``start.x0``. With exactly one harmonic, ``forcing.omega``, ``forcing.amplitude`` and
``forcing.phase`` are short for those of ``forcing.harmonics.0``. A Fourier sum has
``forcing.omega``, its base frequency, and ``forcing.cos.0`` for the first of its ``cos``. Where
there is one frequency, ``forcing.period`` is 2 pi over it. A record has
``forcing.record.amplitude``, and ``forcing.record.omega`` where it is a wave. With a mass,
``oscillator.mass``, ``oscillator.damping_coefficient`` is another name of ``oscillator.damping``.

A structure has ``structure.stiffness.0.1``, ``structure.stops.0.at``, ``start.x0.1`` and, for each
load in the order given, ``loads.1`` in the place of ``forcing``. Its mass is symmetric:
``structure.mass.0.1`` is both entries.

The name of a parameter (`percuss.model.expression`) is a path, too: it changes all numbers that are
expressions of it, which are no paths of their own then. The path of a number that is a parameter
alone is another name of it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, TypeVar

from percuss.errors import ParameterError
from percuss.model.exact import Phase, PiTimes, angle, as_float, kept, pi_times
from percuss.model.expression import Expression, as_expression, parameters_in
from percuss.model.faults import faults, raise_first
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.parameter_fields import (
    PREFIXES,
    AnyForce,
    AnyStart,
    fields_by_path,
    forcings_by_name,
    free_parameters,
    is_changed,
    is_tied,
    parameters_by_path,
    with_values,
)
from percuss.model.restitution import RestitutionTable
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart

OscT = TypeVar("OscT", bound=Oscillator | Structure)
ForceT = TypeVar("ForceT", bound=Forcing | Loads | None)
BeginT = TypeVar("BeginT", bound=Start | StructureStart | None)

_SHORT_FORMS = ("amplitude", "omega", "phase")
# Other names of parameters, and the last word of the paths that they mean.
_WORDS = {
    "wall": "at",
    "gap": "at",
    "clearance": "at",
    "frequency": "omega",
    "stops": "at",
    "r": "restitution",
    "k": "stiffness",
    "m": "mass",
    "c": "damping",
    "load": "constant",
}
MOST_MEANT = 3
# Names that a message lists: matrices have many entries.
MOST_LISTED = 60


def parameter_paths(
    osc: Oscillator | Structure, force: AnyForce = None, start: AnyStart = None
) -> tuple[str, ...]:
    """Return the paths of all parameters, in their long form, without ``forcing.period``.

    Parameters
    ----------
    osc
        The oscillator, or a structure.
    force
        The forcing, or None; the loads of a structure.
    start
        The start, or None.

    Returns
    -------
    tuple of str
        The paths, those of the oscillator first; last the names of parameters in expressions.

    Examples
    --------
    >>> from percuss.model import impact_oscillator
    >>> parameter_paths(impact_oscillator())[2:]
    ('oscillator.stops.0.at', 'oscillator.stops.0.restitution')
    """
    return tuple(parameters_by_path(osc, force, start))


def get_parameter(
    osc: Oscillator | Structure, force: AnyForce, start: AnyStart, path: str
) -> Phase:
    """Return the value of a parameter, as it was given.

    Parameters
    ----------
    osc, force, start
        The values to look in; the last two may be None.
    path
        Path of the parameter, in its long or short form.

    Returns
    -------
    Phase
        The value: a number, or a multiple of pi.

    Raises
    ------
    ParameterError
        If there is no such parameter.

    Examples
    --------
    >>> from percuss.model import impact_oscillator, sine
    >>> get_parameter(impact_oscillator(), sine("2.8"), None, "forcing.omega")
    '2.8'
    """
    name = long_form(path, osc, force, start)
    owner = _owner_of_period(name, force)
    if owner is not None and owner[1].given_period is None:
        times, plus = angle(pi_times(2) / as_expression(_one_frequency(*owner)[1]))
        return PiTimes(times, plus) if times else kept(plus)
    return parameters_by_path(osc, force, start)[name]


def replace_parameter(
    osc: OscT, force: ForceT, start: BeginT, path: str, value: Phase
) -> tuple[OscT, ForceT, BeginT]:
    """Return the same values with one parameter replaced.

    Parameters
    ----------
    osc, force, start
        The values to start from; the last two may be None.
    path
        Path of the parameter, in its long or short form.
    value
        Its new value.

    Returns
    -------
    tuple of Oscillator, Forcing and Start
        New values; what has not changed is the same object.

    Raises
    ------
    ParameterError
        If there is no such parameter, or it cannot have this value.

    Examples
    --------
    >>> from percuss.model import impact_oscillator
    >>> osc, *_ = replace_parameter(
    ...     impact_oscillator(), None, None, "oscillator.stops.0.restitution", 0.8
    ... )
    >>> osc == impact_oscillator(restitution=0.8)
    True
    """
    return replace_parameters(osc, force, start, {path: value})


def replace_parameters(
    osc: OscT,
    force: ForceT,
    start: BeginT,
    changes: Mapping[str, Phase],
) -> tuple[OscT, ForceT, BeginT]:
    """Return the same values with several parameters replaced at once.

    Two walls can thus be moved together, past where either alone could go.

    Parameters
    ----------
    osc, force, start
        The values to start from; the last two may be None.
    changes
        New values by path, in long or short form.

    Returns
    -------
    tuple of Oscillator, Forcing and Start
        New values; what has not changed is the same object.

    Raises
    ------
    ParameterError
        If there is no such parameter, one is named twice, or the values do not fit.

    Examples
    --------
    >>> from percuss.model import impact_oscillator
    >>> _, _, start = replace_parameters(
    ...     impact_oscillator(), None, Start(0.0, 1.0), {"start.x0": 0.5, "start.v0": 0.0}
    ... )
    >>> start
    Start(x0=0.5, v0=0.0, t0=0.0)
    """
    fields, by_path = fields_by_path(osc, force, start), dict[str, Phase]()
    names = _long_forms(tuple(changes), fields, force, osc)
    for path, name in zip(changes, names, strict=True):
        if name in by_path:
            before = tuple(changes)[names.index(name)]
            raise ParameterError("path", (before, path), "the same parameter, named twice")
        by_path[name] = changes[path]
    by_path = _by_field(by_path, fields, force)
    if is_changed(by_path, PREFIXES[type(osc)]):
        osc = with_values(osc, by_path)
        raise_first(faults(osc))
    if force is not None and is_changed(by_path, PREFIXES[type(force)]):
        force = with_values(force, by_path)
        raise_first(faults(force))
    if start is not None and is_changed(by_path, "start"):
        start = with_values(start, by_path)
        raise_first(faults(start))
    return osc, force, start


def long_form(
    path: str,
    osc: Oscillator | Structure,
    force: AnyForce = None,
    start: AnyStart = None,
) -> str:
    """Return the path of a parameter as it is printed.

    Parameters
    ----------
    path
        Path of a parameter, in its long or short form.
    osc, force, start
        The values that have the parameter; the last two may be None.

    Returns
    -------
    str
        The long form.

    Raises
    ------
    ParameterError
        If there is no such parameter; with the nearest ones that there are.

    Examples
    --------
    >>> from percuss.model import impact_oscillator, sine
    >>> long_form("forcing.omega", impact_oscillator(), sine(3.0))
    'forcing.harmonics.0.omega'
    """
    return long_forms([path], osc, force, start)[0]


def long_forms(
    paths: Iterable[str],
    osc: Oscillator | Structure,
    force: AnyForce = None,
    start: AnyStart = None,
) -> list[str]:
    """Return the long form of each path, as `long_form` does, which looks the fields up each time."""
    return _long_forms(paths, fields_by_path(osc, force, start), force, osc)


def _long_forms(
    paths: Iterable[str],
    fields: Mapping[str, Phase],
    force: AnyForce,
    osc: Oscillator | Structure,
) -> list[str]:
    known = free_parameters(fields)
    return [
        path if path in known else _long_form(path, fields, known, force, osc) for path in paths
    ]


def _long_form(
    path: str,
    fields: Mapping[str, Phase],
    known: Mapping[str, Phase],
    force: AnyForce,
    osc: Oscillator | Structure,
) -> str:
    short_forms: dict[str, str] = {}
    for name, forcing in forcings_by_name(force).items():
        part = _only_part(forcing)
        if part is not None:
            forms = {f"{name}.{word}": f"{name}.{part}.{word}" for word in _SHORT_FORMS}
            short_forms |= {form: path for form, path in forms.items() if path in fields}
    if "oscillator.mass" in fields:
        short_forms["oscillator.damping_coefficient"] = "oscillator.damping"
    long = _upper(short_forms.get(path, path))
    owner = _owner_of_period(path, force)
    if owner is not None and _has_one_frequency(owner[1]):
        long, _ = _one_frequency(*owner)
        if not is_tied(fields[long]):
            return path
    if long in known:
        return long
    tied = fields.get(long)
    if isinstance(tied, Expression):
        if tied.is_parameter and owner is None:
            return tied.text
        names = " and ".join(tied.names)
        reason = f"tied to {names} by {long} = {tied}; change {names}"
        raise ParameterError("path", path, reason)
    periods = [
        f"{name}.period"
        for name, forcing in forcings_by_name(force).items()
        if _has_one_frequency(forcing) and not is_tied(fields[_one_frequency(name, forcing)[0]])
    ]
    # Parameters first; of short forms those that may be changed.
    own = sorted(known, key=lambda name: "." in name)
    alike = [*own, *(form for form, target in short_forms.items() if target in known), *periods]
    raise ParameterError("path", path, _unknown(path, alike, force, _tables_of(osc)))


def _tables_of(osc: Oscillator | Structure) -> list[str]:
    """Return the paths of restitutions that are tables, and so no numbers."""
    return [
        f"oscillator.stops.{index}.restitution"
        for index, stop in enumerate(osc.stops)
        if isinstance(getattr(stop, "restitution", None), RestitutionTable)
    ]


class MovedFields(NamedTuple):
    """The fields of a model that a path changes.

    Attributes
    ----------
    name
        Name of the path's value in the expressions.
    fields
        By their own paths, as expressions of this name, and of other parameters.
    """

    name: str
    fields: dict[str, Expression]


def moved_fields(
    osc: Oscillator | Structure, force: AnyForce, start: AnyStart, path: str
) -> MovedFields:
    """Return the numbers that change with a parameter, and how.

    Parameters
    ----------
    osc, force, start
        The values that have the parameter; the last two may be None.
    path
        Its path, in long or short form.

    Returns
    -------
    MovedFields
        The path itself where it is that of a field.

    Examples
    --------
    >>> from percuss.model import cosine, impact_oscillator, parameter
    >>> w = parameter("w", "1.7")
    >>> force = cosine(w, amplitude="0.15" * w**2)
    >>> for field, value in moved_fields(impact_oscillator(), force, None, "w").fields.items():
    ...     print(field, "=", value)
    forcing.harmonics.0.amplitude = 0.15*w**2
    forcing.harmonics.0.omega = w
    """
    name, fields = long_form(path, osc, force, start), fields_by_path(osc, force, start)
    own = "x"
    while own in parameters_in(*fields.values()):
        own += "_"
    if name in fields:
        return MovedFields(own, {name: Expression(own, ((own, fields[name]),))})
    owner = _owner_of_period(name, force)
    if owner is not None:
        value = get_parameter(osc, force, start, name)
        omega, _ = _one_frequency(*owner)
        return MovedFields(own, {omega: Expression(f"2*pi/{own}", ((own, value),))})
    return MovedFields(name, _tied_to(name, fields))


def moved_in_law(osc: Oscillator, force: Forcing | None, path: str) -> MovedFields:
    """Return the numbers of the motion that change with a parameter: those of unit mass.

    Parameters
    ----------
    osc, force
        The values that have the parameter; the forcing may be None.
    path
        Its path, in long or short form.

    Returns
    -------
    MovedFields
        As `moved_fields` has them; with a mass divided by it, and all that it divides where it is
        what moves.

    Examples
    --------
    >>> from percuss.model import Oscillator, cosine
    >>> osc = Oscillator.from_mass(2, 50, damping_coefficient=3)
    >>> for field, value in moved_in_law(osc, cosine(3), "oscillator.mass").fields.items():
    ...     print(field, float(value), float(value.derivative("x")))
    oscillator.stiffness 25.0 -12.5
    oscillator.damping 0.75 -0.375
    forcing.harmonics.0.amplitude 0.5 -0.25
    """
    moved = moved_fields(osc, force, None, path)
    if osc.mass is None:
        return moved
    osc = with_values(osc, moved.fields)
    force = None if force is None else with_values(force, moved.fields)
    unit = None if force is None else force.acceleration_of(osc.mass)
    fields = fields_by_path(osc.of_unit_mass(), unit, None)
    return MovedFields(moved.name, _tied_to(moved.name, fields))


def _tied_to(name: str, fields: Mapping[str, Phase]) -> dict[str, Expression]:
    """Return the fields that are expressions of a parameter."""
    tied = {path: value for path, value in fields.items() if isinstance(value, Expression)}
    return {path: value for path, value in tied.items() if name in value.names}


def _by_field(
    changes: Mapping[str, Phase], fields: Mapping[str, Phase], force: AnyForce
) -> dict[str, Phase]:
    """Return changes of parameters as changes of fields."""
    by_field = dict(changes)
    for path in changes:
        owner = _owner_of_period(path, force)
        if owner is None or path in fields:
            continue
        omega, _ = _one_frequency(*owner)
        if omega in by_field:
            raise ParameterError("path", (path, omega), "the same parameter, named twice")
        by_field[omega] = _frequency_of(path, by_field.pop(path))
    names = {name: by_field.pop(name) for name in changes if name not in fields and "." not in name}
    if names:
        for field, value in fields.items():
            if isinstance(value, Expression) and not names.keys().isdisjoint(value.names):
                by_field[field] = value.replaced(names)
    return by_field


def _owner_of_period(path: str, force: AnyForce) -> tuple[str, Forcing] | None:
    """Return the forcing whose period a path is, and the beginning of its path."""
    name, _, word = str(path).rpartition(".")
    forcings = forcings_by_name(force)
    return (name, forcings[name]) if word == "period" and name in forcings else None


def _upper(path: str) -> str:
    """Return the path of an entry of the mass below its diagonal as that above, which is equal."""
    entry = re.fullmatch(r"structure\.mass\.(\d+)\.(\d+)", str(path))
    if entry is None or int(entry[1]) <= int(entry[2]):
        return path
    return f"structure.mass.{entry[2]}.{entry[1]}"


def _only_part(force: Forcing) -> str | None:
    """Return the path of the one part of a forcing that is one harmonic or one record alone."""
    if force.base is None and len(force.harmonics) == 1:
        return "harmonics.0"
    return "record" if force.record is not None and not force.harmonics else None


def _has_one_frequency(force: Forcing) -> bool:
    """Return whether a forcing repeats by one frequency, which its period is a parameter for."""
    record = force.record
    is_one = record is None or (not force.harmonics and record.omega is not None)
    return force.given_period is None and force.frequency is not None and is_one


def _one_frequency(name: str, force: Forcing) -> tuple[str, Any]:
    """Return path and value of the one frequency of a forcing whose path begins with a name."""
    if force.base is not None:
        return f"{name}.omega", force.base
    if not force.harmonics and force.record is not None:
        return f"{name}.record.omega", force.record.omega
    return f"{name}.harmonics.0.omega", getattr(force.harmonics[0], "omega", None)


def _frequency_of(path: str, period: Phase) -> Any:
    """Return the frequency of a period, exactly."""
    if as_float(period) <= 0.0:
        raise ParameterError(path, period, "not positive")
    times, plus = angle(period)
    return pi_times(2) / as_expression(period) if plus else kept(2 / times)


def _unknown(path: str, known: list[str], force: AnyForce, tables: list[str]) -> str:
    meant = [table for table in tables if path == table or _of_that_word(path, [table])]
    if meant:
        return f"no number: {meant[0]} is a table of speeds; {meant[0]}.values.0 is its first value"
    if force is None and path.startswith("forcing."):
        return "no such parameter; the motion is free, it has no forcing"
    name, _, own = str(path).rpartition(".")
    forcing = forcings_by_name(force).get(name)
    if forcing is not None and own in _SHORT_FORMS and len(forcing.harmonics) > 1:
        wanted = f"{name}.harmonics.0.{own}"
        if wanted in known:
            return f"one of {len(forcing.harmonics)} harmonics; write {wanted} for the first"
    if own == "damping_ratio" and f"{name}.damping_coefficient" in known:
        return f"no such parameter: the ratio only sets {name}.damping_coefficient; write that"
    alike = difflib.get_close_matches(str(path), known, n=3, cutoff=0.6)
    meant = _of_that_word(str(path), known)
    # A single word resembles no whole path, but may be the last word of one.
    similar = alike or meant if "." in str(path) else meant or alike
    more = ", ..." if len(known) > MOST_LISTED else ""
    listed = f"there are {', '.join(known[:MOST_LISTED])}{more}"
    hint = f"did you mean {' or '.join(similar)}?" if similar else listed
    return f"no such parameter; {hint}"


def _of_that_word(path: str, known: list[str]) -> list[str]:
    """Return the parameters that a word alone may mean, short forms in place of their long ones."""
    given = [word for word in path.lower().split(".") if not word.isdecimal()]
    word = _WORDS.get(given[-1], given[-1]) if given else ""
    named = [full for full in known if re.sub(r"(\.\d+)+$", "", full).endswith(f".{word}")]
    short = [full for full in named if re.fullmatch(r"(forcing|loads\.\d+)\.\w+", full)]
    return (short or named)[:MOST_MEANT]
