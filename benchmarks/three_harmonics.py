"""Three harmonics, damping, a wall and a soft stop: the general law."""

from __future__ import annotations

import numpy as np
from tests.oracle.event_driven import simulate
from tests.oracle.from_model import problem_of

import percuss as pc
from benchmarks.report import Report, installed
from benchmarks.timing import race

OSCILLATOR = pc.Oscillator(
    damping=0.02,
    stops=(
        pc.Wall(at=0.0, side="below", restitution=0.9),
        pc.SoftStop(at=1.0, side="above", stiffness=8.0, damping=0.05),
    ),
)
FORCE = pc.fourier(2.0, cos=(1.0, 0.3, 0.1), sin=(0.2, 0.0, 0.15))
# Impacts and entries into the soft stop, which come in turn.
N = 200_000
# Of the comparison.
T = 2000.0


def run(report: Report) -> None:
    """Time 100,000 impacts; crossings of the soft stop come on top."""
    report.section(
        "Three harmonics, damping and a soft stop",
        "x'' + 0.04 x' + x = three harmonics; wall at 0, r = 0.9; soft stop at 1 with k_s = 8 "
        "and damping.",
    )
    # Two impacts more than percuss lists, to hold all of its crossings.
    expected = simulate(problem_of(OSCILLATOR, FORCE), 0.5, 0.0, max_impacts=22)
    found = _motion(40)
    for table in ("impacts", "crossings"):
        times = getattr(found, table).t
        exact = [float(t) for t in getattr(expected, table).t]
        assert len(exact) >= len(times) >= 19
        np.testing.assert_allclose(times, exact[: len(times)], rtol=0, atol=1e-11)

    motion = _motion(N)
    taken = race({"percuss": lambda: _motion(N)})["percuss"]
    impacts, crossings = len(motion.impacts), len(motion.crossings)
    report.below("percuss, ns per impact (aim)", taken / impacts * 1e9, 200, "ns")
    report.line("crossings per impact", f"{crossings / impacts:.2f}")
    each = taken / (impacts + crossings)
    report.below("percuss, ns per impact or crossing (aim)", each * 1e9, 150, "ns")
    if installed("heyoka"):
        _compare(report)


def _compare(report: Report) -> None:
    from benchmarks.heyoka_peer import ThreeHarmonics

    peer = ThreeHarmonics()
    impacts, crossings = peer.run(T)
    own = pc.simulate(OSCILLATOR, FORCE, x0=0.5, t_end=T)
    # Rounding grows: the beginning tells whether both follow the same motion.
    np.testing.assert_allclose(impacts[:20], own.impacts.t[:20], rtol=0, atol=1e-11)
    contenders = {
        "heyoka": lambda: peer.run(T),
        "percuss": lambda: pc.simulate(OSCILLATOR, FORCE, x0=0.5, t_end=T),
    }
    taken = race(contenders)
    each = {
        "heyoka": taken["heyoka"] / (len(impacts) + len(crossings)),
        "percuss": taken["percuss"] / (len(own.impacts) + len(own.crossings)),
    }
    report.line("heyoka, ns per impact or crossing", f"{each['heyoka'] * 1e9:.0f} ns")
    report.ratio("heyoka : percuss", each["heyoka"] / each["percuss"], 35.0)


def _motion(n: int) -> pc.Trajectory:
    return pc.simulate(OSCILLATOR, FORCE, x0=0.5, max_impacts=n)
