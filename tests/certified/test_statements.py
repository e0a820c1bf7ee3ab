from __future__ import annotations

import math
from fractions import Fraction
from typing import Literal

import numpy as np
import pytest

import percuss as pc
from percuss.certified.statements import critical_velocity, keeps_eigenset
from percuss.errors import ParameterError

WALL = pc.impact_oscillator()


@pytest.mark.parametrize(
    ("n", "v0", "holds"),
    [
        (3, "0.51", True),
        (3, "0.49", False),
        (3, "0.5000000000000001", True),
        (3, "0.4999999999999999", False),
        # Exactly critical: the second flight touches the wall half way.
        (3, "0.5", None),
        (5, "0.3", True),
        (5, "0.2", False),
        # Even harmonics grow from rest (Dyskin et al. 2012, eq. 18).
        (2, 0, True),
        (4, 0, True),
    ],
)
def test_impacts_keep_to_the_eigenset_for_ever_or_provably_not(
    n: int, v0: str, holds: bool | None
) -> None:
    verdict = keeps_eigenset(WALL, pc.sine(n), v0)

    assert verdict.holds is holds
    assert math.isinf(verdict.n_impacts)
    assert str(verdict).startswith({True: "certified:", False: "certified to", None: "open"}[holds])


def test_a_verdict_agrees_with_runs() -> None:
    for v0 in np.linspace(0.02, 0.7, 23):
        verdict = keeps_eigenset(WALL, pc.sine(3), float(v0))
        run = pc.simulate(WALL, pc.sine(3), v0=float(v0), max_impacts=12)
        on = np.allclose(run.impacts.t, np.arange(1, 13) * math.pi, atol=1e-9)
        assert verdict.holds is on


def test_a_velocity_that_falls_keeps_to_it_for_a_while() -> None:
    force = pc.sine(2, amplitude=-1)  # V falls by 4/3 an impact
    run = pc.simulate(WALL, force, v0=10, max_impacts=12)
    on = np.isclose(run.impacts.t, np.arange(1, 13) * math.pi, atol=1e-9)
    last = int(np.argmin(on))

    assert 3 < last < 12
    assert keeps_eigenset(WALL, force, 10, n_impacts=last).holds is True
    assert keeps_eigenset(WALL, force, 10, n_impacts=last + 1).holds is False
    assert keeps_eigenset(WALL, force, 10).holds is False


@pytest.mark.parametrize(
    ("osc", "force", "why"),
    [
        (pc.impact_oscillator("0.9"), pc.sine(3), "elastic"),
        (pc.impact_oscillator(damping="0.1"), pc.sine(3), "damping"),
        (pc.impact_oscillator(wall="0.1"), pc.sine(3), "equilibrium"),
        (WALL, pc.sine("2.7"), "multiple"),
        (WALL, pc.sine(1), "multiple"),
        (WALL, pc.cosine(2), "even harmonics"),
        (pc.backlash_oscillator(gap=1, stiffness=3), pc.sine(3), "one wall"),
    ],
)
def test_what_the_closed_form_does_not_hold_for_is_open(
    osc: pc.Oscillator, force: pc.Forcing, why: str
) -> None:
    verdict = keeps_eigenset(osc, force, 1)

    assert verdict.holds is None
    assert why in verdict.reason


def test_another_place_side_and_spring_are_the_same() -> None:
    osc = pc.impact_oscillator(wall="0.5", side="above", stiffness=4)
    force = pc.Forcing((pc.Harmonic(4, 6, "-pi/2"),), constant=2)

    # Scaled: x - 1/2 = -y, tau = 2 t; y'' + y = -sin(3 tau), a start off the wall has v < 0.
    found = [keeps_eigenset(osc, force, v0).holds for v0 in (-3, "-0.01")]

    assert found == [True, False]


def test_critical_velocities_of_the_paper_are_enclosed() -> None:
    three = critical_velocity(WALL, pc.sine(3), "0.1", 1)
    five = critical_velocity(WALL, pc.sine(5), "0.1", 1)
    seven = critical_velocity(WALL, pc.sine(7), "0.1", 1, digits=18)

    assert three.contains(Fraction(1, 2))
    assert five.contains(Fraction(25, 96))  # 0.26041666...
    assert abs(seven.mid() - 0.17981521478001872551) < 1e-15
    assert min(ball.digits() for ball in (three, five)) >= 11.9
    assert seven.digits() >= 17.9


