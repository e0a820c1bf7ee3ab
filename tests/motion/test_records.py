"""Motions under records: closed forms, many digits, and what a knot must not change."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.oracle.event_driven import simulate
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import (
    Motion,
    chattering_motion,
    random_motion,
    with_record,
)

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.pieces import next_knot, record_at
from percuss.kernels.record import CROSSING, EVENT_T, KIND, KNOT
from percuss.model.force_record import RecordKind
from percuss.model.system import law

# Stiffness and damping: undamped, damped, critical, overdamped, and so without a spring and with
# a negative one; near critical, and stiff with a strong dashpot.
REGIMES = [
    (1.0, 0.0),
    (1.0, 0.1),
    (1.0, 1.0),
    (1.0, 3.0),
    (0.0, 0.0),
    (0.0, 0.4),
    (-0.5, 0.0),
    (-0.5, 0.3),
    (1e-6, 5.0),
    (1.0, 0.999999),
    (40.0, 7.0),
]
# The error of a motion relative to the largest displacement in it (issue: 1e-13 of the amplitude).
ROUNDED = 1e-13


def noise(n: int, seed: int, spacing: float = 0.7) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.exponential(spacing, n)), rng.normal(size=n)


@pytest.mark.parametrize(
    ("stiffness", "damping", "kind"),
    [
        # By day each regime under one kind of record.
        pytest.param(*regime, kind, marks=pytest.mark.nightly if (i + j) % 2 else ())
        for i, regime in enumerate(REGIMES)
        for j, kind in enumerate(("linear", "hold"))
    ],
)
def test_free_motions_are_exact_in_every_regime(
    stiffness: float, damping: float, kind: RecordKind
) -> None:
    """Against the exponential of a matrix, in 40 digits, piece by piece."""
    t, f = noise(40, 3)
    osc = pc.Oscillator(stiffness, damping)

    run = pc.simulate(osc, pc.record(t, f, kind), 0.3, -0.2, float(t[0]), t_end=float(t[-1]))

    with mpmath.workdps(40):
        state = mpmath.matrix([0.3, -0.2, 0, 0])
        largest = [abs(state[0]), abs(state[1])]
        for i in range(len(t) - 1):
            s = mpmath.mpf(t[i + 1]) - mpmath.mpf(t[i])
            slope = (mpmath.mpf(f[i + 1]) - mpmath.mpf(f[i])) / s if kind == "linear" else 0
            rates = [[0, 1, 0, 0], [-stiffness, -2 * damping, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
            state[2], state[3] = mpmath.mpf(f[i]), slope
            state = mpmath.expm(mpmath.matrix(rates) * s) * state
            largest = [max(size, abs(state[i])) for i, size in enumerate(largest)]
    x, v = run(t[-1])
    assert abs(x - state[0]) <= ROUNDED * largest[0]
    assert abs(v - state[1]) <= ROUNDED * largest[1]


def test_a_long_record_keeps_its_digits() -> None:
    """Twenty thousand knots against 40 digits, whose step is a closed form of its own."""
    t: Floats = np.linspace(0.0, 1000.0, 20_001)
    f = np.random.default_rng(4).normal(size=20_001)
    a, k = 0.02, 1.0
    run = pc.simulate(pc.Oscillator(k, a), pc.record(t, f), t_end=float(t[-1]))
    with mpmath.workdps(40):
        x, v, largest = mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(0)
        rate = mpmath.sqrt(mpmath.mpf(k) - mpmath.mpf(a) ** 2)
        for i in range(len(t) - 1):
            s = mpmath.mpf(t[i + 1]) - mpmath.mpf(t[i])
            slope = (mpmath.mpf(f[i + 1]) - mpmath.mpf(f[i])) / s
            constant = mpmath.mpf(f[i]) - 2 * mpmath.mpf(a) * slope
            z, w = x - constant, v - slope
            shrink = mpmath.exp(-a * s)
            c, d = mpmath.cos(rate * s), mpmath.sin(rate * s) / rate
            x = constant + slope * s + shrink * (z * c + (w + a * z) * d)
            v = slope + shrink * (w * c - (a * w + k * z) * d)
            largest = max(largest, abs(x))
    assert abs(run(t[-1])[0] - x) <= ROUNDED * largest


def test_a_square_wave_in_resonance_grows_by_four_a_period() -> None:
    """x = 1 - cos t over the first half; each half period adds two to the amplitude."""
    run = pc.simulate(pc.Oscillator(), pc.square_wave(1), t_end="400*pi")
    count = np.arange(1, 400)
    x, v = run(count * math.pi)
    assert np.abs(x - (-1.0) ** (count + 1) * 2.0 * count).max() < 800 * ROUNDED
    # The instants are off by their own rounding, times the acceleration.
    assert np.abs(v).max() < 800 * 1e-12


def test_a_wave_is_the_wave_and_keeps_its_phase_after_a_million_periods() -> None:
    force = pc.square_wave("0.3", amplitude=2)
    period = 2 * math.pi / 0.3
    system = law(pc.Oscillator(), force)
    for turn in (0, 1, 10**6):
        for part, value in ((0.01, 2.0), (0.49, 2.0), (0.51, -2.0), (0.99, -2.0)):
            assert record_at(system, (turn + part) * period, 0.0) == (value, 0.0)
    high, low = next_knot(system, 1e6 * period + 1.0, 0.0)
    with mpmath.workdps(50):
        exact = (2 * 10**6 + 1) * mpmath.pi / (mpmath.mpf(3) / 10)
        assert abs(mpmath.mpf(high) + mpmath.mpf(low) - exact) < 1e-24
    assert force.period == pytest.approx(period, rel=1e-16)


@pytest.mark.parametrize("kind", ["linear", "hold"])
@pytest.mark.parametrize(
    ("delta", "n"),
    [
        *(pytest.param(10.0**-k, 6, marks=pytest.mark.nightly) for k in (3, 6, 9, 11, 12)),
        (1e-12, 3),
    ],
)
def test_a_touch_under_a_record_is_seen_however_shallow(
    delta: float, n: int, kind: RecordKind
) -> None:
    """A wall a hair before, or behind, the highest point of a motion without stops.

    The highest point is that of the oracle, in 40 digits; one knot more lies at, just before or
    just after it, which changes no force.
    """
    for seed in range(n):
        rng = np.random.default_rng([5, seed])
        t, f = noise(25, seed)
        k, a = REGIMES[seed]
        t_end = float(t[-1])
        top, at = highest_of(seed, kind)
        near = at * (1.0 + float(rng.choice([0.0, 1e-9, -1e-9, 1e-15])))
        i = int(np.searchsorted(t, near))
        if 0 < i < len(t) and t[i] != near and kind == "hold":
            t, f = np.insert(t, i, near), np.insert(f, i, f[i - 1])
        size = max(1.0, abs(float(top)))
        for side in (-1.0, 1.0):
            place = float(top) + side * delta * size
            hard = pc.Oscillator(k, a, (pc.Wall(place, "above", 0.5),))
            run = pc.simulate(hard, pc.record(t, f, kind), 0.1, 0.2, t_end=t_end)
            assert (len(run.impacts) > 0) == (side < 0.0), (seed, place)
            if side < 0.0:
                assert run.impacts.t[0] <= at


@cache
def highest_of(seed: int, kind: RecordKind) -> tuple[mpmath.mpf, float]:
    """Return the highest point of a motion without stops, and its instant, by the oracle."""
    t, f = noise(25, seed)
    problem = problem_of(pc.Oscillator(*REGIMES[seed]), pc.record(t, f, kind))
    exact = simulate(problem, 0.1, 0.2, t_end=float(t[-1]), digits=25)
    with mpmath.workdps(60):
        return highest(exact, 0.0, float(t[-1]))


def highest(run: object, low: float, high: float) -> tuple[mpmath.mpf, float]:
    """Return the largest x inside a run of the oracle, and its instant."""
    times = np.linspace(low, high, 4000)
    values = [float(run(float(t))[0]) for t in times]  # type: ignore[operator]
    i = int(np.argmax(values[1:-1])) + 1
    left, right = mpmath.mpf(times[i - 1]), mpmath.mpf(times[i + 1])
    for _ in range(150):
        middle = (left + right) / 2
        if run(middle)[1] > 0:  # type: ignore[operator]
            left = middle
        else:
            right = middle
    return run(left)[0], float(left)  # type: ignore[operator]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["linear", "hold"]), st.booleans())
def test_a_knot_on_a_straight_line_changes_nothing(seed: int, kind: RecordKind, soft: bool) -> None:
    """Events and motion are the same when pieces are cut in two."""
    rng = np.random.default_rng(seed)
    t, f = noise(8, seed)
    parts = rng.uniform(0.1, 0.9, len(t) - 1)
    cut = t[:-1] + parts * np.diff(t)
    between = f[:-1] + parts * np.diff(f) if kind == "linear" else f[:-1]
    more = np.insert(t, np.arange(1, len(t)), cut), np.insert(f, np.arange(1, len(t)), between)
    stop = pc.SoftStop(0.3, "above", 20.0, 0.1) if soft else pc.Wall(0.3, "above", 0.7)
    osc = pc.Oscillator(1.0, 0.05, (stop,))
    first, second = (
        pc.simulate(osc, pc.record(*samples, kind), 0.0, 0.4, t_end=float(t[-1]), max_impacts=40)
        for samples in ((t, f), more)
    )
    instants = [run.crossings.t if soft else run.impacts.t for run in (first, second)]
    assert len(instants[0]) == len(instants[1])
    assert np.abs(instants[0] - instants[1]).max(initial=0.0) < 1e-9
    if len(first.impacts) < 40:
        times = np.linspace(0.0, 0.9 * float(min(first.t_end, second.t_end)), 50)
        assert np.abs(first(times)[0] - second(times)[0]).max() < 1e-9


def test_knots_are_in_no_table() -> None:
    t, f = noise(200, 1, 0.05)
    osc = pc.impact_oscillator(0.8, wall=-0.1)
    run = pc.simulate(osc, pc.record(t, f), v0=1.0, t_end=20.0)
    assert len(run.impacts) > 3
    assert np.allclose(np.diff(run.impacts.t), run.impacts.intervals[1:], rtol=1e-14)
    assert run.impacts.intervals[0] == run.impacts.t[0]
    assert np.abs(run(run.impacts.t)[0] + 0.1).max() == 0.0
    assert len(run.crossings) == len(run.grazes) == 0


def test_what_the_force_does_is_what_the_energy_gains() -> None:
    """Without dashpot: the change of energy is the integral of f v, by Gauss's rule on pieces."""
    t, f = noise(30, 2)
    stop = pc.SoftStop(0.2, "above", 30.0)
    run = pc.simulate(pc.Oscillator(2.0, 0.0, (stop,)), pc.record(t, f), v0=0.5, t_end=float(t[-1]))
    cuts = np.union1d(np.concatenate([[0.0], t]), run.crossings.t)
    nodes, weights = np.polynomial.legendre.leggauss(30)
    work = 0.0
    for low, high in pairwise(cuts):
        times = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        power = run.forces(times).forcing.values * run(times)[1]
        work += 0.5 * (high - low) * float(weights @ power)
    assert len(run.crossings) > 4
    gained = run.energy(run.t_end) - run.energy(0.0)
    assert abs(float(gained) - work) < 1e-11


