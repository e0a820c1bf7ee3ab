"""A structure under loads, and its modes under each set of acting stops.

A set is met in a run before it is made: `StructureSystem.add` decomposes the structure with the
stops of its bits, and appends it to the arrays that the kernels read.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np

from percuss.arrays import Complexes, Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels.law_columns import (
    COLUMNS,
    FIRST_HARMONIC,
    N_HARMONICS,
    N_REGIONS,
    OMEGA,
    Law,
)
from percuss.kernels.structure import basis as at
from percuss.kernels.structure.basis import Sets
from percuss.kernels.structure.bounds import MOST_DOUBLINGS, fill_guard_bounds, fill_mode_bounds
from percuss.kernels.structure.steps import fill_steps
from percuss.model.exact import as_float, as_fraction
from percuss.model.expression import parameters_in
from percuss.model.forcing import Component, Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.structure import Structure
from percuss.model.structure_frames import StructureFrames, frames_of, stacked_laws
from percuss.model.system import fill_harmonic, fill_motion, fill_response
from percuss.model.system import law as law_of
from percuss.numerics import matmul, solve_linear

# Most memory for all sets of acting stops that a structure has met [bytes].
MOST_BYTES = 1_000_000_000
# By how much a state may be behind a wall that it touches, as a part of its size.
TOUCHING = 1e-9
# Held while a set is appended to the arrays of any system.
_ADDING = threading.RLock()
# How often a state is moved out of walls, of which one may push it behind another.
PUSHES = 100


class StructureSystem:
    """A structure and its loads, with the sets of acting stops that have been met so far.

    Parameters
    ----------
    structure
        The structure.
    loads
        The loads on it.
    """

    def __init__(self, structure: Structure, loads: Loads) -> None:
        self.structure, self.loads = structure, loads
        self._made: dict[int, dict[str, Floats]] = {}
        self._sets: Sets | None = None

    @staticmethod
    def of(structure: Structure, loads: object) -> StructureSystem:
        """Return the system of a caller's two arguments, the same one for equal values."""
        return _system(structure, loads_of(structure, loads))

    def __reduce__(self) -> tuple[object, tuple[Structure, Loads]]:
        return _system, (self.structure, self.loads)

    @cached_property
    def _frames(self) -> StructureFrames:
        return frames_of(self.structure)

    @property
    def signs(self) -> Floats:
        """1 for a stop below, -1 for one above, (n_stops,)."""
        return self._frames.signs

    @property
    def effective_masses(self) -> Floats:
        """1 / (c . M^-1 c) of each stop, (n_stops,) [mass]."""
        return self._frames.effective_masses

    @cached_property
    def period(self) -> float | None:
        """The common period of the loads [time]; None without one."""
        return self.loads.period

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of coordinates, stops, harmonics and records, which shape all arrays."""
        n_records = sum(forcing.record is not None for forcing in self.loads.forcings)
        return self.structure.n, len(self.structure.stops), len(self.omegas), n_records

    @property
    def sets(self) -> Sets:
        """The sets that have been met."""
        if self._sets is None:
            self.add(0)
        assert self._sets is not None
        return self._sets

    def numbers_of(self, keys: Sequence[int]) -> list[int]:
        """Return the numbers of the sets of the stops of these bits, which are made if need be."""
        self.add(*keys)
        numbers = {key: number for number, key in enumerate(self._made)}
        return [numbers[key] for key in keys]

    def add(self, *keys: int) -> None:
        """Make the sets of the stops of these bits, and append them to the arrays.

        Raises
        ------
        ConvergenceError
            If the modes of one cannot be told apart, or walls hold the structure that hold it
            twice.
        ParameterError
            If all sets together take more than a gigabyte.
        """
        # Branches on several threads share systems.
        with _ADDING:
            new = [key for key in dict.fromkeys(keys) if key not in self._made]
            if not new:
                return
            for key in new:
                self._made[key] = self._make(key)
                self._check_size(key)
            made = list(self._made.values())
            arrays = {
                name: _joined([arrays_of_set[name] for arrays_of_set in made]) for name in made[0]
            }
            self._sets = Sets(
                **arrays, keys=np.array(list(self._made), dtype=np.int64),
                stops=self._frames.stops, walls=self._frames.walls, records=self.records,
                normals=self._frames.gradients, impulses=self._frames.impulses,
            )  # fmt: skip

    def _check_size(self, key: int) -> None:
        """Refuse the last set, where all together are larger than a memory should hold."""
        size = sum(array.nbytes for array in self._made[key].values())
        count = len(self._made)
        if count * size > MOST_BYTES:
            del self._made[key]
            reason = (
                f"the motion has met {count:,} sets of acting stops, of {size / 1e3:.0f} kB each and"
                f" more than {MOST_BYTES / 1e6:.0f} MB together; shorten the run, or leave out stops"
            )
            raise ParameterError("stops", len(self.structure.stops), reason)

    def key_at(self, x: Floats, v: Floats) -> int:
        """Return the bits of the soft stops that press at displacements and velocities (n,)."""
        return int(self.keys_at(x, v))

    def keys_at(self, x: Floats, v: Floats) -> Integers:
        """Return the bits of the soft stops that press at displacements and velocities (..., n)."""
        keys = np.zeros(x.shape[:-1], dtype=np.int64)
        for i, stop in enumerate(self.structure.stops):
            if isinstance(stop, SoftStop):
                c = self.structure.stop_directions[i]
                depth = self.signs[i] * (as_float(stop.at) - (c * x).sum(axis=-1))
                inwards = -self.signs[i] * (c * v).sum(axis=-1)
                presses = (depth > 0.0) | ((depth == 0.0) & (inwards > 0.0))
                keys |= np.where(presses, 1 << i, 0)
        return keys

    @cached_property
    def _components(self) -> list[tuple[int, Component]]:
        """The harmonics of all loads, with the number of each one's load."""
        return [
            (i, component)
            for i, forcing in enumerate(self.loads.forcings)
            for component in forcing.components()
        ]

    @cached_property
    def omegas(self) -> list[Fraction]:
        """The frequencies of the loads' harmonics [1/time], each once."""
        return sorted({component.omega for _, component in self._components})

    @cached_property
    def _directions(self) -> Floats:
        """L^-1 c of each load, (n_loads, n)."""
        rows = self.loads.directions(self.structure)
        return matmul(rows, self._frames.inverse_factor.T) if len(rows) else rows

    @cached_property
    def _pushes(self) -> Complexes:
        """Accelerations by each harmonic in coordinates of unit mass, (n_harmonics, n): cos - i sin."""
        pushes = np.zeros((len(self.omegas), self.structure.n), dtype=np.complex128)
        for i, component in self._components:
            k = self.omegas.index(component.omega)
            pushes[k].real += component.cos * self._directions[i]
            pushes[k].imag -= component.sin * self._directions[i]
        return pushes

    @cached_property
    def _constant(self) -> Floats:
        """The accelerations by the constant loads, (n,)."""
        total = np.zeros(self.structure.n)
        for i, forcing in enumerate(self.loads.forcings):
            if forcing.constant != 0:
                total += float(as_fraction(forcing.constant)) * self._directions[i]
        return total

    @cached_property
    def _record_directions(self) -> Floats:
        """The accelerations by each record at value 1, (n_records, n)."""
        rows = [
            self._directions[i]
            for i, forcing in enumerate(self.loads.forcings)
            if forcing.record is not None
        ]
        return np.array(rows).reshape(len(rows), self.structure.n)

    @cached_property
    def records(self) -> Floats:
        """Laws that hold one record each, (n_records, rows, COLUMNS)."""
        alone = [_record_alone(force) for force in self.loads.forcings if force.record is not None]
        free = Oscillator(stiffness=0, damping=0) if alone else None
        return stacked_laws([law_of(free, force) for force in alone if free is not None])

    def _make(self, key: int) -> dict[str, Floats]:
        """Return the arrays of one set."""
        frame, n = self._frames.at(key), self.structure.n
        inward, direct = frame["inward"], frame["direct"]
        modes, levels, guard = (frame[name].copy() for name in ("modes", "levels", "guard"))
        m = len(self.omegas)
        # All accelerations at once, in rows: of the constants, the harmonics and the records.
        pushes = np.concatenate(
            [frame["pull"][None] + self._constant, self._constant[None], self._pushes.real,
             -self._pushes.imag, self._record_directions]
        )  # fmt: skip
        into_modes = (inward[:, :, None, n:] * pushes).sum(axis=-1)
        into_guards = (direct[:, None, :] * pushes).sum(axis=-1)
        modes[:, at.FORCE], modes[:, at.RATE] = into_modes[:, 1, 0], into_modes[:, 0, 0]
        levels[:, at.CONSTANT] += into_guards[:, 1]
        cosines, sines, records = slice(2, 2 + m), slice(2 + m, 2 + 2 * m), slice(2 + 2 * m, None)
        drive = np.empty((n, m, at.DRIVE_ENTRIES))
        for column, part in ((at.FORCE_COS, 1), (at.RATE_COS, 0)):
            drive[:, :, column] = into_modes[:, part, cosines]
            drive[:, :, column + 1] = into_modes[:, part, sines]
        feed = np.stack([into_guards[:, cosines], into_guards[:, sines]], axis=-1)
        record_drive = np.stack([into_modes[:, 1, records], into_modes[:, 0, records]], axis=-1)
        arrays = {name: frame[name] for name in ("shape", "offset", "inverse", "kick")} | {
            "modes": modes,
            "drive": drive,
            "record_drive": record_drive,
            "guard": guard,
            "levels": levels,
            "feed": feed,
            "record_feed": into_guards[:, records],
        }
        springs, drags = modes[:, at.SPRING].tolist(), modes[:, at.DRAG].tolist()
        law = _law_of_modes(tuple(springs), tuple(drags), tuple(self.omegas))
        arrays |= {"law": law, "of_set": self._bounds(law, arrays)}
        walk = np.empty((at.WALK_ROWS + at.DRIVE_ENTRIES * m, n))
        walk[: at.WALK_ROWS] = modes[:, : at.WALK_ROWS].T
        walk[at.WALK_ROWS :] = drive.transpose(1, 2, 0).reshape(-1, n)
        steps = np.zeros((MOST_DOUBLINGS + 1, at.STEP_ENTRIES + at.STEP_HARMONIC * m, n))
        turns = np.zeros((MOST_DOUBLINGS + 1, m, 2))
        n_levels = int(arrays["of_set"][at.N_LEVELS])
        shortest = float(arrays["of_set"][at.STEP_LENGTH])
        fill_steps(law, modes, shortest, steps[:n_levels], turns[:n_levels])
        return arrays | {"walk": walk, "steps": steps, "turns": turns}

    def _bounds(self, law: Law, arrays: dict[str, Floats]) -> Floats:
        """Fill what bounds the guards' fourth derivatives; return the columns of the set."""
        modes, drive = arrays["modes"], arrays["drive"]
        omegas = law[FIRST_HARMONIC : FIRST_HARMONIC + len(self.omegas), OMEGA].copy()
        of_set = np.zeros(at.SET_COLUMNS)
        fill_mode_bounds(modes, drive, arrays["record_drive"], omegas, of_set)
        fill_guard_bounds(modes, drive, omegas, arrays["guard"], arrays["feed"], arrays["levels"])
        return of_set


