"""A tuple of two numbers is a range wherever values are taken; anything else are values."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.grid import make_grid, values_of

OSC, FORCE = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)


def test_a_range_has_equal_steps_and_its_ends_as_they_were_given() -> None:
    values = values_of("forcing.omega", ("2.1", 3), 11)

    assert (values[0], values[-1]) == ("2.1", 3)
    np.testing.assert_allclose([float(v) for v in values], np.linspace(2.1, 3, 11), rtol=1e-15)


def test_a_list_of_two_are_two_values_and_a_tuple_of_three_are_three() -> None:
    assert values_of("start.v0", [1.0, 2.0]) == (1.0, 2.0)
    assert values_of("start.v0", np.array([1.0, 2.0])) == (1.0, 2.0)
    assert values_of("start.v0", (1.0, 2.0, 5.0)) == (1.0, 2.0, 5.0)


def test_a_range_may_go_down() -> None:
    assert values_of("start.v0", (1.0, 0.0), 3) == (1.0, 0.5, 0.0)


def test_every_call_takes_ranges() -> None:
    quick = {"transient": 2, "periods": 2}
    swept = pc.sweep("period", OSC, FORCE, over={"forcing.omega": (2.0, 3.0)}, **quick)  # type: ignore[arg-type]
    diagram = pc.bifurcation_diagram(
        OSC, FORCE, over={"forcing.omega": (2.0, 3.0)}, transient=1, points=2, follow=[]
    )
    basins = pc.basins(OSC, FORCE, x0=(0.0, 1.0), v0=[0.5], periods=40)
    turned = pc.basins(OSC, FORCE, cycle=(0.0, 1.0), v=[0.5], periods=40)

    assert swept.sizes["forcing.omega"] == 101
    assert diagram.sizes["forcing.omega"] == 401
    assert basins.sizes["start.x0"] == 201
    # The cycles 0 and 1 are the same instant.
    assert turned.cycle.values[0] == 0.0
    assert turned.cycle.values[-1] == pytest.approx(1.0 - 1.0 / 201)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((2.0, 2.0), "without width"),
        ((1.0, math.inf), "inf"),
        ((1.0, "two"), "two"),
        ((), "without values"),
        (2.0, "nor a range"),
        ("12", "nor a range"),
    ],
)
def test_a_wrong_range_is_refused(values: object, message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        make_grid(OSC, FORCE, None, {"forcing.omega": values})


def test_over_that_is_no_mapping_is_refused() -> None:
    with pytest.raises(pc.ParameterError, match="path: values"):
        pc.sweep("period", OSC, FORCE, over=["forcing.omega"])  # type: ignore[arg-type]
