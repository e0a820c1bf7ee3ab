"""The equations of all orbits with some impacts in some periods, on boxes of the impact surface."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from flint import arb, arb_mat

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import BallMatrix, BallPair, Cloud, applied, times
from percuss.certified.covering import MOST_EVENTS, ImpactSurface
from percuss.certified.numbers import between, largest_abs
from percuss.certified.set_flight import SlowEvents, next_passage, possible_events, search_set
from percuss.certified.shooting import OrbitEvent
from percuss.certified.step import Departure, flight_of, moved_by

# Stretches shorter than this part of the time over which a box spreads are not worth a try.
SHORTEST = 0.5
# Events up to this multiple of the least speed may be open for some states of a box.
GLANCING = 2.0
IDENTITY: BallMatrix = ((arb(1), arb(0)), (arb(0), arb(1)))


class SurfaceBox(NamedTuple):
    """A rectangle of instants and velocities after an impact; its floats are exact numbers."""

    t_low: float
    t_high: float
    v_low: float
    v_high: float

    @property
    def middle(self) -> tuple[float, float]:
        """About the middle."""
        return 0.5 * (self.t_low + self.t_high), 0.5 * (self.v_low + self.v_high)

    def cloud(self) -> Cloud:
        """Return it in the form that flights take."""
        t = between(arb(self.t_low), arb(self.t_high))
        return Cloud.of(t, between(arb(self.v_low), arb(self.v_high)))

    def halves(self, scale: tuple[float, float]) -> tuple[SurfaceBox, SurfaceBox]:
        """Return its halves across its longer side, measured by the scales of t and v."""
        t, v = self.middle
        if (self.t_high - self.t_low) * scale[1] > (self.v_high - self.v_low) * scale[0]:
            return self._replace(t_high=t), self._replace(t_low=t)
        return self._replace(v_high=v), self._replace(v_low=v)

    def holds(self, box: SurfaceBox, later: arb) -> bool:
        """Return whether another box, made later by a time, lies inside of this one."""
        return bool(
            arb(box.t_low) + later > self.t_low
            and arb(box.t_high) + later < self.t_high
            and box.v_low > self.v_low
            and box.v_high < self.v_high
        )

    def holds_state(self, t: arb, v: arb) -> bool:
        """Return whether a ball of states lies inside."""
        return bool(t > self.t_low and t < self.t_high and v > self.v_low and v < self.v_high)


class Missed(NamedTuple):
    """By how much states of a box fail to come back: h in the middle, its derivative on the box.

    By the mean value theorem h on the box lies within ``value + derivative * spread``.
    """

    middle: BallPair
    spread: BallPair
    value: BallPair
    derivative: BallMatrix

    def inverse(self) -> BallMatrix | None:
        """Return about the inverse of the derivative, exact numbers; None where it has none."""
        (a, b), (c, d) = self.derivative
        matrix = arb_mat([[a.mid(), b.mid()], [c.mid(), d.mid()]])
        try:
            inverse = matrix.inv().mid()
        except ZeroDivisionError:
            return None
        if not all(entry.is_finite() for entry in inverse.entries()):
            return None
        return (inverse[0, 0], inverse[0, 1]), (inverse[1, 0], inverse[1, 1])

    def has_no_root(self) -> bool:
        """Return whether h is proven to have no zero on the box, by its own enclosure."""
        moved = applied(self.derivative, self.spread)
        return any(
            not (value + more).contains(0) for value, more in zip(self.value, moved, strict=True)
        )

    def krawczyk(self, inverse: BallMatrix) -> BallPair:
        """Return balls, relative to the middle, in which all zeros of h on the box lie."""
        shift = applied(inverse, self.value)
        (a, b), (c, d) = times(inverse, self.derivative)
        moved = applied(((1 - a, -b), (-c, 1 - d)), self.spread)
        return moved[0] - shift[0], moved[1] - shift[1]

    def has_one_root(self) -> bool:
        """Return whether h is proven to have exactly one zero on the box, inside of it."""
        inverse = self.inverse()
        if inverse is None:
            return False
        image = self.krawczyk(inverse)
        return all(abs(ball) < size.rad() for ball, size in zip(image, self.spread, strict=True))


@dataclass(frozen=True, slots=True)
class ReturnEquations:
    """The equations F^n(t, v) = (t + p T, v) of orbits, for all states of a box.

    Where the oscillator has one wall and no other stop, the last flight is taken without a search:
    x at the instant t + p T and the velocity after an impact there. Events slower than a speed are
    flown through, and motions that have any are none of those that the equations are about.

    Attributes
    ----------
    surface
        The impact map F.
    impacts, periods
        n and p.
    slowest, fastest
        Speeds after events, exact: all events leave with the first at least, those on the stop of
        the surface with the second at most.
    """

    surface: ImpactSurface
    impacts: int
    periods: int
    slowest: float
    fastest: float

    @property
    def off(self) -> int:
        """The sign of the velocity after an event of the surface: away from a wall, into a soft stop."""
        region = self.surface.system.regions[self.surface.event.after]
        return 1 if region.lower == self.surface.event.bound else -1

    @property
    def is_direct(self) -> bool:
        """Whether the last flight can meet nothing else."""
        system = self.surface.system
        return len(system.bounds) == 1 and self.surface.event.wall

    def missed(self, box: SurfaceBox, *, anyhow: bool = False) -> Missed | None:
        """Return by how much the states of a box fail to come back; None if none of them can.

        With ``anyhow`` also where they cannot, as Newton's method needs it; None then means that
        there is no next event.

        Raises
        ------
        Undecided
            If the balls leave open which event comes next.
        """
        system, event = self.surface.system, self.surface.event
        cloud = box.cloud()
        begin, v0 = cloud.box()
        end = begin + self.periods * self.surface.period
        start = Departure(event.after, cloud, event.bound)
        point, product, n_on_stop = cloud.middle, IDENTITY, 0
        for _ in range(MOST_EVENTS * self.impacts):
            if n_on_stop == self.impacts - self.is_direct:
                break
            search = search_set(system, start, *self._options(start, end))
            for touch_event, state in possible_events(system, start, search._replace(bracket=None)):
                if not self._is_excluded(touch_event, state, n_on_stop, (begin, v0), end):
                    raise Undecided("graze", "whether some motions of a box touch a stop is open")
            passage = next_passage(system, start, search)
            if passage is None or (passage.box[0] > end and not anyhow):
                return None
            if not anyhow and self._is_outside(passage.event, passage.box[1]):
                return None
            point = passage.image_of(point, start)
            product = times(passage.derivative, product)
            start, n_on_stop = passage.following, n_on_stop + (passage.event == event)
        else:
            raise Undecided("no_event", "very many events on other stops")
        middle = cloud.middle
        spread = begin - middle[0], v0 - middle[1]
        t_end = middle[0] + self.periods * self.surface.period
        if not self.is_direct:
            t, v = start.cloud.box()
            if not (anyhow or ((t - end).contains(0) and (v - v0).contains(0))):
                return None
            (a, b), (c, d) = product
            return Missed(
                middle, spread, (point[0] - t_end, point[1] - middle[1]), ((a - 1, b), (c, d - 1))
            )
        if not anyhow and self._misses(start, (begin, v0), end):
            return None
        whole = flight_of(system, start, whole=True)
        duration = end - start.cloud.box()[0]
        (_, v, acceleration), _ = whole.derivatives(duration, 2)
        # At t + p T, later by dt as well.
        (x_t, x_v), (v_t, v_v) = times(moved_by(start, whole, duration), product)
        x_t, v_t = x_t + v, v_t + acceleration
        kept = -event.passed(system, v).kept
        derivative = (x_t, x_v), (kept * v_t, kept * v_v - 1)
        last = flight_of(system, Departure(event.after, Cloud.of(*point), event.bound), whole=True)
        (x, v), _ = last.derivatives(t_end - point[0], 1)
        place = law_of(system).places[event.bound]
        value = x - place, event.passed(system, v).after - middle[1]
        return Missed(middle, spread, value, derivative)

    def are_solved_by(self, states: list[BallPair]) -> bool:
        """Return whether a formal orbit solves these equations: its events are those searched for.

        ``states`` are the instants and velocities after its events, as balls.
        """
        if not self.is_direct or len(states) != self.impacts:
            return False
        system, event = self.surface.system, self.surface.event
        end = states[0][0] + self.periods * self.surface.period
        for state, following in pairwise(states):
            start = Departure(event.after, Cloud.of(*state), event.bound)
            try:
                search = search_set(system, start, *self._options(start, end))
            except Undecided:
                return False
            # The bracket has one root alone.
            duration = following[0] - state[0]
            if search.bracket is None or search.bracket.place_of(duration) != 0:
                return False
        return True

    def excludes(self, box: SurfaceBox) -> bool:
        """Return whether no motion from a box is proven to come back, by balls of states alone.

        These are wider than those of `missed`, but need no velocity that is known.
        """
        state = box.cloud().box()
        end = state[0] + self.periods * self.surface.period
        return self._comes_to_nothing(self.surface.event, state, 0, state, end)

    def _comes_to_nothing(
        self, event: OrbitEvent, state: BallPair, n_on_stop: int, begin: BallPair, end: arb
    ) -> bool:
        """Return whether no motion from balls of states after an event comes back at the end."""
        start = Departure(event.after, Cloud.of(*state), event.bound)
        if n_on_stop == self.impacts - self.is_direct:
            if self.is_direct:
                return self._misses(start, begin, end)
            return not ((state[0] - end).contains(0) and (state[1] - begin[1]).contains(0))
        system = self.surface.system
        try:
            search = search_set(system, start, *self._options(start, end))
            return all(
                self._is_excluded(next_event, after, n_on_stop, begin, end)
                for next_event, after in possible_events(system, start, search)
            )
        except Undecided:
            return False

    def _is_excluded(
        self, event: OrbitEvent, after: BallPair, n_on_stop: int, begin: BallPair, end: arb
    ) -> bool:
        """Return whether no motion from balls of states after its next event comes back."""
        if after[0] > end or self._is_outside(event, after[1]):
            return True
        if not event.wall and not abs(after[1]) > 0:
            return False
        v = self._fast_part(after[1])
        n = n_on_stop + (event == self.surface.event)
        return self._comes_to_nothing(event, (after[0], v), n, begin, end)

    def _fast_part(self, v: arb) -> arb:
        """Return the velocities after an event that are not too slow."""
        sign = 1 if v.mid() > 0 else -1
        return sign * between(arb(self.slowest), (sign * v).upper())

    def _is_outside(self, event: OrbitEvent, v: arb) -> bool:
        """Return whether velocities after an event are too slow, or too fast."""
        speed = abs(v)
        return bool(speed < self.slowest or (event == self.surface.event and speed > self.fastest))

    def _misses(self, start: Departure, begin: BallPair, end: arb) -> bool:
        """Return whether the last flights do not end at the stop, with the velocity of the begin."""
        system, event = self.surface.system, self.surface.event
        whole = flight_of(system, start, whole=True)
        (x, v), _ = whole.derivatives(end - start.cloud.box()[0], 1)
        rebound = event.passed(system, v)
        speed = self.off * rebound.after
        if speed < self.slowest or speed > self.fastest:
            return True
        place = law_of(system).places[event.bound]
        return not ((x - place).contains(0) and (rebound.after - begin[1]).contains(0))

    def _options(self, start: Departure, end: arb) -> tuple[float, SlowEvents]:
        """Return the time up to which the next event is looked for, and which are slow."""
        began = start.cloud.box()[0]
        slow = SlowEvents(SHORTEST * float(began.rad()), self.slowest, GLANCING * self.slowest)
        return largest_abs(end - began), slow
