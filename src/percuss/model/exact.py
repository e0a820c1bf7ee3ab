"""Exact numbers: what the user gave, before any rounding.

A float means that double exactly, a decimal string or a ``Decimal`` that decimal, and
multiples of pi are kept as such, so that nothing is rounded before the equation is set up.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from numbers import Rational
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypeVar, cast

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels import law_formulas
from percuss.kernels.arithmetic import LARGEST_ANGLE
from percuss.model.ratios import PI, exact, ratio_of
from percuss.numerics import cosine_sine

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Read = TypeVar("Read")


class Scalar(Protocol):
    """A scalar of NumPy, or an array without dimensions."""

    def __float__(self) -> float: ...

    def item(self) -> Any:
        """Return it as a Python number."""


class Computed:
    """A number that follows from others: an `percuss.model.expression.Expression`.

    All that this module does with numbers it does with these, too.
    """

    __slots__ = ()

    def problem(self) -> str | None:
        """Return why it is no finite number, None if it is one."""
        raise NotImplementedError

    def angle(self) -> tuple[Fraction, Fraction]:
        """Return ``(times, plus)`` of the value times * pi + plus, rounded where irrational."""
        raise NotImplementedError

    def sqrt(self) -> Computed:
        """Return the square root."""
        raise NotImplementedError

    def __add__(self, other: object) -> Computed:
        raise NotImplementedError

    __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __add__
    __truediv__ = __rtruediv__ = __pow__ = __add__

    def __neg__(self) -> Computed:
        raise NotImplementedError

    def __float__(self) -> float:
        return as_float(self)


Exact: TypeAlias = int | float | Fraction | Decimal | str | Scalar | Computed

_LARGEST_REDUCED = 10**40
# Kernels count in integers of 64 bits.
MOST_COUNTED = 2**63 - 1
# A table has fewer rows than memory has numbers.
MOST_ROWS = 10**9
# cos(pi q) where it is rational, for q in [0, 2); there are no others (Niven's theorem).
COSINES = {
    Fraction(0): Fraction(1),
    Fraction(1, 3): Fraction(1, 2),
    Fraction(1, 2): Fraction(0),
    Fraction(2, 3): Fraction(-1, 2),
    Fraction(1): Fraction(-1),
    Fraction(4, 3): Fraction(-1, 2),
    Fraction(3, 2): Fraction(0),
    Fraction(5, 3): Fraction(1, 2),
}

_DECIMAL_TEXT = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,6})?"
_QUOTIENT_TEXT = r"[+-]?\d+/\d+"
_DECIMAL = re.compile(_DECIMAL_TEXT, re.ASCII)
_QUOTIENT = re.compile(_QUOTIENT_TEXT, re.ASCII)
_PI_TEXT = re.compile(
    rf"(?:(?P<plus>{_QUOTIENT_TEXT}|{_DECIMAL_TEXT})(?=[+-]))?"
    r"(?P<sign>[+-]?)(?:(?P<times>\d+(?:\.\d+|/\d+)?)\*?)?pi(?:/(?P<over>\d+))?",
    re.ASCII,
)
_SPACES = re.compile(r"\s*([-+*/])\s*|(?<=\d)\s+(?=pi)", re.ASCII)
_NOT_FINITE_TEXTS = frozenset({"nan", "inf", "infinity"})
# A longer text is no physical parameter, and its conversion takes quadratic time.
_LONGEST_TEXT = 1000

NOT_A_NUMBER = (
    'not a number; give an int, float, Fraction, Decimal or a text such as "2.8" or "1/3"'
)
NOT_A_PHASE = f'{NOT_A_NUMBER}, or a multiple of pi such as "pi/2" or pi_times(1, 2)'
NOT_FINITE = "not finite"
DIVISION_BY_ZERO = "a division by zero"
OUT_OF_RANGE = "beyond the range of floats, 5e-324 to 1.8e308"


@dataclass(frozen=True, slots=True, repr=False)
class PiTimes:
    """The number ``times * pi + plus``, exactly.

    Made by `pi_times`; it can be multiplied by numbers, and these added and subtracted.

    Parameters
    ----------
    times
        Multiple of pi.
    plus
        Rational part.

    Examples
    --------
    >>> pi_times(1, 2) + "0.25"
    pi_times(1, 2) + 0.25
    >>> 3 * pi_times(1, 2)
    pi_times(3, 2)
    """

    times: Fraction
    plus: Fraction = Fraction(0)

    def __add__(self, other: Phase) -> PiTimes:
        if isinstance(other, Computed):
            return NotImplemented
        times, plus = angle(other)
        return PiTimes(self.times + times, self.plus + plus)

    def __mul__(self, factor: Exact) -> Any:
        if isinstance(factor, Computed | PiTimes):
            return NotImplemented
        by = as_fraction(factor)
        return PiTimes(by * self.times, by * self.plus)

    __rmul__ = __mul__

    def __neg__(self) -> PiTimes:
        return PiTimes(-self.times, -self.plus)

    def __sub__(self, other: Phase) -> PiTimes:
        if isinstance(other, Computed):
            return NotImplemented
        times, plus = angle(other)
        return PiTimes(self.times - times, self.plus - plus)

    __radd__ = __add__

    def __rsub__(self, other: Phase) -> PiTimes:
        return -self + other

    def __float__(self) -> float:
        return float(self.times * PI + self.plus)

    def __repr__(self) -> str:
        p, q = self.times.numerator, self.times.denominator
        text = f"pi_times({p})" if q == 1 else f"pi_times({p}, {q})"
        return f"{text} + {kept(self.plus)!r}" if self.plus else text

    def __str__(self) -> str:
        """Return the text that a phase of the same value can be given as."""
        if not self.times:
            return str(self.plus)
        plus = f"{self.plus} + " if self.plus else ""
        return f"{plus}{self.times}*pi".replace("+ -", "- ")


Phase: TypeAlias = Exact | PiTimes


def pi_times(p: Exact, q: Exact = 1) -> PiTimes:
    """Return the exact number pi p/q, for a phase, a period or a time.

    Parameters
    ----------
    p
        Numerator, any number.
    q
        Denominator, not 0.

    Returns
    -------
    PiTimes
        The exact multiple of pi.

    Raises
    ------
    ParameterError
        If p or q is not a finite number, or q is 0.

    Examples
    --------
    >>> pi_times(-1, 2)
    pi_times(-1, 2)
    >>> as_float(pi_times(2))
    6.283185307179586
    """
    denominator = as_fraction(q)
    if denominator == 0:
        raise ParameterError("q", q, "zero; pi p/q needs a denominator")
    return PiTimes(as_fraction(p) / denominator)


def plain(value: object) -> object:
    """Return any scalar as a Python value of the same number, anything else unchanged.

    Scalars are those of NumPy, arrays without dimensions (also of xarray and others), subclasses
    of Python's numbers, and whatever is registered as a rational or has ``as_integer_ratio``.

    Parameters
    ----------
    value
        Anything.

    Returns
    -------
    object
        An int, float, Fraction, Decimal, str or `PiTimes` where the value is a scalar.

    Examples
    --------
    >>> import numpy as np
    >>> plain(np.array(0.25)), plain(np.float32(0.1)), plain(np.int64(3))
    (0.25, 0.10000000149011612, 3)
    """
    if type(value) in _PLAIN_TYPES or value is None or isinstance(value, bool):
        return value
    # Recognised without importing NumPy. The item of an instant or a duration is a bare count of
    # its units, and that of a masked value is 0.
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        kind = getattr(getattr(value, "dtype", None), "kind", "")
        if kind in _NO_NUMBERS or getattr(value, "mask", False):
            return value
        return _from_library(value.item())
    for base in (int, float, str):
        if isinstance(value, base):
            return base(value)
    return _from_library(value)


def _from_library(value: object) -> object:
    """Return a number of another library as Python's own; anything else unchanged."""
    if type(value) in _PLAIN_TYPES or isinstance(value, bool | Decimal | Fraction):
        return value
    if isinstance(value, Rational):
        quotient = Fraction(int(value.numerator), int(value.denominator))
        return quotient.numerator if quotient.denominator == 1 else quotient
    # A long double, which is its own item.
    if hasattr(value, "as_integer_ratio"):
        try:
            return kept(Fraction(*map(int, value.as_integer_ratio())))
        except (OverflowError, ValueError):
            return math.nan
    return value


