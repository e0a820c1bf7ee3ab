"""How far a search for orbits has come: told to whoever asks, and bounded."""

from __future__ import annotations

import math

from percuss.errors import ParameterError
from percuss.kernels import law as at
from percuss.kernels.law import Law
from percuss.orbits.orbit.steady import regions
from percuss.progress import Progress, Report

__all__ = ["SearchBudget", "check_length", "swings_of"]

# Swings of an orbit that is looked for; of those that are found without a search, ten times more.
MOST_SWINGS = 100_000
# What a search takes at most, in swings of a motion that is followed: some ten seconds.
ALL_SWINGS = 1e7
# What Newton's method on so many equations and an orbit of so many swings take, in swings that are
# followed: a hundredth of the equations' cube, and twenty times as many, for its turning points.
SOLVING, MAKING = 0.01, 20.0


def swings_of(table: Law, time: float) -> float:
    """Return about how many swings a motion makes in a time.

    The time in a stiff stop is short: there it turns once, however high the frequency is.
    """
    n = int(table[0, at.N_HARMONICS])
    forced = table[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n, at.OMEGA].max(initial=0.0)
    springs = [math.sqrt(abs(float(table[row, at.STIFFNESS]))) for row in regions(table)]
    softest = min((omega for omega in springs if omega > 0.0), default=0.0)
    return time * max(float(forced), min(max(springs), 2.0 * softest)) / (2.0 * math.pi)


def check_length(table: Law, n_impacts: float, n_periods: int) -> None:
    """Raise an error if an orbit lasts longer than one that can be looked for."""
    period = n_periods * float(table[0, at.PERIOD])
    swings = swings_of(table, period)
    most = MOST_SWINGS * (10 if n_impacts in (0, math.inf) else 1)
    if swings > most:
        reason = (
            f"an orbit that lasts {period:.6g} makes some {swings:,.0f} swings; those of up to "
            f"{most:,} are looked for, and simulate follows longer motions"
        )
        raise ParameterError("n_periods", n_periods, reason)


class SearchBudget:
    """What a search has looked at.

    Parameters
    ----------
    table
        The law.
    report
        As ``progress`` of `percuss.find_orbits`.
    starts
        From how many starts it looks at most.

    Attributes
    ----------
    end_reason
        Why it is to end early; "" while it goes on.
    """

    def __init__(self, table: Law, report: Report = None, starts: int = 1) -> None:
        self.law, self.end_reason = table, ""
        self._progress, self._spent = Progress(report, starts, "starts looked at"), 0.0

    @property
    def n_done(self) -> int:
        """How many starts have been looked at."""
        return int(self._progress.done)

    def goes_on(self) -> bool:
        """Return whether to look at more."""
        return not self.end_reason

    def followed(self, time: float) -> None:
        """Take down a motion that was followed for a time."""
        self._spend(swings_of(self.law, time))

    def solved(self, n_events: int) -> None:
        """Take down that Newton's method was tried on an orbit with so many events."""
        self._spend(SOLVING * (2 * n_events + 1) ** 3)

    def made(self, period: float) -> None:
        """Take down that an orbit was found."""
        self._spend(MAKING * swings_of(self.law, period))

    def start_is_done(self) -> None:
        """Take down that the motion from a start has been looked at."""
        if not self._progress.advance():
            self.end_reason = "stopped by progress"

    def close(self) -> None:
        """End the line that tells of it, if there is one."""
        self._progress.close()

    def _spend(self, swings: float) -> None:
        self._spent += swings
        if self._spent > ALL_SWINGS and self.goes_on():
            self.end_reason = f"it took as long as {ALL_SWINGS:,.0f} swings of a motion, its most"
