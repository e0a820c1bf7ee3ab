"""Parameters in expressions as paths: what they change, and what is no path any more."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest

import percuss as pc
from percuss.errors import ParameterError
from percuss.model import (
    Forcing,
    Harmonic,
    Oscillator,
    SoftStop,
    Start,
    Wall,
    get_parameter,
    long_form,
    moved_fields,
    parameter_paths,
    replace_parameter,
    replace_parameters,
)

W, GAP = pc.parameter("w", "1.7"), pc.parameter("gap", "0.5")
FORCE = pc.cosine(W, amplitude="0.15" * W**2)
OSC = Oscillator(
    damping="0.01" * W,
    stops=(Wall(-GAP, "below", 0.7), SoftStop(GAP, "above", stiffness=1 / GAP, damping=0.1)),
)
START = Start(GAP / 2, 0.0, 2 * W)


def test_the_names_of_parameters_are_paths_and_what_is_tied_is_none() -> None:
    paths = parameter_paths(OSC, FORCE, START)
    assert paths == (
        "oscillator.stiffness",
        "oscillator.stops.0.restitution",
        "oscillator.stops.1.damping",
        "forcing.constant",
        "forcing.harmonics.0.phase",
        "start.v0",
        "gap",
        "w",
    )
    for path in paths:
        assert long_form(path, OSC, FORCE, START) == path


def test_a_parameter_changes_all_that_is_tied_to_it_and_nothing_else() -> None:
    osc, force, start = replace_parameter(OSC, FORCE, START, "w", "2")

    assert force is not None
    assert [float(x) for x in (force.harmonics[0].amplitude, force.harmonics[0].omega)] == [0.6, 2]  # type: ignore[union-attr]
    assert float(osc.damping) == 0.02
    assert osc.stops == OSC.stops
    assert start is not None
    assert (start.x0, float(start.t0)) == (START.x0, 4.0)
    assert get_parameter(osc, force, start, "w") == "2"
    assert replace_parameter(osc, force, start, "w", "1.7") == (OSC, FORCE, START)


def test_several_parameters_are_replaced_at_once() -> None:
    both = pc.cosine(W, amplitude=GAP * W)
    one = replace_parameters(OSC, both, None, {"w": 2, "gap": 3, "oscillator.stiffness": 4})
    then = replace_parameter(*one, "w", "1.7")
    assert float(one[1].harmonics[0].amplitude) == 6.0  # type: ignore[union-attr]
    assert get_parameter(*then, "gap") == 3


def test_what_is_a_parameter_alone_has_two_paths() -> None:
    assert long_form("forcing.omega", OSC, FORCE) == "w"
    assert replace_parameter(OSC, FORCE, None, "forcing.omega", 2) == replace_parameter(
        OSC, FORCE, None, "w", 2
    )
    with pytest.raises(ParameterError, match="named twice"):
        replace_parameters(OSC, FORCE, None, {"w": 2, "forcing.omega": 2})


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        (
            "forcing.amplitude",
            "tied to w by forcing.harmonics.0.amplitude = 0.15*w**2; change w",
        ),
        ("oscillator.damping", "tied to w by oscillator.damping = 0.01*w; change w"),
        ("forcing.period", "tied to w by forcing.harmonics.0.omega = w; change w"),
        ("oscillator.stops.0.at", "tied to gap by oscillator.stops.0.at = -gap; change gap"),
        ("start.x0", "tied to gap by start.x0 = gap/2; change gap"),
        ("gaps", "no such parameter; did you mean gap?"),
    ],
)
def test_a_tied_path_is_refused_with_the_parameter_to_change(path: str, reason: str) -> None:
    with pytest.raises(ParameterError) as caught:
        replace_parameter(OSC, FORCE, START, path, 1)
    assert caught.value.reason == reason


def test_a_value_at_which_the_model_is_none_names_the_field_and_the_value() -> None:
    with pytest.raises(ParameterError) as caught:
        replace_parameter(OSC, FORCE, START, "gap", 0)
    assert str(caught.value) == (
        "oscillator.stops.1.stiffness = expression('1/gap', gap=0): a division by zero"
    )
    with pytest.raises(ParameterError, match="behind the wall below at x = -gap"):
        replace_parameter(OSC, FORCE, START, "gap", -1)


def test_two_parameters_of_one_name_have_one_value() -> None:
    other = pc.cosine(pc.parameter("w", "1.8"))
    calls: list[Any] = [
        lambda: pc.simulate(OSC, other, x0=0, v0=1, max_impacts=1),
        lambda: parameter_paths(OSC, other),
        lambda: replace_parameter(OSC, other, None, "w", 2),
        lambda: pc.simulate(OSC, FORCE, x0=0, v0=pc.parameter("w", 1), max_impacts=1),
    ]
    for call in calls:
        with pytest.raises(ParameterError, match="one name has one value"):
            call()


def test_the_period_is_a_path_where_there_is_one_frequency() -> None:
    osc = pc.impact_oscillator()
    for force in (pc.cosine("2.8"), pc.fourier("2.8", cos=(1, 2)), pc.sine(2.8)):
        assert math.isclose(
            float(get_parameter(osc, force, None, "forcing.period")), 2 * math.pi / 2.8
        )
        moved = replace_parameter(osc, force, None, "forcing.period", "1.5")[1]
        assert moved is not None
        assert moved.period == 1.5
        assert get_parameter(osc, moved, None, "forcing.period") == 1.5
        exact = replace_parameter(osc, moved, None, "forcing.period", "pi/2")[1]
        assert exact is not None
        assert exact.frequency == Fraction(4)
        assert long_form("forcing.period", osc, force) not in parameter_paths(osc, force)
    with pytest.raises(ParameterError, match="not positive"):
        replace_parameter(osc, pc.cosine(2), None, "forcing.period", 0)
    with pytest.raises(ParameterError, match="named twice"):
        replace_parameters(osc, pc.cosine(2), None, {"forcing.period": 1, "forcing.omega": 2})
    for several in (pc.cosine(2) + pc.cosine(3), Forcing()):
        with pytest.raises(ParameterError, match="no such parameter"):
            long_form("forcing.period", osc, several)
    two = Forcing((Harmonic(1, 2), Harmonic(1, 3)), period="2*pi")
    assert long_form("forcing.period", osc, two) == "forcing.period"


def test_the_frequency_of_a_wave_is_a_path_as_that_of_a_harmonic() -> None:
    osc = pc.impact_oscillator("0.8")
    wave = pc.square_wave(2, "0.5")
    assert get_parameter(osc, wave, None, "forcing.omega") == 2
    assert get_parameter(osc, wave, None, "forcing.amplitude") == "0.5"
    assert get_parameter(osc, wave, None, "forcing.period") == pc.pi_times(1)
    _, moved, _ = replace_parameter(osc, wave, None, "forcing.period", 2)
    assert moved.period == 2.0
    for path, meant in (
        ("forcing.omegaa", "did you mean forcing.omega"),
        ("oscillator.stops.3.at", "did you mean oscillator.stops.0.at"),
    ):
        with pytest.raises(pc.ParameterError, match=meant):
            get_parameter(osc, wave, None, path)
    # Of a wave and a harmonic there are two frequencies; a record in seconds has none.
    for force in (wave + pc.cosine(2), pc.record([0, 1, 2], [0, 1, 0], repeat=True)):
        with pytest.raises(pc.ParameterError, match="no such parameter"):
            get_parameter(osc, force, None, "forcing.omegaa")


def test_a_shaking_base_keeps_its_amplitude() -> None:
    osc = pc.impact_oscillator(stiffness=0)
    force = pc.base_excitation("0.15", "1.7", constant=-1)
    for omega in ("1.7", 2, 0.1):
        moved = replace_parameter(osc, force, None, "forcing.omega", omega)[1]
        plain = pc.cosine(omega, amplitude=Fraction("0.15") * Fraction(omega) ** 2, constant=-1)
        assert moved is not None
        assert moved.components() == plain.components()
    assert parameter_paths(osc, force)[-2:] == ("base_amplitude", "base_omega")
    assert pc.base_excitation("0.15", W).components() == FORCE.components()


def test_constructors_keep_what_is_tied() -> None:
    m, k = pc.parameter("m", 2), pc.parameter("k", 50)
    osc = Oscillator.from_mass(m, k, damping_ratio="0.25", stops=(SoftStop(1, "above", 30, 4),))
    assert osc == Oscillator.from_mass(
        m, k, damping_ratio="0.25", stops=(SoftStop(1, "above", 30, 4),)
    )
    numbers = Oscillator.from_mass(
        2, 50, damping_ratio="0.25", stops=(SoftStop(1, "above", 30, 4),)
    )
    for (path, tied), plain in zip(_numbers(osc), _numbers(numbers), strict=True):
        assert float(tied) == float(plain[1]), path
    heavier = replace_parameter(osc, None, None, "m", 8)[0]
    assert float(heavier.damping) == 2 * 0.25 * math.sqrt(50 * 8)
    assert float(heavier.of_unit_mass().damping) == 0.25 * math.sqrt(50 / 8)
    _, force = pc.ball_on_table("0.3", W, restitution="0.15")
    assert float(replace_parameter(osc, force, None, "w", 2)[1].harmonics[0].amplitude) == 1.2  # type: ignore[union-attr]
    assert pc.cosine(2, amplitude=W).per_mass(m).components()[0].cos == 0.85
    both = pc.cosine(W) + pc.fourier(2 * W, cos=(1,))
    assert [float(part.omega) for part in both.components()] == [1.7, 3.4]
    assert moved_fields(osc, both, None, "w").fields.keys() == {
        "forcing.harmonics.0.omega",
        "forcing.harmonics.1.omega",
    }
    gap = pc.backlash_oscillator(GAP, 100)
    assert [float(stop.at) for stop in gap.stops] == [-0.5, 0.5]
    assert parameter_paths(gap)[-1] == "gap"


def _numbers(osc: Oscillator) -> list[tuple[str, Any]]:
    stop = osc.stops[0]
    assert isinstance(stop, SoftStop)
    return [
        ("stiffness", osc.stiffness),
        ("damping", osc.damping),
        ("stops.0.stiffness", stop.stiffness),
        ("stops.0.damping", stop.damping),
    ]
