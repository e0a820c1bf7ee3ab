"""Complete lists of periodic orbits: all with so many impacts in so many periods, proven."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import arb

from percuss.arrays import Floats
from percuss.certified.ball_arithmetic import Ball, Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.certify import certify
from percuss.certified.covering import ImpactSurface
from percuss.certified.numbers import ball, exact_range, precision
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.return_equations import Missed, ReturnEquations, SurfaceBox
from percuss.certified.set_flight import event_at
from percuss.certified.shooting import OrbitEvent
from percuss.certified.system import BallSystem, system_of
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.exact import Exact, whole
from percuss.model.force_record import refuse_record
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, stops_in_words
from percuss.model.periods import require_period
from percuss.motion.simulate import simulate
from percuss.orbits.finding.find import find_orbit
from percuss.progress import Progress, Report
from percuss.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

BITS = 64
# Boxes shorter than this part of the region along both sides are left open.
FINEST = 2.0**-26
# A box on which the derivative is known to this part of itself is close enough for Newton's method.
NARROW = 0.5
STEPS = 12
# Half-widths of boxes around a root, in units of a cycle and of the greatest speed: the first, and
# by how much each is wider than the last.
FIRST_HALF, WIDER, LARGEST_HALF = 1e-9, 4.0, 0.2
# Reasons of open boxes that are told.
MOST_REASONS = 3


class _Root(NamedTuple):
    """A box in which the equations have exactly one root, and about where that is."""

    box: SurfaceBox
    point: tuple[float, float]


class _BoxSearch:
    """Divides a region of the impact surface until each part is proven to have one root or none."""

    def __init__(self, equations: ReturnEquations, most_boxes: int) -> None:
        self.equations, self.most_boxes = equations, most_boxes
        period = equations.surface.period
        self.period = period
        self.scale = float(period.upper()), equations.fastest
        self.roots: list[_Root] = []
        self.open: list[tuple[SurfaceBox, str]] = []
        self.n_boxes = 0

    def run(self, region: SurfaceBox, progress: Progress) -> None:
        """Search a region."""
        stack, finest = [region], FINEST
        area = _area(region) or 1.0
        while stack:
            box = stack.pop()
            if self.n_boxes >= self.most_boxes or progress.is_stopped:
                self.open += [(part, "the boxes are spent") for part in (box, *stack)]
                return
            self.n_boxes += 1
            if self.n_boxes % 64 == 0:
                done = 1.0 - sum(_area(part) for part in stack) / area
                progress.advance(64, f"{100.0 * done:.1f} % of the region")
            rest, reason = self._without_roots(box)
            if rest is None:
                continue
            if self._is_small(rest, finest):
                self.open.append((rest, reason))
                continue
            stack += rest.halves(self.scale)

    def cycles(self, box: SurfaceBox) -> tuple[float, float, float, float]:
        """Return a box with cycles in place of instants, for pictures and tables."""
        period = self.scale[0]
        return box.t_low / period, box.t_high / period, box.v_low, box.v_high

    def _is_small(self, box: SurfaceBox, finest: float) -> bool:
        return bool(
            box.t_high - box.t_low < finest * self.scale[0]
            and box.v_high - box.v_low < finest * self.scale[1]
        )

    def _without_roots(self, box: SurfaceBox) -> tuple[SurfaceBox | None, str]:
        """Return the part of a box in which roots may be that are not known yet, None if none may."""
        if self._is_known(box):
            return None, ""
        if self.equations.excludes(box):
            return None, ""
        try:
            missed = self.equations.missed(box)
        except Undecided as question:
            return box, question.reason
        if missed is None or missed.has_no_root():
            return None, ""
        inverse = missed.inverse()
        if inverse is None:
            return box, "the equations are singular"
        inside = missed.krawczyk(inverse)
        rest = _part(box, missed, inside)
        if rest is None:
            return None, ""
        if self._contracts(missed, inverse) and self._finds_root(box):
            return (None, "") if self._is_known(rest) else (rest, "")
        return rest, "the equations are nearly singular"

    def _is_known(self, box: SurfaceBox) -> bool:
        return any(
            root.box.holds(box, turn * self.period) for root in self.roots for turn in (-1, 0, 1)
        )

    @staticmethod
    def _contracts(missed: Missed, inverse: object) -> bool:
        image = missed.krawczyk(inverse)  # type: ignore[arg-type]
        return all(
            ball.rad() < NARROW * size.rad()
            for ball, size in zip(image, missed.spread, strict=True)
        )

    def _finds_root(self, box: SurfaceBox) -> bool:
        """Look for a root next to a box, and prove that it is alone in one as large as may be."""
        point = _newton(self.equations, box.middle, self.scale)
        if point is None or self._is_known(_around(point, 0.0, self.scale)):
            return False
        best: SurfaceBox | None = None
        half = FIRST_HALF
        while half < LARGEST_HALF:
            trial = _around(point, half, self.scale)
            try:
                missed = self.equations.missed(trial)
                proven = missed is not None and missed.has_one_root()
            except Undecided:
                proven = False
            if proven:
                best = trial
            elif best is not None:
                break
            half *= WIDER
        if best is None:
            return False
        self.roots.append(_Root(best, point))
        return True


def _area(box: SurfaceBox) -> float:
    return (box.t_high - box.t_low) * (box.v_high - box.v_low)


def _around(point: tuple[float, float], half: float, scale: tuple[float, float]) -> SurfaceBox:
    (t, v), (t_half, v_half) = point, (half * scale[0], half * scale[1])
    return SurfaceBox(t - t_half, t + t_half, v - v_half, v + v_half)


def _part(box: SurfaceBox, missed: Missed, inside: tuple[arb, arb]) -> SurfaceBox | None:
    """Return the part of a box in a set around its middle, None where they have no common state."""
    ends = []
    for low, high, middle, ball_ in (
        (box.t_low, box.t_high, missed.middle[0], inside[0]),
        (box.v_low, box.v_high, missed.middle[1], inside[1]),
    ):
        place = middle + ball_
        if place < low or place > high:
            return None
        ends += [max(low, _down(place)), min(high, _up(place))]
    return SurfaceBox(*ends)


def _down(value: arb) -> float:
    return math.nextafter(float(value.lower()), -math.inf)


def _up(value: arb) -> float:
    return math.nextafter(float(value.upper()), math.inf)


def _newton(
    equations: ReturnEquations, point: tuple[float, float], scale: tuple[float, float]
) -> tuple[float, float] | None:
    """Return about where the equations have a root near a point, None if none is found."""
    for _ in range(STEPS):
        t, v = point
        try:
            missed = equations.missed(SurfaceBox(t, t, v, v), anyhow=True)
        except Undecided:
            return None
        inverse = None if missed is None else missed.inverse()
        if missed is None or inverse is None:
            return None
        (a, b), (c, d) = inverse
        x, y = missed.value
        dt, dv = float(a * x + b * y), float(c * x + d * y)
        if abs(dt) > 0.5 * scale[0] or abs(dv) > 0.5 * scale[1]:
            return None
        point = t - dt, v - dv
        if abs(dt) < 1e-14 * scale[0] and abs(dv) < 1e-14 * scale[1]:
            break
    return point


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CompleteList:
    """All periodic orbits with some impacts in some periods, proven; made by `list_orbits`.

    Where `complete` is True, every periodic motion of `periods` forcing periods that meets the stop
    `impacts` times, leaves all stops with the first of `speeds` at least and this one with the
    second at most, and has one of its impacts on it in the range of `cycle`, is one of `orbits` or,
    run through more than once, of `shorter`; and these exist. Where it is False, each motion that
    is missing has all of its impacts on the stop, as far as they lie in the range of `cycle`, in
    `open_boxes`.

    Attributes
    ----------
    oscillator, forcing
        The exact values that the proof is about.
    stop, impacts, periods
        The stop, how often an orbit meets it, and in how many forcing periods.
    speeds
        Least speed after any event, and greatest after an impact on the stop [length/time]. The
        first is the width of the band about the grazing set of which nothing is said.
    cycle
        The range of (t / period) mod 1 of an impact.
    orbits
        Certified orbits with these numbers, not less.
    shorter
        Certified orbits that have them when they are run through more than once.
    n_formal
        Number of solutions of the equations that are proven to pass through a stop: no orbits.
    boxes
        (n, 4) array, cycle_low, cycle_high, v_low, v_high of boxes in which exactly one solution is
        proven to be: one for each impact of each orbit in the region, and formal solutions.
    open_boxes
        (n, 4) array, boxes in which nothing is decided.
    n_boxes
        Number of boxes that were looked at.
    reason
        What is open, and why; empty if nothing is.
    """

    oscillator: Oscillator
    forcing: Forcing
    stop: int
    impacts: int
    periods: int
    speeds: tuple[float, float]
    cycle: tuple[float, float]
    orbits: tuple[CertifiedOrbit, ...]
    shorter: tuple[CertifiedOrbit, ...]
    n_formal: int
    boxes: Floats = field(repr=False)
    open_boxes: Floats = field(repr=False)
    n_boxes: int
    reason: str

    @property
    def complete(self) -> bool:
        """Whether the list is proven to be complete."""
        return not len(self.open_boxes)

    @property
    def open_part(self) -> float:
        """Part of the area of the region that is open."""
        low, high = self.speeds
        area = (self.cycle[1] - self.cycle[0]) * (high - low)
        a, b, c, d = self.open_boxes.T
        return float(((b - a) * (d - c)).sum() / area)

    def __len__(self) -> int:
        """Return the number of orbits."""
        return len(self.orbits)

    def __repr__(self) -> str:
        """Return in a line what is proven."""
        what = (
            f"{counted(len(self), 'orbit')} with {counted(self.impacts, 'impact')} in "
            f"{counted(self.periods, 'period')}"
        )
        low, high = self.speeds
        known = "all that there are" if self.complete else "perhaps not all"
        more = f", {len(self.shorter)} shorter" if self.shorter else ""
        open_ = "" if self.complete else f"; {len(self.open_boxes)} boxes are open: {self.reason}"
        return f"<CompleteList: {what}{more}, {known} with speeds {low:g} to {high:g}{open_}>"

    def to_pandas(self) -> DataFrame:
        """Return a row an orbit, in the order of `orbits`.

        Returns
        -------
        DataFrame
            ``cycle``, ``v_after`` of the first impact on the stop with their radii, ``stability``,
            ``trace``, ``determinant`` and ``min_impact_speed``.

        Examples
        --------
        >>> import percuss as pc
        >>> from percuss.certified import list_orbits
        >>> osc = pc.impact_oscillator("0.8")
        >>> orbits = list_orbits(osc, pc.cosine("2.5"), speeds=("0.1", 2))
        >>> orbits.to_pandas()[["cycle", "v_after", "stability"]].round(6)
              cycle   v_after   stability
        0  0.978364  0.516282  asymptotic
        """
        import pandas as pd

        return pd.DataFrame(self._columns())

    def to_xarray(self) -> Dataset:
        """Return the columns of `to_pandas` over ``orbit``, which `percuss.save_csv` writes."""
        import xarray

        columns = {name: ("orbit", np.array(column)) for name, column in self._columns().items()}
        return xarray.Dataset(columns)

    def _columns(self) -> dict[str, Sequence[object]]:
        rows = [self._first(orbit) for orbit in self.orbits]
        return {
            "cycle": [cycle.mid() for cycle, _ in rows],
            "cycle_radius": [cycle.radius() for cycle, _ in rows],
            "v_after": [v.mid() for _, v in rows],
            "v_after_radius": [v.radius() for _, v in rows],
            "stability": [orbit.stability for orbit in self.orbits],
            "trace": [orbit.trace.mid() for orbit in self.orbits],
            "determinant": [orbit.determinant.mid() for orbit in self.orbits],
            "min_impact_speed": [orbit.min_impact_speed.mid() for orbit in self.orbits],
        }

    def _first(self, orbit: CertifiedOrbit) -> tuple[Ball, Ball]:
        k = orbit.sequence.index(self.stop)
        return orbit.impacts.cycle[k], orbit.impacts.v_after[k]


def list_orbits(
    osc: Oscillator,
    force: Forcing,
    impacts: int = 1,
    periods: int = 1,
    *,
    speeds: tuple[Exact, Exact],
    cycle: tuple[Exact, Exact] = (0, 1),
    stop: int = 0,
    most_boxes: int = 200_000,
    progress: Report = None,
) -> CompleteList:
    """Find all periodic orbits with so many impacts in so many periods, and prove that they are all.

    A region of the impact surface is divided into boxes, until each is proven to hold exactly one
    solution of the equations of such orbits, by the operator of Krawczyk, or none, by an enclosure
    of where the motions from it are after these periods (docs/theory/certified.md, section 12).

    Parameters
    ----------
    osc, force
        The oscillator, and its forcing: harmonics with a common period.
    impacts
        Impacts on the stop in one round of the orbit, >= 1; others on other stops are not counted.
    periods
        Forcing periods of one round, >= 1.
    speeds
        The region: the least speed after any impact on any stop, entry or exit, above 0, and the
        greatest after an impact on the stop [length/time]. At a graze the map is not continuous;
        the band of slower impacts is left out.
    cycle
        Range of (t / period) mod 1 in which one of the impacts on the stop lies.
    stop
        Index of the stop.
    most_boxes
        Boxes that are looked at, at most; those that are left are open. A box takes about a
        millisecond.
    progress
        True shows a line on the error stream; a function ``(done, total) -> bool`` is called now
        and then, and ends the search by returning False.

    Returns
    -------
    CompleteList

    Raises
    ------
    ParameterError
        If the forcing has no period or a record, there is no such stop, or the region is empty or
        reaches to speed 0.
    MissingExtraError
        If python-flint is not installed.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.certified import list_orbits
    >>> orbits = list_orbits(pc.impact_oscillator("0.8"), pc.cosine("2.5"), speeds=("0.1", 2))
    >>> orbits.complete, len(orbits), orbits.orbits[0].stability
    (True, 1, 'asymptotic')
    """
    impacts, periods = whole("impacts", impacts, 1), whole("periods", periods, 1)
    most_boxes = whole("most_boxes", most_boxes, 1)
    system = system_of(osc, force)
    require_period(force, "a list of orbits needs a periodic forcing")
    refuse_record(force, "a list of orbits")
    event = _event_of(system, osc, stop)
    low, high = exact_range("speeds", speeds)
    if not low > 0:
        reason = (
            "reaches to 0, where impacts graze and the map is not continuous; give a least speed "
        )
        raise ParameterError("speeds", speeds, f"{reason}above 0")
    begin, end = exact_range("cycle", cycle)
    if begin < 0 or end > 1:
        raise ParameterError("cycle", cycle, "not within 0 and 1")
    with precision(BITS):
        surface = ImpactSurface(system, event)
        slowest, fastest = _down(ball(low)), _up(ball(high))
        equations = ReturnEquations(surface, impacts, periods, slowest, fastest)
        period = surface.period
        v = (slowest, fastest) if equations.off > 0 else (-fastest, -slowest)
        region = SurfaceBox(_down(ball(begin) * period), _up(ball(end) * period), *v)
        search = _BoxSearch(equations, most_boxes)
        reported = Progress(progress, most_boxes, "boxes", is_bound=True)
        search.run(region, reported)
        reported.close()
    return _listed(search, osc, force, stop, ((low, high), (begin, end)))


def _event_of(system: BallSystem, osc: Oscillator, stop: int) -> OrbitEvent:
    """Return the event of an impact on a stop, or an entry into it."""
    if whole("stop", stop, 0) >= len(osc.stops):
        raise ParameterError("stop", stop, stops_in_words(osc))
    for number, bound in enumerate(system.bounds):
        if bound.wall == stop or stop in bound.edges:
            is_below = osc.stops[stop].side == "below"
            region = next(
                i
                for i, region in enumerate(system.regions)
                if (region.lower if is_below else region.upper) == number
            )
            return event_at(system, region, number, 1 if is_below else -1)
    raise ParameterError("stop", stop, "behind a wall, where no motion meets it")


def _listed(
    search: _BoxSearch,
    osc: Oscillator,
    force: Forcing,
    stop: int,
    region: tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]],
) -> CompleteList:
    """Return the list, with an orbit proven in each box that has a root."""
    equations, (low, high) = search.equations, region[0]
    left = list(search.roots)
    orbits: list[CertifiedOrbit] = []
    shorter: list[CertifiedOrbit] = []
    n_formal = 0
    while left:
        root = left[0]
        proof = _proof_of(search, osc, force, stop, root, left)
        if proof is None:
            search.open.append((root.box, "an orbit in a box is not proven"))
            left.remove(root)
            continue
        orbit, times_covered, others = proof
        left = [other for other in left if other not in others]
        if orbit.admissible is False:
            n_formal += 1
            continue
        inside = _is_inside(orbit, stop, low, high)
        if inside is None:
            search.open.append((root.box, "an orbit lies at the edge of the region"))
        elif inside:
            (orbits if times_covered == 1 else shorter).append(orbit)
    with precision(BITS):
        boxes = np.array([search.cycles(root.box) for root in search.roots]).reshape(-1, 4)
        open_boxes = np.array([search.cycles(box) for box, _ in search.open]).reshape(-1, 4)
    reasons = dict.fromkeys(reason for _, reason in search.open)
    return CompleteList(
        oscillator=osc,
        forcing=force,
        stop=stop,
        impacts=equations.impacts,
        periods=equations.periods,
        speeds=(float(low), float(high)),
        cycle=(float(region[1][0]), float(region[1][1])),
        orbits=tuple(orbits),
        shorter=tuple(shorter),
        n_formal=n_formal,
        boxes=boxes,
        open_boxes=open_boxes,
        n_boxes=search.n_boxes,
        reason="; ".join(list(reasons)[:MOST_REASONS]),
    )


def _proof_of(
    search: _BoxSearch,
    osc: Oscillator,
    force: Forcing,
    stop: int,
    root: _Root,
    left: Sequence[_Root],
) -> tuple[CertifiedOrbit, int, list[_Root]] | None:
    """Return the orbit of a root with how often it is run through, and the roots of its events.

    None where it is not proven that a root is that of an orbit, or of a formal one.
    """
    equations = search.equations
    n, p = equations.impacts, equations.periods
    for times_covered in range(math.gcd(n, p), 0, -1):
        if n % times_covered or p % times_covered:
            continue
        orbit = _orbit_at(osc, force, stop, equations, root, times_covered)
        if orbit is None or not orbit.exists:
            continue
        others = _roots_of(search, orbit, stop, left)
        if root not in others:
            continue
        if orbit.admissible is False and times_covered == 1:
            # Which root is that of a formal orbit is another question than for a motion.
            with precision(orbit.precision):
                states = [state for _, state in orbit.events]
                k = next(i for i, state in enumerate(states) if _holds(search, root, state))
                later = law_of(equations.surface.system).period(p)
                turned = [*states[k:], *((t + later, v) for t, v in states[:k])]
                is_root = equations.are_solved_by(turned)
            return (orbit, 1, [root]) if is_root else None
        if orbit.admissible:
            return orbit, times_covered, others
    return None


def _orbit_at(
    osc: Oscillator,
    force: Forcing,
    stop: int,
    equations: ReturnEquations,
    root: _Root,
    times_covered: int,
) -> CertifiedOrbit | None:
    """Return the orbit of a root, certified; None if it is not found."""
    period = float(equations.surface.period)
    t, v = root.point
    n, p = equations.impacts // times_covered, equations.periods // times_covered
    sequence = None if equations.is_direct else _sequence(osc, force, stop, (t, v), p * period)
    number = n if sequence is None else len(sequence)
    try:
        guess = t / period % 1.0, v
        orbit = find_orbit(osc, force, number, p, sequence, guess, formal=True)
    except (ConvergenceError, ParameterError):
        return None
    return certify(orbit)


def _sequence(
    osc: Oscillator, force: Forcing, stop: int, state: tuple[float, float], duration: float
) -> list[int]:
    """Return the stops that a motion from a stop meets in some time, by floats; this one first."""
    t, v = state
    end = t + duration * (1.0 + 1e-6)
    run = simulate(osc, force, x0=osc.stops[stop].at, v0=v, t0=t, t_end=end)
    crossings = run.crossings
    entries = [*zip(run.impacts.t.tolist(), run.impacts.stop.tolist(), strict=True)]
    entries += [
        (at, number)
        for at, number, direction in zip(
            crossings.t.tolist(), crossings.stop.tolist(), crossings.direction, strict=True
        )
        if direction == "in" and at > t + 1e-9 * duration
    ]
    return [stop, *(number for _, number in sorted(entries)[:-1])]


def _roots_of(
    search: _BoxSearch, orbit: CertifiedOrbit, stop: int, roots: Sequence[_Root]
) -> list[_Root]:
    """Return the roots whose boxes hold an event of an orbit that is proven."""
    if not orbit.exists:
        return []
    with precision(orbit.precision):
        states = [state for event, state in orbit.events if event.stop == stop]
        return [root for root in roots if any(_holds(search, root, state) for state in states)]


def _holds(search: _BoxSearch, root: _Root, state: tuple[arb, arb]) -> bool:
    """Return whether a state lies in the box of a root, whole periods earlier or later or not."""
    period = search.equations.surface.period
    return root.box.holds_state(*_near(root.point[0], state, period))


def _near(t: float, state: tuple[arb, arb], period: arb) -> tuple[arb, arb]:
    """Return an instant and velocity, whole periods earlier or later, so that it is near another."""
    return state[0] - round(float((state[0] - t) / period)) * period, state[1]


def _is_inside(orbit: CertifiedOrbit, stop: int, low: Fraction, high: Fraction) -> bool | None:
    """Return whether all speeds of an orbit lie in the range; None where that is open."""
    inside: bool | None = True
    with precision(orbit.precision):
        for event, (_, v) in orbit.events:
            speed, is_on_stop = abs(v), event.stop == stop
            if speed < ball(low) or (is_on_stop and speed > ball(high)):
                return False
            if not (speed > ball(low) and (not is_on_stop or speed < ball(high))):
                inside = None
    return inside
