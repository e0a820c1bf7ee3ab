"""The examples that are no single motions: run in short form, they show what they say."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.execution import Execution
from percuss.studies.reading import parse_study

EXAMPLES = Path(__file__).parents[2] / "examples"


def answer(name: str, **replaced: str) -> Any:
    """Run an example with some lines of its text replaced, for a shorter run."""
    lines = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8").splitlines()
    for start, line in replaced.items():
        (number,) = (i for i, text in enumerate(lines) if text.strip('"').startswith(start))
        lines[number] = line
    study = parse_study("\n".join(lines), name)
    return study.question.answer(study, Execution())


def test_cocos_family_ends_at_a_fold_just_below_its_graze() -> None:
    branch = answer("coco")

    places = {point.kind: point.value for point in branch.special_points}
    assert places["grazing"] == pytest.approx(0.1, abs=1e-12)
    assert 0.1 - places["fold"] == pytest.approx(2.9e-5, abs=5e-7)
    assert not branch[-1].admissible


def test_the_gears_resonance_is_bent_between_two_folds_with_two_attractors() -> None:
    branch = answer("gear_backlash")

    folds = sorted(point.value for point in branch.special_points if point.kind == "fold")
    assert len(folds) == 2
    assert folds[0] < 0.72 < folds[1]
    # Between them, on either side of the unstable orbits, two stable ones: a motion that begins
    # on one of them stays.
    rows = [row for row, omega in enumerate(branch.values)
            if 0.72 < omega < folds[1] - 0.005 and branch.is_stable[row]]  # fmt: skip
    for row in (rows[0], rows[-1]):
        orbit = branch[row]
        run = pc.simulate(orbit.oscillator, orbit.forcing, orbit.x0, orbit.v0, orbit.t0,
                          t_end=orbit.t0 + 40 * orbit.period)  # fmt: skip
        speeds = run.crossings.v[run.crossings.direction == "in"]
        largest = np.abs(orbit.impacts.v_before).max()
        assert np.abs(speeds[-1]) == pytest.approx(largest, rel=1e-6)
    least = [branch.impact_velocity[row].min() for row in (rows[0], rows[-1])]
    assert max(least) > 3.0 * min(least)


def test_the_response_is_stable_at_the_multiples_of_twice_the_eigenfrequency() -> None:
    response = answer("response", max_periods='max_periods = 2\nn_seeds = 2',
                      **{"forcing.omega": '"forcing.omega" = ["1.8", "4.2"]'})  # fmt: skip

    families = {(it.n_impacts, it.n_periods): it for it in response.families}
    for n_periods, omega in ((1, 2.0), (2, 4.0)):
        ranges = families[1, n_periods].stable_ranges
        assert any(low < omega < high for low, high in ranges)


def test_the_diagrams_period_doubles_where_the_closed_form_says() -> None:
    diagram = answer("bifurcation", **{"forcing.omega": '"forcing.omega" = ["2.65", "2.66"]'},
                     points="points = 16", starts="starts = [[0, 1]]")  # fmt: skip

    assert diagram.period.sel(branch="start 0").values.tolist() == [1, 2]


def test_the_basins_are_those_of_two_orbits() -> None:
    basins = answer("basins", x0="x0 = [-2, 0]", v0="v0 = [-3, 0]")

    found = {float(basins.n_impacts[i]) for i in basins.basin.values.ravel()}
    assert found == {0.0, 1.0}
    # Where the picture has the motion without impacts: around its orbit.
    inside = basins.basin.sel({"start.x0": 0.0, "start.v0": 0.0})
    assert float(basins.n_impacts[int(inside)]) == 0.0


def test_the_chart_shows_periods_and_exponents() -> None:
    chart = answer("chart", **{
        "oscillator.stops.0.restitution": '"oscillator.stops.0.restitution" = ["0.5", "0.8"]',
        "forcing.omega": '"forcing.omega" = [2, 4]',
        "transient": "transient = 200",
    })  # fmt: skip

    assert chart.period.values.tolist() == [[1.0, 2.0], [1.0, 2.0]]
    # One impact in n forcing periods: each multiplier of modulus r, if they are a pair.
    rate = math.log(0.8) / math.pi
    exponent = float(chart.largest_lyapunov_exponent[1, 0])
    assert exponent == pytest.approx(rate, rel=0.05)
