"""A periodic orbit of a structure, and its search by shooting over whole periods of the loads."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels import eigenvalues as kernels
from percuss.kernels.record import KIND, KNOT, NEXT_REGION, START
from percuss.kernels.structure.run import StructureRun
from percuss.kernels.structure.sample import evaluate
from percuss.kernels.structure.tangent import carry_run
from percuss.model.acting_sets import StructureSystem, is_before_walls
from percuss.model.exact import whole
from percuss.model.loads import Loads, loads_of
from percuss.model.periods import require_period
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart, check_start
from percuss.motion.follow_structure import followed
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.structures import StructureImpacts, StructureTrajectory
from percuss.motion.trajectory import Outcome
from percuss.numerics import balanced, norm, solve_linear
from percuss.orbits.orbit.moved_structure_orbit import (
    ClosedStructureMotion,
    StructureOrbitSensitivity,
    sensitivity_of_structure_orbit,
)
from percuss.orbits.orbit.stability import ON_CIRCLE, Stability, stability_of_multipliers
from percuss.pictures import HasPicture
from percuss.wording import counted

# Residuals of an orbit, as a part of its size: rounding of a sequence of flights is some 1e-15.
SOLVED = 1e-12
MOST_STEPS = 30
# Newton's step may be halved so often before it counts as lost.
HALVINGS = 8
# Periods of an orbit after which a motion from rest may have settled.
SETTLING = 200
# States, a period apart, from which an orbit is then sought.
ATTEMPTS = 20
# Events of one period.
MOST_EVENTS = 100_000


class PeriodMap(NamedTuple):
    """The image of a state after whole periods, its derivative, and the record of the motion."""

    image: Floats
    derivative: Floats
    record: StructureRun

    @property
    def keys_met(self) -> tuple[int, ...]:
        """The sets of acting stops that the motion meets, by their bits."""
        keys = self.record.sets.keys.tolist()
        return tuple(keys[i] for i in dict.fromkeys(self.record.marks[:, NEXT_REGION].tolist()))


def period_map(
    system: StructureSystem, state: Floats, n_periods: int, *, derivative: bool = True
) -> PeriodMap:
    """Return the state (x, v), (2 n,), after whole periods of the loads, with its derivative.

    Raises
    ------
    ConvergenceError
        If the motion does not reach the end.
    """
    end = n_periods * period_of(system)
    return map_between(system, state, (0.0, end), f"{n_periods} periods", derivative=derivative)


def map_between(
    system: StructureSystem,
    state: Floats,
    span: tuple[float, float],
    how_long: str,
    *,
    derivative: bool = True,
) -> PeriodMap:
    """Return the state (x, v), (2 n,), at the end of a span of time, with its derivative.

    Raises
    ------
    ConvergenceError
        If the motion does not reach the end; ``how_long`` says in words when that is.
    """
    n = system.structure.n
    begin, end = span
    record, outcome = followed(system, (state[:n], state[n:], begin), end, MOST_EVENTS)
    if outcome is not Outcome.reached_t_end:
        what = f"the motion does not last {how_long}: {outcome.value}"
        raise ConvergenceError(what, state, math.nan, "start nearer to an orbit")
    place = np.empty((1, n, 2))
    evaluate(record, np.array([end]), True, place)
    image = np.concatenate([place[0, :, 0], place[0, :, 1]])
    matrix = derivative_at(record, end) if derivative else np.full((2 * n, 2 * n), np.nan)
    return PeriodMap(image, matrix, record)


def derivative_at(record: StructureRun, end: float) -> Floats:
    """Return the derivative of the state (x, v) at an instant by that at the start, (2 n, 2 n)."""
    n = len(record.begin)
    columns = np.zeros((2, n, 2 * n))
    columns[0, :, :n], columns[1, :, n:] = np.eye(n), np.eye(n)
    carry_run(record, end, columns, np.zeros((n, 2, 2 * n)), np.zeros((2, 2, n)))
    return columns.reshape(2 * n, 2 * n)


def period_of(system: StructureSystem) -> float:
    """Return the period of the loads, or raise a `ParameterError` where they have none."""
    return require_period(system.loads, "a periodic orbit needs loads of one period")


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureOrbit(HasPicture):
    """A periodic orbit of a structure, made by `find_orbit`.

    Attributes
    ----------
    structure, loads
        The structure and its loads.
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
    monodromy
        (2 n, 2 n) derivative of the map over its period.
    admissible
        Whether it is a motion; a formal orbit, beyond a graze on a branch, passes through a wall.
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
    admissible: bool = True

    picture: ClassVar = "plot_orbit"

    @property
    def period(self) -> float:
        """Its period [time]."""
        return self.n_periods * period_of(self.run.system)

    @property
    def is_steady(self) -> bool:
        """Whether it meets and leaves no stop: the response of a linear structure to its loads."""
        return bool(np.isin(self.run.record.marks[:, KIND], (START, KNOT)).all())

    @property
    def acting_first(self) -> int:
        """The stops that act from t = 0 on, as bits."""
        record = self.run.record
        return int(record.sets.keys[record.marks[0, NEXT_REGION]])

    @property
    def is_stable(self) -> bool:
        """Whether neighbours approach it: all multipliers lie inside the unit circle."""
        return bool((np.abs(self.multipliers) < 1.0 - ON_CIRCLE).all())

    @property
    def stability(self) -> Stability:
        """To first order: "asymptotic", "elliptic", "parabolic" or "unstable".

        Elliptic are orbits with complex pairs of multipliers on the unit circle and none outside,
        as without damping; parabolic those with one at +1 or -1.
        """
        return stability_of_multipliers(self.multipliers)

    @property
    def impacts(self) -> StructureImpacts:
        """The impacts on walls in a period, those of `run`."""
        return self.run.impacts

    @property
    def n_impacts(self) -> int:
        """Impacts on walls and entries into soft stops in a period."""
        return len(self.run.impacts) + int((self.run.crossings.direction == "in").sum())

    @property
    def strobes(self) -> Floats:
        """(x, v) at the beginning of each period of the loads, (n_periods, 2 n) array."""
        times = np.arange(self.n_periods) * (self.period / self.n_periods)
        return np.concatenate(self.run(times), axis=1)

    def sensitivity(self, paths: Sequence[str]) -> StructureOrbitSensitivity:
        """Return the derivative of the orbit by parameters, exact to rounding.

        Parameters
        ----------
        paths
            Paths of parameters of the structure and the loads, in long or short form, and names of
            parameters in expressions.

        Returns
        -------
        StructureOrbitSensitivity
            That of its state at t = 0, period, impacts, motion and measures.

        Raises
        ------
        ParameterError
            If there is no such parameter, or moved alone it leaves the loads without a period.
        ConvergenceError
            If the orbit grazes a wall, is on a fold, or is one of a family.

        Examples
        --------
        >>> import percuss as pc
        >>> wall = pc.Wall(at=0, side="above", restitution="0.7", on=0)
        >>> two = pc.chain(masses=[1, 1], springs=[1, 1, 1], dashpots="0.1", stops=[wall])
        >>> orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine(2)}))
        >>> d = orbit.sensitivity(["loads.0.amplitude"])
        >>> bool(abs(d.x0[:, 0] - orbit.x0).max() < 1e-9)
        True
        """
        return sensitivity_of_structure_orbit(self.closed_motion, paths)

    @property
    def closed_motion(self) -> ClosedStructureMotion:
        """What its derivatives by parameters are computed of."""
        return ClosedStructureMotion(self.run, self.period, self.monodromy, self.multipliers)

    def __repr__(self) -> str:
        """Return the orbit in a line."""
        largest = float(np.abs(self.multipliers).max())
        return (
            f"<StructureOrbit: {counted(self.structure.n, 'coordinate')}, "
            f"{counted(self.n_periods, 'period')} = {self.period:.6g}, "
            f"{counted(self.n_impacts, 'impact')}; {self.stability}, largest multiplier {largest:.6g}"
            f"{'' if self.admissible else '; formal: it passes through a wall'}>"
        )


