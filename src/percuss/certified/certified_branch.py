"""A certified branch: stretches of orbits that are proven whole, and what lies between them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain, groupby, pairwise

import numpy as np

from percuss.arrays import Floats
from percuss.certified.ball_arithmetic import Ball, Balls, Undecided
from percuss.certified.fold import OrbitCurve
from percuss.certified.graze_end import GrazeEnd, graze_at_end
from percuss.certified.numbers import ball, precision
from percuss.certified.results import doubles_of, in_words
from percuss.certified.shooting import OrbitEvent, events_of, guess_of, pairs, vector_of
from percuss.certified.special import check_mirrored, check_symmetric_over
from percuss.certified.strips import STOPPED, Strip, StripChain, chain_of
from percuss.certified.system import system_of
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_fraction
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.paths import long_form
from percuss.model.system import System
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.progress import Progress, Report

# What leads from the begin and from the end of a chain to a graze.
GrazeEnds = tuple[GrazeEnd | None, GrazeEnd | None]
BITS = 96
# Width of strips that are not divided any more, as a part of the range of the parameter and of the
# period and the greatest speed: as far as to this, special points are told apart.
FINEST = 2.0**-20
# Halves of an orbit of floats are each other's images to this part of the period and the speed.
SAME = 1e-6


@dataclass(frozen=True, slots=True)
class BranchStretch:
    """Orbits on a smooth curve, one after the other, of which the same holds.

    Attributes
    ----------
    low, high
        All of their parameters lie between these, which are those of its ends where the stability
        is decided; next to a fold or a graze they may lie a little beyond.
    stability
        "asymptotic", "elliptic", "parabolic", "unstable", or "undecided": of all of them.
    admissible
        Whether each passes through no stop: True and False are proven, None is open.
    n_strips
        The strips of its proof.
    joined
        Whether the curve is proven to go on from the stretch before.
    """

    low: float
    high: float
    stability: str
    admissible: bool | None
    n_strips: int
    joined: bool


@dataclass(frozen=True, slots=True)
class EnclosedPoint:
    """A special point that is proven to lie on the curve, between two stretches.

    Attributes
    ----------
    kind
        "period_doubling", "fold", "symmetry_breaking" or "grazing".
    value
        A ball that holds its parameter.
    statement
        What is proven, in words.
    """

    kind: str
    value: Ball
    statement: str


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedBranch:
    """A branch of periodic orbits that is proven whole; made by `certify`.

    Along each stretch there is exactly one orbit near each of those that were given: the curve of
    orbits is smooth, has no gap and no second curve beside it. Each stretch that is `joined` goes
    on from the one before.

    Attributes
    ----------
    oscillator, forcing
        The exact values that the proof is about, but for the parameter.
    path
        The parameter.
    stretches
        In order along the branch.
    special_points
        Those that are proven to lie on it, in order; several of one kind within a ball count as
        one.
    complete
        Whether the proof goes from the first orbit of the branch to the last without a gap.
    reason
        What is open, and why.
    precision
        The bits that were worked with.
    chains, grazes
        What the proof is made of: strips, and for each chain what leads from its begin and from its
        end to a graze, or None.
    """

    oscillator: Oscillator
    forcing: Forcing | None
    path: str
    stretches: tuple[BranchStretch, ...]
    special_points: tuple[EnclosedPoint, ...]
    complete: bool
    reason: str
    precision: int
    chains: tuple[StripChain, ...] = field(repr=False)
    grazes: tuple[GrazeEnds, ...] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of strips."""
        return sum(1 for _ in self._strips())

    def _strips(self) -> Iterator[Strip]:
        return chain.from_iterable(part.strips for part in self.chains)

    def events_at(self, value: Exact) -> list[tuple[Balls, Balls]]:
        """Return instants and velocities after the events of the orbits at a value of the parameter.

        Parameters
        ----------
        value
            The parameter, taken exactly.

        Returns
        -------
        list of (Balls, Balls)
            One for each strip that may have an orbit there: of orbits of one curve that pass a
            value twice, as at a fold, both; at the end of a strip that of the next one as well.

        Raises
        ------
        ParameterError
            If no strip has an orbit there.

        Examples
        --------
        >>> import percuss as pc
        >>> orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
        >>> branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.6)})
        >>> ((t, v),) = pc.certify(branch).events_at("2.505")
        >>> round(float(v.mid()[0]), 2), bool(v.radius()[0] < 0.01)
        (0.51, True)
        """
        at, enclosures = as_fraction(value), []
        with precision(self.precision):
            for part, ends in zip(self.chains, self.grazes, strict=True):
                walk = part.walk()
                boxes = [walk.box_at(strip.tube, at) for strip in part.strips]
                boxes += [
                    tube.box()
                    for end in ends if end is not None
                    for tube in end.tubes if tube.may_have(at)
                ]  # fmt: skip
                for box in boxes:
                    if box is not None:
                        equations = part.curve.equations(box[-1])
                        states = vector_of(equations.whole(pairs(box[:-1]))[1])
                        enclosures.append((Balls.of(states[::2]), Balls.of(states[1::2])))
        if not enclosures:
            known = ", ".join(f"{s.low:.9g} to {s.high:.9g}" for s in self.stretches) or "nothing"
            raise ParameterError("value", value, f"no strip has an orbit there; proven is {known}")
        return enclosures

    @property
    def system(self) -> System:
        """The oscillator and the forcing together."""
        return System(self.oscillator, self.forcing)

    def outlines(self) -> list[tuple[Floats, str, bool | None]]:
        """Return what each strip encloses, as floats for pictures.

        Returns
        -------
        list of (array, str, bool or None)
            The corners of a quadrangle that holds the parameter and the velocity after the first
            event of all orbits of the strip, (4, 2), their stability, and whether they are
            admissible; in order, those next to grazes last.
        """
        strips = []
        grazing = [end for end in chain.from_iterable(self.grazes) if end is not None]
        tubes = [(strip.tube, strip.stability, strip.admissible) for strip in self._strips()]
        tubes += [(tube, end.stability, True) for end in grazing for tube in end.tubes]
        with precision(self.precision):
            for tube, stability, admissible in tubes:
                p, q = tube.parameters
                v, w = ((tube.end(value) if tube.is_along_parameter else tube.box())[1]
                        for value in (p, q))  # fmt: skip
                corners = [
                    (float(p), float(v.lower())), (float(q), float(w.lower())),
                    (float(q), float(w.upper())), (float(p), float(v.upper())),
                ]  # fmt: skip
                strips.append((np.array(corners), stability, admissible))
        return strips

    @property
    def doubles(self) -> tuple[str, ...]:
        """Numbers given as floats that are not the decimals they print as: taken as doubles."""
        return tuple(
            name for name in doubles_of(self.oscillator, self.forcing) if name != self.path
        )

    def __repr__(self) -> str:
        """Return in a line what is proven."""
        if not self.stretches:
            return f"<CertifiedBranch: nothing is proven; {self.reason}>"
        points = ", ".join(f"{p.kind} at {p.value.text(10)}" for p in self.special_points)
        low = min(stretch.low for stretch in self.stretches)
        high = max(stretch.high for stretch in self.stretches)
        whole = "from end to end" if self.complete else f"with gaps; {self.reason}"
        return (
            f"<CertifiedBranch: {self.path} from {low:.6g} to {high:.6g} in {len(self)} strips, "
            f"{whole}; on it: {points or 'no special points'}{in_words(self.doubles)}>"
        )


