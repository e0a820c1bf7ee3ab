from __future__ import annotations

import pytest

import percuss as pc
from percuss.motion.trajectory import Trajectory


@pytest.fixture(scope="session")
def run() -> Trajectory:
    """A motion with impacts, crossings and exact parameters."""
    stops = (pc.Wall("-1", "below", "0.8"), pc.SoftStop("1/3", "above", 29, 0.1))
    force = pc.sine("1.3", phase="0.25", constant="-0.1")
    run: Trajectory = pc.simulate(pc.Oscillator("0.2", "0.01", stops), force, v0=0.3, t_end=40.0)
    return run
