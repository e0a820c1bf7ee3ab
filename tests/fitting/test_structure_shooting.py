"""Runs of a structure from nodes: samples and derivatives, against differences and `simulate`."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from tests.fitting.differences import assert_derivatives_are_those_of_differences

import percuss as pc
from percuss.arrays import Floats
from percuss.fitting.measured import MeasuredRecord, read_samples
from percuss.fitting.shooting import Layout, Shots, motion_between, shoot

T = np.linspace(0, 8, 161)
LOADS = pc.Loads({0: pc.cosine("2.3", amplitude="1.5")})
PATHS = (
    "structure.stops.0.at", "structure.stops.0.restitution", "structure.stops.1.stiffness",
    "structure.stops.1.damping", "structure.mass.1.1", "structure.stiffness.0.1", "structure.damping.0.0",
    "loads.0.harmonics.0.amplitude",
)  # fmt: skip
SETTING = np.array([0.3, 0.7, 25, 0.4, 1.5, -2.0, 0.2, 1.5])
NODES = np.array([
    [0.1, -0.1, 0.2, 1.2, 0.1, 0.0], [0.0, 0.1, 0.3, 0.9, -0.6, 0.3], [0.2, 0.0, -0.05, -0.4, 0.8, -0.2],
])  # fmt: skip


def three() -> pc.Structure:
    return pc.Structure(
        mass=[1, "1.5", "0.8"],
        stiffness=[[5, -2, 0], [-2, 5, -1], [0, -1, 3]],
        damping=[["0.2", "-0.05", 0], ["-0.05", "0.2", 0], [0, 0, "0.1"]],
        stops=[
            pc.Wall(at="0.3", side="above", restitution="0.7", on=0),
            pc.SoftStop(at="0.1", side="above", stiffness=25, damping="0.4", on=(0, 1, -1)),
        ],
        points={"middle": (0, 1, 0)},
    )


def shots(quantity: str, values: Floats, nodes: Floats) -> Shots:
    data = {"t": T, quantity: np.zeros(len(T))}
    samples, impacts = read_samples(data, 1.0, three())
    spans = np.array([[0, 2.71], [2.71, 5.3], [5.3, 8]])
    first = np.append(np.searchsorted(T, spans[:, 0]), len(T))
    layout = Layout(MeasuredRecord(samples, impacts, LOADS, None), spans, first, False)
    named = dict(zip(PATHS, values.tolist(), strict=True))
    return shoot(three(), (layout,), named, nodes)


@pytest.mark.parametrize(
    "quantity", ["displacement_2", "velocity_middle", "acceleration_0", "stop_force_1"]
)
def test_derivatives_of_samples_and_ends_are_those_of_differences(quantity: str) -> None:
    found = shots(quantity, SETTING, NODES)
    assert found.is_complete
    assert (found.counts > 0).all()
    assert_derivatives_are_those_of_differences(partial(shots, quantity), SETTING, NODES, near=5e-6)


def test_a_segment_is_the_run_from_its_node() -> None:
    run = pc.simulate(three(), LOADS, x0=NODES[0, :3], v0=NODES[0, 3:], t_end=2.71)
    inside = T[T < 2.71]
    x, v = run(inside)
    forces = run.forces(inside)
    for quantity, values in (("displacement_2", x[:, 2]), ("velocity_1", v[:, 1])):
        found = shots(quantity, SETTING, NODES)
        np.testing.assert_allclose(found.values[: len(inside), 0], values, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.ends[0], np.concatenate(run(2.71)), rtol=0, atol=1e-12)
    own = shots("stop_force_1", SETTING, NODES).values[: len(inside), 0]
    np.testing.assert_allclose(own, forces.stops.values[1], rtol=0, atol=1e-11)
    own = shots("acceleration_0", SETTING, NODES).values[: len(inside), 0]
    c = three().stop_directions
    whole = forces.spring.values + forces.damping.values + forces.loads.values
    whole = whole + forces.stops.values.T @ c
    np.testing.assert_allclose(own, whole[:, 0] / 1.0, rtol=0, atol=1e-11)


def test_beside_an_impact_the_other_side_is_the_flight_continued() -> None:
    """Where two flights meet both have the wall's place, and velocities in the ratio -r."""
    found = shots("velocity_0", SETTING, NODES)
    nearest = int(np.argmin(found.away))
    own, other = found.values[nearest]
    assert found.away[nearest] < 0.03
    assert min(own, other) / max(own, other) == pytest.approx(
        -0.7, abs=0.15
    ) or own == pytest.approx(other, abs=0.1)


def test_a_node_behind_a_wall_is_moved_onto_it() -> None:
    nodes = NODES.copy()
    nodes[1, 0] = 0.6
    found = shots("displacement_0", SETTING, nodes)
    assert found.nodes[1, 0] == pytest.approx(0.3, abs=1e-15)
    values = SETTING.copy()
    values[0] += 1e-6
    moved = shots("displacement_0", values, nodes)
    slope = (moved.ends[1] - found.ends[1]) / 1e-6
    np.testing.assert_allclose(found.end_rows[1, :, 0], slope, rtol=1e-3, atol=1e-4)


def test_a_held_mass_and_the_force_that_holds_it() -> None:
    """A structure pressed onto a wall: chatter, contact with its force, and release."""
    structure = pc.Structure(
        mass=[1, 1], stiffness=[[3, -1], [-1, 2]], damping=[["0.1", 0], [0, "0.1"]],
        stops=[pc.Wall(at=0, side="below", restitution="0.2", on=0)],
    )  # fmt: skip
    loads = pc.Loads({0: pc.cosine("0.8", amplitude=2) + pc.Forcing(constant=-1)})
    run = pc.simulate(structure, loads, x0=[0.2, 0], v0=[0, 0.3], t_end=12)
    assert len(run.contacts.start) > 0
    t = np.linspace(0, 12, 241)[:-1]
    nodes = np.array([[0.0, 0.2, 0.0, 0.0, 0.3]])
    own = motion_between(structure, loads, nodes, 12.0, t, [3, 1 << 16])
    np.testing.assert_allclose(own[:, 0], run.forces(t).stops.values[0], rtol=0, atol=1e-10)
    np.testing.assert_allclose(own[:, 1], run(t)[0][:, 1], rtol=0, atol=1e-11)
