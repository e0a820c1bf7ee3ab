from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.certified.motions import ELASTIC, chaotic

import percuss as pc
from percuss.certified import keeps_eigenset, list_orbits, prove_basins
from percuss.errors import ParameterError


@pytest.mark.parametrize(
    ("name", "value"), [("digits", 0), ("digits", 2.5), ("bits", 4), ("most_bits", True)]
)
def test_bad_numbers_are_refused(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=name):
        pc.certify(chaotic(2), **{name: value})  # type: ignore[call-overload]


def test_what_is_no_result_is_refused() -> None:
    with pytest.raises(ParameterError, match="neither a run, nor an orbit"):
        pc.certify(ELASTIC)  # type: ignore[call-overload]


def test_a_start_inside_the_wall_is_refused() -> None:
    with pytest.raises(ParameterError, match="below the wall"):
        pc.certify(pc.simulate(ELASTIC, v0=1, t_end=3.0), start=pc.Start(-1, 0))


def test_whole_numbers_of_numpy_are_whole_numbers() -> None:
    proven = pc.certify(chaotic(3), digits=np.int64(20), max_impacts=np.int64(2))  # type: ignore[call-overload]

    assert len(proven.impacts) == 2
    assert proven.impacts.t.digits().min() >= 20


def test_a_start_that_is_none_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"not \(x0, v0\) or \(x0, v0, t0\)"):
        pc.certify(chaotic(2), start=(0,))


@pytest.mark.parametrize("n", [1, 2.5, True, "3"])
def test_samples_of_no_number_are_refused(n: object) -> None:
    with pytest.raises(ParameterError, match="not a whole number of at least 2"):
        pc.certify(chaotic(2)).sample(n)  # type: ignore[arg-type]


@pytest.mark.parametrize("t", [None, "soon", math.nan, [1.0, math.inf], 1j])
def test_times_that_are_no_numbers_are_refused_by_name(t: object) -> None:
    with pytest.raises(ParameterError, match=r"^t = "):
        pc.certify(chaotic(2))(t)  # type: ignore[arg-type]


@pytest.mark.parametrize("what", [None, 3, "wall", [], {}])
def test_what_is_no_oscillator_and_no_force_is_said(what: Any) -> None:
    other: Any
    force, other = pc.cosine("14/5"), 3 if what is None else what
    for name, asked in (
        ("osc", lambda: list_orbits(what, force, speeds=("1/5", 3))),
        ("osc", lambda: keeps_eigenset(what, force, 1)),
        ("force", lambda: list_orbits(ELASTIC, other, speeds=("1/5", 3))),
        ("force", lambda: keeps_eigenset(ELASTIC, other, 1)),
    ):
        with pytest.raises(ParameterError, match=f"^{name} = .*: not a"):
            asked()


@pytest.mark.parametrize("over", ["forcing.constant", 3, (1, 2), [], {"a": 1, "b": 2}])
def test_a_range_that_is_none_is_refused(over: Any) -> None:
    with pytest.raises(ParameterError, match="not one parameter and its values"):
        pc.certify(chaotic(2), over=over)


@pytest.mark.parametrize("what", [None, 3, [], [3], ELASTIC])
def test_attractors_that_are_none_are_refused(what: Any) -> None:
    with pytest.raises(ParameterError, match="neither an orbit nor a list of orbits"):
        prove_basins(what, x0=(0, 1), v0=(0, 1))


@pytest.mark.parametrize("cells", [None, "", "12", (1, 2, 3), 2.5, (1, 0), {}])
def test_cells_that_are_no_numbers_are_refused(cells: Any) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("7/10"), pc.cosine("23/10"))

    with pytest.raises(ParameterError, match="cells = "):
        prove_basins(orbit, x0=(0, 1), v0=(0, 1), cells=cells)


@pytest.mark.parametrize("digits", [None, "x", 0, -1, 1.5, math.nan])
def test_digits_of_a_ball_that_are_no_number_are_refused(digits: Any) -> None:
    ball = pc.certify(chaotic(1)).impacts.t[0]

    for text in (ball.text, ball.decimals):
        with pytest.raises(ParameterError, match="digits = "):
            text(digits)
