"""Records as values: their faults, sums, periods and paths."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
import pytest

import percuss as pc
from percuss.model import (
    as_fraction,
    draft,
    faults,
    get_parameter,
    parameter_paths,
    replace_parameter,
)
from percuss.model.exact import PiTimes
from percuss.model.force_record import ForceRecord


@pytest.mark.parametrize(
    ("t", "f", "name", "words"),
    [
        ([0, 1, 1], [1, 2, 3], "t.2", "the instant of t.1, too"),
        ([0, 2, 1], [1, 2, 3], "t.2", "before t.1 = 2"),
        ([0, 1, 2], [1, math.nan, 3], "f.1", "not finite"),
        ([0, math.inf, 2], [1, 2, 3], "t.1", "not finite"),
        ([0], [1], "t", "two samples"),
        ([0, 1, 2], [1, 2], "t", "3 instants for 2 forces"),
        ([0, 1], ["a", 2], "f.0", "number"),
        (7, [1, 2], "t", "not a sequence"),
        ([0, 1e-200], [0, 1e100], "t.1", "steeper"),
    ],
)
def test_what_is_no_record_is_told_in_a_sentence(
    t: object, f: object, name: str, words: str
) -> None:
    with pytest.raises(pc.ParameterError, match=f"forcing.record.{name} = .*{words}"):
        pc.record(t, f)  # type: ignore[arg-type]


def test_all_faults_of_a_record_are_told_at_once() -> None:
    value = draft(
        ForceRecord, t=(0.0, math.nan), f=(1.0, math.nan), kind="spline", outside="all", amplitude=0
    )
    names = [fault.name for fault in faults(value, "forcing.record")]
    assert names == [f"forcing.record.{name}" for name in ("kind", "outside", "t.1", "f.1")]


def test_numbers_counts_and_order_of_samples_are_told_together() -> None:
    value = draft(ForceRecord, t=(0, 2.0, 2.0, "x", 1, "0.5"), f=(0.0, "nan", 1e200, 3))

    found = {fault.name: fault.reason for fault in faults(value, "record")}

    assert list(found) == [f"record.{name}" for name in ("t.3", "f.1", "t", "t.2", "t.5")]
    assert found["record.t"].startswith("6 instants for 4 forces")
    assert "the instant of t.1, too" in found["record.t.2"]
    assert "before t.4 = 1" in found["record.t.5"]
    alone = draft(ForceRecord, t=(1, 0, 2), f=3)
    assert [fault.name for fault in faults(alone, "")] == ["f", "t.1"]


def test_arrays_texts_and_fractions_are_taken_exactly() -> None:
    force = pc.record(np.array([0.0, 0.5]), ["0.1", Fraction(1, 3)])
    assert force.record is not None
    assert force.record.t == (0.0, 0.5)
    assert force.record.f == ("0.1", Fraction(1, 3))
    assert force == pc.record([0.0, 0.5], ["0.1", Fraction(1, 3)])
    assert force != pc.record([0.0, 0.5], ["0.1", Fraction(1, 3)], "hold")


def test_a_sum_has_a_period_only_if_its_parts_agree() -> None:
    wave = pc.square_wave(2)
    assert (wave + pc.cosine(2)).period == wave.period == math.pi
    assert (wave + pc.cosine(2)).frequency == 2
    assert (wave + pc.cosine(3)).period is None
    assert (wave + pc.Forcing(constant=1)).period == math.pi
    assert (wave + pc.fourier(2, cos=(1, 2))).base == 2
    assert (wave + pc.fourier(2, cos=(1, 2))).period == math.pi
    once = pc.record([0, 1], [0, 1])
    assert once.period is None
    assert (once + pc.cosine(2)).period is None
    assert pc.record([0, "0.1", "0.3"], [0, 1, 0], repeat=True).period == 0.3
    whole = pc.Forcing((pc.Harmonic(1, 3),), period="2*pi", record=wave.record)
    assert whole.period == 2 * math.pi
    with pytest.raises(pc.ParameterError, match=r"period = .*periods of the record"):
        pc.Forcing(period="pi/3", record=wave.record)
    with pytest.raises(pc.ParameterError, match="does not repeat"):
        pc.Forcing(period=1, record=once.record)
    with pytest.raises(pc.ParameterError, match="both forces have a record"):
        _ = wave + once


def test_a_record_in_seconds_shares_its_period_with_harmonics_in_hertz() -> None:
    swell = pc.record([0, "0.5", 2], [0, 1, 0], repeat=True)
    f = pc.parameter("f", "1.5")
    omegas: tuple[Any, ...] = (
        "pi",
        "2*pi",
        pc.pi_times(3),
        2 * pc.pi_times(1) * f,
        pc.expression("pi"),
    )
    for omega in omegas:
        both = swell + pc.cosine(omega)
        assert both.exact_period == PiTimes(Fraction(0), Fraction(2))
    assert (swell + pc.cosine("2*pi") + pc.cosine("3*pi")).period == 2
    assert (swell + pc.cosine("1.25*pi")).period is None
    # A double next to pi is not pi.
    assert (swell + pc.cosine(math.pi)).period is None
    assert (pc.square_wave(2) + pc.cosine(4)).period == math.pi
    assert (pc.square_wave(2) + pc.fourier(4, cos=(0, 1))).exact_period == pc.pi_times(1)


def test_a_record_is_kept_when_something_else_is_replaced() -> None:
    osc, force = pc.impact_oscillator("0.8"), pc.square_wave("1.5", "0.3") + pc.cosine(3)
    paths = parameter_paths(osc, force)
    assert "forcing.record.amplitude" in paths
    assert "forcing.record.omega" in paths
    _, other, _ = replace_parameter(osc, force, None, "forcing.constant", 2)
    assert other is not None
    assert other.record is force.record
    _, other, _ = replace_parameter(osc, force, None, "forcing.record.omega", "1.6")
    assert other == pc.square_wave("1.6", "0.3") + pc.cosine(3)
    assert get_parameter(osc, force, None, "forcing.record.amplitude") == "0.3"
    with pytest.raises(pc.ParameterError, match=r"forcing.record.omega = -1: not positive"):
        replace_parameter(osc, force, None, "forcing.record.omega", -1)
    assert "forcing.record.omega" not in parameter_paths(osc, pc.record([0, 1], [0, 1]))


def test_the_amplitude_and_the_frequency_of_a_wave_may_be_expressions() -> None:
    w = pc.parameter("w", 2)
    force = pc.square_wave(w, "0.15" * w**2)
    osc = pc.Oscillator()
    assert parameter_paths(osc, force)[-1] == "w"
    _, other, _ = replace_parameter(osc, force, None, "w", 3)
    assert other is not None
    assert other.record is not None
    assert other.period == pytest.approx(2 * math.pi / 3, rel=1e-15)
    halved = other.per_mass(2).record
    assert halved is not None
    assert as_fraction(halved.amplitude) == Fraction(27, 40)


def test_a_long_record_prints_in_a_line() -> None:
    force = pc.record(np.arange(1000.0), np.zeros(1000))
    assert "<1000 samples from 0.0 to 999.0>" in repr(force)
    short = ForceRecord((0, 1), (0, 2))
    assert eval(repr(short), {"ForceRecord": ForceRecord}) == short


@pytest.mark.parametrize("width", [0, 1, -0.1, "x"])
def test_a_pulse_lasts_a_part_of_its_period(width: object) -> None:
    with pytest.raises(pc.ParameterError, match="width"):
        pc.pulses(2, width)  # type: ignore[arg-type]


def test_what_is_not_to_be_had_under_a_record_says_so() -> None:
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    with pytest.raises(pc.ParameterError, match="not to be had under a record; give harmonics"):
        pc.velocity_gap_curve(osc, pc.square_wave(2))


@pytest.mark.parametrize(
    ("t", "f", "message"),
    [
        ([3, 2, 1], [0, 1, 0], r"forcing\.record\.t = '3 to 1': in reverse order; turn both t and"),
        (np.zeros((3, 2)), [0, 1, 0], r"t = 'an array of shape \(3, 2\)': not a sequence of num"),
        (pd.DataFrame({"t": [0, 1], "f": [1, 2]}), [0, 1], r"'a table with the columns t, f': not"),
        ("0, 1", [0, 1], "not a sequence of numbers; give one column"),
    ],
)
def test_what_is_no_column_of_samples_is_said(t: object, f: object, message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.record(t, f)  # type: ignore[arg-type]
