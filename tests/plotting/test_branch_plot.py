"""The picture of a branch."""

from __future__ import annotations

from itertools import pairwise
from typing import get_args

import numpy as np
import pytest
from matplotlib.axes import Axes
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.orbits import Branch
from percuss.orbits.bifurcations.special_points import SpecialPointKind
from percuss.plotting import Units, plot_branch
from percuss.plotting.branch_plot import MARKERS
from percuss.plotting.style import BLUE, VERMILION


@pytest.fixture(scope="module")
def branch() -> Branch:
    osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    orbit = pc.find_orbit(osc, pc.cosine(1.0))
    return pc.continue_orbit(orbit, over={"forcing.amplitude": (1.0, 0.05)})


def test_each_stretch_looks_like_its_orbits(branch: Branch) -> None:
    ax = plot_branch(branch, new_axes())

    drawn = {str(line.get_label()): line for line in ax.lines}
    rows = {point.kind: point.row for point in branch.special_points}
    fold, graze, doubling = rows["fold"], rows["grazing"], rows["period_doubling"]
    for label, first, last in (
        ("stable", 0, fold),
        ("unstable", fold, graze),
        ("unstable, not physical", graze, doubling),
        ("stable, not physical", doubling, len(branch) - 1),
    ):
        part = slice(first, last + 1)
        expected = np.column_stack([branch.values[part], branch.impact_velocity[part, 0]])
        np.testing.assert_array_equal(drawn[label].get_xydata(), expected)
    assert drawn["stable"].get_linestyle() == "-"
    assert drawn["unstable"].get_linestyle() == "--"
    assert drawn["stable, not physical"].get_alpha() == pytest.approx(0.3)


def explained(ax: Axes) -> list[str]:
    """Return what the legend says."""
    legend = ax.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def test_special_points_are_marked_and_the_legend_says_how(branch: Branch) -> None:
    ax = plot_branch(branch, new_axes())

    marks = [line.get_xdata()[0] for line in ax.lines if line.get_marker() not in ("None", None)]
    assert marks == [point.value for point in branch.special_points]
    # Names beside points that stand close would hide each other.
    assert not ax.texts
    assert explained(ax)[-3:] == ["fold", "period doubling", "grazing"]


@pytest.mark.parametrize(
    ("omega", "label"),
    [
        (pc.parameter("w", "1.2"), "w (1/s)"),
        (pc.pi_times(2) * pc.parameter("f", "0.2"), "f (Hz)"),
        (pc.pi_times(2) / pc.parameter("T", 3), "T (s)"),
        (2 * pc.parameter("w", "0.6"), "w (1/s)"),
        (pc.parameter("q", "0.2") + 1, "q"),
    ],
)
def test_a_named_parameter_has_the_unit_of_what_it_is_times_a_number(
    omega: pc.Expression, label: str
) -> None:
    osc = pc.impact_oscillator("0.8", wall=5, side="above", damping="0.05")
    calm = pc.find_orbit(osc, pc.cosine(omega), n_impacts=0)
    ((name, value),) = omega.parameters
    over = {name: (value, 1.01 * float(value))}
    ax = plot_branch(pc.continue_orbit(calm, over=over), new_axes(), units=Units("m", "s"))
    assert ax.get_xlabel() == label


def test_axes_name_the_parameter_and_the_quantity(branch: Branch) -> None:
    ax = plot_branch(branch, new_axes(), units=Units("mm", "s"))
    margin = plot_branch(branch, new_axes(), quantity="grazing_margin", units=Units("mm", "s"))
    multiplier = plot_branch(branch, new_axes(), quantity="multiplier")

    assert ax.get_xlabel() == "forcing amplitude (mm/s$^{2}$)"
    assert ax.get_ylabel() == "least impact velocity (mm/s)"
    assert margin.get_ylabel() == "distance to grazing (mm)"
    assert "multiplier" in multiplier.get_ylabel()


def test_orbits_without_impacts_are_drawn_by_their_margin() -> None:
    osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    orbit = pc.find_orbit(osc, pc.cosine(1.0, amplitude=0.02), n_impacts=0)
    free = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.02, 0.5)})

    ax = plot_branch(free, new_axes())

    assert ax.get_ylabel() == "distance to grazing (dimensionless)"
    with pytest.raises(pc.ParameterError, match="no impacts"):
        plot_branch(free, new_axes(), quantity="impact_velocity")


def test_the_axis_reaches_over_orbits_without_impacts() -> None:
    osc = pc.Oscillator(1, "0.05", (pc.SoftStop(1, "above", 9, "0.5"),))
    orbit = pc.find_orbit(osc, pc.cosine("0.7", amplitude="0.3"), n_impacts=0)
    ax = plot_branch(pc.continue_orbit(orbit, over={"forcing.constant": (0, 0.6)}), new_axes())

    drawn = np.concatenate([line.get_xdata()[np.isfinite(line.get_ydata())] for line in ax.lines])
    assert min(x for x in drawn.tolist() if x > 0.0) > 0.4
    assert ax.get_xlim()[0] < 0.0


def test_a_quantity_that_is_none_is_named(branch: Branch) -> None:
    with pytest.raises(pc.ParameterError, match="none of"):
        plot_branch(branch, new_axes(), quantity="speed")


def test_each_kind_of_special_point_has_a_marker() -> None:
    assert set(get_args(SpecialPointKind)) == set(MARKERS)


