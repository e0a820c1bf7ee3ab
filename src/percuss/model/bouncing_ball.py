"""A ball that bounces on a shaking table, in the frame of the table."""

from __future__ import annotations

from percuss.model.exact import Exact, Phase, kept, operand, scaled
from percuss.model.faults import not_negative_faults, number_faults, plain_number, raise_first
from percuss.model.forcing import Forcing, frequency_faults
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import Oscillator, impact_oscillator
from percuss.model.restitution import Restitution


def ball_on_table(
    amplitude: Exact,
    omega: Exact,
    *,
    gravity: Exact = 1.0,
    restitution: Restitution = 1.0,
    phase: Phase = 0.0,
) -> tuple[Oscillator, Forcing]:
    """Return the oscillator and the forcing of a ball on a table at A sin(omega t + phase).

    The height of the ball over the table, y >= 0, obeys
    y'' = -gravity + A omega^2 sin(omega t + phase). Heights and velocities of a run are
    therefore those relative to the table.

    The amplitude of the force is A omega^2, a number of its own: a study over `forcing.omega` keeps
    it, and with it the table's acceleration, not its amplitude A. With a `parameter` for omega it
    follows, and a study over this parameter keeps A.

    Parameters
    ----------
    amplitude
        Amplitude A of the table [length].
    omega
        Angular frequency of the table [1/time], > 0.
    gravity
        Acceleration of gravity, downwards [length/time^2], >= 0.
    restitution
        Coefficient of restitution of the impacts on the table, in [0, 1], or a `restitution_table`.
    phase
        Phase of the table [rad].

    Returns
    -------
    tuple of Oscillator and Forcing
        Free flight above a wall at 0, and the forcing in the frame of the table.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> osc, force = ball_on_table(amplitude=1.25, omega=2.0, restitution=0.8)
    >>> force.constant, force.components()
    (-1.0, (Component(omega=Fraction(2, 1), cos=0.0, sin=5.0),))
    """
    amplitude, omega, gravity = (plain_number(value) for value in (amplitude, omega, gravity))
    raise_first(
        [
            *number_faults("amplitude", amplitude),
            *frequency_faults("omega", omega),
            *not_negative_faults(
                "gravity", gravity, "negative; it points down to the table, give its size"
            ),
        ]
    )
    force = sine(
        omega,
        amplitude=scaled(amplitude, operand(omega) ** 2),
        phase=phase,
        constant=kept(-operand(gravity)),
    )
    return impact_oscillator(restitution, stiffness=0.0), force