def test_a_mass_is_held_and_let_go_at_the_jump_of_a_force() -> None:
    """Pulses that press for the first half: rest on the wall, off it when the force turns."""
    osc = pc.impact_oscillator(0.0, wall=0, side="above", stiffness=0)
    run = pc.simulate(osc, pc.square_wave(2 * Fraction(1), amplitude=3), t_end="3*pi")
    # Up at once: the mass rests on the wall and leaves it at pi/2, falls, returns and sticks.
    assert run.contacts.start[0] == 0.0
    assert run.contacts.release[0] == pytest.approx(math.pi / 2, rel=1e-15)
    x, v = run(math.pi)
    assert float(x) == pytest.approx(-1.5 * (math.pi / 2) ** 2, rel=1e-14)
    assert float(v) == pytest.approx(-1.5 * math.pi, rel=1e-14)
    # Braked as long as it was driven, it is at rest again, twice as far, once a period.
    place, speed = (float(value) for value in run(2.5 * math.pi))
    assert place == pytest.approx(-6.0 * (math.pi / 2) ** 2, rel=1e-14)
    assert abs(speed) < 1e-13


def test_a_contact_lasts_over_many_knots_and_ends_where_the_force_turns() -> None:
    t = np.arange(0.0, 10.5, 0.5)
    f = np.where(t < 8.0, -1.0 - 0.1 * np.sin(7.0 * t), 2.0 * (t - 8.25))
    run = pc.simulate(pc.impact_oscillator(0.5, stiffness=0), pc.record(t, f), t_end=10.0)
    assert len(run.contacts) == 1
    # From f(7.5) to f(8) < 0 to f(8.5) = 0.5: the zero of the line between.
    low, high = f[16], f[17]
    assert run.contacts.release[0] == pytest.approx(8.0 + 0.5 * low / (low - high), rel=1e-14)
    assert run(9.9)[0] > 0.0


