"""The steps of the walk that are made at once: places from the closed form, and their proof."""

from __future__ import annotations

import random

import mpmath
import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.compile import kernel
from percuss.kernels.flight import Flight, acceleration_and_jerk, four_derivatives, move
from percuss.kernels.law_columns import FIRST_HARMONIC, STEP, STEPS_AHEAD, Law
from percuss.kernels.next_event import WALK_SLACK, clearances, margins_ahead
from percuss.kernels.step import (
    derivatives_ahead,
    set_parts,
    size_of_steps,
    turn_parts,
    walk_ahead,
)
from percuss.kernels.vectors import entry_of
from percuss.model.system import law as law_of

FORCES = {
    "none": None,
    "one": pc.cosine(2.8, 0.7),
    "three": pc.fourier(2.0, cos=(1.0, 0.3, 0.1), sin=(0.2, 0.0, 0.15), constant=0.3),
    "far apart": pc.fourier(0.01, cos=(1.0,)) + pc.cosine(40.0, 0.2),
}
OSCILLATORS = {
    "free": pc.Oscillator(0.0, 0.0),
    "dragged": pc.Oscillator(0.0, 0.7),
    "undamped": pc.Oscillator(1.0, 0.0),
    "damped": pc.Oscillator(1.0, 0.05),
    "critical": pc.Oscillator(1.0, 1.0),
    "overdamped": pc.Oscillator(1.0, 40.0),
    "resonant": pc.Oscillator(4.0, 0.0),
    "unstable": pc.Oscillator(-0.5, 0.0),
    "fed": pc.Oscillator(1.0, -0.2),
}


@kernel
def places_ahead(
    law: Law, region: int, start: tuple[float, float], phases: Floats, parts: Floats, out: Floats
) -> float:
    """Write what follows each of the steps from a velocity; return their size."""
    v, force = start
    set_parts(law, phases, parts)
    ahead = walk_ahead(law, region, force, parts, 0.0, v)
    for k in range(STEPS_AHEAD):
        out[0, k] = entry_of(ahead.y1, k)
        out[1, k] = entry_of(ahead.v1, k)
        y, w = entry_of(ahead.y, k), entry_of(ahead.v, k)
        out[2, k], out[3, k] = derivatives_ahead(law, region, force, parts, k, y, w)
    size = size_of_steps(law, region, force, parts, 0.0, v)
    turn_parts(law, region, parts)
    return size


@kernel
def judged(
    law: Law,
    region: int,
    start: tuple[float, float, float],
    parts: Floats,
    reach: tuple[float, float],
    out: Floats,
) -> int:
    """Return a bit for each doubtful step from (s, v) under a constant force; write their ends."""
    s, v, force = start
    ahead = walk_ahead(law, region, force, parts, 0.0, v)
    for k in range(STEPS_AHEAD):
        out[0, k] = entry_of(ahead.y, k)
        out[1, k] = entry_of(ahead.v, k)
        out[2, k] = entry_of(ahead.y1, k)
        out[3, k] = entry_of(ahead.v1, k)
    second, third = derivatives_ahead(law, region, force, parts, 0, 0.0, v)
    load = size_of_steps(law, region, force, parts, 0.0, v)
    margin, is_doubtful = margins_ahead(law, region, reach, (s, 0.0, v, second, third, load), ahead)
    doubtful = 1 if is_doubtful else 0
    for k in range(STEPS_AHEAD):
        if not entry_of(margin, k) > 0.0:
            doubtful |= 1 << k
    return doubtful


def system_of(oscillator: str, force: str) -> tuple[Law, int, int]:
    """Return a law, the row of its region and the number of harmonics."""
    forcing = FORCES[force]
    law = law_of(OSCILLATORS[oscillator], forcing if forcing is not None else pc.cosine(1.0, 0.0))
    n = int(law[0, 0])
    return law, FIRST_HARMONIC + n, n


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_each_step_ends_where_the_closed_form_is(oscillator: str, force: str) -> None:
    """Much nearer than the slack that the walk allows for."""
    law, region, n = system_of(oscillator, force)
    rng = np.random.default_rng(7)
    step = law[region, STEP]
    if oscillator == "free" and force == "none":
        # Nothing has a rate: the motion is not walked.
        assert step == 0.0
        return
    for _ in range(20):
        angles = rng.uniform(0.0, 6.0, n)
        phases = np.ascontiguousarray(np.column_stack([np.cos(angles), np.sin(angles)]))
        start = (float(rng.standard_normal()), float(rng.standard_normal()))
        parts, arrival = np.empty((n, 2)), np.empty((n, 2))
        out = np.empty((4, STEPS_AHEAD))

        size = places_ahead(law, region, start, phases, parts, out)

        flight = Flight(law, region, (0.0, 0.0, *start), phases, arrival)
        for k in range(STEPS_AHEAD):
            y, v = move(flight, (k + 1.0) * step)
            assert abs(out[0, k] - y) <= 0.01 * WALK_SLACK * size
            assert step * abs(out[1, k] - v) <= 0.01 * WALK_SLACK * size
            if k + 1 < STEPS_AHEAD:
                second, third = acceleration_and_jerk(law, region, start[1], arrival, y, v)
                assert out[2, k + 1] == pytest.approx(second, rel=1e-9, abs=1e-9)
                assert out[3, k + 1] == pytest.approx(third, rel=1e-9, abs=1e-7)
        # The turned parts are those of the phases at the end.
        there = np.empty((n, 2))
        _set_parts(law, arrival, there)
        np.testing.assert_allclose(parts, there, rtol=0, atol=1e-13)


