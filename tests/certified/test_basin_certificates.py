"""Basins that percuss proves, another program proves again; what is changed in them, it refuses."""

from __future__ import annotations

import copy
import json
import re
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from tests.certified.checker import (
    Claims,
    assert_refused,
    by_name,
    changed,
    chosen,
    leaves,
    theorem_of,
)

import percuss as pc
from arithmetic import NotProvenError, bits
from basins import SET_BITS, check_cell, trap_of
from orbits import proven_orbit
from percuss.certified import CertifiedBasins, certificate, prove_basins
from percuss.errors import ParameterError
from reading import FORMS, LAW, ORBIT, law_of, read
from theorems import theorem
from words import told

OSC, FORCE = pc.impact_oscillator("0.6"), pc.cosine("2.2")
# An orbit with an impact and the motion without one, both stable (a gap, with damping).
GAP, SLOW = (
    pc.impact_oscillator("0.7", wall="1.45789", side="above", damping="0.05"),
    pc.cosine("1.5"),
)


@pytest.fixture(scope="module")
def basins() -> CertifiedBasins:
    orbit = pc.find_orbit(OSC, FORCE)
    # The first column of cells lies beyond the wall, the second touches it.
    return prove_basins(orbit, x0=("-0.1", "0.3"), v0=("0.25", "0.4"), cells=(4, 2), depth=1)


@pytest.fixture(scope="module")
def claims(basins: CertifiedBasins) -> Claims:
    """A certificate with two rectangles, and a trap of a third, without stages: proven sooner."""
    whole = certificate(basins)
    (trap,) = whole["orbits"][0]["traps"]
    trap["axes"] = [[str(Fraction(x) / 3) for x in row] for row in trap["axes"]]
    trap["stages"] = []
    near = [it for it in whole["cells"] if Fraction(it["x"][0]) > Fraction(1, 10)]
    return whole | {"cells": near[:2]}


def with_cell(claims: Claims, **change: Any) -> str:
    """Return a certificate with something else in its first rectangle."""
    return json.dumps(claims | {"cells": [claims["cells"][0] | change, *claims["cells"][1:]]})


def area(cells: list[Any]) -> Fraction:
    sides = [[Fraction(b) - Fraction(a) for a, b in (it["x"], it["v"])] for it in cells]
    return sum((x * v for x, v in sides), Fraction(0))


def test_basins_of_an_orbit_are_proven_again(basins: CertifiedBasins) -> None:
    proven = certificate(basins)
    assert len(basins.parts) > 0
    assert float(area(proven["cells"])) == pytest.approx(basins.areas[0])

    words = theorem_of(proven)

    assert f"in {len(proven['cells'])} rectangles of the plane" in words
    assert "Nothing is claimed of other starts" in words
    assert f"an area of {told(area(proven['cells']))}, rounded down" in words
    assert "from x = 0.05 to 0.299999999 and v = 0.25 to 0.4, about, go to orbit 0" in words


def test_parts_of_open_cells_are_rectangles_of_their_own(basins: CertifiedBasins) -> None:
    assert (basins.labels[:2] == [[-2, -2], [-1, -1]]).all()
    assert set(basins.labels_of_parts) == {0}
    assert (basins.parts[:, 0] == 0.05).all()
    whole = (basins.labels == 0).sum() * 0.1 * 0.075
    sides = np.diff(basins.parts)[:, ::2]
    assert whole + np.prod(sides, axis=1).sum() == pytest.approx(basins.areas[0])


@pytest.fixture(scope="module")
def two() -> Claims:
    """Starts next to the motion without impacts, which is the first of two attractors, and the other."""
    known = {f"({o.n_impacts:g}, 1)": o for o in pc.find_orbits(GAP, SLOW, 1, 1) if o.is_stable}
    claims: list[Claims] = []
    for near in (known["(0, 1)"], known["(1, 1)"]):
        x, v = (float(value) for value in near.trajectory(2)(near.period))
        ends = (x - 1e-3, x + 1e-3), (v - 1e-3, v + 1e-3)
        attractors = [known["(0, 1)"], known["(1, 1)"]]
        claims.append(
            certificate(prove_basins(attractors, x0=ends[0], v0=ends[1], cells=1, depth=0))
        )
    first, other = claims
    assert first["orbits"] == other["orbits"]
    first["orbits"][0]["traps"][0]["stages"] = []
    return first | {"cells": [*first["cells"], *other["cells"]]}


