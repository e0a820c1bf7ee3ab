from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.errors import ParameterError
from percuss.model import (
    Component,
    ForceRecord,
    Forcing,
    FourierTerm,
    Harmonic,
    Phase,
    as_float,
    as_fraction,
    cosine,
    fourier,
    pi_times,
    sine,
)

COEFFICIENTS = st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=5)


def force_at(force: Forcing, t: np.ndarray) -> np.ndarray:
    """The force from its components."""
    return as_float(force.constant) + sum(
        (
            part.cos * np.cos(float(part.omega) * t) + part.sin * np.sin(float(part.omega) * t)
            for part in force.components()
        ),
        np.zeros_like(t),
    )


@pytest.mark.parametrize(
    ("phase", "cos", "sin"),
    [
        (0, 0.0, 1.5),
        (0.0, 0.0, 1.5),
        (-0.0, 0.0, 1.5),
        ("0.0e0", 0.0, 1.5),
        (pi_times(1, 2), 1.5, 0.0),
        (pi_times(1), 0.0, -1.5),
        ("-pi/2", -1.5, 0.0),
        (pi_times(-7), 0.0, -1.5),
    ],
)
def test_a_sine_has_exact_coefficients_at_multiples_of_a_quarter_turn(
    phase: Phase, cos: float, sin: float
) -> None:
    assert sine(3, amplitude=1.5, phase=phase).components() == (Component(Fraction(3), cos, sin),)


def test_the_force_of_a_sine_at_rest_has_no_negative_zero() -> None:
    (component,) = sine(3.0, amplitude=-1.0).components()

    assert math.copysign(1.0, component.cos) == 1.0


@given(
    omega=st.floats(0.1, 10.0),
    amplitude=st.floats(-5.0, 5.0),
    phase=st.floats(-10.0, 10.0),
    constant=st.floats(-5.0, 5.0),
)
def test_sine_and_cosine_are_what_their_names_say(
    omega: float, amplitude: float, phase: float, constant: float
) -> None:
    t = np.linspace(-3.0, 3.0, 7)

    for make, function in ((sine, np.sin), (cosine, np.cos)):
        expected = constant + amplitude * function(omega * t + phase)
        # omega t + phase reaches 40: its rounding is 4e-15, times the amplitude.
        np.testing.assert_allclose(
            force_at(make(omega, amplitude, phase, constant), t), expected, rtol=0, atol=1e-13
        )


@given(omega=st.floats(0.1, 10.0), cos=COEFFICIENTS, sin=COEFFICIENTS)
def test_a_fourier_sum_has_the_coefficients_of_every_multiple_of_its_base(
    omega: float, cos: list[float], sin: list[float]
) -> None:
    t = np.linspace(-1.0, 1.0, 5)
    expected = 0.5 + sum(
        (c * np.cos(n * omega * t) for n, c in enumerate(cos, 1)), np.zeros_like(t)
    )
    expected = expected + sum((s * np.sin(n * omega * t) for n, s in enumerate(sin, 1)), 0.0 * t)

    force = fourier(omega, cos=cos, sin=sin, constant=0.5)

    # Phases reach 50, ten coefficients reach 10.
    np.testing.assert_allclose(force_at(force, t), expected, rtol=0, atol=1e-12)


def test_frequencies_of_a_fourier_sum_are_exact_multiples_and_zero_terms_are_left_out() -> None:
    force = fourier("0.1", cos=(1.0, 0.0, 0.5), sin=(0.0, 0))

    assert [part.omega for part in force.components()] == [Fraction(1, 10), Fraction(3, 10)]
    assert force.frequency == Fraction(1, 10)


