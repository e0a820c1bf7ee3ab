"""A structure under loads, and its modes under each set of acting stops.

A set is met in a run before it is made: `StructureSystem.add` decomposes the structure with the
stops of its bits, and appends it to the arrays that the kernels read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np

from percuss.arrays import Complexes, Floats, Integers
from percuss.errors import ConvergenceError, ParameterError
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
from percuss.kernels.structure.steps import fill_steps
from percuss.model.exact import Exact, as_float, as_fraction
from percuss.model.forcing import Component, Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import Oscillator, SoftStop, Wall
from percuss.model.structure import Structure
from percuss.model.system import fill_harmonic, fill_motion, fill_response
from percuss.model.system import law as law_of
from percuss.numerics import (
    ModePairs,
    Wide,
    directions,
    entry_sizes,
    matmul,
    mode_pairs,
    solve_linear,
)

__all__ = ["StructureSystem", "fill_guard_bounds", "within_walls"]

# The shortest step of the search, as a phase of the quickest rate, and how often it is doubled at
# most: a mode that a quick one leaves behind sets the longest.
SHORTEST_PHASE = 0.25
MOST_DOUBLINGS = 14
# The longest step is this phase of the slowest rate.
LONGEST_PHASE = 2.0
# Where the motion grows the bounds over a step hold a factor exp(phase).
GROWING_PHASE = 0.5
# Without any rate the motion is a cubic, and steps may have any length [time].
ANY_STEP = 2.0**-8
# Of all sets of acting stops that a structure has met [bytes].
MOST_BYTES = 1_000_000_000
# How often a state is moved out of walls, of which one may push it behind another.
PUSHES = 100


class StructureFrames:
    """A structure in coordinates of unit mass, without its loads.

    Parameters
    ----------
    structure
        The structure.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self._made: dict[int, dict[str, Floats]] = {}

    @cached_property
    def signs(self) -> Floats:
        """1 for a stop below, -1 for one above, (n_stops,)."""
        return np.array([1.0 if stop.side == "below" else -1.0 for stop in self.structure.stops])

    @cached_property
    def gradients(self) -> Floats:
        """The gradients of the clearances, (n_stops, n)."""
        return self.structure.stop_directions * self.signs[:, None]

    @cached_property
    def effective_masses(self) -> Floats:
        """1 / (c . M^-1 c) of each stop, (n_stops,) [mass]."""
        return np.asarray(1.0 / (self._normals * self._normals).sum(axis=-1))

    @cached_property
    def _factor(self) -> Wide:
        """L of M = L L^T."""
        return _wide(self.structure.mass).cholesky()

    @cached_property
    def _back(self) -> Wide:
        """L^-1."""
        return self._factor.inverse()

    @property
    def inverse_factor(self) -> Floats:
        return self._back.rounded

    @cached_property
    def walls(self) -> Floats:
        """Laws that hold one wall each, for its restitution."""
        laws = []
        for stop in self.structure.stops:
            walls = [Wall(0, stop.side, stop.restitution)] if isinstance(stop, Wall) else []
            laws.append(law_of(Oscillator(stiffness=0, damping=0, stops=tuple(walls)), None))
        return _stacked(laws)

    @cached_property
    def stops(self) -> Floats:
        rows = np.zeros((len(self.structure.stops), at.STOP_COLUMNS))
        rows[:, at.IS_WALL] = [isinstance(stop, Wall) for stop in self.structure.stops]
        return rows

    @cached_property
    def _wide_normals(self) -> Wide:
        """The gradients of the clearances in coordinates of unit mass, (n_stops, n)."""
        return Wide.of(self.gradients) @ self._back.T

    @property
    def _normals(self) -> Floats:
        return self._wide_normals.rounded

    @cached_property
    def impulses(self) -> Floats:
        """M^-1 c / (c . M^-1 c) of each stop, along its clearance, (n_stops, n)."""
        along = matmul(self._normals, self.inverse_factor) if len(self._normals) else self._normals
        return np.asarray(along * self.effective_masses[:, None])

    @cached_property
    def _levels(self) -> Floats:
        """The clearances at x = 0."""
        return np.array(
            [
                -sign * as_float(stop.at)
                for sign, stop in zip(self.signs, self.structure.stops, strict=True)
            ]
        )

    def at(self, key: int) -> dict[str, Floats]:
        """Return the arrays of `Sets` for one set of acting stops, except those of the loads.

        Besides these, the modes from displacements and velocities of unit mass (inward), the
        constant force there (pull), and what a guard takes of forces directly (direct).
        """
        if key not in self._made:
            self._made[key] = self._make(key)
        return self._made[key]

    def _make(self, key: int) -> dict[str, Floats]:
        structure, n = self.structure, self.structure.n
        back = self._back
        stiffness, damping = self._matrices
        stiff_size, drag_size = self._sizes
        pull = Wide.zeros(n, 1)
        held = []
        for i, stop in enumerate(structure.stops):
            if not key >> i & 1:
                continue
            if isinstance(stop, Wall):
                held.append(i)
                continue
            normal = self._wide_normals[i : i + 1]
            spring, dashpot = (_wide([[value]]) for value in (stop.stiffness, stop.damping))
            square = normal.T @ normal
            stiffness = stiffness + spring * square
            damping = damping + dashpot * square
            size = normal.rounded[0] * normal.rounded[0]
            stiff_size = np.sqrt(stiff_size * stiff_size + abs(spring.rounded[0, 0]) * size)
            drag_size = np.sqrt(drag_size * drag_size + abs(dashpot.rounded[0, 0]) * size)
            # The force is -k h along the gradient of the clearance h, which is its level at 0.
            pull = pull - (float(self._levels[i]) * spring) * normal.T
        free, offset, reactions = self._constraint(held)
        pull = pull - stiffness @ offset
        m = len(free)
        spread = np.abs(free.rounded)
        pairs = _pairs_of(
            free @ stiffness @ free.T,
            free @ damping @ free.T,
            (matmul(spread, stiff_size), matmul(spread, drag_size)),
        )
        of_u, of_w = Wide.zeros(n, n), Wide.zeros(n, n)
        of_u[:, :m], of_w[:, :m] = free.T @ pairs.of_u, free.T @ pairs.of_w
        inward = Wide.zeros(2 * n, 2 * n)
        inward[: 2 * m] = pairs.inverse @ _twice(free)
        modes = np.zeros((n, at.MODE_COLUMNS))
        modes[:m, at.SPRING], modes[:m, at.DRAG] = pairs.spring, pairs.drag
        shape = np.zeros((n, n, 2))
        shape[:, :, 0] = (back.T @ of_u).rounded
        shape[:, :, 1] = (back.T @ of_w).rounded
        # Velocities: u' = w, w' = -k u - d w.
        fast_u = -of_w.columns_times(modes[:, at.SPRING])
        fast_w = of_u - of_w.columns_times(modes[:, at.DRAG])
        s = len(structure.stops)
        guard = np.zeros((s, n, at.GUARD_ENTRIES))
        levels = np.zeros((s, at.LEVEL_COLUMNS))
        levels[:, at.IS_ON] = 1.0
        direct = np.zeros((s, n))
        for i in range(s):
            normal = self._wide_normals[i : i + 1]
            if i in held:
                number = held.index(i)
                row = -reactions[number : number + 1]
                stiff, damped = row @ stiffness, row @ damping
                guard[i, :, at.OF_U] = (-(damped @ fast_u) - stiff @ of_u).rounded[0]
                guard[i, :, at.OF_W] = (-(damped @ fast_w) - stiff @ of_w).rounded[0]
                levels[i, at.CONSTANT] = (row @ pull).rounded[0, 0]
                levels[i, at.IS_FED] = 1.0
                direct[i] = row.rounded[0]
                continue
            side = -1.0 if key >> i & 1 else 1.0
            guard[i, :, at.OF_U] = side * (normal @ of_u).rounded[0]
            guard[i, :, at.OF_W] = side * (normal @ of_w).rounded[0]
            level = Wide.of(np.array([[self._levels[i]]])) + normal @ offset
            levels[i, at.CONSTANT] = side * level.rounded[0, 0]
        inverse = (inward @ _twice(self._factor.T)).rounded
        inward_rows = inward.rounded.reshape(n, 2, 2 * n)
        frame = {
            "inward": inward_rows,
            "pull": pull.rounded[:, 0],
            "direct": direct,
            "modes": modes,
            "guard": guard,
            "levels": levels,
            "shape": shape,
            "offset": (back.T @ offset).rounded[:, 0],
            "inverse": np.ascontiguousarray(inverse).reshape(n, 2, 2 * n),
            "kick": self._kicks(inward, free, held),
        }
        for i in range(s):
            levels[i, at.SELF_DRAG] = _self_drag(frame, i)
        return frame

    @cached_property
    def _matrices(self) -> tuple[Wide, Wide]:
        """Stiffness and damping in coordinates of unit mass."""
        back, structure = self._back, self.structure
        return (
            back @ _wide(structure.stiffness) @ back.T,
            back @ _wide(structure.damping) @ back.T,
        )

    @cached_property
    def _sizes(self) -> tuple[Floats, Floats]:
        """Sizes (n,) of the coordinates: their products are what entries of K and C are rounded to."""
        spread = np.abs(self.inverse_factor)
        return (
            matmul(spread, entry_sizes(self.structure.stiffness_matrix)),
            matmul(spread, entry_sizes(self.structure.damping_matrix)),
        )

    def _constraint(self, held: Sequence[int]) -> tuple[Wide, Wide, Wide]:
        """Return an orthonormal basis of what walls leave free, a point they allow, and reactions.

        The reaction of each wall is minus its row times the force that is not the walls'.
        """
        n = self.structure.n
        if not held:
            return Wide.unit(n), Wide.zeros(n, 1), Wide.zeros(0, n)
        normals = self._wide_normals[list(held)]
        sizes, rows = directions(normals.rounded)
        if len(held) > n or sizes[len(held) - 1] <= 1e-10 * sizes[0]:
            walls = ", ".join(f"stops.{i}" for i in held)
            raise ConvergenceError(
                f"the walls {walls} hold one displacement twice",
                None,
                float(sizes[-1]),
                "leave one of them out, or move it a little",
            )
        reactions = (normals @ normals.T).solve(normals)
        offset = -(reactions.T @ Wide.of(self._levels[list(held)][:, None]))
        free = Wide.of(rows[len(held) :])
        free = (free - (free @ normals.T) @ reactions).orthonormal()
        return free, offset, reactions

    def _kicks(self, inward: Wide, free: Wide, held: Sequence[int]) -> Floats:
        """Return the jumps of the modes that change the velocity of each clearance by 1."""
        n = self.structure.n
        kicks = np.zeros((len(self.structure.stops), n, 2))
        for i in range(len(kicks)):
            if i in held:
                continue
            normal = self._wide_normals[i : i + 1]
            along = free.T @ (free @ normal.T)
            square = along.T @ along
            # What held walls leave of a direction may be nothing: such a stop cannot be struck.
            if square.rounded[0, 0] > 1e-20 * (normal @ normal.T).rounded[0, 0]:
                kick = (square.inverse() * (inward[:, n:] @ along)).rounded
                kicks[i] = kick.reshape(n, 2)
        return kicks


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
        return _frames_of(self.structure)

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

    def add(self, *keys: int) -> None:
        """Make the sets of the stops of these bits, and append them to the arrays.

        Raises
        ------
        ConvergenceError
            If the modes of one cannot be told apart, or walls hold the structure that hold it twice.
        ParameterError
            If all sets together take more than a gigabyte.
        """
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
        """The accelerations by each harmonic in coordinates of unit mass, (n_harmonics, n): cos - i sin."""
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
        free = Oscillator(stiffness=0, damping=0)
        return _stacked(
            [
                law_of(free, _record_alone(forcing))
                for forcing in self.loads.forcings
                if forcing.record is not None
            ]
        )

    def _make(self, key: int) -> dict[str, Floats]:
        """Return the arrays of one set."""
        frame, n = self._frames.at(key), self.structure.n
        inward, direct = frame["inward"], frame["direct"]
        modes, levels, guard = (frame[name].copy() for name in ("modes", "levels", "guard"))
        pull = frame["pull"] + self._constant
        modes[:, at.FORCE] = matmul(inward[:, 1, n:], pull)
        modes[:, at.RATE] = matmul(inward[:, 0, n:], pull)
        levels[:, at.CONSTANT] += matmul(direct, self._constant)
        m, r, s = len(self.omegas), len(self._record_directions), len(levels)
        drive = np.zeros((n, m, at.DRIVE_ENTRIES))
        feed = np.zeros((s, m, 2))
        for k, push in enumerate(self._pushes):
            for column, part in ((at.FORCE_COS, 1), (at.RATE_COS, 0)):
                drive[:, k, column] = matmul(inward[:, part, n:], push.real)
                drive[:, k, column + 1] = -matmul(inward[:, part, n:], push.imag)
            feed[:, k, 0], feed[:, k, 1] = matmul(direct, push.real), -matmul(direct, push.imag)
        record_drive = np.zeros((n, r, 2))
        for k, push in enumerate(self._record_directions):
            record_drive[:, k, 0] = matmul(inward[:, 1, n:], push)
            record_drive[:, k, 1] = matmul(inward[:, 0, n:], push)
        arrays = {name: frame[name] for name in ("shape", "offset", "inverse", "kick")} | {
            "modes": modes,
            "drive": drive,
            "record_drive": record_drive,
            "guard": guard,
            "levels": levels,
            "feed": feed,
            "record_feed": matmul(direct, self._record_directions.T) if r else np.zeros((s, 0)),
        }
        law = self._law(modes)
        arrays |= {"law": law, "of_set": self._bounds(law, arrays)}
        steps = np.zeros((MOST_DOUBLINGS + 1, n, at.STEP_ENTRIES + at.STEP_HARMONIC * m))
        turns = np.zeros((MOST_DOUBLINGS + 1, m, 2))
        n_levels = int(arrays["of_set"][at.N_LEVELS])
        shortest = float(arrays["of_set"][at.STEP_LENGTH])
        fill_steps(law, modes, shortest, steps[:n_levels], turns[:n_levels])
        return arrays | {"steps": steps, "turns": turns}

    def _law(self, modes: Floats) -> Law:
        """Return the modes as regions of a law under harmonics of these frequencies."""
        m, n = len(self.omegas), len(modes)
        law = np.zeros((FIRST_HARMONIC + m + n * (1 + m), COLUMNS))
        law[0, N_HARMONICS], law[0, N_REGIONS] = m, n
        for k, omega in enumerate(self.omegas):
            fill_harmonic(law[FIRST_HARMONIC + k], Component(omega, 1.0, 0.0))
        for j, mode in enumerate(modes):
            row = FIRST_HARMONIC + m + j * (1 + m)
            stiffness, damping = Fraction(mode[at.SPRING]), Fraction(mode[at.DRAG]) / 2
            law[row] = _motion_row(float(mode[at.SPRING]), float(mode[at.DRAG]))
            for k, omega in enumerate(self.omegas):
                fill_response(law[row + 1 + k], stiffness, damping, omega)
        return law

    def _bounds(self, law: Law, arrays: dict[str, Floats]) -> Floats:
        """Fill what bounds the guards' fourth derivatives; return the columns of the set.

        With K >= 0 the norm sqrt(K) |u| + |w| is that of the energy, which no free motion raises,
        with negative damping d by exp(|d| s) at most; with K < 0 it is max(p |u|, |w|), which grows
        by exp(p s), p = |d| / 2 + sqrt(d^2 / 4 + |K|) (docs/theory/structures.md).
        """
        modes, guard, levels = arrays["modes"], arrays["guard"], arrays["levels"]
        omegas = law[FIRST_HARMONIC : FIRST_HARMONIC + len(self.omegas), OMEGA]
        spring, drag = modes[:, at.SPRING], modes[:, at.DRAG]
        pace = 0.5 * np.abs(drag) + np.sqrt(0.25 * drag * drag + np.abs(spring))
        modes[:, at.ROOT] = np.where(spring >= 0.0, np.sqrt(np.abs(spring)), pace)
        growth = np.where(spring < 0.0, pace, np.where(drag < 0.0, np.abs(drag), 0.0))
        pushes = np.zeros(len(modes))
        for k, omega in enumerate(omegas.tolist()):
            force, rate = (
                np.sqrt(drive[:, 0] * drive[:, 0] + drive[:, 1] * drive[:, 1])
                for drive in (arrays["drive"][:, k, :2], arrays["drive"][:, k, 2:])
            )
            pushes += omega * omega * (force + modes[:, at.ROOT] * rate)
        modes[:, at.SURGE] = pushes
        fill_guard_bounds(arrays, omegas.tolist(), guard, arrays["feed"], levels)
        of_set = np.zeros(at.SET_COLUMNS)
        rates = np.concatenate([np.sqrt(np.abs(spring)), np.abs(drag), omegas])
        rates = rates[rates > 0.0]
        of_set[at.STEP_LENGTH] = ANY_STEP
        of_set[at.N_LEVELS] = MOST_DOUBLINGS + 1
        if len(rates):
            of_set[at.QUICKEST] = rates.max()
            of_set[at.STEP_LENGTH] = SHORTEST_PHASE / rates.max()
            longest = LONGEST_PHASE / rates.min()
            if growth.max() > 0.0:
                longest = min(longest, GROWING_PHASE / growth.max())
            doublings = 0
            while (
                doublings < MOST_DOUBLINGS
                and of_set[at.STEP_LENGTH] * 2.0 ** (doublings + 1) <= longest
            ):
                doublings += 1
            of_set[at.N_LEVELS] = doublings + 1
        of_set[at.GROWTH] = growth.max(initial=0.0)
        rates_used = np.abs(modes[:, at.RATE]).max(initial=0.0)
        rates_used = max(rates_used, float(np.abs(arrays["drive"][:, :, 2:]).max(initial=0.0)))
        rates_used = max(
            rates_used, float(np.abs(arrays["record_drive"][:, :, 1]).max(initial=0.0))
        )
        of_set[at.HAS_RATES] = float(rates_used > 0.0)
        return of_set


