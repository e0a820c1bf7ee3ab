"""The equations of a periodic orbit in balls, and their solution by the operator of Krawczyk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

from flint import arb, arb_mat, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import Rebound, law_of
from percuss.certified.cloud import BallMatrix, BallPair, Cloud, times
from percuss.certified.first_root import Bracket
from percuss.certified.numbers import precision, span
from percuss.certified.pieces import Moment
from percuss.certified.step import (
    Arrival,
    Departure,
    at_moment,
    flight_of,
    landed,
    levels_of,
)
from percuss.certified.system import BallSystem
from percuss.kernels.law_columns import FIRST_HARMONIC, N_HARMONICS
from percuss.model.system import law, lines
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

Vector: TypeAlias = list[arb]
# Instants and velocities after the events, in turn.
States: TypeAlias = list[BallPair]
# Value of the equations at a point, and their derivative on a box.
BallFunction: TypeAlias = Callable[[Vector], arb_mat]

# Boxes tried by Krawczyk's test, each wider than the last by a factor.
BOXES, WIDER = 6, 4
# How far from its guess a flight time may be, as a part of itself.
AROUND = 2.0**-6
# How far around a flight time other roots are excluded at least, as a part of it, where they can.
ISOLATION = 2.0**-20
MOST_STEPS = 60


@dataclass(frozen=True, slots=True)
class OrbitEvent:
    """One event of an orbit.

    Attributes
    ----------
    bound
        Number of the bound.
    before, after
        Numbers of the regions before and after it.
    stop
        The stop that is met, None where soft stops are left.
    wall
        Whether it is an impact on a wall.
    """

    bound: int
    before: int
    after: int
    stop: int | None
    wall: bool

    def passed(self, system: BallSystem, v: arb) -> Rebound:
        """Return what the event makes of a velocity; a crossing is the impact of restitution -1.

        Raises
        ------
        Undecided
            If an impact may be at a knot of a table of restitutions, where there is no derivative.
        """
        if not self.wall:
            return Rebound(v, arb(-1), arb(-1))
        assert self.stop is not None
        rebound = law_of(system).rebound(self.stop, v)
        if rebound.at_knot:
            reason = f"an impact at about {float(abs(v)):.6g} may be at a knot of the table of "
            raise Undecided("precision", f"{reason}restitutions, where there is no derivative")
        return rebound


def region_of_row(system: BallSystem, row: int) -> int:
    """Return the number of the region of a row of the kernels' law."""
    n = int(law(system.oscillator, system.forcing)[0, N_HARMONICS])
    return (row - FIRST_HARMONIC - n) // (1 + n)


def events_of(system: BallSystem, orbit: PeriodicOrbit) -> list[OrbitEvent]:
    """Return the events of an orbit, the first one that of its start.

    Raises
    ------
    Undecided
        If stops that coincide as floats do not coincide exactly.
    """
    layout = lines(system.oscillator)
    shift = 1 if layout.at[0] is None else 0
    if len(system.bounds) != sum(at is not None for at in layout.at):
        raise Undecided("precision", "stops that coincide as floats do not coincide exactly")
    stops, events = system.oscillator.stops, []
    for row, row_before, row_after in orbit.itinerary.events.tolist():
        number = int(row) - shift
        before, after = (region_of_row(system, int(region)) for region in (row_before, row_after))
        bound = system.bounds[number]
        stop = bound.wall
        if stop is None:
            side = "above" if after > before else "below"
            stop = next((i for i in bound.edges if stops[i].side == side), None)
        events.append(OrbitEvent(number, before, after, stop, bound.wall is not None))
    return events


def guess_of(orbit: PeriodicOrbit) -> States:
    """Return the floats of an orbit: instants and velocities after its events."""
    n, unknowns = len(orbit.itinerary), [float(value) for value in orbit.itinerary.vector]
    t, states = arb(unknowns[0]), []
    for duration, v in zip(unknowns[1 : 1 + n], unknowns[1 + n :], strict=False):
        states.append((t, arb(v)))
        t = t + arb(duration)
    return states


def pairs(z: Vector) -> States:
    """Return a vector as instants and velocities."""
    return [(z[i], z[i + 1]) for i in range(0, len(z), 2)]


