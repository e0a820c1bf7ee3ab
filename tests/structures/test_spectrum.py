"""Spectra of structures' runs, against Gauss's rule, closed forms and the oscillator's own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import percuss as pc
import percuss.plotting as pp
from percuss.arrays import Complexes, Floats
from percuss.motion.spectrum import signal_of

DRIVE = pc.cosine("1.5", amplitude=2, constant="0.3")
NOISE = pc.record(np.linspace(0.0, 50.0, 60), np.random.default_rng(0).normal(size=60))
WALL = pc.Wall("0.3", "above", "0.5", on=1)
CHAIN = pc.chain(
    [1, 2, 1], [1, 3, 2, 0], "0.1", [WALL, pc.SoftStop("0.2", "above", 20, on=(1, -1, 0))]
)
CASES: dict[str, tuple[pc.Structure, pc.Loads, tuple[int, ...]]] = {
    "wall and soft stop": (CHAIN, pc.Loads({0: DRIVE, 1: pc.sine(2)}), (0, 1, 1)),
    "sticking": (
        pc.chain([1, 2, 1], [1, 3, 2, 0], "0.4", [pc.Wall("0.05", "above", "0.2", on=1)]),
        pc.Loads({0: pc.cosine("0.4", amplitude=3)}),
        (0, 1, 1),
    ),
    "record": (pc.chain([1, 2, 1], [1, 3, 2, 0], "0.1", [WALL]), pc.Loads({0: NOISE, 1: DRIVE}),
               (1, 0, 0)),
    "resonance without damping": (
        pc.chain([1, 1], [1, 1, 1], 0, [pc.Wall(3, "above", on=1)]), pc.Loads({0: pc.cosine(1)}),
        (0, 1),
    ),
    "gyroscopic": (
        pc.Structure([1, 2], [[3, -1], [-1, 2]], [["0.2", "0.5"], ["-0.5", "0.1"]],
                     [pc.SoftStop("0.2", "above", 30, "0.3", on=0)]),
        pc.Loads({0: DRIVE}),
        (1, 2),
    ),
}  # fmt: skip


def by_gauss(
    run: pc.StructureTrajectory, c: Any, omega: Floats, low: float, high: float
) -> Complexes:
    """The integral of c . x exp(-i w (t - low)), in pieces of 0.02 that no event cuts."""
    events = run.record.events[:, 0]
    inside = events[(events > low) & (events < high)]
    edges = np.unique(np.concatenate([inside, np.arange(low, high, 0.02), [high]]))
    nodes, weights = np.polynomial.legendre.leggauss(12)
    widths = np.diff(edges)[:, None]
    t = (edges[:-1, None] + 0.5 * widths * (1.0 + nodes)).ravel()
    values = (run(t)[0] * np.asarray(c)).sum(axis=1) * (0.5 * widths * weights).ravel()
    return np.array([(values * np.exp(-1j * w * (t - low))).sum() for w in omega])


@pytest.mark.parametrize("name", CASES)
def test_the_integral_is_that_of_gauss(name: str) -> None:
    structure, loads, c = CASES[name]
    run = pc.simulate(structure, loads, t_end=60)
    # Among them the frequencies of modes and of loads, where integration by parts has no digits.
    omega = np.concatenate([np.linspace(-1.0, 12.0, 40), [1.0, 1.5, 2.0, math.sqrt(3.0)]])
    signal = signal_of(run, c)

    for low, high in ((0.0, 60.0), (3.3, 41.7)):
        exact = by_gauss(run, c, omega, low, high)
        np.testing.assert_allclose(
            signal.integral(omega, low, high), exact, rtol=0, atol=2e-13 * np.abs(exact).max()
        )


def test_one_coordinate_has_the_spectrum_of_the_oscillator() -> None:
    stops = (pc.Wall("0.5", "above", "0.8"),)
    one = pc.simulate(pc.Structure(1, 1, "0.1", stops), pc.Loads({0: DRIVE}), t_end=20)
    other = pc.simulate(pc.Oscillator(1, "0.05", stops), DRIVE, t_end=20)
    assert len(one.impacts) == len(other.impacts) > 2

    for method in ("exact", "fft"):
        for of in ("displacement", "velocity"):
            own, its = (pc.spectrum(run, method, of=of) for run in (one, other))
            assert own.attrs == its.attrs
            np.testing.assert_array_equal(own.omega, its.omega)
            largest = float(its.amplitude.max())
            np.testing.assert_allclose(own.amplitude, its.amplitude, rtol=0, atol=1e-11 * largest)


def test_lines_of_an_orbit_sum_up_to_its_motion() -> None:
    stops = [pc.SoftStop("0.2", "above", 20, on=(1, -1))]
    structure, loads = pc.chain([1, 1], [1, 1, 0], "0.3", stops), pc.Loads({0: pc.cosine("0.9")})
    run = pc.simulate(structure, loads, periods=150)
    assert len(run.crossings) > 200
    period = loads.period
    assert period is not None

    lines = pc.line_spectrum(run, period, 400, on=(1, -1))

    assert max(float(lines.mismatch_x), float(lines.mismatch_v)) < 1e-11
    t = np.linspace(run.t_end - period, run.t_end, 50)
    angles = np.multiply.outer(t, lines.omega.values)
    y = np.cos(angles) @ lines.cosine.values + np.sin(angles) @ lines.sine.values
    # The force of the soft stop has kinks: the lines fall as n^-4, what is left out as n^-3.
    np.testing.assert_allclose(y, run.displacement((1, -1), t)[0], rtol=0, atol=2e-7)


def test_points_and_pictures_have_spectra() -> None:
    beam = pc.cantilever(2, damping_ratio="0.05", points={"tip": 1})
    run = pc.simulate(beam, pc.Loads({"tip": pc.cosine(2)}), t_end=200)

    ax = pp.plot_spectrum(run, on="tip")

    (line,) = ax.lines
    heights = np.asarray(line.get_ydata(), dtype=float)
    assert heights.max() == pytest.approx(float(pc.spectrum(run, on="tip").amplitude.max()))


def test_what_has_no_spectrum_is_told() -> None:
    structure, loads, _ = CASES["gyroscopic"]
    run = pc.simulate(structure, loads, t_end=5)
    with pytest.raises(pc.ParameterError, match="on = None: not said on what it acts"):
        pc.spectrum(run)
    with pytest.raises(pc.ParameterError, match="on = 2: no such coordinate"):
        pc.line_spectrum(run, 1.0, on=2)
    bouncing = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=9.0)
    with pytest.raises(pc.ParameterError, match="on = 1: a run of an oscillator has one displac"):
        pc.spectrum(bouncing, on=1)