@lru_cache(maxsize=256)
def _frames_of(structure: Structure) -> StructureFrames:
    return StructureFrames(structure)


def _wide(rows: Sequence[Sequence[Exact]]) -> Wide:
    """Return a matrix of exact entries."""
    return Wide.of(
        [[e if isinstance(e, int | float) else as_fraction(e) for e in row] for row in rows]
    )


def _pairs_of(stiffness: Wide, damping: Wide, sizes: tuple[Floats, Floats]) -> ModePairs:
    """Return the modes of two matrices, kept: another load or place of a stop leaves them."""
    texts = (stiffness.parts.tobytes(), damping.parts.tobytes())
    return _pairs(len(stiffness), *texts, *(size.tobytes() for size in sizes))


@lru_cache(maxsize=256)
def _pairs(n: int, stiffness: bytes, damping: bytes, *sizes: bytes) -> ModePairs:
    one, other = (Wide(np.frombuffer(text).reshape(n, n, 2)) for text in (stiffness, damping))
    first, second = (np.frombuffer(text) for text in sizes)
    return mode_pairs(one, other, (first, second))


@lru_cache(maxsize=1024)
def _motion_row(spring: float, drag: float) -> Floats:
    row = np.zeros(COLUMNS)
    fill_motion(row, Fraction(spring), Fraction(drag) / 2)
    return row


