"""Designs against closed forms, and the sentences of their faults."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.optimization.outcomes import outcome_of

WALL = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
SOFT = pc.Oscillator(damping="0.1", stops=(pc.SoftStop(at="0.2", side="above", stiffness=30),))
PLACE = "oscillator.stops.0.at"


def test_the_height_from_which_a_ball_lands_with_a_speed() -> None:
    ball = pc.Oscillator(0, stops=(pc.Wall(at=0, side="below", restitution="0.9"),))
    weight = pc.Forcing(constant="-9.81")
    best = pc.design(
        "peak_impact_velocity", ball, weight, free={"start.x0": (0.5, 3)}, goal=5, on="run",
        start=(1, 0), t_end=2,
    )  # fmt: skip
    assert best.converged
    assert best.values["start.x0"] == pytest.approx(25 / (2 * 9.81), rel=1e-10)
    assert best.start is not None
    assert best.value == pytest.approx(5, rel=1e-10)


def test_the_resonance_of_a_linear_oscillator() -> None:
    osc = pc.Oscillator(damping="0.2")
    best = pc.design(
        "max_displacement", osc, pc.cosine("0.8"), goal="largest", free={"forcing.omega": (0.5, 2)}
    )
    # The amplitude 1/abs(1 - w^2 + 2 i a w) is largest at w^2 = 1 - 2 a^2.
    assert best.values["forcing.harmonics.0.omega"] == pytest.approx(math.sqrt(0.92), rel=1e-6)
    assert best.value == pytest.approx(1 / (0.4 * math.sqrt(0.96)), rel=1e-12)
    assert best.gradient[0] == pytest.approx(0, abs=1e-5)


def test_a_wanted_value_is_that_next_to_the_given_setting() -> None:
    osc = pc.Oscillator(damping="0.2")
    above, below = (
        pc.design(
            "max_displacement", osc, pc.cosine(w), goal=1.5, free={"forcing.omega": (0.3, 2)}
        ).values["forcing.harmonics.0.omega"]
        for w in ("1.3", "0.5")
    )
    # Both roots of (1 - w^2)^2 + 0.16 w^2 = 1/1.5^2.
    middle, half = 0.92, math.sqrt(0.92**2 - 1 + 1 / 1.5**2)
    assert [above**2, below**2] == pytest.approx([middle + half, middle - half], rel=1e-8)


def test_a_limit_that_binds() -> None:
    free = {"oscillator.stops.0.stiffness": (5, 100)}
    best = pc.design(
        "peak_stop_force", SOFT, pc.cosine(2), free=free, restarts=1,
        subject_to={"max_displacement": (None, 0.29)},
    )  # fmt: skip
    assert best.converged
    assert best.active == ("max_displacement",)
    assert best.outcomes["max_displacement"] == pytest.approx(0.29, rel=1e-7)
    loose = pc.design("peak_stop_force", SOFT, pc.cosine(2), free=free, restarts=1)
    assert loose.active == ("oscillator.stops.0.stiffness",)
    assert loose.value < best.value


def test_a_limit_that_no_setting_keeps_is_told() -> None:
    best = pc.design(
        "peak_stop_force", SOFT, pc.cosine(2), restarts=0,
        free={"oscillator.stops.0.stiffness": (5, 100)}, subject_to={"max_displacement": (None, 0.1)},
    )  # fmt: skip
    assert not best.converged
    assert "max_displacement" in best.reason
    assert best.reason in repr(best)
    # How SLSQP goes on without a setting that keeps to it hangs on rounding.
    assert best.n_motions < 50


def test_the_multiplier_of_an_orbit() -> None:
    best = pc.design(
        "multiplier", WALL, pc.cosine(2), free={"forcing.omega": (1.8, 2.6)}, goal=0.9, restarts=0
    )
    assert best.orbit is not None
    assert abs(best.orbit.multipliers).max() == pytest.approx(0.9, rel=1e-9)
    assert best.orbit.is_stable


def test_an_orbit_that_is_given_is_followed_where_it_is_unstable() -> None:
    orbit = pc.find_orbit(WALL, pc.cosine(2))
    free = {"forcing.omega": (1.8, 2.6)}
    best = pc.design("multiplier", WALL, pc.cosine(2), free=free, goal=1.2, on=orbit, restarts=0)
    assert best.orbit is not None
    assert abs(best.orbit.multipliers).max() == pytest.approx(1.2, rel=1e-8)
    assert not best.orbit.is_stable


def test_the_period_of_a_limit_cycle() -> None:
    osc = pc.Oscillator(1, "-0.05", stops=(pc.Wall(at=1, side="above", restitution="0.7"),))
    free = {"oscillator.stops.0.restitution": (0.3, 0.85)}
    best = pc.design("period", osc, free=free, goal=4.0, restarts=0)
    assert isinstance(best.oscillator, pc.Oscillator)
    again = pc.find_orbit(best.oscillator)
    assert again.period == pytest.approx(4.0, rel=1e-9)


@pytest.mark.parametrize(("wall", "omega", "n_impacts"), [(0.2, 2, 1), (0.2, 0.3, 1), (9, 2, 0)])
def test_the_margin_to_a_graze(wall: float, omega: float, n_impacts: int) -> None:
    def orbit(place: float) -> pc.PeriodicOrbit:
        osc = pc.impact_oscillator("0.5", wall=place, side="above", damping="0.2")
        return pc.find_orbit(osc, pc.cosine(omega), n_impacts, formal=True)

    step = 1e-4
    near = [orbit(wall + k * step).grazing_margin for k in (-2, -1, 1, 2)]
    wanted = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * step)
    middle = orbit(wall)
    value, slope = outcome_of(middle, middle.sensitivity([PLACE]), "grazing_margin")
    assert value == middle.grazing_margin
    assert slope[0] == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_hops_into_a_contact_are_no_margin_to_a_graze() -> None:
    def orbit(constant: float) -> pc.PeriodicOrbit:
        osc = pc.Oscillator(0, "0.05", stops=(pc.Wall(at="-0.2", side="below", restitution=0),))
        force = pc.cosine("2.7", amplitude="1.72", phase="2.75", constant=constant)
        return pc.find_orbit(osc, force, math.inf, 2)

    middle = orbit(-0.3)
    value, slope = outcome_of(middle, middle.sensitivity(["forcing.constant"]), "grazing_margin")
    assert value == middle.grazing_margin
    step = 1e-5
    wanted = (orbit(step - 0.3).grazing_margin - orbit(-0.3 - step).grazing_margin) / (2 * step)
    assert slope[0] == pytest.approx(wanted, rel=1e-6)


def test_the_largest_margin_to_a_graze() -> None:
    osc = pc.impact_oscillator("0.5", wall="0.2", side="above", damping="0.2")
    best = pc.design(
        "grazing_margin", osc, pc.cosine("1.1"), goal="largest", free={PLACE: (-1, 1)}, restarts=2
    )
    assert isinstance(best.orbit, pc.PeriodicOrbit)
    assert best.value == best.orbit.grazing_margin
    assert best.value > pc.find_orbit(osc, pc.cosine("1.1")).grazing_margin


def test_a_start_beyond_the_wall_is_a_bound() -> None:
    best = pc.design(
        "peak_displacement", WALL, pc.cosine(2), free={PLACE: (-1, 1)}, on="run", start=("0.1", 0),
        t_end=20, restarts=3,
    )  # fmt: skip
    assert best.values[PLACE] >= 0.1
    assert all(attempt.values[PLACE] >= 0.1 for attempt in best.attempts)


@pytest.mark.parametrize("damping", ["0.1", pytest.param("0.15", marks=pytest.mark.nightly)])
def test_a_search_goes_up_to_the_graze_where_its_attractor_ends(damping: str) -> None:
    """On the way there are steps to two other attractors, both worse."""
    osc = pc.Oscillator(
        "3.9", damping, stops=(pc.Wall(at="-0.15", side="below", restitution="0.7"),)
    )
    force = pc.cosine(1, amplitude="0.8", phase="4.15", constant="0.2")
    free = {"oscillator.damping": (0.02, 0.8)}
    best = pc.design("peak_impact_velocity", osc, force, free=free, restarts=0)
    assert best.converged
    assert isinstance(best.orbit, pc.PeriodicOrbit)
    assert (best.orbit.n_impacts, best.orbit.n_periods) == (1, 1)
    assert 0.0 <= best.orbit.grazing_margin < 1e-7
    again = pc.design("peak_impact_velocity", osc, force, free=free, restarts=1)
    assert again.value <= best.value * (1 + 1e-7)


def test_a_search_stays_on_its_attractor_or_takes_a_better_one() -> None:
    """It ended at 2.748, with a slope that nothing held, and called that an optimum."""
    osc = pc.impact_oscillator(
        "0.677", stiffness="1.413", wall="-0.042", side="above", damping="0.039"
    )
    free = {
        "forcing.omega": (0.9324, 1.8648), "oscillator.stops.0.restitution": (0.3, 0.95),
        "oscillator.damping": (0.01, 0.5),
    }  # fmt: skip
    best = pc.design(
        "peak_impact_velocity", osc, pc.cosine("1.332", amplitude="1.477"), goal="largest",
        free=free, restarts=0,
    )  # fmt: skip
    assert best.converged
    assert best.value == pytest.approx(4.76729204, rel=1e-8)
    assert best.active == ("oscillator.stops.0.restitution", "oscillator.damping")
    assert best.gradient[0] == pytest.approx(0, abs=1e-4)


def test_a_limit_that_is_missed_at_the_end_of_an_attractor_is_told() -> None:
    stops: tuple[Any, ...] = (
        pc.Wall(at="-0.036", side="above", restitution="0.843"),
        pc.SoftStop(at="-0.176", side="below", stiffness="48.993", damping="0.583"),
    )
    best = pc.design(
        "min_displacement", pc.Oscillator("1.508", "0.069", stops=stops),
        pc.cosine("1.024", amplitude="0.976"), free={"oscillator.damping": (0.01, 0.5)},
        subject_to={"grazing_margin": (0.02, None)}, restarts=0,
    )  # fmt: skip
    assert best.outcomes["grazing_margin"] < 0.02
    assert not best.converged
    assert "grazing_margin" in best.reason


def test_the_least_along_the_grazes_where_an_attractor_ends() -> None:
    """Two parameters are free: the end of the attractor holds the slope, and a limit leads there."""
    stops: tuple[Any, ...] = (
        pc.Wall(at="-0.024", side="above", restitution="0.768"),
        pc.SoftStop(at="-0.086", side="below", stiffness="13.583", damping="0.5"),
    )
    osc, force = pc.Oscillator("1.806", "0.128", stops=stops), pc.cosine("2.407", amplitude="0.81")
    free = {PLACE: (-0.224, 0.176), "oscillator.damping": (0.01, 0.5)}
    best = pc.design("rms_displacement", osc, force, free=free, restarts=0)
    assert best.converged
    assert isinstance(best.orbit, pc.PeriodicOrbit)
    assert 0.0 <= best.orbit.grazing_margin < 1e-7
    limited = pc.design(
        "rms_displacement", best.oscillator, best.forcing, free=free, restarts=0,
        subject_to={"grazing_margin": (1e-3, None)},
    )  # fmt: skip
    assert limited.converged
    assert best.value < limited.value < best.value * (1 + 1e-3)


def test_an_end_of_an_attractor_that_could_be_gone_along_is_told() -> None:
    stops = (
        pc.Wall(at="-0.07", side="above", restitution="0.889"),
        pc.Wall(at="-0.371", side="below", restitution="0.686"),
    )
    best = pc.design(
        "max_displacement", pc.Oscillator("1.579", "0.13", stops=stops),
        pc.cosine("2.007", amplitude="1.198"), restarts=0,
        free={PLACE: (-0.27, 0.13), "oscillator.stiffness": (0.9474, 2.5264)},
    )  # fmt: skip
    assert not best.converged
    assert best.reason.startswith("its attractor ends beside it")


def test_an_orbit_without_impacts_is_followed_though_it_is_unstable() -> None:
    osc = pc.Oscillator(damping="-0.1", stops=(pc.Wall(at=9, side="above", restitution="0.5"),))
    orbit = pc.find_orbit(osc, pc.cosine("1.6"), 0)
    best = pc.design(
        "max_displacement", osc, pc.cosine("1.6"), goal=1.0, free={"forcing.omega": (1.2, 2)},
        on=orbit,
    )  # fmt: skip
    # (w^2 - 1)^2 + (0.2 w)^2 = 1
    middle = 1 - 0.02
    omega = math.sqrt(middle + math.sqrt(middle**2))
    assert best.values["forcing.harmonics.0.omega"] == pytest.approx(omega, rel=1e-8)


def test_settings_without_a_motion_to_begin_with_are_told() -> None:
    """A spring that pushes the mass away has no orbit."""
    osc = pc.Oscillator(1, "0.2")
    best = pc.design(
        "max_displacement", osc, pc.cosine(2), free={"oscillator.stiffness": (-5, 2)}, restarts=3,
    )  # fmt: skip
    assert best.n_settings == 4
    assert 1 <= best.n_begun < 4
    assert repr(best).endswith(f"; begun at {best.n_begun} of 4 settings>")


def test_settings_without_a_motion_of_a_structure_are_told() -> None:
    """From one of them the motion grows beyond all numbers, which ended the design."""
    pair = pc.chain([1, 1], [2, 1, 0], ["0.2", "0.2", 0])
    loads = pc.Loads({0: pc.cosine("1.2", amplitude="0.4")})
    free = {"structure.stiffness.0.0": (-9, 5)}
    best = pc.design("max_displacement_1", pair, loads, free=free, restarts=1)
    assert (best.n_begun, best.n_settings) == (1, 2)


def test_a_front_falls() -> None:
    front = pc.pareto_front(
        ("peak_stop_force", "max_displacement"), SOFT, pc.cosine(2), n=4, restarts=0,
        free={"oscillator.stops.0.stiffness": (5, 100)},
    )  # fmt: skip
    assert len(front) == 4
    assert (np.diff(front.values[:, 0]) > 0).all()
    assert (np.diff(front.values[:, 1]) < 0).all()
    # At equal distances of the second outcome.
    np.testing.assert_allclose(np.diff(front.values[:, 1], 2), 0.0, atol=1e-6)


def test_a_front_from_an_end_that_another_design_betters_is_whole() -> None:
    """The first search ends in an optimum near by, at the weakest stop, far from the front."""
    stop = pc.SoftStop(at=8e-4, side="above", stiffness=4e4, damping=30)
    rig = pc.Oscillator.from_mass(1.3, 5200, 4, stops=(stop,))
    front = pc.pareto_front(
        ("peak_stop_force", "max_displacement"), rig, pc.cosine(24 * math.pi, 25), n=5, restarts=0,
        free={"oscillator.stops.0.stiffness": (1e4, 2e5), PLACE: (2e-4, 3e-3)},
    )  # fmt: skip
    assert len(front) == 5
    # An end of a range is that number.
    assert {design.values[PLACE] for design in front.designs} == {2e-4}
    assert front.n_left_out == 0
    assert front.designs[0].values["oscillator.stops.0.stiffness"] > 2e4
    np.testing.assert_allclose(np.diff(front.values[:, 1], 2), 0.0, atol=1e-8)


def test_it_stops_when_it_is_asked_to() -> None:
    calls: list[float] = []

    def report(done: float, total: float) -> bool:  # noqa: ARG001
        calls.append(done)
        return False

    best = pc.design(
        "peak_stop_force", SOFT, pc.cosine(2), free={"oscillator.stops.0.stiffness": (5, 100)},
        progress=report,
    )  # fmt: skip
    assert not best.converged
    assert "stopped" in best.reason
    assert best.n_motions == len(calls) == 1


FREE: dict[str, Any] = {PLACE: (-0.3, 0.3)}
FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "outcome": ({"outcome": "peak_force"}, "none of the outcomes of an orbit"),
    "outcome of a run": (
        {"outcome": "period", "on": "run", "t_end": 5},
        "none of the outcomes of a run",
    ),
    "no parameter": ({"free": {}}, "no parameter"),
    "unknown": ({"free": {"oscillator.stops.0.as": (0, 1)}}, "did you mean|no such|nearest"),
    "force of a wall": ({"outcome": "peak_stop_force"}, "ask for peak_impact_velocity"),
    "limited force of a wall": (
        {"subject_to": {"peak_stop_force": (None, 1)}},
        "ask for peak_impact_velocity",
    ),
    "restitution": (
        {"free": {"oscillator.stops.0.restitution": (0.3, 1.3)}},
        "the model does not allow 1.3: .*outside",
    ),
    "a list of parameters": ({"free": [PLACE]}, r"not \{path: \(least, largest\)\}"),
    "a list of limits": (
        {"subject_to": ["max_displacement"]},
        r"not \{outcome: \(least, largest\)\}",
    ),
    "range": ({"free": {PLACE: (0.3, -0.3)}}, "not below the largest"),
    "no range": ({"free": {PLACE: 0.3}}, "not a range"),
    "goal": ({"goal": "smallest"}, 'neither "least" nor "largest" nor a number'),
    "limits": ({"subject_to": {"max_displacement": 1.2}}, "least, largest"),
    "limits crossed": ({"subject_to": {"max_displacement": (2, 1)}}, "above the largest"),
    "limit of a run": ({"t_end": 5}, 'on="run"'),
    "restarts": ({"restarts": -1}, "not a whole number from 0 to 100000"),
    "too many restarts": ({"restarts": 10**22}, "not a whole number from 0 to 100000"),
    "where": ({"on": "motion"}, "neither"),
}


def test_a_value_out_of_reach_is_told_with_the_nearest_one() -> None:
    best = pc.design("peak_impact_velocity", WALL, pc.cosine(2), goal=9.0, free=FREE, restarts=0)
    largest = pc.design(
        "peak_impact_velocity", WALL, pc.cosine(2), goal="largest", free=FREE, restarts=0
    )
    assert not best.converged
    assert best.reason == (
        "peak_impact_velocity = 9 is out of reach: the nearest that was found is 3.90248"
    )
    assert best.value == pytest.approx(largest.value, rel=1e-6)
    start: dict[str, Any] = {"on": "run", "start": ("0.1", 0), "t_end": 20}
    faster = pc.design(
        "peak_impact_velocity", WALL, pc.cosine(2), goal=30, free={PLACE: (-1, 0.5)}, **start
    )
    assert "is out of reach: the nearest that was found is 3.33235" in faster.reason


def test_settings_that_make_no_model_bound_a_design() -> None:
    """Between s = 0.68 and 1.32 an impact would create energy."""
    s = pc.parameter("s", 0.4)
    osc = pc.impact_oscillator("1.1" - (s - 1) * (s - 1), wall="0.2", side="above", damping="0.05")
    best = pc.design(
        "peak_impact_velocity", osc, pc.cosine(2), goal="largest", free={"s": (0.2, 1.8)},
        restarts=0,
    )  # fmt: skip
    assert best.converged, best
    assert best.values["s"] == pytest.approx(1 - np.sqrt(0.1), abs=1e-6)


def test_the_force_of_rigid_walls_is_refused() -> None:
    words = "a rigid wall has impulses in place of a force, .* ask for peak_impact_velocity"
    run = pc.simulate(WALL, pc.cosine(2), t_end=20)
    structure = pc.Structure(
        [1], [[1]], stops=(pc.Wall(at="0.2", side="above", restitution="0.8", on=0),)
    )
    with pytest.raises(pc.ParameterError, match=words):
        run.sensitivity([PLACE]).of("peak_stop_force")
    with pytest.raises(pc.ParameterError, match=words):
        pc.gradient("peak_stop_force", WALL, pc.cosine(2), wrt=[PLACE], t_end=20)
    with pytest.raises(pc.ParameterError, match=words):
        pc.simulate(structure, {0: pc.cosine(2)}, t_end=20).sensitivity([GAP]).of("peak_stop_force")


@pytest.mark.parametrize("case", FAULTS)
def test_a_fault_is_one_sentence(case: str) -> None:
    changed, sentence = FAULTS[case]
    arguments = {"outcome": "peak_impact_velocity", "free": FREE} | changed
    with pytest.raises(pc.ParameterError, match=sentence) as caught:
        pc.design(arguments.pop("outcome"), WALL, pc.cosine(2), **arguments)
    assert "\n" not in str(caught.value)


STOPS: list[pc.Wall | pc.SoftStop] = [
    pc.Wall(at="0.2", side="above", restitution="0.7", on=0),
    pc.SoftStop(at="-0.2", side="below", stiffness=100, damping="0.3", on=1),
]
ROW = pc.Structure(
    [1, 1], [[1, -1], [-1, 2]], [["0.13", "-0.03"], ["-0.03", "0.16"]], STOPS,
    points={"tip": (0, 1)},
)  # fmt: skip
LOADS = pc.Loads({1: pc.cosine("1.7", amplitude="0.4")})
GAP = "structure.stops.0.at"


def test_the_least_force_of_the_stops_of_a_structure() -> None:
    free = {GAP: (0.05, 0.6), "structure.stops.1.stiffness": (20, 200)}
    best = pc.design("peak_stop_force", ROW, LOADS, free=free, restarts=0)
    assert best.converged
    assert isinstance(best.orbit, pc.StructureOrbit)
    assert best.orbit.is_stable
    # The soft end of the spring, and in the other parameter a least value: the slope is zero.
    assert best.active == ("structure.stops.1.stiffness",)
    assert best.gradient[0] == pytest.approx(0, abs=1e-4)
    own = best.orbit.run
    pulls = [own.extremes("stop_force", stop=1)]
    assert best.value == pytest.approx(max(pull.peak for pull in pulls), rel=1e-12)

    limits = {"max_displacement_tip": (None, 0.9 * own.extremes("displacement", on="tip").maximum)}
    kept = pc.design("peak_stop_force", ROW, LOADS, free=free, restarts=0, subject_to=limits)
    assert kept.value > best.value
    assert kept.outcomes["max_displacement_tip"] <= limits["max_displacement_tip"][1] * (1 + 1e-6)


def test_the_multiplier_of_a_structure() -> None:
    orbit = pc.find_orbit(ROW, LOADS)
    best = pc.design("multiplier", ROW, LOADS, free={GAP: (0.1, 0.3)}, goal=0.97, on=orbit)
    assert isinstance(best.orbit, pc.StructureOrbit)
    assert abs(best.orbit.multipliers).max() == pytest.approx(0.97, rel=1e-8)


def test_a_run_of_a_structure_from_a_start_that_is_free() -> None:
    free = {"start.v0.1": (-1, 1)}
    best = pc.design(
        "max_displacement_0", ROW, free=free, goal=0.1, on="run", t_end=2, start=([0, 0], [0, 0.3])
    )
    run = pc.simulate(ROW, v0=[0, best.values["start.v0.1"]], t_end=2)
    assert run.extremes("displacement", on=0).maximum == pytest.approx(0.1, rel=1e-7)


@pytest.mark.parametrize(
    ("outcome", "more", "words"),
    [
        ("max_displacement", {}, "max_displacement_1, max_displacement_tip"),
        ("grazing_margin", {}, "none of the outcomes of an orbit of this structure"),
        ("period", {"on": "run", "t_end": 3}, "none of the outcomes of a run of this structure"),
        ("multiplier", {"force": None}, "a periodic orbit needs loads of one period"),
        ("multiplier", {"on": "motion"}, 'neither "orbit" nor "run"'),
    ],
)
def test_faults_of_designs_of_structures(outcome: str, more: dict[str, Any], words: str) -> None:
    given = {"force": LOADS, "free": {GAP: (0.1, 0.3)}, **more}
    with pytest.raises(pc.ParameterError, match=words):
        pc.design(outcome, ROW, **given)
