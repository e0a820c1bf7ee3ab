"""The data behind each figure of the paper, and how they are drawn."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

import percuss as pc
from percuss.motion.spectrum import line_spectrum
from percuss.paper.claims.resonances import OF_ORDER
from percuss.paper.collection import Item, figure_named, items
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import draw_curve, panels
from percuss.paper.figures.half_harmonic_figures import PORTRAIT_END
from percuss.paper.figures.power import PRINTED_POINTS
from percuss.paper.figures.printed_frames import FRAMES

mpl.use("agg")

FIGURES = {item.name: item for item in items() if item.kind == "figure"}
OF_THE_PAPER = [*(f"fig{n}" for n in range(1, 16)), "figA1"]


@cache
def data_of(name: str) -> xr.Dataset:
    return figure_named(FIGURES[name]).compute()


def test_every_figure_of_the_paper_is_there() -> None:
    assert set(OF_THE_PAPER) <= set(FIGURES)


def test_fig1_has_the_two_stiffnesses_of_figure_2() -> None:
    data = data_of("fig1")

    np.testing.assert_allclose(data.force.sel(x=slice(-1, -0.01)) / data.x[data.x < -0.009], 20)
    np.testing.assert_allclose(data.force.sel(x=slice(0.01, 2)) / data.x[data.x > 0.009], 1)


def test_fig2_is_driven_one_percent_above_resonance_and_drifts_against_the_force() -> None:
    data = data_of("fig2")
    root = math.sqrt(20)

    assert data.resonant_frequency == pytest.approx(2 * root / (1 + root), rel=1e-14)
    assert data.omega == pytest.approx(1.01 * data.resonant_frequency, rel=1e-14)
    # Flights last half a percent longer than the force's period, not once the period itself.
    assert data.flight_in_forcing_periods.min() > 1.004
    assert data.flight_in_forcing_periods[-1] == pytest.approx(1.005, abs=1e-4)


@pytest.mark.parametrize("name", ["fig3", "fig4"])
def test_figs_3_and_4_are_the_printed_motions_with_impact_times_y_m(name: str) -> None:
    data = data_of(name)

    assert data.time_error.max() < 1e-12
    assert data.motion_error.max() < 1e-12
    assert data.velocity.values == pytest.approx([0.0, 0.5, 2 / math.sqrt(3)])


def test_fig_a1_shows_u_below_w_only_above_the_critical_velocity() -> None:
    data = data_of("figA1")

    for m in (2, 3):
        is_above = data.attrs[f"v0_m{m}"] > data.attrs[f"critical_velocity_m{m}"]
        assert (data.attrs[f"least_gap_m{m}"] < 0) == is_above
    assert data.critical_velocity_m3 == pytest.approx(1 + 3 * math.sqrt(2) / 4, rel=1e-13)


def test_fig5_gains_2n_over_n_squared_less_1_at_each_impact() -> None:
    data = data_of("fig5")

    for n in (2, 4, 6):
        v = data[f"impact_v_n{n}"].values
        np.testing.assert_allclose(v, 2 * n / (n * n - 1) * np.arange(1, 9), rtol=1e-12)
        np.testing.assert_allclose(data[f"impact_t_n{n}"], math.pi * np.arange(1, 9), rtol=1e-14)


def test_fig6a_hits_at_multiples_of_pi() -> None:
    t = data_of("fig6").impact_t_above_limit.values

    np.testing.assert_allclose(t, math.pi * np.arange(1, t.size + 1), rtol=0, atol=1e-12)
    assert t.size == 29


def test_fig6b_is_periodic_in_the_limit_with_six_impacts_in_4_pi() -> None:
    t = data_of("fig6").impact_t_below_limit.values

    np.testing.assert_allclose(t[6:] - t[:-6], 4 * math.pi, rtol=0, atol=1e-10)
    assert np.abs(t[3:] - t[:-3] - 2 * math.pi).min() > 0.01


def test_fig6_tells_the_limit_from_both_readings_of_the_stiffness() -> None:
    data = data_of("fig6")

    assert 1e-4 < data.off_limit_below_stiff < 0.01 < data.off_limit_below_soft < 0.5


def test_fig6c_shows_the_distances_that_its_caption_names() -> None:
    data = data_of("fig6")

    for name in ("stiff", "soft"):
        shown = data[f"difference_{name}"].max()
        # The curve is searched at 2^14 points, the caption's number at 20,001.
        assert shown == pytest.approx(data.attrs[f"off_limit_below_{name}"], rel=0.01)
    assert data.difference_stiff.max() < data.difference_steps.max() < data.difference_soft.max()


def test_fig2_fills_the_printed_axes() -> None:
    """Displacements are proportional to the amplitude, which the paper does not state."""
    data = data_of("fig2")
    turns = data.t_run * data.resonant_frequency / (2 * math.pi)

    assert float(data.x_run[turns <= 7].max()) == pytest.approx(8, rel=0.02)
    assert float(data.x_run[turns >= 56].max()) == pytest.approx(40, rel=0.02)


def test_fig7_turns_on_the_wall_with_the_velocity_it_started_with() -> None:
    data = data_of("fig7")
    jumps = np.flatnonzero(data.jump_above_limit)

    np.testing.assert_allclose(data.v_above_limit[jumps], -0.51, rtol=1e-12)
    np.testing.assert_allclose(data.v_above_limit[jumps + 1], 0.51, rtol=1e-12)


def test_fig8_has_the_lines_of_the_exact_fourier_series_on_the_printed_scale() -> None:
    data = data_of("fig8")
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", t_end=30 * math.pi)
    lines = line_spectrum(run, 2 * math.pi, 37)

    heights = PRINTED_POINTS * (lines.amplitude.values / 2) ** 2
    heights[0] *= 4
    for n in (0, 1, 2, 3, 4, 6, 10, 36):
        at = np.argmin(np.abs(data.omega_above_limit.values - n))
        # The grid is one step in 2^20 too long: at n it misses 15 n 2^-20 of the width of a line.
        assert data.S_above_limit[at] == pytest.approx(heights[n], rel=1e-5)


@pytest.mark.parametrize("name", ["above_limit", "below_limit"])
def test_fig8_is_the_fast_fourier_transform_of_the_printed_points(name: str) -> None:
    """The scale as its formula, by numpy's transform: between the lines too."""
    data = data_of("fig8")
    v0 = {"above_limit": "0.51", "below_limit": "0.45"}[name]
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=v0, t_end=30 * math.pi)
    x = run(np.linspace(0.0, 30 * math.pi, PRINTED_POINTS))[0]

    total = np.abs(np.fft.rfft(x)[: data.sizes[f"{name}_line"]])

    found = np.sqrt(data[f"S_{name}"].values * PRINTED_POINTS)
    # Each of the 30 to 44 impacts adds an eighth of a step's jump of the velocity, 9e-5, at most.
    np.testing.assert_allclose(found, total, rtol=1e-7, atol=44 * 9e-5 / 8)


