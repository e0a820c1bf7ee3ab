"""The cases at the edges: tangency, rest on a stop, chatter, coincidence."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

import percuss as pc

WALL = pc.impact_oscillator()


def test_exact_tangency_is_a_graze_and_changes_nothing() -> None:
    """n = 3 with V0 = 1/2 touches the wall in the middle of every second flight."""
    run = pc.simulate(WALL, pc.sine(3), v0=0.5, t_end=30.0)

    np.testing.assert_allclose(run.impacts.t, math.pi * np.arange(1, 10), rtol=1e-13)
    np.testing.assert_allclose(run.grazes.t, math.pi * np.arange(1.5, 9.6, 2.0), rtol=1e-7)
    assert (np.abs(run.grazes.clearance) <= run.grazes.error_bound).all()
    assert (run.grazes.error_bound < 1e-13).all()


def test_a_motion_from_rest_on_a_wall_comes_back_to_it_without_velocity() -> None:
    """The instants 2 pi k are no doubles: next to them the clearance is some 1e-32, and its error less."""
    wall = pc.impact_oscillator("0.5", wall=1, side="above")
    whole = 2.0 * math.pi * np.arange(1, 5)

    for run in (
        pc.simulate(wall, x0=1, t_end=30),
        pc.simulate(pc.impact_oscillator(0, wall=1, side="above"), v0=2, t_end=30),
    ):
        begin = float(run.impacts.t[0]) if len(run.impacts) else 0.0
        np.testing.assert_allclose(run.grazes.t - begin, whole[: len(run.grazes)], rtol=1e-15)
        assert len(run.grazes) == 4
        assert (run.grazes.clearance <= run.grazes.error_bound).all()
        assert (run.grazes.error_bound < 1e-27).all()
    # No derivative there.
    assert np.isnan(
        pc.simulate(wall, x0=1, t_end=8).sensitivity(["oscillator.damping"])(7.0)[0]
    ).all()
    assert len(pc.simulate(wall, x0="0.999999999999", t_end=30).grazes) == 0


@pytest.mark.parametrize(
    ("force", "is_held"),
    [
        (pc.cosine(1.0, amplitude=-1.0), True),
        (pc.cosine(1.0), False),
        (pc.sine(1.0, amplitude=-1.0), True),
        (pc.sine(1.0), False),
        (pc.cosine(1.0, constant=-1.0), True),
        (pc.cosine(1.0, amplitude=-1.0, constant=1.0), False),
        (pc.Forcing(constant=-1.0), True),
        (pc.Forcing(constant=1.0), False),
        (None, True),
    ],
    ids=[
        "into it", "away", "falling from zero", "rising from zero", "zero from below",
        "zero from above", "constant into it", "constant away", "none",
    ],
)  # fmt: skip
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
def test_start_at_rest_on_a_wall_is_contact_exactly_where_the_force_holds_it(
    force: pc.Forcing | None, is_held: bool, stiffness: float
) -> None:
    osc = pc.impact_oscillator(0.5, stiffness=stiffness)

    run = pc.simulate(osc, force, t_end=1.0)

    assert (len(run.contacts) == 1) == is_held
    assert len(run.impacts) == 0
    assert (float(run(1.0)[0]) > 0.0) == (not is_held)


def test_start_with_velocity_into_the_wall_is_an_impact_at_the_start() -> None:
    run = pc.simulate(pc.impact_oscillator(0.5), v0=-2.0, t_end=1.0)

    assert (run.impacts.t[0], run.impacts.v_before[0], run.impacts.v_after[0]) == (0.0, -2.0, 1.0)


@pytest.mark.parametrize("stiffness", [0.0, 1.0])
@pytest.mark.parametrize("sides", [1, 2])
def test_free_motion_leaves_a_stop_it_starts_on_or_returns_from(
    stiffness: float, sides: int
) -> None:
    """Without any force, with nothing on the other side to come back from."""
    walls = (pc.Wall(0.0, "below"), pc.Wall(4.0, "above"))[:sides]
    soft = (pc.SoftStop(0.0, "below", 4.0),)

    for stops in (walls, soft):
        leaving = pc.simulate(pc.Oscillator(stiffness, 0.0, stops), v0=1.0, t_end=2.0)
        assert len(leaving.impacts) + len(leaving.crossings) == 0
        assert float(leaving(1.0)[0]) > 0.8
    returned = pc.simulate(pc.Oscillator(stiffness, 0.0, soft), x0=0.5, v0=-1.0, t_end=3.5)
    assert returned.crossings.direction.tolist()[:2] == ["in", "out"]
    assert len(returned.crossings) == 2


def test_chatter_sticks_at_its_accumulation_and_is_released() -> None:
    """f = -cos(t / 2): contact until it turns at pi."""
    run = pc.simulate(pc.impact_oscillator(0.2), pc.cosine(0.5, amplitude=-1.0), x0=0.1, t_end=4.0)

    assert len(run.contacts) == 1
    assert run.contacts.release[0] == pytest.approx(math.pi, rel=1e-15)
    assert run.contacts.n_impacts[0] == len(run.impacts)
    tail = run.contacts.start[0] - run.impacts.t[-1]
    assert 0.0 < tail < 1e-4
    # The sum's own error is far below the rounding of the impacts before it.
    assert 1e-16 < run.contacts.error_bound[0] < 1e-13
    during = np.linspace(run.contacts.start[0], run.contacts.release[0], 20)
    assert (np.array(run(during[:-1])) == 0.0).all()
    # After the release x is (t - pi)^3 / 12 at first.
    s = 1e-3
    assert float(run(run.contacts.release[0] + s)[0]) == pytest.approx(s**3 / 12, rel=1e-3)


def test_wall_that_takes_all_velocity_holds_at_the_first_impact() -> None:
    run = pc.simulate(pc.impact_oscillator(0.0), pc.Forcing(constant=-1.0), x0=1.0, t_end=50.0)

    assert len(run.impacts) == len(run.contacts) == 1
    assert run.contacts.start[0] == run.impacts.t[0] == pytest.approx(math.pi / 3, rel=1e-15)
    assert (run.outcome, run.t_end) == (pc.Outcome.at_rest, 50.0)


def test_elastic_hops_are_counted_one_by_one_up_to_the_limit() -> None:
    run = pc.simulate(WALL, pc.Forcing(constant=-1.0), v0=1e-3, max_impacts=5000)

    assert run.outcome is pc.Outcome.reached_max_impacts
    np.testing.assert_allclose(run.impacts.intervals, 2.0 * math.atan(1e-3), rtol=1e-12)


def test_impacts_at_the_unforced_equilibrium_decay_without_accumulation() -> None:
    run = pc.simulate(pc.impact_oscillator(0.5), v0=1.0, t_end=1000.0)

    assert len(run.contacts) == 0
    np.testing.assert_allclose(run.impacts.t, math.pi * np.arange(1, 319), rtol=1e-14)
    np.testing.assert_allclose(run.impacts.v_after, 0.5 ** np.arange(1, 319), rtol=1e-11)


def test_contact_survives_the_instants_at_which_the_force_is_zero() -> None:
    run = pc.simulate(pc.impact_oscillator(0.5), pc.cosine(2.0, constant=-1.0), t_end=100.0)

    assert len(run.impacts) == 0
    assert np.isnan(run.contacts.release).tolist() == [True]
    assert run.outcome is pc.Outcome.at_rest


@pytest.mark.parametrize("gap", [2.0**-52, 1e-12, 1e-6])
def test_two_walls_a_hair_apart_are_struck_in_turn(gap: float) -> None:
    osc = pc.Oscillator(1.0, 0.0, (pc.Wall(1.0, "below"), pc.Wall(1.0 + gap, "above")))
    width = (1.0 + gap) - 1.0

    run = pc.simulate(osc, pc.sine(2.0), x0=1.0, v0=0.5, max_impacts=1000)

    assert run.impacts.stop.tolist() == [1, 0] * 500
    # The force changes the speed by its work over the gap at most.
    np.testing.assert_allclose(run.impacts.intervals, width / 0.5, rtol=1e-2)
    assert run.t_end == pytest.approx(2000.0 * width, rel=1e-2)


@pytest.mark.parametrize("depth", [1e-12, 1e-9, 1e-6])
def test_shallow_visit_to_a_wall_is_two_impacts_a_hair_apart(depth: float) -> None:
    """n = 3: the second flight would dip to -depth at 3 pi / 2."""
    run = pc.simulate(WALL, pc.sine(3), v0=0.5 - depth, t_end=5.0)

    # At the turning point x'' = f - x = 1.
    assert len(run.impacts) >= 2
    assert run.impacts.t[0] == pytest.approx(math.pi, rel=1e-15)
    first = 1.5 * math.pi - run.impacts.t[1]
    assert first == pytest.approx(math.sqrt(2.0 * depth), rel=1e-2)


def test_exact_resonance_grows_by_its_secular_term() -> None:
    """From rest x = t sin(2 t) / 4 under cos(2 t) with K = 4."""
    run = pc.simulate(pc.Oscillator(4.0), pc.cosine(2.0), t_end=1e5)

    t = np.linspace(0.0, 1e5, 1001)
    np.testing.assert_allclose(run(t)[0], t * np.sin(2.0 * t) / 4.0, atol=1e5 * 4e-11)


def test_a_sampled_resonance_is_right_to_rounding_from_its_start_on() -> None:
    """From rest x = (sin t - t cos t) / 2 and v = t sin t / 2, against 40 digits."""
    run = pc.simulate(pc.Oscillator(1.0), pc.sine(1), t_end=400.0)
    instants = np.concatenate([np.geomspace(1e-4, 1.0, 60), np.linspace(1.0, 400.0, 300)])

    x, v = run(instants)

    with mpmath.workdps(40):
        for t, at, speed in zip(map(mpmath.mpf, instants), x, v, strict=True):
            exact = (mpmath.sin(t) - t * mpmath.cos(t)) / 2
            exact_v = t * mpmath.sin(t) / 2
            # Early on the terms cancel, by three digits at most; later they are of the size of t.
            limit = 1e-15 * max(float(t), 1.0)
            assert abs(at - exact) <= limit
            assert abs(speed - exact_v) <= limit
            assert t > 1.0 or abs(at / exact - 1) <= 1e-12


def test_incommensurate_harmonics_have_no_period_and_keep_their_phases() -> None:
    force = pc.Forcing(
        harmonics=(pc.Harmonic(1.0, 1.0, pc.pi_times(-1, 2)), pc.Harmonic(0.5, math.sqrt(2.0)))
    )
    run = pc.simulate(pc.impact_oscillator(0.7), force, v0=1.0, t_end=1e5)

    assert force.period is None
    assert np.isnan(run.impacts.cycle).all()
    with pytest.raises(pc.ParameterError, match="period"):
        run.stroboscopic()
    # The forcing as the run has it, after 1e5 units of time.
    driven = run.forces([1e5])["forcing"].to_numpy()[0]
    assert driven == pytest.approx(math.sin(1e5) + 0.5 * math.cos(math.sqrt(2.0) * 1e5), abs=1e-9)


def test_soft_stops_that_share_an_edge_act_as_their_sum_and_are_listed_each() -> None:
    shared = (pc.SoftStop("0.2", "above", 3.0, 0.1), pc.SoftStop(0.2, "above", 5.0))
    both = pc.simulate(pc.Oscillator(1.0, 0.0, shared), v0=1.0, t_end=9.0)
    single = pc.simulate(
        pc.Oscillator(1.0, 0.0, (pc.SoftStop(0.2, "above", 8.0, 0.1),)), v0=1.0, t_end=9.0
    )

    assert both.crossings.t[::2].tolist() == both.crossings.t[1::2].tolist()
    assert both.crossings.stop.tolist() == [0, 1] * len(single.crossings)
    np.testing.assert_allclose(both.crossings.t[::2], single.crossings.t, rtol=1e-13)


def test_soft_stop_in_front_of_a_wall_is_entered_before_the_wall_is_struck() -> None:
    osc = pc.Oscillator(1.0, 0.0, (pc.Wall(-0.1, "below", 0.9), pc.SoftStop(0.0, "below", 10.0)))

    run = pc.simulate(osc, x0=1.0, t_end=1.7)

    assert run.crossings.direction.tolist() == ["in"]
    assert run.crossings.t[0] == pytest.approx(math.pi / 2, rel=1e-15)
    # Energy: 1/2 (1 - 11 * 0.1^2) of what the springs leave.
    assert run.impacts.v_before[0] == pytest.approx(-math.sqrt(1.0 - 11.0 * 0.01), rel=1e-14)


def test_unstable_spring_bounces_between_two_walls_for_ever() -> None:
    osc = pc.Oscillator(-1.0, 0.0, (pc.Wall(-1.0, "below"), pc.Wall(1.0, "above")))

    run = pc.simulate(osc, x0=0.0, v0=0.5, max_impacts=1000)

    # x = v0 sinh(t); from wall to wall twice asinh(1 / v0).
    assert run.impacts.stop.tolist() == [1, 0] * 500
    np.testing.assert_allclose(run.impacts.intervals[1:], 2.0 * math.asinh(2.0), rtol=1e-11)


def test_unstable_motion_ends_in_overflow_and_holds_what_was_before() -> None:
    run = pc.simulate(pc.impact_oscillator(stiffness=-1.0), x0=1.0, v0=2.0, t_end=1e4)

    assert run.outcome is pc.Outcome.overflow
    assert run.t_end < 1e4
    assert np.isfinite(run(run.t_end)).all()


def test_rest_at_an_unstable_equilibrium_stays() -> None:
    for osc in (pc.Oscillator(damping="-0.05"), pc.Oscillator(stiffness=-1)):
        run = pc.simulate(osc, t_end=2e4)
        assert run.outcome is pc.Outcome.reached_t_end
        assert [part.tolist() for part in run([0.0, 2e4])] == [[0.0, 0.0], [0.0, 0.0]]


@pytest.mark.parametrize("damping", [1e3, 1e6, 1e9])
def test_huge_dashpot_creeps_to_its_equilibrium(damping: float) -> None:
    """x' = -x / (2 a) from 1, to the first order in 1 / a^2."""
    run = pc.simulate(pc.impact_oscillator(damping=damping), x0=1.0, t_end=100.0)

    assert len(run.impacts) == 0
    assert float(run(100.0)[0]) == pytest.approx(math.exp(-50.0 / damping), rel=1e-4)


