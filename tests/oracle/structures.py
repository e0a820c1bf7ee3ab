"""The motion of a structure from event to event by Taylor series, in integers.

It shares no code with percuss: matrices in, events out. No mode, no exponential and no closed form
takes part. Numbers are whole multiples of 2**-256, as in `taylor_series`. On each step the
coefficients follow by recurrence from

    M x'' = loads + stops - C x' - K x,   p_j' = w_j q_j,   q_j' = -w_j p_j,

where p_j and q_j are the cosines and sines of the loads. A step h times the quickest rate s is at
most 1/2, where s is the largest of |C|, sqrt |K| (as row sums, after the division by M) and w_j:
derivatives grow by 1.62 s at most, so that 40 terms leave 0.81^41 / 41! of the state, 1e-53. What a
step can hide is decided on its polynomial: c . x(s) - at of each stop has no root where its
Bernstein coefficients have one sign, and one where their signs change once; else the step is halved
(`taylor_series.first_root`). What 60 halvings leave open is in `doubts`.

The rules. A wall turns c . x' into -r c . x' by an impulse along M^-1 c. Of several walls at one
instant the one of lowest index that is approached comes first, and again, until none is. Walls
whose speed is nothing hold the motion as long as they push; which of them do is the solution of the
linear complementarity problem. Hops of a chatter below 1e-18 are summed as a geometric series,
which leaves its square; those of two walls at once are listed down to 1e-30, where a motion counts
as at rest. A soft stop acts while y is beyond it, also where its dashpot pulls.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import mpmath
from tests.oracle.curves import Harmonic, Real
from tests.oracle.event_driven import Piece, Soft, Wall, number, restitution_of
from tests.oracle.from_model import harmonic_of, pieces_of
from tests.oracle.taylor_series import BITS, ONE, first_root, fixed, real, times, turned, value_at

import percuss as pc
from percuss.model import as_fraction, loads_of
from percuss.model.restitution import restitution_knots

ORDER = 40
# Distances and speeds below these count as nothing: rounding, of quantities of order one.
AT, STILL = ONE >> 190, ONE >> 100
# Derivatives below this count as zero where a motion at rest sets off.
TINY = ONE >> 120
HIGHEST = 12
# What the last terms of a step may leave.
REST = ONE >> 160
# Hops of a chatter slower than this are summed.
SLOW = ONE // 10**18
# Another wall nearer than this may take part in a chatter.
NEAR = ONE // 10**12
MOST_IMPACTS_AT_ONCE = 1000

Vector = list[int]
Rows = list[list[int]]


@dataclass(frozen=True)
class Load:
    """A force along a direction: constant, harmonics and pieces, as `event_driven` has them."""

    direction: tuple[Fraction, ...]
    constant: Fraction = Fraction(0)
    harmonics: tuple[Harmonic, ...] = ()
    pieces: tuple[Piece, ...] = ()


@dataclass(frozen=True)
class StructureProblem:
    """M x'' + C x' + K x = loads + stops; soft stops have full coefficients k_s and c_s."""

    mass: tuple[tuple[Fraction, ...], ...]
    damping: tuple[tuple[Fraction, ...], ...]
    stiffness: tuple[tuple[Fraction, ...], ...]
    stops: tuple[tuple[tuple[Fraction, ...], Wall | Soft], ...] = ()
    loads: tuple[Load, ...] = ()


@dataclass(frozen=True)
class StructureEvent:
    """What happened: impact, in, out, rest or release, at which stop, and y' there."""

    kind: str
    t: Real
    stop: int
    v_before: Real = 0
    v_after: Real = 0


