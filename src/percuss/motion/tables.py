"""The events of a run as columns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats, Integers
from percuss.motion.html_table import html_table

if TYPE_CHECKING:
    # A second of import, and only `to_dataset` needs it.
    from xarray import Dataset

__all__ = ["Contacts", "Crossings", "Grazes", "Impacts"]


# The columns of each table as a dataset, and what they are.
COLUMNS: dict[str, dict[str, str]] = {
    "impact": {
        "t": "time of the impact",
        "v_before": "velocity before the impact",
        "v_after": "velocity after the impact",
        "stop": "index of the stop that is hit",
        "cycle": "time in forcing periods, modulo 1",
        "impulse": "impulse of the stop per unit mass",
    },
    "crossing": {
        "t": "time of the crossing",
        "v": "velocity at the crossing",
        "stop": "index of the soft stop",
        "direction": "in or out of the soft stop",
    },
    "contact": {
        "start": "time at which the motion comes to rest on the stop",
        "release": "time of the release, NaN if it has not come yet",
        "stop": "index of the stop",
        "n_impacts": "number of impacts listed before the contact",
        "error_bound": "bound of the whole error of the start",
    },
    "graze": {
        "t": "time of the touch",
        "stop": "index of the stop",
        "clearance": "distance from the stop",
        "error_bound": "bound of the error of the clearance",
    },
}


class EventColumns:
    """The table of one kind of event, a column for each quantity."""

    __slots__ = ()
    # Row of COLUMNS, and the dimension of the dataset.
    kind: ClassVar[str]

    def to_dataset(self) -> Dataset:
        """Return the columns as an xarray.Dataset over their kind of event.

        Its ``to_dataframe`` makes them a table of pandas.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
        >>> run.impacts.to_dataset().v_after.values
        array([0.5 , 0.25])
        """
        import xarray

        return xarray.Dataset(
            {
                name: (self.kind, getattr(self, name), {"long_name": meaning})
                for name, meaning in COLUMNS[self.kind].items()
            }
        )

    def _instants(self) -> Floats:
        """Return the first column: when each event happened, or began."""
        return cast("Floats", getattr(self, next(iter(COLUMNS[self.kind]))))

    def __len__(self) -> int:
        """Return the number of events."""
        return len(self._instants())

    def __repr__(self) -> str:
        """Return the number of events and when they were."""
        t = self._instants()
        span = "" if len(t) == 0 else f" at t = {t[0]:.6g}"
        if len(t) > 1:
            span = f", t = {t[0]:.6g} ... {t[-1]:.6g}"
        return f"<{type(self).__name__}: {len(t)}{span}>"

    def _repr_html_(self) -> str:
        return html_table(
            repr(self)[1:-1], {name: getattr(self, name) for name in COLUMNS[self.kind]}
        )


@dataclass(frozen=True, slots=True, repr=False)
class Impacts(EventColumns):
    """The impacts on walls, in order; the start of a run is none of them.

    Attributes
    ----------
    t
        (n,) array, instants [time].
    v_before, v_after
        (n,) arrays, velocity just before and just after [length/time].
    stop
        (n,) array, index into the oscillator's `stops`.
    cycle
        (n,) array in [0, 1), (t / period) mod 1; NaN for a forcing without a period.
    intervals
        (n,) array, flight times [time]: from the impact before, the first from the start.
    """

    kind: ClassVar[str] = "impact"
    t: Floats
    v_before: Floats
    v_after: Floats
    stop: Integers
    cycle: Floats
    intervals: Floats

    @property
    def impulse(self) -> Floats:
        """(n,) array, the wall's impulse per unit mass, v_after - v_before [length/time]."""
        return self.v_after - self.v_before


@dataclass(frozen=True, slots=True, repr=False)
class Crossings(EventColumns):
    """The crossings of the edges of soft stops, in order.

    Attributes
    ----------
    t
        (n,) array, instants [time].
    v
        (n,) array, velocity [length/time]; a crossing leaves it as it is.
    stop
        (n,) array, index into the oscillator's `stops`.
    direction
        (n,) array of "in" and "out".
    """

    kind: ClassVar[str] = "crossing"
    t: Floats
    v: Floats
    stop: Integers
    direction: NDArray[np.str_]


@dataclass(frozen=True, slots=True, repr=False)
class Contacts(EventColumns):
    """The contacts: the mass rests on a wall (sticks) while the force presses it there.

    Attributes
    ----------
    start
        (n,) array [time]: where chatter accumulates, a touchdown, or a landing whose speed is zero
        to within its rounding.
    release
        (n,) array [time]: where the force changes sign; NaN where the run ended before.
    stop
        (n,) array, index into the oscillator's `stops`.
    n_impacts
        (n,) array, how many of the run's impacts are listed before it.
    """

    kind: ClassVar[str] = "contact"
    start: Floats
    release: Floats
    stop: Integers
    n_impacts: Integers
    _errors: Callable[[], Floats] = field(repr=False)

    @property
    def error_bound(self) -> Floats:
        """(n,) array [time], bound on the whole error of `start`, computed when first asked for.

        It holds the summation of the chatter's tail and all rounding since the last release or
        the start of the run, as the flights and impacts in between have carried it
        (docs/theory/error-bounds.md). It is infinite where rounding may have changed what the
        motion meets: next to a graze, or once a chaotic motion is lost; and for all contacts
        after that.
        """
        return self._errors()


@dataclass(frozen=True, slots=True, repr=False)
class Grazes(EventColumns):
    """Touches of a stop that rounding cannot decide, and exact tangencies.

    A graze is no impact and changes nothing.

    Attributes
    ----------
    t
        (n,) array, instants of the turning points [time].
    stop
        (n,) array, index into the oscillator's `stops`.
    clearance
        (n,) array [length], computed distance to the stop, negative beyond it.
    error_bound
        (n,) array [length], bound on the error of `clearance`; never below its magnitude.
    """

    kind: ClassVar[str] = "graze"
    t: Floats
    stop: Integers
    clearance: Floats
    error_bound: Floats


_NO_FLOATS = np.empty(0)
_NO_NUMBERS = np.empty(0, dtype=np.int64)
NO_CROSSINGS = Crossings(_NO_FLOATS, _NO_FLOATS, _NO_NUMBERS, np.empty(0, dtype="<U3"))
NO_CONTACTS = Contacts(_NO_FLOATS, _NO_FLOATS, _NO_NUMBERS, _NO_NUMBERS, partial(np.empty, 0))
NO_GRAZES = Grazes(_NO_FLOATS, _NO_NUMBERS, _NO_FLOATS, _NO_FLOATS)
