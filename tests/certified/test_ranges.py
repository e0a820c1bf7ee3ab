"""A number of the force that is a ball: for all values in it, and so for one that is no fraction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified import Ball
from percuss.errors import ParameterError

WALL = pc.impact_oscillator()


def cosine_ball(m: int, bits: int = 400) -> Ball:
    with ctx.workprec(bits):
        return Ball((arb.pi() / (m + 1)).cos())


@pytest.mark.parametrize("m", [3, 4, 7])
def test_impacts_on_the_subset_are_at_multiples_of_pi_to_all_digits(m: int) -> None:
    force = pc.subset_forcing(m)
    run = pc.simulate(WALL, force, v0="0.25", max_impacts=8)

    exact = pc.certify(run, digits=40, over={"forcing.constant": cosine_ball(m)})
    double = pc.certify(run, digits=40)

    assert exact.complete
    assert exact.over is not None
    assert exact.over[0] == "forcing.constant"
    assert exact.over[1].arb.contains((arb.pi() / (m + 1)).cos().mid())
    assert double.over is None
    times = [(m + 1) * (k // 2) + (m if k % 2 else 0) for k in range(1, 9)]
    for ball, s in zip(exact.impacts.t, times, strict=True):
        assert ball.contains(f"{s}*pi")
        assert ball.digits() > 39
    # The double is another force, and these balls tell: not for m = 2 and 5, whose cosine it holds.
    assert not all(b.contains(f"{s}*pi") for b, s in zip(double.impacts.t, times, strict=True))


def test_a_range_holds_the_runs_of_its_values() -> None:
    osc = pc.impact_oscillator("0.8")
    run = pc.simulate(osc, pc.cosine("2.5"), v0=1, max_impacts=10)

    whole = pc.certify(run, digits=3, over={"forcing.amplitude": ("0.99999", "1.00001")})

    for amplitude in ("0.99999", "0.999995", "1.00001"):
        one = pc.simulate(osc, pc.cosine("2.5", amplitude=amplitude), v0=1, max_impacts=10)
        for all_, here in zip(whole.impacts.t, pc.certify(one).impacts.t, strict=True):
            assert all_.arb.contains(here.arb)
    assert 1e-7 < whole.impacts.t.radius()[-1] < 1e-2


def test_an_orbit_is_proven_for_all_values_of_a_range() -> None:
    osc = pc.impact_oscillator("0.8")
    orbit = pc.find_orbit(osc, pc.cosine("2.5", constant="0.1"))

    whole = pc.certify(orbit, digits=4, over={"forcing.constant": ("0.0999999", "0.1000001")})

    assert whole.exists, whole
    assert whole.over is not None
    assert whole.over[1].contains("0.1")
    assert whole.stability == orbit.stability
    for constant in ("0.0999999", "0.1", "0.1000001"):
        one = pc.certify(pc.find_orbit(osc, pc.cosine("2.5", constant=constant)))
        assert whole.v0.arb.contains(one.v0.arb)
    assert 1e-8 < whole.v0.radius() < 1e-4


def test_a_family_needs_exact_numbers() -> None:
    orbit = pc.find_orbit(WALL, pc.sine(3), n_impacts=2, n_periods=3, guess=(0.0, 0.6))

    proven = pc.certify(orbit, over={"forcing.amplitude": (1, "1.000001")}, most_bits=200)

    assert not proven.exists
    assert "exact numbers" in proven.reason


@pytest.mark.parametrize(
    ("over", "why"),
    [
        ({"forcing.omega": (1, 2)}, "no number of the force"),
        ({"oscillator.damping": (0, 1)}, "no number of the force"),
        ({"forcing.constant": (1, 0)}, "above the second"),
        ({"forcing.constant": "0.5"}, "neither a ball nor two numbers"),
        ({"forcing.constant": Ball(arb.nan())}, "without a number"),
        ({}, "not one parameter"),
    ],
)
def test_other_ranges_are_refused(over: Any, why: str) -> None:
    run = pc.simulate(WALL, pc.sine(3), v0=1, max_impacts=2)

    with pytest.raises(ParameterError, match=why):
        pc.certify(run, over=over)


def test_a_special_point_has_a_parameter_of_its_own() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.4, 2.7)})

    with pytest.raises(ParameterError, match="of its own"):
        pc.certify(branch.special_points[0], over={"forcing.constant": (0, 1)})  # type: ignore[call-overload]


def test_the_motion_on_an_orbit_is_that_of_its_run() -> None:
    osc = pc.backlash_oscillator(gap=1, stiffness=10, damping="0.05")
    orbit = pc.find_orbits(osc, pc.cosine("1.2", amplitude=2), max_impacts=3, max_periods=2)[0]
    proven = pc.certify(orbit)
    t = orbit.t0 + np.linspace(0.01, 0.99, 21) * orbit.period

    x, v = proven(t)
    later, _ = proven(t - 3 * orbit.period)

    run = orbit.trajectory()
    np.testing.assert_allclose(x.mid(), run(t)[0], atol=1e-11)
    np.testing.assert_allclose(v.mid(), run(t)[1], atol=1e-11)
    np.testing.assert_allclose(later.mid(), x.mid(), atol=1e-12)
    assert x.radius().max() < 1e-12


def test_steady_motion_is_enclosed_too() -> None:
    osc = pc.impact_oscillator("0.7", wall=2, side="above", damping="0.05")
    proven = pc.certify(pc.find_orbit(osc, pc.cosine("1.5"), n_impacts=0))

    x, _ = proven("pi/3")

    assert x.shape == ()
    assert math.isclose(float(x.mid()), float(proven([math.pi / 3])[0].mid()[0]), abs_tol=1e-14)


def test_a_range_that_is_too_wide_is_told() -> None:
    run = pc.simulate(pc.impact_oscillator("0.8"), pc.cosine("2.8"), v0=1, max_impacts=30)
    wide = {"forcing.harmonics.0.amplitude": ("0.9", "1.1")}

    proven = pc.certify(run, over=wide, most_bits=256)

    assert not proven.complete
    assert "the range of forcing.harmonics.0.amplitude is too wide" in proven.reason
    assert "too wide" not in pc.certify(run).reason


def test_a_range_that_is_too_wide_is_told_as_that_and_not_as_an_impact_without_velocity() -> None:
    osc, force = pc.impact_oscillator("1/2"), pc.cosine(2)
    run = pc.simulate(osc, force, v0=1, max_impacts=2)
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))

    for what in (run, orbit):
        proven = pc.certify(what, over={"forcing.amplitude": ("0.7", "1.3")}, most_bits=128)
        assert "the box is too wide: the instant of an event is known to" in proven.reason
        assert "velocity" not in proven.reason
