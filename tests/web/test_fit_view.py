"""A record on the page: read by the server, fitted, and its values in the sliders."""

from __future__ import annotations

import copy
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.web.frames import read_frame
from tests.web.hands import box_of, follow_link, link_of, set_box, view_of
from tests.web.test_server import fetched

import percuss as pc
from percuss.errors import StudyError
from percuss.execution import Execution
from percuss.web.code_text import python_text
from percuss.web.downloads import file_of
from percuss.web.fit_view import MOST_VALUES, answer_measured
from percuss.web.jobs import answer_job
from percuss.web.presets import presets
from percuss.web.request import BadRequest, PageRequest, RunningRequest, read_request
from percuss.web.view_study import study_of_view

GAP, RESTITUTION = "oscillator.stops.0.at", "oscillator.stops.0.restitution"
# The first motion of the page, with another wall.
STUDY: dict[str, Any] = copy.deepcopy(dict(presets()[0].tables))
RIG = pc.impact_oscillator("0.72", wall="0.25", side="above", damping="0.05")


def table(n: int = 200) -> str:
    """Return a record of the rig as a logger writes it."""
    t = np.linspace(0, 15, n)
    x, _ = pc.simulate(RIG, pc.cosine("2.8"), v0="0.3", t_end=15)(t)
    x += 0.01 * np.random.default_rng(1).standard_normal(n)
    rows = "".join(f"{a:.6f};{b:.5f}\n" for a, b in zip(t.tolist(), x.tolist(), strict=True))
    return "Time (s);x\n" + rows.replace(".", ",")


def request(kind: str = "fit", **options: Any) -> PageRequest:
    given = {"csv": table(), "free": {GAP: 0.2, RESTITUTION: [0.4, 0.95]}, "noise": 0.01}
    return PageRequest(1, kind, STUDY, given | options)


def test_a_table_is_read_with_its_faults_by_line() -> None:
    header, arrays = read_frame(answer_measured(request("measured")))
    assert header["quantities"] == ["displacement"]
    assert header["n"] == len(arrays["t0"]) == len(arrays["y0"]) == 200
    assert header["titles"] == ["Time (s)", "x"]
    with pytest.raises(BadRequest, match="load a record first"):
        answer_measured(request("measured", csv=None))
    with pytest.raises(BadRequest, match="the file is empty"):
        answer_measured(request("measured", csv=""))
    with pytest.raises(BadRequest, match="a binary file; save it as CSV"):
        answer_measured(request("measured", csv="PK\3\4\0\0x;t\n0;1\n"))
    for text, words in (
        ("t,x\n0,far\n1\n", 'line 2: x = "far" is no finite number; line 3: 1 cell'),
        ("t,x\n0,nan\n1,\n", "no values of displacement: all are missing"),
        ("t,stop_force_3\n0,1\n", "stop_force_3: of stop 3, where the oscillator has 1"),
        (
            "t,x\n" + "".join(f"{i},1\n" for i in range(MOST_VALUES + 1)),
            "values; the page fits 20,000 at most",
        ),
    ):
        header, _ = read_frame(answer_measured(request("measured", csv=text)))
        assert words in header["fault"]
        assert header["titles"]
    with pytest.raises(BadRequest, match="write the names above them"):
        answer_measured(request("measured", csv="0;1\n1;2\n"))


def test_columns_of_other_names_are_chosen() -> None:
    text = "Clock;v;Laser 2\nms;m/s;mm\n0;9;1,5\n500;9;2\n1000;9;3\n1500;9;3\n"
    header, _ = read_frame(answer_measured(request("measured", csv=text)))
    assert header["titles"] == ["Clock", "v", "Laser 2"]
    assert {name: title for name, title in header["columns"].items() if title} == {"velocity": "v"}
    assert "no column of instants" in header["fault"]
    chosen = {"t": "Clock", "displacement": "Laser 2", "velocity": ""}
    asked = request("measured", csv=text, columns=chosen)
    asked.tables["oscillator"]["units"] = {"length": "m", "time": "s"}
    header, arrays = read_frame(answer_measured(asked))
    assert header["quantities"] == ["displacement"]
    assert arrays["t0"].tolist() == [0.0, 0.5, 1.0, 1.5]
    np.testing.assert_array_equal(arrays["y0"], np.array([0.0015, 0.002, 0.003, 0.003], np.float32))
    (record,) = study_of_view(replace(asked, kind="fit")).question.records  # type: ignore[attr-defined]
    assert set(record.data) == {"t", "displacement"}