@pytest.mark.parametrize("damping", [1.0, 2.0, 5.0])
def test_creep_to_a_wall_at_the_equilibrium_never_strikes_it(damping: float) -> None:
    """What rounding cannot decide at the end of the approach is a graze, no impact."""
    run = pc.simulate(pc.impact_oscillator(damping=damping), x0=1.0, t_end=1000.0)

    assert len(run.impacts) == 0


def test_motion_that_only_touches_the_wall_is_not_struck_by_it() -> None:
    """x = 2/3 (1 - cos t)^2, which is zero to the fourth order at whole periods."""
    force = pc.cosine(2.0, amplitude=-1.0, constant=1.0)

    run = pc.simulate(pc.impact_oscillator(0.0), force, t_end=30.0)

    assert len(run.impacts) == 0
    t = np.linspace(0.0, 30.0, 100)
    np.testing.assert_allclose(run(t)[0], 2.0 / 3.0 * (1.0 - np.cos(t)) ** 2, atol=1e-12)


def test_wall_that_takes_all_velocity_lets_go_at_once_where_the_force_turns_away() -> None:
    """f = 1 - cos(t) presses never: impacts at whole periods, each from rest again."""
    force = pc.cosine(1.0, amplitude=-1.0, constant=1.0)

    run = pc.simulate(pc.impact_oscillator(0.0), force, t_end=40.0)

    np.testing.assert_allclose(run.impacts.t, math.tau * np.arange(1, 7), rtol=1e-12)
    np.testing.assert_allclose(run.impacts.v_before, -math.pi, rtol=1e-7)


