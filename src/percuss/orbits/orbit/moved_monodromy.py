"""The derivative of a structure's monodromy matrix and of its multipliers by parameters.

The monodromy is a product of propagators of flights and of jumps at events. Its derivative along
the orbit, which moves with the parameter, is carried beside it, column by column: over a flight by
the same power series as the columns of the motion, and over an event by the derivative of its jump
(docs/theory/sensitivities.md, section 8).
"""

from __future__ import annotations

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.kernels import record as events_of
from percuss.kernels.compile import uncompiled
from percuss.kernels.restitution import kept_of_error, restitution_at
from percuss.kernels.sensitivity import moved_restitution
from percuss.kernels.structure import sensitivity as engine
from percuss.kernels.structure.basis import DRAG, SPRING, basis_of, wall_of
from percuss.kernels.structure.columns import column_changes, new_series
from percuss.kernels.structure.flight import U, W
from percuss.kernels.structure.sample import flight_after
from percuss.kernels.structure.tangent import carry, to_modes, to_places
from percuss.motion.moved_structure_motion import MovedStructureMotion, scratch_of
from percuss.motion.structure_measures import taylor_of
from percuss.numerics import matmul, solve_linear

# Two multipliers whose directions are so nearly the same are equal to rounding.
EQUAL = 1e-7
# Inverse iteration: how far beside the multiplier, as a part of the largest, and how often.
BESIDE, TIMES = 1e-9, 4
# A part of a speed over which a piece of a table of restitutions is taken to be straight.
PIECE = 2.0**-8


def moved_monodromy(d: MovedStructureMotion, longer: Floats) -> tuple[Floats, Floats] | None:
    """Return the monodromy of a period of a motion, and its derivative along the orbit.

    Parameters
    ----------
    d
        The derivative of one period of the motion.
    longer
        (n_parameters,) array, that of its end.

    Returns
    -------
    (2 n, 2 n) and (2 n, 2 n, n_parameters) arrays
        None where the motion rests on a wall, lands at rest, or strikes two walls at once.
    """
    run, record = d.run, d.varied.run
    kinds = record.marks[:, events_of.KIND]
    instants = record.events[:, events_of.EVENT_T]
    met = (events_of.START, events_of.IMPACT, events_of.CROSSING, events_of.KNOT)
    if not np.isin(kinds, met).all() or (np.diff(instants[kinds != events_of.KNOT]) <= 0.0).any():
        return None
    carried = _Carried(d)
    moved_t = np.concatenate([d.columns.instants[:, engine.DT], longer[None]])
    ends = np.append(instants, run.t_end)
    lows = np.append(record.events[:, events_of.EVENT_T_LOW], 0.0)
    for row in range(len(instants)):
        s = (ends[row + 1] - ends[row]) + (lows[row + 1] - lows[row])
        carried.fly(row, float(s), moved_t[row + 1] - moved_t[row])
        if row + 1 < len(instants) and kinds[row + 1] != events_of.KNOT:
            carried.jump(row + 1, moved_t[row + 1])
    n = run.structure.n
    return carried.place.reshape(2 * n, -1), carried.moved.reshape(2 * n, 2 * n, -1)


