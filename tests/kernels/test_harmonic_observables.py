"""The highest point of a harmonic flight, against a search among samples."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import pytest

import percuss as pc
from percuss.kernels import harmonic_observables as seen
from percuss.kernels.flight import Flight, constant_force, set_phases
from percuss.kernels.harmonic_flight import bounds_of, harmonic_step, margins, motion_of
from percuss.kernels.law_columns import FIRST_HARMONIC
from percuss.kernels.step import walk_of
from percuss.model.oscillator import Side
from percuss.model.system import law

REGION = FIRST_HARMONIC + 1
Case: TypeAlias = tuple[float, float, float, Side, float]
SETTINGS: tuple[tuple[float, float, Side, float], ...] = (
    (0.0, 0.8, "below", 0.0),
    (0.1, 0.7, "above", 0.4),
)
# Forcing frequency, damping, restitution, side of the wall and its place: humps of all kinds, next
# to resonance, where the parts of the motion cancel, and with a fast force that hardly moves it.
CASES: list[Case] = [
    (omega, damping, restitution, side, at)
    for omega in (0.7, 0.99, 1.01, 1.1, 1.5, 2.2, 2.8, 5.0, 11.0)
    for damping, restitution, side, at in SETTINGS
]


def flights_of(case: Case) -> list[tuple[Flight, float]]:
    """Return flights from impact to impact with their times."""
    omega, damping, restitution, side, at = case
    osc = pc.Oscillator(1.0, damping, (pc.Wall(at, side, restitution),))
    force = pc.cosine(omega)
    sign = 1.0 if side == "below" else -1.0
    run = pc.simulate(osc, force, at, 0.8 * sign, max_impacts=70)
    table = law(osc, force)
    found = []
    impacts = run.impacts
    for i in range(len(impacts) - 1):
        t, s = float(impacts.t[i]), float(impacts.t[i + 1] - impacts.t[i])
        phases, arrival = np.empty((2, 1, 2))
        set_phases(table, t, 0.0, phases)
        start = (t, 0.0, float(impacts.v_after[i]), constant_force(table, REGION, at))
        flight = Flight(table, REGION, start, phases, arrival)
        # A contact or a slow landing may lie between two impacts.
        if abs(seen.place_in(flight, s)[0]) > 1e-9:
            continue
        found.append((flight, s))
    return found


def highest_sample(flight: Flight, s: float, sign: float) -> float:
    low, high = 0.0, s
    for _ in range(8):
        times = np.linspace(low, high, 201)
        y = [sign * seen.place_in(flight, float(each))[0] for each in times]
        k = int(np.argmax(y))
        low, high = times[max(k - 2, 0)], times[min(k + 2, 200)]
    return max(y)


@pytest.mark.parametrize("case", CASES[::4])
def test_the_highest_point_is_that_of_a_search(
    case: Case,
) -> None:
    sign = 1.0 if case[3] == "below" else -1.0
    flights = flights_of(case)
    missing = 0
    for flight, s in flights:
        top = seen.flight_summit(flight, sign, s)
        if math.isnan(top):
            missing += 1
        else:
            # Both terms of the motion are as large as the gain next to resonance.
            size = 1.0 + 1.0 / abs(1.0 - case[0] ** 2)
            highest = highest_sample(flight, s, sign)
            assert top == pytest.approx(highest, rel=0, abs=4e-15 * size)
    long = sum(s * bounds_of(flight.law, REGION)[2] > 1.0 for flight, s in flights)
    assert len(flights) - missing > 0.9 * long > 20


@pytest.mark.parametrize("case", CASES)
def test_no_step_goes_above_its_bound(case: Case) -> None:
    sign = 1.0 if case[3] == "below" else -1.0
    for flight, s in flights_of(case)[::10]:
        motion, bounds = motion_of(flight.law, REGION), bounds_of(flight.law, REGION)
        walk, begin = walk_of(flight.law, REGION), seen.begin_of(flight, sign)
        fourth, _, slack = margins(motion, bounds, begin)
        step = bounds[0]
        before = (0.0, begin[3], begin[1], begin[2])
        for k in range(min(math.ceil(s / step), 20)):
            after = harmonic_step(walk, begin[0], before)
            own = seen.fourth_of_step(motion, bounds, begin[0], before, fourth)
            top = seen.top_of_step(step, before, after, own, slack)
            times = step * (k + np.linspace(0.0, 1.0, 21))
            y, v = np.array([seen.harmonic_place(motion, begin, float(each)) for each in times]).T
            assert y.max() <= (max(y[0], y[-1]) + slack if top == -math.inf else top)
            if top == -math.inf:
                assert (v > -slack).all() or (v < slack).all()
            before = after


def test_a_flight_too_short_for_the_closed_form_is_left_open() -> None:
    case: Case = (2.92, 0.1, 0.7, "below", 0.0)
    limit = 0.5
    short = [
        (flight, s)
        for flight, s in flights_of(case)
        if s * bounds_of(flight.law, REGION)[2] < limit
    ]
    assert short
    for flight, s in short:
        assert math.isnan(seen.flight_summit(flight, 1.0, s))
