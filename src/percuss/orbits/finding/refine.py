"""From a guess to an orbit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.kernels.law import PERIOD
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.orbits.finding.search import Guess
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution, solve
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.same import TOLERANCE, Signature, repetitions, signature_of

__all__ = ["Known", "refined", "solved"]

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
        """Tell whether a guess is as good as one of them."""
        return self._is_met(self.signature(guess), guess.trial, SETTLED)

    def holds(self, signature: Signature, trial: int = 0) -> bool:
        """Tell whether an orbit is one of them; if not, it is from now on."""
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
    """Tell whether an impact has no speed: an orbit may have any number of those at a graze."""
    speeds = np.abs(solution.unknowns[1 + len(guess.chain) :])
    # A velocity that is zero by restitution 0 is exactly so.
    return bool(((speeds > 0.0) & (speeds < IDLE * speeds.max())).any())


def _goes_back(guess: Guess, solution: Solution) -> bool:
    """Tell whether a flight lasts less than no time: that is no motion, not even a formal one."""
    durations = solution.unknowns[1 : 1 + len(guess.chain)]
    return bool(durations.min() < -SETTLED * durations.sum())


def once(guess: Guess, unknowns: NDArray[np.float64], times: int) -> Guess:
    """Return a guess that goes round several times as one that goes round once."""
    n = len(guess.chain)
    m = n // times
    first = np.concatenate([unknowns[: 1 + m], unknowns[1 + n :][:m]])
    counts = guess.n_impacts // times, guess.n_periods // times
    return Guess(guess.chain[:m], first, *counts, guess.trial)
