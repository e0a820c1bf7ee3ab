"""The page speaks of parameters and fields, not of code."""

from __future__ import annotations

from typing import Any

import pytest
from matplotlib.figure import Figure

from percuss.errors import StudyError
from percuss.web import downloads
from percuss.web.downloads import file_of
from percuss.web.request import BadRequest, PageRequest, study_of
from percuss.web.session import _fault
from percuss.web.view_study import study_of_view
from percuss.web.wording import axis_name, name_axes, plain

DIAGRAM = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "values": 20, "points": 4}


def reasons(study: dict[str, Any]) -> str:
    with pytest.raises(StudyError) as caught:
        study_of(study)
    return "; ".join(_fault(fault)["reason"] for fault in caught.value.faults)


def test_faults_say_nothing_of_code_or_of_files(study: dict[str, Any]) -> None:
    study["start"]["x0"] = 2
    assert "a soft stop can be entered" in reasons(study)
    study["start"]["x0"] = "zero"
    assert reasons(study).endswith("not a number, such as 2.8 or 1/3")


@pytest.mark.parametrize(
    ("kind", "options", "words"),
    [
        ("diagram", {"low": 5, "high": 3}, "from = 5 is not below to = 3"),
        ("diagram", {"points": 1}, "points at each = 1 is not between"),
        ("basins", {"x_low": 5, "x_high": 3}, "x from = 5 is not below x to = 3"),
        ("basins", {"starts": 0}, "starts along a side = 0 is not between"),
        ("response", {"max_impacts": 0}, "impacts up to = 0"),
        ("response", {"path": "start.v0"}, "do not depend on a start"),
    ],
)
def test_options_are_called_what_their_fields_are(
    study: dict[str, Any], kind: str, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(BadRequest, match=words):
        study_of_view(PageRequest(1, kind, study, {**DIAGRAM, **options}))


def test_pictures_name_parameters_and_the_phase_of_their_section(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Figure] = []
    real = name_axes

    def hear(figure: Figure, it: Any) -> None:
        real(figure, it)
        seen.append(figure)

    monkeypatch.setattr(downloads, "name_axes", hear)
    file_of(PageRequest(1, "diagram", study, DIAGRAM), "png")
    study["start"]["t0"] = "0.25"
    file_of(PageRequest(1, "diagram", study, DIAGRAM), "png")
    labels = [(it.axes[0].get_xlabel(), it.axes[0].get_ylabel()) for it in seen]

    omega = r"forcing frequency $\omega$ (dimensionless)"
    assert labels[0] == (omega, "x at whole periods (dimensionless)")
    assert labels[1][1] == "x at $t$ = 0.25 + whole periods (dimensionless)"


def test_other_words_stay() -> None:
    assert plain("negative") == "negative"
    assert axis_name("displacement $x$") == "displacement $x$"
    assert axis_name("forcing phase, harmonic 1") == "forcing phase, harmonic 2"


def test_a_diagram_over_the_start_is_the_start(study: dict[str, Any]) -> None:
    options = {**DIAGRAM, "path": "start.v0", "low": 0.1, "high": 0.9}
    asked = study_of_view(PageRequest(1, "diagram", study, options))

    assert list(asked.question.over) == ["start.v0"]  # type: ignore[attr-defined]
    assert file_of(PageRequest(1, "diagram", study, options), "csv").data.count(b"\n") > 20 * 4
