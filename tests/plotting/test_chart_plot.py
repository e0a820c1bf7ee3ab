"""Charts over two parameters, and lines over one."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.plotting import Units, plot_chart, plot_sweep
from percuss.plotting.chart_plot import PERIODS

A, B = "forcing.harmonics.0.omega", "start.v0"


def chart(name: str, values: list[list[float]], units: str = "1") -> xr.Dataset:
    array = np.array(values)
    return xr.Dataset(
        {name: ((A, B), array, {"units": units})},
        coords={
            A: (A, np.linspace(1.0, 2.0, array.shape[0]), {"units": "1/time"}),
            B: (B, np.linspace(0.0, 1.0, array.shape[1]), {"units": "length/time"}),
        },
    )


def shown(ax: Axes, image: int = 0) -> np.ndarray:
    """Return the colours of the cells, rows upwards."""
    it = ax.images[image]
    return np.asarray(it.to_rgba(np.ma.asarray(it.get_array())))


def test_each_period_has_its_colour_and_long_ones_share_the_last() -> None:
    ax = plot_chart(chart("period", [[0, 1, 2], [8, 9, 40]]), ax=new_axes())

    cells = shown(ax)
    expected = [PERIODS[0], PERIODS[1], PERIODS[2], PERIODS[8], PERIODS[9], PERIODS[9]]
    found = [cells[j, i] for i in range(2) for j in range(3)]
    np.testing.assert_allclose(found, [to_rgba(colour) for colour in expected])
    bar = ax.figure.axes[1]
    assert [label.get_text() for label in bar.get_yticklabels()] == [
        "none", "1", "2", "3", "4", "5", "6", "7", "8", "> 8",
    ]  # fmt: skip
    assert bar.get_ylabel() == "forcing periods of the orbit"


def test_a_chart_of_few_periods_has_no_colours_for_others() -> None:
    ax = plot_chart(chart("period", [[1, 2], [2, 1]]), ax=new_axes())

    bar = ax.figure.axes[1]
    assert [label.get_text() for label in bar.get_yticklabels()] == ["none", "1", "2"]


def test_an_exponent_has_a_hue_for_either_sign_and_white_between() -> None:
    values = [[-0.2, -0.1], [0.0, 0.3]]
    ax = plot_chart(chart("largest_lyapunov_exponent", values, "1/time"), ax=new_axes())

    cells = shown(ax)
    red, blue = cells[..., 0], cells[..., 2]
    assert cells[0, 1, :3].min() > 0.95
    assert blue[0, 0] > red[0, 0]
    assert red[1, 1] > blue[1, 1]
    assert ax.figure.axes[1].get_ylabel() == "largest Lyapunov exponent (dimensionless)"


def test_minus_infinity_and_no_answer_have_marks_of_their_own() -> None:
    values = [[-np.inf, np.nan], [0.0, 0.3]]
    ax = plot_chart(chart("largest_lyapunov_exponent", values), ax=new_axes())

    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["minus infinity", "no answer"]
    numbers, still = (np.ma.getmaskarray(image.get_array()) for image in ax.images)
    assert numbers.tolist() == [[True, False], [True, False]]
    assert still.tolist() == [[False, True], [True, True]]


def test_axes_are_named_and_measured() -> None:
    ax = plot_chart(
        chart("fraction", [[0.1, 0.4], [0.7, 1.0]]), ax=new_axes(), units=Units("m", "s")
    )

    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        r"forcing frequency $\omega$, harmonic 0 (1/s)",
        "initial velocity $v_0$ (m/s)",
    )
    assert ax.get_xlim() == (0.5, 2.5)


def test_a_measure_is_drawn_over_one_parameter() -> None:
    with pytest.warns(UserWarning, match="1 of 3 points have no answer"):
        data = pc.sweep(
            ["period", "peak_impact_velocity"],
            pc.impact_oscillator(0.8),
            pc.cosine(2.5),
            over={"forcing.omega": [2.6, 2.5, 1e200]},
            start=(0.0, 1.0),
        )

    ax = plot_sweep(data, "peak_impact_velocity", new_axes())

    (line,) = ax.lines
    order = np.argsort(data["forcing.omega"].values)
    np.testing.assert_array_equal(line.get_ydata(), data.peak_impact_velocity.values[order])
    assert ax.get_ylabel() == "peak impact velocity (dimensionless)"
    assert plot_sweep(data, ax=new_axes()).get_ylabel() == "forcing periods of the orbit"


def test_values_in_equal_ratios_have_a_logarithmic_axis_and_cells_of_one_width() -> None:
    data = chart("peak_displacement", np.arange(12.0).reshape(4, 3).tolist())
    assert plot_chart(data, ax=new_axes()).get_xscale() == "linear"

    data = data.assign_coords({A: (A, [0.001, 0.01, 0.1, 1.0], {"units": "1/time"})})
    ax = plot_chart(data, over=(A, B), ax=new_axes())
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    (cells,) = ax.collections
    edges = cells.get_coordinates()[0, :, 0]
    np.testing.assert_allclose(np.log10(edges), [-3.5, -2.5, -1.5, -0.5, 0.5], atol=1e-12)
    one = data.isel({B: 0})
    assert plot_sweep(one, ax=new_axes()).get_xscale() == "log"


def test_axes_are_named_by_the_short_form_where_there_is_one_harmonic() -> None:
    over = {"forcing.harmonics.0.omega": [2.5, 2.6]}
    osc, two = pc.impact_oscillator(0.8), pc.cosine(2.5) + pc.cosine(5.0)
    one = pc.sweep("peak_impact_velocity", osc, pc.cosine(2.5), over={"forcing.omega": [2.5, 2.6]})
    many = pc.sweep(lambda osc, force: 1.0, osc, two, over=over)  # noqa: ARG005

    omega = r"forcing frequency $\omega$"
    assert plot_sweep(one, ax=new_axes()).get_xlabel() == f"{omega} (dimensionless)"
    assert plot_sweep(many, ax=new_axes()).get_xlabel() == f"{omega}, harmonic 0 (dimensionless)"
    metric = plot_sweep(one, ax=new_axes(), units=Units("mm", "s"))
    assert (metric.get_xlabel(), metric.get_ylabel()) == (
        f"{omega} (1/s)",
        "peak impact velocity (mm/s)",
    )


def test_a_coordinate_beside_the_path_does_not_take_its_place() -> None:
    data = pc.sweep(
        "period", pc.impact_oscillator(0.8), pc.cosine(2.5), over={"forcing.omega": [2.5, 2.6]}
    )
    beside = data.assign_coords(ratio=("forcing.omega", [1.0, 2.0]))
    assert plot_sweep(beside, ax=new_axes()).get_xlabel().startswith("forcing frequency")
    with pytest.raises(pc.ParameterError, match="no measure over two parameters"):
        plot_chart(beside.assign_coords(more=("forcing.omega", [1.0, 2.0])), ax=new_axes())


@pytest.mark.parametrize("plot", [plot_sweep, plot_chart])
def test_a_column_of_a_table_is_not_the_table(plot) -> None:  # type: ignore[no-untyped-def]
    column = chart("period", [[1.0, 2.0], [0.0, 1.0]]).period

    with pytest.raises(pc.ParameterError, match="data = 'period': one column of a table; give the"):
        plot(column)
    with pytest.raises(pc.ParameterError, match="data = 'list': no table; give the whole Dataset"):
        plot([1.0])


def test_a_period_of_free_motions_is_a_time() -> None:
    data = pc.sweep(
        "period",
        pc.Oscillator(1),
        over={"oscillator.stiffness": [1.0, 4.0]},
        start=(0.0, 1.0),
        section={"at": 0.0},
    )

    ax = plot_sweep(data, ax=new_axes(), units=Units("m", "s"))

    assert ax.get_ylabel() == "period (s)"
    assert ax.get_xlabel() == "stiffness $k$ (1/s$^{2}$)"
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [2.0 * np.pi, np.pi], rtol=1e-12)


def test_what_cannot_be_drawn_is_told() -> None:
    data = chart("period", [[1, 2], [2, 1]])

    with pytest.raises(pc.ParameterError, match="none of period"):
        plot_chart(data, "fraction", new_axes())
    with pytest.raises(
        pc.ParameterError, match="no measure over one parameter; plot_chart draws two"
    ):
        plot_sweep(data, ax=new_axes())


def test_nothing_but_holes_can_be_drawn() -> None:
    ax = plot_chart(chart("fraction", [[np.nan, np.nan]] * 2), ax=new_axes())

    assert ax.get_legend() is not None


def test_a_sweep_without_an_answer_says_so_over_its_range() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    with pytest.warns(UserWarning, match="no "):
        data = pc.sweep("period", osc, pc.cosine(2), over={"start.x0": [2.0, 3.0]})
    ax = plot_sweep(data, ax=new_axes())
    assert [text.get_text() for text in ax.texts] == ["no answer"]
    assert ax.get_xlim() == (2.0, 3.0)


def test_what_is_no_path_is_told_as_it_was_given() -> None:
    """It was told as a list, [3], and that it was not one of the path."""
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.5")
    one = pc.sweep("peak_displacement", osc, force, over={"forcing.omega": [2.4, 2.5]})
    both = pc.sweep(
        "peak_displacement", osc, force,
        over={"forcing.omega": [2.4, 2.5], "oscillator.stops.0.restitution": [0.7, 0.8]},
    )  # fmt: skip

    said = r"^over = 3: not the path of a parameter of the data; these are forcing\.omega$"
    with pytest.raises(pc.ParameterError, match=said):
        plot_sweep(one, over=3)
    with pytest.raises(
        pc.ParameterError, match="not 2 different parameters of the data; these are"
    ):
        plot_chart(both, over=("forcing.omega", "forcing.omega"))
