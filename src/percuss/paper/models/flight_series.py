"""Fast flights between elastic impacts as exact series in the inverse of their speed.

Under cos(omega t + phase) with rational omega all coefficients lie in a cyclotomic field, at
omega = 1 with powers of pi: no number is rounded.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from flint import fmpq, fmpq_poly, fmpz_poly

from percuss import numerics
from percuss.paper.models.averaging import order

# Powers of 1/V at the start, of exp(i phase) and of pi, to a number of the cyclotomic field.
Key = tuple[int, int, int]


@dataclass(frozen=True)
class EnergyGain:
    """The energy gained in q flights, at leading order in 1/V.

    Parameters
    ----------
    power
        Of 1/V in the leading term.
    waves
        The powers of exp(i phase) in its coefficient.
    size
        Of sin(q phase) in it, up to the sign.
    """

    power: int
    waves: tuple[int, ...]
    size: float


class _Field:
    """Series up to a power of 1/V, with coefficients in the field of a root of unity."""

    def __init__(self, roots: int, highest: int) -> None:
        self.roots, self.highest = roots, highest
        self.modulus = fmpq_poly(fmpz_poly.cyclotomic(roots))

    def root(self, turn: Fraction) -> fmpq_poly:
        """Return exp(2 pi i turn)."""
        step = turn * self.roots % self.roots
        return fmpq_poly([0] * int(step) + [1]) % self.modulus

    def term(self, number: Fraction | fmpq_poly, key: Key = (0, 0, 0)) -> dict[Key, fmpq_poly]:
        if isinstance(number, Fraction):
            number = fmpq_poly([fmpq(number.numerator, number.denominator)])
        return {key: number % self.modulus}

    def add(self, *series: dict[Key, fmpq_poly]) -> dict[Key, fmpq_poly]:
        total: dict[Key, fmpq_poly] = defaultdict(fmpq_poly)
        for one in series:
            for key, number in one.items():
                total[key] += number
        return {key: number for key, number in total.items() if number.degree() >= 0}

    def times(self, one: dict[Key, fmpq_poly], other: dict[Key, fmpq_poly]) -> dict[Key, fmpq_poly]:
        total: dict[Key, fmpq_poly] = defaultdict(fmpq_poly)
        for (e, z, p), a in one.items():
            for (f, y, r), b in other.items():
                if e + f <= self.highest:
                    total[e + f, z + y, p + r] += a * b
        reduced = {key: number % self.modulus for key, number in total.items()}
        return {key: number for key, number in reduced.items() if number.degree() >= 0}

    def scaled(self, factor: Fraction, one: dict[Key, fmpq_poly]) -> dict[Key, fmpq_poly]:
        return self.times(self.term(factor), one)

    def exponential(self, small: dict[Key, fmpq_poly]) -> dict[Key, fmpq_poly]:
        """Return exp of a series without a term of power 0."""
        power = total = self.term(Fraction(1))
        for k in range(1, self.highest + 1):
            power = self.scaled(Fraction(1, k), self.times(power, small))
            total = self.add(total, power)
        return total

    def cosine_sine(
        self, wave: dict[Key, fmpq_poly], back: dict[Key, fmpq_poly]
    ) -> tuple[dict[Key, fmpq_poly], dict[Key, fmpq_poly]]:
        """Return cosine and sine from exp(i a) and exp(-i a)."""
        minus_i = self.root(Fraction(3, 4))
        half = Fraction(1, 2)
        difference = self.add(wave, self.scaled(Fraction(-1), back))
        return (
            self.scaled(half, self.add(wave, back)),
            self.scaled(half, self.times(self.term(minus_i), difference)),
        )


class _Motion:
    """A motion from the speed V and any phase, flight by flight; e = 1/V."""

    def __init__(self, omega: Fraction, flights: int) -> None:
        turn = omega / 2
        self.omega = omega
        self.field = _Field(math.lcm(4, turn.denominator), flights)
        self.turn = turn
        self.drift: dict[Key, fmpq_poly] = {}
        # Over V.
        self.speed = self.field.term(Fraction(1))
        self.count = 0

    def wave(self, turns: int, more: dict[Key, fmpq_poly]) -> tuple[dict[Key, fmpq_poly], ...]:
        """Return cosine and sine of the phase after some half turns and a delay."""
        field = self.field
        sides = []
        for sign in (1, -1):
            angle = field.scaled(sign * self.omega, field.add(self.drift, more))
            small = field.times(field.term(field.root(Fraction(1, 4))), angle)
            start = field.term(field.root(sign * turns * self.turn), (0, sign, 0))
            sides.append(field.times(start, field.exponential(small)))
        return field.cosine_sine(sides[0], sides[1])

    def parts(self, delay: dict[Key, fmpq_poly]) -> tuple[dict[Key, fmpq_poly], ...]:
        """Return what multiplies sin(delay) and -1 at the wall, and the speed after the impact.

        All of it is multiplied by e.
        """
        field, omega = self.field, self.omega
        e = field.term(Fraction(1), (1, 0, 0))
        (c0, s0), (c1, s1) = self.wave(self.count, {}), self.wave(self.count + 1, delay)
        i_delay = field.times(field.term(field.root(Fraction(1, 4))), delay)
        cos_d, sin_d = field.cosine_sine(
            field.exponential(i_delay), field.exponential(field.scaled(Fraction(-1), i_delay))
        )
        if omega == 1:
            # x = V sin s + (s sin(phase + s) - sin(phase) sin s)/2.
            half = Fraction(1, 2)
            lasting = field.add(field.term(Fraction(1), (0, 0, 1)), delay)
            steep = field.add(self.speed, field.scaled(-half, field.times(e, s0)))
            push = field.scaled(half, field.times(e, field.times(lasting, s1)))
            wave = field.add(s1, field.times(lasting, c1))
            after = field.add(field.times(steep, cos_d), field.scaled(-half, field.times(e, wave)))
            return steep, push, after, sin_d
        p = 1 / (1 - omega * omega)
        steep = field.add(self.speed, field.scaled(p * omega, field.times(e, s0)))
        push = field.scaled(p, field.times(e, field.add(field.times(c0, cos_d), c1)))
        wave = field.add(field.times(c0, sin_d), field.scaled(omega, s1))
        after = field.add(field.times(steep, cos_d), field.scaled(p, field.times(e, wave)))
        return steep, push, after, sin_d

    def fly(self) -> None:
        """Follow one flight: its delay against pi is found power by power."""
        field = self.field
        delay: dict[Key, fmpq_poly] = {}
        for _ in range(field.highest + 1):
            steep, push, after, sin_d = self.parts(delay)
            left = field.add(push, field.scaled(Fraction(-1), field.times(steep, sin_d)))
            if not left:
                break
            delay = field.add(delay, left)
        self.drift = field.add(self.drift, delay)
        self.speed, self.count = after, self.count + 1


@cache
def energy_gain(omega: Fraction, power: int | None = None) -> EnergyGain:
    """Return the leading term of the energy gained in q flights at omega = 2 p / q.

    Parameters
    ----------
    omega
        The frequency of the force cos(omega t + phase).
    power
        Up to which power of 1/V the series is followed; default: q - 2.

    Returns
    -------
    EnergyGain
        Of the first power of 1/V whose coefficient is not zero; its waves are empty if all are.

    Examples
    --------
    >>> gain = energy_gain(Fraction(2, 3))
    >>> gain.power, gain.waves
    (1, (-3, 3))
    """
    _, q = order(omega)
    highest = q - 2 if power is None else power
    motion = _Motion(omega, highest + 2)
    for _ in range(q):
        motion.fly()
    field = motion.field
    square = field.add(field.times(motion.speed, motion.speed), field.term(Fraction(-1)))
    # The energy is V^2 times half of that.
    least = min((key[0] for key in square), default=highest + 3)
    leading = {key: number for key, number in square.items() if key[0] == least}
    waves = tuple(sorted({key[1] for key in leading}))
    size = 0.0
    for (_, z, p), number in leading.items():
        if z == q:
            # Of a sine: the coefficient of exp(i q phase) is imaginary.
            size += math.prod([math.pi] * p) * _imaginary(number, field.roots)
    return EnergyGain(least - 2, waves, abs(size))


def _imaginary(number: fmpq_poly, roots: int) -> float:
    return sum(
        int(c.p) / int(c.q) * numerics.sin(2.0 * math.pi * k / roots)
        for k, c in enumerate(number.coeffs())
    )