@pytest.mark.parametrize("kind", ["linear", "hold"])
def test_chatter_meets_knots(kind: RecordKind) -> None:
    """Hops that die while the force changes its slope: against the oracle, hop by hop."""
    t = np.linspace(0.0, 6.0, 61)
    f = -1.0 - 0.4 * np.cos(3.0 * t)
    osc = pc.impact_oscillator(0.6, stiffness=0.5)
    force = pc.record(t, f, kind)
    run = pc.simulate(osc, force, x0=0.4, t_end=6.0)
    exact = simulate(problem_of(osc, force), 0.4, 0.0, t_end=6.0, digits=25)
    assert len(run.contacts) == len(exact.contacts.start) == 1
    assert run.contacts.start[0] == pytest.approx(float(exact.contacts.start[0]), rel=1e-10)
    n = min(len(run.impacts), 12)
    assert np.allclose(run.impacts.t[:n], [float(s) for s in exact.impacts.t[:n]], rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "seed"), [(random_motion, 240), (chattering_motion, 1022), (chattering_motion, 1594)]
)
def test_a_slope_far_steeper_than_the_harmonics_does_not_stop_the_search(
    make: Callable[[int], Motion], seed: int
) -> None:
    """The time to a release was a difference of nearly equal numbers: no step, for ever."""
    case = with_record(make(seed + 500_000 if make is random_motion else seed), seed)
    t_end = case.start[2] + 5.0
    run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=t_end)
    exact = simulate(problem_of(case.oscillator, case.forcing), *case.start, t_end=t_end)

    assert len(run.contacts) >= 2
    for ours, theirs in zip(run.contacts.release, exact.contacts.release, strict=False):
        assert math.isnan(ours) == mpmath.isnan(theirs)
        assert math.isnan(ours) or abs(ours - float(theirs)) < 1e-12


