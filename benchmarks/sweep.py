"""W2: 600 impacts at each of 500 frequencies, x'' + x = cos(omega t) on x > 0, r = 0.8."""

from __future__ import annotations

import numpy as np

import percuss as pc
from benchmarks import references
from benchmarks.report import Report, installed
from benchmarks.timing import race

OSCILLATOR = pc.impact_oscillator(restitution="0.8")
FREQUENCIES = [float(omega) for omega in np.linspace(1.5, 5.0, 500)]
N = 600
CHECKED = FREQUENCIES[::125]
# Of every so many frequencies for a peer that would take minutes.
HEYOKA_STEP = 10


def run(report: Report) -> None:
    """Time the sweep through plain calls of `simulate`."""
    report.section(
        "W2: a bifurcation diagram's motions",
        "x'' + x = cos(omega t), wall at 0, r = 0.8, v0 = 1; 600 impacts at each of 500 "
        "frequencies, one call of `simulate` each. heyoka does every tenth frequency; where "
        "impacts accumulate it is set to rest below 1e-9 by its callback.",
    )
    for omega in CHECKED:
        force = pc.cosine(omega)
        t, _ = references.impacts(OSCILLATOR, force, (0, 1), 20, f"w2-{omega:.6f}")
        found = pc.simulate(OSCILLATOR, force, v0=1.0, max_impacts=20).impacts
        np.testing.assert_allclose(found.t, t, rtol=0, atol=1e-10)

    contenders = {"percuss": _sweep}
    if installed("heyoka"):
        from benchmarks.heyoka_peer import Impacts

        peer = Impacts()

        def heyoka() -> int:
            return sum(
                len(peer.run(N, omega, 0.0, 0.8, (0.0, 1.0))[0])
                for omega in FREQUENCIES[::HEYOKA_STEP]
            )

        contenders["heyoka"] = heyoka
    taken = race(contenders)
    each = taken["percuss"] / _sweep()
    report.line("percuss, whole sweep", f"{taken['percuss']:.3f} s")
    report.line("percuss, ns per impact", f"{each * 1e9:.0f} ns")
    if "heyoka" in taken:
        slow = taken["heyoka"] / contenders["heyoka"]()
        report.line("heyoka, ns per impact", f"{slow * 1e9:.0f} ns")
        report.ratio("heyoka : percuss", slow / each)


def _sweep() -> int:
    return sum(
        len(pc.simulate(OSCILLATOR, pc.cosine(omega), v0=1.0, max_impacts=N).impacts)
        for omega in FREQUENCIES
    )
