"""Systems and orbits that repeat themselves mirrored after half a period."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.model.system import law
from percuss.orbits.orbit.symmetry import half_multipliers, is_symmetric_system

TWO_WALLS = (pc.Wall(0.3, "above", 0.7), pc.Wall(-0.3, "below", 0.7))


@pytest.mark.parametrize(
    ("stops", "symmetric"),
    [
        ((), True),
        (TWO_WALLS, True),
        ((pc.Wall("0.3", "above", 0.7), pc.Wall(-0.3, "below", 0.7)), False),
        ((pc.Wall(0.3, "above", 0.7), pc.Wall(-0.3, "below", 0.8)), False),
        ((pc.Wall(0.3, "above", 0.7),), False),
        ((pc.SoftStop(0.1, "above", 2.0, 0.1), pc.SoftStop(-0.1, "below", 2.0, 0.1)), True),
        ((pc.SoftStop(0.1, "above", 2.0, 0.1), pc.SoftStop(-0.1, "below", 2.0, 0.2)), False),
        ((pc.SoftStop(0.0, "below", 3.0),), False),
    ],
)
def test_stops_come_in_mirrored_pairs(stops: tuple[pc.Wall, ...], symmetric: bool) -> None:
    assert is_symmetric_system(pc.Oscillator(1.0, 0.1, stops), pc.cosine(1.0)) is symmetric


@pytest.mark.parametrize(
    ("force", "symmetric"),
    [
        (None, True),
        (pc.sine(2.0), True),
        (pc.cosine(2.0, constant=0.1), False),
        (pc.fourier(2.0, cos=(1.0, 0.0, 0.3)), True),
        (pc.fourier(2.0, cos=(1.0, 0.2)), False),
        (pc.cosine(1.0) + pc.cosine(3.0), False),
        (pc.Forcing((pc.cosine(1.0) + pc.cosine(3.0)).harmonics, period="2*pi"), True),
        (pc.Forcing((pc.cosine(2.0) + pc.cosine(3.0)).harmonics, period="2*pi"), False),
        # A period that is twice what it need be: over half of it the force does not change sign.
        (pc.Forcing(pc.cosine(2.0).harmonics, period="2*pi"), False),
    ],
)
def test_forcing_has_odd_harmonics_of_its_period(force: pc.Forcing | None, symmetric: bool) -> None:
    assert is_symmetric_system(pc.Oscillator(1.0, 0.1, TWO_WALLS), force) is symmetric


def test_orbits_between_two_walls() -> None:
    osc = pc.Oscillator(1.0, 0.02, TWO_WALLS)

    assert pc.find_orbit(osc, pc.cosine(1.5), 2, 1).symmetric
    assert pc.find_orbit(osc, pc.cosine(1.5, amplitude=0.01), 0).symmetric
    pushed = pc.cosine(1.5, constant=0.01)
    assert not pc.find_orbit(osc, pushed, 2, 1).symmetric


def test_the_map_over_half_a_period_squares_to_the_whole() -> None:
    osc = pc.Oscillator(1.0, 0.02, TWO_WALLS)
    for amplitude in (0.4, 1.0):
        orbit = pc.find_orbit(osc, pc.cosine(1.5, amplitude=amplitude), 2, 1)
        over_half = half_multipliers(law(osc, orbit.forcing), *orbit.record)
        squares = sorted((each**2 for each in over_half), key=lambda m: (m.real, m.imag))
        whole = sorted(orbit.multipliers, key=lambda m: (m.real, m.imag))
        np.testing.assert_allclose(squares, whole, rtol=1e-9)


def test_the_symmetry_breaks_where_the_half_map_has_minus_one() -> None:
    osc = pc.Oscillator(1.0, 0.02, TWO_WALLS)
    orbit = pc.find_orbit(osc, pc.cosine(1.5, amplitude=0.5), 2, 1)

    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.5, 0.7)})

    (point,) = branch.special_points
    assert point.kind == "symmetry_breaking"
    over_half = half_multipliers(law(osc, point.orbit.forcing), *point.orbit.record)
    assert min(abs(each + 1.0) for each in over_half) < 1e-8


def test_a_fold_of_symmetric_orbits_is_no_breaking() -> None:
    """There the half map has the multiplier +1; that of the orbit, its square, is 1 as well."""
    osc = pc.Oscillator(1.0, 0.02, (pc.Wall(1.0, "above", 0.7), pc.Wall(-1.0, "below", 0.7)))
    orbit = pc.find_orbit(osc, pc.cosine(1.5, amplitude=3.0), 2, 1)

    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (3.0, 0.1)})

    folds = [point for point in branch.special_points if point.kind == "fold"]
    assert folds
    for fold in folds:
        assert fold.orbit.symmetric
        over_half = half_multipliers(law(osc, fold.orbit.forcing), *fold.orbit.record)
        assert min(abs(each - 1.0) for each in over_half) < 1e-6
