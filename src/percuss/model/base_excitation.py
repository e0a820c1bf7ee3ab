"""The force on a mass whose support shakes."""

from __future__ import annotations

from percuss.model.exact import Exact, Phase
from percuss.model.expression import Expression, parameter
from percuss.model.forcing import Forcing, Harmonic

__all__ = ["base_excitation"]


def base_excitation(
    amplitude: Exact, omega: Exact, phase: Phase = 0.0, constant: Exact = 0.0
) -> Forcing:
    """Return the force on a mass whose support moves by -amplitude cos(omega t + phase).

    In the frame of the support it is constant + amplitude omega^2 cos(omega t + phase) per unit
    mass, and marked so: an oscillator with a mass takes it as that acceleration. A study over `forcing.omega` keeps the amplitude of the support: the amplitude of the
    force is an expression of two parameters, `base_amplitude` and `base_omega`, or of those given.

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
