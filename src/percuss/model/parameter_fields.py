"""The numbers of a model by their paths, and models with other numbers at them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from typing import Any, TypeAlias, TypeVar, cast

from percuss.model.exact import Exact, Phase
from percuss.model.expression import Expression, parameters_in
from percuss.model.faults import draft
from percuss.model.force_record import ForceRecord
from percuss.model.forcing import Forcing, ForcingTerm, FourierTerm
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, Stop
from percuss.model.restitution import RestitutionTable
from percuss.model.start import Start
from percuss.model.structure import MatrixRows, Structure
from percuss.model.structure_start import StructureStart

AnyForce: TypeAlias = Forcing | Loads | None
AnyStart: TypeAlias = Start | StructureStart | None
T = TypeVar("T")

# The beginnings of the paths.
PREFIXES: dict[type, str] = {
    Oscillator: "oscillator",
    Structure: "structure",
    Forcing: "forcing",
    Loads: "loads",
}


def forcings_by_name(force: AnyForce) -> dict[str, Forcing]:
    """Return the forcings by the beginning of their paths."""
    if isinstance(force, Loads):
        return {f"loads.{i}": forcing for i, forcing in enumerate(force.forcings)}
    return {} if force is None else {"forcing": force}


def parameters_by_path(
    osc: Oscillator | Structure, force: AnyForce, start: AnyStart
) -> dict[str, Phase]:
    """Return all parameters by their long form."""
    return free_parameters(fields_by_path(osc, force, start))


def free_parameters(fields: Mapping[str, Phase]) -> dict[str, Phase]:
    """Return the fields that depend on no parameter, and the parameters of the others."""
    free = {path: value for path, value in fields.items() if not is_tied(value)}
    return free if len(free) == len(fields) else free | parameters_in(*fields.values())


def is_tied(value: object) -> bool:
    """Return whether a number is an expression of parameters."""
    return isinstance(value, Expression) and bool(value.parameters)


def fields_by_path(
    osc: Oscillator | Structure, force: AnyForce, start: AnyStart
) -> dict[str, Phase]:
    """Return the numbers of all fields by their paths."""
    parameters: dict[str, Phase] = {}
    if isinstance(osc, Structure):
        parameters |= osc.matrix_entries
    else:
        parameters |= {
            "oscillator.stiffness": osc.stiffness,
            "oscillator.damping": osc.damping,
        }
        if osc.mass is not None:
            parameters["oscillator.mass"] = osc.mass
    for index, stop in enumerate(osc.stops):
        fields = _fields(stop)
        del fields["side"], fields["on"]
        if isinstance(fields.get("restitution"), RestitutionTable):
            fields |= _table_fields(fields.pop("restitution"))
        path = f"{PREFIXES[type(osc)]}.stops.{index}"
        parameters |= {f"{path}.{name}": value for name, value in fields.items()}
    for name, forcing in forcings_by_name(force).items():
        parameters |= _forcing_parameters(forcing, name)
    if isinstance(force, Loads) and force.given_period is not None:
        parameters["loads.period"] = force.given_period
    if start is not None:
        parameters |= _start_parameters(start)
    return parameters


def _start_parameters(start: Start | StructureStart) -> dict[str, Phase]:
    if isinstance(start, Start):
        return {f"start.{name}": value for name, value in _fields(start).items()}
    parameters: dict[str, Phase] = {}
    for name in ("x0", "v0"):
        values = getattr(start, name)
        parameters |= {f"start.{name}.{i}": value for i, value in enumerate(values)}
    return parameters | {"start.t0": start.t0}


def _forcing_parameters(force: Forcing, name: str) -> dict[str, Phase]:
    parameters: dict[str, Phase] = {f"{name}.constant": force.constant}
    if force.given_period is not None:
        parameters[f"{name}.period"] = force.given_period
    if force.base is not None:
        parameters[f"{name}.omega"] = force.base
    if force.record is not None:
        parameters[f"{name}.record.amplitude"] = force.record.amplitude
        if force.record.omega is not None:
            parameters[f"{name}.record.omega"] = force.record.omega
    for index, part in enumerate(force.harmonics):
        paths = _part_paths(index, part, name)
        parameters |= {path: _fields(part)[own] for path, own in paths.items()}
    return parameters


def _part_paths(index: int, part: ForcingTerm, name: str) -> dict[str, str]:
    """Return the names of the fields of a part of a forcing by their paths."""
    if isinstance(part, FourierTerm):
        return {f"{name}.{own}.{index}": own for own in ("cos", "sin")}
    return {f"{name}.harmonics.{index}.{own}": own for own in _fields(part)}


def is_changed(by_path: Mapping[str, Phase], owner: str) -> bool:
    """Return whether a number of a part of the model is among those that are replaced."""
    return any(path.startswith(f"{owner}.") for path in by_path)


def with_values(value: T, by_path: Mapping[str, Phase]) -> T:
    """Return a system, a force or a start with other numbers, not checked yet."""
    new: Any
    if isinstance(value, Structure):
        new = _replace_in_structure(value, by_path)
    elif isinstance(value, Oscillator):
        fields = _fields(value) | {"stops": _replace_in_stops(value.stops, "oscillator", by_path)}
        new = _replace_fields(draft(Oscillator, **fields), "oscillator", by_path)
    elif isinstance(value, Loads):
        items = zip(value.items, forcings_by_name(value).items(), strict=True)
        new = draft(
            Loads,
            items=tuple((on, _replace_in_forcing(forcing, name, by_path))
                        for (on, _), (name, forcing) in items),
            period=by_path.get("loads.period", value.given_period),
        )  # fmt: skip
    elif isinstance(value, Forcing):
        new = _replace_in_forcing(value, "forcing", by_path)
    elif isinstance(value, StructureStart):
        new = draft(
            StructureStart,
            x0=_replace_in_row(value.x0, "start.x0", by_path),
            v0=_replace_in_row(value.v0, "start.v0", by_path),
            t0=by_path.get("start.t0", value.t0),
        )
    else:
        new = _replace_fields(value, "start", by_path)
    return cast("T", new)


def _replace_in_structure(structure: Structure, by_path: Mapping[str, Phase]) -> Structure:
    def replaced(name: str) -> MatrixRows:
        return tuple(
            _replace_in_row(row, f"structure.{name}.{i}", by_path)
            for i, row in enumerate(getattr(structure, name))
        )

    mass = replaced("mass")
    n = len(mass)
    fields = _fields(structure) | {
        "mass": tuple(tuple(mass[min(i, j)][max(i, j)] for j in range(n)) for i in range(n)),
        "stiffness": replaced("stiffness"),
        "damping": replaced("damping"),
        "stops": _replace_in_stops(structure.stops, "structure", by_path),
    }
    return draft(Structure, **fields)


def _replace_in_row(
    row: tuple[Exact, ...], prefix: str, by_path: Mapping[str, Phase]
) -> tuple[Any, ...]:
    return tuple(by_path.get(f"{prefix}.{i}", value) for i, value in enumerate(row))


def _replace_in_stops(
    stops: tuple[Stop, ...], prefix: str, by_path: Mapping[str, Phase]
) -> tuple[Stop, ...]:
    return tuple(
        _replace_fields(stop, f"{prefix}.stops.{index}", by_path)
        for index, stop in enumerate(stops)
    )


def _replace_in_forcing(force: Forcing, name: str, by_path: Mapping[str, Phase]) -> Forcing:
    if not is_changed(by_path, name):
        return force
    parts = tuple(
        draft(
            type(part),
            **_fields(part)
            | {
                own: by_path[path]
                for path, own in _part_paths(index, part, name).items()
                if path in by_path
            },
        )
        for index, part in enumerate(force.harmonics)
    )
    return draft(
        Forcing,
        harmonics=parts,
        constant=by_path.get(f"{name}.constant", force.constant),
        period=by_path.get(f"{name}.period", force.given_period),
        base=by_path.get(f"{name}.omega", force.base),
        record=_replace_in_record(force.record, name, by_path),
        is_per_mass=force.is_per_mass,
    )


def _replace_in_record(
    record: ForceRecord | None, name: str, by_path: Mapping[str, Phase]
) -> ForceRecord | None:
    paths = {own: f"{name}.record.{own}" for own in ("amplitude", "omega")}
    new = {own: by_path[path] for own, path in paths.items() if path in by_path}
    return record if record is None or not new else record.with_fields(**new)


def _replace_fields(value: T, prefix: str, by_path: Mapping[str, Phase]) -> T:
    fields = _fields(value)
    new = {name: by_path.get(f"{prefix}.{name}", old) for name, old in fields.items()}
    table = fields.get("restitution")
    if isinstance(table, RestitutionTable) and is_changed(by_path, f"{prefix}.restitution"):
        parts = {
            name: tuple(
                by_path.get(f"{prefix}.restitution.{name}.{i}", old)
                for i, old in enumerate(getattr(table, name))
            )
            for name in ("speeds", "values")
        }
        new["restitution"] = draft(RestitutionTable, **parts)
    return draft(type(value), **new)


def _table_fields(table: RestitutionTable) -> dict[str, Phase]:
    """Return the numbers of a table of restitutions by the ends of their paths."""
    return {
        f"restitution.{name}.{i}": value
        for name in ("speeds", "values")
        for i, value in enumerate(getattr(table, name))
    }


def _fields(value: Any) -> dict[str, Any]:
    kind: Any = type(value)
    return {name: getattr(value, name) for name in _names_of(kind)}


@cache
def _names_of(kind: Any) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(kind))
