"""Parameters by their dotted paths: list them, read them, replace them.

A path is the way to a number through the frozen values: ``oscillator.damping``,
``oscillator.stops.0.restitution``, ``forcing.constant``, ``forcing.harmonics.1.phase``,
``start.x0``. With exactly one harmonic, ``forcing.omega``, ``forcing.amplitude`` and
``forcing.phase`` are short for those of ``forcing.harmonics.0``. A Fourier sum has
``forcing.omega``, its base frequency, and ``forcing.cos.0`` for the first of its ``cos``. Where
there is one frequency, ``forcing.period`` is 2 pi over it. A record has
``forcing.record.amplitude``, and ``forcing.record.omega`` where it is a wave. With a mass,
``oscillator.mass``, ``oscillator.damping_coefficient`` is another name of ``oscillator.damping``.

The name of a parameter (`percuss.model.expression`) is a path, too: it changes all numbers that are
expressions of it, which are no paths of their own then. The path of a number that is a parameter
alone is another name of it.
"""

from __future__ import annotations

import dataclasses
import difflib
import re
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias, TypeVar

from percuss.errors import ParameterError
from percuss.model.exact import Phase, PiTimes, angle, as_float, kept, pi_times
from percuss.model.expression import Expression, as_expression, parameters_in
from percuss.model.faults import draft, faults, raise_first
from percuss.model.force_record import ForceRecord
from percuss.model.forcing import Forcing, ForcingTerm, FourierTerm
from percuss.model.oscillator import Oscillator
from percuss.model.restitution import RestitutionTable
from percuss.model.start import Start

__all__ = [
    "MovedFields",
    "get_parameter",
    "long_form",
    "moved_fields",
    "moved_in_law",
    "parameter_paths",
    "replace_parameter",
    "replace_parameters",
]

Parts: TypeAlias = tuple[Oscillator, Forcing | None, Start | None]

T = TypeVar("T")

_PERIOD = "forcing.period"
_SHORT_FORMS = ("forcing.amplitude", "forcing.omega", "forcing.phase")
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


def parameter_paths(
    osc: Oscillator, force: Forcing | None = None, start: Start | None = None
) -> tuple[str, ...]:
    """Return the paths of all parameters, in their long form, without ``forcing.period``.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, or None.
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
    return tuple(_parameters(osc, force, start))


def get_parameter(osc: Oscillator, force: Forcing | None, start: Start | None, path: str) -> Phase:
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
    if name == _PERIOD and force is not None and force.given_period is None:
        times, plus = angle(pi_times(2) / as_expression(_one_frequency(force)[1]))
        return PiTimes(times, plus) if times else kept(plus)
    return _parameters(osc, force, start)[name]


def replace_parameter(
    osc: Oscillator, force: Forcing | None, start: Start | None, path: str, value: Phase
) -> Parts:
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
    osc: Oscillator,
    force: Forcing | None,
    start: Start | None,
    changes: Mapping[str, Phase],
) -> Parts:
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
    fields, by_path = _fields_of(osc, force, start), dict[str, Phase]()
    for path, value in changes.items():
        name = _long_form(path, fields, force)
        if name in by_path:
            before = next(other for other in changes if _long_form(other, fields, force) == name)
            raise ParameterError("path", (before, path), "the same parameter, named twice")
        by_path[name] = value
    by_path = _by_field(by_path, fields, force)
    if _changed(by_path, "oscillator"):
        osc = _replace_in_oscillator(osc, by_path)
        raise_first(faults(osc))
    if force is not None and _changed(by_path, "forcing"):
        force = _replace_in_forcing(force, by_path)
        raise_first(faults(force))
    if start is not None and _changed(by_path, "start"):
        start = _replace_fields(start, "start", by_path)
        raise_first(faults(start))
    return osc, force, start


def long_form(
    path: str,
    osc: Oscillator,
    force: Forcing | None = None,
    start: Start | None = None,
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
    return _long_form(path, _fields_of(osc, force, start), force)


def _long_form(path: str, fields: Mapping[str, Phase], force: Forcing | None) -> str:
    known = _free(fields)
    if path in known:
        return path
    short_forms = {}
    if force is not None and force.base is None and len(force.harmonics) == 1:
        short_forms = {short: short.replace(".", ".harmonics.0.") for short in _SHORT_FORMS}
    if "oscillator.mass" in fields:
        short_forms["oscillator.damping_coefficient"] = "oscillator.damping"
    long = short_forms.get(path, path)
    if path == _PERIOD and force is not None and force.given_period is None and force.frequency:
        long, _ = _one_frequency(force)
        if not _is_tied(fields[long]):
            return path
    if long in known:
        return long
    tied = fields.get(long)
    if isinstance(tied, Expression):
        if tied.is_parameter and path != _PERIOD:
            return tied.text
        names = " and ".join(tied.names)
        reason = f"tied to {names} by {long} = {tied}; change {names}"
        raise ParameterError("path", path, reason)
    raise ParameterError("path", path, _unknown(path, [*known, *short_forms], force))


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
    osc: Oscillator, force: Forcing | None, start: Start | None, path: str
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
    name, fields = long_form(path, osc, force, start), _fields_of(osc, force, start)
    own = "x"
    while own in parameters_in(*fields.values()):
        own += "_"
    if name in fields:
        return MovedFields(own, {name: Expression(own, ((own, fields[name]),))})
    if name == _PERIOD and force is not None:
        value = get_parameter(osc, force, start, name)
        omega, _ = _one_frequency(force)
        return MovedFields(own, {omega: Expression(f"2*pi/{own}", ((own, value),))})
    tied = {field: value for field, value in fields.items() if isinstance(value, Expression)}
    return MovedFields(name, {field: value for field, value in tied.items() if name in value.names})


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
    forcing.constant 0.0 0.0
    forcing.harmonics.0.amplitude 0.5 -0.25
    """
    moved = moved_fields(osc, force, None, path)
    if osc.mass is None:
        return moved
    osc = _replace_in_oscillator(osc, moved.fields)
    force = None if force is None else _replace_in_forcing(force, moved.fields)
    unit = None if force is None else force.acceleration_of(osc.mass)
    fields = _fields_of(osc.of_unit_mass(), unit, None)
    tied = {field: value for field, value in fields.items() if isinstance(value, Expression)}
    return MovedFields(
        moved.name, {field: value for field, value in tied.items() if moved.name in value.names}
    )