def test_a_basin_of_a_motion_without_impacts_is_proven_again() -> None:
    orbits = pc.find_orbits(GAP, SLOW, 1, 1)
    (steady,) = (o for o in orbits if o.is_stable and o.n_impacts == 0)
    x, v = (float(value) for value in steady.trajectory(2)(steady.period))
    claims = certificate(
        prove_basins(steady, x0=(x - 1e-3, x + 1e-3), v0=(v - 1e-3, v + 1e-3), cells=2, depth=0)
    )
    assert (claims["orbits"], claims["steady"], len(claims["cells"])) == ([], [0], 1)

    words = theorem_of(claims)

    assert "Orbit 0: The motion in region 0 that repeats itself and meets no stop." in words
    assert "0.000004, rounded down" in words
    for regions, reason in (([1], "is none, or"), ([0, 0], "stands twice"), ([], "not there")):
        assert_refused(claims | {"steady": regions}, reason)
    other = copy.deepcopy(claims)
    other["law"]["regions"][0]["damping"] = "0"
    assert_refused(other, "do not decay")
    # A wall that the motion reaches.
    other = copy.deepcopy(claims)
    other["law"]["bounds"][0]["at"] = "3/4"
    assert_refused(other, "not proven to go where it says")


@pytest.mark.nightly
def test_basins_of_a_motion_without_impacts_and_of_an_orbit_are_proven_again(two: Claims) -> None:
    assert [it["to"] for it in two["cells"]] == [1, 0]
    assert two["steady"] == [0]

    words = theorem_of(two)

    assert "Orbit 1: The motion in region 0 that repeats itself and meets no stop." in words
    assert "go to orbit 0" in words
    for k in range(2):
        cells = copy.deepcopy(two["cells"])
        cells[k]["to"] = 1 - cells[k]["to"]
        assert_refused(two | {"cells": cells}, "not proven to go where it says")


@by_name
def test_basins_that_are_changed_anywhere_are_refused(claims: Claims, by_name: bool) -> None:

    def told_of(text: str) -> str:
        # How many parts it takes is no part of what is claimed.
        return re.sub(r"\(proven on [0-9]+ parts", "", theorem(text))

    said = told_of(json.dumps(claims))
    for path in chosen(leaves(claims), by_name):
        if (path[0] in ("cells", "t") and path[-1] != "to") or "traps" in path:
            # Starts nearby and other sets may be as good: but what is told is of these starts.
            try:
                other = told_of(changed(claims, path))
            except NotProvenError:
                continue
            assert (other == said) == ("traps" in path)
            continue
        assert_refused(changed(claims, path))


def test_rectangles_that_are_none_or_lie_on_a_stop_are_refused(claims: Claims) -> None:
    (one, two) = claims["cells"]
    for change, reason in (
        ({"x": [one["x"][0], one["x"][0]]}, "has no area"),
        ({"v": one["v"][::-1]}, "has no area"),
        ({"x": ["-1/100", "1/100"]}, "lies on a stop or beyond a wall"),
        ({"x": ["0", "1/100"]}, "lies on a stop or beyond a wall"),
        ({"x": ["-2", "-1"]}, "lies on a stop or beyond a wall"),
        ({"to": 1}, "an orbit that is not there"),
        ({"x": two["x"], "v": two["v"]}, "overlaps another one"),
        # So wide that most of it is proven, and some of it grazes.
        ({"x": ["1/1000", "1/100"], "v": ["-1/2", "0"]}, "not proven to go where it says"),
    ):
        assert_refused(with_cell(claims, **change), reason)
    assert_refused(claims | {"cells": []}, "no cell is claimed")


def test_starts_that_chatter_are_refused(claims: Claims) -> None:
    """Next to the wall, at rest, when the force points to it."""
    cell = {"x": ["1/1000000", "1/500000"], "v": ["-1/1000", "1/1000"], "to": 0}
    assert_refused(claims | {"t": ["5/11", "0"], "cells": [cell]}, "not proven to go where it says")


