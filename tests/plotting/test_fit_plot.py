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
    above, below, beside = plotting.plot_fit(fit).axes
    samples, motion, impacts = above.get_lines()
    np.testing.assert_allclose(samples.get_ydata(), fit.residuals.value.values[::2])
    np.testing.assert_array_equal(impacts.get_xdata(), fit.impacts)
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
    assert figure.axes[0].get_ylabel() == "velocity (dimensionless)"
    assert figure.axes[0].get_xlim() == (5, 10)
    assert "restitution" in figure.axes[2].get_xlabel()


def test_one_parameter_has_no_ellipse_and_impact_times_have_flights() -> None:
    ball = pc.Oscillator(0, stops=(pc.Wall(at=0, side="below", restitution="0.7"),))
    heard = 0.5 + np.concatenate([[0], np.cumsum(0.8 ** np.arange(8))])
    fit = pc.fit({"impact_times": heard}, ball, pc.Forcing(constant=-10), free={RESTITUTION: 0.7})
    figure = plotting.plot_fit(fit)
    assert len(figure.axes) == 2
    np.testing.assert_allclose(figure.axes[0].get_lines()[0].get_ydata(), np.diff(heard)[1:])


def test_faults(fit: pc.Fit) -> None:
    with pytest.raises(pc.ParameterError, match="not a Fit"):
        plotting.plot_fit(None)
    with pytest.raises(pc.ParameterError, match="none of those measured: displacement, velocity"):
        plotting.plot_fit(fit, quantity="acceleration")
    with pytest.raises(pc.ParameterError, match="none of the fitted parameters"):
        plotting.plot_fit(fit, parameters=(GAP, "oscillator.damping"))
