"""The rounded force law: its shape, the proved bound, the orders, and its one dependency."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import percuss as pc
from percuss.errors import ParameterError
from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.models.smooth_law import (
    Rounding,
    growth_rate,
    rounded_magnitude,
    smooth_motion,
)
from percuss.paper.models.smoothing_errors import (
    RADII,
    bound_use,
    crossing_errors,
    expected_gain,
    grazing_errors,
    grazing_jump,
    horizons,
    stiff_errors,
    time_gained,
    wall_delay,
)

ROUNDINGS: tuple[Rounding, ...] = ("parabola", "hyperbola")


@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_the_rounding_lies_above_the_kink_and_has_its_radius(rounding: Rounding) -> None:
    x = np.linspace(-3.0, 3.0, 60_001)
    excess = rounded_magnitude(x, 0.5, rounding) - np.abs(x)
    most = 0.25 if rounding == "parabola" else 0.5
    assert excess.min() >= 0.0
    assert excess.max() == pytest.approx(most, abs=1e-12)
    step = 1e-4
    middle = rounded_magnitude([-step, 0.0, step], 0.5, rounding)
    assert (middle[0] - 2.0 * middle[1] + middle[2]) / step**2 == pytest.approx(2.0, rel=1e-6)


def test_the_parabola_joins_with_its_slope_and_ends_there() -> None:
    radius, step = 0.3, 1e-7
    around = rounded_magnitude([radius - step, radius, radius + step], radius)
    assert np.diff(around) / step == pytest.approx([1.0, 1.0], abs=1e-6)
    assert rounded_magnitude([-0.3, 0.3, 5.0], radius).tolist() == [0.3, 0.3, 5.0]


def test_radius_zero_is_the_kink() -> None:
    assert rounded_magnitude([-2.0, 0.0, 1.0], 0.0).tolist() == [2.0, 0.0, 1.0]


@pytest.mark.parametrize("radius", [-1e-3, np.nan, np.inf])
def test_a_radius_that_is_no_length_is_refused(radius: float) -> None:
    with pytest.raises(ParameterError, match="radius"):
        rounded_magnitude([0.0], radius)
    with pytest.raises(ParameterError, match="radius"):
        smooth_motion(pc.cosine(1), [0.0, 1.0], 0.0, 0.0, stiffness_below=2.0, radius=radius)


def test_an_unknown_rounding_is_refused() -> None:
    with pytest.raises(ParameterError, match="hyperbola"):
        rounded_magnitude([0.0], 1.0, "circle")  # type: ignore[arg-type]


def test_equal_stiffness_has_no_kink_to_round() -> None:
    times = np.linspace(0.0, 9.0, 10)
    x, v = smooth_motion(pc.cosine(2), times, 1.0, 0.0, stiffness_below=1.0, radius=0.7)
    free = pc.simulate(pc.Oscillator(stiffness=1.0), pc.cosine(2), x0=1.0, t_end=9.0)(times)
    assert np.abs(x - free[0]).max() < 1e-10
    assert np.abs(v - free[1]).max() < 1e-10


@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("below", [4.0, 20.0, 100.0])
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_the_proved_bound_holds(rounding: Rounding, below: float, damping: float) -> None:
    osc = pc.bilinear_oscillator(stiffness_below=below, damping=damping)
    force = pc.cosine(2.6, phase=0.4)
    times = np.linspace(0.0, 4.0, 41)
    exact_x, exact_v = pc.simulate(osc, force, x0=0.05, v0=-0.3, t_end=4.0)(times)
    mean = 0.5 * (1.0 + below)
    for radius in (0.3, 0.03, 0.003):
        x, v = smooth_motion(
            force,
            times,
            0.05,
            -0.3,
            stiffness_below=below,
            damping=damping,
            radius=radius,
            rounding=rounding,
        )
        eta = 1.0 if rounding == "parabola" else 2.0
        bound = eta * radius * np.expm1(growth_rate(1.0, below) * times)
        error = np.hypot(x - exact_x, (v - exact_v) / np.sqrt(mean))
        assert (error <= bound + 1e-10).all()


@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_another_method_of_another_library_agrees(rounding: Rounding) -> None:
    below, damping, radius = 20.0, 0.1, 0.05
    force = pc.cosine(1.3, phase=0.2) + pc.fourier(2.0, cos=(0.3,), constant=-0.1)

    def slope(t: float, state: np.ndarray) -> tuple[float, float]:
        x, v = state
        springs = 0.5 * (1.0 + below) * x
        springs -= 0.5 * (below - 1.0) * float(rounded_magnitude(x, radius, rounding))
        push = math.cos(1.3 * t + 0.2) + 0.3 * math.cos(2.0 * t) - 0.1
        return v, push - springs - 2.0 * damping * v

    times = [0.0, 2.0, 4.0]
    x, v = smooth_motion(
        force, times, 0.5, 0.3, stiffness_below=below, damping=damping, radius=radius,
        rounding=rounding,
    )  # fmt: skip
    other = solve_ivp(slope, (0.0, 4.0), [0.5, 0.3], "DOP853", times, rtol=1e-12, atol=1e-12)

    # The library's error is some hundred times its tolerance.
    assert np.abs(other.y - [x, v]).max() < 1e-9


def test_order_two_at_fast_crossings() -> None:
    orders = local_orders(RADII, crossing_errors())[-5:]
    assert orders == pytest.approx([2.0] * 5, abs=0.02)
    assert bound_use(20.0) < 1e-3


def test_order_three_halves_at_a_touch_with_the_derived_constant() -> None:
    assert local_orders(RADII, grazing_errors())[-1] == pytest.approx(1.5, abs=2e-3)
    ratio = grazing_errors() / grazing_jump(RADII)
    # The next term halves with each two radii: what is left is extrapolated.
    assert 2.0 * ratio[-1] - ratio[-2] == pytest.approx(1.0, abs=1e-4)
    other = grazing_errors("hyperbola") / grazing_jump(RADII)
    assert other[-1] == pytest.approx(1.748 / 0.37712, rel=0.03)


def test_the_kick_of_one_fast_crossing() -> None:
    below, radius = 400.0, 1e-4
    start = (0.5, -1.0)
    osc = pc.bilinear_oscillator(stiffness_below=below)
    run = pc.simulate(osc, None, *start, t_end=1.0)
    hit, speed = float(run.crossings.t[0]), -float(run.crossings.v[0])
    later = hit + 0.3 * np.pi / np.sqrt(below)
    x, v = smooth_motion(
        pc.cosine(1, 0.0), [0.0, later], *start, stiffness_below=below, radius=radius
    )
    dx, dv = x[-1] - run(later)[0], v[-1] - run(later)[1]
    assert np.hypot(np.sqrt(below) * dx, dv) == pytest.approx(
        (below - 1.0) * radius**2 / (6.0 * speed), rel=1e-3
    )


def test_a_stiff_rounded_spring_is_a_wall_at_the_radius() -> None:
    errors = [stiff_errors(k, 0.01)[1] for k in (1e5, 1e6, 1e7)]
    ratios = [error / wall_delay(k, 0.01) for error, k in zip(errors, (1e5, 1e6, 1e7), strict=True)]
    assert ratios[0] < ratios[1] < ratios[2] < 1.0
    # The next term falls as k-^(-1/3).
    cube = 10.0 ** (1.0 / 3.0)
    assert (cube * ratios[2] - ratios[1]) / (cube - 1.0) == pytest.approx(1.0, abs=5e-3)


def test_each_tenth_of_the_radius_gains_the_time_of_a_hundredfold_error_in_chaos() -> None:
    found = horizons()
    gained, gained_error = time_gained()
    expected, expected_error = expected_gain()

    assert np.isfinite(found).all()
    assert (np.diff(found.mean(axis=0)) > 0.0).all()
    assert gained_error < 0.06 * gained
    # Three standard errors of the difference.
    assert gained == pytest.approx(expected, abs=3.0 * math.hypot(gained_error, expected_error))
