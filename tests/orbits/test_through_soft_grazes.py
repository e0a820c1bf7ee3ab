"""Branches that meet soft stops and leave them: nothing beside the graze is lost."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.orbits import Branch

AMPLITUDE, OMEGA = "forcing.amplitude", "forcing.omega"
TWO_SOFT = (pc.SoftStop(1, "above", 20, 0.3), pc.SoftStop(-1, "below", 20, 0.3))


def values(branch: Branch, kind: str) -> list[float]:
    return sorted(point.value for point in branch.special_points if point.kind == kind)


def all_located(branch: Branch) -> bool:
    return all(point.status == "located" for point in branch.special_points)


@pytest.fixture(scope="module")
def between_two() -> pc.PeriodicOrbit:
    """An orbit that enters two soft stops in turn."""
    osc, force = pc.Oscillator(0, "0.1", TWO_SOFT), pc.cosine(2, amplitude=8)
    (orbit,) = (each for each in pc.find_orbits(osc, force, max_periods=1) if each.n_impacts == 2)
    return orbit


@pytest.mark.parametrize(
    "ends",
    [
        pytest.param((0.8, 5.0), marks=pytest.mark.nightly),
        (2.0, 4.0),
        (4.0, 2.0),
        pytest.param((1.5, 4.0), marks=pytest.mark.nightly),
    ],
)
def test_both_stops_left_at_once(between_two: pc.PeriodicOrbit, ends: tuple[float, float]) -> None:
    """Either stop may formally be left alone: two families cross at the graze."""
    branch = pc.continue_orbit(between_two, over={OMEGA: ends})

    graze = values(branch, "grazing")[-1]
    # Without the stops the amplitude is A / (w sqrt(w^2 + 4 a^2)), and 1 where they are grazed.
    assert 8.0 / (graze * np.hypot(graze, 0.2)) == pytest.approx(1.0, abs=1e-11)
    assert all_located(branch)
    assert f"{OMEGA} = {max(ends):g} reached" in branch.end_reason


def test_a_stop_is_left_whose_entry_comes_first() -> None:
    """What stays begins with an exit: orbits begin with an entry."""
    stops = (pc.SoftStop(1, "above", 9), pc.SoftStop("1.4", "above", 9))
    osc, force = pc.Oscillator(1, "0.05", stops), pc.cosine("1.5", amplitude="1.31")
    (orbit,) = (each for each in pc.find_orbits(osc, force) if each.sequence == (1, 0))

    branch = pc.continue_orbit(orbit, over={OMEGA: (1.45, 1.7)})

    assert values(branch, "grazing") == pytest.approx([1.50243819523, 1.51696644638], abs=1e-9)
    assert branch.values[[0, -1]].tolist() == [1.45, 1.7]
    assert np.isnan(branch.impact_velocity).any()


def test_a_mass_that_a_force_holds_in_a_stop_leaves_it_beyond_a_graze() -> None:
    """The orbit begins inside, and leaves the stop before it enters it."""
    osc = pc.Oscillator(1, "0.1", (pc.SoftStop(0, "below", 8),))
    orbit = pc.find_orbit(osc, pc.cosine(2, amplitude="0.5", constant=-2), 0)
    branch = pc.continue_orbit(orbit, over={"forcing.constant": (-2, -0.2)})

    # Within the stop the stiffness is 9.
    amplitude = 0.5 / abs(9 - 4 + 2j * 0.1 * 2)
    (graze,) = values(branch, "grazing")
    assert graze == pytest.approx(-9 * amplitude, rel=1e-11)
    assert [branch[k].n_impacts for k in (0, -1)] == [0, 1]
    assert branch[-1].admissible
    run = pc.simulate(osc, branch[-1].forcing, v0=0.3, periods=300)
    last = run.extremes("displacement", between=(run.t_end - np.pi, run.t_end))
    own = branch[-1].trajectory().extremes("displacement")
    assert (own.minimum, own.maximum) == pytest.approx((last.minimum, last.maximum), abs=1e-9)


def test_a_doubling_just_beyond_a_graze_is_found_from_both_sides() -> None:
    """The multipliers change with the root of the distance: the doubling is 1.3e-4 away."""
    stops = (pc.SoftStop("0.468", "above", 9), pc.SoftStop("-1.177", "below", 3, "0.1"))
    osc = pc.Oscillator("-0.3", "0.1", stops)
    orbits = pc.find_orbits(osc, pc.cosine("2.623", amplitude="3.756", phase=0.7), max_periods=2)
    orbit = next(each for each in orbits if each.sequence in ((0, 1), (1, 0)) and each.n_periods == 2
                 and each.stability == "unstable")  # fmt: skip

    into = pc.continue_orbit(orbit, over={AMPLITUDE: (1.5, 6.0)})
    beyond = into.values > 5.0
    row = next(row for row in np.flatnonzero(beyond).tolist() if len(into[row].impacts) == 3)
    start = into[row]
    out = pc.continue_orbit(start, over={AMPLITUDE: (1.5, 6.0)})

    for branch in (into, out):
        assert values(branch, "grazing") == pytest.approx([4.374702041151], abs=1e-10)
        doublings = values(branch, "period_doubling")
        assert doublings[-1] == pytest.approx(4.375255788105, abs=1e-10)
        assert len(doublings) == 3
        assert all_located(branch)


def test_a_fold_just_beyond_a_graze_is_a_fold() -> None:
    """It is 7e-9 from the graze: the family turns there, and comes back along the parameter."""
    stops = (pc.SoftStop("0.115", "above", 100), pc.SoftStop("-1.516", "below", 100))
    force = pc.cosine("1.896", amplitude="0.252", phase=0.7)
    orbits = pc.find_orbits(pc.Oscillator(1, 0, stops), force, max_impacts=2, max_periods=1)
    both = 0
    for orbit in orbits:
        if orbit.n_impacts not in (1, 2):
            continue
        branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": (-0.285, 0.515)})
        assert not values(branch, "branch_point")
        grazes = [value for value in values(branch, "grazing") if abs(value + 0.21049) < 1e-5]
        folds = [value for value in values(branch, "fold") if abs(value + 0.21049) < 1e-5]
        assert len(grazes) == len(folds)
        if grazes:
            both += 1
            assert 0.0 < grazes[0] - folds[0] < 1e-8
    assert both


def test_beyond_a_graze_a_doubled_family_continues_to_its_origin() -> None:
    """Not on to the orbit that it doubles, which is near there."""
    stops = (pc.SoftStop("0.649", "above", 9), pc.Wall("0.879", "above", "0.7"))
    osc = pc.Oscillator(1, "0.02", stops)
    force = pc.cosine("2.494", amplitude="2.21", phase=0.7, constant="0.2")
    grazes: list[float] = []
    for orbit in pc.find_orbits(osc, force, max_impacts=1, max_periods=2):
        if orbit.n_periods != 2:
            continue
        branch = pc.continue_orbit(orbit, over={AMPLITUDE: (0.884, 3.536)})
        grazes += [value for value in values(branch, "grazing") if abs(value - 2.3564) < 1e-4]
        if grazes:
            break
    doubled = branch.special_points[-1]
    assert grazes == pytest.approx([2.3564074214849], abs=1e-10)
    single = pc.find_orbit(osc, pc.cosine("2.494", amplitude=2.35, phase=0.7, constant="0.2"), 1)
    own = pc.continue_orbit(single, over={AMPLITUDE: (2.349, 2.36)})
    assert doubled.kind == "period_doubling"
    assert "the two-fold cover" in branch.end_reason
    assert [doubled.value] == pytest.approx(values(own, "period_doubling"), abs=1e-10)


def test_a_branch_closes_through_grazes() -> None:
    stops = (pc.SoftStop("0.588", "above", 20, "0.1"), pc.SoftStop("-0.588", "below", 20, "0.1"))
    osc, force = pc.Oscillator("-0.3", 0, stops), pc.cosine("0.952", amplitude="0.496")
    orbit = pc.find_orbit(osc, force, n_impacts=0)

    branch = pc.continue_orbit(orbit, over={"forcing.constant": (-0.18, 0.18)})

    assert branch.end_reason == "the branch closed"
    grazes = np.array(values(branch, "grazing"))
    # The system is symmetric: so are the grazes.
    np.testing.assert_allclose(grazes, -grazes[::-1], rtol=0, atol=1e-10)
    assert len(grazes) == len(values(branch, "fold")) == 4
    # By rounding the flights in a grazed soft stop have negative durations: no penetration.
    assert all(point.admissible for point in branch.special_points if point.kind == "grazing")


def test_where_another_family_crosses_the_multiplier_is_not_lost() -> None:
    """Newton's method finds nothing at some points very near to the crossing."""
    stops = (pc.SoftStop("1.158", "above", 9), pc.SoftStop("-0.195", "below", 3))
    osc = pc.Oscillator(2, 0, stops)
    force = pc.cosine("2.987", amplitude="0.395", phase=0.7, constant="0.2")
    orbits = pc.find_orbits(osc, force, max_impacts=1, max_periods=2)
    orbit = next(each for each in orbits if (each.n_impacts, each.n_periods) == (1, 2)
                 and each.stability == "unstable")  # fmt: skip

    branch = pc.continue_orbit(orbit, over={OMEGA: (2.9, 3.73)})

    kinds = branch.stability.tolist()
    changes = [i for i in range(len(branch) - 1) if kinds[i] != kinds[i + 1]]
    rows = {point.row for point in branch.special_points}
    assert kinds[-1] == "elliptic"
    assert kinds[0] != "elliptic"
    assert all(rows & {i, i + 1} for i in changes)


