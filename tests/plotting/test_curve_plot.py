"""The chart of curves in two parameters."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.orbits import Curve
from percuss.plotting import plot_curves

PLANE = {"forcing.omega": (0.97, 1.03), "forcing.amplitude": (0.05, 1.0)}


@pytest.fixture(scope="module")
def curves() -> list[Curve]:
    osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    orbit = pc.find_orbit(osc, pc.cosine(1.0, amplitude=0.2))
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.2, 0.08)})
    return [pc.continue_curve(point, PLANE) for point in branch.special_points]


def test_physical_orbits_are_solid_and_others_faint(curves: list[Curve]) -> None:
    (fold,) = (curve for curve in curves if curve.kind == "fold")
    ax = plot_curves(fold, new_axes())

    drawn = [line for line in ax.lines if line.get_marker() in ("None", None)]
    drawn = [line for line in drawn if len(line.get_xdata())]
    row = fold.special_points[0].row
    assert len(drawn) == 2
    for line, part in zip(drawn, (slice(0, row + 1), slice(row, len(fold))), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), fold.values[part])
    physical = fold.admissible[0], fold.admissible[-1]
    assert physical[0] != physical[1]
    assert [line.get_alpha() is None for line in drawn] == list(physical)


def test_curves_are_labelled_by_kind_and_points_named_once(curves: list[Curve]) -> None:
    ax = plot_curves(curves, new_axes())

    legend = ax.get_legend()
    assert legend is not None
    labels = [text.get_text() for text in legend.get_texts()]
    assert labels == ["fold", "period doubling", "grazing", "not physical"]
    named = plot_curves(curves, new_axes(), units=pc.Units("m", "s"))
    assert named.get_xlabel() == r"forcing frequency $\omega$ (1/s)"
    assert ax.get_ylabel() == "forcing amplitude (dimensionless)"
    # All three touch in one point.
    assert [text.get_text() for text in ax.texts] == ["resonant grazing"]
    marks = [line.get_xydata()[0] for line in ax.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(marks, [curves[0].special_points[0].values], atol=1e-9)


def test_a_point_on_other_curves_alone_keeps_its_names(curves: list[Curve]) -> None:
    ax = plot_curves([curve for curve in curves if curve.kind != "grazing"], new_axes())

    assert [text.get_text() for text in ax.texts] == ["fold grazing, period doubling grazing"]


def test_several_charts_share_axes(curves: list[Curve]) -> None:
    ax = new_axes()

    assert plot_curves(curves[:1], ax) is ax
    assert plot_curves(curves[1:], ax) is ax

    labels = ax.get_legend_handles_labels()[1]
    assert len(labels) == len(set(labels)) == 4


def test_what_cannot_be_drawn_is_named(curves: list[Curve]) -> None:
    point = curves[0].orbits[0]
    with pytest.raises(pc.ParameterError, match="none to draw"):
        plot_curves([], new_axes())
    branch = pc.continue_orbit(point, over={"forcing.amplitude": (0.05, 0.5)})
    turned = {"forcing.amplitude": (0.05, 0.5), "forcing.omega": (0.9, 1.1)}
    other = pc.continue_curve(branch.special_points[0], turned, max_points=3)
    with pytest.raises(pc.ParameterError, match=r"first, forcing\.omega"):
        plot_curves([curves[0], other], new_axes())
