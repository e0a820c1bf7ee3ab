"""A force given by its samples: linear, or constant, between the instants of a record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, get_args

from percuss.errors import ParameterError
from percuss.model.exact import (
    Exact,
    Phase,
    PiTimes,
    angle,
    as_float,
    as_fraction,
    kept,
    number_problem,
    operand,
    phase_problem,
    plain,
    rational,
)
from percuss.model.faults import (
    Fault,
    dotted,
    faults,
    make_numbers,
    make_plain,
    number_faults,
    positive_faults,
    raise_first,
    scale_faults,
)
from percuss.model.ratios import Ratio

RecordKind = Literal["linear", "hold"]
Outside = Literal["end", "zero"]
# Faults of samples that are told at once; a wrong column has one in every line.
MOST_TOLD = 10
# Properties of samples, computed once for all records that have them.
OF_SAMPLES = ("_samples_hash", "has_good_samples", "exact_samples")
# Slopes beyond this, as other numbers of a model, leave the range of floats in the bounds.
STEEPEST = 1e100


@dataclass(frozen=True, eq=False, repr=False)
class ForceRecord:
    """A force per unit mass by its samples, exact; `record` and `square_wave` make forcings of it.

    Parameters
    ----------
    t
        Instants of the samples [time], each after the one before; with `omega`, its phases [rad].
        Numbers or multiples of pi.
    f
        The force at these instants, as parts of the amplitude.
    kind
        "linear" between the samples, or "hold": from each sample to the next.
    repeat
        Whether it begins again at its last sample, which then only ends its period.
    outside
        Before and after a record that does not repeat, "end": the first and the last sample hold;
        "zero": there is no force.
    amplitude
        Factor of the force [length/time^2], for a record of forces 1.
    omega
        Angular frequency [1/time] > 0 of a wave given by its phases; None where `t` are instants.

    Raises
    ------
    ParameterError
        If a value is outside its domain, or the samples are no record.

    Examples
    --------
    >>> ForceRecord((0, 1, 3), (0.0, 2.0, 0.0))
    ForceRecord(t=(0, 1, 3), f=(0.0, 2.0, 0.0), kind='linear', repeat=False, outside='end')
    """

    t: tuple[Phase, ...]
    f: tuple[Exact, ...]
    kind: RecordKind = "linear"
    repeat: bool = False
    outside: Outside = "end"
    amplitude: Exact = 1
    omega: Exact | None = None

    def __post_init__(self) -> None:
        for name in ("t", "f"):
            object.__setattr__(self, name, _samples(getattr(self, name)))
        make_plain(self, "kind", "repeat", "outside")
        make_numbers(self, "amplitude", "omega")
        raise_first(faults(self))

    def __repr__(self) -> str:
        if len(self.t) <= 2 * MOST_TOLD:
            samples = f"t={self.t!r}, f={self.f!r}"
        else:
            samples = f"<{len(self.t)} samples from {self.t[0]!r} to {self.t[-1]!r}>"
        wave = "" if self.amplitude == 1 else f", amplitude={self.amplitude!r}"
        if self.omega is not None:
            wave += f", omega={self.omega!r}"
        return (
            f"ForceRecord({samples}, kind={self.kind!r}, repeat={self.repeat!r}, "
            f"outside={self.outside!r}{wave})"
        )

    def _key(self) -> tuple[object, ...]:
        """Return the fields of a record besides its samples."""
        return self.kind, self.repeat, self.outside, self.amplitude, self.omega

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, ForceRecord) or self._key() != other._key():
            return False
        # Of one tuple the samples need not be compared.
        return self.t == other.t and self.f == other.f

    def __hash__(self) -> int:
        # Each call that looks for the law of a system asks for it.
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self._samples_hash, *self._key()))

    @cached_property
    def _samples_hash(self) -> int:
        return hash((self.t, self.f))

    @cached_property
    def has_good_samples(self) -> bool:
        """Whether the samples make a record."""
        return not _sample_faults(self, "")

    @cached_property
    def exact_samples(self) -> tuple[tuple[Ratio, Ratio], ...]:
        """Instants, or phases, and forces as numerators and denominators."""
        return tuple(
            (
                t.as_integer_ratio() if type(t) is float else rational(t).as_integer_ratio(),
                f.as_integer_ratio() if type(f) is float else as_fraction(f).as_integer_ratio(),
            )
            for t, f in zip(self.t, self.f, strict=True)
        )

    def __getstate__(self) -> dict[str, object]:
        """Return the fields: the hash of a text differs from process to process."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def period(self) -> PiTimes | None:
        """The time after which it begins again, exactly; None if it does not."""
        if not self.repeat:
            return None
        first, last = angle(self.t[0]), angle(self.t[-1])
        pace = Fraction(1) if self.omega is None else as_fraction(self.omega)
        return PiTimes((last[0] - first[0]) / pace, (last[1] - first[1]) / pace)

    @cached_property
    def mean(self) -> Fraction:
        """The mean force over the samples [length/time^2], exact."""
        samples = [(Fraction(*t), Fraction(*f)) for t, f in self.exact_samples]
        total = sum(
            ((f if self.kind == "hold" else (f + g) / 2) * (u - t)
             for (t, f), (u, g) in pairwise(samples)),
            Fraction(0),
        )  # fmt: skip
        return as_fraction(self.amplitude) * total / (samples[-1][0] - samples[0][0])

    @property
    def rate(self) -> float:
        """The mean number of samples in a unit of time."""
        length = as_float(self.t[-1]) - as_float(self.t[0])
        pace = 1.0 if self.omega is None else as_float(self.omega)
        return (len(self.t) - 1) * pace / length

    def scaled(self, factor: Exact) -> ForceRecord:
        """Return the record with its amplitude times a factor.

        Examples
        --------
        >>> ForceRecord((0, 1), (0, 2)).scaled("0.5").amplitude
        '0.5'
        """
        amplitude = (
            factor if self.amplitude == 1 else kept(operand(self.amplitude) * operand(factor))
        )
        return self.with_fields(amplitude=amplitude)

    def with_fields(self, **changed: Any) -> ForceRecord:
        """Return the record with other fields; what is known of its samples is kept.

        Raises
        ------
        TypeError
            If there is no such field.
        """
        new = object.__new__(ForceRecord)
        for field in fields(self):
            value = changed.pop(field.name, getattr(self, field.name))
            object.__setattr__(new, field.name, value)
        if changed:
            raise TypeError(f"ForceRecord has no {', '.join(changed)}")
        if new.t is self.t and new.f is self.f:
            known = vars(self)
            vars(new).update({name: known[name] for name in OF_SAMPLES if name in known})
        return new


