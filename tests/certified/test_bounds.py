from __future__ import annotations

import math

import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified.ball_law import law_of
from percuss.certified.flight import EnclosedFlight, Push
from percuss.certified.system import system_of
from percuss.model.exact import Exact

FORCE = pc.Forcing((pc.Harmonic("1.3", "1.7", "0.4"), pc.Harmonic("0.6", "2.9", 1)), "-0.2")
REGIMES: dict[str, tuple[Exact, Exact]] = {
    "oscillating": (1, 0),
    "damped": ("2.3", "0.3"),
    "critical": (1, 1),
    "overdamped": (1, "1.7"),
    "stiffly overdamped": (1, 30),
    "free": (0, 0),
    "drag": (0, "0.4"),
    "unstable": (-2, "0.1"),
    "resonant": ("2.89", 0),
    "near resonance": ("2.890000001", 0),
    "near resonance, damped": ("2.89", "1e-8"),
}


@pytest.mark.parametrize("name", REGIMES)
@pytest.mark.parametrize("n", [3, 5])
def test_derivatives_stay_below_their_bound_and_are_those_of_one_another(name: str, n: int) -> None:
    system = system_of(pc.Oscillator(*REGIMES[name]), FORCE)
    with ctx.workprec(256):
        law = law_of(system)
        flight = EnclosedFlight(law, 0, law.phasors(arb("0.3")), arb("0.2"), arb("-0.7"))
        for s, h in ((0.0, 0.5), (0.7, 0.1), (4.0, 1.0)):
            values, size = flight.derivatives(arb(s), n - 1)
            bound = flight.bound(n, s, h, size)
            largest = 0.0
            for k in range(41):
                found, _ = flight.derivatives(arb(s) + arb(h) * k / 40, n)
                largest = max(largest, float(abs(found[n]).upper()))
            assert largest <= bound
            # The bound is of some use: a few times the sum of the amplitudes at most.
            assert bound < 400 * (largest + sum(a * w**n for a, w in flight.strengths))
            # Taylor's sum from s with all derivatives but the last is off by the bound at most.
            total = sum((c * arb(h) ** k / math.factorial(k) for k, c in enumerate(values)), arb(0))
            there = flight.derivatives(arb(s + h), 1)[0][0]
            assert abs(there - total) <= bound * h**n / math.factorial(n) * 1.001
    assert "near" not in name or flight.region.cancels


@pytest.mark.parametrize("name", REGIMES)
def test_the_series_at_the_start_is_the_closed_form(name: str) -> None:
    system = system_of(pc.Oscillator(*REGIMES[name]), FORCE)
    with ctx.workprec(256):
        law = law_of(system)
        flight = EnclosedFlight(law, 0, law.phasors(arb("0.3")), arb("0.2"), arb("-0.7"))
        coefficients = flight.taylor(7)
        values, _ = flight.derivatives(arb(0), 7)
        for k, (c, value) in enumerate(zip(coefficients, values, strict=True)):
            assert (c * math.factorial(k)).overlaps(value)
        bound = flight.bound(8, 0.0, 0.1, flight.size_at_start(7))
        there, _ = flight.derivatives(arb("0.1"), 8)
        assert abs(there[8]) <= bound


def test_the_force_of_a_contact_and_its_bound() -> None:
    system = system_of(pc.impact_oscillator(wall="0.5"), FORCE)
    with ctx.workprec(128):
        law = law_of(system)
        push = Push(law, 0, law.phasors(arb("0.3")), arb("0.5"), 0)
        for k in range(20):
            values, size = push.derivatives(arb(k) / 3, 4)
            assert abs(values[4]) <= push.bound(4, 0.0, 10.0, size)
        f = arb("1.3") * (arb("1.7") * (arb("0.3") + 2) + arb("0.4")).cos()
        f += arb("0.6") * (arb("2.9") * (arb("0.3") + 2) + 1).cos() - arb("0.2") - arb("0.5")
        assert push.derivatives(arb(2), 0)[0][0].overlaps(f)
