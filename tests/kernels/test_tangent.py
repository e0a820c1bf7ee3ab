from __future__ import annotations

import math

import numpy as np
import pytest
from tests.kernels.uncompiled import python_of

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.flight import Flight, constant_force, move, set_phases
from percuss.kernels.law_columns import FIRST_HARMONIC, N_HARMONICS, STEP
from percuss.kernels.record import MotionRecord
from percuss.kernels.shooting import ShootingProblem, shoot, turning_points
from percuss.kernels.tangent import (
    crossing_saltation,
    delayed_start,
    impact_saltation,
    neighbours,
    propagator,
)
from percuss.model.system import law as law_of

SYSTEMS = {
    "one wall": (pc.impact_oscillator(0.8, damping=0.05), pc.cosine(2.1)),
    "two walls": (
        pc.Oscillator(1.0, 0.02, (pc.Wall(0.4, "above", 0.7), pc.Wall(-0.5, "below", 0.9))),
        pc.cosine(1.3),
    ),
    "soft stops with dashpots": (
        pc.Oscillator(
            1.0,
            0.02,
            (pc.SoftStop(0.2, "above", 29.0, 0.7), pc.SoftStop(-0.3, "below", 5.0, 0.2)),
        ),
        pc.cosine(1.3),
    ),
    "soft stop before a wall": (
        pc.Oscillator(
            1.0,
            0.02,
            (
                pc.Wall(0.4, "above", 0.7),
                pc.SoftStop(0.2, "above", 5.0, 0.3),
                pc.Wall(-0.5, "below", 0.9),
            ),
        ),
        pc.fourier(1.3, cos=(1.0, 0.3), sin=(0.2,)),
    ),
    "no spring": (
        pc.Oscillator(0.0, 0.0, (pc.Wall(-1.0, "below", 0.7), pc.Wall(1.0, "above", 0.7))),
        pc.cosine(1.0),
    ),
    "negative spring": (
        pc.Oscillator(-0.5, 0.1, (pc.Wall(-1.0, "below", 0.7), pc.Wall(1.0, "above", 0.7))),
        pc.fourier(2.0, cos=(1.0, 0.2), sin=(0.3,)),
    ),
    "overdamped": (
        pc.Oscillator(1.0, 1.5, (pc.Wall(-0.1, "below", 0.9), pc.Wall(0.1, "above", 0.9))),
        pc.cosine(1.3, amplitude=3.0),
    ),
}
each_system = pytest.mark.parametrize("name", SYSTEMS)


def derivative(run: pc.Trajectory, t: float, after: bool = True) -> Floats:
    """Return the derivative of (x, v) at t by the start of a run."""
    out = np.empty((1, 4))
    law = law_of(run.oscillator, run.forcing)
    scratch = np.empty((int(law[0, N_HARMONICS]), 2))
    record = MotionRecord(law, run.x0, run._events, run._marks)
    neighbours(record, np.array([t]), after, scratch, out)
    return out.reshape(2, 2)


def differences(
    osc: pc.Oscillator, force: pc.Forcing, start: tuple[float, float], t: float, step: float = 1e-6
) -> Floats:
    """Return the same by central differences."""
    columns = []
    for i in range(2):
        ends = []
        for sign in (1.0, -1.0):
            x, v = start
            x, v = (x + sign * step, v) if i == 0 else (x, v + sign * step)
            ends.append(np.array(pc.simulate(osc, force, x, v, t_end=t)(t)))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T


@each_system
@pytest.mark.parametrize("start", [(0.05, 0.9), (-0.03, -1.6)])
def test_derivative_by_the_start_agrees_with_central_differences(
    name: str, start: tuple[float, float]
) -> None:
    osc, force = SYSTEMS[name]
    start = (abs(start[0]), start[1]) if name == "one wall" else start
    t = 3.0
    run = pc.simulate(osc, force, *start, t_end=t)
    assert len(run.impacts) + len(run.crossings) > 0

    matrix = derivative(run, t)

    size = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, differences(osc, force, start, t), atol=3e-8 * size)


