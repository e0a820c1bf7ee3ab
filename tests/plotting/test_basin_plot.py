"""The pictures of basins and of their fractions."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.plotting import Units, plot_basins, plot_fractions
from percuss.plotting.basin_plot import CLASS_COLOURS, NO_START, UNDECIDED, _pale, class_names

OSC = pc.impact_oscillator(restitution=0.7, wall="1.45789", side="above", damping=0.05)
FORCE = pc.cosine(1.5)


def texts(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


@pytest.fixture(scope="module")
def basins() -> xr.Dataset:
    return pc.basins(
        OSC, FORCE, x0=np.linspace(-3.0, 1.5, 10), v0=np.linspace(-3.0, 3.0, 7), periods=400
    )


def test_every_start_has_the_colour_of_its_class(basins: xr.Dataset) -> None:
    one = basins.copy(deep=True)
    one.basin[0, 0] = -1

    ax = plot_basins(one, new_axes())

    (image,) = ax.images
    cells = np.asarray(image.get_array())
    order = np.argsort(-basins.fraction.values)
    for i in range(10):
        for j in range(7):
            label = int(one.basin[i, j])
            place = int(np.flatnonzero(order == label)[0]) if label >= 0 else 0
            expected = {-2: to_rgb(NO_START), -1: to_rgb(UNDECIDED)}.get(
                label, _pale(CLASS_COLOURS[place])
            )
            # Rows go upwards along v0.
            np.testing.assert_allclose(cells[j, i], expected)
    assert texts(ax)[-1] == "inside a wall"


def test_attractors_are_drawn_where_they_are(basins: xr.Dataset) -> None:
    ax = plot_basins(basins, new_axes())

    drawn = np.array([line.get_xydata()[0] for line in ax.lines])
    expected = np.stack([basins.attractor_x0.values[:, 0], basins.attractor_v0.values[:, 0]], 1)
    np.testing.assert_array_equal(drawn, expected)
    assert {text.split(":")[0] for text in texts(ax)} >= {"(1, 1)", "(0, 1)"}


def test_attractors_are_not_drawn_beyond_the_axes(basins: xr.Dataset) -> None:
    ax = plot_basins(basins, new_axes())

    assert len(ax.lines) > 0
    assert all(line.get_clip_on() for line in ax.lines)


def test_manifolds_of_a_saddle_are_drawn_over_them(basins: xr.Dataset) -> None:
    (saddle,) = (
        orbit
        for orbit in pc.find_orbits(OSC, FORCE, max_impacts=1, max_periods=1)
        if orbit.stability == "unstable"
    )
    curves = pc.manifolds(saddle, length=2.0)
    curve = np.array([[0.0, 0.0], [1.0, 1.0]])

    by_result = plot_basins(basins, new_axes(), manifolds=curves)
    by_hand = plot_basins(basins, new_axes(), manifolds={"stable": [curve], "unstable": curve})
    bare = plot_basins(basins, new_axes(), manifolds=[curve])

    pieces = sum(len(branch.pieces) for branch in curves.branches)
    assert len(by_result.lines) == pieces + 2
    assert texts(by_result)[-2:] == ["stable manifold", "unstable manifold"]
    assert [line.get_linestyle() for line in by_hand.lines[:2]] == ["-", "--"]
    assert texts(bare)[-1] == "stable manifold"
    # They do not change what is shown.
    assert by_result.get_xlim() == plot_basins(basins, new_axes()).get_xlim()


def test_the_impact_surface_has_its_own_axes() -> None:
    basins = pc.basins(OSC, FORCE, cycle=(0.0, 1.0), v=[0.5, 1.5, 2.5], periods=400)

    ax = plot_basins(basins, new_axes(), units=Units("m", "s"))

    assert (ax.get_xlabel(), ax.get_ylabel()) == ("cycle", "v (m/s)")


def test_many_attractors_share_a_colour_and_equal_names_have_numbers(basins: xr.Dataset) -> None:
    n = 12
    many = xr.Dataset(
        {
            "basin": (("start.x0", "start.v0"), np.arange(n).reshape(n, 1)),
            "kind": ("attractor", np.array(["periodic"] * n, dtype=object)),
            "name": ("attractor", np.array(["(1, 1)"] * n, dtype=object)),
            "fraction": ("attractor", np.full(n, 1.0 / n)),
            "attractor_x0": (("attractor", "point"), np.zeros((n, 1))),
            "attractor_v0": (("attractor", "point"), np.zeros((n, 1))),
        },
        coords={"start.x0": np.arange(float(n)), "start.v0": [0.0]},
        attrs={"undecided": 0.0},
    )

    assert texts(plot_basins(many, new_axes()))[-1] == f"{n - len(CLASS_COLOURS)} others: 41.7%"
    assert class_names(many)[:2] == ["(1, 1) no. 1", "(1, 1) no. 2"]
    assert class_names(basins) == [str(name) for name in basins.name.values]


def test_what_cannot_be_drawn_is_told(basins: xr.Dataset) -> None:
    with pytest.raises(pc.ParameterError, match=r"not what percuss\.basins returns"):
        plot_basins(basins.drop_vars("basin"), new_axes())
    with pytest.raises(pc.ParameterError, match=r"shape \(n, 2\)"):
        plot_basins(basins, new_axes(), manifolds=[np.zeros((3, 3))])
    with pytest.raises(pc.ParameterError, match="neither curves nor manifolds"):
        plot_basins(basins, new_axes(), manifolds=3)


def test_fractions_are_stacked_and_named() -> None:
    gap = "oscillator.stops.0.at"
    shares = pc.basin_fractions(
        OSC, FORCE, over={gap: [0.6, 1.2, 2.0]}, x0=(-4.0, 0.5), v0=(-4.0, 4.0), n_starts=100
    )

    ax = plot_fractions(shares, new_axes(), units=Units("m", "s"))

    assert ax.get_xlabel() == "place of the stop (m)"
    assert texts(ax) == ["(1, 1)", "(0, 1)"]
    lower, upper = (patch.get_data() for patch in ax.patches)
    np.testing.assert_allclose(lower.values, shares.fraction.values[0])
    np.testing.assert_allclose(upper.values, 1.0)
    with pytest.raises(pc.ParameterError, match="basin_fractions"):
        plot_fractions(shares.drop_vars("fraction"), new_axes())