def _samples(values: object) -> tuple[Any, ...] | object:
    """Return samples as a tuple of Python's numbers, anything that is no sequence unchanged."""
    if getattr(values, "ndim", 1) != 1:
        return values
    if hasattr(values, "tolist"):
        values = values.tolist()
    if isinstance(values, str) or not isinstance(values, Sequence):
        return values
    if all(type(value) is float for value in values):
        return tuple(values)
    return tuple(plain(value) for value in values)


@faults.register
def _(value: ForceRecord, prefix: str | None = None) -> list[Fault]:
    prefix = "forcing.record" if prefix is None else prefix
    problems = []
    for name, allowed in (("kind", get_args(RecordKind)), ("outside", get_args(Outside))):
        chosen = getattr(value, name)
        if chosen not in allowed:
            reason = f'neither "{allowed[0]}" nor "{allowed[1]}"'
            problems.append(Fault(dotted(prefix, name), chosen, reason))
    if not isinstance(value.repeat, bool):
        problems.append(Fault(dotted(prefix, "repeat"), value.repeat, "neither True nor False"))
    amplitude = dotted(prefix, "amplitude")
    problems += number_faults(amplitude, value.amplitude) or scale_faults(
        amplitude, value.amplitude
    )
    if value.omega is not None:
        omega = dotted(prefix, "omega")
        problems += positive_faults(omega, value.omega) or scale_faults(omega, value.omega)
    return problems if value.has_good_samples else problems + _sample_faults(value, prefix)


