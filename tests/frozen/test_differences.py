"""The comparison of `make frozen` finds what has changed, and only that."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest
from tests.frozen.__main__ import differences

KEPT: dict[str, Any] = {"a": [1.0, [2, "word"], math.nan], "b": {"c": math.inf}}


def test_what_is_the_same_to_within_the_tolerance_is_no_change() -> None:
    now = copy.deepcopy(KEPT)
    now["a"][0] = 1.0 + 1e-13

    assert list(differences(KEPT, now, 1e-12)) == []
    assert len(list(differences(KEPT, now, 0.0))) == 1


@pytest.mark.parametrize(
    "now",
    [
        {"a": [1.0, [2, "word"], math.nan]},
        KEPT | {"d": 1},
        KEPT | {"a": [1.0 + 1e-9, [2, "word"], math.nan]},
        KEPT | {"a": [1.0, [2, "words"], math.nan]},
        KEPT | {"a": [1.0, [2], math.nan]},
        KEPT | {"a": [1.0, [2, "word"], 0.0]},
        KEPT | {"b": {"c": -math.inf}},
        KEPT | {"b": 1.0},
    ],
)
def test_each_change_is_told(now: dict[str, Any]) -> None:
    assert list(differences(KEPT, now, 1e-12)) != []