# NumPy's kinds of durations and of instants.
_NO_NUMBERS = ("m", "M")
_PLAIN_TYPES = frozenset({int, float, Fraction, Decimal, str, PiTimes})


def whole(name: str, value: object, least: int, most: float = MOST_COUNTED) -> int:
    """Return a whole number, NumPy's and 4.0 too, as Python's own.

    A ParameterError with this name is raised where the value is no whole number from ``least`` to
    ``most``, by default as far as kernels count.

    Examples
    --------
    >>> import numpy as np
    >>> whole("periods", np.int64(3), 1)
    3
    """
    number = plain(value)
    if isinstance(number, (float, Fraction)) and number % 1 == 0:
        number = int(number)
    is_whole = isinstance(number, int) and not isinstance(number, bool)
    if is_whole and least <= cast("int", number) <= most:
        return cast("int", number)
    # An end that only a machine has is named where it is passed.
    is_limited = most < MOST_ROWS or (is_whole and cast("int", number) > most)
    limits = f"from {least} to {most}" if is_limited else f"of at least {least}"
    raise ParameterError(name, number, f"not a whole number {limits}")


def real(name: str, value: Phase) -> float:
    """Return any number, or a phase, as the nearest double; `as_float` with the name in its error.

    Raises
    ------
    ParameterError
        If the value is not a finite number.
    """
    try:
        return as_float(value)
    except ParameterError as error:
        raise ParameterError(name, value, error.reason) from None


