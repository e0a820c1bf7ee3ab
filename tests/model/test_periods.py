"""The period that harmonics have in common, which a sum of forcings does not have by itself."""

from __future__ import annotations

import pytest

import percuss as pc
from percuss.model.exact import Exact
from percuss.model.periods import period_in_common


@pytest.mark.parametrize(
    ("omegas", "period"),
    [
        (("1.5", "3"), "4*pi/3"),
        ((0.8, 1.2), "5*pi"),  # their ratio as doubles is not 3/2
        (("4.2", "2.9"), "20*pi"),
        (("2.1", 0.7 * 3), "20*pi/21"),
        ((1, "1.01"), "200*pi"),
        ((1, "1.001"), None),  # 1,000 turns
        ((1, "1.41421"), None),
        ((1, pc.expression("sqrt(2)")), None),
        ((pc.expression("sqrt(2)"), pc.expression("2*sqrt(2)")), None),  # no multiple of pi
    ],
)
def test_the_period_in_common_is_one(omegas: tuple[Exact, ...], period: str | None) -> None:
    force = pc.Forcing(tuple(pc.Harmonic(1, omega) for omega in omegas), constant="0.1")

    assert period_in_common(force) == period
    if period is not None:
        # Checked by the forcing: each harmonic makes a whole number of turns in it.
        periodic = pc.Forcing(force.harmonics, force.constant, period=period)
        assert periodic.period is not None


def test_loads_of_several_points_have_one_in_common() -> None:
    assert period_in_common(pc.Loads({0: pc.cosine(2), 1: pc.sine(3)})) == "2*pi"
    assert period_in_common(pc.Loads({0: pc.cosine(2), 1: pc.Forcing(constant=1)})) == "pi"


def test_a_record_has_its_own() -> None:
    record = pc.square_wave(2)

    assert period_in_common(pc.cosine(3) + record) is None


def test_where_a_period_is_needed_the_one_in_common_is_named() -> None:
    two, chain = pc.cosine("1.5") + pc.sine(3), pc.chain(masses=[1, 1], springs=[1, 1, 1])
    loads = pc.Loads({0: pc.cosine(2), 1: pc.sine(3)})
    osc = pc.impact_oscillator("0.8")

    common = r'give "4\*pi/3", which its harmonics have in common, as period= of Forcing'
    with pytest.raises(pc.ParameterError, match=common):
        pc.find_orbit(osc, two)
    with pytest.raises(pc.ParameterError, match=f"{common}, or between="):
        pc.sweep("peak_displacement", osc, two, over={"forcing.constant": [0.0]})
    sentence = (
        r'needs loads of one period; give "2\*pi", which its loads have in common, as period= of'
    )
    with pytest.raises(pc.ParameterError, match=sentence):
        pc.find_orbit(chain, loads)
    with pytest.raises(pc.ParameterError, match="give period= of Forcing where it has one"):
        pc.stroboscopic_map(osc, pc.cosine(1) + pc.cosine("1.41421"))
