"""Proofs of motions whose numbers are expressions: rational ones exactly, others as balls."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
from flint import arb

import percuss as pc
from percuss.certified.ball_law import law_of
from percuss.certified.branch import system_over
from percuss.certified.numbers import precision
from percuss.certified.system import system_of

W = pc.parameter("w", "1.66")
BALL = pc.impact_oscillator("0.15", stiffness=0)
TABLE = pc.cosine(W, amplitude=W**2, constant=-1)


def first_doubling() -> arb:
    """Return the frequency of the first doubling at r = 0.15 (Luo & Han 1996)."""
    r = arb(15) / 100
    one = arb.pi() * (1 - r) / (1 + r)
    return ((one**2 + (2 * (1 + r * r) / (1 + r) ** 2) ** 2).sqrt()).sqrt()


def test_the_doubling_of_the_bouncing_ball_is_enclosed_with_its_closed_form() -> None:
    orbit = pc.find_orbit(BALL, TABLE, n_impacts=1, n_periods=1)
    (doubling,) = pc.continue_orbit(orbit, over={"w": (1.66, 1.79)}).special_points
    proven = pc.certify(doubling, digits=20)
    assert proven.exists
    with precision(200):
        assert proven.value.arb.contains(first_doubling())
        assert float(proven.value.arb.rad()) < 1e-19


def test_a_fold_over_a_tied_parameter_is_that_over_the_number_itself() -> None:
    """The chain rule: the amplitude is the square of s, and a fold is where it is another's."""
    s = pc.parameter("s", 1)
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    points: list[Any] = []
    for force, path, ends in (
        (pc.cosine(1, amplitude=s**2), "s", (1.0, 0.2)),
        (pc.cosine(1), "forcing.amplitude", (1.0, 0.04)),
    ):
        branch = pc.continue_orbit(pc.find_orbit(osc, force), over={path: ends})
        points.append(next(p for p in branch.special_points if p.kind == "fold"))
    tied, own = (pc.certify(point, digits=15) for point in points)
    assert tied.exists
    assert own.exists
    with precision(200):
        assert (tied.value.arb**2).overlaps(own.value.arb)
        assert float(tied.value.arb.rad()) < 1e-14


def test_a_rational_expression_is_proven_as_the_number_that_it_is() -> None:
    run = pc.simulate(BALL, TABLE, x0=0, v0=1, max_impacts=8)
    plain = pc.cosine("1.66", amplitude=Fraction("1.66") ** 2, constant=-1)
    same = pc.simulate(BALL, plain, x0=0, v0=1, max_impacts=8)
    one, other = pc.certify(run, digits=15), pc.certify(same, digits=15)
    assert one.complete
    for mine, theirs in zip(one.impacts.t, other.impacts.t, strict=True):
        assert mine.text(15) == theirs.text(15)


@pytest.mark.parametrize(
    ("osc", "force"),
    [
        (BALL, pc.cosine(pc.expression("sqrt(w)", w=3), amplitude=2, constant=-1)),
        (BALL, pc.cosine(pc.pi_times(1) * pc.parameter("f", "0.5"), amplitude=3, constant=-1)),
        (pc.impact_oscillator("0.8", stiffness=W.sqrt(), damping=W / 10), pc.cosine(2)),
        (pc.impact_oscillator("0.8", damping=pc.expression("sqrt(2)/20")), pc.cosine(2)),
        # From the heights of a drop and of its rebound.
        (pc.impact_oscillator(pc.expression("sqrt(h/d)", h="0.6", d=1)), pc.cosine(2)),
        (pc.impact_oscillator("0.8"), pc.cosine(2, amplitude=W.sqrt(), phase=W.sin())),
        (
            pc.Oscillator(1, 0.1, (pc.SoftStop(0, "below", 20 * W.sqrt()),)),
            pc.fourier(2, cos=(1, W.cos()), constant=-W.sqrt()),
        ),
    ],
)  # fmt: skip
def test_irrational_numbers_are_balls_that_hold_the_float_motion(
    osc: pc.Oscillator, force: pc.Forcing
) -> None:
    run = pc.simulate(osc, force, x0=0.5, v0=1, max_impacts=6)
    proven = pc.certify(run, digits=25)
    assert proven.complete
    table, rows = (
        (proven.impacts, run.impacts) if len(run.impacts) else (proven.crossings, run.crossings)
    )
    assert len(rows) >= 3
    for ball, t in zip(table.t, rows.t, strict=True):
        assert abs(float(ball.arb.mid()) - t) < 1e-11 * max(1.0, t)
        assert float(ball.arb.rad()) < 1e-24 * max(1.0, t)


def test_a_chatter_with_an_irrational_restitution_ends_where_its_closed_form_does() -> None:
    """A ball dropped from 1/2: it rests at sqrt(2 h / g) (1 + r) / (1 - r), here with r^2 = 1/2."""
    osc = pc.impact_oscillator(pc.expression("sqrt(2)/2"), stiffness=0)
    run = pc.simulate(osc, pc.Forcing(constant=-1), x0=0.5, v0=0, t_end=10)
    (contact,) = pc.certify(run, digits=25).contacts.start
    with precision(200):
        r = arb(2).sqrt() / 2
        assert contact.arb.contains((1 + r) / (1 - r))
        assert float(contact.arb.rad()) < 1e-24