@pytest.mark.parametrize(
    ("force", "constant"),
    [
        # No force on the mass for half of each period.
        (pc.square_wave(2, "0.5"), "-0.5"),
        # Harmonics and record are largest at different instants.
        (pc.triangle_wave(2, "0.5") + pc.cosine(2, amplitude="0.5"), "-0.8"),
        (pc.record([0, 1, 2, 3], [-1, -2, -1, -1], repeat=True), "0.5"),
    ],
)
def test_a_mass_held_for_a_period_is_held_for_ever(force: pc.Forcing, constant: str) -> None:
    force = force + pc.Forcing(constant=constant)
    osc = pc.impact_oscillator(0.0)

    run = pc.simulate(osc, force, t0=0.25, max_impacts=10)
    long = pc.simulate(osc, force, t0=0.25, t_end=40.0)

    for ended in (run, long):
        assert ended.outcome is pc.Outcome.at_rest
        assert ended.contacts.start.tolist() == [0.25]
        assert math.isnan(ended.contacts.release[0])
    lifted = pc.simulate(osc, force + pc.Forcing(constant="0.6"), t0=0.25, t_end=40.0)
    assert len(lifted.impacts) > 0


def test_extremes_and_sections_see_what_lies_between_knots() -> None:
    t, f = noise(50, 8, 0.3)
    run = pc.simulate(pc.Oscillator(1.0, 0.05), pc.record(t, f), v0=0.3, t_end=float(t[-1]))
    times = np.linspace(0.0, run.t_end, 200_001)
    x, v = run(times)
    for name, values in (("displacement", x), ("velocity", v)):
        extrema = run.extremes(name)  # type: ignore[arg-type]
        assert extrema.minimum <= values.min() <= extrema.minimum + 1e-6
        assert values.max() <= extrema.maximum <= values.max() + 1e-6
    passages = run.section(at=0.05).t.values
    assert len(passages) == np.count_nonzero(np.diff(np.sign(x - 0.05)))
    assert np.abs(run(passages)[0] - 0.05).max() < 1e-13


