"""The derivative of a structure's equation by parameters, as the kernels of structures take it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.kernels import law_columns as at
from percuss.kernels.structure.basis import DRAG, FORCE, RATE, RATE_COS, SELF_DRAG, SPRING, Sets
from percuss.kernels.structure.columns import WAVE_ENTRIES, MovedSets
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.expression import parameters_in
from percuss.model.moved_law import (
    moved_force_rows,
    moved_rows,
    moved_stops,
    parameter_names,
    unit_law,
)
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.parameter_fields import parameters_by_path
from percuss.model.paths import moved_fields
from percuss.model.structure_start import StructureStart
from percuss.model.system import System
from percuss.numerics import inverse, matmul, solve_linear

MATRICES = ("mass", "damping", "stiffness")


class MovedLoads(NamedTuple):
    """The derivatives of the loads on the coordinates by one parameter.

    constant: (n,); waves: (m, 4, n), of cos(w t), sin(w t), t cos(w t) and t sin(w t); records:
    (r, 3, n), of a record's value, of its value at scale 1 and of t times its slope; paces: (r,),
    the derivatives of the logarithms of the records' paces, and rates: those of all frequencies.
    """

    constant: Floats
    waves: Floats
    records: Floats
    paces: Floats
    rates: Floats


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class MovedStructure:
    """The derivatives of a structure, its loads and the start of a motion by parameters.

    Attributes
    ----------
    paths
        The parameters, in their long form.
    mass, damping, stiffness
        The derivatives of the matrices by them, (n_parameters, n, n).
    stops
        Those of the place, the stiffness and the damping of each stop, (n_parameters, n_stops, 3).
    walls
        Those of the laws that hold one wall each, (n_parameters, n_stops, rows, columns).
    loads
        Those of the loads, for each parameter.
    begin
        Those of x, v and t of the start, (n_parameters, 2 n + 1).
    """

    paths: tuple[str, ...]
    mass: Floats
    damping: Floats
    stiffness: Floats
    stops: Floats
    walls: Floats
    loads: tuple[MovedLoads, ...]
    begin: Floats


def moved_structure(
    system: StructureSystem, start: StructureStart | None, paths: Sequence[str], end: object = None
) -> MovedStructure:
    """Return the derivatives of a structure's equation, and of a start, by parameters.

    Parameters
    ----------
    system
        The structure and its loads.
    start
        The start of the motion; None: it is no parameter.
    paths
        Paths of the parameters, in long or short form; names of parameters in expressions too.
    end
        What ends the motion, whose parameters may be named, too: they move nothing of the equation.

    Returns
    -------
    MovedStructure
        The derivatives, from those of the expressions, exact to rounding.

    Raises
    ------
    ParameterError
        If there is no such parameter, one is named twice, or none at all; and for the coefficients
        of a term of a Fourier sum that is left out since it is zero.

    Examples
    --------
    >>> from percuss.model import Structure
    >>> system = StructureSystem.of(Structure([1, 2], [[3, -1], [-1, 1]]), None)
    >>> moved_structure(system, None, ["structure.mass.0.1"]).mass[0]
    array([[0., 1.],
           [1., 0.]])
    """
    structure, loads, n = system.structure, system.loads, system.structure.n
    names = parameter_names(paths, structure, loads, start, end)
    of_end = parameters_in(end).keys() - parameters_by_path(structure, loads, start).keys()
    count, n_stops = len(names), len(structure.stops)
    matrices = np.zeros((len(MATRICES), count, n, n))
    stops = np.zeros((count, n_stops, 3))
    walls = np.zeros((count, *system.sets.walls.shape))
    begin = np.zeros((count, 2 * n + 1))
    of_loads = []
    for p, name in enumerate(names):
        fields = {} if name in of_end else _derivatives(system, start, name)
        is_moved = any(path.startswith("structure.") for path in fields)
        for k, matrix in enumerate(MATRICES if is_moved else ()):
            for i in range(n):
                for j in range(n):
                    # Of two equal entries of the mass that above the diagonal is the parameter.
                    row, column = (min(i, j), max(i, j)) if matrix == "mass" else (i, j)
                    matrices[k, p, i, j] = fields.get(f"structure.{matrix}.{row}.{column}", 0.0)
        stops[p] = moved_stops("structure", n_stops, fields)
        for i, stop in enumerate(structure.stops):
            of_stop = _renamed(fields, f"structure.stops.{i}.", "oscillator.stops.0.")
            if isinstance(stop, Wall) and of_stop:
                wall = Wall(0, stop.side, stop.restitution)
                alone = System(Oscillator(stiffness=0, damping=0, stops=(wall,)), None)
                rows = moved_rows(alone, of_stop)
                walls[p, i, : len(rows)] = rows
        of_start = [[fields.get(f"start.{own}.{i}", 0.0) for i in range(n)] for own in ("x0", "v0")]
        begin[p] = [*of_start[0], *of_start[1], fields.get("start.t0", 0.0)]
        of_loads.append(_moved_loads(system, fields, matrices[0, p]))
    mass, damping, stiffness = matrices
    return MovedStructure(names, mass, damping, stiffness, stops, walls, tuple(of_loads), begin)


def _derivatives(
    system: StructureSystem, start: StructureStart | None, name: str
) -> dict[str, float]:
    """Return the derivatives of the fields of the equation and of the start by a parameter."""
    moved = moved_fields(system.structure, system.loads, start, name)
    return {path: float(value.derivative(moved.name)) for path, value in moved.fields.items()}


def _renamed(fields: Mapping[str, float], prefix: str, new: str) -> dict[str, float]:
    """Return the fields whose paths begin with a prefix, with another one."""
    return {
        f"{new}{path.removeprefix(prefix)}": value
        for path, value in fields.items()
        if path.startswith(prefix)
    }


def _moved_loads(system: StructureSystem, fields: Mapping[str, float], mass: Floats) -> MovedLoads:
    """Return the derivatives of the loads by one parameter, of which that of the mass is given."""
    structure, n = system.structure, system.structure.n
    directions = system.loads.directions(structure)
    _, _, m, r = system.shape
    constant, waves = np.zeros(n), np.zeros((m, WAVE_ENTRIES, n))
    records, paces = np.zeros((r, 3, n)), np.zeros(r)
    number, rates = 0, []
    for i, (on, force) in enumerate(system.loads.items):
        c, turned = directions[i], np.zeros(n)
        if force.is_per_mass:
            turned = matmul(mass, structure.direction(on))
        own = _renamed(fields, f"loads.{i}.", "forcing.")
        rows = moved_force_rows(force, own)
        constant += rows[0, at.FORCING_CONSTANT] * c + as_float(force.constant) * turned
        components = force.components()
        for k, component in enumerate(components, at.FIRST_HARMONIC):
            wave = waves[system.omegas.index(component.omega)]
            wave[0] += rows[k, at.COSINE] * c + component.cos * turned
            wave[1] += rows[k, at.SINE] * c + component.sin * turned
            rates.append(rows[k, at.OMEGA] / float(component.omega))
            wave[2] += rows[k, at.OMEGA] * component.sin * c
            wave[3] -= rows[k, at.OMEGA] * component.cos * c
        if force.record is not None:
            row = rows[at.FIRST_HARMONIC + len(components)]
            records[number] = turned, row[at.COSINE] * c, row[at.OMEGA] * c
            paces[number] = row[at.OMEGA]
            rates.append(row[at.OMEGA])
            number += 1
    return MovedLoads(constant, waves, records, paces, np.array(rates))


def moved_sets(system: StructureSystem, moved: MovedStructure, sets: Sets) -> MovedSets:
    """Return the forces of the equation's changes on the modes of each set of a run."""
    structure, count = system.structure, len(moved.paths)
    n, n_stops, m, r = system.shape
    normals, mass = sets.normals, structure.mass_matrix
    # The level of a clearance: it is n . x less this.
    levels = np.array([system.signs * moved.stops[p, :, 0] for p in range(count)])
    b, q = len(sets.keys), 2 * n + n_stops
    pushes = MovedSets(
        change=np.zeros((b, n, 2, q, count)),
        push=np.zeros((b, q, count)),
        waves=np.zeros((b, m, WAVE_ENTRIES, q, count)),
        records=np.zeros((b, r, 3, q, count)),
        places=np.zeros((b, n, count)),
        reactions=np.zeros((b, n_stops, n, count)),
        drags=np.zeros((b, n_stops, count)),
        impulses=np.zeros((n_stops, n, count)),
        levels=np.ascontiguousarray(levels.reshape(count, n_stops).T),
        walls=moved.walls,
        paces=np.array([loads.paces for loads in moved.loads]).reshape(count, r).T.copy(),
        units=_unit_laws(system, sets),
        record_pushes=_record_pushes(system),
    )
    for p in range(count):
        # Else the impulses stay.
        for i in range(n_stops if moved.mass[p].any() else 0):
            pushes.impulses[i, :, p] = _reaction(mass, normals[[i]], moved.mass[p])[1][:, 0]
        for k in range(b):
            _fill_set(pushes, system, moved, sets, (k, p))
    return pushes


