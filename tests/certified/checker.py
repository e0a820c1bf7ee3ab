"""The program that checks certificates, systems that it is asked about, and what it refuses."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from arithmetic import NotProvenError
from theorems import theorem

CHECKER = Path(__file__).parents[2] / "tools" / "check_certificate"
Claims = dict[str, Any]

# As many digits as a number of a certificate may have.
NINES = "9" * 2000
WALL = pc.impact_oscillator("4/5")
SOFT = pc.Oscillator(
    1,
    damping="1/20",
    stops=(pc.SoftStop(at="1/2", side="above", stiffness=20, damping="1/10"),),
)


def run_of(osc: pc.Oscillator, force: pc.Forcing | None, **start: Any) -> Any:
    return pc.certify(pc.simulate(osc, force, **start))


def two_walls(upper: str) -> Claims:
    """Return the law of a spring between walls, without a force: from rest at 0, x = sin t."""
    return {
        "regions": [{"stiffness": "1", "damping": "0", "constant": "0", "lower": 0, "upper": 1}],
        "bounds": [{"at": "-1/2", "restitution": "1/2"}, {"at": upper, "restitution": "1/2"}],
        "tones": [],
        "base": None,
    }


def wave(omega: str, amplitude: Any, phase: str = "0") -> Claims:
    return {"omega": omega, "amplitude": amplitude, "phase": [phase, "0"]}


def later(orbit: Claims, periods: int) -> Claims:
    """Return an orbit of cos 14 t/5 some periods of the force later, in boxes that are wide enough."""
    shift, wider = periods * Fraction(str(5 * np.pi / 7)), Fraction(1, 10**9)
    events = []
    for event in orbit["events"]:
        low, high = (Fraction(end) + shift for end in event["t"])
        events.append(event | {"t": [str(low - wider), str(high + wider)]})
    return orbit | {"events": events}


def theorem_of(claims: Claims) -> str:
    """Return the theorem of a certificate."""
    return theorem(json.dumps(claims))


def assert_refused(claims: Claims | str, said: str = ".") -> None:
    with pytest.raises(NotProvenError, match=said):
        theorem(claims if isinstance(claims, str) else json.dumps(claims))


def with_value(claims: Claims, place: tuple[Any, ...], value: Any) -> Claims:
    """Return a certificate with another value in a place."""
    other = copy.deepcopy(claims)
    parent: Any = other
    for key in place[:-1]:
        parent = parent[key]
    parent[place[-1]] = value
    return other


def at_point(claims: Claims) -> Claims:
    """Return the strips next to the point of a curve, from one side of it to the other."""
    other = copy.deepcopy(claims)
    (curve,) = other["curves"]
    (point,) = curve["points"]
    first = point["before"]
    curve["strips"] = curve["strips"][first : point["after"] + 1]
    curve["points"] = [point | {"before": 0, "after": point["after"] - first}]
    return other


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in items:
        if isinstance(part, dict | list):
            yield from leaves(part, (*path, key))
        else:
            yield *path, key


# By day one place of each name and coordinate is changed, at night each place.
by_name = pytest.mark.parametrize("by_name", [True, pytest.param(False, marks=pytest.mark.nightly)])


def chosen(places: Iterable[tuple[Any, ...]], by_name: bool) -> list[tuple[Any, ...]]:
    """Return all places or, of those of one name and coordinate, one: the first, the last, ..."""
    alike: dict[Any, list[tuple[Any, ...]]] = {}
    for path in places:
        names = tuple(key for key in path if isinstance(key, str))
        alike.setdefault((names, path[-1]) if by_name else path, []).append(path)
    return [paths[-k % len(paths)] for k, paths in enumerate(alike.values())]


def changed(claims: dict[str, Any], path: tuple[Any, ...]) -> str:
    """Return a certificate with another value in a place, so far off that no claim allows it."""
    value: Any = claims
    for key in path:
        value = value[key]
    if isinstance(value, int):
        other: Any = value + 1
    elif value is None:
        other = 0
    elif value in ("asymptotic", "unstable"):
        other = "unstable" if value == "asymptotic" else "asymptotic"
    elif isinstance(value, str) and value[-1].isdigit():
        # The lower end of an interval goes up, the upper end down.
        other = str(Fraction(value) + (-1 if path[-1] == 1 else 1) * Fraction(3, 7))
    else:
        other = f"{value}?"
    return json.dumps(with_value(claims, path, other))
