"""Branches from which several files of tests follow curves."""

from __future__ import annotations

import pytest

import percuss as pc
from percuss.orbits import Branch

AMPLITUDE = "forcing.amplitude"


@pytest.fixture(scope="session")
def soft() -> Branch:
    """A branch with two folds at a soft stop."""
    osc = pc.Oscillator(1.0, "0.05", (pc.SoftStop(1.0, "above", 9.0),))
    orbit = pc.find_orbit(osc, pc.cosine("1.5", amplitude=3))
    return pc.continue_orbit(orbit, over={AMPLITUDE: (4.0, 0.5)})


@pytest.fixture(scope="session")
def mirrored() -> Branch:
    """A branch of symmetric orbits between two walls, whose symmetry breaks."""
    stops = (pc.Wall(0.3, "above", 0.7), pc.Wall(-0.3, "below", 0.7))
    orbit = pc.find_orbit(pc.Oscillator(1.0, 0.02, stops), pc.cosine(1.5), 2, 1)
    return pc.continue_orbit(orbit, over={AMPLITUDE: (0.05, 4.0)})


@pytest.fixture(scope="session")
def conservative() -> Branch:
    """A branch of elastic impacts without damping, formal where it begins."""
    with pytest.warns(pc.FormalOrbitWarning):
        orbit = pc.find_orbit(pc.impact_oscillator(1, wall=-0.5), pc.cosine(2.6))
    return pc.continue_orbit(orbit, over={"forcing.omega": (2.2, 3.8)})
