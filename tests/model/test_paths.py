from __future__ import annotations

import math

import numpy as np
import pytest

from percuss.errors import ParameterError
from percuss.model import (
    Forcing,
    Harmonic,
    Oscillator,
    Phase,
    SoftStop,
    Start,
    Wall,
    cosine,
    fourier,
    get_parameter,
    impact_oscillator,
    long_form,
    parameter,
    parameter_paths,
    pi_times,
    replace_parameter,
    replace_parameters,
    restitution_table,
    sine,
)

OSC = Oscillator(
    stiffness="1.5",
    damping=0.01,
    stops=(Wall(-1.0, "below", 0.7), SoftStop(1.0, "above", stiffness=29.0)),
)
TWO = Forcing((Harmonic(1.0, 2.0, "pi/2"), Harmonic(0.5, 3.0)), period=pi_times(2))
START = Start(0.0, "0.45", 1)
FORCINGS = (None, sine(3.0), TWO, fourier(2.0, cos=(1.0,), sin=(0.0, 0.1), constant=-0.5))


@pytest.mark.parametrize("force", FORCINGS)
def test_every_parameter_is_replaced_by_its_path_and_nothing_else_is(force: Forcing | None) -> None:
    paths = parameter_paths(OSC, force, START)
    for path in paths:
        if path in {"forcing.period", "forcing.harmonics.1.omega", "forcing.harmonics.0.omega"}:
            continue  # these go together where the period was given
        value = 0.625 if path != "oscillator.stops.0.at" else -2.5

        changed = replace_parameter(OSC, force, START, path, value)

        assert get_parameter(*changed, path) == value
        for other in paths:
            if other != path:
                assert get_parameter(*changed, other) == get_parameter(OSC, force, START, other)


@pytest.mark.parametrize("force", FORCINGS)
def test_replacing_every_parameter_by_itself_gives_equal_values(force: Forcing | None) -> None:
    changes = {
        path: get_parameter(OSC, force, START, path) for path in parameter_paths(OSC, force, START)
    }

    assert replace_parameters(OSC, force, START, changes) == (OSC, force, START)


def test_what_has_not_changed_stays_the_same_object() -> None:
    osc, force, start = replace_parameter(OSC, TWO, START, "start.v0", 0.0)

    assert osc is OSC
    assert force is TWO
    assert start == Start(0.0, 0.0, 1)


@pytest.mark.parametrize("name", ["omega", "amplitude", "phase"])
def test_with_one_harmonic_the_short_form_is_printed_as_the_long_one(name: str) -> None:
    force = sine(3.0)

    _, changed, _ = replace_parameter(OSC, force, None, f"forcing.{name}", 2.0)

    assert long_form(f"forcing.{name}", OSC, force) == f"forcing.harmonics.0.{name}"
    assert changed is not None
    assert getattr(changed.harmonics[0], name) == 2.0


def test_the_frequency_of_a_fourier_sum_is_its_base() -> None:
    force = fourier(2.0, cos=(1.0, 0.5))

    _, changed, _ = replace_parameter(OSC, force, None, "forcing.omega", "2.5")

    assert changed == fourier("2.5", cos=(1.0, 0.5), sin=(0.0, 0.0))
    assert long_form("forcing.omega", OSC, force) == "forcing.omega"


def test_harmonics_and_their_period_are_replaced_together() -> None:
    changes: dict[str, Phase] = {
        "forcing.harmonics.0.omega": 4,
        "forcing.harmonics.1.omega": 6,
        "forcing.period": pi_times(1),
    }

    _, changed, _ = replace_parameters(OSC, TWO, None, changes)

    assert changed is not None
    assert changed.period == math.pi
    with pytest.raises(ParameterError, match=r"forcing\.period = .* harmonic 0 of omega = 2.5"):
        replace_parameter(OSC, TWO, None, "forcing.harmonics.0.omega", 2.5)


