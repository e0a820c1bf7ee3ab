"""Proofs of chaos: sets of states along homoclinic orbits of a saddle whose images cross each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from flint import arb

from percuss.arrays import Floats
from percuss.certified.ball_arithmetic import Ball, Undecided
from percuss.certified.certify import certify
from percuss.certified.cloud import applied
from percuss.certified.covering import (
    Covering,
    HSet,
    ImageOfSet,
    ImpactSurface,
    are_disjoint,
    covering,
    image_of,
    seen_from,
)
from percuss.certified.numbers import ball, between, precision
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.shooting import events_of
from percuss.certified.system import system_of
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import whole
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.system import System
from percuss.numerics import hypot, inverse, matmul
from percuss.orbits.finding.find import find_orbits
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import orbit_of_solution, solve
from percuss.orbits.surface.homoclinic import HomoclinicOrbit, homoclinic_orbits
from percuss.orbits.surface.maps import ImpactMap, impact_map
from percuss.orbits.surface.saddles import points_at_impacts
from percuss.progress import Progress, Report

BITS = 96
# A set is longer than what it has to cover needs, and wider than the image that crosses it, by
# this.
LONGER, WIDER = 1.3, 1.2
# Half-length of the set about the saddle, in the distance of the last point of the homoclinic orbit
# inside of it.
AROUND = 1.3
# Half-widths of that set that are tried, in its half-length.
PARTS = (0.3, 0.6, 1.0)
# The largest and the smallest set about a saddle that are tried, in units of a cycle and of the
# orbit's velocity.
LARGEST, SMALLEST = 0.04, 1e-3
# Trials of the lengths of sets along a homoclinic orbit, each with the shear that the last one
# showed.
TRIALS = 6
# Trials of the length of the part of the saddle's set from which a chain begins.
STRIPS = 4
# A root of an equation is enclosed to this part of 1.
ROOT_BITS = 60


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedChaos:
    """Sets of states that motions visit in any order that a graph allows, proven; of `prove_chaos`.

    The sets are disjoint, and the image of each under the impact map crosses those to which a
    transition leads. So for every endless walk in the graph there is a motion that visits the sets
    in its order, and for every closed walk one that is periodic (docs/theory/certified.md, section
    10).

    Attributes
    ----------
    orbit
        The saddle, a float orbit.
    homoclinic
        The homoclinic orbits along which the sets lie, floats.
    stop
        Index of the stop of the impact surface.
    sets
        The parallelograms, number 0 about the saddle; each has ``center``, ``unstable`` and
        ``stable`` as (t, v) [time, length/time], t in the first forcing period.
    transitions
        Pairs of numbers of sets: the image of the first covers the second.
    coverings
        How far, for each transition.
    strips
        The part of the first set of each transition whose image covers: where its middle is along
        the unstable direction and its half-length, in units of that of the set.
    loops
        The numbers of the sets on each loop from the saddle's set back to it.
    entropy
        Lower bound of the topological entropy of the impact map on these motions [1/impact]: the
        logarithm of the largest root of the sum of x^-n over the lengths n of the loops = 1.
    reason
        Why nothing is proven; empty if it is.
    bits
        Bits of the balls.
    """

    orbit: PeriodicOrbit
    homoclinic: tuple[HomoclinicOrbit, ...] = field(repr=False)
    stop: int
    sets: tuple[HSet, ...]
    transitions: tuple[tuple[int, int], ...]
    coverings: tuple[Covering, ...]
    strips: tuple[tuple[float, float], ...]
    loops: tuple[tuple[int, ...], ...]
    entropy: Ball
    reason: str
    bits: int

    def __bool__(self) -> bool:
        """Whether chaos is proven."""
        return not self.reason

    def __repr__(self) -> str:
        """Return what is proven, in a line."""
        if self.reason:
            return f"<CertifiedChaos: open: {self.reason}>"
        lengths = " and ".join(str(len(loop)) for loop in self.loops)
        return (
            f"<CertifiedChaos: {len(self.sets)} sets, loops of {lengths} impacts, topological "
            f"entropy >= {self.entropy.mid():.6g} an impact>"
        )

    def periodic_orbit(self, itinerary: Sequence[int], digits: int = 15) -> CertifiedOrbit:
        """Return the periodic orbit that passes through loops in an order, enclosed.

        Parameters
        ----------
        itinerary
            Numbers of loops, in any order: ``[0, 0, 1]`` passes the saddle's loop twice, then the
            next.
        digits
            Digits of the enclosure.

        Returns
        -------
        CertifiedOrbit
            With its impacts in the sets, proven, in the order of the loops.

        Raises
        ------
        ParameterError
            If nothing is proven, or a number is not that of a loop, or there is none.
        ConvergenceError
            If the orbit, which exists, was not found or not enclosed inside the sets.
        """
        order = [whole("itinerary", number, 0) for number in itinerary]
        if not self or not order or max(order) >= len(self.loops):
            reason = self.reason or f"numbers of loops are 0 to {len(self.loops) - 1}"
            raise ParameterError("itinerary", tuple(itinerary), reason)
        numbers = [number for loop in order for number in self.loops[loop]]
        certified = certify(_orbit_through(self, numbers), digits=digits)
        if not _visits(self, certified, numbers):
            reason = f"the orbit of loops {order} was not enclosed inside its sets"
            raise ConvergenceError(reason, (), certified.unique_within, "ask for more digits")
        return certified


def prove_chaos(
    osc: Oscillator,
    force: Forcing,
    *,
    saddle: PeriodicOrbit | None = None,
    stop: int | None = None,
    most_orbits: int = 2,
    progress: Report = None,
) -> CertifiedChaos:
    """Prove that motions are chaotic: that some follow each of infinitely many orders of sets.

    The float engine finds a saddle and homoclinic orbits, along which small parallelograms are laid
    in the impact surface. Ball arithmetic proves that the image of each, all of it, lies across the
    next one, and that they are disjoint: covering relations (Zgliczynski & Gidea 2004). Loops of
    n1, n2, ... impacts through the saddle's set then give motions for every sequence of loops.

    Parameters
    ----------
    osc, force
        The oscillator and its forcing: harmonics with a common period.
    saddle
        An unstable orbit with one impact a period on the stop; default: the first one that is found
        and has homoclinic orbits.
    stop
        Index of the stop; default: that of the saddle's first impact.
    most_orbits
        Homoclinic orbits along which sets are laid, >= 1.
    progress
        True shows a line on the error stream; a function ``(done, total) -> bool`` is called after
        each trial, and ends the search by returning False.

    Returns
    -------
    CertifiedChaos
        Which is False, with the reason, if no proof was found.

    Raises
    ------
    ParameterError
        If the given orbit is none, or no saddle, does not meet the stop once a period, or is of
        another system; if the forcing has no period or a record.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.certified import prove_chaos
    >>> chaos = prove_chaos(pc.impact_oscillator("4/5"), pc.cosine("14/5"), most_orbits=1)
    >>> bool(chaos), [len(loop) for loop in chaos.loops], chaos.entropy.mid() > 0.1437
    (True, [1, 10], True)
    """
    most_orbits = whole("most_orbits", most_orbits, 1)
    if stop is not None:
        stop = whole("stop", stop, 0)
    if saddle is not None and not isinstance(saddle, PeriodicOrbit):
        reason = "not a periodic orbit of find_orbit or find_orbits"
        raise ParameterError("saddle", type(saddle).__name__, reason)
    if saddle is not None and (saddle.oscillator, saddle.forcing) != (osc, force):
        raise ParameterError("saddle", saddle, "an orbit of another oscillator or forcing")
    reason = "no saddle with one impact a period was found"
    candidates = [saddle] if saddle is not None else _saddles(osc, force)
    reported = Progress(progress, max(1, len(candidates)), "saddles")
    best: CertifiedChaos | None = None
    for orbit in candidates:
        chaos = _proof_at(orbit, stop, most_orbits)
        if chaos or best is None:
            best = chaos
        goes_on = reported.advance()
        if chaos or not goes_on:
            break
    reported.close()
    if best is None:
        raise ParameterError("saddle", None, f"{reason}; give one by saddle=")
    return best


def _saddles(osc: Oscillator, force: Forcing) -> list[PeriodicOrbit]:
    """Return unstable orbits with one impact that motions follow, the least unstable first."""
    orbits = find_orbits(osc, force, max_impacts=1, max_periods=3)
    saddles = [
        orbit
        for orbit in orbits
        if orbit.admissible
        and len(orbit.impacts) == 1
        and orbit.multipliers[0].imag == 0.0
        and abs(orbit.multipliers[0]) > 1.0 > abs(orbit.multipliers[1]) > 0.0
    ]
    return sorted(saddles, key=lambda orbit: abs(orbit.multipliers[0]))


def _proof_at(orbit: PeriodicOrbit, stop: int | None, most_orbits: int) -> CertifiedChaos:
    """Return the proof about one saddle."""
    homoclinic = homoclinic_orbits(orbit, stop=stop, most_orbits=most_orbits)
    chosen = int(orbit.impacts.stop[0]) if stop is None else stop
    reason = "no homoclinic orbit of the saddle was found"
    best: _Graph | None = None
    with precision(BITS):
        layout = _layout(orbit, chosen)
        for half in sorted({h for path in homoclinic for h in layout.halves(path)}, reverse=True):
            try:
                graph = _Graph(layout.surface, layout.about_saddle(half))
            except Undecided as question:
                reason = question.reason
                continue
            for path in homoclinic:
                try:
                    graph.add(layout.along(path, graph.first))
                except Undecided as question:
                    reason = question.reason
            if len(graph.loops) > 1 and (best is None or graph.entropy() > best.entropy()):
                best = graph
        if best is None:
            none = Ball(arb(0))
            return CertifiedChaos(orbit, homoclinic, chosen, (), (), (), (), (), none, reason, BITS)
        return CertifiedChaos(
            orbit,
            homoclinic,
            chosen,
            sets=tuple(best.sets),
            transitions=tuple(best.transitions),
            coverings=tuple(best.coverings),
            strips=tuple(best.strips),
            loops=tuple(best.loops),
            entropy=Ball(best.entropy()),
            reason="",
            bits=BITS,
        )


def _layout(orbit: PeriodicOrbit, stop: int) -> _Layout:
    assert orbit.forcing is not None
    system = system_of(orbit.oscillator, orbit.forcing)
    event = next(event for event in events_of(system, orbit) if event.stop == stop)
    saddles = points_at_impacts(orbit, stop)
    axes = [saddles.directions(float(value))[0] for value in orbit.multipliers.real]
    return _Layout(
        ImpactSurface(system, event),
        impact_map(orbit.oscillator, orbit.forcing, stop),
        saddles.points[0],
        np.stack(axes, axis=1),
    )


class SaddleSet(NamedTuple):
    """The set about the saddle, with its half-lengths in the units of `HomoclinicOrbit`."""

    hset: HSet
    image: ImageOfSet
    unstable: float
    stable: float


class SetChain(NamedTuple):
    """Sets from the saddle's set on, without it, that end where it is covered again.

    ``coverings`` has one more: the first is that of the first set by a strip of the saddle's, which
    lies at ``at`` with a half-length of ``half``.
    """

    sets: list[HSet]
    coverings: list[Covering]
    at: float
    half: float


@dataclass(frozen=True, slots=True)
class _Layout:
    """Lays sets along homoclinic orbits, by floats; `covering` says what they prove.

    Attributes
    ----------
    surface, map
        The impact map in balls and in floats.
    saddle, axes
        The saddle, and its unstable and stable directions as columns, in (cycle, v).
    """

    surface: ImpactSurface
    map: ImpactMap
    saddle: Floats
    axes: Floats

    def halves(self, path: HomoclinicOrbit) -> list[float]:
        """Return half-lengths of a saddle's set in whose inside the last point before leaving lies."""
        a = abs(path.coordinates[: _farthest(path) + 1, 0])
        halves = [AROUND * x for x, y in pairwise(a.tolist()) if x < y]
        return [half for half in halves if SMALLEST <= half <= LARGEST]

    def hset(self, point: Floats, unstable: Floats, stable: Floats) -> HSet:
        """Return a set from cycles and velocities."""
        scale = np.array([float(self.surface.period.mid()), 1.0])
        (t, v), (t_u, v_u), (t_s, v_s) = (
            (scale * value).tolist() for value in (point, unstable, stable)
        )
        return HSet((t, v), (t_u, v_u), (t_s, v_s))

    def about_saddle(self, half: float) -> SaddleSet:
        """Return the narrowest of some sets about the saddle that its image crosses."""
        unstable, stable = self.axes.T
        for part in PARTS:
            hset = self.hset(self.saddle, half * unstable, part * half * stable)
            image = image_of(self.surface, hset)
            try:
                covering(self.surface, image, hset, hset)
            except Undecided:
                if part == PARTS[-1]:
                    raise
                continue
            return SaddleSet(hset, image, half, part * half)
        raise AssertionError

    def along(self, path: HomoclinicOrbit, first: SaddleSet) -> SetChain:
        """Return sets along a homoclinic orbit, each as long as the next one needs it.

        Raises
        ------
        Undecided
            If the orbit does not fit the saddle's set, or an image does not cross the next set.
        """
        points, at = self._outside(path, first)
        jacobians = self.map.jacobian(*points.T)
        unstable, stable = self._directions(jacobians)
        moved = [matmul(jacobian, u) for jacobian, u in zip(jacobians, unstable, strict=True)]
        stretches, shears = [float(hypot(*vector)) for vector in moved], [0.0] * len(points)
        for trial in range(TRIALS):
            halves = _halves(stretches, shears, first.unstable)
            following = self.hset(points[1], halves[1] * unstable[1], stable[1])
            half = halves[0] / first.unstable
            before, image, half = self._strip(first, at, half, following)
            sets = [before]
            coverings: list[Covering] = []
            for k in range(1, len(points) + 1):
                if k < len(points):
                    thin = self.hset(points[k], halves[k] * unstable[k], stable[k])
                    (_, s), (_, (s_by_u, s_by_s)) = seen_from(self.surface, image, before, thin)
                    wide = WIDER * float((abs(s) + abs(s_by_u) + abs(s_by_s)).upper())
                    here = self.hset(points[k], halves[k] * unstable[k], wide * stable[k])
                else:
                    here = first.hset
                try:
                    coverings.append(covering(self.surface, image, before, here))
                except Undecided:
                    if trial == TRIALS - 1:
                        raise
                (u, _), ((u_by_u, u_by_s), _) = seen_from(self.surface, image, before, here)
                if u_by_u.contains(0):
                    raise Undecided("precision", "a set is folded by the map")
                if k > 1:
                    stretches[k - 1] = float(u_by_u.abs_lower()) * halves[k] / halves[k - 1]
                    shears[k - 1] = float((abs(u) + abs(u_by_s)).upper()) * halves[k]
                if k < len(points):
                    before, image = here, image_of(self.surface, here)
                    sets.append(here)
            if len(coverings) == len(points):
                return SetChain(sets[1:], coverings, at, half)
        raise AssertionError

    def _strip(
        self, first: SaddleSet, at: float, half: float, following: HSet
    ) -> tuple[HSet, ImageOfSet, float]:
        """Return a part of the saddle's set that is stretched across a set, its image and its half."""
        for _ in range(STRIPS):
            if abs(at) + half > 1.0:
                break
            strip = first.hset.strip(at, half)
            image = image_of(self.surface, strip)
            (u, _), ((u_by_u, u_by_s), _) = seen_from(self.surface, image, strip, following)
            needed = float(((1 + abs(u) + abs(u_by_s)) / u_by_u.abs_lower()).upper())
            if needed < 1.0:
                return strip, image, half
            half *= LONGER * needed
        raise Undecided("precision", "the saddle's set is too short for a homoclinic orbit")

    def _outside(self, path: HomoclinicOrbit, first: SaddleSet) -> tuple[Floats, float]:
        """Return the points outside of the saddle's set with the one before, and where that one is."""
        a, b = abs(path.coordinates).T
        far = _farthest(path)
        inside = np.flatnonzero(a[:far] < 0.9 * first.unstable)
        back = np.flatnonzero((b[far:] < 0.8 * first.stable) & (a[far:] < 0.5 * first.unstable))
        if not inside.size or not back.size:
            raise Undecided("precision", "a homoclinic orbit does not end in the saddle's set")
        begin, end = int(inside[-1]), far + int(back[0])
        return path.points[begin:end], float(path.coordinates[begin, 0]) / first.unstable

    def _directions(self, jacobians: Floats) -> tuple[Floats, Floats]:
        """Return the unstable and stable directions at points, carried forth and back from the saddle."""
        unstable, stable = [self.axes[:, 0]], [self.axes[:, 1]]
        for jacobian in jacobians[:-1]:
            moved = matmul(jacobian, unstable[-1])
            unstable.append(moved / hypot(*moved))
        for jacobian in jacobians[::-1]:
            moved = matmul(inverse(jacobian), stable[-1])
            stable.append(moved / hypot(*moved))
        return np.array(unstable), np.array(stable[:0:-1])


