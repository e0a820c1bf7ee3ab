"""Harmonic flights are those of the general search, made faster."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.kernels import law_columns as columns
from percuss.model.system import law as law_of
from percuss.motion import Trajectory

CASES = {
    "elastic": (pc.impact_oscillator(), pc.sine(3), 0.45),
    "elastic, growing": (pc.impact_oscillator(), pc.sine(2), 1.0),
    "wall above": (pc.impact_oscillator(restitution=0.9, side="above"), pc.cosine(2.3), -1.0),
    "damped": (pc.impact_oscillator(restitution=0.8, damping=0.05), pc.cosine(4.4), 1.0),
    "wall away from 0, preload": (
        pc.impact_oscillator(restitution=0.9, wall=-0.3),
        pc.cosine(2.1, constant=0.2),
        1.0,
    ),
}


def flown(case: tuple[pc.Oscillator, pc.Forcing, float]) -> Trajectory:
    oscillator, force, v0 = case
    x0 = oscillator.stops[0].at
    # Few impacts: chaos would drive roundings apart.
    return pc.simulate(oscillator, force, x0=x0, v0=v0, max_impacts=12)


@pytest.mark.parametrize("name", CASES)
def test_the_same_impacts_come_with_and_without_the_loop_of_harmonic_flights(name: str) -> None:
    law = law_of(*CASES[name][:2])
    region = columns.FIRST_HARMONIC + 1
    looped = flown(CASES[name]).impacts

    law[region, columns.HARMONIC] = 0.0
    try:
        general = flown(CASES[name]).impacts
    finally:
        law[region, columns.HARMONIC] = 1.0

    # Room for what the motion makes of a rounding in 12 impacts.
    np.testing.assert_allclose(looped.t, general.t, rtol=0, atol=1e-11)
    np.testing.assert_allclose(looped.v_before, general.v_before, rtol=0, atol=1e-11)
    assert len(looped) == 12


@pytest.mark.parametrize("name", CASES)
def test_the_cases_are_harmonic(name: str) -> None:
    assert law_of(*CASES[name][:2])[columns.FIRST_HARMONIC + 1, columns.HARMONIC] == 1.0
