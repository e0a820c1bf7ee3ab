"""One motion from event to event by Taylor series of its differential equation, in integers.

No closed form of the motion, and no code of percuss or of `event_driven` takes part. Numbers are
whole multiples of 2**-256. On each step the coefficients follow by recurrence from

    x'' = force - 2 a x' - k x,    p_j' = w_j q_j,   q_j' = -w_j p_j,    force = g + sum p_j,

with h times the quickest rate at most 1/4, so that 25 terms leave less than 1e-39 of the state.
The first root of the polynomial comes from its Bernstein coefficients (Descartes' rule of signs),
halved until there is none or one. What 60 halvings do not decide, a touch to 1e-36, is in `doubts`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import mpmath
from tests.oracle.curves import Real
from tests.oracle.event_driven import Problem, Soft, Wall, number, restitution_of

BITS = 256
ONE = 1 << BITS
ORDER = 24
HALVINGS = 60
# Below this a derivative counts as zero where the direction of a motion at rest is asked for.
TINY = ONE >> 90
# Hops of a chatter slower than this are summed as a geometric series, which leaves its square.
SLOW = ONE // 10**15


def fixed(value: Real) -> int:
    """Return a rational or real number as a multiple of 2**-BITS."""
    if isinstance(value, Fraction | int):
        return (value.numerator << BITS) // value.denominator
    return int(mpmath.floor(mpmath.ldexp(number(value), BITS)))


def real(value: int) -> Real:
    """Return the number that an integer stands for."""
    return mpmath.ldexp(mpmath.mpf(value), -BITS)


def times(a: int, b: int) -> int:
    """Return a product."""
    return (a * b) >> BITS


def turned(p: int, q: int, turn: int, order: int) -> tuple[list[int], list[int]]:
    """Return the coefficients of a cosine and a sine whose phase grows by a turn in a step."""
    a, b = [p], [q]
    for n in range(1, order + 1):
        a.append(times(turn, b[n - 1]) // n)
        b.append(-times(turn, a[n - 1]) // n)
    return a, b


@dataclass(frozen=True)
class Event:
    """What happened, and the flight that led there, for the tests' tolerances in floats.

    ``stop`` is that of a wall, or one of the soft stops at the place that is crossed.
    """

    kind: str  # impact, in, out, rest, release
    t: Real
    stop: int
    v_before: Real = 0
    v_after: Real = 0
    # Of the flight: duration, velocity at its start, stiffness, damping, bound of the force there.
    flight: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    # Accelerations at the start of the flight, and at its end before the event; the rate of the
    # force at a release.
    bends: tuple[float, float] = (0.0, 0.0)


@dataclass
class Run:
    """The events in order, the states at the times asked for, and the undecided touches."""

    events: list[Event] = field(default_factory=list)
    states: dict[float, tuple[Real, Real]] = field(default_factory=dict)
    doubts: list[Real] = field(default_factory=list)
    # Summed tails of chatters.
    tails: list[tuple[Real, Real]] = field(default_factory=list)


def simulate(
    problem: Problem,
    x0: Real,
    v0: Real,
    t0: Real = 0,
    *,
    t_end: float,
    most_events: int = 2000,
    at: tuple[float, ...] = (),
) -> Run:
    """Return the motion up to t_end or a number of events, with its states at times ``at``."""
    with mpmath.workdps(100):
        march = _March(problem, number(x0), number(v0), number(t0), sorted(at))
        march.go(fixed(number(t_end)), most_events)
    return march.run


class _March:
    def __init__(self, problem: Problem, x: Real, v: Real, t: Real, at: list[float]) -> None:
        self.damping, self.stiffness = fixed(problem.damping), fixed(problem.stiffness)
        self.constant = fixed(problem.constant)
        self.omegas = [fixed(h.omega) for h in problem.harmonics]
        self.amplitude = sum(
            abs(fixed(h.cos)) + abs(fixed(h.sin)) for h in problem.harmonics
        ) + abs(self.constant)
        self.p, self.q = [], []
        for h in problem.harmonics:
            c, s = mpmath.cos_sin(number(h.omega) * t)
            cos, sin = number(h.cos), number(h.sin)
            self.p.append(fixed(cos * c + sin * s))
            self.q.append(fixed(sin * c - cos * s))
        self.stops = problem.stops
        self.walls = {i: s for i, s in enumerate(problem.stops) if isinstance(s, Wall)}
        self.softs = {i: s for i, s in enumerate(problem.stops) if isinstance(s, Soft)}
        self.places = [fixed(number(stop.at)) for stop in problem.stops]
        self.x, self.v, self.t = fixed(x), fixed(v), fixed(t)
        self.run = Run()
        self.at = at
        self.inside = {
            i for i, soft in self.softs.items() if _into(soft) * (self.x - self.places[i]) > 0
        }
        self.began = False

    def go(self, t_end: int, most: int) -> None:
        while self.t < t_end and len(self.run.events) < most:
            wall = next((i for i in self.walls if self.places[i] == self.x), None)
            order, way = self._direction()
            into = wall is not None and way * _into(self.stops[wall]) >= 0
            if wall is not None and into and order == 1 and not self.began:
                self._strike(wall, (0.0,) * 5, (0.0, 0.0))
            elif wall is not None and into:
                self._hold(wall, t_end)
            elif order == 0:
                self._skip(t_end)
                return
            else:
                self._switch(way)
                self._fly(order, way, t_end)
            self.began = True

    # -- the equation ---------------------------------------------------------------------------

    def _law(self) -> tuple[int, int, int]:
        """Return stiffness, twice the damping, and the constant force."""
        softs = [(self.softs[i], self.places[i]) for i in sorted(self.inside)]
        k = self.stiffness + sum(fixed(s.stiffness) for s, _ in softs)
        twice = 2 * (self.damping + sum(fixed(s.damping) for s, _ in softs))
        constant = self.constant + sum(times(fixed(s.stiffness), at) for s, at in softs)
        return k, twice, constant

    def _series(self, h: int) -> tuple[list[int], list[list[int]], list[list[int]]]:
        """Return the coefficients of x, and of each p and q, in powers of s / h."""
        k, twice, constant = self._law()
        hh = times(h, h)
        pull, drag = times(k, hh), times(twice, h)
        ps, qs = [], []
        for p, q, omega in zip(self.p, self.q, self.omegas, strict=True):
            a, b = turned(p, q, times(omega, h), ORDER)
            ps.append(a)
            qs.append(b)
        d = [self.x, times(self.v, h)]
        for n in range(ORDER - 1):
            force = sum(a[n] for a in ps) + (constant if n == 0 else 0)
            bend = times(force, hh) - times(drag, d[n + 1]) * (n + 1) - times(pull, d[n])
            d.append(bend // ((n + 1) * (n + 2)))
        return d, ps, qs

    def _longest(self) -> int:
        k, twice, _ = self._law()
        rates = [math.sqrt(abs(k / ONE)), twice / ONE, *(w / ONE for w in self.omegas), 0.05]
        return fixed(Fraction(0.25 / max(rates)))

    def _bend(self) -> int:
        """Return the acceleration here."""
        k, twice, constant = self._law()
        return constant + sum(self.p) - times(k, self.x) - times(twice, self.v)

    def _direction(self) -> tuple[int, int]:
        """Return the order and the sign of the first derivative that moves x, 0 if none does."""
        if abs(self.v) > 0:
            return 1, 1 if self.v > 0 else -1
        h = self._longest()
        d, _, _ = self._series(h)
        power = times(h, h)
        for n in range(2, 13):
            c = (d[n] << BITS) // power * math.factorial(n)
            if abs(c) > TINY:
                return n, 1 if c > 0 else -1
            power = times(power, h)
        return 0, 0

    # -- what may happen ------------------------------------------------------------------------

    def _switch(self, way: int) -> None:
        """Enter or leave the soft stops at x for a motion that sets off in a direction."""
        for i, stop in self.softs.items():
            if self.places[i] == self.x:
                inside = way * _into(stop) > 0
                (self.inside.add if inside else self.inside.discard)(i)

    def _fly(self, order: int, way: int, t_end: int) -> None:
        if order > 1:
            self.v = 0
        k, twice, constant = self._law()
        load = self.amplitude + abs(constant) + abs(times(k, self.x))
        begin, v0, bend0, x0 = self.t, self.v, self._bend(), self.x
        multiplicity = order
        levels = self._levels(way)
        guess = 4 * abs(self.v) * ONE // max(abs(bend0), 1) if order == 1 else 0
        while self.t < t_end:
            h = min(self._longest(), self._until(t_end))
            if guess > 0 and guess < h and multiplicity:
                # A short hop ends soon: a step of its own length separates its roots.
                h = guess
            d, ps, qs = self._series(h)
            found: tuple[int, int] | None = None
            for sign, level in levels:
                p = [sign * c for c in d]
                p[0] -= sign * level
                if multiplicity and level == x0 == self.x:
                    p = p[multiplicity:]
                root, doubtful = first_root(p)
                if doubtful:
                    self.run.doubts.append(real(self.t + h))
                if root is not None and (found is None or root < found[0]):
                    found = root, level
            u = ONE if found is None else found[0]
            self._move(h, u, d, ps, qs)
            multiplicity = 0
            if found is not None:
                self.x = found[1]
                flight = (
                    (self.t - begin) / ONE,
                    v0 / ONE,
                    k / ONE,
                    twice / ONE / 2,
                    load / ONE,
                )
                self._meet(flight, (bend0 / ONE, self._bend() / ONE))
                return

    def _move(self, h: int, u: int, d: list[int], ps: list[list[int]], qs: list[list[int]]) -> None:
        slope = value_at([n * c for n, c in enumerate(d)][1:], u)
        self.x, self.v = value_at(d, u), (slope << BITS) // h
        self.p = [value_at(a, u) for a in ps]
        self.q = [value_at(b, u) for b in qs]
        self.t += times(h, u)
        self._note()

    def _note(self) -> None:
        """Keep the state where it was asked for."""
        while self.at and fixed(Fraction(self.at[0])) <= self.t:
            self.run.states[self.at.pop(0)] = real(self.x), real(self.v)

    def _until(self, t_end: int) -> int:
        wanted = fixed(Fraction(self.at[0])) if self.at else t_end
        return max(1, min(t_end, wanted) - self.t)

    def _levels(self, way: int) -> list[tuple[int, int]]:
        """Return (sign, place) of the nearest place below (sign 1) and above (sign -1)."""
        found = []
        for sign in (1, -1):
            near = [
                (sign * (self.x - at), at)
                for at in self.places
                if sign * (self.x - at) > 0 or (at == self.x and way == sign)
            ]
            if near:
                found.append((sign, min(near)[1]))
        return found

    def _meet(
        self, flight: tuple[float, float, float, float, float], bends: tuple[float, float]
    ) -> None:
        wall = [
            i
            for i, stop in self.walls.items()
            if self.places[i] == self.x and _into(stop) * self.v > 0
        ]
        if wall:
            self._strike(wall[0], flight, bends)
            return
        v = real(self.v)
        for i, stop in self.softs.items():
            if self.places[i] == self.x:
                kind = "in" if _into(stop) * self.v > 0 else "out"
                self.run.events.append(Event(kind, real(self.t), i, v, v, flight, bends))

    def _strike(
        self,
        wall: int,
        flight: tuple[float, float, float, float, float],
        bends: tuple[float, float],
    ) -> None:
        stop = self.walls[wall]
        before = self.v
        ratio = fixed(restitution_of(stop, abs(real(self.v))))
        self.v = -times(ratio, self.v)
        self.run.events.append(
            Event("impact", real(self.t), wall, real(before), real(self.v), flight, bends)
        )
        press = _into(stop) * (self._bend() + times(self._law()[1], self.v))
        # Only where the force presses do slow hops shrink to a point.
        if 0 < abs(self.v) < SLOW and abs(self.v) * 10**9 < press and ratio < ONE:
            left = (2 * abs(self.v) << BITS) // times(press, ONE - ratio)
            self.run.tails.append((real(self.t), real(self.t + left)))
            self._turn(left)
            self.v = 0

    def _turn(self, s: int) -> None:
        """Let a short time pass at a wall."""
        _, ps, qs = self._series(s)
        self.p = [value_at(a, ONE) for a in ps]
        self.q = [value_at(b, ONE) for b in qs]
        self.t += s
        self._note()

    def _hold(self, wall: int, t_end: int) -> None:
        """Stay at a wall until the force turns away from it."""
        self.v = 0
        start = real(self.t)
        self.run.events.append(Event("rest", start, wall))
        k, _, constant = self._law()
        push = constant - times(k, self.x)
        into = _into(self.stops[wall])
        first = True
        if not self.p:
            # Without harmonics the force never turns.
            self._skip(t_end)
        while self.t < t_end:
            h = min(self._longest(), self._until(t_end))
            _, ps, qs = self._series(h)
            force = [into * sum(a[n] for a in ps) for n in range(ORDER + 1)]
            force[0] += into * push
            order = 0
            while first and order < ORDER and abs(force[order]) < TINY:
                order += 1
            root, doubtful = first_root(force[order:]) if order < ORDER else (None, False)
            first = False
            if doubtful:
                self.run.doubts.append(real(self.t + h))
            u = ONE if root is None else root
            self.p = [value_at(a, u) for a in ps]
            self.q = [value_at(b, u) for b in qs]
            self.t += times(h, u)
            self._note()
            if root is not None:
                slope = sum(times(w, b) for w, b in zip(self.omegas, self.q, strict=True)) / ONE
                load = (self.amplitude + abs(push)) / ONE
                self.run.events.append(
                    Event(
                        "release", real(self.t), wall, flight=(0, 0, 0, 0, load), bends=(0, slope)
                    )
                )
                # The force there is zero: what the digits leave of it does not count.
                self.p[0] -= push + sum(self.p)
                return

    def _skip(self, t_end: int) -> None:
        """Rest where nothing ever moves."""
        self.t = t_end
        self._note()


def _into(stop: Wall | Soft) -> int:
    """Return the direction into a stop."""
    return -1 if stop.side == "below" else 1


def value_at(coefficients: list[int], u: int) -> int:
    """Return a polynomial's value, by Horner's scheme."""
    total = 0
    for c in reversed(coefficients):
        total = times(total, u) + c
    return total


def first_root(p: list[int]) -> tuple[int | None, bool]:
    """Return the first root in (0, 1] of a polynomial that is positive at 0, and any doubt."""
    rest = abs(p[-1]) + abs(p[-2]) + (1 << 12)
    if p[0] > sum(abs(c) for c in p[1:]) + rest:
        return None, False
    degree = len(p) - 1
    scaled = [(c << 8) // math.comb(degree, n) for n, c in enumerate(p)]
    # By repeated sums: b_i = sum_j comb(i, j) scaled_j.
    bernstein, row = [], list(scaled)
    for _ in range(degree + 1):
        bernstein.append(row[0] >> 8)
        row = [a + b for a, b in pairwise(row)]
    bracket, doubtful = _bracket(bernstein, 0, ONE, 0, rest)
    return (None if bracket is None else _refined(p, *bracket)), doubtful


def _bracket(
    b: list[int], low: int, width: int, depth: int, rest: int
) -> tuple[tuple[int, int] | None, bool]:
    """Return where the first root lies alone, and whether one was left undecided before it."""
    if min(b) > rest:
        return None, False
    if max(abs(c) for c in b) <= rest:
        return None, True
    signs = [c > 0 for c in b]
    changes = sum(s != t for s, t in pairwise(signs))
    if changes == 1 and b[0] > 0 and b[-1] <= -rest:
        return (low, low + width), False
    if depth == HALVINGS:
        return ((low, low + width), True) if b[-1] < 0 else (None, True)
    left, right, row = [], [], list(b)
    while row:
        left.append(row[0])
        right.append(row[-1])
        row = [(p + q) >> 1 for p, q in pairwise(row)]
    found, doubtful = _bracket(left, low, width // 2, depth + 1, rest)
    if found is not None:
        return found, doubtful
    found, more = _bracket(right[::-1], low + width // 2, width // 2, depth + 1, rest)
    return found, doubtful or more


def _refined(p: list[int], low: int, high: int) -> int:
    """Return the one root between, by Newton's steps kept in the bracket."""
    slopes = [n * c for n, c in enumerate(p)][1:]
    u = (low + high) // 2
    while high - low > 2:
        value = value_at(p, u)
        low, high = (u, high) if value > 0 else (low, u)
        slope = value_at(slopes, u)
        step = -(value << BITS) // slope if slope else 0
        if abs(step) <= 2:
            return u + step
        u = u + step if low < u + step < high else (low + high) // 2
    return u
