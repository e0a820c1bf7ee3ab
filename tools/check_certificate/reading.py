"""What a certificate says, read in one way only.

Proven here: a certificate has the names of its kind and no others, each once, with numbers that are
rational and words for nothing else; its law has a meaning, and the period of its force is the
smallest. Why nothing is read in two ways, and no claim left unread, is section 11.1 of
docs/theory/certified.md.
"""

from __future__ import annotations

import json
import re
from fractions import Fraction
from itertools import pairwise
from math import gcd
from typing import Any

from arithmetic import NotProvenError, angle, cosine_and_sine, of
from flights import Bound, Law, Region, Tone
from words import DIGITS, told

VERSION = 1
# Whole numbers of a certificate are no larger.
COUNT = 10**9

LEAVES = {
    "q": f"rational number p/q of at most {DIGITS} digits each",
    "n": f"whole number from 0 to {COUNT}",
    "z": f"whole number of at most {COUNT} in size",
    "l": "rational number, or a pair of them, a and b, for a + b p",
    "l?": "rational number, or a pair of them, or null",
    "n?": "whole number from 0, or null",
    "w": "word of small letters",
}
NUMBER = re.compile(f"-?[0-9]{{1,{DIGITS}}}(/[0-9]{{1,{DIGITS}}})?")
WORD = re.compile("[a-z_]{1,40}")
PAIR = ("q", "q")
# Numbers of the law of a branch may depend on its parameter p.
LAW = {
    "regions": [
        {"stiffness": "l", "damping": "l", "constant": "l", "lower": "n?", "upper": "n?"}
    ],
    "bounds": [{"at": "l", "restitution": "l?"}],
    "tones": [{"omega": "l", "amplitude": "l", "phase": PAIR}],
    "base": "l?",
}  # fmt: skip
# Orbits for all values of one coordinate, number ``along``, of the instants and velocities after
# the events and the parameter: within ``sizes`` of middle + tangent (value - middle of this
# coordinate). Next to a graze ``slow`` is the number of the event whose velocity goes to zero.
STRIP = {
    "along": "n", "begin": "q", "end": "q", "middle": ["q"], "tangent": ["q"], "sizes": ["q"],
    "stability": "w", "slow": "n?",
}  # fmt: skip
ORBIT = {
    "periods": "n",
    "events": [{"bound": "n", "region": "n", "t": PAIR, "v": PAIR}],
    "stability": "w",
}
FORMS: dict[str, dict[str, Any]] = {
    "run": {
        "start": {"x": "q", "v": "q", "t": PAIR},
        "events": [{"bound": "n", "t": PAIR, "v_before": PAIR, "v_after": PAIR}],
    },
    "orbit": ORBIT,
    "branch": {
        "curves": [
            {
                # A whole number, or a half of an odd one: after it the orbit is its mirror image.
                "periods": "q",
                "events": [{"bound": "n", "region": "n"}],
                "strips": [STRIP],
                "points": [{"kind": "w", "before": "n", "after": "n"}],
            }
        ]
    },
    "list": {
        "impacts": "n",
        "periods": "n",
        "speeds": PAIR,
        "cycle": PAIR,
        "orbits": [ORBIT],
        "boxes": [{"cycle": PAIR, "v": PAIR}],
    },
    "basins": {
        "t": PAIR,
        "orbits": [
            {
                "orbit": ORBIT,
                "traps": [{"event": "n", "axes": (PAIR, PAIR), "rounds": "n", "stages": ["q"]}],
            }
        ],
        "steady": ["n"],
        "cells": [{"x": PAIR, "v": PAIR, "to": "n"}],
    },
    "chaos": {
        "bound": "n",
        "region": "n",
        "sets": [{"center": PAIR, "unstable": PAIR, "stable": PAIR}],
        "transitions": [{"from": "n", "to": "n", "turns": "z", "at": "q", "half": "q"}],
        "growth": "q",
    },
}


def read(value: Any, form: Any) -> Any:
    """Return what stands in a certificate with numbers for their words, if it has the form."""
    if isinstance(form, dict):
        if not isinstance(value, dict) or value.keys() != form.keys():
            names = ", ".join(value) if isinstance(value, dict) else repr(value)[:60]
            raise ValueError(f"{', '.join(form)} should stand where {names} stands")
        return {key: read(value[key], part) for key, part in form.items()}
    if isinstance(form, list | tuple):
        if not isinstance(value, list) or (isinstance(form, tuple) and len(value) != len(form)):
            raise ValueError(f"{repr(value)[:60]} is no list of {repr(form)[:60]}")
        return tuple(read(part, form[i % len(form)]) for i, part in enumerate(value))
    if value is None and form.endswith("?"):
        return None
    if form[0] == "l" and isinstance(value, list):
        return read(value, PAIR)
    if form[0] in "ql" and isinstance(value, str) and NUMBER.fullmatch(value):
        return Fraction(value)
    # True is an int, too.
    least = -COUNT if form == "z" else 0
    if form[0] in "nz" and type(value) is int and least <= value <= COUNT:
        return value
    if form == "w" and isinstance(value, str) and WORD.fullmatch(value):
        return value
    raise ValueError(f"{repr(value)[:60]} is no {LEAVES[form]}")


