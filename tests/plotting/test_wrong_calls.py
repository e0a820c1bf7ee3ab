"""What cannot be drawn is refused in a sentence, whatever it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from tests.plotting.axes import new_axes

import percuss as pc
from percuss import plotting

OSC, FORCE = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05"), pc.cosine("2.8")
PLOTS = [getattr(plotting, name) for name in plotting.__all__ if name.startswith("plot_")]


@pytest.fixture(scope="module")
def results() -> dict[str, object]:
    run = pc.simulate(OSC, FORCE, v0="0.5", periods=5)
    over = {"forcing.omega": [2, 3]}
    return {
        "run": run,
        "sweep": pc.sweep("impacts_per_period", OSC, FORCE, over=over, transient=5, periods=5),
        "diagram": pc.bifurcation_diagram(OSC, FORCE, over=over, transient=5, points=4),
        "basins": pc.basins(OSC, FORCE, x0=[-1, 0], v0=[0, 1], periods=40),
        "spectrum": pc.spectrum(run),
        "strobes": run.stroboscopic(),
        "an empty table": xr.Dataset(),
        "oscillator": OSC,
        "an array": np.ones(3),
        "nothing": None,
    }


@pytest.mark.parametrize("plot", PLOTS, ids=lambda plot: plot.__name__)
def test_a_result_of_another_kind_is_no_fault_of_python(
    plot: Callable[..., Any], results: dict[str, object]
) -> None:
    for result in results.values():
        try:
            plot(result)
        except pc.ParameterError:
            pass
        finally:
            plt.close("all")


@pytest.mark.parametrize("name", ["sweep", "spectrum", "strobes", "basins"])
def test_a_table_that_is_no_diagram_is_named(name: str, results: dict[str, object]) -> None:
    with pytest.raises(pc.ParameterError, match=r"not what percuss\.bifurcation_diagram returns"):
        plotting.plot_diagram(results[name], new_axes())


def test_a_diagram_has_no_measure_over_two_parameters(results: dict[str, object]) -> None:
    with pytest.raises(pc.ParameterError, match="no measure over two parameters"):
        plotting.plot_chart(results["diagram"], ax=new_axes())


def test_axes_are_no_figure_of_several_panels(results: dict[str, object]) -> None:
    shapes = pc.chain([1, 1], 1)
    with pytest.raises(pc.ParameterError, match=r"figure = .*: no figure of matplotlib"):
        plotting.plot_motion(results["run"], new_axes())
    with pytest.raises(pc.ParameterError, match=r"figure = .*: no figure of matplotlib"):
        plotting.plot_mode_shapes(shapes, new_axes())
    plotting.plot_mode_shapes(shapes, plotting.offscreen_figure().subfigures(1, 2)[0])


def test_the_spectrum_of_an_orbit_is_drawn_as_lines() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
    ax = plotting.plot_spectrum(orbit, new_axes())
    assert ax.get_xlim()[1] == pytest.approx(32 * 2.5)  # the lines of the orbit, of period 1
    assert "resonant frequency" in ax.get_legend_handles_labels()[1]


def test_each_result_that_one_function_draws_draws_itself() -> None:
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.7)
    orbit = pc.find_orbit(osc, force)
    assert pc.velocity_gap_curve(osc, force).plot(ax=new_axes()).lines
    assert pc.manifolds(orbit, length=0.1).plot(ax=new_axes()).lines
    assert pc.singularity_set(osc, force).plot(ax=new_axes()).lines
    assert pc.StructureManifolds.picture == "plot_manifolds"


def test_axes_behind_the_result_are_told_their_name(results: dict[str, object]) -> None:
    for plot, name in (
        (plotting.plot_sweep, "measure"),
        (plotting.plot_chart, "measure"),
        (plotting.plot_response, "quantity"),
    ):
        with pytest.raises(pc.ParameterError, match=f"the {name}; give them as ax="):
            plot(results["sweep"], new_axes())
