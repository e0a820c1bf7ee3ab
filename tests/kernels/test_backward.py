"""Motions followed back in time."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.kernels import backward as engine
from percuss.kernels.backward import bound_of_fourth, time_to_leave
from percuss.kernels.flight import Flight, move, set_phases
from percuss.kernels.law_columns import FIRST_HARMONIC, QUICKEST
from percuss.model.system import System
from percuss.model.system import law as law_of
from percuss.orbits.surface.backward import BackwardMotions

WALLS = (pc.Wall(-1, "below", 0.8), pc.Wall(1, "above", 0.7))
SOFT = (pc.SoftStop(0.2, "above", 29.0, 0.7), pc.SoftStop(-0.3, "below", 5.0, 0.2))
SYSTEMS = {
    "wall": (pc.impact_oscillator(0.8), pc.cosine(2.5)),
    "damped": (pc.impact_oscillator(0.7, wall=-0.4, damping=0.05), pc.cosine(1.3)),
    "overdamped": (pc.impact_oscillator(0.7, wall=-0.1, damping=1.1), pc.cosine(1.3)),
    "soft stops": (pc.Oscillator(1.0, 0.02, SOFT), pc.cosine(1.3)),
    "two walls": (pc.Oscillator(0.3, 0.01, WALLS), pc.fourier(1.3, cos=(1.0, 0.3))),
    "no spring": pc.ball_on_table(amplitude=0.9, omega=1.0, gravity=1.0, restitution=0.9),
    "elastic resonance": (pc.impact_oscillator(), pc.sine(1)),
    "square wave": (pc.impact_oscillator(0.8, wall=-0.2), pc.square_wave("2.5")),
    "triangle wave and a harmonic": (
        pc.impact_oscillator(0.7, wall=-0.4, damping=0.05),
        pc.triangle_wave("1.3") + pc.cosine("1.3", amplitude=0.3),
    ),
    "held samples": (
        pc.Oscillator(1.0, 0.02, SOFT),
        pc.record([0.5, 1.5, 2.2, 3.4, 9.0], [0.0, 2.0, -1.0, 0.3, 0.5], "hold"),
    ),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_motions_come_back_to_where_they_began(name: str) -> None:
    osc, force = SYSTEMS[name]
    rng = np.random.default_rng(7)
    x0, v0 = rng.uniform(0.0, 0.9, 60), rng.uniform(-1.0, 1.0, 60)
    end = 6.0
    runs = [pc.simulate(osc, force, x, v, t_end=end) for x, v in zip(x0, v0, strict=True)]
    free = np.array([len(run.contacts) == 0 for run in runs])
    events = np.array([len(run.impacts) + len(run.crossings) for run in runs])
    states = np.array([run(end) for run in runs])

    motions = BackwardMotions(System(osc, force))
    past = motions.follow(np.full(60, end), states[:, 0], states[:, 1], end)

    assert free.sum() > 20
    assert events[free].max() >= 1
    assert set(past.status[free].tolist()) == {engine.AT_TIME}
    # Back in time a distance grows as the free motion and each impact let it shrink before.
    damping = float(osc.damping)
    growth = np.exp(end * (damping + np.sqrt(max(damping**2 - 1.0, 0.0)))) / 0.7 ** events[free]
    error = np.hypot(past.x_end - x0, past.v_end - v0)[free]
    assert (error / growth).max() < 1e-12


def test_impact_before_is_that_of_the_run() -> None:
    osc, force = SYSTEMS["damped"]
    run = pc.simulate(osc, force, 0.0, 1.0, t_end=30.0)
    impacts = run.impacts
    motions = BackwardMotions(System(osc, force))
    end = float(impacts.t[-1]) + 0.3
    x, v = run([end])

    past = motions.follow(np.array([end]), x, v, 30.0, bound=0, n_hits=4)

    np.testing.assert_allclose(past.t[0], impacts.t[-1:-5:-1], atol=1e-11)
    np.testing.assert_allclose(past.v[0], impacts.v_after[-1:-5:-1], atol=1e-11)
    assert past.n_between[0].tolist() == [0, 1, 2, 3]


def test_no_way_leads_back_over_an_impact_without_restitution() -> None:
    osc = pc.impact_oscillator(0.0)
    past = BackwardMotions(System(osc, pc.cosine(2.5))).follow(
        np.array([1.0]), np.array([0.5]), np.array([0.5]), 20.0
    )

    assert past.status.tolist() == [engine.NO_RESTITUTION]


def test_mass_under_pressure_has_no_past() -> None:
    osc = pc.impact_oscillator(0.8)
    past = BackwardMotions(System(osc, pc.cosine(2.5, amplitude=-1.0))).follow(
        np.zeros(1), np.zeros(1), np.zeros(1), 5.0
    )

    assert past.status.tolist() == [engine.NO_PAST]


def test_motion_that_was_ever_faster_is_given_up() -> None:
    """Between two walls impacts accumulate back in time."""
    osc, force = pc.Oscillator(0.3, 0.01, WALLS), pc.cosine(1.3)
    past = BackwardMotions(System(osc, force)).follow(
        np.zeros(1), np.zeros(1), np.ones(1), 500.0, fastest=1e3
    )

    assert past.status.tolist() == [engine.TOO_FAST]
    assert 1e3 <= abs(past.v_end[0]) < 2e3


def test_start_at_a_wall_with_the_velocity_off_it_is_that_after_an_impact() -> None:
    motions = BackwardMotions(System(pc.impact_oscillator(0.5), pc.cosine(2.5)))
    after = motions.follow(np.zeros(1), np.zeros(1), np.ones(1), 1.0)
    before = motions.follow(np.zeros(1), np.zeros(1), -2.0 * np.ones(1), 1.0)

    assert after.x_end == pytest.approx(before.x_end, abs=1e-15)


@pytest.mark.parametrize("damping", [0.0, 0.3, 1.0, 1.7])
@pytest.mark.parametrize("stiffness", [1.0, 0.0, -1.0])
def test_fourth_derivative_keeps_its_bound(damping: float, stiffness: float) -> None:
    osc = pc.Oscillator(stiffness, damping)
    law = law_of(osc, pc.cosine(1.7, amplitude=2.0))
    region = FIRST_HARMONIC + 1
    phases, arrival = np.empty((1, 2)), np.empty((1, 2))
    set_phases(law, 0.4, 0.0, phases)
    width = 0.5 / max(1.7, law[region, QUICKEST])

    def derivatives(s: float) -> tuple[float, float, float]:
        y, v = move(Flight(law, region, (0.4, 0.0, 0.8, 0.0), phases, arrival), -s)
        t = 0.4 - s
        second = 2.0 * np.cos(1.7 * t) - 2.0 * damping * v - stiffness * y
        third = -3.4 * np.sin(1.7 * t) - 2.0 * damping * second - stiffness * v
        fourth = -2.0 * 1.7**2 * np.cos(1.7 * t) - 2.0 * damping * third - stiffness * second
        return second, third, fourth

    second, third, _ = derivatives(0.0)
    largest = max(abs(derivatives(s)[2]) for s in np.linspace(0.0, width, 40))
    for bound in (bound_of_fourth, bound_of_fourth.py_func):  # type: ignore[attr-defined]
        assert largest <= bound(law, region, second, third, width) < 30.0 * (largest + 6.0)


def test_time_to_leave_keeps_the_clearance_positive() -> None:
    for call in (time_to_leave, time_to_leave.py_func):  # type: ignore[attr-defined]
        assert call(-1.0, 1.0, 1.0, 1.0, 1.0) == 0.0
        assert call(0.0, -1.0, 1.0, 1.0, 1.0) == 0.0
        assert call(0.0, 0.0, 1.0, 1.0, 1.0) == 0.0
        for first, second, third in ((1.0, -4.0, 2.0), (0.0, 1.0, -9.0), (1e-9, -1.0, 0.0)):
            free = call(first, second, third, 0.5, 1.0)
            s = np.linspace(0.0, free, 50)[1:]
            least = first * s + second * s**2 / 2 - abs(third) * s**3 / 6 - 0.5 * s**4 / 24
            assert free > 0.0
            assert least.min() > 0.0
