"""Sections of diagrams in study files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.errors import StudyError
from percuss.execution import Execution
from percuss.plotting import plot_diagram
from percuss.studies.kinds.diagram import Diagram
from percuss.studies.reading import load_study, parse_study
from percuss.studies.running import run_study
from percuss.web.code_text import python_text

STUDY = """
[study]
kind = "diagram"
[oscillator]
damping = "0.05"
stops = [{type = "wall", at = "0.2", side = "above", restitution = "0.8"}]
[[forcing.harmonics]]
amplitude = 1
omega = "2.5"
[over]
"forcing.omega" = ["2.2", "2.3", "2.4"]
[diagram]
section = SECTION
transient = 50
points = 20
"""
SECTIONS = {
    '{at = "0.1", direction = "up"}': {"at": 0.1, "direction": "up"},
    '{at = -0.25}': {"at": -0.25, "direction": "both"},
    '{cycle = "1/4"}': {"cycle": 0.25},
    '"impacts"': "impacts",
    '"stroboscopic"': "stroboscopic",
}  # fmt: skip


@pytest.mark.parametrize("text", SECTIONS)
def test_a_diagram_at_a_section_is_written_and_repeated(text: str, tmp_path: Path) -> None:
    study = parse_study(STUDY.replace("SECTION", text))

    assert isinstance(study.question, Diagram)
    assert parse_study(study.text()) == study
    files = run_study(study, tmp_path).files
    for file in files:
        assert load_study(file) == study
    found = pc.load_netcdf(tmp_path / "diagram.nc")
    over: dict[str, Any] = {"forcing.omega": ["2.2", "2.3", "2.4"]}
    direct = pc.bifurcation_diagram(
        study.oscillator, study.forcing, over=over, section=SECTIONS[text],  # type: ignore[arg-type]
        transient=50, points=20,
    )  # fmt: skip
    for name in direct.data_vars:
        if name != "reason":
            np.testing.assert_array_equal(found[name], direct[name])
    assert plot_diagram(found).get_ylabel() == plot_diagram(direct).get_ylabel()
    assert repr(SECTIONS[text]) in python_text(study) or text == '"stroboscopic"'


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            '"poincare"',
            'diagram.section = "poincare": neither stroboscopic nor impacts, nor a cycle',
        ),
        ("{at = 1, way = 2}", 'a place such as {at = 0.3, direction = "up"}'),
        ('{at = 1, direction = "left"}', 'direction = "left": none of up, down, both'),
        ("{cycle = 2}", "cycle = 2.0: not in [0, 1)"),
        ("3", "diagram.section = 3: neither stroboscopic"),
    ],
)
def test_a_section_that_is_none_is_one_fault_with_its_line(text: str, fault: str) -> None:
    with pytest.raises(StudyError) as caught:
        parse_study(STUDY.replace("SECTION", text))

    (line,) = str(caught.value).split("\n")
    assert line.startswith("study:13: diagram.section")
    assert fault in line


def test_the_summary_of_a_diagram_tells_motions_without_a_point_and_its_measures() -> None:
    study = parse_study(
        '[study]\nkind = "diagram"\n'
        '[oscillator]\nstiffness = 1\ndamping = "0.1"\n'
        '[[oscillator.stops]]\ntype = "wall"\nat = 2\nside = "above"\nrestitution = "0.8"\n'
        "[[forcing.harmonics]]\namplitude = 1\nomega = 2\n"
        '[over]\n"forcing.omega" = [1, 2, "2.1"]\n'
        '[diagram]\nsection = "impacts"\nstarts = [[0, 0]]\nfollow = []\ntransient = 100\n'
        'points = 10\nmeasures = ["peak_displacement"]\n'
    )
    result = study.question.answer(study, Execution())
    rows = study.question.report(result)

    assert rows["start 0, periods"] == "no point on the section: 2, 1: 1"
    low, high = (float(text) for text in rows["peak_displacement"].split(" to "))
    assert (low, high) == pytest.approx((0.2911, 2.066), abs=1e-3)
