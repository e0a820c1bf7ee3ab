"""The kinds of results that can be saved: their names, their tables and their records."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Complexes
from percuss.ensembles.measures import outcome_dimensions
from percuss.errors import ParameterError
from percuss.io.column_units import Columns
from percuss.io.fit_tables import (
    covariance_columns,
    fit_impact_columns,
    fitted_columns,
    profile_columns,
    residual_columns,
)
from percuss.io.study_text import branch_text, motion_text, orbit_text, response_text
from percuss.model.dimensions import unit_of_setting
from percuss.model.units import in_units, is_unit
from percuss.motion.tables import HasTable
from percuss.orbits.bifurcations.structure_branch import StructureBranch

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

    from percuss.optimization.design import Design
    from percuss.optimization.pareto import ParetoFront
    from percuss.orbits.bifurcations.branch import Branch
    from percuss.orbits.bifurcations.curve import Curve
    from percuss.orbits.bifurcations.structure_curve import StructureCurve
    from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
    from percuss.orbits.orbit.structure_orbit import StructureOrbit
    from percuss.orbits.responses.response import Response


def orbit_columns(orbits: Sequence[PeriodicOrbit]) -> Columns:
    """Return orbits as a table, one row an orbit."""
    names = ("n_impacts", "n_periods", "period", "t0", "x0", "v0", "min_impact_speed",
             "grazing_margin", "stability", "admissible", "isolated", "residual")  # fmt: skip
    columns = _fields_of(orbits, names)
    multipliers = np.array([orbit.multipliers for orbit in orbits]).reshape(-1, 2)
    columns |= _of_multipliers(multipliers)
    stops = [" ".join(map(str, orbit.sequence)) for orbit in orbits]
    return columns | {"stops": np.array(stops, dtype=object)}


def _fields_of(orbits: Sequence[Any], names: Sequence[str]) -> dict[str, NDArray[Any]]:
    return {name: np.array([getattr(one, name) for one in orbits], dtype=object) for name in names}


def structure_orbit_columns(orbits: Sequence[StructureOrbit]) -> Columns:
    """Return orbits of a structure as a table, one row an orbit."""
    names = ("n_impacts", "n_periods", "period", "is_stable", "residual")
    columns = _fields_of(orbits, names)
    for name in ("x0", "v0"):
        states = np.array([getattr(orbit, name) for orbit in orbits])
        columns |= {f"{name}_{i}": column for i, column in enumerate(states.T)}
    return columns | _of_multipliers(np.array([orbit.multipliers for orbit in orbits]))


def branch_columns(branch: Branch) -> Columns:
    """Return a branch as a table, one row an orbit."""
    velocities = {
        f"impact_velocity_{i}": column for i, column in enumerate(branch.impact_velocity.T)
    }
    return {
        branch.path: branch.values,
        "arclength": branch.arclength,
        "period": branch.period,
        **velocities,
        **_of_multipliers(branch.multipliers),
        "stability": branch.stability,
        "admissible": branch.admissible,
        "grazing_margin": branch.grazing_margin,
        "special_point": _kinds_in_rows(branch),
    }


def structure_branch_columns(branch: StructureBranch) -> Columns:
    """Return a branch of a structure as a table, one row an orbit."""
    amplitudes = {f"amplitude_{i}": column for i, column in enumerate(branch.amplitude.T)}
    return {
        branch.path: branch.values,
        **amplitudes,
        "n_impacts": branch.n_impacts,
        "is_stable": branch.is_stable,
        "admissible": branch.admissible,
        "special_point": _kinds_in_rows(branch),
        **_of_multipliers(branch.multipliers),
    }


def search_columns(design: Design) -> Columns:
    """Return the searches of a design as a table, the best one first."""
    rows = design.attempts
    return {
        **{path: np.array([row.values[path] for row in rows]) for path in design.values},
        design.outcome: np.array([row.value for row in rows]),
        "reason": np.array([row.reason for row in rows], dtype=object),
    }


def best_columns(design: Design) -> Columns:
    """Return the setting of a design: a row for the outcome, each parameter and each limit.

    The derivatives are those of the outcome; of the outcomes there are none.
    """
    osc, force = design.oscillator, design.forcing
    limits = [
        (-np.inf if low is None else low, np.inf if high is None else high)
        for low, high in design.limits.values()
    ]
    values = {design.outcome: design.value} | design.values | design.outcomes
    ends = [(np.nan, np.nan), *design.bounds.values(), *limits]
    slopes = [np.nan, *design.gradient.tolist(), *(np.nan for _ in limits)]
    outcomes = {design.outcome, *design.outcomes}
    units = [
        in_units(osc.units, outcome_dimensions(name, osc))
        if name in outcomes
        else unit_of_setting(name, osc, force)
        for name in values
    ]
    return {
        "name": np.array(list(values), dtype=object),
        "value": np.array(list(values.values())),
        "unit": np.array([unit if is_unit(unit) else "" for unit in units], dtype=object),
        "least": np.array([low for low, _ in ends]),
        "largest": np.array([high for _, high in ends]),
        "derivative": np.array(slopes),
        "active": np.array([name in design.active for name in values]),
    }


def front_columns(front: ParetoFront) -> Columns:
    """Return a front as a table, one row a design."""
    first = front.designs[0]
    return {
        **dict(zip(front.outcomes, front.values.T, strict=True)),
        **{
            path: np.array([design.values[path] for design in front.designs])
            for path in first.values
        },
        "reason": np.array([design.reason for design in front.designs], dtype=object),
    }


def structure_response_columns(response: Response) -> Columns:
    """Return the branches of a structure's response as a table, one row an orbit."""
    quantities = ("amplitude", "largest_displacement", "impact_velocity")

    def columns(number: int) -> Columns:
        branch = response.branches[number]
        measured = {name: getattr(response, name)[number] for name in quantities}
        periods = np.array([orbit.n_periods for orbit in branch.orbits])
        rows = {branch.path: branch.values, **measured, "n_periods": periods}
        return {**rows, **structure_branch_columns(branch)}

    table: Columns = _many(columns, "branch")(range(len(response.branches)))
    return table