# Along a branch the loads change more often than what they act on.
@lru_cache(maxsize=64)
def _law_of_modes(
    springs: tuple[float, ...], drags: tuple[float, ...], omegas: tuple[Fraction, ...]
) -> Law:
    """Return modes as regions of a law under harmonics of these frequencies."""
    m, n = len(omegas), len(springs)
    law = np.zeros((FIRST_HARMONIC + m + n * (1 + m), COLUMNS))
    law[0, N_HARMONICS], law[0, N_REGIONS] = m, n
    for k, omega in enumerate(omegas):
        fill_harmonic(law[FIRST_HARMONIC + k], Component(omega, 1.0, 0.0))
    for j, (spring, drag) in enumerate(zip(springs, drags, strict=True)):
        row = FIRST_HARMONIC + m + j * (1 + m)
        law[row] = _motion_row(spring, drag)
        for k, omega in enumerate(omegas):
            fill_response(law[row + 1 + k], Fraction(spring), Fraction(drag) / 2, omega)
    return law


@lru_cache(maxsize=1024)
def _motion_row(spring: float, drag: float) -> Floats:
    row = np.zeros(COLUMNS)
    fill_motion(row, Fraction(spring), Fraction(drag) / 2)
    return row


@lru_cache(maxsize=256)
def _system(structure: Structure, loads: Loads) -> StructureSystem:
    parameters_in(structure, loads)  # one name has one value
    return StructureSystem(structure, loads)


