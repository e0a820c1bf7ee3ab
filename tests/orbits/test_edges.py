"""The edge cases of orbits, each by its name."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import percuss as pc
from percuss.kernels.law_columns import FIRST_HARMONIC
from percuss.model import Side
from percuss.model.system import System
from percuss.orbits import single_impact, single_impact_orbits
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.orbit.extremes import extremes_of
from percuss.orbits.orbit.stability import multipliers_of, stability_of, stability_of_multipliers
from percuss.orbits.orbit.steady import steady_orbit

# Formal orbits are meant here: they are looked at one by one.
pytestmark = pytest.mark.filterwarnings("ignore::percuss.FormalOrbitWarning")

COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")


def test_grazing_orbit() -> None:
    """At A = 1/10 the orbit without impacts grazes the wall, to rounding."""
    orbit = pc.find_orbit(COCO, pc.cosine(1, amplitude="0.1"), n_impacts=0)

    assert orbit.grazing_margin == 0.0
    assert orbit.admissible
    for amplitude, admissible in (("0.1000000001", False), ("0.0999999999", True)):
        orbit = pc.find_orbit(COCO, pc.cosine(1, amplitude=amplitude), n_impacts=0)
        assert orbit.admissible == admissible
        assert abs(orbit.grazing_margin) == pytest.approx(1e-9, rel=1e-5)


@pytest.mark.parametrize(("side", "at"), [("below", Fraction(-1, 3)), ("above", Fraction(1, 3))])
def test_graze_at_the_very_instant_at_which_the_period_is_counted(side: Side, at: Fraction) -> None:
    """x = -cos(2 t)/3 turns at t = 0, and half a period later."""
    for depth, sign in ((0, 0.0), (Fraction(1, 10**9), -1.0), (Fraction(-1, 10**9), 1.0)):
        wall = at + depth * (1 if side == "below" else -1)
        osc = pc.impact_oscillator(0.8, wall=wall, side=side)

        orbit = pc.find_orbit(osc, pc.cosine(2), n_impacts=0)

        assert orbit.grazing_margin == pytest.approx(sign * 1e-9, abs=1e-15)
        assert orbit.admissible == (sign >= 0.0)


def test_next_to_a_graze_the_multipliers_are_still_exact() -> None:
    """One grows as the inverse of the impact speed; their product does not."""
    kept = 0.64 * math.exp(-0.2 * math.pi)
    for amplitude in ("0.09999", "0.0999999", "0.099999999999"):
        orbit = single_impact_orbits(COCO, pc.cosine(1, amplitude=amplitude))[1]
        assert orbit.admissible
        assert orbit.stability == "unstable"
        assert np.prod(orbit.multipliers).real == pytest.approx(kept, rel=1e-14)
        # trace = u + w / U with w from the force at the wall, 1.8 (0.1 sin - 1) S(T).
        t, speed = orbit.impacts.t[0], orbit.impacts.v_before[0]
        period, rate = orbit.period, math.sqrt(1.0 - 0.05**2)
        impulse = math.exp(-0.05 * period) * math.sin(rate * period) / rate
        even = math.exp(-0.05 * period) * math.cos(rate * period)
        force = float(amplitude) * math.cos(t) - 1.0
        trace = -1.6 * even + 1.8 * force / speed * impulse
        assert np.trace(orbit.monodromy) == pytest.approx(trace, rel=1e-9)


def test_the_family_folds_just_below_its_graze_and_goes_on_formally_above() -> None:
    """COCO's example: two orbits between fold and graze, 2.9e-5 apart; a formal one beyond."""
    for amplitude, kinds in (
        ("0.09997", []),
        ("0.0999711", [True, True]),
        ("0.09999", [True, True]),
        ("0.1001", [True, False]),
    ):
        orbits = single_impact_orbits(COCO, pc.cosine(1, amplitude=amplitude))
        assert [orbit.admissible for orbit in orbits] == kinds
    beyond = single_impact_orbits(COCO, pc.cosine(1, amplitude="0.1001"))[1]
    assert beyond.impacts.v_before[0] < 0.0
    # Into the wall after the impact, and out of it before.
    assert len(beyond.passages) == 2


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_two_impacts_a_hair_apart(gap: float) -> None:
    """A wall just behind the edge of a soft stop."""
    stops = (pc.SoftStop(0.25, "above", 5.0, 0.1), pc.Wall(0.25 + gap, "above", 0.8))
    osc = pc.Oscillator(1.0, 0.05, stops)

    orbit = pc.find_orbit(osc, pc.cosine(1.0), 2, 1)

    assert orbit.sequence == (0, 1)
    assert orbit.admissible
    apart = (0.25 + gap - 0.25) / orbit.impacts.v_before[0]
    assert orbit.impacts.intervals[1] == pytest.approx(apart, rel=2.0 * gap, abs=1e-15)
    run = pc.simulate(osc, pc.cosine(1.0), orbit.x0, orbit.v0, orbit.t0, t_end=orbit.t0 + 7.0)
    end = orbit.t0 + orbit.period - 0.5
    before = orbit.trajectory()(end)
    np.testing.assert_allclose(run(end), before, rtol=0, atol=1e-12)


