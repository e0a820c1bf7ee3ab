"""An impact is a vertical dashed jump, never a slanted line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import percuss as pc
from percuss.motion.trajectory import Trajectory
from percuss.plotting import offscreen_figure, plot_phase_portrait, plot_velocity
from percuss.plotting.marks import Jumps
from percuss.plotting.samples import MOST_JUMPS
from percuss.plotting.style import figure_of

Plot = Callable[[Trajectory, Axes], Axes]


def drawn(plot: Plot, run: Trajectory) -> Axes:
    return plot(run, offscreen_figure().add_subplot())


def jumps_of(ax: Axes) -> Jumps:
    (jumps,) = (artist for artist in ax.collections if isinstance(artist, Jumps))
    return jumps


def dashes_of(jumps: Jumps) -> list[tuple[float, tuple[float, float]]]:
    """Return the offset and the lengths of the dashes of each line."""
    styles: Any = jumps.get_linestyle()
    return list(styles)


@pytest.mark.parametrize("plot", [plot_velocity, plot_phase_portrait])
@pytest.mark.parametrize("name", ["elastic", "chattering", "between_stops"])
def test_there_is_one_vertical_dashed_line_for_each_impact(
    plot: Plot, name: str, request: pytest.FixtureRequest
) -> None:
    run = request.getfixturevalue(name)

    jumps = jumps_of(drawn(plot, run))
    ends = np.array(jumps.get_segments())

    assert len(ends) == len(run.impacts) > 0
    np.testing.assert_array_equal(ends[:, 0, 0], ends[:, 1, 0])
    assert all(len(dashes) == 2 for _, dashes in dashes_of(jumps))


def test_a_jump_spans_the_velocities_of_its_impact_at_its_time(elastic: Trajectory) -> None:
    ends = np.array(jumps_of(drawn(plot_velocity, elastic)).get_segments())

    impacts = elastic.impacts
    np.testing.assert_array_equal(ends[:, 0, 0], impacts.t)
    np.testing.assert_array_equal(
        np.sort(ends[:, :, 1]), np.stack([impacts.v_before, impacts.v_after], 1)
    )


def test_a_jump_in_the_phase_plane_stands_at_its_stop(between_stops: Trajectory) -> None:
    ends = np.array(jumps_of(drawn(plot_phase_portrait, between_stops)).get_segments())

    assert set(ends[:, 0, 0]) == {-1.0}


def test_the_velocity_is_not_joined_across_an_impact(chattering: Trajectory) -> None:
    line = drawn(plot_velocity, chattering).lines[0]
    t, v = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())

    joined = np.isfinite(v[:-1]) & np.isfinite(v[1:])
    for instant in chattering.impacts.t:
        crossing = (t[:-1] < instant) & (t[1:] > instant)
        assert not (joined & crossing).any()
    # The curve ends at both limits; evaluated anew, they differ by rounding.
    for limit in (chattering.impacts.v_before, chattering.impacts.v_after):
        assert np.abs(np.subtract.outer(limit, v[np.isfinite(v)])).min(axis=1).max() < 1e-12


def test_dashes_that_lie_on_one_another_leave_the_same_gaps(elastic: Trajectory) -> None:
    """Counted from the start of each line they would fill each other's gaps."""
    ax = drawn(plot_phase_portrait, elastic)
    figure = figure_of(ax)
    assert isinstance(figure, Figure)
    figure.draw_without_rendering()
    jumps = jumps_of(ax)

    bottoms = np.array([segment[0] for segment in jumps.get_segments()])
    heights = ax.transData.transform(bottoms)[:, 1] * 72.0 / figure.dpi
    for height, (offset, dashes) in zip(heights, dashes_of(jumps), strict=True):
        phase = (height - offset) / sum(dashes)
        assert abs(phase - round(phase)) < 1e-6


def test_a_long_run_keeps_every_jump_that_can_be_told_from_another() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", max_impacts=2 * MOST_JUMPS)

    ends = np.array(jumps_of(drawn(plot_phase_portrait, run)).get_segments())

    # All impacts are alike, up to rounding.
    assert 1 <= len(ends) <= 4
    np.testing.assert_allclose(np.ptp(ends[:, :, 1]), 2 * 0.51, rtol=1e-9)