class _Carried:
    """The derivatives of a state by the 2 n numbers of the start, and how parameters move them."""

    def __init__(self, d: MovedStructureMotion) -> None:
        self.d, self.varied = d, scratch_of(d.varied)
        n, p = d.run.structure.n, len(d.paths)
        self.n, self.p = n, p
        self.place = np.eye(2 * n).reshape(2, n, 2 * n)
        self.moved = np.zeros((2, n, 2 * n, p))
        run, given = self.varied.run, d.varied.moved
        self.series = new_series(n, len(run.phases), len(run.records), p)
        # Of the homogeneous equation: what a parameter changes of loads and places plays no part.
        still = ("push", "waves", "records")
        self.change = given._replace(**{k: np.zeros_like(getattr(given, k)) for k in still})

    def fly(self, row: int, s: float, longer: Floats) -> None:
        """Carry all over a flight of length s, which is longer with the parameters."""
        n, p = self.n, self.p
        run = self.varied.run
        sets, b = run.sets, int(run.marks[row, events_of.NEXT_REGION])
        columns, moved = np.zeros((n, 2, 2 * n)), np.zeros((n, 2, 2 * n * p))
        to_modes(sets, b, self.place, columns)
        to_modes(sets, b, np.ascontiguousarray(self.moved.reshape(2, n, -1)), moved)
        flight = flight_after(run, row)
        # A tuple of views that a kernel returns holds the whole arrays.
        own = uncompiled(basis_of)(sets, b)
        basis = own._replace(drive=np.zeros_like(own.drive))
        flight = flight._replace(basis=basis, pull=np.zeros_like(flight.pull))
        begin, changes = columns.copy(), np.zeros((n, 2, p))
        carry(own, s, columns)
        carry(own, s, moved)
        whole = moved.reshape(n, 2, 2 * n, p)
        for c in range(2 * n):
            self.series.present[...] = begin[:, :, c]
            column_changes(
                flight, self.change, b, (0.0, 0.0, s), np.zeros((n, 2, p)), changes, self.series
            )
            whole[:, :, c] += changes
        spring, drag = sets.modes[b, :, SPRING, None], sets.modes[b, :, DRAG, None]
        rate = np.stack([columns[:, W], -spring * columns[:, U] - drag * columns[:, W]], axis=1)
        whole += rate[..., None] * longer
        to_places(sets, b, columns, self.place)
        out = np.zeros((2, n, 2 * n * p))
        to_places(sets, b, whole.reshape(n, 2, -1), out)
        self.moved = out.reshape(2, n, 2 * n, p)

    def jump(self, row: int, late: Floats) -> None:
        """Carry all over an event, which comes later with the parameters."""
        run, given = self.varied.run, self.d.varied.moved
        sets, stop = run.sets, int(run.marks[row, events_of.BOUND])
        t, normal = float(run.events[row, events_of.EVENT_T]), run.sets.normals[stop]
        sides = [taylor_of(self.d, t, after=after, stop=stop) for after in (False, True)]
        # Rates (2, n) of the state, and how they move along with the event.
        before, after = (orders[1:3] for orders, _ in sides)
        moved_before, moved_after = (
            (moved + orders[1:, :, None] * late)[1:3] for orders, moved in sides
        )
        speed, faster = (
            float((normal * before[0]).sum()),
            (normal[:, None] * moved_before[0]).sum(0),
        )
        gap = (normal[:, None] * self.place[0]).sum(axis=0)
        moved_gap = (normal[:, None, None] * self.moved[0]).sum(axis=0)
        delay = -gap / speed
        moved_delay = -moved_gap / speed + (gap / (speed * speed))[:, None] * faster
        place = self.place + before[..., None] * delay
        moved = self.moved + moved_before[:, :, None] * delay[:, None]
        moved += before[..., None, None] * moved_delay
        if run.marks[row, events_of.KIND] == events_of.IMPACT:
            region, bound = wall_of(sets, stop)
            law = sets.walls[stop]
            kept = float(kept_of_error(law, region, bound, -speed))
            bent = np.array(
                [
                    moved_kept(law, given.walls[p, stop], (region, bound), -speed, -faster[p])
                    for p in range(self.p)
                ]
            )
            along, moved_along = sets.impulses[stop], given.impulses[stop]
            change = (normal[:, None] * place[1]).sum(axis=0)
            moved_change = (normal[:, None, None] * moved[1]).sum(axis=0)
            place[1] -= (1.0 + kept) * along[:, None] * change
            moved[1] -= (1.0 + kept) * along[:, None, None] * moved_change
            moved[1] -= (
                (1.0 + kept) * moved_along[:, None] + along[:, None, None] * bent
            ) * change[:, None]
        place -= after[..., None] * delay
        moved -= moved_after[:, :, None] * delay[:, None]
        moved -= after[..., None, None] * moved_delay
        self.place, self.moved = place, moved


def moved_kept(
    law: Floats, rows: Floats, where: tuple[int, int], speed: float, faster: float
) -> float:
    """Return how the derivative of r(u) u by the speed u moves, along with the speed.

    Parameters
    ----------
    law, rows
        The law of the wall, and its change by the parameter.
    where
        Its region and bound.
    speed, faster
        The speed, and how it moves.
    """
    region, bound = where

    def of(u: float) -> tuple[float, float, float]:
        """Return r, how it moves at that speed, and what is asked for."""
        return (
            float(restitution_at(law, region, bound, u)),
            float(moved_restitution(law, rows, region, bound, u)),
            float(kept_of_error(law, region, bound, u)),
        )

    r, moved, kept = of(speed)
    # Between two speeds of a table r(u) and how it moves are linear: the piece beside u is that of
    # u itself where the slopes of r are the same.
    slope = (kept - r) / speed
    tilts = []
    for step in (PIECE * speed, -PIECE * speed):
        other = of(speed + step)
        its_slope = (other[2] - other[0]) / (speed + step)
        tilts.append((abs(its_slope - slope), (other[1] - moved) / step))
    tilt = min(tilts)[1]
    return 2.0 * slope * faster + moved + speed * tilt


def moved_multipliers(monodromy: Floats, moved: Floats, multipliers: Complexes) -> Complexes:
    """Return the derivatives of multipliers, (n, n_parameters), NaN of those that are equal.

    With the right and left eigenvectors x, y of a multiplier it is y M' x / y x.
    """
    n, p = len(monodromy), moved.shape[2]
    size = float(np.abs(multipliers).max(initial=0.0))
    derivatives = np.full((n, p), np.nan + 0j)
    if size == 0.0:
        return derivatives
    for i, value in enumerate(multipliers.tolist()):
        right, left = (_direction(part, value, size) for part in (monodromy, monodromy.T))
        # Of a semisimple pair the iteration finds one of its vectors, of a defective one y x = 0.
        both = (left * right).sum()
        others = np.abs(np.delete(multipliers, i) - value)
        if abs(both) < EQUAL or others.min(initial=np.inf) < EQUAL * size:
            continue
        for k in range(p):
            image = matmul(moved[..., k], right.real) + 1j * matmul(moved[..., k], right.imag)
            derivatives[i, k] = (left * image).sum() / both
    return derivatives


def _direction(matrix: Floats, value: complex, size: float) -> Complexes:
    """Return the unit vector that a matrix multiplies by an eigenvalue, by inverse iteration."""
    n = len(matrix)
    shift = value + BESIDE * size
    real, imaginary = matrix - shift.real * np.eye(n), -shift.imag * np.eye(n)
    whole = np.block([[real, -imaginary], [imaginary, real]])
    vector = np.ones(2 * n) + 0.1 * np.arange(2 * n)
    for _ in range(TIMES):
        vector = np.asarray(solve_linear(whole, vector))
        vector = vector / np.sqrt((vector * vector).sum())
    return np.asarray(vector[:n] + 1j * vector[n:])