def test_a_flight_of_no_duration_is_no_hop() -> None:
    """It solves its own equation: a gear's search once took such chains for orbits."""
    osc = pc.backlash_oscillator(1.0, 100.0, damping=0.05, stop_damping=0.3)

    for orbit in pc.find_orbits(osc, pc.cosine(1.3), max_periods=1, formal=True):
        if orbit.n_impacts:
            assert (orbit.impacts.intervals > 1e-6).all()


def test_an_orbit_that_starts_at_a_crossing() -> None:
    osc = pc.bilinear_oscillator(1, stiffness_below=4, damping="0.05")

    orbit = pc.find_orbit(osc, pc.cosine(1))

    assert orbit.x0 == 0.0
    assert orbit.v0 == orbit.impacts.v_after[0] < 0.0
    assert orbit.impacts.v_before[0] == pytest.approx(orbit.v0, rel=1e-14)
    run = orbit.trajectory()
    assert list(run.crossings.direction) == ["out", "in"]
    again = pc.simulate(osc, pc.cosine(1), 0.0, orbit.v0, orbit.t0, t_end=orbit.t0 + orbit.period)
    np.testing.assert_allclose(again.crossings.t[0], run.crossings.t[0], rtol=0, atol=1e-13)


def test_plastic_impacts_stick_or_take_off_at_once() -> None:
    """With r = 0 an orbit that takes off at once keeps one multiplier, one that sticks none."""
    takes_off = pc.impact_oscillator(0, wall="-0.1")
    force = pc.cosine(1)
    orbits = pc.find_orbits(takes_off, force, formal=True)

    assert orbits
    for orbit in orbits:
        if orbit.n_impacts == 0:
            continue
        assert orbit.multipliers[1] == 0.0
        if math.isinf(orbit.n_impacts):
            assert orbit.multipliers[0] == 0.0
            assert len(orbit.trajectory(2).contacts) >= 1


def test_a_plastic_impact_that_the_force_holds_is_no_take_off() -> None:
    """With r = 0 the equations have a solution, but through the wall: the mass would stick."""
    osc = pc.impact_oscillator(0, wall=0.12542965401773365)
    force = pc.cosine(2.495783329831724, amplitude=0.8572883860324156)

    formal = single_impact_orbits(osc, force)[0]
    orbit = pc.find_orbit(osc, force, math.inf)

    assert formal.impacts.v_before[0] < 0.0
    assert not formal.admissible
    assert len(orbit.trajectory(2).contacts) >= 1


def test_sticking_at_two_walls_in_one_orbit() -> None:
    walls = (pc.Wall("-0.1", "below", "0.3"), pc.Wall("0.1", "above", "0.3"))
    osc = pc.Oscillator(1, "0.05", walls)

    orbit = pc.find_orbit(osc, pc.cosine("0.5"), math.inf)

    run = orbit.trajectory(2)
    assert set(run.contacts.stop) == {0, 1}
    assert len(orbit.impacts) > 0
    times = run.t0 + np.linspace(0.001, 0.99, 40) * orbit.period
    np.testing.assert_allclose(run(times), run(times + orbit.period), rtol=0, atol=1e-12)
    settled = pc.simulate(osc, pc.cosine("0.5"), t_end=10 * orbit.period)
    late = orbit.t0 + 8.3 * orbit.period
    np.testing.assert_allclose(settled(late), run(orbit.t0 + 0.3 * orbit.period), atol=1e-9)


