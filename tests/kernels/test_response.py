from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from mpmath import mp
from tests.kernels.exact_flight import DIGITS, Rest

from percuss.kernels.angles import cos_sin
from percuss.kernels.law import FIRST_HARMONIC, TURNS, TURNS_LOW
from percuss.kernels.response import free_response, harmonic_response

ULP = 2.0**-52

# The errors come from some ten roundings in each of a few terms; the engine allows 16 ulp of the
# sum of the terms' sizes (flight.ROUNDING), which is what the scales below are.
ALLOWED = 16 * ULP

REGIMES = {
    "undamped": Rest(1.0, 0.0, 3.0),
    "undamped, stiff": Rest(1e14, 0.0, 2.0),
    "undamped, soft": Rest(1e-12, 0.0, 2.0),
    "underdamped": Rest(1.0, 0.05, 2.7),
    "underdamped, strongly": Rest(1.0, 0.9, 0.4),
    "nearly critical from below": Rest(1.0, 1.0 - 2.0**-50, 0.7),
    "critical": Rest(1.0, 1.0, 1.0),
    "nearly critical from above": Rest(1.0, 1.0 + 2.0**-50, 1.3),
    "overdamped": Rest(1.0, 5.0, 0.1),
    "overdamped, nearly without spring": Rest(1e-9, 5.0, 1e-3),
    "huge dashpot": Rest(1.0, 1e6, 3.0),
    "free flight": Rest(0.0, 0.0, 3.0),
    "dashpot alone": Rest(0.0, 0.7, 3.0),
    "dashpot alone, slow force": Rest(0.0, 0.7, 1e-6),
    "unstable": Rest(-1.0, 0.0, 2.0),
    "unstable, damped": Rest(-0.3, 0.4, 2.0),
    "exact resonance": Rest(4.0, 0.0, 2.0),
    "resonance, lightly damped": Rest(4.0, 1e-9, 2.0),
    "fast force": Rest(1.0, 0.1, 1e5),
}
DETUNINGS = [10.0**-e for e in range(17)]
# Tiny ones see the power series, those next to its limit the change of form.
TIMES = [1e-9, 1e-3, 0.2, 0.4999, 0.5001, 1.0, 3.1, 20.0, 1e3, 1e6]


@pytest.mark.parametrize("rest", REGIMES.values(), ids=REGIMES.keys())
def test_free_responses_are_exact_to_rounding_in_every_regime(rest: Rest) -> None:
    for s in times_of(rest):
        with mpmath.workdps(DIGITS):
            S, c, D = rest.free(s)
            allowed = free_allowed(rest, s, c)

        computed = free_response(rest.table, rest.region, s)

        with mpmath.workdps(DIGITS):
            for name, value, exact, most in zip("ScD", computed, (S, c, D), allowed, strict=True):
                assert abs(value - exact) <= most, (name, s, float(abs(value - exact) / most))


@pytest.mark.parametrize("rest", REGIMES.values(), ids=REGIMES.keys())
def test_responses_to_a_harmonic_are_exact_to_rounding_in_every_regime(rest: Rest) -> None:
    for s in times_of(rest):
        assert harmonic_error(rest, s) <= 1.0, s


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("damping", [0.0, 1e-12, 0.01])
def test_no_detuning_from_resonance_loses_digits(damping: float, sign: int) -> None:
    for detuning in DETUNINGS:
        rest = Rest(4.0, damping, 2 * (1 + sign * Fraction(detuning) / 2))
        for s in TIMES:
            assert harmonic_error(rest, s) <= 1.0, (detuning, s)


def test_a_decay_that_underflows_leaves_the_responses_to_lasting_forces() -> None:
    rest = Rest(2.0, 1.0, 3.0)

    blow, even, rise = free_response(rest.table, rest.region, 1e5)

    assert (blow, even, rise) == (0.0, 0.0, 0.5)


def times_of(rest: Rest) -> list[float]:
    """Return times over all the forms; where the motion grows only until it overflows."""
    scale = 1.0 / max(abs(float(rest.stiffness)) ** 0.5, 2.0 * float(rest.damping), 1e-3)
    times = [*TIMES, *(t * scale for t in TIMES)]
    return [t for t in times if rest.stiffness >= 0.0 or t <= 20.0]


def free_allowed(rest: Rest, s: float, c: mpmath.mpf) -> tuple[mpmath.mpf, ...]:
    """Return the errors allowed of S, c and D: of the sizes these have around s."""
    envelope = decay(rest, s)
    swing = min(s, 1.0 / (frequency(rest) or 1e-300))
    # A rounding of the rate of growth, or decay, counts once for each time constant.
    growth = 1.0 + exponent(rest) * s
    blow = envelope * swing * growth
    even = max(envelope, abs(c)) * growth
    rise = min(s * s / 2, abs(1 + even + float(rest.damping) * blow) / abs_or_tiny(rest.stiffness))
    if rest.stiffness <= 0.0 or overdamped(rest):
        rise = max(rise * 0, abs(rest.free(s)[2])) * growth
    return ALLOWED * blow, ALLOWED * even, ALLOWED * rise


def harmonic_error(rest: Rest, s: float) -> float:
    """Return the error of Q at s in parts of what is allowed."""
    table, region = rest.table, rest.region
    harmonic = table[FIRST_HARMONIC]
    turn = cos_sin(harmonic[TURNS], harmonic[TURNS_LOW], s, 0.0)
    blow, even, _ = free_response(table, region, s)
    computed = complex(*harmonic_response(table, region, 0, s, blow, even, turn))
    with mpmath.workdps(DIGITS):
        exact = rest.harmonic(s)
        w, a = float(rest.omega), float(rest.damping)
        S, c, _ = rest.free(s)
        envelope = decay(rest, s) * min(s, 1.0 / (frequency(rest) or 1e-300))
        terms = 1 + max(abs(c), decay(rest, s)) + (a + w) * max(abs(S), envelope)
        gain = 1 / abs(mpmath.mpc(float(rest.stiffness) - w * w, 2 * a * w) + mpmath.mpf(1e-300))
        near = s * decay(rest, s) / w + terms / w**2
        scale = min(mpmath.mpf(s) ** 2 / 2, terms * gain, near if s * w > 0.5 else mp.inf)
        scale = max(scale * (1 + exponent(rest) * s * (rest.stiffness < 0)), abs(exact))
        return float(abs(mpmath.mpc(computed) - exact) / (ALLOWED * scale))


def overdamped(rest: Rest) -> bool:
    return float(rest.damping) ** 2 > rest.stiffness


def frequency(rest: Rest) -> float:
    """Return sqrt(abs(K - a^2))."""
    return float(abs(Fraction(rest.stiffness) - Fraction(rest.damping) ** 2)) ** 0.5


def exponent(rest: Rest) -> float:
    """Return the rate of the slowest decay, or of the growth."""
    a = float(rest.damping)
    if not overdamped(rest):
        return a
    return abs(float(rest.stiffness)) / (a + frequency(rest))


def decay(rest: Rest, s: float) -> mpmath.mpf:
    grows = -1 if rest.stiffness < 0 else 1
    return mpmath.exp(-grows * mpmath.mpf(exponent(rest)) * s)


def abs_or_tiny(value: float | Fraction) -> float:
    return abs(float(value)) or 1e-300


def test_every_regime_has_its_own_form() -> None:
    """The table above covers what the formulas distinguish, else a form could go untested."""
    kinds = {
        (overdamped(rest), np.sign(float(rest.stiffness)), frequency(rest) == 0.0)
        for rest in REGIMES.values()
    }
    assert len(kinds) >= 6
