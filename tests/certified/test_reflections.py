"""Families with flights that end early: closed exactly, or not claimed to be."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.families import ReflectedMotion
from percuss.certified.statements import repeats_after
from percuss.certified.system import system_of
from percuss.errors import ParameterError

WALL = pc.impact_oscillator()


def family(v0: float, n: int, periods: int) -> pc.PeriodicOrbit:
    return pc.find_orbit(WALL, pc.sine(3), n_impacts=n, n_periods=periods, guess=(0.0, v0))


@pytest.mark.parametrize(
    ("v0", "n", "periods"), [(0.45, 6, 6), (0.3, 6, 6), (0.1, 14, 12), (0.495, 14, 12)]
)
def test_families_below_the_critical_velocity_are_proven(v0: float, n: int, periods: int) -> None:
    orbit = family(v0, n, periods)

    proven = pc.certify(orbit)

    assert proven.exists, proven
    assert (proven.isolated, proven.admissible, proven.stability) == (False, True, "parabolic")
    assert proven.period.contains(f"{2 * periods}*pi/3")
    assert proven.n_impacts == n
    run = pc.simulate(WALL, pc.sine(3), v0=proven.v0.mid(), t0=proven.t0.mid(), max_impacts=n)
    np.testing.assert_allclose(proven.impacts.t.mid()[1:], run.impacts.t[:-1], atol=1e-11)


def test_the_times_of_six_impacts_are_those_of_the_closed_form() -> None:
    with ctx.workprec(200):
        system = system_of(WALL, pc.sine(3))
        motion = ReflectedMotion(system, arb(0), arb("0.45"))
        early = (arb("0.9").sqrt()).asin()
        pi = arb.pi()
        expected = [pi, pi + early, 2 * pi + early, 3 * pi - early, 4 * pi - early, 4 * pi]

        for time in expected:
            assert not motion.is_closed
            motion.fly()
            assert motion.t.overlaps(time)
            assert motion.t.rad() < 1e-40

        assert motion.is_closed
        assert motion.half_periods == 4


def test_a_start_that_has_another_pattern_does_not_close() -> None:
    verdict = repeats_after(WALL, pc.sine(3), "0.495", 6)

    assert verdict.holds is False
    assert repeats_after(WALL, pc.sine(3), "0.495", 14).holds is True


@pytest.mark.parametrize("digits", [6, 9, 12])
def test_six_impacts_begin_and_end_where_theory_says(digits: int) -> None:
    root, near = 2.0 * math.sqrt(2.0), 10.0**-digits
    low, high = (5.0 - root) / 16.0, (5.0 + root) / 16.0

    found = [
        repeats_after(WALL, pc.sine(3), v, 6).holds
        for v in (low - near, low + near, high - near, high + near)
    ]

    assert found == [False, True, True, False]


def test_a_touch_is_open() -> None:
    # At V0 = 1/2 the second flight touches the wall half way.
    assert repeats_after(WALL, pc.sine(3), "1/2", 6).holds is None


@pytest.mark.parametrize(
    ("osc", "force"),
    [
        (pc.impact_oscillator("0.99"), pc.sine(3)),
        (pc.impact_oscillator(wall="1/1000000"), pc.sine(3)),
        (pc.impact_oscillator(damping="1/1000000"), pc.sine(3)),
        (WALL, pc.sine("3.000001")),
        (WALL, pc.sine(2)),
        (pc.backlash_oscillator(gap=1, stiffness=3), pc.sine(3)),
    ],
)
def test_without_the_closed_form_nothing_is_claimed(osc: pc.Oscillator, force: pc.Forcing) -> None:
    assert repeats_after(osc, force, "0.45", 6).holds is None


def test_motion_into_the_wall_is_no_start() -> None:
    with ctx.workprec(120), pytest.raises(Undecided):
        ReflectedMotion(system_of(WALL, pc.sine(3)), arb(0), arb("-0.45")).fly()


def test_a_family_is_not_claimed_for_another_force() -> None:
    import dataclasses

    moved = dataclasses.replace(family(0.45, 6, 6), forcing=pc.sine(3, "1.2"))

    proven = pc.certify(moved, most_bits=300)

    # 0.45 of a force 1.2 is 0.375 of 1: six impacts again, but at times of their own.
    assert proven.exists
    early = math.asin(math.sqrt(0.75))
    assert any(abs(t - (math.pi + early)) < 1e-9 for t in proven.impacts.t.mid())


@pytest.mark.parametrize("n", [0, -1, True, 10**9])
def test_numbers_of_impacts_out_of_range_are_refused(n: Any) -> None:
    with pytest.raises(ParameterError, match="n_impacts"):
        repeats_after(WALL, pc.sine(3), "0.45", n)


def test_an_isolated_orbit_is_never_made_of_a_family() -> None:
    import dataclasses

    pretended = dataclasses.replace(family(0.45, 6, 6), isolated=True)

    proven = pc.certify(pretended, most_bits=300)

    # Krawczyk's test must fail: the equations are singular on the whole family.
    assert not proven.exists