@pytest.mark.parametrize(
    ("force", "period", "frequency"),
    [
        (sine(3.0), 2.0943951023931957, Fraction(3)),  # 2 * math.pi / 3 is an ulp less
        (sine("2.8", amplitude=0), 2 * math.pi / 2.8, Fraction(14, 5)),
        (fourier(2.0, cos=(0.0, 1.0)), math.pi, Fraction(2)),
        (Forcing(), None, None),
        (Forcing(constant=1.0), None, None),
        (Forcing((Harmonic(1.0, 2.0), Harmonic(1.0, 4.0))), None, None),
        (
            Forcing((Harmonic(1.0, 2.0), Harmonic(1.0, 3.0)), period=pi_times(2)),
            2 * math.pi,
            Fraction(1),
        ),
        # A given float is a period of both, so the exact one is known.
        (
            Forcing((Harmonic(1.0, 2.0), Harmonic(1.0, 3.0)), period=2 * math.pi),
            2 * math.pi,
            Fraction(1),
        ),
        # Twice the shortest period is a period too.
        (Forcing((Harmonic(1.0, 2),), period="2*pi"), 2 * math.pi, Fraction(1)),
    ],
)
def test_the_period_follows_from_the_harmonics_or_is_given(
    force: Forcing, period: float | None, frequency: Fraction | None
) -> None:
    assert force.period == period
    assert force.frequency == frequency


def test_harmonics_that_fit_a_period_only_to_rounding_have_no_exact_frequency() -> None:
    """The doubles 0.1 and 0.3 are not in the ratio 1 : 3."""
    force = Forcing((Harmonic(1.0, 0.1), Harmonic(1.0, 0.3)), period=20 * math.pi)

    assert force.period == 20 * math.pi
    assert force.frequency is None


@pytest.mark.parametrize(
    ("period", "message"),
    [
        (6.28, "period = 6.28: harmonic 0 of omega = 2 makes 1.99898"),
        (math.pi, "period = 3.141592653589793: harmonic 1 of omega = 3 makes 1.5"),
        (0.0, "period = 0.0: not positive"),
        (-1, "period = -1: not positive"),
        (math.inf, "period = inf: not finite"),
        ("pi/0", "period = 'pi/0': a division by zero"),
        (1e-12, "turns in it, not a whole number"),
    ],
)
def test_a_period_that_does_not_fit_is_refused_with_its_numbers(
    period: Phase, message: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        Forcing((Harmonic(1.0, 2.0), Harmonic(1.0, 3.0)), period=period)

    assert message in str(caught.value)


def test_a_constant_force_takes_no_period() -> None:
    with pytest.raises(ParameterError, match="nothing to repeat"):
        Forcing(constant=1.0, period=2.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, (1.0,)), "omega = 0.0: not positive; a part of zero frequency is the constant"),
        ((1.0, (), ()), "cos = (): empty as sin is; give the coefficients"),
        ((1.0, (1.0, math.nan)), "cos.1 = nan: not finite"),
        ((1.0, (), (True,)), "sin.0 = True: not a number"),
        ((1.0, "12"), "cos = '12': not a tuple of coefficients for n = 1, 2, ..."),
        ((1.0, 1.0), "cos = 1.0: not a tuple of coefficients for n = 1, 2, ..."),
        ((1.0, {1: 0.5}), "cos = {1: 0.5}: not a tuple of coefficients for n = 1, 2, ..."),
        ((1.0, (), {0.5}), "sin = {0.5}: not a tuple of coefficients for n = 1, 2, ..."),
    ],
)
def test_bad_fourier_sums_are_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        fourier(*arguments)  # type: ignore[arg-type]

    assert message in str(caught.value)


@pytest.mark.parametrize("omega", [0, -1.0])
def test_a_harmonic_has_a_frequency_above_zero(omega: float) -> None:
    with pytest.raises(ParameterError, match="a part of zero frequency is the constant"):
        Harmonic(1.0, omega)


def test_harmonics_and_fourier_terms_do_not_mix() -> None:
    with pytest.raises(ParameterError, match=r"harmonics\.0 = .*: not a FourierTerm"):
        Forcing((Harmonic(1.0, 1.0),), base=1.0)
    with pytest.raises(ParameterError, match=r"harmonics\.0 = .*: not a Harmonic"):
        Forcing((FourierTerm(1, 1.0),))


def test_the_text_of_a_forcing_shows_what_was_given() -> None:
    two = (Harmonic("0.5", 2, "pi/2"), Harmonic(Fraction(1, 3), 3.0))

    assert repr(Forcing(two, period=pi_times(2))) == (
        "Forcing(harmonics=(Harmonic(amplitude='0.5', omega=2, phase='pi/2'), "
        "Harmonic(amplitude=Fraction(1, 3), omega=3.0, phase=0.0)), constant=0.0, "
        "period=pi_times(2))"
    )