def test_damped_motion_near_resonance_stays_finite_however_long_it_is() -> None:
    """The transient dies like exp(-0.05 t); what is left is sin(t - pi / 2) / 0.1."""
    run = pc.simulate(pc.Oscillator(1.0, 0.05), pc.sine(1.0), v0=1.0, t_end=2e4)

    t = np.linspace(1e3, 2e4, 200)
    np.testing.assert_allclose(run(t)[0], -10.0 * np.cos(t), atol=1e-10)


def test_harmonic_as_slow_as_an_unstable_spring_is_fast_keeps_its_digits() -> None:
    """K = -w^2: every other pair of terms of the response's power series vanishes."""
    run = pc.simulate(pc.Oscillator(-0.25), pc.cosine(0.5), t_end=1.0)

    # x'' - x / 4 = cos(t / 2) from rest: x = 2 (cosh(t / 2) - cos(t / 2)).
    t = np.linspace(0.05, 1.0, 20)
    np.testing.assert_allclose(run(t)[0], 2.0 * (np.cosh(t / 2.0) - np.cos(t / 2.0)), rtol=1e-13)


def test_far_stop_costs_no_digits_of_the_motion_elsewhere() -> None:
    osc = pc.Oscillator(1.0, 0.0, (pc.Wall(-1e9, "below"), pc.Wall(1.0, "above")))

    run = pc.simulate(osc, x0=0.3, v0=0.1, t_end=6.0)

    t = np.linspace(0.0, 6.0, 50)
    np.testing.assert_allclose(run(t)[0], 0.3 * np.cos(t) + 0.1 * np.sin(t), atol=1e-14)


