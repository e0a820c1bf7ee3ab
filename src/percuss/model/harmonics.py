"""The parts of a forcing: harmonics and terms of a Fourier sum."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from percuss.model.exact import Exact, Phase, as_float, cos_sin, scaled
from percuss.model.faults import (
    Fault,
    dotted,
    faults,
    make_plain,
    number_faults,
    phase_faults,
    positive_faults,
    raise_first,
    scale_faults,
)

__all__ = ["Component", "ForcingTerm", "FourierTerm", "Harmonic"]


@dataclass(frozen=True, slots=True)
class Component:
    """A harmonic as cos cos(omega t) + sin sin(omega t), as the kernels need it.

    Parameters
    ----------
    omega
        Angular frequency [1/time], exact.
    cos
        Coefficient of the cosine [length/time^2].
    sin
        Coefficient of the sine [length/time^2].
    """

    omega: Fraction
    cos: float
    sin: float


@dataclass(frozen=True, slots=True)
class Harmonic:
    """The force A cos(omega t + phase) per unit mass.

    Parameters
    ----------
    amplitude
        Amplitude A [length/time^2], finite.
    omega
        Angular frequency [1/time], > 0.
    phase
        Phase [rad]; a number, a multiple of pi by `pi_times`, or a text such as ``"-pi/2"``.
        Multiples of pi/2 give exact coefficients.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> Harmonic(amplitude=1.0, omega=2.0, phase=0.3)
    Harmonic(amplitude=1.0, omega=2.0, phase=0.3)
    """

    amplitude: Exact
    omega: Exact
    phase: Phase = 0.0

    def __post_init__(self) -> None:
        make_plain(self, "amplitude", "omega", "phase")
        raise_first(faults(self))


@dataclass(frozen=True, slots=True)
class FourierTerm:
    """The force cos cos(n w t) + sin sin(n w t), where w is the base of the forcing.

    Made by `fourier`.

    Parameters
    ----------
    n
        Multiple of the base frequency, >= 1.
    cos
        Coefficient of the cosine [length/time^2], finite.
    sin
        Coefficient of the sine [length/time^2], finite.

    Raises
    ------
    ParameterError
        If a value is outside its domain.
    """

    n: int
    cos: Exact = 0.0
    sin: Exact = 0.0

    def __post_init__(self) -> None:
        make_plain(self, "n", "cos", "sin")
        raise_first(faults(self))


ForcingTerm: TypeAlias = Harmonic | FourierTerm


@faults.register
def _(value: Harmonic, prefix: str | None = None) -> list[Fault]:
    return [
        *number_faults(dotted(prefix, "amplitude"), value.amplitude),
        *frequency_faults(dotted(prefix, "omega"), value.omega),
        *phase_faults(dotted(prefix, "phase"), value.phase),
    ]


@faults.register
def _(value: FourierTerm, prefix: str | None = None) -> list[Fault]:
    problems = []
    if type(value.n) is not int or value.n < 1:
        problems.append(Fault(dotted(prefix, "n"), value.n, "not a whole number of at least 1"))
    for name, coefficient in (("cos", value.cos), ("sin", value.sin)):
        problems += number_faults(dotted(prefix, name), coefficient)
    return problems


def frequency_faults(name: str, value: object) -> list[Fault]:
    """Return the fault of a value that is no angular frequency."""
    problems = positive_faults(
        name, value, "not positive; a part of zero frequency is the constant"
    )
    return problems or scale_faults(name, value)


def scaled_part(part: ForcingTerm, factor: Fraction) -> ForcingTerm:
    """Return a part of a forcing times a factor, exactly."""
    if isinstance(part, FourierTerm):
        return FourierTerm(part.n, scaled(part.cos, factor), scaled(part.sin, factor))
    return Harmonic(scaled(part.amplitude, factor), part.omega, part.phase)


def coefficients(part: ForcingTerm) -> tuple[float, float]:
    """Return the coefficients of cos(omega t) and sin(omega t) of a part, without -0.0.

    Examples
    --------
    >>> coefficients(Harmonic(amplitude=2.0, omega=1.0, phase="-pi/2"))
    (0.0, 2.0)
    """
    if isinstance(part, FourierTerm):
        return as_float(part.cos) + 0.0, as_float(part.sin) + 0.0
    amplitude = as_float(part.amplitude)
    cosine, sine = cos_sin(part.phase)
    return amplitude * cosine + 0.0, -amplitude * sine + 0.0
