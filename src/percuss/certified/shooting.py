"""The equations of a periodic orbit in balls, and their solution by the operator of Krawczyk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from flint import arb, arb_mat, ctx

from percuss.certified.balls import Undecided
from percuss.certified.cloud import BallMatrix, Cloud
from percuss.certified.first_root import Bracket
from percuss.certified.law import law_of
from percuss.certified.numbers import precision, span
from percuss.certified.step import Arrival, Departure, flight_of, landed, levels_of
from percuss.certified.system import BallSystem
from percuss.kernels.law import FIRST_HARMONIC, N_HARMONICS
from percuss.model.law import law, lines
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = [
    "Image",
    "Link",
    "Residual",
    "Shooting",
    "Solved",
    "States",
    "chain_of",
    "krawczyk",
    "pairs",
    "region_of_row",
    "unique_in",
]


@dataclass(frozen=True, slots=True)
class Link:
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

    def kept(self, system: BallSystem) -> arb:
        """Return the velocity after the event as a part of that before."""
        if not self.wall:
            return arb(1)
        return -law_of(system).number(f"oscillator.stops.{self.stop}.restitution")


def region_of_row(system: BallSystem, row: int) -> int:
    """Return the number of the region of a row of the kernels' law."""
    n = int(law(system.oscillator, system.forcing)[0, N_HARMONICS])
    return (row - FIRST_HARMONIC - n) // (1 + n)


def chain_of(system: BallSystem, orbit: PeriodicOrbit) -> list[Link]:
    """Return the events of an orbit, the first one that of its start.

    Raises
    ------
    Undecided
        If stops that are one as floats are not one exactly.
    """
    layout = lines(system.oscillator)
    shift = 1 if layout.at[0] is None else 0
    if len(system.bounds) != sum(at is not None for at in layout.at):
        raise Undecided("precision", "stops that are at one place as floats are not so exactly")
    found = []
    for bound_, before_, after_ in orbit.itinerary.events.tolist():
        bound = int(bound_) - shift
        before, after = region_of_row(system, int(before_)), region_of_row(system, int(after_))
        here = system.bounds[bound]
        stop = here.wall
        if stop is None:
            side = "above" if after > before else "below"
            stops = system.oscillator.stops
            stop = next((i for i in here.edges if stops[i].side == side), None)
        found.append(Link(bound, before, after, stop, here.wall is not None))
    return found


Vector: TypeAlias = list[arb]
# Value of the equations at a point, and their derivative on a box.
BallFunction: TypeAlias = Callable[[Vector], arb_mat]

ROUNDS = 6
WIDER = 4


class Solved(NamedTuple):
    """A box that holds exactly one solution, and the larger box in which it is the only one."""

    box: Vector
    trial: Vector


def krawczyk(value: BallFunction, derivative: BallFunction, point: Vector) -> Solved:
    """Return a box around a point that holds exactly one solution.

    Raises
    ------
    Undecided
        If the test fails: the solution is singular, or the box too wide.
    """
    n = len(point)
    inverse = _inverse(derivative(point))
    shift = inverse * value(point)
    trial = [2 * shift[i, 0].abs_upper() for i in range(n)]
    largest = max(trial, key=float)
    # A coordinate that moves by nothing at the point may still move on the box.
    trial = [size.max(largest / 2**20) for size in trial]
    for _ in range(ROUNDS):
        box = [z + span(size) for z, size in zip(point, trial, strict=True)]
        found = _image(inverse, shift, derivative(box), point, trial)
        if all(abs(new - z) < size for new, z, size in zip(found, point, trial, strict=True)):
            return Solved(found, box)
        trial = [WIDER * size for size in trial]
    raise Undecided("precision", "no box was found that the equations map into itself")


def unique_in(derivative: BallFunction, value: BallFunction, point: Vector, sizes: Vector) -> bool:
    """Return whether the box of these half-widths holds exactly one solution, for certain."""
    try:
        inverse = _inverse(derivative(point))
        shift = inverse * value(point)
        box = [z + span(size) for z, size in zip(point, sizes, strict=True)]
        found = _image(inverse, shift, derivative(box), point, sizes)
    except Undecided:
        return False
    return all(abs(new - z) < size for new, z, size in zip(found, point, sizes, strict=True))


def _inverse(matrix: arb_mat) -> arb_mat:
    try:
        return matrix.mid().inv().mid()
    except ZeroDivisionError:
        raise Undecided("precision", "the equations are singular at the solution") from None


def _image(
    inverse: arb_mat, shift: arb_mat, slopes: arb_mat, point: Vector, trial: Vector
) -> Vector:
    """Return Krawczyk's operator on the box around a point."""
    n = len(point)
    left = arb_mat([[arb(int(i == j)) for j in range(n)] for i in range(n)]) - inverse * slopes
    moved = left * arb_mat([[span(size)] for size in trial])
    return [point[i] - shift[i, 0] + moved[i, 0] for i in range(n)]


# Instants and velocities after the events, in turn.
States: TypeAlias = list[tuple[arb, arb]]
# How far from its guess a flight time may be, as a part of itself.
AROUND = 2.0**-6
# How far around a flight time other roots are excluded at least, as a part of it, where they can.
APART = 2.0**-20
MOST_STEPS = 60


class Image(NamedTuple):
    """Where the flights from an event lead: instant and velocity after the next one.

    Attributes
    ----------
    state, derivative
        The image, and its derivative on the whole set.
    lasts, alone
        How long the flights last, and a ball in which each of them has this root only.
    """

    state: tuple[arb, arb]
    derivative: BallMatrix
    lasts: arb
    alone: arb


