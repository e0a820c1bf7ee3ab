"""Grids over parameters in expressions: each point is the motion of its own model."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.grid import make_grid

W, D = pc.parameter("w", "1.66"), pc.parameter("d", "0.5")
BALL = pc.impact_oscillator("0.15", stiffness=0, wall=-D)
TABLE = pc.cosine(W, amplitude=W**2, constant=-1)


def test_every_point_of_a_sweep_is_the_motion_of_a_model_without_expressions() -> None:
    start = pc.Start(2 * D, W / 2)
    data = pc.sweep(
        "peak_displacement", BALL, TABLE, start=start, periods=12, transient=3,
        over={"w": [1.5, 1.7, 1.9], "d": ["0.1", "0.5"], "start.t0": [0, 1]},
    )  # fmt: skip
    assert data["peak_displacement"].dims == ("w", "d", "start.t0")
    for w in (1.5, 1.7, 1.9):
        for d in (0.1, 0.5):
            for t0 in (0, 1):
                plain = pc.sweep(
                    "peak_displacement",
                    pc.impact_oscillator("0.15", stiffness=0, wall=-d),
                    pc.cosine(w, amplitude=w**2, constant=-1),
                    start=(2 * d, w / 2, t0), periods=12, transient=3, over={"oscillator.damping": [0]},
                )  # fmt: skip
                own = data["peak_displacement"].sel({"w": w, "d": d, "start.t0": t0})
                assert float(own) == float(plain["peak_displacement"][0])
    assert data["w"].attrs["units"] == "1/time"
    # The wall is at -d.
    assert data["d"].attrs["units"] == "length"


def test_a_diagram_over_a_tied_parameter_is_that_of_models_made_at_each_value() -> None:
    data = pc.bifurcation_diagram(
        BALL, TABLE, over={"w": [1.6, 1.7, 1.74]}, starts=[(0.0, 1.0)], follow=[], points=8
    )
    for k, w in enumerate((1.6, 1.7, 1.74)):
        plain = pc.cosine(w, amplitude=w**2, constant=-1)
        alone = pc.bifurcation_diagram(
            BALL,
            plain,
            over={"oscillator.damping": [0.0]},
            starts=[(0.0, 1.0)],
            follow=[],
            points=8,
        )
        np.testing.assert_array_equal(data["x"].values[:, k], alone["x"].values[:, 0])
    assert data["period"].values.tolist() == [[1, 2, 4]]


def test_a_value_without_a_model_is_a_point_without_an_answer() -> None:
    osc = pc.impact_oscillator("0.6" - D)
    with pytest.warns(UserWarning, match=r"d = 0.7.* expression\('0.6-d', d='0.7'\): outside"):
        data = pc.sweep(
            "peak_displacement", osc, pc.cosine(2.0), start=(0.0, 1.0), over={"d": ["0.5", "0.7"]}
        )
    assert np.isnan(data["peak_displacement"].values).tolist() == [False, True]


def test_a_grid_knows_its_parameters_exactly() -> None:
    grid = make_grid(BALL, TABLE, pc.Start(0, 1), {"w": ("1.66", "1.79")}, points=3)
    assert grid.point(0)[1] == TABLE
    assert grid.axes[0].given[0] == "1.66"
    assert str(W**2) in grid.motion()["forcing"]
    other = make_grid(
        BALL, pc.cosine(W, constant=-1), pc.Start(0, 1), {"w": ("1.66", "1.79")}, points=3
    )
    assert grid.identity() != other.identity()


def test_two_names_of_one_parameter_are_the_same_axis() -> None:
    with pytest.raises(pc.ParameterError, match="named twice"):
        make_grid(BALL, TABLE, None, {"w": [1.0], "forcing.omega": [2.0]})
    with pytest.raises(pc.ParameterError, match=r"tied to d by oscillator.stops.0.at = -d"):
        make_grid(BALL, TABLE, None, {"oscillator.stops.0.at": [1.0]})


def test_a_parameter_with_the_name_of_a_measure_is_no_axis_of_it() -> None:
    """Both would be columns of one table."""
    osc = pc.impact_oscillator("0.8", damping=pc.parameter("min_displacement", "0.05"))
    over = {"min_displacement": ["0.05", "0.1"]}
    table = pc.sweep("max_displacement", osc, pc.cosine(2), over=over, transient=2, periods=2)
    assert table.max_displacement.dims == ("min_displacement",)
    with pytest.raises(pc.ParameterError, match="the name of a measure that is asked for"):
        pc.sweep("min_displacement", osc, pc.cosine(2), over=over, transient=2, periods=2)