def test_elastic_walls_hold_nothing_back() -> None:
    """With r = 1 no motion comes to stick: the search for sticking ends at once."""
    with pytest.raises(pc.ConvergenceError, match="no orbit with sticking"):
        pc.find_orbit(pc.impact_oscillator(), pc.cosine(1.0, constant=-0.9), math.inf)


def test_without_a_spring_the_momentum_gives_the_velocity() -> None:
    """The ball's closed form is singular: both phases have the velocity g T / (1 + r)."""
    osc, force = pc.ball_on_table(amplitude="0.9", omega=1, gravity=1, restitution="0.8")

    form = single_impact(osc, force)

    np.testing.assert_allclose(form.roots[:, 1], -2.0 * math.pi / 1.8, rtol=1e-14)
    assert np.isnan(form.coefficients).all()
    assert {orbit.stability for orbit in single_impact_orbits(osc, force)} == {
        "asymptotic",
        "unstable",
    }


def test_where_the_free_motion_returns_by_itself_nothing_balances_the_impact() -> None:
    """Without damping every free motion has the period 2 pi of two forcing periods."""
    form = single_impact(pc.impact_oscillator("0.8"), pc.cosine(2), n_periods=2)

    assert len(form.roots) == 0
    assert len(single_impact(pc.impact_oscillator("0.8"), pc.cosine(2), n_periods=1).roots) == 2


def test_a_root_of_no_velocity_is_no_impact() -> None:
    """Without spring and gravity nothing brings the mass back to the wall."""
    osc, force = pc.Oscillator(0, 0, (pc.Wall(-1, "below", 0.5),)), pc.cosine(1)

    assert (single_impact(osc, force).roots[:, 1] == 0.0).all()
    assert single_impact_orbits(osc, force) == []
    assert [orbit.n_impacts for orbit in pc.find_orbits(osc, force)] == [0]


def test_without_stops_there_is_the_steady_motion() -> None:
    (orbit,) = pc.find_orbits(pc.Oscillator(1, "0.1"), pc.cosine(1, amplitude="0.2"))

    assert orbit.x0 == pytest.approx(0.0, abs=1e-15)
    assert orbit.v0 == pytest.approx(1.0, rel=1e-14)
    assert orbit.grazing_margin == math.inf


def test_turns_of_a_steady_motion_are_sought_at_the_pace_of_its_harmonics() -> None:
    """Under a forcing of 1e-9, at the pace of the free motion, that would take 4e10 steps."""
    osc, force = (
        pc.impact_oscillator("0.8", wall=2, side="above", damping="0.05"),
        pc.sine("1e-9"),
    )

    orbit = steady_orbit(System(osc, force), FIRST_HARMONIC + 1)

    # The displacement follows the force, up to terms of 1e-10.
    swing = extremes_of(orbit)
    assert [swing.low, swing.high] == pytest.approx([-1.0, 1.0], abs=1e-15)
    turns = math.pi * 1e9 * np.array([0.5, 1.5, 2.5])
    np.testing.assert_allclose(orbit.turning_points.t, turns, rtol=1e-9)


def test_elastic_motion_between_two_walls_without_force_is_a_family() -> None:
    walls = (pc.Wall(-1, "below"), pc.Wall(1, "above"))

    (orbit,) = pc.find_orbits(pc.Oscillator(0, 0, walls), max_impacts=2)

    assert not orbit.isolated
    assert orbit.period == pytest.approx(4.0 / abs(orbit.v0), rel=1e-14)


def test_a_loose_mass_may_rest_anywhere() -> None:
    osc = pc.backlash_oscillator(1.0, 100.0)

    orbit = pc.find_orbit(osc, pc.cosine(2.0, amplitude=0.1), n_impacts=0)

    assert not orbit.isolated
    assert orbit.grazing_margin == pytest.approx(1.0 - 0.1 / 4.0, abs=1e-14)


