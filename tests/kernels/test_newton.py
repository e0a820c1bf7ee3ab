from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.kernels.law_columns import FIRST_HARMONIC
from percuss.kernels.shooting import SETTLED, SINGULAR, SPENT, ShootingProblem, advance, iterate
from percuss.model.system import law as law_of


def test_a_step_leaves_every_flight_a_tenth_of_its_duration() -> None:
    # t0, two durations, two velocities; the scales are 2 and 4.
    unknowns = np.array([0.0, 1.0, 3.0, 4.0, -1.0])

    size = advance(unknowns, np.array([0.0, -0.9, 0.0, 0.5, 0.0]), 2)

    assert size == 0.9
    np.testing.assert_allclose(unknowns, [0.0, 0.1, 3.0, 5.0, -1.0], rtol=1e-15)


def run(
    restitution: float, omega: float, unknowns: list[float], steps: int = 40
) -> tuple[int, float, list[float]]:
    """Return why it came back, the residual and the best unknowns: one wall, one impact."""
    law = law_of(pc.impact_oscillator(restitution, side="above"), pc.cosine(omega))
    region = FIRST_HARMONIC + 1
    itinerary = np.array([[1, region, region]])
    best = np.empty(3)
    period = 2.0 * math.pi / omega
    problem = ShootingProblem(law, itinerary, period, np.empty((1, 2)), np.empty((1, 2)))
    solution = np.array([unknowns[0], period, unknowns[1]])
    why, size, _ = iterate(problem, solution, np.empty(3), np.empty((3, 3)), best, steps)
    return why, size, best.tolist()


def test_newtons_method_converges_to_the_closed_form() -> None:
    """The reference case orbit-w2.5-r0.8-s0-n1."""
    why, size, best = run(0.8, 2.5, [1.25, -0.45])

    assert why == SETTLED
    assert size < 1e-14
    expected = [1.202260149499610598, 2.0 * math.pi / 2.5, -0.8 * 0.64535217841419570395]
    np.testing.assert_allclose(best, expected, rtol=1e-14)


def test_without_steps_left_the_best_iterate_is_given() -> None:
    why, size, best = run(0.8, 2.5, [1.25, -0.45], steps=1)

    assert why == SPENT
    assert 1e-8 < size < 1e-1
    assert best[1] == pytest.approx(2.0 * math.pi / 2.5, rel=1e-15)


def test_equations_of_a_family_are_singular() -> None:
    """Every free elastic hop lasts pi: one forcing period of a force of no amplitude cannot tell one from another."""
    law = law_of(pc.impact_oscillator(), pc.cosine(2, amplitude=0.0))
    itinerary = np.array([[0, FIRST_HARMONIC + 1, FIRST_HARMONIC + 1]])
    problem = ShootingProblem(law, itinerary, math.pi, np.empty((1, 2)), np.empty((1, 2)))
    guess, scratch = np.array([0.3, 3.0, 1.0]), (np.empty(3), np.empty((3, 3)))

    why, _, _ = iterate(problem, guess, *scratch, np.empty(3), 40)

    assert why == SINGULAR