def test_two_walls_are_moved_together_past_where_either_alone_could_go() -> None:
    osc = Oscillator(stops=(Wall(0.0, "below"), Wall(1.0, "above")))
    changes = {"oscillator.stops.0.at": 5.0, "oscillator.stops.1.at": np.float64(6.0)}

    moved, _, _ = replace_parameters(osc, None, None, changes)

    assert moved == Oscillator(stops=(Wall(5.0, "below"), Wall(6.0, "above")))
    with pytest.raises(ParameterError, match=r"^oscillator\.stops\.1\.at = 1.0: not above"):
        replace_parameter(osc, None, None, "oscillator.stops.0.at", 5.0)


def test_a_bad_value_is_refused_under_its_full_path() -> None:
    with pytest.raises(ParameterError, match=r"^oscillator\.stops\.0\.restitution = 1.1: outside"):
        replace_parameter(OSC, None, None, "oscillator.stops.0.restitution", 1.1)
    with pytest.raises(ParameterError, match=r"^start\.x0 = nan: not finite"):
        replace_parameter(OSC, None, START, "start.x0", math.nan)


@pytest.mark.parametrize(
    ("force", "path", "reason"),
    [
        (sine(3.0), "forcing.omga", "did you mean forcing.omega"),
        (sine(3.0), "oscillator.stop.0.restitution", "did you mean oscillator.stops.0.restitution"),
        (None, "forcing.omega", "the motion is free, it has no forcing"),
        (TWO, "forcing.omega", "one of 2 harmonics; write forcing.harmonics.0.omega for the first"),
        (sine(3.0), "oscillator.stops.2.at", "did you mean oscillator.stops.1.at"),
        (sine(3.0), "zzz", "there are oscillator.stiffness, oscillator.damping"),
        (sine(3.0), 3, "no such parameter"),
    ],
)
def test_an_unknown_path_is_refused_with_the_nearest_ones(
    force: Forcing | None, path: str, reason: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        get_parameter(OSC, force, None, path)

    assert caught.value.name == "path"
    assert reason in caught.value.reason


def test_the_damping_ratio_is_refused_with_the_coefficient_that_it_sets() -> None:
    massive = Oscillator.from_mass(2, stiffness=18, damping_ratio="0.1")

    with pytest.raises(ParameterError, match=r"ratio only sets oscillator\.damping_coefficient"):
        get_parameter(massive, None, None, "oscillator.damping_ratio")


def test_a_parameter_named_in_both_its_forms_is_refused() -> None:
    changes = {"forcing.omega": 1.0, "forcing.harmonics.0.omega": 2.0}

    with pytest.raises(ParameterError, match="named twice"):
        replace_parameters(impact_oscillator(), sine(3.0), None, changes)


@pytest.mark.parametrize(
    ("path", "meant"),
    [
        ("forcing.peroid", "did you mean forcing.period"),
        ("period", "did you mean forcing.period?"),
        ("forcing.Period", "did you mean forcing.period"),
        ("oscillator.stops.1.restitution", "no number: oscillator.stops.1.restitution is a table"),
        (
            "oscillator.stops.1.restitution.value.0",
            "did you mean oscillator.stops.1.restitution.values.0",
        ),
        ("r", "is a table of speeds"),
    ],
)
def test_periods_and_tables_are_named_in_messages(path: str, meant: str) -> None:
    table = restitution_table([0, 1], ["0.9", "0.8"])
    osc = Oscillator(1, stops=(SoftStop(-1, "below", 9), Wall(1, "above", table)))
    with pytest.raises(ParameterError) as error:
        long_form(path, osc, cosine(2))
    assert meant in str(error.value)


def test_a_period_that_is_tied_or_missing_is_not_meant() -> None:
    w = parameter("w", 2)
    for force in (cosine(w), cosine("1.3") + cosine("2.9"), None):
        with pytest.raises(ParameterError) as error:
            long_form("forcing.peroid", Oscillator(1), force)
        assert "forcing.period" not in str(error.value)
