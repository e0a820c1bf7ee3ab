from __future__ import annotations

import pytest
from tests.certified.comparison import misses
from tests.oracle.random_problems import FORCE_FREE, random_motion


# The first 150 are the suite's, in parts that can run side by side.
@pytest.mark.parametrize(
    "seeds",
    [
        *(range(first, first + 50) for first in range(0, 150, 50)),
        pytest.param(range(150, 10_000), marks=pytest.mark.nightly),
    ],
    ids=lambda seeds: f"{seeds.start} to {seeds.stop - 1}",
)
def test_no_enclosure_misses_the_truth(seeds: range) -> None:
    # With 53 bits the balls are wide, and hold what they must by nothing but their radii.
    found = [text for seed in seeds for text in misses(random_motion(seed), bits=(None, 53))]

    assert found == []


@pytest.mark.parametrize("name", FORCE_FREE)
def test_without_forces_nothing_is_missed_either(name: str) -> None:
    assert misses(FORCE_FREE[name]) == []
