"""The extreme displacements of a periodic motion, exact from the closed form of its flights."""

from __future__ import annotations

import math
from dataclasses import dataclass

from percuss.arrays import Floats, Integers
from percuss.kernels.law_columns import Law
from percuss.kernels.record import MotionRecord, place_of_event
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.turning_points import flight_turns, flights_of


@dataclass(frozen=True, slots=True)
class Extremes:
    """The least and the largest displacement of a periodic motion.

    Attributes
    ----------
    low, high
        Over a whole period [length].
    """

    low: float
    high: float

    @property
    def amplitude(self) -> float:
        """Half the distance between them [length]."""
        return 0.5 * (self.high - self.low)

    @property
    def largest(self) -> float:
        """The largest abs(x) [length]."""
        return max(abs(self.low), abs(self.high))


def extremes_of(orbit: PeriodicOrbit) -> Extremes:
    """Return the extremes of an orbit, over its turning points and events; nothing is sampled.

    Between two events the motion is a closed form, whose turning points are the zeros of its
    velocity; at an impact it turns at the wall. A formal orbit is followed beyond the stops that it
    penetrates.

    Parameters
    ----------
    orbit
        Any periodic orbit, with sticking too.

    Returns
    -------
    Extremes
        To rounding.

    Examples
    --------
    Far from the wall the motion is the linear response, A = 1/sqrt((k - w^2)^2 + (2 a w)^2):

    >>> import math
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=5.0, side="above", damping=0.05)
    >>> orbit = pc.find_orbit(osc, pc.cosine(2.0), n_impacts=0)
    >>> abs(extremes_of(orbit).amplitude - 1.0 / math.hypot(3.0, 0.2)) < 1e-15
    True
    """
    t_end = orbit.t0 + orbit.period
    is_steady = len(orbit.record[0]) == 1
    if is_steady:
        # Without events a period and a half holds both extremes, wherever it starts.
        t_end += 0.5 * orbit.period
    return extremes_of_record(orbit.system.law, *orbit.record, orbit.x0, t_end, is_steady=is_steady)


def extremes_of_record(
    law: Law,
    events: Floats,
    marks: Integers,
    x0: float,
    t_end: float,
    *,
    is_steady: bool = False,
) -> Extremes:
    """Return the extremes of a motion between the first and the last row of its record.

    Parameters
    ----------
    law
        The law of the motion.
    events, marks
        A record of `march`; its first row may be any event.
    x0
        Displacement at the first row where that is a start [length].
    t_end
        End of the motion if there is one row only [time].
    """
    is_alone = len(events) == 1
    record = MotionRecord(law, x0, events, marks)
    rows = range(1 if is_alone else len(events) - 1)
    displacements = [place_of_event(record, row) for row in rows]
    # No flight follows the last of several rows.
    for _, region, x, start, duration in flights_of(
        law, events, marks, x0, t_end if is_alone else -math.inf
    ):
        turns = flight_turns(law, region, x, start, duration, is_steady=is_steady)
        displacements += [x + y for y in turns[:, 1].tolist()]
    return Extremes(min(displacements), max(displacements))
