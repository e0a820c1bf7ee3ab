"""Chains of strips: curves of orbits that are enclosed whole, through folds.

A strip holds the orbits for all values of one coordinate, the parameter or, near a fold, an instant
or a velocity. In each of its values exactly one orbit lies near the tangent; where the end of one
strip lies in the next one, the curve goes on in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce
from itertools import pairwise

from flint import arb, arb_mat, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.branch import system_over
from percuss.certified.fold import OrbitCurve
from percuss.certified.numbers import ball, exact_value, span
from percuss.certified.properties import admissible_of, monodromy_of
from percuss.certified.shooting import (
    Image,
    Shooting,
    Vector,
    derivative_over,
    matrix_of,
    pairs,
    residual_of,
)
from percuss.errors import ParameterError

# Why a chain ends that its caller did not wait for.
STOPPED = "stopped"
# How often the box around the tangent is made wider, and by how much beyond its image.
TRIALS, WIDER = 5, 1.5
# A first half-width of that box, as a part of the length of the tangent in the strip.
FIRST_WIDTH = 2.0**-10
# How many strips of one width come before a wider one is tried.
PATIENCE = 3
# The first width of a strip, and the least, as parts of the scale of its coordinate.
FIRST_STEP, LEAST_STEP = 2.0**-7, 2.0**-13
# A width at which another coordinate is tried, and for how many strips it then stays.
NARROW, STAYING = 2.0**-9, 8
# How far back a strip along another coordinate begins, as a part of its width.
OVERLAP = 2.0**-4
# How much longer the curve may be than the way from orbit to orbit.
MOST_LENGTH = 2.0
# The last point is made the end of a strip where it is nearer than so many widths.
ENOUGH = 1.2
# A strip is slender if it is narrower than this part of its length; it is cut so often at most.
SLENDER, MOST_CUTS = 2.0**-4, 3
# How often the parts of a strip that may have an orbit at a value of the parameter are halved, and
# how many there are at most.
MOST_HALVINGS, MOST_PARTS = 12, 8
# How many times the radius of a ball its middle should be away from zero.
CLEAR = 3
# The parameter is the coordinate of a strip while its part of the tangent is at least this.
STEEP = 0.2


@dataclass(frozen=True)
class Tube:
    """Orbits of a curve for all values of one of their coordinates, near its tangent.

    Instants and velocities after the events and then the parameter are the coordinates, numbered
    from 0.

    Attributes
    ----------
    along
        The coordinate that is given.
    low, high
        Its ends.
    middle, tangent
        A point near the curve in the middle, and its derivative by the coordinate.
    sizes, trial
        How far from the tangent the orbits are at most; and how far there are no others.
    """

    along: int
    low: Fraction
    high: Fraction
    middle: Vector
    tangent: Vector
    sizes: Vector
    trial: Vector

    @property
    def is_along_parameter(self) -> bool:
        """Whether the parameter is the coordinate that is given."""
        return self.along == len(self.middle) - 1

    @property
    def parameters(self) -> tuple[Fraction, Fraction]:
        """Two numbers between which the parameters of all its orbits lie."""
        if self.is_along_parameter:
            return self.low, self.high
        value = self.box()[-1]
        return exact_value(value.lower()), exact_value(value.upper())

    def box(self) -> Vector:
        """Return a box that holds all its orbits."""
        ends = ball(self.low).union(ball(self.high))
        return _around(self.along, ends, self.middle, self.tangent, self.sizes)

    def end(self, value: Fraction) -> Vector:
        """Return a box that holds the orbit at one value of the coordinate."""
        return _around(self.along, ball(value), self.middle, self.tangent, self.sizes)

    def may_have(self, parameter: Fraction) -> bool:
        """Return whether an orbit at a value of the parameter may be one of its own."""
        low, high = self.parameters
        return low <= parameter <= high

    def has_only(self, box: Vector) -> bool:
        """Return whether a solution in a box is one of the tube's own: it lies where no other is."""
        eta = box[self.along]
        if not (eta >= ball(self.low) and eta <= ball(self.high)):
            return False
        tangent = _around(self.along, eta, self.middle, self.tangent, [arb(0)] * len(box))
        return all(
            abs(own - point) < size
            for i, (own, point, size) in enumerate(zip(box, tangent, self.trial, strict=True))
            if i != self.along
        )


