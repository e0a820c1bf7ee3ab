from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import percuss as pc

GAP = "oscillator.stops.0.at"
OSC = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
FORCE = pc.cosine("1.5")
BOX = {"x0": (-4.0, 0.6), "v0": (-4.0, 4.0)}


def fractions(values: object, **keywords: object):  # type: ignore[no-untyped-def]
    given = {"n_starts": 200, **BOX} | keywords
    return pc.basin_fractions(OSC, FORCE, over={GAP: values}, **given)  # type: ignore[arg-type]


def test_attractors_begin_and_end_where_the_orbits_do() -> None:
    """Case fold-a0.05-r0.7-w1.5: grazing at a gap of 0.7943015, the fold at 2.1214694."""
    gaps = np.array([0.78, *np.linspace(1.2, 2.0, 6), 2.11, 2.13])
    found = fractions(gaps)

    assert found.exists.values[0].tolist() == (gaps < 2.1214694).tolist()
    assert found.exists.values[1].tolist() == (gaps > 0.7943015).tolist()
    assert found.name.values[:, 1].tolist() == ["(1, 1)", "(0, 1)"]
    np.testing.assert_array_equal(found.fraction.sum("attractor"), 1.0 - found.undecided)


def test_an_attractor_whose_basin_holds_no_start_is_carried_on() -> None:
    """Starts near the motion without impacts, and the one with impacts from where it was alone."""
    found = fractions([0.7, 1.5, 2.0], n_starts=20, x0=(-0.8, -0.7), v0=(0.1, 0.2))

    assert found.name.values[0].tolist() == ["(1, 1)", "(1, 1)", "(1, 1)"]
    assert found.fraction.values[0].tolist() == [1.0, 0.0, 0.0]
    assert found.fraction.values[1].tolist() == [0.0, 1.0, 1.0]


def test_an_attractor_is_the_same_through_a_period_doubling() -> None:
    """Case pd-r0.8-n1: at omega = 2.6533."""
    found = pc.basin_fractions(
        pc.impact_oscillator("0.8"),
        pc.cosine(2.5),
        over={"forcing.omega": [2.64, 2.66]},
        x0=(0.0, 0.1),
        v0=(0.9, 1.1),
        n_starts=20,
    )

    (both,) = np.flatnonzero(found.exists.values.all(axis=1))
    assert found.name.values[both].tolist() == ["(1, 1)", "(2, 2)"]


def test_errors_are_those_of_a_sample() -> None:
    found = fractions([1.2], n_starts=400)
    other = fractions([1.2], n_starts=400, seed=1)

    p = found.fraction.values
    np.testing.assert_allclose(found.fraction_error, np.sqrt(p * (1 - p) / 400))
    apart = np.abs(found.fraction.values - other.fraction.values)
    assert 0.0 < apart.max() < 4.0 * np.hypot(found.fraction_error, other.fraction_error).max()


def test_starts_inside_the_wall_count_for_nothing() -> None:
    found = fractions([0.7, 1.0], x0=(-1.0, 1.0), n_starts=300)

    n = found.n_starts.values
    assert n[1] == 300
    assert n[0] == pytest.approx(300 * 0.85, abs=4 * np.sqrt(300 * 0.85 * 0.15))
    np.testing.assert_allclose(found.fraction.sum("attractor") + found.undecided, 1.0)


def test_a_store_goes_on_and_ends_the_same(tmp_path: Path) -> None:
    path = tmp_path / "f.zarr"
    keywords = {"n_starts": 400, "periods": 200}

    part = fractions((0.7, 2.2), store=path, progress=lambda *_: False, **keywords)
    whole = fractions((0.7, 2.2), store=path, **keywords)

    assert part.attrs["complete"] == 0
    assert whole.identical(fractions((0.7, 2.2), **keywords))
    assert pc.load_store(path).fraction.equals(whole.fraction)


def test_a_value_without_a_motion_is_passed_over() -> None:
    found = pc.basin_fractions(
        OSC, FORCE, over={"oscillator.stops.0.restitution": [0.7, 1.4, 0.7]}, n_starts=50,
        x0=BOX["x0"], v0=BOX["v0"],
    )  # fmt: skip

    assert found.n_starts.values.tolist() == [50, 0, 50]
    assert not found.exists.values[:, 1].any()
    assert found.exists.values[:, 2].any()


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"x0": (1.0, 0.0)}, "low to a higher"),
        ({"x0": 1.0}, r"not a range \(low, high\)"),
        ({"n_starts": 0}, "at least 1"),
        ({"periods": 3}, "at least 40"),
        ({"over": {"start.x0": [1.0]}}, "one axis"),
        ({"over": {"forcing.omga": [1.0]}}, "did you mean"),
    ],
)
def test_what_is_wrong_with_a_call_is_said(keywords: dict[str, object], message: str) -> None:
    given = {"over": {GAP: [1.0]}, "n_starts": 10, **BOX} | keywords
    with pytest.raises(pc.ParameterError, match=message):
        pc.basin_fractions(OSC, FORCE, **given)  # type: ignore[arg-type]
