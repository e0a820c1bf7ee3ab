"""Bounds on what rounding has done to a run, computed when they are asked for."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.error_bounds import GENERATORS, contact_errors
from percuss.kernels.law_columns import N_HARMONICS
from percuss.model.exact import as_float, as_fraction, rational
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.model.system import System


class ContactErrors:
    """The bounds of the errors of a run's contacts: called, it gives them, computed once.

    The run is followed a second time from its record (docs/theory/error-bounds.md), which most
    runs never need.
    """

    def __init__(
        self,
        system: System,
        start: Start,
        events: Floats,
        marks: Integers,
    ) -> None:
        self._motion = system, start, events, marks
        self._bounds: Floats | None = None

    def __call__(self) -> Floats:
        """Return the (n_contacts,) bounds [time]."""
        if self._bounds is None:
            self._bounds = self._computed()
        return self._bounds

    def _computed(self) -> Floats:
        system, start, events, marks = self._motion
        law = system.law
        n = int(law[0, N_HARMONICS])
        out = np.empty(np.count_nonzero(marks[:, columns.KIND] == columns.CONTACT))
        contact_errors(
            columns.MotionRecord(law, as_float(start.x0), events, marks),
            _start_errors(system.oscillator, start),
            np.empty((n, 2)),
            np.empty((n, 2)),
            (
                np.empty((2, GENERATORS)),
                np.zeros(1, dtype=np.int64),
                np.empty((1, GENERATORS)),
            ),
            out,
        )
        return out


def _start_errors(oscillator: Oscillator, start: Start) -> tuple[float, float, float]:
    """Return by how much the floats of a start miss it: position, velocity and time."""
    x, v, t = as_fraction(start.x0), as_fraction(start.v0), rational(start.t0)
    floats = [Fraction(as_float(value)) for value in (start.x0, start.v0, start.t0)]
    errors = [abs(exact - rounded) for exact, rounded in zip((x, v, t), floats, strict=True)]
    # A start that falls together with a stop as floats is taken to be on it.
    places = [as_fraction(stop.at) for stop in oscillator.stops]
    errors[0] = max([errors[0], *(abs(x - at) for at in places if float(at) == float(x))])
    return float(errors[0]), float(errors[1]), float(errors[2])