def certify_branch(branch: Branch, report: Report = None) -> CertifiedBranch:
    """Prove a branch; see `percuss.certify`."""
    first = branch.orbits[0]
    path = long_form(branch.path, first.oscillator, first.forcing)
    low, high = float(branch.values.min()), float(branch.values.max())
    chains: list[StripChain] = []
    grazes: list[GrazeEnds] = []
    reasons: list[str] = []
    progress = Progress(report, 0.0, "strips", is_bound=True)

    def tell(value: float) -> bool:
        return progress.advance(1, lambda: f"{path} = {value:.6g}")

    with precision(BITS):
        sections = list(_sections(branch, reasons))
        for number, (events, rows) in enumerate(sections):
            orbit = branch.orbits[rows[0]]
            mirrored = _is_mirrored(branch, events, rows, path)
            curve = OrbitCurve(system_of(first.oscillator, first.forcing), events,
                               orbit.n_periods, path, mirrored=mirrored)  # fmt: skip
            points = [_point(branch.orbits[row], float(branch.values[row])) for row in rows]
            if mirrored:
                # The states of half of each orbit, and the parameter.
                points = [[*point[: len(events)], point[-1]] for point in points]
            scale = _scale(orbit, points, high - low)
            begin = 0
            while begin + 1 < len(points) and not progress.is_stopped:
                walked = part = chain_of(curve, points[begin:], scale, FINEST, tell)
                after = None
                if part.strips:
                    # The ends of the branch itself are no grazes.
                    goes_on = bool(part.reason) or number + 1 < len(sections)
                    before = None
                    if begin or number:
                        part, before = _with_graze(part, branch, at_begin=True)
                    if goes_on:
                        part, after = _with_graze(part, branch, at_begin=False)
                    chains.append(part)
                    grazes.append((before, after))
                if not part.reason or (after is not None and after.holds(points[-1])):
                    break
                at, nearest = points[begin], begin
                if part.strips:
                    at = [float(value) for value in walked.strips[-1].tube.middle]
                    nearest = _nearest(points, at, scale)
                # Of the orbits next to one that is told of it goes without saying.
                if part.strips or begin == 0:
                    reasons.append(f"at {path} = {at[-1]:.9g}: {part.reason}")
                begin = max(begin, nearest) + 1
        if len(sections) > 1:
            reasons.append("the orbits have other events after a graze")
        stretches, special = _told(chains, grazes, path)
    progress.close()
    whole = len(chains) == 1 and not reasons
    return CertifiedBranch(
        oscillator=first.oscillator,
        forcing=first.forcing,
        path=path,
        stretches=stretches,
        special_points=special,
        complete=whole,
        reason="; ".join(dict.fromkeys(reasons)),
        precision=BITS,
        chains=tuple(chains),
        grazes=tuple(grazes),
    )