def _joined(parts: Sequence[Floats]) -> Floats:
    """Return arrays of one shape one below the other; `numpy.stack` takes ten times as long."""
    joined = np.empty((len(parts), *parts[0].shape))
    for i, part in enumerate(parts):
        joined[i] = part
    return joined


def _record_alone(forcing: Forcing) -> Forcing:
    return Forcing(record=forcing.record)


def is_before_walls(structure: Structure, state: Floats) -> bool:
    """Return whether a state (x, v) lies behind no wall, but for rounding.

    Examples
    --------
    >>> from percuss.model import impact_pair
    >>> pair = impact_pair([1, 1], gap=1)
    >>> [is_before_walls(pair, np.array([0.0, x, 0.0, 0.0])) for x in (0.9, 1.0, 1.1)]
    [True, True, False]
    """
    n, size = structure.n, float(np.abs(state).max(initial=0.0))
    for stop, c in zip(structure.stops, structure.stop_directions, strict=True):
        if isinstance(stop, Wall):
            depth = float((c * state[:n]).sum()) - as_float(stop.at)
            reach = abs(as_float(stop.at)) + size * float(np.abs(c).sum())
            if depth * (1.0 if stop.side == "above" else -1.0) > TOUCHING * reach:
                return False
    return True


def within_walls(structure: Structure, state: Floats) -> Floats:
    """Return (x, v) moved out of the walls that it lies behind, along M^-1 c of each.

    Examples
    --------
    >>> from percuss.model import impact_pair
    >>> within_walls(impact_pair([1, 1], gap=1), np.array([0.0, 1.5, 0.0, 0.0]))
    array([0.25, 1.25, 0.  , 0.  ])
    """
    x, n = state[: structure.n].copy(), structure.n
    for _ in range(PUSHES):
        is_moved = False
        for stop, c in zip(structure.stops, structure.stop_directions, strict=True):
            depth = float((c * x).sum()) - as_float(stop.at)
            if isinstance(stop, Wall) and depth * (1.0 if stop.side == "above" else -1.0) > 0.0:
                push = solve_linear(structure.mass_matrix, c)
                x -= depth / float((c * push).sum()) * push
                is_moved = True
        if not is_moved:
            break
    return np.concatenate([x, state[n:]])
