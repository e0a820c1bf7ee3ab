"""The budget of a search for orbits, and its progress."""

from __future__ import annotations

import math

from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import Law
from percuss.orbits.orbit.steady import regions
from percuss.progress import Progress, Report

# Swings of an orbit at most; of those that are found without a search, ten times more.
MOST_SWINGS = 100_000
# The cost of a search at most, in swings of a simulated motion: some ten seconds.
ALL_SWINGS = 1e7
# The cost of Newton's method, and of making an orbit, in simulated swings: a hundredth of the cube
# of the number of equations, and twenty times the swings of the orbit, for its turning points.
SOLVING, MAKING = 0.01, 20.0


def swings_of(law: Law, time: float) -> float:
    """Return about how many swings a motion makes in a time.

    In a stiff stop it turns once only, however high the frequency is.
    """
    n = int(law[0, at.N_HARMONICS])
    forced = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n, at.OMEGA].max(initial=0.0)
    springs = [math.sqrt(abs(float(law[row, at.STIFFNESS]))) for row in regions(law)]
    softest = min((omega for omega in springs if omega > 0.0), default=0.0)
    return time * max(float(forced), min(max(springs), 2.0 * softest)) / (2.0 * math.pi)


def check_length(law: Law, n_impacts: float, n_periods: int, *, given: str = "n") -> None:
    """Raise a ParameterError if an orbit is longer than those that are searched for.

    Its numbers are called n_impacts and n_periods, or for another ``given`` word as that has it.
    """
    if MOST_SWINGS < n_impacts < math.inf:
        reason = f"orbits of up to {MOST_SWINGS:,} impacts are searched for"
        raise ParameterError(f"{given}_impacts", n_impacts, reason)
    period = n_periods * float(law[0, at.PERIOD])
    swings = swings_of(law, period)
    most = MOST_SWINGS * (10 if n_impacts in (0, math.inf) else 1)
    if swings > most:
        reason = (
            f"an orbit that lasts {period:.6g} makes some {swings:,.0f} swings; those of up to "
            f"{most:,} are searched for, and simulate follows longer motions"
        )
        raise ParameterError(f"{given}_periods", n_periods, reason)


class SearchBudget:
    """The starts and swings that a search has spent.

    Parameters
    ----------
    law
        The law of the motion.
    report
        As ``progress`` of `percuss.find_orbits`.
    starts
        The most starts of the search.

    Attributes
    ----------
    end_reason
        Why the search is to end early; "" while it goes on.
    """

    def __init__(self, law: Law, report: Report = None, starts: int = 1) -> None:
        self.law, self.end_reason = law, ""
        self._progress, self._spent = Progress(report, starts, "starts done"), 0.0

    @property
    def n_done(self) -> int:
        """The number of starts that are done."""
        return int(self._progress.done)

    def goes_on(self) -> bool:
        """Return whether the search goes on."""
        return not self.end_reason

    def followed(self, time: float) -> None:
        """Count the simulation of a motion for a time."""
        self._spend(swings_of(self.law, time))

    def solved(self, n_events: int) -> None:
        """Count Newton's method for an orbit with so many events."""
        self._spend(SOLVING * (2 * n_events + 1) ** 3)

    def made(self, period: float) -> None:
        """Count an orbit that was found."""
        self._spend(MAKING * swings_of(self.law, period))

    def start_is_done(self) -> None:
        """Count a start that is done."""
        if not self._progress.advance():
            self.end_reason = "stopped by progress"

    def close(self) -> None:
        """End the line of progress, if there is one."""
        self._progress.close()

    def _spend(self, swings: float) -> None:
        self._spent += swings
        if self._spent > ALL_SWINGS and self.goes_on():
            self.end_reason = f"it took as long as {ALL_SWINGS:,.0f} swings of a motion, its most"
