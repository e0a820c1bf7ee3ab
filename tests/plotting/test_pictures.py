"""What a picture shows: stops, contacts, grazes, labels; and what it leaves alone."""

from __future__ import annotations

import inspect
import subprocess
import sys

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Rectangle
from tests.plotting.axes import new_axes

import percuss as pc
from percuss import plotting
from percuss.model import Side
from percuss.motion.trajectory import Trajectory
from percuss.plotting import (
    Units,
    offscreen_figure,
    plot_displacement,
    plot_impact_velocities,
    plot_motion,
    plot_phase_portrait,
    plot_velocity,
)
from percuss.plotting.style import ORANGE, PURPLE, VERMILION

ALL = [plot_displacement, plot_velocity, plot_phase_portrait, plot_impact_velocities]
RUNS = ["elastic", "grazing", "chattering", "between_stops"]


def hatched(ax: Axes) -> list[Rectangle]:
    return [patch for patch in ax.patches if isinstance(patch, Rectangle) and patch.get_hatch()]


def marks(ax: Axes, colour: str) -> list[tuple[float, float]]:
    """Return the places of the markers of a colour."""
    return [
        (x, y)
        for line in ax.lines
        if line.get_marker() != "None" and to_rgba(line.get_markeredgecolor()) == to_rgba(colour)
        for x, y in np.asarray(line.get_xydata()).tolist()
    ]


@pytest.mark.parametrize(("side", "sign"), [("below", -1.0), ("above", 1.0)])
def test_the_wall_is_hatched_on_the_side_where_it_lies(side: Side, sign: float) -> None:
    osc = pc.Oscillator(stops=(pc.Wall(0.25, side),))
    run = pc.simulate(osc, pc.sine(1.3), x0=0.25 - 0.5 * sign, t_end=20.0)

    along_y, along_x = plot_displacement(run, new_axes()), plot_phase_portrait(run, new_axes())

    (strip,) = hatched(along_y)
    assert sorted([strip.get_y(), strip.get_y() + strip.get_height()])[sign < 0] == 0.25
    (strip,) = hatched(along_x)
    assert sorted([strip.get_x(), strip.get_x() + strip.get_width()])[sign < 0] == 0.25


def test_a_soft_stop_is_shaded_to_the_edge_of_the_picture(between_stops: Trajectory) -> None:
    ax = plot_displacement(between_stops, new_axes())

    (region,) = (p for p in ax.patches if p.get_facecolor()[:3] == to_rgba(ORANGE)[:3])
    assert isinstance(region, Rectangle)
    assert region.get_y() == 1.0
    assert region.get_y() + region.get_height() > ax.get_ylim()[1]


def test_a_stop_far_from_the_motion_does_not_shrink_it() -> None:
    run = pc.simulate(pc.impact_oscillator(wall=-100.0), x0=1.0, t_end=10.0)

    ax = plot_displacement(run, new_axes())

    assert ax.get_ylim()[0] > -2.0
    assert hatched(ax) == []


@pytest.mark.parametrize("name", RUNS)
def test_the_whole_motion_is_inside_the_axes(name: str, request: pytest.FixtureRequest) -> None:
    run = request.getfixturevalue(name)
    x, v = run(np.linspace(run.t0, run.t_end, 20_001))

    for plot, values in ((plot_displacement, x), (plot_velocity, v)):
        low, high = plot(run, new_axes()).get_ylim()
        assert low < values.min()
        assert values.max() < high


def test_contacts_are_marked_from_touchdown_to_release(chattering: Trajectory) -> None:
    contacts = chattering.contacts
    assert len(contacts) == 2

    ax = plot_displacement(chattering, new_axes())

    assert marks(ax, VERMILION) == [(start, 0.0) for start in contacts.start]
    (lines,) = (c for c in ax.collections if tuple(c.get_colors()[0]) == to_rgba(VERMILION))
    spans = np.array(lines.get_segments())[:, :, 0]
    np.testing.assert_array_equal(spans, np.stack([contacts.start, contacts.release], axis=1))


def test_each_graze_is_marked_where_it_touches(grazing: Trajectory) -> None:
    assert len(grazing.grazes) == 5

    in_time = plot_displacement(grazing, new_axes())
    in_phase_plane = plot_phase_portrait(grazing, new_axes())

    assert marks(in_time, PURPLE) == [(t, 0.0) for t in grazing.grazes.t]
    assert marks(in_phase_plane, PURPLE) == [(0.0, 0.0)]


