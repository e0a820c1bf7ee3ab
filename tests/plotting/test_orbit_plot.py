"""Pictures of orbits, multipliers and sections."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from tests.plotting.axes import new_axes

import percuss as pc
from percuss.plotting import (
    Units,
    plot_manifolds,
    plot_multipliers,
    plot_orbit,
    plot_singularity_set,
)
from percuss.plotting.style import figure_of

COCO = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)


@pytest.fixture(scope="module")
def orbit() -> pc.PeriodicOrbit:
    return pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.7))


@pytest.fixture(scope="module")
def branch() -> pc.Branch:
    first = pc.find_orbit(COCO, pc.cosine(1.0))
    return pc.continue_orbit(first, over={"forcing.amplitude": (1.0, 0.05)})


def lines_of(ax: Axes) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {
        str(line.get_label()): (np.asarray(line.get_xdata()), np.asarray(line.get_ydata()))
        for line in ax.lines
    }


def test_orbit_is_closed_by_its_impact(orbit: pc.PeriodicOrbit) -> None:
    ax = plot_orbit(orbit, new_axes(), units=Units("m", "s"))

    x, v = lines_of(ax)["orbit"]
    assert x.min() == pytest.approx(0.0, abs=1e-12)
    assert v[0] == pytest.approx(orbit.impacts.v_after[0])
    assert v[-1] == pytest.approx(orbit.impacts.v_before[0])
    assert any(isinstance(artist, LineCollection) for artist in ax.collections)
    assert ax.get_title() == "1 impact in 1 forcing period, T = 2.32711 s, unstable"
    assert ax.get_xlabel() == "displacement $x$ (m)"


def test_what_is_beyond_a_wall_is_faint(branch: pc.Branch) -> None:
    deepest = min(branch, key=lambda orbit: orbit.grazing_margin)
    ax = plot_orbit(deepest, new_axes())

    x, _ = lines_of(ax)["orbit"]
    assert np.nanmax(x) <= 1.0
    beyond, _ = lines_of(ax)["passes through a stop"]
    assert np.nanmax(beyond) == pytest.approx(1.0 + deepest.passages.depth.max(), abs=1e-3)
    assert ax.get_title().endswith("not physical")
    faint = next(line for line in ax.lines if line.get_label() == "passes through a stop")
    assert faint.get_alpha() is not None


def test_orbit_without_impacts_is_drawn() -> None:
    osc = pc.Oscillator(1.0, 0.1)
    ax = plot_orbit(pc.find_orbit(osc, pc.cosine(2.0), n_impacts=0), new_axes())

    x, v = lines_of(ax)["orbit"]
    assert np.hypot(x[-1] - x[0], v[-1] - v[0]) < 1e-12


def test_stay_in_a_soft_stop_is_physical() -> None:
    orbit = pc.find_orbit(pc.bilinear_oscillator(stiffness_below=9.0, damping=0.1), pc.cosine(1.5))
    ax = plot_orbit(orbit, new_axes())

    assert "passes through a stop" not in lines_of(ax)
    assert lines_of(ax)["orbit"][0].min() < 0.0


def test_multipliers_of_an_orbit_are_its_own(orbit: pc.PeriodicOrbit) -> None:
    drawn = lines_of(plot_multipliers(orbit, new_axes()))

    assert drawn["outside"][0] == pytest.approx(orbit.multipliers.real[:1])
    assert drawn["in or on the circle"][0] == pytest.approx(orbit.multipliers.real[1:])


def test_the_legend_of_multipliers_lies_beside_the_circle(orbit: pc.PeriodicOrbit) -> None:
    ax = plot_multipliers(orbit, new_axes())
    legend = ax.get_legend()
    assert legend is not None
    ax.figure.canvas.draw()

    box = legend.get_window_extent()
    _, top = ax.transData.transform((0.0, 1.0))

    assert box.y0 > top


def test_multipliers_far_outside_stand_at_the_edge() -> None:
    saddle = pc.find_orbit(pc.Oscillator(-1.0, 0.1), pc.cosine(1.0), n_impacts=0)
    ax = plot_multipliers(saddle, new_axes())

    assert saddle.multipliers[0].real > 100.0
    assert ax.get_xlim()[1] < 5.0
    assert ax.texts[0].get_text() == f"{saddle.multipliers[0].real:.4g}"


def test_multipliers_of_a_branch_are_coloured_and_not_joined_over_infinity(
    branch: pc.Branch,
) -> None:
    ax = plot_multipliers(branch, new_axes())

    assert len(ax.figure.axes) == 2
    edge = ax.get_xlim()[1]
    for artist in ax.collections:
        if isinstance(artist, LineCollection):
            for path in artist.get_paths():
                begin, end = np.asarray(path.vertices)
                assert np.hypot(*(end - begin)) < edge
    assert np.abs(branch.multipliers).max() > edge


def test_singularity_set_is_drawn_in_one_cycle() -> None:
    curves = pc.singularity_set(pc.impact_oscillator(0.8), pc.cosine(2.7), n_iterates=2)
    ax = plot_singularity_set(curves, new_axes())

    assert ax.get_xlim() == (0.0, 1.0)
    for line in ax.lines:
        cycle = np.asarray(line.get_xdata())
        drawn = np.isfinite(cycle)
        assert drawn.any()
        # Only one point each beyond the edges.
        assert ((cycle[drawn] < -0.05) | (cycle[drawn] > 1.05)).sum() == 0
    labels = ax.get_legend_handles_labels()[1]
    assert sorted(labels) == ["touch at impact 1", "touch at impact 2"]


def test_several_sets_share_axes_and_labels() -> None:
    curves = pc.singularity_set(pc.impact_oscillator(0.8), pc.cosine(2.7))
    ax = plot_singularity_set(curves, plot_singularity_set(curves, new_axes()))

    assert ax.get_legend_handles_labels()[1] == ["touch at impact 1"]


@pytest.mark.parametrize("section", ["stroboscopic", "impact"])
def test_manifolds_are_drawn_with_gaps_at_their_cuts(orbit: pc.PeriodicOrbit, section: str) -> None:
    curves = pc.manifolds(orbit, section=section, cycle=0.37, length=5.0)  # type: ignore[call-overload]
    ax = plot_manifolds(curves, new_axes())

    drawn = lines_of(ax)
    assert {"unstable manifold", "stable manifold", "saddle"} <= set(drawn)
    for kind in ("unstable", "stable"):
        x, y = drawn[f"{kind} manifold"]
        steps = np.hypot(np.diff(x) / curves.scale[0], np.diff(y) / curves.scale[1])
        assert np.nanmax(steps) <= 0.01
        assert np.isfinite(x).sum() == sum(len(b) for b in curves.branches if b.kind == kind)


def test_set_and_manifolds_share_a_picture_and_its_legend(orbit: pc.PeriodicOrbit) -> None:
    curves = pc.manifolds(orbit, section="impact", length=1.0)
    ax = plot_manifolds(curves)
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.7)
    plot_singularity_set(pc.singularity_set(osc, force), ax)
    (legend,) = ax.figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    plt.close(figure_of(ax))

    assert texts == ["saddle", "unstable manifold", "stable manifold", "touch at impact 1"]
    assert ax.get_legend() is None


def test_other_things_are_not_drawn() -> None:
    for draw in (plot_orbit, plot_multipliers, plot_singularity_set, plot_manifolds):
        with pytest.raises(pc.ParameterError, match=r"(not|neither) a"):
            draw("orbit", new_axes())