def reals(name: str, values: ArrayLike) -> Floats:
    """Return numbers of any shape as doubles; exact ones and texts are rounded one by one.

    Raises
    ------
    ParameterError
        If a value is no number. NaN and infinities are left to the caller.
    """
    import numpy as np  # half of the time of an import that needs no arrays

    try:
        given = np.asarray(values)
    except ValueError:
        raise ParameterError(name, values, "rows of different lengths; give an array") from None
    if given.dtype.kind in "iuf":
        return given.astype(np.float64, copy=False)
    items = [real(name, item) for item in given.ravel().tolist()]
    return np.array(items, dtype=np.float64).reshape(given.shape)


def number_problem(value: object) -> str | None:
    """Return why a plain value is no finite real number, None if it is one."""
    if isinstance(value, float):
        return None if math.isfinite(value) else NOT_FINITE
    if isinstance(value, bool) or not isinstance(value, int | Fraction | Decimal | str):
        return value.problem() if isinstance(value, Computed) else NOT_A_NUMBER
    if isinstance(value, str):
        return _text_problem(value)
    if isinstance(value, Decimal):
        return _decimal_problem(value)
    return range_problem(value)


def _text_problem(text: str) -> str | None:
    if len(text) > _LONGEST_TEXT:
        return NOT_A_NUMBER
    bare = _without_spaces(text)
    if _DECIMAL.fullmatch(bare):
        return _decimal_problem(Decimal(bare))
    if _QUOTIENT.fullmatch(bare):
        numerator, denominator = (int(part) for part in bare.split("/"))
        if denominator == 0:
            return DIVISION_BY_ZERO
        return range_problem(Fraction(numerator, denominator))
    return NOT_FINITE if bare.lower().lstrip("+-") in _NOT_FINITE_TEXTS else NOT_A_NUMBER


def _without_spaces(text: str) -> str:
    """Return a text without the spaces around it and around its signs of operation."""
    return _SPACES.sub(r"\1", text.strip())


def _decimal_problem(value: Decimal) -> str | None:
    if not value.is_finite():
        return NOT_FINITE
    # Checked on the exponent: the fraction of 1e999999 would have a million digits.
    number = float(value)
    return OUT_OF_RANGE if math.isinf(number) or (number == 0.0 and value != 0) else None


