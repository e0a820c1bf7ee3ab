"""Many motions in one call are the runs of `simulate`, whatever motions are called together."""

from __future__ import annotations

import itertools
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

import percuss as pc
from percuss.ensembles.batch import BatchResult, Plan, follow_batch
from percuss.kernels import observables
from percuss.kernels import record as columns
from percuss.model.system import law

PERIOD = 2.0 * math.pi / 2.8
CHAOS = (pc.impact_oscillator(restitution=0.8), pc.cosine(2.8))
STARTS = np.array([(0.0, 1.0, 0.0), (0.7, -2.0, 0.0), (2.9, 0.3, 0.0), (0.01, 0.0, 0.3)])

CASES: dict[str, tuple[pc.Oscillator, pc.Forcing, tuple[float, float]]] = {
    "one wall": (*CHAOS, (0.0, 1.0)),
    "one wall, started away from it": (*CHAOS, (0.9, -0.2)),
    "chatter, contact and release": (
        pc.impact_oscillator(0.3),
        pc.cosine(2.7, constant=-0.8),
        (0.0, 1.0),
    ),
    "two walls and two soft stops": (
        pc.Oscillator(
            1.0,
            0.02,
            (
                pc.Wall(-1.0, "below", 0.7),
                pc.Wall(1.0, "above", 0.9),
                pc.SoftStop(0.5, "above", 29.0, 0.3),
                pc.SoftStop(-0.5, "below", 5.0),
            ),
        ),
        pc.fourier(2.0, cos=(1.0, 0.2), sin=(0.3, 0.1), constant=0.1),
        (0.1, 2.0),
    ),
    "overdamped": (pc.impact_oscillator(0.5, damping=3.0), pc.sine(1.0), (0.0, 1.0)),
    "no stop at all": (pc.Oscillator(1.0, 0.1), pc.cosine(2.0), (0.3, 0.0)),
    "a landing at zero speed": (pc.impact_oscillator(), pc.sine(3), (0.0, 0.0)),
    "held for ever": (pc.impact_oscillator(0.3), pc.cosine(2.0, constant=-2.0), (0.2, 0.0)),
}


def follow(
    osc: pc.Oscillator,
    force: pc.Forcing,
    starts: NDArray[np.float64],
    until: float,
    since: float = 0.0,
    **keywords: object,
) -> BatchResult:
    n = len(starts)
    plan = Plan(
        np.full(n, since),
        np.full(n, float(force.period or 1.0)),
        np.full(n, until),
        **keywords,  # type: ignore[arg-type]
    )
    return follow_batch(law(osc, force)[np.newaxis], np.zeros(n, dtype=np.int64), starts, plan)


@pytest.mark.parametrize("name", CASES)
def test_a_member_of_a_batch_is_the_run_of_simulate(name: str) -> None:
    osc, force, (x0, v0) = CASES[name]
    run = pc.simulate(osc, force, x0, v0, t_end=30.0)

    motions = follow(osc, force, np.array([[x0, v0, 0.0]]), 30.0)

    entries = int((run.crossings.direction == "in").sum())
    at_rest = int((run._marks[:, columns.KIND] == columns.SLOW_LANDING).sum())
    assert motions.n_impacts[0] == len(run.impacts) + entries + at_rest
    x, v = run(30.0, "before")
    ends = motions.values[0, [observables.END_X, observables.END_V]]
    # The trajectory sums the terms of a fast formula in another order.
    np.testing.assert_allclose(ends, [x, v], rtol=0, atol=1e-12)
    if len(run.impacts):
        assert motions.values[0, observables.PEAK_SPEED] >= np.abs(run.impacts.v_before).max()


def test_every_impact_has_the_bits_that_simulate_gives_it() -> None:
    run = pc.simulate(*CHAOS, v0=1.0, t_end=200.0)
    n = len(run.impacts)

    motions = follow(*CHAOS, STARTS[:1], 200.0, section=observables.IMPACT_POINTS, n_points=n)

    assert n > 80
    np.testing.assert_array_equal(motions.points[0, :, observables.FIRST], run.impacts.cycle)
    np.testing.assert_array_equal(motions.points[0, :, observables.SECOND], run.impacts.v_after)


