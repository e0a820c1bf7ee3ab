"""The arrays in which a run keeps its state and writes down what happened."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Integers: TypeAlias = NDArray[np.int64]

# What an event is: column KIND of the marks.
# (As int64 and not int, for which numba would compile a function anew for each value.)
# After a SLOW_LANDING, whose speed is lost in its own rounding, the mass is at rest on the wall.
IMPACT, CROSSING, CONTACT, RELEASE, START, SLOW_LANDING = (np.int64(kind) for kind in range(6))

# Why `march` came back.
MOVING, REACHED_END, REACHED_LIMIT, AT_REST, OVERFLOW, NO_MORE, FULL, SPENT = range(8)

# Entries of the state: the last event's instant, place, velocity after it, and constant force;
# how far the flight, or contact, from it has been searched; the greatest impact speed so far.
T, T_LOW, X, V, FORCE, FREE_BELOW, FREE_ABOVE, HELD, FASTEST = range(9)
STATE_ENTRIES = 9
# Entries of the counters: the region's row; the wall touched, as the sign of its normal (0 in
# flight); and how many events, impacts or entries into soft stops, and grazes there were.
REGION, TOUCHED, N_EVENTS, N_IMPACTS, N_GRAZES = range(5)
COUNTERS = 5

# Columns of `events`. For a CONTACT, V_BEFORE holds the error bound of its instant.
EVENT_T, EVENT_T_LOW, V_BEFORE, V_AFTER = range(4)
EVENT_COLUMNS = 4
# Columns of `marks`: kind of the event, number of the bound, row of the region that follows.
KIND, BOUND, NEXT_REGION = range(3)
MARK_COLUMNS = 3
# Columns of `grazes`.
GRAZE_T, GRAZE_T_LOW, GRAZE_BOUND, GRAZE_CLEARANCE, GRAZE_ERROR = range(5)
GRAZE_COLUMNS = 5

# Beyond this the squares in a bound would overflow.
HUGE = 1e150