def find_structure_orbit(
    structure: Structure, loads: object, guess: object = None, n_periods: int = 1
) -> StructureOrbit:
    """Find a periodic orbit of a structure by Newton's method on the map over its period.

    Parameters
    ----------
    structure, loads
        The structure and its loads, which have a common period.
    guess
        (x0, v0), the state at t = 0 near which to look [length, length/time], a run that settles
        on the orbit, or an orbit of a similar structure. Default: the motion from rest, after 200
        periods of the orbit, or some more where none is found from there.
    n_periods
        Periods of the loads after which it repeats; 1 stands for those of a guess that is a run or
        an orbit.

    Returns
    -------
    StructureOrbit
        The orbit, stable or not.

    Raises
    ------
    ConvergenceError
        If Newton's method finds none near.
    ParameterError
        If the loads have no common period, or the guess does not fit.
    """
    loads, n_periods = loads_of(structure, loads), whole("n_periods", n_periods, 1)
    system = StructureSystem.of(structure, loads)
    if guess is None:
        return _orbit_from_rest(system, n_periods)
    if isinstance(guess, StructureTrajectory):
        if n_periods == 1:
            n_periods = classify_impact_times(guess).n_periods or 1
        guess = _last_strobe(guess)
    elif isinstance(guess, StructureOrbit):
        n_periods = guess.n_periods if n_periods == 1 else n_periods
        guess = guess.x0.tolist(), guess.v0.tolist()
    if not isinstance(guess, tuple | list) or len(guess) != 2:
        reason = "not a state (x0, v0), and no run or orbit of a structure"
        raise ParameterError("guess", guess, reason)
    start = check_start(structure, guess[0], guess[1])
    return structure_orbit_at(system, np.concatenate([start.x, start.v]), n_periods)


