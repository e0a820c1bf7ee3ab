from __future__ import annotations

import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import Cloud
from percuss.certified.first_root import BallStretch, FloatStretch, Level, Search
from percuss.certified.flight import EnclosedFlight
from percuss.certified.step import Arrival, Departure, first_arrival
from percuss.certified.system import BallSystem, system_of

FORCE = pc.Forcing((pc.Harmonic("1.3", "1.7", "0.4"), pc.Harmonic("0.6", "2.9", 1)), "-0.2")
# Name, oscillator and the bound from which the flight starts, away from it upwards.
LAWS = {
    "oscillating": pc.impact_oscillator("0.8"),
    "damped": pc.impact_oscillator("0.8", damping="0.3"),
    "critical": pc.impact_oscillator("0.8", stiffness=1, damping=1),
    "overdamped": pc.impact_oscillator("0.8", damping="1.7"),
    "gravity alone": pc.impact_oscillator("0.8", stiffness=0),
    "drag alone": pc.impact_oscillator("0.8", stiffness=0, damping="0.4"),
    "unstable": pc.impact_oscillator("0.8", stiffness="-0.2"),
    "resonant": pc.impact_oscillator("0.8", stiffness="2.89"),
    "soft": pc.Oscillator(1, "0.1", (pc.SoftStop("-0.1", "below", 40, "0.5"),)),
}


def arrival(system: BallSystem, t: arb, v: arb) -> Arrival:
    above = next(i for i, region in enumerate(system.regions) if region.lower == 0)
    start = Departure(above, Cloud.of(t, v), 0)
    found = first_arrival(system, start, arb.pos_inf(), 0.3)
    assert found is not None
    return found


@pytest.mark.parametrize("name", LAWS)
def test_the_derivative_on_a_set_holds_the_slope_between_any_two_of_its_starts(name: str) -> None:
    system = system_of(LAWS[name], FORCE)
    with ctx.workprec(200):
        t, v, step = arb("0.3"), arb("0.7"), arb(10) ** -12
        base = arrival(system, t, v).point
        for k, moved in enumerate(((t + step, v), (t, v + step))):
            shifted = arrival(system, *moved).point
            box = arrival(system, *(z + arb(0, 2e-12) for z in (t, v)))
            for j in range(2):
                slope = (shifted[j] - base[j]) / step
                assert box.derivative[j][k].overlaps(slope)
                # And hardly more.
                assert box.derivative[j][k].rad() < 1e-6 * (1 + abs(slope))


@pytest.mark.parametrize("name", LAWS)
def test_a_box_of_starts_lands_in_the_box_of_landings(name: str) -> None:
    system = system_of(LAWS[name], FORCE)
    with ctx.workprec(120):
        t, v, size = arb("0.3"), arb("0.7"), 1e-6
        whole = arrival(system, t + arb(0, size), v + arb(0, size)).box
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                point = arrival(system, t + i * size, v + j * size).point
                assert whole[0].overlaps(point[0])
                assert whole[1].overlaps(point[1])


@pytest.mark.parametrize("kind", [FloatStretch, BallStretch])
def test_stretches_tell_positive_and_falling_polynomials(
    kind: type[FloatStretch | BallStretch],
) -> None:
    clear = kind.of([arb(1), arb(-1), arb("0.3")])
    falls = kind.of([arb(1), arb(-2), arb("0.1")])
    bends = kind.of([arb("0.25"), arb(-1), arb(1)])  # (s - 1/2)^2

    assert clear.is_clear(0.0, 1.0, 3)
    assert not clear.is_clear(0.31, 1.0, 3)
    assert not clear.falls_through(0.0, 0.0, 1.0, 3)
    assert falls.falls_through(0.0, 0.0, 1.0, 3)
    assert not falls.falls_through(1.0, 3.0, 1.0, 3)
    assert abs(falls.root(1.0) - 0.513167) < 1e-6
    assert not bends.is_clear(0.0, 1.0, 3)
    assert not bends.falls_through(0.0, 0.0, 1.0, 3)


def test_balls_tell_clearances_that_floats_do_not() -> None:
    with ctx.workprec(256):
        hair = arb(10) ** -40
        coefficients = [arb(1) + hair, arb(-2), arb(1)]  # (1 - s)^2 and a hair
        assert not FloatStretch.of(coefficients).is_clear(0.0, 1.0, 3)
        # On [0, 1] the Bernstein coefficients are 1, 0, 0 and a hair.
        assert BallStretch.of(coefficients).is_clear(0.0, 1.0, 3)


def test_a_dip_between_two_samples_is_seen() -> None:
    # x'' = -x from 1 + d: the lowest place is -1 - d, at pi; beyond the wall at -1 for 3e-4.
    system = system_of(pc.impact_oscillator(wall=-1), None)
    for start, hits in (("1.00000001", True), ("0.99999999", False)):
        with ctx.workprec(128):
            flight = EnclosedFlight(law_of(system), 0, [], arb(start), arb(0))
            level = Level(0, 1, law_of(system).places[0])
            search = Search(flight, [level], None, 1, width=1.0, least=1e-9, sharp=False)
            found = search.first(6.0)
            assert (found is not None) is hits
            if found is not None:
                assert 3.141 < found.low < found.high < 3.142


def test_a_start_that_leaves_too_slowly_is_a_question() -> None:
    system = system_of(pc.impact_oscillator(), None)
    with ctx.workprec(64):
        start = Departure(0, Cloud.of(arb(0), arb(0, 1e-9)), 0)
        with pytest.raises(Undecided):
            first_arrival(system, start, arb(10), 1.0)
