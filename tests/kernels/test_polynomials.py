"""The guess at a landing, and the steps that amplitudes prove clear."""

from __future__ import annotations

import math

import numpy as np
from tests.kernels.uncompiled import python_of

import percuss as pc
from percuss.kernels.arithmetic import quintic_root
from percuss.kernels.event_location import series_root
from percuss.kernels.flight import constant_force
from percuss.kernels.law_columns import FIRST_HARMONIC
from percuss.kernels.next_event import stays_clear
from percuss.model.system import law as law_of


def test_a_falling_motion_is_guessed_close_to_its_root() -> None:
    """y = sin-like motions that begin above zero, or on it, and end below after a phase of one."""
    rng = np.random.default_rng(4)
    guess = python_of(quintic_root)
    misses: list[float] = []
    while len(misses) < 2000:
        a, b, c, turn = rng.normal(size=4)
        if len(misses) % 3 == 0:
            c = -a * math.cos(turn)  # from the wall itself
        y = [a * math.cos(turn + p) + b * p + c for p in (0.0, 1.0)]
        v = [-a * math.sin(turn + p) + b for p in (0.0, 1.0)]
        w = [-a * math.cos(turn + p) for p in (0.0, 1.0)]
        if not (y[0] > 0.0 or (y[0] == 0.0 and v[0] > 0.0)) or not y[1] < 0.0:
            continue
        part = guess((y[0], v[0], w[0]), (y[1], v[1], w[1]))
        assert 0.0 < part < 1.0
        left, right = (0.0, 1.0) if y[0] > 0.0 else (1e-6, 1.0)
        grid = np.linspace(left, right, 2001)
        below = a * np.cos(turn + grid) + b * grid + c < 0.0
        # One crossing only: which of three is guessed does not matter.
        if np.count_nonzero(np.diff(below)) == 1:
            misses.append(abs(part - grid[np.argmax(below)]))
    # A grid of 5e-4; near a graze the root of the quintic is far from that of the motion.
    assert np.mean(np.array(misses) > 2e-3) < 0.02


def test_a_degenerate_step_has_a_guess_inside_it() -> None:
    guess = python_of(quintic_root)
    for y, v, w in ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (5e-324, 1.0, 0.0), (0.0, 1e-300, 0.0)):
        assert 0.0 < guess((y, v, w), (-1.0, 0.0, 0.0)) < 1.0


def test_what_stays_clear_by_its_amplitudes_never_comes_to_the_wall() -> None:
    rng = np.random.default_rng(6)
    proved = 0
    for _ in range(300):
        damping, omega = rng.uniform(0.0, 0.3), rng.uniform(0.4, 3.0)
        osc = pc.Oscillator(1.0, damping, (pc.Wall(1.5, "above", 0.7),))
        force = pc.cosine(float(omega), constant=float(rng.uniform(-0.5, 0.5)))
        x, v = rng.uniform(-1.5, 1.4), rng.uniform(-1.0, 1.0)
        law = law_of(osc, force)
        region = FIRST_HARMONIC + 1
        pull = constant_force(law, region, x)
        phases, reach = np.array([[1.0, 0.0]]), (-math.inf, 1.5 - x)
        if python_of(stays_clear)(law, region, pull, phases, 0.0, v, reach):
            proved += 1
            free = pc.simulate(pc.Oscillator(1.0, damping), force, x, v, t_end=100.0)
            assert free(np.linspace(0.0, 100.0, 5001))[0].max() < 1.5
            assert len(pc.simulate(osc, force, x, v, t_end=100.0).impacts) == 0
    assert 30 < proved < 270


def test_resonance_is_never_clear_by_its_amplitudes() -> None:
    law = law_of(pc.Oscillator(1.0, 0.0, (pc.Wall(100.0, "above"),)), pc.cosine(1))
    phases = np.array([[1.0, 0.0]])
    assert not python_of(stays_clear)(
        law, FIRST_HARMONIC + 1, 0.0, phases, 0.0, 0.0, (-math.inf, 100.0)
    )


def test_a_series_that_by_chance_gives_no_step_gives_way_to_newton() -> None:
    """1 - x + 2 x^2 - 5 x^3 vanishes at x = 0.6003: far from its root the series says none."""
    for value in np.linspace(-0.7, -0.5, 401):
        step = python_of(series_root)(float(value), 1.0, 2.0, 0.0, 0.0)
        assert 0.25 < step < 1.4
    assert python_of(series_root)(1.0, 0.0, 1.0, 0.0, 0.0) == math.inf
    assert python_of(series_root)(0.0, 0.0, 1.0, 0.0, 0.0) == 0.0


def test_a_case_that_once_landed_where_there_was_no_wall() -> None:
    """Its first guess is bad, and the series from there ended at x = 0.0046, at t = 5.2164."""
    osc, force = pc.impact_oscillator(), pc.cosine(2.8410855696038393)
    start = (0.494389725140067, 0.20913886774449914, 3.2005328847638252)

    run = pc.simulate(osc, force, *start, t_end=7.0, max_impacts=1)

    x, _ = pc.simulate(pc.Oscillator(), force, *start, t_end=7.0)(run.impacts.t)
    np.testing.assert_allclose(x, 0.0, atol=1e-14)
