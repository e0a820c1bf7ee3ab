from __future__ import annotations

import dataclasses
import functools
import math
from fractions import Fraction

import pytest
from flint import arb, ctx
from tests.certified.motions import backlash

import percuss as pc
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.branch import NEXT_TO_ZERO, parameter_size
from percuss.certified.grazing import TurningPoint, clearances_at_ends
from percuss.certified.shooting import Image, Residual, shooting_of
from percuss.certified.system import system_of

IMPACTING = pc.impact_oscillator("0.7", wall="1.5", side="above", damping="0.05")


@functools.cache
def wall_0() -> pc.PeriodicOrbit:
    return pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))


@functools.cache
def points(
    orbit: pc.PeriodicOrbit, path: str, low: float, high: float
) -> dict[str, pc.SpecialPoint]:
    branch = pc.continue_orbit(orbit, over={path: (low, high)})
    return {point.kind: point for point in branch.special_points}


@functools.cache
def impacting(n: int) -> pc.PeriodicOrbit:
    orbits = pc.find_orbits(IMPACTING, pc.cosine("1.5"), max_impacts=1, max_periods=1)
    return next(orbit for orbit in orbits if orbit.n_impacts == n)


def test_a_period_doubling_is_enclosed() -> None:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]

    proven = pc.certify(point)

    # 20 digits by another way: see tests/reference/cases.json, pd-r0.8-n1.
    assert proven.exists
    assert proven.value.arb.overlaps(arb("2.6533477278553229342") + arb(0, 1e-18))
    assert proven.value.digits() >= 12
    assert "2.65334772785" in repr(proven)


@pytest.mark.parametrize("digits", [8, 12, 20])
def test_a_fold_is_enclosed(digits: int) -> None:
    point = points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["fold"]

    proven = pc.certify(point, digits=digits)

    # sigma = G sqrt(1 + (omega k_x / k_d)^2): tests/reference/cases.json, fold-a0.05-r0.7-w1.5.
    assert proven.value.arb.overlaps(arb("2.1214694431410491882") + arb(0, 1e-18))
    assert proven.value.digits() >= digits


@pytest.mark.parametrize("n_impacts", [0, 1])
def test_a_graze_is_enclosed_from_both_sides(n_impacts: int) -> None:
    point = points(impacting(n_impacts), "oscillator.stops.0.at", 0.5, 2.5)["grazing"]

    proven = pc.certify(point)

    # The amplitude of steady motion, 1/|1 - omega^2 + 2 i a omega|.
    omega, a = arb("1.5"), arb("0.05")
    detuning = 1 - omega * omega
    amplitude = 1 / (detuning * detuning + 4 * a * a * omega * omega).sqrt()
    assert proven.value.arb.overlaps(amplitude)
    assert proven.value.digits() >= 12


@pytest.mark.parametrize("kind", ["fold", "grazing"])
def test_hundreds_of_digits_need_no_more_bits_than_they_have(kind: str) -> None:
    point = points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)[kind]

    proven = pc.certify(point, digits=600)

    assert proven.exists, proven.reason
    assert proven.value.digits() >= 600
    assert proven.precision < 600 / math.log10(2) + 100


def test_a_parameter_next_to_zero_has_a_size_beyond_the_greatest_float() -> None:
    wall = pc.Wall("1e260", "above", "0.7")
    osc = pc.Oscillator.from_mass("1e60", "1e60", damping_ratio="1e-6", stops=[wall])
    orbit = pc.find_orbit(osc, pc.cosine(1, "1e306"), 0)

    # At resonance the motion's force on its mass is that of the cosine over twice the ratio.
    size = parameter_size(orbit, "forcing.constant", Fraction(0))

    assert size / NEXT_TO_ZERO / 10**306 == pytest.approx(500_000, rel=1e-3)


@pytest.mark.parametrize("bits", range(150, 158))
def test_a_turning_point_that_stays_is_one_whatever_the_last_bit_is(bits: int) -> None:
    point = points(impacting(0), "oscillator.stops.0.at", 0.5, 2.5)["grazing"]

    assert pc.certify(point, digits=20, bits=bits).exists


def test_too_few_bits_for_the_digits_are_named() -> None:
    point = points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["fold"]

    proven = pc.certify(point, digits=600, most_bits=1000)

    assert not proven.exists
    assert proven.precision == 1000
    assert proven.reason.endswith("; 600 digits were tried with 1000 bits")


def test_a_frequency_as_parameter_moves_the_period_too() -> None:
    located = points(impacting(1), "forcing.omega", 1.0, 2.5)

    fold = pc.certify(located["fold"])

    assert fold.exists
    assert abs(fold.value.mid() - located["fold"].value) < 1e-8
    assert pc.certify(located["grazing"]).exists


def test_restitution_as_parameter() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.655"))
    point = points(orbit, "oscillator.stops.0.restitution", 0.5, 0.95)["period_doubling"]

    proven = pc.certify(point)

    assert proven.exists
    assert abs(proven.value.mid() - point.value) < 1e-8


