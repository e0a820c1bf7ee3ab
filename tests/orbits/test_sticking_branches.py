"""Families of orbits with sticking: from the release and back to it, over a parameter."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq
from tests.oracle import event_driven as oracle
from tests.oracle.from_model import problem_of

import percuss as pc
from percuss.kernels import record as columns
from percuss.orbits import Branch
from percuss.orbits.orbit.sticking import releases_of

OMEGA, WALL = "forcing.omega", "oscillator.stops.0.at"
RESTITUTION = "oscillator.stops.0.restitution"
TWO = pc.Oscillator(1, 0.05, (pc.Wall(-0.2, "below", 0.3), pc.Wall(0.3, "above", 0.2)))


def branch_of(osc: pc.Oscillator, omega: float, over: dict[str, tuple[float, float]]) -> Branch:
    return pc.continue_orbit(pc.find_orbit(osc, pc.cosine(omega), math.inf), over=over)


@pytest.fixture(scope="module")
def over_frequency() -> Branch:
    return branch_of(pc.impact_oscillator(0.3, damping=0.05), 0.8, {OMEGA: (0.2, 2.0)})


@pytest.fixture(scope="module")
def over_wall() -> Branch:
    return branch_of(pc.impact_oscillator(0.0, damping=0.05), 0.8, {WALL: (-2.0, 1.5)})


@pytest.fixture(scope="module")
def two_walls() -> Branch:
    return branch_of(TWO, 0.3, {OMEGA: (0.05, 1.5)})


def test_releases_are_where_the_force_lets_go(over_wall: Branch) -> None:
    """With cos(2 pi c) = k x/A at the wall, on the rising side; every multiplier is 0."""
    assert len(over_wall) > 20
    for at, orbit in zip(over_wall.values, over_wall, strict=True):
        ((_, cycle),) = releases_of(orbit)
        assert cycle == pytest.approx(1.0 - math.acos(at) / (2.0 * math.pi), abs=1e-7)
        assert orbit.n_impacts == math.inf
        assert orbit.admissible
        assert not orbit.multipliers.any()


def test_it_ends_where_the_force_lets_go_no_more(over_wall: Branch) -> None:
    """The force at the wall, A cos - k x, pushes into it always from x = A/k on."""
    assert over_wall.values[-1] == pytest.approx(1.0, abs=1e-12)
    assert "beyond oscillator.stops.0.at = 1 the force never releases the mass from stop 0" in (
        over_wall.end_reason
    )


def free_from(at: float, t0: float, omega: float) -> pc.Trajectory:
    free = pc.Oscillator(1, 0.05)
    return pc.simulate(free, pc.cosine(omega), x0=at, v0=0.0, t0=t0, t_end=t0 + 20.0)


def missed(at: float, omega: float) -> float:
    """Return how far a plastic mass is from the wall a period after its release.

    It lands while the force pulls, leaves at once, and comes back.
    """
    period = 2.0 * math.pi / omega
    t0 = (1.0 - math.acos(at) / (2.0 * math.pi)) * period
    first = free_from(at, t0, omega)
    landing = brentq(lambda t: float(first(t)[0]) - at, t0 + 0.6 * period, t0 + 0.95 * period)
    return float(free_from(at, landing, omega)(t0 + period)[0]) - at


def test_a_plastic_contact_ends_where_the_flights_last_a_period(over_wall: Branch) -> None:
    """With r = 0 it lasts from the landing to the release: no time if they come together."""
    exact = brentq(lambda at: missed(at, 0.8), -0.97, -0.93, xtol=1e-14)

    (end,) = over_wall.special_points

    assert (end.kind, end.status, end.row) == ("chatter", "located", 0)
    assert end.value == pytest.approx(exact, abs=1e-11)
    assert "zero duration" in end.detail
    assert "zero duration" in over_wall.end_reason


@pytest.mark.parametrize("row", [0, 5, 12, -2])
def test_every_orbit_is_what_motions_settle_on(over_frequency: Branch, row: int) -> None:
    orbit = over_frequency[row]
    end = 30.0 * orbit.period
    run = pc.simulate(orbit.oscillator, orbit.forcing, x0=0.7, v0=-0.4, t_end=end)

    release = run.contacts.release[np.isfinite(run.contacts.release)][-1]
    ((_, cycle),) = releases_of(orbit)
    assert (release / orbit.period) % 1.0 == pytest.approx(cycle, abs=1e-9)
    later = orbit.trajectory(31)
    instants = np.linspace(end - orbit.period, end, 50)
    assert np.asarray(run(instants)) == pytest.approx(np.asarray(later(instants)), abs=1e-9)


def test_beyond_its_end_nothing_comes_to_rest(over_frequency: Branch) -> None:
    (end,) = over_frequency.special_points
    assert end.status == "located"
    assert end.interval[1] - end.interval[0] < 1e-12
    for step, sticks in ((-1e-5, True), (1e-5, False)):
        force, period = pc.cosine(end.value + step), 2.0 * math.pi / (end.value + step)
        run = pc.simulate(end.orbit.oscillator, force, x0=0.7, v0=0.0, t_end=60.0 * period)
        last = run.contacts.start > run.t_end - 1.5 * period
        assert last.any() == sticks


def test_its_end_is_where_a_calculation_with_40_digits_has_it(over_frequency: Branch) -> None:
    """A hair before it the mass still comes to rest for some 1e-5; an end was once 1e-8 off."""
    (end,) = over_frequency.special_points
    for step, sticks in ((-2e-9, True), (2e-9, False)):
        problem = problem_of(end.orbit.oscillator, pc.cosine(end.value + step))
        with mpmath.workdps(50):
            period = 2 * mpmath.pi / mpmath.mpf(end.value + step)
            release = -period / 4
        run = oracle.simulate(problem, 0, 0, release, t_end=release + period)

        assert any(start > 0 for start in run.contacts.start) == sticks


def test_grazes_accumulate_where_one_of_two_contacts_ends(two_walls: Branch) -> None:
    """A hop less each: what is left of the time to the release shrinks by the restitution."""
    chatter = two_walls.special_points[0]
    assert (chatter.kind, chatter.status) == ("chatter", "located")
    # On this side both walls hold the mass, on the other one does.
    assert len(releases_of(two_walls[chatter.row])) == 2
    assert len(releases_of(two_walls[chatter.row + 3])) == 1

    grazes = [point for point in two_walls.special_points if point.kind == "grazing"]
    apart = np.array([point.value - chatter.value for point in grazes])
    assert (np.diff(apart) > 0.0).all()
    assert apart[5:8] / apart[4:7] == pytest.approx(1.0 / 0.3, rel=0.05)


def test_a_graze_is_where_an_impact_comes_and_goes(two_walls: Branch) -> None:
    graze = [point for point in two_walls.special_points if point.kind == "grazing"][-1]
    assert graze.status == "located"
    counts = []
    for step in (-1e-6, 1e-6):
        force, period = pc.cosine(graze.value + step), 2.0 * math.pi / (graze.value + step)
        run = pc.simulate(TWO, force, x0=0.0, v0=0.0, t_end=40.0 * period)
        held = run.contacts.start[-2:]
        # Of a round, those before the chatter on stop 1.
        here = (run.impacts.t > held[0]) & (run.impacts.t <= held[1]) & (run.impacts.stop == 0)
        counts.append(int(here.sum()))
    assert abs(counts[1] - counts[0]) == 1


def test_restitution_is_followed_to_plastic_impacts() -> None:
    found = branch_of(pc.impact_oscillator(0.3, wall=0.2, damping=0.05), 0.8,
                      {RESTITUTION: (0.0, 0.95)})  # fmt: skip

    assert found.values[0] == 0.0
    assert len(found[0].impacts) == 1
    # One number an orbit: the fastest impact.
    assert found.impact_velocity.shape == (len(found), 1)
    assert (np.diff(found.values) > 0.0).all()


def test_an_orbit_at_the_end_of_the_range_is_followed_one_way(over_frequency: Branch) -> None:
    branch = pc.continue_orbit(over_frequency[0], over={OMEGA: (0.2, 0.3)})

    assert branch.values[0] == 0.2
    assert branch.end_reason == "forcing.omega = 0.3 reached"


def test_progress_and_limits(over_frequency: Branch) -> None:
    orbit = over_frequency[5]
    few = pc.continue_orbit(orbit, over={OMEGA: (0.2, 2.0)}, max_points=2)
    assert len(few) == 5
    assert "max_points = 2 reached" in few.end_reason

    stopped = pc.continue_orbit(orbit, over={OMEGA: (0.2, 2.0)}, progress=lambda n, _: n < 3)
    assert len(stopped) == 4
    assert stopped.end_reason == "stopped by progress"


def test_what_sticks_does_not_double_or_switch(over_frequency: Branch, two_walls: Branch) -> None:
    with pytest.raises(pc.ParameterError, match="continue_orbit follows it"):
        pc.follow_cascade(over_frequency[0], over={OMEGA: (0.2, 0.9)})
    graze = next(point for point in two_walls.special_points if point.kind == "grazing")
    assert graze.graze is None
    with pytest.raises(pc.ParameterError, match="no other starts"):
        pc.switch_branch(graze)
    with pytest.raises(pc.ParameterError, match="sticks"):
        pc.continue_curve(graze, over={OMEGA: (0.5, 1.5), "forcing.amplitude": (0.5, 2.0)})


def test_the_release_is_no_turning_point(over_frequency: Branch) -> None:
    """It leaves as the cube of time: rounding made it turn there, at no distance to the wall."""
    osc = pc.impact_oscillator(0.3, damping=0.05)
    for omega in (0.5, 0.8, 0.9):
        assert pc.find_orbit(osc, pc.cosine(omega), math.inf).grazing_margin > 0.1
    assert (over_frequency.grazing_margin > 0.0).all()


@pytest.mark.parametrize("omega", ["0.9", 1, "1.1", 2])
def test_a_release_by_a_jump_is_no_graze(omega: Any) -> None:
    walls = pc.Wall(0, "below", "0.7"), pc.Wall("0.5", "above", 0)
    force = pc.square_wave(omega, amplitude="0.7") + pc.Forcing(constant="0.1")
    orbit = pc.find_orbit(pc.Oscillator(1, "0.6", stops=walls), force, math.inf)
    assert orbit.grazing_margin > 1e-4
    events, marks = orbit.trajectory().record
    released = np.flatnonzero(marks[:, columns.KIND] == columns.RELEASE)
    assert (marks[released + 1, columns.KIND] == columns.KNOT).any()
    np.testing.assert_array_equal(events[released, :2], events[released + 1, :2])
