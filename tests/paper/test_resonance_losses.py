"""Resonances with losses: closed forms, heights and widths of peaks, and what is a saddle."""

from __future__ import annotations

import importlib
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from tests.paper.findings import finding

import percuss as pc
from percuss.errors import ParameterError
from percuss.paper.claims.resonance_losses import STATEMENTS
from percuss.paper.figures.loss_figures import FIGURES, peaks
from percuss.paper.models.resonance_losses import (
    cycle_work,
    gain,
    lossy,
    lost_share,
    peak_and_width,
    peak_orbit,
    response,
    saddle_speed,
    single_impact_speed,
    stiff_resonance,
)
from percuss.paper.statement import grade, judge

BY_ID = {statement.id: statement for statement in STATEMENTS}


@pytest.mark.parametrize("name", sorted(BY_ID))
def test_every_statement_holds(name: str) -> None:
    assert judge(finding(name)) == "holds"


def test_the_resonance_curve_is_certified() -> None:
    assert grade(finding("losses-curve")) == "certified"
    assert len(finding("losses-curve").printed) == 54


def test_the_curve_without_damping_is_the_short_form() -> None:
    for turns, r in ((1, 0.8), (2, 0.95), (3, 0.3)):
        omega = 2.0 * turns + np.linspace(-0.6, 0.6, 13)
        delta = 2.0 * math.pi * turns / omega - math.pi
        short = 2.0 / np.abs(1.0 - omega**2)
        short /= np.hypot((1.0 + r) * np.tan(0.5 * delta), (1.0 - r) / omega)
        np.testing.assert_allclose(
            single_impact_speed(omega, turns, r, 0.0), short, rtol=1e-11, atol=0.0
        )


def test_the_curve_without_any_loss_is_that_of_the_elastic_oscillator() -> None:
    omega = 2.3
    expected = abs(math.tan(math.pi / omega) / (1.0 - omega**2))
    assert float(single_impact_speed(omega, 1, 1.0, 0.0)) == pytest.approx(expected, rel=1e-12)


def test_the_two_equations_of_the_curve_follow_from_one_flight() -> None:
    sp: Any = importlib.import_module("sympy")
    t, x, y, v, r = sp.symbols("t X Y V r", real=True)
    a = sp.Rational(1, 5)
    natural = sp.sqrt(1 - a**2)
    # Without the response to the force, which returns after the flight, the mass moves freely.
    h0, slope0 = -x, r * v - y
    free = sp.exp(-a * t) * (
        h0 * sp.cos(natural * t) + (slope0 + a * h0) / natural * sp.sin(natural * t)
    )
    c, s, decay = sp.cos(natural * t), sp.sin(natural * t) / natural, sp.exp(-a * t)
    place = -(1 - decay * (c + a * s)) * x + decay * s * y - r * decay * s * v
    speed = decay * s * x + (1 - decay * (c - a * s)) * y + (1 + r * decay * (c - a * s)) * v

    assert sp.simplify(sp.diff(free, t, 2) + 2 * a * sp.diff(free, t) + free) == 0
    assert sp.simplify(free + x + place) == 0
    assert sp.simplify(sp.diff(free, t) + y + v - speed) == 0


@pytest.mark.parametrize(("r", "a"), [(0.8, 0.0), (0.9, 0.03)])
def test_attractors_of_a_sweep_lie_on_the_curve(r: float, a: float) -> None:
    omegas = np.array([1.9, 2.0, 2.1, 3.95, 4.0, 4.05])
    speeds, widest = response(lossy(r, a), omegas, (1.0, 4.0), 300)
    curve = [float(single_impact_speed(w, round(w / 2.0), r, a)) for w in omegas]

    np.testing.assert_allclose(speeds, curve, rtol=1e-9)
    assert (widest > 0.3).all()


def test_the_peak_is_exact_at_the_resonant_frequency() -> None:
    for n in (2, 4, 6):
        at = float(single_impact_speed(float(n), n // 2, 0.9, 0.0))
        assert at == pytest.approx(gain(n) / lost_share(0.9, 0.0), rel=1e-12)


@pytest.mark.parametrize(("below", "m"), [(4.0, 1), (4.0, 3), (25.0, 3), (9.0, 2), (25 / 9, 4)])
def test_work_on_a_cycle_is_the_integral_of_force_times_velocity(below: float, m: int) -> None:
    root = math.sqrt(below)
    w = m * stiff_resonance(below)
    above = np.linspace(0.0, math.pi, 20_001)
    inside = np.linspace(0.0, math.pi / root, 20_001)
    work = np.trapezoid(np.cos(above) * np.exp(1j * w * above), above)
    work -= np.trapezoid(np.cos(root * inside) * np.exp(1j * w * (inside + math.pi)), inside)

    assert cycle_work(below, m) == pytest.approx(abs(work), abs=1e-7)


def test_balanced_orbits_of_higher_order_are_saddles_at_any_loss_tried() -> None:
    for text in ("2/3", "3/2"):
        for lost in (0.05, 1e-3, 1e-5):
            orbit = peak_orbit(Fraction(text), 1.0 - lost)
            assert orbit.stability == "unstable"
            assert orbit.admissible
            assert np.abs(orbit.impacts.v_before).max() > saddle_speed(Fraction(text), lost)


def test_a_frequency_without_such_an_orbit_says_so() -> None:
    with pytest.raises(ParameterError, match="no orbit near the speed"):
        peak_orbit(Fraction(6, 5), 0.999)


def test_the_half_harmonic_is_a_stable_peak_that_a_run_reaches() -> None:
    orbit = peak_orbit(Fraction(1), 0.9)
    run = pc.simulate(lossy(0.9, 0.0), pc.cosine(1), v0=2.5, t0=0.9 * math.pi, t_end=1200 * math.pi)

    assert orbit.stability == "asymptotic"
    late = np.abs(run.impacts.v_before[-2:])
    assert late.max() == pytest.approx(np.abs(orbit.impacts.v_before).max(), rel=1e-6)


def test_a_peak_cut_off_has_no_width() -> None:
    omegas = np.linspace(0.0, 1.0, 11)
    assert math.isnan(peak_and_width(omegas, 1.0 - omegas)[1])


def test_the_figure_shows_the_derived_powers() -> None:
    data = peaks()
    for n in (2, 4, 6):
        heights = data.height.sel(n=n).values
        np.testing.assert_allclose(heights * data.lost.values, gain(n), rtol=0.02)
    power = np.polyfit(np.log(data.half_lost), np.log(data.half_width), 1)[0]
    assert power == pytest.approx(2.0, abs=0.05)
    assert [figure.name for figure in FIGURES] == [
        "losses-curves",
        "losses-bilinear",
        "losses-peaks",
    ]
