"""Real and complex balls: proven comparisons, and the exception that ends a proof without one."""

from __future__ import annotations

import copyreg
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, overload

import numpy as np
from flint import acb, arb

from percuss.arrays import Floats
from percuss.certified.numbers import precision, time_ball
from percuss.model.exact import Phase, whole

# Bits to compare and print with: more than any ball has by default.
WIDE = 8192
LOG10_2 = math.log10(2.0)


class OpenGraze(NamedTuple):
    """A graze that is open: between two times of a flight, at a bound, within a clearance.

    The times are floats or exact arbs.
    """

    low: Any
    high: Any
    bound: int
    clearance: float


class Undecided(Exception):  # noqa: N818
    """The balls leave a question open.

    Every step of a proof may raise it, and does where what its name claims is not proven; caught
    inside `percuss.certified`.

    Parameters
    ----------
    kind
        Name of the `Ending` that it leads to if more bits do not help.
    reason
        What is open, in a sentence with its numbers.
    graze
        Where, for a graze in a flight.
    """

    def __init__(self, kind: str, reason: str, graze: OpenGraze | None = None) -> None:
        super().__init__(kind, reason)
        self.kind = kind
        self.reason = reason
        self.graze = graze


@dataclass(frozen=True, slots=True, repr=False)
class Ball:
    """A real number that lies for certain within a radius of a midpoint.

    Attributes
    ----------
    arb
        The ball itself, of python-flint, for further calculations.

    Examples
    --------
    >>> from flint import arb
    >>> ball = Ball(arb(1) / 3)
    >>> ball.mid(), ball.digits() >= 15, ball.contains("1/3")
    (0.3333333333333333, True, True)
    """

    arb: arb

    def mid(self) -> float:
        """Return the midpoint as the nearest float."""
        return float(self.arb.mid())

    def radius(self) -> float:
        """Return a bound of the number's distance from `mid`, whose rounding to a float is in it."""
        if not self.arb.is_finite():
            return math.nan if self.arb.is_nan() else math.inf
        with precision(WIDE):
            distance = (self.arb - arb(self.mid())).abs_upper()
            return 0.0 if distance.is_zero() else float(distance) * (1.0 + 2.0**-50) + 5e-324

    def digits(self) -> float:
        """Return the number of decimal digits that are certain: -log10(radius / midpoint)."""
        return _digits(self.arb)

    def text(self, digits: int = 20) -> str:
        """Return the decimals that are certain, ``digits`` >= 1 of them at most, and the error."""
        return str(self.arb.str(whole("digits", digits, 1)))

    def decimals(self, digits: int) -> tuple[str, str]:
        """Return a decimal and a radius around it that hold the number, both as text.

        Parameters
        ----------
        digits
            Significant digits of the decimal, >= 1, which may be more than are certain.

        Returns
        -------
        tuple of str
            The midpoint, and an upper bound of the number's distance from this decimal; of any
            size, also where a float would be 0. Without a number, "nan" and "inf".

        Examples
        --------
        >>> from flint import arb
        >>> Ball(arb(2).sqrt()).decimals(6)
        ('1.41421', '3.60e-6')
        """
        digits = whole("digits", digits, 1)
        if not self.arb.is_finite():
            return "nan", "inf"
        text = str(self.arb.mid().str(digits, radius=False, more=True))
        with precision(WIDE):
            return text, upwards((self.arb - arb(text)).abs_upper())

    def contains(self, value: Phase) -> bool:
        """Return whether an exact number, as ``"1/3"`` or ``"20*pi"``, lies in the ball, for certain.

        It can then be the number that the ball encloses; that it is this number no ball can prove.
        """
        with precision(WIDE):
            return bool(self.arb.contains(time_ball(value)))

    def may_contain(self, value: Phase) -> bool:
        """Return whether an exact number may lie in the ball: if False, it is not the number.

        It differs from `contains` at the very ends of the ball only.

        Examples
        --------
        >>> from flint import arb
        >>> Ball(arb(1) / 3).may_contain("1/3"), Ball(arb(1) / 3).may_contain("0.3333")
        (True, False)
        """
        with precision(WIDE):
            return bool(self.arb.overlaps(time_ball(value)))

    def overlaps(self, other: Ball) -> bool:
        """Return whether two balls may enclose the same number: if False, the numbers differ."""
        return bool(self.arb.overlaps(other.arb))

    def __float__(self) -> float:
        return self.mid()

    def __repr__(self) -> str:
        """Return the certain digits and the error."""
        return f"<Ball {self.text()}>"