def more_columns(moved: MovedSets, count: int) -> MovedSets:
    """Return the changes with so many further columns, last, that change nothing."""
    still = {"units", "record_pushes"}
    fields: dict[str, Floats] = {}
    for name, array in moved._asdict().items():
        axis = 0 if name == "walls" else array.ndim - 1
        more = [(0, count if i == axis and name not in still else 0) for i in range(array.ndim)]
        fields[name] = np.ascontiguousarray(np.pad(array, more))
    return MovedSets(**fields)


def _unit_laws(system: StructureSystem, sets: Sets) -> Floats:
    """Return laws that hold one record each, at scale 1."""
    laws = np.zeros_like(sets.records)
    forces = [force for force in system.loads.forcings if force.record is not None]
    for law, force in zip(laws, forces, strict=True):
        own = unit_law(force)
        law[: len(own)] = own
    return laws


def _record_pushes(system: StructureSystem) -> Floats:
    """Return the accelerations by each record at value 1, (r, n)."""
    directions = system.loads.directions(system.structure)
    rows = [
        solve_linear(system.structure.mass_matrix, c)
        for c, force in zip(directions, system.loads.forcings, strict=True)
        if force.record is not None
    ]
    return np.array(rows).reshape(len(rows), system.structure.n)


def _reaction(mass: Floats, normals: Floats, moved: Floats) -> tuple[Floats, Floats]:
    """Return M^-1 G^T (G M^-1 G^T)^-1, (n, h), and its derivative by a change of the mass."""
    n, h = mass.shape[0], len(normals)
    if h == 0:
        return np.zeros((n, 0)), np.zeros((n, 0))
    along = solve_linear(mass, normals.T)
    gram = inverse(matmul(normals, along))
    reaction = matmul(along, gram)
    change = -solve_linear(mass, matmul(moved, along))
    return reaction, matmul(change - matmul(reaction, matmul(normals, change)), gram)


