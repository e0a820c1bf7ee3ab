"""Which frequencies resonate: verdicts, strengths in closed form, and the twist."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest
from tests.paper.findings import finding
from tests.paper.normal_form import NormalForm

import percuss as pc
from percuss.paper.claims.resonances import OF_ORDER, STATEMENTS
from percuss.paper.figures.resonance_figures import FIGURES, growth, portraits
from percuss.paper.models.averaging import averaged, fast_flight, kick, mean_delays, order, strength
from percuss.paper.models.flight_series import energy_gain
from percuss.paper.models.resonance_runs import ensemble, growing_phase, growing_run
from percuss.paper.statement import grade, judge

VERDICTS = {
    "resonance-even": "holds",
    "resonance-half": "holds",
    "resonance-odd": "holds",
    "resonance-order": "holds",
    "resonance-strength": "holds",
    "resonance-phase": "holds",
    "resonance-twist": "holds",
    "resonance-subharmonics": "holds with the correction only for m <= 6; from m = 7 on, fast "
    "motions stay near their speed",
    "subharmonic-only": "undecided because the article does not say whether it speaks of all "
    "resonances off the eigenset, which is wrong, or announces those of its section 5, which are "
    "sub-harmonic",
    "resonance-others": "holds",
}


BY_ID = {statement.id: statement for statement in STATEMENTS}


@pytest.mark.parametrize("id", BY_ID)
def test_the_verdict_of_each_statement(id: str) -> None:
    assert judge(finding(id)) == VERDICTS[id]


DEDUCED = ("resonance-odd", "resonance-order")


def test_what_is_deduced() -> None:
    for id in BY_ID:
        assert grade(finding(id)) == ("deduced" if id in DEDUCED else "measured"), id


@pytest.mark.parametrize("text", ["2", "1", "4/3", "1/2", "4/5"])
def test_the_series_of_flights_is_what_fast_flights_gain(text: str) -> None:
    """Flights at V = 1e12 in ninety digits, which share nothing with the series."""
    omega = Fraction(text)
    p, q = order(omega)
    gains = energy_gain(omega)
    assert (gains.power, gains.waves) == (q - 2, (-q, q))
    if omega == 1:
        assert gains.size == pytest.approx(math.pi / 2, rel=1e-15)
        return
    with mp.workdps(90):
        measured = exact_strength(mp.mpf(omega.numerator) / omega.denominator, p, q)
    assert gains.size == pytest.approx(2.0 * math.pi * p * q * abs(float(measured)), rel=1e-12)


def test_an_odd_harmonic_gains_nothing_at_any_order_followed() -> None:
    assert energy_gain(Fraction(3), 4).waves == ()


def exact_strength(omega: mp.mpf, p: int, q: int) -> mp.mpf:
    """Return the strength from q flights at V = 1e12, with an error of order V^-2."""
    speed = mp.mpf(10) ** 12
    n = 8 * q
    total = mp.mpf(0)
    for k in range(n):
        start = phase = 2 * mp.pi * k / n
        v = speed
        for _ in range(q):
            phase, v = exact_flight(phase, v, omega)
        total += (v - speed) * (v + speed) / 2 * mp.sin(q * start)
    power = total * 2 / n / (q * mp.pi) * speed ** (q - 2)
    return (-1) ** p * power / (q * omega)


def exact_flight(phase: mp.mpf, speed: mp.mpf, omega: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    gain = 1 / (1 - omega**2)
    x0, v0 = gain * mp.cos(phase), speed + gain * omega * mp.sin(phase)
    s = +mp.pi
    for _ in range(10):
        end = phase + omega * s
        x = v0 * mp.sin(s) - x0 * mp.cos(s) + gain * mp.cos(end)
        v = v0 * mp.cos(s) + x0 * mp.sin(s) - gain * omega * mp.sin(end)
        s -= x / v
    return phase + omega * s, -v


@pytest.mark.parametrize(
    "text", ["2", "6", "2/3", "4/3", "8/3", "10/3", "14/3", "1/2", "3/2", "5/2", "7/2"]
)
def test_closed_forms_of_the_strength_hold_to_twenty_digits(text: str) -> None:
    omega = Fraction(text)
    p, q = order(omega)
    with mp.workdps(90):
        w = mp.mpf(omega.numerator) / omega.denominator
        k = 2 * mp.cos(mp.pi * w / 2) / (1 - w**2)
        form = {
            1: k / mp.pi,
            3: k**3 * (1 - w**2) / (12 * mp.pi),
            4: k**4 * w * (1 - w**2) * mp.tan(mp.pi * w / 2) / (24 * mp.pi),
        }[q]
        ratio = exact_strength(w, p, q) / form
        assert abs(ratio - 1) < mp.mpf(10) ** -20
    assert strength(omega) == pytest.approx(float(form), rel=1e-14)


@pytest.mark.parametrize("text", ["0.3", "0.618", "0.75", "1.41421356", "1.7", "1.9", "2.3", "3.3"])
def test_no_twist_up_to_the_fourth_order(text: str) -> None:
    with mp.workdps(50):
        delays = NormalForm(mp.mpf(text), 4).delays()
        assert max(abs(delay) for delay in delays) < mp.mpf(10) ** -40


def test_the_twist_of_sixth_order_is_that_of_the_normal_form() -> None:
    with mp.workdps(30):
        sixth = float(mp.re(NormalForm(mp.mpf("0.618"), 6).delays()[5]))
    slow, fast = mean_delays(0.618, np.array([40.0, 80.0])) * np.array([40.0, 80.0]) ** 6
    assert sixth == pytest.approx(0.5590046561, rel=1e-9)
    assert 2.0 * fast - slow == pytest.approx(sixth, rel=1e-2)


def test_kicks_of_odd_harmonics_vanish_and_the_half_harmonic_has_no_pole() -> None:
    assert [abs(kick(n)) < 1e-15 for n in (3.0, 5.0, 7.0)] == [True] * 3
    assert kick(1.0) == math.pi / 2
    assert kick(1.0 + 1e-9) == pytest.approx(math.pi / 2, rel=1e-8)


@pytest.mark.parametrize("omega", [1.0, 2.0 / 3.0, 3.0])
def test_fast_flights_are_those_of_the_march(omega: float) -> None:
    phase, v, longer = fast_flight(np.array([1.1]), np.array([4.0]), omega)
    run = pc.simulate(pc.impact_oscillator(), pc.cosine(omega, phase=1.1), v0=4.0, max_impacts=1)
    assert v[0] == pytest.approx(run.impacts.v_after[0], abs=1e-13)
    assert math.pi + longer[0] == pytest.approx(run.impacts.t[0], abs=1e-13)
    assert phase[0] == pytest.approx(1.1 + omega * run.impacts.t[0], abs=1e-13)


def test_speed_grows_in_the_growing_phase_at_the_derived_rate() -> None:
    for q, (omega, _, _) in OF_ORDER.items():
        rates = []
        for speed in (30.0, 60.0):
            impacts = 2000 * q
            speeds, _ = growing_run(omega, speed, 0.0, impacts)
            rates.append((speeds[-1] ** q - speeds[0] ** q) / (math.pi * impacts))
        # What averaging leaves out is of relative order 1 / V.
        assert 2.0 * rates[1] - rates[0] == pytest.approx(averaged(omega).rate, rel=0.05), q


def test_the_growing_phase_of_an_even_harmonic_attracts_from_anywhere() -> None:
    phase = growing_phase(Fraction(2))
    run = pc.simulate(
        pc.impact_oscillator(), pc.cosine(2, phase=phase + 2.9), v0=30.0, max_impacts=5000
    )
    assert run.impacts.v_after.min() < 30.0
    assert run.impacts.v_after[-1] > 2000.0


def test_slow_starts_inside_closed_curves_do_not_grow_though_fast_ones_do() -> None:
    omega = Fraction(6, 5)
    assert averaged(omega).balance == pytest.approx(4.0, abs=0.1)
    slow, fast = (ensemble(omega, 16, 40_000, low, low + 1.0) for low in (0.5, 4.0))
    late = int(np.searchsorted(slow.counts, 2_000))
    assert (slow.largest[:, -1] / slow.largest[:, late]).max() < 1.1
    assert (fast.largest[:, -1] / fast.largest[:, late]).max() > 1.3


def test_the_figures_show_the_exponents() -> None:
    data = growth()
    # At 0 stands the ratio that no order has: there the speed does not grow.
    for q, expected in ((1, 1.0), (2, 1 / 2), (3, 1 / 3), (4, 1 / 4), (5, 1 / 5), (0, 0.0)):
        one = data.sel(q=q)
        assert abs(one.exponent - expected) <= max(3.0 * float(one.exponent_error), 0.01)
    lines = portraits()
    x = lines["x_2_1"].values
    assert np.ptp(x) < 0.05 * np.ptp(lines["y_2_1"].values)
    assert [figure.name for figure in FIGURES] == [
        "resonance-scan",
        "resonance-growth",
        "resonance-portraits",
    ]