@pytest.mark.parametrize("kind", ["linear", "hold"])
def test_the_acceleration_has_both_limits_at_a_knot(kind: RecordKind) -> None:
    t, f = [0.0, 1.0, 2.0, 3.0], [0.0, 5.0, -5.0, 0.0]
    run = pc.simulate(pc.Oscillator(0.0, 0.0), pc.record(t, f, kind), t_end=3.0)
    extrema = run.extremes("acceleration")
    assert (extrema.minimum, extrema.maximum) == (-5.0, 5.0)
    assert (extrema.t_minimum, extrema.t_maximum) == (2.0, 1.0)


def test_the_force_of_a_wall_in_contact_has_its_extremes_at_knots() -> None:
    force = pc.record([0.0, 1.0, 2.0, 3.0], [-1.0, -4.0, -2.0, -3.0])
    run = pc.simulate(pc.impact_oscillator(0.5), force, t_end=3.0)
    extrema = run.extremes("stop_force")
    assert (extrema.minimum, extrema.maximum) == (1.0, 4.0)
    assert (extrema.t_minimum, extrema.t_maximum) == (0.0, 1.0)
    jumps = pc.record([0.0, 1.0, 2.0, 3.0], [-1.0, -4.0, -2.0, -3.0], "hold")
    extrema = pc.simulate(pc.impact_oscillator(0.5), jumps, t_end=2.5).extremes("stop_force")
    assert (extrema.minimum, extrema.maximum) == (1.0, 4.0)


def test_the_force_of_a_wall_has_its_extremes_at_the_end_of_a_window_too() -> None:
    """Under a record alone the end of a contact, or of the window in it, was left out."""
    held = pc.Oscillator(stops=(pc.Wall(0, "above", 0),))
    push = pc.record([0, 10], [1, 5])
    run = pc.simulate(held, push, t_end=8)
    for between, least, most in (((1, 3), -2.2, -1.4), ((0, 8), -4.2, -1.0)):
        extrema = run.extremes("stop_force", between=between)
        assert (extrema.minimum, extrema.maximum) == pytest.approx((least, most), rel=1e-15)
        assert (extrema.t_minimum, extrema.t_maximum) == between[::-1]
    data = pc.sweep("peak_stop_force", held, push, over={}, between=(1, 3))
    assert float(data.peak_stop_force) == pytest.approx(2.2, rel=1e-15)
    peak, moved = run.sensitivity(["forcing.record.amplitude"]).measured("peak_stop_force")
    assert (peak, moved[0]) == pytest.approx((4.2, 4.2), rel=1e-15)


def test_a_wall_never_pulls_where_the_jump_of_a_force_ends_a_contact() -> None:
    """The force after the jump was the wall's in some of them, by rounding."""
    held = pc.Oscillator(stiffness="1.5", stops=(pc.Wall("-0.1", "below", 0),))
    n = 0
    for omega in np.linspace(1.2, 1.7, 11):
        force = pc.square_wave(omega, "2.2") + pc.cosine("2.6", amplitude="0.2")
        run = pc.simulate(held, force, t0=1000, t_end=1030)
        n += len(run.contacts)
        assert run.extremes("stop_force").minimum == 0.0
    assert n > 40


@pytest.mark.parametrize("mass", [None, 2])
def test_forces_at_an_event_are_those_after_it(mass: int | None) -> None:
    """Of a dashpot at its entry, and of a wave at its jump, rounding chose the side."""
    stops = (pc.SoftStop("0.3", "above", 20, "0.8"), pc.SoftStop("-0.4", "below", 9, "1.5"))
    osc = pc.Oscillator(1, "0.1", stops=stops)
    if mass is not None:
        osc = pc.Oscillator.from_mass(mass, 1, "0.1", stops=stops)
    one = pc.Structure([2], [1], ["0.1"], [*stops])
    wave = pc.square_wave("0.7", "1.5") + pc.cosine("1.9")
    for run in (pc.simulate(osc, wave, t_end=60), pc.simulate(one, pc.Loads({0: wave}), t_end=60)):
        marks = run.record.marks if isinstance(run, pc.StructureTrajectory) else run.record[1]
        events = run.record.events if isinstance(run, pc.StructureTrajectory) else run.record[0]
        t = events[np.isin(marks[:, KIND], [CROSSING, KNOT]), EVENT_T]
        assert len(run.crossings) > 20
        assert len(t) > len(run.crossings) + 10
        here, after = run.forces(t), run.forces(t + 1e-10)
        for name in ("forcing" if isinstance(run, pc.Trajectory) else "loads", "stops"):
            assert np.abs(here[name].values - after[name].values).max() < 1e-7
        both = np.array([t, t + 1e-10])
        own = (
            run.acceleration(both) if isinstance(run, pc.Trajectory) else run.acceleration(0, both)
        )
        assert np.abs(own[1] - own[0]).max() < 1e-7


