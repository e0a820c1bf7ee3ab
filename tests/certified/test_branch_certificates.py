"""Branches that percuss proves, another program proves again; what is changed in them, it refuses."""

from __future__ import annotations

import copy
import re
from fractions import Fraction
from typing import Any

import pytest
from tests.certified.checker import (
    SOFT,
    WALL,
    Claims,
    assert_refused,
    at_point,
    by_name,
    changed,
    chosen,
    leaves,
    theorem_of,
    two_walls,
    wave,
)

import percuss as pc
from percuss.certified import certificate

DAMPED = pc.impact_oscillator("7/10", damping="1/20", wall="1/5")


def proven_branch(
    osc: pc.Oscillator, force: pc.Forcing, path: str, low: float, high: float, n_events: int = 1
) -> Any:
    orbits = pc.find_orbits(osc, force, max_impacts=1, max_periods=1)
    orbit = next(o for o in orbits if o.admissible and len(o.itinerary) == n_events)
    return pc.certify(pc.continue_orbit(orbit, over={path: (low, high)}))


@pytest.fixture(scope="module")
def branch() -> Claims:
    proven = proven_branch(SOFT, pc.cosine("11/10"), "oscillator.stops.0.at", 0.499, 0.5, 2)
    claims = certificate(proven)
    claims["curves"][0]["strips"] = claims["curves"][0]["strips"][:3]
    return claims


@pytest.fixture(scope="module")
def doubling() -> Claims:
    """The strips next to a doubling, from one that is stable to one that is not."""
    proven = proven_branch(WALL, pc.cosine("2.653"), "forcing.omega", 2.653, 2.6537)
    return at_point(certificate(proven))


@pytest.mark.parametrize(
    ("osc", "force", "path", "low", "high"),
    [
        (WALL, pc.cosine("5/2"), "forcing.omega", 2.5, 2.51),
        (DAMPED, pc.fourier(2, cos=(1, "1/5")), "forcing.cos.1", 0.19, 0.2),
        (DAMPED, pc.cosine("3/2"), "oscillator.stops.0.restitution", 0.70, 0.702),
        (DAMPED, pc.cosine("3/2"), "oscillator.stiffness", 1, 1.001),
        (DAMPED, pc.cosine("3/2"), "oscillator.damping", 0.05, 0.051),
    ],
    ids=["frequency", "amplitude", "restitution", "spring", "damping"],
)
def test_branches_over_each_kind_of_number_are_proven_again(
    osc: pc.Oscillator, force: pc.Forcing, path: str, low: float, high: float
) -> None:
    claims = certificate(proven_branch(osc, force, path, low, high))
    n = len(claims["curves"][0]["strips"])
    assert n > 4

    words = theorem_of(claims)

    assert f"The {n} strips of a curve hold" in words
    assert "They form one smooth curve" in words
    assert "Neighbouring motions approach the orbits" in words
    assert re.search(r"\bp\b", words[words.index("What moves:") :])


def test_a_doubling_on_a_branch_is_proven_again(doubling: Claims) -> None:
    words = theorem_of(doubling)

    said = next(line for line in words.splitlines() if "a multiplier is -1" in line)
    low, high = (Fraction(word.rstrip(".")) for word in said.split() if word.startswith("2.65"))
    # 20 digits by another way: see tests/reference/cases.json, pd-r0.8-n1.
    assert low <= Fraction("2.6533477278553229342") <= high + Fraction(1, 10**9)
    assert high - low < Fraction(1, 10**6)
    for change in (
        {"kind": "fold"},
        {"kind": "graze"},
        {"after": 0},
        {"after": len(doubling["curves"][0]["strips"])},
        {"before": 1, "after": 2},
    ):
        other = copy.deepcopy(doubling)
        other["curves"][0]["points"][0] |= change
        assert_refused(other)


@pytest.mark.nightly
def test_a_branch_round_a_fold_is_proven_again() -> None:
    osc = pc.impact_oscillator("0.7", damping="0.05", wall="2.12", side="above")
    orbits = pc.find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1)
    orbit = next(o for o in orbits if o.n_impacts == 1 and o.is_stable)
    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": (2.12, 2.15)})

    words = theorem_of(certificate(pc.certify(branch)))

    # sigma = G sqrt(1 + (omega k_x / k_d)^2): tests/reference/cases.json, fold-a0.05-r0.7-w1.5.
    (said,) = (line for line in words.splitlines() if "p is extremal along the curve" in line)
    low, high = map(Fraction, re.findall(r"2\.[0-9]+", said))
    assert low <= Fraction("2.1214694431410491882") <= high + Fraction(1, 10**10)
    assert high - low < Fraction(1, 10**9)
    assert "The orbits are unstable" in words


@by_name
def test_a_branch_that_is_changed_anywhere_is_refused(branch: Claims, by_name: bool) -> None:
    theorem_of(branch)
    places = chosen(leaves(branch), by_name)

    assert len(places) > 30
    for path in places:
        assert_refused(changed(branch, path))


