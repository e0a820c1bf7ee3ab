"""``[parameters]`` of study files: expressions that are read, written, and never executed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.errors import StudyError
from percuss.io.exact_json import decoded, encoded
from percuss.studies.reading import load_study, parse_study
from percuss.studies.running import run_study

BALL = """
[study]
kind = "branch"

[parameters]
w = "1.66"
A = 1

[oscillator]
stiffness = 0

[[oscillator.stops]]
type = "wall"
at = 0
side = "below"
restitution = "0.15"

[forcing]
constant = -1

[[forcing.harmonics]]
amplitude = "A * w**2"
omega = "w"

[orbit]
impacts = 1
periods = 1

[over]
w = ["1.66", "1.79"]

[save]
csv = true
"""
W = pc.parameter("w", "1.66")


def faults_of(text: str) -> list[str]:
    with pytest.raises(StudyError) as caught:
        parse_study(text)
    return str(caught.value).split("\n")


def test_a_study_with_parameters_is_read_and_written_as_it_was() -> None:
    study = parse_study(BALL)
    assert study.forcing is not None
    assert study.forcing == pc.cosine(W, amplitude=pc.parameter("A", 1) * W**2, constant=-1)
    assert 'amplitude = "A*w**2"' in study.text()
    assert '[parameters]\nA = 1\nw = "1.66"' in study.text()
    assert parse_study(study.text()) == study


def test_a_file_that_a_study_wrote_repeats_it(tmp_path: Path) -> None:
    study = parse_study(BALL)
    files = run_study(study, tmp_path).files
    branch = pc.load_netcdf(tmp_path / "branch.nc")
    for file in files:
        assert load_study(file) == study
    assert branch.special_points[0].value == pytest.approx(1.670269622, abs=6e-10)
    assert branch.path == "w"
    assert branch.orbits[0].forcing == study.forcing
    np.testing.assert_array_equal(
        branch.values, [float(o.forcing.harmonics[0].omega) for o in branch.orbits]
    )


def test_results_saved_by_hand_carry_their_parameters(tmp_path: Path) -> None:
    osc = pc.impact_oscillator("0.15", stiffness=0)
    force = pc.cosine(W, amplitude=W**2, constant=-1)
    run = pc.simulate(osc, force, x0=0, v0=W / 2, t0=W, periods=10)
    pc.save_netcdf(run, tmp_path / "run.nc")
    study = load_study(tmp_path / "run.nc")
    assert (study.oscillator, study.forcing) == (osc, force)
    assert (study.question.start.v0, study.question.start.t0) == (W / 2, W)  # type: ignore[attr-defined]
    again = study.question.answer(study, _execution())
    np.testing.assert_array_equal(again.impacts.t, run.impacts.t)


def _execution() -> Any:
    from percuss.execution import Execution

    return Execution()


def test_values_in_files_are_expressions_again_and_bad_ones_are_refused() -> None:
    force = pc.cosine(W, amplitude=0.1 * W**2, phase=pc.pi_times(1, 2) + W)
    assert decoded(encoded(force)) == force
    text = encoded(W)
    text["fields"]["text"] = "__import__('os')"
    with pytest.raises(pc.ParameterError):
        decoded(text)


def test_all_faults_of_parameters_are_told_at_once_with_line_and_path() -> None:
    text = (
        BALL.replace("A = 1", 'A = "w + 1"\nomega = 2\nq = "one"\nu = true\nz = "sqrt(-1)"')
        .replace('"0.15"', '"w"')
        .replace("constant = -1", 'constant = "sin(w"')
        .replace("at = 0", 'at = "open(w)"')
        .replace('omega = "w"', 'omega = "ww"')
        .replace("stiffness = 0", 'stiffness = "2**10**10"\ndamping = "1/(w - 1.66)"')
    )
    assert faults_of(text) == [
        (
            'study:7: parameters.A = "w + 1": an expression; a parameter is a number, and others are '
            "expressions of it"
        ),
        (
            "study:8: parameters.omega = 2: a word of paths, results or expressions; give it another "
            "name, such as w"
        ),
        (
            'study:9: parameters.q = "one": not a number; write 2.8, or "2.8" for that decimal, "1/3" '
            'for that fraction, "pi/2" for that multiple of pi'
        ),
        (
            'study:10: parameters.u = true: not a number; write 2.8, or "2.8" for that decimal, "1/3" '
            'for that fraction, "pi/2" for that multiple of pi'
        ),
        'study:11: parameters.z = "sqrt(-1)": the square root of a negative number',
        (
            'study:14: oscillator.stiffness = "2**10**10": no exponent; a whole number from -64 to 64 '
            "is one, and sqrt(x) the power 1/2"
        ),
        'study:15: oscillator.damping = "1/(w-1.66)": a division by zero',
        'study:19: oscillator.stops.0.at = "open(w)": open() is not allowed; sqrt, sin and cos are',
        (
            'study:21: oscillator.stops.0.restitution = "w" = 1.66: outside [0, 1]; above 1 an impact '
            "would create energy"
        ),
        (
            'study:24: forcing.constant = "sin(w": no expression such as 0.15*w**2: a sign, a number '
            "or a parenthesis is missing"
        ),
        'study:28: forcing.harmonics.0.omega = "ww": ww is no parameter; did you mean w?',
    ]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("A = 1", "A = 1\nB = 2", "study:8: parameters.B: no number of the model uses it"),
        (
            'restitution = "0.15"',
            'restitution = "w - 0.7"',
            ('study:30: over.w.1 = "1.79": there oscillator.stops.0.restitution = w-0.7 is outside '
            "[0, 1]"),
        ),
        (
            "w = [",
            '"forcing.amplitude" = [',
            ("study:30: over.forcing.amplitude: tied to A and w by forcing.harmonics.0.amplitude = "
            "A*w**2; change A and w"),
        ),
        (
            '[parameters]\nw = "1.66"\nA = 1\n',
            "",
            ('study:20: forcing.harmonics.0.omega = "w": not a number; write 2.8, or "2.8" for that '
            'decimal, "1/3" for that fraction'),
        ),
        ("[parameters]", "[paramters]", 'study:5: paramters: unknown key; did you mean "parameters"?'),
        ("w = [", "v = [", "study:30: over.v: no such parameter"),
    ],
)  # fmt: skip
def test_a_fault_of_a_parameter_names_its_place(old: str, new: str, fault: str) -> None:
    assert any(line.startswith(fault) for line in faults_of(BALL.replace(old, new, 1)))


def test_a_parameter_that_is_not_used_hides_no_other_fault() -> None:
    wrong = BALL.replace('w = ["1.66"', 'ww = ["1.66"')
    found = faults_of(wrong.replace("A = 1", "A = 1\nspare = 3"))
    assert any("parameters.spare: no number of the model uses it" in fault for fault in found)
    assert len(found) == 1 + len(faults_of(wrong)) == 2


@pytest.mark.parametrize(
    ("kind", "names"), [("lyapunov", {"largest", "smallest"}), ("orbit", {"orbit", "stability"})]
)
def test_questions_about_a_limit_cycle_need_no_table(kind: str, names: set[str]) -> None:
    text = f"""
        study = {{kind = "{kind}"}}
        oscillator.damping = "-0.05"
        [[oscillator.stops]]
        type = "wall"
        at = 1
        side = "above"
        restitution = "0.6"
        """
    study = parse_study(text + ('[start]\nx0 = "0.1"\nv0 = 0' if kind == "lyapunov" else ""))
    answer = study.question.answer(study, _execution())
    assert names <= study.question.report(answer).keys()


def test_a_parameter_with_the_name_of_the_measure_asked_for_is_a_fault() -> None:
    text = """[study]
