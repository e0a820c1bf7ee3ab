"""The picture of a branch."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from matplotlib.axes import Axes

import percuss as pc
from percuss.orbits import Branch
from percuss.orbits.families.special_points import Kind
from percuss.plotting import Units, offscreen_figure, plot_branch
from percuss.plotting.branch_plot import MARKERS


def new_axes() -> Axes:
    ax: Axes = offscreen_figure().add_subplot()
    return ax


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


def test_special_points_are_marked_and_labelled(branch: Branch) -> None:
    ax = plot_branch(branch, new_axes())

    marks = [line.get_xdata()[0] for line in ax.lines if line.get_marker() not in ("None", None)]
    assert marks == [point.value for point in branch.special_points]
    assert [text.get_text() for text in ax.texts] == ["fold", "grazing", "period doubling"]


def test_axes_name_the_parameter_and_the_quantity(branch: Branch) -> None:
    ax = plot_branch(branch, new_axes(), units=Units("mm", "s"))
    margin = plot_branch(branch, new_axes(), quantity="grazing_margin", units=Units("mm", "s"))
    multiplier = plot_branch(branch, new_axes(), quantity="multiplier")

    assert ax.get_xlabel() == "forcing.amplitude"
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


def test_a_quantity_that_is_none_is_named(branch: Branch) -> None:
    with pytest.raises(pc.ParameterError, match="none of"):
        plot_branch(branch, new_axes(), quantity="speed")


def test_each_kind_of_special_point_has_a_marker() -> None:
    assert set(get_args(Kind)) == set(MARKERS)


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