def test_a_trap_that_is_none_is_refused(claims: Claims) -> None:
    (it,) = claims["orbits"]
    (trap,) = it["traps"]
    wide = [[str(24 * Fraction(x)) for x in row] for row in trap["axes"]]
    for change, reason in (
        ({"axes": wide}, "mapped into itself"),
        ({"axes": [["1", "2"], ["2", "4"]]}, "parallel"),
        ({"event": 1}, "no event of its orbit"),
        ({"rounds": 0}, "no rounds"),
        ({"rounds": 100}, "more than 60 events"),
        ({"stages": ["1/2"]}, "below 1"),
        ({"stages": ["-2"]}, "below 1"),
        ({"stages": ["150"]}, "not proven to come in"),
    ):
        orbits = [it | {"traps": [trap | change]}]
        assert_refused(claims | {"orbits": orbits}, reason)
    assert_refused(claims | {"orbits": [it | {"traps": []}]}, "not proven to go where it says")


def test_an_orbit_under_two_numbers_is_refused(claims: Claims) -> None:
    (it,) = claims["orbits"]
    orbit = it["orbit"]
    twice = orbit | {"periods": 2, "events": []}
    for k in range(2):
        shift = k * 2 * Fraction(
            "3.141592653589793238462643383279502884"
        ) / Fraction(claims["law"]["base"])  # fmt: skip
        twice["events"] = [
            *twice["events"],
            *(
                event | {"t": [str(Fraction(t) + shift) for t in event["t"]]}
                for event in orbit["events"]
            ),
        ]
    assert "2 events in 2 periods" in proven_orbit(
        law_of(read(claims["law"], LAW)), read(twice, ORBIT)
    )
    for other in (orbit, twice):
        orbits = [it, it | {"orbit": other}]
        assert_refused(claims | {"orbits": orbits}, "orbits 0 and 1 may be one")


def test_a_saddle_has_no_trap() -> None:
    """Deliberately wrong: a small set about an orbit that repels."""
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.8")
    orbit = certificate(pc.certify(pc.find_orbit(osc, force)))
    small = {
        "event": 0,
        "axes": [["1/1000", "0"], ["0", "1/1000"]],
        "rounds": 1,
        "stages": [],
    }
    claims = {
        "certificate": 1,
        "kind": "basins",
        "law": orbit["law"],
        "t": ["0", "0"],
        "orbits": [
            {
                "orbit": {key: orbit[key] for key in ("periods", "events", "stability")},
                "traps": [small],
            }
        ],
        "steady": [],
        "cells": [{"x": ["1", "2"], "v": ["0", "1"], "to": 0}],
    }

    assert_refused(claims, "mapped into itself")


def test_basins_cut_off_or_of_another_version_are_refused(claims: Claims) -> None:
    text = json.dumps(claims)

    for part in (text[:-1], text[: len(text) // 2]):
        assert_refused(part, "cut off or changed")
    assert_refused(claims | {"certificate": 3}, "version 3")
    assert_refused(claims | {"open": "0"}, "cut off or changed")


def test_basins_of_which_nothing_is_proven_have_no_certificate() -> None:
    orbit = pc.find_orbit(OSC, FORCE)
    nothing = prove_basins(orbit, x0=("0.1", 3), v0=(-2, 2), cells=1, depth=0)
    with pytest.raises(ParameterError, match="no cell is proven"):
        certificate(nothing)


@pytest.mark.parametrize("n", [40, pytest.param(100, marks=pytest.mark.nightly)])
def test_rectangles_that_are_proven_hold_motions_of_the_float_engine(
    claims: Claims, n: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Starts of rectangles that the program proves by itself, whatever percuss said of them."""
    law = law_of(read(claims["law"], LAW))
    (it,) = read(claims["orbits"], FORMS["basins"]["orbits"])
    orbit = pc.find_orbit(OSC, FORCE)
    rng = np.random.default_rng(5)
    n_proven = 0
    with bits(SET_BITS):
        traps = [trap_of(law, it["orbit"], it["traps"][0])]
        monkeypatch.setattr("basins.SMALLEST_PART", Fraction(1, 2))
        for _ in range(n):
            x, v = rng.uniform(0.0, 2.0), rng.uniform(-2.0, 2.0)
            cell = {
                "x": (Fraction(x), Fraction(x + 0.01)),
                "v": (Fraction(v), Fraction(v + 0.01)),
            }
            try:
                check_cell(law, (Fraction(0), Fraction(0)), cell, traps)
            except NotProvenError:
                continue
            n_proven += 1
            run = pc.simulate(OSC, FORCE, x0=x + 0.005, v0=v + 0.005, t_end=80 * orbit.period)
            last = run.impacts.v_after[-1]
            assert last == pytest.approx(float(orbit.impacts.v_after[0]), abs=1e-4)
    assert n_proven > n / 4
