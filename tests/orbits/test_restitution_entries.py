"""Values of a restitution table as parameters: branches and curves over them, and no false proof."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc

ENTRY = "oscillator.stops.0.restitution.values.1"


def oscillator(value: object) -> pc.Oscillator:
    table = pc.restitution_table([0, 1], ["0.9", value])  # type: ignore[list-item]
    return pc.Oscillator(1, stops=(pc.Wall(0, "below", table),))


@pytest.fixture(scope="module")
def doubling() -> pc.SpecialPoint:
    """A period doubling over the frequency, for 0.6 at speed 1."""
    orbit = pc.find_orbit(oscillator("0.6"), pc.cosine("2.5"))
    (point,) = pc.continue_orbit(orbit, over={"forcing.omega": (2.4, 2.8)}).special_points
    return point


def test_a_branch_over_an_entry_is_made_of_the_orbits_of_its_tables() -> None:
    branch = pc.continue_orbit(
        pc.find_orbit(oscillator("0.6"), pc.cosine("2.5")), over={ENTRY: (0.5, 0.7)}
    )

    for row in (0, len(branch) // 3, len(branch) - 1):
        own = pc.find_orbit(oscillator(float(branch.values[row])), pc.cosine("2.5"))
        np.testing.assert_allclose(own.impacts.v_before, branch[row].impacts.v_before, rtol=1e-11)
        np.testing.assert_allclose(own.multipliers, branch[row].multipliers, atol=1e-9)


def test_the_doubling_over_the_entry_is_that_over_the_frequency(doubling: pc.SpecialPoint) -> None:
    orbit = pc.find_orbit(oscillator("0.58"), pc.cosine(doubling.value))

    (point,) = pc.continue_orbit(orbit, over={ENTRY: (0.55, 0.65)}).special_points

    assert point.kind == doubling.kind == "period_doubling"
    assert math.isclose(point.value, 0.6, rel_tol=1e-9)
    proven = pc.certify(point)
    assert not proven.exists
    assert "no number that can be a ball" in proven.reason or "nothing is proven" in proven.reason


def test_the_curve_of_doublings_goes_through_both(doubling: pc.SpecialPoint) -> None:
    curve = pc.continue_curve(doubling, {"forcing.omega": (2.6, 2.7), ENTRY: (0.55, 0.65)})

    order = np.argsort(curve.values[:, 1])
    at = np.interp(0.6, curve.values[order, 1], curve.values[order, 0])
    assert abs(at - doubling.value) < 1e-6


def test_a_table_beyond_its_domain_is_refused_by_its_path() -> None:
    with pytest.raises(pc.ParameterError, match=r"stops\.0\.restitution\.values\.1 = 1\.5: above"):
        pc.model.replace_parameter(oscillator("0.6"), None, None, ENTRY, 1.5)
    speeds = ENTRY.replace("values", "speeds")
    osc, _, _ = pc.model.replace_parameter(oscillator("0.6"), None, None, speeds, 2)
    assert osc.stops[0].restitution == pc.restitution_table([0, 2], ["0.9", "0.6"])  # type: ignore[union-attr]
    with pytest.raises(pc.ParameterError, match=r"speeds\.1"):
        pc.model.replace_parameter(osc, None, None, speeds, 0)
