"""Pictures of structures: what of a run concerns a direction, and the shapes of modes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

import percuss as pc
from percuss import plotting
from percuss.plotting.direction_view import direction_name, view_of

STOPS = (
    pc.Wall(at=-1, side="below", restitution="0.6", on=0),
    pc.Wall(at="1.6", side="above", restitution="0.7", on=(2, -2, 0)),
    pc.SoftStop(at="0.5", side="above", stiffness=40, damping="0.8", on=2),
)
THREE = pc.chain([2, 1, "1.5"], [3, 2, 1, 2], dashpots="0.05", stops=STOPS)
LOADS = pc.Loads({0: pc.cosine("1.3", amplitude=3), 2: pc.cosine("0.7", amplitude=2)})
RUN = pc.simulate(THREE, LOADS, v0=[1, -2, 0], t_end=30)


def new_axes() -> Axes:
    ax: Axes = plotting.offscreen_figure().add_subplot()
    return ax


def test_a_direction_has_the_stops_of_its_line_at_their_places() -> None:
    relative, back, alone = (view_of(RUN, on) for on in ((1, -1, 0), (-1, 1, 0), 1))

    assert [(float(s.at), s.side) for s in relative.oscillator.stops] == [(0.8, "above")]
    assert [(float(s.at), s.side) for s in back.oscillator.stops] == [(-0.8, "below")]
    assert alone.oscillator.stops == ()
    hits = RUN.impacts.stop == 1
    np.testing.assert_allclose(relative(RUN.impacts.t[hits])[0], 0.8, rtol=0, atol=1e-13)
    # Impacts on the ground of the first mass jump in the relative velocity, too.
    assert len(relative.impacts) == len(RUN.impacts) > hits.sum() > 0
    assert set(relative.impacts.stop.tolist()) == {0, -1}
    # The second mass moves on as it was where the first meets the ground.
    assert len(alone.impacts) == hits.sum()


def test_the_drawn_curve_is_the_motion_and_jumps_where_its_velocity_does() -> None:
    ax = plotting.plot_velocity(RUN, new_axes(), on=1)
    (jumps,) = ax.collections
    hits = RUN.impacts.stop == 1

    assert len(jumps.get_paths()) == hits.sum()
    t, v = np.asarray(ax.lines[0].get_xydata()).T
    kept = np.isfinite(v)
    exact = RUN.displacement(1, np.clip(t[kept], 0, 30))[1]
    apart = np.abs(t[kept][:, None] - RUN.impacts.t).min(axis=1) > 1e-9
    np.testing.assert_allclose(v[kept][apart], exact[apart], rtol=0, atol=1e-12)
    assert ax.get_ylabel() == "velocity of $x_{1}$\n(dimensionless)"


def test_a_phase_portrait_of_a_pair_shows_the_wall_between_them() -> None:
    ax = plotting.plot_phase_portrait(RUN, new_axes(), on=(1, -1, 0))

    assert ax.get_xlabel() == "displacement $x_{0} - x_{1}$ (dimensionless)"
    assert any(patch.get_hatch() for patch in ax.patches)
    x = np.asarray(ax.lines[0].get_xydata())[:, 0]
    assert np.nanmax(x) <= 0.8 + 1e-12


def test_coordinates_share_their_time_and_one_legend() -> None:
    figure = plotting.plot_coordinates(
        RUN, plotting.offscreen_figure(), on=[0, 2, (1, -1, 0)], window=(5, 20), title="three"
    )

    assert [ax.get_ylabel() for ax in figure.axes] == ["$x_{0}$", "$x_{2}$", "$x_{0} - x_{1}$"]
    assert {ax.get_xlim() for ax in figure.axes} == {(5.0, 20.0)}
    assert len(figure.legends) == 1
    with pytest.raises(pc.ParameterError, match=r"13 panels; give 1 to 12"):
        plotting.plot_coordinates(RUN, on=[0] * 13)
    with pytest.raises(pc.ParameterError, match=r"on = 3: no such coordinate"):
        plotting.plot_coordinates(RUN, plotting.offscreen_figure(), on=[3])


def test_a_direction_of_an_oscillator_is_refused() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=5)
    with pytest.raises(pc.ParameterError, match=r"which has one displacement"):
        plotting.plot_displacement(run, new_axes(), on=0)


def test_modes_of_a_chain_are_sines() -> None:
    figure = plotting.plot_mode_shapes(pc.chain([1] * 5, [1] * 6), plotting.offscreen_figure())

    assert len(figure.axes) == 5
    for i, ax in enumerate(figure.axes, 1):
        shape = np.asarray(ax.lines[1].get_xydata())[:, 1]
        sine = np.sin(math.pi * i * np.arange(1, 6) / 6)
        assert abs(shape @ sine) == pytest.approx(np.linalg.norm(shape) * np.linalg.norm(sine))
        assert f"{2 * math.sin(math.pi * i / 12):.5g}" in ax.get_title(loc="left")
    free = plotting.plot_mode_shapes(pc.chain([1, 2], [0, 1, 0]), plotting.offscreen_figure())
    assert free.axes[0].get_title(loc="left") == "mode 1: free"
    rotor = pc.Structure([1, 1], [[1, 2], [-2, 1]])
    with pytest.raises(pc.ParameterError, match=r"structure\.stiffness = .*: not symmetric"):
        plotting.plot_mode_shapes(rotor)


@pytest.mark.parametrize(
    ("on", "name"),
    [(0, "x_{0}"), ((1, 0, -1), "x_{0} - x_{2}"), ((-1, "0.5", 0), r"-x_{0} + 0.5\,x_{1}")],
)
def test_directions_are_named_by_their_coordinates(on: object, name: str) -> None:
    assert direction_name(THREE, on) == name  # type: ignore[arg-type]


def test_a_run_of_a_structure_is_saved_with_its_coordinates(tmp_path: Path) -> None:
    pc.save_netcdf(RUN, tmp_path / "run.nc", samples=101)
    saved = pc.load_netcdf(tmp_path / "run.nc")

    assert dict(saved.sizes) == {"sample": 101, "coordinate": 3, "stop": 3}
    t = saved["t"].values
    np.testing.assert_array_equal(saved["x"].values, RUN(t)[0])
    np.testing.assert_array_equal(saved["stop_force"].values, RUN.forces(t)["stops"].values)
    np.testing.assert_array_equal(saved["impacts"]["stop"].values, RUN.impacts.stop)
    np.testing.assert_array_equal(saved["impacts/impulse"].values, RUN.impacts.impulse)
    assert saved["impacts/impulse"].attrs["long_name"] == "impulse of the stop"
    np.testing.assert_array_equal(
        saved["impacts/effective_mass"].values, RUN.impacts.effective_mass
    )
    for name in ("impacts", "crossings", "contacts", "motion"):
        pc.save_csv(RUN, tmp_path / f"{name}.csv", table=name)
    head, first, *_ = (tmp_path / "motion.csv").read_text(encoding="utf-8").splitlines()
    assert head == "t,x0,x1,x2,v0,v1,v2"
    assert float(first.split(",")[5]) == pytest.approx(-2.0, abs=1e-15)
    rows = (tmp_path / "impacts.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == len(RUN.impacts) + 1


# Example 03 of NLvib, whose parameters alone are taken.
PAIR = pc.Structure(
    [1, 1], [[1, -1], [-1, 2]], [["0.03", "-0.03"], ["-0.03", "0.06"]],
    stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
)  # fmt: skip


def test_a_branch_and_a_curve_of_a_structure_are_drawn_with_their_special_points() -> None:
    orbit = pc.find_orbit(PAIR, pc.Loads({1: pc.cosine("0.60", amplitude="0.1")}))
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.57, 0.63)}, largest_step=0.2)
    torus = [point for point in branch.special_points if point.kind == "torus"][-1]
    ranges = {"loads.0.omega": (0.57, 0.63), "loads.0.amplitude": (0.07, 0.11)}
    curve = pc.continue_curve(torus, over=ranges, largest_step=0.1)

    below = plotting.plot_branch(branch, new_axes(), coordinate=1)
    plane = plotting.plot_curves(curve, new_axes())

    assert below.get_ylabel() == "amplitude of coordinate 1 (dimensionless)"
    assert {line.get_label() for line in below.lines} >= {"stable", "unstable"}
    assert "torus" in {text.get_text() for text in below.texts}
    assert below.get_xlabel() == plane.get_xlabel()
    assert plane.get_xlabel() == r"forcing frequency $\omega$ (dimensionless)"
    assert plane.get_ylabel() == "forcing amplitude (dimensionless)"
    assert [text.get_text() for text in plane.texts] == ["1:4"]
    with pytest.raises(pc.ParameterError, match="the coordinates are 0 to 1"):
        plotting.plot_branch(branch, new_axes(), coordinate=2)
