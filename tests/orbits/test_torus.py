"""Torus points: a complex pair of multipliers leaves the unit circle under negative damping."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc

DAMPING = "oscillator.damping"


def torus_points(branch: pc.Branch) -> list[pc.SpecialPoint]:
    return [point for point in branch.special_points if point.kind == "torus"]


def other_kinds(branch: pc.Branch) -> list[str]:
    return [point.kind for point in branch.special_points if point.kind != "torus"]


@pytest.mark.parametrize(
    ("omega", "restitution"), [("2.5", "0.8"), ("1.5", "0.8"), ("2.5", "0.95")]
)
def test_the_damping_that_undoes_an_impact(omega: str, restitution: str) -> None:
    """The determinant r^2 exp(-2 a T) is 1 at a = ln(r) / T."""
    osc = pc.impact_oscillator(restitution, damping="0.02")
    orbit = pc.find_orbit(osc, pc.cosine(omega))

    branch = pc.continue_orbit(orbit, over={DAMPING: ("-0.12", "0.05")})

    (point,) = torus_points(branch)
    expected = math.log(float(restitution)) * float(omega) / (2.0 * math.pi)
    assert point.status == "located"
    assert abs(point.value - expected) < 1e-12
    assert np.abs(np.abs(point.orbit.multipliers) - 1.0).max() < 1e-11
    assert point.orbit.multipliers[0].imag > 0.1
    assert branch.stability[point.row - 1 : point.row + 2 : 2].tolist() == [
        "unstable",
        "asymptotic",
    ]


@pytest.mark.parametrize("ends", [(-0.1, 0.1), (-0.05, 0.1), (0.0, 0.1), (-0.1, 0.0)])
def test_a_steady_motion_loses_its_stability_where_damping_ends(ends: tuple[float, float]) -> None:
    """Without impacts the multipliers are exp((-a +- i w) T); the range may end at the point."""
    at = 0.05 if ends[1] > 0.0 else -0.05
    orbit = pc.find_orbit(pc.Oscillator(1, at), pc.cosine("1.7"), n_impacts=0)

    branch = pc.continue_orbit(orbit, over={DAMPING: ends})

    (point,) = torus_points(branch)
    assert abs(point.value) < 1e-13
    # 1/1.7 of a turn, seen from the other side.
    assert f"{1.0 - 1.0 / 1.7:.6g} turns" in point.detail


def test_real_multipliers_whose_product_is_one_are_no_torus() -> None:
    """Between k < 0 and a wall: a saddle whose areas begin to grow, but nothing turns."""
    saddle = pc.find_orbit(pc.Oscillator("-0.5", "0.1"), pc.cosine("1.7"), n_impacts=0)

    branch = pc.continue_orbit(saddle, over={DAMPING: ("-0.1", "0.1")})

    assert np.prod(branch.multipliers[[0, -1]].real, axis=1) - 1.0 == pytest.approx(
        [math.expm1(0.4 * math.pi / 1.7), math.expm1(-0.4 * math.pi / 1.7)]
    ), "the determinant has passed 1"
    assert branch.special_points == ()


def test_a_conservative_family_has_no_torus_points(conservative: pc.Branch) -> None:
    assert torus_points(conservative) == []
    assert "strong_resonance" in other_kinds(conservative)


def test_elastic_impacts_lose_their_stability_at_no_damping() -> None:
    """All orbits are conservative at that one value, which lies between rows or at one."""
    orbit = pc.find_orbit(
        pc.impact_oscillator(1, wall=-0.5, damping=0.01), pc.cosine(2.6), formal=True
    )

    for ends in ((-0.01, 0.01), (-0.02, 0.013)):
        (point,) = torus_points(pc.continue_orbit(orbit, over={DAMPING: ends}))
        assert abs(point.value) < 1e-12


def test_the_dashpot_of_a_soft_stop_makes_up_for_damping_below_zero() -> None:
    """The determinant is exp(-2 int a dt): a T + a_s t_c = 0, with the time t_c of contact."""
    stop = pc.SoftStop(at="0.1", side="above", stiffness=10, damping="0.3")
    orbit = pc.find_orbit(pc.Oscillator(1, "0.05", (stop,)), pc.cosine("1.3"), n_impacts=1)

    branch = pc.continue_orbit(orbit, over={DAMPING: ("-0.15", "0.06")})

    (point,) = torus_points(branch)
    share = pc.sweep(
        "contact_share",
        point.orbit.oscillator,
        point.orbit.forcing,
        over={},
        start=(point.orbit.x0, point.orbit.v0, point.orbit.t0),
        transient=0,
        periods=1,
    ).contact_share.item()
    assert abs(point.value + 0.3 * share) < 1e-9
    assert share > 0.05


def test_no_branch_of_orbits_starts_at_a_torus_point() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8", damping="0.02"), pc.cosine("2.5"))
    (point,) = torus_points(pc.continue_orbit(orbit, over={DAMPING: ("-0.12", "0.05")}))

    with pytest.raises(pc.ParameterError, match="an invariant torus, no periodic orbit"):
        pc.switch_branch(point)


def test_beyond_a_torus_point_motions_stay_near_the_orbit_without_a_period() -> None:
    """The dashpot of a stop farther out holds them: the strobes lie on a closed curve."""
    stop = pc.SoftStop(at="1.5", side="above", stiffness=0, damping=1)
    osc, force = pc.Oscillator(1, "-0.02", (stop,)), pc.cosine("1.7")

    data = pc.sweep(["period", "max_displacement"], osc, force, over={}, transient=2000)

    steady = 1.0 / abs(1.0 - 1.7**2)
    assert data.period.item() == 0.0
    assert steady < 1.5 < data.max_displacement.item() < 2.5
