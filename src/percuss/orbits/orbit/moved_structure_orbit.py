"""The derivative of a periodic orbit of a structure by parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Complexes, Floats
from percuss.errors import ParameterError
from percuss.model.oscillator import On
from percuss.motion.moved_measures import MovedMeasure
from percuss.motion.moved_motion import MovedImpacts
from percuss.motion.moved_structure_motion import rates_at
from percuss.motion.structure_measures import structure_measure_and_derivative
from percuss.motion.structure_sensitivity import (
    StructureSensitivity,
    structure_sensitivity_of,
    structure_slowing_of,
)
from percuss.motion.structures import StructureTrajectory
from percuss.numerics import solve_linear
from percuss.orbits.orbit.moved_monodromy import moved_monodromy, moved_multipliers
from percuss.orbits.orbit.moved_orbit import ON_FOLD, refuse_derivative, refuse_frequency_alone


class ClosedStructureMotion(NamedTuple):
    """A `StructureOrbit` as its derivative reads it; ``run`` is one period of its motion."""

    run: StructureTrajectory
    period: float
    monodromy: Floats
    multipliers: Complexes


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StructureOrbitSensitivity:
    """The derivative of an orbit of a structure by parameters; made by `StructureOrbit.sensitivity`.

    Called with times in the period, it gives the derivatives of x and v there.

    Attributes
    ----------
    paths
        The parameters, in their long form; the last axis of all arrays.
    x0, v0
        (n, n_parameters) arrays, of the orbit's state at t = 0.
    period
        (n_parameters,) array; an orbit keeps its number of periods of the loads.
    impacts
        Those of the orbit's impacts, `t`, `v_before` and `v_after`.
    motion
        That of one period of its motion.
    closed
        The orbit.
    """

    paths: tuple[str, ...]
    x0: Floats
    v0: Floats
    period: Floats
    impacts: MovedImpacts
    motion: StructureSensitivity
    closed: ClosedStructureMotion

    @property
    def multipliers(self) -> Complexes:
        """(2 n, n_parameters) complex array, of the multipliers in their order.

        NaN where two are equal; all NaN where the orbit rests on a wall, or strikes two at once.
        """
        monodromy = moved_monodromy(self.motion, self.period)
        if monodromy is None:
            shape = (len(self.closed.multipliers), len(self.paths))
            return np.full(shape, np.nan + 0j)
        return moved_multipliers(*monodromy, self.closed.multipliers)

    def __repr__(self) -> str:
        """Return what it is the derivative by, in a line."""
        return f"<StructureOrbitSensitivity: by {', '.join(self.paths)}>"

    def __call__(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return the derivatives of x and v at fixed times t in the first period."""
        return self.motion(t)

    def of(self, measure: MovedMeasure, on: On | None = None) -> Floats:
        """Return the derivative of a measure of one period; see `StructureSensitivity.of`."""
        return structure_measure_and_derivative(self.motion, measure, on, self.period)[1]


def sensitivity_of_structure_orbit(
    orbit: ClosedStructureMotion, paths: Sequence[str]
) -> StructureOrbitSensitivity:
    """Return the derivative of an orbit by parameters; see `StructureOrbit.sensitivity`.

    With M the monodromy and c the column of a period from a fixed start, the column w of the
    state at t = 0 obeys w = M w + c + z' dT.
    """
    run, n = orbit.run, orbit.run.structure.n
    still = _still(run, paths)
    if not still.differentiable:
        refuse_derivative(still.reason)
    if (np.abs(orbit.multipliers - 1.0) < ON_FOLD).any():
        refuse_derivative("it is on a fold, or one of a family")
    right, period = _closure(orbit, still)
    state = np.asarray(solve_linear(np.eye(2 * n) - orbit.monodromy, right))
    begin = np.concatenate([state, np.zeros((1, len(still.paths)))])
    motion = structure_sensitivity_of(run, paths, begin)
    return StructureOrbitSensitivity(
        paths=motion.paths,
        x0=state[:n],
        v0=state[n:],
        period=period,
        impacts=motion.impacts,
        motion=motion,
        closed=orbit,
    )


def closure_by_parameters(orbit: ClosedStructureMotion, paths: Sequence[str]) -> Floats | None:
    """Return how the image of an orbit's state after its period depends on parameters.

    Returns
    -------
    (2 n, n_parameters) array
        The derivatives of x and v from a fixed start; None where they do not exist.
    """
    still = _still(orbit.run, paths)
    if not still.differentiable:
        return None
    try:
        right, _ = _closure(orbit, still)
    except ParameterError:
        # The period is that of several loads, and no function of one of them.
        return None
    return right if np.isfinite(right).all() else None


def _still(run: StructureTrajectory, paths: Sequence[str]) -> StructureSensitivity:
    """Return the derivative of a run from a fixed start."""
    begin = np.zeros((2 * run.structure.n + 1, len(paths)))
    return structure_sensitivity_of(run, paths, begin)


def _closure(orbit: ClosedStructureMotion, still: StructureSensitivity) -> tuple[Floats, Floats]:
    """Return the derivatives of the state after a period, and of the period."""
    run = orbit.run
    slower = structure_slowing_of(still)
    refuse_frequency_alone(slower, still.paths)
    period = np.asarray(orbit.period * slower)
    end = np.concatenate(still(run.t_end))
    rate = rates_at(still.varied, run.t_end).reshape(-1)
    return end + rate[:, None] * period, period
