from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb
from tests.certified.motions import ELASTIC

import percuss as pc
from percuss.certified import Ending
from percuss.errors import ParameterError
from percuss.model import Phase


def test_a_start_is_taken_exactly_as_text_fraction_or_double() -> None:
    exact, fraction, double = (
        pc.certify(pc.simulate(ELASTIC, pc.sine(3), v0=v0, max_impacts=5), digits=30)
        for v0 in ("0.45", Fraction(9, 20), 0.45)
    )

    assert exact.impacts.t[4].overlaps(fraction.impacts.t[4])
    assert not exact.impacts.t[4].overlaps(double.impacts.t[4])
    assert abs(exact.impacts.t.mid()[4] - double.impacts.t.mid()[4]) < 1e-14


def test_a_start_on_the_wall_into_it_is_an_impact_there() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2"), pc.cosine(2), v0=-1, max_impacts=3)

    proven = pc.certify(run)

    assert proven.impacts.t[0].contains(0)
    assert proven.impacts.v_after[0].contains("1/2")
    np.testing.assert_allclose(run.impacts.t, proven.impacts.t.mid(), atol=1e-13)


def test_a_release_under_a_force_that_starts_at_zero_takes_off_with_the_third_derivative() -> None:
    # x = (sin t - t cos t)/2: the first impact is at tan t = t (Dyskin et al. 2012).
    run = pc.simulate(ELASTIC, pc.sine(1), max_impacts=1)

    t = pc.certify(run).impacts.t[0].arb

    assert (t.tan() - t).contains(0)
    assert t > 4.49
    assert t < 4.5


def test_an_impact_at_the_start_counts() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2"), pc.cosine(2), v0=-1, max_impacts=1)

    proven = pc.certify(run)

    assert len(proven.impacts) == len(run.impacts) == 1
    assert proven.outcome is Ending.reached_max_impacts


def test_a_start_at_a_multiple_of_pi_is_exact_too() -> None:
    # f = sin t is 0 at 2 pi, exactly: the third derivative takes off, as at 0.
    run = pc.simulate(ELASTIC, pc.sine(1), t0="2*pi", max_impacts=1)

    t = pc.certify(run).impacts.t[0].arb

    since = t - 2 * arb.pi()
    assert (since.tan() - since).contains(0)
    # The float 2 pi is before that: the mass rests on the wall till then.
    late = pc.certify(run, start=pc.Start(0, 0, run.t0), max_impacts=1)
    assert len(late.contacts) == 1
    assert late.contacts.release[0].contains("2*pi")


def test_a_start_next_to_a_stop_by_less_than_a_float_is_where_it_was_given() -> None:
    osc = pc.impact_oscillator("1/2", wall="0.2")
    run = pc.simulate(osc, x0="0.20000000000000000001", v0=-1, t_end=1.0)

    proven = pc.certify(run)

    # It takes 1e-20 to the wall; as a float it is there at once.
    assert abs(proven.impacts.t.mid()[0] - 1e-20) < 1e-34
    rounded = pc.certify(run, start=pc.Start(0.2, -1))
    assert rounded.impacts.t.arbs[0].is_zero()


def test_an_exact_start_inside_a_wall_by_less_than_a_float_is_refused() -> None:
    run = pc.simulate(pc.impact_oscillator(wall="0.2"), x0="0.19999999999999999999", t_end=1.0)

    with pytest.raises(ParameterError, match=r"below the wall at x = 1/5, by 1e-20"):
        pc.certify(run)


def test_a_force_that_is_zero_at_the_start_is_told_in_rationals() -> None:
    # A cos t - A pushes into the wall, A - A cos t off it, both with their second derivative;
    # as balls, 0.3 - 0.3 is not zero.
    held, thrown = (
        pc.simulate(
            pc.impact_oscillator("1/2"),
            pc.cosine(1, amplitude=f"{sign}0.3", constant=f"{other}0.3"),
            t_end=3.0,
        )
        for sign, other in (("", "-"), ("-", ""))
    )

    assert len(pc.certify(held).contacts) == 1
    proven = pc.certify(thrown)
    assert len(proven.contacts) == 0
    # x'' + x = A (1 - cos t) from rest: x = A (1 - cos t) - A t sin(t)/2 + ..., 0.3 t^4/24 at
    # first.
    assert proven([0.01])[0].mid()[0] == pytest.approx(0.3 * 0.01**4 / 24, rel=1e-4)


