from __future__ import annotations

import pytest
from flint import arb, arb_mat

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.shooting import krawczyk, unique_in


def value(z: list[arb]) -> arb_mat:
    """x^2 - y = 0, x - y^2 = 0: solutions (0, 0) and (1, 1)."""
    x, y = z
    return arb_mat([[x * x - y], [x - y * y]])


def derivative(z: list[arb]) -> arb_mat:
    x, y = z
    return arb_mat([[2 * x, arb(-1)], [arb(1), -2 * y]])


def test_a_simple_solution_is_found_in_a_box_around_it() -> None:
    found = krawczyk(value, derivative, [arb("0.9999999"), arb("1.0000001")])

    assert all(ball.contains(1) for ball in found.box)
    assert all(ball.rad() < 1e-12 for ball in found.box)
    assert all(outer.contains(inner) for outer, inner in zip(found.trial, found.box, strict=True))


def test_where_there_is_no_solution_none_is_claimed() -> None:
    for point in ([arb("0.9"), arb(-3)], [arb(2), arb(2)]):
        with pytest.raises(Undecided):
            krawczyk(value, derivative, point)


def test_a_double_solution_is_not_claimed_to_be_alone() -> None:
    with pytest.raises(Undecided):
        krawczyk(
            lambda z: arb_mat([[z[0] * z[0]]]),
            lambda z: arb_mat([[2 * z[0]]]),
            [arb("0.0000001")],
        )


def test_uniqueness_is_claimed_in_boxes_with_one_solution_only() -> None:
    one = [arb(1), arb(1)]

    assert unique_in(derivative, value, one, [arb("0.1"), arb("0.1")])
    # (0, 0) lies in it as well.
    assert not unique_in(derivative, value, one, [arb("1.2"), arb("1.2")])
    # And here is none.
    assert not unique_in(derivative, value, [arb(1), arb("0.5")], [arb("0.1"), arb("0.1")])
