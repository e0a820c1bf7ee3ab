"""The runs from nodes: their samples and derivatives, against differences and against `simulate`."""

from __future__ import annotations

import dataclasses
from functools import partial

import numpy as np
import pytest
from tests.fitting.differences import assert_derivatives_are_those_of_differences

import percuss as pc
from percuss.arrays import Floats
from percuss.fitting.effort import Effort
from percuss.fitting.measured import MeasuredRecord, read_samples
from percuss.fitting.shooting import Layout, Shots, shoot

T = np.linspace(0, 9, 181)
FORCE = pc.cosine("1.7", amplitude="1.3") + pc.Forcing(constant="-0.6")
WALL = pc.Oscillator.from_mass(
    2, stiffness=3, damping_coefficient="0.4",
    stops=(pc.Wall(at="0.35", side="above", restitution="0.7"),),
)  # fmt: skip
SOFT = pc.Oscillator.from_mass(
    2, stiffness=3, damping_coefficient="0.4",
    stops=(pc.SoftStop(at="0.15", side="above", stiffness=40, damping=3),),
)  # fmt: skip
RESTING = pc.impact_oscillator("0.2", wall=0, side="below", damping="0.1")
NODES = np.array([[0.1, 0.9], [-0.2, 0.6], [0.05, -0.5]])
AT, STIFFNESS = "oscillator.stops.0.at", "oscillator.stops.0.stiffness"
PATHS = {
    "wall": (AT, "oscillator.stops.0.restitution", "oscillator.mass", "forcing.omega"),
    "soft": (AT, STIFFNESS, "oscillator.stops.0.damping", "oscillator.mass", "oscillator.damping"),
    "resting": (AT, "oscillator.damping", "forcing.amplitude"),
}
MODELS = {"wall": WALL, "soft": SOFT, "resting": RESTING}


def shots(model: str, quantity: str, values: Floats, nodes: Floats) -> Shots:
    data = {"t": T, quantity: np.zeros(len(T))}
    samples, impacts = read_samples(data, 1.0, MODELS[model])
    spans = np.array([[0, 3.01], [3.01, 6.02], [6.02, 9]])
    first = np.append(np.searchsorted(T, spans[:, 0]), len(T))
    layout = Layout(MeasuredRecord(samples, impacts, FORCE, None), spans, first, False)
    named = dict(zip(PATHS[model], values.tolist(), strict=True))
    return shoot(MODELS[model], (layout,), named, nodes)


def setting(model: str) -> Floats:
    found = {
        "wall": (0.35, 0.7, 2, 1.7), "soft": (0.15, 40, 3, 2, 0.4), "resting": (0, 0.1, 1.3),
    }  # fmt: skip
    return np.array(found[model], dtype=np.float64)


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration", "stop_force"])
@pytest.mark.parametrize("model", list(MODELS))
def test_derivatives_of_samples_and_ends_are_those_of_differences(
    model: str, quantity: str
) -> None:
    values, nodes = setting(model), NODES.copy()
    if model == "resting":
        nodes = np.array([[0.1, -0.9], [0.02, 0.1], [0.05, -0.5]])
    found = shots(model, quantity, values, nodes)
    assert found.is_complete
    assert found.counts.sum() >= 2
    assert_derivatives_are_those_of_differences(
        partial(shots, model, quantity), values, nodes, near=2e-6
    )


def test_a_segment_is_the_run_from_its_node() -> None:
    found = shots("soft", "stop_force", setting("soft"), NODES)
    run = pc.simulate(SOFT, FORCE, x0=0.1, v0=0.9, t_end=3.01)
    inside = T[T < 3.01]
    forces = run.forces(inside)
    np.testing.assert_allclose(found.values[: len(inside), 0], forces.stops.values[0], atol=1e-12)
    acceleration = shots("soft", "acceleration", setting("soft"), NODES).values[: len(inside), 0]
    whole = sum(forces[name].values for name in ("spring", "damping", "forcing"))
    np.testing.assert_allclose(acceleration, (whole + forces.stops.values[0]) / 2, atol=1e-12)
    np.testing.assert_allclose(found.ends[0], [float(part) for part in run(3.01)], atol=1e-12)


