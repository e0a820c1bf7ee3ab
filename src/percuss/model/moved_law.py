"""The derivative of a law by parameters, as the kernels of sensitivities take it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels.flight_columns import Change
from percuss.kernels.law_columns import Law
from percuss.model.exact import as_float
from percuss.model.expression import Expression, parameters_in
from percuss.model.forcing import Forcing, FourierTerm, Harmonic
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.parameter_fields import fields_by_path, parameters_by_path
from percuss.model.paths import long_forms, moved_fields, moved_in_law
from percuss.model.restitution import RestitutionTable
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.model.system import System, region_rows, touching_stops
from percuss.numerics import cos, sin

START = "start."
# Frequencies that a parameter moves in proportion do so to this part.
ALIKE = 1e-12


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class MovedLaw:
    """The derivatives of the law of a system and of the start of a motion by parameters.

    Attributes
    ----------
    paths
        The parameters, in their long form.
    change
        The derivatives of the law by them, (n_parameters, n_rows, columns).
    begin
        Those of x, v and t of the start, (n_parameters, 3).
    stops
        Those of the place, the stiffness and the damping of each stop, per unit mass,
        (n_parameters, n_stops, 3).
    """

    paths: tuple[str, ...]
    change: Change
    begin: Floats
    stops: Floats


def moved_law(
    system: System, start: Start | None, paths: Sequence[str], end: object = None
) -> MovedLaw:
    """Return the derivatives of the law of a system, and of a start, by parameters.

    Parameters
    ----------
    system
        Oscillator and forcing.
    start
        The start of the motion; None: it is no parameter.
    paths
        Paths of the parameters, in long or short form; names of parameters in expressions too.
    end
        What ends the motion, whose parameters may be named, too: they move nothing of the law.

    Returns
    -------
    MovedLaw
        The derivatives, from those of the expressions, exact to rounding.

    Raises
    ------
    ParameterError
        If there is no such parameter, one is named twice, or none at all; and for the coefficients
        of a term of a Fourier sum that is left out since it is zero.

    Examples
    --------
    >>> from percuss.model import cosine, impact_oscillator
    >>> system = System(impact_oscillator("0.8"), cosine(2))
    >>> moved = moved_law(system, Start(0, 1), ["start.v0", "forcing.omega"])
    >>> moved.paths, moved.begin[0]
    (('start.v0', 'forcing.harmonics.0.omega'), array([0., 1., 0.]))
    """
    osc, force = system
    names = parameter_names(paths, osc, force, start, end)
    of_end = set(parameters_in(end))
    if of_end:
        of_end -= parameters_by_path(osc, force, start).keys()
    law = system.law
    begin = np.zeros((len(names), 3))
    stops = np.zeros((len(names), len(osc.stops), 3))
    moved_law_rows = []
    needs_unit = False
    for p, name in enumerate(names):
        fields = {} if name in of_end else _derivatives(system, start, name)
        begin[p] = [fields.get(START + field, 0.0) for field in ("x0", "v0", "t0")]
        stops[p] = moved_stops("oscillator", len(osc.stops), fields)
        moved_law_rows.append(moved_rows(system, fields))
        needs_unit = needs_unit or fields.get("forcing.record.amplitude", 0.0) != 0.0
    rows = np.array(moved_law_rows)
    change = Change(rows, unit_law(force) if needs_unit else law)
    return MovedLaw(names, change, begin, stops)


def moved_stops(owner: str, n_stops: int, fields: Mapping[str, float]) -> Floats:
    """Return the derivatives of place, stiffness and damping of each stop, (n_stops, 3)."""
    paths = [
        [f"{owner}.stops.{i}.{field}" for field in ("at", "stiffness", "damping")]
        for i in range(n_stops)
    ]
    return np.array([[fields.get(path, 0.0) for path in own] for own in paths]).reshape(n_stops, 3)


def check_paths(name: str, paths: Sequence[str]) -> None:
    """Raise a `ParameterError` with this name unless paths is a list of some."""
    if isinstance(paths, str) or not len(paths):
        raise ParameterError(name, paths, 'no list of paths; give one such as ["start.v0"]')


def parameter_names(
    paths: Sequence[str],
    osc: Oscillator | Structure,
    force: Forcing | Loads | None,
    start: Start | StructureStart | None,
    end: object = None,
) -> tuple[str, ...]:
    """Return the long form of each path; that of a parameter of the end is its name.

    Raises
    ------
    ParameterError
        If there is no such parameter, one is named twice, or none at all.
    """
    check_paths("paths", paths)
    names: list[str] = []
    of_end = parameters_in(end)
    of_motion = [path for path in paths if path not in of_end]
    long = dict(zip(of_motion, long_forms(of_motion, osc, force, start), strict=True))
    for path in paths:
        name = long.get(path, path)
        if name in names:
            raise ParameterError("paths", path, "the same parameter, named twice")
        names.append(name)
    return tuple(names)


def moved_period(
    rates: Floats, osc: Oscillator | Structure, force: Forcing | Loads | None, names: Sequence[str]
) -> Floats:
    """Return the derivatives of the logarithm of the period of several forces by parameters.

    Parameters
    ----------
    rates
        (n_forces, n_parameters) array, those of the logarithm of the frequency of each force.
    osc, force
        What they act on, and the forces.
    names
        The parameters, in their long form.

    Returns
    -------
    (n_parameters,) array
        The derivatives; NaN where a parameter leaves the forces without a common period, or without
        the one that was given.

    Examples
    --------
    >>> from percuss.model import Harmonic, impact_oscillator, parameter, pi_times
    >>> w = parameter("w", 2)
    >>> force = Forcing((Harmonic(1, w), Harmonic(1, 3 * w)), period=2 * pi_times(1) / w)
    >>> moved_period(np.array([[0.5], [0.5]]), impact_oscillator(), force, ["w"])
    array([-0.5])
    """
    periods = {
        path: value
        for path, value in fields_by_path(osc, force, None).items()
        if path.endswith(".period")
    }
    rows = [*-rates]
    for path, value in periods.items():
        slower = moved_number(value, names) + [float(name == path) for name in names]
        rows.append(slower / as_float(value))
    if not rows:
        return np.zeros(len(names))
    all_rows = np.array(rows)
    apart = np.ptp(all_rows, axis=0) > ALIKE * np.abs(all_rows).max(axis=0)
    return np.where(apart, np.nan, all_rows[0])


def moved_number(value: object, names: Sequence[str]) -> Floats:
    """Return the derivatives of a number by parameters, 0 where it does not depend on one.

    Examples
    --------
    >>> from percuss.model import parameter
    >>> moved_number(3 * parameter("T", 2) ** 2, ["T", "forcing.omega"])
    array([12.,  0.])
    """
    if not isinstance(value, Expression):
        return np.zeros(len(names))
    slopes = [float(value.derivative(name)) if name in value.names else 0.0 for name in names]
    return np.array(slopes)


def moved_rows(system: System, fields: Mapping[str, float]) -> Floats:
    """Return the derivatives of the rows of a law, from those of the fields of its motion.

    Parameters
    ----------
    system
        Oscillator and forcing.
    fields
        The derivatives of the fields of the motion of unit mass, and of the mass, by their paths.

    Returns
    -------
    array
        (n_rows, columns), of `Change`.

    Raises
    ------
    ParameterError
        For the coefficients of a term of a Fourier sum that is left out since it is zero.
    """
    law = system.law
    n_rows = int(law[0, at.FIRST_KNOT]) if law[0, at.N_KNOTS] else len(law)
    rows = np.zeros((n_rows, at.COLUMNS))
    rows[0, at.MASS] = fields.get("oscillator.mass", 0.0)
    rows[0, at.FORCING_CONSTANT] = fields.get("forcing.constant", 0.0)
    _fill_harmonics(rows, system, fields)
    if any(path.startswith("oscillator.") or path == "forcing.constant" for path in fields):
        for region, number in zip(region_rows(law), range(len(law)), strict=False):
            _fill_region(rows[region], law[region], system, number, fields)
        _fill_tables(rows, system, fields)
    return rows


def moved_force_rows(force: Forcing, fields: Mapping[str, float]) -> Floats:
    """Return the first rows of `moved_rows`, of the forcing of a free mass: harmonics and record.

    Parameters
    ----------
    force
        The forcing.
    fields
        The derivatives of its fields, by their paths.
    """
    rows = np.zeros((at.FIRST_HARMONIC + len(force.components()) + 1, at.COLUMNS))
    rows[0, at.FORCING_CONSTANT] = fields.get("forcing.constant", 0.0)
    _fill_harmonics(rows, System(Oscillator(stiffness=0, damping=0), force), fields)
    return rows


def _derivatives(system: System, start: Start | None, name: str) -> dict[str, float]:
    """Return the derivatives of the fields of the motion of unit mass, and of the start."""
    osc, force = system
    is_number = "." in name and not name.endswith(".period")
    if is_number and (osc.mass is None or name.startswith(START)):
        return {name: 1.0}
    moved = moved_fields(osc, force, start, name)
    fields = {
        path: value
        for path, value in moved.fields.items()
        if path.startswith(START) or path == "oscillator.mass"
    }
    parameter = dict.fromkeys(fields, moved.name)
    if not all(path.startswith(START) for path in moved.fields):
        # Divided by the mass where there is one.
        in_law = moved_in_law(osc, force, name)
        fields |= in_law.fields
        parameter |= dict.fromkeys(in_law.fields, in_law.name)
    return {path: float(value.derivative(parameter[path])) for path, value in fields.items()}


def unit_law(force: Forcing | None) -> Law:
    """Return a law with the record of a forcing at scale 1, and nothing else."""
    assert force is not None
    assert force.record is not None
    record = force.record.with_fields(amplitude=1.0)
    return System(Oscillator(stiffness=0, damping=0), Forcing(record=record)).law


def _fill_harmonics(rows: Floats, system: System, fields: Mapping[str, float]) -> None:
    force = system.of_unit_mass.forcing
    if force is None or not any(path.startswith("forcing.") for path in fields):
        return
    row = at.FIRST_HARMONIC
    for i, part in enumerate(force.harmonics):
        if isinstance(part, Harmonic):
            own = (float(system.law[row, at.COSINE]), float(system.law[row, at.SINE]))
            rows[row, :3] = _moved_harmonic(part, own, f"forcing.harmonics.{i}.", fields)
        else:
            in_cos, in_sin = (
                fields.get(f"forcing.cos.{i}", 0.0),
                fields.get(f"forcing.sin.{i}", 0.0),
            )
            if as_float(part.cos) == as_float(part.sin) == 0.0:
                _refuse_left_out(in_cos, in_sin, i, part)
                continue
            rows[row, :3] = in_cos, in_sin, part.n * fields.get("forcing.omega", 0.0)
        row += 1
    if force.record is not None:
        rows[row, at.COSINE] = fields.get("forcing.record.amplitude", 0.0)
        pace = force.record.omega
        if pace is not None:
            rows[row, at.OMEGA] = fields.get("forcing.record.omega", 0.0) / as_float(pace)


def _refuse_left_out(in_cos: float, in_sin: float, i: int, part: FourierTerm) -> None:
    for value, name in ((in_cos, "cos"), (in_sin, "sin")):
        if value != 0.0:
            reason = (
                f"zero with its partner, so that term {part.n} is left out of the sum; give 1e-30"
            )
            raise ParameterError(f"forcing.{name}.{i}", 0.0, reason)


def _moved_harmonic(
    part: Harmonic, own: tuple[float, float], path: str, fields: Mapping[str, float]
) -> tuple[float, float, float]:
    """Return the derivatives of the cosine, the sine and the frequency of A cos(w t + phase).

    ``own`` are the cosine and the sine in the law: at whole quarters of a turn one is exactly zero.
    """
    amplitude, phase = as_float(part.amplitude), as_float(part.phase)
    louder, later = fields.get(f"{path}amplitude", 0.0), fields.get(f"{path}phase", 0.0)
    faster = fields.get(f"{path}omega", 0.0)
    if louder == later == 0.0:
        return 0.0, 0.0, faster
    if amplitude != 0.0:
        in_cos, in_sin = own[0] / amplitude, own[1] / amplitude
    else:
        in_cos, in_sin = cos(phase), -sin(phase)
    return (
        louder * in_cos + later * amplitude * in_sin,
        louder * in_sin - later * amplitude * in_cos,
        faster,
    )


def _fill_region(
    row: Floats, own: Floats, system: System, number: int, fields: Mapping[str, float]
) -> None:
    """Fill the row of a region, whose own row in the law is given."""
    osc, bounds = system.of_unit_mass.oscillator, system.lines

    def moved(i: int, name: str) -> float:
        return fields.get(f"oscillator.stops.{i}.{name}", 0.0)

    touched = touching_stops(system.oscillator, number)
    stiffer = fields.get("oscillator.stiffness", 0.0)
    push = fields.get("forcing.constant", 0.0)
    row[at.STIFFNESS] = stiffer + sum(moved(i, "stiffness") for i in touched)
    row[at.DAMPING] = fields.get("oscillator.damping", 0.0)
    row[at.DAMPING] += sum(moved(i, "damping") for i in touched)
    row[at.ORIGIN_FORCE] = push
    for i in touched:
        stop = osc.stops[i]
        assert isinstance(stop, SoftStop)
        row[at.ORIGIN_FORCE] += moved(i, "stiffness") * as_float(stop.at)
        row[at.ORIGIN_FORCE] += as_float(stop.stiffness) * moved(i, "at")
    ends = (
        (number, at.LOWER, at.LOWER_FORCE, at.LOWER_ENTRY, at.LOWER_RESTITUTION),
        (number + 1, at.UPPER, at.UPPER_FORCE, at.UPPER_ENTRY, at.UPPER_RESTITUTION),
    )
    for bound, place, force, entry, restitution in ends:
        wall, edges = bounds.wall[bound], bounds.edges[bound]
        if bounds.at[bound] is None:
            continue
        x = float(own[place])
        row[place] = moved(edges[0] if wall is None else wall, "at")
        row[force] = push - stiffer * x - as_float(osc.stiffness) * row[place]
        for i in touched:
            stop = osc.stops[i]
            assert isinstance(stop, SoftStop)
            row[force] -= moved(i, "stiffness") * (x - as_float(stop.at))
            row[force] -= as_float(stop.stiffness) * (row[place] - moved(i, "at"))
        for i in edges:
            stop = osc.stops[i]
            assert isinstance(stop, SoftStop)
            dashpot = 2.0 * as_float(stop.damping) * (moved(i, "at") - row[place])
            row[entry] += dashpot if stop.side == "above" else -dashpot
        if wall is not None:
            row[restitution] = moved(wall, "restitution")


def _fill_tables(rows: Floats, system: System, fields: Mapping[str, float]) -> None:
    """Fill the knots of tables of restitution."""
    law = system.law
    for i, stop in enumerate(system.oscillator.stops):
        if not isinstance(stop, Wall) or not isinstance(stop.restitution, RestitutionTable):
            continue
        column = at.LOWER_TABLE if stop.side == "below" else at.UPPER_TABLE
        first = int(max(law[region, column] for region in region_rows(law)))
        for k in range(len(stop.restitution.values)):
            path = f"oscillator.stops.{i}.restitution"
            rows[first + k, at.KNOT_SPEED] = fields.get(f"{path}.speeds.{k}", 0.0)
            rows[first + k, at.KNOT_RESTITUTION] = fields.get(f"{path}.values.{k}", 0.0)