@pytest.mark.parametrize(
    ("osc", "force", "x0", "v0"),
    [
        (pc.impact_oscillator(0.5, stiffness=0, damping=1), None, 1.0, -0.1),
        (pc.impact_oscillator(stiffness=0), pc.sine(1), 1.0, 2.0),
        (pc.impact_oscillator(stiffness=0, damping=0.5), pc.sine(1), 5.0, 2.0),
        (pc.impact_oscillator(stiffness=0), pc.fourier(1.0, cos=(1.0,), constant=0.5), 1.0, 2.0),
        (
            pc.impact_oscillator(stiffness=0, damping=0.1),
            pc.fourier(1.0, cos=(1.0,), constant=0.5),
            1.0,
            2.0,
        ),
    ],
    ids=["damped", "drift", "damped and driven", "pushed off", "damped and pushed off"],
)
def test_mass_without_spring_that_leaves_for_ever_is_seen_to_do_so(
    osc: pc.Oscillator, force: pc.Forcing | None, x0: float, v0: float
) -> None:
    run = pc.simulate(osc, force, x0=x0, v0=v0, max_impacts=5)

    assert run.outcome is pc.Outcome.no_more_impacts
    assert len(run.impacts) == 0


@pytest.mark.parametrize(
    ("drift", "constant"), [(-0.01, 0.0), (2.0, -0.01), (-0.3, 0.001)], ids=str
)
def test_mass_without_spring_that_comes_back_does_impact(drift: float, constant: float) -> None:
    """x'' = cos t + G: x = 1 + drift t + (1 - cos t) + G t^2 / 2 meets the wall at a known time."""
    force = pc.fourier(1.0, cos=(1.0,), constant=constant)

    run = pc.simulate(pc.impact_oscillator(stiffness=0), force, x0=1.0, v0=drift, max_impacts=1)

    if constant > 0.0:
        assert 1.0 + drift * run.impacts.t[0] < 0.0
    assert len(run.impacts) == 1
    t = run.impacts.t[0]
    x = 1.0 + drift * t + (1.0 - math.cos(t)) + 0.5 * constant * t * t
    assert x == pytest.approx(0.0, abs=1e-13 * (1.0 + abs(drift) * t))


