"""Hops from a wall, found from the derivatives at their start, and by the search of a step."""

from __future__ import annotations

import random

import numpy as np
import pytest

import percuss as pc
from percuss.kernels.event_location import HIT, NONE
from percuss.kernels.flight import Flight, acceleration_and_jerk, move, set_phases
from percuss.kernels.law_columns import FIRST_HARMONIC, LOWER_FORCE, STEP
from percuss.kernels.next_event import event_of_hop, first_event
from percuss.model.system import law as law_of

FORCE = pc.fourier(2.7, cos=(1.0, 0.4), sin=(0.2, -0.3))
OSCILLATORS = {
    "wall": pc.impact_oscillator(0.8),
    "damped": pc.Oscillator(1.0, 0.3, (pc.Wall(0.0, "below", 0.8),)),
    "overdamped": pc.Oscillator(1.0, 5.0, (pc.Wall(0.0, "below", 0.8),)),
    "unstable": pc.Oscillator(-0.5, 0.0, (pc.Wall(0.0, "below", 0.8),)),
}


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_hops_land_where_the_search_by_pieces_finds_them(oscillator: str) -> None:
    law = law_of(OSCILLATORS[oscillator], FORCE)
    region = FIRST_HARMONIC + 2
    step = float(law[region, STEP])
    phases, arrival = np.empty((2, 2)), np.empty((2, 2))
    random.seed(8)
    found = 0
    for _ in range(600):
        t = random.uniform(0.0, 3.0)
        set_phases(law, t, 0.0, phases)
        force = float(law[region, LOWER_FORCE])
        v = 10.0 ** random.uniform(-9.0, 0.0)
        second, third = acceleration_and_jerk(law, region, force, phases, 0.0, v)
        if not (second < 0.0 and 2.0 * v < 0.8 * step * -second):
            continue
        flight = Flight(law, region, (t, 0.0, v, force), phases, arrival)
        reach = (0.0, 0.1)

        hop = event_of_hop(flight, reach, (0.0, 0.0), second, third)

        expected = first_event(flight, reach, (0.0, 0.0), step)
        if hop.verdict == NONE:
            continue
        found += 1
        assert (hop.verdict, hop.side) == (HIT, -1.0) == (expected.verdict, expected.side)
        assert hop.s + hop.rest == pytest.approx(expected.s + expected.rest, rel=1e-12)
        assert hop.value == pytest.approx(expected.value, rel=1e-12)
        # Nothing is passed before it.
        assert min(move(flight, hop.s * part)[0] for part in np.linspace(0.01, 0.99, 50)) > 0.0
    assert found > 150


def test_the_same_from_a_wall_above() -> None:
    below = law_of(OSCILLATORS["wall"], pc.cosine(2.7))
    above = law_of(pc.Oscillator(stops=(pc.Wall(0.0, "above", 0.8),)), pc.cosine(2.7, -1.0))
    region = FIRST_HARMONIC + 1
    phases = np.array([[-1.0, 0.0]])
    arrival = np.empty((1, 2))
    up = Flight(below, region, (0.0, 0.0, 0.01, 0.0), phases, arrival)
    down = Flight(above, region, (0.0, 0.0, -0.01, 0.0), phases, arrival)

    one = event_of_hop(up, (0.0, np.inf), (0.0, 0.0), -1.0, 0.0)
    other = event_of_hop(down, (-np.inf, 0.0), (0.0, 0.0), 1.0, 0.0)

    assert one.verdict == other.verdict == HIT
    assert (one.s, one.side, one.value) == (other.s, -other.side, -other.value)


def test_what_is_in_doubt_is_left_open() -> None:
    law = law_of(OSCILLATORS["wall"], FORCE)
    region = FIRST_HARMONIC + 2
    phases, arrival = np.empty((2, 2)), np.empty((2, 2))
    set_phases(law, 1.2, 0.0, phases)
    v = 1e-3
    second, third = acceleration_and_jerk(law, region, 0.0, phases, 0.0, v)
    assert second < 0.0
    flight = Flight(law, region, (1.2, 0.0, v, 0.0), phases, arrival)
    near = v * v / -second
    no, yes = (0.0, 0.0), (0.0, np.inf)

    def verdict(reach: tuple[float, float], free: tuple[float, float], pull: float) -> np.int64:
        return event_of_hop(flight, reach, free, pull, third).verdict

    assert verdict(yes, no, second) == HIT
    # A bound so near that the hop might meet it; not from this bound; taken up after a graze; a
    # force that is a rounding; one that turns before the mass is back.
    assert verdict((0.0, near), no, second) == NONE
    assert verdict((-1.0, np.inf), no, second) == NONE
    assert verdict(yes, (1e-3, 1e-3), second) == NONE
    assert verdict(yes, no, -1e-9) == NONE
    assert event_of_hop(flight, yes, no, second, second * second / v).verdict == NONE