@pytest.mark.parametrize(("x", "v"), [(0.6, 1.2), (0.9, 0.35)])
def test_sign_of_the_saltation_entry_of_cocos_example(x: float, v: float) -> None:
    """At COCO's orbit a wrong sign changes the trace in the fifth digit; here it is seen."""
    osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    force = pc.cosine(1.0)
    run = pc.simulate(osc, force, x, v, t_end=1.5)
    assert len(run.impacts) == 1

    matrix = derivative(run, 1.5)

    expected = differences(osc, force, (x, v), 1.5)
    np.testing.assert_allclose(matrix, expected, atol=1e-8 * np.abs(expected).max())
    t, before = run.impacts.t[0], run.impacts.v_before[0]
    after = np.array(propagator(law_of(osc, force), FIRST_HARMONIC + 1, 1.5 - t)).reshape(2, 2)
    entry = 1.8 * (math.cos(t) - 1.0) / before
    first = np.array(propagator(law_of(osc, force), FIRST_HARMONIC + 1, t)).reshape(2, 2)
    wrong = after @ np.array([[-0.8, 0.0], [-entry, -0.8]]) @ first
    assert np.abs(wrong - expected).max() > 1e-2 * np.abs(expected).max()


@each_system
def test_determinant_is_what_impacts_and_dashpots_leave_of_an_area(name: str) -> None:
    osc, force = SYSTEMS[name]
    run = pc.simulate(osc, force, 0.05, 0.9, t_end=40.0, max_impacts=25)
    end = run._events[-1, 0]
    walls = np.array([getattr(stop, "restitution", 1.0) for stop in osc.stops])
    dampings = law_of(osc, force)[run._marks[:-1, 2], 8]
    decay = float(dampings @ np.diff(run._events[:, 0]))
    expected = float((walls[run.impacts.stop] ** 2).prod()) * math.exp(-2.0 * decay)
    assert len(run.contacts) == 0

    matrix = derivative(run, end)

    assert np.linalg.det(matrix) == pytest.approx(expected, abs=1e-10 * (matrix**2).sum())


def test_nothing_of_the_past_survives_a_contact() -> None:
    osc, force = pc.impact_oscillator(0.5), pc.cosine(1.0, constant=-0.9)
    run = pc.simulate(osc, force, v0=0.3, t_end=9.0)
    release = run.contacts.release[0]
    assert release < run.impacts.t[-1]

    for t in (0.5 * (run.contacts.start[0] + release), release, 8.9):
        np.testing.assert_array_equal(derivative(run, t), np.zeros((2, 2)))
    assert np.abs(derivative(run, run.impacts.t[0])).max() > 0.1


def test_a_plastic_impact_that_takes_off_at_once_leaves_one_direction() -> None:
    osc, force = pc.impact_oscillator(0.0, wall=-0.1), pc.cosine(1.0)
    start, t = (0.3, -1.5), 0.9
    run = pc.simulate(osc, force, *start, t_end=t)
    assert len(run.impacts) == 1
    assert len(run.contacts) == 0

    matrix = derivative(run, t)

    assert np.linalg.matrix_rank(matrix, tol=1e-12) == 1
    np.testing.assert_allclose(matrix, differences(osc, force, start, t), atol=1e-8)


def test_sides_of_an_event_differ_by_its_saltation_matrix() -> None:
    osc, force = SYSTEMS["one wall"]
    run = pc.simulate(osc, force, 0.5, 0.1, t_end=5.0)
    t, v = run.impacts.t[0], run.impacts.v_before[0]

    jump = derivative(run, t) @ np.linalg.inv(derivative(run, t, after=False))

    entry = 1.8 * math.cos(2.1 * t) / v
    np.testing.assert_allclose(jump, [[-0.8, 0.0], [entry, -0.8]], atol=1e-12)


