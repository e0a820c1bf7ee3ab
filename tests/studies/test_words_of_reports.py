"""What a report says of a study in which nothing, or all, came out."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

import percuss as pc
from percuss.studies import parse_study, run_study
from percuss.studies.kinds.basins import Basins
from percuss.studies.kinds.motion import impact_times_words
from percuss.studies.kinds.response import Response
from percuss.studies.study import failure_rows


def response(missed: int, others: int = 0) -> Any:
    families = [
        SimpleNamespace(n_impacts=0, n_periods=1, ranges=(), stable_ranges=()),
        SimpleNamespace(n_impacts=1, n_periods=1, ranges=((1.0, 2.0),), stable_ranges=()),
        SimpleNamespace(n_impacts=2, n_periods=1, ranges=((1.0, 2.0),), stable_ranges=((1.0, 1.5),)),
    ]  # fmt: skip
    points = [SimpleNamespace(kind="period_doubling", value=value) for value in (1.25, 1.5)]
    away = missed + others
    seen = [SimpleNamespace(branch=None if i < away else 0) for i in range(102)]
    return SimpleNamespace(
        branches=[None] * 3, families=families, attractors=seen, missed=seen[:missed],
        special_points=points,
    )  # fmt: skip


def test_a_response_is_reported_without_double_negations() -> None:
    rows = Response(over={}).report(response(0))

    assert rows["(0, 1)"] == "formal everywhere: each orbit would pass through a stop"
    assert rows["(1, 1)"] == "physical 1 to 2; nowhere stable"
    assert rows["(2, 1)"] == "physical 1 to 2; stable 1 to 1.5"
    assert rows["special points"] == "period doubling at 1.25, 1.5"
    assert rows["compared"] == "102 attractors of direct simulation, all of them on a branch"
    assert Response(over={}).report(response(2))["compared"].endswith("2 of them on no branch")
    compared = Response(over={}).report(response(0, others=1))["compared"]
    assert compared.endswith("simulation, 1 of them of no kind that was looked for")


def test_special_points_are_in_order_and_short_intervals_have_ends_that_differ() -> None:
    found = response(0)
    found.special_points.reverse()
    # A doubling lies on the branch that doubles and on the doubled one.
    found.special_points.append(found.special_points[0])
    found.families[2].ranges = ((22.10370986, 22.10372621), (3.0, 3.0))

    rows = Response(over={}).report(found)

    assert rows["special points"] == "period doubling at 1.25, 1.5"
    assert rows["(2, 1)"] == "physical 22.10371 to 22.10373, 3; stable 1 to 1.5"


def test_a_pattern_of_one_forcing_period_is_in_the_singular() -> None:
    times = pc.ImpactTimes("settling", 2, 1, 0.5, 1e-3, 40)

    assert impact_times_words(times) == "settling towards 2 in 1 forcing period, as exp(-0.5 t)"


def test_basins_whose_starts_are_all_inside_a_wall_say_so() -> None:
    osc, force = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)
    with pytest.warns(UserWarning, match="no motion starts anywhere"):
        basins = pc.basins(osc, force, x0=[-1.0, -2.0], v0=[0.0, 1.0])

    rows = Basins().report(basins)

    assert rows == {"starts": "0", "inside a wall": "4 of 4"}
    assert math.isfinite(cast("float", basins.attrs["undecided"]))


def test_reasons_that_differ_in_numbers_only_are_one() -> None:
    reasons = [f"x0 = 0.0: above the wall at x = {-0.1 * k}" for k in range(1, 5)]

    reported = failure_rows([*reasons, "the motion grew beyond 1e150"], 10)["without answer"]

    assert reported == "5 of 10: x0 = 0.0: above the wall at x = -0.1 (4); other reasons: 1"


def test_a_motion_of_a_structure_is_reported_with_its_impact_times(tmp_path: Path) -> None:
    study = parse_study("""
[structure]
mass = [1]
stiffness = [1]
[[structure.stops]]
type = "wall"
at = 0
side = "below"
restitution = "0.8"
[[loads]]
[[loads.harmonics]]
amplitude = 1
omega = "2.1"
[start]
x0 = [0]
v0 = ["0.3"]
[run]
periods = 40
""")

    rows = study.question.report(run_study(study, tmp_path / "out").answer)

    assert rows["impact times"].startswith("settling towards 1 in 1 forcing period, as exp(")
    assert list(rows)[-3:] == ["impact times", "outcome", "time"]
