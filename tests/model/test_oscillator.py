from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest

from percuss.errors import ParameterError
from percuss.model import (
    Component,
    Oscillator,
    SoftStop,
    Units,
    Wall,
    as_fraction,
    backlash_oscillator,
    ball_on_table,
    bilinear_oscillator,
    cosine,
    impact_oscillator,
)


def test_a_restitution_that_is_a_function_is_told_of_the_table() -> None:
    with pytest.raises(ParameterError, match=r"a function; a .* is a restitution_table\("):
        impact_oscillator(lambda v: 0.8 - 0.1 * v)  # type: ignore[arg-type]


def test_an_oscillator_in_engineers_units_has_the_coefficients_of_unit_mass() -> None:
    """m = 2, k = 50, c = 0.5: k/m = 25 and a = c/(2 m) = 1/8; a stop's the same way."""
    osc = Oscillator.from_mass(
        mass=2.0,
        stiffness=50.0,
        damping_coefficient=0.5,
        stops=(Wall(-1.0, "below", 0.7), SoftStop(1.0, "above", stiffness=58.0, damping=3.0)),
    )

    assert (osc.mass, osc.stiffness, osc.damping) == (2.0, 50.0, 0.5)
    assert osc.stops[1] == SoftStop(1.0, "above", stiffness=58.0, damping=3.0)
    assert osc.of_unit_mass() == Oscillator(
        stiffness=25.0,
        damping=0.125,
        stops=(Wall(-1.0, "below", 0.7), SoftStop(1.0, "above", stiffness=29.0, damping=0.75)),
    )


def test_division_by_the_mass_is_exact() -> None:
    osc = Oscillator.from_mass(mass=3, stiffness="0.1", damping_coefficient=1).of_unit_mass()

    assert as_fraction(osc.stiffness) == Fraction(1, 30)
    assert as_fraction(osc.damping) == Fraction(1, 6)


def test_a_damping_ratio_is_a_fraction_of_critical_damping() -> None:
    """a = zeta sqrt(k/m), exact where the root is rational."""
    exact = Oscillator.from_mass(mass=2, stiffness=18, damping_ratio="0.1").of_unit_mass()
    rounded = Oscillator.from_mass(mass=1, stiffness=2, damping_ratio=1).of_unit_mass()

    assert as_fraction(exact.damping) == Fraction(3, 10)
    assert rounded.damping == math.sqrt(2.0)


def test_a_force_is_divided_by_the_mass_too() -> None:
    """m x'' + k x = F: the static deflection F/k does not depend on the mass."""
    osc = Oscillator.from_mass(mass=3.0, stiffness=10.0)
    force = cosine(2.0, amplitude=6.0, constant=20.0).per_mass(3.0)

    assert as_fraction(force.constant) / as_fraction(osc.of_unit_mass().stiffness) == 2
    assert force.components()[0].cos == 2.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": 0.0, "stiffness": 1.0}, "mass = 0.0: not positive"),
        ({"mass": -2, "stiffness": 1.0}, "mass = -2: not positive"),
        ({"mass": 1.0, "stiffness": math.nan}, "stiffness = nan: not finite"),
        (
            {"mass": 1.0, "stiffness": 1.0, "damping_coefficient": math.inf},
            "damping_coefficient = inf: not finite",
        ),
        ({"mass": 1.0, "stiffness": 0.0, "damping_ratio": 0.1}, "needs a stiffness above 0, not 0"),
        (
            {"mass": 1.0, "stiffness": 1.0, "damping_ratio": 0.1, "damping_coefficient": 0.2},
            "together with damping_coefficient = 0.2; give one",
        ),
    ],
)
def test_bad_engineering_values_are_named_as_they_were_given(
    arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        Oscillator.from_mass(**arguments)

    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("above", "below", "difference"),
    [(1.0, 400.0, 399), ("0.1", "0.3", Fraction(1, 5)), (1.0, 1e-30, Fraction(1e-30) - 1)],
)
def test_the_stop_of_a_bilinear_oscillator_adds_the_exact_difference(
    above: float, below: float, difference: Fraction
) -> None:
    (stop,) = bilinear_oscillator(stiffness_above=above, stiffness_below=below).stops

    assert isinstance(stop, SoftStop)
    assert (stop.at, stop.side, as_fraction(stop.stiffness)) == (0.0, "below", difference)


def test_backlash_is_free_inside_the_gap_and_meets_a_stop_on_either_side() -> None:
    osc = backlash_oscillator(gap="0.5", stiffness=100.0, damping=0.01, stop_damping=0.2)

    assert osc == Oscillator(
        stiffness=0.0,
        damping=0.01,
        stops=(SoftStop(-0.5, "below", 100.0, 0.2), SoftStop("0.5", "above", 100.0, 0.2)),
    )


def test_a_negative_gap_is_refused() -> None:
    with pytest.raises(ParameterError, match="gap = -1: negative"):
        backlash_oscillator(gap=-1, stiffness=1.0)


def test_a_ball_leaves_the_table_when_the_table_falls_faster_than_gravity() -> None:
    """y'' = -g + A omega^2 sin(omega t + phase) with A = 1.25, omega = 2, g = 9.81."""
    osc, force = ball_on_table(1.25, 2, gravity="9.81", restitution=0.8)

    (component,) = force.components()
    assert osc == impact_oscillator(0.8, stiffness=0.0)
    assert as_fraction(force.constant) == Fraction(-981, 100)
    assert component == Component(Fraction(2), 0.0, 5.0)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"amplitude": math.inf, "omega": 1.0}, "amplitude"),
        ({"amplitude": 1.0, "omega": 0.0}, "omega"),
        ({"amplitude": 1.0, "omega": 1.0, "gravity": -9.81}, "gravity"),
        ({"amplitude": 1.0, "omega": 1.0, "restitution": 1.5}, "restitution"),
        ({"amplitude": 1.0, "omega": 1.0, "phase": math.nan}, "phase"),
    ],
)
def test_bad_values_of_a_shaking_table_are_named_as_they_were_given(
    arguments: dict[str, Any], name: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        ball_on_table(**arguments)

    assert caught.value.name == name
    assert caught.value.value == pytest.approx(arguments[name], nan_ok=True)


def test_stops_keep_their_order_and_may_be_given_as_a_list() -> None:
    stops = [SoftStop(2.0, "above", -3.0), Wall(-1.0, "below"), SoftStop(1.0, "above", 5.0)]

    assert Oscillator(stops=stops).stops == tuple(stops)  # type: ignore[arg-type]


def test_negative_damping_keeps_its_sign_in_engineers_units() -> None:
    by_ratio = Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_ratio="-0.25")
    by_coefficient = Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_coefficient=-5)

    assert by_ratio.damping == by_coefficient.damping == -5
    assert by_ratio.of_unit_mass().damping == -1.25


@pytest.mark.parametrize("units", [None, Units("mm", "s", "g")])
def test_an_oscillator_with_a_mass_shows_its_coefficient_as_one(units: Units | None) -> None:
    """``damping`` is c beside a mass and a without one: 2 a = c for a mass of 1."""
    osc = Oscillator(1, "0.1", (Wall(1, "above", "0.8"),), mass=1, units=units)

    assert "damping_coefficient='0.1'" in repr(osc)
    assert "damping='0.05'" in repr(Oscillator(1, "0.05"))
    assert eval(repr(osc), {"Oscillator": Oscillator, "Wall": Wall, "Units": Units}) == osc
