"""A periodic orbit of a structure, and its search by shooting over whole periods of the loads."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels import eigenvalues as kernels
from percuss.kernels.structure.march import new_run
from percuss.kernels.structure.tangent import carry_run
from percuss.model.exact import whole
from percuss.model.loads import Loads, loads_of
from percuss.model.structure import Structure, check_start
from percuss.motion.simulate import simulate
from percuss.motion.structures import StructureTrajectory
from percuss.numerics import norm, solve_linear

__all__ = ["StructureOrbit", "find_structure_orbit", "period_map", "structure_orbit_at"]

# Residuals of an orbit, as a part of its size: rounding of a sequence of flights is some 1e-15.
SOLVED = 1e-12
MOST_STEPS = 30
# Newton's step may be halved so often before it counts as lost.
HALVINGS = 8
# Multipliers this near to the unit circle are on it.
ON_CIRCLE = 1e-9
# Events of one period.
MOST_EVENTS = 100_000


class PeriodMap(NamedTuple):
    """The image of a state after whole periods, its derivative, and the motion."""

    image: Floats
    derivative: Floats
    run: StructureTrajectory


def period_map(
    structure: Structure, loads: Loads, state: Floats, n_periods: int, *, derivative: bool = True
) -> PeriodMap:
    """Return the state (x, v), (2 n,), after whole periods of the loads, with its derivative.

    Raises
    ------
    ConvergenceError
        If the motion does not reach the end.
    """
    n = structure.n
    period = _period_of(loads)
    run = simulate(
        structure,
        loads,
        x0=state[:n].tolist(),
        v0=state[n:].tolist(),
        t_end=n_periods * period,
        max_impacts=MOST_EVENTS,
    )
    if run.t_end < n_periods * period:
        raise ConvergenceError(
            f"the motion does not last {n_periods} periods: {run.outcome.value}",
            state,
            math.nan,
            "",
        )
    x, v = run(run.t_end)
    image = np.concatenate([x, v])
    matrix = np.full((2 * n, 2 * n), np.nan)
    if derivative:
        matrix = derivative_of_run(run)
    return PeriodMap(image, matrix, run)


def derivative_of_run(run: StructureTrajectory) -> Floats:
    """Return the derivative of the state (x, v) at the end of a run by that at its start.

    Returns
    -------
    array
        (2 n, 2 n).
    """
    n = run.structure.n
    place = np.zeros((2, n, 2 * n))
    place[0, :, :n], place[1, :, n:] = np.eye(n), np.eye(n)
    record = run.record
    scratch = new_run(record.sets, 0, 0)._replace(
        events=record.events, marks=record.marks, states=record.states
    )
    carry_run(scratch, run.t_end, place, np.zeros((n, 2, 2 * n)), np.zeros((2, 2, n)))
    return place.reshape(2 * n, 2 * n)


def _period_of(loads: Loads) -> float:
    period = loads.period
    if period is None:
        reason = "the loads have no common period; give Loads(..., period=...)"
        raise ParameterError("loads.period", None, reason)
    return period


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureOrbit:
    """A periodic orbit of a structure, made by `find_orbit`.

    Attributes
    ----------
    structure, loads
        What moves.
    x0, v0
        (n,) coordinates [length] and velocities [length/time] at t = 0.
    n_periods
        Periods of the loads after which it repeats.
    multipliers
        (2 n,) complex array, eigenvalues of the derivative of the map over its period, the
        largest first.
    residual
        Largest part by which it fails to close, in units of its size.
    run
        The motion over one period of the orbit.
    """

    structure: Structure
    loads: Loads
    x0: Floats
    v0: Floats
    n_periods: int
    multipliers: Complexes
    residual: float
    run: StructureTrajectory = field(repr=False)
    monodromy: Floats = field(repr=False)

    @property
    def period(self) -> float:
        """Its period [time]."""
        return self.n_periods * _period_of(self.loads)

    @property
    def is_stable(self) -> bool:
        """Whether neighbours approach it: all multipliers lie inside the unit circle."""
        return bool((np.abs(self.multipliers) < 1.0 - ON_CIRCLE).all())

    @property
    def n_impacts(self) -> int:
        """Impacts on walls and entries into soft stops in a period."""
        return len(self.run.impacts) + int((self.run.crossings.direction == "in").sum())

    def __repr__(self) -> str:
        """Return the orbit in a line."""
        largest = float(np.abs(self.multipliers).max())
        kind = "stable" if self.is_stable else "unstable"
        periods = "1 period" if self.n_periods == 1 else f"{self.n_periods} periods"
        return (
            f"<StructureOrbit: {self.structure.n} coordinates, {periods} = {self.period:.6g}, "
            f"{self.n_impacts} impacts; {kind}, largest multiplier {largest:.6g}>"
        )


def find_structure_orbit(
    structure: Structure,
    loads: object,
    *,
    x0: object = None,
    v0: object = None,
    n_periods: int = 1,
    transient: int = 200,
) -> StructureOrbit:
    """Find a periodic orbit of a structure by Newton's method on the map over its period.

    Parameters
    ----------
    structure, loads
        What moves; the loads have a common period.
    x0, v0
        (n,) state at t = 0 near which to look [length, length/time]; default: at rest.
    n_periods
        Periods of the loads after which it repeats.
    transient
        Periods that the motion from there is followed before Newton's method begins, >= 0: 0 for
        an orbit that is not stable.

    Returns
    -------
    StructureOrbit
        The orbit, stable or not.

    Raises
    ------
    ConvergenceError
        If Newton's method finds none near.
    ParameterError
        If the loads have no common period.

    Examples
    --------
    Two masses, the first with a stiff stop, of example 03 of NLvib:

    >>> import percuss as pc
    >>> structure = pc.Structure(
    ...     mass=[1, 1], stiffness=[[1, -1], [-1, 2]], damping=[["0.03", "-0.03"], ["-0.03", "0.06"]],
    ...     stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
    ... )
    >>> loads = pc.Loads({1: pc.cosine("0.65", amplitude="0.1")})
    >>> orbit = pc.find_orbit(structure, loads)
    >>> orbit.run.crossings.t.round(9)
    array([0.148007457, 0.442556446])
    >>> orbit.is_stable
    True
    """
    loads = loads_of(structure, loads)
    n_periods, transient = whole("n_periods", n_periods, 1), whole("transient", transient, 0)
    start = check_start(structure, x0, v0)
    state = np.concatenate([start.x, start.v])
    if transient > 0:
        settled = period_map(structure, loads, state, n_periods * transient, derivative=False)
        state = settled.image
    return structure_orbit_at(structure, loads, state, n_periods)


def structure_orbit_at(
    structure: Structure, loads: Loads, state: Floats, n_periods: int
) -> StructureOrbit:
    """Return the orbit next to a state (x, v), by Newton's method with halved steps."""
    here = period_map(structure, loads, state, n_periods)
    unit = np.eye(2 * structure.n)
    error = _error(here, state)
    for _ in range(MOST_STEPS):
        step = solve_linear(here.derivative - unit, state - here.image)
        better = None
        part = 1.0
        for _ in range(HALVINGS):
            try:
                there = period_map(structure, loads, state + part * step, n_periods)
            except PercussError:
                part *= 0.5
                continue
            if _error(there, state + part * step) < error or error < SOLVED:
                better = there
                break
            part *= 0.5
        if better is None:
            break
        new_error = _error(better, state + part * step)
        if error < SOLVED and new_error >= 0.5 * error:
            break
        state, here, error = state + part * step, better, new_error
    if not error < SOLVED:
        raise ConvergenceError(
            "no periodic orbit found near this start", state, error, "start nearer to it"
        )
    n = structure.n
    return StructureOrbit(
        structure=structure,
        loads=loads,
        x0=state[:n],
        v0=state[n:],
        n_periods=n_periods,
        multipliers=multipliers_of_matrix(here.derivative),
        residual=error,
        run=here.run,
        monodromy=here.derivative,
    )


def _error(there: PeriodMap, state: Floats) -> float:
    """Return by how much a motion fails to close, as a part of its size."""
    size = max(norm(state), float(np.abs(there.image).max()))
    return float(np.abs(there.image - state).max()) / size if size > 0.0 else 0.0


def multipliers_of_matrix(matrix: Floats) -> Complexes:
    """Return the eigenvalues of a real matrix, the largest first, pairs side by side."""
    values = np.empty(len(matrix), dtype=np.complex128)
    if not kernels.eigenvalues(matrix.astype(np.complex128), values):
        raise ConvergenceError("no multipliers of an orbit found", None, math.nan, "")
    sizes = np.sqrt(values.real * values.real + values.imag * values.imag)
    # Of a real matrix: what is within rounding of the axis is real.
    small = np.abs(values.imag) <= 1e-12 * sizes.max(initial=0.0)
    values = np.where(small, values.real + 0j, values)
    order = sorted(
        range(len(values)),
        key=lambda i: (-round(float(sizes[i]), 12), -float(values[i].imag), -float(values[i].real)),
    )
    return np.asarray(values[order])
