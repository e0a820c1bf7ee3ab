"""The spectrum is that of the closed form: held against quadrature, series and Parseval."""

from __future__ import annotations

import contextlib
import math
import sys
import warnings
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from mpmath import mp
from tests.oracle.event_driven import simulate as exact_simulate
from tests.oracle.from_model import problem_of

import percuss as pc
from percuss.motion.fourier_integral import fourier_integral
from percuss.motion.trajectory import Trajectory

OMEGAS = np.array([0.0, 1e-3, 0.3, 0.99, 1.0, 1.0001, 1.5, 2.0, 2.7, 3.0, 3.001, 7.3, 36.0, -2.0])
ELASTIC = pc.impact_oscillator()
BETWEEN = pc.Oscillator(
    0.2, 0.01, (pc.Wall(-1.0, "below", 0.8), pc.SoftStop(1.0, "above", 29, 0.1))
)
BALL = pc.ball_on_table(amplitude=0.9, omega=1.0, gravity=1.0, restitution=0.8)

CASES = {
    "impacts": (ELASTIC, pc.sine(3), {"v0": "0.45", "t_end": 31.0}),
    "secular": (ELASTIC, pc.sine(1), {"t_end": 31.0}),
    "no stop, forced at resonance": (pc.Oscillator(), pc.sine(1), {"t_end": 31.0}),
    "no spring": (pc.Oscillator(stiffness=0), pc.sine(1), {"t_end": 31.0}),
    "no spring, with damping": (pc.Oscillator(0, 0.3), pc.sine(1), {"v0": 1, "t_end": 31.0}),
    "overdamped": (pc.impact_oscillator(0.8, damping=3, wall=-0.05), pc.sine(1.3), {"t_end": 31.0}),
    "critical": (pc.impact_oscillator(0.8, damping=1), pc.cosine(1.3), {"v0": 1, "t_end": 31.0}),
    "chatter and contact": (
        pc.impact_oscillator(0.5, side="above"),
        pc.cosine(0.5, amplitude=-1),
        {"x0": -1, "t_end": 31.0},
    ),
    "wall and soft stop": (BETWEEN, pc.cosine(1.3), {"v0": 0.3, "t_end": 40.0}),
    "stiff stop": (pc.bilinear_oscillator(stiffness_below=4e8), pc.sine(3), {"t_end": 31.0}),
    "unstable spring": (
        pc.Oscillator(-1, stops=(pc.Wall(-1.0, "below", 0.9), pc.Wall(1.0, "above", 0.9))),
        pc.cosine(1.3),
        {"v0": 0.3, "t_end": 20.0},
    ),
    "two harmonics and a constant": (
        pc.impact_oscillator(0.9, wall=-0.4),
        pc.fourier(0.7, cos=(1.0, 0.2), sin=(0.0, 0.5), constant=-0.3),
        {"t_end": 31.0},
    ),
    "ball at rest in the end": (*BALL, {"x0": 3.0, "t_end": 60.0}),
    "square wave": (BETWEEN, pc.square_wave(1.3), {"v0": 0.3, "t_end": 40.0}),
    "triangle wave at resonance, without a stop": (
        pc.Oscillator(), pc.triangle_wave(1, "0.4"), {"t0": -3.3, "t_end": 31.0},
    ),
    "samples and a harmonic, chatter and contact": (
        pc.impact_oscillator(0.5, side="above", damping=0.1),
        pc.record([-2.0, 0.4, 1.1, 2.9, 21.0], [0.0, 2.0, 0.8, 1.9, -1.0])
        + pc.cosine(0.5, amplitude=0.3),
        {"x0": -1, "t_end": 31.0},
    ),
    "samples, without a spring": (
        pc.impact_oscillator(0.8, stiffness=0),
        pc.record([0.0, 0.7, 1.1, 2.9], [-1.0, 0.5, -2.5, -1.0], repeat=True),
        {"x0": 1.0, "t_end": 25.0},
    ),
}  # fmt: skip


def run_of(name: str) -> Trajectory:
    osc, force, limits = CASES[name]
    run: Trajectory = pc.simulate(osc, force, **limits)  # type: ignore[arg-type]
    return run


