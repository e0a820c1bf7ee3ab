"""A study file is read exactly."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import pytest
from tests.studies.texts import HEAD, RUN, end_of, motion_of

from percuss.errors import StudyError
from percuss.model import (
    Forcing,
    Harmonic,
    Oscillator,
    SoftStop,
    Wall,
    as_float,
    fourier,
    pi_times,
    sine,
)
from percuss.studies import load_study, parse_study


def test_a_quoted_number_is_exact_and_a_bare_one_is_that_double() -> None:
    study = parse_study(HEAD.replace("v0 = 1", 'v0 = "0.51"\nt0 = 0.1') + '[run]\nt_end = "1/3"')

    assert motion_of(study).start.v0 == "0.51"
    assert motion_of(study).start.t0 == 0.1
    assert end_of(study) == 1 / 3


def test_a_phase_of_multiples_of_pi_is_exact() -> None:
    text = HEAD + RUN + '[[forcing.harmonics]]\namplitude = 1\nomega = 3\nphase = "-pi/2"'

    study = parse_study(text)

    assert study.forcing is not None
    assert study.forcing.components() == sine(3).components()


def test_a_phase_may_have_a_part_that_is_no_multiple_of_pi() -> None:
    phase = "-pi/2 + 3/10"
    text = HEAD + RUN + f'[[forcing.harmonics]]\namplitude = 1\nomega = 3\nphase = "{phase}"'

    study = parse_study(text)

    assert study.forcing is not None
    harmonic = study.forcing.harmonics[0]
    assert isinstance(harmonic, Harmonic)
    assert harmonic.phase == pi_times(-1, 2) + Fraction(3, 10)


def test_a_fourier_sum_keeps_its_base_frequency() -> None:
    text = HEAD + RUN + '[forcing]\nconstant = -1\nomega = "0.1"\ncos = [1, "0.2"]\nsin = [0.0, 3]'

    assert parse_study(text).forcing == fourier("0.1", (1, "0.2"), (0.0, 3), constant=-1)


def test_an_end_after_periods_is_rounded_once() -> None:
    text = HEAD + "[run]\nperiods = 1000000\n" + "[[forcing.harmonics]]\namplitude=1\nomega=3\n"

    exact = Decimal("2094395.1023931954923084289221863352561314462662500705473")
    assert end_of(parse_study(text)) == float(exact)


def test_stops_keep_their_order() -> None:
    text = (
        'oscillator.stops = [{type = "soft", at = 1, side = "above", stiffness = 2},\n'
        ' {type = "wall", at = 0, side = "below"}]\nstart = {x0 = 0, v0 = 0}\nrun.max_impacts = 3'
    )

    assert parse_study(text).oscillator.stops == (SoftStop(1, "above", 2), Wall(0, "below"))


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "none.toml"

    with pytest.raises(StudyError) as caught:
        load_study(path)

    assert str(caught.value) == f'{path}: no such file or directory; "percuss new" writes one'


def test_a_folder_is_no_study(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="is a directory"):
        load_study(tmp_path)


def test_bytes_that_are_no_text_are_reported_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "latin.toml"
    path.write_bytes(b"[study]\ntitle = 'caf\xe9'\n")

    with pytest.raises(StudyError) as caught:
        load_study(path)

    assert str(caught.value) == f"{path}:2: not UTF-8 text: byte 20 is 0xe9"


def test_files_with_a_byte_order_mark_and_foreign_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + (HEAD + RUN).replace("\n", "\r\n").encode())

    assert load_study(path) == parse_study(HEAD + RUN)


WITH_MASS = """\
[oscillator]
mass = "50"
stiffness = 20
damping_ratio = "0.25"
stops = [{type = "soft", at = 1, side = "above", stiffness = 400, damping = 10}]
[forcing]
constant = 10
harmonics = [{amplitude = "1/3", omega = 1}]
[start]
x0 = 0
v0 = 0
[run]
t_end = 1
"""


def test_a_study_with_a_mass_is_the_oscillator_with_it_as_in_python() -> None:
    stop = SoftStop(1, "above", 400, 10)
    force = Forcing((Harmonic("1/3", 1),), 10)

    study = parse_study(WITH_MASS)

    assert study.oscillator == Oscillator.from_mass("50", 20, damping_ratio="0.25", stops=(stop,))
    assert study.forcing == force


def test_a_study_with_a_mass_keeps_its_units_in_its_text() -> None:
    study = parse_study(WITH_MASS)

    assert parse_study(study.text()) == study
    assert 'mass = "50"' in study.text()
    assert 'amplitude = "1/3"' in study.text()


def test_a_start_may_be_at_a_multiple_of_pi() -> None:
    study = parse_study(
        HEAD + 't0 = "pi/2 + 1/4"\n' + "[run]\nperiods = 2\n[forcing]\nomega = 2\ncos = [1]"
    )

    assert as_float(motion_of(study).start.t0) == pytest.approx(0.25 + math.pi / 2, rel=1e-15)
    assert end_of(study) == pytest.approx(0.25 + 2.5 * math.pi, rel=1e-15)
    assert parse_study(study.text()) == study


def test_a_motion_begins_at_rest_at_0_without_a_start_unless_a_wall_is_there() -> None:
    text = '[oscillator]\nstops = [{type = "wall", at = %s, side = "below"}]\n[run]\nt_end = 9\n'
    motion = motion_of(parse_study(text % "-1"))
    assert (motion.start.x0, motion.start.v0, motion.start.t0) == (0, 0, 0)
    with pytest.raises(StudyError, match="start: missing; the default x0 = 0 lies below the wall"):
        parse_study(text % "1")
