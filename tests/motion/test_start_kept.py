"""A run keeps its start as it was given, also through files."""

from __future__ import annotations

import pickle
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import percuss as pc
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
