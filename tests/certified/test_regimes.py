from __future__ import annotations

import math
import time
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified import CertifiedRun, Ending
from percuss.certified.ball_law import BallLaw, law_of
from percuss.certified.event_location import fourth_around
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import ball
from percuss.certified.system import system_of


@pytest.mark.parametrize(
    ("osc", "force", "x", "v"),
    [
        # Resonance without damping from rest: t sin(t)/2.
        (pc.Oscillator(), pc.cosine(1), lambda t: t * t.sin() / 2, None),
        # Critical damping: t exp(-t).
        (pc.Oscillator(1, 1), None, lambda t: t * (-t).exp(), 1),
        # Overdamped: (exp(-t) - exp(-3 t))/2.
        (pc.Oscillator(3, 2), None, lambda t: ((-t).exp() - (-3 * t).exp()) / 2, 1),
        # Free flight and gravity.
        (pc.Oscillator(0), pc.Forcing(constant=-2), lambda t: t - t * t, 1),
        # Free flight with drag: (1 - exp(-t))/1 for a = 1/2.
        (pc.Oscillator(0, 0.5), None, lambda t: 1 - (-t).exp(), 1),
        # Thrown off an unstable spring: sinh(2 t)/2.
        (pc.Oscillator(-4), None, lambda t: (2 * t).sinh() / 2, 1),
        # Near resonance: (cos(w t) - cos(t))/(1 - w^2).
        (
            pc.Oscillator(),
            pc.cosine("1.0000000001"),
            lambda t: (
                ((t * arb("1.0000000001")).cos() - t.cos())
                / (1 - arb("1.0000000001") * arb("1.0000000001"))
            ),
            None,
        ),
    ],
)
def test_every_linear_regime_is_its_formula(osc, force, x, v) -> None:  # type: ignore[no-untyped-def]
    run = pc.simulate(osc, force, v0=v or 0, t_end=5.0)

    proven = pc.certify(run, bits=200)

    place = proven(3.25)[0][0]
    assert place.arb.overlaps(x(arb(3.25)))
    assert place.digits() > 20


def test_soft_stops_a_million_times_stiffer_are_followed() -> None:
    osc = pc.bilinear_oscillator(stiffness_below="1e12")
    run = pc.simulate(osc, pc.sine(2), v0=1, t_end=30.0)

    proven = pc.certify(run)

    assert list(proven.crossings.direction) == list(run.crossings.direction)
    np.testing.assert_allclose(proven.crossings.t.mid(), run.crossings.t, atol=1e-10)
    assert proven.crossings.v.digits().min() > 8


def test_two_stops_at_one_float_are_two_exactly() -> None:
    stops = (pc.SoftStop("0.2", "above", 3), pc.SoftStop(0.2, "above", 5))
    run = pc.simulate(pc.Oscillator(stops=stops), x0=0.0, v0=1.0, t_end=3.0)

    proven = pc.certify(run)

    assert list(proven.crossings.stop[:2]) == [0, 1]
    assert proven.crossings.t.arbs[1] - proven.crossings.t.arbs[0] > 0


@pytest.mark.parametrize(
    ("osc", "force"),
    [
        (pc.impact_oscillator(), pc.cosine("1.000000000000000000001")),
        (pc.impact_oscillator(damping="1e-21"), pc.cosine(1)),
        (pc.impact_oscillator(stiffness="1.000000000000000000001"), pc.cosine(1)),
    ],
)
def test_motions_close_to_resonance_are_those_of_resonance(
    osc: pc.Oscillator, force: pc.Forcing
) -> None:
    run = pc.simulate(osc, force, v0=1, max_impacts=20)
    resonant = pc.simulate(pc.impact_oscillator(), pc.cosine(1), v0=1, max_impacts=20)
    start = time.process_time()

    near, resonance = pc.certify(run, digits=25), pc.certify(resonant, digits=25)

    assert time.process_time() - start < 1.0
    np.testing.assert_allclose(near.impacts.t.mid(), resonance.impacts.t.mid(), rtol=1e-15)
    # The derivative of an impact time by the detuning is some tens, here and there none.
    differences = [
        abs(a - b) for a, b in zip(near.impacts.t.arbs, resonance.impacts.t.arbs, strict=True)
    ]
    assert max(float(d) for d in differences) < 1e-18
    assert sum(d > 1e-22 for d in differences) >= 10


