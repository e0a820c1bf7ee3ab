"""Homoclinic orbits: they leave a saddle and come back, and nothing else is called so."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.orbits.surface.homoclinic import HomoclinicOrbit, homoclinic_orbits


@pytest.fixture(scope="module")
def found() -> tuple[HomoclinicOrbit, ...]:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.8"))
    return homoclinic_orbits(orbit, most_orbits=2)


def test_each_point_is_the_image_of_the_one_before(found: tuple[HomoclinicOrbit, ...]) -> None:
    step = pc.impact_map(found[0].orbit.oscillator, pc.cosine("2.8"))
    for path in found:
        images = np.stack(step(*path.points[:-1].T), axis=1)
        missed = images - path.points[1:]
        assert np.abs((missed[:, 0] + 0.5) % 1.0 - 0.5).max() < 1e-12
        assert np.abs(missed[:, 1]).max() < 1e-12


def test_it_leaves_along_the_unstable_and_comes_back_along_the_stable_direction(
    found: tuple[HomoclinicOrbit, ...],
) -> None:
    assert len(found) == 2
    for path in found:
        a, b = path.coordinates.T
        large, small = path.orbit.multipliers.real
        assert a[1] / a[0] == pytest.approx(large, rel=1e-2)
        assert abs(a[0]) < 1e-3
        assert np.hypot(a, b).max() > 0.2
        back = b[-8:]
        assert back[1:] / back[:-1] == pytest.approx(np.full(7, small), rel=0.1)
        assert np.hypot(a[-1], b[-1]) < 1e-5


def test_there_is_none_just_after_the_period_doubling() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.66"))
    assert homoclinic_orbits(orbit) == ()


def test_what_is_no_saddle_and_what_meets_no_stop_is_refused() -> None:
    damped = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    with pytest.raises(pc.ParameterError, match="no saddle"):
        homoclinic_orbits(pc.find_orbit(damped, pc.cosine(1)))
    pendulum = pc.Oscillator(-1, "0.1", (pc.Wall(1, "above", "0.5"),))
    steady = pc.find_orbit(pendulum, pc.cosine(2, amplitude="0.3"), n_impacts=0)
    with pytest.raises(pc.ParameterError, match="the orbit does not meet it"):
        homoclinic_orbits(steady, stop=0)
    with pytest.raises(pc.ParameterError, match="meets no stop"):
        homoclinic_orbits(steady)


@pytest.mark.parametrize(
    ("restitution", "wall", "omega"),
    [("0.652", "-0.261", "3.611"), ("0.855", 0, "3.204"), ("0.305", "-0.227", "2.895")],
)
def test_each_comes_back_to_its_saddle_at_the_last(
    restitution: str, wall: str | int, omega: str
) -> None:
    osc = pc.impact_oscillator(restitution, wall=wall)
    orbits = pc.find_orbits(osc, pc.cosine(omega), max_impacts=1, max_periods=3)
    saddles = [orbit for orbit in orbits if abs(orbit.multipliers[0]) > 1.0]

    paths = [p for orbit in saddles for p in homoclinic_orbits(orbit, most_impacts=12)]

    assert paths
    # Beyond a fold of the manifold, and beside a jump of the map, motions pass the saddle on both
    # sides, too: those ended up to 0.09 from it.
    for path in paths:
        assert np.abs(path.coordinates[0]).max() < 2e-4
        assert np.abs(path.coordinates[-1]).max() < 1e-4
