"""Branches of periodic orbits, and the special points on them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from tests.orbits.kinds import points
from tests.orbits.test_reference_orbits import ROWS, agree, system

import percuss as pc
from percuss.orbits import Branch, single_impact, single_impact_orbits

GAP = "oscillator.stops.0.at"
COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")


@pytest.fixture(scope="module")
def coco() -> Branch:
    orbit = pc.find_orbit(COCO, pc.cosine(1))
    return pc.continue_orbit(orbit, over={"forcing.amplitude": (1, 0.05)})


def test_coco_the_family_turns_at_a_fold_and_grazes(coco: Branch) -> None:
    (fold,), (graze,) = points(coco, "fold"), points(coco, "grazing")
    form = single_impact(COCO, pc.cosine(1))
    c2, c1, c0 = form.coefficients
    # c0 = b^2 - A^2 at A = 1, and the discriminant is zero.
    assert fold.value == pytest.approx(math.sqrt(c0 + 1.0 - c1**2 / (4.0 * c2)), abs=1e-12)
    assert fold.orbit.min_impact_speed == pytest.approx(abs(0.5 * c1 / c2), abs=1e-9)
    assert graze.value == pytest.approx(0.1, abs=1e-11)
    assert 0.1 - fold.value == pytest.approx(2.9e-5, abs=5e-7)
    assert fold.status == graze.status == "located"
    assert fold.row < graze.row
    assert coco.end_reason == "forcing.amplitude = 1 reached"


def test_coco_formal_orbits_beyond_the_graze_are_flagged(coco: Branch) -> None:
    (graze,) = points(coco, "grazing")

    speeds = coco.impact_velocity[:, 0]

    assert coco.admissible[: graze.row].all()
    assert not coco.admissible[graze.row + 1 :].any()
    assert (speeds[graze.row + 1 :] < 0.0).all()
    assert speeds[[0, -1]] == pytest.approx(single_impact(COCO, pc.cosine(1)).roots[:, 1])


def test_coco_physical_rows_are_fixed_points_of_the_map(coco: Branch) -> None:
    (graze,) = points(coco, "grazing")
    for row in range(0, graze.row - 1, 9):
        orbit = coco[row]
        assert orbit.forcing is not None
        impact = pc.impact_map(orbit.oscillator, orbit.forcing)
        cycle, v_after = orbit.impacts.cycle[0], orbit.impacts.v_after[0]
        np.testing.assert_allclose(impact(cycle, v_after), [cycle, v_after], atol=1e-10)
        assert pc.cosine(1, amplitude=float(coco.values[row])) == orbit.forcing


@pytest.mark.parametrize("which", range(3))
def test_orbits_without_impacts_graze(which: int) -> None:
    name, omega = "coco-grazing-A", ("1", "0.7", "1.3")[which]
    orbit = pc.find_orbit(*system(name, A="0.02", omega=omega), n_impacts=0)

    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.02, 1.0)})

    (graze,) = branch.special_points
    agree(graze.value, float(ROWS[name]["value"][which]), name)
    assert (graze.kind, graze.status) == ("grazing", "located")
    assert not branch.admissible[graze.row + 1 :].any()


def test_fold_and_graze_in_the_gap() -> None:
    name = "fold-a0.05-r0.7-w1.5"
    sigma, grazing, speed = (float(value) for value in ROWS[name]["value"])
    orbit = pc.find_orbit(*system(name, x="1"))

    branch = pc.continue_orbit(orbit, over={GAP: (0.5, 3.0)})

    (fold,), (graze,) = points(branch, "fold"), points(branch, "grazing")
    agree([fold.value, graze.value], [sigma, grazing], name)
    agree(fold.orbit.min_impact_speed, speed, name)
    assert branch.values.max() == fold.value
    assert "at the other end" in branch.end_reason


@pytest.mark.parametrize("name", ["pd-r0.8-n1", "pd-r0.5-n1"])
def test_period_doublings(name: str) -> None:
    omega, speed = (float(value) for value in ROWS[name]["value"])
    orbit = pc.find_orbit(*system(name, omega="2.5"))

    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.1, 3.9)})

    (doubling,) = branch.special_points
    assert (doubling.kind, doubling.status) == ("period_doubling", "located")
    agree([doubling.value, doubling.orbit.min_impact_speed], [omega, speed], name)
    assert branch.stability[doubling.row - 1] == "asymptotic"
    assert branch.stability[doubling.row + 1] == "unstable"
    assert branch.values[[0, -1]].tolist() == [2.1, 3.9]


def test_thresholds_of_the_ball() -> None:
    name = "ball-thresholds-r0.8"
    orbit = pc.find_orbit(*system(name, A="0.6"))

    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.2, 1.3)})

    (fold,), (doubling,) = points(branch, "fold"), points(branch, "period_doubling")
    agree([fold.value, doubling.value], [float(value) for value in ROWS[name]["value"]], name)


def test_symmetry_breaking_between_two_walls(mirrored: Branch) -> None:
    (point,) = points(mirrored, "symmetry_breaking")

    assert point.status == "located"
    assert mirrored.admissible[point.row]
    assert np.abs(point.orbit.multipliers - 1.0).min() < 1e-8
    assert {mirrored.stability[point.row - 1], mirrored.stability[point.row + 1]} == {
        "asymptotic",
        "unstable",
    }
    np.testing.assert_allclose(point.orbit.impacts.v_before.sum(), 0.0, atol=1e-8)


def test_strong_resonances_of_a_conservative_family(conservative: Branch) -> None:
    located = points(conservative, "strong_resonance")
    assert len(located) == 2
    for point, trace in zip(located, [0.0, -1.0], strict=True):
        both = single_impact_orbits(conservative[0].oscillator, pc.cosine(point.value))
        apart = [abs(np.trace(each.monodromy) - trace) for each in both]
        assert min(apart) < 1e-8


def test_stability_changes_at_special_points_only(coco: Branch, mirrored: Branch) -> None:
    for branch in (coco, mirrored):
        special = np.array([point.row for point in branch.special_points])
        changes = np.flatnonzero(branch.stability[1:] != branch.stability[:-1])
        assert len(changes) > 0
        assert all(np.isin([row, row + 1], special).any() for row in changes)


def test_a_branch_may_close() -> None:
    """Just below the largest gap at resonance, orbits with impacts live between two folds."""
    start = pc.find_orbit(COCO, pc.cosine(1, amplitude="0.5"))
    gaps = pc.continue_orbit(start, over={GAP: (1.0, 9.0)})
    (fold,) = points(gaps, "fold")
    osc, force = pc.impact_oscillator(0.8, wall=fold.value * 0.9999, side="above",
                                      damping="0.05"), pc.cosine(1, amplitude="0.5")  # fmt: skip

    branch = pc.continue_orbit(
        single_impact_orbits(osc, force)[0], over={"forcing.omega": (0.8, 1.2)}
    )

    assert branch.end_reason == "the branch closed"
    assert len(points(branch, "fold")) == 2
    assert branch.values[0] == pytest.approx(branch.values[-1], abs=1e-2)


def test_a_doubled_orbit_ends_where_the_single_one_doubles() -> None:
    name = "pd-r0.8-n1"
    orbit = pc.find_orbit(*system(name, omega="2.68"), 2, 2)

    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.6, 2.7)})

    first = branch.special_points[0]
    assert (first.kind, first.row) == ("period_doubling", 0)
    agree(first.value, float(ROWS[name]["value"][0]), name)
    assert "the two-fold cover" in branch.end_reason
    assert branch.stability[1] == "asymptotic"


@pytest.mark.parametrize("restitution", [0.0, 1.0])
def test_a_parameter_may_go_to_the_edge_of_what_it_can_be(restitution: float) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.5), pc.cosine(2.5))

    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.restitution": (0.5, restitution)})

    assert branch.values[-1] == restitution
    osc = pc.impact_oscillator(restitution)
    expected = single_impact(osc, pc.cosine(2.5)).roots[0, 1]
    assert branch.impact_velocity[-1, 0] == pytest.approx(-expected, abs=1e-11)


def test_the_order_of_the_range_is_that_of_the_rows() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))

    up = pc.continue_orbit(orbit, over={"forcing.omega": (2.4, 2.6)})
    down = pc.continue_orbit(orbit, over={"forcing.omega": (2.6, 2.4)})

    assert (up.values[0], up.values[-1]) == (2.4, 2.6)
    np.testing.assert_allclose(down.values, up.values[::-1], atol=1e-12)


def test_what_was_followed_is_returned_when_the_points_are_used_up() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))

    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.6)}, max_points=3)

    assert branch.end_reason == "max_points = 3 reached"
    assert len(branch) == 4
    assert "max_points = 3 reached" in repr(branch)


def test_progress_is_told_and_may_stop_it() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
    reported: list[tuple[float, float]] = []

    def until_ten(done: float, total: float) -> bool:
        reported.append((done, total))
        return done < 10

    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.4, 2.6)}, progress=until_ten)

    assert branch.end_reason == "stopped by progress"
    assert reported == [(k + 1, 4000) for k in range(10)]
    assert len(branch) == 11


def test_a_long_branch_shows_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("percuss.progress.PATIENCE", -1.0)
    monkeypatch.setattr("percuss.progress.RENEWED_IN_A_LOG", 0.0)
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))

    pc.continue_orbit(orbit, over={"forcing.omega": (2.49, 2.51)}, progress=True)

    assert "orbits, forcing.omega = 2.5" in capsys.readouterr().err


def test_a_branch_is_a_table(coco: Branch) -> None:
    data = coco.to_xarray()

    assert data.value.values.tolist() == coco.values.tolist()
    assert data.special_kind.values.tolist() == [point.kind for point in coco.special_points]
    assert (np.diff(coco.arclength) > 0.0).all()
    assert len(list(coco)) == len(coco) == data.sizes["point"]


def test_bad_input_is_named() -> None:
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.5)
    orbit = pc.find_orbit(osc, force)

    with pytest.raises(pc.ParameterError, match=r"did you mean forcing\.omega"):
        pc.continue_orbit(orbit, over={"forcing.omga": (2.0, 3.0)})
    # To its last digit: the end is beside it by rounding.
    with pytest.raises(pc.ParameterError, match=r"\(2, 2\.4999.*own value 2\.5$"):
        pc.continue_orbit(orbit, over={"forcing.omega": (2, np.nextafter(2.5, 0.0))})
    with pytest.raises(pc.ParameterError, match=r"own value 2\.5$"):
        pc.continue_orbit(orbit, over={"forcing.omega": (2.6, 3.0)})
    with pytest.raises(pc.ParameterError, match="two numbers"):
        pc.continue_orbit(orbit, over={"forcing.omega": (2.6,)})  # type: ignore[dict-item]
    with pytest.raises(pc.ParameterError, match="one parameter"):
        pc.continue_orbit(orbit, over={})
    with pytest.raises(pc.ParameterError, match="max_points"):
        pc.continue_orbit(orbit, over={"forcing.omega": (2.0, 3.0)}, max_points=0)
    with pytest.raises(pc.ParameterError, match="largest_step"):
        pc.continue_orbit(orbit, over={"forcing.omega": (2.0, 3.0)}, largest_step=0.0)
    free = pc.find_orbit(
        pc.impact_oscillator(), guess=pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=20.0)
    )
    with pytest.raises(pc.ParameterError, match="family"):
        pc.continue_orbit(free, over={"oscillator.stiffness": (0.5, 1.5)})


def test_a_doubled_family_ends_at_its_origin_far_from_where_it_was_begun() -> None:
    """Newton's method gains a factor of two a step only where the shorter orbit crosses."""
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    orbits = pc.find_orbits(osc, pc.cosine("2.8"), max_periods=4)
    (doubled,) = (each for each in orbits if (each.n_impacts, each.n_periods) == (2, 4))
    single = max((each for each in orbits if (each.n_impacts, each.n_periods) == (1, 2)),
                 key=lambda each: each.min_impact_speed)  # fmt: skip

    followed = pc.continue_orbit(doubled, over={"forcing.omega": (2.6, 3.2)})
    own = pc.continue_orbit(single, over={"forcing.omega": (2.6, 3.2)})

    (doubling,) = points(own, "period_doubling")
    assert doubling.value == pytest.approx(2.88752366009, abs=1e-10)
    assert points(followed, "period_doubling")[-1].value == pytest.approx(doubling.value, abs=1e-10)
    assert followed.values.max() == pytest.approx(doubling.value, abs=1e-10)
    assert "the two-fold cover" in followed.end_reason


