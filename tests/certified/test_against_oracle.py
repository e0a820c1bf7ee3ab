from __future__ import annotations

import pytest
from tests.certified.comparison import misses
from tests.oracle.random_problems import FORCE_FREE, random_motion


# Some of the first 150 are the suite's: the oracle takes a sixth of a second for a motion, nine
# tenths of the time.
@pytest.mark.parametrize(
    "seeds",
    [
        range(0, 150, 15),
        pytest.param(range(10_000), marks=pytest.mark.nightly),
    ],
    ids=lambda seeds: f"{len(seeds)} from {seeds.start}",
)
def test_no_enclosure_misses_the_truth(seeds: range) -> None:
    # With 53 bits the balls are wide, and hold what they must by nothing but their radii.
    found = [text for seed in seeds for text in misses(random_motion(seed), bits=(None, 53))]

    assert found == []


@pytest.mark.parametrize("name", FORCE_FREE)
def test_without_forces_nothing_is_missed_either(name: str) -> None:
    assert misses(FORCE_FREE[name]) == []
