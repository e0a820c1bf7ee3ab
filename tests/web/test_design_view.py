"""The best setting of free parameters on the page: searched by the server, and put into the sliders."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.web.frames import read_frame
from tests.web.hands import box_of, field, set_box, view_of

import percuss as pc
from percuss.errors import StudyError
from percuss.web.code_text import python_text
from percuss.web.downloads import file_of
from percuss.web.jobs import answer_job
from percuss.web.presets import presets
from percuss.web.request import BadRequest, PageRequest, RunningRequest, study_of
from percuss.web.view_study import study_of_view

GAP = "oscillator.stops.0.at"
# The first motion of the page at a frequency where it repeats.
STUDY: dict[str, Any] = copy.deepcopy(dict(presets()[0].tables))
STUDY["forcing"]["harmonics"][0]["omega"] = "2"
HARDEST = {
    "outcomes": ["peak_impact_velocity"],
    "goals": ["largest"],
    "free": {GAP: [-0.3, 0.3]},
    "limits": {"grazing_margin": [0.1, None]},
    "restarts": 0,
}
HEAVY: dict[str, Any] = {"mass": 2, "stiffness": 2, "damping_coefficient": "0.2", "stops": [
    {"type": "soft", "at": "0.2", "side": "above", "stiffness": 40, "damping": "0.5"}
]}  # fmt: skip


def request(tables: dict[str, Any] = STUDY, **options: Any) -> PageRequest:
    return PageRequest(1, "design", tables, HARDEST | options)


def answered(asked: PageRequest) -> tuple[dict[str, Any], dict[str, Any]]:
    header, arrays = read_frame(list(answer_job(asked, RunningRequest()))[-1])
    return header, arrays


def test_a_design_is_that_of_the_call_and_of_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    header, arrays = answered(request())
    study = study_of(STUDY)
    direct = pc.design(
        "peak_impact_velocity", study.oscillator, study.forcing, goal="largest",
        free={GAP: (-0.3, 0.3)}, subject_to={"grazing_margin": (0.1, None)}, restarts=0,
    )  # fmt: skip

    (best,) = header["designs"]
    assert header["done"]
    assert header["converged"]
    assert best["values"] == {GAP: direct.values[GAP]}
    assert best["outcomes"] == [direct.value]
    assert [name for name, _ in header["report"]][:3] == ["design", GAP, "grazing_margin"]
    # A frame holds single precision.
    run = direct.run
    t = np.clip(arrays["t"].astype(float), run.t0, run.t_end)
    np.testing.assert_allclose(arrays["x"], run(t)[0], atol=1e-5)
    # The portrait of an orbit is closed.
    assert arrays["portrait_x"][0] == arrays["portrait_x"][-1]
    assert arrays["portrait_v"][0] == arrays["portrait_v"][-1]
    assert best["start"] == [*(float(part) for part in run(run.t0)), run.t0]

    asked = study_of_view(request())
    assert file_of(request(), "toml").data.decode() == asked.text()
    assert b"peak_impact_velocity" in file_of(request(), "csv").data
    assert file_of(PageRequest(1, "design", STUDY, HARDEST | {"table": "best"}), "csv").data
    assert file_of(request(), "png").data.startswith(b"\x89PNG")
    monkeypatch.chdir(tmp_path)
    told: dict[str, Any] = {}
    exec(python_text(asked), told)  # noqa: S102  our own text
    assert told["best"].values == direct.values
    assert (tmp_path / "design.png").exists()


def test_a_run_with_a_mass_is_designed_under_the_names_of_the_page() -> None:
    tables: dict[str, Any] = copy.deepcopy(STUDY)
    tables |= {"oscillator": HEAVY, "run": {"t_end": 20}}
    tables["parameters"] = {"w": "2"}
    tables["forcing"]["harmonics"][0]["omega"] = "w"
    free = {"oscillator.damping_coefficient": [0.1, 0.4], "parameters.w": [1.9, 2.1]}
    asked = request(
        tables, outcomes=["peak_stop_force"], goals=["least"], free=free, limits={}, on="run"
    )

    header, arrays = answered(asked)

    assert list(header["designs"][0]["values"]) == list(free)
    assert set(free) <= {name for name, _ in header["report"]}
    assert (arrays["t"][0], arrays["t"][-1]) == (0.0, 20.0)
    told: dict[str, Any] = {}
    text = python_text(study_of_view(asked))
    exec(text[: text.index("plotting.plot")], told)  # noqa: S102  our own text
    assert list(told["best"].values.values()) == list(header["designs"][0]["values"].values())


def test_two_outcomes_give_a_front() -> None:
    options: dict[str, Any] = {
        "outcomes": ["peak_impact_velocity", "max_displacement"],
        "limits": {},
        "n": 4,
    }
    header, _ = answered(request(goals=["largest", "least"], **options))

    assert header["outcomes"] == ["peak impact velocity", "max displacement"]
    assert header["told"].startswith(f"{len(header['designs'])} designs")
    pairs = np.array([row["outcomes"] for row in header["designs"]])
    assert len(pairs) > 1
    assert (np.diff(pairs, axis=0) < 0.0).all()


def test_outcomes_of_a_front_have_units_and_what_is_left_out_is_told() -> None:
    tables = copy.deepcopy(STUDY)
    tables["oscillator"]["units"] = {"length": "mm", "time": "s"}
    # One design is the best in both outcomes: all others are left out.
    outcomes = ["peak_impact_velocity", "peak_displacement"]
    header, _ = answered(request(tables, outcomes=outcomes, goals=["least"] * 2, limits={}, n=3))

    assert header["outcomes"] == ["peak impact velocity (mm/s)", "peak displacement (mm)"]
    left = "; 2 more were no better in either outcome than one of these."
    assert header["told"] == f"1 design{left}"


def test_a_value_that_is_out_of_reach_is_told_in_words() -> None:
    header, _ = answered(request(goals=[99], limits={}))

    assert not header["converged"]
    assert "No optimum: peak impact velocity = 99 is out of reach" in header["told"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"free": {}}, "tick the parameters that are free"),
        ({"free": {f"a{i}": [0, 1] for i in range(13)}}, "13 free parameters; the page takes 12"),
        ({"restarts": 99}, "restarts = 99 is not between 0 and 16"),
        ({"outcomes": "all"}, "choose an outcome"),
        ({"limits": [1]}, "limits of outcomes: 8 at most"),
        ({"on": "moon"}, "on is none of orbit, run"),
    ],
)
def test_requests_without_an_answer(options: dict[str, Any], words: str) -> None:
    with pytest.raises(BadRequest) as told:
        study_of_view(request(**options))
    assert words in str(told.value)


@pytest.mark.parametrize(
    ("options", "path"),
    [
        ({"free": {GAP: [0.3, -0.3]}}, r"design\.free\.oscillator\.stops\.0\.at"),
        ({"limits": {"grazing_margin": [None, None]}}, r"design\.subject_to\.grazing_margin"),
        ({"limits": {"grazing_margin": 3}}, r"design\.subject_to\.grazing_margin"),
        ({"outcomes": ["beauty"]}, r"design\.outcome"),
    ],
)
def test_faults_of_a_design_have_their_paths(options: dict[str, Any], path: str) -> None:
    with pytest.raises(StudyError, match=path):
        study_of_view(request(**options))


def test_a_design_is_searched_and_put_into_the_sliders(page: Page) -> None:
    view = view_of(page, "Design")
    view.locator(".primary").click()
    expect(view.locator(".job .status")).to_contain_text("tick the parameters that are free")
    field(view, "goal").select_option("largest")
    view.locator(f"[data-free='{GAP}']").check()
    ends = view.locator(f"div:has(> label > [data-free='{GAP}']) .ends input")
    for end, value in zip(ends.all(), ("0.1", "0.2"), strict=True):
        end.fill(value)
        end.blur()
    view.get_by_role("button", name="add a limit").click()
    field(view, "limit of").select_option("grazing_margin")
    field(view, "at least").fill("0.1")
    field(view, "at least").blur()
    field(view, "of").select_option("run")
    expect(field(view, "limit of")).to_have_count(0)
    field(view, "restarts").fill("0")
    field(view, "restarts").blur()
    view.locator(".primary").click()

    expect(view.locator("p[role=status]").last).to_have_text(
        "An optimum that keeps all limits.", timeout=60_000
    )
    row = view.locator(".fitted tr", has_text="Wall: at")
    found = float(row.inner_text().split("\t")[1].split(";")[0].split(",")[0])
    assert 0.1 <= found <= 0.2
    view.get_by_role("button", name="put into the sliders").click()
    page.locator("[data-view=explore]").click()
    assert float(box_of(page, GAP).input_value()) == pytest.approx(found, rel=1e-7)
    expect(view.locator(".stale-note")).to_have_text("")
    set_box(page, "start.v0", "0.7")
    expect(view.locator(".stale-note")).to_contain_text("The start has been changed since")
