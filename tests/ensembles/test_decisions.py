"""What decides about motions, where Python and a browser have to decide alike."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles import attractors
from percuss.ensembles.decisions import (
    BLOCKS,
    EXPONENT_COLUMNS,
    SIDE,
    drift_of_points,
    fill_cells,
    has_settled,
    is_near,
    many_exponents,
    shares_in_cells,
    sign_of_exponent,
)


def test_exponents_and_their_errors_are_those_of_numpy_to_the_bit() -> None:
    points = np.random.default_rng(3).normal(size=(50, BLOCKS + 1, 3)).cumsum(axis=1)
    durations, every = np.linspace(100.0, 200.0, 50), np.linspace(1.5, 3.0, 50)
    points[7, -1, 0] = -math.inf
    out = np.empty((50, EXPONENT_COLUMNS))
    many_exponents(points, durations, every, np.empty(BLOCKS), out)

    assert out[7].tolist() == [-math.inf, -math.inf, 0.0, -math.inf]
    own = np.arange(50) != 7
    rates = np.diff(points[own, :, 0], axis=1) / every[own, np.newaxis]
    assert (out[own, 2] == rates.std(axis=1, ddof=1) / math.sqrt(BLOCKS)).all()
    assert (out[own, 0] == (points[own, -1, 0] - points[own, 0, 0]) / durations[own]).all()
    halves = np.abs(rates[:, 32:].mean(axis=1) - rates[:, :32].mean(axis=1))
    wanted = np.where(halves > 6.0 * out[own, 2], halves, 0.0)
    found = [drift_of_points(points[i], every[i], np.empty(BLOCKS)) for i in np.flatnonzero(own)]
    assert found == wanted.tolist()


def test_places_outside_the_cells_of_an_attractor_are_not_on_it() -> None:
    frame, full = np.empty((2, 2)), np.empty((SIDE, SIDE), dtype=np.int64)
    cloud = np.array([[0.0, 0.0], [1.0, 5.0], [math.nan, 2.0]])
    fill_cells(cloud, frame, full)
    places = np.array(
        [[0.0, 0.0], [1.0, 5.0], [0.02, 0.1], [0.5, 2.5], [-9.0, 0.0], [0.0, 99.0],
         [math.nan, 0.0], [math.inf, 5.0], [-math.inf, 0.0], [1e300, 1e300]]
    )  # fmt: skip
    shares = np.empty(10)
    shares_in_cells(places[:, np.newaxis], frame, full, shares)

    assert shares.tolist() == [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_a_strobe_is_near_an_orbit_by_its_size() -> None:
    orbit = np.array([[10.0, 0.0], [-10.0, 1.0]])

    assert is_near(np.array([-10.0029, 1.0029]), orbit, 2.0 * math.pi)
    assert not is_near(np.array([-10.0031, 1.0]), orbit, 2.0 * math.pi)
    assert not is_near(np.array([math.nan, 1.0]), orbit, 2.0 * math.pi)


@pytest.mark.parametrize("unit", [1.0, 2.0**-20, 2.0**-30, 2.0**30])
def test_attractors_are_the_same_in_every_unit_of_time(unit: float) -> None:
    """Small motions in two wells differ in their places alone, and velocities are 1e6 times as large."""
    stiff = 4.0 / unit**2
    walls = (pc.SoftStop(0.5, "above", stiff), pc.SoftStop(-0.5, "below", stiff))
    osc = pc.Oscillator(stiffness=-1.0 / unit**2, damping=0.2 / unit, stops=walls)
    force = pc.cosine(1.3 / unit, amplitude=0.05 / unit**2)
    x0, v0 = [-0.8, 0.1, 0.8], [-0.5 / unit, 0.5 / unit]

    found = pc.basins(osc, force, x0=x0, v0=v0, periods=400)

    assert found.basin.values.tolist() == [[0, 0], [0, 1], [1, 1]]
    np.testing.assert_allclose(found.attractor_x0.values.ravel(), [-0.6337, 0.6996], atol=1e-4)
    drifting = pc.sweep(
        "period",
        pc.Oscillator(0.0, 0.2 / unit),
        pc.cosine(1.3 / unit, amplitude=0.05 / unit**2, constant=1e-4 / unit**2),
        over={},
    )
    assert drifting.period.item() == 0.0


@pytest.mark.parametrize(("value", "sign"), [(0.2, 1), (0.09, 0), (-0.2, -1), (math.nan, 0)])
def test_an_exponent_has_a_sign_beyond_its_error(value: float, sign: int) -> None:
    assert sign_of_exponent(value, 0.02, 1000, 6.0) == sign


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_the_sign_of_an_exponent_is_the_same_in_every_unit_of_time(unit: float) -> None:
    """Neighbours that part by a power of the time; in other units they seemed to do more."""
    n, period = 1000, 2.0 * math.pi * unit
    seeming = 2.0 * math.log(n) / (n * period)

    assert sign_of_exponent(0.99 * seeming, 0.0, n, period) == 0
    assert sign_of_exponent(1.01 * seeming, 0.0, n, period) == 1


def test_weakly_damped_motions_on_all_sides_of_an_orbit_go_to_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They are as far from it as may be when they seem periodic: only the orbit itself is near all."""
    # In resonance they come nearer straight, from x = 0, v = 909 above and below.
    osc, x0, v0 = pc.Oscillator(1.0, 4.9e-4), [-200.0, 200.0], [400.0, 1400.0]
    found = pc.basins(osc, pc.cosine(1.0), x0=x0, v0=v0, periods=4000)
    assert found.basin.values.ravel().tolist() == [0] * 4

    # Those of a motion that still settles are not.
    monkeypatch.setattr(attractors, "has_settled", lambda _points, _p, _period: True)
    early = pc.basins(osc, pc.cosine(1.0), x0=x0, v0=v0, periods=4000)
    assert early.sizes["attractor"] > 1 or (early.basin.values == -1).any()
    assert not has_settled(np.array([[1.0, 0.0], [1.0 + 1e-7, 0.0]]), 1, 1.0)