def test_a_sum_has_all_harmonics_and_the_exact_constant() -> None:
    total = cosine(2, constant="0.1") + sine(3, 5, constant="0.2")

    assert total.harmonics == (*cosine(2).harmonics, *sine(3, 5).harmonics)
    assert as_fraction(total.constant) == Fraction(3, 10)
    assert total.period is None


def test_a_sum_keeps_a_period_that_both_have() -> None:
    one = Forcing((Harmonic(1, 2),), period=pi_times(2))
    other = Forcing((Harmonic(1, 3),), period="2*pi")

    assert (one + other).frequency == 1
    assert (cosine("2.8") + sine("14/5")).frequency == Fraction(14, 5)
    assert (one + cosine(3)).period is None


def test_a_constant_is_added_without_losing_the_period() -> None:
    series = fourier(2, (1, 2), (3,))

    assert Forcing(constant=1) + series == fourier(2, (1, 2), (3,), constant=1.0)
    assert (sine(3) + Forcing(constant=-1)).period == sine(3).period


def test_a_fourier_sum_is_added_as_its_harmonics() -> None:
    total = fourier(2, (1, 0), (0, "0.5")) + cosine(2, "0.25")

    assert [(float(c.omega), c.cos, c.sin) for c in total.components()] == [
        (2.0, 1.0, 0.0),
        (4.0, 0.0, 0.5),
        (2.0, 0.25, 0.0),
    ]
    assert total.frequency == 2
    assert (fourier(2, (0,)) + fourier(2, (0,))).harmonics == ()


@pytest.mark.parametrize(
    "force",
    [
        cosine(2, amplitude="0.5", phase="pi/3", constant=-1),
        fourier(2, cos=(1, "0.5"), constant="0.25"),
        Forcing(record=ForceRecord((0, 1, 2), (0, "1.5", 0), repeat=True)) + Forcing(constant=1),
    ],
)
def test_a_force_times_a_number_is_the_force_divided_by_its_inverse(force: Forcing) -> None:
    assert (4 * force).per_mass(1) == (force * 4).per_mass(1) == force.per_mass("1/4")
    assert (4 * force).period == force.period
    assert (force / "1/4").per_mass(1) == (4 * force).per_mass(1)
    assert (-force).per_mass(1) == (force * -1).per_mass(1)
    assert (force - Forcing(constant=3)).constant == as_fraction(force.constant) - 3
    assert not (4 * force).is_per_mass
    assert (4 * force.per_mass(2)).is_per_mass


def test_a_force_is_multiplied_by_numbers_only() -> None:
    with pytest.raises(ParameterError, match="factor"):
        cosine(2) * "two"
    with pytest.raises(TypeError):
        cosine(2) * cosine(2)  # type: ignore[operator]
    with pytest.raises(ParameterError, match="divisor = 0: a division by zero"):
        cosine(2) / 0
    with pytest.raises(ParameterError, match="divisor = 'two'"):
        cosine(2) / "two"


@pytest.mark.parametrize(
    "added",
    [lambda f: f + 1, lambda f: 1 + f, lambda f: f - 1, lambda f: 1 - f, lambda f: 0 - f],
    ids=["f + 1", "1 + f", "f - 1", "1 - f", "0 - f"],
)
def test_a_sum_with_what_is_no_forcing_is_told_in_a_sentence(
    added: Callable[[Forcing], object],
) -> None:
    with pytest.raises(ParameterError, match=r"not a Forcing; a constant force that is added"):
        added(Forcing(constant=1))


def test_coefficients_of_a_sum_may_be_arrays() -> None:
    """To a type checker, too: those of a transform are."""
    values = np.fft.rfft(np.sin(np.arange(8) * np.pi / 4)) / 4

    assert fourier(2, cos=values.real[1:2], sin=-values.imag[1:2]) == fourier(
        2, cos=values.real[1:2].tolist(), sin=(-values.imag[1:2]).tolist()
    )