kind = "sweep"
[parameters]
min_displacement = "0.05"
[oscillator]
damping = "min_displacement"
[forcing]
omega = 2
cos = [1]
[sweep]
measure = ["min_displacement"]
[over]
min_displacement = ["0.05", "0.1"]
"""
    assert faults_of(text) == [
        (
            "study:13: over.min_displacement: the name of a measure that is asked for; give the "
            "parameter another name"
        )
    ]


def test_parameters_that_are_no_table_are_a_fault() -> None:
    text = BALL.replace('[parameters]\nw = "1.66"\nA = 1\n', "").replace(
        "\n[study]", "parameters = 3\n[study]", 1
    )
    assert "study:1: parameters = 3: not a table" in faults_of(text)


def test_start_and_run_may_be_expressions() -> None:
    study = parse_study(
        BALL.split("[orbit]", maxsplit=1)[0].replace("branch", "motion")
        + '[start]\nx0 = 0\nv0 = "sqrt(w)"\nt0 = "pi/2"\n[run]\nt_end = "40*pi/w"\n'
    )
    run = study.question.answer(study, _execution())
    assert run.t_end == pytest.approx(40 * np.pi / 1.66, rel=1e-15)
    assert float(run.start.v0) == np.sqrt(1.66)
    assert parse_study(study.text()) == study


def test_a_number_may_be_a_multiple_of_pi_without_parameters() -> None:
    text = """
[oscillator]
stiffness = "4*pi**2"
damping = "pi/10"
[[forcing.harmonics]]
amplitude = 1
omega = "2*pi"
phase = "pi/2"
[start]
x0 = 0
v0 = "pi"
[run]
periods = 3
"""
    study = parse_study(text)
    assert study.forcing == pc.cosine(pc.expression("2*pi"), phase="pi/2")
    assert float(study.oscillator.damping) == np.pi / 10
    assert study.question.answer(study, _execution()).t_end == 3.0
    assert parse_study(study.text()) == study


def test_a_model_with_a_mass_keeps_its_parameters() -> None:
    text = """
[parameters]
m = 2
[oscillator]
mass = "m"
stiffness = "25*m"
damping_ratio = "0.05"
[start]
x0 = 1
v0 = 0
[run]
t_end = 1
"""
    study = parse_study(text)
    assert float(study.oscillator.stiffness) == 50.0
    assert float(study.oscillator.of_unit_mass().stiffness) == 25.0
    assert parse_study(study.text()) == study
    assert 'mass = "m"' in study.text()
    named = text.replace(
        'mass = "m"', 'mass = "m"\nunits = {length = "m", time = "s", mass = "kg"}'
    )
    assert parse_study(named).oscillator.units == pc.Units("m", "s", "kg")


def test_numbers_without_parameters_are_what_they_were() -> None:
    assert parse_study(BALL.replace('"A * w**2"', '"sqrt(2)"').replace("A = 1\n", "")).forcing
    text = BALL.replace("stiffness = 0", 'stiffness = "high"').replace('"A * w**2"', '"1"')
    without = text.replace('[parameters]\nw = "1.66"\nA = 1\n', "").replace('"w"', '"1.66"')
    assert 'oscillator.stiffness = "high": not a number; write 2.8' in "\n".join(faults_of(without))