def test_the_ball_of_an_irrational_number_is_not_its_float() -> None:
    """An amplitude of sqrt(2): the double nearest to it is another motion, and told apart."""
    root = pc.expression("sqrt(2)")
    runs = [
        pc.simulate(BALL, pc.cosine(2, amplitude=a, constant=-1), x0=0, v0=1, max_impacts=3)
        for a in (root, math.sqrt(2.0))
    ]
    exact, rounded = (pc.certify(run, digits=30) for run in runs)
    assert not exact.impacts.t[2].arb.overlaps(rounded.impacts.t[2].arb)
    system = system_of(BALL, pc.cosine(2, amplitude=root))
    with precision(300):
        number = law_of(system).number("forcing.harmonics.0.amplitude")
        assert number.contains(arb(2).sqrt())
        assert (number**2).contains(2)


def test_a_parameter_may_be_a_ball_where_it_moves_no_stop() -> None:
    run = pc.simulate(BALL, TABLE, x0=0, v0=1, max_impacts=4)
    ends = Fraction("1.66") - Fraction(1, 10**9), Fraction("1.66") + Fraction(1, 10**9)
    over = pc.certify(run, digits=6, over={"w": ends})
    assert over.complete
    for value in (*ends, Fraction("1.66")):
        plain = pc.cosine(value, amplitude=value**2, constant=-1)
        each = pc.certify(pc.simulate(BALL, plain, x0=0, v0=1, max_impacts=4), digits=20)
        for wide, narrow in zip(over.impacts.t, each.impacts.t, strict=True):
            assert wide.arb.contains(narrow.arb)
    orbit = pc.find_orbit(BALL, TABLE)
    assert pc.certify(orbit, digits=5, over={"w": ends}).exists


def test_what_a_proof_cannot_take_is_told_in_one_sentence() -> None:
    d = pc.parameter("d", "0.5")
    wall = pc.impact_oscillator("0.8", wall=-d)
    run = pc.simulate(wall, TABLE, x0=0, v0=1, max_impacts=2)
    assert pc.certify(run).complete
    with pytest.raises(pc.ParameterError, match="the place or restitution of a stop depends on it"):
        pc.certify(run, over={"d": ("0.4", "0.6")})
    with pytest.raises(pc.ParameterError, match="tied to w"):
        pc.certify(run, over={"forcing.amplitude": (1, 2)})
    zero = pc.cosine(2, amplitude=pc.expression("sqrt(2)**2 - 2"))
    with pytest.raises(pc.ParameterError, match="not told from 0"):
        pc.certify(pc.simulate(wall, zero, x0=0, v0=1, max_impacts=1))


def test_stops_that_would_pass_each_other_inside_a_range_are_not_proven() -> None:
    g = pc.parameter("g", "0.3")
    osc = pc.Oscillator(
        stops=(pc.SoftStop((g - "0.5") ** 2, "above", 4), pc.SoftStop("0.01", "above", 9))
    )
    system = system_of(osc, pc.cosine(2))
    with precision(100):
        assert system_over(system, "g", Fraction(1, 5), Fraction(3, 10)).moved
        with pytest.raises(Exception, match="order"):
            system_over(system, "g", Fraction(1, 5), Fraction(7, 10))


def test_irrational_places_starts_and_ends_are_those_of_their_closed_form() -> None:
    """x = sqrt(2) cos(t - sqrt(3)) falls from its start to the wall at 1 below it in pi/4."""
    root = pc.expression("sqrt(2)")
    osc = pc.impact_oscillator("1/2", wall=1)
    start = pc.Start(root, 0, pc.expression("sqrt(3)"))
    run = pc.simulate(osc, start=start, t_end=pc.expression("sqrt(3) + 3*pi/8"))
    proven = pc.certify(run, digits=30)
    assert proven.complete
    with precision(200):
        t, v = proven.impacts.t[0].arb, proven.impacts.v_before[0].arb
        assert t.contains(arb(3).sqrt() + arb.pi() / 4)
        assert v.contains(-1)
        assert max(float(t.rad()), float(v.rad())) < 1e-29
        # After the impact x = cos s + sin s/2.
        x, _ = proven(pc.expression("sqrt(3) + 3*pi/8"))
        s = arb.pi() / 8
        assert x[0].arb.contains(s.cos() + s.sin() / 2)
    # A wall at the irrational place itself, from the middle: after pi/4 at double the amplitude.
    far = pc.simulate(pc.impact_oscillator("1/2", wall=-root), v0=-2, max_impacts=2)
    with precision(200):
        assert pc.certify(far, digits=30).impacts.t[0].arb.contains(arb.pi() / 4)
    # On the wall by its own expression: at rest on it, under a force into it.
    held = pc.simulate(pc.impact_oscillator("1/2", wall=root), pc.sine(1), x0=root, v0=0, t_end=1)
    assert len(pc.certify(held).contacts) == len(held.contacts)


def test_a_start_next_to_an_irrational_stop_is_on_one_side_or_refused() -> None:
    root = pc.expression("sqrt(2)/2")
    osc = pc.impact_oscillator("0.8", wall=root)
    run = pc.simulate(osc, pc.cosine(2), x0=root, v0=1, max_impacts=2)
    assert pc.certify(run).complete
    other = pc.simulate(osc, pc.cosine(2), x0=pc.expression("1/sqrt(2)"), v0=1, max_impacts=2)
    with pytest.raises(pc.ParameterError, match=r"x0 = .*not told from sqrt\(2\)/2 by 300 bits"):
        pc.certify(other)
    # The float at which `simulate` starts on the stop is the stop's exact place.
    at = float(root)
    proven = pc.certify(pc.simulate(osc, pc.cosine(2), x0=at, v0=1, max_impacts=2))
    assert proven.start.x0 == root
    nothing = pc.simulate(osc, pc.cosine(2), x0=1, v0=pc.expression("sqrt(2)**2-2"), t_end=1.0)
    with pytest.raises(pc.ParameterError, match=r"v0 = .*not told from 0 by 4800 bits"):
        pc.certify(nothing)