def _sections(branch: Branch, reasons: list[str]) -> Iterator[tuple[list[OrbitEvent], list[int]]]:
    """Yield the rows of the branch whose orbits have the same events, and these."""

    def events(row: int) -> tuple[OrbitEvent, ...] | str:
        orbit = branch.orbits[row]
        if math.isinf(orbit.n_impacts):
            return "orbits that stick have infinitely many impacts, their equations finitely many"
        if not len(orbit.itinerary):
            return "orbits without events are the linear response, in closed form"
        if not orbit.n_periods:
            return "the period of a limit cycle is an unknown"
        if not orbit.isolated:
            return "orbits of a family are not alone at a value of the parameter"
        try:
            return tuple(events_of(system_of(orbit.oscillator, orbit.forcing), orbit))
        except Undecided as question:
            return question.reason

    for sequence, rows in groupby(range(len(branch)), events):
        if isinstance(sequence, str):
            reasons.append(sequence)
        else:
            numbers = list(rows)
            if len(numbers) > 1:
                yield list(sequence), numbers
            else:
                reasons.append(f"the orbit of row {numbers[0]} alone has its events")


def _is_mirrored(branch: Branch, events: list[OrbitEvent], rows: list[int], path: str) -> bool:
    """Return whether orbits are symmetric, and a breaking of the symmetry lies among them."""
    if not any(point.kind == "symmetry_breaking" for point in branch.special_points):
        return False
    first = branch.orbits[rows[0]]
    system = system_of(first.oscillator, first.forcing)
    try:
        check_mirrored(system, events, first.n_periods)
        check_symmetric_over(system, path, as_fraction(float(branch.values[rows[0]])))
    except Undecided:
        return False
    return all(_mirrors_itself(branch.orbits[row]) for row in rows)


def _mirrors_itself(orbit: PeriodicOrbit) -> bool:
    """Return whether the second half of an orbit is the mirror image of the first, by floats."""
    states = [(float(t), float(v)) for t, v in guess_of(orbit)]
    half, fastest = len(states) // 2, max(abs(v) for _, v in states)
    return all(
        abs(u - t - orbit.period / 2) < SAME * orbit.period and abs(v + w) < SAME * fastest
        for (t, v), (u, w) in zip(states[:half], states[half:], strict=True)
    )


def _point(orbit: PeriodicOrbit, value: float) -> list[float]:
    return [*(float(entry) for entry in vector_of(guess_of(orbit))), value]


