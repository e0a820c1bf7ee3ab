"""The events of a run as columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sized
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats, Integers
from percuss.model.units import Units
from percuss.motion.html_table import html_table
from percuss.wording import counted

if TYPE_CHECKING:
    # A second of import, and only `to_xarray` and `to_pandas` need it.
    from pandas import DataFrame
    from xarray import Dataset

# Which side to take at the very instant of an event.
Limit = Literal["after", "before"]


class EventColumn(NamedTuple):
    """A column of a table of events: its meaning and its dimensions."""

    meaning: str
    dimensions: str = "1"


# The columns of each table as a dataset; those of an oscillator with a mass are not per unit mass.
COLUMNS: dict[str, dict[str, EventColumn]] = {
    "impact": {
        "t": EventColumn("time of the impact", "time"),
        "v_before": EventColumn("velocity before the impact", "length/time"),
        "v_after": EventColumn("velocity after the impact", "length/time"),
        "stop": EventColumn("index of the stop that is hit"),
        "cycle": EventColumn("time in forcing periods, modulo 1"),
        "impulse": EventColumn("impulse of the stop per unit mass", "mass length/time"),
    },
    "crossing": {
        "t": EventColumn("time of the crossing", "time"),
        "v": EventColumn("velocity at the crossing", "length/time"),
        "stop": EventColumn("index of the soft stop"),
        "direction": EventColumn("in or out of the soft stop"),
    },
    "contact": {
        "start": EventColumn("time at which the motion comes to rest on the stop", "time"),
        "release": EventColumn("time of the release, NaN if it has not come yet", "time"),
        "stop": EventColumn("index of the stop"),
        "n_impacts": EventColumn("number of impacts listed before the contact"),
        "error_bound": EventColumn(
            "bound of the error of the start; of a structure, of its chatter's sum", "time"
        ),
    },
    "graze": {
        "t": EventColumn("time of the touch", "time"),
        "stop": EventColumn("index of the stop"),
        "clearance": EventColumn("distance from the stop", "length"),
        "error_bound": EventColumn("bound of the error of the clearance", "length"),
    },
}


class HasTable:
    """A result with a table of its numbers."""

    __slots__ = ()

    def to_xarray(self) -> Dataset:
        """Return the table as an xarray.Dataset."""
        raise NotImplementedError

    def to_pandas(self) -> DataFrame:
        """Return `to_xarray` as a pandas.DataFrame, of events with a row for each.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
        >>> run.impacts.to_pandas().v_after.tolist()
        [0.5, 0.25]
        """
        return self.to_xarray().to_dataframe()


class EventTable(HasTable):
    """The events of one kind in a run, a column for each of their numbers."""

    __slots__ = ()
    dimension: ClassVar[str]
    units: Units | None

    def to_xarray(self) -> Dataset:
        """Return the columns as an xarray.Dataset over the events.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
        >>> run.impacts.to_xarray().v_after.values
        array([0.5 , 0.25])
        """
        import xarray

        return xarray.Dataset(
            {
                name: (self.dimension, values, self._about(column))
                for name, column, values in self._columns()
            }
        )

    def _about(self, column: EventColumn) -> dict[str, str]:
        """Return what a column is, with its unit where the oscillator has units."""
        meaning, dimensions = column
        if not self._has_mass:
            dimensions = dimensions.removeprefix("mass ")
        else:
            meaning = meaning.removesuffix(" per unit mass")
        unit = {} if self.units is None else {"units": self.units.of(dimensions)}
        return {"long_name": meaning} | unit

    @property
    def _has_mass(self) -> bool:
        """Whether the columns are not per unit mass."""
        return getattr(self, "mass", None) is not None

    def __len__(self) -> int:
        """Return the number of events."""
        return len(self._instants())

    def __repr__(self) -> str:
        """Return the number of events and when they were."""
        return f"<{type(self).__name__}: {len(self)}{_span(self._instants())}>"

    def _repr_html_(self) -> str:
        columns = {name: values for name, _, values in self._columns()}
        return html_table(repr(self)[1:-1], columns)

    def _instants(self) -> Any:
        """Return the first column: the instants at which the events begin."""
        return getattr(self, next(iter(COLUMNS[self.dimension])))

    def _columns(self) -> Iterator[tuple[str, EventColumn, Any]]:
        """Yield the name, meaning and values of each column, as arrays."""
        for name, column in COLUMNS[self.dimension].items():
            yield name, column, getattr(self, name)


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Impacts(EventTable):
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
    mass
        The mass of the oscillator, None without one.
    units
        The units of the oscillator, None without.
    """

    dimension: ClassVar[str] = "impact"
    t: Floats
    v_before: Floats
    v_after: Floats
    stop: Integers
    cycle: Floats
    intervals: Floats
    mass: float | None = None
    units: Units | None = None

    @property
    def impulse(self) -> Floats:
        """(n,) array, the wall's impulse on the mass, m (v_after - v_before).

        [mass length/time]; per unit mass, v_after - v_before, without a mass.
        """
        gained = self.v_after - self.v_before
        return gained if self.mass is None else self.mass * gained


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Crossings(EventTable):
    """The crossings of the edges of soft stops, in order.

    Stops of an oscillator that share an edge are crossed together, with a row for each of them;
    where impacts and entries are counted, that is one entry.

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

    dimension: ClassVar[str] = "crossing"
    t: Floats
    v: Floats
    stop: Integers
    direction: NDArray[np.str_]
    units: Units | None = None


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Contacts(EventTable):
    """The times of contact: the mass is held at a wall (sticks).

    Attributes
    ----------
    start
        (n,) array [time]: where chatter accumulates, a touchdown, or a landing whose speed is zero
        to within its rounding.
    release
        (n,) array [time]: where the force lets go; NaN where the run ended before.
    stop
        (n,) array, index into the oscillator's `stops`.
    n_impacts
        (n,) array, how many of the run's impacts are listed before it.
    """

    dimension: ClassVar[str] = "contact"
    start: Floats
    release: Floats
    stop: Integers
    n_impacts: Integers
    _errors: Callable[[], Floats] = field(repr=False)
    units: Units | None = None

    @property
    def error_bound(self) -> Floats:
        """(n,) array [time], bound on the whole error of `start`, computed when first asked for.

        It holds the summation of the chatter's tail and all rounding since the last release or
        the start of the run, as the flights and impacts in between have carried it
        (docs/theory/error-bounds.md). It is infinite where rounding may have changed what the
        motion meets: next to a graze, or once a chaotic motion is lost; and for all contacts
        after that. Of a structure it holds the summation of the chatter's tail alone, 0 where
        there is none, and no rounding: what flights of several masses carry is not bounded yet.

        Examples
        --------
        >>> import percuss as pc
        >>> ball = pc.ball_on_table(amplitude="0.5", omega=1, gravity=1, restitution="0.5")
        >>> run = pc.simulate(*ball, v0=1, periods=3)  # it bounces until it lies on the table
        >>> run.contacts.start, run.contacts.error_bound < 1e-12
        (array([4.59622578]), array([ True]))
        """
        return self._errors()


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Grazes(EventTable):
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

    dimension: ClassVar[str] = "graze"
    t: Floats
    stop: Integers
    clearance: Floats
    error_bound: Floats
    units: Units | None = None


def _span(t: Floats) -> str:
    if len(t) == 0:
        return ""
    return f" at t = {t[0]:.6g}" if len(t) == 1 else f", t = {t[0]:.6g} ... {t[-1]:.6g}"


_NO_FLOATS = np.empty(0)
_NO_NUMBERS = np.empty(0, dtype=np.int64)
_NO_TEXTS = np.empty(0, dtype="<U3")


@lru_cache(maxsize=16)
def no_crossings(units: Units | None) -> Crossings:
    """Return a table without rows."""
    return Crossings(_NO_FLOATS, _NO_FLOATS, _NO_NUMBERS, _NO_TEXTS, units)


@lru_cache(maxsize=16)
def no_contacts(units: Units | None) -> Contacts:
    """Return a table without rows."""
    errors = partial(np.empty, 0)
    return Contacts(_NO_FLOATS, _NO_FLOATS, _NO_NUMBERS, _NO_NUMBERS, errors, units)


@lru_cache(maxsize=16)
def no_grazes(units: Units | None) -> Grazes:
    """Return a table without rows."""
    return Grazes(_NO_FLOATS, _NO_NUMBERS, _NO_FLOATS, _NO_FLOATS, units)


class HasEvents(Protocol):
    """A motion between two instants with its events."""

    @property
    def t0(self) -> float:
        """Time of its start."""

    @property
    def t_end(self) -> float:
        """Time of its end."""

    @property
    def impacts(self) -> Impacts:
        """Its impacts."""

    @property
    def crossings(self) -> Crossings:
        """Its crossings."""

    @property
    def contacts(self) -> Contacts:
        """Its contacts."""

    @property
    def grazes(self) -> Grazes:
        """Its grazes."""


def counts_in_words(of_impacts: str = "", /, **events: Sized) -> str:
    """Return the numbers of events in words; of those that are none impacts alone are named.

    Parameters
    ----------
    of_impacts
        What is said of the impacts behind their number.
    **events
        Events of each kind, by the name of the kind.

    Returns
    -------
    str
        Such as "3 impacts, 1 contact".

    Examples
    --------
    >>> counts_in_words(impacts=[], crossings=[1.0, 2.0], contacts=[])
    '0 impacts, 2 crossings'
    """
    counts = {name: len(each) for name, each in events.items()}
    said = {"impacts": of_impacts}
    return ", ".join(
        counted(n, name.removesuffix("s")) + said.get(name, "")
        for name, n in counts.items()
        if n or name == "impacts"
    )