def curve_columns(curve: Curve) -> Columns:
    """Return a curve of special points as a table, one row an orbit."""
    return {
        **dict(zip(curve.paths, curve.values.T, strict=True)),
        "arclength": curve.arclength,
        **_of_multipliers(curve.multipliers),
        "stability": curve.stability,
        "admissible": curve.admissible,
        "special_point": _kinds_in_rows(curve),
    }


def structure_curve_columns(curve: StructureCurve) -> Columns:
    """Return a curve of a structure as a table, one row an orbit."""
    return {
        **dict(zip(curve.paths, curve.values.T, strict=True)),
        "special_point": _kinds_in_rows(curve),
        **_of_multipliers(curve.multipliers),
    }


def _kinds_in_rows(followed: Branch | StructureBranch | Curve | StructureCurve) -> NDArray[Any]:
    """Return the kind of the special point of each row, empty where it is none."""
    kinds = np.full(len(followed), "", dtype=object)
    for point in followed.special_points:
        kinds[point.row] = point.kind
    return kinds


def _of_multipliers(multipliers: Complexes) -> dict[str, NDArray[Any]]:
    return {
        f"multiplier_{part}_{i}": np.asarray(getattr(multipliers[:, i], part))
        for i in range(multipliers.shape[1])
        for part in ("real", "imag")
    }


def _attractor_columns(data: Dataset) -> Columns:
    """Return the variables of the attractors alone as a table."""
    own = {str(name): variable.values
           for name, variable in data.data_vars.items() if variable.dims == ("attractor",)}  # fmt: skip
    return {"attractor": np.arange(data.sizes["attractor"])} | own


def dataset_columns(data: Dataset) -> Columns:
    """Return the variables of the most dimensions as a table, one row a point of them all.

    Variables of fewer dimensions are repeated along the others; those of none of these are left
    out, as the coordinates without numbers are.
    """
    widest = max(
        (variable for variable in data.data_vars.values()), key=lambda variable: variable.size
    )
    dims = widest.dims
    shape = widest.shape
    columns: dict[str, NDArray[Any]] = {}
    for i, dim in enumerate(dims):
        values = data[dim].values if dim in data.coords else np.arange(shape[i])
        along = values.reshape([-1 if k == i else 1 for k in range(len(dims))])
        columns[str(dim)] = np.broadcast_to(along, shape).ravel()
    # Parameters that vary along a dimension first.
    varying = {name: data[name] for name in data.coords if name not in dims}
    for name, variable in [*varying.items(), *data.data_vars.items()]:
        if variable.dims and set(variable.dims) <= set(dims):
            wide = variable.broadcast_like(widest).transpose(*dims)
            columns[str(name)] = wide.values.ravel()
    return columns


