"""Chaotic attractors told apart by where their strobes lie and by their largest exponents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.fates import CERTAIN, LEAST_EXPONENT, Arrays
from percuss.ensembles.lanes import Lanes, Plan, follow_lanes
from percuss.ensembles.refining import System
from percuss.ensembles.tangents import exponents_of, tangent_plan
from percuss.kernels import survey
from percuss.numerics import hypot

__all__ = ["Chaos", "same_chaos"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Strobes that fill an attractor, those of a motion that is asked for its attractor, and the cells
# along each axis in which they are compared.
FILLING, ASKED, CELLS = 4000, 40, 50
# Most strobes of a motion lie in a cell of the attractor or beside one.
MOST = 0.95
# Forcing periods of the exponent of an attractor, and of a motion that seems to have another.
LONG = 16_384
# Exponents that differ by more than so many standard errors are not the same.
DIFFERENT = 6.0
# Motions that are asked at a time.
AT_ONCE = 4096


@dataclass(frozen=True, slots=True)
class Chaos:
    """A chaotic motion that has gone over its attractor.

    Attributes
    ----------
    strobes
        (n, 2) array, x and v at whole periods.
    exponent, error
        Largest Lyapunov exponent and its standard error [1/time].
    lasts
        Whether it is still chaotic at the end of a long time.
    """

    strobes: Floats
    exponent: float
    error: float
    lasts: bool

    @classmethod
    def of(cls, system: System, strobe: Floats) -> Chaos:
        """Follow a chaotic motion from a strobe on."""
        strobes = _strobes(system, strobe[np.newaxis], FILLING)[0]
        largest, error = _exponents(system, strobe[np.newaxis], LONG)
        end = strobes[-1:]
        late = _exponents(system, end, LONG // 16)[0] if np.isfinite(end).all() else np.zeros(1)
        lasts = bool(
            largest[0] > max(CERTAIN * error[0], LEAST_EXPONENT / system.period)
            and late[0] > LEAST_EXPONENT / system.period
        )
        return cls(strobes, float(largest[0]), float(error[0]), lasts)


def same_chaos(system: System, chaos: Chaos, arrays: Arrays, rows: Numbers) -> NDArray[np.bool_]:
    """Tell which chaotic motions are on an attractor.

    Parameters
    ----------
    system
        What moves.
    chaos
        A motion that has gone over the attractor.
    arrays
        What has become of each start, by the names of `FateColumns`.
    rows
        (n,) array, the starts that are asked.

    Returns
    -------
    (n,) array
        True where strobes lie among those of the attractor and the exponents agree.
    """
    cells = _Cells(chaos.strobes)
    same = np.zeros(len(rows), dtype=np.bool_)
    for first in range(0, len(rows), AT_ONCE):
        those = rows[first : first + AT_ONCE]
        starts = np.asarray(arrays["strobe"], dtype=np.float64)[those]
        among = cells.share(_strobes(system, starts, ASKED)) > MOST
        own = np.asarray(arrays["exponent"], dtype=np.float64)[those]
        agree = _agree(chaos, own, np.asarray(arrays["exponent_error"], dtype=np.float64)[those])
        # A long look: of many motions some are beyond the errors of short ones by chance.
        doubtful = np.flatnonzero(among & ~agree)
        if len(doubtful):
            agree[doubtful] = _agree(chaos, *_exponents(system, starts[doubtful], LONG))
        same[first : first + AT_ONCE] = among & agree
    return same


def _agree(chaos: Chaos, exponents: Floats, errors: Floats) -> NDArray[np.bool_]:
    apart = np.abs(exponents - chaos.exponent)
    return np.asarray(apart <= DIFFERENT * hypot(errors, chaos.error))


class _Cells:
    """The cells of the plane that an attractor lies in, and those beside them."""

    def __init__(self, cloud: Floats) -> None:
        cloud = cloud[np.isfinite(cloud).all(axis=1)]
        self._low = cloud.min(axis=0)
        width = np.ptp(cloud, axis=0)
        self._size = np.where(width > 0.0, width, 1.0) / CELLS
        # Two cells of room on all sides: a place outside is in the outermost, which are empty.
        i, j = self._cell(cloud)
        full = np.zeros((CELLS + 5, CELLS + 5), dtype=np.bool_)
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                full[i + di, j + dj] = True
        self._full = full

    def _cell(self, places: Floats) -> tuple[Numbers, Numbers]:
        cells = np.floor((places - self._low) / self._size)
        number = np.clip(np.nan_to_num(cells, nan=-2.0), -2, CELLS + 2).astype(np.int64) + 2
        return number[..., 0], number[..., 1]

    def share(self, places: Floats) -> Floats:
        """Return which part of the places (n, m, 2) of each motion lies there."""
        return np.asarray(self._full[self._cell(places)].mean(axis=1))


def _strobes(system: System, starts: Floats, count: int) -> Floats:
    """Return so many strobes (n, count, 2) of each motion from one on, that one included."""
    since = np.full(len(starts), system.t0)
    every = np.full(len(starts), system.period)
    plan = Plan(since, every, since + (count - 1) * every, survey.STROBES, count)
    return np.asarray(_follow(system, starts, plan).points[:, :, :2])


def _exponents(system: System, starts: Floats, periods: int) -> tuple[Floats, Floats]:
    """Return the largest exponent of each motion and its standard error."""
    since = np.full(len(starts), system.t0)
    plan = tangent_plan(np.full(len(starts), system.period), since, 0, periods)
    largest, _, error, _ = exponents_of(_follow(system, starts, plan), plan)
    return largest, error


def _follow(system: System, starts: Floats, plan: Plan) -> Lanes:
    begin = np.column_stack([starts, plan.since])
    which = np.zeros(len(starts), dtype=np.int64)
    return follow_lanes(system.table[np.newaxis], which, begin, plan)
