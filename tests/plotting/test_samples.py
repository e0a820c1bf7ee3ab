"""Curves are dense enough to be true, and reduced to what can be seen."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import percuss as pc
from percuss import plotting
from percuss.arrays import Floats
from percuss.motion.trajectory import Trajectory
from percuss.plotting import samples
from percuss.plotting.samples import (
    SampledMotion,
    reduce_to_columns,
    reduce_to_pixels,
    sample_curve,
    sample_in_full,
)


def test_a_chord_stays_close_to_the_curve(between_stops: Trajectory) -> None:
    curve = sample_curve(between_stops)

    flown = np.flatnonzero(np.diff(curve.t) > 0.0)
    middle = 0.5 * (curve.t[flown] + curve.t[flown + 1])
    x, v = between_stops(middle)
    # 64 points a cycle keep chords within 0.12 % of the amplitude.
    for exact, drawn in ((x, curve.x), (v, curve.v)):
        chord = 0.5 * (drawn[flown] + drawn[flown + 1])
        assert np.abs(chord - exact).max() < 1.3e-3 * np.ptp(drawn)


def test_a_short_visit_to_a_stiff_stop_is_drawn_round() -> None:
    osc = pc.bilinear_oscillator(stiffness_below=4e8)
    run = pc.simulate(osc, v0=1.0, t_end=10.0)

    curve = sample_curve(run)
    entry, exit_ = run.crossings.t[:2]

    assert ((curve.t > entry) & (curve.t < exit_)).sum() >= 30
    # The deepest point of half a cycle at frequency 2e4 and speed 1.
    assert curve.x.min() == pytest.approx(-1.0 / 2e4, rel=2e-3)


def test_a_window_cuts_the_curve(elastic: Trajectory) -> None:
    inside, beyond = sample_curve(elastic, (5.0, 7.0)), sample_curve(elastic, (30.0, 60.0))

    assert (inside.t[0], inside.t[-1]) == (5.0, 7.0)
    assert (beyond.t[0], beyond.t[-1]) == (30.0, elastic.t_end)


@pytest.mark.parametrize(
    ("window", "words"),
    [
        ((50.0, 60.0), r"window = \(50.0, 60.0\): outside the run, 0.0 to 31.0"),
        ((-2.0, 0.0), "outside the run"),
        ((7.0, 5.0), r"window = \(7.0, 5.0\): the first time is not before the last"),
        ((5.0, 5.0), "not before"),
        (100, "window = 100: not a pair of times"),
        ((1.0, 2.0, 3.0), "not a pair"),
        ((float("nan"), 2.0), "not finite"),
    ],
)
def test_a_window_that_shows_nothing_is_refused(
    window: Any, words: str, elastic: Trajectory
) -> None:
    with pytest.raises(pc.ParameterError, match=words):
        sample_curve(elastic, window)


def test_numbers_too_large_for_a_picture_are_left_out() -> None:
    run = pc.simulate(pc.Oscillator(stiffness=-1.0), x0=1.0, t_end=500.0)

    curve = sample_curve(run)

    assert np.abs(curve.x).max() <= samples.LARGEST
    assert curve.t[0] == 0.0


walks = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).normal(size=5000).cumsum()
)


@given(values=walks, breaks=st.sets(st.integers(0, 4998), max_size=20))
def test_reduced_columns_keep_the_extremes_of_every_column(
    values: Floats, breaks: set[int]
) -> None:
    t = np.linspace(3.0, 4.0, values.size)
    jumps = np.isin(np.arange(values.size), list(breaks))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(samples, "DRAWN_POINTS", 100)
        patch.setattr(samples, "COLUMNS", 50)
        t_left, left, jumps_left = reduce_to_columns(t, values, jumps)

    assert left.size <= 2 * (50 + 1 + len(breaks))
    assert (np.diff(t_left) > 0).all()
    assert np.isin(left, values).all()
    column = np.minimum(((t - 3.0) * 50).astype(int), 50)
    column_left = np.minimum(((t_left - 3.0) * 50).astype(int), 50)
    for k in range(50):
        whole, part = values[column == k], left[column_left == k]
        assert (part.min(), part.max()) == (whole.min(), whole.max())
    # Two neighbours are joined only if no jump lies between them.
    for a, b, is_apart in zip(t_left[:-1], t_left[1:], jumps_left[:-1], strict=True):
        assert is_apart == bool(jumps[(t >= a) & (t < b)].any())


def test_short_curves_are_drawn_as_they_are(elastic: Trajectory) -> None:
    curve = sample_curve(elastic)

    t, x, _ = reduce_to_columns(curve.t, curve.x, curve.jumps)

    np.testing.assert_array_equal(t, curve.t)
    np.testing.assert_array_equal(x, curve.x)


@given(values=walks)
def test_a_reduced_portrait_leaves_out_only_what_lies_on_the_rest(values: Floats) -> None:
    x, v = values, np.roll(values, 7)
    jumps = np.arange(values.size) % 1000 == 999
    jumps[-1] = False
    curve = SampledMotion(np.arange(values.size, dtype=np.float64), x, v, jumps)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(samples, "DRAWN_POINTS", 100)
        patch.setattr(samples, "COLUMNS", 20)
        x_left, v_left = reduce_to_pixels(curve)
        pixels = samples._pixels

        def chords(a: Floats, b: Floats) -> set[tuple[int, ...]]:
            joined = np.isfinite(a[:-1]) & np.isfinite(a[1:])
            every = [a[:-1][joined], b[:-1][joined], a[1:][joined], b[1:][joined]]
            return set(
                zip(
                    *(
                        pixels(np.append(part, lim))[: part.size].tolist()
                        for part, lim in zip(
                            every, ([x.min(), x.max()], [v.min(), v.max()]) * 2, strict=True
                        )
                    ),
                    strict=True,
                )
            )

        kept = chords(x_left, v_left)
        whole = np.insert(x, np.flatnonzero(jumps) + 1, np.nan)
        other = np.insert(v, np.flatnonzero(jumps) + 1, np.nan)
        assert kept == chords(whole, other)


def test_a_periodic_motion_is_drawn_once_however_long_it_is() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", max_impacts=5000)

    curve = sample_curve(run)
    x, _ = reduce_to_pixels(curve)

    assert curve.x.size > 300_000
    assert x.size < 20_000


def test_of_many_dots_the_last_in_each_cell_is_left() -> None:
    x, y = np.random.default_rng(1).uniform(size=(2, 100_000)) ** 2

    kept = samples.topmost(x, y)

    cell = samples._pixels(x, samples.DOT_COLUMNS) * 1000 + samples._pixels(y, samples.DOT_COLUMNS)
    last = {code: index for index, code in enumerate(cell.tolist())}
    assert set(kept.tolist()) == set(last.values())
    assert kept.size < x.size
    assert samples.topmost(x[:1000], y[:1000]).size == 1000


def test_of_many_spans_the_long_ones_and_one_a_pixel_column_are_left() -> None:
    first = np.sort(np.random.default_rng(1).uniform(0.0, 1.0, 100_000))
    last = first + 1e-6
    last[777] = first[777] + 0.1

    kept = samples.distinct_spans(first, last, np.zeros(first.size), 1.0)

    assert 777 in kept
    assert samples.COLUMNS // 2 < kept.size <= samples.COLUMNS + 2
    assert np.diff(first[kept], prepend=0.0, append=1.0).max() < 3.0 / samples.COLUMNS


@pytest.mark.parametrize("budget", [20_000, 1_000_000])
def test_chords_of_a_long_run_are_as_true_as_those_of_a_short_one(
    budget: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(samples, "BUDGET", budget)
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    run = pc.simulate(osc, pc.cosine(2), v0="0.5", periods=500)

    curve = sample_in_full(run)
    drawn = np.flatnonzero((np.diff(curve.t) > 0.0) & ~curve.jumps[:-1])
    x, _ = run(0.5 * (curve.t[drawn] + curve.t[drawn + 1]))
    chord = 0.5 * (curve.x[drawn] + curve.x[drawn + 1])

    assert curve.t.size <= budget
    assert (curve.t[0], curve.t[-1]) == (0.0, run.t_end)
    assert np.abs(chord - x).max() < 1.3e-3 * np.ptp(curve.x)
    assert curve.jumps.sum() >= (budget < 1_000_000) * 100


@pytest.mark.parametrize("end", [1e3, 1e5, 1e14])
def test_the_portrait_of_a_long_free_motion_is_a_circle(end: float) -> None:
    """Chords of a polygon would lie inside of it."""
    ax = plotting.plot_phase_portrait(pc.simulate(pc.Oscillator(), v0=1, t_end=end))

    x, v = np.asarray(ax.lines[0].get_data())
    radius = np.hypot(0.5 * (x[1:] + x[:-1]), 0.5 * (v[1:] + v[:-1]))
    assert np.nanmin(radius) > 0.998
    plt.close(ax.figure)