@dataclass(frozen=True)
class Strip:
    """A tube and what holds for all of its orbits.

    Attributes
    ----------
    tube
        The orbits.
    end
        The value of its coordinate at which the curve goes on.
    trace, determinant
        Of their monodromy.
    stability, admissible
        As of `CertifiedOrbit`.
    half
        Of symmetric orbits det(1 - H') with the mirrored map H over half of each; else None.
    keeps_areas
        Whether the determinant is 1 exactly.
    """

    tube: Tube
    end: Fraction
    trace: arb
    determinant: arb
    stability: str
    admissible: bool | None
    half: arb | None = None
    keeps_areas: bool = False

    @property
    def begin(self) -> Fraction:
        """The value of its coordinate at which it begins."""
        return self.tube.low if self.end == self.tube.high else self.tube.high

    @property
    def fold(self) -> arb:
        """What is zero at a fold: det(1 - M) for the map M over the orbit, or `half`."""
        return 1 - self.trace + self.determinant if self.half is None else self.half

    @property
    def is_decided(self) -> bool:
        """Whether stability and admissibility of all its orbits are proven."""
        return self.stability != "undecided" and self.admissible is not None

    @property
    def is_clear(self) -> bool:
        """Whether stability is decided by balls some times wider than they are."""
        clear = [1 + sign * self.trace + self.determinant for sign in (1, -1)]
        return all(abs(value.mid()) > CLEAR * value.rad() for value in clear)

    def points_before(self, other: Strip) -> list[str]:
        """Return the kinds of special points that lie on the curve between this strip and another."""
        both = self, other
        fold = [strip.fold for strip in both]
        if self.half is None or other.half is None:
            doubling = [1 + strip.trace + strip.determinant for strip in both]
            functions = {"period_doubling": doubling, "fold": fold}
            if all(strip.keeps_areas for strip in both):
                functions["third_root"] = [1 + strip.trace for strip in both]
                functions["fourth_root"] = [strip.trace for strip in both]
        else:
            # M = H^2, so that det(1 - M) = det(1 - H') det(1 + H').
            breaking = [(1 - s.trace + s.determinant) / s.fold for s in both]
            functions = {"symmetry_breaking": breaking, "fold": fold}
        return [kind for kind, pair in functions.items() if _change(*pair)]


def _change(one: arb, other: arb) -> bool:
    """Return whether a function changes its sign between two values of it."""
    return bool((one > 0 and other < 0) or (one < 0 and other > 0))


def _around(along: int, eta: arb, middle: Vector, tangent: Vector, sizes: Vector) -> Vector:
    """Return a box around the tangent for a ball of its coordinate."""
    shift = eta - middle[along]
    box = [
        point + slope * shift + span(size)
        for point, slope, size in zip(middle, tangent, sizes, strict=True)
    ]
    box[along] = eta
    return box


class StripEquations:
    """The equations F(z; p) - z of a curve and their derivatives by all coordinates."""

    def __init__(self, curve: OrbitCurve) -> None:
        self.curve = curve
        self.durations: list[arb] = []
        # Those of a point and of a box, and of the end before: each is asked for several times.
        self._known: list[tuple[arb, Shooting]] = []

    def at(self, value: arb) -> Shooting:
        """Return the equations for a ball of the parameter."""
        for known, equations in self._known:
            if known.contains(value) and value.contains(known):
                return equations
        try:
            equations = self.curve.equations(value)
        except ParameterError as fault:
            raise Undecided("precision", f"next to it there is no such system; {fault}") from None
        self._keep(value, equations)
        return equations

    def put(self, value: arb, low: Fraction, high: Fraction) -> None:
        """Note the equations between two values of the parameter, for a ball that holds them."""
        curve = self.curve
        system = system_over(curve.system, curve.path, low, high)
        self._keep(value, curve.equations_of(system))

    def _keep(self, value: arb, equations: Shooting) -> None:
        self._known = [*self._known[-3:], (value, equations)]

    def _images(self, u: Vector) -> tuple[Shooting, list[Image]]:
        equations = self.at(u[-1])
        return equations, equations.images(pairs(u[:-1]), self.curve.coarse())

    def value(self, u: Vector) -> arb_mat:
        """Return by how much a point misses itself, and note the flights' roots."""
        _, images = self._images(u)
        self.durations = [image.duration for image in images]
        return residual_of(pairs(u[:-1]), images)

    def derivative(self, u: Vector, *, checked: bool = True) -> list[list[arb]]:
        """Return the rows of the derivative on a box, the column of the parameter last."""
        equations, images = self._images(u)
        if checked:
            for image, duration in zip(images, self.durations, strict=True):
                if not image.isolating.contains(duration):
                    reason = "value and derivative may be of two roots of a flight"
                    raise Undecided("precision", reason)
        column = self.curve.by_parameter(equations, pairs(u[:-1]), u[-1])
        rows: list[list[arb]] = matrix_of(images).tolist()
        return [[*row, entry] for row, entry in zip(rows, column, strict=True)]


