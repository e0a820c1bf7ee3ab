"""W2: 600 impacts at each of 500 frequencies, x'' + x = cos(omega t) on x > 0, r = 0.8."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import percuss as pc
from benchmarks import references, second_core
from benchmarks.report import Report, installed
from benchmarks.timing import race
from percuss.ensembles.batch import BatchResult, Plan, follow_batch
from percuss.kernels.observables import IMPACT_POINTS, SECOND
from percuss.model.system import law

OSCILLATOR = pc.impact_oscillator(restitution="0.8")
FREQUENCIES = [float(omega) for omega in np.linspace(1.5, 5.0, 500)]
N = 600
# Impacts of each motion that a diagram shows.
SHOWN = 100
LAWS = np.stack([law(OSCILLATOR, pc.cosine(omega)) for omega in FREQUENCIES])
CHECKED = FREQUENCIES[::125]
# Of every so many frequencies for a peer that would take minutes.
HEYOKA_STEP = 10


def run(report: Report) -> None:
    """Time the sweep through the batch kernel."""
    report.section(
        "W2: a bifurcation diagram's motions",
        "x'' + x = cos(omega t), wall at 0, r = 0.8, v0 = 1; 600 impacts at each of 500 "
        "frequencies in one call of the batch kernel, of which the last 100 are kept. The laws "
        "are made beforehand, which takes longer; a line of its own. heyoka does every tenth "
        "frequency, one by one and in its batch mode, 16 at a time with a callback for each; where "
        "impacts accumulate it is set to rest below 1e-9 by its callback.",
    )
    followed = follow()
    assert (followed.n_impacts == N).all()
    for omega in CHECKED:
        force = pc.cosine(omega)
        t, _ = references.impacts(OSCILLATOR, force, (0, 1), 20, f"w2-{omega:.6f}")
        found = pc.simulate(OSCILLATOR, force, v0=1.0, max_impacts=20).impacts
        np.testing.assert_allclose(found.t, t, rtol=0, atol=1e-10)
        # Room for a thousand: a buffer that is nearly full takes another way to the same impact.
        run = pc.simulate(OSCILLATOR, force, v0=1.0, max_impacts=N + 400).impacts
        kept = followed.points[FREQUENCIES.index(omega), :, SECOND]
        np.testing.assert_array_equal(kept, run.v_after[N - SHOWN : N])

    contenders: dict[str, Callable[[], object]] = {
        "percuss": follow,
        "laws": _laws,
        "simulate": _runs,
    }
    if installed("heyoka"):
        from benchmarks.heyoka_peer import BatchImpacts, Impacts

        peer, batch = Impacts(), BatchImpacts()
        motions = [(omega, 0.0, 1.0) for omega in FREQUENCIES[::HEYOKA_STEP]]
        for (omega, _, _), (times, _) in zip(motions, batch.run(motions, 0.8, N), strict=True):
            own = pc.simulate(OSCILLATOR, pc.cosine(omega), v0=1.0, max_impacts=8).impacts
            # Later, chaos makes more of the rounding.
            np.testing.assert_allclose(times[:8], own.t, rtol=0, atol=1e-10)
            assert len(times) == N

        def heyoka() -> int:
            return sum(
                len(peer.run(N, omega, 0.0, 0.8, (0.0, 1.0))[0])
                for omega in FREQUENCIES[::HEYOKA_STEP]
            )

        contenders["heyoka"] = heyoka
        contenders["batch"] = lambda: batch.run(motions, 0.8, N)
    taken = race(contenders)
    each = taken["percuss"] / int(followed.n_impacts.sum())
    report.below("percuss, whole sweep", taken["percuss"], 0.05, "s")
    report.line("percuss, ns per impact", f"{each * 1e9:.0f} ns")
    report.line("percuss, the laws of 500 new oscillators", f"{taken['laws']:.3f} s")
    report.ratio("one call of simulate each : percuss", taken["simulate"] / taken["percuss"])
    if "heyoka" in taken:
        slow = taken["heyoka"] / heyoka()
        report.line("heyoka, ns per impact", f"{slow * 1e9:.0f} ns")
        report.ratio("heyoka : percuss", slow / each, 30)
        slow = taken["batch"] / (N * len(FREQUENCIES[::HEYOKA_STEP]))
        report.line("heyoka in batches, ns per impact", f"{slow * 1e9:.0f} ns")
        report.ratio("heyoka in batches : percuss", slow / each, 15)
    second_core.run(report, second_core.MotionsJob(LAWS, *_arguments()))


def follow() -> BatchResult:
    return follow_batch(LAWS, *_arguments())


def _arguments() -> tuple[NDArray[np.int64], NDArray[np.float64], Plan]:
    n = len(FREQUENCIES)
    still = np.zeros(n)
    plan = Plan(still, still + 1.0, still + math.inf, IMPACT_POINTS, SHOWN, max_impacts=N)
    return np.arange(n), np.tile([0.0, 1.0, 0.0], (n, 1)), plan


def _laws() -> int:
    law.cache_clear()
    return len([law(OSCILLATOR, pc.cosine(omega)) for omega in FREQUENCIES])


def _runs() -> int:
    return sum(
        len(pc.simulate(OSCILLATOR, pc.cosine(omega), v0=1.0, max_impacts=N).impacts)
        for omega in FREQUENCIES
    )
