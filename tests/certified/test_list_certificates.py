"""Complete lists that percuss proves, another program proves again; others it refuses."""

from __future__ import annotations

import copy
import json

import pytest
from tests.certified.checker import (
    WALL,
    Claims,
    assert_refused,
    changed,
    later,
    leaves,
    theorem_of,
)

import percuss as pc
from percuss.certified import certificate, list_orbits
from theorems import theorem


@pytest.mark.parametrize(
    ("osc", "kind", "n_orbits"),
    [
        (WALL, (1, 1), 1),
        (WALL, (1, 2), 0),
        pytest.param(WALL, (2, 2), 2, marks=pytest.mark.nightly),
        (pc.impact_oscillator("7/10", damping="1/20", wall="41/20", side="above"), (1, 1), 2),
    ],
    ids=["one", "none", "two impacts", "wall above"],
)
def test_complete_lists_are_proven_again(
    osc: pc.Oscillator, kind: tuple[int, int], n_orbits: int
) -> None:
    force = pc.cosine("14/5" if osc is WALL else "3/2")
    found = list_orbits(osc, force, *kind, speeds=("1/5", 3))
    assert len(found.orbits) + len(found.shorter) == n_orbits

    words = theorem_of(certificate(found))

    assert f"is among {n_orbits} orbit" in words
    assert words.count("There is one periodic orbit, and one only") == n_orbits


@pytest.mark.parametrize(
    ("osc", "force", "periods"),
    [
        (
            pc.impact_oscillator("51/100", side="above", damping="7/50"),
            pc.cosine("7/4", "89/100", "203/100"),
            2,
        ),
        (
            pc.impact_oscillator("47/100", stiffness="81/50"),
            pc.cosine("29/20", "141/100", "-7/10"),
            2,
        ),
    ],
    ids=["above", "below"],
)
def test_a_box_is_a_hint_of_which_a_part_may_be_proven(
    osc: pc.Oscillator, force: pc.Forcing, periods: int
) -> None:
    # Those of percuss are as wide as its own bounds allow, and formal orbits have no others.
    claims = certificate(list_orbits(osc, force, 1, periods, speeds=("1/10", 4)))

    assert claims["boxes"]
    assert "is among 0 orbits" in theorem_of(claims)


def test_a_list_that_is_changed_anywhere_is_refused(complete: Claims) -> None:
    theorem_of(complete)

    for path in leaves(complete):
        if path[0] in ("speeds", "cycle"):
            # A smaller region is another theorem, as true, and it is the one that is told.
            end = json.loads(changed(complete, path))[path[0]][path[1]]
            assert end in theorem(changed(complete, path)).splitlines()[0]
            continue
        assert_refused(changed(complete, path))


def test_a_list_without_one_of_its_orbits_is_refused(complete: Claims) -> None:
    (orbit,) = complete["orbits"]
    wide = {"cycle": ["1/2", "11/10"], "v": ["1/5", "3"]}
    for change, reason in (
        ({"orbits": []}, "may hold an orbit"),
        ({"boxes": []}, "an orbit may be missing"),
        ({"orbits": [], "boxes": []}, "an orbit may be missing"),
        ({"boxes": [wide]}, "."),
        ({"orbits": [orbit | {"periods": 2}]}, "."),
        ({"impacts": 2}, "has not the impacts"),
        ({"impacts": 0}, "region of a list is empty"),
        ({"cycle": ["0", "2"]}, "region of a list is empty"),
        ({"speeds": ["0", "3"]}, "reaches to speed 0"),
    ):
        assert_refused(complete | change, reason)
    other = copy.deepcopy(complete)
    other["law"]["regions"][0]["upper"] = 1
    other["law"]["bounds"].append({"at": "9", "restitution": "1"})
    assert_refused(other, "one wall and no other stop")


def test_an_orbit_counts_once_in_a_list(complete: Claims) -> None:
    (orbit,) = complete["orbits"]

    assert "is among 1 orbit (" in theorem_of(complete | {"orbits": [later(orbit, 0)]})
    for again in (orbit, later(orbit, 0), later(orbit, 1), later(orbit, -7)):
        assert_refused(complete | {"orbits": [orbit, again]}, "orbits 0 and 1 may be one")


def test_a_solution_that_passes_through_the_wall_is_no_orbit_of_a_list() -> None:
    osc = pc.impact_oscillator("4/5", wall="1/5")
    found = list_orbits(osc, pc.cosine("7/2"), speeds=("1/20", 2))
    assert (len(found), found.n_formal) == (1, 1)

    words = theorem_of(certificate(found))

    assert "is among 1 orbit (" in words