def test_where_fewer_stops_are_met_the_least_velocity_is_of_those() -> None:
    stops = (pc.SoftStop(1, "above", 9), pc.SoftStop("1.4", "above", 9))
    osc, force = pc.Oscillator(1, "0.05", stops), pc.cosine("1.5", amplitude="1.31")
    (orbit,) = (each for each in pc.find_orbits(osc, force) if each.sequence == (1, 0))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (1.45, 1.7)})
    one = np.isnan(branch.impact_velocity).sum(axis=1) == 1
    assert one.any()

    ax = plot_branch(branch, new_axes())

    curve = [
        line
        for line in ax.lines
        if line.get_marker() in ("None", None) and len(line.get_xdata()) > 2
    ]
    drawn = np.concatenate([line.get_xydata() for line in curve])
    wanted = np.column_stack([branch.values[one], np.nanmax(branch.impact_velocity[one], axis=1)])
    assert all((np.abs(drawn - row).max(axis=1) == 0.0).any() for row in wanted)


def test_the_line_is_broken_where_an_impact_more_is_made() -> None:
    gear = pc.backlash_oscillator(gap=0.36, stiffness=10.7, damping=0.074, stop_damping=0.05)
    orbits = pc.find_orbits(gear, pc.cosine(1.06, amplitude=1.17, constant=0.41), 2, 2)
    orbit = next(each for each in orbits if each.sequence == (1, 0))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (0.636, 1.696)})
    met = (~np.isnan(branch.impact_velocity)).sum(axis=1)
    jumps = np.flatnonzero(np.diff(met))
    assert len(jumps) >= 2

    ax = plot_branch(branch, new_axes())

    drawn = {
        (tuple(a), tuple(b))
        for line in ax.lines
        for a, b in pairwise(np.asarray(line.get_xydata()).tolist())
    }
    least = np.nanmin(branch.impact_velocity, axis=1)
    rows = np.column_stack([branch.values, least]).tolist()
    for k, (a, b) in enumerate(pairwise(rows)):
        assert ((tuple(a), tuple(b)) in drawn) == (k not in jumps)


def test_several_branches_have_colours_of_their_own_and_one_legend(branch: Branch) -> None:
    other = pc.continue_orbit(branch[3], over={"forcing.amplitude": (1.0, 0.5)})

    ax = plot_branch([branch, other], new_axes())

    lines = [line for line in ax.lines if len(np.asarray(line.get_xdata())) > 2]
    ends = {
        str(line.get_color()): np.asarray(line.get_xdata())[-1]
        for line in lines
        if line.get_linestyle() == "-" and line.get_alpha() is None
    }
    assert ends == {
        BLUE: branch.special_points[0].value,
        VERMILION: other.values[-1],
    }
    labels = explained(ax)
    assert len(labels) == len(set(labels)) == 4 + len({p.kind for p in branch.special_points})


def test_branches_over_different_parameters_or_none_are_refused(branch: Branch) -> None:
    other = pc.continue_orbit(branch[0], over={"forcing.omega": (0.99, 1.01)})

    with pytest.raises(pc.ParameterError, match=r"forcing\.amplitude and forcing\.omega"):
        plot_branch([branch, other], new_axes())
    with pytest.raises(pc.ParameterError, match="neither a branch"):
        plot_branch([], new_axes())


def test_the_line_breaks_where_the_nearest_turning_point_vanishes() -> None:
    """Down in frequency the nearest of two swings between impacts flattens and is gone."""
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    smooth = pc.continue_orbit(orbit, over={"forcing.omega": (1.6, 2.6)})
    whole = pc.continue_orbit(orbit, over={"forcing.omega": (1.2, 2.6)})
    leap = int(np.abs(np.diff(whole.grazing_margin)).argmax())
    assert np.abs(np.diff(whole.grazing_margin))[leap] > 0.15
    assert 1.4 < whole.values[leap] < 1.5

    lines = plot_branch(whole, new_axes(), quantity="grazing_margin").lines
    drawn = [line.get_xdata() for line in lines if len(line.get_xdata()) > 1]
    assert not any(set(whole.values[leap : leap + 2]) <= set(np.asarray(x).tolist()) for x in drawn)

    # Where none vanishes it is one line, steep as it may be.
    (line,) = plot_branch(smooth, new_axes(), quantity="grazing_margin").lines
    assert len(line.get_xdata()) == len(smooth)


def test_a_branch_with_sticking_shows_its_fastest_impacts(branch: Branch) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.3, damping=0.05), pc.cosine(0.8), np.inf)
    sticks = pc.continue_orbit(orbit, over={"forcing.omega": (0.5, 1.0)})
    ax = plot_branch(sticks, new_axes())

    assert ax.get_ylabel().startswith("largest impact velocity")
    (line,) = [line for line in ax.lines if line.get_label() == "stable"]
    fastest = [float(np.abs(it.impacts.v_before).max()) for it in sticks]
    np.testing.assert_array_equal(line.get_ydata(), fastest)
    assert explained(ax)[-1] == "chatter"
    assert plot_branch(branch, new_axes()).get_ylabel().startswith("least impact velocity")


def test_orbits_without_impacts_and_stops_are_drawn_by_their_multiplier() -> None:
    orbit = pc.find_orbit(pc.Oscillator(damping="0.1"), pc.cosine(2), n_impacts=0)
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2, 3)})
    ax = plot_branch(branch, new_axes())
    assert ax.get_ylabel() == "modulus of the larger multiplier"
    drawn = np.concatenate([line.get_ydata() for line in ax.lines])
    assert np.isfinite(drawn).all()
