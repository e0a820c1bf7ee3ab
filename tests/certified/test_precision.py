from __future__ import annotations

import math
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from tests.certified.motions import ELASTIC, chaotic

import percuss as pc
from percuss.certified import CertifiedRun


def test_balls_of_few_bits_overlap_and_hold_those_of_many() -> None:
    run = chaotic(40)
    fine = pc.certify(run, bits=512)

    for bits in (53, 128, 256):
        coarse = pc.certify(run, bits=bits)
        n = len(coarse.impacts)
        assert n >= 15 if bits == 53 else n == 40
        for name in ("t", "v_before", "v_after"):
            ours = getattr(coarse.impacts, name).arbs
            theirs = getattr(fine.impacts, name).arbs
            assert all(a.contains(b.mid()) for a, b in zip(ours, theirs, strict=False))
            # They are no wider than they need be.
            assert all(a.rad() > b.rad() for a, b in zip(ours, theirs, strict=False))


def test_float_runs_lie_within_their_rounding_of_the_balls() -> None:
    run = pc.simulate(pc.impact_oscillator("0.9", wall=0.2, damping="0.05"), pc.cosine("1.3"),
                      x0=0.5, t_end=60.0)  # fmt: skip
    proven = pc.certify(run)

    assert len(proven.impacts) == len(run.impacts) > 5
    np.testing.assert_allclose(run.impacts.t, proven.impacts.t.mid(), rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.impacts.v_before, proven.impacts.v_before.mid(), atol=1e-12)
    np.testing.assert_allclose(run.impacts.cycle, proven.impacts.cycle.mid(), atol=1e-12)
    np.testing.assert_allclose(run.impacts.intervals, proven.impacts.intervals.mid(), atol=1e-12)
    times = np.linspace(0.0, 60.0, 50).reshape(5, 10)
    for ours, theirs in zip(run(times), proven(times), strict=True):
        assert theirs.mid().shape == (5, 10)
        np.testing.assert_allclose(ours, theirs.mid(), rtol=0, atol=1e-12)
        assert theirs.radius().max() < 1e-12


def test_bits_are_spent_as_the_exponent_demands() -> None:
    n = 200
    run = chaotic(n)

    proven = pc.certify(run, bits=400)

    # log2 of how neighbours part over all impacts, from the exact motion's own derivatives.
    demanded = _growth_in_bits(proven)
    assert demanded / n > 0.3
    assert proven.bits_per_impact < 1.25 * demanded / n + 0.1 + 2 * math.log2(n) / n


def _growth_in_bits(proven: CertifiedRun) -> float:
    """Return log2 of the norm of the product of the impact map's derivatives, in floats."""
    omega, r = 2.8, 0.8
    times = [0.0, *proven.impacts.t.mid()]
    speeds = [-1.0, *proven.impacts.v_after.mid()]
    product, logarithm = np.eye(2), 0.0
    for i in range(len(times) - 1):
        s, v0 = times[i + 1] - times[i], speeds[i]
        a0, a1 = math.cos(omega * times[i]), math.cos(omega * times[i + 1])
        v1 = proven.impacts.v_before.mid()[i]
        c, d = math.cos(s), math.sin(s)
        x_by = np.array([-(c * v0 + d * a0), d])
        v_by = np.array([d * v0 - c * a0, c])
        t_by = -x_by / v1
        product = np.array([t_by, -r * (v_by + a1 * t_by)]) @ product
        size = float(np.abs(product).max())
        product, logarithm = product / size, logarithm + math.log2(size)
    return logarithm


def test_an_elastic_motion_of_a_thousand_impacts_takes_less_than_a_second() -> None:
    run = pc.simulate(ELASTIC, pc.sine(3), v0="0.45", max_impacts=1000)
    start = time.process_time()

    proven = pc.certify(run)

    assert time.process_time() - start < 1.0
    assert len(proven.impacts) == 1000
    assert proven.impacts.t.digits().min() >= 12
    # Neighbours part no faster than in proportion to the number of impacts squared.
    assert proven.bits_per_impact < 0.1


def test_a_chaotic_motion_of_two_hundred_impacts_takes_less_than_two_seconds() -> None:
    run = chaotic(200)
    start = time.process_time()

    proven = pc.certify(run)

    assert time.process_time() - start < 2.0
    assert len(proven.impacts) == 200
    assert proven.impacts.t.digits().min() >= 12


def test_too_few_bits_end_early_and_stay_right() -> None:
    run = chaotic(200)

    proven = pc.certify(run, bits=64)

    assert not proven.complete
    assert 20 < len(proven.impacts) < 200
    whole = pc.certify(run)
    assert all(a.overlaps(b) for a, b in zip(proven.impacts.t, whole.impacts.t, strict=False))


def test_threads_do_not_disturb_one_another() -> None:
    alone = [pc.certify(chaotic(n), digits=d).impacts.t[n - 1] for n, d in ((20, 8), (60, 40))]

    with ThreadPoolExecutor(4) as pool:
        jobs = [(20, 8), (60, 40)] * 4
        together = list(pool.map(lambda job: pc.certify(chaotic(job[0]), digits=job[1]), jobs))

    for run, ball in zip(together, alone * 4, strict=True):
        assert run.impacts.t.arbs[-1].rad() == ball.arb.rad()


def test_the_most_bits_are_kept_to_and_digits_that_miss_are_told() -> None:
    proven = pc.certify(chaotic(60), digits=20, most_bits=90)

    assert proven.precision == 90
    assert proven.complete
    assert proven.impacts.t.digits().min() < 20
    assert "fewer digits than asked for, with 90 bits" in repr(proven)
    assert pc.certify(chaotic(60), digits=20).reason == ""