def test_a_fit_is_that_of_the_study_in_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    header, arrays = read_frame(list(answer_job(request(), RunningRequest()))[-1])
    assert header["done"]
    assert header["converged"]
    values = {row["path"]: row for row in header["values"]}
    assert list(values) == [GAP, RESTITUTION]
    for path, true in ((GAP, 0.25), (RESTITUTION, 0.72)):
        assert values[path]["value"] == pytest.approx(true, abs=4 * values[path]["error"])
        assert "±" in values[path]["text"]
    assert np.mean(np.square(arrays["residual0"])) == pytest.approx(header["chi2"], rel=1e-5)
    drawn = np.interp(arrays["t0"], arrays["curve_t0"], arrays["curve0"])
    np.testing.assert_allclose(drawn, arrays["y0"], atol=0.06)
    assert len(arrays["impact_t"]) == len(arrays["impact_v"]) > 2

    study = study_of_view(request())
    assert file_of(request(), "toml").data.decode() == study.text()
    assert b"oscillator.stops.0.at" in file_of(request(), "csv").data
    assert file_of(request(), "png").data.startswith(b"\x89PNG")
    monkeypatch.chdir(tmp_path)
    told: dict[str, Any] = {}
    exec(python_text(study), told)  # noqa: S102  our own text
    assert told["result"].values[GAP] == pytest.approx(values[GAP]["value"], rel=1e-9)
    assert (tmp_path / "fit.png").exists()


def test_a_fit_says_what_the_report_of_its_study_says_under_the_names_of_the_page() -> None:
    tables = copy.deepcopy(STUDY)
    tables["parameters"] = {"w": "2.8"}
    tables["forcing"]["harmonics"][0]["omega"] = "w"
    tables["oscillator"]["units"] = {"length": "m", "time": "s"}
    free = {"parameters.w": 2.8, GAP: 0.2, RESTITUTION: 0.8}
    asked = PageRequest(1, "fit", tables, {"csv": table(), "free": free, "noise": 5})
    header, _ = read_frame(list(answer_job(asked, RunningRequest()))[-1])
    study = study_of_view(asked)
    report = study.question.report(study.question.answer(study, Execution()))

    assert [row["path"] for row in header["values"]] == list(free)
    texts = [row["text"] for row in header["values"]]
    assert texts == [report[path] for path in ("w", GAP, RESTITUTION)]
    assert texts[1].endswith(" m")
    notes = dict(header["notes"])
    # Of a noise in other units, which would pass for white residuals.
    assert "times theirs: is it in the model's units?" in notes["residuals"]
    assert notes == {name: report[name] for name in ("residuals", "noise")}


def test_the_noise_of_a_quantity_is_told_in_words() -> None:
    run = pc.simulate(RIG, pc.cosine("2.8"), v0="0.3", t_end=60)
    text = "impact_times\n" + "".join(f"{t:.4f}\n" for t in run.impacts.t.tolist())
    asked = request(csv=text, free={GAP: 0.25}, noise=None)
    header, _ = read_frame(list(answer_job(asked, RunningRequest()))[-1])

    assert dict(header["notes"])["noise"].startswith("impact times ")


def test_a_known_start_is_that_of_the_motion() -> None:
    tables = copy.deepcopy(STUDY)
    tables["start"] |= {"v0": "0.3"}
    options = {**request().options, "start": True, "free": {"start.v0": 0.4, GAP: 0.2}}
    asked = PageRequest(1, "fit", tables, options)
    assert study_of_view(asked).text().count("[start]") == 1
    assert "start=(0, '0.3', 0.0)" in python_text(study_of_view(asked))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"free": {}}, "tick the parameters that are not known"),
        ({"free": {f"a{i}": 1 for i in range(13)}}, "13 free parameters; the page fits 12 at most"),
        ({"noise": -1}, "noise = -1 is not between"),
        ({"csv": 3}, "load a record first"),
    ],
)
def test_requests_without_an_answer(options: dict[str, Any], words: str) -> None:
    with pytest.raises(BadRequest) as told:
        study_of_view(request(**options))
    assert words in str(told.value)


def test_faults_of_parameters_have_their_paths() -> None:
    with pytest.raises(StudyError, match=r"fit\.free\.oscillator\.stops\.0\.restitution"):
        study_of_view(request(free={RESTITUTION: [0.5, 1.5]}))


def test_a_long_record_has_files_too(address: str) -> None:
    body = {"kind": "fit", "study": STUDY, **request(csv=table(6000)).options}
    data = json.dumps(body).encode()
    assert len(data) > 100_000
    status, _, text = fetched(address, "/api/file/py", data)
    assert status == 200
    assert b"pc.fit(" in text


def test_only_messages_with_records_may_be_long() -> None:
    text = '{"id": 1, "kind": "%s", "csv": "' + "1,2;" * 20_000 + '"}'
    assert read_request(text % "fit", ("fit", "explore")).kind == "fit"
    with pytest.raises(BadRequest, match="65536 are the most"):
        read_request(text % "explore", ("fit", "explore"))
    with pytest.raises(BadRequest, match="1000000 are the most"):
        read_request(" " * 1_000_001, ("fit",))


