from __future__ import annotations

import math
from fractions import Fraction

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


def test_an_impact_at_the_very_end_is_listed_and_what_is_open_is_told() -> None:
    run = pc.simulate(ELASTIC, v0=1, t_end=7.0)

    proven = pc.certify(run, t_end="2*pi")

    assert proven.outcome is Ending.impact_at_t_end
    assert "whether the last impact that is listed comes by t_end is open" in repr(proven)
    assert len(proven.impacts) == 2
    assert proven.impacts.t[1].contains("2*pi")
    assert proven.complete
    # The impact may be before that or not: v is of either sign there.
    with ctx.workprec(200):
        assert proven.t_end.arb < 2 * arb.pi()
    assert proven.t_end.mid() == pytest.approx(2 * math.pi)
    with pytest.raises(ParameterError, match="outside of what is proven"):
        proven("2*pi")


@pytest.mark.parametrize("end", [{"t_end": "20*pi"}, {"periods": 30}])
def test_an_exact_end_is_that_of_the_run_and_the_impact_there_is_listed(
    end: dict[str, str | int],
) -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", **end)  # type: ignore[call-overload]

    proven = pc.certify(run)

    assert len(proven.impacts) == 20
    assert [t.contains(f"{k}*pi") for k, t in enumerate(proven.impacts.t, 1)] == [True] * 20
    assert proven.outcome is Ending.impact_at_t_end
    # The double below is before the impact, for certain.
    before = pc.certify(run, t_end=run.t_end)
    assert len(before.impacts) == 19
    assert before.outcome is Ending.reached_t_end


def test_a_crossing_and_a_release_at_the_very_end_are_listed_too() -> None:
    soft = pc.Oscillator(1, 0, (pc.SoftStop(0, "below", 4),))
    crossing = pc.certify(pc.simulate(soft, x0=1, t_end="pi/2"))

    assert crossing.outcome is Ending.impact_at_t_end
    assert crossing.crossings.t[0].contains("pi/2")
    # The force -cos t holds the mass up to pi/2.
    held = pc.simulate(pc.impact_oscillator("1/2"), pc.cosine(1, amplitude=-1), t_end="pi/2")
    release = pc.certify(held)
    assert release.outcome is Ending.impact_at_t_end
    assert release.contacts.release[0].contains("pi/2")
    assert "the last release" in release.reason


def test_times_beyond_an_exact_end_or_before_an_exact_start_by_less_than_any_ball_are_refused() -> (
    None
):
    run = pc.simulate(pc.impact_oscillator("1/2"), x0=1, t0="pi", t_end=pc.pi_times(3, 2) - "1/10")
    proven = pc.certify(run)
    hair = Fraction(1, 10**60)
    first, last = pc.pi_times(1), pc.pi_times(3, 2) - "1/10"

    for inside in (first, first + hair, last - hair, last):
        assert proven(inside)[0][0].radius() < 1e-12
    for outside in (first - hair, last + hair):
        with pytest.raises(ParameterError, match="outside of what is proven"):
            proven(outside)


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
