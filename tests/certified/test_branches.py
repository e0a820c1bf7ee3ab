"""Stretches of a parameter over which a system is not one and the same."""

from __future__ import annotations

from fractions import Fraction

import pytest

import percuss as pc
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.branch import system_over
from percuss.certified.system import system_of

HAIR = Fraction(1, 10**30)


def test_a_part_of_the_forcing_that_is_zero_amid_a_stretch_is_not_left_out_of_all_of_it() -> None:
    system = system_of(pc.impact_oscillator(), pc.fourier(2, cos=(1, "0.1")))

    with pytest.raises(Undecided, match="a part of the forcing goes"):
        system_over(system, "forcing.cos.1", -HAIR, HAIR)
    assert system_over(system, "forcing.cos.1", HAIR, 2 * HAIR).moved is not None


def test_stops_that_change_their_order_on_a_stretch_are_not_in_that_of_its_middle() -> None:
    stops = pc.SoftStop("0.3", "above", 4), pc.SoftStop("0.5", "above", 9)
    system = system_of(pc.Oscillator(1, 0, stops), pc.cosine(2))
    half = Fraction(1, 2)

    with pytest.raises(Undecided, match="stops change their order"):
        system_over(system, "oscillator.stops.0.at", half - HAIR, half + 2 * HAIR)
    assert system_over(system, "oscillator.stops.0.at", half - 2 * HAIR, half - HAIR).moved
