"""Flights far longer than the fastest part of the motion: only what is alive sets the pace."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.kernels import record as columns
from percuss.model.system import System
from percuss.motion.simulate import _March

STIFF = pc.Oscillator(1.0, 0.0, (pc.SoftStop(0.0, "below", 1e8, 1e6),))


def searches(osc: pc.Oscillator, force: pc.Forcing, t_end: float, x0: float, v0: float) -> int:
    """Return how many searches a run takes, to the next few hundred."""
    march = _March(System(osc, force), x0, v0, 0.0, 100_000)
    for count in range(1, 1000):
        status = engine_step(march, t_end, 300)
        if status != columns.SPENT:
            assert status == columns.REACHED_END
            return 300 * count
    pytest.fail("the run takes more than 300,000 searches")


def engine_step(march: _March, t_end: float, patience: int) -> int:
    from percuss.kernels.march import march as go

    return int(go(march.arrays, t_end, 100_000, patience))


def test_a_dead_fast_part_does_not_set_the_pace() -> None:
    """A stop of stiffness 1e8 and damping 1e6: 2e6 steps of its decay for each unit of time."""
    force = pc.cosine(2.1)
    run = pc.simulate(STIFF, force, 0.3, 0.3, t_end=1000.0)

    assert len(run.crossings) > 600
    assert searches(STIFF, force, 1000.0, 0.3, 0.3) < 100 * len(run.crossings)


@pytest.mark.parametrize("omega", [1e6, 1e8, 1e12])
@pytest.mark.parametrize("slow", [None, 2.0])
def test_a_fast_harmonic_of_no_reach_does_not_set_the_pace(
    omega: float, slow: float | None
) -> None:
    osc = pc.impact_oscillator(0.8)
    force = pc.cosine(omega) if slow is None else pc.cosine(omega) + pc.cosine(slow)

    assert searches(osc, force, 100.0, 0.3, 0.3) < 100_000


def test_the_motion_in_a_stiff_stop_is_that_of_its_closed_form() -> None:
    """Inside the stop x'' + 2e6 x' + (1e8 + 1) x = cos(2.1 t), and 1e-3 after the entry it creeps."""
    run = pc.simulate(STIFF, pc.cosine(2.1), 0.3, 0.3, t_end=20.0)
    inside = run.crossings.direction == "in"
    first = np.flatnonzero(inside)[0]
    enters, leaves = run.crossings.t[first], run.crossings.t[first + 1]

    # What is left are the slow one of both roots and the answer to the harmonic.
    root = -(1e8 + 1) / (1e6 + math.sqrt(1e12 - 1e8 - 1))
    assert leaves - enters > 0.1
    gain = 1.0 / complex(1e8 + 1 - 2.1**2, 2e6 * 2.1)

    def creep(t: float) -> float:
        steady = (gain * complex(math.cos(2.1 * t), math.sin(2.1 * t))).real
        begin = float(run(enters + 1e-3)[0])
        at = enters + 1e-3
        response = (gain * complex(math.cos(2.1 * at), math.sin(2.1 * at))).real
        return steady + (begin - response) * math.exp(root * (t - at))

    for part in (0.1, 0.5, 0.9):
        t = enters + part * (leaves - enters)
        assert float(run(t)[0]) == pytest.approx(creep(t), rel=1e-6, abs=1e-16)