def test_strips_left_out_turned_or_of_another_curve_are_refused(branch: Claims) -> None:
    (curve,) = branch["curves"]
    one, two, three = strips = curve["strips"]
    turned = two | {"begin": two["end"], "end": two["begin"]}
    changes: list[Claims] = [
        {"strips": [one, three]},
        {"strips": strips[::-1]},
        {"strips": [one, turned, three]},
        {"strips": []},
        {"events": []},
        {"events": curve["events"][:1]},
        {"periods": "0"},
        {"periods": "1/2"},
        {"periods": "1/3"},
        {"strips": [one | {"sizes": ["0"] * 5}]},
        {"strips": [one | {"sizes": [f"-{size}" for size in one["sizes"]]}]},
        {"strips": [one | {"middle": one["middle"][:-1]}]},
        {"strips": [one | {"end": one["begin"], "middle": [*one["middle"][:-1], one["begin"]]}]},
        {"strips": [one | {"along": 5}]},
        {"strips": [one | {"slow": 0}]},
        {"strips": [one | {"slow": 1, "along": 3}]},
        {"strips": [one | {"slow": 2, "along": 5}]},
    ]
    for change in changes:
        assert_refused(branch | {"curves": [curve | change]})
    assert_refused(branch | {"curves": []})


def test_a_law_without_a_meaning_on_a_branch_is_refused(branch: Claims) -> None:
    for place, number in (
        (("regions", 1, "constant"), ["0", "9"]),
        (("bounds", 0, "at"), ["0", "1/2"]),
        (("tones", 0, "omega"), ["11/10", "-11/5"]),
        (("base",), "11/20"),
    ):
        other = copy.deepcopy(branch)
        parent: Any = other["law"]
        for key in place[:-1]:
            parent = parent[key]
        parent[place[-1]] = number
        assert_refused(other)


def test_a_frequency_that_leaves_its_base_on_a_branch_is_refused() -> None:
    law = two_walls("1") | {
        "tones": [
            {"omega": "1", "amplitude": "1", "phase": ["0", "0"]},
            {"omega": ["0", "1"], "amplitude": "1", "phase": ["0", "0"]},
        ],
        "base": "1",
    }
    # At p = 1, 2 and 3 it is a multiple, but not between.
    strip = {
        "along": 2, "begin": "1", "end": "3", "middle": ["0", "1", "2"], "tangent": ["0", "0", "1"],
        "sizes": ["1/9", "1/9", "0"], "stability": "undecided", "slow": None,
    }  # fmt: skip
    curve = {
        "periods": "1",
        "events": [{"bound": 0, "region": 0}],
        "strips": [strip],
        "points": [],
    }
    claims = {"certificate": 1, "kind": "branch", "law": law, "curves": [curve]}

    assert_refused(claims, "the same multiples of their base")


def test_a_tone_that_vanishes_on_a_branch_is_refused(branch: Claims) -> None:
    p = Fraction(branch["curves"][0]["strips"][0]["middle"][-1])
    for tones in (
        [wave("11/10", "1"), wave("33/10", [str(-p), "1"])],
        [wave("11/10", "1"), wave("33/10", ["0", "1"]), wave("33/10", str(p), "1")],
    ):
        other = copy.deepcopy(branch)
        other["law"]["tones"] = tones
        assert_refused(other, "no amplitude at some parameter")


@pytest.mark.parametrize("gap", [Fraction(1, 10**40), Fraction(1, 2**6000)], ids=["40", "1800"])
def test_strips_with_a_gap_between_them_are_no_curve(branch: Claims, gap: Fraction) -> None:
    (curve,) = branch["curves"]
    first, second, *_ = curve["strips"]
    assert first["along"] == second["along"]
    assert first["end"] == second["begin"]
    sign = 1 if Fraction(second["end"]) > Fraction(second["begin"]) else -1
    begin = Fraction(second["begin"]) + sign * gap
    middle = list(second["middle"])
    middle[second["along"]] = str((begin + Fraction(second["end"])) / 2)
    apart = second | {"begin": str(begin), "middle": middle}

    assert_refused(
        branch | {"curves": [curve | {"strips": [first, apart]}]},
        "the curve is not proven to go on",
    )


def test_strips_that_meet_at_a_third_are_a_curve(branch: Claims) -> None:
    (curve,) = branch["curves"]
    first, *_ = curve["strips"]
    low, high = Fraction(first["begin"]), Fraction(first["end"])
    # No number of units of an interval, however many bits it has.
    third = low + (high - low) / 3
    strips = []
    for begin, end in ((low, third), (third, high)):
        shift = (begin + end) / 2 - (low + high) / 2
        middle = [
            str(Fraction(p) + shift * Fraction(slope))
            for p, slope in zip(first["middle"], first["tangent"], strict=True)
        ]
        strips.append(first | {"begin": str(begin), "end": str(end), "middle": middle})

    assert "The 2 strips" in theorem_of(branch | {"curves": [curve | {"strips": strips}]})