Tables: TypeAlias = "dict[str, Dataset]"

# Equally spaced times of a motion.
SAMPLES = 2001

IMPACTS: tuple[str, ...] = ("t", "v_before", "v_after", "stop", "cycle", "impulse")
STRUCTURE_IMPACTS: tuple[str, ...] = (*IMPACTS, "effective_mass")
CONTACTS: tuple[str, ...] = ("start", "release", "stop", "n_impacts", "error_bound")
CROSSINGS: tuple[str, ...] = ("t", "v", "stop", "direction")


@dataclass(frozen=True, slots=True)
class ResultKind:
    """A kind of results that can be saved.

    Attributes
    ----------
    name, title
        The name and title in the attributes of its file.
    outcome
        Returns how it ended, in words.
    columns
        The tables that can be saved as CSV, by name; the first one is the default.
    study
        Returns a study that repeats it, as TOML text; empty where the result does not determine it.
    tables
        Returns datasets for other programs, by the names of their groups.
    is_whole
        Whether its file holds the whole result, to the bit; else the tables alone.
    """

    name: str
    title: str
    outcome: Callable[[Any], str]
    columns: Mapping[str, Callable[[Any], Columns]]
    study: Callable[[Any], str] = lambda _: ""
    tables: Callable[[Any], Tables] = lambda _: {}
    is_whole: bool = True


def kind_of(result: Any) -> ResultKind:
    """Return the kind of a result.

    Raises
    ------
    ParameterError
        If it is no result that percuss can save.
    """
    if isinstance(result, list | tuple):
        return _kind_of_list(result)
    name = type(result).__name__
    if name == "Response" and any(
        isinstance(branch, StructureBranch) for branch in result.branches
    ):
        name = "StructureResponse"
    kind = _KINDS.get(name)
    if kind is None:
        known = "a run, an orbit, a list of them, a branch, a curve, a response, a fit or a dataset"
        table = "; its table is in to_pandas() and to_xarray()" * isinstance(result, HasTable)
        raise ParameterError("result", result, f"not {known}{table}")
    return kind


def _kind_of_list(results: Sequence[Any]) -> ResultKind:
    kinds = {type(result).__name__ for result in results}
    for name, kind in _LISTS.items():
        if kinds <= {name}:
            return kind
    raise ParameterError("result", sorted(kinds), f"not a list of one of {', '.join(_LISTS)}")


def table_of(result: Any, name: str, samples: int | None = None) -> Columns:
    """Return a table of a result.

    Parameters
    ----------
    result
        The result; a list may be empty.
    name
        Name of the table.
    samples
        Number of times of a motion.
    """
    if isinstance(result, list | tuple) and not result:
        return next(kind.columns[name] for kind in _LISTS.values() if name in kind.columns)(result)
    if name == "motion":
        return _motion_columns(result, SAMPLES if samples is None else samples)
    return kind_of(result).columns[name](result)


def _motion_columns(result: Any, samples: int = SAMPLES) -> Columns:
    run = result if hasattr(result, "sample") else result.trajectory()
    data = run.sample(samples)
    columns = {"t": data["t"].values}
    for name in ("x", "v"):
        values = data[name].values
        # Those of a structure are a column for each coordinate.
        own = {f"{name}{i}": column for i, column in enumerate(values.T)}
        columns |= {name: values} if values.ndim == 1 else own
    model = getattr(run, "structure", None) or run.oscillator
    if model.stops:
        forces = run.forces(columns["t"]).stops.transpose("stop", "t").values
        columns |= dict(zip(_names_of_forces(len(forces)), forces, strict=True))
    return columns


