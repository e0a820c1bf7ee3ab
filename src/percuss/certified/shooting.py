"""The equations of an orbit, z -> F(z) - z, in balls: values, derivatives, Newton's method.

The unknowns are instant and velocity after each event; each flight leads from one event to the
next, and the last to the first, a whole number of periods later.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from flint import arb, arb_mat, ctx

from percuss.certified.chain import Link
from percuss.certified.cloud import Cloud, Matrix
from percuss.certified.first_root import Bracket
from percuss.certified.numbers import precision
from percuss.certified.step import Arrival, Departure, flight_of, landed, levels_of
from percuss.certified.system import System
from percuss.certified.undecided import Undecided

__all__ = ["Shooting", "States"]

# Instants and velocities after the events, in turn.
States: TypeAlias = list[tuple[arb, arb]]
# How far from its guess a flight time may be, as a part of itself.
AROUND = 2.0**-6
MOST_STEPS = 60


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

    system: System
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
        s = float(until - state[0].mid())
        near = following.bound == self.chain[i].bound
        low, high = s * (1.0 - AROUND), s * (1.0 + AROUND)
        bracket = Bracket(level, low, high, s, near=near, far=high)
        return landed(self.system, start, whole, bracket, coarse)

    def images(self, states: States, coarse: int) -> list[tuple[tuple[arb, arb], Matrix]]:
        """Return, for each event, the image of the state after it and the derivative of that."""
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
            found.append(((t - (self.period if following == 0 else 0), kept * v), derivative))
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
            residual = residual_of(now, [point for point, _ in found])
            matrix = matrix_of([derivative for _, derivative in found])
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


def matrix_of(derivatives: list[Matrix]) -> arb_mat:
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
