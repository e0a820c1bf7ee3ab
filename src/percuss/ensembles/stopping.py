"""Whether what a thread is doing is still wanted, asked between the steps of its work.

A thread cannot be ended from outside: it looks at a flag of its own, which compiled loops take as
an array and look at too. Elsewhere than in the threads of `Threads` the flag is never set.
"""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError

__all__ = ["UnwantedError", "check_wanted", "obey", "stop_flag"]

_own = threading.local()
_NEVER = np.zeros(1, dtype=np.int64)


class UnwantedError(PercussError):
    """Work was given up because nobody waits for it any more."""


def obey(flag: NDArray[np.int64]) -> None:
    """Give up the work of this thread once the flag's only entry is not 0."""
    _own.flag = flag


def stop_flag() -> NDArray[np.int64]:
    """Return the flag of this thread, (1,) array: 0 as long as its work is wanted."""
    found: NDArray[np.int64] = getattr(_own, "flag", _NEVER)
    return found


def check_wanted() -> None:
    """Raise `UnwantedError` if nobody waits for the work of this thread any more.

    Examples
    --------
    >>> check_wanted()
    """
    if stop_flag()[0] != 0:
        raise UnwantedError("given up")
