"""The picture of a certified run: the motion, and how its radius grows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Circle

import percuss as pc
from percuss.errors import ParameterError
from percuss.plotting import Units, offscreen_figure, plot_enclosure

pytest.importorskip("flint")

Line = tuple[np.ndarray, np.ndarray]


def drawn(
    proven: pc.certified.CertifiedRun | pc.certified.CertifiedOrbit,
) -> tuple[Axes, dict[str, Line]]:
    figure = offscreen_figure()
    ax = plot_enclosure(proven, figure.add_subplot(), units=Units("mm", "s"))
    figure.canvas.draw()
    lines = {str(line.get_label()): line for axes in figure.axes for line in axes.lines}
    points = {
        name: (np.asarray(line.get_xdata()), np.asarray(line.get_ydata()))
        for name, line in lines.items()
    }
    return ax, points


def test_chaos_is_a_rise_at_the_rate_of_its_exponent() -> None:
    osc = pc.impact_oscillator("0.8", side="above")
    run = pc.simulate(osc, pc.cosine("2.8"), v0=-1, max_impacts=60)
    proven = pc.certify(run)

    ax, lines = drawn(proven)

    t, x = lines["motion"]
    np.testing.assert_allclose(x[t < 20], run(t[t < 20])[0], atol=1e-9)
    times, radii = lines["of impacts"]
    np.testing.assert_array_equal(times, proven.impacts.t.mid())
    assert radii[-1] == pytest.approx(math.log10(float(proven.impacts.t[59].arb.rad())), abs=1e-6)
    assert radii[-1] - radii[0] > 6
    assert np.polyfit(*lines["of impacts"], 1)[0] > 0.03
    assert ax.get_xlabel() == "time $t$ (s)"


def test_motion_lies_above_the_radii() -> None:
    ax, lines = drawn(pc.certify(pc.simulate(pc.impact_oscillator(), v0=1, t_end=9.0)))

    upper, lower = ax.figure.axes
    x, radii = lines["motion"][1], lines["radius of $x$"][1]
    lowest = upper.transData.transform([(0.0, x.min())])[0, 1]
    highest = lower.transData.transform([(0.0, np.nanmax(radii))])[0, 1]
    assert highest < lowest


def test_end_of_a_proof_at_a_graze_is_marked() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2", wall=-1), x0=1, t_end=20.0)

    _, lines = drawn(pc.certify(run, most_bits=256))

    assert lines["graze"][0] == pytest.approx([np.pi])
    assert lines["the proof ends"][0] == pytest.approx([np.pi, np.pi])


def test_radii_below_the_least_float_are_drawn() -> None:
    _, lines = drawn(pc.certify(pc.simulate(pc.impact_oscillator(), x0=1, t_end=1.0), 400))

    radii = lines["radius of $x$"][1]
    assert np.nanmin(radii) > -450
    assert np.nanmax(radii) < -400


def test_rest_for_ever_ends_in_a_contact() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2"), pc.Forcing(constant=-1), x0=1, t_end=50.0)

    _, lines = drawn(pc.certify(run))

    assert lines["contact"][0] == pytest.approx(run.contacts.start)
    assert lines["motion"][0][-1] > run.contacts.start[0]


def test_entries_into_soft_stops_are_marked() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=9), v0=1, t_end=12.0)

    _, lines = drawn(pc.certify(run))

    np.testing.assert_allclose(lines["of crossings"][0], run.crossings.t, atol=1e-12)


def test_a_thousand_impacts_take_no_more_points_than_are_seen() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.45", max_impacts=1000)

    _, lines = drawn(pc.certify(run))

    assert len(lines["motion"][0]) <= 6001


def test_a_float_run_is_refused() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=1.0)

    with pytest.raises(ParameterError, match=r"percuss.certify\(run\) makes one"):
        plot_enclosure(run)


def test_an_orbit_is_drawn_with_its_multipliers_in_the_circle() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    proven = pc.certify(orbit)

    ax, lines = drawn(proven)

    portrait, circle, radii = ax.figure.axes
    x, v = lines["orbit"]
    run = orbit.trajectory()
    t = proven.t0.mid() + np.linspace(0.01, 0.99, 5) * orbit.period
    for place, speed in zip(*run(t), strict=True):
        assert np.hypot(x - place, v - speed).min() < 0.03
    assert (
        portrait.get_title()
        == "proven: alone with these events, passes through no stop, asymptotic"
    )
    middles = sorted(patch.center[1] for patch in circle.patches[1:] if isinstance(patch, Circle))
    assert middles == pytest.approx(sorted(m.imag.mid() for m in proven.multipliers))
    assert "radius at most" in circle.get_xlabel()
    assert lines["radius of $x$"][1].max() < -20
    assert radii.get_xlabel() == "time (s)"


def test_a_multiplier_whose_ball_touches_the_circle_is_neither_in_nor_out() -> None:
    family = pc.find_orbit(
        pc.impact_oscillator(), pc.sine(3), n_impacts=6, n_periods=6, guess=(0.0, 0.45)
    )
    unstable = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.8"))
    colours = []
    for orbit in (family, unstable):
        ax, _ = drawn(pc.certify(orbit))
        colours.append([patch.get_facecolor()[:3] for patch in ax.figure.axes[1].patches[1:]])

    black, others = colours
    assert black == [(0.0, 0.0, 0.0)] * 2
    assert others[0] != others[1]
    assert (0.0, 0.0, 0.0) not in others


def test_special_points_stand_below_their_branch() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.3, 2.8)})
    points = [pc.certify(point) for point in branch.special_points]
    figure = offscreen_figure()

    ax = plot_enclosure(points, figure.add_subplot(), branch=branch)
    figure.canvas.draw()

    lower = figure.axes[1]
    assert lower.get_xlabel() == r"forcing frequency $\omega$ (dimensionless)"
    texts = [text.get_text() for text in lower.texts]
    assert any(text.startswith("[2.653347727855") for text in texts)
    assert lower.get_xlim() == ax.get_xlim()
    with pytest.raises(ParameterError, match="branch of the special points is needed"):
        plot_enclosure(points)


def test_an_orbit_that_is_not_proven_is_refused() -> None:
    family = pc.find_orbit(
        pc.impact_oscillator(), pc.sine(3), n_impacts=6, n_periods=6, guess=(0.0, 0.45)
    )
    open_ = pc.certify(family, over={"forcing.amplitude": (1, "1.001")}, most_bits=64)

    with pytest.raises(ParameterError, match="not proven"):
        plot_enclosure(open_)


def test_strips_of_a_branch_are_drawn_at_their_size_with_what_lies_on_it() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.65"))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.645, 2.66)})
    proven = pc.certify(branch)

    ax = plot_enclosure(proven, offscreen_figure().add_subplot())

    assert len(ax.patches) == len(proven)
    for row in range(0, len(branch), 7):
        at = branch.values[row], float(branch.orbits[row].itinerary.vector[2])
        assert any(patch.get_path().contains_point(at, radius=1e-9) for patch in ax.patches), row
    assert "period doubling\n[2.6533" in ax.texts[0].get_text()
    assert ax.get_title() == f"proven in {len(proven)} strips, from end to end"
    names = {str(line.get_label()) for line in ax.lines}
    assert {"asymptotically stable", "unstable", "stability open"} <= names

    nothing = pc.certify(branch, progress=lambda *_: False)
    assert plot_enclosure(nothing, offscreen_figure().add_subplot()).get_title().endswith("gaps")
