"""Whether the flights of an orbit meet nothing before their ends."""

from __future__ import annotations

from flint import arb, ctx

from percuss.certified.chain import Link
from percuss.certified.law import coarse_bits
from percuss.certified.numbers import precision
from percuss.certified.shooting import Shooting, States
from percuss.certified.step import flight_of, levels_of, search_along, width_of
from percuss.certified.undecided import Undecided

__all__ = ["admissible_of"]


def admissible_of(equations: Shooting, states: States) -> tuple[bool | None, str]:
    """Tell whether each flight of an orbit meets its event first; None where that stays open.

    One flight that does not is enough, whatever is open of the others.
    """
    n, open_ = len(states), ""
    for i, state in enumerate(states):
        following = (i + 1) % n
        until = states[following][0] + (equations.period if following == 0 else arb(0))
        # Of half an orbit, the chain is all of it.
        link = equations.chain[(i + 1) % len(equations.chain)]
        try:
            first = _meets_first(equations, i, state, until - state[0], link)
        except Undecided as question:
            open_ = open_ or f"flight {i}: {question.reason}"
            continue
        if not first:
            return False, f"flight {i} passes through a stop before its end"
    return (None, open_) if open_ else (True, "")


def _meets_first(
    equations: Shooting, i: int, state: tuple[arb, arb], s: arb, following: Link
) -> bool:
    """Tell whether the first event of a flight is the next one of the orbit."""
    system = equations.system
    start = equations.departure(i, state)
    into = 1 if system.regions[start.region].lower == start.bound else -1
    if into * state[1] < 0:
        return False
    tries = sorted({coarse_bits(system), ctx.prec})
    for coarse in tries:
        with precision(coarse):
            flight = flight_of(system, start, whole=True)
            levels = levels_of(system, start.region)
            width = width_of(system, flight)
            search = search_along(system, flight, levels, start.bound, 1, width)
            try:
                bracket = search.first(2.0 * float(s.upper()))
            except Undecided:
                if coarse == tries[-1]:
                    raise
                continue
            if bracket is None:
                raise Undecided("precision", "no event was found where the orbit has one")
            where = bracket.place_of(s)
            if where == 0 and bracket.level.bound == following.bound:
                return True
            if where == 1:
                return False
            raise Undecided("graze", "another event lies within the radius of the orbit's")
    raise Undecided("graze", "a turning point touches a stop within the radius")