def test_before_and_after_a_record_its_ends_hold_or_nothing_acts() -> None:
    t, f = [1.0, 2.0], [3.0, 5.0]
    free = pc.Oscillator(stiffness=0)
    held = pc.simulate(free, pc.record(t, f), t_end=4.0)
    assert held.forces([0.5, 1.0, 1.5, 2.0, 3.0]).forcing.values.tolist() == [3, 3, 4, 5, 5]
    none = pc.simulate(free, pc.record(t, f, outside="zero"), t_end=4.0)
    assert none.forces([0.5, 1.0, 1.5, 2.0, 3.0]).forcing.values.tolist() == [0, 3, 4, 0, 0]
    # 3.5 of speed in the second second alone.
    assert float(none(4.0)[1]) == pytest.approx(4.0, rel=1e-15)


def test_runs_of_a_record_are_the_same_after_pickling() -> None:
    t, f = noise(20, 6)
    force = pc.record(t, f) + pc.cosine("1.3", amplitude="0.4")
    osc = pc.impact_oscillator("0.8", wall=-0.2)
    copy = pickle.loads(pickle.dumps(force))
    assert copy == force
    assert hash(copy) == hash(force)
    runs = [pc.simulate(osc, one, v0=1.0, t_end=12.0) for one in (force, copy)]
    assert runs[0].impacts.t.tobytes() == runs[1].impacts.t.tobytes()


def test_a_run_beyond_its_record_says_so() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.5", side="above", damping="0.05")
    t = np.arange(0.0, 60.0, 0.1)
    f = np.cos(2.6 * t)
    for push, words in (
        (pc.record(t, f), "its end values hold"),
        (pc.record(t, f, outside="zero"), "nothing acts"),
    ):
        within, beyond = (pc.simulate(osc, push, t_end=end) for end in (t[-1], 80.0))
        assert within.beyond_record == ""
        assert beyond.beyond_record in repr(beyond)
        assert beyond.beyond_record == f"the record lasts from t = 0 to 59.9, {words} beyond"
    early = pc.simulate(osc, pc.record(t + 10.0, np.cos(t)), t_end=50.0)
    assert early.beyond_record.startswith("the record lasts from t = 10 to 69.9")
    assert pc.simulate(osc, pc.square_wave(2), t_end=500.0).beyond_record == ""


