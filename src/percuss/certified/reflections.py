"""Families below a critical velocity: flights that end early, and close after many impacts.

Let an elastic wall lie at the equilibrium of a spring K without damping, under harmonics of odd
multiples n >= 3 of sqrt(K). Every solution h of the linear equation has h(t + P) = -h(t) with
P = pi/sqrt(K). With h(z) = 0 let R_z h be the solution that leaves z with the velocity reversed.
R_z depends on z modulo P only, and R_z R_z = 1. A flight along h from z ends at a zero of h: at
z + P (it is full) or at an earlier one (short), and the next one runs along R of that zero. So
flights are told by a word of zeros in which equal neighbours cancel, and a zero of a curve that
comes again, some P later, is the same zero exactly. Where the word is empty again, at the first
zero, the motion is where it began, a whole number of P later. Nothing here fixes the start: all
motions nearby return as well (docs/theory/third-harmonic.md has the case of six impacts).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from flint import arb, ctx

from percuss.certified.cloud import Cloud
from percuss.certified.first_root import Bracket
from percuss.certified.flight import EnclosedFlight
from percuss.certified.law import coarse_bits
from percuss.certified.numbers import ball, precision
from percuss.certified.step import (
    Departure,
    flight_of,
    landed,
    levels_of,
    search_along,
    width_of,
)
from percuss.certified.system import System
from percuss.certified.undecided import Undecided

__all__ = ["Rounds", "first_impact"]

# A curve: zeros at which the first one is reflected in turn, none twice running.
Word = tuple[int, ...]


def first_impact(
    system: System, start: Departure, longest: float
) -> tuple[Bracket, EnclosedFlight, int]:
    """Return where a flight first meets a stop, for all of its starts.

    Raises
    ------
    Undecided
        If the balls leave it open, or it meets none in this time.
    """
    tries = sorted({coarse_bits(system), ctx.prec})
    for coarse in tries:
        with precision(coarse):
            whole = flight_of(system, start, whole=True)
            levels = levels_of(system, start.region)
            width = width_of(system, whole)
            search = search_along(system, whole, levels, start.bound, start.order, width)
            try:
                bracket = search.first(longest)
            except Undecided:
                if coarse == tries[-1]:
                    raise
                continue
        if bracket is not None:
            return bracket, whole, coarse
        break
    raise Undecided("no_event", "a flight meets no stop within a natural period")


@dataclass
class Rounds:
    """A motion on one wall, flight after flight, each zero by its name.

    Attributes
    ----------
    system
        The exact system; that its flights return reversed is for the caller to know.
    t, v
        Instant and velocity after the last impact; at first those of the start.
    half
        Half a natural period, P.
    word
        The curve that the motion now flies along; empty for that of the start.
    zero, turns
        Name of the zero it flies from, 0 that of the start, and by how many P this is later than
        when the zero was first found.
    zeros
        Of each curve the zeros that are known, by name, and when each was first found.
    """

    system: System
    t: arb
    v: arb
    half: arb = field(init=False)
    word: Word = ()
    zero: int = 0
    turns: int = 0
    zeros: dict[Word, set[int]] = field(init=False)
    times: list[arb] = field(init=False)

    def __post_init__(self) -> None:
        """Begin at the start."""
        self.half = arb.pi() / ball(self.system.stiffness(self.system.regions[0])).sqrt()
        self.zeros, self.times = {(): {0}}, [self.t]

    @property
    def is_closed(self) -> bool:
        """Whether the motion is where it began, exactly, ``turns`` half periods later."""
        return not self.word and self.zero == 0 and self.turns > 0

    def fly(self) -> arb:
        """Fly to the next impact, and return the velocity before it."""
        off = 1 if self.system.regions[0].lower == 0 else -1
        if not off * self.v > 0:
            raise Undecided("graze", "whether the motion leaves the wall is open")
        start = Departure(0, self.system.bounds[0].at, Cloud.of(self.t, self.v), 0)
        bracket, whole, coarse = first_impact(self.system, start, 2.0 * float(self.half))
        known = self._named(bracket)
        if known is None:
            there = landed(self.system, start, whole, bracket, coarse)
            self.t, before = there.box
            self.zero, self.turns = len(self.times), 0
            self.times.append(self.t)
            self.zeros[self.word].add(self.zero)
        else:
            full = known[0] == self.zero
            self.zero, self.turns = known
            before = -self.v
            if not full:
                before = landed(self.system, start, whole, bracket, coarse).box[1]
            self.t = self.times[self.zero] + self.turns * self.half
        self.v = -before
        cancels = bool(self.word) and self.word[-1] == self.zero
        self.word = self.word[:-1] if cancels else (*self.word, self.zero)
        self.zeros.setdefault(self.word, set()).add(self.zero)
        return before

    def _named(self, bracket: Bracket) -> tuple[int, int] | None:
        """Return the zero that the flight ends at, and its turns, None for a new one.

        In the bracket the flight has one zero only: one that lies there is that.
        """
        for zero in sorted(self.zeros[self.word]):
            if zero == self.zero:
                # Exactly, without the radius of the start.
                turns, s = self.turns + 1, self.half
            else:
                apart = (self.t - self.times[zero] + bracket.guess) / self.half
                turns = round(float(apart))
                s = self.times[zero] + turns * self.half - self.t
            where = bracket.place_of(s)
            if where == 0:
                return zero, turns
            if where is None:
                raise Undecided("precision", "whether a flight ends at a known zero is open")
        return None
