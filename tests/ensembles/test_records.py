"""Many motions under records: the same as one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles import batch
from percuss.ensembles.batch import Plan, follow_batch
from percuss.kernels import observables, record
from percuss.model.system import law, stop_rows


def test_a_sweep_over_the_amplitude_of_a_record_is_made_of_its_runs() -> None:
    rng = np.random.default_rng(1)
    t = np.concatenate([[0.0], np.cumsum(rng.exponential(0.4, 20))])
    force = pc.record(t, rng.normal(size=21), repeat=True)
    osc = pc.impact_oscillator(0.8, wall=-0.1, damping=0.02)
    amplitudes = [0.5, 0.9, 1.4, 2.0]

    grid = pc.sweep(
        ["peak_impact_velocity", "impacts_per_period", "max_displacement"],
        osc,
        force,
        over={"forcing.record.amplitude": amplitudes},
        start=(0.0, 0.3),
        transient=0,
        periods=3,
    )

    for i, amplitude in enumerate(amplitudes):
        assert force.record is not None
        own = pc.Forcing(record=force.record.with_fields(amplitude=amplitude))
        run = pc.simulate(osc, own, v0=0.3, periods=3)
        assert float(grid.peak_impact_velocity[i]) == np.abs(run.impacts.v_before).max()
        assert float(grid.impacts_per_period[i]) == pytest.approx(len(run.impacts) / 3)
        highest = run.extremes("displacement").maximum
        assert float(grid.max_displacement[i]) == pytest.approx(highest, rel=1e-12)


def test_the_exponents_of_a_stable_motion_under_a_square_wave_obey_the_sum_rule() -> None:
    """Without stops they are the real parts of the roots; with one, ln r of each impact more."""
    free = pc.lyapunov_exponents(
        pc.Oscillator(1.0, 0.1), pc.square_wave(1.3), transient=50, periods=200
    )
    assert np.allclose(free.exponents, -0.1, atol=1e-6)
    osc = pc.impact_oscillator(0.7, wall=0.0, damping=0.05)
    rates = pc.lyapunov_exponents(osc, pc.square_wave(2.5), start=(0.0, 1.0), periods=2000)
    expected = -0.1 + 2.0 * math.log(0.7) * rates.impact_rate
    assert rates.exponents.sum() == pytest.approx(expected, abs=1e-3)
    assert rates.total == pytest.approx(expected, abs=1e-9)


def test_a_neighbour_moves_as_the_exponents_say() -> None:
    """The knots leave the derivative of a motion alone: two starts a hair apart."""
    osc = pc.impact_oscillator(0.9, wall=-0.5)
    force = pc.triangle_wave("1.7", amplitude=2)
    step = 1e-7
    run, near = (pc.simulate(osc, force, v0=v, t_end=12.0) for v in (0.4, 0.4 + step))
    assert len(run.impacts) == len(near.impacts) > 1
    moved = (near(12.0)[0] - run(12.0)[0]) / step
    rate = 0.0
    assert abs(moved) < 1e3
    for s in (1e-5, 1e-6):
        other = pc.simulate(osc, force, v0=0.4 + s, t_end=12.0)
        rate = (float(other(12.0)[0]) - float(run(12.0)[0])) / s
    assert rate == pytest.approx(float(moved), rel=1e-3)


def test_basins_under_a_square_wave_know_their_motions() -> None:
    osc = pc.impact_oscillator(0.6, wall=-0.3, damping=0.1)
    x0, v0 = np.linspace(-0.2, 1.0, 4), np.linspace(-1.0, 1.0, 4)
    basins = pc.basins(osc, pc.square_wave(2.0), x0=x0, v0=v0, periods=300)
    run = pc.simulate(osc, pc.square_wave(2.0), x0=x0[1], v0=v0[2], periods=400)
    ends = run.stroboscopic().isel(period=slice(-20, None))
    assert (basins.basin == 0).all()
    assert float(basins.attractor_x0[0, 0]) == pytest.approx(float(ends.x[-1]), abs=1e-6)
    assert float(basins.attractor_v0[0, 0]) == pytest.approx(float(ends.v[-1]), abs=1e-6)


def test_strobes_in_contact_are_written_at_the_knots_that_they_pass(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A motion that is left in a contact over many knots has all its strobes up to there."""
    knots = np.arange(0.0, 40.0, 0.5)
    force = pc.record(knots, -1.0 - 0.2 * np.sin(knots))
    osc = pc.impact_oscillator(0, wall=0.0)
    rows, stops = law(osc, force)[np.newaxis], stop_rows(osc)[np.newaxis]
    which, start = np.zeros(1, dtype=np.int64), np.array([[0.0, 0.0, 0.0]])
    plan = Plan(
        np.array([1.0]), np.array([0.3]), np.array([39.0]), observables.STROBES, n_points=200
    )
    whole = follow_batch(rows, which, start, plan, stops)
    monkeypatch.setattr(batch, "MOST_SEARCHES", 0)
    reached = []
    for patience in range(1, 60, 7):
        monkeypatch.setattr(batch, "PATIENCE", patience)
        part = follow_batch(rows, which, start, plan, stops)
        t, n = float(part.state[0, record.T]), int(part.values[0, observables.POINTS])
        assert part.status[0] == record.SPENT
        assert n == int((1.0 + 0.3 * np.arange(200) < t).sum())
        np.testing.assert_array_equal(part.points[0, :n], whole.points[0, :n])
        reached.append(t)
    assert (np.diff(reached) > 0.0).all()
    assert reached[-1] > 20.0
    assert int(whole.values[0, observables.POINTS]) == 127