def test_only_the_unitary_transform_puts_fig8_on_the_printed_axes() -> None:
    """The printed numbers end at 10^5 and 10^-9, two decades from the next ones."""
    above, below = FRAMES["fig8"]
    data = data_of("fig8")
    top, median = data.S_above_limit.max(), data.S_above_limit.median()

    def fits(factor: float) -> bool:
        top_fits = above.upwards[1] / 100 < factor * top < above.upwards[1] * 100
        return bool(top_fits and above.upwards[0] / 100 < factor * median < above.upwards[0] * 100)

    duration = (30 * math.pi) ** 2 / PRINTED_POINTS
    assert [fits(f) for f in (1, PRINTED_POINTS, 1 / PRINTED_POINTS, duration)] == [1, 0, 0, 0]
    assert below.upwards[0] < data.S_below_limit.min() < data.S_below_limit.max() < 1e2 * 1e5


def test_the_slow_fall_of_fig8b_comes_from_the_cut_of_half_a_period() -> None:
    data = data_of("fig8")
    high = data.omega_below_limit.values > 18

    between = data.S_below_limit.values[high]
    assert np.median(between) > 1e-2
    assert data.floor_of_whole_periods < 1e-8


def test_fig8_is_wide_only_with_the_softer_stop() -> None:
    data = data_of("fig8")
    between = {}
    for name in ("above_limit", "below_limit", "below_soft"):
        omega, s = data[f"omega_{name}"].values, data[f"smooth_{name}"].values
        high = omega > 18
        off = high & (np.abs(2 * omega - np.round(2 * omega)) > 0.3)
        between[name] = s[off].sum() / s[high].sum()

    # The grid, one step in 2^20 too long, lets the window's side lobes through.
    assert between["above_limit"] < 1e-8
    assert between["below_limit"] < 1e-3
    assert between["below_soft"] > 0.1


def test_fig9_stays_on_the_eigenset_with_little_room() -> None:
    data = data_of("fig9")

    assert data.time_error < 1e-11
    assert 0 < data.clearance < 1e-3


def test_figs_10_and_11_grow_towards_the_asymptotic_law() -> None:
    data = data_of("fig10")

    # Of V^2/t two neighbouring impacts: the alternation of V cancels to the first order.
    t, v = data.impact_t_limit.values[-2:], data.impact_v_limit.values[-2:]
    assert math.sqrt((v**2).mean() / t.mean()) == pytest.approx(data.asymptotic_factor, rel=0.02)
    assert 0.4 < data.velocity_exponent < 0.55
    assert 0.4 < data.displacement_exponent < 0.55