def _scale(orbit: PeriodicOrbit, points: Sequence[Sequence[float]], width: float) -> list[float]:
    fastest = max(abs(v) for point in points for v in point[1:-1:2])
    return [float(orbit.period), fastest] * ((len(points[0]) - 1) // 2) + [width]


def _nearest(points: Sequence[Sequence[float]], at: Sequence[float], scale: Sequence[float]) -> int:
    """Return the point that is nearest to another."""

    def distance(point: Sequence[float]) -> float:
        parts = zip(point, at, scale, strict=True)
        return sum(((value - own) / size) ** 2 for value, own, size in parts)

    return min(range(len(points)), key=lambda i: distance(points[i]))


def _with_graze(
    part: StripChain, branch: Branch, *, at_begin: bool
) -> tuple[StripChain, GrazeEnd | None]:
    """Return a chain and what is proven to lead from its end, or its begin, to a graze of the branch.

    Without the strips there whose orbits lie on that way as well, and of which the same is proven.
    """
    graze = _graze_of(part, branch, at_begin=at_begin)
    if graze is None:
        return part, None
    strips = part.strips[::-1] if at_begin else part.strips
    alike = 0
    while alike < len(strips) and (
        (strips[-1 - alike].stability, strips[-1 - alike].admissible) == (graze.stability, True)
    ):
        alike += 1
    while alike > 1:
        kept = strips[: len(strips) - alike + 1]
        shorter = dataclasses.replace(part, strips=kept[::-1] if at_begin else kept)
        longer = _graze_of(shorter, branch, at_begin=at_begin)
        if longer is not None and longer.stability == graze.stability:
            return shorter, longer
        alike //= 2
    return part, graze


def _graze_of(part: StripChain, branch: Branch, *, at_begin: bool) -> GrazeEnd | None:
    """Return what is proven to lead to a graze of a branch from the end of a chain, or its begin."""
    if part.reason == STOPPED or not part.strips[0 if at_begin else -1].admissible:
        return None
    if not any(point.kind == "grazing" for point in branch.special_points):
        return None
    within = float(branch.values.min()), float(branch.values.max())
    with suppress(Undecided):
        return graze_at_end(part, at_begin=at_begin, within=within)
    return None


def _to_graze(graze: GrazeEnd, *, joined: bool) -> tuple[BranchStretch, EnclosedPoint]:
    """Return the orbits next to a graze, and that."""
    low, high = graze.parameters
    stretch = BranchStretch(
        low=_outward(low, -math.inf),
        high=_outward(high, math.inf),
        stability=graze.stability,
        admissible=True,
        n_strips=len(graze.tubes),
        joined=joined,
    )
    reason = (
        "an impact loses its velocity on the curve, all orbits on the way are motions, and the one at "
        "its end touches the stop"
    )
    return stretch, EnclosedPoint("grazing", Ball(graze.value), reason)


def _told(
    chains: Sequence[StripChain], grazes: Sequence[GrazeEnds], path: str
) -> tuple[tuple[BranchStretch, ...], tuple[EnclosedPoint, ...]]:
    """Return the stretches of the same properties, and the special points between them."""
    stretches: list[BranchStretch] = []
    points: list[EnclosedPoint] = []
    for part, (first, last) in zip(chains, grazes, strict=True):
        if first is not None:
            stretch, point = _to_graze(first, joined=False)
            stretches.append(stretch)
            points.append(point)
        groups = [
            list(group) for _, group in groupby(part.strips, lambda s: (s.stability, s.admissible))
        ]
        for k, group in enumerate(groups):
            low, high = part.parameters(group)
            stretches.append(
                BranchStretch(
                    low=_outward(low, -math.inf),
                    high=_outward(high, math.inf),
                    stability=group[0].stability,
                    admissible=group[0].admissible,
                    n_strips=len(group),
                    joined=k > 0 or first is not None,
                )
            )
        decided = [k for k, group in enumerate(groups) if group[0].is_decided]
        for before, after in pairwise(decided):
            between = [strip for group in groups[before + 1 : after] for strip in group]
            ends = groups[before][-1], groups[after][0]
            points += list(_points(ends, between or list(ends), part, path))
        if last is not None:
            stretch, point = _to_graze(last, joined=True)
            stretches.append(stretch)
            points.append(point)
    return tuple(stretches), tuple(points)


def _outward(value: Fraction, side: float) -> float:
    """Return a float next to a number, not on its inner side."""
    nearest = float(value)
    inside = nearest > value if side < 0 else nearest < value
    return math.nextafter(nearest, side) if inside else nearest


def _points(
    ends: tuple[Strip, Strip], between: Sequence[Strip], part: StripChain, path: str
) -> Iterator[EnclosedPoint]:
    """Yield what is proven to lie between two strips of a curve."""
    low, high = part.parameters(between)
    value = Ball(ball(low).union(ball(high)))
    kinds = ends[0].points_before(ends[1])
    along = all(strip.tube.is_along_parameter for strip in (*ends, *between))
    if "period_doubling" in kinds:
        reason = "a multiplier goes through -1 on the curve, which is smooth"
        # No multiplier is 1 there, so that the index of the map done twice changes.
        reason += ": orbits of twice the period branch off" if along else ""
        yield EnclosedPoint("period_doubling", value, reason)
    if "fold" in kinds:
        reason = f"a multiplier goes through 1 on the curve, along which {path} is extremal"
        yield EnclosedPoint("fold", value, reason)
    if "symmetry_breaking" in kinds and along:
        reason = (
            "a multiplier of the map over half an orbit goes through -1 on a smooth curve of symmetric "
            "orbits: others without the symmetry branch off"
        )
        yield EnclosedPoint("symmetry_breaking", value, reason)
    if {end.admissible for end in ends} == {True, False}:
        yield EnclosedPoint(
            "grazing", value, "the orbits on one side of it are motions, on the other formal"
        )