class Residual:
    """The equations F(z) - z and their derivative, of one and the same root of each flight.

    Flights may have other roots next to it: to the value at a point belongs the derivative on a
    box around it only where the root of the point is the one that all flights of the box have.

    Parameters
    ----------
    images
        The images of the states after the events, in a vector or a box of them.
    """

    def __init__(self, images: Callable[[list[arb]], list[Image]]) -> None:
        self.images = images
        self.lasts: list[arb] = []

    def value(self, z: list[arb]) -> arb_mat:
        """Return by how much the states miss themselves, and note the flights' roots."""
        return self._missed(z, z)

    def _missed(self, unknowns: list[arb], z: list[arb]) -> arb_mat:
        found = self.images(unknowns)
        self.lasts = [image.lasts for image in found]
        return residual_of(pairs(z), [image.state for image in found])

    def derivative(self, z: list[arb]) -> arb_mat:
        """Return the derivative on a box.

        Raises
        ------
        Undecided
            If the last value may be of other roots.
        """
        found = self.images(z)
        for image, lasts in zip(found, self.lasts, strict=False):
            if not image.alone.contains(lasts):
                raise Undecided("precision", "value and derivative may be of two roots of a flight")
        return matrix_of([image.derivative for image in found])


def pairs(z: list[arb]) -> States:
    """Return a vector as instants and velocities."""
    return [(z[i], z[i + 1]) for i in range(0, len(z), 2)]


@dataclass(frozen=True)
class Shooting:
    """The equations of an orbit.

    Attributes
    ----------
    system
        The exact system.
    chain
        The events.
    period
        How long the orbit lasts, at the working precision.
    """

    system: BallSystem
    chain: list[Link]
    period: arb

    def departure(self, i: int, state: tuple[arb, arb]) -> Departure:
        """Return the departure from an event in all states of two balls."""
        link = self.chain[i]
        at = self.system.bounds[link.bound].at
        return Departure(link.after, at, Cloud.of(*state), link.bound)

    def arrival(self, i: int, state: tuple[arb, arb], until: arb, coarse: int) -> Arrival:
        """Return where the flight from event i meets the next one, near an instant."""
        start = self.departure(i, state)
        following = self.chain[(i + 1) % len(self.chain)]
        with precision(coarse):
            whole = flight_of(self.system, start, whole=True)
            level = next(
                level
                for level in levels_of(self.system, following.before)
                if level.bound == following.bound
            )
        lasts = until - state[0]
        s = float(until - state[0].mid())
        near = following.bound == self.chain[i].bound
        low, high = s * (1.0 - AROUND), s * (1.0 + AROUND)
        bracket = Bracket(level, low, high, s, near=near, far=high)
        # So far that it holds the flight of the orbit itself, and of others in its box.
        apart = (2 * (lasts - s).abs_upper()).max(arb(abs(s) * APART))
        return landed(self.system, start, whole, bracket, coarse, apart)

    def images(self, states: States, coarse: int) -> list[Image]:
        """Return the images of the states after the events, and their derivatives."""
        found = []
        n = len(states)
        for i, state in enumerate(states):
            following = (i + 1) % n
            until = states[following][0] + (self.period if following == 0 else arb(0))
            there = self.arrival(i, state, until, coarse)
            kept = self.chain[following].kept(self.system)
            (by_t, by_v) = there.derivative
            # Of all of the state: a coordinate along a fold is a ball.
            t, v = there.box
            derivative = by_t, (kept * by_v[0], kept * by_v[1])
            image = t - (self.period if following == 0 else 0), kept * v
            found.append(Image(image, derivative, there.lasts, there.alone))
        return found

    def newton(self, states: States) -> States:
        """Return a solution near some states, to about the working precision.

        Raises
        ------
        Undecided
            If Newton's method finds none.
        """
        now = [(t.mid(), v.mid()) for t, v in states]
        n = len(now)
        # No floats: at some thousand bits the steps are smaller than the least of them.
        enough, before = arb(2) ** -int(0.6 * ctx.prec), arb.pos_inf()
        for _ in range(MOST_STEPS):
            found = self.images(now, ctx.prec)
            residual = residual_of(now, [image.state for image in found])
            matrix = matrix_of([image.derivative for image in found])
            try:
                step = matrix.mid().solve(residual.mid())
            except ZeroDivisionError:
                raise Undecided("precision", "the equations of the orbit are singular") from None
            now = [
                ((now[i][0] - step[2 * i, 0]).mid(), (now[i][1] - step[2 * i + 1, 0]).mid())
                for i in range(n)
            ]
            size = greatest(step)
            if size < enough:
                return now
            if size > 1000 * before:
                break
            before = before.min(size)
        raise Undecided("precision", "Newton's method finds no orbit here")


def greatest(step: arb_mat) -> arb:
    """Return a bound of the entries of a matrix."""
    found = arb(0)
    for value in step.entries():
        found = found.max(value.abs_upper())
    return found


def residual_of(states: States, images: States) -> arb_mat:
    """Return F(z) - z."""
    n = len(states)
    rows = []
    for i in range(n):
        # The image of event i - 1 is event i.
        t, v = images[i - 1]
        rows += [[t - states[i][0]], [v - states[i][1]]]
    return arb_mat(rows)


def matrix_of(derivatives: list[BallMatrix]) -> arb_mat:
    """Return the derivative of F(z) - z."""
    n = len(derivatives)
    rows = [[arb(0)] * (2 * n) for _ in range(2 * n)]
    for i in range(2 * n):
        rows[i][i] = arb(-1)
    for i in range(n):
        following, block = (i + 1) % n, derivatives[i]
        for j in range(2):
            for k in range(2):
                row, column = 2 * following + j, 2 * i + k
                rows[row][column] = rows[row][column] + block[j][k]
    return arb_mat(rows)