@kernel
def _set_parts(law: Law, phases: Floats, parts: Floats) -> None:
    """Write the parts at some phases."""
    set_parts(law, phases, parts)


@pytest.mark.parametrize("from_bound", [True, False])
def test_no_step_that_is_clear_meets_a_bound(from_bound: bool) -> None:
    """Sampled densely in the closed form, and clear to the test of one step as well."""
    random.seed(3)
    clear = doubted = 0
    for _ in range(1500):
        oscillator = random.choice(["free", "undamped", "damped", "overdamped", "resonant"])
        law, region, n = system_of(oscillator, random.choice(["one", "three", "far apart"]))
        step = float(law[region, STEP])
        angles = np.array([random.uniform(0.0, 6.0) for _ in range(n)])
        phases = np.ascontiguousarray(np.column_stack([np.cos(angles), np.sin(angles)]))
        parts, arrival = np.empty((n, 2)), np.empty((n, 2))
        _set_parts(law, phases, parts)
        v, force = random.gauss(0.0, 1.0), random.gauss(0.0, 1.0)
        size = step * abs(v) + 10.0 * step * step
        low = 0.0 if from_bound and v > 0.0 else -size * 10.0 ** random.uniform(-3.0, 1.0)
        high = 0.0 if from_bound and v < 0.0 else size * 10.0 ** random.uniform(-3.0, 1.0)
        s = 0.0 if from_bound else step
        out = np.empty((4, STEPS_AHEAD))

        doubtful = judged(law, region, (s, v, force), parts, (low, high), out)

        flight = Flight(law, region, (0.0, 0.0, v, force), phases, arrival)
        for k in range(STEPS_AHEAD):
            if doubtful >> k & 1:
                doubted += 1
                continue
            clear += 1
            times = np.linspace(k * step, (k + 1) * step, 41)[1 if k == 0 else 0 :]
            places = np.array([move(flight, float(t))[0] for t in times])
            assert places.min() > low
            assert places.max() < high
            # The bound of the step's own fourth derivative is no larger.
            y, w = (0.0, v) if k == 0 else move(flight, k * step)
            if k == 0:
                arrival[:] = phases
            _, _, fourth, _ = four_derivatives(law, region, force, arrival, y, w)
            ends = out[0, k], out[1, k], out[2, k], out[3, k]
            margins = clearances(
                (low, high), s + k * step, step, 0.0, ends[:2], ends[2:], abs(fourth)
            )
            assert min(margins) > 0.0
    assert clear > 1000
    assert doubted > 200


def test_the_size_of_the_steps_bounds_the_responses_of_many_digits() -> None:
    """A slow force on a mass without a spring is where the closed form cancels most."""
    law = law_of(pc.Oscillator(0.0, 0.5), pc.cosine(1e-3, 1.0))
    region = FIRST_HARMONIC + 1
    step = float(law[region, STEP])
    out = np.empty((4, STEPS_AHEAD))
    parts = np.empty((1, 2))

    size = places_ahead(law, region, (0.0, 0.0), np.array([[1.0, 0.0]]), parts, out)

    with mpmath.workdps(60):
        for k in range(STEPS_AHEAD):
            end = (k + 1) * mpmath.mpf(step)
            # y'' + y' = cos(w s): integrated against 1 - exp(-(s - u)).
            exact = mpmath.quad(
                lambda u, end=end: (1 - mpmath.exp(u - end)) * mpmath.cos(mpmath.mpf("0.001") * u),
                [0, end],
            )
            assert abs(out[0, k] - exact) <= 0.01 * WALK_SLACK * size