def by_quadrature(run: Trajectory, low: float, high: float) -> np.ndarray:
    """Return the integral by forty Gauss nodes on each of many short panels between events."""
    released = run.contacts.release
    times = np.concatenate(
        [run.impacts.t, run.crossings.t, run.contacts.start, released[np.isfinite(released)]]
    )
    if run.forcing is not None and run.forcing.record is not None:
        times = np.concatenate([times, run.record[0][:, 0]])
    cuts = np.unique(np.concatenate([[low], times[(times > low) & (times < high)], [high]]))
    panels = [np.linspace(a, b, max(1, math.ceil(7 * (b - a))) + 1) for a, b in pairwise(cuts)]
    left = np.concatenate([panel[:-1] for panel in panels])
    width = np.concatenate([np.diff(panel) for panel in panels])
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t = (left[:, None] + np.multiply.outer(width, 0.5 * (nodes + 1))).reshape(-1)
    share = np.multiply.outer(width, 0.5 * weights).reshape(-1)
    x = run(np.clip(t, run.t0, run.t_end))[0]
    return np.array([(share * x * np.exp(-1j * w * (t - low))).sum() for w in OMEGAS])


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("window", ["whole", "part"])
def test_the_integral_of_every_kind_of_flight_agrees_with_quadrature(
    name: str, window: str
) -> None:
    run = run_of(name)
    low, high = (run.t0, run.t_end) if window == "whole" else (3.3, 17.7)

    computed = fourier_integral(run, OMEGAS, low, high)

    expected = by_quadrature(run, low, high)
    assert np.abs(computed - expected).max() < 1e-13 * np.abs(expected).max()


def test_the_integral_agrees_with_forty_digits_of_an_independent_motion() -> None:
    """The motion by the oracle, the integral by mpmath: nothing of percuss in it."""
    run = run_of("impacts")
    exact = exact_simulate(problem_of(ELASTIC, pc.sine(3)), 0, mp.mpf("0.45"), t_end=31, digits=30)
    with mp.workdps(30):
        cuts = [mp.mpf(0), *exact.impacts.t, mp.mpf(31)]
        for w in (0.3, 1.0, 3.0):
            expected = mpmath.fsum(
                mpmath.quad(lambda t, w=w: exact(t)[0] * mpmath.expj(-w * t), [a, b])
                for a, b in pairwise(cuts)
            )
            computed = complex(fourier_integral(run, np.array([w]), 0.0, 31.0)[0])
            assert abs(computed - complex(expected)) < 1e-13


def test_late_in_a_long_run_phases_keep_their_digits() -> None:
    """On the eigenset x = sin(t - k pi): over the last 100 flights at t = 1e6 the same integral."""
    run = pc.simulate(ELASTIC, v0=1.0, max_impacts=320_000)
    late, early = run.impacts.t[-101], 0.0
    omega = np.array([0.7, 2.0, 13.9])

    computed = fourier_integral(run, omega, float(late), float(run.impacts.t[-1]))

    expected = fourier_integral(run, omega, early, float(run.impacts.t[99]))
    # The window begins at a float: not on the impact, but half a unit of the last place from it.
    shift = 0.5 * np.spacing(late)
    assert (np.abs(computed - expected) < omega * shift * np.abs(expected) + 2 * shift).all()
    line = 2.0 * fourier_integral(run, np.array([2.0]), 0.0, run.t_end)[0] / run.t_end
    # The speed itself has rounded off by some 1e-11 over so many impacts.
    assert abs(line - -4 / (3 * math.pi) * run.impacts.v_after.mean()) < 1e-14


def test_amplitude_at_a_line_is_the_coefficient_of_the_fourier_series() -> None:
    """abs(sin t) = 2/pi - (4/pi) sum of cos(2 n t)/(4 n^2 - 1)."""
    run = pc.simulate(ELASTIC, v0=1.0, t_end=50 * math.pi)
    n = np.arange(1, 20)

    for window in ("none", "hann"):
        computed = pc.spectrum(run, omega=2.0 * n, window=window)
        np.testing.assert_allclose(computed.cosine, -4 / math.pi / (4 * n**2 - 1), rtol=1e-12)
        np.testing.assert_allclose(computed.sine, 0.0, atol=1e-14)
    lines = pc.line_spectrum(run, math.pi, 20)
    np.testing.assert_allclose(lines.cosine[1:], -4 / math.pi / (4 * n**2 - 1), rtol=1e-12)
    assert float(lines.cosine[0]) == pytest.approx(2 / math.pi, rel=1e-14)


def test_the_velocity_has_the_spectrum_of_the_derivative() -> None:
    run = run_of("impacts")
    omega = np.array([0.4, 1.5, 3.0])
    t = np.linspace(0, 31, 2_000_001)
    weight = 0.5 - 0.5 * np.cos(2 * math.pi * t / 31)

    computed = pc.spectrum(run, omega=omega, of="velocity")

    v = run(t)[1]
    summed = [np.trapezoid(weight * v * np.cos(w * t), t) / 15.5 * 2 for w in omega]
    np.testing.assert_allclose(computed.cosine, summed, atol=2e-6)


def test_the_power_integrates_to_the_mean_square() -> None:
    run = run_of("impacts")
    t = np.linspace(0, 31, 1_000_001)
    weight = (0.5 - 0.5 * np.cos(2 * math.pi * t / 31)) ** 2
    mean_square = np.trapezoid(weight * run(t)[0] ** 2, t) / np.trapezoid(weight, t)

    for spectrum in (pc.spectrum(run, omega=np.linspace(0, 60, 6001)), pc.spectrum(run, "fft")):
        assert float(spectrum.power.integrate("omega")) == pytest.approx(mean_square, rel=1e-4)