def test_beside_an_impact_the_other_side_is_the_flight_continued() -> None:
    """Where two flights meet both have the wall's place, and velocities in the ratio -r."""
    found = shots("wall", "velocity", setting("wall"), NODES)
    nearest = int(np.argmin(found.away))
    own, other = found.values[nearest]
    assert found.away[nearest] < 0.02
    ratio = min(own, other) / max(own, other)
    assert ratio == pytest.approx(-0.7, abs=0.1)


def test_a_node_behind_a_wall_is_moved_onto_it() -> None:
    nodes = NODES.copy()
    nodes[1] = 0.6, -0.4
    found = shots("wall", "displacement", setting("wall"), nodes)
    assert found.nodes[1].tolist() == [0.35, -0.4]
    # It then moves with the wall, and not with the state.
    assert (found.end_rows[1, :, 4] == 0.0).all()
    values = setting("wall")
    values[0] += 1e-6
    nodes[1, 0] = 0.6
    moved = shots("wall", "displacement", values, nodes)
    assert moved.nodes[1, 0] == values[0]
    slope = (moved.ends[1] - found.ends[1]) / 1e-6
    np.testing.assert_allclose(found.end_rows[1, :, 0], slope, rtol=1e-4)


def test_a_motion_that_cannot_be_followed_is_told() -> None:
    nodes = NODES.copy()
    nodes[0, 1] = np.inf
    assert not shots("wall", "displacement", setting("wall"), nodes).is_complete
    assert dataclasses.is_dataclass(Shots)


RIG = pc.Oscillator(
    damping="0.05",
    stops=(
        pc.Wall(at=-1, side="below", restitution="0.8"),
        pc.Wall(at="0.2", side="above", restitution="0.8"),
    ),
)


def layout_of(t: Floats, spans: Floats) -> Layout:
    samples, impacts = read_samples({"t": t, "displacement": np.zeros(len(t))}, 1.0, RIG)
    first = np.append(np.searchsorted(t, spans[:, 0]), len(t))
    return Layout(MeasuredRecord(samples, impacts, pc.cosine(2), None), spans, first, False)


def test_a_run_returns_to_its_caller_and_goes_on_in_the_midst_of_a_segment() -> None:
    """Some thousand impacts take several calls, and end where those of one run end."""
    t = np.linspace(0, 12000, 9)
    layout = layout_of(t, np.array([[0, 5900], [5900, 12000]], dtype=np.float64))
    asked = []

    def ask() -> bool:
        asked.append(1)
        return True

    effort = Effort(ask)
    nodes = np.array([[0, 0.5], [-0.2, 0.6]])
    long = shoot(RIG, (layout,), {"oscillator.damping": 0.05}, nodes, effort)
    assert long.is_complete
    assert len(asked) > 2
    assert effort.made_in_run >= long.counts.sum() > 1000
    run = pc.simulate(RIG, pc.cosine(2), v0=0.5, t_end=5900)
    np.testing.assert_allclose(long.values[:4, 0], run(t[:4])[0], rtol=0, atol=1e-9)
    refused = shoot(RIG, (layout,), {}, nodes, Effort(lambda: False))
    assert (refused.counts < 0).any()
    assert not refused.is_complete


def test_motions_that_cost_too_much_are_not_followed() -> None:
    """At critical damping the motion decays at once, but its derivatives take 1e11 steps.

    Far above it the fast decay is over after a few.
    """
    t = np.linspace(0, 9, 41)
    layout = layout_of(t, np.array([[0, 9.0]]))
    effort = Effort()
    node = np.array([[0.1, 0.9]])
    values = {"oscillator.damping": 1e11}
    assert shoot(RIG, (layout,), values, node, Effort()).is_complete
    values["oscillator.stiffness"] = 1e22
    assert not shoot(RIG, (layout,), values, node, effort).is_complete
    assert effort.made < effort.of_all
