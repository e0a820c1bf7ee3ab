"""The equations of curves in two parameters: those of an orbit, and one condition.

A curve is the set of zeros of K equations in K + 1 unknowns, the last two of which are the
parameters. At folds, period doublings and symmetry breakings a matrix M is singular: the number g
of the bordered system [M b; c' 0] [q; g] = [0; 1] vanishes (Govaerts 2000, chapter 3). It is as
smooth as M, also where an impact has zero velocity.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import lru_cache
from typing import Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError
from percuss.kernels.law_columns import Law
from percuss.numerics import directions, dot, matmul, norm
from percuss.orbits.bifurcations.branch_equations import OrbitEquations
from percuss.orbits.bifurcations.parameter_ranges import Ranges
from percuss.orbits.continuation.correct import Broyden, corrected, solved, tangent_of
from percuss.orbits.continuation.problem import BorderError, Point, along_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

Values = tuple[float, float]

# Scaled residuals of a point that need not become smaller, and those near other curves.
ENOUGH, ROUNDING = 1e-13, 1e-16
# Steps of Broyden's method, and from how many points its derivatives are computed anew.
MOST_STEPS, MOST_TIMES = 13, 4
# Scaled arclength of the longest step, where the velocities are those of the first orbit.
LONGEST_STEP = 0.25
# Velocities into a soft stop below this part of the scale: it is hardly met. Steps to there are
# repeated with half the length, down to the second number, in scaled arclength.
HARDLY, NEAR_END = 1e-4, 1e-5
# Cosine of the angle between tangents below which a curve is told to have a corner.
TURNED = 0.97
# Scaled steps of central differences, where h^2 and 1e-16/h are both small, and of one-sided ones.
CENTRAL, ONE_SIDED = 1e-5, 1e-7
# Component of a parameter in the tangent below which a curve runs along the end of its range.
ALONG_EDGE = 1e-6
# The part of the period between an event and a jump of the force at which a curve has come to it:
# beyond it a step cannot be told from one across.
AT_JUMP = 1e-4


class CurveEquations(ABC):
    """The equations of a curve; the points are z = (scaled unknowns, two scaled parameters).

    Parameters
    ----------
    equations
        Those of the orbits.
    """

    noun = "curve"
    cyclic = slice(0, 1)
    order = 2
    of_multipliers = False

    def __init__(self, equations: OrbitEquations) -> None:
        self.equations, self.paths = equations, equations.paths
        self.n_periods = equations.n_periods
        self._matrix: Floats | None = None
        self._latest = np.empty(0), np.empty((0, 0))

    @property
    def orbits(self) -> OrbitEquations:
        """The equations of the orbits of the curve."""
        return self.equations

    @abstractmethod
    def residual(self, z: Floats) -> Floats:
        """Return the scaled residuals, (K,)."""

    @abstractmethod
    def by_unknowns(self, z: Floats) -> Floats:
        """Return their derivatives by all but the two parameters, (K, K - 1)."""

    @abstractmethod
    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""

    @abstractmethod
    def tests(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions whose zeros are points of codimension two."""

    def evaluated(self, z: Floats) -> tuple[PeriodicOrbit, dict[str, float]]:
        """Return the orbit of a point with these functions."""
        orbit = self.solution(z)
        return orbit, self.tests(z, orbit)

    def test(self, z: Floats, name: str) -> float:
        """Return one of the functions, which may be cheaper than all of them."""
        return self.evaluated(z)[1][name]

    def pieces(self, a: Floats, b: Floats) -> int:  # noqa: ARG002
        """Return the number of pieces between two points with one change of sign at most."""
        return 1

    def values(self, z: Floats) -> Values:
        """Return the two parameters of a point."""
        one, other = (self.equations.value_at(k, float(z[k - 2])) for k in range(2))
        return one, other

    def law_of(self, z: Floats) -> Law:
        """Return the law of a point."""
        return self.equations.law_at(self.values(z))

    def size(self, z: Floats) -> float:
        """Return the ratio of the velocities to those of the first orbit, at least 1."""
        return max(1.0, float(np.abs(z[1 + self.equations.n : -2]).max(initial=0.0)))

    def derivatives(self, z: Floats) -> Floats:
        """Return the derivatives of the residuals, (K, K + 1); by the parameters as differences.

        They give directions only: solutions do not depend on their last digits.
        """
        here = self.residual(z)
        slopes = [self._slope(z, here, k) for k in (-2, -1)]
        return np.column_stack([self.by_unknowns(z), *slopes])

    def _slope(self, z: Floats, here: Floats, k: int) -> Floats:
        shifted = z.copy()
        # Inwards: beyond the range there may be no system.
        shifted[k] += ONE_SIDED if z[k] < 0.5 else -ONE_SIDED
        return np.asarray((self.residual(shifted) - here) / (shifted[k] - z[k]))

    def corrected(
        self,
        guess: Floats,
        normal: Floats,
        *,
        near_others: bool = False,
    ) -> Floats:
        """Return the point of the curve in the plane through a guess with this normal.

        Broyden's method, from the derivatives at the settled point, or from new ones. Near other
        curves, where small residuals are large errors, down to rounding.

        Raises
        ------
        ConvergenceError
            If it finds none.
        ParameterError
            If the parameters cannot have the values.
        """
        z, error = guess, np.inf
        enough = ROUNDING if near_others else ENOUGH
        for k in range(MOST_TIMES):
            matrix = self._matrix if k == 0 else self.derivatives(z)
            if matrix is None:
                continue
            equations = Broyden(self.residual, matrix)
            z, error, is_solved = corrected(
                equations, z, normal, steps=MOST_STEPS, enough=enough, size=self.size
            )
            if is_solved:
                return z
        raise ConvergenceError("no point of the curve found", guess, error, "take smaller steps")

    def started(self, guess: Floats) -> Point[Self]:
        """Return the point of the curve next to a guess, with its tangent.

        A parameter at an end of its range stays there.

        Raises
        ------
        ConvergenceError
            If there is none.
        """
        _, rows = directions(self.derivatives(guess))
        tangent = normal = rows[-1]
        for k in (-2, -1):
            if guess[k] in (0.0, 1.0) and abs(tangent[k]) > ALONG_EDGE:
                normal = along_parameter(len(guess), k)
        return self._point(self.corrected(guess, normal), tangent)

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution with its tangent, on the side of an earlier one's, and its tests."""
        point = self._point(z, before.tangent)
        if self._meets_jump(before, point):
            raise BorderError("an event meets a jump of the force", is_located=False)
        lost = self.lost_stop(point.tests)
        if lost and norm(z - before.z) > NEAR_END:
            raise ConvergenceError(lost, z, 0.0, "take smaller steps")
        return point

    def _meets_jump(self, before: Point[Self], point: Point[Self]) -> bool:
        """Return whether a curve has a corner, or ends, between two points at a jump of the force.

        There the multipliers jump, so that a condition on them is no longer met; other curves may
        turn little.
        """
        if not self.equations.jumps:
            return False
        sides = [self.equations.sides(each.z[:-2], self.values(each.z)) for each in (before, point)]
        changes = bool((sides[0] != sides[1]).any())
        return changes and (self.of_multipliers or dot(before.tangent, point.tangent) < TURNED)

    def jump_met(self, last: Point[Self]) -> str:
        """Return the sentence of a curve that ends at a jump of the force, "" where it does not."""
        if self.orbits.nearest_jump(last.z[:-2], self.law_of(last.z)) > AT_JUMP:
            return ""
        met = f"beyond {last.text} an event meets a jump of the force, where the multipliers jump"
        return f"{met}: the curve ends there"

    def lost_stop(self, tests: Mapping[str, float]) -> str:
        """Return the soft stop that is hardly met, "" for none.

        There the time inside the stop vanishes, and a factor of the equations with it: their zeros
        are no folds. The curves on the other side, and that of grazing, lead to the point itself.
        """
        orbits = self.orbits
        for k, (row, stop, _) in enumerate(orbits.entries):
            slowest = HARDLY * orbits.scale[-1]
            if not orbits.walls[row] and tests[f"velocity {k}"] < slowest:
                return f"the orbit hardly meets soft stop {stop}"
        return ""

    def _point(self, z: Floats, before: Floats) -> Point[Self]:
        derivatives = self.derivatives(z)
        self._latest = z, derivatives
        return Point(z, tangent_of(derivatives, before), *self.evaluated(z), self)

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return the point itself: its tangent is the best there is."""
        return point

    def recentre(self, point: Point[Self]) -> None:
        """Make a point the centre of the neighbourhood in which the next are computed."""
        z, derivatives = self._latest
        if z is not point.z:
            derivatives = self.derivatives(point.z)
        self._matrix = self._centred(point.z, derivatives)

    def _centred(self, z: Floats, derivatives: Floats) -> Floats:  # noqa: ARG002
        """Prepare the equations for the neighbourhood of a point; return its derivatives then."""
        return derivatives

    def corrector_normal(self, tangent: Floats, step: float) -> Floats:  # noqa: ARG002
        """Return the normal of the hyperplane of Newton's correction."""
        return tangent

    def longest_step(self, point: Point[Self], largest: float) -> float:
        """Return the longest step, in proportion to the velocities.

        The parameters change by the caller's largest step at most.
        """
        longest = LONGEST_STEP * self.size(point.z)
        return min(longest, largest / max(norm(point.tangent[-2:]), 1e-9))


