"""The pictures of spectra and of impact times beside the eigenset."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.motion.trajectory import Trajectory
from percuss.plotting import Units, plot_spectrum, plot_staircase
from percuss.plotting.style import BLUE, ORANGE


def curve(ax: Axes) -> np.ndarray:
    """Return the points of the blue line."""
    (line,) = (line for line in ax.lines if to_rgba(line.get_color()) == to_rgba(BLUE))
    return np.asarray(line.get_xydata())


def test_on_the_eigenset_the_staircase_is_flat(elastic: Trajectory) -> None:
    points = curve(plot_staircase(elastic, new_axes()))

    np.testing.assert_array_equal(points[:, 0], np.arange(1, len(elastic.impacts) + 1))
    np.testing.assert_allclose(points[:, 1], 0.0, atol=1e-13)


def test_the_picture_of_an_eigenset_is_not_filled_with_rounding(elastic: Trajectory) -> None:
    low, high = plot_staircase(elastic, new_axes()).get_ylim()

    assert low < -0.01
    assert high > 0.01


def test_additional_impacts_go_down_by_steps() -> None:
    """sin 3t with V0 = 0.45: six impacts in the time of four of the eigenset."""
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.45", t_end=100.0)

    heights = curve(plot_staircase(run, new_axes()))[:, 1]

    np.testing.assert_allclose(heights[6:] - heights[:-6], -2 * math.pi, atol=1e-12)


def test_soft_stops_are_entered_instead_and_a_spacing_may_be_given() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=4.0), v0=1.0, t_end=60.0)

    natural = curve(plot_staircase(run, new_axes()))[:, 1]
    given = curve(plot_staircase(run, new_axes(), spacing=3.0))[:, 1]

    # The start enters the free side: the first entry is after half a period of that.
    np.testing.assert_allclose(natural, -math.pi / 2, atol=1e-12)
    np.testing.assert_allclose(np.diff(given), 1.5 * math.pi - 3.0, atol=1e-12)


def test_a_spacing_is_needed_and_positive(between_stops: Trajectory) -> None:
    with pytest.raises(pc.ParameterError, match="amplitude"):
        plot_staircase(between_stops, new_axes())
    with pytest.raises(pc.ParameterError, match="positive"):
        plot_staircase(between_stops, new_axes(), spacing=0.0)


def test_a_run_without_impacts_says_so() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=1.0)

    ax = plot_staircase(run, new_axes())

    assert [text.get_text() for text in ax.texts] == ["no impacts"]


def test_the_spectrum_of_a_run_marks_its_resonant_frequency(elastic: Trajectory) -> None:
    ax = plot_spectrum(elastic, new_axes())

    (line,) = (line for line in ax.lines if to_rgba(line.get_color()) == to_rgba(ORANGE))
    np.testing.assert_array_equal(line.get_xdata(), [2.0, 2.0])
    assert ax.get_yscale() == "log"
    points = curve(ax)
    expected = pc.spectrum(elastic)
    np.testing.assert_array_equal(points[:, 0], expected.omega)
    high = expected.amplitude.values > 1e-9 * expected.amplitude.values.max()
    np.testing.assert_array_equal(points[high, 1], expected.amplitude.values[high])


def test_a_run_without_a_resonant_frequency_has_no_line(between_stops: Trajectory) -> None:
    ax = plot_spectrum(between_stops, new_axes())

    assert not [line for line in ax.lines if to_rgba(line.get_color()) == to_rgba(ORANGE)]


def test_lines_of_rounding_are_not_drawn() -> None:
    """Of sin 3t with V0 = 0.51 all odd lines but 1 and 3 are zero, and all half ones."""
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", t_end=60.0)

    ax = plot_spectrum(pc.line_spectrum(run, 4 * math.pi, 25), new_axes(), resonance=2.0)

    drawn = curve(ax)[:, 0]
    np.testing.assert_allclose(drawn, [0, 1, 2, 3, 4, 6, 8, 10, 12])


def test_a_long_spectrum_is_reduced_to_what_can_be_seen() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", t_end=2000.0)
    fast = pc.spectrum(run, "fft", n=2**17)

    points = curve(plot_spectrum(fast, new_axes()))

    assert len(points) < 10_000
    assert points[:, 1].max() == float(fast.amplitude.max())


def test_axes_name_the_quantity_and_its_unit(elastic: Trajectory) -> None:
    velocity = pc.spectrum(elastic, omega=[1.0, 2.0], of="velocity")

    assert "dimensionless" in plot_spectrum(velocity, new_axes()).get_ylabel()
    metric = plot_spectrum(velocity, new_axes(), units=Units("mm", "s"))
    assert "mm/s" in metric.get_ylabel()
    assert "1/s" in metric.get_xlabel()
    assert "(s)" in plot_staircase(elastic, new_axes(), units=Units("mm", "s")).get_ylabel()


def test_a_motion_that_is_nothing_is_drawn() -> None:
    run = pc.simulate(pc.Oscillator(), t_end=5.0)

    plot_spectrum(run, new_axes()).figure.draw_without_rendering()
