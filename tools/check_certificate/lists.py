"""Complete lists: all orbits with some impacts in some periods, for one wall.

Proven here: on parts of the region of all their impacts, together the whole of it, there is no
motion that comes back but those of the orbits that the list has, each of them proven and no two the
same. Section 11.9 of docs/theory/certified.md, with orbits by 11.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

from arithmetic import Interval, NotProvenError, nearest, of, product, with_first
from flights import Flight, Law, State, met
from orbits import check_different, check_inside, contracted, inverse, proven_orbit
from parts import Rectangle, Side, proven_on_parts
from words import counted, told

# Boxes are not made smaller than this part of the region, and steps of flights in which some of
# them may have an impact not shorter than this part of the longest one.
SMALLEST_BOX, FINEST_STEP = Fraction(1, 2**24), Fraction(1, 32)
# Parts of a box that are tried.
PARTS_OF_BOX = tuple(Fraction(1, 2**n) for n in range(9))
# There are no lists of more impacts or periods.
MOST_RETURNS = 100


class Returns:
    """The equations of motions that meet one wall n times in p periods and then come back.

    From (t, v) after an impact: x(t + p T) is the wall, and an impact there leaves with v again.
    The speeds after all impacts are between two.
    """

    def __init__(self, law: Law, n: int, p: int, speeds: Side) -> None:
        self.law, self.n, self.duration, self.period = law, n, p * law.period(), law.period()
        self.slow, self.fast = of(speeds[0]).low, of(speeds[1]).high
        self.at, self.r = of(law.bounds[0].at), law.bounds[0].restitution
        # The sign of velocities after an impact.
        self.off = 1 if law.regions[0].lower == 0 else -1

    def box(self, cycle: Side, v: Side) -> State:
        """Return the states whose t over the period, and speed, lie between two numbers each."""
        return State(of(*cycle) * self.period, self.at, self.off * of(*v))

    def missed(self, start: State) -> tuple[list[Interval], list[list[Interval]]]:
        """Return by how much states fail to come back, and the derivative by t and v."""
        t, v0, total = start.t, start.v, ((of(1), of(0)), (of(0), of(1)))
        for _ in range(self.n - 1):
            event = met(Flight(self.law, 0, start), 0)
            total, start = product(event.derivative, total), event.after
        flight, tau = Flight(self.law, 0, start), t + self.duration - start.t
        x, v = flight.at(tau)
        (a, b), (c, d) = product(flight.by_start(tau, 0), total)
        # The end is later by dt as well.
        a, c = a + v, c + flight.acceleration(flight.force(tau), x, v)
        return [x - self.at, -self.r * v - v0], [[a, b], [-self.r * c, -self.r * d - 1]]

    def excludes(self, box: State) -> bool:
        """Return whether no motion that is sought has an impact in a box."""
        with suppress(NotProvenError):
            if self.comes_to_nothing(box, 0, box):
                return True
        with suppress(NotProvenError):
            return self.has_no_zero(box)
        return False

    def has_no_zero(self, box: State) -> bool:
        """Return whether the mean value theorem shows that no state of a box comes back."""
        middle = State(box.t.middle(), self.at, box.v.middle())
        value, _ = self.missed(middle)
        _, rows = self.missed(box)
        spread = box.t - middle.t, box.v - middle.v
        whole = [
            e + row[0] * spread[0] + row[1] * spread[1] for e, row in zip(value, rows, strict=True)
        ]
        return any(part.least > 0 for part in whole)

    def zero(self, box: State) -> State:
        """Return a small box with the one zero of the equations in a box; prove that it is one."""
        found = box
        for _ in range(6):
            middle = State(found.t.middle(), self.at, found.v.middle())
            widths = [found.t - middle.t, found.v - middle.v]
            _, rows = self.missed(found)
            part = contracted(inverse(rows), rows, widths, self.missed(middle)[0])
            if found is box:
                check_inside(widths, part)
            found = State(middle.t + part[0], self.at, middle.v + part[1])
        return found

    def is_left_at(self, start: State) -> bool:
        """Return whether the motion from a small box is proven not to come back after n impacts."""
        state = start
        for _ in range(self.n):
            state = met(Flight(self.law, 0, state), 0).after
        apart = state.t - start.t - self.duration, state.v - start.v
        return any(part.least > 0 for part in apart)

    def comes_to_nothing(self, start: State, k: int, begin: State) -> bool:
        """Return whether no motion from a box after k impacts comes back, by intervals alone.

        An impact that is too slow is none of a motion that is sought: the flight goes on, through
        the wall. Where an impact may be, what follows it is looked at, and the flight without it as
        well.
        """
        flight, end = Flight(self.law, 0, start), begin.t + self.duration
        if k == self.n - 1:
            x, v = flight.at(end - start.t)
            speed = -self.r * v * self.off
            apart = (x - self.at).least > 0 or (speed * self.off - begin.v).least > 0
            return bool(apart or speed.high < self.slow or speed.low > self.fast)
        tau, (h, shortest, longest) = Fraction(0), flight.numbers.steps
        while (start.t + of(tau)).low <= end.high:
            try:
                x, v, since = flight.on_step(tau, h)
            except NotProvenError:
                h /= 2
                if h < shortest:
                    return False
                continue
            inside = (since if tau == 0 else x - self.at) * self.off
            speed = -self.r * v * self.off
            if inside.low <= 0 and speed.high >= self.slow:
                if h > longest * FINEST_STEP or tau == 0:
                    h /= 2
                    if h < shortest:
                        return False
                    continue
                left = Interval(max(speed.low, self.slow), min(speed.high, self.fast))
                if left.low <= left.high:
                    state = State(start.t + of(tau, tau + h), self.at, left * self.off)
                    if not self.comes_to_nothing(state, k + 1, begin):
                        return False
                if ((flight.at(of(tau + h))[0] - self.at) * self.off).high < 0:
                    return True
            tau, h = tau + h, min(2 * h, longest)
        return True


def proven_list(law: Law, claims: Any) -> str:
    """Prove that all orbits with some impacts in some periods are those of a list."""
    n, p, (slow, fast), cycle = (claims[key] for key in ("impacts", "periods", "speeds", "cycle"))
    if len(law.bounds) != 1 or law.bounds[0].restitution is None:
        raise NotProvenError("a list is checked for one wall and no other stop")
    if max(n, p) > MOST_RETURNS:
        raise NotProvenError(
            f"a list of more than {MOST_RETURNS} impacts or periods is not checked"
        )
    if n < 1 or p < 1 or not 0 < slow < fast or not 0 <= cycle[0] < cycle[1] <= 1:
        raise NotProvenError("the region of a list is empty, or reaches to speed 0")
    if any(it[key][0] >= it[key][1] for it in claims["boxes"] for key in ("cycle", "v")):
        raise NotProvenError("a box of the list is empty")
    returns = Returns(law, n, p, (slow, fast))
    said, events = [], []
    for orbit in claims["orbits"]:
        said.append(proven_orbit(law, orbit))
        rounds = Fraction(n, len(orbit["events"]))
        if rounds.denominator != 1 or rounds * orbit["periods"] != p:
            raise NotProvenError("an orbit has not the impacts and periods of the list")
        events += [(of(*event["t"]), of(*event["v"])) for event in orbit["events"]]
    check_different(law, claims["orbits"])
    known = []
    for it in claims["boxes"]:
        box, zero = _with_one_zero(returns, (it["cycle"], it["v"]))
        known.append(box)
        is_known = any(_holds_state(box, event, returns.period) for event in events)
        if not is_known and not returns.is_left_at(zero):
            raise NotProvenError(f"the box at t = {told(box.t.fractions()[0])} may hold an orbit")
    n_boxes = _check_region(returns, known, (cycle, (slow, fast)))
    head = (
        f"Whatever periodic motion meets the wall with {counted(n, 'impact')} in "
        f"{counted(p, 'period')} of the force, all of which it leaves with speeds of {slow} to {fast}, "
        f"one of them at a t over the period, modulo 1, between {cycle[0]} and {cycle[1]}, is among "
        f"{counted(len(said), 'orbit')} (proven on {counted(n_boxes, 'box', 'boxes')} of the region)"
    )
    return "\n".join([f"{head}{':' if said else ': there is none.'}", *said])


def _with_one_zero(returns: Returns, claim: Rectangle) -> tuple[State, State]:
    """Return a box that is proven to hold one zero, and a small one with it.

    It is the one that is claimed, or a part of that about its middle: what is beside it is left to
    the search of the region.
    """

    def proven(part: Fraction) -> tuple[State, State]:
        (a, b), (c, d) = (
            ((low + high - part * (high - low)) / 2, (low + high + part * (high - low)) / 2)
            for low, high in claim
        )
        box = returns.box((a, b), (c, d))
        return box, returns.zero(box)

    return with_first(PARTS_OF_BOX, proven)


def _holds_state(box: State, state: tuple[Interval, Interval], period: Interval) -> bool:
    """Return whether a state lies in a box, whole periods earlier or later."""
    t, v = state
    turns = nearest((box.t - t).middle(), period)
    return box.t.holds(t + turns * period) and box.v.holds(v)


def _check_region(returns: Returns, known: Sequence[State], region: Rectangle) -> int:
    """Prove that a region has no motion sought but those of the known boxes; count its parts."""

    def has_no_other(part: Rectangle) -> bool | None:
        box = returns.box(*part)
        is_known = any(_holds_state(one, (box.t, box.v), returns.period) for one in known)
        return is_known or returns.excludes(box) or None

    said = "an orbit may be missing"
    return sum(proven_on_parts(region, has_no_other, said, SMALLEST_BOX))