def vector_of(states: States) -> Vector:
    """Return instants and velocities as a vector."""
    return [value for state in states for value in state]


def check_inside(outer: Vector, inner: Vector) -> None:
    """Raise Undecided unless one box holds another, so that both hold the same solution."""
    if not all(a.contains(b) for a, b in zip(outer, inner, strict=True)):
        raise Undecided("precision", "the ends of the branch lie outside of its box")


class Solved(NamedTuple):
    """A box that holds exactly one solution, and the larger box in which it is the only one."""

    box: Vector
    trial: Vector


def krawczyk(value: BallFunction, derivative: BallFunction, point: Vector) -> Solved:
    """Return a box around a point that holds exactly one solution."""
    inverse = _inverse(derivative(point))
    shift = inverse * value(point)
    sizes = [2 * entry.abs_upper() for entry in shift.entries()]
    # A coordinate that moves by nothing at the point may still move on the box.
    least = max(sizes, key=float) / 2**20
    sizes = [size if size > 0 else least for size in sizes]
    for _ in range(BOXES):
        box = [z + span(size) for z, size in zip(point, sizes, strict=True)]
        image = _image(inverse, shift, derivative(box), point, sizes)
        if _lies_inside(image, point, sizes):
            return Solved(image, box)
        # Each by as much as it needs: instants, velocities and a parameter have units of their own.
        reached = [(x - z).abs_upper() for x, z in zip(image, point, strict=True)]
        sizes = [WIDER * size.max(moved) for size, moved in zip(sizes, reached, strict=True)]
    raise Undecided("precision", "no box was found that the equations map into itself")


def unique_in(derivative: BallFunction, value: BallFunction, point: Vector, sizes: Vector) -> bool:
    """Return whether the box of these half-widths holds exactly one solution, for certain."""
    try:
        inverse = _inverse(derivative(point))
        shift = inverse * value(point)
        box = [z + span(size) for z, size in zip(point, sizes, strict=True)]
        return _lies_inside(_image(inverse, shift, derivative(box), point, sizes), point, sizes)
    except Undecided:
        return False


def _inverse(matrix: arb_mat) -> arb_mat:
    try:
        return matrix.mid().inv().mid()
    except ZeroDivisionError:
        raise Undecided("precision", "the equations are singular at the solution") from None


def _image(
    inverse: arb_mat, shift: arb_mat, slopes: arb_mat, point: Vector, sizes: Vector
) -> Vector:
    """Return Krawczyk's operator on the box around a point."""
    n = len(point)
    contraction = arb_mat([[arb(int(i == j)) for j in range(n)] for i in range(n)])
    contraction = contraction - inverse * slopes
    moved = contraction * arb_mat([[span(size)] for size in sizes])
    return [point[i] - shift[i, 0] + moved[i, 0] for i in range(n)]


def _lies_inside(image: Vector, point: Vector, sizes: Vector) -> bool:
    return all(abs(x - z) < size for x, z, size in zip(image, point, sizes, strict=True))


def newton(step: Callable[[Vector], arb_mat], guess: Vector) -> Vector:
    """Return a solution near a guess, to about the working precision, by Newton's steps."""
    z = [value.mid() for value in guess]
    # No floats: at some thousand bits the steps are smaller than the least of them.
    enough, before = arb(2) ** -int(0.6 * ctx.prec), arb.pos_inf()
    for _ in range(MOST_STEPS):
        try:
            move = step(z)
        except ZeroDivisionError:
            raise Undecided("precision", "the equations of the orbit are singular") from None
        z = [(value - move[k, 0]).mid() for k, value in enumerate(z)]
        size = arb(0)
        for entry in move.entries():
            size = size.max(entry.abs_upper())
        if size < enough:
            return z
        if size > 1000 * before:
            break
        before = before.min(size)
    raise Undecided("precision", "Newton's method finds no orbit here")


class Image(NamedTuple):
    """The end of the flights from an event: instant and velocity after the next one.

    Attributes
    ----------
    state, derivative
        The image, and its derivative on the whole set.
    duration, isolating
        Duration of the flights, and a ball in which each of them has this root only.
    v_before
        The velocity before the next event.
    knot
        The last knot of a record before that event, from which the duration counts; None for none.
    """

    state: BallPair
    derivative: BallMatrix
    duration: arb
    isolating: arb
    v_before: arb
    knot: arb | None = None


