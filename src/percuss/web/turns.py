"""Work that is done in turns: whoever asks much waits, and others do not wait for it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import Any, TypeVar

from percuss.ensembles.threads import Threads

__all__ = ["Turn", "Turns"]

T = TypeVar("T")

# After so long others come first [s]. A motion asks a few times in that whether it is to go on.
SLICE = 0.02
# Of the time, the part of those that have had a slice where others come for the first time: whoever
# needs little does not wait for a round of those who need much, and these go on all the same.
SHARE = 0.1
# Threads, with those that wait for their next turn: more than there are clients.
MOST_THREADS = 2048


class Turn:
    """One piece of work, seen by itself.

    Parameters
    ----------
    turns
        Where its turns come from.
    work
        Called with this.
    """

    def __init__(self, turns: Turns, work: Callable[[Turn], Any]) -> None:
        self.turns = turns
        self.work = work
        self.future: Future[Any] = Future()
        self.is_begun = self.had_slice = False
        self.goes_on = threading.Event()
        self._since = self._spent = 0.0

    def begin(self) -> None:
        """Note that its turn begins."""
        self._since = time.monotonic()

    def end(self) -> float:
        """Note that its turn is over; return how long it was [s]."""
        before = self._spent
        self._spent, self._since = self.seconds(), 0.0
        return self._spent - before

    def seconds(self) -> float:
        """Return how long it has worked, without its waits [s]."""
        return self._spent + (time.monotonic() - self._since if self._since else 0.0)

    def pause(self) -> bool:
        """Let others work, if it is their turn; return whether to go on at all."""
        if time.monotonic() - self._since > SLICE:
            self.turns.give_way(self)
        return not self.turns.is_closed


class Turns:
    """Work by turns: a round robin of what is new, and one of what takes longer than a slice.

    Who asks is bound to a few questions at once elsewhere, so that a round is short.

    Parameters
    ----------
    n
        How many work at once.

    Examples
    --------
    >>> turns = Turns(1)
    >>> turns.submit(lambda turn: turn.pause()).result()
    True
    """

    def __init__(self, n: int) -> None:
        self._free = n
        self._new: deque[Turn] = deque()
        self._long: deque[Turn] = deque()
        # What those that have had a slice may still have [s].
        self._owed = 0.0
        self._all: set[Turn] = set()
        self._lock = threading.Lock()
        self._threads = Threads(MOST_THREADS)
        self.is_closed = False

    def submit(self, work: Callable[[Turn], T]) -> Future[T]:
        """Have work done; it should call ``turn.pause()`` now and then.

        Returns
        -------
        concurrent.futures.Future
            Its answer; it is cancelled when the turns are closed.
        """
        turn = Turn(self, work)
        with self._lock:
            if self.is_closed:
                turn.future.cancel()
                return turn.future
            self._all.add(turn)
            self._new.append(turn)
            self._hand_out()
        return turn.future

    def give_way(self, turn: Turn) -> None:
        """Wait until it is a turn's turn again; at once where no other waits."""
        with self._lock:
            self._count(turn)
            if not (self._new or self._long) or self.is_closed:
                turn.begin()
                return
            turn.goes_on.clear()
            self._long.append(turn)
            self._free += 1
            self._hand_out()
        turn.goes_on.wait()
        turn.begin()

    def close(self) -> None:
        """Cancel all answers; work is told by its next pause, and is not waited for."""
        with self._lock:
            if self.is_closed:
                return
            self.is_closed = True
            turns, self._all = self._all, set()
            for turn in turns:
                turn.goes_on.set()
            self._new.clear()
            self._long.clear()
        for turn in turns:
            turn.future.cancel()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _count(self, turn: Turn) -> None:
        """Note what a turn has taken; under the lock."""
        taken = turn.end()
        if turn.had_slice:
            self._owed = max(-1.0, self._owed - taken)
        else:
            self._owed = min(SLICE, self._owed + SHARE * taken)
        turn.had_slice = True

    def _hand_out(self) -> None:
        """Let the next ones work; under the lock."""
        while self._free > 0 and (self._new or self._long):
            is_long = self._long and (not self._new or self._owed > 0.0)
            turn = (self._long if is_long else self._new).popleft()
            self._free -= 1
            if turn.is_begun:
                turn.goes_on.set()
            else:
                turn.is_begun = True
                self._threads.submit(self._do, turn)

    def _do(self, turn: Turn) -> None:
        turn.begin()
        # Whoever waited may have gone.
        with suppress(InvalidStateError):
            try:
                if not turn.future.cancelled():
                    turn.future.set_result(turn.work(turn))
            except InvalidStateError:
                raise
            except BaseException as error:  # noqa: BLE001 - whoever waits is told
                turn.future.set_exception(error)
        with self._lock:
            self._count(turn)
            self._all.discard(turn)
            self._free += 1
            self._hand_out()