def test_unstable_by_a_negative_spring() -> None:
    osc = pc.Oscillator(-1.0, 0.1, (pc.Wall(2.0, "above"), pc.Wall(-2.0, "below")))

    orbit = pc.find_orbit(osc, pc.cosine(1.0, amplitude=0.5), n_impacts=0)

    root = math.sqrt(1.01)
    expected = [math.exp((root - 0.1) * 2 * math.pi), math.exp((-root - 0.1) * 2 * math.pi)]
    np.testing.assert_allclose(orbit.multipliers, expected, rtol=1e-12)
    assert orbit.stability == "unstable"


def test_multipliers_far_apart_keep_their_digits() -> None:
    matrix = np.array([[3e8, 1.0], [6e7, 0.2 + 1e-16]])

    small = multipliers_of(matrix, 0.3)[1]

    assert small.real == pytest.approx(0.3 / 3e8, rel=1e-8)


@pytest.mark.parametrize(
    ("trace", "determinant", "conservative", "expected"),
    [
        (0.3, 0.5, False, "asymptotic"),
        (1.5, 0.5, False, "parabolic"),
        (-1.6, 0.5, False, "unstable"),
        (0.3, 1.0, True, "elliptic"),
        (-2.0, 1.0, True, "parabolic"),
        (2.1, 1.0, True, "unstable"),
    ],
)
def test_stability_by_trace_and_determinant(
    trace: float, determinant: float, conservative: bool, expected: str
) -> None:
    matrix = np.array([[trace, -determinant], [1.0, 0.0]])

    assert stability_of(matrix, determinant, conservative=conservative) == expected


@pytest.mark.parametrize(
    ("multipliers", "expected"),
    [
        ([0.5, 0.9j, -0.9j, 0.1], "asymptotic"),
        ([0.6 + 0.8j, 0.6 - 0.8j, 0.3, 0.2], "elliptic"),
        ([1.0, 0.2], "parabolic"),
        ([-1.0, 0.6 + 0.8j, 0.6 - 0.8j, 0.2], "parabolic"),
        # Two that meet at 1 have half of the digits each.
        ([1.0 + 1e-6, 1.0 - 1e-6], "parabolic"),
        ([1.0 + 1e-6, 0.5], "unstable"),
        ([1.1, 1.0 / 1.1], "unstable"),
        ([1.0, 1.2], "unstable"),
        ([0.9 + 0.8j, 0.9 - 0.8j], "unstable"),
        ([math.inf, 0.0], "unstable"),
    ],
)
def test_stability_follows_from_multipliers_of_any_number(
    multipliers: list[complex], expected: str
) -> None:
    assert stability_of_multipliers(np.array(multipliers, dtype=complex)) == expected


def test_a_flight_of_negative_duration_is_formal() -> None:
    """It solves the equations, into the wall at both ends, and passes it nowhere."""
    osc = pc.impact_oscillator("0.7", wall="0.113", damping="0.05")
    force = pc.cosine("3.409", amplitude="1.694", phase=0.7)
    orbit = pc.find_orbit(osc, force, 2, 2)
    path = "oscillator.stops.0.at"
    branch = pc.continue_orbit(orbit, over={path: (-0.287, 0.2)})
    graze = min(branch.special_points, key=lambda point: abs(point.value + 0.1594))
    family = BranchEquations(graze.orbit, path, -0.287, 0.2)
    start = family.start(graze.orbit, graze.value)
    along = family.tangent(start, np.append(np.zeros(len(start) - 1), 1.0))

    shortest = []
    for step in (-1e-3, 1e-3):
        near = family.solution(family.corrected(start + step * along, along))
        shortest.append(near.itinerary.durations[:2].min())
        assert not near.admissible
    assert min(shortest) < -1e-5 < 1e-5 < max(shortest)
    # So the branch ends there.
    assert "a flight would have a negative duration" in branch.end_reason
    assert min(each.itinerary.durations[:2].min() for each in branch) > -1e-9
