"""Figures 10 to 13: the half-harmonic resonance from rest."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.forcing import sine
from percuss.motion.growth import growth
from percuss.motion.half_harmonic import half_harmonic_growth
from percuss.motion.trajectory import Trajectory
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import COLOURS, draw_envelope, label, styled
from percuss.paper.figures.model_panels import heading, portraits, spectra, time_panels
from percuss.paper.figures.power import with_power
from percuss.paper.models.motions import (
    MODEL_LABELS,
    STEP_TOLERANCE,
    motion_dataset,
    simulate_all,
    step_columns,
    step_through,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

__all__ = ["FIGURES"]

T_END = 400
PRINTED_FACTOR = 0.61
HIGHEST = 36.0
NAMES = ("limit", "stiff", "soft")
ALL_NAMES = (*NAMES, "steps")
# The envelope is fitted where the motion has forgotten its start.
FITTED_FROM = 40.0


def runs() -> dict[str, Trajectory]:
    """Return the half-harmonic from rest: the limit and both bilinear oscillators."""
    return simulate_all(sine(1), 0, T_END)


@cache
def motions() -> Dataset:
    """Return the three motions, the second also by steps, and the law of the limit's growth."""
    data = motion_dataset(runs(), v0=0.0, printed_factor=PRINTED_FACTOR)
    limit = runs()["limit"]
    data = data.assign(step_columns("steps", step_through(sine(1), 0, T_END)))
    for what in ("velocity", "displacement"):
        law = growth(limit, what, since=FITTED_FROM)
        data.attrs[f"{what}_factor"] = law.coefficient
        data.attrs[f"{what}_exponent"] = law.exponent
        data.attrs[f"{what}_exponent_error"] = law.exponent_error
    last = half_harmonic_growth(float(limit.impacts.t[-1]), float(limit.impacts.v_after[-1]))
    return data.assign_attrs(asymptotic_factor=last.constant)


def _law(data: Dataset, what: str) -> str:
    """Return the fitted envelope of the limit in words."""
    attrs = data.attrs
    return (
        f"{attrs[f'{what}_factor']:.3f} t^({attrs[f'{what}_exponent']:.3f} ± "
        f"{attrs[f'{what}_exponent_error']:.3f})"
    )


def _greatest(data: Dataset, what: str) -> str:
    """Return the greatest values of the four motions as a list."""
    values = [float(np.abs(data[f"{what}_{name}"].values).max()) for name in ALL_NAMES]
    return f"{', '.join(f'{value:.3f}' for value in values[:-1])} and {values[-1]:.3f}"


def _caption_velocity(data: Dataset) -> str:
    return (
        "Velocity of the half-harmonic resonance x'' + x = sin t from rest. (a) In the exact limit "
        f"the impact velocity grows as {_law(data, 'velocity')}, fitted from t = {FITTED_FROM:g} "
        "on; the factor b of the asymptotics b sqrt t, computed from the last impact, is "
        f"{data.asymptotic_factor:.5f}; dashed, {PRINTED_FACTOR:g} sqrt t. The bilinear oscillator "
        "of the paper, solved exactly with 2e4 as the ratio of frequencies (b) and of their "
        "squares (c), and (b) once more as the paper computed it, by Runge-Kutta, here to a "
        f"coarse {STEP_TOLERANCE:g} a step (d). "
        f"Greatest speeds to t = {T_END}: {_greatest(data, 'v')}."
    )


def _caption_displacement(data: Dataset) -> str:
    return (
        "Displacement of the same motions. (a) In the limit the highest points of the flights grow "
        f"as {_law(data, 'displacement')}; dashed, {PRINTED_FACTOR:g} sqrt t, which the paper "
        "fitted by eye. (b), (c) The bilinear oscillator, exactly; (d) by Runge-Kutta. Greatest "
        f"displacements: {_greatest(data, 'x')}."
    )


def _draw(data: Dataset, what: str) -> Picture:
    figure, axes = time_panels(data, ALL_NAMES, what)
    text = rf"${PRINTED_FACTOR:g}\,\sqrt{{t}}$"
    for ax, name, letter in zip(axes, ALL_NAMES, "abcd", strict=True):
        signs = (1,) if what == "x" else (1, -1)
        draw_envelope(
            ax, T_END, PRINTED_FACTOR, text, signs=signs, color=COLOURS["paper"], ls="--", lw=1.2
        )
        label(ax, heading(name), letter)
    axes[-1].legend(loc="upper left", handlelength=2.6)
    return figure


@styled
def _draw_velocity(data: Dataset) -> Picture:
    return _draw(data, "v")


@styled
def _draw_displacement(data: Dataset) -> Picture:
    return _draw(data, "x")


def _caption_portraits(data: Dataset) -> str:
    t, x = data.t_limit.values, data.x_limit.values
    corners = [
        f"x to {float(data[f'x_{name}'].max()):.2f}, |v| to "
        f"{float(np.abs(data[f'v_{name}'].values).max()):.2f}"
        for name in ALL_NAMES
    ]
    return (
        f"Phase portraits of the same motions to t = {T_END}: (a) the limit, {corners[0]}; (b) "
        f"2e4 as ratio of frequencies, {corners[1]}; (c) as ratio of their squares, {corners[2]}; (d) "
        f"(b) by Runge-Kutta, {corners[3]}. "
        "The printed portrait ends near x = 5 and |v| = 6, which the limit first passes at t = "
        f"{float(t[np.argmax(x > 5.0)]):.1f} (x = 5)."
    )


@styled
def _draw_portraits(data: Dataset) -> Picture:
    ratios = [MODEL_LABELS[name].split(", ")[1] for name in ("stiff", "soft")]
    return portraits(data, ALL_NAMES, ["limit", *ratios, "by Runge-Kutta"])


def power() -> Dataset:
    """Return the power spectra of the three motions."""
    import xarray as xr

    return with_power(xr.Dataset(attrs=dict(motions().attrs)), runs(), HIGHEST)


def _share_even(data: Dataset, name: str) -> float:
    """Return the share of the power, the mean apart, within 0.1 of an even frequency."""
    omega, s = data[f"omega_{name}"].values, data[f"S_{name}"].values
    moving = omega > 0.2
    near = np.abs(omega - 2.0 * np.round(omega / 2.0)) < 0.1
    return float(s[moving & near].sum() / s[moving].sum())


def _caption_power(data: Dataset) -> str:
    shares = [_share_even(data, name) for name in NAMES]
    return (
        f"Power spectra of the same motions to t = {T_END}, as in figure 8; dashed, the resonant "
        "frequency 2. Share of the power, the mean apart, within 0.1 of an even frequency: (a) "
        f"{shares[0]:.4f}, (b) {shares[1]:.4f}, (c) {shares[2]:.4f}."
    )


@styled
def _draw_power(data: Dataset) -> Picture:
    return spectra(data, NAMES, [heading(name) for name in NAMES], lowest=1e-8)


FIGURES = (
    Figure("fig10", "Half-harmonic, velocity", _caption_velocity, motions, _draw_velocity),
    Figure(
        "fig11", "Half-harmonic, displacement", _caption_displacement, motions, _draw_displacement
    ),
    Figure("fig12", "Half-harmonic, phase portrait", _caption_portraits, motions, _draw_portraits),
    Figure("fig13", "Half-harmonic, power spectrum", _caption_power, power, _draw_power),
)
