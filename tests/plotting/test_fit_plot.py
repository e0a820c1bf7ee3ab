"""Pictures of fits."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss import plotting

GAP, RESTITUTION = "oscillator.stops.0.at", "oscillator.stops.0.restitution"


@pytest.fixture(scope="module")
def fit() -> pc.Fit:
    rig = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    t = np.linspace(0, 20, 200)
    x, v = pc.simulate(rig, pc.cosine(2), v0=0.5, t_end=20)(t)
    random = np.random.default_rng(0)
    data = {"t": t, "displacement": x + 0.01 * random.standard_normal(200), "velocity": v}
    noise = {"displacement": 0.01, "velocity": 0.02}
    free = {GAP: 0.22, RESTITUTION: 0.75}
    return pc.fit(data, rig, pc.cosine(2), free=free, noise=noise)


def test_record_residuals_impacts_and_ellipse_are_drawn(fit: pc.Fit) -> None:
    above, middle, below, beside = plotting.plot_fit(fit).axes
    samples, motion = above.get_lines()
    (impacts,) = middle.get_lines()
    np.testing.assert_allclose(samples.get_ydata(), fit.residuals.value.values[::2])
    np.testing.assert_allclose(impacts.get_xdata(), fit.impacts, rtol=1e-12)
    at_wall = fit.run.impacts
    np.testing.assert_allclose(impacts.get_ydata(), np.abs(at_wall.v_before), atol=1e-6)
    assert np.ptp(np.asarray(motion.get_xdata())) == pytest.approx(20)
    residuals = np.asarray(below.get_lines()[-1].get_ydata())
    assert np.mean(residuals**2) == pytest.approx(1, abs=0.4)
    # The outer region is as wide as the 95 % of two parameters.
    outer = np.asarray(beside.patches[0].get_path().vertices)[:, 0]
    assert np.ptp(outer) == pytest.approx(2 * np.sqrt(5.9915) * fit.errors[GAP], rel=1e-3)


def test_another_quantity_and_a_window(fit: pc.Fit) -> None:
    figure = plotting.plot_fit(
        fit, quantity="velocity", window=(5, 10), parameters=(RESTITUTION, GAP)
    )
    assert figure.axes[0].get_ylabel() == "velocity\n(dimensionless)"
    assert figure.axes[0].get_xlim() == (5, 10)
    assert "restitution" in figure.axes[3].get_xlabel()


def test_one_parameter_has_no_ellipse_and_impact_times_have_flights() -> None:
    ball = pc.Oscillator(0, stops=(pc.Wall(at=0, side="below", restitution="0.7"),))
    heard = 0.5 + np.concatenate([[0], np.cumsum(0.8 ** np.arange(8))])
    fit = pc.fit({"impact_times": heard}, ball, pc.Forcing(constant=-10), free={RESTITUTION: 0.7})
    figure = plotting.plot_fit(fit)
    assert len(figure.axes) == 3
    np.testing.assert_allclose(figure.axes[0].get_lines()[0].get_ydata(), np.diff(heard)[1:])


def test_another_record_and_entries_into_a_soft_stop() -> None:
    stop = pc.SoftStop(at="0.2", side="above", stiffness=20)
    rig = pc.Oscillator(damping="0.05", stops=(stop,))
    t = np.linspace(0, 10, 80)
    data = [
        {"t": t, "displacement": pc.simulate(rig, pc.cosine(2), v0=v0, t_end=10)(t)[0]}
        for v0 in (0.5, -0.3)
    ]
    fit = pc.fit(data, rig, pc.cosine(2), free={GAP: 0.22}, noise=0.01)

    above, middle, _ = plotting.plot_fit(fit, record=1).axes

    samples, motion = above.get_lines()
    np.testing.assert_array_equal(samples.get_ydata(), data[1]["displacement"])
    drawn = np.interp(t, np.asarray(motion.get_xdata()), np.asarray(motion.get_ydata()))
    np.testing.assert_allclose(drawn, data[1]["displacement"], atol=1e-3)
    (entries,) = middle.get_lines()
    assert entries.get_fillstyle() == "none"
    with pytest.raises(pc.ParameterError, match="none of the 2 records, counted from 0"):
        plotting.plot_fit(fit, record=2)


def test_a_parameter_with_a_name_of_its_own_stands_on_the_axis() -> None:
    k = pc.parameter("k", 1.2)
    t = np.linspace(0, 20, 100)
    x = np.exp(-0.05 * t) * np.cos(t) + 0.01 * np.sin(37 * t**2)
    data = {"t": t, "displacement": x}
    fit = pc.fit(data, pc.Oscillator(k, "0.04"), free={"k": 1.1, "oscillator.damping": 0.04})
    beside = plotting.plot_fit(fit).axes[-1]
    assert beside.get_xlabel() == "k"
    assert plotting.plot_profiles(fit, parameters=["k"], n=3).axes[0].get_xlabel() == "k"


def test_profiles_stand_beside_the_parabolas_of_the_errors(fit: pc.Fit) -> None:
    figure = plotting.plot_profiles(fit, parameters=[GAP], n=5)
    (ax,) = figure.axes
    parabola, profile, points = ax.get_lines()[:3]
    np.testing.assert_allclose(np.asarray(points.get_ydata())[2], 0, atol=1e-6)
    np.testing.assert_allclose(points.get_ydata(), [9, 2.25, 0, 2.25, 9], rtol=0.15, atol=1e-6)
    np.testing.assert_allclose(profile.get_ydata(), parabola.get_ydata(), rtol=0.2, atol=0.1)
    assert list(fit.profiles) == [GAP]
    # Those that were asked for are drawn, and not fitted again.
    assert len(plotting.plot_profiles(fit).axes) == 1
    with pytest.raises(pc.ParameterError, match="none of the fitted parameters"):
        plotting.plot_profiles(fit, parameters=["oscillator.damping"])


def test_faults(fit: pc.Fit) -> None:
    with pytest.raises(pc.ParameterError, match="not a Fit"):
        plotting.plot_fit(None)
    with pytest.raises(pc.ParameterError, match="none of those measured: displacement, velocity"):
        plotting.plot_fit(fit, quantity="acceleration")
    with pytest.raises(pc.ParameterError, match="none of the fitted parameters"):
        plotting.plot_fit(fit, parameters=(GAP, "oscillator.damping"))


def test_all_pairs_of_parameters_have_their_regions(fit: pc.Fit) -> None:
    free = {**fit.values, "oscillator.damping": 0.05}
    t, noise = fit.residuals.t.values[::2], {"displacement": 0.01}
    data = {"t": t, "displacement": fit.residuals.value.values[::2]}
    three = pc.fit(data, fit.oscillator, pc.cosine(2), free=free, noise=noise)

    axes = plotting.plot_confidence(three).axes

    assert [ax.get_ylabel().split()[:1] for ax in axes] == [["restitution"], ["damping"], []]
    for ax, pair in zip(axes, ((0, 1), (0, 2), (1, 2)), strict=True):
        shared = three.covariance[np.ix_(pair, pair)]
        outer = np.asarray(ax.patches[0].get_path().vertices)
        sizes = 2 * np.sqrt(5.9915 * np.diag(shared))
        np.testing.assert_allclose(np.ptp(outer, axis=0), sizes, rtol=1e-3)
        correlation = shared[0, 1] / np.sqrt(shared[0, 0] * shared[1, 1])
        assert ax.get_title() == f"correlation {correlation:.2f}"
    (only,) = plotting.plot_confidence(fit).axes
    assert "correlation" in only.get_title()
    for wrong, words in (
        ([GAP], "1 with an error; a region of confidence needs two"),
        ([GAP, "oscillator.damping"], "none of the fitted parameters"),
    ):
        with pytest.raises(pc.ParameterError, match=words):
            plotting.plot_confidence(fit, parameters=wrong)
