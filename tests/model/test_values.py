from __future__ import annotations

import dataclasses
import pickle
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from percuss.errors import (
    MissingExtraError,
    OutputError,
    ParameterError,
    PercussError,
    StudyError,
)
from percuss.model import (
    Component,
    Fault,
    Forcing,
    FourierTerm,
    Harmonic,
    Oscillator,
    SoftStop,
    Start,
    Wall,
    backlash_oscillator,
    ball_on_table,
    bilinear_oscillator,
    fourier,
    impact_oscillator,
    pi_times,
    sine,
)

VALUES = (
    Component(Fraction(3), 0.0, 1.0),
    Fault("damping", -0.1, "negative"),
    Forcing((Harmonic(1.0, 2), Harmonic("0.5", 3)), constant=Decimal("0.1"), period=pi_times(2)),
    FourierTerm(2, "0.1"),
    Harmonic(1.0, "2.8", pi_times(1, 3)),
    Oscillator(stops=(Wall(0, "below"),)),
    SoftStop(Decimal("1.5"), "above", Fraction(1, 3), 0.1),
    Start(0.0, "0.45"),
    Wall("-1", "below", "0.7"),
    backlash_oscillator(gap=1.0, stiffness=100.0),
    ball_on_table(amplitude=0.9, omega=1.0, restitution=0.8),
    bilinear_oscillator(stiffness_below=400.0),
    fourier(2.0, cos=(1.0, 0.2), sin=(0.0, 0.1), constant=-0.5),
    impact_oscillator(),
    pi_times(2, 3) + "0.25",
    sine(3.0, phase=0.3),
)


@pytest.mark.parametrize("value", VALUES)
def test_a_value_survives_pickling_and_is_a_key(value: object) -> None:
    copy = pickle.loads(pickle.dumps(value))

    assert copy == value
    assert {copy: "found"}[value] == "found"
    assert repr(copy) == repr(value)


@pytest.mark.parametrize("value", [value for value in VALUES if not isinstance(value, tuple)])
def test_a_value_cannot_be_changed(value: object) -> None:
    first = dataclasses.fields(value)[0].name  # type: ignore[arg-type]

    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(value, first, 0.0)
    # A new name meets the frozen dataclass in some versions of Python, the slots in others.
    with pytest.raises((AttributeError, TypeError)):
        value.note = "mine"  # type: ignore[attr-defined]


def test_a_value_keeps_what_was_given() -> None:
    wall = Wall(at=Decimal("-1.50"), side="below", restitution="0.70")

    assert repr(wall) == "Wall(at=Decimal('-1.50'), side='below', restitution='0.70')"


def test_numpy_scalars_become_python_numbers() -> None:
    two: Any = np.int64(2)
    half: Any = np.float32(0.5)
    above: Any = np.str_("above")

    force = sine(np.float64(3.0), amplitude=two, phase=half)
    osc = impact_oscillator(half, side=above)

    assert "np." not in repr(force) + repr(osc)
    assert osc == impact_oscillator(0.5, side="above")


def test_equal_numbers_make_equal_values_and_a_text_is_not_its_double() -> None:
    assert impact_oscillator(wall=0) == impact_oscillator(wall=0.0)
    assert impact_oscillator(0.8) != impact_oscillator("0.8")


@pytest.mark.parametrize(
    "error",
    [
        MissingExtraError("certified mode needs python-flint", "certified"),
        OutputError("out", "holds files already"),
        ParameterError("damping", -0.1, "negative"),
        StudyError([Fault("run.t_end", -1, "not after t0 = 0"), "unknown key 'strat'"]),
    ],
)
def test_an_error_travels_back_from_a_worker_process(error: PercussError) -> None:
    copy = pickle.loads(pickle.dumps(error))

    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)


def test_a_parameter_error_is_a_value_error_and_a_missing_extra_an_import_error() -> None:
    assert issubclass(ParameterError, ValueError)
    assert issubclass(MissingExtraError, ImportError)
