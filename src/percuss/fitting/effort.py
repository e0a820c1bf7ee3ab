"""How much a fit may cost: the searches for events that its runs make."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# Searches of the first run, of one with many segments more of each; and of all runs.
OF_RUN, OF_SEGMENT, OF_ALL = 20_000, 200, 100_000
# Of later runs and of all: so many times those of the first run that was followed, and some more.
RUNS, MORE, ALL_RUNS = 50, 2_000, 500


def go_on() -> bool:
    """Return True: nothing asks the search to stop."""
    return True


@dataclass(eq=False)
class Effort:
    """The searches for events that the runs of a fit may make.

    At settings far from the data a motion may need millions of them, and a fit would seem to hang.
    They are counted, not timed, so that a fit ends at one place on every machine.

    Attributes
    ----------
    ask
        Called between searches; False ends the run.
    of_run, of_all
        The most of one run of all segments, and of all runs.
    made, made_in_run
        How many were made so far, and in this run.

    Examples
    --------
    >>> effort = Effort()
    >>> effort.begin_run(n_segments=10)
    >>> effort.spend(10)
    True
    >>> effort.end_run(is_followed=True)
    >>> effort.begin_run(n_segments=10)
    >>> effort.spend(10_000), effort.is_spent
    (False, False)
    """

    ask: Callable[[], bool] = go_on
    of_run: int = OF_RUN
    of_all: int = OF_ALL
    made: int = 0
    made_in_run: int = 0
    _is_scaled: bool = False

    @property
    def is_spent(self) -> bool:
        """Whether no further run may be made."""
        return self.made >= self.of_all

    def begin_run(self, n_segments: int) -> None:
        """Begin to count the searches of a run."""
        self.made_in_run = 0
        if not self._is_scaled:
            self.of_run = max(OF_RUN, OF_SEGMENT * n_segments)
            self.of_all = max(OF_ALL, 5 * self.of_run)

    def spend(self, n: int) -> bool:
        """Count searches of the run; return whether it may go on."""
        self.made += n
        self.made_in_run += n
        return self.made_in_run <= self.of_run and not self.is_spent and self.ask()

    def end_run(self, *, is_followed: bool) -> None:
        """End a run; the first one that was followed is the scale for others."""
        if is_followed and not self._is_scaled:
            self._is_scaled = True
            self.of_run = MORE + RUNS * self.made_in_run
            self.of_all = max(OF_ALL, ALL_RUNS * self.made_in_run)
