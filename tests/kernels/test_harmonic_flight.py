"""Harmonic flights are those of the general search, made faster."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.kernels import law_columns as columns
from percuss.kernels import record
from percuss.kernels.arithmetic import ULP
from percuss.kernels.flight import set_phases
from percuss.kernels.march import march
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
    return pc.simulate(oscillator, force, x0=x0, v0=v0, max_impacts=10)


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

    # Room for what the motion makes of a rounding in 10 impacts.
    np.testing.assert_allclose(looped.t, general.t, rtol=0, atol=1e-11)
    np.testing.assert_allclose(looped.v_before, general.v_before, rtol=0, atol=1e-11)
    assert len(looped) == 10


@pytest.mark.parametrize("name", CASES)
def test_the_cases_are_harmonic(name: str) -> None:
    assert law_of(*CASES[name][:2])[columns.FIRST_HARMONIC + 1, columns.HARMONIC] == 1.0


def marched(case: tuple[pc.Oscillator, pc.Forcing, float], at_once: int) -> record.Run:
    """Return a run of 60 impacts, left and taken up again after so many each time."""
    oscillator, force, v0 = case
    run = record.new_run(law_of(oscillator, force), 64)
    run.state[record.X], run.state[record.V] = oscillator.stops[0].at, v0
    for limit in range(at_once, 61, at_once):
        march(run, np.inf, limit, 10_000)
    return run


@pytest.mark.parametrize("name", CASES)
def test_a_run_that_is_taken_up_again_goes_on_with_the_same_bits(name: str) -> None:
    whole = marched(CASES[name], 60)
    assert whole.counters[record.N_IMPACTS] == 60
    for at_once in (1, 3, 20):
        parts = marched(CASES[name], at_once)
        n = whole.counters[record.N_EVENTS]
        assert parts.events[:n].tobytes() == whole.events[:n].tobytes()


@pytest.mark.parametrize("name", CASES)
def test_the_force_that_is_carried_along_is_that_of_the_instant(name: str) -> None:
    """To the 12 roundings for which the walk's slack has room."""
    oscillator, force, _ = CASES[name]
    law = law_of(oscillator, force)
    harmonic = law[columns.FIRST_HARMONIC]
    sign = 1.0 if oscillator.stops[0].side == "below" else -1.0
    for at_once in (7, 9, 11, 13):
        state = marched(CASES[name], at_once).state
        assert state[record.CARRIED_T] == state[record.T]
        phases = np.empty((1, 2))
        set_phases(law, state[record.T], state[record.T_LOW], phases)
        cosine, sine = phases[0]
        push = harmonic[columns.COSINE] * cosine + harmonic[columns.SINE] * sine
        rate = harmonic[columns.SINE] * cosine - harmonic[columns.COSINE] * sine
        limit = 12 * ULP * harmonic[columns.AMPLITUDE]
        assert abs(state[record.CARRIED_PUSH] - sign * push) <= limit
        assert abs(state[record.CARRIED_RATE] - sign * rate) <= limit