def _farthest(path: HomoclinicOrbit) -> int:
    """Return the number of the point farthest from the saddle."""
    return int(np.argmax(hypot(*path.coordinates.T)))


def _halves(stretches: list[float], shears: list[float], last: float) -> list[float]:
    """Return the half-lengths of sets that are stretched to more than the next one and its shear."""
    halves = [last]
    for stretch, shear in zip(stretches[::-1], shears[::-1], strict=True):
        halves.append(LONGER * (halves[-1] + shear) / stretch)
    return halves[::-1]


class _Graph:
    """The sets so far, with the transitions between them."""

    def __init__(self, surface: ImpactSurface, first: SaddleSet) -> None:
        self.surface, self.first = surface, first
        self.sets = [first.hset]
        self.loops = [(0,)]
        self.transitions = [(0, 0)]
        self.coverings = [covering(surface, first.image, first.hset, first.hset)]
        self.strips = [(0.0, 1.0)]

    def add(self, chain: SetChain) -> None:
        """Add a chain if its sets are disjoint from all others."""
        sets = self.sets + chain.sets
        pairs = [(i, j) for j in range(len(self.sets), len(sets)) for i in range(j)]
        for i, j in pairs:
            if not are_disjoint(self.surface, sets[i], sets[j]):
                raise Undecided("precision", f"sets {i} and {j} are not proven to be disjoint")
        numbers = (0, *range(len(self.sets), len(sets)))
        self.transitions += list(zip(numbers, (*numbers[1:], 0), strict=True))
        self.coverings += chain.coverings
        self.strips += [(chain.at, chain.half), *[(0.0, 1.0)] * len(chain.sets)]
        self.loops.append(numbers)
        self.sets = sets

    def entropy(self) -> arb:
        """Return the logarithm of the growth of the number of walks."""
        low, high = growth_of_loops([len(loop) for loop in self.loops])
        return between(ball(low), ball(high)).log()


