"""The response chart: all families over one parameter, checked by direct simulation."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import percuss as pc
from percuss.orbits.orbit.extremes import extremes_of

WALL = pc.impact_oscillator(0.8, wall=0.2, side="above", damping=0.05)
SOFT = pc.bilinear_oscillator(stiffness_above=1.0, stiffness_below=9.0, damping=0.05)
OMEGA = "forcing.omega"


@functools.cache
def wall_chart() -> pc.Response:
    """Return the chart of the wall oscillator, from its resonance to (1, 3) orbits."""
    return pc.response_curve(
        WALL, pc.cosine(3.0), {OMEGA: (1.8, 5.5)}, max_impacts=2, max_periods=3, n_seeds=2
    )


@functools.cache
def soft_chart() -> pc.Response:
    """Return a chart of the bilinear oscillator around the end of its (2, 2) orbits."""
    return pc.response_curve(
        SOFT, pc.cosine(2.0), {OMEGA: (2.1, 2.7)}, max_impacts=3, max_periods=3, n_seeds=1
    )


def kind_of_rows(branch: pc.Branch, n_impacts: float, n_periods: int) -> NDArray[np.bool_]:
    kinds = np.array([(orbit.n_impacts, orbit.n_periods) for orbit in branch])
    return np.asarray((kinds == (n_impacts, n_periods)).all(axis=1))


def kinds(chart: pc.Response) -> set[tuple[int, int]]:
    return {(family.n_impacts, family.n_periods) for family in chart.families}


@pytest.mark.parametrize("n", [4, pytest.param(20, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("which", ["wall", "soft"])
def test_every_attractor_of_many_motions_is_on_a_branch(which: str, n: int) -> None:
    """Some frequencies, six starts each, told apart by their states at whole periods."""
    osc, chart = (WALL, wall_chart()) if which == "wall" else (SOFT, soft_chart())
    random = np.random.default_rng(5)
    compared = 0
    for omega in np.linspace(chart.low + 0.013, chart.high - 0.013, n).tolist():
        for _ in range(6):
            v0, cycle = random.uniform(-3.0, 0.0), random.random()
            seen = _settled(osc, omega, float(v0), float(cycle))
            if seen is None or seen[0] > chart.max_impacts:
                continue
            n_impacts, n_periods, fastest = seen
            assert fastest in _Fastest(chart, omega, n_impacts, n_periods)
            compared += 1
    assert compared > 3 * n


def _settled(
    osc: pc.Oscillator, omega: float, v0: float, cycle: float
) -> tuple[int, int, float] | None:
    """Return impacts, periods and the largest impact speed of what a motion comes to."""
    period = 2.0 * math.pi / omega
    run = pc.simulate(osc, pc.cosine(omega), 0.0, v0, cycle * period, periods=300)
    states = np.column_stack(run(run.t_end - period * np.arange(4.0)))
    returns = np.abs(states[1:] - states[0]).max(axis=1) < 1e-7
    if not returns.any():
        return None
    n_periods = 1 + int(returns.argmax())
    entries = run.crossings.direction == "in"
    t = run.impacts.t if osc is WALL else run.crossings.t[entries]
    v = run.impacts.v_before if osc is WALL else run.crossings.v[entries]
    last = t > run.t_end - n_periods * period
    fastest = float(np.abs(v[last]).max(initial=0.0))
    return int(last.sum()), n_periods, fastest


class _Fastest:
    """The largest impact velocities of stable orbits of a kind, between the rows of a chart."""

    def __init__(self, chart: pc.Response, omega: float, n_impacts: int, n_periods: int) -> None:
        self.found: list[float] = []
        for branch, speeds in zip(chart.branches, chart.impact_velocity, strict=True):
            of_kind = kind_of_rows(branch, n_impacts, n_periods)
            off = branch.values - omega
            for i in np.flatnonzero((off[:-1] * off[1:] <= 0.0) & of_kind[:-1] & of_kind[1:]):
                if branch.is_stable[[i, i + 1]].any() and off[i] != off[i + 1]:
                    part = off[i] / (off[i] - off[i + 1])
                    speed = speeds[i] + part * (speeds[i + 1] - speeds[i])
                    self.found.append(float(np.nan_to_num(speed)))

    def __contains__(self, speed: float) -> bool:
        # The line between two rows is straight.
        return any(abs(one - speed) < 5e-3 * max(1.0, speed) for one in self.found)


def test_the_kinds_that_are_known_are_there() -> None:
    assert kinds(wall_chart()) == {(0, 1), (1, 1), (1, 2), (2, 2), (1, 3), (2, 3)}
    assert {(1, 1), (1, 2), (2, 2), (2, 3), (3, 3)} <= kinds(soft_chart())


def test_no_attractor_is_missed_and_each_number_of_a_branch_is_right() -> None:
    chart = wall_chart()

    assert chart.missed == ()
    assert chart.complete
    on = [seen for seen in chart.attractors if seen.branch is not None]
    assert len(on) > 5
    for seen in on:
        assert seen.branch is not None
        branch = chart.branches[seen.branch]
        values = branch.values[kind_of_rows(branch, seen.n_impacts, seen.n_periods)]
        assert values.min() <= seen.value <= values.max()


def test_a_hidden_branch_is_reported_as_missed() -> None:
    chart = wall_chart()
    gone = next(i for i, b in enumerate(chart.branches) if b[0].n_periods == 3)
    seen = tuple(
        dataclasses.replace(seen, branch=None) if seen.branch == gone else seen
        for seen in chart.attractors
    )
    hidden = dataclasses.replace(chart, attractors=seen)

    assert {(seen.n_impacts, seen.n_periods) for seen in hidden.missed} == {(1, 3)}
    assert f"{len(hidden.missed)} missed" in repr(hidden)


def test_single_impact_families_end_where_the_closed_form_says() -> None:
    """The fold of the (1, 2) orbits in omega, from the ellipse of velocity against gap."""
    chart = wall_chart()
    family = next(f for f in chart.families if (f.n_impacts, f.n_periods) == (1, 2))
    fold = family.ranges[-1][1]

    inside = pc.velocity_gap_curve(WALL, pc.cosine(fold - 1e-6), 2, n_points=3)
    outside = pc.velocity_gap_curve(WALL, pc.cosine(fold + 1e-6), 2, n_points=3)
    assert len(inside.velocities_at(0.2)) == 2
    assert len(outside.velocities_at(0.2)) == 0
    assert family.stable_ranges[-1][1] == fold


def test_no_family_is_followed_twice() -> None:
    for chart in (wall_chart(), soft_chart()):
        for i, one in enumerate(chart.branches):
            for k, other in enumerate(chart.branches):
                if i == k or one[0].n_impacts != other[0].n_impacts:
                    continue
                middle = one[len(one) // 2]
                near = int(np.abs(other.values - one.values[len(one) // 2]).argmin())
                if one[0].n_periods != other[0].n_periods or middle.n_impacts == 0:
                    continue
                apart = abs(extremes_of(middle).amplitude - chart.amplitude[k][near])
                same_place = abs(other.values[near] - one.values[len(one) // 2]) < 1e-3
                assert not (same_place and apart < 1e-6)


def test_branches_go_on_where_a_soft_stop_is_met_once_more() -> None:
    """(2, 3) orbits begin where (3, 3) ones leave the stop, at both of their ends."""
    families = {(f.n_impacts, f.n_periods): f for f in soft_chart().families}

    two, three = families[2, 3], families[3, 3]
    (low, high), *_ = two.ranges
    edges = [edge for interval in three.stable_ranges for edge in interval]
    assert min(abs(edge - low) for edge in edges) < 1e-9
    assert min(abs(edge - high) for edge in edges) < 1e-9


@pytest.mark.parametrize("which", ["wall", "soft"])
def test_amplitudes_are_those_of_the_motion(which: str) -> None:
    response = wall_chart() if which == "wall" else soft_chart()
    for branch, amplitude, largest in zip(
        response.branches, response.amplitude, response.largest_displacement, strict=True
    ):
        for row in range(0, len(branch), max(len(branch) // 3, 1)):
            run = branch[row].trajectory(2)
            x, _ = run(np.linspace(run.t0, run.t_end, 4001))
            # A sample misses an extreme by the square of its step.
            assert 0.5 * np.ptp(x) == pytest.approx(amplitude[row], rel=1e-5)
            assert 0.5 * np.ptp(x) <= amplitude[row] + 1e-12
            assert np.abs(x).max() == pytest.approx(largest[row], rel=1e-5)


def test_extremes_of_the_linear_response_are_its_amplitude() -> None:
    chart = wall_chart()
    omega = chart.branches[0].values

    expected = 1.0 / np.hypot(1.0 - omega**2, 0.1 * omega)
    np.testing.assert_allclose(chart.amplitude[0], expected, rtol=1e-13)


def test_extremes_with_sticking_end_at_the_wall() -> None:
    osc, force = pc.ball_on_table(amplitude="1.2", omega=1, gravity=1, restitution="0.5")
    orbit = pc.find_orbit(osc, force, n_impacts=math.inf)

    found = extremes_of(orbit)
    run = orbit.trajectory()
    x, _ = run(np.linspace(run.t0, run.t_end, 20001))
    assert found.low == 0.0
    assert found.high == pytest.approx(x.max(), rel=1e-7)


def test_the_same_seed_gives_the_same_chart() -> None:
    over = {OMEGA: (2.0, 2.2)}
    one, other = (
        pc.response_curve(WALL, pc.cosine(2.0), over, max_impacts=1, max_periods=1, n_seeds=1)
        for _ in range(2)
    )

    assert len(one.branches) == len(other.branches)
    for a, b in zip(one.branches, other.branches, strict=True):
        np.testing.assert_array_equal(a.values, b.values)


def test_over_a_gap_as_over_a_frequency() -> None:
    gap = "oscillator.stops.0.at"
    chart = pc.response_curve(
        WALL, pc.cosine(2.8), {gap: (-0.5, 1.5)}, max_impacts=1, max_periods=2, n_seeds=1
    )
    ellipse = pc.velocity_gap_curve(WALL, pc.cosine(2.8), 2)
    family = next(f for f in chart.families if (f.n_impacts, f.n_periods) == (1, 2))

    assert family.ranges[-1][1] == pytest.approx(ellipse.fold, abs=1e-9)
    branch = chart.branches[family.branches[0]]
    for value, speed in zip(branch.values[::20], branch.impact_velocity[::20, 0], strict=True):
        if speed > 0.0:
            assert np.abs(ellipse.velocities_at(float(value)) - speed).min() < 1e-7


def test_as_a_table_every_row_has_its_branch() -> None:
    chart = wall_chart()
    data = chart.to_xarray()

    assert data.sizes["point"] == sum(len(branch) for branch in chart.branches)
    rows = data.where(data.branch == 2, drop=True)
    np.testing.assert_array_equal(rows.value, chart.branches[2].values)
    np.testing.assert_array_equal(rows.amplitude, chart.amplitude[2])
    assert data.attrs["path"] == OMEGA
    assert data.sizes["attractor"] == len(chart.attractors)


def test_progress_is_told_and_can_stop_it() -> None:
    reported: list[tuple[float, float]] = []

    def stop(done: float, total: float) -> bool:
        reported.append((done, total))
        return done < 10

    chart = pc.response_curve(
        WALL, pc.cosine(2.0), {OMEGA: (2.0, 2.5)},
        max_impacts=1, max_periods=1, n_seeds=1, progress=stop,
    )  # fmt: skip

    # The value that is searched counts as eight at which motions settle; a slow machine may be told
    # that nothing is done yet.
    assert sorted({done for done, _ in reported} - {0}) == [8, 9, 10]
    assert all(done <= total for done, total in reported)
    assert not chart.complete
    assert "stopped" in repr(chart)


@pytest.mark.parametrize(
    ("moves", "path", "on"),
    [
        (WALL, OMEGA, None),
        (
            pc.chain([1], [0, 1], [0, "0.05"], [pc.Wall(at=1.0, side="above", on=0)]),
            "loads.0.omega",
            0,
        ),
    ],
)
def test_progress_is_told_and_can_stop_it_while_a_branch_is_followed(
    moves: pc.Oscillator | pc.Structure,
    path: str,
    on: int | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # By the clock: here at each orbit of the branch.
    monkeypatch.setattr("percuss.progress.CALLED", 0.0)
    reported: list[float] = []

    def while_following(done: float, total: float) -> bool:  # noqa: ARG001
        reported.append(done)
        # All has been searched and has settled after 8 + 8; then orbits are followed.
        return reported.count(16) < 5

    force = pc.cosine(2.0)
    chart = pc.response_curve(
        moves, force if on is None else pc.Loads({on: force}), {path: (2.0, 2.5)}, on=on,
        max_impacts=1, max_periods=1, n_seeds=1, progress=while_following,
    )  # fmt: skip

    assert max(reported) == 16
    assert not chart.complete
    assert [len(branch) for branch in chart.branches] == [5]


@pytest.mark.parametrize(
    ("force", "over", "options", "message"),
    [
        (pc.cosine(2.0), {"forcing.omgea": (1.0, 2.0)}, {}, "did you mean"),
        (pc.cosine(2.0), {OMEGA: (2.0, 2.0)}, {}, "two different finite"),
        (pc.cosine(2.0), {OMEGA: (-1.0, 2.0)}, {}, "omega"),
        (pc.cosine(2.0), {OMEGA: (1.0, 2.0, 3.0)}, {}, "two numbers"),
        (pc.cosine(2.0), {}, {}, "one parameter"),
        (pc.cosine(2.0), {OMEGA: (1.0, 2.0)}, {"n_seeds": 0}, "n_seeds = 0"),
        (pc.cosine(2.0), {OMEGA: (1.0, 2.0)}, {"max_impacts": 0}, "max_impacts = 0"),
        (None, {OMEGA: (1.0, 2.0)}, {}, "not a Forcing"),
        (pc.Forcing(constant=1.0), {"forcing.constant": (1.0, 2.0)}, {}, "periodic forcing"),
    ],
)
def test_what_does_not_fit_is_told_in_a_sentence(
    force: Any, over: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.response_curve(WALL, force, over, **options)
