"""One motion from event to event, in arithmetic of as many digits as asked for.

It shares no code with percuss: numbers in, numbers out. Walls take v to -r v; soft stops add
-k_s (x - at) - 2 a_s v while x is beyond them, and superpose. Chatter is followed hop by hop to
a speed of 1e-25, where the rest is a geometric series to more digits than a test compares.
"""

from __future__ import annotations

import itertools
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Literal

import mpmath
from mpmath import mp
from tests.oracle.curves import Flight, Force, Harmonic, Real, taylor_of_state
from tests.oracle.roots import ORDER, Search

Direction = Literal["in", "out"]


@dataclass(frozen=True)
class Wall:
    """A rigid stop; side is "below" or "above"."""

    at: Real
    side: str
    restitution: Real = 1


@dataclass(frozen=True)
class Soft:
    """A compliant stop; side is "below" or "above"."""

    at: Real
    side: str
    stiffness: Real
    damping: Real = 0


@dataclass(frozen=True)
class Piece:
    """A force + slope (t - t of the piece) from t on, until the next piece."""

    t: Real
    force: Real
    slope: Real = 0


@dataclass(frozen=True)
class Problem:
    """x'' + 2 damping x' + stiffness x = constant + harmonics + pieces + stops.

    Decimals may be texts. Before the first piece there is none.
    """

    damping: Real = 0
    stiffness: Real = 1
    constant: Real = 0
    harmonics: tuple[Harmonic, ...] = ()
    stops: tuple[Wall | Soft, ...] = ()
    pieces: tuple[Piece, ...] = ()


@dataclass
class Impacts:
    """One entry an impact."""

    t: list[Real] = field(default_factory=list)
    v_before: list[Real] = field(default_factory=list)
    v_after: list[Real] = field(default_factory=list)
    stop: list[int] = field(default_factory=list)


@dataclass
class Crossings:
    """One entry a crossing of a soft stop."""

    t: list[Real] = field(default_factory=list)
    v: list[Real] = field(default_factory=list)
    stop: list[int] = field(default_factory=list)
    direction: list[Direction] = field(default_factory=list)


@dataclass
class Contacts:
    """One entry a time at rest on a wall; a release that did not come is nan."""

    start: list[Real] = field(default_factory=list)
    release: list[Real] = field(default_factory=list)
    stop: list[int] = field(default_factory=list)


@dataclass
class Run:
    """What happened, and the motion itself."""

    digits: int
    impacts: Impacts = field(default_factory=Impacts)
    crossings: Crossings = field(default_factory=Crossings)
    contacts: Contacts = field(default_factory=Contacts)
    touches: list[Real] = field(default_factory=list)
    starts: list[Real] = field(default_factory=list)
    pieces: list[Flight | Real] = field(default_factory=list)

    def __call__(self, t: Real) -> tuple[Real, Real]:
        """Return (x, v) at t, after an impact at t."""
        with mpmath.workdps(_working(self.digits)):
            t = number(t)
            i = max(0, bisect_right(self.starts, t) - 1)
            piece = self.pieces[i]
            if isinstance(piece, Flight):
                return piece.state(t - self.starts[i])
            return piece, mp.zero


def number(value: Real) -> Real:
    """Return an exact value (number, decimal text, Fraction) at the working precision."""
    if hasattr(value, "numerator") and hasattr(value, "denominator"):
        return mpmath.mpf(int(value.numerator)) / int(value.denominator)
    return mpmath.mpf(value)


def simulate(
    problem: Problem,
    x0: Real,
    v0: Real,
    t0: Real = 0,
    *,
    t_end: Real = mp.inf,
    max_impacts: int | None = None,
    digits: int = 40,
) -> Run:
    """Return the motion from (x0, v0) at t0 up to t_end or the given number of impacts.

    Without t_end the impacts must come, or the search goes on for ever.
    """
    with mpmath.workdps(_working(digits)):
        march = _March(problem, number(x0), number(v0), number(t0), digits)
        march.go(number(t_end), max_impacts)
        return march.run


def _working(digits: int) -> int:
    # Exponents moved apart by 10^-digits cost up to two times as many digits, twice over, and a
    # slope once more.
    return 6 * digits + 20


