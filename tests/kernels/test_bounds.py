"""What the proof that no event is missed rests on: bounds, departures, decided touches."""

from __future__ import annotations

import math

import mpmath
import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.kernels.exact_flight import Rest

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.event_location import GRAZE, HIT, NONE, departure, first_root
from percuss.kernels.flight import (
    Flight,
    acceleration_and_jerk,
    derivative_bound,
    four_derivatives,
    move,
)
from percuss.kernels.law_columns import FIRST_HARMONIC, FORCE_BOUND, STEP
from percuss.model.system import law as law_of

STATES = st.floats(-10.0, 10.0)
NO_PHASES = np.empty((0, 2))


@given(
    stiffness=st.sampled_from([-4.0, -0.1, 0.0, 1e-3, 1.0, 400.0]),
    damping=st.sampled_from([0.0, 0.1, 1.0, 30.0]),
    omega=st.sampled_from([0.1, 1.0, 7.0]),
    order=st.sampled_from([0, 1, 2]),
    x=STATES,
    v=STATES,
    phase=st.floats(0.0, 6.3),
)
@settings(max_examples=150)
def test_no_derivative_exceeds_its_bound_within_a_step(
    stiffness: float, damping: float, omega: float, order: int, x: float, v: float, phase: float
) -> None:
    """Of the exact motion, at 33 points of the step."""
    rest = Rest(stiffness, damping, omega)
    law, region = rest.law, rest.region
    phases = np.array([[math.cos(phase), math.sin(phase)]])
    # Around x = 0, where no constant force acts, in `order` 0; else from wherever x is.
    force = -stiffness * x
    start = (0.0, 0.0, v, force)
    second, third = acceleration_and_jerk(law, region, force, phases, 0.0, v)
    given_two = ((x, v), (v, second), (second, third))[order]
    step = float(law[region, STEP])

    most = float(law[0, FORCE_BOUND + order])
    bound = derivative_bound(law, region, most, *given_two, step)

    arrival = np.empty((1, 2))
    for s in np.linspace(0.0, step, 33):
        y, speed = move(Flight(law, region, start, phases, arrival), float(s))
        derivatives = four_derivatives(law, region, force, arrival, y, speed)
        assert abs(derivatives[order]) <= bound * (1.0 + 1e-12) + 1e-12


@given(
    v=st.floats(-3.0, -0.1),
    force=st.floats(0.1, 3.0),
    depth=st.floats(-16.0, -3.0),
    sign=st.sampled_from([-1.0, 1.0]),
)
@settings(max_examples=200)
def test_touch_of_a_shallow_minimum_is_decided_rightly_or_called_a_graze(
    v: float, force: float, depth: float, sign: float
) -> None:
    """y = v sin s + force (1 - cos s) has its minimum force - hypot(v, force)."""
    law = law_of(pc.Oscillator(), None)
    with mpmath.workdps(40):
        lowest = mpmath.mpf(force) - mpmath.hypot(mpmath.mpf(v), mpmath.mpf(force))
        distance = float(lowest + sign * 10**depth)
        clearance = float(lowest - distance)
    assume(distance < 0.0)

    root = first_root(
        Flight(law, FIRST_HARMONIC, (0.0, 0.0, v, force), NO_PHASES, NO_PHASES),
        (1.0, distance),
        (0.0, 6.0),
    )

    if root.verdict == GRAZE:
        assert abs(clearance) <= 2.0 * root.rest <= 1e-13 * (abs(v) + force)
    else:
        assert root.verdict == (HIT if clearance < 0.0 else NONE)
    if root.verdict == HIT:
        with mpmath.workdps(40):
            # (v, force) turned: the clearance is hypot(v, force) [1 - cos(s - bottom)] + lowest.
            bottom = mpmath.atan2(-v, force)
            off = mpmath.acos(1 + (lowest - distance) / mpmath.hypot(v, force))
            exact = bottom - off
        # A rounding of the displacement by its slope.
        slope = max(abs(v * math.cos(root.s) + force * math.sin(root.s)), 1e-16)
        assert abs(root.s - float(exact)) <= 1e-14 * (1.0 + 1.0 / slope)


@given(v=st.floats(1e-300, 10.0), force=st.floats(-10.0, 10.0), longest=st.floats(1e-6, 3.0))
def test_a_flight_is_free_of_the_bound_it_leaves_for_as_long_as_promised(
    v: float, force: float, longest: float
) -> None:
    law = law_of(pc.Oscillator(), None)

    free = departure(
        Flight(law, FIRST_HARMONIC, (0.0, 0.0, v, force), NO_PHASES, NO_PHASES), 1.0, longest
    )

    assert 0.0 < free <= longest
    # y / sin(s) = v + force tan(s / 2) is monotonic.
    assert v + force * math.tan(free / 2.0) > 0.0


def test_departure_is_decided_by_the_first_derivative_that_is_not_zero() -> None:
    rows: list[tuple[pc.Forcing, float, bool]] = [
        (pc.cosine(1.0), 0.0, True),
        (pc.cosine(1.0, amplitude=-1.0), 0.0, False),
        (pc.sine(1.0), 0.0, True),
        (pc.sine(1.0, amplitude=-1.0), 0.0, False),
        (pc.cosine(1.0, constant=-1.0), 0.0, False),
        (pc.cosine(1.0, amplitude=-1.0, constant=1.0), 0.0, True),
    ]
    for force, v, leaves in rows:
        law = law_of(pc.Oscillator(), force)
        start = (0.0, 0.0, v, float(force.constant))
        at_zero: Floats = np.array([[1.0, 0.0]])

        free = departure(Flight(law, FIRST_HARMONIC + 1, start, at_zero, at_zero), 1.0, 0.5)

        assert (free > 0.0) == leaves, force
