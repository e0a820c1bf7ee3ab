"""Units as names, and which of them fit."""

from __future__ import annotations

from typing import Any

import pytest

import percuss as pc
from percuss.errors import ParameterError


@pytest.mark.parametrize(
    ("units", "force", "energy", "power", "stiffness", "damping"),
    [
        (("m", "s", "kg"), "N", "J", "W", "N/m", "N s/m"),
        (("m", "s", "t"), "kN", "kJ", "kW", "kN/m", "kN s/m"),
        (("mm", "s", "t"), "N", "mJ", "mW", "N/mm", "N s/mm"),
        (("mm", "ms", "kg"), "kN", "J", "kW", "kN/mm", "kN ms/mm"),
        (("L", "s", "kg"), "kg L/s^2", "kg L^2/s^2", "kg L^2/s^3", "N/L", "kg/s"),
    ],
)
def test_forces_energies_and_powers_have_the_names_of_si_where_there_are(
    units: tuple[str, str, str], force: str, energy: str, power: str, stiffness: str, damping: str
) -> None:
    own = pc.Units(*units)

    assert own.of("mass length/time^2") == force
    assert own.of("mass length^2/time^2") == energy
    assert own.of("mass length^2/time^3") == power
    if units[0] != "L":
        assert (own.of("mass/time^2"), own.of("mass/time")) == (stiffness, damping)
    assert own.of("1/time") == f"1/{units[1]}"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.Units("s"), "units.length = 's': a unit of time, not of length"),
        (lambda: pc.Units(mass="kN"), "units.mass = 'kN': a unit of force, not of mass"),
        (lambda: pc.Units(time=3), "units.time = 3: not a text"),  # type: ignore[arg-type]
        (
            lambda: pc.Oscillator(units=pc.Units("m", "s", "kg")),
            "units.mass = 'kg': a unit of mass for an oscillator without one",
        ),
        (
            lambda: pc.Oscillator.from_mass(2, 50, units=pc.Units("m", "s")),
            "units.mass = '': no unit for the mass of 2",
        ),
        (
            lambda: pc.Oscillator(units="m"),  # type: ignore[arg-type]
            "units = 'm': not a Units",
        ),
        (
            lambda: pc.cosine(2).per_mass(2).per_mass(3),
            "mass = 3: the force is per unit mass already",
        ),
        (lambda: pc.cosine(2).per_mass(2) + pc.cosine(3), "have no sum"),
        (
            lambda: pc.Oscillator.from_mass(1e-60, 1e60),
            "after the division by it, stiffness is not between",
        ),
    ],
)
def test_what_does_not_fit_is_said_in_a_sentence(make: Any, message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        make()

    assert message in str(caught.value)