class _March:
    """The state between two events."""

    def __init__(self, problem: Problem, x: Real, v: Real, t: Real, digits: int) -> None:
        self.a, self.k = number(problem.damping), number(problem.stiffness)
        self.constant = number(problem.constant)
        self.harmonics = tuple(
            Harmonic(number(h.omega), number(h.cos), number(h.sin)) for h in problem.harmonics
        )
        self.stops = tuple(_as_numbers(stop) for stop in problem.stops)
        self.pieces = tuple(
            Piece(number(p.t), number(p.force), number(p.slope)) for p in problem.pieces
        )
        self.knots = [piece.t for piece in self.pieces]
        self.resting = False
        self.walls = {i: s for i, s in enumerate(self.stops) if isinstance(s, Wall)}
        self.softs = {i: s for i, s in enumerate(self.stops) if isinstance(s, Soft)}
        self.x, self.v, self.t = x, v, t
        self.tiny = mpmath.mpf(10) ** -digits
        self.digits = digits
        self.run = Run(digits)
        self.beyond = {i for i, s in self.softs.items() if _inward(s) * (x - s.at) > 0}

    def go(self, t_end: Real, max_impacts: int | None) -> None:
        limit = mp.inf if max_impacts is None else max_impacts
        last = t_end
        while self.t < last and len(self.run.impacts.t) < limit:
            t_end = min([last, *(t for t in self.knots if t > self.t)])
            wall = self._wall_here()
            order, direction = self._direction()
            into = wall is not None and direction * _inward(self.stops[wall]) >= 0
            if wall is not None and into and order == 1:
                self._impact(wall)
            elif wall is not None and into:
                self._rest(wall, t_end)
            elif order == 0:
                self._note(self.x)
                if t_end == last:
                    return
                self.t = t_end
            else:
                if self.resting:
                    self._release()
                self._enter(direction, recorded=bool(self.run.starts))
                self._fly(order, direction, t_end)

    def _direction(self) -> tuple[int, int]:
        """Return the order and the sign of the first derivative that moves x, 0 if none does.

        Up to there it is the same with and without the soft stops that begin here.
        """
        c = taylor_of_state(*self._law(), mp.zero, self.x, self.v, ORDER)
        # Nothing is what is below the digits beside quantities of order one.
        scale = 1 + sum(h.amplitude for h in self.harmonics) + abs(self.constant)
        scale += max((abs(p.force) + abs(p.slope) for p in self.pieces), default=0)
        for n in range(1, ORDER + 1):
            if abs(c[n]) > self.tiny * scale:
                return n, 1 if c[n] > 0 else -1
        return 0, 0

    def _law(self) -> tuple[Real, Real, Force]:
        softs = [self.softs[i] for i in self.beyond]
        a = self.a + mpmath.fsum(s.damping for s in softs)
        k = self.k + mpmath.fsum(s.stiffness for s in softs)
        constant = self.constant + mpmath.fsum(s.stiffness * s.at for s in softs)
        i = bisect_right(self.knots, self.t) - 1
        if i < 0:
            return a, k, Force(constant, self.harmonics, self.t)
        piece = self.pieces[i]
        constant += piece.force + piece.slope * (self.t - piece.t)
        return a, k, Force(constant, self.harmonics, self.t, piece.slope)

    def _wall_here(self) -> int | None:
        return next((i for i, wall in self.walls.items() if wall.at == self.x), None)

    def _enter(self, direction: int, *, recorded: bool) -> None:
        """Switch the soft stops at x for a motion that leaves it in the given direction."""
        for i, stop in self.softs.items():
            if stop.at != self.x:
                continue
            inside = direction * _inward(stop) > 0
            if recorded and inside != (i in self.beyond):
                row = self.run.crossings
                row.t.append(self.t)
                row.v.append(self.v)
                row.stop.append(i)
                row.direction.append("in" if inside else "out")
            (self.beyond.add if inside else self.beyond.discard)(i)

    def _fly(self, order: int, direction: int, t_end: Real) -> None:
        a, k, force = self._law()
        if order > 1:
            # What is below the resolution is nothing: a release starts with no speed at all.
            self.v = mp.zero
        flight = Flight(a, k, force, self.x, self.v, self.digits)
        self._note(flight)
        end, place = t_end - self.t, None
        for sign in (1, -1):
            for level in self._levels(sign, direction):
                multiplicity = order if level == self.x else 0
                search = Search(flight, level, sign, multiplicity, self.digits)
                found = search.first_root(end)
                self.run.touches += [self.t + s for s in search.touches]
                if found is not None:
                    end, place = found, level
        # At the end itself, a knot, without rounding.
        self.t = self.t + end if place is not None else t_end
        self.x, self.v = flight.state(end) if mpmath.isfinite(end) else (self.x, self.v)
        if place is not None:
            self.x = place

    def _levels(self, sign: int, direction: int) -> list[Real]:
        """Return the nearest level that bounds x from below (sign 1) or above (sign -1)."""
        distances = [sign * (self.x - stop.at) for stop in self.stops]
        levels = [
            (d, stop.at)
            for d, stop in zip(distances, self.stops, strict=True)
            if d > 0 or (d == 0 and direction == sign)
        ]
        return [min(levels)[1]] if levels else []

    def _impact(self, wall: int) -> None:
        r = restitution_of(self.walls[wall], abs(self.v))
        after = -r * self.v
        row = self.run.impacts
        row.t.append(self.t)
        row.v_before.append(self.v)
        row.v_after.append(after)
        row.stop.append(wall)
        self.v = after
        push = self._push() * _inward(self.walls[wall])
        # Far from chatter's end, and where nothing presses, hops this small do not shrink so.
        if 0 < abs(after) < min(1e-25, 1e-12 * push) and r < 1:
            self.t += 2 * abs(after) / (push * (1 - r))
            self.v = mp.zero

    def _push(self) -> Real:
        """Return the acceleration of a body that is held here."""
        _, k, force = self._law()
        return force.value(mp.zero) - k * self.x

    def _rest(self, wall: int, t_end: Real) -> None:
        """Stay on the wall until the push turns away from it."""
        self.v = mp.zero
        self._note(self.x)
        _, k, force = self._law()
        force = Force(force.constant - k * self.x, force.harmonics, self.t, force.slope)
        inward = _inward(self.stops[wall])
        release = None
        # Without harmonics the push never turns.
        if force.harmonics or force.slope:
            c = force.taylor(mp.zero, ORDER)
            order = next(n for n in range(ORDER) if abs(c[n]) > self.tiny)
            search = Search(force, mp.zero, inward, order, self.digits)
            release = search.first_root(t_end - self.t)
            if release is not None and t_end - self.t - release < self.tiny:
                # The next piece decides whether the push turns.
                release = None
        row = self.run.contacts
        if not self.resting:
            row.start.append(self.t)
            row.stop.append(wall)
            row.release.append(mp.nan)
            self.resting = True
        self.t = t_end if release is None else self.t + release
        if release is not None:
            self._release()

    def _release(self) -> None:
        self.run.contacts.release[-1] = self.t
        self.resting = False

    def _note(self, piece: Flight | Real) -> None:
        self.run.starts.append(self.t)
        self.run.pieces.append(piece)


def restitution_of(wall: Wall, speed: Real) -> Real:
    """Return the restitution at a speed, of a table linear between its pairs."""
    if not isinstance(wall.restitution, tuple):
        return number(wall.restitution)
    table = [(number(u), number(r)) for u, r in wall.restitution]
    if speed <= table[0][0]:
        return table[0][1]
    for (u0, r0), (u1, r1) in itertools.pairwise(table):
        if speed <= u1:
            return r0 + (r1 - r0) * (speed - u0) / (u1 - u0)
    return table[-1][1]


def _inward(stop: Wall | Soft) -> int:
    """Return the direction into the stop."""
    return -1 if stop.side == "below" else 1


def _as_numbers(stop: Wall | Soft) -> Wall | Soft:
    if isinstance(stop, Wall):
        return Wall(number(stop.at), stop.side, stop.restitution)
    return Soft(number(stop.at), stop.side, number(stop.stiffness), number(stop.damping))
