"""What is written on a picture stands inside it and apart, also for odd data and long names."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox, BboxBase
from tests.plotting.axes import new_axes

import percuss as pc
from percuss import plotting
from percuss.errors import ParameterError
from percuss.plotting import Units
from percuss.studies.reading import parse_study
from percuss.studies.running import draw_picture

PATH = "oscillator.stops.0.at"
# A micromechanical switch, in metres and seconds.
SWITCH = pc.Oscillator(
    stiffness=1e10, damping=5000,
    stops=(pc.Wall(2e-7, "above", restitution="0.7"),), units=Units("m", "s"),
)  # fmt: skip
PUSH = pc.cosine(8e4, amplitude=5000)
LONG = "all that is known of the motion of the buoy in the sea of the first of January " * 3


def box(text: Text) -> Bbox:
    return text.get_window_extent()


def apart(boxes: list[Bbox]) -> bool:
    return not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def is_inside(inner: BboxBase, outer: BboxBase) -> bool:
    (x0, y0, x1, y1), (left, low, right, high) = inner.extents, outer.extents
    return bool(left - 1 <= x0 and x1 <= right + 1 and low - 1 <= y0 and y1 <= high + 1)


def figure_of(ax: Axes) -> Figure:
    assert isinstance(ax.figure, Figure)
    ax.figure.canvas.draw()
    return ax.figure


def over_the_place(values: list[float]) -> xr.Dataset:
    at = np.linspace(-1e-6, 1e-6, len(values))
    across = [1e5, 2e5]
    return xr.Dataset(
        {"largest": ((PATH, "forcing.omega"), np.column_stack([values, values]))},
        coords={PATH: at, "forcing.omega": across},
    ).transpose("forcing.omega", PATH)


def test_a_legend_of_many_entries_has_rows_that_fit() -> None:
    stops = [pc.SoftStop(at, "above", stiffness=10) for at in ("0.5", "0.6", "0.7")]
    stops += [pc.SoftStop(at, "below", stiffness=10) for at in ("-0.5", "-0.6", "-0.7")]
    run = pc.simulate(pc.Oscillator(damping="0.02", stops=tuple(stops)), pc.cosine(1), t_end=300)

    figures = [plotting.plot_motion(run), figure_of(plotting.plot_impact_velocities(run))]

    for figure in figures:
        figure.canvas.draw()
        (legend,) = figure.legends
        assert len(legend.get_texts()) >= 5
        assert is_inside(legend.get_window_extent(), figure.bbox)


def test_a_legend_above_leaves_the_factor_of_the_ticks_free() -> None:
    ax = plotting.plot_chart(over_the_place([1.0, np.nan, 3.0]))

    figure_of(ax)
    factor, legend = ax.yaxis.get_offset_text(), ax.get_legend()
    assert factor.get_text().startswith("1e")
    assert legend is not None
    assert not box(factor).overlaps(legend.get_window_extent())


def test_numbers_on_an_axis_do_not_run_together() -> None:
    run = pc.simulate(SWITCH, PUSH, t_end=1e-3)
    at = np.array([1e-3, 2e-3])
    table = pc.bifurcation_diagram(SWITCH, PUSH, over={PATH: at})
    far = pc.simulate(pc.impact_oscillator(wall=1000), pc.cosine(2), x0=1000.001, t_end=1)

    for figure in (
        plotting.plot_motion(run), plotting.plot_motion(far),
        figure_of(plotting.plot_diagram(table)),
    ):  # fmt: skip
        figure.canvas.draw()
        for ax in figure.axes:
            labels = [box(label) for label in ax.get_xticklabels() if label.get_text()]
            shown = [
                it for it in labels if ax.bbox.x0 - 1 <= 0.5 * (it.x0 + it.x1) <= ax.bbox.x1 + 1
            ]
            assert all(one.x1 + 3 < other.x0 for one, other in pairwise(shown))
            title = box(ax.xaxis.label)
            assert not title.overlaps(box(ax.xaxis.get_offset_text()))


def test_long_titles_have_several_lines() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=10)
    chain = pc.simulate(pc.chain([1, 1], [1, 1, 1]), pc.Loads({0: pc.cosine(2)}), t_end=10)

    for figure in (
        plotting.plot_motion(run, title=LONG),
        plotting.plot_coordinates(chain, title=LONG),
        figure_of(plotting.plot_displacement(run, xlabel=LONG, ylabel=LONG)),
    ):
        figure.canvas.draw()
        words = [box(text) for text in figure.findobj(Text) if LONG[:20] in text.get_text()]
        assert words
        assert all(is_inside(it, figure.bbox) for it in words)
        assert apart(words)


def test_a_dollar_in_the_title_of_coordinates_is_a_dollar() -> None:
    chain = pc.simulate(pc.chain([1, 1], [1, 1, 1]), pc.Loads({0: pc.cosine(2)}), t_end=10)
    figure = plotting.plot_coordinates(chain, title="for $5 to $6")
    assert not figure.texts[0].get_parse_math()


def test_answers_between_gaps_are_seen() -> None:
    omega = np.linspace(1, 2, 40)
    values = np.where(np.arange(40) % 4 == 1, 1.0, np.nan)
    values[:6] = 1.0
    table = xr.Dataset({"largest": ("forcing.omega", values)}, coords={"forcing.omega": omega})

    line, dots = plotting.plot_sweep(table, ax=new_axes()).lines

    assert line.get_linestyle() == "-"
    np.testing.assert_array_equal(dots.get_xdata(), omega[9::4])


def test_points_of_a_diagram_that_differ_by_rounding_are_one() -> None:
    free = pc.bifurcation_diagram(SWITCH, PUSH, over={PATH: np.array([1e-3, 2e-3])})
    x = free["x"].to_numpy()
    assert 0.0 < np.nanmax(x) - np.nanmin(x) < 1e-12 * np.nanmax(np.abs(x))

    low, high = plotting.plot_diagram(free, new_axes(), quantity="x").get_ylim()

    assert high - low > 0.5 * np.nanmax(np.abs(x))


def test_a_single_impact_has_a_whole_number() -> None:
    run = pc.simulate(pc.impact_oscillator("0.5"), x0=1, t_end=2)
    ax = plotting.plot_staircase(run, new_axes())
    figure_of(ax)
    assert {label.get_text() for label in ax.get_xticklabels()} <= {"0", "1", "2"}


def test_the_spectrum_of_rest_has_no_amplitudes() -> None:
    ax = plotting.plot_spectrum(pc.simulate(pc.impact_oscillator(wall=-1), t_end=10), new_axes())
    assert [text.get_text() for text in ax.texts] == ["no motion"]
    assert not ax.lines


def test_multipliers_at_a_graze_leave_the_others_to_be_seen() -> None:
    osc, force = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.1"), pc.cosine(1)
    orbit = pc.find_orbit(osc, force, n_impacts=1)
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.05, 1)})
    moduli = np.abs(branch.multipliers).max(axis=1)
    assert moduli.max() > 1e6

    ax = plotting.plot_branch(branch, new_axes(), quantity="multiplier")

    figure_of(ax)
    low, high = ax.transData.transform([(0, 0), (0, 1)])[:, 1]
    assert high - low > 0.15 * ax.bbox.height


def test_sections_are_in_the_units_of_their_oscillator() -> None:
    found = pc.singularity_set(SWITCH, PUSH)
    assert plotting.plot_singularity_set(found, new_axes()).get_ylabel().endswith("(m/s)")


def test_what_is_given_in_the_place_of_axes_is_told() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=5)
    with pytest.raises(ParameterError, match="ax = 'x': not axes of matplotlib"):
        plotting.plot_displacement(run, "x")


def test_a_long_title_of_a_study_has_several_lines() -> None:
    text = '[study]\ntitle = "%s"\n[oscillator]\nstiffness = 1\n[start]\nv0 = 1\n[run]\nt_end = 9\n'
    study = parse_study(text % LONG, "study")
    run = pc.simulate(study.oscillator, v0=1, t_end=9)

    figure = draw_picture("motion", run, study)

    figure.canvas.draw()
    (title,) = figure.texts
    assert "".join(title.get_text().split()) == "".join(LONG.split())
    assert is_inside(box(title), figure.bbox)