class Residual:
    """The equations F(z) - z and their derivative, of one and the same root of each flight.

    Flights may have other roots close to this one. The derivative on a box belongs to the value at
    a point only where the root of the point is the one that all flights of the box have.

    Parameters
    ----------
    images
        The images of the states after the events, in a vector or a box of them.
    """

    def __init__(self, images: Callable[[Vector], list[Image]]) -> None:
        self.images = images
        self.durations: list[arb] = []

    def value(self, z: Vector) -> arb_mat:
        """Return by how much the states miss themselves, and note the flights' roots."""
        return self.missed(z, z)

    def missed(self, unknowns: Vector, z: Vector) -> arb_mat:
        """Return by how much states miss themselves that follow from other unknowns."""
        images = self.images(unknowns)
        self.durations = [image.duration for image in images]
        return residual_of(pairs(z), images)

    def derivative(self, z: Vector) -> arb_mat:
        """Return the derivative on a box.

        Raises
        ------
        Undecided
            If the last value may be of other roots.
        """
        images = self.images(z)
        for image, duration in zip(images, self.durations, strict=False):
            if not image.isolating.contains(duration):
                raise Undecided("precision", "value and derivative may be of two roots of a flight")
        return matrix_of(images)


@dataclass(frozen=True)
class Shooting:
    """The equations of an orbit, or of half a symmetric one.

    Attributes
    ----------
    system
        The exact system.
    events
        The events of the orbit; of half an orbit as well, all of them.
    period
        Time from the first event to its return, or to its mirror image, at the working precision.
    mirrored
        Whether the last flight leads to the mirror image of the first event.
    """

    system: BallSystem
    events: list[OrbitEvent]
    period: arb
    mirrored: bool = False

    @classmethod
    def of(
        cls,
        system: BallSystem,
        events: list[OrbitEvent],
        n_periods: int,
        *,
        mirrored: bool = False,
    ) -> Shooting:
        """Return the equations of an orbit over so many periods of the forcing, or of half of it."""
        period = law_of(system).period(n_periods)
        return cls(system, events, period / 2 if mirrored else period, mirrored)

    def whole(self, states: States) -> tuple[Shooting, States]:
        """Return the equations of all of an orbit, and its states, from those of half of it."""
        if not self.mirrored:
            return self, states
        images = [(t + self.period, -v) for t, v in states]
        return Shooting(self.system, self.events, 2 * self.period), [*states, *images]

    def next_event(self, i: int) -> OrbitEvent:
        """Return the event after event i."""
        return self.events[(i + 1) % len(self.events)]

    def end_of_flight(self, i: int, states: States) -> arb:
        """Return the instant of the event after event i."""
        return states[i + 1][0] if i + 1 < len(states) else states[0][0] + self.period

    def departure(self, i: int, state: BallPair) -> Departure:
        """Return the departure from an event in all states of two balls."""
        event = self.events[i]
        piece = law_of(self.system).piece_at(Moment(state[0]))
        # From a wall that keeps nothing, at rest exactly, the acceleration takes off.
        order = 2 if state[1].is_zero() else 1
        return Departure(event.after, Cloud.of(*state), event.bound, order=order, piece=piece)

    def pieces_of_flight(self, i: int, states: States) -> list[tuple[Departure, BallMatrix | None]]:
        """Return the departures into the pieces of a record that the flight from event i passes.

        With the derivative by the state after the event, None for the flight from there itself.
        """
        start, end = self.departure(i, states[i]), self.end_of_flight(i, states)
        pieces: list[tuple[Departure, BallMatrix | None]] = [(start, None)]
        product: BallMatrix | None = None
        while (knot := law_of(self.system).next_knot(start.piece)) is not None:
            if not knot.t.mid() < end.mid():
                break
            start, by = at_moment(self.system, start, knot, start.piece + 1)
            product = by if product is None else times(by, product)
            pieces.append((start, product))
        return pieces

    def arrival(self, i: int, states: States, coarse: int) -> tuple[Arrival, arb | None]:
        """Return where the flight from event i meets the next one, near its instant in the states.

        And the last knot of a record before it, None for none.

        Raises
        ------
        Undecided
            If the balls leave the event open, or on which side of a knot it is.
        """
        start, by_state = self.pieces_of_flight(i, states)[-1]
        following = self.next_event(i)
        with precision(coarse):
            whole = flight_of(self.system, start, whole=True)
            level = next(
                level
                for level in levels_of(self.system, following.before)
                if level.bound == following.bound
            )
        knot = None if start.moment is None else start.moment.t
        t, end = states[i][0] if knot is None else knot, self.end_of_flight(i, states)
        s = float(end - t.mid())
        if not s > 0.0:
            raise Undecided("precision", "an event does not come after the one before it")
        low, high = s * (1.0 - AROUND), s * (1.0 + AROUND)
        returns = following.bound == start.bound
        bracket = Bracket(level, low, high, s, from_start=returns, far=high)
        # So far that it holds the flight of the orbit itself, and of others in its box.
        isolation = (2 * (end - t - s).abs_upper()).max(arb(s * ISOLATION))
        landing = landed(self.system, start, whole, bracket, coarse, isolation)
        after = law_of(self.system).next_knot(start.piece)
        early = knot is not None and not landing.box[0] > knot
        if early or (after is not None and not landing.box[0] < after.t):
            reason = f"whether an event of the orbit at t = {float(end):.12g} is before or after a "
            raise Undecided("precision", f"{reason}knot of the record is open")
        if by_state is not None:
            landing = replace(landing, derivative=times(landing.derivative, by_state))
        return landing, knot

    def images(self, states: States, coarse: int) -> list[Image]:
        """Return the images of the states after the events, and their derivatives."""
        images = []
        for i in range(len(states)):
            arrival, knot = self.arrival(i, states, coarse)
            closes = i + 1 == len(states)
            by_t, by_v = arrival.derivative
            # Of all of the state: a coordinate along a fold is a ball.
            t, v = arrival.box
            rebound = self.next_event(i).passed(self.system, v)
            after, factor = rebound.after, -rebound.kept
            if closes and self.mirrored:
                after, factor = -after, -factor
            images.append(
                Image(
                    state=(t - self.period if closes else t, after),
                    derivative=(by_t, (factor * by_v[0], factor * by_v[1])),
                    duration=arrival.duration,
                    isolating=arrival.isolating,
                    v_before=v,
                    knot=knot,
                )
            )
        return images

    def newton(self, states: States) -> States:
        """Return a solution near some states, to about the working precision."""

        def step(z: Vector) -> arb_mat:
            images = self.images(pairs(z), ctx.prec)
            return matrix_of(images).mid().solve(residual_of(pairs(z), images).mid())

        return pairs(newton(step, vector_of(states)))


