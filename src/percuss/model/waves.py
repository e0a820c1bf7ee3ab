"""Forcings made of records: measured forces, square and triangle waves, pulses."""

from __future__ import annotations

from collections.abc import Sequence

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, as_float, pi_times, plain
from percuss.model.faults import number_faults, positive_faults, raise_first
from percuss.model.force_record import ForceRecord, Outside, RecordKind
from percuss.model.forcing import Forcing


def record(
    t: Sequence[Phase] | Floats,
    f: Sequence[Exact] | Floats,
    kind: RecordKind = "linear",
    repeat: bool = False,
    outside: Outside = "end",
) -> Forcing:
    """Return the forcing that has given values at given instants.

    The motion under it is exact, as under harmonics: between two samples the force is linear, and
    so is what it does in closed form. Add harmonics, or a constant, by ``+``.

    Parameters
    ----------
    t
        Instants [time], each after the one before; two at least.
    f
        The force at these instants: of an oscillator with a mass a force, otherwise per unit mass
        [length/time^2]; ``record(t, a).per_mass(1)`` marks an acceleration.
    kind
        "linear" between the samples, or "hold": each value from its instant to the next.
    repeat
        Whether the record begins again at its last instant; the period is ``t[-1] - t[0]``.
    outside
        What acts before and after a record that does not repeat: "end", its first and its last
        value; "zero", nothing.

    Returns
    -------
    Forcing
        With the record, no harmonics, and the period of a repeated record.

    Raises
    ------
    ParameterError
        If a sample is no finite number, the instants do not rise, the lengths differ, or there is
        one sample alone.

    Examples
    --------
    >>> import percuss as pc
    >>> force = pc.record([0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
    >>> run = pc.simulate(pc.Oscillator(stiffness=0), force, t_end=2.0)
    >>> x, v = run(2.0)
    >>> float(x), float(v)
    (1.0, 1.0)
    """
    return Forcing(record=ForceRecord(t, f, kind, repeat, outside))  # type: ignore[arg-type]


def square_wave(omega: Exact, amplitude: Exact = 1.0) -> Forcing:
    """Return the force +amplitude on the first half of each period from t = 0, -amplitude after it.

    It is the wave itself, not a Fourier sum of it, which would overshoot at its jumps.

    Parameters
    ----------
    omega
        Angular frequency [1/time], > 0.
    amplitude
        Amplitude per unit mass [length/time^2].

    Returns
    -------
    Forcing
        With a repeated record; its paths are ``forcing.record.omega`` and
        ``forcing.record.amplitude``.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> force = square_wave(2, amplitude="0.5")
    >>> force.period
    3.141592653589793
    """
    return _wave((0, pi_times(1), pi_times(2)), (1, -1, 1), "hold", omega, amplitude)


def triangle_wave(omega: Exact, amplitude: Exact = 1.0) -> Forcing:
    """Return the piecewise linear wave that starts at 0 upwards and lies between +-amplitude.

    Parameters
    ----------
    omega
        Angular frequency [1/time], > 0.
    amplitude
        Amplitude per unit mass [length/time^2].

    Returns
    -------
    Forcing
        With a repeated record; its paths are ``forcing.record.omega`` and
        ``forcing.record.amplitude``.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> triangle_wave(2).record.f
    (0, 1, -1, 0)
    """
    turns = (0, pi_times(1, 2), pi_times(3, 2), pi_times(2))
    return _wave(turns, (0, 1, -1, 0), "linear", omega, amplitude)


def pulses(omega: Exact, width: Exact, amplitude: Exact = 1.0) -> Forcing:
    """Return the force +amplitude on the first part of each period from t = 0, and none after it.

    Parameters
    ----------
    omega
        Angular frequency [1/time], > 0.
    width
        Part of the period that a pulse lasts, between 0 and 1.
    amplitude
        Force of a pulse per unit mass [length/time^2].

    Returns
    -------
    Forcing
        With a repeated record; its paths are ``forcing.record.omega`` and
        ``forcing.record.amplitude``.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> pulses(2, "0.25").record.t
    (0, pi_times(1, 2), pi_times(2))
    """
    width = plain(width)  # type: ignore[assignment]
    raise_first(number_faults("width", width) or positive_faults("width", width))
    if not as_float(width) < 1.0:
        raise ParameterError("width", width, "not below 1, the whole period")
    end = pi_times(width) + pi_times(width)
    return _wave((0, end, pi_times(2)), (1, 0, 1), "hold", omega, amplitude)


def _wave(
    turns: tuple[Phase, ...],
    values: tuple[int, ...],
    kind: RecordKind,
    omega: Exact,
    amplitude: Exact,
) -> Forcing:
    """Return the force that repeats values at phases of a frequency."""
    if omega is None:  # a record without one counts time
        raise ParameterError("omega", omega, "not a number; a wave has a frequency")
    return Forcing(record=ForceRecord(turns, values, kind, True, "end", amplitude, omega))
