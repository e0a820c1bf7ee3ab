"""An ODE solver, restarted at the events, has to find the same motion between them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.model.exact import as_float

MIXED = pc.Oscillator(
    1.0,
    0.02,
    (
        pc.Wall(-1.0, "below", 0.7),
        pc.SoftStop(0.5, "above", 29.0, 0.3),
        pc.SoftStop(-0.5, "below", 5.0, 0.0),
        pc.SoftStop(0.5, "above", -1.0, 0.1),
    ),
)
TWO = pc.fourier(2.0, cos=(1.0, 0.2), sin=(0.3, 0.1), constant=0.1)
CASES = {
    "wall": (pc.impact_oscillator(0.8), pc.cosine(2.0), 0.0, 1.0),
    "chatter": (pc.impact_oscillator(0.5), pc.cosine(2.7, constant=-0.5), 0.0, 1.0),
    "mixed stops": (MIXED, TWO, 0.1, 2.0),
    "bilinear": (pc.bilinear_oscillator(stiffness_below=100.0), pc.sine(1.3), 0.0, 1.0),
    "overdamped": (pc.impact_oscillator(0.5, wall=0.05, damping=3.0), TWO, 0.5, -3.0),
    "unstable between walls": (
        pc.Oscillator(-1.0, 0.1, (pc.Wall(-1.0, "below"), pc.Wall(1.0, "above", 0.6))),
        pc.sine(2.0),
        0.1,
        0.0,
    ),
    "free flight": (*pc.ball_on_table(amplitude=0.9, omega=1.0, restitution=0.8), 1.0, 0.0),
}


@pytest.mark.parametrize(("osc", "force", "x0", "v0"), CASES.values(), ids=CASES.keys())
def test_motion_between_events_is_what_a_solver_finds(
    osc: pc.Oscillator, force: pc.Forcing, x0: float, v0: float
) -> None:
    """DOP853 at 1e-12 from each of percuss's own states to the next."""
    from scipy.integrate import solve_ivp

    run = pc.simulate(osc, force, x0, v0, t_end=15.0)
    contacts = np.concatenate([run.contacts.start, run.contacts.release])
    events = np.concatenate([[0.0], run.impacts.t, run.crossings.t, contacts, [15.0]])
    events = np.unique(events[np.isfinite(events)])
    assert len(events) > 5
    for left, right in pairwise(events):
        # A chatter's tail is shorter than the solver's first step; in contact nothing moves.
        if right - left < 1e-3 or is_in_contact(run, left):
            continue
        x, v = run(left)
        middle = 0.5 * (left + right)
        solution = solve_ivp(
            right_hand_side(osc, force, float(run(middle)[0])),
            (left, right),
            [float(x), float(v)],
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            dense_output=True,
        )
        t = np.linspace(left, right, 12)[:-1]
        np.testing.assert_allclose(np.array(run(t)), solution.sol(t), atol=1e-9)
        for stop in osc.stops:
            # Between events no stop is passed.
            distance = solution.sol(t)[0] - as_float(stop.at)
            assert distance.max() <= 1e-9 or distance.min() >= -1e-9


def is_in_contact(run: pc.Trajectory, t: float) -> bool:
    in_contact = (run.contacts.start <= t) & ~(run.contacts.release <= t)
    return bool(in_contact.any())


def right_hand_side(osc: pc.Oscillator, force: pc.Forcing, inside: float):  # type: ignore[no-untyped-def]
    """Return the equation of motion in the region of a place inside it."""
    stiffness, damping = as_float(osc.stiffness), as_float(osc.damping)
    constant = as_float(force.constant)
    for stop in osc.stops:
        touched = inside > as_float(stop.at) if stop.side == "above" else inside < as_float(stop.at)
        if isinstance(stop, pc.SoftStop) and touched:
            stiffness += as_float(stop.stiffness)
            damping += as_float(stop.damping)
            constant += as_float(stop.stiffness) * as_float(stop.at)

    def derivative(t: float, state: Floats) -> list[float]:
        push = constant
        for part in force.components():
            phase = float(part.omega) * t
            push += part.cos * np.cos(phase) + part.sin * np.sin(phase)
        return [state[1], push - 2.0 * damping * state[1] - stiffness * state[0]]

    return derivative