def shooting_of(system: BallSystem, orbit: PeriodicOrbit) -> tuple[Shooting, States]:
    """Return the equations of an orbit, and the floats that solve them nearly."""
    return Shooting.of(system, events_of(system, orbit), orbit.n_periods), guess_of(orbit)


def derivative_over(equations: Shooting, states: States) -> tuple[BallMatrix, list[Image]]:
    """Return the product of the derivatives of all flights, and their images."""
    product: BallMatrix | None = None
    images = equations.images(states, ctx.prec)
    for i, image in enumerate(images):
        begin = states[i][0] if image.knot is None else image.knot
        if not image.isolating.contains(equations.end_of_flight(i, states) - begin):
            raise Undecided("precision", "a flight's root may be another one than the orbit's")
        product = image.derivative if product is None else times(image.derivative, product)
    assert product is not None
    return product, images


def residual_of(states: States, images: list[Image]) -> arb_mat:
    """Return F(z) - z."""
    rows = []
    for i, state in enumerate(states):
        # The image of event i - 1 is event i.
        rows += [[new - old] for new, old in zip(images[i - 1].state, state, strict=True)]
    return arb_mat(rows)


def matrix_of(images: list[Image]) -> arb_mat:
    """Return the derivative of F(z) - z."""
    n = len(images)
    rows = [[arb(-1) if i == j else arb(0) for j in range(2 * n)] for i in range(2 * n)]
    for i, image in enumerate(images):
        following = (i + 1) % n
        for j in range(2):
            for k in range(2):
                row, column = 2 * following + j, 2 * i + k
                rows[row][column] = rows[row][column] + image.derivative[j][k]
    return arb_mat(rows)
