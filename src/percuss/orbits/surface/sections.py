"""The two sections of a motion, with their maps forth and back in time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.kernels import backward as engine
from percuss.kernels import law as at
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall
from percuss.orbits.orbit.chain import Entry, entry
from percuss.orbits.surface.backward import BackwardMotions
from percuss.orbits.surface.maps import impact_map, stroboscopic_map

__all__ = ["ImpactSection", "Section", "SectionKind", "StroboscopicSection"]

Floats = NDArray[np.float64]
SectionKind: TypeAlias = Literal["stroboscopic", "impact"]

# Natural or forcing periods in which the impact before one is looked for.
LONGEST = 100.0


@dataclass(slots=True)
class StroboscopicSection:
    """The plane (x, v) at one cycle, and the maps over one forcing period.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    cycle
        The cycle.
    fastest
        Velocity beyond which motions are not followed back [length/time].
    """

    oscillator: Oscillator
    forcing: Forcing
    cycle: float
    fastest: float
    _past: BackwardMotions = field(init=False)

    def __post_init__(self) -> None:
        self._past = BackwardMotions(self.oscillator, self.forcing)

    def forth(self, points: Floats) -> Floats:
        """Return (n, 2) points one period later; NaN for NaN."""
        known = np.isfinite(points).all(axis=1)
        found = np.full_like(points, np.nan)
        x, v = self._inside(points[known])
        found[known] = np.stack(stroboscopic_map(self.oscillator, self.forcing, cycle=self.cycle)(x, v), axis=1)  # fmt: skip
        return found

    def back(self, points: Floats) -> Floats:
        """Return (n, 2) points one period earlier; NaN where there was no such motion."""
        known = np.isfinite(points).all(axis=1)
        found = np.full_like(points, np.nan)
        x, v = self._inside(points[known])
        period = float(self._past.law[0, at.PERIOD])
        t = np.full(len(x), (1.0 + self.cycle) * period)
        past = self._past.follow(t, x, v, period, fastest=self.fastest)
        ends = np.stack(self._inside(np.stack([past.x_end, past.v_end], axis=1)), axis=1)
        ends[past.status != engine.AT_TIME] = np.nan
        found[known] = ends
        return found

    def apart(self, first: Floats, second: Floats) -> Floats:
        """Return the differences between points."""
        return second - first

    def _inside(self, points: Floats) -> tuple[Floats, Floats]:
        """Return x and v of points; rounding may have left some in a wall."""
        x = points[:, 0]
        for stop in self.oscillator.stops:
            if isinstance(stop, Wall):
                wall = as_float(stop.at)
                x = np.maximum(x, wall) if stop.side == "below" else np.minimum(x, wall)
        return x, points[:, 1]


@dataclass(slots=True)
class ImpactSection:
    """The impact surface (cycle, v_after) of a stop, and the maps to the next impact on it.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    stop
        Index of the stop.
    fastest
        Velocity beyond which motions are not followed back [length/time].
    """

    oscillator: Oscillator
    forcing: Forcing
    stop: int
    fastest: float
    _past: BackwardMotions = field(init=False)
    _entry: Entry = field(init=False)

    def __post_init__(self) -> None:
        self._past = BackwardMotions(self.oscillator, self.forcing)
        self._entry = entry(self.oscillator, self.stop)

    def forth(self, points: Floats) -> Floats:
        """Return (n, 2) points at the next impact; NaN where there is none, or after a contact."""
        moving = np.isfinite(points).all(axis=1) & (points[:, 1] != 0.0)
        found = np.full_like(points, np.nan)
        step = impact_map(self.oscillator, self.forcing, self.stop)
        found[moving] = np.stack(step(*points[moving].T), axis=1)
        return found

    def back(self, points: Floats) -> Floats:
        """Return (n, 2) points at the impact before; NaN where there was none."""
        known = np.isfinite(points).all(axis=1)
        found = np.full_like(points, np.nan)
        stop = self.oscillator.stops[self.stop]
        before, region = points[known, 1].copy(), self._entry.before
        if isinstance(stop, Wall):
            restitution = as_float(stop.restitution)
            if restitution == 0.0:
                return found
            before /= -restitution
        period = float(self._past.law[0, at.PERIOD])
        past = self._past.follow(
            points[known, 0] * period,
            as_float(stop.at),
            before,
            LONGEST * period,
            region=self._past.row(region),
            bound=self._entry.bound,
            way=self._entry.way,
            fastest=self.fastest,
        )
        found[known] = np.stack([past.t[:, 0] / period % 1.0, past.v[:, 0]], axis=1)
        return found

    def apart(self, first: Floats, second: Floats) -> Floats:
        """Return the differences between points, less whole cycles."""
        found = second - first
        found[:, 0] = (found[:, 0] + 0.5) % 1.0 - 0.5
        return np.asarray(found)


Section: TypeAlias = StroboscopicSection | ImpactSection