def test_of_many_points_the_last_are_kept_in_their_order() -> None:
    run = pc.simulate(*CHAOS, v0=1.0, t_end=200.0)

    motions = follow(*CHAOS, STARTS[:1], 200.0, section=observables.IMPACT_POINTS, n_points=7)

    np.testing.assert_array_equal(
        motions.points[0, :, observables.SECOND], run.impacts.v_after[-7:]
    )


@pytest.mark.parametrize("name", CASES)
def test_strobes_are_those_of_the_run(name: str) -> None:
    osc, force, (x0, v0) = CASES[name]
    period = float(force.period or math.nan)
    run = pc.simulate(osc, force, x0, v0, t_end=12.1 * period)

    motions = follow(
        osc,
        force,
        np.array([[x0, v0, 0.0]]),
        12.0 * period,
        since=4.0 * period,
        section=observables.STROBES,
        n_points=9,
    )

    x, v = run(4.0 * period + np.arange(9) * period)
    np.testing.assert_allclose(motions.points[0, :, observables.FIRST], x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motions.points[0, :, observables.SECOND], v, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_extremes_are_those_of_a_fine_sample(name: str) -> None:
    osc, force, (x0, v0) = CASES[name]
    run = pc.simulate(osc, force, x0, v0, t_end=20.0)
    hits = run.impacts.t[run.impacts.t >= 5.0]
    x, _ = run(np.sort(np.concatenate([np.linspace(5.0, 20.0, 200_001), hits])))

    motions = follow(osc, force, np.array([[x0, v0, 0.0]]), 20.0, since=5.0, with_extremes=True)

    low, high = motions.values[0, [observables.LOWEST, observables.HIGHEST]]
    if motions.status[0] == columns.AT_REST:
        assert (low, high) == (math.inf, -math.inf)
        return
    # A sample misses a turning point by less than x'' dt^2 / 8.
    assert low <= x.min() + 1e-13
    assert high >= x.max() - 1e-13
    np.testing.assert_allclose([low, high], [x.min(), x.max()], rtol=0, atol=1e-7)


def test_the_energy_that_is_lost_is_the_work_of_the_force() -> None:
    """In a round of a periodic motion, by the balance of energy."""
    osc, force = pc.impact_oscillator(restitution=0.7, damping=0.1), pc.cosine(2.2)
    period = float(force.period or math.nan)
    start = np.array([[0.0, 1.0, 0.0]])

    motions = follow(osc, force, start, 401 * period, since=400 * period, with_work=True)

    run = pc.simulate(osc, force, v0=1.0, t_end=401.5 * period)
    cuts = run.impacts.t[(run.impacts.t > 400 * period) & (run.impacts.t < 401 * period)]
    edges = np.concatenate([[400 * period], cuts, [401 * period]])
    nodes, weights = np.polynomial.legendre.leggauss(40)
    work = 0.0
    for low, high in itertools.pairwise(edges):
        t = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        work += 0.5 * (high - low) * float(weights @ (np.cos(2.2 * t) * run(t)[1]))
    lost = motions.values[0, observables.LOST] + motions.values[0, observables.DRAGGED]
    assert motions.values[0, observables.DRAGGED] > 0.01 * lost
    # The motion has come to its round up to 1e-11.
    assert lost == pytest.approx(work, abs=1e-9)


def test_a_member_of_a_batch_has_the_same_bits_alone_and_among_others() -> None:
    together = follow(
        *CHAOS, STARTS, 500.0, section=observables.STROBES, n_points=50, with_extremes=True
    )

    for i in range(len(STARTS)):
        alone = follow(
            *CHAOS,
            STARTS[i : i + 1],
            500.0,
            section=observables.STROBES,
            n_points=50,
            with_extremes=True,
        )
        np.testing.assert_array_equal(alone.values[0], together.values[i])
        np.testing.assert_array_equal(alone.points[0], together.points[i])


def test_a_flight_of_a_million_steps_does_not_hold_up_the_others() -> None:
    """A force of very high frequency: `simulate` looks at the slow part alone, and so does this."""
    osc = pc.impact_oscillator(wall=-1.0)
    force = pc.Forcing((pc.Harmonic(1e-3, 1e7), pc.Harmonic(1e-4, 1.5)), period=pc.pi_times(4))
    start = np.array([[0.0, 0.1, 0.0]])

    motions = follow(osc, force, start, 50.0)

    assert motions.status[0] == columns.REACHED_END
    run = pc.simulate(osc, force, 0.0, 0.1, t_end=50.0)
    x, v = run(50.0)
    np.testing.assert_allclose(
        motions.values[0, [observables.END_X, observables.END_V]], [x, v], rtol=0, atol=1e-10
    )


@pytest.mark.parametrize("start", [(0.5, 1.0), (0.0, 1e160), (0.0, 1e140)])
def test_growth_beyond_all_bounds_is_told_as_simulate_tells_it(start: tuple[float, float]) -> None:
    osc = pc.Oscillator(1.0, 0.0, (pc.Wall(0.0, "below"),))
    run = pc.simulate(osc, pc.cosine(2.0), *start, t_end=20.0)

    motions = follow(osc, pc.cosine(2.0), np.array([[*start, 0.0]]), 20.0)

    overflow = motions.status[0] == columns.OVERFLOW
    assert overflow == (run.outcome == pc.Outcome.overflow) == (start[1] == 1e160)


@pytest.mark.parametrize("t_end", [340.0, 400.0, 1e4])
def test_growth_without_an_event_is_told_as_simulate_tells_it(t_end: float) -> None:
    osc = pc.Oscillator(-1.0, 0.0, (pc.Wall(-1.0, "below"),))
    run = pc.simulate(osc, pc.cosine(2.0), 1.0, 0.0, t_end=t_end)

    motions = follow(osc, pc.cosine(2.0), np.array([[1.0, 0.0, 0.0]]), t_end)

    overflow = motions.status[0] == columns.OVERFLOW
    assert overflow == (run.outcome == pc.Outcome.overflow) == (t_end > 346.0)


def test_a_limit_of_impacts_ends_a_motion() -> None:
    motions = follow(*CHAOS, STARTS, math.inf, max_impacts=300)

    assert set(motions.status) == {columns.REACHED_LIMIT}
    assert set(motions.n_impacts) == {300}


WITHOUT_COMPILER = """
import json
import numpy as np
import percuss as pc
from percuss.ensembles.batch import Plan, follow_batch
from percuss.kernels import batch, observables
from percuss.model.system import law

soft = (pc.SoftStop(0.5, "above", 29.0, 0.3), pc.Wall(-1.0, "below", 0.7))
answers = []
for osc, force in (
    (pc.impact_oscillator(restitution=0.8), pc.cosine(2.8)),
    (pc.impact_oscillator(0.3), pc.cosine(2.7, constant=-0.8)),
    (pc.Oscillator(1.0, 0.02, soft), pc.fourier(2.0, cos=(1.0, 0.2))),
    (pc.impact_oscillator(0.0), pc.cosine(2.8)),
):
    period = force.period
    for section in (observables.STROBES, observables.IMPACT_POINTS, observables.TANGENTS):
        unit = np.ones(1)
        plan = Plan(period * unit, period * unit, 5 * period * unit, section, 5, with_extremes=True)
        laws = law(osc, force)[np.newaxis]
        motions = follow_batch(laws, np.zeros(1, dtype=np.int64), np.array([[0.0, 1.0, 0.0]]), plan)
        numbers = [*motions.values[0], *motions.points[0].ravel(), *motions.state[0]]
        answers.append([number if np.isfinite(number) else str(number) for number in numbers])
print(json.dumps([answers, len(getattr(batch.run_batch, "signatures", [0]))]))
"""


def test_batches_come_out_the_same_without_the_compiler_and_are_compiled_once() -> None:
    answers = []
    for disabled in "10":
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT_COMPILER],
            env={**os.environ, "NUMBA_DISABLE_JIT": disabled},
            capture_output=True,
            text=True,
            check=True,
        )
        answer, signatures = json.loads(done.stdout)
        assert signatures == 1
        answers.append(answer)

    for plain, compiled in zip(*answers, strict=True):
        for first, second in zip(plain, compiled, strict=True):
            if isinstance(first, str) or isinstance(second, str):
                assert first == second
            else:
                # libm's functions need not be rounded alike.
                assert first == pytest.approx(second, rel=1e-11, abs=1e-12)