def certificate_of(text: str) -> Any:
    """Return what a certificate says."""
    try:
        certificate = json.loads(text, object_pairs_hook=_without_twice)
        version, kind = certificate["certificate"], certificate["kind"]
        if read(version, "n") != VERSION:
            raise NotProvenError(
                f"a certificate of version {version!r}; this program checks version {VERSION}"
            )
        if kind not in FORMS:
            raise NotProvenError(
                f"a certificate of {repr(kind)[:60]}; this program checks {', '.join(FORMS)}"
            )
        return read(certificate, {"certificate": "n", "kind": "w", "law": LAW} | FORMS[kind])
    except (ValueError, TypeError, KeyError, ZeroDivisionError, RecursionError) as error:
        raise NotProvenError(f"no certificate, or one cut off or changed: {error!r}") from None


def _without_twice(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    if len(set(names)) < len(names):
        raise ValueError(f"a name stands twice in {', '.join(names)}")
    return dict(pairs)


def law_at(text: Any, p: Any = None) -> Law:
    """Return the law of a certificate at a parameter: a fraction, an interval or a dual number."""

    def number(given: Any) -> Any:
        if not isinstance(given, tuple):
            return given
        if p is None:
            raise NotProvenError("a number depends on a parameter, but this is no branch")
        return given[0] + given[1] * p

    def made(kind: Any, it: dict[str, Any]) -> Any:
        return kind(**{key: part if key == "phase" else number(part) for key, part in it.items()})

    regions = tuple(made(Region, it) for it in text["regions"])
    bounds = tuple(made(Bound, it) for it in text["bounds"])
    return Law(regions, bounds, tuple(made(Tone, it) for it in text["tones"]), number(text["base"]))


def law_of(text: Any, p: Fraction | None = None) -> Law:
    """Return the law of a certificate, whose parts fit each other."""
    law = law_at(text, p)
    regions, bounds, tones, base = law.regions, law.bounds, law.tones, law.base
    inner = [region.upper for region in regions[:-1]]
    if not regions or inner != [region.lower for region in regions[1:]] or None in inner:
        raise NotProvenError("the regions do not lie side by side")
    ends = regions[0].lower, regions[-1].upper
    used = [bound for bound in (ends[0], *inner, ends[1]) if bound is not None]
    if used != list(range(len(bounds))):
        raise NotProvenError("the bounds are not those of the regions")
    if any(lower.at >= upper.at for lower, upper in pairwise(bounds)):
        raise NotProvenError("the bounds are not in order")
    for bound, (_, r) in enumerate(bounds):
        if (r is None) != (bound in inner) or (r is not None and not 0 <= r <= 1):
            said = "no restitution" if r is None else f"a restitution of {told(r)}"
            raise NotProvenError(f"bound {bound} has {said}")
    if any(tone.omega <= 0 for tone in tones):
        raise NotProvenError("a frequency is not above 0")
    if (base is None) != (not tones) or (base is not None and base <= 0):
        said = "nothing" if base is None else told(base)
        raise NotProvenError(f"the frequencies are not multiples of {said}")
    multiples = [tone.omega / base for tone in tones]
    if any(n.denominator != 1 for n in multiples):
        raise NotProvenError("the force does not repeat after its period")
    if tones and gcd(*(n.numerator for n in multiples)) != 1:
        raise NotProvenError("the force repeats before its period ends")
    edges = [bound.at for bound in bounds if bound.restitution is None]
    for at, (lower, upper) in zip(edges, pairwise(regions), strict=True):
        # A soft stop is a spring from its edge on: with it the force at rest there is the same.
        if lower.constant - lower.stiffness * at != upper.constant - upper.stiffness * at:
            raise NotProvenError("the force jumps at the edge of a stop")
    return law


def check_period(law: Law) -> None:
    """Prove that the period of a law is that of its force, which no shorter one is."""
    if not all(any(signs) for signs in signs_of_waves(law).values()):
        raise NotProvenError("a tone has no amplitude, or those of one frequency may cancel")


def signs_of_waves(law: Law) -> dict[Fraction, tuple[int, int]]:
    """Return, for each frequency, the signs of its tones' parts in phase with cos and with sin.

    A frequency with a part that is not zero is one of the force.
    """
    waves: dict[Fraction, list[Tone]] = {}
    for tone in law.tones:
        waves.setdefault(tone.omega / law.base, []).append(tone)
    signs = {}
    for multiple, tones in waves.items():
        # So that a small amplitude is no rounding error.
        unit = max(abs(tone.amplitude) for tone in tones) or 1
        cos = sin = of(0)
        for tone in tones:
            c, s = cosine_and_sine(angle(tone.phase))
            cos, sin = cos + tone.amplitude / unit * c, sin + tone.amplitude / unit * s
        signs[multiple] = cos.sign, sin.sign
    return signs