def test_a_record_is_loaded_fitted_and_put_into_the_sliders(page: Page, tmp_path: Path) -> None:
    (tmp_path / "rig.csv").write_text(table(), encoding="utf-8")
    (tmp_path / "bad.csv").write_text("t,x\n0,far\n", encoding="utf-8")
    view = view_of(page, "Fit")
    file = view.locator("input[type=file]")
    file.set_input_files(tmp_path / "bad.csv")
    expect(view.locator(".settings > .fault")).to_contain_text('line 2: x = "far"')
    file.set_input_files(tmp_path / "rig.csv")
    expect(view).to_contain_text("rig.csv: 200 values of displacement")
    expect(view.locator(".settings > .fault")).to_be_empty()
    view.locator(".primary").click()
    expect(view.locator(".job .status")).to_have_text("tick the parameters that are not known")

    view.locator(f"[data-free='{GAP}']").check()
    view.locator(f"[data-free='{RESTITUTION}']").check()
    view.get_by_role("button", name="range of Wall: restitution r").click()
    expect(view.locator(".free .ends input")).to_have_count(2)
    view.locator(".primary").click()
    row = view.locator(f"tr[data-fitted='{GAP}']")
    expect(row).to_contain_text("Wall: at0.2")
    expect(view.locator("p[role=status]").last).to_contain_text("Converged in ")
    value, error = (float(part) for part in row.inner_text().split("\t")[1].split(" ± "))
    assert abs(value - 0.25) < 5 * error

    view.get_by_role("button", name="put into the sliders").click()
    page.locator("[data-view=explore]").click()
    shown = float(box_of(page, GAP).input_value())
    assert math.isclose(shown, value, abs_tol=error)
    assert abs(float(box_of(page, "start.v0").input_value()) - 0.3) < 0.1
    # The free parameters and the start are those of the fit, wherever they are: another damping is
    # another motion.
    expect(view.locator(".stale-note")).to_have_text("")
    set_box(page, "oscillator.damping", "0.3")
    expect(view.locator(".stale-note")).to_contain_text("The motion has been changed since")
    set_box(page, "oscillator.damping", "0.05")
    expect(view.locator(".stale-note")).to_have_text("")


def test_a_parameter_of_expressions_is_fitted_and_goes_into_its_slider(
    page: Page, address: str, tmp_path: Path
) -> None:
    (tmp_path / "rig.csv").write_text(table(), encoding="utf-8")
    study = copy.deepcopy(STUDY)
    study["parameters"] = {"w": "2.75"}
    study["forcing"]["harmonics"][0]["omega"] = "w"
    study["oscillator"]["stops"][0] |= {"at": "0.25", "restitution": "0.72"}
    follow_link(page, address, {"study": study, "view": "explore"})
    view = view_of(page, "Fit")
    view.locator("input[type=file]").set_input_files(tmp_path / "rig.csv")
    expect(view).to_contain_text("rig.csv: 200 values of displacement")
    view.locator("[data-free='parameters.w']").check()
    view.locator(".primary").click()
    expect(view.locator("[data-fitted='parameters.w'] td").first).to_have_text("Parameters: w")
    view.get_by_role("button", name="put into the sliders").click()
    page.locator("[data-view=explore]").click()

    assert float(box_of(page, "parameters.w").input_value()) == pytest.approx(2.8, abs=0.01)
    expect(page.locator(".explore .stage > .fault")).to_be_empty()
    page.goto("about:blank")


def test_a_table_that_is_too_long_for_the_page_is_told(page: Page, tmp_path: Path) -> None:
    rows = "".join(f"{i / 100:.6f},{math.sin(i / 100):.6f}\n" for i in range(60_000))
    (tmp_path / "long.csv").write_text("t,x\n" + rows, encoding="utf-8")
    (tmp_path / "one.csv").write_text("t,x\n0,1\n", encoding="utf-8")
    view = view_of(page, "Fit")
    file = view.locator("input[type=file]")
    file.set_input_files(tmp_path / "long.csv")
    told = "long.csv: more than 1 MB, the most on the page; percuss run takes any"
    expect(view.locator(".settings > .fault")).to_have_text(told)
    expect(view).not_to_contain_text("reading")
    file.set_input_files(tmp_path / "one.csv")
    expect(view).to_contain_text("one.csv: 1 value of displacement")


