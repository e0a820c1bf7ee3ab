"""The data behind each figure of the paper, and how they are drawn."""

from __future__ import annotations

import math
from functools import cache

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

import percuss as pc
from percuss.motion.spectrum import line_spectrum
from percuss.paper.collection import Item, figure_named, items
from percuss.paper.figures.drawing import draw_curve, panels

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


def test_fig7_turns_on_the_wall_with_the_velocity_it_started_with() -> None:
    data = data_of("fig7")
    jumps = np.flatnonzero(data.jump_above_limit)

    np.testing.assert_allclose(data.v_above_limit[jumps], -0.51, rtol=1e-12)
    np.testing.assert_allclose(data.v_above_limit[jumps + 1], 0.51, rtol=1e-12)


def test_fig8_has_the_lines_of_the_periodic_motion_at_their_height() -> None:
    data = data_of("fig8")
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", t_end=30 * math.pi)
    lines = line_spectrum(run, 2 * math.pi, 5)

    for n in (1, 2, 3):
        at = np.argmin(np.abs(data.omega_above_limit.values - n))
        height = float(lines.amplitude[n]) ** 2 / 4
        assert data.S_above_limit[at] == pytest.approx(height, rel=1e-9)


def test_fig8_is_wide_only_with_the_softer_stop() -> None:
    data = data_of("fig8")
    between = {}
    for name in ("above_limit", "below_limit", "below_soft"):
        omega, s = data[f"omega_{name}"].values, data[f"S_{name}"].values
        high = omega > 18
        off = high & (np.abs(2 * omega - np.round(2 * omega)) > 0.3)
        between[name] = s[off].sum() / s[high].sum()

    assert between["above_limit"] < 1e-20
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


@pytest.mark.parametrize("name", list(FIGURES))
def test_every_axis_has_a_label_and_every_figure_a_caption(name: str) -> None:
    figure = figure_named(FIGURES[name])
    picture = figure.draw(data_of(name))
    drawn = [ax for ax in picture.axes if ax.axison]

    assert any(ax.get_xlabel() for ax in drawn)
    assert all(ax.get_xlabel() for ax in drawn if ax.xaxis.get_tick_params()["labelbottom"])
    assert all(ax.get_ylabel() or name == "fig1" for ax in drawn)
    assert figure.caption(data_of(name)).endswith(".")


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