def _by_field(
    changes: Mapping[str, Phase], fields: Mapping[str, Phase], force: Forcing | None
) -> dict[str, Phase]:
    """Return changes of parameters as changes of fields."""
    by_field = dict(changes)
    if _PERIOD in by_field and _PERIOD not in fields and force is not None:
        omega, _ = _one_frequency(force)
        if omega in by_field:
            raise ParameterError("path", (_PERIOD, omega), "the same parameter, named twice")
        by_field[omega] = _frequency_of(by_field.pop(_PERIOD))
    names = {name: by_field.pop(name) for name in changes if name not in fields and "." not in name}
    if names:
        for field, value in fields.items():
            if isinstance(value, Expression) and not names.keys().isdisjoint(value.names):
                by_field[field] = value.replaced(names)
    return by_field


def _one_frequency(force: Forcing) -> tuple[str, Any]:
    """Return path and value of the one frequency of a forcing."""
    if force.base is not None:
        return "forcing.omega", force.base
    return "forcing.harmonics.0.omega", getattr(force.harmonics[0], "omega", None)


def _frequency_of(period: Phase) -> Any:
    """Return the frequency of a period, exactly."""
    if as_float(period) <= 0.0:
        raise ParameterError(_PERIOD, period, "not positive")
    times, plus = angle(period)
    return pi_times(2) / as_expression(period) if plus else kept(2 / times)


def _unknown(path: object, known: list[str], force: Forcing | None) -> str:
    if force is None and str(path).startswith("forcing."):
        return "no such parameter; the motion is free, it has no forcing"
    if force is not None and path in _SHORT_FORMS and len(force.harmonics) > 1:
        wanted = str(path).replace(".", ".harmonics.0.")
        if wanted in known:
            return f"one of {len(force.harmonics)} harmonics; write {wanted} for the first"
    alike = difflib.get_close_matches(str(path), known, n=3, cutoff=0.6)
    meant = _of_that_word(str(path), known)
    # A single word resembles no whole path, but may be the last word of one.
    similar = alike or meant if "." in str(path) else meant or alike
    hint = f"did you mean {' or '.join(similar)}?" if similar else f"there are {', '.join(known)}"
    return f"no such parameter; {hint}"


def _of_that_word(path: str, known: list[str]) -> list[str]:
    """Return the parameters that a word alone may mean, short forms in place of their long ones."""
    given = [word for word in path.lower().split(".") if not word.isdecimal()]
    word = _WORDS.get(given[-1], given[-1]) if given else ""
    named = [full for full in known if re.sub(r"(\.\d+)+$", "", full).endswith(f".{word}")]
    short = [full for full in named if full in _SHORT_FORMS]
    return (short or named)[:MOST_MEANT]