@pytest.mark.parametrize("s", [1e-6, 0.03, 0.9, 4.0])
@each_system
def test_delay_of_the_start_agrees_with_central_differences(name: str, s: float) -> None:
    osc, force = SYSTEMS[name]
    law = law_of(osc, force)
    n = int(law[0, N_HARMONICS])
    region = FIRST_HARMONIC + n
    phases, arrival = np.empty((n, 2)), np.empty((n, 2))
    pull = constant_force(law, region, 0.0)
    h, ends = 1e-5, []
    for t in (0.7 + h, 0.7 - h):
        set_phases(law, t, 0.0, phases)
        ends.append(np.array(move(Flight(law, region, (t, 0.0, 0.4, pull), phases, arrival), s)))

    set_phases(law, 0.7, 0.0, phases)
    derivatives = delayed_start(law, region, phases, s)

    expected = (ends[0] - ends[1]) / (2.0 * h)
    np.testing.assert_allclose(derivatives, expected, rtol=1e-7, atol=1e-10)


def test_kernels_are_the_same_compiled_and_plain() -> None:
    osc, force = SYSTEMS["soft stop before a wall"]
    law = law_of(osc, force)
    region = FIRST_HARMONIC + int(law[0, N_HARMONICS])
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    set_phases(law, 0.3, 0.0, phases)

    for kernel, arguments in (
        (propagator, (law, region, 0.7)),
        (impact_saltation, (0.8, 0.7, 0.3, 0.1, -1.2)),
        (crossing_saltation, (0.1, 0.4)),
        (delayed_start, (law, region, phases, 0.7)),
    ):
        plain = python_of(kernel)(*arguments)
        assert kernel(*arguments) == pytest.approx(plain, rel=1e-14)


CHAIN = [[1, 0, 1], [1, 1, 0], [0, 0, 0]]


def missed_by(name: str, unknowns: Floats) -> tuple[Floats, Floats]:
    """Return residuals and Jacobian of: into a soft stop above, out again, a wall below."""
    osc = pc.Oscillator(
        1.0, 0.1, (pc.SoftStop(0.3, "above", 9.0, 0.4), pc.Wall(-0.5, "below", 0.7))
    )
    law = law_of(osc, SYSTEMS[name][1])
    n = int(law[0, N_HARMONICS])
    rows = FIRST_HARMONIC + n + np.array(CHAIN)[:, 1:] * (1 + n)
    itinerary = np.column_stack([np.array(CHAIN)[:, 0], rows]).astype(np.int64)
    residual, jacobian = np.empty(7), np.empty((7, 7))
    problem = ShootingProblem(law, itinerary, 5.0, np.empty((n, 2)), np.empty((n, 2)))
    shoot(problem, unknowns, residual, jacobian)
    return residual.copy(), jacobian.copy()


@pytest.mark.parametrize("name", ["one wall", "negative spring"])
def test_jacobian_of_the_equations_agrees_with_central_differences(name: str) -> None:
    unknowns = np.array([0.4, 0.9, 1.3, 2.1, 0.8, -0.7, 1.1])
    _, jacobian = missed_by(name, unknowns)

    h = 1e-6
    columns = [
        (missed_by(name, unknowns + h * e)[0] - missed_by(name, unknowns - h * e)[0]) / (2.0 * h)
        for e in np.eye(7)
    ]

    np.testing.assert_allclose(jacobian, np.array(columns).T, atol=1e-8)


def turns(name: str, v0: float, longest: float) -> Floats:
    osc, force = SYSTEMS[name]
    law = law_of(osc, force)
    n = int(law[0, N_HARMONICS])
    region = FIRST_HARMONIC + n
    phases, arrival, out = np.empty((n, 2)), np.empty((n, 2)), np.empty((64, 3))
    set_phases(law, 0.2, 0.0, phases)
    start = (0.2, 0.0, v0, constant_force(law, region, 0.1))
    flight = Flight(law, region, start, phases, arrival)
    count = turning_points(flight, longest, law[region, STEP], out)
    times = np.linspace(0.0, longest, 20_001)
    v = np.array([move(flight, s)[1] for s in times])
    expected = times[1:-1][v[1:-1] * v[2:] < 0.0]
    assert count == len(expected)
    np.testing.assert_allclose(out[:count, 0], expected, atol=1.01 * times[1])
    return out[:count]


