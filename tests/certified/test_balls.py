from __future__ import annotations

import math

import numpy as np
from flint import acb, arb, ctx

from percuss.certified import Ball, Balls, ComplexBall
from percuss.certified.ball_arithmetic import upwards


def test_midpoint_and_radius_as_floats_hold_the_ball() -> None:
    with ctx.workprec(300):
        ball = Ball(arb(2).sqrt())
        exact = arb(2).sqrt()
        # The float is off by its rounding, and the radius says so.
        assert 0 < ball.radius() < 2e-16
        assert abs(exact - arb(ball.mid())) < ball.radius()
        assert ball.digits() > 80


def test_exact_and_unbounded_balls() -> None:
    assert Ball(arb(3)).radius() < 1e-300
    assert Ball(arb(3)).digits() == math.inf
    assert Ball(arb(0, 1)).digits() == -math.inf
    assert Ball(arb.pos_inf()).radius() == math.inf
    assert math.isnan(Ball(arb.nan()).radius())
    assert float(Ball(arb(0.5))) == 0.5


def test_columns_and_their_shapes() -> None:
    column = Balls.of([arb(1), arb(2, 0.5), arb(3), arb(4)], (2, 2))

    assert column.mid().tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert column.radius().shape == column.digits().shape == (2, 2)
    np.testing.assert_allclose(column.radius()[0, 1], 0.5, rtol=1e-8)
    assert [ball.contains(k) for k, ball in enumerate(column, 1)] == [True] * 4
    assert repr(column).startswith("<Balls: 4, 0.602 digits")
    assert repr(Balls(())) == "<Balls: 0>"


def test_containment_is_of_exact_numbers() -> None:
    with ctx.workprec(128):
        third = Ball(arb(1) / 3)
        assert third.contains("1/3")
        assert not third.contains(1 / 3)
        assert Ball(arb.pi() * 20).contains("20*pi")
        assert third.overlaps(Ball(arb(1) / 3))
        assert not third.overlaps(Ball(arb(1)))


def test_complex_balls() -> None:
    ball = ComplexBall(acb(1, -2))

    assert ball.mid() == 1 - 2j
    assert ball.radius() < 1e-300
    assert ball.imag.contains(-2)
    assert repr(ball).startswith("<ComplexBall")


def test_decimals_hold_the_number_whatever_their_length_and_size() -> None:
    with ctx.workprec(2000):
        root, tiny = arb(2).sqrt(), arb(10) ** -700 / 3
    for exact in (root, tiny, -root, arb(1) / 4):
        for digits in (1, 5, 30):
            text, radius = Ball(exact).decimals(digits)
            with ctx.workprec(3000):
                off = abs(exact - arb(text))
                assert off <= arb(radius) * (1 + arb(10) ** -100)
    assert Ball(arb(3)).decimals(2) == ("3.0", "0")
    assert Ball(arb.nan()).decimals(5) == ("nan", "inf")
    assert float(Ball(tiny).decimals(5)[1]) == 0.0
    assert Ball(tiny).decimals(5)[1].endswith("e-706")


def test_a_radius_is_rounded_up() -> None:
    for value in ("0.9994", "0.99951", "1.004999", "9.999e-400", "1"):
        exact = arb(value).mid()
        with ctx.workprec(200):
            assert arb(upwards(exact)).mid() * (1 + arb(2) ** -50) >= exact
            assert arb(upwards(exact)) < exact * arb("1.02")


def test_a_number_that_no_comparison_tells_from_a_ball_may_lie_in_it_and_is_not_claimed_to() -> (
    None
):
    # 1/3 to all bits that are compared in, without a radius: it is not 1/3.
    with ctx.workprec(8192):
        ball = Ball((arb(1) / 3).mid())

    assert ball.may_contain("1/3")
    assert not ball.contains("1/3")
    assert not ball.may_contain("1/2")
    assert Ball(arb("0.5", 0.25)).contains("1/3")
