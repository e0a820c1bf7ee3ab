"""Properties of an enclosed orbit: admissibility, multipliers, stability."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from flint import acb, arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import BallMatrix
from percuss.certified.numbers import largest_abs, precision, span
from percuss.certified.shooting import OrbitEvent, Shooting, States, derivative_over
from percuss.certified.step import (
    Departure,
    began,
    beyond,
    bracket_within,
    first_bracket,
    flight_of,
    state_in_flight,
)
from percuss.certified.system import BallSystem


@dataclass(frozen=True)
class Proof:
    """The proven properties of an orbit, at the working precision.

    Attributes
    ----------
    events, states, before
        The events, instants and velocities after them, and velocities before.
    period
        Its duration.
    monodromy
        Its derivative.
    admissible
        Whether it passes through no stop; None where that is open.
    isolated
        Whether no other orbit with these events is near.
    unique_within
        Part of period and speed within which it is proven to be the only one.
    reason
        What is open.
    start
        (x, v, t) of an orbit without events.
    """

    events: list[OrbitEvent]
    states: States
    before: list[arb]
    period: arb
    monodromy: Monodromy
    admissible: bool | None
    isolated: bool = True
    unique_within: float = 0.0
    reason: str = ""
    start: tuple[arb, arb, arb] | None = None
    sticking: bool = False

    def digits(self) -> float:
        """Return the fewest decimal digits of the events, as parts of the period and the speed."""
        with precision(64):
            fastest = max((abs(v) for _, v in self.states), key=float, default=arb(1))
            errors = [t.rad() / self.period for t, _ in self.states]
            errors += [v.rad() / fastest for _, v in self.states]
            if self.start is not None:
                x, v, _ = self.start
                errors += [x.rad() / abs(x).max(abs(v)), v.rad() / abs(v).max(abs(x))]
            worst = max((float(error.abs_upper()) for error in errors), default=0.0)
        return math.inf if worst == 0.0 else -math.log10(worst)


def admissible_of(equations: Shooting, states: States) -> tuple[bool | None, str]:
    """Return whether each flight of an orbit meets its event first; None where that stays open.

    One flight that does not is enough, whatever is open of the others.
    """
    open_ = ""
    for i in range(len(states)):
        try:
            first = meets_first(equations, i, states)
        except Undecided as question:
            open_ = open_ or f"flight {i}: {question.reason}"
            continue
        if not first:
            return False, f"flight {i} passes through a stop before its end"
    return (None, open_) if open_ else (True, "")


def meets_first(equations: Shooting, i: int, states: States) -> bool:
    """Return whether the first event of a flight is the next one of the orbit."""
    system = equations.system
    pieces = [start for start, _ in equations.pieces_of_flight(i, states)]
    start = pieces[0]
    off = 1 if system.regions[start.region].lower == start.bound else -1
    v = states[i][1]
    # From rest the motion goes where the force points.
    away = flight_of(system, start, whole=True).a0 if v.is_zero() else v
    if off * away < 0:
        return False
    for piece, following in pairwise(pieces):
        assert following.moment is not None
        if not is_clear(system, piece, following.moment.t):
            return False
    start = pieces[-1]
    duration = equations.end_of_flight(i, states) - began(start, whole=True)
    bracket, _, coarse = first_bracket(system, start, 2.0 * float(duration.upper()))
    with precision(coarse):
        place = bracket.place_of(duration)
    if place == 0 and bracket.level.bound == equations.next_event(i).bound:
        return True
    if place == 1:
        return False
    raise Undecided("graze", "another event lies within the radius of the orbit's")


def is_clear(system: BallSystem, start: Departure, end: arb) -> bool:
    """Return whether all flights of a departure meet no bound up to an instant.

    Raises
    ------
    Undecided
        If the balls leave it open.
    """
    duration = end - began(start, whole=True)
    longest = largest_abs(duration)
    bracket, _, coarse = beyond(partial(bracket_within, system, start), longest, knot=True)
    if bracket is None:
        return True
    with precision(coarse):
        place = bracket.place_of(duration)
    if place == 0:
        # The one root in the bracket is after it where the flights have not met the bound yet.
        x, _ = state_in_flight(system, start, end)
        gap = bracket.level.sign * (x - law_of(system).places[bracket.level.bound])
        place = -1 if gap > 0 else 1 if gap < 0 else None
    if place is None:
        raise Undecided("graze", "an event lies within the radius of a knot of the record")
    return place < 0


@dataclass(frozen=True)
class Monodromy:
    """The derivative over one orbit.

    Attributes
    ----------
    trace, determinant
        Of instant and velocity after the first event, or of (x, v) without events; the determinant
        from its closed form.
    conservative
        Whether the determinant is 1 exactly.
    multipliers
        Its eigenvalues, the larger first where that is known.
    stability
        "asymptotic", "elliptic", "parabolic", "unstable" or "undecided".
    """

    trace: arb
    determinant: arb
    conservative: bool
    multipliers: tuple[acb, acb]
    stability: str

    @classmethod
    def of(cls, matrix: BallMatrix, determinant: arb, *, conservative: bool) -> Monodromy:
        """Return a derivative with its multipliers and stability."""
        trace = matrix[0][0] + matrix[1][1]
        multipliers = multipliers_of(trace, determinant)
        stability = stability_of(trace, determinant, conservative=conservative)
        return cls(trace, determinant, conservative, multipliers, stability)


def monodromy_of(equations: Shooting, states: States) -> tuple[Monodromy, list[arb]]:
    """Return the derivative over one orbit, and the velocities before the events.

    The determinant is that of the closed form: the product of r times the derivative of r v over
    the impacts, r^2 where r is one number, times exp(-2 integral of the damping).
    """
    matrix, images = derivative_over(equations, states)
    law = law_of(equations.system)
    conservative = True
    factor, decay = arb(1), arb(0)
    for i, event in enumerate(equations.events):
        if event.wall:
            # It takes areas of the phase plane times r and times the derivative of r v.
            _, r, kept, _ = event.passed(equations.system, images[i - 1].v_before)
            factor = factor * r * kept
            conservative = conservative and r == 1 and kept == 1
        region = law.regions[event.after]
        if region.dashpot:
            conservative = False
            duration = equations.end_of_flight(i, states) - states[i][0]
            decay = decay + region.damping * duration
    determinant = factor if decay.is_zero() else factor * (-2 * decay).exp()
    monodromy = Monodromy.of(matrix, determinant, conservative=conservative)
    # The last flight leads to the first event.
    before = [image.v_before for image in images]
    return monodromy, [before[-1], *before[:-1]]


def multipliers_of(trace: arb, determinant: arb) -> tuple[acb, acb]:
    """Return the roots of z^2 - trace z + determinant.

    Examples
    --------
    >>> [str(value.real) for value in multipliers_of(arb(5), arb(4))]
    ['4.00000000000000', '1.00000000000000']
    """
    if determinant.is_zero() or not trace.is_finite():
        return acb(trace), acb(determinant)
    half = trace / 2
    inside = half * half - determinant
    if inside < 0:
        turn = (-inside).sqrt()
        return acb(half, turn), acb(half, -turn)
    root = acb(inside).sqrt()
    if not inside > 0:
        # Whether real, equal or a complex pair, they lie in the square.
        size = span(inside.abs_upper().sqrt())
        return acb(half + size, size), acb(half + size, size)
    first = acb(half) - root if half < 0 else acb(half) + root
    return first, acb(determinant) / first


def stability_of(trace: arb, determinant: arb, *, conservative: bool) -> str:
    """Return the stability that trace and determinant prove.

    Examples
    --------
    >>> stability_of(arb(1), arb("0.5"), conservative=False)
    'asymptotic'
    >>> stability_of(arb(2), arb(1), conservative=True)
    'undecided'
    """
    edge = 1 + determinant
    if abs(trace) > edge or determinant > 1:
        return "unstable"
    if abs(trace) < edge:
        if conservative:
            return "elliptic"
        if abs(determinant) < 1:
            return "asymptotic"
    return "undecided"
