"""What a proof says, as JSON that `tools/check_certificate` proves anew without percuss.

A certificate holds the exact numbers of the system, per unit mass, and what is claimed; rationals
are written as "p/q". docs/theory/certified.md, section 11, has the theorems.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import groupby, pairwise
from math import gcd, lcm
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from percuss.certified.ball_arithmetic import Ball, Undecided
from percuss.certified.branch import system_at
from percuss.certified.certified_branch import CertifiedBranch, GrazeEnds
from percuss.certified.chaos import CertifiedChaos, growth_of_loops
from percuss.certified.fold import OrbitCurve
from percuss.certified.graze_end import GrazeEnd
from percuss.certified.march import Ending
from percuss.certified.numbers import exact_value, largest_abs, precision
from percuss.certified.orbit_list import CompleteList
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.proven_basins import CertifiedBasins
from percuss.certified.results import CertifiedRun
from percuss.certified.shooting import events_of
from percuss.certified.special import CertifiedPoint
from percuss.certified.special_strips import strips_about
from percuss.certified.strips import Strip, StripChain, Tube
from percuss.certified.system import BallSystem, Region, Tone, system_of
from percuss.certified.trapping import Trap
from percuss.errors import ParameterError
from percuss.model.exact import Phase, angle, as_fraction

VERSION = 1
# A claim is wider than the ball that percuss has by this, so that other arithmetic can prove it.
WIDER = 8
# How much wider the sides of tubes next to a graze, and about a special point, are than those
# proven.
ROOM = Fraction(3, 2)
# Digits to which the ends of a claim are rounded outward, relative to its width.
ROUNDING = 1000
# Digits that a number has at most.
MOST_DIGITS = 2000
Json = dict[str, Any]


def certificate(
    result: CertifiedRun
    | CertifiedOrbit
    | CertifiedPoint
    | CertifiedBranch
    | CertifiedChaos
    | CompleteList
    | CertifiedBasins,
) -> Json:
    """Return what a proof claims, and of what, as a dictionary for JSON.

    Parameters
    ----------
    result
        Of `certify`, or of `prove_chaos`, `list_orbits` or `prove_basins`. Of a branch, what is
        proven of orbits that pass through no stop; of a special point, the short branch about it.

    Returns
    -------
    dict
        With ``certificate`` (the version of the form), ``kind``, ``law`` and the claims.

    Raises
    ------
    ParameterError
        If nothing is proven; if numbers are irrational, an interval or of more than 2000 digits,
        the force has a record or a wall a table of restitutions; if a run holds a chatter or a
        contact, or an orbit has no events; if the numbers of the equation of motion are not linear
        in the parameter of a branch; if the orbits of a special point are formal, or it is a corner
        or the graze of a soft stop; if a list is not complete, or of more than one wall; if no cell
        of a basin is proven.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.certified import certificate
    >>> orbit = pc.find_orbit(pc.impact_oscillator("4/5"), pc.cosine("14/5"))
    >>> claims = certificate(pc.certify(orbit))
    >>> claims["kind"], claims["law"]["bounds"], claims["stability"]
    ('orbit', [{'at': '0', 'restitution': '4/5'}], 'unstable')
    """
    kinds: dict[type, Callable[[Any], Json]] = {
        CertifiedRun: _run,
        CertifiedOrbit: _orbit,
        CertifiedPoint: _point,
        CertifiedBranch: _branch,
        CertifiedChaos: _chaos,
        CompleteList: _list,
        CertifiedBasins: _basins,
    }
    for kind, written in kinds.items():
        if isinstance(result, kind):
            try:
                return {"certificate": VERSION, **written(result)}
            except _NoCertificateError as error:
                reason = f"without a certificate: {error}"
                raise ParameterError("result", kind.__name__, reason) from None
    reason = f"not one of {', '.join(kind.__name__ for kind in kinds)}"
    raise ParameterError("result", type(result).__name__, reason)


class _NoCertificateError(Exception):
    """Why a result has none."""


def _text(number: Fraction) -> str:
    """Return a number in words of a certificate, whose reader takes no longer ones."""
    if max(abs(number.numerator), number.denominator) >= 10**MOST_DIGITS:
        raise _NoCertificateError(f"one of its numbers has more than {MOST_DIGITS} digits")
    return str(number)


def _law(system: BallSystem) -> Json:
    """Return the numbers of a system; its forces at rest are continuous by themselves."""
    if not system.is_exact:
        raise _NoCertificateError("it holds for an interval of a number, or a number is irrational")
    if system.record is not None or system.tables:
        raise _NoCertificateError("its force has a record, or a wall a table of restitutions")
    tones = _tones(system)
    omegas = [system.frequency(tone) for tone in tones]
    return {
        "regions": [_region(system, region) for region in system.regions],
        "bounds": [
            {
                "at": _text(bound.at),
                "restitution": None
                if bound.wall is None
                else _text(system.numbers[f"oscillator.stops.{bound.wall}.restitution"]),
            }
            for bound in system.bounds
        ],
        "tones": [
            {
                "omega": _text(omega),
                "amplitude": _text(system.strength(tone)),
                "phase": [_text(part) for part in tone.phase],
            }
            for tone, omega in zip(tones, omegas, strict=True)
        ],
        "base": _text(_base(omegas)) if omegas else None,
    }


def _region(system: BallSystem, region: Region) -> Json:
    return {
        "stiffness": _text(system.stiffness(region)),
        "damping": _text(system.damping(region)),
        "constant": _text(system.constant(region)),
        "lower": region.lower,
        "upper": region.upper,
    }


def _tones(system: BallSystem) -> list[Tone]:
    """Return the tones that are there: one without amplitude has no period."""
    return [tone for tone in system.tones if system.strength(tone) != 0]


def _base(omegas: Sequence[Fraction]) -> Fraction:
    """Return the greatest frequency of which all others are multiples."""
    return Fraction(
        reduce(gcd, (omega.numerator for omega in omegas)),
        reduce(lcm, (omega.denominator for omega in omegas)),
    )


def _repeats(system: BallSystem) -> int:
    """Return how often the tones repeat in a period of the forcing, which may be given longer."""
    forcing, tones = system.forcing, _tones(system)
    if forcing is None or forcing.frequency is None or not tones:
        raise _NoCertificateError("the period of its force is not known exactly")
    return int(_base([system.frequency(tone) for tone in tones]) / forcing.frequency)


def _claim(value: Ball | arb, least: Fraction = Fraction(0)) -> list[str]:
    """Return an interval about a ball, some times wider and at least so wide, with short ends."""
    number = value if isinstance(value, arb) else value.arb
    middle = exact_value(number)
    radius = max(WIDER * exact_value(number.rad()), least)
    if radius == 0:
        radius = Fraction(1, 2**60)
    unit = _unit(radius)
    low, high = (middle - radius) // unit * unit, -(-(middle + radius) // unit) * unit
    return [_text(low), _text(high)]


def _unit(size: Fraction) -> Fraction:
    """Return a power of ten to which numbers known to within a size are rounded."""
    unit = Fraction(1)
    while unit * ROUNDING > size:
        unit /= 10
    return unit


def _run(run: CertifiedRun) -> Json:
    if run.accumulations or len(run.contacts) or len(run.grazes):
        raise _NoCertificateError("the run has a chatter, a contact or a graze; end it before")
    if not run.complete or run.outcome is Ending.impact_at_t_end:
        raise _NoCertificateError(f"the run is not proven to its end: {run.outcome.value}")
    system = run.system
    law = _law(system)
    at: dict[int, int] = {}
    for i, bound in enumerate(system.bounds):
        at |= dict.fromkeys(bound.edges if bound.wall is None else (bound.wall,), i)
    events = [
        (t.arb, at[int(stop)], before.arb, after.arb)
        for t, stop, before, after in zip(
            run.impacts.t, run.impacts.stop, run.impacts.v_before, run.impacts.v_after, strict=True
        )
    ]
    crossings = zip(run.crossings.t, run.crossings.stop, run.crossings.v, strict=True)
    events += [(t.arb, at[int(stop)], v.arb, v.arb) for t, stop, v in crossings]
    events.sort(key=lambda event: exact_value(event[0]))
    if not events:
        raise _NoCertificateError("the run meets no stop")
    # Of two edges at one place a motion crosses both at once.
    rows = [event for i, event in enumerate(events) if i == 0 or event[:2] != events[i - 1][:2]]
    start = run.start
    x, v = as_fraction(start.x0), as_fraction(start.v0)
    first = rows[0][1]
    wall, outward = law["bounds"][first], v if first == law["regions"][-1]["upper"] else -v
    if outward > 0 and Fraction(wall["at"]) == x and wall["restitution"] is not None:
        # The first impact is the start itself: what is claimed begins behind it.
        v, rows = -Fraction(wall["restitution"]) * v, rows[1:]
    if not rows:
        raise _NoCertificateError("the run meets no stop after its start")
    return {
        "kind": "run",
        "law": law,
        "start": {
            "x": _text(x),
            "v": _text(v),
            "t": _phase(start.t0),
        },
        "events": [
            {"bound": bound, "t": _claim(t), "v_before": _claim(v), "v_after": _claim(w)}
            for t, bound, v, w in rows
        ],
    }


def _phase(value: Phase) -> list[str]:
    return [_text(part) for part in angle(value)]


def _orbit(orbit: CertifiedOrbit) -> Json:
    if not orbit.exists or orbit.admissible is not True or not orbit.isolated:
        raise _NoCertificateError(
            f"the orbit is not proven: {orbit.reason or 'it is one of a family'}"
        )
    if not orbit.events:
        raise _NoCertificateError("the orbit meets no stop")
    # Digits are those of the period and the greatest velocity, whatever their units are.
    speeds = [v.arb for v in orbit.impacts.v_before] + [v for _, (_, v) in orbit.events]
    sizes = Fraction(largest_abs(orbit.period.arb)), Fraction(max(map(largest_abs, speeds)))
    instants, velocities = (size / 10**orbit.wanted_digits for size in sizes)
    system = system_of(orbit.oscillator, orbit.forcing)
    return {
        "kind": "orbit",
        "law": _law(system),
        "periods": orbit.n_periods * _repeats(system),
        "events": [
            {
                "bound": event.bound,
                "region": event.after,
                "t": _claim(t, instants),
                "v": _claim(v, velocities),
            }
            for event, (t, v) in orbit.events
        ],
        "stability": _stability_claimed(orbit.stability),
    }


def _branch(branch: CertifiedBranch) -> Json:
    with precision(branch.precision):
        parts = [
            part
            for chain, ends in zip(branch.chains, branch.grazes, strict=True)
            for part in _motions(chain, ends)
        ]
    if not parts:
        reason = branch.reason or "no orbit is proven to pass through no stop"
        raise _NoCertificateError(f"nothing is proven of the branch: {reason}")
    return _curves(parts)


class _Part(NamedTuple):
    """Motions on a curve: strips, their widening, their special points, grazes at the ends."""

    curve: OrbitCurve
    strips: list[Strip]
    room: list[Fraction]
    points: list[tuple[str, int, int]]
    grazes: GrazeEnds


def _motions(chain: StripChain, grazes: GrazeEnds) -> Iterator[_Part]:
    """Yield the motions of a chain."""
    strips = list(chain.slender())
    for admissible, group in groupby(strips, lambda strip: strip.admissible):
        part = list(group)
        if admissible:
            room = [as_fraction(chain.room(strip.tube)) for strip in part]
            begins, ends = part[0] is strips[0], part[-1] is strips[-1]
            own = grazes[0] if begins else None, grazes[1] if ends else None
            yield _Part(chain.curve, part, room, list(_points(part)), own)


def _point(point: CertifiedPoint) -> Json:
    """Return a special point by itself as the shortest branch that has it."""
    if not point.exists:
        raise _NoCertificateError(f"the point is not proven: {point.reason}")
    try:
        curve, strips, kind, graze = strips_about(point)
    except Undecided as question:
        raise _NoCertificateError(question.reason or question.kind) from None
    points = [] if graze is not None else [(kind, 0, len(strips) - 1)]
    return _curves([_Part(curve, strips, [ROOM] * len(strips), points, (None, graze))])


def _curves(parts: Sequence[_Part]) -> Json:
    tubes = [strip.tube for part in parts for strip in part.strips]
    for graze in (end for part in parts for end in part.grazes):
        tubes += [] if graze is None else graze.tubes
    ends = [end for tube in tubes for end in tube.parameters]
    return {
        "kind": "branch",
        "law": _law_along(parts[0].curve, min(ends), max(ends)),
        "curves": [_curve(part, ends[0]) for part in parts],
    }


def _curve(part: _Part, value: Fraction) -> Json:
    curve, strips, room, points, (before, after) = part
    repeats = _repeats(system_at(curve.system, curve.path, value))
    first = [] if before is None else list(_to_graze(before))
    events = curve.events[: len(curve.events) // 2] if curve.mirrored else curve.events
    return {
        "periods": _text(Fraction(curve.n_periods * repeats, 2 if curve.mirrored else 1)),
        "events": [{"bound": event.bound, "region": event.after} for event in events],
        "strips": [
            *({**it, "begin": it["end"], "end": it["begin"]} for it in reversed(first)),
            *(_strip(strip, wider) for strip, wider in zip(strips, room, strict=True)),
            *([] if after is None else _to_graze(after)),
        ],
        "points": [
            {"kind": kind, "before": len(first) + i, "after": len(first) + j}
            for kind, i, j in points
        ],
    }


def _to_graze(graze: GrazeEnd) -> Iterator[Json]:
    """Yield the claims of the tubes that lead to a graze."""
    for tube in graze.tubes:
        far, near = (tube.low, tube.high) if tube.high <= 0 else (tube.high, tube.low)
        yield {**_tube(tube, far, near, ROOM), "stability": graze.stability, "slow": graze.number}


def _law_along(curve: OrbitCurve, low: Fraction, high: Fraction) -> Json:
    """Return the law with a pair a, b for each number a + b p that depends on the parameter p."""
    at = [low, high, (2 * low + high) / 3]
    laws = [_law(system_at(curve.system, curve.path, p)) for p in at]
    if len({len(law["tones"]) for law in laws}) > 1:
        raise _NoCertificateError("a part of the force has no amplitude at a parameter")

    def along(parts: list[Any], name: str = "") -> Any:
        one, other, between = parts
        if isinstance(one, dict):
            return {key: along([part[key] for part in parts], key) for key in one}
        if isinstance(one, list) and name != "phase":
            return [along(list(entries)) for entries in zip(*parts, strict=True)]
        if one == other == between:
            return one
        if name == "phase":
            raise _NoCertificateError("a phase depends on the parameter")
        values = [Fraction(part) for part in parts]
        if name == "amplitude" and values[0] * values[1] < 0:
            raise _NoCertificateError("a part of the force has no amplitude at a parameter")
        slope = (values[1] - values[0]) / (at[1] - at[0])
        start = values[0] - slope * at[0]
        if values[2] != start + slope * at[2]:
            raise _NoCertificateError(f"its {name} is not linear in {curve.path}")
        return [_text(start), _text(slope)]

    return along(laws)  # type: ignore[no-any-return]


def _strip(strip: Strip, room: Fraction) -> Json:
    tube = strip.tube
    return {
        **_tube(tube, strip.begin, strip.end, room),
        "stability": _stability_claimed(strip.stability) if strip.is_clear else "undecided",
        "slow": None,
    }


def _tube(tube: Tube, begin: Fraction, end: Fraction, room: Fraction) -> Json:
    half = (tube.high - tube.low) / 2
    middle, tangent, sizes = (
        [exact_value(part) for part in vector] for vector in (tube.middle, tube.tangent, tube.trial)
    )
    middle[tube.along] = (tube.low + tube.high) / 2
    for i in range(len(sizes)):
        if i != tube.along:
            size = room * sizes[i]
            middle[i] = _rounded(middle[i], size)
            # What it leaves is multiplied by matrices.
            tangent[i] = _rounded(tangent[i], size / half / ROUNDING)
            sizes[i] = _rounded(size, size)
    return {
        "along": tube.along,
        "begin": _text(begin),
        "end": _text(end),
        "middle": [_text(part) for part in middle],
        "tangent": [_text(part) for part in tangent],
        "sizes": [_text(part) for part in sizes],
    }


def _points(strips: Sequence[Strip]) -> Iterator[tuple[str, int, int]]:
    """Yield the special points between strips of which stability is decided."""
    decided = [i for i, strip in enumerate(strips) if strip.is_decided and strip.is_clear]
    for i, j in pairwise(decided):
        along = all(strip.tube.is_along_parameter for strip in strips[i : j + 1])
        for kind in strips[i].points_before(strips[j]):
            if along or kind != "symmetry_breaking":
                yield kind, i, j


def _stability_claimed(stability: str) -> str:
    return stability if stability in ("asymptotic", "unstable") else "undecided"


def _rounded(value: Fraction, size: Fraction) -> Fraction:
    """Return a number with few digits, within a small part of a size."""
    unit = _unit(size)
    return round(value / unit) * unit


def _list(found: CompleteList) -> Json:
    if not found.complete:
        raise _NoCertificateError(f"the list is not proven to be complete: {found.reason}")
    system = system_of(found.oscillator, found.forcing)
    if len(system.bounds) != 1 or system.bounds[0].wall is None:
        raise _NoCertificateError("the program checks lists of one wall and no other stop")
    periods = found.periods * _repeats(system)
    orbits = [_orbit(orbit) for orbit in (*found.orbits, *found.shorter)]
    return {
        "kind": "list",
        "law": _law(system),
        "impacts": found.impacts,
        "periods": periods,
        "speeds": [_text(Fraction(str(speed))) for speed in found.speeds],
        "cycle": [_text(Fraction(str(end))) for end in found.cycle],
        "orbits": [
            {key: orbit[key] for key in ("periods", "events", "stability")} for orbit in orbits
        ],
        "boxes": [
            {"cycle": _smaller(a, b), "v": _smaller(*sorted((abs(c), abs(d))))}
            for a, b, c, d in found.boxes.tolist()
        ],
    }


def _smaller(low: float, high: float) -> list[str]:
    """Return a part of an interval about its middle, with short ends."""
    middle, half = (Fraction(low) + Fraction(high)) / 2, (Fraction(high) - Fraction(low)) / 6
    return [_text(_rounded(middle + sign * half, half)) for sign in (-1, 1)]


def _basins(basins: CertifiedBasins) -> Json:
    system = system_of(basins.oscillator, basins.forcing)
    orbits = [k for k, fate in enumerate(basins.fates) if not isinstance(fate, int)]
    # In a certificate motions without impacts come last.
    numbers = sorted(range(len(basins.fates)), key=lambda k: (k not in orbits, k))
    cells = [
        {
            "x": [_text(Fraction(x)) for x in (a, b)],
            "v": [_text(Fraction(v)) for v in (c, d)],
            "to": to,
        }
        for label, (a, b, c, d) in _rectangles(basins)
        for to in [numbers.index(label)]
    ]
    if not cells:
        raise _NoCertificateError("no cell is proven")
    return {
        "kind": "basins",
        "law": _law(system),
        "t": _phase(basins.t0),
        "orbits": [
            _trapping(basins.attractors[k], fate)
            for k, fate in enumerate(basins.fates)
            if not isinstance(fate, int)
        ],
        "steady": [basins.fates[k] for k in numbers[len(orbits) :]],
        "cells": cells,
    }


def _rectangles(basins: CertifiedBasins) -> Iterator[tuple[int, tuple[float, ...]]]:
    """Yield what is proven with its labels: blocks of cells of one label, and parts of cells."""
    blocks = [tuple((0, n) for n in basins.labels.shape)]
    while blocks:
        ((i, j), (k, l)) = blocks.pop()
        labels = set(basins.labels[i:j, k:l].flat)
        if len(labels) == 1:
            (label,) = labels
            if label >= 0:
                ends = basins.x0[[i, j]], basins.v0[[k, l]]
                yield int(label), tuple(np.concatenate(ends).tolist())
            continue
        blocks += [(rows, columns) for rows in _halves(i, j) for columns in _halves(k, l)]
    for label, part in zip(basins.labels_of_parts, basins.parts, strict=True):
        yield int(label), tuple(part.tolist())


def _halves(begin: int, end: int) -> list[tuple[int, int]]:
    middle = (begin + end) // 2
    return [(begin, middle), (middle, end)] if begin < middle else [(begin, end)]


def _trapping(attractor: CertifiedOrbit, traps: Sequence[Trap]) -> Json:
    orbit = _orbit(attractor)
    kind = traps[0].event
    places = [k for k, (event, _) in enumerate(attractor.events) if event == kind]
    return {
        "orbit": {key: orbit[key] for key in ("periods", "events", "stability")},
        "traps": [
            {
                "event": place,
                "axes": [[_text(exact_value(x)) for x in row] for row in trap.within],
                "rounds": trap.rounds,
                "stages": [_text(Fraction(stage)) for stage in trap.stages],
            }
            for place, trap in zip(places, traps, strict=True)
        ],
    }


def _chaos(chaos: CertifiedChaos) -> Json:
    if not chaos:
        raise _NoCertificateError(chaos.reason)
    system = system_of(chaos.orbit.oscillator, chaos.orbit.forcing)
    event = next(event for event in events_of(system, chaos.orbit) if event.stop == chaos.stop)
    repeats = _repeats(system)
    return {
        "kind": "chaos",
        "law": _law(system),
        "bound": event.bound,
        "region": event.after,
        "sets": [
            {
                name: [_text(Fraction(x)) for x in getattr(hset, name)]
                for name in ("center", "unstable", "stable")
            }
            for hset in chaos.sets
        ],
        "transitions": [
            {
                "from": i,
                "to": j,
                "turns": covering.turns * repeats,
                "at": _text(Fraction(at)),
                "half": _text(Fraction(half)),
            }
            for (i, j), covering, (at, half) in zip(
                chaos.transitions, chaos.coverings, chaos.strips, strict=True
            )
        ],
        "growth": _text(growth_of_loops([len(loop) for loop in chaos.loops])[0]),
    }