@pytest.mark.parametrize("stiffness", [0, -0.5, 0.1, 0.25, 1e-9, -1e-9, 1])
@pytest.mark.parametrize("damping", [-0.5, 0.5, -0.1])
def test_one_long_piece_is_that_of_the_matrix_exponential(stiffness: float, damping: float) -> None:
    """A force 0.3 + 0.07 t from rest, for damping of either sign down to no spring at all."""
    t, f = (0.0, 20.0), (0.3, 1.7)
    run = pc.simulate(pc.Oscillator(stiffness, damping), pc.record(t, f), t_end=20.0)
    with mpmath.workdps(40):
        slope = (mpmath.mpf(f[1]) - mpmath.mpf(f[0])) / 20
        k, a = mpmath.mpf(stiffness), mpmath.mpf(damping)
        equation = mpmath.matrix([[0, 1, 0, 0], [-k, -2 * a, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
        for instant in (1.0, 9.0, 15.0):
            force = mpmath.matrix([0, 0, mpmath.mpf(f[0]), slope])
            exact = mpmath.expm(equation * instant) * force
            size = max(1.0, abs(float(exact[0])))
            assert abs(float(run(instant)[0]) - float(exact[0])) < 1e-13 * size


@pytest.mark.parametrize(("damping", "gap"), [(0, 5), ("0.1", 1.2), ("0.1", 5)])
def test_a_run_without_end_ends_where_no_impact_comes_any_more(
    damping: float | str, gap: float
) -> None:
    """Under a repeated record: the periodic motion and what is left of the free one stay away."""
    osc = pc.Oscillator(1, damping, (pc.Wall(gap, "above", 0.8),))
    force = pc.square_wave(2)
    run = pc.simulate(osc, force, v0=0.5, max_impacts=50)

    assert run.outcome is pc.Outcome.no_more_impacts
    followed = pc.simulate(osc, force, v0=0.5, t_end=2000)
    assert run.impacts.t.tolist() == followed.impacts.t.tolist()
    assert followed.extremes("displacement", between=(run.t_end, 2000)).maximum < gap


def test_a_late_run_ends_where_one_from_time_0_does() -> None:
    """The steady motion comes within 1e-6 of the wall: at 1e11 periods a double has no such phase."""
    free = pc.simulate(pc.Oscillator(1, "0.3"), pc.square_wave(2), t_end=200)
    top = free.extremes("displacement", between=(190, 200)).maximum
    x0, v0 = map(float, free(60 * math.pi))
    for gap, outcome in ((top + 1e-6, "no_more_impacts"), (top - 1e-6, "reached_max_impacts")):
        osc = pc.Oscillator(1, "0.3", (pc.Wall(gap, "above", 0.8),))
        for n in (0, 10**11):
            run = pc.simulate(osc, pc.square_wave(2), x0, v0, t0=pc.pi_times(n), max_impacts=3)
            assert run.outcome is pc.Outcome[outcome]
            assert run.t_end - run.t0 < 1000


def test_a_motion_that_may_still_come_back_is_followed() -> None:
    """The periodic motion stays away from the wall; the free one reaches it now and then."""
    osc = pc.Oscillator(1, 0, (pc.Wall(0.9, "above", 0.99),))
    run = pc.simulate(osc, pc.square_wave("2.7"), v0=0.6, max_impacts=3)
    assert run.outcome is pc.Outcome.reached_max_impacts


BELOW = (pc.Wall(0, "below", "0.8"),)
BETWEEN = pc.Wall(-3, "below", "0.8"), pc.Wall(9, "above", "0.8")
DRIVES = {
    "square": pc.square_wave(2, amplitude="0.3"),
    "ramps": pc.triangle_wave(2) + pc.cosine(4, amplitude="0.2"),
    "samples": pc.record([0, "1/3", 1, 2], ["-0.1", "0.5", "-0.3", "-0.1"], repeat=True),
}


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize(
    ("damping", "mean", "stops", "v0"),
    [
        ("0.1", "0", BELOW, 1),
        ("0.1", "0.1", BELOW, -1),
        ("0.1", "0", BETWEEN, "0.1"),
        ("0", "0", BELOW, 1),
        ("0", "0", BELOW, -1),
        ("0", "0.1", BELOW, 1),
    ],
)
def test_a_mass_without_spring_that_drifts_off_under_a_repeated_record_ends_its_run(
    drive: str, damping: str, mean: str, stops: tuple[pc.Wall, ...], v0: str | int
) -> None:
    """It went on for ever; with a spring such runs ended."""
    force = DRIVES[drive]
    record = force.record
    assert record is not None
    force = force + pc.Forcing(constant=Fraction(mean) - record.mean)
    osc = pc.Oscillator(0, damping, stops)

    run = pc.simulate(osc, force, x0=5, v0=v0, max_impacts=200)

    assert run.outcome is pc.Outcome.no_more_impacts
    # No impact comes later either.
    later = pc.simulate(osc, force, x0=5, v0=v0, t_end=run.t_end + 2000.0)
    assert len(later.impacts) == len(run.impacts)


@pytest.mark.parametrize("damping", ["0", "0.1"])
def test_a_mass_that_is_pulled_back_to_its_wall_in_the_mean_goes_on(damping: str) -> None:
    """However far and fast it goes off at first, and however little it is pulled."""
    force = DRIVES["square"] + pc.Forcing(constant="-0.001")

    run = pc.simulate(pc.Oscillator(0, damping, BELOW), force, x0=5, v0=1, max_impacts=3)

    assert run.outcome is pc.Outcome.reached_max_impacts


def test_the_mean_of_a_record_is_exact() -> None:
    assert pc.square_wave("1.7", amplitude="0.1").record.mean == 0  # type: ignore[union-attr]
    linear = pc.record([0, "1/3", 1], ["0.1", "0.2", "0.1"], repeat=True).record
    assert linear is not None
    assert linear.mean == Fraction(3, 20)
