"""Chaos that percuss proves, another program proves again; what is changed in it, it refuses."""

from __future__ import annotations

import copy
from fractions import Fraction

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

from chaos import Set, are_apart
from reading import LAW, law_of, read


def test_chaos_is_proven_again(chaos: Claims) -> None:
    words = theorem_of(chaos)

    assert "chaotic" in words
    assert "at least 0.180" in words


@by_name
def test_chaos_that_is_changed_anywhere_is_refused(chaos: Claims, by_name: bool) -> None:
    for path in chosen(leaves(chaos), by_name):
        assert_refused(changed(chaos, path))


@pytest.mark.parametrize("turns", [0, 1, -1, 10**12])
def test_a_set_is_none_of_its_own_whole_periods_later(chaos: Claims, turns: int) -> None:
    period = law_of(read(chaos["law"], LAW)).period()
    t, v = chaos["sets"][0]["center"]
    side, shift = Fraction(1, 50), turns * sum(period.fractions()) / 2
    for off, is_apart in ((Fraction(0), False), (sum(period.fractions()) / 4, True)):
        sets = [
            Set((Fraction(at), Fraction(v)), (side, Fraction(0)), (Fraction(0), side))
            for at in (Fraction(t), Fraction(t) + shift + off)
        ]
        assert are_apart(period, *sets) is is_apart
        assert are_apart(period, *sets[::-1]) is is_apart


def test_chaos_of_no_sets_or_of_one_loop_is_refused(chaos: Claims) -> None:
    itself = [it | {"from": 0, "to": 0} for it in chaos["transitions"]]

    changes: list[Claims] = [
        {"sets": [], "transitions": []},
        {"transitions": []},
        {"sets": chaos["sets"][:1], "transitions": itself},
        {"sets": chaos["sets"][:1]},
        {"growth": "1"},
        {"growth": "1000000001/1000000000"},
    ]
    for change in changes:
        assert_refused(chaos | change)


def test_chaos_says_what_and_where(chaos: Claims) -> None:
    n = len(chaos["sets"])
    words = theorem_of(chaos)
    assert f"the {n} sets of the certificate" in words
    assert "the period of the force, 5/7 pi, is" in words

    flat = copy.deepcopy(chaos)
    flat["sets"][3]["stable"] = flat["sets"][3]["unstable"]
    assert_refused(flat, "of set 3: two sides are parallel")
    # So flat that its sides are parallel to all bits.
    unstable = [Fraction(x) for x in flat["sets"][3]["unstable"]]
    flat["sets"][3]["stable"] = [str(unstable[0] * (1 + Fraction(1, 10**60))), str(unstable[1])]
    assert_refused(flat, r"sets? [0-9]+ (and|to) ")
    # A set through which a graze goes: some of its states do not leave the wall.
    (t, _), (at_t, _) = chaos["sets"][0]["center"], chaos["sets"][0]["unstable"]
    slow = copy.deepcopy(chaos)
    slow["sets"][0] |= {"center": [t, "0"], "unstable": [at_t, "0"], "stable": ["0", "1/100"]}
    assert_refused(slow, "from set 0 to set 0: ")
