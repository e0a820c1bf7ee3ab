from __future__ import annotations

import math
import time
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import percuss as pc
from percuss.certified import CertifiedRun, Ending
from percuss.errors import ParameterError

ELASTIC = pc.impact_oscillator()


def chaotic(n: int) -> pc.Trajectory:
    osc = pc.impact_oscillator("0.8", side="above")
    return pc.simulate(osc, pc.cosine("2.8"), v0=-1, max_impacts=n)


def test_balls_of_few_bits_overlap_and_hold_those_of_many() -> None:
    run = chaotic(40)
    fine = pc.certify(run, bits=512)

    for bits in (53, 128, 256):
        coarse = pc.certify(run, bits=bits)
        n = len(coarse.impacts)
        assert n >= 15 if bits == 53 else n == 40
        for name in ("t", "v_before", "v_after"):
            ours = getattr(coarse.impacts, name).arbs
            theirs = getattr(fine.impacts, name).arbs
            assert all(a.contains(b.mid()) for a, b in zip(ours, theirs, strict=False))
            # They are no wider than they need be.
            assert all(a.rad() > b.rad() for a, b in zip(ours, theirs, strict=False))


def test_float_runs_lie_within_their_rounding_of_the_balls() -> None:
    run = pc.simulate(pc.impact_oscillator("0.9", wall=0.2, damping="0.05"), pc.cosine("1.3"),
                      x0=0.5, t_end=60.0)  # fmt: skip
    proven = pc.certify(run)

    assert len(proven.impacts) == len(run.impacts) > 5
    np.testing.assert_allclose(run.impacts.t, proven.impacts.t.mid(), rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.impacts.v_before, proven.impacts.v_before.mid(), atol=1e-12)
    np.testing.assert_allclose(run.impacts.cycle, proven.impacts.cycle.mid(), atol=1e-12)
    np.testing.assert_allclose(run.impacts.intervals, proven.impacts.intervals.mid(), atol=1e-12)
    times = np.linspace(0.0, 60.0, 50).reshape(5, 10)
    for ours, theirs in zip(run(times), proven(times), strict=True):
        assert theirs.mid().shape == (5, 10)
        np.testing.assert_allclose(ours, theirs.mid(), rtol=0, atol=1e-12)
        assert theirs.radius().max() < 1e-12


def test_bits_are_spent_as_the_exponent_demands() -> None:
    n = 200
    run = chaotic(n)

    proven = pc.certify(run, bits=400)

    # log2 of how neighbours part over all impacts, from the exact motion's own derivatives.
    demanded = _growth_in_bits(proven)
    assert demanded / n > 0.3
    assert proven.bits_per_impact < 1.25 * demanded / n + 0.1 + 2 * math.log2(n) / n


def _growth_in_bits(proven: CertifiedRun) -> float:
    """Return log2 of the norm of the product of the impact map's derivatives, in floats."""
    omega, r = 2.8, 0.8
    times = [0.0, *proven.impacts.t.mid()]
    speeds = [-1.0, *proven.impacts.v_after.mid()]
    product, logarithm = np.eye(2), 0.0
    for i in range(len(times) - 1):
        s, v0 = times[i + 1] - times[i], speeds[i]
        a0, a1 = math.cos(omega * times[i]), math.cos(omega * times[i + 1])
        v1 = proven.impacts.v_before.mid()[i]
        c, d = math.cos(s), math.sin(s)
        x_by = np.array([-(c * v0 + d * a0), d])
        v_by = np.array([d * v0 - c * a0, c])
        t_by = -x_by / v1
        product = np.array([t_by, -r * (v_by + a1 * t_by)]) @ product
        size = float(np.abs(product).max())
        product, logarithm = product / size, logarithm + math.log2(size)
    return logarithm


def test_an_elastic_motion_of_a_thousand_impacts_takes_less_than_a_second() -> None:
    run = pc.simulate(ELASTIC, pc.sine(3), v0="0.45", max_impacts=1000)
    start = time.process_time()

    proven = pc.certify(run)

    assert time.process_time() - start < 1.0
    assert len(proven.impacts) == 1000
    assert proven.impacts.t.digits().min() >= 12
    # Neighbours part no faster than in proportion to the number of impacts squared.
    assert proven.bits_per_impact < 0.1


def test_a_chaotic_motion_of_two_hundred_impacts_takes_less_than_two_seconds() -> None:
    run = chaotic(200)
    start = time.process_time()

    proven = pc.certify(run)

    assert time.process_time() - start < 2.0
    assert len(proven.impacts) == 200
    assert proven.impacts.t.digits().min() >= 12


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


def test_an_impact_at_the_start_counts() -> None:
    run = pc.simulate(pc.impact_oscillator("1/2"), pc.cosine(2), v0=-1, max_impacts=1)

    proven = pc.certify(run)

    assert len(proven.impacts) == len(run.impacts) == 1
    assert proven.outcome is Ending.reached_max_impacts


def test_forced_chatter_is_released_where_the_force_lets_go() -> None:
    run = pc.simulate(pc.impact_oscillator("0.8"), pc.cosine("2.7"), v0=1, t_end=60.0)

    proven = pc.certify(run)

    assert len(proven.contacts) == len(run.contacts) == 3
    np.testing.assert_allclose(proven.contacts.start.mid(), run.contacts.start, atol=1e-9)
    for release in proven.contacts.release:
        # cos(2.7 t) = 0 there, whatever was before.
        assert (release.arb * arb("2.7")).cos().contains(0)
        assert release.radius() < 1e-13


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


