"""From a guess that is given to the orbit it leads to."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from percuss.errors import ConvergenceError
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.motion.trajectory import Trajectory
from percuss.orbits.finding.guessing import GivenGuess, counts_of_run, guess_of
from percuss.orbits.finding.refine import Known, refined, solved
from percuss.orbits.finding.search import Guess
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit, counted
from percuss.orbits.orbit.same import repetitions

__all__ = ["counts_of_guess", "described", "orbit_near"]


def described(n_impacts: float, n_periods: int) -> str:
    """Return a kind of orbit in words."""
    count = "sticking" if math.isinf(n_impacts) else counted(n_impacts, "impact")
    return count + (f" in {counted(n_periods, 'forcing period')}" if n_periods else "")


def counts_of_guess(given: GivenGuess, n_impacts: float, n_periods: int) -> tuple[float, int]:
    """Return the impacts and periods that are asked for, by default those of a run or an orbit."""
    if (n_impacts, n_periods) != (1, 1):
        return n_impacts, n_periods
    if isinstance(given, PeriodicOrbit):
        return given.n_impacts, given.n_periods or 1
    return counts_of_run(given) if isinstance(given, Trajectory) else (n_impacts, n_periods)


def orbit_near(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: int,
    n_periods: int,
    sequence: Sequence[int] | None,
    given: GivenGuess,
) -> PeriodicOrbit:
    """Return the orbit that a guess leads to.

    Raises
    ------
    ParameterError
        If the guess does not fit.
    ConvergenceError
        If it leads to none, or to one that is shorter.
    """
    guess = guess_of(osc, force, n_impacts, n_periods, sequence, given)
    if isinstance(given, Trajectory):
        # What a run repeats may be twice its orbit.
        orbit = refined(osc, force, guess, Known(osc, force))
        if orbit is not None:
            return orbit
    solution = solved(osc, force, guess)
    what = described(guess.n_impacts, guess.n_periods)
    if not solution.converged:
        last = _as_pairs(guess, solution)
        advice = "try another guess, one nearer to the orbit"
        raise ConvergenceError(f"no orbit with {what} found", last, solution.residual, advice)
    times = repetitions(guess.chain, solution.unknowns, guess.n_periods)
    if times > 1:
        last = _as_pairs(guess, solution)
        shorter = described(guess.n_impacts // times, guess.n_periods // times)
        reason = f"the guess leads to an orbit with {shorter}, {times} times round"
        advice = f"try another guess, or ask for {shorter}"
        raise ConvergenceError(reason, last, solution.residual, advice)
    return orbit_of_solution(osc, force, guess.chain, solution, guess.n_periods)


def _as_pairs(guess: Guess, solution: Solution) -> list[tuple[float, float]]:
    """Return (t, v_after) of each event of an iterate."""
    n = len(guess.chain)
    t = solution.unknowns[0] + np.concatenate([[0.0], np.cumsum(solution.unknowns[1:n])])
    return [(float(a), float(b)) for a, b in zip(t, solution.unknowns[1 + n :], strict=True)]