@pytest.mark.parametrize("end", ["2", "2.000001"])
def test_velocities_that_grow_near_a_resonance(end: str) -> None:
    """At w = 2 the free motion between two impacts lasts a forcing period."""
    orbit = pc.find_orbit(pc.impact_oscillator(1, wall=0), pc.cosine("2.6"))

    branch = pc.continue_orbit(orbit, over={"forcing.omega": (end, 3)})

    assert branch.impact_velocity.max() > 4e5
    if end == "2":
        assert "grow without bound towards forcing.omega = 2.0000" in branch.end_reason
    else:
        assert branch.values[0] == float(end)
    # V = A / (w - 2) to first order.
    grown = branch.impact_velocity[:, 0] * (branch.values - 2.0)
    assert grown[branch.values < 2.001] == pytest.approx(grown[1], rel=1e-2)
    for row, each in enumerate(branch):
        assert each.residual < 1e-11 * max(1.0, branch.impact_velocity[row, 0])


def test_the_tables_of_branches_and_charts_have_the_units_of_sweeps() -> None:
    wall = pc.Wall(1, "above", "0.7")
    osc, over = (
        pc.Oscillator(1, "0.1", [wall], units=pc.Units("mm", "ms")),
        {"forcing.omega": (1.2, 1.25)},
    )
    swept = pc.sweep("peak_displacement", osc, pc.cosine("1.2"), over={"forcing.omega": [1.2]})
    branch = pc.continue_orbit(pc.find_orbit(osc, pc.cosine("1.2")), over=over)
    chart = pc.response_curve(osc, pc.cosine("1.2"), over=over, max_impacts=1, max_periods=1)
    bare = pc.continue_orbit(
        pc.find_orbit(pc.Oscillator(1, "0.1", [wall]), pc.cosine("1.2")), over=over
    )
    one = pc.Structure(
        [1], [1], ["0.2"], [pc.Wall(1, "above", "0.7", on=0)], units=pc.Units("mm", "ms", "g")
    )
    structure = pc.continue_orbit(
        pc.find_orbit(one, pc.Loads({0: pc.cosine("1.2")})), over={"loads.0.omega": (1.2, 1.25)}
    )

    def units(data: xr.Dataset, *names: str) -> list[str]:
        return [data[name].attrs["units"] for name in names]

    names = "value", "special_value", "impact_velocity"
    assert swept["forcing.omega"].attrs["units"] == "1/ms"
    assert units(branch.to_xarray(), *names) == ["1/ms", "1/ms", "mm/ms"]
    assert units(branch.to_xarray(), "period", "grazing_margin") == ["ms", "mm"]
    assert units(chart.to_xarray(), *names) == ["1/ms", "1/ms", "mm/ms"]
    assert units(chart.to_xarray(), "attractor_value", "amplitude") == ["1/ms", "mm"]
    assert units(bare.to_xarray(), *names) == ["1/time", "1/time", "length/time"]
    assert units(structure.to_xarray(), "value", "amplitude") == ["1/ms", "mm"]