def split_along(rows: list[list[arb]], along: int) -> tuple[arb_mat, arb_mat]:
    """Return the derivative by the other coordinates, and that by the one that is given."""
    others = arb_mat([[entry for i, entry in enumerate(row) if i != along] for row in rows])
    return others, arb_mat([[row[along]] for row in rows])


def _with(vector: list[arb], along: int, entry: arb) -> Vector:
    return [*vector[:along], entry, *vector[along:]]


@dataclass
class StripChain:
    """Strips of one curve, each of which goes on in the next one; made by `chain_of`.

    Attributes
    ----------
    curve
        The curve.
    scale
        Of each coordinate.
    strips
        In order.
    reason
        Why it ends before the last point; empty where it reaches it.
    """

    curve: OrbitCurve
    scale: Vector
    strips: list[Strip] = field(default_factory=list)
    reason: str = ""

    def walk(self) -> StripWalk:
        """Return a walk along the curve that does not divide strips."""
        return StripWalk(StripEquations(self.curve), self.scale, 0.0)

    def room(self, tube: Tube) -> float:
        """Return by how much a tube may be made wider without being wide beside its length."""
        return max(1.5, SLENDER / self.walk().width_to_length(tube))

    def parameters(self, strips: Sequence[Strip]) -> tuple[Fraction, Fraction]:
        """Return two numbers between which all parameters of successive strips lie, as near as known.

        Where no orbit is at a fold the parameter goes one way along the curve: those of the two
        ends decide.
        """
        lows, highs = zip(*(strip.tube.parameters for strip in strips), strict=True)
        low, high = min(lows), max(highs)
        if all(strip.fold > 0 or strip.fold < 0 for strip in strips):
            walk, first, last = self.walk(), strips[0], strips[-1]
            with suppress(Undecided):
                ends = (
                    *walk.parameters_at(first.tube, first.begin),
                    *walk.parameters_at(last.tube, last.end),
                )
                return max(low, min(ends)), min(high, max(ends))
        return low, high

    def slender(self) -> Iterator[Strip]:
        """Yield the strips, cut into shorter ones that are easier to prove again.

        Each is narrow beside its length, and what is said of its stability far from being open, as
        far as few cuts lead.
        """
        walk = self.walk()
        for strip in self.strips:
            yield from walk.parts(strip, MOST_CUTS)