def _parameters(osc: Oscillator, force: Forcing | None, start: Start | None) -> dict[str, Phase]:
    """Return all parameters by their long form."""
    return _free(_fields_of(osc, force, start))


def _free(fields: Mapping[str, Phase]) -> dict[str, Phase]:
    """Return the fields that depend on no parameter, and the parameters of the others."""
    free = {path: value for path, value in fields.items() if not _is_tied(value)}
    return free if len(free) == len(fields) else free | parameters_in(*fields.values())


def _is_tied(value: object) -> bool:
    return isinstance(value, Expression) and bool(value.parameters)


def _fields_of(osc: Oscillator, force: Forcing | None, start: Start | None) -> dict[str, Phase]:
    """Return the numbers of all fields by their paths."""
    parameters: dict[str, Phase] = {
        "oscillator.stiffness": osc.stiffness,
        "oscillator.damping": osc.damping,
    }
    if osc.mass is not None:
        parameters["oscillator.mass"] = osc.mass
    for index, stop in enumerate(osc.stops):
        fields = _fields(stop)
        del fields["side"]
        if isinstance(fields.get("restitution"), RestitutionTable):
            del fields["restitution"]
        parameters |= {f"oscillator.stops.{index}.{name}": value for name, value in fields.items()}
    if force is not None:
        parameters |= _forcing_parameters(force)
    if start is not None:
        parameters |= {f"start.{name}": value for name, value in _fields(start).items()}
    return parameters


def _forcing_parameters(force: Forcing) -> dict[str, Phase]:
    parameters: dict[str, Phase] = {"forcing.constant": force.constant}
    if force.given_period is not None:
        parameters["forcing.period"] = force.given_period
    if force.base is not None:
        parameters["forcing.omega"] = force.base
    if force.record is not None:
        parameters["forcing.record.amplitude"] = force.record.amplitude
        if force.record.omega is not None:
            parameters["forcing.record.omega"] = force.record.omega
    for index, part in enumerate(force.harmonics):
        parameters |= {path: _fields(part)[name] for path, name in _part_paths(index, part).items()}
    return parameters


def _part_paths(index: int, part: ForcingTerm) -> dict[str, str]:
    """Return the names of the fields of a part of a forcing by their paths."""
    if isinstance(part, FourierTerm):
        return {f"forcing.{name}.{index}": name for name in ("cos", "sin")}
    return {f"forcing.harmonics.{index}.{name}": name for name in _fields(part)}


def _changed(by_path: Mapping[str, Phase], owner: str) -> bool:
    return any(path.startswith(f"{owner}.") for path in by_path)


def _replace_in_oscillator(osc: Oscillator, by_path: Mapping[str, Phase]) -> Oscillator:
    stops = tuple(
        _replace_fields(stop, f"oscillator.stops.{index}", by_path)
        for index, stop in enumerate(osc.stops)
    )
    return _replace_fields(
        draft(Oscillator, **_fields(osc) | {"stops": stops}), "oscillator", by_path
    )


def _replace_in_forcing(force: Forcing, by_path: Mapping[str, Phase]) -> Forcing:
    parts = tuple(
        draft(
            type(part),
            **_fields(part)
            | {
                name: by_path[path]
                for path, name in _part_paths(index, part).items()
                if path in by_path
            },
        )
        for index, part in enumerate(force.harmonics)
    )
    return draft(
        Forcing,
        harmonics=parts,
        constant=by_path.get("forcing.constant", force.constant),
        period=by_path.get("forcing.period", force.given_period),
        base=by_path.get("forcing.omega", force.base),
        record=_replace_in_record(force.record, by_path),
        is_per_mass=force.is_per_mass,
    )


def _replace_in_record(
    record: ForceRecord | None, by_path: Mapping[str, Phase]
) -> ForceRecord | None:
    names = ("amplitude", "omega")
    paths = {name: f"forcing.record.{name}" for name in names}
    new = {name: by_path[path] for name, path in paths.items() if path in by_path}
    return record if record is None or not new else record.with_fields(**new)


def _replace_fields(value: T, prefix: str, by_path: Mapping[str, Phase]) -> T:
    fields = _fields(value)
    new = {name: by_path.get(f"{prefix}.{name}", old) for name, old in fields.items()}
    return draft(type(value), **new)


def _fields(value: Any) -> dict[str, Any]:
    return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