def _orbit_from_rest(system: StructureSystem, n_periods: int) -> StructureOrbit:
    """Return the orbit next to where the motion from rest has come to.

    Where it does not settle, in chaos, Newton's method leads to an orbit from some of the states
    that it passes, and not from others.
    """
    start = check_start(system.structure)
    state = np.concatenate([start.x, start.v])
    state = period_map(system, state, n_periods * SETTLING, derivative=False).image
    for _ in range(ATTEMPTS - 1):
        try:
            return structure_orbit_at(system, state, n_periods)
        except ConvergenceError:
            state = period_map(system, state, n_periods, derivative=False).image
    return structure_orbit_at(system, state, n_periods)


def _last_strobe(run: StructureTrajectory) -> tuple[list[float], list[float]]:
    """Return the state at the last whole period of the loads in a run."""
    strobes = run.stroboscopic(cycle=0.0)
    if not strobes.sizes["period"]:
        raise ParameterError("guess", run, "a run without a whole period of its loads")
    return strobes.x[-1].values.tolist(), strobes.v[-1].values.tolist()


def structure_orbit_at(system: StructureSystem, state: Floats, n_periods: int) -> StructureOrbit:
    """Return the orbit next to a state (x, v), by Newton's method with halved steps."""
    here = period_map(system, state, n_periods)
    unit = np.eye(2 * system.structure.n)
    period = period_of(system)
    error = closing_error(here, state, period)
    for _ in range(MOST_STEPS):
        step = solve_linear(here.derivative - unit, state - here.image)
        better = None
        part = 1.0
        for _ in range(HALVINGS):
            if not is_before_walls(system.structure, state + part * step):
                # No motion begins there.
                part *= 0.5
                continue
            try:
                mapped = period_map(system, state + part * step, n_periods)
            except PercussError:
                part *= 0.5
                continue
            if closing_error(mapped, state + part * step, period) < error or error < SOLVED:
                better = mapped
                break
            part *= 0.5
        if better is None:
            break
        new_error = closing_error(better, state + part * step, period)
        if error < SOLVED and new_error >= 0.5 * error:
            break
        state, here, error = state + part * step, better, new_error
    if not error < SOLVED:
        raise ConvergenceError(
            "no periodic orbit found near this start", state, error, "start nearer to it"
        )
    return orbit_of_map(system, state, n_periods, here, error)


def covered_twice(orbit: StructureOrbit) -> StructureOrbit:
    """Return an orbit as one of twice the period."""
    system = StructureSystem.of(orbit.structure, orbit.loads)
    state, n_periods = np.concatenate([orbit.x0, orbit.v0]), 2 * orbit.n_periods
    mapped = period_map(system, state, n_periods)
    error = closing_error(mapped, state, period_of(system))
    return orbit_of_map(system, state, n_periods, mapped, error)


def orbit_of_map(
    system: StructureSystem,
    state: Floats,
    n_periods: int,
    mapped: PeriodMap,
    error: float,
    *,
    admissible: bool = True,
) -> StructureOrbit:
    """Return the orbit of a state that its period map brings back."""
    structure, loads, n = system.structure, system.loads, system.structure.n
    start = StructureStart(state[:n].tolist(), state[n:].tolist())
    end = n_periods * period_of(system)
    run = StructureTrajectory.of_run(system, start, mapped.record, end, Outcome.reached_t_end)
    return StructureOrbit(
        structure=structure,
        loads=loads,
        x0=state[:n],
        v0=state[n:],
        n_periods=n_periods,
        multipliers=multipliers_of_matrix(mapped.derivative),
        residual=error,
        run=run,
        monodromy=mapped.derivative,
        admissible=admissible,
    )


def closing_error(mapped: PeriodMap, state: Floats, period: float) -> float:
    """Return by how much a motion fails to close, as a part of its size; see `in_lengths`."""
    begin, end = in_lengths(state, period), in_lengths(mapped.image, period)
    size = max(norm(begin), float(np.abs(end).max()))
    return float(np.abs(end - begin).max()) / size if size > 0.0 else 0.0


def in_lengths(states: Floats, period: float) -> Floats:
    """Return states (x, v), (..., 2 n), with velocities as what they move in a radian of the loads.

    Distances of states are then the same in every unit of time.

    Examples
    --------
    >>> in_lengths(np.array([1.0, 3.0]), np.pi)
    array([1. , 1.5])
    """
    n = states.shape[-1] // 2
    return np.asarray(states * np.repeat([1.0, period / (2.0 * math.pi)], n))


def multipliers_of_matrix(matrix: Floats) -> Complexes:
    """Return the eigenvalues of a real matrix, the largest first, pairs side by side."""
    values = np.empty(len(matrix), dtype=np.complex128)
    if not kernels.eigenvalues(balanced(matrix).astype(np.complex128), values):
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
