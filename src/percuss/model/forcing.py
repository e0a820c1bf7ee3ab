"""The forcing: a constant, harmonics and a record, as frozen values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any, NoReturn, TypeAlias, cast

from percuss.errors import ParameterError
from percuss.model.exact import (
    DIVISION_BY_ZERO,
    Exact,
    Phase,
    PiTimes,
    angle,
    as_float,
    as_fraction,
    cos_sin,
    kept,
    operand,
    phase_problem,
    pi_times,
    plain,
    scaled,
)
from percuss.model.faults import (
    Fault,
    as_tuple,
    dotted,
    faults,
    make_numbers,
    make_plain,
    number_faults,
    phase_faults,
    plain_number,
    positive_faults,
    raise_first,
    scale_faults,
)
from percuss.model.force_record import ForceRecord
from percuss.model.ratios import PI

# How far omega period / (2 pi) may be from a whole number: far more than what rounding does.
PERIOD_TOLERANCE = 1e-9


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
        make_numbers(self, "amplitude", "omega")
        make_plain(self, "phase")
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
        make_plain(self, "n")
        make_numbers(self, "cos", "sin")
        raise_first(faults(self))


ForcingTerm: TypeAlias = Harmonic | FourierTerm


@dataclass(frozen=True, slots=True, init=False, repr=False)
class Forcing:
    """The force per unit mass f(t) = constant + sum of A cos(omega t + phase) + record.

    Parameters
    ----------
    harmonics
        The harmonics, any number. Forcings can be added: `cosine(2) + sine(3)` has both.
    constant
        Constant part [length/time^2], finite.
    period
        A common period of the harmonics [time], > 0, which makes a sum of several periodic: it
        is not guessed, and without it `period` is None. Every omega period / (2 pi) is a whole
        number within 1e-9. May be a multiple of pi.
    base
        Base frequency of a sum made by `fourier`, which sets it.
    record
        A force given by its samples; `record` (the function) and `square_wave` make one.
    is_per_mass
        Whether it is per unit mass for an oscillator that has a mass, too; `per_mass` sets it.

    Attributes
    ----------
    given_period
        The period as it was given, or None; `period` is the one that holds.

    Raises
    ------
    ParameterError
        If a value is outside its domain, or the period does not fit the harmonics.

    Examples
    --------
    >>> force = Forcing((Harmonic(1.0, 2.0), Harmonic(0.5, 3.0)), period=pi_times(2))
    >>> force.period, force.frequency
    (6.283185307179586, Fraction(1, 1))
    """

    harmonics: tuple[ForcingTerm, ...] = ()
    constant: Exact = 0.0
    given_period: Phase | None = field(default=None, metadata={"given_as": "period"})
    base: Exact | None = None
    record: ForceRecord | None = None
    is_per_mass: bool = False

    def __init__(
        self,
        harmonics: Iterable[ForcingTerm] = (),
        constant: Exact = 0.0,
        period: Phase | None = None,
        *,
        base: Exact | None = None,
        record: ForceRecord | None = None,
        is_per_mass: bool = False,
    ) -> None:
        object.__setattr__(self, "harmonics", as_tuple(harmonics))
        object.__setattr__(self, "constant", plain_number(constant))
        object.__setattr__(self, "given_period", plain(period))
        object.__setattr__(self, "base", plain_number(base))
        object.__setattr__(self, "record", record)
        object.__setattr__(self, "is_per_mass", is_per_mass)
        raise_first(faults(self, ""))

    def __repr__(self) -> str:
        if self.base is not None:
            terms = cast("tuple[FourierTerm, ...]", self.harmonics)
            cos, sin = tuple(term.cos for term in terms), tuple(term.sin for term in terms)
            text = f"fourier({self.base!r}, cos={cos!r}, sin={sin!r}, constant={self.constant!r})"
            if self.record is not None:
                text = f"{text} + {Forcing(record=self.record)!r}"
                return f"({text}).per_mass(1)" if self.is_per_mass else text
            return f"{text}.per_mass(1)" if self.is_per_mass else text
        more = "" if self.given_period is None else f", period={self.given_period!r}"
        more += "" if self.record is None else f", record={self.record!r}"
        more += ", is_per_mass=True" if self.is_per_mass else ""
        return f"Forcing(harmonics={self.harmonics!r}, constant={self.constant!r}{more})"

    def __add__(self, other: Forcing) -> Forcing:
        """Return the sum of two forcings, exactly.

        It keeps a period that both have, and that of the other one if one is constant; otherwise it
        has none. Two records cannot be added. Both are forces, or both per unit mass.
        """
        if not isinstance(other, Forcing):
            raise _no_term(other)
        if self.is_per_mass != other.is_per_mass:
            reason = (
                "a force and a force per unit mass have no sum; .per_mass(m) makes a force one per "
                "unit mass, with m = 1 where the oscillator has no mass"
            )
            raise ParameterError("force", other, reason)
        constant = kept(operand(self.constant) + operand(other.constant))
        if self.record is not None and other.record is not None:
            reason = "both forces have a record; add the samples of the two, and make one of them"
            raise ParameterError("forcing.record", other.record, reason)
        record = self.record or other.record
        pairs = ((self, other), (other, self))
        for force, added in pairs:
            if added.is_constant:
                return force._with(constant=constant, record=record)
        periods = {_exact_period(force) for force in (self, other)}
        period = periods.pop() if len(periods) == 1 else None
        for force, added in pairs:
            if not added.harmonics:
                # A Fourier sum has its period from its base.
                own = period if force.base is None else None
                return force._with(constant=constant, period=own, record=record)
        parts = [part for force in (self, other) for part in _plain_harmonics(force)]
        # Of harmonics that are all zero none is left.
        period = period if parts or record is not None else None
        return Forcing(parts, constant, period, record=record, is_per_mass=self.is_per_mass)

    def _with(self, **changed: Any) -> Forcing:
        """Return the forcing with other values of some arguments."""
        own = {
            "harmonics": self.harmonics,
            "constant": self.constant,
            "period": self.given_period,
            "base": self.base,
            "record": self.record,
            "is_per_mass": self.is_per_mass,
        }
        return Forcing(**(own | changed))

    @property
    def is_constant(self) -> bool:
        """Whether it is its constant alone: no harmonics and no record."""
        return not self.harmonics and self.record is None

    @property
    def period(self) -> float | None:
        """Period [time]; None without harmonics, and for several unless you give ``period=``.

        `fourier` needs none: its period is 2 pi over its base frequency. That of a repeated record
        is the period of its sum with harmonics only if it is theirs, too.
        """
        frequency = self.frequency
        if frequency is not None:
            # 2 pi / frequency, rounded once; a quotient of integers takes a tenth of one of
            # fractions.
            return 2 * PI.numerator * frequency.denominator / (PI.denominator * frequency.numerator)
        exact = self.exact_period
        return None if exact is None else as_float(exact)

    @property
    def exact_period(self) -> PiTimes | None:
        """The period as the exact number that it is or was given as; None without one."""
        return _exact_period(self)

    @property
    def frequency(self) -> Fraction | None:
        """Exact angular frequency of the period [1/time]; None where it is not known exactly.

        With a given period it is known if the harmonics are exact multiples of one frequency.
        """
        return _frequency(self)

    def components(self) -> tuple[Component, ...]:
        """Return the harmonics as cosine and sine coefficients.

        Terms of a Fourier sum that are zero are left out, other harmonics never.

        Returns
        -------
        tuple of Component
            One for each harmonic, in their order.

        Examples
        --------
        >>> from percuss.model import sine
        >>> sine(3).components()
        (Component(omega=Fraction(3, 1), cos=0.0, sin=1.0),)
        """
        return _components(self)

    def per_mass(self, mass: Exact) -> Forcing:
        """Return a force divided by a mass, and marked as per unit mass.

        An oscillator without a mass takes it as any force. One that has a mass takes it as the
        acceleration that it is: its own mass does not divide it again.

        Parameters
        ----------
        mass
            Mass [mass], > 0; 1 marks a force that is per unit mass already.

        Returns
        -------
        Forcing
            With amplitudes and constant divided by the mass, exactly.

        Raises
        ------
        ParameterError
            If the mass is no number above zero, or the force is per unit mass already.

        Examples
        --------
        >>> from percuss.model import cosine
        >>> force = cosine(3.0, amplitude=5.0).per_mass(2.0)
        >>> force.harmonics, force.is_per_mass
        ((Harmonic(amplitude=2.5, omega=3.0, phase=0.0),), True)
        """
        mass = plain_number(mass)
        raise_first(positive_faults("mass", mass))
        if self.is_per_mass:
            raise ParameterError("mass", mass, "the force is per unit mass already")
        return self._times(1 / operand(mass), is_per_mass=True)

    def __mul__(self, factor: Exact) -> Forcing:
        """Return the force times a number, exactly: ``20e3 * sea`` of a sea in metres.

        Raises
        ------
        ParameterError
            If the factor is no number.

        Examples
        --------
        >>> from percuss.model import cosine
        >>> (3 * cosine(2.0, amplitude="0.5", constant=1)).harmonics[0].amplitude
        1.5
        """
        if isinstance(factor, Forcing):
            return NotImplemented
        factor = plain_number(factor)
        raise_first(number_faults("factor", factor))
        return self._times(operand(factor), is_per_mass=self.is_per_mass)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Exact) -> Forcing:
        """Return the force over a number, exactly.

        Raises
        ------
        ParameterError
            If the divisor is no number, or zero.

        Examples
        --------
        >>> from percuss.model import cosine
        >>> (cosine(2.0, amplitude=1) / 3).harmonics[0].amplitude
        Fraction(1, 3)
        """
        if isinstance(divisor, Forcing):
            return NotImplemented
        divisor = plain_number(divisor)
        raise_first(number_faults("divisor", divisor))
        if as_fraction(divisor) == 0:
            raise ParameterError("divisor", divisor, DIVISION_BY_ZERO)
        return self._times(1 / operand(divisor), is_per_mass=self.is_per_mass)

    def __neg__(self) -> Forcing:
        """Return the force in the opposite direction, exactly."""
        return self._times(Fraction(-1), is_per_mass=self.is_per_mass)

    def __sub__(self, other: Forcing) -> Forcing:
        """Return the sum with the opposite of another forcing, exactly.

        Raises
        ------
        ParameterError
            As for a sum.

        Examples
        --------
        >>> from percuss.model import cosine
        >>> (cosine(2.0) - cosine(3.0)).harmonics[1].amplitude
        -1.0
        """
        if not isinstance(other, Forcing):
            raise _no_term(other)
        return self + -other

    def __radd__(self, other: object) -> Forcing:
        """Return the forcing itself for 0, with which Python's `sum` begins.

        Raises
        ------
        ParameterError
            For anything else.

        Examples
        --------
        >>> from percuss.model import cosine
        >>> sum([cosine(2.0), cosine(3.0)]) == cosine(2.0) + cosine(3.0)
        True
        """
        if isinstance(other, int) and other == 0:
            return self
        raise _no_term(other)

    def __rsub__(self, other: object) -> NoReturn:
        """Raise the error of a difference from what is no forcing."""
        raise _no_term(other)

    def _times(self, factor: Fraction, *, is_per_mass: bool) -> Forcing:
        return self._with(
            harmonics=tuple(_scaled_part(part, factor) for part in self.harmonics),
            constant=scaled(self.constant, factor),
            record=None if self.record is None else self.record.scaled(kept(factor)),
            is_per_mass=is_per_mass,
        )

    def acceleration_of(self, mass: Exact | None) -> Forcing:
        """Return what a force does to a mass: the force per unit mass.

        Parameters
        ----------
        mass
            Mass of the oscillator that it acts on; None for one of unit mass.

        Returns
        -------
        Forcing
            The force divided by the mass; itself without one, and if it is per unit mass already.

        Examples
        --------
        >>> from percuss.model import cosine
        >>> force = cosine(3.0, amplitude=5.0)
        >>> force.acceleration_of(2.0) == force.per_mass(2.0).acceleration_of(2.0)
        True
        """
        return self if mass is None or self.is_per_mass else self.per_mass(mass)


def sine_phase(phase: Phase) -> PiTimes:
    """Return the phase of the cosine that is the sine of the given phase."""
    return pi_times(-1, 2) + cast("Phase", plain(phase))


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


@faults.register
def _(value: Forcing, prefix: str | None = None) -> list[Fault]:
    prefix = "forcing" if prefix is None else prefix
    problems = number_faults(dotted(prefix, "constant"), value.constant)
    if not isinstance(value.is_per_mass, bool):
        name = dotted(prefix, "is_per_mass")
        problems.append(Fault(name, value.is_per_mass, "neither true nor false"))
    if value.base is not None:
        problems += frequency_faults(dotted(prefix, "omega"), value.base)
    if value.record is not None:
        if not isinstance(value.record, ForceRecord):
            problems.append(Fault(dotted(prefix, "record"), value.record, "not a ForceRecord"))
        else:
            problems += faults(value.record, dotted(prefix, "record"))
    if not isinstance(value.harmonics, tuple):
        return [*problems, Fault(dotted(prefix, "harmonics"), value.harmonics, "not a tuple")]
    for index, part in enumerate(value.harmonics):
        name = dotted(prefix, f"harmonics.{index}")
        if value.base is not None and isinstance(part, FourierTerm):
            for coefficient in ("cos", "sin"):
                name = dotted(prefix, f"{coefficient}.{index}")
                problems += number_faults(name, getattr(part, coefficient))
        elif value.base is None and isinstance(part, Harmonic):
            problems += faults(part, name)
        else:
            wanted = "Harmonic" if value.base is None else "FourierTerm"
            problems.append(Fault(name, part, f"not a {wanted}"))
    return problems or _period_faults(value, prefix)


def _period_faults(forcing: Forcing, prefix: str) -> list[Fault]:
    if forcing.base is not None and not forcing.harmonics:
        return [Fault(dotted(prefix, "cos"), (), "empty as sin is; give the coefficients")]
    name, period = dotted(prefix, "period"), forcing.given_period
    if period is None:
        return []
    problem = phase_problem(period)
    if problem is None and as_float(period) <= 0.0:
        problem = "not positive"
    if problem is None and forcing.is_constant:
        problem = "given without harmonics; there is nothing to repeat"
    if problem is None and forcing.record is not None:
        problem = _record_problem(forcing.record, period)
    if problem is not None:
        return [Fault(name, period, problem)]
    problems = []
    for index, omega in enumerate(_omegas(forcing)):
        turns = _turns(omega, period)
        if abs(turns - max(round(turns), 1)) > PERIOD_TOLERANCE:
            reason = (
                f"harmonic {index} of omega = {float(omega):.15g} makes {float(turns):.15g} turns"
                " in it, not a whole number"
            )
            problems.append(Fault(name, period, reason))
    return problems


def _record_problem(record: ForceRecord, period: Phase) -> str | None:
    """Return what is wrong with a period of a sum with a record."""
    if record.period is None:
        return "given with a record that does not repeat; give repeat=True"
    (times, plus), (own_times, own_plus) = angle(period), angle(record.period)
    turns = (times * PI + plus) / (own_times * PI + own_plus)
    if abs(turns - max(round(turns), 1)) > PERIOD_TOLERANCE:
        return f"{float(turns):.15g} periods of the record, not a whole number"
    return None


def frequency_faults(name: str, value: object) -> list[Fault]:
    """Return the fault of a value that is no angular frequency."""
    problems = positive_faults(
        name, value, "not positive; a part of zero frequency is the constant"
    )
    return problems or scale_faults(name, value)


def _scaled_part(part: ForcingTerm, factor: Fraction) -> ForcingTerm:
    """Return a part of a forcing times a factor, exactly."""
    if isinstance(part, FourierTerm):
        return FourierTerm(part.n, scaled(part.cos, factor), scaled(part.sin, factor))
    return Harmonic(scaled(part.amplitude, factor), part.omega, part.phase)


def _coefficients(part: ForcingTerm) -> tuple[float, float]:
    """Return the coefficients of cos(omega t) and sin(omega t) of a part, without -0.0.

    Examples
    --------
    >>> _coefficients(Harmonic(amplitude=2.0, omega=1.0, phase="-pi/2"))
    (0.0, 2.0)
    """
    if isinstance(part, FourierTerm):
        return as_float(part.cos) + 0.0, as_float(part.sin) + 0.0
    amplitude = as_float(part.amplitude)
    cosine, sine = cos_sin(part.phase)
    return amplitude * cosine + 0.0, -amplitude * sine + 0.0


def _omegas(forcing: Forcing) -> tuple[Fraction, ...]:
    if forcing.base is None:
        harmonics = cast("tuple[Harmonic, ...]", forcing.harmonics)
        return tuple(as_fraction(harmonic.omega) for harmonic in harmonics)
    terms = cast("tuple[FourierTerm, ...]", forcing.harmonics)
    return tuple(term.n * as_fraction(forcing.base) for term in terms)


def _turns(omega: Fraction, period: Phase) -> Fraction:
    times, plus = angle(period)
    return omega * (times + plus / PI) / 2


def _plain_harmonics(forcing: Forcing) -> list[Harmonic]:
    """Return the parts as harmonics, those of a Fourier sum as cosines and sines."""
    harmonics = []
    for part in forcing.harmonics:
        if isinstance(part, Harmonic):
            harmonics.append(part)
        else:
            pairs: tuple[tuple[Exact, Phase], ...] = (
                (part.cos, 0.0),
                (part.sin, sine_phase(0.0)),
            )
            omega = kept(part.n * operand(cast("Exact", forcing.base)))
            harmonics += [
                Harmonic(amplitude, omega, phase)
                for amplitude, phase in pairs
                if as_float(amplitude) != 0.0
            ]
    return harmonics


def _exact_period(forcing: Forcing) -> PiTimes | None:
    """Return the period as the exact number it is or was given as."""
    if forcing.record is not None:
        if forcing.given_period is not None:
            return PiTimes(*angle(forcing.given_period))
        own = forcing.record.period
        if not forcing.harmonics or own is None:
            return own
        if all(_turns(omega, own).denominator == 1 for omega in _omegas(forcing)):
            return own
        # Both may be of one irrational parameter.
        harmonics = Forcing(forcing.harmonics, base=forcing.base)
        return own if _exact_period(harmonics) == own else None
    if forcing.frequency is not None:
        return _period_of(forcing.frequency)
    return None if forcing.given_period is None else PiTimes(*angle(forcing.given_period))


def _period_of(frequency: Fraction) -> PiTimes:
    """Return 2 pi over a frequency; that of a multiple of pi is rational."""
    per_pi = frequency / PI
    if per_pi.denominator < frequency.denominator:
        return PiTimes(Fraction(0), 2 / per_pi)
    return PiTimes(2 / frequency)


# Every run asks for the next two, which depend on the frozen value alone.
@lru_cache(maxsize=1024)
def _frequency(forcing: Forcing) -> Fraction | None:
    if forcing.record is not None:
        period = _exact_period(forcing)
        return 2 / angle(period)[0] if period is not None and not angle(period)[1] else None
    omegas = _omegas(forcing)
    if forcing.given_period is None:
        if forcing.base is not None:
            return as_fraction(forcing.base)
        return omegas[0] if len(omegas) == 1 else None
    turns = [round(_turns(omega, forcing.given_period)) for omega in omegas]
    candidates = {omega / count for omega, count in zip(omegas, turns, strict=True)}
    return candidates.pop() if len(candidates) == 1 else None


@lru_cache(maxsize=1024)
def _components(forcing: Forcing) -> tuple[Component, ...]:
    return tuple(
        Component(omega, *_coefficients(part))
        for omega, part in zip(_omegas(forcing), forcing.harmonics, strict=True)
        if isinstance(part, Harmonic) or any(_coefficients(part))
    )


def _no_term(other: object) -> ParameterError:
    """Return the error of a sum of a forcing and something else."""
    reason = "not a Forcing; a constant force that is added is Forcing(constant=1)"
    return ParameterError("force", other, reason)
