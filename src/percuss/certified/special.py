"""Special points of branches: what is certified of one, and the proof for each kind."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import cast

from flint import arb

from percuss.certified.ball_arithmetic import Ball, Undecided
from percuss.certified.branch import ParameterBranch, parameter_size, system_at
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
from percuss.orbits.bifurcations.special_points import TWO_FOLD, SpecialPoint
from percuss.orbits.orbit.symmetry import is_symmetric_system

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
        "infinitely many impacts accumulate next to it, and the equations of an orbit have finitely "
        "many"
    ),
    "border_collision": (
        "the derivative of the equations has two values there, one for an impact before the jump of "
        "the force and one after it, and no proof here takes both"
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
        Whether it is proven to exist.
    value
        The parameter; NaN if it is not proven.
    statement
        What is proven, in words.
    reason
        What is open, and why.
    wanted_digits, precision
        The digits that were asked for, and the bits that were worked with.
    is_formal
        Whether the orbit passes through a stop: what is proven is then a statement on the formal
        equations, not on a motion. True and False are proven, for all orbits over the ball; None
        is open, as at a graze, where no ball separates a touch from a passage.
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
        """Return in a line what is proven."""
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
    work = bits or min(most_bits, math.ceil(digits / math.log10(2)) + FIRST_MARGIN)

    value, admissible, statement, reason = arb.nan(), None, "", ""
    while True:
        try:
            with precision(work):
                value, admissible, statement = _proof(point, path, digits)
            break
        except Undecided as question:
            if bits is not None or work >= most_bits or question.kind in HOPELESS:
                reason = question.reason or question.kind
                if question.kind not in HOPELESS:
                    reason += f"; {digits} digits were tried with {work} bits"
                break
            work = min(most_bits, 2 * work)
    return CertifiedPoint(
        kind=point.kind,
        path=path,
        exists=not reason,
        value=Ball(value),
        statement=statement,
        reason=reason,
        wanted_digits=digits,
        precision=work,
        is_formal=None if admissible is None else not admissible,
        point=point,
    )


def _proof(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None, str]:
    """Return the parameter, whether the orbits are admissible, and what is proven."""
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
            + (
                ", and orbits of twice the period branch off"
                if point.kind == "period_doubling"
                else ""
            )
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
        return _coincident_stops(point, path, digits)
    reason = WITHOUT_PROOF.get(point.kind, f"no proof is known for a {point.kind}")
    raise Undecided("kind", reason)


def _coincident_stops(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None, str]:
    """Return the exact place of the stop to which the parameter moves another, and the statement."""
    orbit = point.orbit
    met = [orbit.oscillator.stops[i].at for i in set(orbit.sequence)]
    places = {as_fraction(at) for at in met if as_float(at) == point.value}
    # Where the orbit of the point, next to the coincidence, has the stop that is moved.
    moved = as_fraction(cast("Exact", get_parameter(orbit.oscillator, orbit.forcing, None, path)))
    others = places - {moved} or places
    if len(others) != 1:
        raise Undecided("kind", "which stops coincide is not known exactly")
    neighbour = certify_orbit(orbit, digits, 2**10, None)
    if not neighbour.exists:
        reason = f"the orbit next to the corner is not proven; {neighbour.reason}"
        raise Undecided("kind", reason)
    return (
        ball(others.pop()),
        neighbour.admissible,
        (
            "two stops that the orbit meets coincide there, exactly; the orbit that is proven is "
            f"the one at {float(moved):.17g}, next to it"
        ),
    )


def crossing_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which the trace passes its critical value.

    And whether the orbits at all values in it are admissible, None where that is open.
    """
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    events, guess, n_periods = half_of_doubled(point, system)

    def test_function(equations: Shooting, states: States) -> arb:
        monodromy, _ = monodromy_of(equations, states)
        if point.kind == "period_doubling":
            return 1 + monodromy.trace + monodromy.determinant
        if not monodromy.conservative:
            raise Undecided("precision", "a strong resonance is of conservative families only")
        # Third roots of 1 have trace -1, fourth roots 0.
        return 1 + monodromy.trace if "third" in point.detail else monodromy.trace

    equations = partial(Shooting.of, events=events, n_periods=n_periods)
    value = Fraction(point.value)
    branch = ParameterBranch(system, path, equations, parameter_size(point.orbit, path, value))
    return branch.enclosed_zero(test_function, value, guess, digits)


def half_of_doubled(
    point: SpecialPoint, system: BallSystem
) -> tuple[list[OrbitEvent], States, int]:
    """Return events, states and periods of a point's orbit: the one that doubles, not twice it."""
    orbit = point.orbit
    events, guess, n_periods = events_of(system, orbit), guess_of(orbit), orbit.n_periods
    if point.kind == "period_doubling" and TWO_FOLD in point.detail:
        # The double cover of the orbit that doubles.
        half = len(events) // 2
        events, guess, n_periods = events[:half], guess[:half], n_periods // 2
    return events, guess, n_periods


def symmetry_function(equations: Shooting, states: States) -> arb:
    """Return 1 + trace + determinant of the mirrored map over half an orbit."""
    ((a, b), (c, d)), _ = derivative_over(equations, states)
    return 1 + a + d + (a * d - b * c)


def symmetry_breaking_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which symmetric orbits lose their symmetry.

    And whether the orbits at all values in it are admissible, None where that is open.
    """
    orbit = point.orbit
    system = system_of(orbit.oscillator, orbit.forcing)
    events, value = events_of(system, orbit), Fraction(point.value)
    check_mirrored(system, events, orbit.n_periods)
    check_symmetric_over(system, path, value)
    equations = partial(Shooting.of, events=events, n_periods=orbit.n_periods, mirrored=True)
    branch = ParameterBranch(system, path, equations, parameter_size(orbit, path, value))
    guess = guess_of(orbit)[: len(events) // 2]
    return branch.enclosed_zero(symmetry_function, value, guess, digits)


def check_mirrored(system: BallSystem, events: list[OrbitEvent], n_periods: int) -> None:
    """Refuse an orbit whose events are not each other's mirror images."""
    half, odd = divmod(len(events), 2)
    bounds, regions = len(system.bounds) - 1, len(system.regions) - 1
    if odd or not half or n_periods % 2 == 0:
        raise Undecided("symmetry", "the events do not come in two mirrored halves")
    for event, partner in zip(events[:half], events[half:], strict=True):
        image = bounds - event.bound, regions - event.before, regions - event.after
        if image != (partner.bound, partner.before, partner.after):
            raise Undecided("symmetry", "the events do not come in two mirrored halves")


def check_symmetric_over(system: BallSystem, path: str, value: Fraction) -> None:
    """Refuse a parameter that breaks the symmetry itself: at three values of it, exactly."""
    for part in (Fraction(0), Fraction(1, 10**6), Fraction(-1, 10**6)):
        changed = system_at(system, path, value * (1 + part) if value else part)
        if not is_symmetric_system(changed.oscillator, changed.forcing):
            raise Undecided("symmetry", f"{path} takes the symmetry away from the system itself")
