from __future__ import annotations

import matplotlib as mpl
import pytest

import percuss as pc
from percuss.motion.trajectory import Trajectory

# No test may need a screen.
mpl.use("agg")


@pytest.fixture(scope="session")
def elastic() -> Trajectory:
    """The third harmonic above its critical velocity (Dyskin et al. 2012, fig. 6a)."""
    run: Trajectory = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", t_end=31.0)
    return run


@pytest.fixture(scope="session")
def grazing() -> Trajectory:
    """The same at the critical velocity 1/2, where each second flight touches the wall."""
    run: Trajectory = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.5, t_end=31.0)
    return run


@pytest.fixture(scope="session")
def chattering() -> Trajectory:
    """A wall above, on which the motion comes to a stand twice."""
    osc = pc.impact_oscillator(0.5, side="above")
    run: Trajectory = pc.simulate(osc, pc.cosine(0.5, amplitude=-1.0), x0=-1.0, t_end=30.0)
    return run


@pytest.fixture(scope="session")
def between_stops() -> Trajectory:
    """A wall below and a soft stop above."""
    stops = (pc.Wall(-1.0, "below", 0.8), pc.SoftStop(1.0, "above", 29.0, 0.1))
    run: Trajectory = pc.simulate(
        pc.Oscillator(0.2, 0.01, stops), pc.cosine(1.3), v0=0.3, t_end=40.0
    )
    return run
