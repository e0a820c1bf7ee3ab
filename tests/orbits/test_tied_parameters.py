"""Orbits over parameters in expressions: the bouncing ball, whose force follows its frequency.

A ball on a table of amplitude 1 under gravity 1 with restitution 0.15, over the table's frequency
(homework of the Universidad de Chile, FI3104B 2015, problem 2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.errors import ParameterError
from percuss.model import replace_parameter

RESTITUTION = 0.15
W = pc.parameter("w", "1.66")
BALL = pc.impact_oscillator("0.15", stiffness=0)
TABLE = pc.cosine(W, amplitude=W**2, constant=-1)
# By continuation in the amplitude at fixed frequency, time scaled by it (published table: N7).
DOUBLINGS = [1.670269622, 1.729801446, 1.743244263, 1.746157753, 1.746783373, 1.746917435]


def first_doubling(r: float) -> float:
    """Return the frequency of the first doubling of the ball, which returns once a period.

    The multiplier is -1 where (A w^2 / g)^2 = (pi (1 - r) / (1 + r))^2 +
    (2 (1 + r^2) / (1 + r)^2)^2 (Luo & Han 1996), here with A = g = 1.
    """
    level = math.hypot(math.pi * (1.0 - r) / (1.0 + r), 2.0 * (1.0 + r * r) / (1.0 + r) ** 2)
    return math.sqrt(level)


@pytest.fixture(scope="module")
def orbit() -> pc.PeriodicOrbit:
    return pc.find_orbit(BALL, TABLE, n_impacts=1, n_periods=1)


def test_the_multiplier_of_the_bouncing_ball(orbit: pc.PeriodicOrbit) -> None:
    assert min(orbit.multipliers.real) == pytest.approx(-0.91514, abs=5e-6)


def test_the_cascade_of_the_bouncing_ball_over_the_frequency_in_one_call(
    orbit: pc.PeriodicOrbit,
) -> None:
    cascade = pc.follow_cascade(orbit, over={"w": (1.66, 1.79)})
    assert [point.value for point in cascade.points] == pytest.approx(DOUBLINGS, abs=6e-10)
    assert cascade.points[0].value == pytest.approx(first_doubling(RESTITUTION), rel=1e-13)


def test_a_branch_over_a_tied_parameter_is_that_of_models_made_at_each_value(
    orbit: pc.PeriodicOrbit,
) -> None:
    branch = pc.continue_orbit(orbit, over={"w": (1.66, 1.79)})
    assert branch.path == "w"
    for value, found in list(zip(branch.values, branch.orbits, strict=True))[::9]:
        plain = pc.cosine(value, amplitude=value**2, constant=-1)
        again = pc.find_orbit(BALL, plain, n_impacts=1, n_periods=1)
        np.testing.assert_allclose(again.impacts.v_before, found.impacts.v_before, rtol=1e-12)
    (doubling,) = branch.special_points
    assert doubling.value == pytest.approx(first_doubling(RESTITUTION), rel=1e-13)
    assert doubling.path == "w"


def test_a_curve_of_doublings_over_two_parameters_is_the_closed_form() -> None:
    r = pc.parameter("r", "0.15")
    ball = pc.impact_oscillator(r, stiffness=0)
    orbit = pc.find_orbit(ball, TABLE, n_impacts=1, n_periods=1)
    (doubling,) = pc.continue_orbit(orbit, over={"w": (1.66, 1.79)}).special_points
    curve = pc.continue_curve(doubling, over={"w": (1.3, 1.8), "r": (0.1, 0.4)})
    assert len(curve) > 10
    for w, restitution in curve.values:
        assert w == pytest.approx(first_doubling(restitution), rel=1e-12)


def test_a_walls_place_may_be_an_expression() -> None:
    gap = pc.parameter("gap", "1.0")
    osc = pc.impact_oscillator(0.8, wall=2 * gap, side="above", damping=0.05)
    plain = pc.impact_oscillator(0.8, wall=2.0, side="above", damping=0.05)
    force = pc.cosine(1.0)
    found = [
        pc.continue_orbit(pc.find_orbit(each, force), over={path: ends})
        for each, path, ends in (
            (osc, "gap", (0.5, 10.0)),
            (plain, "oscillator.stops.0.at", (1.0, 20.0)),
        )
    ]
    tied, own = (branch.special_points for branch in found)
    assert len(own) > 1
    assert [point.kind for point in tied] == [point.kind for point in own]
    assert [2 * p.value for p in tied] == pytest.approx([p.value for p in own], rel=1e-12)


def test_stops_of_which_one_is_tied_meet_in_a_corner() -> None:
    far = pc.parameter("far", "1.1")
    stops = pc.SoftStop(1.0, "above", 4.0), pc.SoftStop(far**2, "above", 9.0)
    orbit = pc.find_orbit(pc.Oscillator(1.0, 0.05, stops), pc.cosine(1.5, amplitude=4), 2, 1)

    branch = pc.continue_orbit(orbit, over={"far": (1.2, 0.9)})

    corners = [point for point in branch.special_points if point.kind == "corner"]
    assert [(point.value, point.status) for point in corners] == [(1.0, "located")]
    assert branch.values[-1] == 0.9
    assert branch[0].sequence == (0, 1)
    assert branch[len(branch) - 1].sequence == (1, 0)


def test_walls_that_move_together_meet_where_their_gap_closes() -> None:
    gap = pc.parameter("gap", "0.3")
    walls = pc.Wall(gap, "above", 0.7), pc.Wall(-gap, "below", 0.7)
    orbit = pc.find_orbit(pc.Oscillator(1.0, 0.02, walls), pc.cosine(1.5), 2, 1)

    branch = pc.continue_orbit(orbit, over={"gap": (0.3, -0.5)})

    corner = branch.special_points[-1]
    assert corner.kind == "corner"
    assert corner.value == pytest.approx(0.0, abs=1e-9)


def test_a_response_over_a_tied_parameter() -> None:
    damped = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    force = pc.base_excitation("0.4", 1.0)
    over = {"base_omega": (0.9, 1.1)}
    tied = pc.response_curve(damped, force, over, max_impacts=1, max_periods=1, n_seeds=1)
    for branch in tied.branches:
        for value, orbit in zip(branch.values[::20], branch.orbits[::20], strict=True):
            assert orbit.forcing is not None
            (harmonic,) = orbit.forcing.components()
            assert harmonic.cos == pytest.approx(0.4 * value**2, rel=1e-15)
    assert tied.path == "base_omega"
    assert tied.branches


def test_the_period_is_a_parameter_of_branches() -> None:
    osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    orbit = pc.find_orbit(osc, pc.cosine(1.0))
    over_period = pc.continue_orbit(orbit, over={"forcing.period": (6.0, 7.0)})
    over_omega = pc.continue_orbit(
        orbit, over={"forcing.omega": (2 * math.pi / 6.0, 2 * math.pi / 7.0)}
    )
    periods = [2 * math.pi / point.value for point in over_omega.special_points]
    assert [p.value for p in over_period.special_points] == pytest.approx(periods, rel=1e-11)
    np.testing.assert_allclose(
        [o.period for o in over_period.orbits], over_period.values, rtol=1e-15
    )


def test_a_range_in_which_the_model_is_none_ends_the_branch_with_the_reason() -> None:
    d = pc.parameter("d", 0.2)
    osc = pc.impact_oscillator("0.95" - d**2, wall=1.0, side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine(1.0))
    branch = pc.continue_orbit(orbit, over={"d": (0.2, 1.0)})
    assert "outside [0, 1]" in branch.end_reason
    assert branch.values.max() == pytest.approx(0.95**0.5, abs=1e-3)


def test_tied_paths_are_refused_by_every_call(orbit: pc.PeriodicOrbit) -> None:
    over = {"forcing.amplitude": (1.0, 3.0)}
    calls: list[Any] = [
        lambda: pc.continue_orbit(orbit, over=over),
        lambda: pc.response_curve(BALL, TABLE, over=over),
        lambda: pc.bifurcation_diagram(BALL, TABLE, over=over),
        lambda: pc.sweep("period", BALL, TABLE, over=over),
        lambda: pc.follow_cascade(orbit, over=over),
        lambda: replace_parameter(BALL, TABLE, None, "forcing.amplitude", 1),
    ]
    for call in calls:
        with pytest.raises(ParameterError, match="tied to w"):
            call()