def _fill_set(
    pushes: MovedSets,
    system: StructureSystem,
    moved: MovedStructure,
    sets: Sets,
    which: tuple[int, int],
) -> None:
    """Fill what a parameter changes in a set; ``which`` are the numbers of both."""
    (b, p), structure = which, system.structure
    n, key = structure.n, int(sets.keys[b])
    mass, normals = structure.mass_matrix, sets.normals
    held, pressed = (
        [i for i, stop in enumerate(structure.stops) if key >> i & 1 and isinstance(stop, kind)]
        for kind in (Wall, SoftStop)
    )
    stiffness, stiffer, damping, damped, push = _pressed(system, moved, p, pressed)
    reaction, change = _reaction(mass, normals[held], moved.mass[p])
    place = matmul(reaction, pushes.levels[held, p]) if held else np.zeros(n)
    pushes.places[b, :, p] = place
    for k, i in enumerate(held):
        pushes.reactions[b, i, :, p] = change[:, k]
    # What receives a force: the modes, and the forces of the walls that hold.
    into = np.zeros((2 * n + len(structure.stops), n))
    into[: 2 * n] = solve_linear(mass.T, sets.inverse[b, n:].transpose(0, 2, 1).reshape(n, 2 * n)).T
    for k, i in enumerate(held):
        into[2 * n + i] = -reaction[:, k]
    x, v, a = motion_of_modes(sets.shape[b].transpose(2, 0, 1), sets.modes[b])
    heavier = moved.mass[p]
    force = -(matmul(heavier, a) + matmul(damped, v) + matmul(stiffer, x))
    pushes.change[b, :, :, :, p] = matmul(into, force).T.reshape(n, 2, -1)
    # What the loads do to the accelerations, which the change of the mass resists.
    inertia = matmul(heavier, v)
    loads = moved.loads[p]
    constant = np.stack([sets.modes[b, :, RATE], sets.modes[b, :, FORCE]], axis=-1).reshape(-1)
    push = push + loads.constant - matmul(inertia, constant)
    push = push - matmul(stiffer, sets.offset[b]) - matmul(stiffness, place)
    pushes.push[b, :, p] = matmul(into, push)
    for k in range(len(loads.waves)):
        wave = loads.waves[k].copy()
        for part in range(2):
            drive = sets.drive[b, :, k, [RATE_COS + part, part]].T.reshape(-1)
            wave[part] -= matmul(inertia, drive)
        pushes.waves[b, k, :, :, p] = matmul(wave, into.T)
    for k in range(len(loads.records)):
        record = loads.records[k].copy()
        record[0] -= matmul(inertia, sets.record_drive[b, :, k, ::-1].reshape(-1))
        pushes.records[b, k, :, :, p] = matmul(record, into.T)
    for i in range(len(structure.stops) if damped.any() or heavier.any() else 0):
        if sets.levels[b, i, SELF_DRAG] != 0.0 or damped.any():
            pushes.drags[b, i, p] = _moved_drag(
                (mass, heavier), (damping, damped), (reaction, change, normals[held]), normals[i]
            )