def test_the_keys_go_on_where_a_fit_was_cancelled(page: Page, tmp_path: Path) -> None:
    t = np.linspace(0, 600, 9000).tolist()
    rows = "".join(f"{a:.5f},{math.sin(a) + 0.3 * math.sin(2.2 * a):.5f}\n" for a in t)
    (tmp_path / "long.csv").write_text("t,x\n" + rows, encoding="utf-8")
    view = view_of(page, "Fit")
    view.locator("input[type=file]").set_input_files(tmp_path / "long.csv")
    expect(view).to_contain_text("long.csv: 9000 values of displacement; too long for a link")
    view.locator(f"[data-free='{GAP}']").check()
    view.locator(".primary").focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    expect(view.get_by_role("button", name="Cancel")).to_be_focused()
    page.keyboard.press("Enter")

    expect(view.locator(".job .status")).to_have_text("cancelled")
    expect(view.locator(".primary")).to_be_focused()


def test_forces_of_stops_are_counted_from_one(page: Page, tmp_path: Path) -> None:
    text = "t,x,stop_force_1\n" + "".join(f"{i / 10},{math.sin(i / 10)},1\n" for i in range(60))
    (tmp_path / "rig.csv").write_text(text, encoding="utf-8")
    page.get_by_role("button", name="add a soft stop").click()
    view = view_of(page, "Fit")
    view.locator("input[type=file]").set_input_files(tmp_path / "rig.csv")
    expect(view).to_contain_text("rig.csv: 120 values of displacement, stop force 2")


CHOOSE = """(root, wanted) => {
  for (const label of root.querySelectorAll("label")) {
    const select = label.querySelector("select");
    const [, title] = Object.entries(wanted).find(([name]) => label.textContent.startsWith(name)) ?? [];
    if (title === undefined) continue;
    select.value = title;
    select.dispatchEvent(new Event("change"));
  }
}"""


def test_columns_are_chosen_and_kept_in_the_link(page: Page, tmp_path: Path) -> None:
    text = table().replace("Time (s);x", "Clock;Laser 2")
    (tmp_path / "rig.csv").write_text(text, encoding="utf-8")
    view = view_of(page, "Fit")
    view.locator("input[type=file]").set_input_files(tmp_path / "rig.csv")
    expect(view.locator(".settings > .fault")).to_contain_text("no column")
    # Both in one task of the page: the second is chosen before the first can be answered.
    view.locator(".columns").evaluate(CHOOSE, {"instants": "Clock", "displacement": "Laser 2"})
    expect(view).to_contain_text("rig.csv: 200 values of displacement")
    for quantity, title in (("instants", "Clock"), ("displacement", "Laser 2")):
        choice = view.locator(".columns label", has_text=quantity).locator("select")
        expect(choice).to_have_value(title)
    expect(view.locator(".settings > .fault")).to_be_empty()
    view.locator(f"[data-free='{GAP}']").check()
    view.get_by_role("button", name="range of Wall: at").click()
    address = link_of(page)
    page.goto("about:blank")
    page.goto(address)
    expect(view).to_contain_text("rig.csv: 200 values of displacement")
    expect(view.locator(f"[data-free='{GAP}']")).to_be_checked()
    expect(view.locator(".free .ends input")).to_have_count(2)
    view.locator(".primary").click()
    expect(view.locator("p[role=status]").last).to_contain_text("onverged")


def test_each_quantity_of_a_record_is_drawn_when_it_is_chosen(page: Page, tmp_path: Path) -> None:
    t = np.linspace(0, 15, 150)
    x, v = pc.simulate(RIG, pc.cosine("2.8"), v0="0.3", t_end=15)(t)
    rows = "".join(
        f"{a:.6f},{b:.6f},{c:.6f}\n"
        for a, b, c in zip(*(some.tolist() for some in (t, x, v)), strict=True)
    )
    (tmp_path / "rig.csv").write_text("t,x,v\n" + rows, encoding="utf-8")
    view = view_of(page, "Fit")
    choice = view.get_by_label("drawn")
    view.locator("input[type=file]").set_input_files(tmp_path / "rig.csv")
    expect(view).to_have_attribute("data-quantity", "displacement")
    choice.select_option("velocity")
    expect(view).to_have_attribute("data-quantity", "velocity")
    view.locator(f"[data-free='{GAP}']").check()
    view.locator(".primary").click()
    expect(view.locator("p[role=status]").last).to_contain_text("onverged")
    expect(view).to_have_attribute("data-quantity", "velocity")
    choice.select_option("displacement")
    expect(view).to_have_attribute("data-quantity", "displacement")
    # The plots over time show the same times.
    canvases = view.locator(".plot .canvas")
    ends = "all => all.map((it) => JSON.parse(it.dataset.limits).x)"
    whole = canvases.evaluate_all(ends)
    canvases.first.press("+")
    part = canvases.evaluate_all(ends)
    assert part[0] == part[1] == part[2] == pytest.approx([1.5, 13.5], abs=0.01)
    canvases.first.press("0")
    assert canvases.evaluate_all(ends) == whole
