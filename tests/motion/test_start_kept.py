"""A run keeps its start as it was given, also through files."""

from __future__ import annotations

import pickle
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.errors import ParameterError
from percuss.io import load_record, motion_text, save_netcdf
from percuss.studies import Motion, parse_study


def start_in(text: str) -> pc.Start:
    question = parse_study(text).question
    assert isinstance(question, Motion)
    start: pc.Start = question.start
    return start


@pytest.fixture(scope="module")
def run() -> pc.Trajectory:
    osc = pc.impact_oscillator(wall="0.1")
    return pc.simulate(osc, pc.sine(3), x0=Fraction(1, 3), v0="0.45", t0="pi/3", max_impacts=3)


def test_start_is_kept_and_its_floats_move(run: pc.Trajectory) -> None:
    assert run.start == pc.Start(Fraction(1, 3), "0.45", "pi/3")
    assert (run.x0, run.v0) == (1 / 3, 0.45)
    assert run.t0 == pytest.approx(np.pi / 3, abs=1e-15)
    floats = pc.simulate(run.oscillator, run.forcing, run.x0, run.v0, run.t0, max_impacts=3)
    assert floats.start == pc.Start(run.x0, run.v0, run.t0)
    np.testing.assert_array_equal(floats.impacts.t, run.impacts.t)


def test_start_outlives_a_pickle_the_text_and_a_file(run: pc.Trajectory, tmp_path: Path) -> None:
    save_netcdf(run, tmp_path / "run.nc")

    assert pickle.loads(pickle.dumps(run)).start == run.start
    for text in (motion_text(run), load_record(tmp_path / "run.nc").study):
        start = start_in(text)
        assert (start.x0, start.v0, start.t0) == ("1/3", "0.45", "pi/3")


def test_start_of_numpy_numbers_is_plain() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=np.float64(1.5), t_end=1.0)

    assert type(run.start.v0) is float


def test_start_of_an_orbit_is_its_floats() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))

    assert orbit.trajectory().start == pc.Start(orbit.x0, orbit.v0, orbit.t0)


@pytest.mark.parametrize("start", [pc.Start("0.1", "0.3", "1/3"), ("0.1", "0.3", "1/3")])
def test_a_start_is_given_as_one_value_or_as_three(start: Any) -> None:
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.5")

    run = pc.simulate(osc, force, start=start, t_end=20)

    assert run.start == pc.Start("0.1", "0.3", "1/3")
    same = pc.simulate(osc, force, "0.1", "0.3", "1/3", t_end=20)
    np.testing.assert_array_equal(run.impacts.t, same.impacts.t)
    over = {"forcing.omega": [2.4, 2.5]}
    one = pc.bifurcation_diagram(osc, force, over=over, start=(0, 1), transient=20, points=4)
    several = pc.bifurcation_diagram(osc, force, over=over, starts=[(0, 1)], transient=20, points=4)
    np.testing.assert_array_equal(one.x, several.x)


PAIRS: Any = {0: 1, 2: 3}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda o, f: pc.simulate(o, f, v0=1, start=(0, 1), t_end=1),
            "v0 = 1: given together with",
        ),
        (lambda o, f: pc.simulate(o, f, start=(0,), t_end=1), r"not \(x0, v0\) or \(x0, v0, t0\)"),
        (lambda o, f: pc.simulate(o, f, start=PAIRS, t_end=1), r"not \(x0, v0\) or"),
        (lambda o, f: pc.simulate(o, f, start=(-1, 0), t_end=1), "start.x0 = -1: below the wall"),
        (
            lambda o, f: pc.bifurcation_diagram(
                o, f, over={"forcing.omega": [2.5]}, start=(0, 1), starts=[(0, 2)]
            ),
            "given together with starts",
        ),
    ],
)
def test_a_start_given_wrongly_is_a_sentence(call: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        call(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
