"""Forcings made of harmonics: cosines and sines, Fourier sums, a shaking support."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, plain
from percuss.model.expression import Expression, parameter
from percuss.model.faults import draft, is_row, phase_faults, raise_first
from percuss.model.forcing import Forcing, FourierTerm, Harmonic, sine_phase


def cosine(
    omega: Exact, amplitude: Exact = 1.0, phase: Phase = 0.0, constant: Exact = 0.0
) -> Forcing:
    """Return the forcing constant + amplitude cos(omega t + phase).

    Parameters
    ----------
    omega
        Angular frequency [1/time], > 0.
    amplitude
        Amplitude per unit mass [length/time^2].
    phase
        Phase [rad].
    constant
        Constant part [length/time^2].

    Returns
    -------
    Forcing
        With one harmonic.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> cosine("2.8").harmonics
    (Harmonic(amplitude=1.0, omega='2.8', phase=0.0),)
    """
    return Forcing((Harmonic(amplitude, omega, phase),), constant)


def sine(
    omega: Exact, amplitude: Exact = 1.0, phase: Phase = 0.0, constant: Exact = 0.0
) -> Forcing:
    """Return the forcing constant + amplitude sin(omega t + phase), which is exactly 0 at rest.

    It is kept as the cosine whose phase is less by pi/2, exactly.

    Parameters
    ----------
    omega
        Angular frequency [1/time], > 0.
    amplitude
        Amplitude per unit mass [length/time^2].
    phase
        Phase [rad].
    constant
        Constant part [length/time^2].

    Returns
    -------
    Forcing
        With one harmonic.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> sine(3.0).harmonics
    (Harmonic(amplitude=1.0, omega=3.0, phase=pi_times(-1, 2)),)
    """
    raise_first(phase_faults("phase", plain(phase)))
    return cosine(omega, amplitude, sine_phase(phase), constant)


def fourier(
    omega: Exact,
    cos: Sequence[Exact] | Floats = (),
    sin: Sequence[Exact] | Floats = (),
    constant: Exact = 0.0,
) -> Forcing:
    """Return the forcing constant + sum of cos[n-1] cos(n omega t) + sin[n-1] sin(n omega t).

    Its frequencies are exact multiples of omega, which is its one parameter of frequency,
    ``forcing.omega``.

    Parameters
    ----------
    omega
        Base frequency [1/time], > 0; the period is 2 pi/omega.
    cos
        Coefficients of the cosines [length/time^2], for n = 1, 2, ...
    sin
        Coefficients of the sines; the shorter of the two is filled with zeros.
    constant
        Constant part [length/time^2].

    Returns
    -------
    Forcing
        With one `FourierTerm` for each n.

    Raises
    ------
    ParameterError
        If a value is outside its domain, or there are no coefficients.

    Examples
    --------
    >>> fourier(2.0, cos=(1.0, 0.2), sin=(0.0, 0.1), constant=-0.5)
    fourier(2.0, cos=(1.0, 0.2), sin=(0.0, 0.1), constant=-0.5)
    """
    for name, values in (("cos", cos), ("sin", sin)):
        if not is_row(values):
            raise ParameterError(name, values, "not a tuple of coefficients for n = 1, 2, ...")
    # Forcing checks the terms, and names each fault by its number.
    terms = [
        draft(FourierTerm, n=n, cos=c, sin=s)
        for n, (c, s) in enumerate(zip_longest(cos, sin, fillvalue=0.0), 1)
    ]
    return Forcing(terms, constant, base=omega)


def base_excitation(
    amplitude: Exact, omega: Exact, phase: Phase = 0.0, constant: Exact = 0.0
) -> Forcing:
    """Return the force on a mass whose support moves by -amplitude cos(omega t + phase).

    In the frame of the support it is constant + amplitude omega^2 cos(omega t + phase) per unit
    mass, and marked so: an oscillator with a mass takes it as that acceleration. A study over
    `forcing.omega` keeps the amplitude of the support: the amplitude of the force is an expression
    of two parameters, `base_amplitude` and `base_omega`, or of those given.

    Parameters
    ----------
    amplitude
        Amplitude of the support [length]; a number, or an expression of parameters.
    omega
        Angular frequency [1/time], > 0; a number, or an expression of parameters.
    phase
        Phase [rad].
    constant
        Constant part [length/time^2].

    Returns
    -------
    Forcing
        With one harmonic.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> force = base_excitation("0.15", 2)
    >>> print(force.harmonics[0].amplitude, force.components()[0].cos)
    base_amplitude*base_omega**2 0.6
    """
    if not isinstance(amplitude, Expression):
        amplitude = parameter("base_amplitude", amplitude)
    if not isinstance(omega, Expression):
        omega = parameter("base_omega", omega)
    wave = Harmonic(amplitude * omega**2, omega, phase)
    return Forcing((wave,), constant, is_per_mass=True)