@pytest.mark.parametrize("detuning", ["1e-20", "1e-34", "1e-60"])
def test_damping_hardly_above_none_near_resonance_is_that_of_resonance(detuning: str) -> None:
    osc = pc.Oscillator(stiffness=1 + Fraction(detuning) ** 2, damping=detuning)
    run = pc.simulate(osc, pc.cosine(1), t_end=5.0)

    proven = pc.certify(run)

    # t sin(t)/2, but for some multiple of the detuning.
    assert abs(proven([3.0])[0].mid()[0] - 1.5 * math.sin(3.0)) < 1e-15
    assert proven([3.0])[0].digits()[0] > 12


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("offset", ["1e-30", "1e-90"])
def test_damping_hardly_off_critical_is_critical_but_for_that(sign: int, offset: str) -> None:
    run = pc.simulate(pc.Oscillator(1 + sign * Fraction(offset), 1), v0=1, t_end=5.0)

    place = pc.certify(run, bits=128)([3.0])[0]

    # t exp(-t) (1 - sign offset t^2/6 + ...).
    assert abs(place.mid()[0] - 3.0 * math.exp(-3.0)) < 1e-15
    assert place.digits()[0] > 35


def test_the_norm_may_grow_where_the_stiffness_is_a_wide_ball() -> None:
    # (pace^2 x^2 + v^2)^(1/2) grows by (pace - K/pace)/2 for each K in the ball.
    system = system_of(pc.Oscillator(), pc.cosine(2))
    wide = BallLaw(system, "oscillator.stiffness", arb(1, 0.125)).regions[0]
    exact = BallLaw(system).regions[0]

    assert wide.growth > 0.5 * (wide.pace - 0.875 / wide.pace)
    assert exact.growth == 0.0


def test_the_fourth_derivative_is_bounded_on_both_sides_of_a_landing() -> None:
    # Almost without a spring, where the force has its steepest: x'''' = f'' is zero there.
    system = system_of(pc.Oscillator("1e-14"), pc.Forcing((pc.Harmonic(1, 1),), constant="0.5"))
    law = law_of(system)
    flight = EnclosedFlight(law, 0, law.phasors_at(0), arb(0), arb(1))
    s, trial = arb.pi() / 2, arb(1e-3)
    assert flight.region.cancels

    _, size = flight.derivatives(s, 3)
    bound = fourth_around(flight, s, trial, size)

    for part in (-1.0, -0.5, 0.0, 0.5, 1.0):
        derivatives, _ = flight.derivatives(s + part * trial, 4)
        assert abs(derivatives[4]) <= bound


def test_a_motion_beyond_all_floats_ends_the_proof_and_says_so() -> None:
    run = pc.simulate(pc.Oscillator(-1, stops=(pc.Wall(-1, "below", 1),)), v0=1, t_end=10.0)

    proven = pc.certify(run, t_end=1e4)

    assert proven.outcome is Ending.no_event
    assert "beyond all floats" in proven.reason
    assert 700 < proven.t_end.mid() < 720
    assert len(proven.grazes) == 0


@pytest.mark.parametrize("fast", ["1e-34", "1e-9", "1e12", "1e30"])
@pytest.mark.parametrize("long", ["1e-9", "1e9"])
@pytest.mark.parametrize("bits", [128, 800])
def test_other_units_of_time_and_length_change_nothing_else(
    fast: str, long: str, bits: int
) -> None:
    plain = _bouncing(Fraction(1), Fraction(1), bits)
    w, size = Fraction(fast), Fraction(long)

    scaled = _bouncing(w, size, bits)

    assert len(scaled.impacts) == len(plain.impacts) == 30
    with ctx.workprec(2 * bits):
        for ours, theirs in zip(scaled.impacts.t.arbs, plain.impacts.t.arbs, strict=True):
            assert (ours * ball(w)).overlaps(theirs)
        speeds = zip(scaled.impacts.v_after.arbs, plain.impacts.v_after.arbs, strict=True)
        assert all(ours.overlaps(theirs * ball(w * size)) for ours, theirs in speeds)
    assert scaled.impacts.t.digits().min() > plain.impacts.t.digits().min() - 8


def _bouncing(w: Fraction, size: Fraction, bits: int) -> CertifiedRun:
    """Return low hops in units of time and length."""
    osc = pc.Oscillator(w * w, w / 10, (pc.Wall(0, "below", "4/5"),))
    force = pc.Forcing((pc.Harmonic(size * w * w, w * Fraction(3, 2)),), constant=-2 * size * w * w)
    run = pc.simulate(osc, force, v0=size * w / 1000, t_end=float(100 / w))
    return pc.certify(run, max_impacts=30, bits=bits)