def range_problem(value: int | Fraction) -> str | None:
    """Return why a number is beyond the range of floats, None if it is not."""
    try:
        number = float(value)
    except OverflowError:
        return OUT_OF_RANGE
    return OUT_OF_RANGE if number == 0.0 and value != 0 else None


def phase_problem(value: object) -> str | None:
    """Return why a plain value is no phase, None if it is one."""
    try:
        multiple = value if isinstance(value, PiTimes) else _multiple_in_text(value)
    except ZeroDivisionError:
        return DIVISION_BY_ZERO
    if multiple is None:
        problem = number_problem(value)
        return NOT_A_PHASE if problem == NOT_A_NUMBER else problem
    times, plus = multiple.times, multiple.plus
    problem = range_problem(times) or range_problem(plus)
    # Two floats, but with pi, which is below 4, their sum may be none.
    is_in_range = problem is not None or math.isfinite(4.0 * float(times) + float(plus))
    return problem if is_in_range else OUT_OF_RANGE


def _multiple_in_text(value: object) -> PiTimes | None:
    if not isinstance(value, str) or "pi" not in value or len(value) > _LONGEST_TEXT:
        return None
    match = _PI_TEXT.fullmatch(_without_spaces(value))
    if match is None:
        return None
    times = Fraction(match["times"] or 1) / int(match["over"] or 1)
    plus = match["plus"]
    if plus is not None and number_problem(plus) is not None:
        return None
    return PiTimes(-times if match["sign"] == "-" else times, Fraction(plus or 0))


def as_fraction(value: Exact) -> Fraction:
    """Return a number as the exact fraction it means.

    Parameters
    ----------
    value
        A float means that double exactly, a decimal string that decimal.

    Returns
    -------
    Fraction
        The exact value; that of an irrational expression within 2^-256 of its size.

    Raises
    ------
    ParameterError
        If the value is not a finite number.

    Examples
    --------
    >>> as_fraction("2.8")
    Fraction(14, 5)
    >>> as_fraction(0.5)
    Fraction(1, 2)
    """
    if type(value) is float and math.isfinite(value):
        return Fraction(value)
    number = plain(value)
    problem = number_problem(number)
    if problem is not None:
        raise ParameterError("value", value, problem)
    if isinstance(number, str):
        number = _without_spaces(number)
    elif isinstance(number, Computed):
        times, plus = number.angle()
        return times * PI + plus if times else plus
    return Fraction(cast("int | float | Fraction | Decimal | str", number))


def two_of(read: Callable[[Any], Read], name: str, given: object, reason: str) -> tuple[Read, Read]:
    """Return two numbers, each read by `as_float` or another, or raise a ParameterError."""
    try:
        first, second = (read(value) for value in given)  # type: ignore[attr-defined]  # else raised
    except (TypeError, ValueError) as error:
        raise ParameterError(name, given, reason) from error
    return first, second


def as_float(value: Phase) -> float:
    """Return a number, or a phase, as the nearest double.

    Parameters
    ----------
    value
        Anything a physical parameter takes, or a multiple of pi.

    Returns
    -------
    float
        The value, correctly rounded.

    Raises
    ------
    ParameterError
        If the value is not a finite number.

    Examples
    --------
    >>> as_float("2.8"), as_float(pi_times(1, 2))
    (2.8, 1.5707963267948966)
    """
    if type(value) is float and math.isfinite(value):
        return value
    if type(value) is int and value.bit_length() <= sys.float_info.mant_dig:
        return float(value)
    return _nearest(value) if isinstance(value, PiTimes | str) else _rounded(value)


def rational(value: Phase) -> Fraction:
    """Return a number exactly, a multiple of pi with `PI` for pi."""
    times, plus = angle(value)
    return times * PI + plus if times else plus


def _rounded(value: Phase) -> float:
    return float(rational(value))


# Ends of runs, phases of knots and levels of stops are asked for again and again.
_nearest = lru_cache(256)(_rounded)


