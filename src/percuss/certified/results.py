"""A certified run: what is proven of it, and which of its numbers were given as doubles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from flint import arb
from numpy.typing import ArrayLike, NDArray

from percuss.certified.ball_arithmetic import Ball, Balls
from percuss.certified.ball_law import law_of, range_of
from percuss.certified.cloud import BallPair
from percuss.certified.march import Ending, MarchRecord, moved_in_words
from percuss.certified.motion import (
    energy_of,
    exact_times,
    forces_of,
    is_proven,
    state_at,
    states_as_balls,
)
from percuss.certified.numbers import precision, time_ball
from percuss.certified.system import BallSystem
from percuss.certified.tables import (
    CertifiedContacts,
    CertifiedCrossings,
    CertifiedGrazes,
    CertifiedImpacts,
    contacts_of,
    crossings_of,
    grazes_of,
    impacts_of,
)
from percuss.errors import ParameterError
from percuss.model.exact import Phase, PiTimes, as_float, whole
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.paths import get_parameter, parameter_paths
from percuss.model.start import Start
from percuss.motion.instants import check_limit
from percuss.motion.run_dataset import run_dataset
from percuss.motion.tables import Limit, counts_in_words

if TYPE_CHECKING:
    # A second of import, and only `sample` needs it.
    from xarray import Dataset

# Endings of motions that are proven to the end that was asked for.
COMPLETE = (
    Ending.reached_t_end,
    Ending.reached_max_impacts,
    Ending.at_rest,
    Ending.impact_at_t_end,
)


def doubles_of(
    osc: Oscillator, force: Forcing | None, start: Start | None = None
) -> tuple[str, ...]:
    """Return the paths of the numbers given as floats that are not the decimals they print as.

    Examples
    --------
    >>> import percuss as pc
    >>> doubles_of(pc.impact_oscillator(0.8, damping=0.5), pc.cosine("2.8"))
    ('oscillator.stops.0.restitution',)
    """
    values = {path: get_parameter(osc, force, start, path)
              for path in parameter_paths(osc, force, start)}  # fmt: skip
    return tuple(
        path
        for path, value in values.items()
        if isinstance(value, float) and Fraction(repr(value)) != Fraction(value)
    )


def in_words(doubles: tuple[str, ...]) -> str:
    """Return words that name the numbers taken as doubles; none without any."""
    return f"; taken as doubles: {', '.join(doubles)}" if doubles else ""


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedRun:
    """A motion that is proven; made by `certify`. Called with times, it returns the motion then.

    Attributes
    ----------
    oscillator, forcing, start
        The exact values that the proof is about. A float at which `simulate` starts on a stop is
        replaced by the stop's exact place.
    start_given
        The start as it was given.
    t_end
        The end of the proven motion [time].
    outcome
        How the proof ended.
    reason
        Why, with numbers; empty where `outcome` says all.
    impacts, crossings, contacts, grazes
        The events, as columns of balls.
    wanted_digits
        The digits that were asked for.
    precision
        The bits that were worked with.
    bits_spent
        Growth of the balls from the start to the last event, in bits.
    system
        The numbers of oscillator and forcing as rationals, and the range of one that is a ball.
    """

    oscillator: Oscillator
    forcing: Forcing | None
    start: Start
    t_end: Ball
    outcome: Ending
    reason: str
    impacts: CertifiedImpacts
    crossings: CertifiedCrossings
    contacts: CertifiedContacts
    grazes: CertifiedGrazes
    wanted_digits: int
    precision: int
    bits_spent: float
    start_given: Start = field(repr=False)
    system: BallSystem = field(repr=False)
    _record: MarchRecord = field(repr=False)

    @property
    def event_times(self) -> Balls:
        """The instants at which flights and contacts begin, the start among them; knots are none."""
        return Balls.of(piece.start for piece in self._record.pieces if not piece.at_knot)

    @property
    def doubles(self) -> tuple[str, ...]:
        """Numbers given as floats that are not the decimals they print as: taken as doubles."""
        return doubles_of(self.oscillator, self.forcing, self.start)

    @property
    def accumulations(self) -> int:
        """Number of chatters that end: each has infinitely many impacts besides the listed ones."""
        return self._record.accumulations

    @property
    def complete(self) -> bool:
        """Whether the motion is proven to the end that was asked for.

        Where the outcome is `Ending.impact_at_t_end`, all events up to t_end are listed, and
        whether the last of them comes by then is open.
        """
        return self.outcome in COMPLETE

    @property
    def bits_per_impact(self) -> float:
        """Mean growth of the balls at an impact or crossing, in bits."""
        return self.bits_spent / max(1, len(self.impacts) + len(self.crossings))

    @property
    def known_times(self) -> tuple[float, float]:
        """First and last float of the proven motion; at rest for good, up to the last event.

        Raises
        ------
        ParameterError
            If the proof ends before the next float.
        """
        low, high = _inside(self.start_time, math.inf), _inside(self._last_time(), -math.inf)
        if low > high:
            reason = f"the proof ends before the first float after its start; {self.outcome.value}"
            raise ParameterError("t_end", self.t_end.mid(), reason)
        return low, high

    def __repr__(self) -> str:
        """Return in a line what is proven."""
        infinite = " listed, and infinitely many in each accumulation"
        counts = counts_in_words(
            infinite if self.accumulations else "",
            impacts=self.impacts,
            crossings=self.crossings,
            contacts=self.contacts,
        )
        reason = f" ({self.reason})" if self.reason else ""
        return (
            f"<CertifiedRun: t = {float(self.start_time):.6g} ... {self.t_end.mid():.6g}, "
            f"{counts}, {self.precision} bits; {self.outcome.value}{reason}"
            f"{moved_in_words(self.start, self.start_given)}{in_words(self.doubles)}>"
        )

    @property
    def start_time(self) -> Ball:
        """The instant of the start."""
        return Ball(self._record.pieces[0].start if self._record.pieces else self.t_end.arb)

    @property
    def over(self) -> tuple[str, Ball] | None:
        """A number of the force, and the ball for all values in which the proof holds, or None."""
        return range_of(self.system)

    def __call__(self, t: ArrayLike | Phase, limit: Limit = "after") -> tuple[Balls, Balls]:
        """Return (x, v) at times t.

        Parameters
        ----------
        t
            Times up to `t_end`, of any shape, each taken exactly: a float is that double,
            ``"1/3"`` and ``"20*pi"`` are these numbers.
        limit
            Which velocity to return at an impact. Both are in the ball whatever this is, since the
            instant of the impact is a ball.

        Returns
        -------
        tuple of Balls
            x [length] and v [length/time], of t's shape.

        Raises
        ------
        ParameterError
            If a time lies outside of what is proven.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=2)
        >>> x, v = pc.certify(run)([0.5])
        >>> bool(abs(x.mid()[0] - 0.479425538604203) < 1e-15), bool(x.radius()[0] < 1e-15)
        (True, True)
        """
        check_limit(limit)
        return states_as_balls(self._state, t, self.precision)

    def sample(self, n: int) -> Dataset:
        """Return x and v at n equidistant times, both ends included, with their radii.

        Parameters
        ----------
        n
            Number of points, >= 2.

        Returns
        -------
        xarray.Dataset
            x, x_radius [length], v and v_radius [length/time] over t [time], (n,) each.

        Raises
        ------
        ParameterError
            If n is below 2.
        """
        n = whole("n", n, 2)
        low, high = self.known_times
        times = np.clip(np.linspace(low, high, n), low, high)
        return self._dataset("t", times, list(times))

    def stroboscopic(self) -> Dataset:
        """Return x and v once every forcing period, from the start on, with their radii.

        Returns
        -------
        xarray.Dataset
            x, x_radius [length], v and v_radius [length/time] over `period`, the number of exact
            periods since the start.

        Raises
        ------
        ParameterError
            If the period of the forcing is not known exactly.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, t_end=20.0)
        >>> dict(pc.certify(run).stroboscopic().sizes)
        {'period': 10}
        """
        period = law_of(self.system).exact_period()
        if period is None:
            reason = "a stroboscopic view needs a forcing whose period is known exactly"
            raise ParameterError("forcing.period", None, reason)
        last = self._last_time()
        length = last.mid() - self.start_time.mid()
        count = int(length / float(period) + 1e-9) + 1
        times = [PiTimes(k * period.times, k * period.plus) + self.start.t0 for k in range(count)]
        with precision(self.precision):
            times = [t for t in times if is_proven(self._record, t) and not time_ball(t) > last.arb]
        return self._dataset("period", np.arange(len(times)), times)

    def forces(self, t: ArrayLike | Phase) -> Dataset:
        """Return the forces on the mass at times t, with radii; per unit mass without a mass.

        Parameters
        ----------
        t
            Times up to `t_end`, one or a row of them, each taken exactly [time].

        Returns
        -------
        xarray.Dataset
            `spring`, `damping`, `forcing` over t and `stops` over (stop, t), and
            ``spring_radius`` and so on [length/time^2]. The force of a soft stop whose edge lies
            within the radius holds both sides; that of a wall is its reaction in contact.

        Raises
        ------
        ParameterError
            If a time lies outside of what is proven.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.bilinear_oscillator(stiffness_below=9.0), v0=1.0, t_end=4.0)
        >>> float(pc.certify(run).forces([0.5]).stops_radius.max())
        0.0
        """
        times, _ = exact_times(np.ravel(np.asarray(t, dtype=object)))
        with precision(self.precision):
            rows = [forces_of(self.system, self._record, time, self._state(time)) for time in times]
        columns = [Balls.of(row[i] for row in rows) for i in range(3 + len(self.oscillator.stops))]
        data: dict[str, object] = {}
        for suffix, part in (("", Balls.mid), ("_radius", Balls.radius)):
            values = [part(column) for column in columns]
            for name, value in zip(("spring", "damping", "forcing"), values, strict=False):
                data[name + suffix] = ("t", value)
            stops = np.reshape(values[3:], (len(self.oscillator.stops), len(times)))
            data["stops" + suffix] = (("stop", "t"), stops)
        coords = {"t": [as_float(time) for time in times]}
        return run_dataset(data, coords, self.outcome.value, self.oscillator.units)

    def energy(self, t: ArrayLike | Phase) -> Balls:
        """Return the mechanical energy at times t; per unit mass where there is no mass.

        Parameters
        ----------
        t
            Times up to `t_end`, of any shape, each taken exactly [time].

        Returns
        -------
        Balls
            m v^2 / 2 + k x^2 / 2 and the springs of the soft stops [mass length^2/time^2], of t's
            shape.

        Raises
        ------
        ParameterError
            If a time lies outside of what is proven.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(), v0=2.0, t_end=9.0)
        >>> pc.certify(run).energy([4.0, 8.0]).mid()
        array([2., 2.])
        """
        times, shape = exact_times(t)
        with precision(self.precision):
            energies = [energy_of(self.system, self._state(time)) for time in times]
        return Balls.of(energies, shape)

    def _state(self, time: Phase) -> BallPair:
        return state_at(self.system, self._record, time)

    def _last_time(self) -> Ball:
        """Return the end of the motion; of one at rest for good, its last event."""
        return self.t_end if self.t_end.arb.is_finite() else Ball(self._record.pieces[-1].start)

    def _dataset(self, name: str, index: NDArray[np.generic], times: Sequence[Phase]) -> Dataset:
        x, v = states_as_balls(self._state, times, self.precision)
        data = {
            "x": (name, x.mid()),
            "x_radius": (name, x.radius()),
            "v": (name, v.mid()),
            "v_radius": (name, v.radius()),
        }
        return run_dataset(data, {name: index}, self.outcome.value, self.oscillator.units)


def _inside(instant: Ball, towards: float) -> float:
    """Return a float that is certainly not before an instant, or not after it, by a direction."""
    middle = instant.mid()
    if instant.arb == middle:
        return middle
    return math.nextafter(middle + math.copysign(instant.radius(), towards), towards)


def run_of_record(
    system: BallSystem, starts: tuple[Start, Start], record: MarchRecord, spent: float, digits: int
) -> CertifiedRun:
    """Return the result of a motion from a start, the exact one of two; the other was given."""
    start = record.pieces[0].start if record.pieces else arb(0)
    with precision(record.bits):
        impacts = impacts_of(system, record.impacts, start)
    return CertifiedRun(
        oscillator=system.oscillator,
        forcing=system.forcing,
        start=starts[0],
        t_end=Ball(record.until),
        outcome=record.ending,
        reason=record.reason,
        impacts=impacts,
        crossings=crossings_of(system, record),
        contacts=contacts_of(system, record),
        grazes=grazes_of(system, record),
        wanted_digits=digits,
        precision=record.bits,
        bits_spent=spent,
        start_given=starts[1],
        system=system,
        _record=record,
    )
