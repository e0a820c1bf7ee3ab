"""The ellipses of impact velocity against gap (Whiston 1987; Budd & Dux 1994)."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.model import Side
from percuss.orbits import VelocityGap, single_impact_orbits

CASES: dict[str, tuple[float, float, Side, float, int]] = {
    "one period": (0.8, 0.05, "above", 1.4, 1),
    "two periods": (0.8, 0.02, "above", 2.8, 2),
    "undamped, below": (0.7, 0.0, "below", 2.6, 1),
    "three periods": (0.8, 0.05, "above", 4.5, 3),
    "plastic": (0.0, 0.1, "above", 2.2, 1),
    "overdamped": (0.6, 1.7, "above", 3.0, 1),
}
each_case = pytest.mark.parametrize("name", CASES)


def oscillator(name: str, gap: float) -> pc.Oscillator:
    """Return the oscillator with its wall so far from the equilibrium at 0."""
    r, a, side, _, _ = CASES[name]
    return pc.impact_oscillator(r, wall=gap if side == "above" else -gap, side=side, damping=a)


def curve_of(name: str, n_points: int = 25) -> VelocityGap:
    """Return the ellipse of a case; where the wall is must not matter."""
    _, _, _, omega, n = CASES[name]
    return pc.velocity_gap_curve(oscillator(name, 0.3), pc.cosine(omega), n, n_points=n_points)


@each_case
def test_each_point_is_an_orbit_of_the_oscillator_with_that_gap(name: str) -> None:
    _, _, side, omega, n = CASES[name]
    sign = 1.0 if side == "above" else -1.0
    curve = curve_of(name)

    for row in range(1, len(curve.gap) - 1):
        osc = oscillator(name, float(curve.gap[row]))
        orbits = single_impact_orbits(osc, pc.cosine(omega), n)
        into = np.array([sign * orbit.impacts.v_before[0] for orbit in orbits])
        nearest = int(np.abs(into - curve.velocity[row]).argmin())
        assert into[nearest] == pytest.approx(curve.velocity[row], rel=1e-8)
        assert orbits[nearest].stability == curve.stability[row]
        assert orbits[nearest].admissible == curve.admissible[row]
        both = np.sort(into[into > 0.0])[::-1]
        np.testing.assert_allclose(curve.velocities_at(float(curve.gap[row])), both, rtol=1e-7)


@each_case
def test_points_lie_on_the_ellipse_and_its_limits_are_the_extremes(name: str) -> None:
    curve = curve_of(name, n_points=401)

    z = np.array([curve.gap, curve.velocity])
    np.testing.assert_allclose(np.einsum("in,ij,jn->n", z, curve.form, z), 1.0, rtol=1e-9)
    farthest = int(np.abs(curve.gap).argmax())
    # Near an extreme half a step of the angle, pi/800, enters as its square.
    assert abs(curve.fold) == pytest.approx(np.abs(curve.gap).max(), rel=1e-5)
    assert math.copysign(1.0, curve.fold) == np.sign(curve.gap[farthest])
    assert curve.largest_velocity == pytest.approx(curve.velocity.max(), rel=1e-5)
    assert np.abs(curve.gap[[0, -1]]) == pytest.approx(curve.graze, rel=1e-12)


@each_case
def test_an_impact_without_velocity_is_a_graze_of_the_linear_response(name: str) -> None:
    _, a, _, omega, _ = CASES[name]

    amplitude = 1.0 / math.hypot(1.0 - omega**2, 2.0 * a * omega)
    assert curve_of(name).graze == pytest.approx(amplitude, rel=1e-10)


@each_case
def test_two_orbits_this_side_of_the_fold_and_none_beyond(name: str) -> None:
    curve = curve_of(name)

    inside = curve.fold - 1e-3 * (curve.fold - math.copysign(curve.graze, curve.fold))
    assert len(curve.velocities_at(inside)) == 2
    assert len(curve.velocities_at(curve.fold * (1.0 + 1e-9))) == 0
    near_fold = curve.velocities_at(curve.fold * (1.0 - 1e-12))
    assert near_fold == pytest.approx(curve.fold_velocity, rel=1e-4)


def test_a_stable_point_attracts_a_simulated_motion() -> None:
    curve = curve_of("two periods", n_points=9)
    row = int(np.flatnonzero(curve.is_stable & curve.admissible)[0])
    osc, force = oscillator("two periods", float(curve.gap[row])), pc.cosine(2.8)

    t0 = float(curve.cycle[row]) * float(force.period or 0.0)
    v0 = -0.8 * float(curve.velocity[row]) * 1.001
    run = pc.simulate(osc, force, curve.gap[row], v0, t0, max_impacts=400)

    assert run.impacts.v_before[-1] == pytest.approx(curve.velocity[row], rel=1e-9)
    assert run.impacts.cycle[-1] == pytest.approx(curve.cycle[row], abs=1e-9)


def test_a_constant_force_moves_the_centre_and_nothing_else() -> None:
    osc = pc.impact_oscillator(0.8, wall=0.0, side="above", stiffness=2.0, damping=0.05)
    plain = pc.velocity_gap_curve(osc, pc.cosine(2.0), n_points=9)
    pushed = pc.velocity_gap_curve(osc, pc.fourier(2.0, cos=(1.0,), constant=0.5), n_points=9)

    assert (plain.equilibrium, pushed.equilibrium) == (0.0, 0.25)
    np.testing.assert_allclose(pushed.gap, plain.gap, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(pushed.stability, plain.stability)


@pytest.mark.parametrize(
    ("osc", "force", "n", "message"),
    [
        (pc.impact_oscillator(1.0), pc.cosine(2.6), 1, "elastic"),
        (pc.impact_oscillator(0.8), pc.cosine(2.0), 2, "closes after 2"),
        (pc.impact_oscillator(0.8, stiffness=0.0), pc.cosine(2.0), 1, "without a spring"),
        (pc.bilinear_oscillator(stiffness_below=9.0), pc.cosine(2.0), 1, "one wall"),
        (pc.impact_oscillator(0.8), pc.fourier(2.0, cos=(1.0, 1.0)), 1, "one harmonic"),
        (pc.impact_oscillator(0.8), pc.cosine(2.0), 0, "at least 1"),
    ],
)
def test_where_there_is_no_ellipse_it_says_why(
    osc: pc.Oscillator, force: pc.Forcing, n: int, message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.velocity_gap_curve(osc, force, n)