@pytest.mark.parametrize(("start", "impacts"), [("0.9999999999999", 0), ("1.0000000000001", 1)])
def test_a_graze_by_a_hair_is_decided(start: str, impacts: int) -> None:
    run = pc.simulate(pc.impact_oscillator("1/2", wall=-1), x0=1.0, t_end=8.0)

    proven = pc.certify(run, start=pc.Start(start, 0))

    assert proven.outcome is Ending.reached_t_end
    assert len(proven.impacts) == impacts


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


def test_a_run_that_ends_where_chatter_does_is_proven_up_to_its_last_hop() -> None:
    run = pc.simulate(pc.Oscillator(0, stops=(pc.Wall(0, "below", "1/2"),)),
                      pc.Forcing(constant=-1), v0=2, t_end=8.0)  # fmt: skip

    proven = pc.certify(run, t_end=8)

    assert proven.outcome is Ending.chatter
    assert 7.99 < proven.t_end.mid() < 8.0
    assert len(proven.impacts) >= 20


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


def test_too_few_bits_end_early_and_stay_right() -> None:
    run = chaotic(200)

    proven = pc.certify(run, bits=64)

    assert not proven.complete
    assert 20 < len(proven.impacts) < 200
    whole = pc.certify(run)
    assert all(a.overlaps(b) for a, b in zip(proven.impacts.t, whole.impacts.t, strict=False))


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
    ("name", "value"), [("digits", 0), ("digits", 2.5), ("bits", 4), ("most_bits", True)]
)
def test_bad_numbers_are_refused(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=name):
        pc.certify(chaotic(2), **{name: value})  # type: ignore[call-overload]


def test_what_is_no_result_is_refused() -> None:
    with pytest.raises(ParameterError, match="neither a run, nor an orbit"):
        pc.certify(ELASTIC)  # type: ignore[call-overload]


def test_a_start_inside_the_wall_is_refused() -> None:
    with pytest.raises(ParameterError, match="below the wall"):
        pc.certify(pc.simulate(ELASTIC, v0=1, t_end=3.0), start=pc.Start(-1, 0))


def test_samples_and_text_show_the_enclosure() -> None:
    proven = pc.certify(pc.simulate(ELASTIC, pc.sine(3), v0=1, t_end=9.0))

    data = proven.sample(7)

    assert dict(data.sizes) == {"t": 7}
    assert float(data.x_radius.max()) < 1e-12
    assert "proven up to t_end" in repr(proven)
    assert proven.impacts.t[0].text(10).startswith("3.14159265") or "3.1415" in repr(
        proven.impacts.t[0]
    )


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


def test_threads_do_not_disturb_one_another() -> None:
    alone = [pc.certify(chaotic(n), digits=d).impacts.t[n - 1] for n, d in ((20, 8), (60, 40))]

    with ThreadPoolExecutor(4) as pool:
        jobs = [(20, 8), (60, 40)] * 4
        together = list(pool.map(lambda job: pc.certify(chaotic(job[0]), digits=job[1]), jobs))

    for run, ball in zip(together, alone * 4, strict=True):
        assert run.impacts.t.arbs[-1].rad() == ball.arb.rad()


@pytest.mark.parametrize(
    ("osc", "force"),
    [
        (pc.impact_oscillator(), pc.cosine("1.000000000000000000001")),
        (pc.impact_oscillator(damping="1e-21"), pc.cosine(1)),
        (pc.impact_oscillator(stiffness="1.000000000000000000001"), pc.cosine(1)),
    ],
)
def test_motions_beside_resonance_are_those_of_resonance(
    osc: pc.Oscillator, force: pc.Forcing
) -> None:
    run = pc.simulate(osc, force, v0=1, max_impacts=20)
    resonant = pc.simulate(pc.impact_oscillator(), pc.cosine(1), v0=1, max_impacts=20)
    start = time.process_time()

    beside, there = pc.certify(run, digits=25), pc.certify(resonant, digits=25)

    assert time.process_time() - start < 1.0
    np.testing.assert_allclose(beside.impacts.t.mid(), there.impacts.t.mid(), rtol=1e-15)
    # The derivative of an impact time by the detuning is some tens, here and there none.
    apart = [abs(a - b) for a, b in zip(beside.impacts.t.arbs, there.impacts.t.arbs, strict=True)]
    assert max(float(d) for d in apart) < 1e-18
    assert sum(d > 1e-22 for d in apart) >= 10


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


def test_a_stroboscopic_view_is_at_exact_periods() -> None:
    run = pc.simulate(pc.impact_oscillator("0.8"), pc.cosine("2.5"), v0=0.6, t_end=40.0)

    ours, theirs = pc.certify(run).stroboscopic(), run.stroboscopic()

    assert dict(ours.sizes) == dict(theirs.sizes)
    np.testing.assert_allclose(ours.x, theirs.x, atol=1e-12)
    np.testing.assert_allclose(ours.v, theirs.v, atol=1e-12)
    assert float(ours.x_radius.max()) < 1e-14
    with pytest.raises(ParameterError, match="period"):
        pc.certify(pc.simulate(ELASTIC, v0=1, t_end=3.0)).stroboscopic()


def test_floats_of_known_times_are_inside_of_what_is_proven() -> None:
    # The end is a ball narrower than a float's rounding.
    chaotic = pc.simulate(pc.impact_oscillator("0.8", side="above"), pc.cosine("2.8"), v0=-1,
                          max_impacts=60)  # fmt: skip
    for run in (chaotic, pc.simulate(ELASTIC, pc.sine(3), v0=1, t0="2*pi", max_impacts=2)):
        proven = pc.certify(run)

        low, high = proven.known_times

        assert 0.0 <= low - run.t0 < 1e-14
        assert arb(high) < proven.t_end.arb
        assert proven.t_end.mid() - high < 1e-12
        assert proven.sample(3).sizes == {"t": 3}