def _pressed(
    system: StructureSystem, moved: MovedStructure, p: int, pressed: Sequence[int]
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return stiffness and damping of a set, each with its change, and the stops' constant push."""
    structure = system.structure
    stiffness, stiffer = structure.stiffness_matrix.copy(), moved.stiffness[p].copy()
    damping, damped = structure.damping_matrix.copy(), moved.damping[p].copy()
    push = np.zeros(structure.n)
    for i in pressed:
        stop, c = structure.stops[i], structure.stop_directions[i]
        assert isinstance(stop, SoftStop)
        away, spring, drag = moved.stops[p, i]
        square = c[:, None] * c
        stiffness += as_float(stop.stiffness) * square
        stiffer += spring * square
        damping += as_float(stop.damping) * square
        damped += drag * square
        push += (spring * as_float(stop.at) + as_float(stop.stiffness) * away) * c
    return stiffness, stiffer, damping, damped, push


def motion_of_modes(shape: Floats, modes: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the matrices (n, 2 n) from the modes to x, v and the acceleration, without the loads."""
    n = len(modes)
    spring, drag = modes[:, SPRING], modes[:, DRAG]
    rows = [shape]
    for _ in range(2):
        of_u, of_w = rows[-1][..., 0], rows[-1][..., 1]
        rows.append(np.stack([-spring * of_w, of_u - drag * of_w], axis=-1))
    x, v, a = (row.reshape(n, 2 * n) for row in rows)
    return x, v, a


def _moved_drag(
    masses: tuple[Floats, Floats],
    dampings: tuple[Floats, Floats],
    held: tuple[Floats, Floats, Floats],
    normal: Floats,
) -> float:
    """Return the derivative of SELF_DRAG of a stop; a matrix comes with its change."""
    (mass, heavier), (damping, damped), (reaction, change, walls) = masses, dampings, held
    along = solve_linear(mass, normal)
    moved_along = -solve_linear(mass, matmul(heavier, along))

    def freed(vector: Floats, moved: Floats) -> tuple[Floats, Floats]:
        """Return the part of accelerations that the walls in contact allow, and its change."""
        if not len(walls):
            return vector, moved
        off, moved_off = matmul(walls, vector), matmul(walls, moved)
        return (
            vector - matmul(reaction, off),
            moved - matmul(reaction, moved_off) - matmul(change, off),
        )

    along, moved_along = freed(along, moved_along)
    size, moved_size = float((normal * along).sum()), float((normal * moved_along).sum())
    if not size > 1e-20 * float((normal * normal).sum()):
        return 0.0
    unit = along / size
    moved_unit = moved_along / size - unit * (moved_size / size)
    slowed = solve_linear(mass, matmul(damping, unit))
    moved_slowed = matmul(damped, unit) + matmul(damping, moved_unit) - matmul(heavier, slowed)
    return float((normal * freed(slowed, solve_linear(mass, moved_slowed))[1]).sum())
