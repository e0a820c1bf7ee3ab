"""Where the first root is claimed to be, at the ends of the stretches that are tested."""

from __future__ import annotations

import math

import pytest
from flint import arb

from percuss.certified.first_root import FloatStretch, Level, Search
from percuss.certified.numbers import precision


class Line:
    """The curve root - s."""

    longest = math.inf

    def __init__(self, root: arb) -> None:
        self.root = root

    def derivatives(self, s: arb, n: int) -> tuple[list[arb], float]:
        return [self.root - s, arb(-1), *(arb(0) for _ in range(n - 1))], 0.0

    def bound(self, n: int, s: float, h: float, size: float) -> float:  # noqa: ARG002
        return 0.0

    def taylor(self, n: int) -> list[arb]:
        return self.derivatives(arb(0), n)[0]

    def size_at_start(self, n: int) -> float:  # noqa: ARG002
        return 0.0


@pytest.mark.parametrize("part", [0.25, 0.6, 0.75, 0.9])
def test_a_time_is_after_the_first_root_only_beyond_the_whole_stretch_that_was_tested(
    part: float,
) -> None:
    with precision(192):
        # The stretch [0, 1] is tested up to 1 + 2^-50.
        root = 1 + part * arb(2) ** -50
        level = Level(0, 1, arb(0))
        search = Search(Line(root), [level], None, 1, width=0.5, least=1e-30, sharp=True)

        bracket = search.first(2.0)

        assert bracket is not None
        assert root < bracket.far
        # The root itself is not after the first root; what is past the stretch is.
        assert bracket.place_of(root) in (0, None)
        assert bracket.place_of(root + arb(2) ** -50) == 1
        assert bracket.place_of(root / 2) == 0
        assert bracket.place_of(arb(-1)) == -1
        assert bracket.place_of(arb(0.5, 1)) is None


def test_sums_beyond_all_floats_are_not_clear() -> None:
    # Negative at 1; but Bernstein's sums are infinite, or no numbers, in floats.
    huge = FloatStretch([1e308, 1.7e308, 1.7e308, -1.7e308, -1.7e308, -1.7e308], [0.0] * 6)

    assert not huge.is_clear(0.0, 1.0, 6)