@lru_cache(maxsize=256)
def _system(structure: Structure, loads: Loads) -> StructureSystem:
    return StructureSystem(structure, loads)


def fill_guard_bounds(
    arrays: dict[str, Floats], omegas: Sequence[float], guard: Floats, feed: Floats, levels: Floats
) -> None:
    """Fill what bounds the fourth derivatives of guards, (k, n, 3), of one set.

    Parameters
    ----------
    arrays
        Modes and drive of the set, by their names in `Sets`.
    omegas
        (m,) frequencies of the harmonics [1/time].
    guard, feed, levels
        (k, n, 3), (k, m, 2) and (k, LEVEL_COLUMNS) arrays of which OF_NORM, SURGES and TWIST are
        filled.
    """
    modes, drive = arrays["modes"], arrays["drive"]
    spring, drag = modes[:, at.SPRING], modes[:, at.DRAG]
    pace = 0.5 * np.abs(drag) + np.sqrt(0.25 * drag * drag + np.abs(spring))
    for i in range(len(guard)):
        p, q = guard[i, :, at.OF_U], guard[i, :, at.OF_W]
        p1, q1 = -spring * q, p - drag * q
        p2, q2 = -spring * q1, p1 - drag * q1
        with np.errstate(divide="ignore", invalid="ignore"):
            energy = np.sqrt(np.where(spring > 0.0, p2 * p2 / spring, 0.0) + q2 * q2)
            other = np.where(spring < 0.0, np.abs(p2) / pace, 0.0) + np.abs(q2)
        guard[i, :, at.OF_NORM] = np.where(spring >= 0.0, energy, other)
        levels[i, at.SURGES] = float((guard[i, :, at.OF_NORM] * modes[:, at.SURGE]).sum())
        twist = 0.0
        for k, omega in enumerate(omegas):
            force = drive[:, k, 0] - 1j * drive[:, k, 1]
            rate = drive[:, k, 2] - 1j * drive[:, k, 3]
            direct = complex(feed[i, k, 0], -feed[i, k, 1])
            whole = -omega * omega * complex((p1 * rate + q1 * force).sum())
            whole += -1j * omega**3 * complex((p * rate + q * force).sum()) + omega**4 * direct
            twist += math.hypot(whole.real, whole.imag)
        levels[i, at.TWIST] = twist


