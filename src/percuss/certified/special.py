"""Special points of branches: what is certified of one, and the proof for each kind."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import cast

from flint import arb

from percuss.certified.balls import Ball, Undecided
from percuss.certified.branch import ParameterBranch, system_at
from percuss.certified.fold import fold_of
from percuss.certified.grazing import grazing_of
from percuss.certified.numbers import ball, precision
from percuss.certified.orbits import certify_orbit
from percuss.certified.properties import monodromy_of
from percuss.certified.shooting import (
    OrbitEvent,
    Shooting,
    States,
    derivative_over,
    events_of,
    guess_of,
)
from percuss.certified.system import BallSystem, system_of
from percuss.model.exact import Exact, as_float, as_fraction
from percuss.model.paths import get_parameter, long_form
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.orbit.symmetry import is_symmetric_system

__all__ = [
    "CertifiedPoint",
    "certify_point",
    "crossing_of",
    "symmetry_breaking_of",
    "symmetry_function",
]

# Bits beyond the digits asked for at the first attempt.
FIRST_MARGIN = 80
# Questions that no bits answer.
HOPELESS = ("kind", "symmetry")
WITHOUT_PROOF = {
    "branch_point": (
        "branches that cross without a symmetry part under an arbitrarily small change of any "
        "number, so that no ball, which holds such changes, can prove that they cross"
    ),
    "chatter": (
        "infinitely many impacts accumulate beside it, and the equations of an orbit are of "
        "finitely many"
    ),
}


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class CertifiedPoint:
    """A special point whose parameter is enclosed; made by `certify`.

    Attributes
    ----------
    kind, path
        Those of the point.
    exists
        Whether it is proven to be there.
    value
        The parameter: without a number if it is not proven.
    statement
        What is proven, in words.
    reason
        What is open, and why.
    wanted_digits, precision
        The digits that were asked for, and the bits that were worked with.
    is_formal
        Whether the orbit there passes through a stop: then what is proven is about the formal
        equations, no motion. True and False are proven, of all orbits over the ball; None is open,
        as at a graze, where no ball tells a touch from a passage.
    """

    kind: str
    path: str
    exists: bool
    value: Ball
    statement: str
    reason: str
    wanted_digits: int
    precision: int
    is_formal: bool | None
    point: SpecialPoint = field(repr=False)

    def __repr__(self) -> str:
        """Tell in a line what is proven."""
        if not self.exists:
            return f"<CertifiedPoint: {self.kind} not proven; {self.reason}>"
        formal = {
            True: "; formal, the orbit passes through a stop",
            False: "",
            None: "; whether the orbit passes through a stop is open",
        }[self.is_formal]
        return f"<CertifiedPoint: {self.kind} at {self.path} = {self.value.text()}{formal}>"


def certify_point(
    point: SpecialPoint, digits: int, most_bits: int, bits: int | None
) -> CertifiedPoint:
    """Prove a special point; see `percuss.certify`."""
    path = long_form(point.path, point.orbit.oscillator, point.orbit.forcing)
    work = bits or math.ceil(digits / math.log10(2)) + FIRST_MARGIN

    def told(
        value: Ball, statement: str, reason: str, admissible: bool | None = None
    ) -> CertifiedPoint:
        exists = not reason
        formal = None if admissible is None else not admissible
        return CertifiedPoint(
            point.kind, path, exists, value, statement, reason, digits, work, formal, point
        )

    while True:
        try:
            with precision(work):
                value, admissible, statement = _proof(point, path, digits)
        except Undecided as question:
            if bits is not None or 2 * work > most_bits or question.kind in HOPELESS:
                return told(Ball(arb.nan()), "", question.reason or question.kind)
            work *= 2
            continue
        return told(Ball(value), statement, "", admissible)


def _proof(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None, str]:
    """Return the parameter, whether the orbits there pass through no stop, and what is proven."""
    if math.isinf(point.orbit.n_impacts):
        reason = "the orbit sticks: it has infinitely many impacts, its equations finitely many"
        raise Undecided("kind", reason)
    if point.kind == "fold":
        return *fold_of(point, path, digits), (
            "on a smooth curve of orbits, along which the parameter is extremal in the ball, a "
            "multiplier goes through 1 there"
        )
    if point.kind in ("period_doubling", "strong_resonance"):
        return *crossing_of(point, path, digits), (
            "on a smooth branch of orbits over the ball, the trace goes through the value of a "
            f"{point.kind.replace('_', ' ')} there"
        )
    if point.kind == "symmetry_breaking":
        return *symmetry_breaking_of(point, path, digits), (
            "on a smooth branch of symmetric orbits over the ball, a multiplier of the map over "
            "half of them goes through -1 there, and orbits without the symmetry branch off"
        )
    if point.kind == "grazing":
        return *grazing_of(point, path, digits), (
            "on a smooth branch of orbits over the ball, a turning point passes the stop there"
        )
    if point.kind == "corner":
        return _corner(point, path, digits)
    reason = WITHOUT_PROOF.get(point.kind, f"no proof is known for a {point.kind}")
    raise Undecided("kind", reason)


def _corner(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None, str]:
    """Return the place of the stop that another is moved to, exactly, and what is proven beside."""
    orbit = point.orbit
    met = [orbit.oscillator.stops[i].at for i in set(orbit.sequence)]
    places = {as_fraction(at) for at in met if as_float(at) == point.value}
    moved = as_fraction(_place(point, path))
    others = places - {moved} or places
    if len(others) != 1:
        raise Undecided("kind", "which stops come to lie at one place is not told exactly")
    beside = certify_orbit(orbit, digits, 2**10, None)
    if not beside.exists:
        raise Undecided("kind", f"the orbit beside the corner is not proven; {beside.reason}")
    return (
        ball(others.pop()),
        beside.admissible,
        (
            "two stops that the orbit meets lie at one place there, exactly; what is proven of the "
            f"orbits is the one at {float(moved):.17g}, beside it"
        ),
    )


def _place(point: SpecialPoint, path: str) -> Exact:
    """Return the position of the stop that the parameter moves, as the orbit beside has it."""
    value = get_parameter(point.orbit.oscillator, point.orbit.forcing, None, path)
    return cast("Exact", value)


def crossing_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which the trace passes its critical value.

    And whether the orbits at all values in it are admissible, None where that is open.
    """
    orbit = point.orbit
    system = system_of(orbit.oscillator, orbit.forcing)
    events, guess, n_periods = events_of(system, orbit), guess_of(orbit), orbit.n_periods
    if point.kind == "period_doubling" and "twice" in point.detail:
        # The double cover of the orbit that doubles.
        half = len(events) // 2
        events, guess, n_periods = events[:half], guess[:half], n_periods // 2

    def test_function(equations: Shooting, states: States) -> arb:
        monodromy, _ = monodromy_of(equations, states)
        if point.kind == "period_doubling":
            return 1 + monodromy.trace + monodromy.determinant
        if not monodromy.conservative:
            raise Undecided("precision", "a strong resonance is of conservative families only")
        # Third roots of 1 have trace -1, fourth roots 0.
        return 1 + monodromy.trace if "third" in point.detail else monodromy.trace

    branch = ParameterBranch(system, path, partial(Shooting.of, events=events, n_periods=n_periods))
    return branch.enclosed_zero(test_function, Fraction(point.value), guess, digits)