class MultiplierCurve(CurveEquations):
    """Orbits with a multiplier of 1 (folds) or -1 (period doublings).

    Over half a period of symmetric orbits, -1 breaks the symmetry.

    Parameters
    ----------
    equations
        Those of the orbits.
    multiplier
        1.0 or -1.0.
    start
        The point at which to begin.
    """

    of_multipliers = True

    def __init__(self, equations: OrbitEquations, multiplier: float, start: Floats) -> None:
        super().__init__(equations)
        self.multiplier = multiplier
        self._edge(start)

    def _edge(self, z: Floats) -> None:
        """Take the null vectors at a point as the border of the matrix."""
        returns = self._returns(z[:-2], self.law_of(z))
        self._border = directions(returns.T)[1][-1], directions(returns)[1][-1]

    def recentre(self, point: Point[Self]) -> None:
        """Make a point the centre of the neighbourhood in which the next are computed."""
        before = point.tests.get("cusp", 0.0)
        if self._latest[0] is not point.z and before * self._bend(point.z) < 0.0:
            # The last centre was far away, and turns the null vectors from those of the tests.
            left, right = self._border
            self._border = -left, right
        super().recentre(point)

    def _returns_of(self, matrix: Floats) -> Floats:
        equations = self.equations
        return return_equations(matrix, equations.n, self.multiplier, equations.mirror)

    def _returns(self, unknowns: Floats, law: Law) -> Floats:
        """Return the matrix that is singular at the multiplier."""
        _, matrix = self.equations.regular_shot(unknowns, law)
        return self._returns_of(matrix)

    def _centred(self, z: Floats, derivatives: Floats) -> Floats:
        """Take the null vectors at a point as the border; return its derivatives then."""
        left, right = self._null(self._returns(z[:-2], self.law_of(z)))
        sizes = norm(left), norm(right)
        self._border = left / sizes[0], right / sizes[1]
        matrix = derivatives.copy()
        # With null vectors of size 1 for its border, g changes by their former sizes.
        matrix[2 * self.equations.n + 1] /= sizes[0] * sizes[1]
        return matrix

    def _bordered(self, returns: Floats) -> tuple[Floats, Floats]:
        """Return the bordered matrix, and the solution (q, g) of its equations."""
        left, right = self._border
        size = len(returns)
        whole = np.zeros((size + 1, size + 1))
        whole[:-1, :-1], whole[:-1, -1], whole[-1, :-1] = returns, left, right
        return whole, solved(whole, np.append(np.zeros(size), 1.0))

    def _null(self, returns: Floats) -> tuple[Floats, Floats]:
        """Return (psi, q), the null vectors of the matrix where it is singular."""
        whole, right = self._bordered(returns)
        return solved(whole.T, np.append(np.zeros(len(returns)), 1.0))[:-1], right[:-1]

    def residual(self, z: Floats) -> Floats:
        """Return those of the orbit, and g."""
        residual, matrix = self.equations.regular_shot(z[:-2], self.law_of(z))
        returns = self._returns_of(matrix)
        return np.append(residual, self._bordered(returns)[1][-1])

    def by_unknowns(self, z: Floats) -> Floats:
        """Return the derivatives: of g, by those of the matrix, -psi' dM q."""
        law, unknowns = self.law_of(z), z[:-2]
        _, matrix = self.equations.regular_shot(unknowns, law)
        psi, q = self._null(self._returns_of(matrix))
        slopes = []
        for k in range(len(unknowns)):
            unit = np.zeros(len(unknowns))
            unit[k] = 1.0
            slopes.append(-dot(psi, matmul(self._change(unknowns, law, unit), q)))
        return np.vstack([matrix, slopes])

    def _change(self, unknowns: Floats, law: Law, direction: Floats) -> Floats:
        """Return the derivative of the matrix along a direction of the unknowns."""
        steps = [CENTRAL, -CENTRAL]
        if self.equations.jumps:
            # Beyond a jump of the force the matrix is another one.
            side = self.equations.sides_under(unknowns, law)
            for k, step in enumerate(steps):
                moved_side = self.equations.sides_under(unknowns + step * direction, law)
                if (moved_side != side).any():
                    steps[k] = 0.0
        ahead, behind = (self._returns(unknowns + step * direction, law) for step in steps)
        return np.asarray((ahead - behind) / (steps[0] - steps[1] or CENTRAL))

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""
        return self.equations.orbit_at(z[:-2], self.values(z))

    def tests(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return velocities, clearance and, of folds, the quadratic coefficient."""
        tests = {"clearance": min(orbit.grazing_margin, 1e300)}
        for k, speed in enumerate(self.equations.into_stops(orbit)):
            tests[f"velocity {k}"] = float(speed)
        if self.multiplier == 1.0:
            tests["cusp"] = self._bend(z)
        return tests

    def _bend(self, z: Floats) -> float:
        """Return psi' F_uu q q, whose zeros are cusps (Kuznetsov 2004, section 8.2)."""
        unknowns, law = z[:-2], self.law_of(z)
        psi, q = self._null(self._returns(unknowns, law))
        psi, q = psi / norm(psi), q / norm(q)
        along = unknowns_from_events(q)
        return dot(psi, matmul(self._change(unknowns, law, along), q))


def return_equations(matrix: Floats, n: int, multiplier: float, mirror: float = 1.0) -> Floats:
    """Return M(mu), the linearised equations of neighbours of a periodic orbit.

    With the changes dt of the instants of the events and dv of the velocities after them as
    unknowns, neighbours that return multiplied by mu obey M(mu) (dt, dv) = 0. Here det M(mu) is the
    characteristic polynomial of the monodromy matrix times the velocities of the events: there is
    no division by the velocity of an impact, and M is smooth where it vanishes.

    Parameters
    ----------
    matrix
        (2 n + 1, 2 n + 1) array, scaled derivatives that `percuss.kernels.shooting.shoot` writes,
        by the first instant, the durations and the velocities, with one unit of time and one of
        velocity.
    n
        Number of events.
    multiplier
        mu.
    mirror
        -1.0 where the events begin anew mirrored, after half a period.

    Returns
    -------
    array
        (2 n, 2 n), by dt_0, ..., dt_(n-1), dv_0, ..., dv_(n-1).
    """
    into, of, factors, constants = _places(n, multiplier, mirror)
    sums = np.bincount(into, factors * matrix.ravel()[of], minlength=4 * n * n)
    return np.asarray((sums + constants).reshape(2 * n, 2 * n))


@lru_cache(maxsize=64)
def _places(n: int, multiplier: float, mirror: float) -> tuple[Integers, Integers, Floats, Floats]:
    """Return the entries of M as sums of derivatives: into, of, factors and constants."""
    terms: list[tuple[int, int, float]] = []
    constants = np.zeros(4 * n * n)
    for i in range(n):
        following = (i + 1) % n
        # After the last event comes the first one, a period later.
        end = multiplier if following == 0 else 1.0
        for row in (2 * i, 2 * i + 1):
            entry, derivative = 2 * n * row, (2 * n + 1) * row
            # A later event delays one flight, and lengthens the flight before it.
            terms += [(entry + i, derivative, 1.0), (entry + i, derivative + 1 + i, -1.0)]
            terms += [(entry + following, derivative + 1 + i, end)]
            terms += [(entry + n + i, derivative + 1 + n + i, 1.0)]
        # The velocity after an event stands in its own row, with the factor 1.
        own = 2 * n * (2 * i + 1) + n + following
        turned = mirror if following == 0 else 1.0
        constants[own] += turned * end - (turned if n == 1 else 0.0)
    into, of, factors = zip(*terms, strict=True)
    return np.array(into), np.array(of), np.array(factors), constants


def unknowns_from_events(changes: Floats) -> Floats:
    """Return changes of the unknowns of an itinerary from those of its events, with mu = 1.

    From (2 n,) dt and dv to (2 n + 1,): the first instant, the durations and the velocities.
    """
    n = len(changes) // 2
    instants = changes[:n]
    return np.concatenate([instants[:1], np.roll(instants, -1) - instants, changes[n:]])


# Largest scaled residual of the second half where the first half solves its equations.
MIRRORED = 1e-9


class HalfEquations(OrbitEquations):
    """The equations of the first half of symmetric orbits, which the second half mirrors.

    Their multipliers are the squares of those of the map over half a period and a mirror: where
    one of these is -1 the symmetry breaks, as a period doubles where one of the others is (Swift &
    Wiesenfeld 1984). The unknowns are the instant of the first event and the durations and
    velocities of the first half; after it comes the first event, mirrored.

    Parameters
    ----------
    orbit
        One of them, symmetric.
    ranges
        As for `OrbitEquations`.
    events
        (2 m, 3) array, all events, where they are not those of the orbit.
    """

    mirror = -1.0

    def __init__(
        self, orbit: PeriodicOrbit, ranges: Ranges, events: Integers | None = None
    ) -> None:
        super().__init__(orbit, ranges, events)
        self.whole = OrbitEquations(orbit, ranges, events)
        n, m = self.whole.n, self.whole.n // 2
        self.n = m
        self.scale = np.repeat([self.scale[0], self.scale[-1]], [1 + m, m])
        self.rows = np.append(self.rows[: 2 * m], self.rows[-1])
        self.entries = [sign for sign in self.entries if sign[0] < m]
        self.walls = self.walls[:m]
        unit = np.eye(m)
        self._copies = np.zeros((2 * n + 1, 2 * m + 1))
        self._copies[0, 0] = 1.0
        self._copies[1 : 1 + n, 1 : 1 + m] = np.vstack([unit, unit])
        self._copies[1 + n :, 1 + m :] = np.vstack([unit, self.mirror * unit])

    def unknowns_of(self, orbit: PeriodicOrbit) -> Floats:
        """Return the scaled unknowns of an orbit with these events."""
        whole = self.whole.unknowns_of(orbit)
        n = self.whole.n
        return np.concatenate([whole[: 1 + self.n], whole[1 + n : 1 + n + self.n]])

    def shot(self, unknowns: Floats, law: Law) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns, under a law."""
        residual, matrix = self.whole.shot(matmul(self._copies, unknowns), law)
        kept = np.append(np.arange(2 * self.n), 4 * self.n)
        return residual[kept], matmul(matrix, self._copies)[kept]

    def orbit_at(self, unknowns: Floats, values: tuple[float, ...]) -> PeriodicOrbit:
        """Return the orbit of a solution.

        Raises
        ------
        ConvergenceError
            If the second half does not mirror the first: the system is not symmetric.
        """
        whole = matmul(self._copies, unknowns)
        residual, _ = self.whole.shot(whole, self.law_at(values))
        error = float(np.abs(residual).max())
        if error > MIRRORED:
            what = "the system is not symmetric, and no orbit mirrors itself"
            raise ConvergenceError(what, unknowns, error, "vary what keeps the symmetry")
        return self.whole.orbit_at(whole, values)

    def into_stops(self, orbit: PeriodicOrbit) -> Floats:
        """Return the velocity into each stop that is met in the first half."""
        return self.whole.into_stops(orbit)[: len(self.entries)]