def _names_of_forces(n: int) -> list[str]:
    """Return the names of the columns of the forces of stops."""
    return ["stop_force"] if n == 1 else [f"stop_force_{i}" for i in range(n)]


def _table(name: str, columns: Sequence[str]) -> Callable[[Any], Columns]:
    return lambda result: {column: getattr(getattr(result, name), column) for column in columns}


def _special_columns(branch: Branch | StructureBranch) -> Columns:
    points = branch.special_points
    ends: Columns = {}
    if not isinstance(branch, StructureBranch):
        intervals = np.array([point.interval for point in branch.special_points]).reshape(-1, 2)
        ends = dict(zip(("low", "high"), intervals.T, strict=True))
    return {
        "kind": np.array([point.kind for point in points], dtype=object),
        branch.path: np.array([point.value for point in points]),
        **ends,
        "status": np.array([point.status for point in points], dtype=object),
        "row": np.array([point.row for point in points], dtype=np.int64),
        "detail": np.array([point.detail for point in points], dtype=object),
    }


def _multipliers_dataset(orbit: StructureOrbit) -> Dataset:
    import xarray

    parts = {"real": orbit.multipliers.real, "imag": orbit.multipliers.imag}
    return xarray.Dataset(
        {f"multiplier_{name}": ("multiplier", values) for name, values in parts.items()}
    )


def _many(columns: Callable[[Any], Columns], number: str) -> Callable[[Any], Columns]:
    """Return the columns of several results one below the other, after the number of the result."""

    def joined(results: Sequence[Any]) -> Columns:
        parts = [columns(result) for result in results]
        names = list(dict.fromkeys(name for part in parts for name in part))
        lengths = np.array([len(next(iter(part.values()))) for part in parts], dtype=np.int64)
        table: dict[str, Any] = {number: np.repeat(np.arange(len(parts)), lengths)}
        for name in names:
            pieces = [part.get(name, np.full(n, "", dtype=object))
                      for part, n in zip(parts, lengths, strict=True)]  # fmt: skip
            table[name] = np.concatenate([np.asarray(piece, dtype=object) for piece in pieces])
        return table

    return joined


def _tables_of_each(name: str) -> Callable[[Any], Tables]:
    return lambda results: {f"{name}_{i}": result.to_xarray() for i, result in enumerate(results)}


def _orbits_outcome(orbits: Sequence[PeriodicOrbit | StructureOrbit]) -> str:
    stable = sum(orbit.is_stable for orbit in orbits)
    return f"{len(orbits)} periodic orbits were found, {stable} of them stable"


def _end_reasons(results: Sequence[Any]) -> str:
    return "; ".join(dict.fromkeys(str(result.end_reason) for result in results))


def _dataset_outcome(dataset: Any) -> str:
    complete = dataset.attrs.get("complete", 1)
    return "all points were done" if complete else "it was interrupted; it holds what was done"