# A table or a plane of numbers has one column too many.
NO_SEQUENCE = "not a sequence of numbers; give one column"


def _named(samples: object) -> object:
    """Return what was given in place of samples: a table takes more than a line."""
    columns = getattr(samples, "columns", None)
    if columns is not None:
        return f"a table with the columns {', '.join(map(str, columns))}"
    shape = getattr(samples, "shape", None)
    return samples if shape is None else f"an array of shape {shape}"


def _sample_faults(value: ForceRecord, prefix: str) -> list[Fault]:
    """Return what is wrong with the columns, their numbers and the order of the instants."""
    problems: list[Fault] = []
    columns: dict[str, list[float]] = {}
    for name, problem_of in (("t", phase_problem), ("f", number_problem)):
        samples, path = getattr(value, name), dotted(prefix, name)
        if not isinstance(samples, tuple):
            problems.append(Fault(path, _named(samples), NO_SEQUENCE))
            continue
        columns[name] = []
        wrong: list[Fault] = []
        for i, sample in enumerate(samples):
            if type(sample) is float and math.isfinite(sample):
                columns[name].append(sample)
                continue
            problem = problem_of(sample)
            # No order is asked of what is no number.
            columns[name].append(math.nan if problem else as_float(sample))
            if problem is not None and len(wrong) < MOST_TOLD:
                wrong.append(Fault(f"{path}.{i}", sample, problem))
        problems += wrong
    if len(columns) == 2:
        problems += _count_faults(value, prefix)
    return problems + (_order_faults(value, columns, prefix) if "t" in columns else [])


def _count_faults(value: ForceRecord, prefix: str) -> list[Fault]:
    reason = None
    if len(value.t) != len(value.f):
        reason = f"{len(value.t)} instants for {len(value.f)} forces; give one for each"
    elif len(value.t) < 2:
        reason = "a record needs two samples at least"
    return [] if reason is None else [Fault(dotted(prefix, "t"), value.t, reason)]


def _order_faults(value: ForceRecord, columns: dict[str, list[float]], prefix: str) -> list[Fault]:
    """Return the faults of instants that do not increase, and of slopes out of range."""
    problems: list[Fault] = []
    times = columns["t"]
    # A force that is missing is as steep as none.
    forces = [*columns.get("f", ()), *[math.nan] * len(times)]
    if len(times) > 1 and all(after < before for before, after in pairwise(times)):
        reason = "in reverse order; turn both t and f round"
        return [Fault(dotted(prefix, "t"), f"{value.t[0]} to {value.t[-1]}", reason)]
    for i, (before, after) in enumerate(pairwise(times), 1):
        if len(problems) == MOST_TOLD:
            break
        name = dotted(prefix, f"t.{i}")
        if after == before:
            reason = f"the instant of t.{i - 1}, too; give one force for each instant"
            problems.append(Fault(name, value.t[i], reason))
        elif after < before:
            reason = f"before t.{i - 1} = {value.t[i - 1]}; sort the samples by time"
            problems.append(Fault(name, value.t[i], reason))
        elif abs(forces[i] - forces[i - 1]) > STEEPEST * (after - before):
            reason = f"steeper than {STEEPEST:g} from t.{i - 1} on; choose other units"
            problems.append(Fault(name, value.t[i], reason))
    return problems


def refuse_record(
    force: object, answer: str, instead: str = "give harmonics, as fourier does"
) -> None:
    """Raise a ParameterError where an answer is not to be had for a forcing with a record.

    Parameters
    ----------
    force
        The forcing, or None.
    answer
        What is asked for, the subject of the sentence.
    instead
        The advice.
    """
    value = getattr(force, "record", None)
    if value is not None:
        reason = f"{answer} is not to be had under a record; {instead}"
        raise ParameterError("forcing.record", value, reason)