def _joined(parts: Sequence[Floats]) -> Floats:
    """Return arrays of one shape one below the other; `numpy.stack` takes ten times as long."""
    joined = np.empty((len(parts), *parts[0].shape))
    for i, part in enumerate(parts):
        joined[i] = part
    return joined


def _record_alone(forcing: Forcing) -> Forcing:
    return Forcing(record=forcing.record)


def _stacked(laws: Sequence[Law]) -> Floats:
    rows = max((len(law) for law in laws), default=1)
    stacked = np.zeros((len(laws), rows, COLUMNS))
    for rows_of_law, law in zip(stacked, laws, strict=True):
        rows_of_law[: len(law)] = law
    return stacked


def _twice(matrix: Wide) -> Wide:
    """Return the block-diagonal matrix of two equal blocks."""
    m, n = matrix.shape
    both = Wide.zeros(2 * m, 2 * n)
    both[:m, :n], both[m:, n:] = matrix, matrix
    return both


def _self_drag(arrays: dict[str, Floats], i: int) -> float:
    """Return less the change of a clearance's acceleration by a unit change of its velocity."""
    modes, kick = arrays["modes"], arrays["kick"][i]
    u1, w1 = kick[:, 1], -modes[:, at.SPRING] * kick[:, 0] - modes[:, at.DRAG] * kick[:, 1]
    u2, w2 = w1, -modes[:, at.SPRING] * u1 - modes[:, at.DRAG] * w1
    guard = arrays["guard"][i]
    return -float((guard[:, at.OF_U] * u2 + guard[:, at.OF_W] * w2).sum())


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