_KINDS: dict[str, ResultKind] = {
    "Trajectory": ResultKind(
        "motion",
        "one motion",
        lambda run: str(run.outcome.value),
        {
            "impacts": _table("impacts", IMPACTS),
            "crossings": _table("crossings", CROSSINGS),
            "motion": _motion_columns,
        },
        study=motion_text,
    ),
    "StructureTrajectory": ResultKind(
        "motion",
        "one motion of a structure",
        lambda run: str(run.outcome.value),
        {
            "impacts": _table("impacts", STRUCTURE_IMPACTS),
            "crossings": _table("crossings", CROSSINGS),
            "contacts": _table("contacts", CONTACTS),
            "motion": _motion_columns,
        },
        study=motion_text,
    ),
    "PeriodicOrbit": ResultKind(
        "orbit",
        "a periodic orbit",
        lambda orbit: repr(orbit)[1:-1],
        {
            "impacts": _table("impacts", IMPACTS),
            "orbit": lambda orbit: orbit_columns([orbit]),
            "motion": _motion_columns,
        },
        study=orbit_text,
        tables=lambda orbit: {"impacts": orbit.impacts.to_xarray()},
    ),
    "Branch": ResultKind(
        "branch",
        "a branch of periodic orbits",
        lambda branch: str(branch.end_reason),
        {"branch": branch_columns, "special_points": _special_columns},
        study=branch_text,
        tables=lambda branch: {"branch": branch.to_xarray()},
    ),
    "StructureOrbit": ResultKind(
        "orbit",
        "a periodic orbit of a structure",
        lambda orbit: repr(orbit)[1:-1],
        {
            "impacts": lambda orbit: _table("impacts", STRUCTURE_IMPACTS)(orbit.run),
            "motion": lambda orbit: _motion_columns(orbit.run),
        },
        tables=lambda orbit: {"multipliers": _multipliers_dataset(orbit)},
    ),
    "StructureBranch": ResultKind(
        "branch",
        "a branch of periodic orbits of a structure",
        lambda branch: str(branch.end_reason),
        {"branch": structure_branch_columns, "special_points": _special_columns},
        tables=lambda branch: {"branch": branch.to_xarray()},
    ),
    "StructureCurve": ResultKind(
        "curve",
        "a curve of special points of a structure",
        lambda curve: str(curve.end_reason),
        {"curve": structure_curve_columns},
        tables=lambda curve: {"curve": curve.to_xarray()},
    ),
    "Curve": ResultKind(
        "curve",
        "a curve of special points",
        lambda curve: str(curve.end_reason),
        {"curve": curve_columns},
        tables=lambda curve: {"curve": curve.to_xarray()},
    ),
    "Response": ResultKind(
        "response",
        "the branches of a response",
        lambda response: f"{len(response.branches)} branches were found",
        {
            "response": lambda response: _many(branch_columns, "branch")(response.branches),
            "special_points": lambda response: _many(_special_columns, "branch")(response.branches),
        },
        study=response_text,
        tables=lambda response: {"response": response.to_xarray()},
    ),
    "StructureResponse": ResultKind(
        "response",
        "the branches of a structure's response",
        lambda response: f"{len(response.branches)} branches were found",
        {
            "response": structure_response_columns,
            "special_points": lambda response: _many(_special_columns, "branch")(response.branches),
        },
        study=response_text,
        tables=lambda response: {"response": response.to_xarray()},
    ),
    "Design": ResultKind(
        "design",
        "the best setting of a design",
        lambda design: design.reason or "an optimum",
        {"searches": search_columns, "best": best_columns},
        is_whole=False,
    ),
    "ParetoFront": ResultKind(
        "design",
        "a front between two outcomes",
        lambda front: repr(front)[1:-1],
        {"front": front_columns},
        is_whole=False,
    ),
    "Fit": ResultKind(
        "fit",
        "parameters fitted to records",
        lambda fit: fit.reason or "converged",
        {
            "parameters": fitted_columns,
            "covariance": covariance_columns,
            "residuals": residual_columns,
            "impacts": fit_impact_columns,
            "profiles": profile_columns,
        },
        is_whole=False,
    ),
    "Dataset": ResultKind(
        "dataset",
        "many motions",
        _dataset_outcome,
        {"table": dataset_columns, "attractors": _attractor_columns},
    ),
}
_LISTS: dict[str, ResultKind] = {
    "PeriodicOrbit": ResultKind(
        "orbits",
        "periodic orbits",
        _orbits_outcome,
        {"orbits": orbit_columns},
        study=lambda orbits: orbit_text(orbits[0]) if orbits else "",
    ),
    "Branch": ResultKind(
        "branches",
        "branches of periodic orbits",
        _end_reasons,
        {"branches": _many(branch_columns, "branch")},
        study=lambda branches: branch_text(branches[0]),
        tables=_tables_of_each("branch"),
    ),
    "Curve": ResultKind(
        "curves",
        "curves of special points",
        _end_reasons,
        {"curves": _many(curve_columns, "curve")},
        tables=_tables_of_each("curve"),
    ),
    "StructureOrbit": ResultKind(
        "orbits",
        "periodic orbits of a structure",
        _orbits_outcome,
        {"orbits": structure_orbit_columns},
    ),
    "StructureCurve": ResultKind(
        "curves",
        "curves of special points of a structure",
        _end_reasons,
        {"curves": _many(structure_curve_columns, "curve")},
        tables=_tables_of_each("curve"),
    ),
}
