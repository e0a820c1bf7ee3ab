"""Whole families of gears and other soft stops: nothing is raised, and each is walked once."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc

OMEGA = "forcing.omega"


@pytest.mark.parametrize(
    ("n_seeds", "max_periods"), [(1, 1), pytest.param(4, 2, marks=pytest.mark.nightly)]
)
def test_a_chart_of_a_gear_goes_through_grazes_of_both_flanks(
    n_seeds: int, max_periods: int
) -> None:
    gear = pc.backlash_oscillator(gap=0.5, stiffness=10.0, damping=0.04, stop_damping=0.02)
    force = pc.cosine(1.9, amplitude=0.9, constant=0.4)

    chart = pc.response_curve(
        gear,
        force,
        over={OMEGA: (1.0, 3.0)},
        max_impacts=2,
        max_periods=max_periods,
        n_seeds=n_seeds,
    )

    assert chart.branches
    widest = max(chart.branches, key=lambda branch: float(np.ptp(branch.values)))
    assert widest.values.min() == 1.0
    assert widest.values.max() == 3.0


@pytest.mark.parametrize("which", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_doubled_families_of_a_bilinear_spring_run_between_their_origins(which: int) -> None:
    osc = pc.bilinear_oscillator(stiffness_above=1.0, stiffness_below=27.7, damping=0.069)
    force = pc.cosine(1.96, amplitude=0.71, constant=-0.46)
    over = {OMEGA: (1.176, 3.136)}
    orbit = pc.find_orbits(osc, force, max_impacts=2, max_periods=1)[0]
    single = pc.continue_orbit(orbit, over=over)
    doublings = [point for point in single.special_points if point.kind == "period_doubling"]
    assert len(doublings) == 2

    branch = pc.continue_orbit(pc.switch_branch(doublings[which]), over=over)

    origins = [each.value for each in (branch.special_points[0], branch.special_points[-1])]
    np.testing.assert_allclose(origins, [each.value for each in doublings], atol=1e-9)
    assert branch.end_reason.count("the two-fold cover") == 2


def test_a_closed_family_of_a_gear_is_walked_once() -> None:
    gear = pc.backlash_oscillator(gap=0.36, stiffness=10.7, damping=0.074, stop_damping=0.05)
    force = pc.cosine(1.06, amplitude=1.17, constant=0.41)
    orbits = pc.find_orbits(gear, force, max_impacts=2, max_periods=2)
    orbit = next(each for each in orbits if each.sequence == (1, 0))

    branch = pc.continue_orbit(orbit, over={OMEGA: (0.636, 1.696)})

    assert branch.end_reason == "the branch closed"
    located = [(point.kind, round(point.value, 8)) for point in branch.special_points]
    assert len(located) == len(set(located))
    assert len([kind for kind, _ in located if kind == "fold"]) % 2 == 0
