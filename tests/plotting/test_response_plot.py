"""The pictures of response charts and of velocity-gap ellipses."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import same_color

import percuss as pc
from percuss.orbits.responses.response import kinds_of
from percuss.plotting import Units, offscreen_figure, plot_response, plot_velocity_gap
from percuss.plotting.style import BLUE, GREY, VERMILION, figure_of

WALL = pc.impact_oscillator(0.8, wall=0.2, side="above", damping=0.05)


def new_axes() -> Axes:
    ax: Axes = offscreen_figure(8.0, 5.0).add_subplot()
    return ax


@pytest.fixture(scope="module")
def chart() -> pc.Response:
    return pc.response_curve(
        WALL, pc.cosine(3.0), {"forcing.omega": (2.2, 3.8)}, max_impacts=2, max_periods=2, n_seeds=1
    )


def drawn(ax: Axes, style: str) -> list[tuple[str, np.ndarray]]:
    """Return colour and points of the lines of a style."""
    return [
        (str(line.get_color()), np.asarray(line.get_xydata()))
        for line in ax.lines
        if line.get_linestyle() == style and len(np.asarray(line.get_xdata())) > 1
    ]


def test_physical_rows_are_drawn_and_only_stable_ones_solid(chart: pc.Response) -> None:
    ax = plot_response(chart, ax=new_axes(), formal=False)

    solid = np.concatenate([points for _, points in drawn(ax, "-")])
    dashed = np.concatenate([points for _, points in drawn(ax, "--")])
    special = {point.value for branch in chart.branches for point in branch.special_points}
    for branch, amplitude in zip(chart.branches, chart.amplitude, strict=True):
        for value, height, stable, physical in zip(
            branch.values, amplitude, branch.is_stable, branch.admissible, strict=True
        ):
            if value in special:
                continue
            in_solid = (solid == (value, height)).all(axis=1).any()
            in_dashed = (dashed == (value, height)).all(axis=1).any()
            assert in_solid == (physical and stable)
            assert in_dashed == (physical and not stable)


def test_formal_orbits_are_faint_and_can_be_left_out(chart: pc.Response) -> None:
    with_formal = plot_response(chart, ax=new_axes())
    without = plot_response(chart, ax=new_axes(), formal=False)

    faint = [line for line in with_formal.lines if line.get_alpha() is not None]
    assert faint
    assert all(line.get_alpha() < 0.5 for line in faint)
    assert not [line for line in without.lines if line.get_alpha() is not None]


def test_colours_tell_the_forcing_periods(chart: pc.Response) -> None:
    ax = plot_response(chart, "amplitude", new_axes(), formal=False)

    colours = {colour for style in ("-", "--") for colour, _ in drawn(ax, style)}
    assert colours == {GREY, BLUE, VERMILION}


def test_orbits_without_impacts_are_grey_on_a_branch_that_grazes_a_soft_stop(
    chart: pc.Response,
) -> None:
    stop = pc.SoftStop(at=1, side="above", stiffness=2)
    osc = pc.Oscillator(damping="0.05", stops=(stop,))
    orbit = pc.find_orbit(osc, pc.cosine("1.8", amplitude="0.4"), n_impacts=0)
    branch = pc.continue_orbit(orbit, over={"forcing.omega": ("1.8", "1.1")}, largest_step=0.1)
    heights = np.linspace(1.0, 2.0, len(branch))
    one = dataclasses.replace(
        chart, low=1.1, high=1.8, branches=(branch,), amplitude=(heights,), attractors=()
    )
    ax = plot_response(one, ax=new_axes(), formal=False)

    flies = kinds_of(branch)[:, 1] == 0
    assert {True, False} == set(flies.tolist())
    grey = np.concatenate([points for colour, points in drawn(ax, "-") if colour == GREY])
    blue = np.concatenate([points for colour, points in drawn(ax, "-") if colour == BLUE])
    assert np.isin(branch.values[flies & branch.admissible], grey[:, 0]).all()
    assert np.isin(branch.values[~flies & branch.is_stable], blue[:, 0]).all()
    assert (GREY, "(0, 1)") in {(text.get_color(), text.get_text()) for text in ax.texts}


def test_each_kind_is_labelled_once_beside_its_curve_and_no_two_overlap(chart: pc.Response) -> None:
    ax = plot_response(chart, ax=new_axes())
    figure = figure_of(ax)
    assert figure is not None
    figure.canvas.draw()

    texts = [text for text in ax.texts if text.get_text().startswith("(")]
    expected = [f"({it.n_impacts}, {it.n_periods})" for it in chart.families if it.ranges]
    assert sorted(text.get_text() for text in texts) == sorted(expected)
    boxes = [text.get_window_extent() for text in texts]
    inside = ax.get_window_extent()
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:i])
        assert inside.x0 <= box.x0 and box.x1 <= inside.x1  # noqa: PT018
        assert inside.y0 <= box.y0 and box.y1 <= inside.y1  # noqa: PT018


def test_special_points_of_physical_orbits_are_marked(chart: pc.Response) -> None:
    ax = plot_response(chart, ax=new_axes())

    marked = {float(line.get_xdata()[0]) for line in ax.lines if line.get_marker() in "osv"}
    folds = [
        point.value
        for branch in chart.branches
        for point in branch.special_points
        if point.kind == "fold" and branch.admissible[point.row - 1]
    ]
    assert folds
    assert set(folds) <= marked


def test_the_whole_range_and_all_physical_orbits_are_seen(chart: pc.Response) -> None:
    for quantity in ("amplitude", "largest_displacement", "impact_velocity"):
        ax = plot_response(chart, quantity, new_axes())
        values = getattr(chart, quantity)
        top = max(
            float(np.nanmax(np.where(branch.admissible, column, np.nan)))
            for branch, column in zip(chart.branches, values, strict=True)
            if np.isfinite(column).any()
        )
        assert ax.get_xlim() == (2.2, 3.8)
        assert top < ax.get_ylim()[1] < 1.2 * top


def test_axes_name_the_parameter_and_the_quantity(chart: pc.Response) -> None:
    ax = plot_response(chart, "impact_velocity", new_axes(), units=Units("mm", "s"), log_y=True)

    assert ax.get_xlabel() == r"forcing frequency $\omega$ (1/s)"
    assert ax.get_ylabel() == "largest impact velocity (mm/s)"
    assert ax.get_yscale() == "log"
    assert ax.get_xscale() == "linear"
    with pytest.raises(pc.ParameterError, match="none of amplitude"):
        plot_response(chart, "speed", new_axes())


def test_attractors_of_other_kinds_are_dots(chart: pc.Response) -> None:
    ax = plot_response(chart, ax=new_axes())

    others = [it.value for it in chart.attractors if it.branch is None]
    dots = [line for line in ax.lines if line.get_marker() == "."]
    assert len(dots) == (1 if others else 0)
    if others:
        assert sorted(dots[0].get_xdata()) == sorted(others)


def test_an_ellipse_is_solid_dashed_and_faint_where_its_orbits_are_so() -> None:
    curve = pc.velocity_gap_curve(WALL, pc.cosine(2.8), 2, n_points=91)
    ax = plot_velocity_gap(curve, new_axes())

    solid = np.concatenate([points for _, points in drawn(ax, "-")])
    rows = curve.is_stable & curve.admissible
    inner = np.flatnonzero(rows[1:-1] & rows[2:] & rows[:-2]) + 1
    assert len(inner) > 5
    for row in inner:
        assert (solid == (curve.gap[row], curve.velocity[row])).all(axis=1).any()
    assert [text.get_text() for text in ax.texts] == ["(1, 2)"]
    assert same_color(ax.texts[0].get_color(), VERMILION)
    marks = [(float(x.get_xdata()[0]), x.get_marker()) for x in ax.lines if x.get_marker() in "ov"]
    assert (curve.fold, "o") in marks
    with pytest.raises(pc.ParameterError, match="no curve"):
        plot_velocity_gap([], new_axes())


def test_names_of_orbits_stand_within_the_axes_beside_the_legend(chart: pc.Response) -> None:
    ax = plot_response(chart, "impact_velocity", log_y=True)
    figure = figure_of(ax)
    assert figure is not None
    figure.canvas.draw()

    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) == 3
    assert all(it.x0 >= ax.bbox.x0 and it.x1 <= ax.bbox.x1 for it in boxes)
