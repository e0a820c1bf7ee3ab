from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.attractors import Attractor
from percuss.ensembles.basin_fractions import (
    NO_MOTION,
    AttractorsAt,
    points_before,
    with_joined_numbers,
)
from percuss.plotting import plot_fractions

GAP = "oscillator.stops.0.at"
OSC = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
FORCE = pc.cosine("1.5")
BOX = {"x0": (-4.0, 0.6), "v0": (-4.0, 4.0)}


def fractions(values: object, **keywords: object):  # type: ignore[no-untyped-def]
    given = {"n_starts": 200, **BOX} | keywords
    return pc.basin_fractions(OSC, FORCE, over={GAP: values}, **given)  # type: ignore[arg-type]


def over_both(over: dict[str, list[float]], n_starts: int):  # type: ignore[no-untyped-def]
    return pc.basin_fractions(OSC, FORCE, over=over, n_starts=n_starts, x0=BOX["x0"], v0=BOX["v0"])


def test_attractors_begin_and_end_where_the_orbits_do() -> None:
    """Case fold-a0.05-r0.7-w1.5: grazing at a gap of 0.7943015, the fold at 2.1214694."""
    gaps = np.array([0.78, *np.linspace(1.2, 2.0, 6), 2.11, 2.13])
    shares = fractions(gaps)

    assert shares.exists.values[0].tolist() == (gaps < 2.1214694).tolist()
    assert shares.exists.values[1].tolist() == (gaps > 0.7943015).tolist()
    assert shares.name.values[:, 1].tolist() == ["(1, 1)", "(0, 1)"]
    np.testing.assert_array_equal(shares.fraction.sum("attractor"), 1.0 - shares.undecided)


def test_an_attractor_whose_basin_holds_no_start_is_carried_on() -> None:
    """Starts near the motion without impacts, and the one with impacts from where it was alone."""
    shares = fractions([0.7, 1.5, 2.0], n_starts=20, x0=(-0.8, -0.7), v0=(0.1, 0.2))

    assert shares.name.values[0].tolist() == ["(1, 1)", "(1, 1)", "(1, 1)"]
    assert shares.fraction.values[0].tolist() == [1.0, 0.0, 0.0]
    assert shares.fraction.values[1].tolist() == [0.0, 1.0, 1.0]


def test_an_attractor_is_the_same_through_a_period_doubling() -> None:
    """Case pd-r0.8-n1: at omega = 2.6533."""
    shares = pc.basin_fractions(
        pc.impact_oscillator("0.8"),
        pc.cosine(2.5),
        over={"forcing.omega": [2.64, 2.66]},
        x0=(0.0, 0.1),
        v0=(0.9, 1.1),
        n_starts=20,
    )

    (both,) = np.flatnonzero(shares.exists.values.all(axis=1))
    assert shares.name.values[both].tolist() == ["(1, 1)", "(2, 2)"]


def test_errors_are_those_of_a_sample() -> None:
    shares = fractions([1.2], n_starts=400)
    other = fractions([1.2], n_starts=400, seed=1)

    p = shares.fraction.values
    np.testing.assert_allclose(shares.fraction_error, np.sqrt(p * (1 - p) / 400))
    apart = np.abs(shares.fraction.values - other.fraction.values)
    assert 0.0 < apart.max() < 4.0 * np.hypot(shares.fraction_error, other.fraction_error).max()


def test_starts_inside_the_wall_count_for_nothing() -> None:
    shares = fractions([0.7, 1.0], x0=(-1.0, 1.0), n_starts=300)

    n = shares.n_starts.values
    assert n[1] == 300
    assert n[0] == pytest.approx(300 * 0.85, abs=4 * np.sqrt(300 * 0.85 * 0.15))
    np.testing.assert_allclose(shares.fraction.sum("attractor") + shares.undecided, 1.0)


def test_a_store_goes_on_and_ends_the_same(tmp_path: Path) -> None:
    path = tmp_path / "f.zarr"
    keywords = {"n_starts": 400, "periods": 200}

    part = fractions((0.7, 2.2), store=path, progress=lambda done, _: done == 0, **keywords)
    whole = fractions((0.7, 2.2), store=path, **keywords)

    assert part.attrs["complete"] == 0
    assert whole.identical(fractions((0.7, 2.2), **keywords))
    assert pc.load_store(path).fraction.equals(whole.fraction)


def test_over_two_parameters_attractors_exist_where_their_orbits_do() -> None:
    """The motion without impacts is there where its amplitude, in closed form, is below the gap."""
    gaps, omegas = [0.5, 0.9, 1.3, 1.7], [1.4, 1.5, 1.6]

    found = over_both({GAP: gaps, "forcing.omega": omegas}, n_starts=600)

    amplitude = np.array([abs(1.0 / complex(1.0 - w * w, 0.1 * w)) for w in omegas])
    free = [i for i in range(len(found.attractor)) if "(0, 1)" in found.name.values[i]]
    assert len(free) == 1
    expected = np.array(gaps)[:, np.newaxis] > amplitude
    np.testing.assert_array_equal(found.exists.values[free[0]], expected)
    assert set(found.name.values[free[0]][expected]) == {"(0, 1)"}
    np.testing.assert_allclose(found.fraction.sum("attractor") + found.undecided, 1.0)
    assert found.fraction.dims == ("attractor", GAP, "forcing.omega")


