"""From a guess to an orbit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from percuss.errors import ConvergenceError
from percuss.model.system import System
from percuss.motion.trajectory import Trajectory
from percuss.orbits.finding.search import GivenGuess, Guess, counts_of_run, guess_of
from percuss.orbits.orbit.itinerary import TOLERANCE, Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.signature import Signature, signature_of
from percuss.orbits.orbit.solve import Solution, orbit_of_solution, solve
from percuss.wording import counts_in_words

# A guess this near a known orbit, in cycles and velocities, leads to it.
SETTLED = 1e-5
# Velocities below this part of the largest are rounding.
IDLE = 1e-10


class Known:
    """The orbits of one system that have been found."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.signatures: list[Signature] = []
        # The starts that led to each orbit, and whether the orbit is admissible.
        self.trials: list[set[int]] = []
        self.admissible: list[bool] = []

    def signature(self, itinerary: Itinerary, *, isolated: bool = True) -> Signature:
        """Return the signature of an orbit with this itinerary."""
        return signature_of(self.system, itinerary, isolated=isolated)

    def is_near(self, guess: Guess) -> bool:
        """Return whether a guess is as near to a known orbit as Newton's method would come."""
        return self._has(self.signature(guess.itinerary), guess.trial, SETTLED)

    def add(self, solution: Solution, trial: int = 0) -> bool:
        """Add the orbit of a solution, and return whether it was new."""
        signature = self.signature(solution.itinerary, isolated=solution.isolated)
        if self._has(signature, trial, TOLERANCE):
            return False
        self.signatures.append(signature)
        self.trials.append({trial})
        self.admissible.append(False)
        return True

    def _has(self, signature: Signature, trial: int, tolerance: float) -> bool:
        for trials, known in zip(self.trials, self.signatures, strict=True):
            if signature.matches(known, tolerance):
                trials.add(trial)
                return True
        return False


def refined(guess: Guess, known: Known) -> PeriodicOrbit | None:
    """Return the orbit that a guess leads to; None for none, or for a known one.

    Of a solution that covers a primitive orbit several times the primitive orbit is taken.
    """
    while not known.is_near(guess):
        solution = solve(known.system, guess.itinerary)
        if not solution.converged:
            return None
        times = solution.itinerary.times_covered
        if times == 1:
            if _has_idle_impact(solution.itinerary) or _has_negative_flight(solution.itinerary):
                return None
            if not known.add(solution, guess.trial):
                return None
            orbit = orbit_of_solution(known.system, solution)
            known.admissible[-1] = orbit.admissible
            return orbit
        guess = guess.primitive(solution.itinerary, times)
    return None


def _has_idle_impact(itinerary: Itinerary) -> bool:
    """Return whether an impact has zero velocity: at a graze an orbit may have any number."""
    speeds = np.abs(itinerary.velocities)
    # A velocity that is zero by restitution 0 is exactly so.
    return bool(((speeds > 0.0) & (speeds < IDLE * speeds.max())).any())


def _has_negative_flight(itinerary: Itinerary) -> bool:
    """Return whether a flight has a negative duration: not even a formal orbit of a search."""
    return bool(itinerary.durations.min() < -SETTLED * itinerary.durations.sum())


def counts_of_guess(given: GivenGuess, n_impacts: float, n_periods: int) -> tuple[float, int]:
    """Return the impacts and periods asked for, by default those of a run or an orbit."""
    if (n_impacts, n_periods) != (1, 1):
        return n_impacts, n_periods
    if isinstance(given, PeriodicOrbit):
        return given.n_impacts, given.n_periods or 1
    return counts_of_run(given) if isinstance(given, Trajectory) else (n_impacts, n_periods)


def orbit_near(
    system: System,
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
    guess = guess_of(system, n_impacts, n_periods, sequence, given)
    if isinstance(given, Trajectory):
        # The pattern that a run repeats may cover its orbit twice.
        orbit = refined(guess, Known(system))
        if orbit is not None:
            return orbit
    solution = solve(system, guess.itinerary)
    what = counts_in_words(guess.n_impacts, guess.n_periods)
    if not solution.converged:
        last = _as_pairs(solution.itinerary)
        advice = "try another guess, one nearer to the orbit"
        raise ConvergenceError(f"no orbit with {what} found", last, solution.residual, advice)
    times = solution.itinerary.times_covered
    if times > 1:
        last = _as_pairs(solution.itinerary)
        shorter = counts_in_words(guess.n_impacts // times, guess.n_periods // times)
        reason = f"the guess leads to the {times}-fold cover of an orbit with {shorter}"
        advice = f"try another guess, or ask for {shorter}"
        raise ConvergenceError(reason, last, solution.residual, advice)
    return orbit_of_solution(system, solution)


def _as_pairs(itinerary: Itinerary) -> list[tuple[float, float]]:
    """Return (t, v_after) of each event of an iterate."""
    return list(zip(itinerary.instants.tolist(), itinerary.velocities.tolist(), strict=True))
