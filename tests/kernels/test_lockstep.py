"""BatchResult that fly in lockstep are the runs of `simulate`, bit for bit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import percuss as pc
from percuss.arrays import Floats
from percuss.ensembles.batch import BatchResult, Plan, follow_batch
from percuss.kernels import batch, lockstep, observables
from percuss.kernels import record as columns
from percuss.model.system import law

# Each as (oscillator, forcing, x0 of the starts).
CASES = {
    "elastic, chaotic": (pc.impact_oscillator(), pc.sine(3), 0.0),
    "elastic, growing": (pc.impact_oscillator(), pc.sine(2), 0.0),
    "chaos, grazes and chatter": (pc.impact_oscillator(restitution=0.8), pc.cosine(2.8), 0.0),
    "started away from the wall": (pc.impact_oscillator(restitution=0.8), pc.cosine(2.8), 0.7),
    "two attractors, wall above, damped": (
        pc.Oscillator(1.0, 0.05, (pc.Wall("1.45789", "above", "0.7"),)),
        pc.cosine(1.5),
        0.3,
    ),
    "chatter, contact and release": (
        pc.impact_oscillator(0.3),
        pc.cosine(2.7, constant=-0.8),
        0.0,
    ),
    "preload, wall away from 0": (
        pc.impact_oscillator(restitution=0.9, wall=-0.3),
        pc.cosine(2.1, constant=0.2),
        0.1,
    ),
    "flights of many steps": (
        pc.impact_oscillator(restitution=0.9, stiffness=0.01),
        pc.cosine(2.0),
        0.0,
    ),
    "no restitution": (pc.impact_oscillator(restitution=0.0), pc.cosine(2.8), 0.0),
    "a wall never met": (pc.impact_oscillator(0.7, wall=-9.0, damping=0.1), pc.cosine(1.5), 0.0),
}
# More than there are slots.
N = 3 * batch.BLOCKS * lockstep.SLOTS // 2
LAST = 9


def starts_of(x0: float, n: int = N) -> Floats:
    starts = np.zeros((n, 3))
    starts[:, 0] = x0
    starts[:, 1] = np.linspace(-2.0, 2.0, n)
    starts[:, 2] = np.linspace(0.0, 1.0, n)
    return starts


def followed(
    laws: Floats, which: NDArray[np.int64], starts: Floats, until: float, **options: object
) -> BatchResult:
    n = len(which)
    plan = Plan(np.full(n, 2.0), np.full(n, 1.5), np.full(n, until), **options)  # type: ignore[arg-type]
    return follow_batch(laws, which, starts, plan)


def assert_same(first: BatchResult, second: BatchResult) -> None:
    for name in ("status", "state", "n_impacts", "values", "points"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)


@pytest.mark.parametrize("name", CASES)
def test_impacts_have_the_bits_that_simulate_gives_them(name: str) -> None:
    osc, force, x0 = CASES[name]
    starts = starts_of(x0)

    motions = followed(
        law(osc, force)[np.newaxis],
        np.zeros(N, dtype=np.int64),
        starts,
        25.0,
        section=observables.IMPACT_POINTS,
        n_points=LAST,
    )

    for i in range(0, N, 7):
        run = pc.simulate(osc, force, *starts[i], t_end=25.0)
        assert motions.n_impacts[i] == len(run.impacts)
        late = run.impacts.t >= 2.0
        kept = motions.points[i, : min(LAST, int(late.sum()))]
        n = len(kept)
        speeds, cycles = run.impacts.v_after[late], run.impacts.cycle[late]
        np.testing.assert_array_equal(kept[:, observables.SECOND], speeds[len(speeds) - n :])
        np.testing.assert_array_equal(kept[:, observables.FIRST], cycles[len(cycles) - n :])
        peak = np.abs(run.impacts.v_before[late]).max(initial=0.0)
        assert motions.values[i, observables.PEAK_SPEED] == peak


@pytest.mark.parametrize(
    "section", [observables.STROBES, observables.IMPACT_POINTS, observables.TANGENTS]
)
@pytest.mark.parametrize("with_extremes", [False, True])
def test_a_motion_does_not_know_its_neighbours(section: int, with_extremes: bool) -> None:
    """All laws together, in any order, in chunks, and one by one, where no motion has a slot."""
    laws = np.stack([law(osc, force) for osc, force, _ in CASES.values()])
    n = 4 * lockstep.SLOTS
    which = np.arange(n) % len(laws)
    starts = starts_of(0.0, n)
    starts[:, 0] = np.array([x0 for _, _, x0 in CASES.values()])[which]
    options = {"section": section, "n_points": 5, "with_extremes": with_extremes}
    together = followed(laws, which, starts, 12.0, **options)

    for size in (1, 4, 11, n - 1):
        for first in range(0, n, max(size, n // 3)):
            chunk = slice(first, first + size)
            alone = followed(laws, which[chunk], starts[chunk], 12.0, **options)
            expected = BatchResult(
                together.status[chunk],
                together.state[chunk],
                together.n_impacts[chunk],
                together.values[chunk],
                together.points[chunk],
            )
            assert_same(alone, expected)
    turned = followed(laws, which[::-1].copy(), starts[::-1].copy(), 12.0, **options)
    np.testing.assert_array_equal(turned.values[::-1], together.values)
    np.testing.assert_array_equal(turned.points[::-1], together.points)


def test_motions_end_at_their_own_times_and_limits() -> None:
    osc, force, _ = CASES["chaos, grazes and chatter"]
    n = 50
    laws, which, starts = (
        law(osc, force)[np.newaxis],
        np.zeros(n, dtype=np.int64),
        starts_of(0.0, n),
    )
    ends = np.linspace(1.5, 60.0, n)
    plan = Plan(np.zeros(n), np.ones(n), ends, max_impacts=20)

    motions = follow_batch(laws, which, starts, plan)

    for i in range(n):
        run = pc.simulate(osc, force, *starts[i], t_end=ends[i], max_impacts=20)
        assert motions.n_impacts[i] == len(run.impacts)
        limited = run.outcome == pc.Outcome.reached_max_impacts
        assert (motions.status[i] == columns.REACHED_LIMIT) == limited
        if len(run.impacts):
            assert motions.state[i, columns.V] == run.impacts.v_after[-1] or len(run.contacts)
    assert {columns.REACHED_END, columns.REACHED_LIMIT} <= set(motions.status)


def test_one_that_chatters_without_end_does_not_stop_the_others() -> None:
    """Elastic hops under a force that presses: no contact ends them, only the limit."""
    hopping = law(pc.impact_oscillator(), pc.cosine(0.01, amplitude=0.0, constant=-1.0))
    harmonic = law(*CASES["elastic, chaotic"][:2])
    n = 40
    which = np.arange(n) % 2
    starts = np.tile([0.0, 1e-6, 0.0], (n, 1))
    starts[which == 1, 1] = 0.45
    plan = Plan(np.zeros(n), np.ones(n), np.full(n, math.inf), max_impacts=2_000)

    motions = follow_batch(np.stack([hopping, harmonic]), which, starts, plan)

    assert set(motions.status) == {columns.REACHED_LIMIT}
    assert set(motions.n_impacts) == {2_000}
    run = pc.simulate(*CASES["elastic, chaotic"][:2], v0=0.45, max_impacts=2_000)
    assert motions.state[1, columns.T] == run.impacts.t[-1]


def test_a_block_is_as_wide_as_its_vectors() -> None:
    assert lockstep.SLOTS % 8 == 0
    assert lockstep.OTHER == lockstep.WALK_RATE - lockstep.MODE + 1
    rows = [
        *range(lockstep.MOTION, lockstep.BOUNDS + 8),
        lockstep.PULL_COS,
        lockstep.PULL_SIN,
        lockstep.PULL,
        lockstep.RESTITUTION,
        lockstep.SIGN,
        lockstep.T_END,
        *range(lockstep.AT, lockstep.RATE + 1),
        *range(lockstep.FOURTH, lockstep.SLACK + 1),
        *range(lockstep.MODE, lockstep.WALK_RATE + 1 + lockstep.OTHER),
        *range(lockstep.S, lockstep.ROWS),
    ]
    assert sorted(rows) == list(range(lockstep.ROWS))
