from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import percuss as pc
from percuss.certified import Ending


def test_resting_where_no_force_acts_is_proven_for_ever() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=9), t_end=3.0)

    proven = pc.certify(run)

    assert proven.outcome is Ending.at_rest
    assert proven(2.0)[0][0].contains(0)


def test_chatter_contact_and_release_are_enclosed() -> None:
    # A ball of v = 2 under gravity 1, r = 1/2: hops 4, 2, 1, ... add up to 8.
    run = pc.simulate(pc.Oscillator(0, stops=(pc.Wall(0, "below", "1/2"),)),
                      pc.Forcing(constant=-1), v0=2, t_end=20.0)  # fmt: skip

    proven = pc.certify(run)

    assert proven.contacts.start[0].contains(8)
    assert proven.contacts.start[0].digits() >= 12
    assert proven.outcome is Ending.at_rest
    # Between the last hop and the rest the ball is at most as high as the last hop.
    x, _ = proven([7.99999999999])
    assert x.radius()[0] < 1e-9
    assert x.mid()[0] + x.radius()[0] >= 0


def test_a_run_that_ends_at_rest_is_proven_to_rest_for_ever() -> None:
    run = pc.simulate(pc.Oscillator(0, stops=(pc.Wall(0, "below", "1/2"),)),
                      pc.Forcing(constant=-1), v0=2, max_impacts=1000)  # fmt: skip

    proven = pc.certify(run)

    assert proven.outcome is Ending.at_rest
    assert proven.contacts.start[0].contains(8)
    assert proven(1e6)[0].mid() == 0.0
    assert float(proven.sample(3).t[-1]) == pytest.approx(8.0)


def test_forced_chatter_is_released_where_the_force_lets_go() -> None:
    run = pc.simulate(pc.impact_oscillator("0.8"), pc.cosine("2.7"), v0=1, t_end=60.0)

    proven = pc.certify(run)

    assert len(proven.contacts) == len(run.contacts) == 3
    np.testing.assert_allclose(proven.contacts.start.mid(), run.contacts.start, atol=1e-9)
    for release in proven.contacts.release:
        # cos(2.7 t) = 0 there, whatever was before.
        assert (release.arb * arb("2.7")).cos().contains(0)
        assert release.radius() < 1e-13


def test_a_run_that_ends_where_chatter_does_is_proven_up_to_its_last_hop() -> None:
    run = pc.simulate(pc.Oscillator(0, stops=(pc.Wall(0, "below", "1/2"),)),
                      pc.Forcing(constant=-1), v0=2, t_end=8.0)  # fmt: skip

    proven = pc.certify(run, t_end=8)

    assert proven.outcome is Ending.chatter
    assert 7.99 < proven.t_end.mid() < 8.0
    assert len(proven.impacts) >= 20


@pytest.mark.parametrize("power", [16, 30, 60])
def test_a_force_that_keeps_its_sign_by_a_hair_holds_after_a_chatter_too(power: int) -> None:
    # At most -10^-power, once in 2 pi; where the chatter ends is known to 1e-12 only.
    force = pc.cosine(1, constant=-1 - Fraction(1, 10**power))
    run = pc.simulate(pc.impact_oscillator("1/2"), force, v0="0.1", t0=3, t_end=20.0)

    proven = pc.certify(run)

    assert proven.outcome is Ending.at_rest
    assert len(proven.contacts) == 1
    assert proven.contacts.start.radius()[0] > 1e-20


def test_the_impacts_of_an_accumulation_are_told_to_be_infinitely_many() -> None:
    osc = pc.impact_oscillator("1/2")
    run = pc.simulate(osc, pc.Forcing(constant=-1), x0="1", t_end=20.0)
    few = pc.simulate(osc, pc.Forcing(constant=-1), x0="1", max_impacts=2)

    chatter, started = pc.certify(run), pc.certify(few)

    assert chatter.accumulations == 1
    count = len(chatter.impacts)
    assert f"{count} impacts listed, and infinitely many in each accumulation" in repr(chatter)
    assert started.accumulations == 0
    assert "infinitely" not in repr(started)