def test_a_second_parameter_of_one_value_changes_nothing() -> None:
    gaps = [0.7, 1.2, 1.7]
    one = fractions(gaps, n_starts=50)

    over = {"forcing.omega": [1.5], GAP: gaps}
    two = over_both(over, n_starts=50)

    for name in ("fraction", "exists", "name", "exponent", "residual", "undecided"):
        values = two[name].isel({"forcing.omega": 0})
        np.testing.assert_array_equal(values.values, one[name].values)


def test_what_appears_at_two_places_and_meets_is_one_attractor_unless_both_are_at_one_place() -> (
    None
):
    nothing = Attractor("rest")

    def there(*numbers: int) -> AttractorsAt:
        return AttractorsAt(
            dict.fromkeys(numbers, nothing), dict.fromkeys(numbers, (0.5, 0.1)), 0.0, 1
        )

    apart = [there(0), there(2), there(1), there(0)]
    joined = with_joined_numbers(apart, [(0, 1)])
    beside = with_joined_numbers([*apart, there(0, 1)], [(0, 1)])

    # What is left is numbered without gaps.
    assert [list(one.attractors) for one in joined] == [[0], [1], [0], [0]]
    assert [list(one.fractions) for one in beside] == [[0], [2], [1], [0], [0, 1]]


def test_the_points_before_are_those_along_each_axis_that_have_a_motion() -> None:
    found = [AttractorsAt({}, {}, float(k), 1) for k in range(6)]
    found[4] = NO_MOTION

    def before(shape: tuple[int, ...], k: int) -> list[float]:
        return [one.undecided for one in points_before(found, shape, k)]

    assert before((6,), 0) == []
    assert before((6,), 5) == [3.0]
    assert before((2, 3), 3) == [0.0]
    assert before((2, 3), 5) == [3.0, 2.0]
    assert before((3, 2), 4) == [2.0]


def test_a_value_without_a_motion_is_passed_over() -> None:
    shares = pc.basin_fractions(
        OSC, FORCE, over={"oscillator.stops.0.restitution": [0.7, 1.4, 0.7]}, n_starts=50,
        x0=BOX["x0"], v0=BOX["v0"],
    )  # fmt: skip

    assert shares.n_starts.values.tolist() == [50, 0, 50]
    assert not shares.exists.values[:, 1].any()
    assert shares.exists.values[:, 2].any()
    for name in ("fraction", "fraction_error"):
        np.testing.assert_array_equal(np.isnan(shares[name].values).any(axis=0), [0, 1, 0])
    assert plot_fractions(shares).get_ylim() == (0.0, 1.0)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"x0": (1.0, 0.0)}, "low to a higher"),
        ({"x0": 1.0}, r"not a range \(low, high\)"),
        ({"n_starts": 0}, "at least 1"),
        ({"periods": 3}, "at least 40"),
        ({"over": {"start.x0": [1.0]}}, "one axis or two"),
        ({"over": {"forcing.omga": [1.0]}}, "did you mean"),
        ({"over": [1.0]}, "not {path: values}"),
    ],
)
def test_what_is_wrong_with_a_call_is_said(keywords: dict[str, object], message: str) -> None:
    given = {"over": {GAP: [1.0]}, "n_starts": 10, **BOX} | keywords
    with pytest.raises(pc.ParameterError, match=message):
        pc.basin_fractions(OSC, FORCE, **given)  # type: ignore[arg-type]


def test_one_start_stands_for_both_ranges_and_attractors_have_measures() -> None:
    over = {GAP: [0.7, 1.2]}
    box = (BOX["x0"], BOX["v0"])
    names = ["peak_impact_velocity", "max_displacement"]

    one = pc.basin_fractions(OSC, FORCE, over=over, n_starts=20, start=box, measures=names)
    both = pc.basin_fractions(OSC, FORCE, over=over, n_starts=20, **BOX)  # type: ignore[arg-type]

    assert one.drop_vars(names).equals(both)
    exists = both.exists.values
    assert (np.isfinite(one.max_displacement.values) == exists).all()
    strikes = both.n_impacts.values > 0
    assert (one.peak_impact_velocity.values[exists & strikes] > 0).all()
    assert (one.peak_impact_velocity.values[exists & ~strikes] == 0).all()
    with pytest.raises(pc.ParameterError, match="given together with x0"):
        pc.basin_fractions(OSC, FORCE, over=over, start=box, **BOX)  # type: ignore[arg-type]
    with pytest.raises(pc.ParameterError, match=r"x0 = None: not a range"):
        pc.basin_fractions(OSC, FORCE, over=over)
    with pytest.raises(pc.ParameterError, match=r"not a range"):
        pc.basin_fractions(OSC, FORCE, over=over, start=(0.0, 1.0))
