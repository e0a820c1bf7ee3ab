"""Parameters on the page: a slider for each, links, Python, and diagrams over them."""

from __future__ import annotations

import copy
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.web.frames import read_frame
from tests.web.hands import box_of, drawn, follow_link, set_box, slider_of, wait_for_drawing

import percuss as pc
from percuss.errors import StudyError
from percuss.web.code_text import python_text
from percuss.web.explore import answer_explore
from percuss.web.jobs import answer_job
from percuss.web.request import PageRequest, RunningRequest, study_of
from percuss.web.view_study import study_of_view
from percuss.web.widget import _tables

BALL: dict[str, Any] = {
    "parameters": {"w": "1.7"},
    "oscillator": {
        "stiffness": 0,
        "stops": [{"type": "wall", "at": 0, "side": "below", "restitution": "0.15"}],
    },
    "forcing": {"constant": -1, "harmonics": [{"amplitude": "w**2", "omega": "w"}]},
    "start": {"x0": 0, "v0": 1},
    "run": {"periods": 40},
}


def with_changes(**changes: Any) -> dict[str, Any]:
    tables = copy.deepcopy(BALL)
    for table, values in changes.items():
        tables[table] |= values
    return tables


def test_a_motion_with_parameters_is_that_of_its_numbers() -> None:
    plain = with_changes(forcing={"harmonics": [{"amplitude": "2.89", "omega": "1.7"}]})
    del plain["parameters"]
    found = [read_frame(answer_explore(PageRequest(1, "explore", it, {}))) for it in (BALL, plain)]
    (header, arrays), (plain_header, plain_arrays) = found
    assert header["n_impacts"] == plain_header["n_impacts"] > 0
    np.testing.assert_array_equal(arrays["x"], plain_arrays["x"])


def test_a_diagram_goes_over_a_parameter() -> None:
    options = {"path": "parameters.w", "low": 1.66, "high": 1.7, "values": 3, "points": 4}
    study = study_of_view(PageRequest(1, "diagram", BALL, options))
    assert list(study.question.over) == ["w"]  # type: ignore[attr-defined]
    frames = list(answer_job(PageRequest(1, "diagram", BALL, options), RunningRequest()))
    header, arrays = read_frame(frames[-1])
    assert header["path"] == "w"
    assert len(arrays)


def test_a_parameter_that_a_slider_has_made_useless_is_no_fault() -> None:
    untied = with_changes(forcing={"harmonics": [{"amplitude": 3, "omega": 2}]})
    assert study_of(untied).forcing == pc.Forcing((pc.Harmonic(3, 2),), -1)


def test_faults_name_the_row_of_the_parameter() -> None:
    for value, reason in (("one", "not a number"), ("1/0", "division by zero")):
        with pytest.raises(StudyError, match=r"parameters\.w") as caught:
            study_of(with_changes(parameters={"w": value}))
        assert reason in str(caught.value)
    with pytest.raises(StudyError, match=r"forcing.harmonics.0.amplitude.*open\(\) is not allowed"):
        study_of(with_changes(forcing={"harmonics": [{"amplitude": "open(w)", "omega": "w"}]}))


def test_python_of_a_motion_with_parameters_is_the_same_motion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tables = with_changes(start={"v0": "sqrt(w)"})
    tables["forcing"]["harmonics"][0]["amplitude"] = "0.98*w**2"
    study = study_of(tables)
    text = python_text(study)
    assert "pc.expression('0.98*w**2', w='1.7')" in text
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.py").write_text(text)
    names = runpy.run_path(str(tmp_path / "script.py"))
    assert (names["osc"], names["force"]) == (study.oscillator, study.forcing)
    assert names["run"].start == study.question.start  # type: ignore[attr-defined]


def test_the_widget_begins_with_the_parameters_of_a_model() -> None:
    w = pc.parameter("w", "1.7")
    tables = _tables(pc.impact_oscillator(), pc.cosine(w, amplitude=w**2), w / 2, 0, 10)
    assert tables["parameters"] == {"w": "1.7"}
    assert study_of(tables).forcing == pc.cosine(w, amplitude=w**2)


def test_a_link_with_parameters_opens_with_a_slider_for_each(page: Page, address: str) -> None:
    state = {"view": "explore", "study": BALL}
    follow_link(page, address, state)

    expect(box_of(page, "parameters.w")).to_have_value("1.7")
    expect(box_of(page, "forcing.harmonics.0.amplitude")).to_have_value("w**2")
    expect(slider_of(page, "forcing.harmonics.0.amplitude")).to_be_disabled()
    expect(slider_of(page, "parameters.w")).to_be_enabled()

    before = drawn(page)
    set_box(page, "parameters.w", "1.8")
    wait_for_drawing(page, before)
    page.wait_for_function(
        "() => atob(location.hash.slice(1).replaceAll('-', '+').replaceAll('_', '/')).includes('\"w\":\"1.8\"')"
    )
    set_box(page, "parameters.w", "-1")
    expect(page.locator(".row .fault", has_text="not positive")).to_be_visible()

    page.locator("[data-view=diagram]").click()
    choices = page.locator("#p-view-diagram select").nth(1).locator("option")
    found = choices.evaluate_all("rows => rows.map(row => row.value)")
    assert found[0] == "parameters.w"
    assert "forcing.harmonics.0.amplitude" not in found
    assert "forcing.harmonics.0.phase" in found