def test_impact_velocities_stand_over_the_cycle(elastic: Trajectory) -> None:
    ax = plot_impact_velocities(elastic, new_axes())

    points = np.asarray(ax.collections[0].get_offsets())
    np.testing.assert_allclose(points[:, 1], 0.51, rtol=1e-12)
    # Impacts at multiples of pi, a period of 2 pi/3; none is drawn a rounding below 1.
    np.testing.assert_allclose(points[:, 0], np.tile([0.5, 0.0], 5)[: len(points)], atol=1e-8)


def test_without_walls_the_entries_into_soft_stops_are_shown() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=20.0), pc.sine(1.2), t_end=30.0)
    entries = run.crossings.direction == "in"

    ax = plot_impact_velocities(run, new_axes())

    points = np.asarray(ax.collections[0].get_offsets())
    np.testing.assert_array_equal(points[:, 1], run.crossings.v[entries])
    assert "entry" in ax.get_ylabel()


def test_free_motion_has_no_cycle_and_stands_over_time() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=10.0)

    ax = plot_impact_velocities(run, new_axes())

    np.testing.assert_array_equal(np.asarray(ax.collections[0].get_offsets())[:, 0], run.impacts.t)
    assert ax.get_xlabel().startswith("time")


@pytest.mark.parametrize("plot", ALL)
def test_axes_say_dimensionless_or_the_units(plot, elastic: Trajectory) -> None:  # type: ignore[no-untyped-def]
    plain = plot(elastic, new_axes())
    metric = plot(elastic, new_axes(), units=Units("mm", "s"))

    assert "(dimensionless)" in plain.get_ylabel()
    assert "(mm" in metric.get_ylabel()
    assert all(ax.get_xlabel() for ax in (plain, metric))


def test_a_dollar_in_a_unit_or_title_is_a_dollar(elastic: Trajectory) -> None:
    figure = plot_motion(elastic, offscreen_figure(), title="a $b", units=Units("$", "$_^"))

    figure.draw_without_rendering()


@pytest.mark.parametrize("name", RUNS)
def test_no_text_is_clipped(name: str, request: pytest.FixtureRequest) -> None:
    figure = plot_motion(request.getfixturevalue(name), offscreen_figure(), title="A title")
    figure.draw_without_rendering()

    # The labels and ticks of all axes, and the title and the legend beside them.
    boxes = [ax.get_tightbbox() for ax in figure.findobj(Axes)]
    boxes += [artist.get_window_extent() for artist in (*figure.texts, *figure.legends)]
    assert len(boxes) == 5 + 2
    page = figure.bbox
    for box in boxes:
        assert box is not None
        assert page.x0 <= box.x0 < box.x1 <= page.x1
        assert page.y0 <= box.y0 < box.y1 <= page.y1


def test_drawing_changes_no_setting_of_matplotlib(elastic: Trajectory) -> None:
    before = mpl.rcParams.copy()

    plot_motion(elastic)

    assert dict(mpl.rcParams) == dict(before)


def test_drawing_on_given_axes_leaves_the_rest_of_their_figure_alone(elastic: Trajectory) -> None:
    left, right = offscreen_figure().subplots(1, 2)

    assert plot_velocity(elastic, left) is left

    assert not right.has_data()


def test_naming_the_package_does_not_import_matplotlib() -> None:
    code = "import sys, percuss.plotting; sys.exit('matplotlib' in sys.modules)"

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("x0", [0.0, 1e-300, 1e300])
def test_a_motion_of_any_size_is_drawn(x0: float) -> None:
    run = pc.simulate(pc.Oscillator(stiffness=-1.0), x0=x0, t_end=5.0)

    plot_motion(run, offscreen_figure()).draw_without_rendering()


@pytest.mark.parametrize("plot", ALL)
@pytest.mark.parametrize("options", [{"units": ("m", "s")}, {"window": 100}, {"window": (99, 100)}])
def test_options_that_cannot_be_are_refused_by_name(plot, options, elastic: Trajectory) -> None:  # type: ignore[no-untyped-def]
    (name,) = options
    with pytest.raises(pc.ParameterError, match=f"^{name} = "):
        plot(elastic, new_axes(), **options)


@pytest.mark.parametrize("name", [name for name in plotting.__all__ if name.startswith("plot_")])
def test_help_describes_each_parameter_in_the_order_of_the_signature(name: str) -> None:
    plot = getattr(plotting, name)
    section = inspect.cleandoc(plot.__doc__).split("Parameters\n----------\n")[1].split("\n\n")[0]
    names = [line for line in section.splitlines() if not line.startswith(" ")]

    assert ", ".join(names).split(", ") == list(inspect.signature(plot).parameters)
    assert plot.__doc__.count("Returns\n") == 1


