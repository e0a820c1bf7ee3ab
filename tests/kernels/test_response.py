from __future__ import annotations

from fractions import Fraction

import mpmath
import pytest
from tests.kernels.exact_flight import DIGITS, Rest
from tests.kernels.uncompiled import python_of

from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.flight import free_response, harmonic_response
from percuss.kernels.law_columns import FIRST_HARMONIC, TURNS, TURNS_LOW

ULP = 2.0**-52

# Some ten roundings in each of a few terms. Most where D and Q leave the power series: there the
# closed form cancels to an eighth of its terms, 21 ulp were seen.
ALLOWED = 24 * ULP

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
    """S and c relative to the swing that the motion has then, D to its size around then."""
    for s in times_of(rest):
        computed = free_response(rest.law, rest.region, s)

        with mpmath.workdps(DIGITS):
            exact = rest.free(s)
            rate = rest.rate
            swing = abs(exact[1]) + rate * abs(exact[0])
            # One rounding of a rate of decay or growth counts once in each of its times.
            swing *= 1 + rest.slowest * s
            rise = max(abs(rest.free(part * s)[2]) for part in (1.0, 0.9, 0.8))
            rise *= 1 + rest.slowest * s * (rest.stiffness < 0)
            scales = (swing * min(s, 1 / (rate or mpmath.mpf(1e-99))), swing, rise)
            errors = [abs(x - y) / z for x, y, z in zip(computed, exact, scales, strict=True)]
        assert max(errors) <= ALLOWED, (s, [float(error / ULP) for error in errors])


@pytest.mark.parametrize("rest", REGIMES.values(), ids=REGIMES.keys())
def test_responses_to_a_harmonic_are_exact_to_rounding_in_every_regime(rest: Rest) -> None:
    for s in times_of(rest):
        assert harmonic_error(rest, s) <= ALLOWED, s


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("damping", [0.0, 1e-12, 0.01])
def test_no_detuning_from_resonance_loses_digits(damping: float, sign: int) -> None:
    for detuning in DETUNINGS:
        rest = Rest(4.0, damping, 2 * (1 + sign * Fraction(detuning) / 2))
        for s in TIMES:
            assert harmonic_error(rest, s) <= ALLOWED, (detuning, s)


def test_a_decay_that_underflows_leaves_the_responses_to_lasting_forces() -> None:
    rest = Rest(2.0, 1.0, 3.0)

    impulse, even, rise = free_response(rest.law, rest.region, 1e5)

    assert (impulse, even, rise) == (0.0, 0.0, 0.5)


def test_plain_python_gives_the_machine_code_to_a_few_ulp() -> None:
    """Not the bits: the C library and the compiler may round powers differently."""
    for rest in REGIMES.values():
        for s in times_of(rest):
            plain = python_of(free_response)(rest.law, rest.region, s)
            assert plain == pytest.approx(free_response(rest.law, rest.region, s), rel=1e-15)


def times_of(rest: Rest) -> list[float]:
    """Return times over all the forms; where the motion grows only until it overflows."""
    scale = 1.0 / max(abs(float(rest.stiffness)) ** 0.5, 2.0 * float(rest.damping), 1e-3)
    times = [*TIMES, *(t * scale for t in TIMES)]
    # Beyond, S and c are below the smallest double.
    longest = min(20.0 if rest.stiffness < 0.0 else 1e6, 600.0 / (float(rest.slowest) or 1e-9))
    return [t for t in times if t <= longest]


def harmonic_error(rest: Rest, s: float) -> float:
    """Return the error of Q at s relative to its largest size around then."""
    law, region = rest.law, rest.region
    harmonic = law[FIRST_HARMONIC]
    turn = cos_sin(harmonic[TURNS], harmonic[TURNS_LOW], s, 0.0)
    impulse, even, _ = free_response(law, region, s)
    computed = complex(*harmonic_response(law, region, 0, s, impulse, even, turn))
    with mpmath.workdps(DIGITS):
        scale = max(abs(rest.harmonic(part * s)) for part in (1.0, 0.9, 0.8))
        return float(abs(mpmath.mpc(computed) - rest.harmonic(s)) / scale)