def test_a_graze_of_a_soft_stop_is_enclosed() -> None:
    osc = pc.Oscillator(1, "0.05", (pc.SoftStop("0.6", "above", 9),))
    orbit = next(
        orbit
        for orbit in pc.find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1)
        if orbit.n_impacts == 1
    )
    located = points(orbit, "oscillator.stops.0.at", 0.3, 2.5)

    proven = pc.certify(located["grazing"])

    assert proven.exists, proven
    assert abs(proven.value.mid() - 0.79430147078953763759) < 1e-12


def test_a_point_of_another_kind_is_left_unproven() -> None:
    point = points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["fold"]
    other = dataclasses.replace(point, kind="branch_point")

    proven = pc.certify(other)

    assert not proven.exists
    assert "branches that cross without a symmetry part" in proven.reason


def test_a_point_that_is_none_is_not_proven() -> None:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]
    other = dataclasses.replace(point, kind="strong_resonance", detail="third")

    assert not pc.certify(other, most_bits=300).exists


def test_a_fold_of_an_orbit_with_several_events_is_enclosed() -> None:
    point = points(backlash(), "forcing.amplitude", 0.3, 2.5)["fold"]
    assert len(point.orbit.itinerary) == 4

    proven = pc.certify(point)

    assert proven.exists, proven
    assert abs(proven.value.mid() - point.value) < 1e-9
    assert proven.value.digits() >= 12


def test_events_that_newtons_steps_take_out_of_order_are_no_fault() -> None:
    point = points(backlash(), "forcing.amplitude", 0.3, 2.5)["grazing"]

    proven = pc.certify(point)

    assert not proven.exists
    assert "does not come after" in proven.reason


def test_the_image_of_a_ball_of_states_holds_the_images_of_its_ends() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    with ctx.workprec(100):
        equations, states = shooting_of(system_of(orbit.oscillator, orbit.forcing), orbit)
        (t, v), size = states[0], arb(10) ** -10

        image_t, image_v = equations.images([(t, v + arb(0, 1e-10))], 100)[0].state

        for end in (v - size, v + size):
            there_t, there_v = equations.images([(t, end)], 100)[0].state
            assert image_t.overlaps(there_t)
            assert image_v.overlaps(there_v)


def test_a_point_of_formal_orbits_stays_formal() -> None:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]
    # The other root of the equations at the same frequency is no motion.
    guess = point.orbit.t0, point.orbit.v0
    with pytest.warns(pc.FormalOrbitWarning):
        formal = pc.find_orbit(wall_0().oscillator, pc.cosine(point.value), guess=guess)

    proven = pc.certify(dataclasses.replace(point, orbit=formal))

    assert proven.exists
    assert proven.is_formal
    assert "formal" in repr(proven)
    assert not pc.certify(point).is_formal
    assert "formal" not in repr(pc.certify(point))


def test_whether_the_orbit_at_a_graze_passes_through_a_stop_is_open() -> None:
    point = points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["grazing"]

    proven = pc.certify(point)

    assert proven.exists
    assert proven.is_formal is None
    assert "is open" in repr(proven)


def test_the_word_of_a_float_run_is_not_taken_for_a_proof_that_an_orbit_is_a_motion() -> None:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]
    changed = dataclasses.replace(point.orbit, admissible=not point.orbit.admissible)
    other = dataclasses.replace(point, orbit=changed)

    assert other.admissible is not point.admissible
    assert pc.certify(other).is_formal is pc.certify(point).is_formal is False


def test_turning_points_at_the_ends_of_a_branch_that_may_be_two_are_left_open() -> None:
    turn = TurningPoint(arb(1), arb(1, 0.125), arb(0, 1))
    near, far = (
        TurningPoint(arb(1.0625), arb(1, 1), arb(1)),
        TurningPoint(arb(2), arb(2, 1), arb(-1)),
    )

    assert clearances_at_ends(turn, [near, near]) == (near.clearance, near.clearance)
    with pytest.raises(Undecided, match="may be two"):
        clearances_at_ends(turn, [near, far])


def test_a_value_and_a_derivative_of_two_roots_of_a_flight_are_no_proof() -> None:
    # At the point the flight has its root at 1; on the box it is another, at 2, that is followed.
    one = (arb(1), arb(0)), (arb(0), arb(1))
    at_1 = Image((arb(0), arb(0)), one, arb(1), arb(1, 0.25), arb(0))
    at_2 = Image((arb(0), arb(0)), one, arb(2), arb(2, 0.25), arb(0))
    found = [at_1, at_2, at_1]
    residual = Residual(lambda _: [found.pop(0)])

    residual.value([arb(0), arb(0)])
    with pytest.raises(Undecided, match="two roots"):
        residual.derivative([arb(0, 1), arb(0, 1)])
    residual.derivative([arb(0, 1), arb(0, 1)])
