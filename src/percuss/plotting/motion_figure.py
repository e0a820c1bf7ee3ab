"""One figure that shows a whole run."""

from __future__ import annotations

from matplotlib.figure import Figure

from percuss.motion.trajectory import Trajectory
from percuss.plotting.impact_plot import plot_impact_velocities
from percuss.plotting.portrait import plot_phase_portrait
from percuss.plotting.style import Units, draw_legend, new_figure, style
from percuss.plotting.time_plots import plot_displacement, plot_velocity

WIDTH, HEIGHT = 8.0, 9.0


def plot_motion(
    run: Trajectory,
    figure: Figure | None = None,
    *,
    title: str = "",
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Figure:
    """Draw a run in four panels: x(t), v(t), the phase portrait and the impact velocities.

    Parameters
    ----------
    run
        The run.
    figure
        An empty figure to draw on, such as `offscreen_figure`; default: a new one.
    title
        Title of the figure.
    window
        First and last time that are drawn; default: the whole run.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Figure
        The figure.
    """
    with style():
        figure = new_figure(WIDTH, HEIGHT) if figure is None else figure
        # Two parts, so that the scale of colours below takes no room from the curves above.
        parts = figure.subfigures(2, 1, squeeze=False, height_ratios=[1.35, 1.0])
        upper, lower = parts[:, 0]
        panels = {
            **upper.subplot_mosaic([["x"], ["v"]]),
            **lower.subplot_mosaic([["portrait", "impacts"]]),
        }
        panels["x"].sharex(panels["v"])
        plot_displacement(run, panels["x"], window=window, units=units)
        plot_velocity(run, panels["v"], window=window, units=units)
        plot_phase_portrait(run, panels["portrait"], window=window, units=units)
        plot_impact_velocities(run, panels["impacts"], window=window, units=units)
        panels["x"].set_xlabel("")
        panels["x"].tick_params(labelbottom=False)
        upper.align_ylabels([panels["x"], panels["v"]])
        if title:
            figure.suptitle(title, fontsize=12.0, parse_math=False)
        draw_legend(figure, panels.values())
    return figure