def test_force_far_faster_than_the_oscillator_only_makes_it_tremble() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(1e8), v0=1.0, max_impacts=2)

    np.testing.assert_allclose(run.impacts.t, [math.pi, 2.0 * math.pi], rtol=1e-15, atol=2e-8)


def test_force_too_fast_for_its_phase_to_be_known_over_a_flight_is_refused() -> None:
    with pytest.raises(pc.ParameterError, match="1e\\+40 times as fast"):
        pc.simulate(pc.impact_oscillator(), pc.sine(1e40), v0=1.0, max_impacts=5)


def test_contact_whose_force_falls_steeply_is_released() -> None:
    """A force that falls by more than its rounding within one ulp of the time in contact."""
    slow, fast = (2.412575340060761, 0.09524200336769265), (0.21916498356896236, 65.84362761944287)
    force = pc.Forcing(
        harmonics=(pc.Harmonic(*slow, 2.5262294887857815), pc.Harmonic(*fast, 1.025918382811785))
    )
    osc = pc.impact_oscillator(0.5, wall=-0.044248419977565505)

    run = pc.simulate(osc, force, v0=0.21307771939097353, t_end=30.0)

    release = float(run.contacts.release[0])
    pulls = [
        float(run.forces([t])["forcing"][0]) + 0.044248419977565505
        for t in (release - 1e-9, release + 1e-9)
    ]
    assert pulls[0] < 0.0 < pulls[1]


@pytest.mark.parametrize("end", ["t_end", "knot"])
@pytest.mark.parametrize("stop", [pc.Wall(0, "below", 0.5), pc.SoftStop(0, "below", 1e-3)])
@pytest.mark.parametrize("is_structure", [False, True])
def test_a_visit_that_would_end_with_the_search_is_not_missed(
    end: str, stop: pc.Wall | pc.SoftStop, is_structure: bool
) -> None:
    """x = (t - 1) (t - r) is back at the stop just where the run, or a piece of its force, ends."""
    for power in range(15):
        r = 1.0 + 2.0**-power
        force = pc.Forcing(constant=2)
        if end == "knot":
            force = pc.record([0, r, r + 1], [2, 2, 3])
        t_end = r if end == "t_end" else r + 1
        start = [r], [-1.0 - r]
        if is_structure:
            mass = pc.Structure([1], [0], stops=[replace(stop, on=0)])
            run: Any = pc.simulate(mass, pc.Loads({0: force}), *start, t_end=t_end)
        else:
            osc = pc.Oscillator(stiffness=0, stops=(stop,))
            run = pc.simulate(osc, force, r, -1.0 - r, t_end=t_end)

        events = run.impacts if isinstance(stop, pc.Wall) else run.crossings
        # The roots lie near to each other: rounding of 1e-15 moves them by 1e-15 over their
        # distance.
        assert events.t[0] == pytest.approx(1.0, abs=1e-14 / (r - 1.0))