def test_velocities_that_do_not_bracket_it_are_refused() -> None:
    with pytest.raises(ParameterError, match="low"):
        critical_velocity(WALL, pc.sine(3), 1, 2)


@pytest.mark.parametrize(("side", "v0"), [("below", "-1"), ("above", "5")])
def test_a_velocity_into_the_wall_is_refused(side: Literal["below", "above"], v0: str) -> None:
    wall = pc.impact_oscillator(side=side)

    with pytest.raises(ParameterError, match="into the wall"):
        keeps_eigenset(wall, pc.sine(3), v0)


@pytest.mark.parametrize("n_impacts", [0, -1, 1.5, True])
def test_no_impacts_are_no_statement(n_impacts: int) -> None:
    with pytest.raises(ParameterError, match="n_impacts"):
        keeps_eigenset(WALL, pc.sine(3), 1, n_impacts=n_impacts)


def test_what_is_open_or_false_is_not_true() -> None:
    verdicts = [keeps_eigenset(WALL, pc.sine(3), v0) for v0 in ("0.51", "0.5", "0.49")]

    assert [bool(verdict) for verdict in verdicts] == [True, False, False]


@pytest.mark.parametrize("digits", [20, pytest.param(100, marks=pytest.mark.nightly)])
def test_a_critical_velocity_has_the_digits_that_were_asked_for(digits: int) -> None:
    five = critical_velocity(WALL, pc.sine(5), "0.1", 1, digits=digits)

    assert five.contains(Fraction(25, 96))
    assert five.digits() >= digits - 0.1


@pytest.mark.parametrize("digits", [0, -3, 2.5, True])
def test_digits_are_a_whole_number_from_1_on(digits: int) -> None:
    with pytest.raises(ParameterError, match="digits"):
        critical_velocity(WALL, pc.sine(3), "0.1", 1, digits=digits)


def falling(amount: Fraction) -> pc.Forcing:
    """A force whose even harmonics add -4/3 of the amount to the velocity at each impact."""
    b = Fraction(1, 3)
    return pc.sine(2, -2 * b / 5 - amount) + pc.sine(4, b)


@pytest.mark.parametrize("exponent", [20, 80])
def test_a_gain_of_velocity_at_a_hairs_breadth_of_zero_has_its_sign(exponent: int) -> None:
    hair = Fraction(1, 10**exponent)

    for side, holds in ((1, False), (0, True), (-1, True)):
        verdict = keeps_eigenset(WALL, falling(side * hair), 2)
        assert verdict.holds is holds, (side, verdict)
        # Two impacts do not ask whether it falls; nor do a million at this rate.
        assert keeps_eigenset(WALL, falling(side * hair), 2, n_impacts=2).holds is True
        assert keeps_eigenset(WALL, falling(side * hair), 2, n_impacts=10**6).holds is True


def test_a_velocity_that_runs_out_exactly_at_the_last_flight_is_told_in_rationals() -> None:
    # V falls by 1/3 + 1e-60 an impact: with 1 it has run out before the fourth flight by 3e-60.
    gain = Fraction(1, 3) + Fraction(1, 10**60)
    force = pc.sine(2, amplitude=-gain * Fraction(3, 4)) + pc.sine(3, "0.0001")

    last = keeps_eigenset(WALL, force, 1, n_impacts=4)

    assert last.holds is False


def test_a_gain_whose_sign_no_ball_tells_is_claimed_for_a_number_of_impacts_only() -> None:
    # Place and velocity of these are zero at the start, the velocity by sines that are irrational:
    # 3/6 - 10/30 - 1/6, and 2 sin(pi/3) (3/3 - 20/15 + 1/3).
    parts = ((3, 2, "pi/3"), (-10, 4, "pi/3"), (1, 2, "2*pi/3"))
    force = pc.Forcing(tuple(pc.Harmonic(*part) for part in parts))

    forever = keeps_eigenset(WALL, force, 20)

    assert forever.holds is None
    assert "whether the velocity falls" in forever.reason
    assert keeps_eigenset(WALL, force, 20, n_impacts=1000).holds is True
