"""Points without an answer are counted everywhere, and where nothing has one a warning says so."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import percuss as pc

OSC = pc.impact_oscillator(restitution=0.8)
GAP = pc.impact_oscillator(restitution=0.8, wall=1, side="above", damping=0.05)
FORCE = pc.cosine(2.5)
AT = "oscillator.stops.0.at"
RESTITUTION = "oscillator.stops.0.restitution"


def test_a_built_in_measure_without_any_answer_warns_with_the_reason_and_its_count() -> None:
    with pytest.warns(UserWarning, match=r"period has no answer for any of 2 points; .*outside"):
        data = pc.sweep("period", OSC, FORCE, over={RESTITUTION: [2, 3]})
    assert data.attrs["failed"] == 2

    with pytest.warns(UserWarning, match=r"\(2 of 2\): x0 = -1.0: below the wall"):
        pc.sweep("period", OSC, FORCE, over={"forcing.omega": [2, 3]}, start=(-1, 0))


def test_the_commonest_of_several_reasons_is_reported_once_for_all_its_numbers() -> None:
    over = {RESTITUTION: [2.0, 0.8], "start.x0": [-0.5, -0.25]}

    with pytest.warns(UserWarning, match=r"the commonest reason \(2 of 4\)"):
        pc.sweep("period", OSC, FORCE, over=over)


def test_of_several_measures_those_without_any_answer_are_named() -> None:
    free = pc.Oscillator(damping=0.1)
    names = ["growth_exponent", "peak_displacement"]

    with pytest.warns(UserWarning, match=r"^growth_exponent has no answer for any of 1 point; "):
        pc.sweep(names, free, FORCE, over={"forcing.omega": [2.0]}, transient=5, periods=5)


def test_a_function_that_returns_nan_everywhere_is_reported() -> None:
    def nothing(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
        return math.nan

    def seldom(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
        return 1.0 if float(force.frequency or 0) > 2.2 else math.nan

    with pytest.warns(UserWarning, match=r"nothing has no answer .* \(2 of 2\): it returned NaN"):
        pc.sweep(nothing, OSC, FORCE, over={"forcing.omega": [2.0, 2.5]})
    # NaN at some points is an answer of whoever wrote the function.
    assert pc.sweep(seldom, OSC, FORCE, over={"forcing.omega": [2.0, 2.5]}).attrs["failed"] == 0


def test_a_sweep_that_was_stopped_does_not_warn() -> None:
    over = {RESTITUTION: [2.0] * 40_000}

    data = pc.sweep("period", OSC, FORCE, over=over, progress=lambda done, total: False)  # noqa: ARG005

    assert data.attrs["complete"] == 0


def test_a_diagram_over_the_gap_counts_the_values_that_its_start_is_beyond() -> None:
    with pytest.warns(
        UserWarning, match=r"400 of 802 values have no answer, the first at .* -1\.0"
    ):
        diagram = pc.bifurcation_diagram(
            GAP, FORCE, over={AT: (-1, 1)}, follow=["forward"], transient=20, points=8
        )

    # The start at 0 is above the wall at 200 of 401 values, on either branch.
    assert (diagram.reason.values != "").sum(axis=1).tolist() == [200, 200]
    assert diagram.attrs["failed"] == 400


def test_a_branch_is_followed_where_the_wall_moves_past_where_it_was() -> None:
    with pytest.warns(UserWarning, match=r"200 of 802 values have no answer, .* of start 0; the"):
        diagram = pc.bifurcation_diagram(
            GAP, FORCE, over={AT: (-1, 1)}, follow=["backward"], transient=20, points=8
        )

    assert (diagram.reason.sel(branch="backward").values == "").all()


def test_the_reason_of_a_start_of_several_is_its_own() -> None:
    with pytest.warns(UserWarning, match=r"^start 1: no points at any of 2 values; .*x0 = 5\.0"):
        diagram = pc.bifurcation_diagram(
            GAP, FORCE, over={AT: [1, 2]}, starts=[(0, 0), (5, 0)], transient=20, points=8
        )

    assert diagram.attrs["failed"] == 2
    assert "x0 = 5.0: above the wall at x = 2.0" in diagram.reason.sel(branch="start 1").values[1]


def test_basins_count_the_starts_inside_a_wall() -> None:
    basins = pc.basins(OSC, FORCE, x0=[-1.0, 2.0], v0=[0.0, 1.0, 2.0, 3.0])

    assert basins.attrs["failed"] == 4
    assert basins.attrs["n_starts"] == 4


def test_starts_that_are_all_inside_a_wall_warn() -> None:
    with pytest.warns(UserWarning, match=r"no motion starts anywhere; .*\(4 of 4\): x0 = -1.0"):
        basins = pc.basins(OSC, FORCE, x0=[-1.0, -2.0], v0=[0.0, 1.0])
    assert basins.attrs["failed"] == 4

    with pytest.warns(UserWarning, match=r"no motion starts anywhere; .*inside a wall"):
        fractions = pc.basin_fractions(
            GAP, FORCE, over={AT: [-2.0, -1.0]}, x0=(0, 1), v0=(0, 1), n_starts=5
        )
    assert fractions.attrs["failed"] == 10


def test_stores_that_are_not_at_their_end_count_failures_too(tmp_path: Path) -> None:
    path = tmp_path / "diagram.zarr"
    pc.bifurcation_diagram(
        GAP, FORCE, over={AT: [-1, 1]}, follow=["forward", "backward"], transient=20, points=8,
        store=path, n_workers=1, progress=lambda done, _: done == 0,
    )  # fmt: skip

    status = pc.load_store(path / "followed")

    assert status.attrs["complete"] == 0
    assert status.attrs["failed"] == int(np.sum(status["period"].values[0] == -1)) == 1


def test_a_wall_that_pushes_a_branch_beyond_all_scales_ends_it_with_a_reason() -> None:
    """Beyond 1e150 squares overflow, and hops on the wall had a million false impacts each."""
    over = {"oscillator.stops.0.at": [-1e300, -1e200, 0.0, 1e300]}
    with pytest.warns(UserWarning, match="values have no answer"):
        found = pc.bifurcation_diagram(
            pc.impact_oscillator("0.8", side="above", damping="0.05"), pc.cosine(2), over=over
        )
    backward = found.sel(branch="backward")
    assert set(backward.reason.values[:2]) == {"the motion grew beyond 1e150"}
    assert backward.period.values.tolist() == [-1, -1, 1, 1]
    assert int(found.attrs["n_impacts"]) < 100_000
