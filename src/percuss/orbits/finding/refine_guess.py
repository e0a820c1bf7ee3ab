"""From a guess to an orbit."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.kernels.law import PERIOD
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.motion.trajectory import Trajectory
from percuss.orbits.finding.search import GivenGuess, Guess, counts_of_run, guess_of
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution, solve
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit, counted
from percuss.orbits.orbit.same import TOLERANCE, Signature, repetitions, signature_of

__all__ = ["Known", "counts_of_guess", "described", "orbit_near", "refined", "solved"]

# A guess this near to a known orbit, in cycles and velocities, leads to it.
SETTLED = 1e-5
# Velocities below this part of the largest are rounding.
IDLE = 1e-10


class Known:
    """The orbits of one system that were found already."""

    def __init__(self, osc: Oscillator, force: Forcing | None) -> None:
        self.osc, self.forcing = osc, force
        self.law = law(osc, force)
        self.signatures: list[Signature] = []
        # Of each, the starts that led to it, and whether it is an admissible orbit.
        self.trials: list[set[int]] = []
        self.admissible: list[bool] = []

    def signature(self, guess: Guess, *, isolated: bool = True) -> Signature:
        """Return the signature that a guess would have as an orbit."""
        return signature_of(
            self.osc, self.law, guess.chain, guess.unknowns, guess.n_periods, isolated=isolated
        )

    def leads_to_one(self, guess: Guess) -> bool:
        """Return whether a guess is as good as one of them."""
        return self._is_met(self.signature(guess), guess.trial, SETTLED)

    def holds(self, signature: Signature, trial: int = 0) -> bool:
        """Return whether an orbit is one of them; if not, it is from now on."""
        if self._is_met(signature, trial, TOLERANCE):
            return True
        self.signatures.append(signature)
        self.trials.append({trial})
        self.admissible.append(False)
        return False

    def _is_met(self, signature: Signature, trial: int, tolerance: float) -> bool:
        for k, other in enumerate(self.signatures):
            if signature.matches(other, tolerance):
                self.trials[k].add(trial)
                return True
        return False


def solved(osc: Oscillator, force: Forcing | None, guess: Guess) -> Solution:
    """Return the solution of the equations of a guess's chain."""
    table = law(osc, force)
    period = guess.n_periods * float(table[0, PERIOD]) if guess.n_periods else None
    return solve(table, guess.chain, guess.unknowns, period)


def refined(
    osc: Oscillator, force: Forcing | None, guess: Guess, known: Known
) -> PeriodicOrbit | None:
    """Return the orbit that a guess leads to, None for none or one that is known.

    Of a solution that goes round an orbit several times, the orbit is taken once.
    """
    while not known.leads_to_one(guess):
        solution = solved(osc, force, guess)
        if not solution.converged:
            return None
        times = repetitions(guess.chain, solution.unknowns, guess.n_periods)
        if times == 1:
            if _has_idle_impact(guess, solution) or _goes_back(guess, solution):
                return None
            there = Guess(guess.chain, solution.unknowns, guess.n_impacts, guess.n_periods)
            if known.holds(known.signature(there, isolated=solution.isolated), guess.trial):
                return None
            orbit = orbit_of_solution(osc, force, guess.chain, solution, guess.n_periods)
            known.admissible[-1] = orbit.admissible
            return orbit
        guess = once(guess, solution.unknowns, times)
    return None


def _has_idle_impact(guess: Guess, solution: Solution) -> bool:
    """Return whether an impact has no speed: an orbit may have any number of those at a graze."""
    speeds = np.abs(solution.unknowns[1 + len(guess.chain) :])
    # A velocity that is zero by restitution 0 is exactly so.
    return bool(((speeds > 0.0) & (speeds < IDLE * speeds.max())).any())


def _goes_back(guess: Guess, solution: Solution) -> bool:
    """Return whether a flight lasts less than no time: that is no motion, not even a formal one."""
    durations = solution.unknowns[1 : 1 + len(guess.chain)]
    return bool(durations.min() < -SETTLED * durations.sum())


def once(guess: Guess, unknowns: Floats, times: int) -> Guess:
    """Return a guess that goes round several times as one that goes round once."""
    n = len(guess.chain)
    m = n // times
    first = np.concatenate([unknowns[: 1 + m], unknowns[1 + n :][:m]])
    counts = guess.n_impacts // times, guess.n_periods // times
    return Guess(guess.chain[:m], first, *counts, guess.trial)


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