def test_figs_10_to_12_grow_less_with_the_softer_stop() -> None:
    data = data_of("fig12")
    greatest = [float(data[f"x_{name}"].max()) for name in ("limit", "stiff", "soft")]

    assert greatest[0] > greatest[1] > 2 * greatest[2]


def test_fig12_fits_the_printed_frame_until_t_65() -> None:
    data = data_of("fig12")
    (frame,) = FRAMES["fig12"]
    shown = data.t_limit <= PORTRAIT_END

    assert 0.9 * frame.across[1] < data.x_limit[shown].max() < frame.across[1] < data.x_limit.max()
    assert np.abs(data.v_limit[shown]).max() < frame.upwards[1] < np.abs(data.v_limit).max()
    # The softer stop stays within a printed step of the frame, below half of figures 10 and 11.
    assert data.x_soft.max() < min(6.0, FRAMES["fig11"][0].upwards[1] / 2)
    assert np.abs(data.v_soft).max() < min(6.0, -FRAMES["fig10"][0].upwards[0] / 2)


def test_peaks_of_figs_10_and_11_alternate_about_the_asymptotic_factor() -> None:
    data = data_of("fig10")

    for what in ("v", "x"):
        factor = (data[f"peak_{what}"] / np.sqrt(data[f"peak_t_{what}"])).values[-60:]
        lower, higher = sorted((factor[::2], factor[1::2]), key=np.median)
        assert lower.max() < data.asymptotic_factor < higher.min()
        # Both come closer to it.
        assert lower[-1] > lower[0] - 1e-3
        assert higher[-1] < higher[0]


def test_fig13_has_its_strongest_line_at_the_resonant_frequency() -> None:
    data = data_of("fig13")

    for name in ("limit", "stiff"):
        moving = data[f"omega_{name}"].values > 0.5
        strongest = data[f"S_{name}"].values[moving].argmax()
        assert data[f"omega_{name}"].values[moving][strongest] == pytest.approx(2, abs=0.02)


def test_figs_14_and_15_do_not_grow_in_the_limit() -> None:
    data = data_of("fig14")

    assert data.closed_form_error < 1e-10
    assert np.abs(data.v_limit).max() == pytest.approx(math.pi / 2, rel=1e-12)
    # The greatest value of (t/2) sin t on [0, pi], where tan t = -t.
    assert data.x_limit.max() == pytest.approx(0.90985299, rel=1e-3)
    assert data.x_limit.max() < data.x_stiff.max() < data.x_soft.max()


def test_coarse_steps_follow_the_growth_but_not_the_touches() -> None:
    resonance, touches = data_of("fig10"), data_of("fig14")

    assert resonance.x_steps.max() == pytest.approx(float(resonance.x_stiff.max()), rel=0.02)
    exact = np.interp(touches.t_steps, touches.t_stiff, touches.x_stiff)
    assert np.abs(touches.x_steps - exact).max() > 0.5 * touches.x_stiff.max()


def test_colours_of_the_portraits_tell_growth() -> None:
    data = data_of("resonance-portraits")

    for number in range(5):
        # At omega = 2 motions come in from below and leave above.
        y, grows = data[f"y_2_{number}"].values, data[f"grows_2_{number}"].values.astype(bool)
        far = np.abs(y) > 10
        np.testing.assert_array_equal(grows[far], y[far] > 0)


@pytest.mark.parametrize(("name", "column"), [("losses-curves", "0"), ("losses-bilinear", "0_0")])
def test_losses_show_every_start(name: str, column: str) -> None:
    data = data_of(name)
    ax = figure_named(FIGURES[name]).draw(data).axes[0]

    drawn = sum(np.size(line.get_xdata()) for line in ax.lines if line.get_marker() == ".")
    columns = (column,) if name == "losses-curves" else ("0_0", "0_1")
    assert drawn == sum(data[f"speed_{one}"].size for one in columns)
    assert data.sizes["start"] >= 3


@pytest.mark.parametrize("name", [f"fig{n}" for n in range(2, 16)] + ["figA1"])
def test_the_printed_frame_is_drawn_with_its_numbers(name: str) -> None:
    figure = figure_named(FIGURES[name])
    axes = [ax for ax in figure.draw(data_of(name)).axes if ax.axison]

    assert figure.frames == FRAMES[name]
    for ax, frame in zip(axes, [*figure.frames, *[figure.frames[-1]] * 3], strict=False):
        if name == "fig6" and ax is axes[2]:
            continue  # distances, not in the paper
        marked = [patch for patch in ax.patches if patch.get_gid() == "printed frame"]
        shown = np.array([ax.get_xlim(), ax.get_ylim()])
        printed = np.array([frame.across, frame.upwards])
        assert (shown[:, 0] <= printed[:, 0]).all()
        assert (shown[:, 1] >= printed[:, 1]).all()
        # A rectangle exactly where more is shown than is printed.
        assert len(marked) == (shown != printed).any()
        assert set(frame.x) <= {float(tick) for tick in ax.get_xticks()}
        assert set(frame.y) <= {float(tick) for tick in ax.get_yticks()}
    ends = f"{figure.frames[0].upwards[0]:g} to {figure.frames[0].upwards[1]:g}"
    assert ends in figure.full_caption(data_of(name))