@dataclass
class StructureRun:
    """The events in order, the motion, and the touches that are left undecided."""

    events: list[StructureEvent] = field(default_factory=list)
    doubts: list[Real] = field(default_factory=list)
    # Summed tails of chatters: begin and end.
    tails: list[tuple[Real, Real]] = field(default_factory=list)
    # Begin and length of each step, coefficients of x in powers of s / h, held walls, soft stops in
    # touch.
    starts: list[int] = field(default_factory=list)
    steps: list[tuple[int, Rows, tuple[int, ...], tuple[int, ...]]] = field(default_factory=list)

    def held_at(self, t: Real) -> tuple[int, ...]:
        """Return the walls that hold the motion at t."""
        with mpmath.workdps(100):
            return self.steps[max(0, bisect_right(self.starts, fixed(number(t))) - 1)][2]

    def __call__(self, t: Real) -> tuple[list[Real], list[Real]]:
        """Return x and x' at t, after an impact at t."""
        with mpmath.workdps(100):
            moment = fixed(number(t))
            i = max(0, bisect_right(self.starts, moment) - 1)
            h, rows, _, _ = self.steps[i]
            u = ((moment - self.starts[i]) << BITS) // h
            x = [real(value_at(row, u)) for row in rows]
            slopes = [[n * c for n, c in enumerate(row)][1:] for row in rows]
            return x, [real((value_at(row, u) << BITS) // h) for row in slopes]


def structure_problem(structure: pc.Structure, loads: object = None) -> StructureProblem:
    """Return the same equation as exact numbers."""
    stops: list[tuple[tuple[Fraction, ...], Wall | Soft]] = []
    for stop, row in zip(structure.stops, structure.stop_directions.tolist(), strict=True):
        direction, at = tuple(map(Fraction, row)), as_fraction(stop.at)
        if isinstance(stop, pc.Wall):
            knots = restitution_knots(stop.restitution)
            wall = Wall(at, stop.side, knots if len(knots) > 1 else knots[0][1])
            stops.append((direction, wall))
        else:
            k, c = as_fraction(stop.stiffness), as_fraction(stop.damping)
            stops.append((direction, Soft(at, stop.side, k, c)))
    mass, damping, stiffness = (
        tuple(tuple(as_fraction(entry) for entry in row) for row in matrix)
        for matrix in (structure.mass, structure.damping, structure.stiffness)
    )
    given = loads_of(structure, loads)
    directions = given.directions(structure).tolist()
    acting = tuple(
        Load(
            tuple(map(Fraction, direction)),
            as_fraction(force.constant),
            tuple(harmonic_of(part, force) for part in force.harmonics),
            () if force.record is None else pieces_of(force.record),
        )
        for direction, force in zip(directions, given.forcings, strict=True)
    )
    return StructureProblem(mass, damping, stiffness, tuple(stops), acting)


def simulate_structure(
    problem: StructureProblem,
    x0: Sequence[Real],
    v0: Sequence[Real],
    t0: Real = 0,
    *,
    t_end: Real,
    most_events: int = 3000,
) -> StructureRun:
    """Return the motion up to t_end, or to a number of events."""
    with mpmath.workdps(100):
        state = [number(x) for x in x0], [number(v) for v in v0]
        march = _March(problem, [fixed(x) for x in state[0]], [fixed(v) for v in state[1]], t0)
        march.go(fixed(number(t_end)), most_events)
    return march.run


def solved(matrix: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> list[Fraction]:
    """Return the exact solution of linear equations, by elimination."""
    rows = [[*map(Fraction, row), Fraction(b)] for row, b in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [entry / rows[k][k] for entry in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                ratio = rows[i][k]
                rows[i] = [a - ratio * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]


def _turned(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def dot(a: Vector, b: Vector) -> int:
    """Return the sum of the products, rounded once."""
    return sum(map(int.__mul__, a, b)) >> BITS


class _March:
    def __init__(self, problem: StructureProblem, x: Vector, v: Vector, t0: Real) -> None:
        self.n = len(x)
        mass = problem.mass
        columns = [
            solved(mass, [Fraction(int(i == j)) for i in range(self.n)]) for j in range(self.n)
        ]
        self.inverse = [[columns[j][i] for j in range(self.n)] for i in range(self.n)]
        self.damping, self.stiffness = problem.damping, problem.stiffness
        self.kinds = [stop for _, stop in problem.stops]
        self.directions = [direction for direction, _ in problem.stops]
        self.rows = [[fixed(c) for c in direction] for direction in self.directions]
        self.pulls = [[fixed(a) for a in self._times_inverse(c)] for c in self.directions]
        self.places = [fixed(number(stop.at)) for stop in self.kinds]
        # The clearance of a stop is sign (y - at): positive on its free side.
        self.signs = [1 if stop.side == "below" else -1 for stop in self.kinds]
        self.walls = [i for i, stop in enumerate(self.kinds) if isinstance(stop, Wall)]
        self.softs = [i for i, stop in enumerate(self.kinds) if isinstance(stop, Soft)]
        self._set_loads(problem.loads, number(t0))
        self.x, self.v, self.t = x, v, fixed(number(t0))
        self.run = StructureRun()
        self.inside = {i for i in self.softs if self._clearance(i) < 0}
        self.held: tuple[int, ...] = ()
        # Stops at which the motion is, with the order of the first derivative that moves it.
        self.orders: dict[int, int] = {}
        self.laws: dict[tuple[object, ...], tuple[Rows, Rows, Vector, int]] = {}
        self.guess = 0

    def _times_inverse(self, c: Sequence[Fraction]) -> list[Fraction]:
        return [
            sum((a * b for a, b in zip(row, c, strict=True)), Fraction(0)) for row in self.inverse
        ]

    def _set_loads(self, loads: Sequence[Load], t: Real) -> None:
        self.constant = [0] * self.n
        self.omegas: list[int] = []
        self.waves: Rows = []
        self.p: Vector = []
        self.q: Vector = []
        # M^-1 c, the pieces as (begin, force, slope), and their begins.
        self.records: list[tuple[Vector, list[tuple[int, int, int]], list[int]]] = []
        for load in loads:
            pull = [fixed(a) for a in self._times_inverse(load.direction)]
            level = fixed(load.constant)
            self.constant = [a + times(level, b) for a, b in zip(self.constant, pull, strict=True)]
            for h in load.harmonics:
                c, s = mpmath.cos_sin(number(h.omega) * t)
                cos, sin = number(h.cos), number(h.sin)
                self.p.append(fixed(cos * c + sin * s))
                self.q.append(fixed(sin * c - cos * s))
                self.omegas.append(fixed(number(h.omega)))
                self.waves.append(pull)
            if load.pieces:
                pieces = [
                    (fixed(number(p.t)), fixed(number(p.force)), fixed(number(p.slope)))
                    for p in load.pieces
                ]
                self.records.append((pull, pieces, [begin for begin, _, _ in pieces]))
        self.knots = sorted({begin for _, _, begins in self.records for begin in begins})

    # -- the equation ---------------------------------------------------------------------------

    def _law(self) -> tuple[Rows, Rows, Vector, int]:
        """Return -M^-1 K, -M^-1 C and M^-1 f of what acts here, walls aside, and a rate."""
        key = tuple(sorted(self.inside))
        if key not in self.laws:
            k = [list(row) for row in self.stiffness]
            c = [list(row) for row in self.damping]
            force = [Fraction(0)] * self.n
            for i in key:
                soft, direction = self.kinds[i], self.directions[i]
                assert isinstance(soft, Soft)
                ks, cs = Fraction(soft.stiffness), Fraction(soft.damping)
                for a in range(self.n):
                    force[a] += direction[a] * ks * Fraction(soft.at)
                    for b in range(self.n):
                        k[a][b] += direction[a] * direction[b] * ks
                        c[a][b] += direction[a] * direction[b] * cs
            pull = [[-fixed(e) for e in self._times_inverse(col)] for col in zip(*k, strict=True)]
            drag = [[-fixed(e) for e in self._times_inverse(col)] for col in zip(*c, strict=True)]
            pull, drag = _turned(pull), _turned(drag)
            size = max(sum(abs(e) for e in row) for row in pull) / ONE
            brake = max(sum(abs(e) for e in row) for row in drag) / ONE
            rate = max(math.sqrt(size), brake, *(w / ONE for w in self.omegas), 0.05)
            at = [fixed(f) + g for f, g in
                  zip(self._times_inverse(force), self.constant, strict=True)]  # fmt: skip
            self.laws[key] = pull, drag, at, fixed(Fraction(0.5 / rate))
        return self.laws[key]

    def _forces(self) -> tuple[Vector, Vector]:
        """Return M^-1 times the records here, and its slope."""
        level, slope = [0] * self.n, [0] * self.n
        for pull, pieces, begins in self.records:
            i = bisect_right(begins, self.t) - 1
            if i >= 0:
                begin, force, steep = pieces[i]
                force += times(steep, self.t - begin)
                level = [a + times(force, b) for a, b in zip(level, pull, strict=True)]
                slope = [a + times(steep, b) for a, b in zip(slope, pull, strict=True)]
        return level, slope

    def _holding(self, held: tuple[int, ...]) -> tuple[Rows, Rows]:
        """Return (C M^-1 C^T)^-1 of the held walls, and M^-1 C^T as rows."""
        size = [[sum((a * b for a, b in zip(self.directions[i], self._times_inverse(
            self.directions[j]), strict=True)), Fraction(0)) for j in held] for i in held]  # fmt: skip
        inverse = [
            [fixed(e) for e in solved(size, [Fraction(int(i == j)) for i in range(len(held))])]
            for j in range(len(held))
        ]
        return inverse, [self.pulls[i] for i in held]

    def _series(self, h: int, held: tuple[int, ...]) -> tuple[Rows, Rows, Rows, Rows]:
        """Return coefficients of x, of p, of q, and of the pushes of held walls times h^2."""
        pull, drag, constant, _ = self._law()
        level, slope = self._forces()
        hh = times(h, h)
        pull = [[times(hh, e) for e in row] for row in pull]
        drag = [[times(h, e) for e in row] for row in drag]
        ps, qs = [], []
        for p, q, omega in zip(self.p, self.q, self.omegas, strict=True):
            a, b = turned(p, q, times(omega, h), ORDER)
            ps.append(a)
            qs.append(b)
        waves = [[times(hh, e) for e in row] for row in self.waves]
        inverse, ways = self._holding(held) if held else ([], [])
        d = [list(self.x), [times(h, v) for v in self.v]]
        pushes: Rows = []
        for k in range(ORDER - 1):
            xs, vs = d[k], [(k + 1) * e for e in d[k + 1]]
            bend = [dot(pull[i], xs) + dot(drag[i], vs) for i in range(self.n)]
            for a, wave in zip(ps, waves, strict=True):
                bend = [e + times(a[k], w) for e, w in zip(bend, wave, strict=True)]
            if k == 0:
                bend = [e + times(hh, c + f) for e, c, f in
                        zip(bend, constant, level, strict=True)]  # fmt: skip
            elif k == 1:
                step = times(hh, h)
                bend = [e + times(step, f) for e, f in zip(bend, slope, strict=True)]
            if held:
                along = [dot(self.rows[i], bend) for i in held]
                push = [-dot(row, along) for row in inverse]
                for size, way in zip(push, ways, strict=True):
                    bend = [e + times(size, w) for e, w in zip(bend, way, strict=True)]
                pushes.append([size * self.signs[i] for size, i in zip(push, held, strict=True)])
            d.append([e // ((k + 1) * (k + 2)) for e in bend])
        return _turned(d), ps, qs, _turned(pushes)

    def _clearance(self, i: int) -> int:
        return self.signs[i] * (dot(self.rows[i], self.x) - self.places[i])

    def _speed(self, i: int) -> int:
        """Return the rate of the clearance."""
        return self.signs[i] * dot(self.rows[i], self.v)

    def _clearances(self, i: int, x: Rows) -> Vector:
        """Return the coefficients of a clearance on a step."""
        sign = self.signs[i]
        p = [sign * dot(self.rows[i], list(column)) for column in zip(*x, strict=True)]
        p[0] -= sign * self.places[i]
        return p

    # -- what may happen ------------------------------------------------------------------------

    def go(self, t_end: int, most: int) -> None:
        self._meet([i for i in range(len(self.kinds)) if abs(self._clearance(i)) < AT])
        while self.t < t_end and len(self.run.events) < most:
            self._step(t_end)

    def _step(self, t_end: int) -> None:
        _, _, _, longest = self._law()
        knots = self.knots[bisect_right(self.knots, self.t) :][:1]
        h = max(1, min(longest, *(t - self.t for t in (t_end, *knots))))
        # A short hop ends soon: a step of its own length separates its roots.
        if 0 < self.guess < h:
            h = self.guess
        self.guess = 0
        x, ps, qs, pushes = self._series(h, self.held)
        # Held walls may quicken the motion beyond the rate.
        while max(abs(row[-1]) + abs(row[-2]) for row in x) > REST:
            h //= 2
            x, ps, qs, pushes = self._series(h, self.held)
        first, who = ONE + 1, list[int]()
        for i in range(len(self.kinds)):
            if i in self.held:
                continue
            p = self._clearances(i, x)
            if i in self.inside:
                p = [-c for c in p]
            p = p[self.orders.get(i, 0) :]
            first, who = self._earlier(p, i, first, who, h)
        for p, i in zip(pushes, self.held, strict=True):
            first, who = self._earlier(p[self.orders.get(i, 0) :], i, first, who, h)
        u = min(first, ONE)
        self.orders = {}
        self.run.starts.append(self.t)
        self.run.steps.append((h, x, self.held, tuple(sorted(self.inside))))
        self.x = [value_at(row, u) for row in x]
        slopes = [[n * c for n, c in enumerate(row)][1:] for row in x]
        self.v = [(value_at(row, u) << BITS) // h for row in slopes]
        self.p, self.q = [value_at(a, u) for a in ps], [value_at(b, u) for b in qs]
        # A whole step ends where it was meant to, at a knot exactly.
        self.t += h if u == ONE else times(h, u)
        if who:
            released = [i for i in who if i in self.held]
            self._release(released)
            here = [i for i in range(len(self.kinds)) if i in who or abs(self._clearance(i)) < AT]
            self._meet([i for i in here if i not in released], released)
        elif self.held and self.t in knots:
            # A force that jumps may turn.
            self._meet(list(self.held))

    def _earlier(
        self, p: Vector, i: int, first: int, who: list[int], h: int
    ) -> tuple[int, list[int]]:
        if len(p) < 2:
            # Nothing moves the stop away, nor ever back.
            return first, who
        root, doubtful = first_root(p)
        if doubtful:
            self.run.doubts.append(real(self.t + h))
        if root is None or root > first + (AT >> 10):
            return first, who
        return (root, [i]) if root < first - (AT >> 10) else (first, [*who, i])

    def _note(self, kind: str, i: int, before: int = 0, after: int = 0) -> None:
        y = [real(self.signs[i] * speed) for speed in (before, after)]
        self.run.events.append(StructureEvent(kind, real(self.t), i, *y))

    def _release(self, released: list[int]) -> None:
        for i in released:
            self._note("release", i)
        self.held = tuple(i for i in self.held if i not in released)

    def _meet(self, here: list[int], released: Sequence[int] = ()) -> None:
        """Let everything happen that happens at one instant, at the stops where the motion is."""
        here = sorted({*here, *self.held})
        walls = [i for i in self.walls if i in here]
        self._strike(walls)
        still = [i for i in walls if abs(self._speed(i)) <= STILL]
        self._stop(still)
        before = self.held
        self.held = self._pressed(still, list(released))
        for i in before:
            if i not in self.held:
                self._note("release", i)
        for i in self.held:
            if i not in before:
                self._note("rest", i)
        self._set_orders(here, list(released))

    def _strike(self, walls: list[int]) -> None:
        for _ in range(MOST_IMPACTS_AT_ONCE):
            i = next((i for i in walls if self._speed(i) < -STILL), None)
            if i is None:
                return
            before = self._speed(i)
            wall = self.kinds[i]
            assert isinstance(wall, Wall)
            ratio = fixed(restitution_of(wall, abs(real(before))))
            after = -times(ratio, before)
            self._push_along(i, after - before)
            self._note("impact", i, before, after)
            others = tuple(j for j in self.held if j != i)
            push = -self._bend_of(i, others)
            alone = not any(
                abs(self._clearance(j)) < NEAR for j in self.walls if j != i and j not in self.held
            )
            # Only where the force presses do slow hops shrink to a point.
            if alone and STILL < after < SLOW and after * 10**9 < push and ratio < ONE:
                self._finish_chatter(i, (2 * after << BITS) // times(push, ONE - ratio))
        raise RuntimeError("walls at one instant hand an impact to and fro")

    def _push_along(self, i: int, change: int) -> None:
        """Change the rate of a clearance by an impulse along M^-1 c."""
        size = (self.signs[i] * change << BITS) // dot(self.rows[i], self.pulls[i])
        self.v = [v + times(size, w) for v, w in zip(self.v, self.pulls[i], strict=True)]

    def _stop(self, still: Sequence[int]) -> None:
        """Take what is left of the speeds at walls, together."""
        if still:
            inverse, ways = self._holding(tuple(still))
            speeds = [dot(self.rows[i], self.v) for i in still]
            for row, way in zip(inverse, ways, strict=True):
                size = dot(row, speeds)
                self.v = [v - times(size, w) for v, w in zip(self.v, way, strict=True)]

    def _bend_of(self, i: int, held: tuple[int, ...]) -> int:
        """Return the second derivative of a clearance, with walls held."""
        h = ONE >> 10
        x, _, _, _ = self._series(h, held)
        return 2 * self._clearances(i, x)[2] << 20

    def _finish_chatter(self, i: int, left: int) -> None:
        """Let the rest of a chatter pass, in which the wall pushes as it will in contact."""
        self.run.tails.append((real(self.t), real(self.t + left)))
        held = tuple(sorted({*self.held, i}))
        self._stop(held)
        x, ps, qs, _ = self._series(left, held)
        self.run.starts.append(self.t)
        self.run.steps.append((left, x, held, tuple(sorted(self.inside))))
        self.x = [value_at(row, ONE) for row in x]
        slopes = [[n * c for n, c in enumerate(row)][1:] for row in x]
        self.v = [(value_at(row, ONE) << BITS) // left for row in slopes]
        self.p, self.q = [value_at(a, ONE) for a in ps], [value_at(b, ONE) for b in qs]
        self.t += left
        self._stop(held)

    def _pressed(self, still: list[int], released: list[int]) -> tuple[int, ...]:
        """Return which walls hold: those that push while no other one is passed."""
        still = [i for i in still if i not in released]
        h = ONE >> 10
        for count in range(len(still) + 1):
            for held in itertools.combinations(still, count):
                x, _, _, pushes = self._series(h, held)
                if all(_sign(p) >= 0 for p in pushes) and all(
                    _sign(self._clearances(i, x)[2:]) > 0 for i in still if i not in held
                ):
                    return held
        raise RuntimeError("no set of walls holds the motion")

    def _set_orders(self, here: list[int], released: list[int]) -> None:
        """Note with which derivative the motion leaves each stop where it is, and switch stops."""
        h = ONE >> 10
        x, _, _, pushes = self._series(h, self.held)
        changed = False
        for i in [*here, *released]:
            if i in self.held:
                continue
            p = self._clearances(i, x)
            order = 3 if i in released else _order(p)
            self.orders[i] = order
            if i in self.softs:
                inside = p[order] < 0 if order < len(p) else False
                if inside != (i in self.inside):
                    speed = self._speed(i)
                    if self.run.starts:
                        self._note("in" if inside else "out", i, speed, speed)
                    (self.inside.add if inside else self.inside.discard)(i)
                    changed = True
            elif order == 1:
                bend = abs(2 * p[2] << 20)
                guess = (4 * (abs(p[1]) << 10) << BITS) // max(bend, 1)
                self.guess = guess if not self.guess else min(guess, self.guess)
        for p, i in zip(pushes, self.held, strict=True):
            # A push that begins with nothing.
            order = _order(p, start=0)
            if order:
                self.orders[i] = order
        if changed and self.held:
            # The force of a dashpot that jumps may turn a contact.
            again = self._pressed(list(self.held), [])
            for i in self.held:
                if i not in again:
                    self._note("release", i)
                    self.orders[i] = 2
            self.held = again


def _order(p: Vector, start: int = 1) -> int:
    """Return the first coefficient, in powers of s * 1024, that is not nothing."""
    return next((n for n in range(start, HIGHEST) if abs(p[n]) << (10 * n) > TINY), len(p))


def _sign(p: Vector) -> int:
    """Return the sign with which a polynomial sets off."""
    n = _order(p, start=0)
    return 0 if n == len(p) else (1 if p[n] > 0 else -1)


@dataclass(frozen=True)
class StructureOrbit:
    """A periodic motion: its state at t = 0, its multipliers, its run over a period, its error."""

    state: list[Real]
    multipliers: list[Real]
    run: StructureRun
    miss: Real


def closed_orbit(
    problem: StructureProblem, guess: Sequence[Real], period: Real, digits: int = 45
) -> StructureOrbit:
    """Return the periodic motion near a state (x, x') at t = 0, by Newton's method.

    Derivatives are differences over 1e-25, so that steps and multipliers are good to as many
    digits.
    """
    n = len(problem.mass)
    with mpmath.workdps(60):
        step, state = mpmath.mpf(10) ** -25, [number(entry) for entry in guess]

        def mapped(z: list[Real]) -> tuple[StructureRun, list[Real]]:
            run = simulate_structure(problem, z[:n], z[n:], 0, t_end=period)
            x, v = run(period)
            return run, [*x, *v]

        for _ in range(60):
            run, image = mapped(state)
            columns = []
            for j in range(2 * n):
                moved = list(state)
                moved[j] += step
                columns.append(
                    [(a - b) / step for a, b in zip(mapped(moved)[1], image, strict=True)]
                )
            matrix = mpmath.matrix(columns).T
            rest = mpmath.matrix([a - b for a, b in zip(state, image, strict=True)])
            miss = mpmath.norm(rest)
            if miss < mpmath.mpf(10) ** -digits:
                values = list(mpmath.eig(matrix, right=False))
                return StructureOrbit(state, values, run, miss)
            change = mpmath.lu_solve(matrix - mpmath.eye(2 * n), rest)
            # Far away the linear equations hold for short steps only.
            factor = min(1, mpmath.mpf("0.3") / mpmath.norm(change))
            state = [a + factor * b for a, b in zip(state, change, strict=True)]
    raise RuntimeError(f"no orbit found; the last state misses by {mpmath.nstr(miss, 3)}")
