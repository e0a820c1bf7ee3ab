"""Motions whose impact times are Y_m = {0, m pi, (m+1) pi, (2m+1) pi, ...}, exactly and for ever.

Under the force of `percuss.subset_forcing`, with its constant cos(pi/(m+1)) exactly, every
A sin t - cos((2t + pi)/(m+1)) + cos(pi/(m+1)) solves the equation and is zero on Y_m. A long
flight that leaves with V leaves m pi with 2q - V for even m, with V for odd m, where
q = 2/(m+1) sin(pi/(m+1)); so does the short flight after it (m+1) pi (Dyskin et al. 2012,
eqs. 10 to 14, as corrected in docs/theory/paper-family.md). So two flights decide for odd m, four
for even m: whether a root comes before. The search for it is in balls that hold the constant.
"""

from __future__ import annotations

import math

from flint import arb

from percuss.certified.balls import Ball
from percuss.certified.cloud import Cloud
from percuss.certified.numbers import ball, precision
from percuss.certified.ranges import system_for
from percuss.certified.reflections import first_impact
from percuss.certified.statements import BITS, Verdict
from percuss.certified.step import Departure
from percuss.certified.system import System, system_of
from percuss.certified.undecided import Undecided
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_fraction
from percuss.model.oscillator import impact_oscillator
from percuss.motion.eigenset_forms import subset_forcing

__all__ = ["keeps_subset"]

# Of the constant: far narrower than what the search can tell.
CONSTANT_BITS = 4 * BITS


def keeps_subset(m: int, v0: Exact) -> Verdict:
    """Tell whether the impacts of a start at t = 0 on the wall are those of Y_m, all of them.

    The oscillator is ``impact_oscillator()``, the force that of `percuss.subset_forcing` with
    its constant taken exactly, which in the model is a double.

    Parameters
    ----------
    m
        The longer gap in units of pi, >= 2.
    v0
        Velocity at the start [length/time], > 0.

    Returns
    -------
    Verdict
        For all impacts; open where the balls do not decide, as at the critical velocity itself.

    Raises
    ------
    ParameterError
        If m is not a whole number of at least 2, or v0 is negative.

    Examples
    --------
    The critical velocity for m = 5 is 3/2 (Dyskin et al. 2012, table 1):

    >>> [keeps_subset(5, v0).holds for v0 in ("1.4999999", "1.5000001")]
    [True, False]
    """
    force, start = subset_forcing(m), as_fraction(v0)
    if start < 0:
        raise ParameterError("v0", v0, "negative: into the wall")
    system = system_of(impact_oscillator(), force)
    with precision(CONSTANT_BITS):
        constant = Ball((arb.pi() / (m + 1)).cos())
    exact = system_for(system, {"forcing.constant": constant})
    try:
        with precision(BITS):
            return _verdict(exact, m, ball(start))
    except Undecided as question:
        return Verdict(None, math.inf, question.reason)


def _verdict(system: System, m: int, v0: arb) -> Verdict:
    pi = arb.pi()
    kick = 2 * (pi / (m + 1)).sin() / (m + 1)
    following = 2 * kick - v0 if m % 2 == 0 else v0
    # Long flights begin at 0, short ones at m pi, modulo the period (m+1) pi of the force.
    flights = [("long", arb(0), v0, m), ("short", m * pi, following, 1)]
    if m % 2 == 0:
        flights += [("long", arb(0), following, m), ("short", m * pi, v0, 1)]
    for k, (name, t, v, gap) in enumerate(flights):
        if not v > 0:
            if v < 0:
                reason = f"the flight before {name} flight {k // 2} would end out of the wall"
                return Verdict(False, math.inf, reason)
            raise Undecided("graze", "an impact has no velocity, within the radius")
        start = Departure(0, system.bounds[0].at, Cloud.of(t, v), 0)
        bracket, _, _ = first_impact(system, start, 1.01 * gap * math.pi)
        where = bracket.place_of(gap * pi)
        if where == 1:
            earlier = f"{name} flight {k // 2} meets the wall before {gap} pi"
            return Verdict(False, math.inf, earlier)
        if where != 0:
            raise Undecided("precision", f"the end of {name} flight {k // 2} is open")
    reason = f"{len(flights)} flights end on Y_{m} and not before, and those decide for all"
    return Verdict(True, math.inf, reason)
