"""Branches of orbits over a parameter, their special points and their grazes.

Proven here: strip by strip, there is one orbit for each value of one coordinate, and the strips
form one smooth curve; where trace and determinant change a sign between two strips, there is a
special point between them. Section 11.7 of docs/theory/certified.md, with the equations of 11.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import groupby, pairwise
from typing import Any

from arithmetic import Dual, Interval, Matrix, NotProvenError, Pair, bits, hull, of, with_first
from flights import Bound, Law, Region
from orbits import (
    Cycle,
    Shot,
    bits_to_try,
    check_first,
    check_inside,
    contracted,
    inverse,
    shot_of,
    stability_of,
)
from reading import law_at, law_of, signs_of_waves
from words import near, told

# Each half of a strip is divided into so many parts along its coordinate.
PARTS_OF_STRIP = (1, 3, 9, 27)
POINTS = "fold", "period_doubling", "symmetry_breaking", "third_root", "fourth_root"
# Of a law that keeps areas, so that the determinant is 1.
ROOTS = {"third_root": "exp(2 pi i/3) and exp(-2 pi i/3)", "fourth_root": "i and -i"}
STABILITIES = {
    "asymptotic": "Neighbouring motions approach the orbits",
    "unstable": "The orbits are unstable",
}


class Strip:
    """Orbits for all values of one of their coordinates, near a tangent; proven when it is made."""

    def __init__(self, text: Any, curve: Any, claim: Any) -> None:
        self.text, self.curve, self.claim = text, curve, claim
        self.along, self.middle = claim["along"], claim["middle"]
        self.tangent = [of(slope) for slope in claim["tangent"]]
        self.ends, self.slow = (claim["begin"], claim["end"]), claim["slow"]
        # The number of the parameter.
        self.n = 2 * len(curve["events"])
        self.widths = [of(-size, size) for i, size in enumerate(claim["sizes"]) if i != self.along]
        self.missed = self._shot([of(value) for value in self.middle])
        self.inverse = inverse(self._others(self.missed.rows))
        try:
            with_first(PARTS_OF_STRIP, self._prove)
        except NotProvenError as error:
            at = told(self.middle[self.n])
            raise NotProvenError(f"in the strip at p = {at}: {error}") from None

    def _prove(self, parts: int) -> None:
        """Prove the strip from its middle to both ends, by so many parts each."""
        zero, parts_of_curve = Fraction(0), []
        for end in self.ends:
            way = end - self.middle[self.along]
            cuts = [way * k / parts for k in range(parts + 1)]
            # By how much the tangent misses, first at the beginning of a part.
            missed = self.missed.missed
            for first, last in pairwise(cuts):
                eta = of(self.middle[self.along]) + of(min(first, last), max(first, last))
                shot = self._shot(self.around(eta, self.widths))
                slopes = [
                    sum((e * t for e, t in zip(row, self.tangent, strict=True)), of(0))
                    for row in shot.rows
                ]
                on_way = of(min(zero, last - first), max(zero, last - first))
                within = [e + slope * on_way for e, slope in zip(missed, slopes, strict=True)]
                part = contracted(self.inverse, self._others(shot.rows), self.widths, within)
                check_inside(self.widths, part)
                missed = [
                    e + (last - first) * slope for e, slope in zip(missed, slopes, strict=True)
                ]
                parts_of_curve.append((eta, part))
        self.moved = [hull(e) for e in zip(*(part for _, part in parts_of_curve), strict=True)]
        # Where the orbits are known to be is less than the strip.
        boxes = [self.around(*part) for part in parts_of_curve]
        for box in boxes:
            check_first(*self._at(box), self.slow)
        shots = [self._shot(box) for box in boxes]
        if self.slow is None:
            found = {stability_of(shot.monodromy) for shot in shots}
            zeros = [_zero_at(shot.monodromy) for shot in shots]
            self.signs = {kind: {zero[kind].sign for zero in zeros} for kind in POINTS}
        else:
            found = {self._stability_next_to_graze(*it) for it in zip(boxes, shots, strict=True)}
            self.signs = {kind: {0} for kind in POINTS}
        if self.claim["stability"] != "undecided" and found != {self.claim["stability"]}:
            raise NotProvenError(f"its orbits are {' or '.join(sorted(found))}")

    def _stability_next_to_graze(self, box: Sequence[Interval], shot: Shot) -> str:
        """Return what a trace above 2 says while the determinant is at most 1.

        Both are known times the slow velocity, without damping that drives.
        """
        (a, _), (_, d) = shot.monodromy
        regions = self._at(box)[0].law.regions
        is_damped = all(of(region.damping).low >= 0 for region in regions)
        is_above = (a + d).least > 2 * box[self.along].size
        return "unstable" if is_damped and is_above else "undecided"

    def _shot(self, point: Sequence[Interval]) -> Shot:
        return shot_of(*self._at(point), self.slow)

    def _at(self, point: Sequence[Interval]) -> tuple[Cycle, list[Pair]]:
        """Return the orbit, under the law of its parameter, and its states at a point."""
        law = law_over(self.text, point[-1])
        states = list(zip(point[:-1:2], point[1::2], strict=True))
        return Cycle(law, self.curve["events"], self.curve["periods"]), states

    def _others(self, rows: Sequence[Sequence[Interval]]) -> list[list[Interval]]:
        return [[e for i, e in enumerate(row) if i != self.along] for row in rows]

    def around(self, eta: Interval, widths: Sequence[Interval]) -> list[Interval]:
        """Return a box about the tangent for an interval of the coordinate."""
        shift = eta - of(self.middle[self.along])
        box = [p + slope * shift for p, slope in zip(self.middle, self.tangent, strict=True)]
        box[self.along] = eta
        others = [i for i in range(self.n + 1) if i != self.along]
        for i, width in zip(others, widths, strict=True):
            box[i] = box[i] + width
        return box

    def has_only(self, box: Sequence[Interval], coordinate: Fraction | None = None) -> bool:
        """Return whether an orbit in a box is one of its own: none is near it but these.

        ``coordinate`` is that of the strip where it is known exactly: a box is rounded outward.
        """
        eta = box[self.along]
        low, high = (coordinate, coordinate) if coordinate is not None else eta.fractions()
        if low < min(self.ends) or high > max(self.ends):
            return False
        tangent = self.around(eta, [of(0)] * self.n)
        apart = [
            e - t for i, (e, t) in enumerate(zip(box, tangent, strict=True)) if i != self.along
        ]
        return all(
            w.low + 3 < a.low and a.high < w.high - 3
            for a, w in zip(apart, self.widths, strict=True)
        )

    def goes_on_in(self, following: Strip, steps: int) -> bool:
        """Return whether the curve goes on in the next strip, by an orbit that both have.

        Those from a graze reach beyond the first orbit of the next strip; else it is that at their
        end.
        """
        return (self.slow is not None and following.begins_in(self, 0, steps)) or self.begins_in(
            following, 1, steps
        )

    def begins_in(self, other: Strip, end: int, steps: int) -> bool:
        """Return whether the orbit at one end is one of another strip."""
        is_known = self.along == other.along
        return other.has_only(self.orbit_at(end, steps), self.ends[end] if is_known else None)

    def orbit_at(self, end: int, steps: int = 0) -> list[Interval]:
        """Return a box with the orbit at its begin, 0, or end, 1; smaller after some steps."""
        eta, moved = of(self.ends[end]), self.moved
        for _ in range(steps):
            middles = [part.middle() for part in moved]
            widths = [part - middle for part, middle in zip(moved, middles, strict=True)]
            rows = self._others(self._shot(self.around(eta, moved)).rows)
            missed = self._shot(self.around(eta, middles)).missed
            found = contracted(inverse(rows), rows, widths, missed)
            moved = [part + middle for part, middle in zip(found, middles, strict=True)]
        return self.around(eta, moved)


def _zero_at(m: Matrix) -> dict[str, Any]:
    """Return what is zero where 1, -1 or, of a law that keeps areas, a root of 1 is a multiplier."""
    (a, b), (c, d) = m
    trace, determinant = a + d, a * d - b * c
    doubling = 1 + trace + determinant
    return {
        "fold": 1 - trace + determinant,
        "period_doubling": doubling,
        "symmetry_breaking": doubling,
        "third_root": 1 + trace,
        "fourth_root": trace,
    }


def law_over(text: Any, p: Any) -> Law:
    """Return the law at an interval of the parameter, with dual numbers for its derivatives."""
    return replace(law_at(text, p), dual=law_at(text, Dual(of(p), of(1))))


def proven_branch(claims: Any) -> str:
    """Prove the strips of each curve, that each goes on in the next one, and the points on it."""
    if not claims["curves"]:
        raise NotProvenError("no curve is claimed")
    return "\n".join(_proven_curve(claims["law"], curve) for curve in claims["curves"])


def _proven_curve(text: Any, curve: Any) -> str:
    if not (curve["strips"] and curve["events"]):
        raise NotProvenError("a curve has no strips, or no events")
    if curve["periods"] <= 0 or curve["periods"].denominator > 2:
        raise NotProvenError("the periods of a curve are no whole number, nor a half of one")
    if any(claim["stability"] not in (*STABILITIES, "undecided") for claim in curve["strips"]):
        raise NotProvenError("a stability is none that can be claimed")
    _check_range(text, curve)
    sizes = [size for claim in curve["strips"] for size in claim["sizes"] if size > 0]
    return with_first(bits_to_try(sizes), lambda n: _proven_strips(text, curve, n))


def _proven_strips(text: Any, curve: Any, n: int) -> str:
    """Prove the strips of a curve, and that each goes on in the next one, with so many bits."""
    with bits(n):
        strips = [Strip(text, curve, claim) for claim in curve["strips"]]
        for strip, following in pairwise(strips):
            if not any(strip.goes_on_in(following, steps) for steps in range(3)):
                at = told(strip.orbit_at(1)[-1].fractions()[0])
                raise NotProvenError(f"at p = {at} the curve is not proven to go on")
        return _curve_in_words(text, curve, strips)


def _check_range(text: Any, curve: Any) -> None:
    """Prove that the law has a meaning for all parameters of a curve.

    What is to hold is linear in p, or quadratic: an identity at three values is one at all.
    """
    ranges = [_parameters(claim, 2 * len(curve["events"])) for claim in curve["strips"]]
    low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
    laws = [law_of(text, p) for p in (low, (low + high) / 2, high)]
    if len({tuple(tone.omega / law.base for tone in law.tones) for law in laws}) > 1:
        raise NotProvenError("the frequencies are not the same multiples of their base throughout")
    # What is linear in p has one sign between two values at which it has that.
    signs = [signs_of_waves(law) for law in laws]
    for wave in signs[0]:
        if not any({s[wave][i] for s in signs} in ({1}, {-1}) for i in range(2)):
            raise NotProvenError("a tone may have no amplitude at some parameter")
    if curve["periods"].denominator == 2 and not all(_is_symmetric(law) for law in laws):
        raise NotProvenError("an orbit of half periods is of a law without the symmetry")


def _is_symmetric(law: Law) -> bool:
    """Return whether a law is unchanged under (x, t) -> (-x, t + half a period)."""
    n = len(law.bounds) - 1
    regions = [
        Region(k, a, -c, None if upper is None else n - upper, None if lower is None else n - lower)
        for k, a, c, lower, upper in reversed(law.regions)
    ]
    bounds = [Bound(-at, restitution) for at, restitution in reversed(law.bounds)]
    odd = all((tone.omega / law.base).numerator % 2 == 1 for tone in law.tones)
    return odd and regions == list(law.regions) and bounds == list(law.bounds)


def _parameters(claim: Any, n: int) -> tuple[Fraction, Fraction]:
    """Return numbers between which all parameters of a strip lie, whose parts fit each other."""
    along, sizes = claim["along"], claim["sizes"]
    if {len(claim[name]) for name in ("middle", "tangent", "sizes")} != {n + 1} or along > n:
        raise NotProvenError(f"a strip has not {n + 1} coordinates")
    if (claim["tangent"][along], sizes[along]) != (1, 0) or min(sizes) < 0:
        raise NotProvenError("the sides of a strip are not those of its coordinate")
    begin, end = claim["begin"], claim["end"]
    if claim["slow"] is not None and (along != 2 * claim["slow"] + 1 or along >= n):
        raise NotProvenError("a strip next to a graze is not along the velocity of its event")
    if begin == end or 2 * claim["middle"][along] != begin + end:
        raise NotProvenError("a strip has no length, or its middle is not there")
    p, slope = claim["middle"][n], claim["tangent"][n]
    low, high = sorted(p + slope * (value - claim["middle"][along]) for value in (begin, end))
    return low - sizes[n], high + sizes[n]


def _curve_in_words(text: Any, curve: Any, strips: Sequence[Strip]) -> str:
    n, periods = len(curve["events"]), curve["periods"]
    halves = ""
    if periods.denominator == 2:
        n, periods, halves = 2 * n, 2 * periods, ", its second half the mirror image of the first"
    begin, end = strips[0].orbit_at(0)[-1].fractions(), strips[-1].orbit_at(1)[-1].fractions()
    said = (
        f"The {len(strips)} strips of a curve hold, for each value of the coordinate of each, one "
        f"periodic orbit of {n} events in {periods} periods of the force{halves}, and one only; each "
        f"meets the stops at these events and no others. They form one smooth curve, which leads from a "
        f"parameter p between {near(begin)} to one between {near(end)}."
    )
    lines = [said]
    for stability, group in groupby(strips, lambda strip: strip.claim["stability"]):
        low, high = _parameters_of(list(group))
        said = STABILITIES.get(stability, "Nothing is claimed of the stability of orbits")
        lines.append(f"  {said}, on the part of the curve with p between {near((low, high))}.")
    for point in curve["points"]:
        kind, i, j = point["kind"], point["before"], point["after"]
        if kind not in POINTS or not i < j < len(strips):
            raise NotProvenError(f"there is no {kind} between strips {i} and {j}")
        said = point_said(text, kind, strips[i : j + 1], mirrored=bool(halves))
        if not said:
            raise NotProvenError(f"that there is a {kind} between strips {i} and {j} is not proven")
        lines.append(
            f"  On the way {said}, at p between {near(_parameters_of(strips[i : j + 1]))}."
        )
    for strip in strips:
        for number, value in enumerate(strip.ends):
            if strip.slow is not None and value == 0:
                where = near(strip.orbit_at(number, 3)[-1].fractions())
                lines.append(
                    f"  At the end with p between {where} event {strip.slow} has no velocity: the "
                    f"motion touches the wall there, and goes on as if it were not there; of the stability of "
                    f"this orbit nothing is claimed."
                )
    return "\n".join(lines)


def point_said(text: Any, kind: str, strips: Sequence[Strip], *, mirrored: bool) -> str:
    """Return what lies between the first and the last of some strips, "" if it is not proven."""
    first, last = (strips[i].signs[kind] for i in (0, -1))
    if sorted([*first, *last]) != [-1, 1]:
        return ""
    if kind == "fold":
        return "p is extremal along the curve"
    if kind in ROOTS:
        keeps_areas = all(it["damping"] in (0, (0, 0)) for it in text["regions"]) and all(
            it["restitution"] in (None, 1, (1, 0)) for it in text["bounds"]
        )
        return f"the multipliers are {ROOTS[kind]}" if keeps_areas and not mirrored else ""
    # While 1 is no multiplier, the index of the map done twice changes its sign with det(M + 1).
    has_others = {sign for strip in strips for sign in strip.signs["fold"]} in ({1}, {-1})
    if kind == "period_doubling" and not mirrored:
        others = ", and orbits of twice the period branch off" if has_others else ""
        return f"a multiplier is -1{others}"
    if kind == "symmetry_breaking" and mirrored and has_others:
        return "a multiplier over half an orbit is -1, and orbits without the symmetry branch off"
    return ""


def _parameters_of(strips: Sequence[Strip]) -> tuple[Fraction, Fraction]:
    """Return numbers between which the parameters of all orbits of some strips lie."""
    ranges = [
        strip.around(of(min(strip.ends), max(strip.ends)), strip.moved)[-1].fractions()
        for strip in strips
    ]
    return min(low for low, _ in ranges), max(high for _, high in ranges)
