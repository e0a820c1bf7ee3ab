"""Why branches, curves and searches end, and what is refused before they begin."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.orbits import Branch, SpecialPoint, continue_curve, follow_cascade, singularity_set

OMEGA, AMPLITUDE, DAMPING = "forcing.omega", "forcing.amplitude", "oscillator.damping"
RESTITUTION, CONSTANT = "oscillator.stops.0.restitution", "forcing.constant"
ONE_WALL = pc.impact_oscillator("0.8")
ABOVE = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
BETWEEN = pc.Oscillator(1, 0.02, (pc.Wall(0.3, "above", 0.7), pc.Wall(-0.3, "below", 0.7)))
# The soft stop lies between the walls.
PASSED = pc.Oscillator(1, 0.02, (*BETWEEN.stops, pc.SoftStop(0.1, "above", 29)))
STICKS = pc.impact_oscillator(0.3, damping=0.05)


@pytest.fixture(scope="module")
def doubling() -> Branch:
    orbit = pc.find_orbit(ONE_WALL, pc.cosine(2.6))
    return pc.continue_orbit(orbit, over={OMEGA: (2.6, 2.7)})


@pytest.fixture(scope="module")
def mirrored() -> Branch:
    orbit = pc.find_orbit(BETWEEN, pc.cosine(1.5), 2, 1)
    return pc.continue_orbit(orbit, over={AMPLITUDE: (0.05, 2.0)})


@pytest.fixture(scope="module")
def sticking() -> pc.PeriodicOrbit:
    return pc.find_orbit(STICKS, pc.cosine(0.8), math.inf)


@pytest.fixture(scope="module")
def free() -> pc.PeriodicOrbit:
    """One of a family: half an oscillation, from an elastic wall and back to it."""
    return pc.find_orbit(pc.impact_oscillator(), None, guess=(0.0, 1.0))


def point_of(branch: Branch, **changed: Any) -> SpecialPoint:
    """Return the one special point of a branch, some of its fields changed."""
    (point,) = branch.special_points
    return dataclasses.replace(point, **changed)


# Ends


def stop_at_once(*_: object) -> bool:
    return False


def test_a_branch_and_a_curve_that_are_stopped_say_so(doubling: Branch) -> None:
    branch = pc.continue_orbit(doubling[0], over={OMEGA: (2.6, 2.7)}, progress=stop_at_once)
    over = {OMEGA: (2.0, 3.0), AMPLITUDE: (0.5, 2.0)}
    curve = continue_curve(point_of(doubling), over=over, progress=stop_at_once)

    assert branch.end_reason == curve.end_reason == "stopped by progress"
    assert 1 <= len(branch) < len(doubling)
    assert len(curve) == 2


def test_what_is_as_long_as_it_may_be_says_so_of_both_its_ends(
    doubling: Branch, sticking: pc.PeriodicOrbit
) -> None:
    over = {OMEGA: (2.0, 3.0), AMPLITUDE: (0.5, 2.0)}
    curve = continue_curve(point_of(doubling), over=over, max_points=5)
    branch = pc.continue_orbit(sticking, over={OMEGA: (0.3, 1.0)}, max_points=3)

    both = "max_points = {0} reached; at the other end max_points = {0} reached"
    assert (curve.end_reason, len(curve)) == (both.format(5), 11)
    assert (branch.end_reason, len(branch)) == (both.format(3), 7)


def test_a_branch_ends_where_there_is_no_such_system() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8", damping="0.05"), pc.cosine(2.6))

    branch = pc.continue_orbit(orbit, over={RESTITUTION: (-0.1, 1.0)})

    assert branch.values.min() == pytest.approx(0.0, abs=1e-9)
    assert branch.values.max() == 1.0
    assert "there is no such system" in branch.end_reason


def test_a_branch_passes_from_damping_to_excitation() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8", damping="0.05"), pc.cosine(2.6))

    branch = pc.continue_orbit(orbit, over={DAMPING: (-0.1, 0.3)})

    assert (branch.values.min(), branch.values.max()) == (-0.1, 0.3)
    # The product of the multipliers is r^2 exp(-2 a T).
    period = orbit.period
    expected = 0.64 * np.exp(-2.0 * branch.values * period)
    np.testing.assert_allclose(np.prod(branch.multipliers, axis=1).real, expected, rtol=1e-11)


def test_a_branch_with_sticking_ends_where_there_is_no_such_system(
    sticking: pc.PeriodicOrbit,
) -> None:
    branch = pc.continue_orbit(sticking, over={RESTITUTION: (-0.1, 0.9)})

    assert "there is no such system" in branch.end_reason


@pytest.mark.parametrize("most", [1000, pytest.param(100_000, marks=pytest.mark.nightly)])
def test_a_branch_with_sticking_ends_where_its_orbits_last_too_long(
    sticking: pc.PeriodicOrbit, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("percuss.orbits.finding.search_budget.MOST_SWINGS", most)

    branch = pc.continue_orbit(sticking, over={"forcing.omega": (-0.5, 0.9)}, max_points=200)

    assert "swings" in branch.end_reason
    # A swing of the oscillator takes 2 pi, the orbit 2 pi / omega: ten times as many as searched
    # for.
    assert branch.values.min() == pytest.approx(0.1 / most, rel=1e-6)


@pytest.mark.parametrize(
    ("path", "ends"), [(RESTITUTION, (0.0, 0.95)), ("oscillator.stiffness", (0.3, 1.5))]
)
def test_sticking_ends_where_its_contact_has_zero_duration(
    sticking: pc.PeriodicOrbit, path: str, ends: tuple[float, float]
) -> None:
    branch = pc.continue_orbit(sticking, over={path: ends})

    (chatter,) = branch.special_points
    contacts = chatter.orbit.trajectory().contacts
    assert chatter.kind == "chatter"
    # Its length is a small power of the distance to the end, which is found to 1e-14.
    assert 0.0 < contacts.release[0] - contacts.start[0] < 1e-4
    assert "the release precedes the end of the impacts" in branch.end_reason


def test_a_cascade_without_a_doubling_ends_at_the_end_of_its_range(doubling: Branch) -> None:
    cascade = follow_cascade(doubling[0], over={OMEGA: (2.6, 2.62)})

    assert len(cascade.points) == 0
    assert cascade.end_reason == f"{OMEGA} = 2.62 reached"


def test_a_curve_of_grazing_states_ends_at_the_longest_time_and_at_a_plastic_wall() -> None:
    plastic = pc.Oscillator(1, 0.02, (BETWEEN.stops[0], pc.Wall(-0.3, "below", 0)))

    short = singularity_set(ONE_WALL, pc.cosine(2.6), spacing=0.05, longest=1.0)
    stopped = singularity_set(plastic, pc.cosine(1.5), spacing=0.05)

    assert [curve.ends for curve in short.curves] == ["longest"]
    assert "no_restitution" in {curve.ends for curve in stopped.curves}


def test_beyond_the_graze_of_a_soft_stop_the_orbit_meets_it() -> None:
    osc = pc.Oscillator(1, 0.05, (pc.SoftStop(1, "above", 29),))
    calm = pc.find_orbit(osc, pc.cosine(1, amplitude="0.05"), 0)
    branch = pc.continue_orbit(calm, over={AMPLITUDE: (0.05, 0.2)})
    graze = next(point for point in branch.special_points if point.kind == "grazing")

    met = pc.switch_branch(graze)

    # At resonance the displacement is amplitude / (2 a omega).
    assert graze.value == pytest.approx(0.1, abs=1e-12)
    assert (calm.n_impacts, met.n_impacts) == (0, 1)
    assert met.admissible
    # A step away from the graze, where it first grazes.
    assert 0.0 < met.min_impact_speed < 0.1


# Refusals

WRONG_GUESSES: dict[str, tuple[Callable[[Branch], Any], str]] = {
    "orbit of two impacts": (
        lambda _: pc.find_orbit(
            ABOVE, pc.cosine(1), 3, 1, guess=pc.find_orbit(ONE_WALL, pc.cosine("2.9"), 2, 2)
        ),
        "an orbit of another kind than 3 impacts",
    ),
    "orbit of one period": (
        lambda branch: pc.find_orbit(ONE_WALL, pc.cosine(2.6), 2, 1, guess=branch[0]),
        "its 1 forcing periods do not go with 1 of the orbit",
    ),
    "orbit with other harmonics": (
        lambda branch: pc.find_orbit(
            ONE_WALL, pc.fourier(2.6, cos=(1.0, 0.1)), guess=branch[0]
        ),
        "an orbit with other stops or harmonics",
    ),
    "run of another system": (
        lambda _: pc.find_orbit(
            ABOVE, pc.cosine(1), guess=pc.simulate(ONE_WALL, pc.cosine(2.6), v0=0.5, t_end=20.0)
        ),
        "a run of another oscillator or forcing",
    ),
    "run that does not close": (
        lambda _: pc.find_orbit(
            ONE_WALL, pc.cosine(2.6), 5, 7,
            guess=pc.simulate(ONE_WALL, pc.cosine(2.6), v0=0.5, t_end=60.0),
        ),
        "it does not come near to 5 impacts in 7 periods at its end$",
    ),
    "run with contact": (
        lambda _: pc.find_orbit(
            STICKS, pc.cosine(0.8), 7, 1, guess=pc.simulate(STICKS, pc.cosine(0.8), t_end=60.0)
        ),
        "with contact ask for n_impacts=math.inf",
    ),
    "into a wall": (
        lambda _: pc.find_orbit(BETWEEN, pc.cosine(1), sequence=(0,), guess=(0.1, 1.0)),
        "into the wall 0; v_after is the velocity after the impact there",
    ),
    "out of a soft stop": (
        lambda _: pc.find_orbit(PASSED, pc.cosine(1), sequence=(2,), guess=(0.1, -1.0)),
        "out of the stop 2",
    ),
    "past a soft stop": (
        lambda _: pc.find_orbit(PASSED, pc.cosine(1), 2, 1, sequence=(0, 1)),
        "between stops 1 and 0 another one is met",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG_GUESSES)
def test_a_guess_that_does_not_fit_the_orbit_is_refused(doubling: Branch, case: str) -> None:
    find, words = WRONG_GUESSES[case]
    with pytest.raises(pc.ParameterError, match=words):
        find(doubling)


def test_an_orbit_that_is_no_special_one_has_no_other_family(doubling: Branch) -> None:
    calm = pc.find_orbit(ABOVE, pc.cosine(1, amplitude="0.05"), 0)
    elsewhere = point_of(doubling, orbit=doubling[0], value=2.6, kind="symmetry_breaking")
    without = point_of(doubling, orbit=calm, kind="symmetry_breaking")

    with pytest.raises(pc.ConvergenceError, match="has no second direction"):
        pc.switch_branch(elsewhere)
    with pytest.raises(pc.ParameterError, match="an orbit without impacts"):
        pc.switch_branch(without)


def test_a_curve_needs_a_force_a_graze_and_the_symmetry_that_breaks(
    doubling: Branch, mirrored: Branch, free: pc.PeriodicOrbit
) -> None:
    two = {"oscillator.stiffness": (1.0, 2.0), DAMPING: (0.0, 0.1)}
    for changed, words in (
        ({"orbit": free}, "the motion is free; curves need a forcing"),
        ({"orbit": free, "kind": "grazing"}, "it is free; curves need a force"),
        ({"kind": "grazing"}, "the orbit grazes no stop"),
    ):
        with pytest.raises(pc.ParameterError, match=words):
            continue_curve(point_of(doubling, **changed), over=two)
    over = {AMPLITUDE: (0.05, 2.0), CONSTANT: (-0.1, 0.1)}
    with pytest.raises(pc.ParameterError, match="the symmetry is lost when they vary"):
        continue_curve(point_of(mirrored), over=over)


def test_manifolds_are_those_of_a_saddle_that_motions_follow(
    doubling: Branch, free: pc.PeriodicOrbit
) -> None:
    grazed = pc.continue_orbit(pc.find_orbit(ABOVE, pc.cosine(1)), over={AMPLITUDE: (1, 0.05)})

    with pytest.raises(pc.ParameterError, match="a section needs a periodic forcing"):
        pc.manifolds(free)
    with pytest.raises(pc.ParameterError, match="no motion follows it"):
        pc.manifolds(grazed[-1])
    with pytest.raises(pc.ParameterError, match='not some of "stable" and "unstable"'):
        pc.manifolds(doubling[-1], kinds=("stable", "centre"))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "ask",
    [
        pc.find_orbit,
        pc.impact_map,
        pc.velocity_gap_curve,
        lambda osc, force: pc.response_curve(osc, force, over={OMEGA: (1.0, 2.0)}),
    ],
)
def test_what_is_no_oscillator_is_refused_by_its_name(ask: Callable[..., object]) -> None:
    with pytest.raises(pc.ParameterError, match="osc = None: not an Oscillator"):
        ask(None, pc.cosine(1))


@pytest.mark.parametrize("find", [pc.find_orbit, pc.find_orbits])
def test_what_is_no_oscillator_and_no_force_is_refused(find: Callable[..., object]) -> None:
    with pytest.raises(pc.ParameterError, match="osc = None: not an Oscillator"):
        find(None, pc.cosine(1))
    with pytest.raises(pc.ParameterError, match="force = '2': not a Forcing"):
        find(pc.impact_oscillator(), "2")