@pytest.mark.parametrize("v0", [-0.7, 0.0, 0.02, 1.3])
@pytest.mark.parametrize("name", ["one wall", "no spring", "overdamped", "negative spring"])
def test_turning_points_are_those_that_a_fine_sampling_shows(name: str, v0: float) -> None:
    turns(name, v0, 6.0)


def test_two_turning_points_a_hair_apart_are_both_found() -> None:
    """The velocity dips through zero between two steps of the search."""
    osc, force = pc.Oscillator(0.0, 0.0), pc.cosine(1.0)
    law = law_of(osc, force)
    phases, arrival, out = np.empty((1, 2)), np.empty((1, 2)), np.empty((8, 3))
    set_phases(law, 0.0, 0.0, phases)
    # v = v0 + sin(t), least at 3 pi/2.
    start = (0.0, 0.0, 1.0 - 1e-6, 0.0)

    flight = Flight(law, FIRST_HARMONIC + 1, start, phases, arrival)
    count = turning_points(flight, 6.0, law[FIRST_HARMONIC + 1, STEP], out)

    half = math.acos(1.0 - 1e-6)
    expected = [1.5 * math.pi - half, 1.5 * math.pi + half]
    np.testing.assert_allclose(out[:count, 0], expected, atol=1e-9)


@pytest.mark.parametrize("v0", [-0.7, 0.0, 2.0])
@pytest.mark.parametrize("damping", [1e3, 1e5, 1e8])
def test_turning_points_after_a_fast_decay_are_those_of_the_slow_motion(
    damping: float, v0: float
) -> None:
    """2 a x' + x = cos(t) where x'' is small: a walk of the fast steps would take a minute."""
    osc, force = pc.Oscillator(1.0, damping), pc.cosine(1.0)
    law = law_of(osc, force)
    region = FIRST_HARMONIC + 1
    phases, arrival, out = np.empty((1, 2)), np.empty((1, 2)), np.empty((64, 3))
    set_phases(law, 0.2, 0.0, phases)
    flight = Flight(law, region, (0.2, 0.0, v0, constant_force(law, region, 0.0)), phases, arrival)

    count = turning_points(flight, 30.0, law[region, STEP], out)

    # Then x' = cos(t) / 2 a to within 1 / 4 a^2. One turn more where v0 is against the force.
    late = out[:count, 0][out[:count, 0] > 0.5] + 0.2
    np.testing.assert_allclose(late, (np.arange(10) + 0.5) * math.pi, atol=2.0 / damping)
    assert count == 10 + (v0 < 0.0)


def test_a_turning_point_right_after_a_start_from_rest_is_found() -> None:
    """From rest into the one direction, and back within the first step of the search."""
    osc, force = pc.Oscillator(0.0, 0.0), pc.sine(1.0)
    law = law_of(osc, force)
    phases, arrival, out = np.empty((1, 2)), np.empty((1, 2)), np.empty((8, 3))
    for lead in (0.1, 1e-3, 1e-6):
        set_phases(law, -lead, 0.0, phases)
        # v = cos(lead) - cos(t), which is zero again at t = lead.
        start = (-lead, 0.0, 0.0, 0.0)

        flight = Flight(law, FIRST_HARMONIC + 1, start, phases, arrival)
        count = turning_points(flight, 3.0, law[FIRST_HARMONIC + 1, STEP], out)

        assert out[0, 0] == pytest.approx(2.0 * lead, rel=1e-7)
        assert out[0, 1] < 0.0
        assert count == 1