def test_a_branch_goes_up_to_the_corner_where_two_soft_stops_meet() -> None:
    """Differences by the position of a stop do not reach past the other one."""
    stops = (pc.SoftStop("0.259", "above", 3), pc.SoftStop("0.358", "above", 9, "0.5"))
    osc = pc.Oscillator("-0.3", "0.02", stops)
    orbits = pc.find_orbits(osc, pc.cosine("2.279", amplitude="1.272"), max_periods=1)
    (orbit,) = (each for each in orbits if each.sequence == (0,))

    for ends in ((-0.042, 0.758), (0.118, 0.558)):
        branch = pc.continue_orbit(orbit, over={"oscillator.stops.1.at": ends})

        assert values(branch, "corner") == [0.259]
        assert branch.values[0] == pytest.approx(0.259, abs=1e-9)
        assert "stops 1 and 0 come to lie at one place" in branch.end_reason
        assert all_located(branch)


@pytest.mark.parametrize("ends", [(4.0, 8.0), (8.0, 4.0)])
def test_a_closed_family_is_there_once_whichever_way_comes_first(ends: tuple[float, float]) -> None:
    """One way ends at a graze which the other passes on its way round."""
    osc = pc.bilinear_oscillator(stiffness_above=1.0, stiffness_below=9.0, damping=0.05)
    orbits = pc.find_orbits(osc, pc.cosine(6.0, 2.0), 1, 4)
    (orbit,) = (each for each in orbits if each.n_periods == 4)
    branch = pc.continue_orbit(orbit, over={OMEGA: ends})

    assert branch.end_reason == "the branch closed"
    assert len(values(branch, "grazing")) == len(values(branch, "fold")) == 2