def symmetry_function(equations: Shooting, states: States) -> arb:
    """Return 1 + trace + determinant of the mirrored map over half an orbit.

    Raises
    ------
    Undecided
        If the flights' roots may be others than the events of the orbit.
    """
    ((a, b), (c, d)), _ = derivative_over(equations, states)
    return 1 + a + d + (a * d - b * c)


def symmetry_breaking_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which symmetric orbits lose their symmetry.

    And whether the orbits at all values in it are admissible, None where that is open.
    """
    orbit = point.orbit
    system = system_of(orbit.oscillator, orbit.forcing)
    events, value = events_of(system, orbit), Fraction(point.value)
    _check_mirrored(system, events, orbit.n_periods)
    _check_parameter(system, path, value)
    equations = partial(Shooting.of, events=events, n_periods=orbit.n_periods, mirrored=True)
    branch = ParameterBranch(system, path, equations)
    guess = guess_of(orbit)[: len(events) // 2]
    return branch.enclosed_zero(symmetry_function, value, guess, digits)


def _check_mirrored(system: BallSystem, events: list[OrbitEvent], n_periods: int) -> None:
    """Refuse an orbit whose events are not each other's mirror images."""
    half, odd = divmod(len(events), 2)
    bounds, regions = len(system.bounds) - 1, len(system.regions) - 1
    if odd or not half or n_periods % 2 == 0:
        raise Undecided("symmetry", "the events do not come in two mirrored halves")
    for event, partner in zip(events[:half], events[half:], strict=True):
        image = bounds - event.bound, regions - event.before, regions - event.after
        if image != (partner.bound, partner.before, partner.after):
            raise Undecided("symmetry", "the events do not come in two mirrored halves")


def _check_parameter(system: BallSystem, path: str, value: Fraction) -> None:
    """Refuse a parameter that breaks the symmetry itself: at three values of it, exactly."""
    for part in (Fraction(0), Fraction(1, 10**6), Fraction(-1, 10**6)):
        there = system_at(system, path, value * (1 + part) if value else part)
        if not is_symmetric_system(there.oscillator, there.forcing):
            raise Undecided("symmetry", f"{path} takes the symmetry away from the system itself")