def angle(value: Phase) -> tuple[Fraction, Fraction]:
    """Return ``(times, plus)`` such that the value is exactly ``times * pi + plus``.

    Examples
    --------
    >>> angle("-3*pi/4")
    (Fraction(-3, 4), Fraction(0, 1))
    """
    number = plain(value)
    problem = phase_problem(number)
    if problem is not None:
        raise ParameterError("value", value, problem)
    if isinstance(number, Computed):
        return number.angle()
    multiple = number if isinstance(number, PiTimes) else _multiple_in_text(number)
    if multiple is not None:
        return multiple.times, multiple.plus
    return Fraction(0), as_fraction(cast("Exact", number))


def cos_sin(phase: Phase) -> tuple[float, float]:
    """Return the cosine and the sine of a phase, exact at multiples of pi/2 and pi/6.

    Parameters
    ----------
    phase
        The phase [rad].

    Returns
    -------
    tuple of float
        Cosine and sine.

    Examples
    --------
    >>> cos_sin(pi_times(-1, 2))
    (0.0, -1.0)
    >>> cos_sin("pi/3")[0]
    0.5
    """
    if type(phase) is float and abs(phase) < LARGEST_ANGLE:
        return cosine_sine(phase)
    times, plus = angle(phase)
    if times == 0 and abs(plus) > _LARGEST_REDUCED:
        return cosine_sine(float(plus))
    cosine, sine = _phasor(ratio_of(times), ratio_of(plus))
    return cosine, sine


_phasor = exact(law_formulas.phasor)


def rational_cosine(times: Fraction, plus: Fraction) -> Fraction | None:
    """Return the cosine of ``times * pi + plus`` where it is rational, else None.

    Examples
    --------
    >>> rational_cosine(Fraction(7, 3), Fraction(0)), rational_cosine(Fraction(1, 4), Fraction(0))
    (Fraction(1, 2), None)
    """
    return COSINES.get(times % 2) if plus == 0 else None


def computed_in(*values: object) -> Iterator[Computed]:
    """Yield the numbers in parts of a model that follow from others."""
    for value in values:
        if type(value) in _PLAIN_TYPES or value is None:
            continue
        if isinstance(value, Computed):
            yield value
        elif isinstance(value, tuple):
            yield from computed_in(*value)
        elif hasattr(value, "__dataclass_fields__"):
            yield from computed_in(*(getattr(value, name) for name in value.__dataclass_fields__))


def operand(value: Exact) -> Any:
    """Return a number for exact arithmetic: as a fraction, or the expression that it is."""
    return value if isinstance(value, Computed) else as_fraction(value)


def kept(value: Any) -> Any:
    """Return a result of exact arithmetic as a float where that is exact, else as it is."""
    if isinstance(value, Computed):
        return value
    if range_problem(value) is not None:
        return value
    number = float(value)
    return number if number.as_integer_ratio() == value.as_integer_ratio() else value


def scaled(value: Exact, factor: Any) -> Any:
    """Return the exact product of a kept number and a factor."""
    if isinstance(factor, Computed):
        if not isinstance(value, Computed) and as_fraction(value) == 0:
            return value
        # With the number as it was written.
        return plain(value) * factor
    return kept(operand(value) * factor)


def rational_root(value: Fraction) -> Fraction | None:
    """Return the square root of a fraction >= 0 where it is rational, else None."""
    p, q = math.isqrt(value.numerator), math.isqrt(value.denominator)
    is_root = p * p == value.numerator and q * q == value.denominator
    return Fraction(p, q) if is_root else None


def square_root(value: Any) -> Any:
    """Return the square root of a fraction, exact where it is rational, else correctly rounded.

    That of an expression is an expression.

    Examples
    --------
    >>> square_root(Fraction(4, 9))
    Fraction(2, 3)
    >>> square_root(Fraction(2))
    1.4142135623730951
    """
    if isinstance(value, Computed):
        return value.sqrt()
    rational = rational_root(value)
    if rational is not None:
        return kept(rational)
    # An integer root with more than 80 significant bits decides the rounding to 53.
    shift = max(0, 80 + (value.denominator.bit_length() - value.numerator.bit_length()) // 2)
    root = math.isqrt((value.numerator << (2 * shift)) // value.denominator)
    return float(Fraction(root, 1 << shift))
