"""Attractors to full accuracy: from a motion that has settled to its periodic orbit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.law import PERIOD
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.orbits.finding.find import find_formal_orbit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import regions, steady_orbit
from percuss.orbits.orbit.sticking import sticking_orbits

__all__ = ["NEAR", "System", "impacts_at", "refined_orbit", "strobes_of_orbit"]

Floats = NDArray[np.float64]

# Strobes of the same periodic orbit are nearer to one another than this part of its size: motions
# that were called periodic agree with themselves to 1e-6 from round to round, and one that turns
# about its limit may be a hundred times as far from it.
NEAR = 3e-4
# Rounds of an orbit that a run goes, from which Newton's method starts.
ROUNDS = 3


@dataclass(frozen=True, slots=True)
class System:
    """What moves, and when its strobes are taken.

    Attributes
    ----------
    osc, force
        What moves; the forcing has a period.
    table
        Its law.
    t0
        An instant of a strobe [time].
    """

    osc: Oscillator
    force: Forcing
    table: Floats
    t0: float

    @classmethod
    def of(cls, osc: Oscillator, force: Forcing, t0: float) -> System:
        """Return a system with its law."""
        return cls(osc, force, law(osc, force), t0)

    @property
    def period(self) -> float:
        """The forcing period [time]."""
        return float(self.table[0, PERIOD])

    def run(self, strobe: Floats, periods: int) -> Trajectory:
        """Return the motion from a strobe on over so many forcing periods."""
        x, v = (float(part) for part in strobe)
        return simulate(self.osc, self.force, x, v, self.t0, t_end=self.t0 + periods * self.period)


def refined_orbit(
    system: System, strobe: Floats, n_periods: int, n_impacts: float
) -> PeriodicOrbit | None:
    """Return the periodic orbit that a motion has settled on, None where none is found there.

    Parameters
    ----------
    system
        What moves.
    strobe
        (2,) array, x and v of the motion at a strobe.
    n_periods, n_impacts
        Forcing periods and impacts of one round.

    Returns
    -------
    PeriodicOrbit or None
        The orbit, whose strobes lie where the motion's do.
    """
    try:
        for orbit in _candidates(system, strobe, n_periods, n_impacts):
            strobes = strobes_of_orbit(system, orbit, strobe)
            size = float(np.abs(strobes).max(initial=0.0)) or 1.0
            if orbit.admissible and np.abs(strobes[0] - strobe).max() <= NEAR * size:
                return orbit
    except (ConvergenceError, ParameterError):
        # It has not settled enough, or lies where impacts accumulate.
        return None
    return None


def _candidates(
    system: System, strobe: Floats, n_periods: int, n_impacts: float
) -> Iterator[PeriodicOrbit]:
    osc, force = system.osc, system.force
    if n_impacts == 0:
        for region in regions(system.table):
            try:
                yield steady_orbit(osc, force, region)
            except ConvergenceError:
                continue
        return
    run = system.run(strobe, ROUNDS * n_periods)
    last = run.t_end - n_periods * system.period
    if len(run.contacts) and run.contacts.start[-1] >= last:
        yield from sticking_orbits(osc, force, n_periods)
    else:
        yield find_formal_orbit(osc, force, n_impacts, n_periods, guess=run)


def strobes_of_orbit(system: System, orbit: PeriodicOrbit, near: Floats) -> Floats:
    """Return x and v of an orbit at all of its strobes, the one nearest to a place first.

    Returns
    -------
    (n_periods, 2) array
        In the order of time.
    """
    period = system.period
    first = system.t0 + math.ceil((orbit.t0 - system.t0) / period) * period
    t = first + np.arange(orbit.n_periods) * period
    strobes = np.stack(orbit.trajectory(2)(t), axis=1)
    nearest = int(np.abs(strobes - near).max(axis=1).argmin())
    return np.roll(strobes, -nearest, axis=0)


def impacts_at(
    system: System, stop: int, strobe: Floats, orbit: PeriodicOrbit | None, periods: int
) -> Floats:
    """Return cycle and speed after the impacts at a stop, of an orbit or of a motion.

    Returns
    -------
    (n, 2) array
        One row an impact.
    """
    impacts = orbit.impacts if orbit is not None else system.run(strobe, periods).impacts
    there = impacts.stop == stop
    return np.stack([impacts.cycle[there], np.abs(impacts.v_after[there])], axis=1)