@pytest.mark.parametrize("turn", [0, "2*pi/3"])
def test_phases_whose_cosines_are_rational_are_told_in_rationals_too(turn: Phase) -> None:
    # cos(pi/3) = cos(2 pi/3 - pi/3) = 1/2.
    phase = pc.pi_times(1 if turn == 0 else -1, 3)
    force = pc.cosine(1, amplitude="0.2", phase=phase, constant="-0.1")

    proven = pc.certify(pc.simulate(pc.impact_oscillator("1/2"), force, t0=turn, t_end=4.0))

    assert proven.outcome is Ending.reached_t_end


def test_rest_where_forces_cancel_exactly_is_for_ever() -> None:
    run = pc.simulate(
        pc.impact_oscillator("1/2", wall="1/3"), pc.Forcing(constant="1/3"), x0="1/3", t_end=5.0
    )

    assert pc.certify(run).outcome is Ending.at_rest


def test_a_start_at_rest_off_the_stops_needs_no_sign_of_the_force() -> None:
    # The force is zero there at first: 1/3 - 1/3.
    run = pc.simulate(
        pc.impact_oscillator("1/2"), pc.cosine("1.1", amplitude="1/3"), x0="1/3", t_end=5.0
    )

    proven = pc.certify(run)

    assert proven.complete
    np.testing.assert_allclose(proven.impacts.t.mid(), run.impacts.t, rtol=1e-13)


def test_a_dead_impact_at_a_multiple_of_pi_departs_with_the_third_derivative() -> None:
    # f = sin t is zero at 2 pi, exactly, as is what is left of the velocity.
    run = pc.simulate(pc.impact_oscillator(0), pc.sine(1), v0=-1, t0="2*pi", t_end=12.0)

    proven = pc.certify(run)

    since = proven.impacts.t[1].arb - 2 * arb.pi()
    assert (since.tan() - since).contains(0)
    assert proven.contacts.start[0].overlaps(proven.impacts.t[1])


def test_a_force_of_either_sign_at_a_start_at_rest_is_left_open() -> None:
    # Its middle value, 1/3 - 1/3 = 0, rests for ever; the others are held or thrown off.
    run = pc.simulate(
        pc.impact_oscillator("1/2", wall="1/3"), pc.Forcing(constant="1/3"), x0="1/3", t_end=5.0
    )
    pushed = pc.simulate(
        pc.impact_oscillator("1/2"), pc.cosine(1, amplitude="0.3", constant="-0.3"), t_end=3.0
    )

    for start, middle in ((run, Fraction(1, 3)), (pushed, Fraction(-3, 10))):
        width = Fraction(1, 10**6)
        wide = {"forcing.constant": (middle - width, middle + width)}
        proven = pc.certify(start, over=wide, most_bits=256)

        assert proven.outcome is Ending.force
        assert len(proven.contacts) == 0


@pytest.mark.parametrize("wall", ["0.3", 0.3], ids=["text", "double"])
def test_a_start_in_text_is_never_moved_to_a_stop(wall: float | str) -> None:
    osc = pc.impact_oscillator("1/2", wall=wall)
    run = pc.simulate(osc, x0="0.30000000000000001", v0="-0.5", t_end=1.0)

    proven = pc.certify(run)

    gap = Fraction("0.30000000000000001") - Fraction(wall)
    assert proven.impacts.t[0].mid() == pytest.approx(float(2 * gap), rel=1e-9)
    assert proven.start == run.start
    with pytest.raises(ParameterError, match="below the wall"):
        pc.certify(run, start=pc.Start("0.29999999999999998", -1))


def test_a_float_that_is_moved_to_a_stop_is_told() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2", wall="0.3"), x0=0.3, v0=-1, t_end=1.0)

    proven = pc.certify(run)

    assert proven.start == pc.Start(Fraction(3, 10), -1)
    assert proven.start_given == run.start
    assert "started on the stop, at x0 = 3/10 for 0.3" in repr(proven)
    assert "start.x0" not in proven.doubles


def test_numbers_that_are_not_their_decimals_are_told() -> None:
    run = pc.simulate(pc.impact_oscillator(0.8), pc.cosine(2.8), v0=0.5, max_impacts=2)

    proven = pc.certify(run)

    # 0.5 is 1/2; text and whole numbers are exact.
    assert proven.doubles == ("oscillator.stops.0.restitution", "forcing.harmonics.0.omega")
    assert "taken as doubles: oscillator.stops.0.restitution" in repr(proven)
    exact = pc.simulate(pc.impact_oscillator("0.8"), pc.cosine("2.8"), v0="0.45", max_impacts=2)
    assert pc.certify(exact).doubles == ()
