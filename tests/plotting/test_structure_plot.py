"""Pictures of structures: what of a run concerns a direction, and the shapes of modes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.mathtext import MathTextParser
from tests.plotting.axes import new_axes

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
    assert head == "t,x0,x1,x2,v0,v1,v2,stop_force_0,stop_force_1,stop_force_2"
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
    assert {line.get_label() for line in below.lines} >= {"stable", "unstable", "torus"}
    assert below.get_xlabel() == plane.get_xlabel()
    assert plane.get_xlabel() == r"forcing frequency $\omega$ (dimensionless)"
    assert plane.get_ylabel() == "forcing amplitude (dimensionless)"
    assert [text.get_text() for text in plane.texts] == ["1:4"]
    with pytest.raises(pc.ParameterError, match="the coordinates are 0 to 1"):
        plotting.plot_branch(branch, new_axes(), coordinate=2)


def test_an_unnamed_line_is_that_of_the_first_stop() -> None:
    named, unnamed = (
        plotting.plot_displacement(RUN, new_axes(), on=on).lines[0].get_xydata() for on in (0, None)
    )
    np.testing.assert_array_equal(np.asarray(named), np.asarray(unnamed))
    assert type(RUN).picture == "plot_motion"
    assert plotting.plot_motion(RUN, plotting.offscreen_figure(), on=2, title="t").axes


def test_impacts_have_the_numbers_of_their_stops_and_the_velocities_of_their_line() -> None:
    every = plotting.plot_impact_velocities(RUN, new_axes())
    relative = plotting.plot_impact_velocities(RUN, new_axes(), on=(-1, 1, 0))

    labels = {str(line.get_label()) for line in every.lines}
    assert labels == {"impact on stop 0", "impact on stop 1", "entry into stop 2"}
    hits = RUN.impacts.stop == 1
    points = np.asarray(relative.collections[0].get_offsets())
    # Stop 1 acts on 2 (x0 - x1).
    np.testing.assert_allclose(
        np.sort(points[:, 1]), np.sort(-0.5 * RUN.impacts.v_after[hits]), rtol=1e-12
    )
    entries = plotting.plot_impact_velocities(RUN, new_axes(), on=(0, 0, -3))
    speeds = RUN.crossings.v[RUN.crossings.direction == "in"]
    drawn = np.asarray(entries.collections[0].get_offsets())[:, 1]
    np.testing.assert_allclose(np.sort(drawn), np.sort(-3 * speeds), rtol=1e-11)


def test_a_pair_of_coordinates_is_drawn_over_each_other_with_the_stops_of_both() -> None:
    ax = plotting.plot_phase_portrait(RUN, new_axes(), on=0, against=2, window=(0, 10))

    x, y = np.asarray(ax.lines[0].get_xydata()).T
    assert x[0] == RUN(0.0)[0][0]
    # Chords of 1/64 of the quickest cycle.
    assert np.abs(y).max() > 0.9988 * np.abs(RUN(np.linspace(0, 10, 400))[0][:, 2]).max()
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "displacement $x_{0}$ (dimensionless)", "displacement $x_{2}$ (dimensionless)",
    )  # fmt: skip
    assert {"wall", "soft stop", "start"} <= set(ax.get_legend_handles_labels()[1])


def test_points_are_drawn_where_the_structure_has_some() -> None:
    mass = [1, 1]
    beam = pc.Structure(mass, [[2, -1], [-1, 1]], points={"tip": (0, 1)})
    run = pc.simulate(beam, v0=[0, 1], t_end=3)
    for on in (None, "tip"):
        figure = plotting.plot_coordinates(run, plotting.offscreen_figure(), on=on)
        assert [ax.get_ylabel() for ax in figure.axes] == [r"$\text{tip}$"]
    modes = plotting.plot_mode_shapes(beam, plotting.offscreen_figure(), on=[1, "tip"])
    first, second = np.asarray(modes.axes[0].lines[1].get_xydata())[:, 1]
    assert first == second == 1.0
    assert [text.get_text() for text in modes.axes[-1].get_xticklabels()] == [
        "$x_{1}$", r"$\text{tip}$",
    ]  # fmt: skip


def test_an_orbit_is_drawn_along_a_line_and_its_formal_part_faint() -> None:
    wall = pc.Wall(at="0.5", side="above", restitution="0.7", on=1)
    two = pc.chain([1, 1], [1, 1, 1], dashpots="0.2", stops=[wall])
    orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine("1.4", amplitude="0.8")}))
    ax = plotting.plot_orbit(orbit, new_axes(), on=(1, -1))
    assert ax.get_xlabel() == "displacement $x_{0} - x_{1}$ (dimensionless)"
    assert ax.get_title() == f"1 impact in 1 forcing period, T = {orbit.period:.6g}, asymptotic"
    (jump,) = ax.collections
    ((place, low), (_, high)) = np.asarray(jump.get_paths()[0].vertices)
    x, _ = orbit.run(orbit.run.impacts.t[0])
    assert place == pytest.approx(x[0] - x[1], abs=1e-14)
    kick = orbit.run.impacts.v_after - orbit.run.impacts.v_before
    assert high - low == pytest.approx(abs(float(kick[0])), rel=1e-12)
    branch = pc.continue_orbit(orbit, over={"loads.0.amplitude": (0.8, 0.3)})
    formal = [each for each in branch.orbits if not each.admissible]
    faint = plotting.plot_orbit(formal[-1], new_axes())
    assert "not physical" in faint.get_title()
    (beyond,) = (line for line in faint.lines if line.get_label() == "passes through a stop")
    assert np.nanmin(np.asarray(beyond.get_xydata())[5:-5, 0]) > 0.4


def test_multipliers_of_a_branch_are_joined_to_their_nearest() -> None:
    orbit = pc.find_orbit(PAIR, pc.Loads({1: pc.cosine("0.60", amplitude="0.1")}))
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.59, 0.61)}, largest_step=0.2)
    assert branch.path == "loads.0.omega"
    ax = plotting.plot_multipliers(branch, new_axes())
    lines = [c for c in ax.collections if hasattr(c, "get_segments")]
    assert len(lines) == 4
    for line in lines:
        for piece in line.get_segments():
            assert np.abs(np.diff(piece, axis=0)).max() < 0.2
    tip = plotting.plot_branch(branch, new_axes(), on=(1, -1))
    assert tip.get_ylabel() == "amplitude of $x_{0} - x_{1}$ (dimensionless)"
    drawn = np.concatenate([np.asarray(line.get_ydata()) for line in tip.lines])
    x = branch.orbits[0].run(np.linspace(0, branch.orbits[0].period, 2000))[0]
    relative = x[:, 0] - x[:, 1]
    assert np.abs(drawn - 0.5 * np.ptp(relative)).min() < 1e-4
    with pytest.raises(pc.ParameterError, match="given together with on"):
        plotting.plot_branch(branch, new_axes(), on=0, coordinate=1)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("plot_staircase", "spacing = None: a structure has several resonant frequencies"),
        ("plot_spectrum", "the coordinates are 0 to 2; give one, or a direction"),
        ("plot_manifolds", "not a Manifolds$"),
        ("plot_singularity_set", "not a SingularitySet, which structures do not have"),
        ("plot_velocity_gap", "not a VelocityGap, which structures do not have"),
        ("plot_enclosure", "not a certified run"),
        ("plot_profiles", "not a Fit$"),
        ("plot_fit", "not a Fit$"),
        ("plot_confidence", "not a Fit$"),
        ("plot_design", "not a Design$"),
        ("plot_pareto", "not a ParetoFront$"),
        ("plot_fractions", "no table; give the whole Dataset that percuss.basin_fractions returns"),
        ("plot_basins", "give the whole Dataset that percuss.basins returns"),
        ("plot_sweep", "give the whole Dataset that percuss.sweep returns"),
        ("plot_chart", "give the whole Dataset that percuss.sweep returns"),
        ("plot_diagram", "give the whole Dataset that percuss.bifurcation_diagram returns"),
        ("plot_branch", "neither a branch nor a list of branches"),
        ("plot_curves", "neither a curve nor a list of curves"),
        ("plot_response", "not a Response$"),
    ],
)
def test_what_is_not_drawn_of_a_run_is_one_sentence(name: str, message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message) as refused:
        getattr(plotting, name)(RUN)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 300


@pytest.mark.parametrize("name", ["tip_mass", "tip mass", "50 % span", "a$b", "x^2", "a\\b", "}{"])
def test_a_point_is_labelled_by_its_name_as_it_is_written(name: str) -> None:
    structure = pc.Structure([1, 1], [1, 1], points={name: [1, 0]})
    run = pc.simulate(structure, v0=[1, 0], t_end=3)

    label = plotting.plot_displacement(run, new_axes(), on=name).get_ylabel().split("\n")[0]

    glyphs = MathTextParser("path").parse(label).glyphs
    assert "".join(chr(glyph[2]) for glyph in glyphs) == f"displacement {name}"


def test_a_run_without_length_is_drawn() -> None:
    # Its first step is shorter than the rounding of any time.
    stop = pc.SoftStop(at="0.03", side="above", stiffness=2000, on=(10**30, 0, 1))
    structure = pc.chain([2, 1, 1], [3, 2, 1, 2], stops=[stop])
    run = pc.simulate(structure, LOADS, t_end=10, progress=lambda *_: False)
    assert run.t_end == run.t0

    ax = plotting.plot_displacement(run, new_axes(), on=1)

    assert len(ax.lines) > 0
