"""A structure without its loads: its modes and its stops under each set of acting stops."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.kernels.law_columns import (
    COLUMNS,
    Law,
)
from percuss.kernels.structure import basis as at
from percuss.model.exact import Exact, as_float, as_fraction
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.structure import Structure
from percuss.model.system import law as law_of
from percuss.numerics import (
    ModePairs,
    Wide,
    directions,
    entry_sizes,
    matmul,
    mode_pairs,
)


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
        """L^-1 of M = L L^T, (n, n)."""
        return self._back.rounded

    @cached_property
    def walls(self) -> Floats:
        """Laws that hold one wall each, for its restitution."""
        laws = []
        for stop in self.structure.stops:
            walls = [Wall(0, stop.side, stop.restitution)] if isinstance(stop, Wall) else []
            laws.append(law_of(Oscillator(stiffness=0, damping=0, stops=tuple(walls)), None))
        return stacked_laws(laws)

    @cached_property
    def stops(self) -> Floats:
        """The stops as the kernels read them, (n_stops, STOP_COLUMNS)."""
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
            "shape": np.ascontiguousarray(shape.transpose(1, 2, 0)),
            "offset": (back.T @ offset).rounded[:, 0],
            "inverse": np.ascontiguousarray(inverse.reshape(n, 2, 2 * n).transpose(2, 1, 0)),
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


@lru_cache(maxsize=256)
def frames_of(structure: Structure) -> StructureFrames:
    """Return the frames of a structure, kept for the next system that has it."""
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


def stacked_laws(laws: Sequence[Law]) -> Floats:
    """Return laws as one array, with rows of zeros below those of the shorter ones."""
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
