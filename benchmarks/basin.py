"""W4: 200 forcing periods from each of 200 x 200 starts, x'' + x = cos 2.8 t, r = 0.8."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from tests.oracle.event_driven import simulate
from tests.oracle.from_model import problem_of

import percuss as pc
from benchmarks import second_core
from benchmarks.report import Report, installed
from benchmarks.timing import race
from percuss.ensembles.batch import BatchResult, Plan, follow_batch
from percuss.kernels.observables import END_V, END_X
from percuss.model.system import law

OSCILLATOR, FORCE = pc.impact_oscillator(restitution=0.8), pc.cosine(2.8)
T_END = 200 * 2 * math.pi / 2.8
STARTS = [(float(x), float(v)) for x in np.linspace(0, 3, 201)[1:] for v in np.linspace(-3, 3, 200)]
SOME = [STARTS[i] for i in np.random.default_rng(0).choice(len(STARTS), 1000, replace=False)]
FEW, ONE = SOME[:50], SOME[:1]


def run(report: Report) -> None:
    """Time the basin's motions through the batch kernel."""
    report.section(
        "W4: a basin's motions",
        "x'' + x = cos 2.8 t, wall at 0, r = 0.8; 200 forcing periods from each of 200 x 200 "
        "starts in [0, 3] x [-3, 3], in one call of the batch kernel, on one core; heyoka does "
        "50 of them, one by one and in its batch mode, 16 at a time; SciPy one.",
    )
    _check_answers()
    counts: dict[str, int] = {}
    contenders: dict[str, Callable[[], object]] = {
        "percuss": lambda: counts.update(percuss=int(follow(STARTS).n_impacts.sum())),
        "simulate": lambda: counts.update(simulate=_impacts_of(FEW)),
    }
    if installed("heyoka"):
        from benchmarks.heyoka_peer import BatchImpacts, Impacts

        peer, batch = Impacts(), BatchImpacts()
        motions = [(2.8, *start) for start in FEW]
        for start, (t, _) in zip(FEW, batch.run(motions, 0.8, t_end=T_END), strict=True):
            own = pc.simulate(OSCILLATOR, FORCE, *start, max_impacts=8).impacts
            # Later, chaos makes more of the rounding.
            np.testing.assert_allclose(t[:8], own.t, rtol=0, atol=1e-10)
        contenders["heyoka in batches"] = lambda: counts.update(
            batch=sum(len(t) for t, _ in batch.run(motions, 0.8, t_end=T_END))
        )
        contenders["heyoka"] = lambda: counts.update(
            heyoka=sum(len(peer.run(10**6, 2.8, 0.0, 0.8, s, T_END)[0]) for s in FEW)
        )
    if installed("scipy"):
        from benchmarks import scipy_peer

        contenders["SciPy"] = lambda: counts.update(
            SciPy=sum(len(scipy_peer.impacts(10**4, 2.8, 0.0, 0.8, s, T_END)[0]) for s in ONE)
        )
    taken = race(contenders)
    followed = {"percuss": len(STARTS), "SciPy": len(ONE)}
    each = {name: taken[name] / followed.get(name, len(FEW)) for name in taken}
    report.below("percuss, whole basin", taken["percuss"], 1.2, "s")
    per_impact = taken["percuss"] / counts["percuss"]
    report.line("percuss, ns per impact", f"{per_impact * 1e9:.0f} ns")
    if "heyoka" in taken:
        # Chaotic motions differ, but not in how often they strike in all.
        np.testing.assert_allclose(counts["batch"], counts["heyoka"], rtol=0.02)
    targets = {"heyoka": 30.0, "heyoka in batches": 15.0}
    for name in ("simulate", "heyoka", "heyoka in batches", "SciPy"):
        if name in taken:
            report.line(f"{name}, a motion of 200 periods", f"{each[name] * 1e3:.3g} ms")
            report.ratio(f"{name} : percuss", each[name] / each["percuss"], targets.get(name))
    second_core.run(report, second_core.MotionsJob(*_arguments(STARTS)))


def _check_answers() -> None:
    """Assert motions against an independent march, and the batch against `simulate`."""
    for start in SOME[:5]:
        expected = simulate(problem_of(OSCILLATOR, FORCE), *start, max_impacts=8)
        found = pc.simulate(OSCILLATOR, FORCE, *start, max_impacts=8).impacts
        # Chaos multiplies the first rounding by less than a thousand in eight impacts.
        np.testing.assert_allclose(found.t, [float(t) for t in expected.impacts.t], atol=1e-11)

    followed_together = follow(SOME[:50])
    for k, start in enumerate(SOME[:50]):
        motion = pc.simulate(OSCILLATOR, FORCE, *start, t_end=T_END)
        assert len(motion.impacts) == followed_together.n_impacts[k]
        # The same impacts, bit for bit; the motion after the last is summed in another order.
        np.testing.assert_allclose(
            followed_together.values[k, [END_X, END_V]],
            [float(part) for part in motion(T_END)],
            atol=1e-12,
        )


def follow(starts: list[tuple[float, float]]) -> BatchResult:
    return follow_batch(*_arguments(starts))


def _arguments(
    starts: list[tuple[float, float]],
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], Plan]:
    n = len(starts)
    end = np.full(n, T_END)
    begin = np.column_stack([np.array(starts), np.zeros(n)])
    which = np.zeros(n, dtype=np.int64)
    return law(OSCILLATOR, FORCE)[np.newaxis], which, begin, Plan(end, end, end)


def _impacts_of(starts: list[tuple[float, float]]) -> int:
    return sum(len(pc.simulate(OSCILLATOR, FORCE, *start, t_end=T_END).impacts) for start in starts)
