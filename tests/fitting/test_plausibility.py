"""What is found wrong with measurements before or after a fit, in the words that say what to do."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.fitting.test_data import GAP, RESTITUTION, fitted, record

import percuss as pc


def test_a_record_at_rest_is_refused() -> None:
    data = record()
    data["displacement"][:] = 0.1
    with pytest.raises(pc.ParameterError, match=r"data\.displacement = 0\.1: the same at all inst"):
        fitted(data)
    # One that moves beside it tells enough.
    both = fitted([data, record()], start=[(0.1, 0), "free"], noise=None)
    assert set(both.residuals.record.values) == {0, 1}


@pytest.mark.parametrize("side", ["above", "below"])
def test_forces_of_a_stop_with_the_wrong_sign_are_refused(side: Any) -> None:
    towards = 1 if side == "above" else -1
    stop = pc.SoftStop(at=0.2 * towards, side=side, stiffness=20, damping="0.1")
    osc = pc.Oscillator(damping="0.05", stops=(stop,))
    t = np.linspace(0, 20, 200)
    run = pc.simulate(osc, pc.cosine(2), v0=0.3, t_end=20)
    force = run.forces(t).stops.values[0]
    assert (force * towards <= 0.1).all()
    free = {"oscillator.stops.0.stiffness": 18.0}
    right = pc.fit({"t": t, "stop_force": force}, osc, pc.cosine(2), free=free, noise=0.01)
    assert right.values["oscillator.stops.0.stiffness"] == pytest.approx(20, rel=1e-6)
    sign = "negative" if side == "above" else "positive"
    with pytest.raises(
        pc.ParameterError, match=f"stop {side} on the mass is {sign}: turn the sign"
    ):
        pc.fit({"t": t, "stop_force": -force}, osc, pc.cosine(2), free=free, noise=0.01)
    # Noise about zero, without a contact, has no sign.
    noise = 0.01 * np.random.default_rng(1).standard_normal(200)
    silent = pc.fit({"t": t, "stop_force": noise}, osc, pc.cosine(2, "0.01"), free=free, noise=0.01)
    assert len(silent.impacts) == 0


def test_times_in_another_unit_are_refused() -> None:
    data = record()
    data["t"] = 1000 * data["t"]
    with pytest.raises(pc.ParameterError, match=r"0\.042 samples in a period of the force, 3\.14"):
        fitted(data)


def test_samples_too_coarse_to_show_the_motion_say_so_unless_their_noise_is_known() -> None:
    data = {name: column[::20] for name, column in record().items()}
    fit = fitted(data, noise=None)
    assert not fit.converged
    assert "samples in a period of the force do not show the motion" in fit.reason
    known = fitted(data, free={GAP: 0.201, RESTITUTION: 0.79}, start=(0, 0.5))
    assert known.converged
    assert known.values[GAP] == pytest.approx(0.2, abs=5 * known.errors[GAP])


def test_a_guess_of_a_phase_is_one_of_a_whole_turn() -> None:
    osc = pc.impact_oscillator("0.65", wall="0.8", side="above", damping="0.02")
    t = np.linspace(0, 20, 400)
    x, v = pc.simulate(osc, pc.cosine("1.2", phase="2.9"), x0="0.3", t_end=20)(t)
    a = -0.04 * v - x + np.cos(1.2 * t + 2.9)
    a += 0.02 * np.random.default_rng(2).standard_normal(len(t))
    model = pc.impact_oscillator("0.5", wall="1", side="above", damping="0.02")
    free: dict[str, Any] = {GAP: (0.3, 2.0), RESTITUTION: (0.3, 0.95), "forcing.phase": 0.0}
    fit = pc.fit({"t": t, "acceleration": a}, model, pc.cosine("1.2"), free=free)
    for path, true in ((GAP, 0.8), (RESTITUTION, 0.65), ("forcing.phase", 2.9)):
        away = math.remainder(fit.values[path] - true, 2 * math.pi)
        assert abs(away) < 5 * fit.errors[path]
    assert fit.converged
    assert fit.at_bounds == ()


def test_data_beyond_the_samples_of_a_force_are_told_where_no_motion_fits() -> None:
    """As of two loggers whose clocks differ."""
    osc, instants = pc.Oscillator(4, "0.1"), np.linspace(0, 6, 40)
    push = 3 * np.random.default_rng(1).standard_normal(40)
    t = np.linspace(0, 6, 45)
    x, _ = pc.simulate(osc, pc.record(instants, push), t_end=6)(t)
    data, cut = {"t": t, "displacement": x}, pc.record(instants[:20], push[:20])
    fit = pc.fit(data, osc, cut, free={"oscillator.damping": 0.1}, start=(0, 0), noise=1e-3)
    assert not fit.converged
    assert fit.reason.endswith("; of the force the record lasts from t = 0 to 2.92308, its end values "
                               "hold beyond")  # fmt: skip
    whole = pc.record(instants, push)
    assert pc.fit(data, osc, whole, free={"oscillator.damping": 0.1}, noise=1e-3).reason == ""


@pytest.mark.parametrize("kind", ["oscillator", "structure"])
def test_samples_between_knots_of_a_force_may_be_on_the_other_side_of_an_impact(kind: str) -> None:
    """Force and acceleration on one time base: between an impact and a sample next to it is a knot."""
    rng = np.random.default_rng(2)
    t = np.arange(0, 2.0, 1e-3)
    push = 60 * np.sin(2 * np.pi * (6 * t + 3 * t**2)) + 5 * rng.standard_normal(t.size)
    force: Any = pc.record(t, push)
    wall = pc.Wall(0.004, "above", 0.62)
    rig: Any = pc.Oscillator.from_mass(2.5, stiffness=9e3, damping_coefficient=25.0, stops=(wall,))
    model, column = "oscillator", "acceleration"
    if kind == "structure":
        rig = pc.Structure(
            mass=[2.5], stiffness=[9e3], damping=[25.0], stops=[pc.Wall(0.004, "above", 0.62, on=0)]
        )
        force, model, column = {0: force}, "structure", "acceleration_0"
    instants = t[:-100]
    run = pc.simulate(rig, force, t_end=1.9)
    exact = run.acceleration(*(() if kind == "oscillator" else (0,)), instants)
    a = np.ravel(exact) + 0.8 * rng.standard_normal(instants.size)
    free = {f"{model}.stops.0.at": 0.004, f"{model}.stops.0.restitution": 0.62}
    fit = pc.fit({"t": instants, column: a}, rig, force, free=free, start=(0, 0))
    assert fit.converged
    assert float(np.abs(fit.residuals.residual.values).max()) < 5.0
