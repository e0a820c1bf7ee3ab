from __future__ import annotations

import math

import pytest
from flint import arb, ctx
from tests.certified.motions import ELASTIC, chaotic

import percuss as pc
from percuss.certified import Ending
from percuss.errors import ParameterError


def test_hops_without_end_stop_at_the_most_events(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("percuss.certified.march.MOST_EVENTS", 50)
    run = pc.simulate(pc.impact_oscillator(), pc.Forcing(constant=-1), v0="0.01", t_end=3.0)

    proven = pc.certify(run)

    assert proven.outcome is Ending.most_events
    assert len(proven.impacts) == 50


def test_impacts_that_never_come_are_no_endless_loop() -> None:
    run = pc.simulate(pc.impact_oscillator(wall=-3), pc.cosine(2), x0=0.5, t_end=10.0)

    proven = pc.certify(run, max_impacts=1)

    assert proven.outcome is Ending.no_event
    assert "no stop again" in proven.reason


def test_an_impact_at_the_very_end_is_left_out_and_told() -> None:
    run = pc.simulate(ELASTIC, v0=1, t_end=7.0)

    proven = pc.certify(run, t_end="2*pi")

    assert proven.outcome is Ending.impact_at_t_end
    assert len(proven.impacts) == 1
    assert proven.complete
    # The impact may be before that or not: v is of either sign there.
    with ctx.workprec(200):
        assert proven.t_end.arb < 2 * arb.pi()
    assert proven.t_end.mid() == pytest.approx(2 * math.pi)
    with pytest.raises(ParameterError, match="outside of what is proven"):
        proven("2*pi")


def test_what_follows_the_last_impact_is_not_claimed() -> None:
    # Whether the next one is still within the last one's radius is not looked at.
    run = pc.simulate(pc.impact_oscillator("1/2"), pc.cosine(2), v0=1, max_impacts=2)

    proven = pc.certify(run, bits=40)

    last = proven.impacts.t[1]
    assert last.radius() > 1e-12
    with pytest.raises(ParameterError, match="outside of what is proven"):
        proven(last.mid())
    assert proven(last.mid() - 2 * last.radius())[1][0].mid() < 0


def test_a_proof_can_be_watched_and_stopped() -> None:
    seen: list[float] = []

    def watch(done: float, total: float) -> bool:
        seen.append(done / total)
        return len(seen) < 10

    proven = pc.certify(chaotic(50), progress=watch)

    assert proven.outcome is Ending.interrupted
    assert not proven.complete
    assert len(proven.impacts) == 10
    assert seen == sorted(seen)
    assert 0.15 < seen[-1] < 0.25