def labels(ax: Axes) -> list[str]:
    return ax.get_legend_handles_labels()[1]


def test_only_a_picture_that_begins_with_the_run_marks_the_start(elastic: Trajectory) -> None:
    assert "start" in labels(plot_phase_portrait(elastic, new_axes()))
    assert "start" not in labels(plot_phase_portrait(elastic, new_axes(), window=(5.0, 9.0)))


@pytest.mark.parametrize("plot", [plot_displacement, plot_velocity, plot_phase_portrait])
def test_a_picture_of_its_own_has_a_legend(plot, chattering: Trajectory) -> None:  # type: ignore[no-untyped-def]
    alone, placed = plot(chattering), plot(chattering, new_axes())

    (legend,) = alone.figure.legends
    assert "contact" in [text.get_text() for text in legend.get_texts()]
    assert placed.figure.legends == []


def test_impacts_and_entries_have_markers_that_the_legend_names(
    between_stops: Trajectory,
) -> None:
    run = between_stops
    ax = plot_impact_velocities(run, new_axes())

    assert labels(ax) == ["impact on stop 0", "entry into stop 1"]
    impacts, entries = (np.asarray(dots.get_offsets())[:, 1] for dots in ax.collections)
    np.testing.assert_array_equal(impacts, run.impacts.v_after)
    np.testing.assert_array_equal(entries, run.crossings.v[run.crossings.direction == "in"])
    assert ax.get_ylabel().startswith("velocity after impact, at entry $v$")
    handles = [line.get_marker() for line in ax.lines]
    assert len(set(handles)) == 2


def test_one_stop_needs_no_legend_of_markers(elastic: Trajectory) -> None:
    assert labels(plot_impact_velocities(elastic, new_axes())) == []


def test_many_jumps_are_drawn_faintly() -> None:
    few, many = (
        pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", max_impacts=n) for n in (20, 400)
    )

    alphas = [plot_velocity(run, new_axes()).collections[0].get_alpha() for run in (few, many)]

    assert alphas[0] == 1.0
    assert 0.1 < alphas[1] < 0.3


def test_pictures_of_a_run_take_a_period_of_an_orbit_and_refuse_what_is_neither() -> None:
    orbit = pc.find_orbit(
        pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05"), pc.cosine(2)
    )
    drawn, run = (plot_phase_portrait(it, new_axes()) for it in (orbit, orbit.trajectory()))
    np.testing.assert_array_equal(drawn.lines[0].get_data(), run.lines[0].get_data())
    with pytest.raises(pc.ParameterError, match=r"^run = 3: "):
        plot_phase_portrait(3)


def test_a_second_picture_on_the_same_axes_leaves_the_first_in_sight() -> None:
    force = pc.cosine("2.8")
    far, near = (pc.impact_oscillator(r, wall="0.2", side="above", damping="0.05") for r in (1, 0))
    first = pc.simulate(far, force, v0=2, periods=10)
    second = pc.simulate(near, force, x0="0.1", periods=5)
    for draw in (plotting.plot_displacement, plotting.plot_phase_portrait, plotting.plot_velocity):
        ax = draw(first, new_axes())
        before = (*ax.get_xbound(), *ax.get_ybound())
        draw(second, ax)
        after = (*ax.get_xbound(), *ax.get_ybound())
        assert before[0] >= after[0]
        assert before[1] <= after[1]
        assert before[2] >= after[2]
        assert before[3] <= after[3]


def test_measurements_stay_in_sight_under_a_motion() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=10)
    ax = new_axes()
    ax.plot([0, 20], [-3, 3], ".")

    plotting.plot_displacement(run, ax, window=(2, 5))

    assert ax.get_xbound()[1] > 20
    assert ax.get_ybound()[0] < -3


def test_a_figure_of_our_own_is_white_paper_whatever_style_holds() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=10)
    with mpl.rc_context(mpl.style.library["dark_background"] | {"axes.grid": True}):
        for axes in (run.plot().axes[0], plotting.plot_displacement(run)):
            colours = (axes.get_facecolor(), axes.yaxis.label.get_color())
            assert [to_rgba(colour) for colour in colours] == [to_rgba("white"), to_rgba("black")]
            assert to_rgba(axes.figure.figure.get_facecolor()) == to_rgba("white")
            assert not axes.yaxis.get_gridlines()[0].get_visible()
        dark = plt.figure().add_subplot()
        plotting.plot_displacement(run, dark)
        assert to_rgba(dark.get_facecolor()) == to_rgba("black")
    plt.close("all")