def growth_of_loops(lengths: Sequence[int]) -> tuple[Fraction, Fraction]:
    """Return two numbers between which the largest root of the sum of x^-n over lengths n = 1 lies.

    It is above a rational where the sum is more than 1, and below one where it is less.
    """
    low, high = Fraction(1), Fraction(len(lengths))
    while high - low > Fraction(1, 2**ROOT_BITS):
        middle = (low + high) / 2
        if sum(middle**-n for n in lengths) > 1:
            low = middle
        else:
            high = middle
    return low, high


def _orbit_through(chaos: CertifiedChaos, numbers: list[int]) -> PeriodicOrbit:
    """Return the float orbit that visits sets in an order."""
    orbit = chaos.orbit
    if len(orbit.itinerary) != 1:
        reason = "the saddle meets other stops as well; periodic orbits are given of one event each"
        raise ParameterError("itinerary", numbers, reason)
    system = System(orbit.oscillator, orbit.forcing)
    period = float(system.law[0, PERIOD])
    turns = dict(zip(chaos.transitions, chaos.coverings, strict=True))
    steps = zip(numbers, (*numbers[1:], numbers[0]), strict=True)
    later = np.array([turns[step].turns for step in steps])
    t, v = np.array([chaos.sets[number].center for number in numbers]).T
    durations = np.roll(t, -1) - t + later * period
    events = np.repeat(orbit.itinerary.events, len(numbers), axis=0)
    guess = Itinerary(events, float(t[0]), durations, v, int(later.sum()))
    solution = solve(system, guess)
    if not solution.converged:
        where = [(float(t[0]), float(v[0]))]
        reason = "the periodic orbit of these loops, which exists, was not found"
        raise ConvergenceError(reason, where, solution.residual, "fewer loops are easier")
    return orbit_of_solution(system, solution)


def _visits(chaos: CertifiedChaos, orbit: CertifiedOrbit, numbers: list[int]) -> bool:
    """Return whether the impacts of an orbit are proven to lie in sets, from some of them on."""
    if not orbit.exists or orbit.admissible is not True:
        return False
    with precision(orbit.precision):
        period = orbit.period.arb / orbit.n_periods
        states = list(zip(orbit.event_times.arbs, orbit.impacts.v_after.arbs, strict=True))
        inside = [
            [_lies_in(chaos.sets[number], t, v, period) for t, v in states]
            for number in set(numbers)
        ]
        row = {number: i for i, number in enumerate(set(numbers))}
        n = len(states)
        return n == len(numbers) and any(
            all(inside[row[number]][(k + shift) % n] for k, number in enumerate(numbers))
            for shift in range(n)
        )


def _lies_in(hset: HSet, t: arb, v: arb, period: arb) -> bool:
    t = t - hset.center[0]
    t = t - round(float(t / period)) * period
    u, s = applied(hset.coordinates(), (t, v - hset.center[1]))
    return bool(abs(u) < 1 and abs(s) < 1)