@pytest.mark.parametrize("name", ["fig2", "fig3", "fig4", "fig5", "fig6", "fig9", "fig11", "fig15"])
def test_the_motion_ends_within_a_printed_step_of_the_frame(name: str) -> None:
    """An axis ends less than a step beyond its last number, or that would be printed."""
    figure = figure_named(FIGURES[name])
    axes = figure.draw(data_of(name)).axes

    for ax, frame in zip(axes, figure.frames, strict=False):
        values = np.concatenate(
            [np.asarray(line.get_ydata(), dtype=float) for line in ax.lines[:1]]
        )
        step = frame.y[-1] - frame.y[-2]
        assert np.nanmin(values) > frame.y[0] - step
        assert np.nanmax(values) < frame.y[-1] + step


# Figures that take seconds each, with less of what they show.
FEWER: dict[str, dict[str, dict[str, Any]]] = {
    "resonance-scan": {"resonance_figures": {"MOTIONS": 4, "IMPACTS": 200}},
    "resonance-growth": {
        "resonance_figures": {
            "OF_ORDER": {q: (omega, 4, 4000) for q, (omega, *_) in OF_ORDER.items()}
        }
    },
    "losses-curves": {"loss_figures": {"LOSSES": ((0.6, 0.05),)}},
    "losses-bilinear": {"loss_figures": {"STIFFNESSES": (4.0,), "DAMPINGS": (0.02, 0.1)}},
    "losses-peaks": {"loss_figures": {"LOST": (0.4, 0.2), "HALF_LOST": (0.2, 0.1)}},
    # `test_smooth_law` tests what it measures.
    "limit-smoothed": {"limit_figures": {"time_gained": lambda: (18.0, 0.5)}},
}


@pytest.mark.parametrize("name", list(FIGURES))
def test_every_axis_has_a_label_and_every_figure_a_caption(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module, constants in FEWER.get(name, {}).items():
        for constant, value in constants.items():
            monkeypatch.setattr(f"percuss.paper.figures.{module}.{constant}", value)
    figure = figure_named(FIGURES[name])

    check_words(figure, figure.compute() if name in FEWER else data_of(name))


@pytest.mark.nightly
@pytest.mark.parametrize("name", FEWER)
def test_whole_figures_have_labels_and_captions_too(name: str) -> None:
    check_words(figure_named(FIGURES[name]), data_of(name))


def check_words(figure: Figure, data: xr.Dataset) -> None:
    picture = figure.draw(data)
    drawn = [ax for ax in picture.axes if ax.axison]

    assert any(ax.get_xlabel() for ax in drawn)
    assert all(ax.get_xlabel() for ax in drawn if ax.xaxis.get_tick_params()["labelbottom"])
    assert all(ax.get_ylabel() or figure.name == "fig1" for ax in drawn)
    assert figure.caption(data).endswith(".")


def test_captions_take_their_numbers_from_the_data() -> None:
    figure = figure_named(FIGURES["fig5"])
    data = data_of("fig5").copy(deep=True)
    data["gain"] = data.gain * 2

    assert figure.caption(data) != figure.caption(data_of("fig5"))
    assert "2.666666666667" in figure.caption(data)


def test_a_long_line_keeps_its_extremes_and_few_points() -> None:
    t = np.linspace(0, 1, 100_001)
    values = np.sin(1e4 * t)
    values[61_234] = 7.0

    _, (ax,) = panels(1)
    draw_curve(ax, t, values)
    (line,) = ax.lines

    assert len(np.asarray(line.get_ydata())) < 10_000
    assert np.nanmax(np.asarray(line.get_ydata(), dtype=float)) == 7.0


def test_names_are_unique() -> None:
    seen: set[tuple[str, str]] = {(item.kind, item.name) for item in items()}

    assert len(seen) == len(items())
    assert all(isinstance(item, Item) for item in items())


@pytest.mark.parametrize("name", ["fig3", "fig4"])
def test_the_legend_above_leaves_the_words_beside_it_free(name: str) -> None:
    picture = figure_named(FIGURES[name]).draw(data_of(name))
    picture.canvas.draw()

    (ax,) = picture.axes
    legend = ax.get_legend()
    assert legend is not None
    (words,) = (text for text in ax.findobj(Text) if text.get_text() == "dotted: printed numbers")
    assert not legend.get_window_extent().overlaps(words.get_window_extent())
