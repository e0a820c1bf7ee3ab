"""Studies as people write them: a sea, no forcing at all, measures, extremes in the summary."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import percuss as pc
from percuss.errors import StudyError
from percuss.io import load_netcdf
from percuss.studies import load_study, parse_study
from percuss.studies.running import run_study

MOORING = """
[oscillator]
mass = 200
stiffness = 50
damping_coefficient = 5
units = {length = "m", time = "s", mass = "t"}

[[oscillator.stops]]
type = "soft"
at = 2
side = "above"
stiffness = 500
damping = 20
"""
SEA = """
[forcing.sea_state]
hs = 3
tp = "9"
n = 25
seed = 4
amplitude = 200
"""
RUN = "[start]\nx0 = 0\nv0 = 0\n[run]\nt_end = 100\n"
CYCLE = """
[oscillator]
stiffness = 1
damping = "-0.05"
[[oscillator.stops]]
type = "soft"
at = 1
side = "above"
stiffness = 0
damping = "0.3"
[start]
x0 = "0.5"
v0 = "0.1"
[over]
"oscillator.damping" = ["-0.05", "-0.04"]
"""


def numbers_of(force: pc.Forcing) -> list[tuple[float, ...]]:
    return [
        (float(part.amplitude), float(part.omega), float(part.phase))
        for part in force.harmonics
        if isinstance(part, pc.Harmonic)
    ]


def test_a_sea_is_that_of_the_call() -> None:
    study = parse_study(MOORING + SEA + RUN)

    expected = 200 * pc.sea_state(hs=3, tp="9", n=25, seed=4)
    assert study.forcing is not None
    assert numbers_of(study.forcing) == numbers_of(expected)
    assert parse_study(study.text()).forcing == study.forcing


def test_the_force_of_a_sea_may_be_an_expression() -> None:
    text = MOORING + SEA.replace("amplitude = 200", 'amplitude = "2*F"') + RUN
    study = parse_study("[parameters]\nF = 100\n" + text)

    osc, force, _ = pc.model.replace_parameters(study.oscillator, study.forcing, None, {"F": 50})
    expected = 100 * pc.sea_state(hs=3, tp="9", n=25, seed=4)
    assert osc == study.oscillator
    assert force is not None
    assert numbers_of(force) == numbers_of(expected)


def test_a_sea_is_added_to_the_other_forces() -> None:
    both = parse_study(
        MOORING + "[forcing]\nconstant = 10\n[[forcing.harmonics]]\namplitude = 1\nomega = 2\n"
        "[forcing.record]\nt = [0, 1]\nf = [0, 1]\n" + SEA + RUN
    ).forcing

    assert both is not None
    assert (both.constant, len(both.harmonics)) == (10, 26)
    assert both.record is not None
    assert both.period is None


@pytest.mark.parametrize(
    ("sea", "faults"),
    [
        ("hs = -1\ntp = 9\n", ["16: forcing.sea_state.hs = -1: not positive"]),
        ("hs = 1\n", ["15: forcing.sea_state.tp: missing"]),
        ("hs = 1\ntp = 9\nseed = -2\n", ["18: forcing.sea_state.seed = -2: "]),
        ("hs = 1\ntp = 9\nn = 0\n", ["18: forcing.sea_state.n = 0: "]),
        ('hs = 1\ntp = 9\nkind = "jonswop"\n', ['18: forcing.sea_state.kind = "jonswop": not']),
        ("hss = 1\ntp = 9\n", ['16: forcing.sea_state.hss: unknown key; did you mean "hs"?']),
        ("hs = 1\ntp = 9\namplitude = true\n", ["18: forcing.sea_state.amplitude = true: not a"]),
        ("hs = 1\ntp = 0\nn = 1.5\n", ["18: forcing.sea_state.n = 1.5: not a whole number"]),
        (
            'hs = "a"\ntp = 0\nkind = "jonswop"\nn = 0\nseed = -1\nfoo = 1\namplitude = "b"\n',
            [
                '16: forcing.sea_state.hs = "a": not a number',
                "17: forcing.sea_state.tp = 0: not positive",
                '18: forcing.sea_state.kind = "jonswop": not',
                "19: forcing.sea_state.n = 0: not a whole",
                "20: forcing.sea_state.seed = -1: not a whole",
                "21: forcing.sea_state.foo: unknown key",
                '22: forcing.sea_state.amplitude = "b": not a number',
            ],
        ),
    ],
)
def test_what_is_wrong_with_a_sea_is_said_with_line_and_path(sea: str, faults: list[str]) -> None:
    with pytest.raises(StudyError) as error:
        parse_study(MOORING + "\n[forcing.sea_state]\n" + sea + RUN)

    for fault in faults:
        assert f"study:{fault}" in str(error.value)


def test_a_sea_does_not_go_with_a_fourier_sum() -> None:
    with pytest.raises(StudyError, match=r"forcing\.sea_state: given together with omega"):
        parse_study(MOORING + "[forcing]\nomega = 1\ncos = [1]\n" + SEA + RUN)


def test_a_study_measures_a_motion_without_a_period(tmp_path: Path) -> None:
    text = (
        '[study]\nkind = "sweep"\n' + MOORING + SEA + "[start]\nx0 = 0\nv0 = 0\n"
        '[over]\n"oscillator.stops.0.at" = [2, 3]\n'
        '[sweep]\nmeasure = ["peak_stop_force", "contact_share"]\nbetween = [50, "350"]\n'
    )
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    study = load_study(tmp_path / "s.toml")

    found = run_study(study, tmp_path / "out").answer

    expected = pc.sweep(
        ["peak_stop_force", "contact_share"],
        study.oscillator,
        study.forcing,
        over={"oscillator.stops.0.at": [2, 3]},
        between=(50, 350),
    )
    np.testing.assert_array_equal(found.peak_stop_force, expected.peak_stop_force)
    assert (found.peak_stop_force.values > 0).all()
    assert found.peak_stop_force.attrs["units"] == "kN"
    rows = study.question.report(found)
    assert rows["peak_stop_force"].endswith(f"{float(found.peak_stop_force.max()):.8g} kN")
    assert not rows["contact_share"].endswith("1 1")
    assert parse_study(study.text()).question == study.question


@pytest.mark.parametrize(
    ("sweep", "fault"),
    [
        ('measure = "max_displacement"\n', "forcing.period: missing; measures count in forcing"),
        ('measure = "period"\nbetween = [0, 9]\n', 'sweep.measure = "period": counted over whole'),
        ('measure = "max_displacement"\nbetween = [9, 0]\n', "sweep.between = [9, 0]: not two"),
        ('measure = "max_displacement"\nbetween = [9]\n', "sweep.between = [9]: 1 values; 2 are"),
        ('measure = "max_displacement"\nbetween = [0, "x"]\n', 'sweep.between.1 = "x": not a'),
        (
            'measure = "max_displacement"\nbetween = [0, 9]\nperiods = 3\n',
            "sweep.periods: given together with between",
        ),
    ],
)
def test_what_is_wrong_with_a_span_is_said(sweep: str, fault: str) -> None:
    over = '[over]\n"oscillator.stops.0.at" = [2, 3]\n'
    with pytest.raises(StudyError) as error:
        parse_study('[study]\nkind = "sweep"\n' + MOORING + SEA + over + "[sweep]\n" + sweep)

    assert len(error.value.faults) == 1
    assert fault in str(error.value)


def test_limit_cycles_are_swept_and_drawn(tmp_path: Path) -> None:
    section = 'section = {at = 0, direction = "up"}\n'
    sweep = parse_study(
        '[study]\nkind = "sweep"\n' + CYCLE + '[sweep]\nmeasure = ["period", "max_displacement"]\n'
        "transient = 400\n" + section
    )
    head, _, rest = CYCLE.partition("[start]")
    over = "[over]" + rest.partition("[over]")[2]
    diagram = parse_study(
        '[study]\nkind = "diagram"\n' + head + over + '[diagram]\nstarts = [["0.5", "0.1"]]\n'
        'transient = 400\nmeasures = ["max_displacement"]\n' + section
    )

    swept = run_study(sweep, tmp_path / "sweep")
    drawn = run_study(diagram, tmp_path / "diagram")

    for branch in ("forward", "start 0"):
        one = drawn.answer.sel(branch=branch)
        np.testing.assert_allclose(one.period, swept.answer.period, rtol=1e-9)
        np.testing.assert_allclose(one.max_displacement, swept.answer.max_displacement, rtol=1e-9)
    assert (tmp_path / "sweep" / "period.png").exists()
    assert (tmp_path / "diagram" / "diagram.png").exists()
    for study in (sweep, diagram):
        assert parse_study(study.text()).question == study.question
    assert "6.312" in " ".join(diagram.question.report(drawn.answer).values())


@pytest.mark.parametrize(
    ("kind", "question", "fault"),
    [
        ("sweep", '[sweep]\nmeasure = "period"\n', "forcing: missing harmonics; without a forcing"),
        ("diagram", "[diagram]\npoints = 9\n", 'give diagram.section = "impacts" or {at = 0.0}'),
        (
            "diagram",
            "[diagram]\nsection = {cycle = 0.5}\n",
            "16: diagram.section = {cycle = 0.5}: without a forcing there are no strobes",
        ),
        ("diagram", '[diagram]\nmeasures = ["peak"]\nsection = "impacts"\n', "diagram.measures.0"),
    ],
)
def test_free_motions_need_a_section(kind: str, question: str, fault: str) -> None:
    head, _, rest = CYCLE.partition("[start]")
    over = "[over]" + rest.partition("[over]")[2]
    with pytest.raises(StudyError) as error:
        parse_study(f'[study]\nkind = "{kind}"\n' + head + over + question)

    assert len(error.value.faults) == 1
    assert fault in str(error.value)


def test_the_summary_of_a_motion_has_its_extremes(tmp_path: Path) -> None:
    study = parse_study(MOORING + SEA + RUN)
    done = run_study(study, tmp_path / "out")

    rows = study.question.report(done.answer)

    pull = done.answer.extremes("stop_force")
    assert pull.minimum < -100.0
    assert f"{pull.minimum:.10g} kN at t = {pull.t_minimum:.10g} s" in rows["force of stop 0"]
    x = done.answer.extremes("displacement")
    assert f"to {x.maximum:.10g} m at t = {x.t_maximum:.10g} s" in rows["displacement"]
    saved = load_netcdf(tmp_path / "out" / "motion.nc").to_dataset()
    np.testing.assert_array_equal(saved.stop_force, done.answer.forces(saved.t.values).stops)
    assert saved.stop_force.attrs["units"] == "kN"


def test_a_stop_that_is_not_touched_has_no_force_in_the_summary() -> None:
    study = parse_study("[oscillator]\nstiffness = 1\n[start]\nx0 = 1\nv0 = 0\n[run]\nt_end = 9\n")
    rows = study.question.report(pc.simulate(study.oscillator, x0=1, t_end=9))
    assert not [name for name in rows if name.startswith("force")]
    assert rows["displacement"].startswith("-1 at t = 3.14159265")


def test_measures_of_attractors_stand_in_the_report(tmp_path: Path) -> None:
    study = parse_study(
        '[study]\nkind = "basins"\n[oscillator]\ndamping = "0.05"\n[[oscillator.stops]]\n'
        'type = "wall"\nat = "1.45789"\nside = "above"\nrestitution = "0.7"\n'
        '[[forcing.harmonics]]\namplitude = 1\nomega = "1.5"\n'
        '[basins]\nx0 = ["-3.4", "0.37"]\nv0 = [0]\nmeasures = ["peak_impact_velocity"]\n'
        "[draw]\npng = false\nsvg = false\n"
    )
    done = run_study(study, tmp_path / "out")

    rows = study.question.report(done.answer)
    values = done.answer.peak_impact_velocity.values
    assert values.min() == 0.0 < values.max()
    for i, value in enumerate(values):
        assert rows[f"attractor {i}, peak_impact_velocity"] == f"{value:.10g}"
    assert parse_study(study.text()).question == study.question


def test_measures_of_a_diagram_have_their_units_in_the_report(tmp_path: Path) -> None:
    study = parse_study(
        '[study]\nkind = "diagram"\n[oscillator]\nmass = 2\nstiffness = 8\n'
        'damping_ratio = "0.1"\nunits = {length = "m", time = "s", mass = "kg"}\n'
        "[[forcing.harmonics]]\namplitude = 8\nomega = 2\n"
        '[over]\n"forcing.omega" = [2, 3]\n[diagram]\ntransient = 9\npoints = 9\n'
        'measures = ["max_displacement"]\n[draw]\npng = false\nsvg = false\n'
    )
    report = run_study(study, tmp_path / "out").report
    assert report["max_displacement"].endswith(" m")


def test_a_table_under_another_name_is_not_missing_as_well() -> None:
    with pytest.raises(StudyError) as error:
        parse_study(
            '[study]\nkind = "sweep"\n[oscillator]\n[[forcing.harmonics]]\namplitude = 1\n'
            'omega = 2\n[Over]\n"forcing.omega" = [1]\n[sweep]\nmeasure = "period"\n'
        )
    assert str(error.value) == 'study:7: Over: unknown key; did you mean "over"?'