def test_fft_tends_to_the_exact_spectrum_as_its_aliases_move_away() -> None:
    run = run_of("impacts")
    errors = []
    for n in (2**10, 2**14):
        fast = pc.spectrum(run, "fft", n=n)
        few = slice(0, 200)
        exact = pc.spectrum(run, omega=fast.omega.values[few])
        errors.append(float(np.abs(fast.amplitude.values[few] - exact.amplitude.values).max()))
        np.testing.assert_allclose(fast.omega[1], 2 * math.pi / 31)
    # The velocity jumps, so the folded part falls with the square of the sampling rate.
    assert 1e-9 < errors[1] < errors[0] / 100 < 1e-4


def test_lines_of_a_periodic_motion_sum_to_it_and_others_show_a_mismatch() -> None:
    run = pc.simulate(ELASTIC, pc.sine(3), v0="0.45", t_end=100.0)
    lines = pc.line_spectrum(run, 4 * math.pi, 2001)
    assert max(float(lines.mismatch_x), float(lines.mismatch_v)) < 1e-13
    t = np.linspace(80.0, 92.0, 25)
    phase = np.multiply.outer(t, lines.omega.values)
    summed = np.cos(phase) @ lines.cosine.values + np.sin(phase) @ lines.sine.values
    np.testing.assert_allclose(summed, run(t)[0], atol=5e-5)

    assert float(pc.line_spectrum(run, 3 * math.pi, 3).mismatch_x) > 0.01


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda run: pc.spectrum(run, method="welch"), "neither exact nor fft"),  # type: ignore[arg-type]
        (lambda run: pc.spectrum(run, n=100), "fft"),
        (lambda run: pc.spectrum(run, "fft", omega=[1.0]), "follow from n"),
        (lambda run: pc.spectrum(run, "fft", n=3), "not a whole number of at least 4"),
        (lambda run: pc.spectrum(run, between=(3.0, 99.0)), "not two instants of the run"),
        (lambda run: pc.spectrum(run, omega=[math.nan]), "finite"),
        (lambda run: pc.spectrum(run, of="energy"), "neither displacement"),  # type: ignore[arg-type]
        (lambda run: pc.line_spectrum(run, 20.0), "do not fit"),
        (lambda run: pc.line_spectrum(run, -1.0), "positive"),
        (lambda run: pc.line_spectrum(run, 1.0, 0), "not a whole number of at least 1"),
    ],
)
def test_what_cannot_be_answered_is_refused(call, match: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(pc.ParameterError, match=match):
        call(run_of("impacts"))


def test_the_default_grid_reaches_beyond_the_forcing_and_is_never_too_long() -> None:
    short = pc.spectrum(run_of("impacts"))
    assert float(short.omega[-1]) == 36.0
    long = pc.spectrum(pc.simulate(ELASTIC, pc.sine(3), v0=1, t_end=1000.0))
    assert long.sizes["omega"] == 4096


def test_progress_is_told_and_stops_with_the_frequencies_that_are_done(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = pc.simulate(ELASTIC, pc.sine(3), v0="0.45", t_end=31.0)
    whole = pc.spectrum(run)
    module = sys.modules["percuss.motion.spectrum"]
    monkeypatch.setattr(module, "BETWEEN_REPORTS", 1)
    told: list[tuple[float, float]] = []

    def two_pieces(done: float, total: float) -> bool:
        told.append((done, total))
        return len(told) < 2

    part = pc.spectrum(run, progress=two_pieces)
    n, total = part.sizes["omega"], whole.sizes["omega"]
    assert told == [(n / 2, total), (n, total)]
    assert n < total
    assert np.allclose(part.amplitude, whole.amplitude[:n], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("size", ["1e200", "1.7e308"])
def test_the_greatest_motions_are_told_without_a_warning_of_numpy(size: str) -> None:
    """Their squares are beyond all floats."""
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.5")
    run = pc.simulate(osc, force, v0=size, periods=3)

    assert not np.isfinite(pc.spectrum(run).power.values).all()
    pc.line_spectrum(run, 2 * math.pi / 2.5)
    assert run.sensitivity(["forcing.amplitude"]).of("rms_displacement").shape == (1,)


@pytest.mark.parametrize("size", ["5e-324", "1e200", "1.7e305"])
def test_numbers_next_to_the_ends_of_floats_warn_nowhere(size: str) -> None:
    force = pc.cosine("2.3", amplitude=size)
    spring = pc.Oscillator(stops=[pc.SoftStop(0, "below", "1e6")])
    run = pc.simulate(pc.impact_oscillator("0.8"), force, v0=size, periods=5)

    assert run.sensitivity(["forcing.amplitude"]).of("rms_displacement").shape == (1,)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.FormalOrbitWarning)
        for osc in (spring, pc.impact_oscillator("0.8")):
            with contextlib.suppress(pc.PercussError):
                pc.find_orbit(osc, force)