@dataclass(frozen=True)
class StripWalk:
    """A walk along a curve of orbits by floats, with a proof of each step.

    Attributes
    ----------
    scale
        Of each coordinate: the period, the greatest speed, and the range of the parameter.
    finest
        Width of strips, as a part of the scale, that is not divided any more.
    """

    equations: StripEquations
    scale: Vector
    finest: float

    @property
    def n(self) -> int:
        """Number of the parameter."""
        return len(self.scale) - 1

    def strips(self, rows: Sequence[Sequence[float]]) -> Iterator[Strip]:
        """Yield the strips from the first of some points to the last; see `chain_of`."""
        first, second, last = rows[0], rows[1], rows[-1]
        apart = (self._scaled(b, [arb(value) for value in a]) for a, b in pairwise(rows))
        left = MOST_LENGTH * (1.0 + sum(map(_norm, apart)))
        position = [arb(value) for value in first]
        direction = self._scaled(second, position)
        before: Tube | None = None
        end, step, held = Fraction(0), FIRST_STEP, 0
        phase = since = 0
        while True:
            along = self._coordinate(direction, other=phase == 1)
            size = exact_value(self.scale[along])
            forward = 1 if direction[along] > 0 else -1
            if before is None:
                near = Fraction(first[along])
            elif before.along == along:
                near = end
            else:
                # The curve goes on along another coordinate: from a little before its end.
                position = self.closer(before, end, position)
                edge = position[along].lower() if forward > 0 else position[along].upper()
                unit = forward * _dyadic(step * OVERLAP, size)
                near = unit * (math.floor(exact_value(edge) / unit) - 1)
            ahead = self._scaled(last, position)
            is_last = _norm(ahead) < ENOUGH * step and _dot(ahead, direction) > 0
            far = Fraction(last[along]) if is_last else near + forward * _dyadic(step, size)
            length = float(forward * (far - near) / size)
            if is_last and length < 2.0**-40:
                return
            guess = self._ahead(position, direction, along, (near + far) / 2)
            try:
                tube = self.tube(along, min(near, far), max(near, far), guess)
                if before is not None:
                    self._check_joined(before, end, position, tube)
                elif not tube.has_only(position):
                    self._refuse("first")
            except Undecided:
                step, held = length / 2, 0
                if length <= (LEAST_STEP if phase == 2 else NARROW):
                    if phase == 2:
                        raise
                    # Another coordinate is tried; then the first one, however narrow.
                    phase, step = phase + 1, (FIRST_STEP if phase == 0 else NARROW)
                    since = 0
                continue
            strip = self.proven(tube, far)
            if not strip.is_decided and length > self.finest:
                step, held = length / 2, 0
                continue
            if is_last and not tube.has_only([arb(value) for value in last]):
                self._refuse("last")
            yield strip
            if is_last:
                return
            left -= _norm(self._scaled([float(part) for part in tube.end(far)], position))
            if left < 0.0:
                self._refuse("last")
            before, end, position = tube, far, tube.end(far)
            direction = self._direction(tube, direction)
            since += 1
            if since > STAYING:
                phase = 0
            # Wider only after some of one width: a failure costs as much as a strip.
            held += 1
            step, held = (2 * length, 0) if held > PATIENCE else (length, held)

    def parts(self, strip: Strip, cuts: int) -> Iterator[Strip]:
        """Yield a strip, or parts of it that are slender or have been cut so many times."""
        tube = strip.tube
        halves: list[Tube] = []
        open_ = strip.stability != "undecided" and not strip.is_clear
        if cuts and (open_ or self.width_to_length(tube) > SLENDER):
            with suppress(Undecided):
                halves = self.halves(tube)
        if not halves:
            yield strip
        elif strip.end == tube.low:
            halves.reverse()
        for half in halves:
            end = half.high if strip.end == tube.high else half.low
            yield from self.parts(self.proven(half, end), cuts - 1)

    def halves(self, tube: Tube) -> list[Tube]:
        """Return the orbits of a tube as two; raise Undecided where they may be others."""
        middle, halves = (tube.low + tube.high) / 2, []
        for low, high in ((tube.low, middle), (middle, tube.high)):
            half = self.tube(tube.along, low, high, _mid(tube.end((low + high) / 2)))
            # What the boxes hold lies between straight lines, so that their ends decide.
            if not all(tube.has_only(half.end(value)) for value in (low, high)):
                raise Undecided("precision", "the orbits of a part of a strip may be others")
            halves.append(half)
        return halves

    def parameters_at(self, tube: Tube, value: Fraction) -> tuple[Fraction, Fraction]:
        """Return two numbers between which the parameter at a value of a tube's coordinate lies."""
        if tube.is_along_parameter:
            return value, value
        own = self.closer(tube, value, tube.end(value))[-1]
        return exact_value(own.lower()), exact_value(own.upper())

    def box_at(self, tube: Tube, parameter: Fraction) -> Vector | None:
        """Return a box with the orbits of a tube at a value of the parameter, None if it has none."""
        if not tube.may_have(parameter):
            return None
        if tube.is_along_parameter:
            return tube.end(parameter)
        parts = [tube]
        with suppress(Undecided):
            for _ in range(MOST_HALVINGS):
                halves = [half for part in parts for half in self.halves(part)]
                nearer = [half for half in halves if half.may_have(parameter)]
                if len(nearer) > MOST_PARTS:
                    break
                parts = nearer
        boxes = [part.box() for part in parts]
        return [reduce(arb.union, balls) for balls in zip(*boxes, strict=True)] if boxes else None

    def width_to_length(self, tube: Tube) -> float:
        """Return the width of a tube over its length, both in instants and velocities."""
        longest, widest = (
            max(float(abs(vector[i]) / self.scale[i]) for i in range(self.n))
            for vector in (tube.tangent, tube.trial)
        )
        return widest / (longest * float((tube.high - tube.low) / 2))

    @staticmethod
    def _refuse(which: str) -> None:
        raise Undecided("precision", f"the curve does not come to the {which} of the orbits")

    def closer(self, tube: Tube, end: Fraction, position: Vector) -> Vector:
        """Return a small box with the orbit at the end of a tube."""
        closer = self.tube(tube.along, end, end, position).end(end)
        if not tube.has_only(closer):
            raise Undecided("precision", "the orbit at the end of a strip may be another one")
        return closer

    def _check_joined(self, before: Tube, end: Fraction, position: Vector, tube: Tube) -> None:
        """Raise Undecided unless the orbit at the end of a tube is one of the next tube's."""
        if not (tube.has_only(position) or tube.has_only(self.closer(before, end, position))):
            raise Undecided("precision", "the orbits of one strip leave the next one")

    def _ahead(
        self, position: Vector, direction: list[float], along: int, value: Fraction
    ) -> Vector:
        """Return about where the curve has a value of a coordinate."""
        way = (ball(value) - position[along]) / (direction[along] * self.scale[along])
        return [
            (point + way * part * size).mid()
            for point, part, size in zip(position, direction, self.scale, strict=True)
        ]

    def _coordinate(self, direction: list[float], *, other: bool) -> int:
        """Return the coordinate along which a strip is best, or the next one."""
        sizes = [abs(part) for part in direction]
        steep = sizes[self.n] < STEEP * max(sizes)
        best, next_one = sizes.index(max(sizes[:-1])), self.n
        if not steep:
            best, next_one = next_one, best
        # Along a coordinate that hardly changes there is no strip.
        return next_one if other and sizes[next_one] > LEAST_STEP else best

    def _scaled(self, point: Sequence[float], origin: Vector) -> list[float]:
        """Return how far a point is from another, in units of the scales."""
        return [
            float((value - start.mid()) / size)
            for value, start, size in zip(point, origin, self.scale, strict=True)
        ]

    def _direction(self, tube: Tube, before: list[float]) -> list[float]:
        """Return the direction in which the curve goes on, of length 1."""
        parts = [float(part / size) for part, size in zip(tube.tangent, self.scale, strict=True)]
        length = math.copysign(_norm(parts), _dot(parts, before))
        return [part / length for part in parts]

    def corrected(self, u: Vector, along: int) -> tuple[Vector, list[list[arb]]]:
        """Return a point closer to the curve by a step of Newton's, and the derivative before it."""
        value = self.equations.value(u)
        rows = self.equations.derivative(u, checked=False)
        others, _ = split_along(rows, along)
        try:
            move = others.mid().solve(value.mid()).mid()
        except ZeroDivisionError:
            raise Undecided("precision", "the equations are singular") from None
        free = [i for i in range(self.n + 1) if i != along]
        better = list(u)
        for k, i in enumerate(free):
            better[i] = (u[i] - move[k, 0]).mid()
        return better, rows

    def tube(self, along: int, low: Fraction, high: Fraction, guess: Vector) -> Tube:
        """Return a proven tube; raise Undecided if it is too wide, or its orbits are singular."""
        centre = list(guess)
        centre[along] = ball((low + high) / 2).mid()
        centre, rows = self.corrected(centre, along)
        others, column = split_along(rows, along)
        try:
            inverse = others.mid().inv().mid()
        except ZeroDivisionError:
            raise Undecided("precision", "the equations are singular") from None
        slopes = (inverse * column).mid()
        free = [-slopes[k, 0] for k in range(self.n)]
        tangent = _with(free, along, arb(1))
        missed = inverse * self.equations.value(centre)
        whole = ball(low).union(ball(high))
        if along == self.n and low < high:
            # A restitution may be 1 at the end of a strip, and no more.
            self.equations.put(whole, low, high)
        half = ball((high - low) / 2)
        others_scale = [size for i, size in enumerate(self.scale) if i != along]
        sizes = [
            (FIRST_WIDTH * half * abs(slope))
            .max(2 * missed[k, 0].abs_upper())
            .max(others_scale[k] * 2 ** -(ctx.prec // 2))
            for k, slope in enumerate(free)
        ]
        unit = arb_mat([[arb(int(i == j)) for j in range(self.n)] for i in range(self.n)])
        for _ in range(TRIALS):
            trial = _with(sizes, along, arb(0))
            box = _around(along, whole, centre, tangent, trial)
            matrix, by_eta = split_along(self.equations.derivative(box), along)
            # How the tangent leaves the equations, and how they contract the box around it.
            drift = (
                inverse
                * (by_eta + matrix * arb_mat([[entry] for entry in free]))
                * (whole - centre[along])
            )
            moved = (unit - inverse * matrix) * arb_mat([[span(size)] for size in sizes])
            reached = [entry.abs_upper() for entry in (moved - missed - drift).entries()]
            if all(a < b for a, b in zip(reached, sizes, strict=True)):
                own = _with(reached, along, arb(0))
                return Tube(along, low, high, centre, tangent, own, trial)
            sizes = [(WIDER * a).max(b) for a, b in zip(reached, sizes, strict=True)]
        raise Undecided("precision", "no box was found that the equations map into itself")

    def proven(self, tube: Tube, end: Fraction) -> Strip:
        """Return the strip of a tube whose curve goes on at an end."""
        box = tube.box()
        equations, states = self.equations.at(box[-1]), pairs(box[:-1])
        half: arb | None = None
        if equations.mirrored:
            half = arb.nan()
            with suppress(Undecided):
                ((a, b), (c, d)), _ = derivative_over(equations, states)
                half = (1 - a) * (1 - d) - b * c
            equations, states = equations.whole(states)
        trace = determinant = arb.nan()
        stability, keeps_areas = "undecided", False
        with suppress(Undecided):
            monodromy, _ = monodromy_of(equations, states)
            trace, determinant = monodromy.trace, monodromy.determinant
            stability, keeps_areas = monodromy.stability, monodromy.conservative
        admissible = admissible_of(equations, states)[0]
        return Strip(tube, end, trace, determinant, stability, admissible, half, keeps_areas)


def _mid(box: Vector) -> Vector:
    return [part.mid() for part in box]


def _dyadic(step: float, size: Fraction) -> Fraction:
    """Return a part of a size as a number that the working precision holds."""
    return Fraction(math.ldexp(1.0, math.frexp(0.75 * step)[1])) * size


def _dot(one: list[float], other: list[float]) -> float:
    return sum(a * b for a, b in zip(one, other, strict=True))


def _norm(vector: list[float]) -> float:
    return math.sqrt(_dot(vector, vector))


def chain_of(
    curve: OrbitCurve,
    rows: Sequence[Sequence[float]],
    scale: Sequence[float],
    finest: float,
    go_on: Callable[[float], bool],
) -> StripChain:
    """Return strips of the curve from the first to the last of some points, as far as they lead.

    Parameters
    ----------
    rows
        Floats of the orbits' instants and velocities, and of the parameter, at points in order.
    scale
        Of each coordinate.
    finest
        Width of strips, as a part of the scales, that are not divided any more.
    go_on
        Called with the parameter after each strip; stops the chain by returning False.
    """
    chain = StripChain(curve, [arb(size) for size in scale])
    walk = StripWalk(StripEquations(curve), chain.scale, finest)
    try:
        for strip in walk.strips(rows):
            chain.strips.append(strip)
            if not go_on(float(strip.tube.middle[-1])):
                chain.reason = STOPPED
                break
    except Undecided as question:
        chain.reason = question.reason or question.kind
    return chain
