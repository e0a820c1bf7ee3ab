"""Periodic orbits under repeated records."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import percuss as pc
from percuss.orbits.orbit.knots import with_knots, without_knots

HARD = pc.impact_oscillator(0.7, wall=-0.2, damping=0.05)
SOFT = pc.Oscillator(1.0, 0.05, (pc.SoftStop(-0.1, "below", 20.0, 0.1),))


def returned(
    orbit: pc.PeriodicOrbit, x: float, v: float, t: float
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    run = pc.simulate(orbit.oscillator, orbit.forcing, x, v, t, t_end=t + orbit.period)
    return np.array(run(run.t_end)).ravel()


@pytest.mark.parametrize("osc", [HARD, SOFT], ids=["wall", "soft stop"])
@pytest.mark.parametrize(
    "force",
    [
        pc.square_wave("2.3"),
        pc.triangle_wave("2.3", amplitude="1.5"),
        pc.square_wave("2.3") + pc.cosine("2.3", amplitude="0.4"),
        pc.record([0.0, 0.7, 1.1, 2.9], [0.0, 2.0, -1.5, 0.0], repeat=True),
    ],
    ids=["square", "triangle", "with a harmonic", "samples"],
)
def test_an_orbit_closes_and_its_multipliers_are_those_of_its_neighbours(
    osc: pc.Oscillator, force: pc.Forcing
) -> None:
    orbit = pc.find_orbit(osc, force)
    run = orbit.trajectory()
    # Away from the events, where the map over a period is smooth.
    t = orbit.t0 + 0.37 * orbit.period
    x, v = (float(value) for value in run(t))
    assert orbit.residual < 1e-11
    assert np.abs(returned(orbit, x, v, t) - [x, v]).max() < 1e-11

    step = 1e-6
    columns = [
        (returned(orbit, x + a, v + b, t) - returned(orbit, x - a, v - b, t)) / (2 * step)
        for a, b in ((step, 0.0), (0.0, step))
    ]
    matrix = np.column_stack(columns)
    assert np.trace(matrix) == pytest.approx(orbit.multipliers.sum().real, abs=1e-6)
    assert np.linalg.det(matrix) == pytest.approx(orbit.multipliers.prod().real, abs=1e-6)


def test_the_motion_of_an_orbit_is_the_run_from_its_start() -> None:
    force = pc.record([0.0, 0.7, 1.1, 2.9], [0.0, 2.0, -1.5, 0.0], repeat=True)
    orbit = pc.find_orbit(HARD, force)
    t = np.linspace(orbit.t0, orbit.t0 + 3 * orbit.period, 400)[1:-1]
    own = orbit.trajectory(3)
    run = pc.simulate(HARD, force, orbit.x0, orbit.v0, orbit.t0, t_end=own.t_end)
    assert np.abs(run(t)[0] - own(t)[0]).max() < 1e-10
    assert len(own.impacts) == 3 * orbit.n_impacts
    events, marks = without_knots(*own.record)
    again = with_knots(orbit.system.law, events, marks, orbit.x0, own.t_end)
    assert np.abs(again[0] - own.record[0]).max() < 1e-13


@pytest.mark.parametrize("omega", [0.7, 2.3])
def test_without_impacts_it_is_the_closed_form(omega: float) -> None:
    """x = 1 - cos(t - h / 2) / cos(h / 2) over the half period h in which the force is 1."""
    orbit = pc.find_orbit(pc.Oscillator(), pc.square_wave(omega), n_impacts=0)
    half = math.pi / omega
    t = np.linspace(0.0, half, 50)
    expected = 1.0 - np.cos(t - half / 2) / math.cos(half / 2)
    assert np.abs(orbit.trajectory()(t)[0] - expected).max() < 1e-13
    assert (
        np.abs(orbit.trajectory()(np.minimum(t + half, orbit.period))[0] + expected).max() < 1e-12
    )
    # Its turning points lie in the middle of each half, and one more at the ends of long ones.
    turns = np.sort(orbit.turning_points.t)
    assert np.abs(turns[:, None] - [half / 2, 3 * half / 2]).min(axis=0).max() < 1e-12


def test_a_resonance_has_no_orbit_without_impacts() -> None:
    with pytest.raises(pc.ConvergenceError, match="resonance"):
        pc.find_orbit(pc.Oscillator(), pc.square_wave(1), n_impacts=0)


def test_a_graze_is_located_where_the_linear_response_reaches_the_wall() -> None:
    calm = pc.find_orbit(HARD, pc.triangle_wave("2.3", amplitude="0.1"), n_impacts=0)
    branch = pc.continue_orbit(calm, over={"forcing.record.amplitude": (0.1, 2.0)})
    (graze,) = branch.special_points
    lowest = calm.trajectory(2).extremes("displacement").minimum
    assert graze.kind == "grazing"
    assert graze.value == pytest.approx(0.1 * 0.2 / -lowest, rel=1e-11)


def test_a_branch_follows_the_frequency_of_a_wave() -> None:
    orbit = pc.find_orbit(HARD, pc.square_wave("2.3"))
    branch = pc.continue_orbit(orbit, over={"forcing.record.omega": (2.3, 2.0)})
    last = branch.orbits[-1]
    assert last.period == pytest.approx(math.pi, rel=1e-14)
    found = pc.find_orbit(HARD, pc.square_wave(2))
    assert float(last.impacts.v_before[0]) == pytest.approx(float(found.impacts.v_before[0]))


def test_a_fine_record_of_a_cosine_has_the_orbit_of_the_cosine() -> None:
    """Linear between n samples a period the force is off by (2 pi / n)^2 / 8."""
    n = 400
    phases = [pc.pi_times(2 * i, n) for i in range(n + 1)]
    values = [math.cos(2 * math.pi * i / n) for i in range(n + 1)]
    wave = pc.model.ForceRecord(tuple(phases), tuple(values), repeat=True, omega="2.3")
    orbit = pc.find_orbit(HARD, pc.Forcing(record=wave))
    smooth = pc.find_orbit(HARD, pc.cosine("2.3"))
    close = 10 * (2 * math.pi / n) ** 2 / 8
    assert float(orbit.impacts.v_before[0]) == pytest.approx(
        float(smooth.impacts.v_before[0]), abs=close
    )
    assert np.abs(orbit.multipliers - smooth.multipliers).max() < 10 * close


def test_the_maps_know_their_derivatives_under_a_record() -> None:
    force, step = pc.square_wave("2.3"), 1e-6
    for point, map_ in (
        ((0.3, 1.2), pc.impact_map(HARD, force)),
        ((0.4, 0.1), pc.stroboscopic_map(HARD, force, cycle=0.1)),
    ):
        moved = [
            (np.array(map_(*np.add(point, d))) - np.array(map_(*np.subtract(point, d))))
            / (2 * step)
            for d in ((step, 0.0), (0.0, step))
        ]
        assert np.abs(map_.jacobian(*point) - np.column_stack(moved)).max() < 1e-6


AMPLITUDE, OMEGA = "forcing.record.amplitude", "forcing.record.omega"


@pytest.mark.parametrize("wave", [pc.triangle_wave, pc.square_wave])
def test_a_curve_of_grazes_is_where_the_linear_response_reaches_the_wall(
    wave: Callable[..., pc.Forcing],
) -> None:
    calm = pc.find_orbit(HARD, wave("2.3", amplitude="0.1"), n_impacts=0)
    (graze,) = pc.continue_orbit(calm, over={AMPLITUDE: (0.1, 2.0)}).special_points
    curve = pc.continue_curve(graze, over={OMEGA: (2.2, 2.5), AMPLITUDE: (0.1, 2.0)})
    assert len(curve) > 5
    for omega, amplitude in curve.values[[0, len(curve) // 2, -1]]:
        linear = pc.find_orbit(pc.Oscillator(1.0, 0.05), wave(omega), n_impacts=0)
        lowest = linear.trajectory(2).extremes("displacement").minimum
        assert amplitude * lowest == pytest.approx(-0.2, rel=1e-11)


def test_a_curve_of_doublings_is_the_same_by_the_force_and_by_the_gap() -> None:
    """Amplitude and gap are one number: a motion under twice the force is twice as large."""
    orbit = pc.find_orbit(HARD, pc.triangle_wave("2.3", amplitude="1.5"))
    branch = pc.continue_orbit(orbit, over={OMEGA: (2.0, 2.6)})
    doubling = next(p for p in branch.special_points if p.kind == "period_doubling")
    ends = {OMEGA: (doubling.value - 0.04, doubling.value + 0.05)}
    by_force = pc.continue_curve(doubling, over={**ends, AMPLITUDE: (0.5, 3.0)})
    by_gap = pc.continue_curve(doubling, over={**ends, "oscillator.stops.0.at": (-0.5, -0.1)})
    assert np.abs(by_force.multipliers + 1.0).min(axis=1).max() < 1e-8
    for first, last in ((0, 0), (-1, -1)):
        (omega, amplitude), (other, gap) = by_force.values[first], by_gap.values[last]
        assert omega == other
        assert amplitude / 1.5 * gap == pytest.approx(-0.2, rel=1e-9)


def test_the_chart_under_a_square_wave_misses_no_attractor() -> None:
    chart = pc.response_curve(
        HARD, pc.square_wave("2.3"), over={OMEGA: (2.0, 2.1)},
        max_impacts=1, max_periods=1, n_seeds=1,
    )  # fmt: skip
    assert chart.missed == ()
    (family,) = [f for f in chart.families if f.n_impacts == 1]
    assert family.stable_ranges == ((2.0, 2.1),)
    orbit = pc.find_orbit(HARD, pc.square_wave("2.1"))
    speeds = [speed[-1] for speed in chart.impact_velocity]
    assert np.nanmin(np.abs(np.array(speeds) + float(orbit.impacts.v_before[0]))) < 1e-10


@pytest.mark.parametrize(
    "force",
    [
        pc.square_wave("0.7") + pc.Forcing(constant="-0.3"),
        pc.triangle_wave("0.7") + pc.Forcing(constant="-0.3"),
        pc.pulses("0.7", width="0.2", amplitude=2) + pc.Forcing(constant="-0.6"),
    ],
    ids=["square", "triangle", "pulses"],
)
def test_an_orbit_with_sticking_is_where_runs_settle(force: pc.Forcing) -> None:
    """A jump of a square wave, and of pulses, releases the mass that the force pressed before."""
    osc = pc.impact_oscillator("0.3", damping="0.1")
    orbit = pc.find_orbit(osc, force, n_impacts=math.inf)
    assert orbit.admissible
    run = pc.simulate(osc, force, orbit.x0, orbit.v0, orbit.t0, t_end=orbit.t0 + 3 * orbit.period)
    t = np.linspace(run.t0, run.t_end, 500)[1:-1]
    own = orbit.trajectory(3)
    assert np.abs(own(t)[0] - run(t)[0]).max() < 1e-12
    assert len(own.contacts) == 3
    late = pc.simulate(osc, force, periods=40)
    assert late.contacts.start[-1] % orbit.period == pytest.approx(
        own.contacts.start[0] % orbit.period, abs=1e-11
    )
    omega = {OMEGA: (0.7, 0.72)}
    last = pc.continue_orbit(orbit, over=omega, largest_step=1.0).orbits[-1]
    assert math.isinf(last.n_impacts)
    assert last.period == pytest.approx(2 * math.pi / 0.72)


@pytest.mark.parametrize("force", [pc.square_wave("2.3"), pc.triangle_wave("2.3", "1.5")])
def test_states_of_a_singularity_set_lead_to_grazes(force: pc.Forcing) -> None:
    singular = pc.singularity_set(HARD, force)
    assert len(singular) > 0
    for curve in singular:
        k = len(curve) // 2
        t0, t1 = curve.cycle[k] * force.period, curve.touch_cycle[k] * force.period
        run = pc.simulate(HARD, force, -0.2, curve.v_after[k], t0, t_end=t1 + 0.01)
        x, v = run(t1, limit="before")
        # Near a graze an error of the state becomes its square root in the velocity.
        assert abs(x + 0.2) < 1e-12
        assert abs(v) < 1e-6


def test_the_manifolds_of_a_driven_pendulum_are_straight_under_a_square_wave_too() -> None:
    osc = pc.Oscillator(stiffness=-1.0, damping=0.1)
    orbit = pc.find_orbit(osc, pc.square_wave(2), n_impacts=0)
    grown = pc.manifolds(orbit, length=2.0)
    root = math.sqrt(1 + 0.1**2)
    for branches, slope in ((grown.unstable, root - 0.1), (grown.stable, -root - 0.1)):
        for branch in branches:
            x, v = (branch.points - grown.saddles[0]).T
            assert np.abs(v[1:] / x[1:] - slope).max() < 1e-9
