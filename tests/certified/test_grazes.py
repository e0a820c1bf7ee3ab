from __future__ import annotations

import math
from fractions import Fraction

import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified import Ending
from percuss.errors import ParameterError
from percuss.model import Exact


def test_a_touch_without_velocity_ends_the_proof_there_and_says_so() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2", wall=-1), x0=1.0, t_end=20.0)

    proven = pc.certify(run)

    assert proven.outcome is Ending.graze
    assert not proven.complete
    assert proven.grazes.t[0].contains("pi")
    assert proven.grazes.clearance[0].contains(0)
    assert abs(proven.t_end.mid() - math.pi) < 1e-9
    assert proven([3.0])[0].radius()[0] < 1e-12
    with pytest.raises(ParameterError, match="outside of what is proven"):
        proven(4.0)


@pytest.mark.parametrize(
    ("start", "impacts"),
    [
        ("0.9999999999999", 0),
        ("1.0000000000001", 1),
        (f"0.{'9' * 28}", 0),
        (f"1.{'0' * 27}1", 1),
        (f"0.{'9' * 90}", 0),
        (f"1.{'0' * 89}1", 1),
    ],
)
def test_a_graze_by_a_hair_is_decided(start: str, impacts: int) -> None:
    run = pc.simulate(pc.impact_oscillator("1/2", wall=-1), x0=1.0, t_end=8.0)

    proven = pc.certify(run, start=pc.Start(start, 0))

    assert proven.outcome is Ending.reached_t_end
    assert len(proven.impacts) == impacts


@pytest.mark.parametrize("stiffness", [9, "-1/2"])
@pytest.mark.parametrize("digits", [12, 60])
def test_a_soft_stop_touched_by_a_hair_is_entered_and_left(stiffness: Exact, digits: int) -> None:
    osc = pc.Oscillator(stops=(pc.SoftStop(-1, "below", stiffness),))
    run = pc.simulate(osc, x0=1.0, t_end=5.0)

    # Depth 1e-70: in and out again within some 1e-35 of pi.
    proven = pc.certify(run, digits=digits, start=pc.Start(1 + Fraction(1, 10**70), 0))

    assert proven.complete
    assert list(proven.crossings.direction) == ["in", "out"]
    into, out = proven.crossings.t.arbs
    with ctx.workprec(600):
        assert into < arb.pi() < out
        # Free fall over 1e-70, twice.
        assert abs((out - into) / (2 * (2 * arb(10) ** -70).sqrt()) - 1) < 1e-9


def test_a_force_that_touches_zero_leaves_the_release_open() -> None:
    # f = cos t - 1 holds the mass, but for an instant at 2 pi.
    force = pc.cosine(1, constant=-1)
    run = pc.simulate(pc.impact_oscillator("1/2"), force, t0=1, t_end=20.0)

    proven = pc.certify(run)

    assert proven.outcome is Ending.graze
    assert "the force on the mass at rest" in proven.reason
    assert abs(proven.t_end.mid() - 2 * math.pi) < 1e-9
    assert len(proven.contacts) == 1
    assert math.isnan(proven.contacts.release.mid()[0])
