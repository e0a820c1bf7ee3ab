"""Sensitivities of runs against differences of the oracle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest
from tests.sensitivity.differences import differences

import percuss as pc
from percuss.arrays import Floats

# Of the largest derivative of a column: what is asked for. The tests see some 1e-13.
CLOSE = 1e-10
# What rounding leaves of a derivative that is zero, where others are of order one.
NOTHING = 1e-15


def assert_close(found: Floats, wanted: Floats, close: float = CLOSE) -> None:
    """Compare two columns with each other, relative to the largest entry."""
    assert found.shape == wanted.shape
    assert (np.isnan(found) == np.isnan(wanted)).all()
    size = np.nanmax(np.abs(wanted), initial=0.0)
    assert np.nanmax(np.abs(found - wanted), initial=0.0) <= close * size + NOTHING


def check(run: pc.Trajectory, *paths: str, close: float = CLOSE) -> pc.Trajectory:
    """Compare all derivatives of a run with differences of the oracle."""
    derivatives = run.sensitivity(paths)
    assert derivatives.differentiable
    events = np.unique(run.record[0][:, 0])
    middles = 0.5 * (events[1:] + events[:-1])
    times = [float(t) for t in [*middles[:3], *middles[-2:], run.t_end]]
    dx, dv = derivatives(times)
    for p, path in enumerate(paths):
        wanted = differences(run, path, times=times)
        assert_close(derivatives.impacts.t[:, p], wanted.t, close)
        assert_close(derivatives.impacts.v_before[:, p], wanted.v_before, close)
        assert_close(derivatives.impacts.v_after[:, p], wanted.v_after, close)
        assert_close(derivatives.crossings.t[:, p], wanted.crossings, close)
        assert_close(derivatives.contacts.start[:, p], wanted.start, close)
        assert_close(derivatives.contacts.release[:, p], wanted.release, close)
        assert_close(dx[:, p], wanted.x, close)
        assert_close(dv[:, p], wanted.v, close)
    return run


WALL = pc.Wall(at="0.2", side="above", restitution="0.8")
ALL = ("oscillator.damping", "oscillator.stiffness", "forcing.omega", "start.v0")
# Stiffness, damping and frequency of each linear regime, and the doubled poles to a hair.
REGIMES = {
    "underdamped": ("1", "0.05", "2"),
    "undamped": ("1", "0", "2"),
    "critical": ("1", "1", "2"),
    "critical to a hair": ("1", "1.000000000001", "2"),
    "overdamped": ("1", "2.5", "2"),
    "no spring": ("0", "0.3", "2"),
    "free": ("0", "0", "2"),
    "inverted": ("-1", "0.1", "2"),
    "growing": ("1", "-0.05", "2"),
    "resonance": ("4", "0", "2"),
    "resonance to a hair": ("4", "1e-13", "2.0000000000001"),
    "fast force": ("1", "0.05", "40"),
}


@pytest.mark.parametrize("regime", REGIMES)
def test_flights_of_each_linear_regime(regime: str) -> None:
    stiffness, damping, omega = REGIMES[regime]
    osc = pc.Oscillator(stiffness, damping)
    run = pc.simulate(osc, pc.cosine(omega, phase="0.3", constant="0.1"), "0.2", "0.5", t_end=4.5)
    check(run, *ALL, "forcing.amplitude", "forcing.phase", "forcing.constant", "start.x0")


def test_a_wall_with_restitution() -> None:
    wall = pc.Wall(at="0.2", side="above", restitution="0.8")
    osc = pc.Oscillator(damping="0.05", stops=(wall,))
    run = pc.simulate(osc, pc.cosine(2), v0="0.5", t_end=12.5)
    assert len(run.impacts) == 4
    check(run, *ALL, "oscillator.stops.0.at", "oscillator.stops.0.restitution", "start.t0")


def test_two_walls_and_a_late_start() -> None:
    walls = (
        pc.Wall(at="-0.3", side="below", restitution="0.9"),
        pc.Wall(at="0.2", side="above", restitution="0.7"),
    )
    osc = pc.Oscillator(2, "0.1", stops=walls)
    force = pc.cosine("1.9") + pc.sine("5.1", amplitude="0.4")
    run = pc.simulate(osc, force, 0, 2, "30*pi", t_end=97)
    assert set(run.impacts.stop) == {0, 1}
    check(
        run,
        "oscillator.stops.0.at",
        "oscillator.stops.1.restitution",
        "forcing.harmonics.1.omega",
        "forcing.harmonics.1.amplitude",
        "start.t0",
    )


def test_a_soft_stop_with_a_dashpot() -> None:
    stop = pc.SoftStop(at="0.1", side="above", stiffness=30, damping="1.5")
    osc = pc.Oscillator(damping="0.05", stops=(stop,))
    run = pc.simulate(osc, pc.cosine(2), v0="0.5", t_end=8)
    assert len(run.crossings) >= 4
    own = [f"oscillator.stops.0.{name}" for name in ("at", "stiffness", "damping")]
    check(run, *ALL, *own)


def test_stops_that_share_an_edge_and_one_is_moved() -> None:
    stops = (
        pc.SoftStop(at="0", side="above", stiffness=30, damping="1.5"),
        pc.SoftStop(at="0", side="above", stiffness=5, damping="0.5"),
        pc.SoftStop(at="0", side="below", stiffness=12, damping="0.2"),
    )
    run = pc.simulate(pc.Oscillator(stops=stops), pc.cosine(2), "-0.1", "0.5", t_end=6)
    path = "oscillator.stops.1.at"
    ahead, behind = (
        pc.simulate(
            pc.Oscillator(stops=(stops[0], pc.SoftStop(at, "above", 5, "0.5"), stops[2])),
            pc.cosine(2),
            "-0.1",
            "0.5",
            t_end=6,
        )
        for at in ("1e-6", "-1e-6")
    )
    wanted = (np.array(ahead(6.0)) - np.array(behind(6.0))) / 2e-6
    np.testing.assert_allclose(np.array(run.sensitivity([path])(6.0))[:, 0], wanted, rtol=1e-4)


def impacts_of_a_long_run(paths: list[str]) -> None:
    """Compare the derivatives of fifty impacts."""
    osc = pc.Oscillator(damping="0.05", stops=(WALL,))
    run = pc.simulate(osc, pc.cosine(2), v0="0.5", max_impacts=50)
    derivatives = run.sensitivity(paths)
    for p, path in enumerate(paths):
        wanted = differences(run, path, max_impacts=50)
        assert_close(derivatives.impacts.t[:, p], wanted.t)
        assert_close(derivatives.impacts.v_after[:, p], wanted.v_after)


def test_fifty_impacts_of_a_motion_that_is_not_chaotic() -> None:
    impacts_of_a_long_run(["oscillator.stops.0.at"])


@pytest.mark.nightly
def test_fifty_impacts_by_the_other_parameters() -> None:
    impacts_of_a_long_run(["oscillator.damping", "forcing.omega", "oscillator.stops.0.restitution"])


def chattering(t_end: float = 12.0) -> pc.Trajectory:
    """Return a run with two chatters on a wall, and releases."""
    osc = pc.Oscillator(1, "0.1", stops=(pc.Wall(at="-0.4", side="below", restitution="0.4"),))
    return pc.simulate(osc, pc.cosine("0.7", phase=2, constant="-0.4"), "-0.1", "0.5", t_end=t_end)


@pytest.mark.parametrize(
    ("paths", "t_end"),
    [
        (("oscillator.stops.0.restitution",), 4.6),
        pytest.param((*ALL, "oscillator.stops.0.at"), 12.0, marks=pytest.mark.nightly),
    ],
)
def test_a_chatter_and_a_release(paths: tuple[str, ...], t_end: float) -> None:
    run = chattering(t_end)
    assert len(run.contacts) == (2 if t_end > 10 else 1)
    assert np.isfinite(run.contacts.release[0])
    derivatives = run.sensitivity(paths)
    rest = float(run.contacts.start[0] + 0.01)
    later = float(run.contacts.release[0] + 0.5)
    dx, dv = derivatives([rest, later])
    for p, path in enumerate(paths):
        wanted = differences(run, path, times=[rest, later])
        n = int(run.contacts.n_impacts[0])
        assert_close(derivatives.impacts.t[:n, p], wanted.t[:n])
        assert_close(derivatives.impacts.v_after[:n, p], wanted.v_after[:n])
        assert_close(derivatives.contacts.start[:, p], wanted.start)
        assert_close(derivatives.contacts.release[:, p], wanted.release)
        assert_close(dx[:, p], wanted.x)
        assert_close(dv[:, p], wanted.v)


def test_what_was_before_a_contact_does_not_matter_after_it() -> None:
    run = chattering()
    dx, dv = run.sensitivity(["start.v0"])(run.contacts.release[0] + 0.5)
    assert dx[0] == dv[0] == 0.0


def test_the_tail_of_a_chatter() -> None:
    run = chattering(2.6)
    n = int(run.contacts.n_impacts[0])
    last, end = run.impacts.t[n - 1], run.contacts.start[0]
    times = last + (end - last) * np.array([0.1, 0.3, 0.65, 0.8, 0.9])
    path = "oscillator.stops.0.restitution"
    found = np.array(run.sensitivity([path])(times))[..., 0]
    wanted = differences(run, path, times=times.tolist())
    # As far as the tail's own hops are those of a constant force.
    np.testing.assert_allclose(found[0], wanted.x, atol=1e-5 * np.abs(wanted.x).max())
    np.testing.assert_allclose(found[1], wanted.v, rtol=1e-5)


def test_a_plastic_impact_and_its_release() -> None:
    osc = pc.Oscillator(1, "0.1", stops=(pc.Wall(at="-0.4", side="below", restitution=0),))
    run = pc.simulate(osc, pc.cosine("0.7", constant="-0.2"), "-0.1", "0.5", t_end=12)
    assert np.isfinite(run.contacts.release[0])
    check(run, *ALL, "oscillator.stops.0.at")


@pytest.mark.parametrize("knot", [0, 1])
def test_restitution_over_the_speed(knot: int) -> None:
    table = pc.restitution_table(speeds=(0, 1, 3), values=("0.9", "0.8", "0.6"))
    wall = pc.Wall(at=0, side="below", restitution=table)
    run = pc.simulate(pc.Oscillator(stops=(wall,)), pc.cosine("2.8"), v0=3, t_end=9)
    stop = "oscillator.stops.0"
    check(run, f"{stop}.restitution.values.{knot}", f"{stop}.restitution.speeds.1", f"{stop}.at")


def test_a_record() -> None:
    push = pc.record(["0", "0.7", "1.5", "3", "4"], ["0.1", "1", "-1.2", "0.9", "0"])
    run = pc.simulate(pc.Oscillator(damping="0.05", stops=(WALL,)), push, v0="0.5", t_end=7)
    assert len(run.impacts) >= 2
    check(run, "forcing.record.amplitude", "start.t0", "oscillator.stops.0.at", *ALL[:2])


@pytest.mark.parametrize("wave", [pc.square_wave, pc.triangle_wave])
def test_the_pace_of_a_wave(wave: Callable[..., pc.Forcing]) -> None:
    force = wave("1.7", "0.8")
    run = pc.simulate(pc.Oscillator(damping="0.05", stops=(WALL,)), force, v0="0.5", t_end=9)
    check(run, "forcing.record.omega", "forcing.record.amplitude", "oscillator.stops.0.at")


def test_a_record_of_no_size() -> None:
    osc = pc.Oscillator(stops=(WALL,))
    run = pc.simulate(osc, pc.square_wave("1.7", 0), v0=1, t_end=4)
    check(run, "forcing.record.amplitude")


def test_a_wall_that_lets_go_where_a_square_wave_turns() -> None:
    osc = pc.Oscillator(stops=(pc.Wall(at=0, side="below", restitution=0),))
    run = pc.simulate(osc, pc.square_wave("0.9", -1), "0", "0.3", t_end=8)
    assert np.isfinite(run.contacts.release[0])
    check(run, "forcing.record.omega", "forcing.record.amplitude", "oscillator.stiffness")


def test_parameters_of_expressions_and_a_mass() -> None:
    w = pc.parameter("w", "1.7")
    gap = pc.parameter("gap", "0.2")
    osc = pc.Oscillator.from_mass(
        2, 3, damping_coefficient="0.3", stops=(pc.Wall(at=gap, side="above", restitution="0.7"),)
    )
    force = pc.cosine(w, amplitude="1.5" * w**2)
    run = pc.simulate(osc, force, 0 * gap, gap * 2, t_end=9)
    check(run, "w", "gap", "oscillator.mass", "oscillator.stiffness", "oscillator.damping")


def test_terms_of_a_fourier_sum() -> None:
    force = pc.fourier("1.3", cos=["0.5", 0, "0.2"], sin=["0.1", "0.4"])
    run = pc.simulate(pc.Oscillator(damping="0.05", stops=(WALL,)), force, v0="0.5", t_end=9)
    check(run, "forcing.omega", "forcing.cos.2", "forcing.sin.1")


def test_a_start_on_a_wall_into_it() -> None:
    osc = pc.Oscillator(stops=(pc.Wall(at=0, side="below", restitution="0.8"),))
    run = pc.simulate(osc, pc.cosine("2.8"), 0, -1, t_end=4)
    assert run.impacts.t[0] == 0.0
    check(run, "start.v0", "oscillator.stops.0.restitution", "oscillator.stiffness")


def test_a_start_in_contact() -> None:
    osc = pc.Oscillator(stops=(pc.Wall(at=0, side="below", restitution="0.8"),))
    run = pc.simulate(osc, pc.sine("0.9", amplitude=-1), t0="0.5", t_end=7)
    assert run.contacts.start[0] == 0.5
    check(run, "start.t0", "forcing.omega", "forcing.amplitude")
    # Above the wall the mass would fall for a time that goes like the square root.
    assert np.isnan(run.sensitivity(["start.x0"]).contacts.start[0, 0])
    assert np.isfinite(run.sensitivity(["start.x0"]).contacts.release[0, 0])


def test_at_rest_on_a_wall_with_nothing_to_hold_it_there() -> None:
    osc = pc.Oscillator(stops=(pc.Wall(at=0, side="below", restitution="0.5"),))
    derivatives = pc.simulate(osc, t_end=3).sensitivity(["start.v0", "oscillator.stiffness"])
    assert not derivatives.differentiable
    np.testing.assert_array_equal(derivatives.grazes.sides, [0, 0])
    dx, dv = derivatives(2.0)
    # Away from the wall it would fly, and into it rebound.
    np.testing.assert_array_equal(dx, [np.nan, 0])
    np.testing.assert_array_equal(dv, [np.nan, 0])
    # A force that begins to press takes it back in no time.
    held = pc.simulate(osc, pc.sine(1, amplitude=-1), t_end=3).sensitivity(["start.v0"])
    assert held.differentiable
    assert held(2.0)[0] == 0.0


def grazing(speed: str) -> pc.Trajectory:
    """Return a run of x = speed sin t, towards a wall at 1."""
    osc = pc.Oscillator(stops=(pc.Wall(at=1, side="above", restitution="0.8"),))
    return pc.simulate(osc, v0=speed, t_end=6)


def test_a_graze_is_not_differentiable() -> None:
    derivatives = grazing("1").sensitivity(["start.v0", "oscillator.damping"])
    assert not derivatives.differentiable
    np.testing.assert_allclose(derivatives.grazes.t, [0.5 * np.pi])
    assert "square root" in derivatives.reason
    assert "start.v0 falls, oscillator.damping grows" in derivatives.reason
    assert "1.570796327" in repr(derivatives)
    dx, dv = derivatives([1.5, 1.6])
    assert np.isfinite(dx[0]).all()
    assert np.isfinite(dv[0]).all()
    assert np.isnan(dx[1]).all()
    assert np.isnan(dv[1]).all()


def test_the_side_of_a_graze_without_an_impact_has_a_derivative() -> None:
    derivatives = grazing("1").sensitivity(["start.v0", "oscillator.stops.0.at", "start.t0"])
    # x = v sin(t - t0), and a start that is later does not reach further.
    np.testing.assert_array_equal(derivatives.grazes.sides, [-1, 1, 0])
    dx, dv = derivatives.one_sided()([3, 5])
    np.testing.assert_allclose(dx[:, :2], [[np.sin(3), 0], [np.sin(5), 0]], rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(dv[:, :2], [[np.cos(3), 0], [np.cos(5), 0]], rtol=1e-13, atol=1e-15)
    assert np.isnan(dx[:, 2]).all()


@pytest.mark.parametrize("side", ["above", "below"])
def test_the_square_root_beyond_a_graze(side: Literal["above", "below"]) -> None:
    sign = 1 if side == "above" else -1
    walls = (
        pc.Wall(at=sign, side=side, restitution="0.8"),
        pc.Wall(at=-sign * 0.5, side="below" if sign > 0 else "above", restitution="0.6"),
    )
    osc = pc.Oscillator(stops=walls)
    run = pc.simulate(osc, v0=sign, t_end=6)
    path = "oscillator.stops.0.at"
    derivatives = run.sensitivity([path, "start.v0"])
    assert len(derivatives.grazes) == 1
    assert derivatives.grazes.sides.tolist() == [sign, -sign]
    root = derivatives.square_root()
    assert len(run.impacts) >= 1
    steps = np.array([1e-10, 4e-10])
    ends, first = [], []
    for h in steps:
        other = pc.simulate(osc, v0=sign * (1 + h), t_end=6)
        assert len(other.impacts) == len(run.impacts) + 1
        ends.append((np.array(other(6.0)) - np.array(run(6.0))) / np.sqrt(h))
        first.append((other.impacts.t[1] - run.impacts.t[0]) / np.sqrt(h))
    # To first order in the square root: that of the difference is removed.
    ahead, later = (2 * values[0] - values[1] for values in (np.array(ends), np.array(first)))
    np.testing.assert_allclose(np.array(root(6.0))[:, 1], ahead, rtol=1e-5)
    np.testing.assert_allclose(root.impacts.t[0, 1], later, rtol=1e-5)
    assert not np.array(root(1.5)).any()


def test_beyond_a_second_graze_nothing_is_known_of_the_root() -> None:
    osc = pc.Oscillator(stops=(pc.Wall(at=1, side="above", restitution="0.8"),))
    derivatives = pc.simulate(osc, v0=1, t_end=10).sensitivity(["start.v0"])
    assert len(derivatives.grazes) == 2
    root = derivatives.square_root()(np.array([7.0, 9.0]))[0]
    assert np.isfinite(root[0, 0])
    assert np.isnan(root[1, 0])
    assert np.isfinite(derivatives.one_sided()(9.0)[0]).all()


@pytest.mark.parametrize("speed", ["0.99999", "1.00001"])
def test_next_to_a_graze_it_is(speed: str) -> None:
    check(grazing(speed), "start.v0")


def test_a_graze_of_a_soft_stop_is_differentiable() -> None:
    stop = pc.SoftStop(at=1, side="above", stiffness=30, damping=1)
    run = pc.simulate(pc.Oscillator(stops=(stop,)), v0=1, t_end=6)
    assert len(run.grazes) == 1
    derivatives = run.sensitivity(["start.v0"])
    assert derivatives.differentiable
    np.testing.assert_allclose(
        np.array(derivatives(6.0))[:, 0], [np.sin(6.0), np.cos(6.0)], rtol=1e-12
    )


@pytest.mark.parametrize(
    ("paths", "reason"),
    [
        ([], "no list of paths"),
        ("start.v0", "no list of paths"),
        (["start.v0", "start.v0"], "named twice"),
        (["forcing.omgea"], "did you mean"),
        (["forcing.cos.1"], "left out of the sum"),
    ],
)
def test_what_cannot_be_asked(paths: list[str], reason: str) -> None:
    run = pc.simulate(pc.Oscillator(), pc.fourier("1.3", cos=["0.5", 0, 1]), t_end=3)
    with pytest.raises(pc.ParameterError, match=reason):
        run.sensitivity(paths)