@dataclass(frozen=True, slots=True, repr=False)
class Balls:
    """A column of balls.

    Attributes
    ----------
    arbs
        The balls of python-flint.
    shape
        Shape of the arrays that `mid` and `radius` return.

    Examples
    --------
    >>> from flint import arb
    >>> column = Balls((arb(1), arb(2).sqrt()))
    >>> column.mid()
    array([1.        , 1.41421356])
    >>> bool((column.radius() < 1e-15).all()), column[0].contains(1)
    (True, True)
    """

    arbs: tuple[arb, ...]
    shape: tuple[int, ...] | None = None

    @classmethod
    def of(cls, balls: Iterable[arb], shape: tuple[int, ...] | None = None) -> Balls:
        """Make a column."""
        return cls(tuple(balls), shape)

    def mid(self) -> Floats:
        """Return the midpoints as the nearest floats."""
        return self._array(float(ball.mid()) for ball in self.arbs)

    def radius(self) -> Floats:
        """Return bounds of the distances from `mid`, whose rounding to floats is in them."""
        return self._array(Ball(ball).radius() for ball in self.arbs)

    def digits(self) -> Floats:
        """Return the number of decimal digits of each ball."""
        return self._array(_digits(ball) for ball in self.arbs)

    def _array(self, values: Iterable[float]) -> Floats:
        array = np.array(list(values), dtype=np.float64)
        return array if self.shape is None else array.reshape(self.shape)

    def __len__(self) -> int:
        """Return the number of balls."""
        return len(self.arbs)

    @overload
    def __getitem__(self, index: int) -> Ball: ...

    @overload
    def __getitem__(self, index: slice) -> Balls: ...

    def __getitem__(self, index: int | slice) -> Ball | Balls:
        """Return one ball, or a part of the column."""
        if isinstance(index, slice):
            return Balls(self.arbs[index])
        return Ball(self.arbs[index])

    def __iter__(self) -> Iterator[Ball]:
        """Iterate over the balls."""
        return (Ball(ball) for ball in self.arbs)

    def __repr__(self) -> str:
        """Return the number of balls and their fewest digits."""
        if not self.arbs:
            return "<Balls: 0>"
        return f"<Balls: {len(self)}, {self.digits().min():.3g} digits or more>"


@dataclass(frozen=True, slots=True, repr=False)
class ComplexBall:
    """A complex number that lies in a rectangle for certain.

    Attributes
    ----------
    acb
        The rectangle, of python-flint.
    """

    acb: acb

    @property
    def real(self) -> Ball:
        """The real part."""
        return Ball(self.acb.real)

    @property
    def imag(self) -> Ball:
        """The imaginary part."""
        return Ball(self.acb.imag)

    def mid(self) -> complex:
        """Return the midpoint as floats."""
        return complex(self.real.mid(), self.imag.mid())

    def radius(self) -> float:
        """Return a bound of the number's distance from `mid`."""
        return math.hypot(self.real.radius(), self.imag.radius()) * (1.0 + 1e-15)

    def __repr__(self) -> str:
        """Return the certain digits and the error of both parts."""
        return f"<ComplexBall {self.real.text(12)} + {self.imag.text(12)} i>"


def upwards(radius: arb, digits: int = 3) -> str:
    """Return an exact radius as a decimal that is not less."""
    if radius.is_zero():
        return "0"
    with precision(64):
        # Rounding to so few digits takes off half a unit of the last one at most.
        return str((radius * (1 + arb(10) ** (1 - digits))).mid().str(digits, radius=False))


def _digits(ball: arb) -> float:
    if not ball.is_finite():
        return -math.inf
    radius = ball.rad()
    if radius.is_zero():
        return math.inf
    size = abs(ball.mid())
    if size.is_zero():
        return -math.inf
    with precision(64):
        return float((size / radius).log()) * LOG10_2 / math.log(2.0)


def _parts(value: arb) -> tuple[int, int]:
    mantissa, exponent = value.man_exp()
    return int(mantissa), int(exponent)


def _reduced(value: arb) -> tuple[object, tuple[object, ...]]:
    """Return what pickles a ball: its midpoint exactly, its radius rounded up to 30 bits."""
    if value.is_finite():
        return arb, (_parts(value.mid()), _parts(value.rad()))
    if value == arb.pos_inf() or value == arb.neg_inf():
        return arb, ("inf" if value > 0 else "-inf",)
    return arb, ("nan",) if value.is_nan() else (0, "inf")


# python-flint itself has no way to pickle or copy its balls.
copyreg.pickle(arb, _reduced)  # type: ignore[arg-type]
copyreg.pickle(acb, lambda value: (acb, (value.real, value.imag)))
