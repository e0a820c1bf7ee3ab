"""Mean delay of fast flights, order by order in 1 / V: the normal form of the impact map.

Functions are polynomials in eps = 1 / V and z = e^(i phase): dictionaries (power of eps, of z) ->
coefficient, cut off beyond an order.
"""

from __future__ import annotations

from typing import Any

import mpmath as mp

Series = dict[tuple[int, int], Any]


def _add(one: Series, other: Series, factor: Any = 1) -> Series:
    total = dict(one)
    for key, value in other.items():
        total[key] = total.get(key, 0) + factor * value
    return total


def _times(one: Series, factor: Any) -> Series:
    return {key: value * factor for key, value in one.items()}


class NormalForm:
    """The impact map under cos(omega t), without its dependence on the phase."""

    def __init__(self, omega: Any, order: int) -> None:
        self.omega, self.order = omega, order
        self.turn = mp.e ** (1j * omega * mp.pi)
        self.one: Series = {(0, 0): mp.mpc(1)}

    def delays(self) -> list[Any]:
        """Return the coefficients of V^-1, V^-2, ... in the mean delay of a flight."""
        shift, factor = self._flight()
        for order in range(1, self.order + 1):
            shift, factor = self._without_phase(shift, factor, order)
        return [shift.get((n, 0), mp.mpc(0)) / self.omega for n in range(1, self.order + 1)]

    def _multiply(self, one: Series, other: Series) -> Series:
        product: Series = {}
        for (m, j), value in one.items():
            for (n, k), factor in other.items():
                if m + n <= self.order:
                    product[m + n, j + k] = product.get((m + n, j + k), 0) + value * factor
        return product

    def _compose(self, coefficients: list[Any], inner: Series) -> Series:
        total: Series = {}
        power = self.one
        for coefficient in coefficients:
            total = _add(total, power, coefficient)
            power = self._multiply(power, inner)
        return total

    def _exponential(self, rate: Any) -> list[Any]:
        return [rate**n / mp.factorial(n) for n in range(self.order + 1)]

    def _flight(self) -> tuple[Series, Series]:
        """Return the shift of the phase beyond omega pi, and the factor of eps, of one flight."""
        w, gain = self.omega, 1 / (1 - self.omega**2)
        half = mp.mpf(1) / 2
        cosine: Series = {(0, 1): mp.mpc(half), (0, -1): mp.mpc(half)}
        sine: Series = {(0, 1): mp.mpc(0, -half), (0, -1): mp.mpc(0, half)}
        delay: Series = {}
        for _ in range(self.order + 1):
            sin, cos, late_cos, _ = self._at(delay)
            x = _add(_add(late_cos, self._multiply(cosine, cos)), self._multiply(sine, sin), -w)
            aim = _times(self._multiply({(1, 0): mp.mpc(1)}, x), gain)
            delay = _add(delay, _add(aim, sin, -1))
        sin, cos, _, late_sin = self._at(delay)
        v = _add(
            _add(_times(late_sin, w), self._multiply(cosine, sin)), self._multiply(sine, cos), w
        )
        ratio = _add(cos, _times(self._multiply({(1, 0): mp.mpc(1)}, v), gain))
        return _times(delay, w), self._inverse(ratio)

    def _at(self, delay: Series) -> tuple[Series, Series, Series, Series]:
        """Return sin and cos of the delay, cos and sin of the phase at the landing."""
        up = self._compose(self._exponential(1j), delay)
        down = self._compose(self._exponential(-1j), delay)
        late = self._multiply(
            {(0, 1): self.turn}, self._compose(self._exponential(1j * self.omega), delay)
        )
        soon = self._multiply(
            {(0, -1): 1 / self.turn}, self._compose(self._exponential(-1j * self.omega), delay)
        )
        return (
            _times(_add(up, down, -1), mp.mpc(0, -0.5)),
            _times(_add(up, down), mp.mpf("0.5")),
            _times(_add(late, soon), mp.mpf("0.5")),
            _times(_add(late, soon, -1), mp.mpc(0, -0.5)),
        )

    def _inverse(self, series: Series) -> Series:
        signs = [(-1) ** n for n in range(self.order + 1)]
        return self._compose(signs, _add(series, self.one, -1))

    def _moved(self, series: Series, shift: Series, growth: Series) -> Series:
        """Return a series with the phase shifted and eps multiplied by 1 + growth."""
        total: Series = {}
        for (m, j), value in series.items():
            turned = self._compose(self._exponential(1j * j), shift)
            scaled = self._compose([mp.binomial(m, n) for n in range(self.order + 1)], growth)
            term = self._multiply({(m, j): value}, self._multiply(turned, scaled))
            total = _add(total, term)
        return total

    def _without_phase(self, shift: Series, factor: Series, order: int) -> tuple[Series, Series]:
        """Remove what depends on the phase at one order, by a change of both variables."""

        def solved(series: Series) -> Series:
            return {
                (m, j): value / (1 - self.turn**j)
                for (m, j), value in series.items()
                if m == order and j != 0
            }

        def turned(series: Series) -> Series:
            return {(m, j): value * self.turn**j for (m, j), value in series.items()}

        a, b = solved(shift), solved(factor)
        back_a: Series = {}
        back_b: Series = {}
        for _ in range(self.order + 1):
            moved_b = self._moved(b, back_a, back_b)
            back_a = _times(self._moved(a, back_a, back_b), -1)
            back_b = _add(self._inverse(_add(self.one, moved_b)), self.one, -1)
        grown = _add(factor, self.one, -1)
        new_shift = _add(shift, self._moved(turned(a), shift, grown))
        new_factor = self._multiply(factor, _add(self.one, self._moved(turned(b), shift, grown)))
        return (
            _add(self._moved(new_shift, back_a, back_b), back_a),
            self._multiply(self._moved(new_factor, back_a, back_b), _add(self.one, back_b)),
        )
