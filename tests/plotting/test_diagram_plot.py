"""The picture of a bifurcation diagram."""

from __future__ import annotations

import time

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.plotting import Units, plot_diagram
from percuss.plotting.diagram_plot import COLOURS

GAP = "oscillator.stops.0.at"


def colour_at(ax: Axes, x: float, y: float) -> tuple[float, ...] | None:
    """Return the colour of the picture at a place, None where it is empty."""
    (image,) = ax.images
    left, right, low, high = image.get_extent()
    cells = np.asarray(image.get_array())
    row = int((y - low) / (high - low) * cells.shape[0])
    column = int((x - left) / (right - left) * cells.shape[1])
    # A line may lie in the next cell.
    around = cells[max(row - 2, 0) : row + 3, column]
    drawn = around[around[:, 3] > 0.0]
    return tuple(drawn[0, :3]) if len(drawn) else None


@pytest.fixture(scope="module")
def hysteresis() -> xr.Dataset:
    """Two motions between the graze at 0.794 and the fold at 2.121."""
    osc = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
    return pc.bifurcation_diagram(
        osc, pc.cosine(1.5), over={GAP: np.linspace(0.5, 2.3, 19)}, transient=400, points=8
    )


def test_each_direction_has_its_colour_where_they_part(hysteresis: xr.Dataset) -> None:
    ax = plot_diagram(hysteresis, new_axes())

    for gap, branch, colour in (
        (0.6, "forward", "both"),
        (1.5, "forward", "forward"),
        (1.5, "backward", "backward"),
        (2.2, "forward", "both"),
    ):
        x = hysteresis.x.sel(branch=branch).sel({GAP: gap}, method="nearest")
        assert colour_at(ax, gap, float(x[0])) == pytest.approx(to_rgb(COLOURS[colour]))
    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["forward", "backward", "both"]


def test_axes_are_named_and_there_is_a_bar(hysteresis: xr.Dataset) -> None:
    ax = plot_diagram(hysteresis, new_axes(), quantity="v", units=Units("mm", "s"))

    assert ax.get_xlabel() == "place of the stop (mm)"
    assert ax.get_ylabel() == "v at whole periods (mm/s)"
    assert [other.get_ylabel() for other in ax.figure.axes] == [ax.get_ylabel(), "points in a cell"]


def test_every_finite_point_is_counted_and_a_million_is_quick() -> None:
    rng = np.random.default_rng(0)
    values = np.linspace(1.0, 2.0, 1000)
    data = xr.Dataset(
        {
            "x": (("branch", "a", "sample"), rng.random((1, 1000, 1000))),
            "period": (("branch", "a"), np.zeros((1, 1000), dtype=np.int64)),
        },
        coords={"branch": ["forward"], "a": values},
    )
    data.x[0, 0, :] = np.nan

    begin = time.process_time()
    ax = plot_diagram(data, new_axes())

    # A second or two where nothing else runs; a scatter of them takes far longer to draw.
    assert time.process_time() - begin < 20.0
    cells = np.asarray(ax.images[0].get_array())
    assert (cells[:, 0, 3] == 0.0).all()
    assert (cells[:, 1:, 3] > 0.0).mean() > 0.7


def test_a_few_points_far_out_do_not_hide_the_others() -> None:
    x = np.zeros((1, 50, 100))
    x[..., :] = np.linspace(0.0, 1.0, 100)
    x[0, 3, 5] = 1e6
    data = xr.Dataset(
        {"x": (("branch", "a", "sample"), x), "period": (("branch", "a"), np.zeros((1, 50)))},
        coords={"branch": ["forward"], "a": np.arange(50.0)},
    )

    low, high = plot_diagram(data, new_axes()).get_ylim()

    assert -0.1 < low < high < 1.1


def test_values_need_no_order_nor_equal_steps() -> None:
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.5)
    over = {"forcing.omega": [2.64, 2.5, 2.6]}

    diagram = pc.bifurcation_diagram(osc, force, over=over, section="impacts", transient=50)
    ax = plot_diagram(diagram, new_axes())

    assert ax.get_xlim()[0] < 2.5
    assert ax.get_ylabel() == "velocity after impacts (dimensionless)"


def test_what_cannot_be_drawn_is_told(hysteresis: xr.Dataset) -> None:
    with pytest.raises(pc.ParameterError, match="neither x nor v"):
        plot_diagram(hysteresis, new_axes(), quantity="cycle")


def test_a_section_that_no_motion_reaches_is_told_and_drawn_as_empty() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    over = {"forcing.omega": [2.4, 2.6]}
    section = {"at": 0.3, "direction": "up"}
    with pytest.warns(
        UserWarning, match=r"no motion has a point on the section .* any of 2 values"
    ):
        data = pc.bifurcation_diagram(osc, pc.cosine(2.5), over=over, section=section)
    ax = plot_diagram(data)
    assert any("no points" in text.get_text() for text in ax.texts)
