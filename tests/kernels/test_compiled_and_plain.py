from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np

# Chatter, contact and release; two walls and soft stops; overdamped; unstable; several harmonics;
# a landing at zero speed, a release at a flat zero, and a stiff stop whose fast part is dead.
RUNS = """
import json
import percuss as pc

def events(run):
    return {
        "impacts": [list(run.impacts.t), list(run.impacts.v_before)],
        "crossings": [list(run.crossings.t), list(run.crossings.v)],
        "contacts": [list(run.contacts.start), list(run.contacts.release[:-1])],
        "motion": [list(part) for part in run([0.3, 1.1, run.t_end])],
    }

two_walls = (pc.Wall(-1.0, "below", 0.7), pc.Wall(1.0, "above", 0.9))
soft = (pc.SoftStop(0.5, "above", 29.0, 0.3), pc.SoftStop(-0.5, "below", 5.0))
both = pc.fourier(2.0, cos=(1.0, 0.2), sin=(0.3, 0.1), constant=0.1)
runs = [
    pc.simulate(pc.impact_oscillator(0.3), pc.cosine(2.7, constant=-0.8), v0=1.0, t_end=9.0),
    pc.simulate(pc.Oscillator(1.0, 0.02, (*two_walls, *soft)), both, 0.1, 2.0, t_end=9.0),
    pc.simulate(pc.impact_oscillator(0.5, damping=3.0), pc.sine(1.0), v0=1.0, t_end=20.0),
    pc.simulate(pc.Oscillator(-0.5, 0.0, two_walls), both, 0.1, t_end=9.0),
    pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, t_end=30.0),
    pc.simulate(pc.impact_oscillator(), pc.sine(3), t_end=9.0),
    pc.simulate(pc.impact_oscillator(), pc.fourier(1, cos=(-4, 1), constant=3 - 1e-15), t_end=9.0),
    pc.simulate(pc.Oscillator(1, 0, (pc.SoftStop(0, "below", 1e8, 1e6),)), pc.cosine(2.1), 0.3,
                0.3, t_end=9.0),
]
print(json.dumps([events(run) for run in runs]))
"""


MANY_SHAPES = """
import json
from itertools import product
import numpy as np
import percuss as pc
from percuss.kernels import march, sample, step

stops = (
    pc.Wall(-1.0, "below"),
    pc.SoftStop(0.5, "above", 3.0, 0.1),
    pc.SoftStop(-0.5, "below", 3.0),
    pc.Wall(1.0, "above", 0.5),
)
for n, count in product(range(1, 9), range(5)):
    force = pc.fourier(2.0, cos=(0.3,) * n)
    run = pc.simulate(pc.Oscillator(1.0, 0.1, stops[:count]), force, v0=1.0, t_end=5.0)
    run(np.linspace(0.0, 5.0, 20)[::2], "before")
    run.forces([1.0])
entries = (
    march.march, sample.evaluate, sample.cycles, sample.drive, step.fill_steps
)
print(json.dumps({entry.__name__: len(entry.signatures) for entry in entries}))
"""


def run_with(disable_jit: str) -> list[dict[str, list[list[float]]]]:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": disable_jit}
    done = subprocess.run(
        [sys.executable, "-c", RUNS], env=environment, capture_output=True, text=True, check=True
    )
    answer: list[dict[str, list[list[float]]]] = json.loads(done.stdout)
    return answer


def test_whole_runs_come_out_the_same_without_the_compiler() -> None:
    """To a few ulp: libm's functions need not be rounded alike, and impacts multiply errors."""
    for plain, compiled in zip(run_with("1"), run_with("0"), strict=True):
        happened = (compiled[name][0] for name in ("impacts", "crossings", "contacts"))
        assert sum(map(len, happened)) > 0
        for name, columns in compiled.items():
            for column, expected in zip(plain[name], columns, strict=True):
                np.testing.assert_allclose(column, expected, rtol=1e-12, atol=1e-13)


def test_each_entry_point_is_compiled_once_whatever_the_oscillator() -> None:
    """In a process of its own: other tests call the kernels with types of their own."""
    done = subprocess.run(
        [sys.executable, "-c", MANY_SHAPES], capture_output=True, text=True, check=True
    )

    counts = json.loads(done.stdout)
    # What is called once a law or once a run may run as plain Python.
    assert set(counts.values()) <= {0, 1}
    assert counts["march"] == counts["evaluate"] == 1
