"""Records by file, new parameters, tables of restitution, units on axes, and sections on the page."""

from __future__ import annotations

import base64
import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.web.frames import read_frame
from tests.web.hands import (
    WAIT,
    box_of,
    compute,
    drawn,
    field,
    fill,
    follow_link,
    link_of,
    set_box,
    slider_of,
    view_of,
    wait_for_drawing,
)

import percuss as pc
from percuss.web.jobs import answer_job
from percuss.web.request import BadRequest, PageRequest, RunningRequest, study_of
from percuss.web.view_study import study_of_view

TABLE = {"speeds": [0, 1, 5], "values": ["0.9", "0.8", "0.6"]}
METRIC: dict[str, Any] = {
    "oscillator": {
        "stiffness": 1,
        "units": {"length": "mm", "time": "s"},
        "stops": [{"type": "wall", "at": "0.2", "side": "below", "restitution": TABLE}],
    },
    "forcing": {"harmonics": [{"amplitude": 1, "omega": "2.5"}]},
    "start": {"x0": "0.5", "v0": 0},
    "run": {"periods": 10},
}
OPTIONS = {"path": "forcing.harmonics.0.omega", "low": 2.4, "high": 2.6, "values": 4, "points": 8}


def opened(page: Page, address: str, study: dict[str, Any]) -> None:
    follow_link(page, address, {"view": "explore", "study": study})


def study_in(page: Page) -> dict[str, Any]:
    text = link_of(page).split("#", 1)[1]
    found: dict[str, Any] = json.loads(base64.urlsafe_b64decode(text + "=="))["study"]
    return found


def choose(page: Page, file: Path) -> None:
    page.locator(".panel input[type=file]").set_input_files(file)


def fault_of(page: Page) -> str:
    return page.locator(".panel div:has(> input[type=file]) > .fault").inner_text()


def written(folder: Path, text: str) -> Path:
    path = folder / "waves.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_record_is_chosen_as_a_file_with_its_columns_by_name(page: Page, tmp_path: Path) -> None:
    choose(page, written(tmp_path, "# m\n\ntime,height,force\n0,9,0.5\n1,8,-1e-1\n2.5,7,0\n"))
    panel = page.locator("form.panel")
    expect(panel.get_by_text("3 samples from t = 0 to 2.5")).to_be_visible()
    panel.locator('label:has-text("forces") select').select_option("force")
    before = drawn(page)
    panel.get_by_role("button", name="use it").click()
    wait_for_drawing(page, before)

    expect(box_of(page, "forcing.record.amplitude")).to_have_value("1")
    study = study_in(page)
    record = study["forcing"]["record"]
    assert (record["t"], record["f"]) == ([0, 1, 2.5], [0.5, -0.1, 0])
    assert study["run"] == {"t_end": 2.5}
    force = study_of(study).forcing
    assert force is not None
    assert force.record == pc.model.ForceRecord((0, 1, 2.5), (0.5, -0.1, 0))

    panel.get_by_label("repeated").check()
    panel.locator('label:has-text("between them") select').select_option("hold")
    assert study_in(page)["forcing"]["record"]["kind"] == "hold"
    assert study_in(page)["forcing"]["record"]["repeat"] is True
    before = drawn(page)
    panel.locator('fieldset:has-text("Record") button:text-is("remove")').click()
    wait_for_drawing(page, before)
    assert "record" not in study_in(page)["forcing"]


def test_columns_with_units_are_converted_on_the_page(
    page: Page, address: str, tmp_path: Path
) -> None:
    study = copy.deepcopy(METRIC)
    study["oscillator"] |= {"mass": 2, "units": {"length": "m", "time": "s", "mass": "kg"}}
    opened(page, address, study)
    choose(page, written(tmp_path, "t (ms),f (kN),eta (m)\n0,1,2\n500,2,3\n"))
    panel = page.locator("form.panel")
    expect(panel.get_by_text("2 samples from t = 0 to 0.5")).to_be_visible()
    panel.locator('label:has-text("forces") select').select_option("eta (m)")
    expect(panel.get_by_text("give amplitude, the force of each m")).to_be_visible()
    panel.locator('label:has-text("forces") select').select_option("f (kN)")
    expect(panel.get_by_text("give amplitude")).to_have_count(0)
    before = drawn(page)
    panel.get_by_role("button", name="use it").click()
    wait_for_drawing(page, before)

    record = study_in(page)["forcing"]["record"]
    assert (record["t"], record["f"]) == ([0, 0.5], [1000, 2000])


def test_a_record_is_dropped_on_the_panel(page: Page) -> None:
    data = page.evaluate_handle(
        """() => {
          const data = new DataTransfer();
          data.items.add(new File(['t,f\\n0,0\\n1,1\\n4,0\\n'], 'dropped.csv', { type: 'text/csv' }));
          return data;
        }"""
    )
    page.locator("form.panel").dispatch_event("drop", {"dataTransfer": data})
    before = drawn(page)
    page.locator("form.panel").get_by_role("button", name="use it").click()
    wait_for_drawing(page, before)

    assert study_in(page)["forcing"]["record"]["t"] == [0, 1, 4]


@pytest.mark.parametrize(
    "table",
    [
        "t;f\n0;0,5\n1,5;-1e-1\n".encode("utf-16"),
        b'\xef\xbb\xbf"t"\t"f"\r\n0\t0.5\r\n1.5\t-0,1\r\n',
        "Messung;Böe 7\n\nt;f\n0;0,5\n1,5;-0.1\n".encode("cp1252"),
        b"t;f;Bemerkung\n0;0,5;an\n1,5;-0,1;\n",
    ],
)
def test_tables_of_spreadsheets_are_read_as_they_are_saved(
    page: Page, tmp_path: Path, table: bytes
) -> None:
    path = tmp_path / "waves.csv"
    path.write_bytes(table)
    choose(page, path)
    before = drawn(page)
    page.locator("form.panel").get_by_role("button", name="use it").click()
    wait_for_drawing(page, before)

    record = study_in(page)["forcing"]["record"]
    assert (record["t"], record["f"]) == ([0, 1.5], [0.5, -0.1])


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            "t,f\n0,0\n1,x\n1,2\n",
            'waves.csv: line 3: f = "x" is no finite number; line 4: t = 1.0 is',
        ),
        ("t,f\n0,0\n2,1\n1,2\n", "line 4: t = 1.0 comes after 2.0; instants must rise"),
        ("t,f\n2,0\n1,1\n0,2\n", "the samples are in reverse order, the last one first"),
        ("t;f\n0;0,5\n1,5;x\n", 'waves.csv: line 3: f = "x" is no finite number'),
        ("0,0\n1,1\n", "its first line holds numbers; write the names above them"),
        ("t,f\n0,0\n", "1 sample; a record needs two at least"),
        ("", "it is empty"),
        ("t\n0\n1\n", "it has one column"),
        (
            "t,f\n" + "".join(f"{k},{k / 7}\n" for k in range(4000)),
            "4000 samples: 86 kB; links of the page hold 56 kB, some 2634 of these samples",
        ),
    ],
)
def test_faults_of_a_table_are_told_by_line(
    page: Page, tmp_path: Path, text: str, fault: str
) -> None:
    choose(page, written(tmp_path, text))

    page.wait_for_function(
        "() => document.querySelector('.panel div:has(> input[type=file]) > .fault').textContent"
    )
    assert fault in fault_of(page)
    use = page.locator("form.panel").get_by_role("button", name="use it")
    assert use.count() == 0 or use.is_disabled()
    assert box_of(page, "forcing.record.amplitude").count() == 0


def test_a_parameter_is_added_and_ties_numbers(page: Page) -> None:
    name = page.get_by_label("name of a new parameter")
    add = page.get_by_role("button", name="add a parameter")
    for wrong, words in (("2w", "a letter, then"), ("pi", "has a meaning"), ("", "a letter")):
        name.fill(wrong)
        add.click()
        expect(page.locator(".panel .fault", has_text=words)).to_be_visible()
    name.fill("w")
    add.click()
    expect(box_of(page, "parameters.w")).to_have_value("1")
    before = drawn(page)
    set_box(page, "forcing.harmonics.0.omega", "2*w + 1/2")
    wait_for_drawing(page, before)
    expect(slider_of(page, "forcing.harmonics.0.omega")).to_be_disabled()
    before = drawn(page)
    set_box(page, "parameters.w", "1.25")
    wait_for_drawing(page, before)

    force = study_of(study_in(page)).forcing
    assert force is not None
    assert force.period == pytest.approx(2.0 * np.pi / 3.0, rel=1e-15)
    page.get_by_label("name of a new parameter").fill("w")
    page.keyboard.press("Enter")
    expect(page.locator(".panel .fault", has_text="there is one of this name")).to_be_visible()


def test_what_a_study_leaves_out_is_shown_as_its_default(page: Page, address: str) -> None:
    study = copy.deepcopy(METRIC) | {"run": {"t_end": 5}}
    study["oscillator"] = {"stops": [{"type": "wall", "at": -1, "side": "below"}]}
    study["forcing"] = {"record": {"t": [0, 1], "f": [0, 1]}}
    opened(page, address, study)

    paths = ("oscillator.stiffness", "oscillator.stops.0.restitution", "forcing.record.amplitude")
    for path in paths:
        expect(box_of(page, path)).to_have_value("1")
    expect(box_of(page, "oscillator.damping")).to_have_value("0")


def test_each_value_of_a_restitution_table_has_a_slider(page: Page, address: str) -> None:
    opened(page, address, METRIC)
    path = "oscillator.stops.0.restitution.values.1"

    expect(page.get_by_text("r at speed 1 mm/s", exact=True)).to_be_visible()
    expect(slider_of(page, path)).to_be_enabled()
    before = drawn(page)
    set_box(page, path, "0.7")
    wait_for_drawing(page, before)
    assert study_in(page)["oscillator"]["stops"][0]["restitution"] == {
        "speeds": [0, 1, 5],
        "values": ["0.9", "0.7", "0.6"],
    }
    set_box(page, path, "1.5")
    expect(page.locator(".row .fault", has_text="create energy")).to_be_visible()


def test_axes_have_the_units_of_the_study(page: Page, address: str) -> None:
    opened(page, address, METRIC)

    labels = page.locator(".explore .plot:has(.canvas)").evaluate_all(
        "plots => plots.map((plot) => [plot.dataset.x, plot.dataset.y])"
    )
    assert labels == [
        ["time t (s)", "displacement x (mm)"],
        ["displacement x (mm)", "velocity v (mm/s)"],
        ["cycle (t / period) mod 1", "speed before the impact (mm/s)"],
        ["time t (s)", "velocity v (mm/s)"],
        ["time t (s)", "impulse (mm/s)"],
        ["angular frequency omega (1/s)", "amplitude (mm)"],
    ]
    view = view_of(page, "Diagram")
    # The picture comes after the view.
    expect(view.locator(".plot").first).to_have_attribute("data-y", "x at whole periods (mm)")


def test_a_mass_and_units_are_given_on_the_panel(page: Page, address: str) -> None:
    study = copy.deepcopy(METRIC)
    soft = {"type": "soft", "at": "0.1", "side": "above", "stiffness": 20, "damping": "1/3"}
    study["oscillator"] |= {"damping": "0.05", "stops": [soft]}
    opened(page, address, study)
    units = page.get_by_role("group", name="units")
    expect(units.locator("select")).to_have_count(2)

    before = drawn(page)
    page.get_by_role("button", name="give it a mass").click()
    wait_for_drawing(page, before)
    heavy = study_in(page)
    expect(page.get_by_role("button", name="give it a mass")).to_have_count(0)
    runs = [
        pc.simulate(osc.oscillator, osc.forcing, x0="0.5", periods=10)
        for osc in map(study_of, (study, heavy))
    ]
    np.testing.assert_array_equal(runs[0].crossings.t, runs[1].crossings.t)
    assert len(runs[0].crossings) > 0
    assert heavy["oscillator"] == {
        "mass": 1,
        "stiffness": 1,
        "damping_coefficient": "0.1",
        "stops": [soft | {"damping": "2*(1/3)"}],
        "units": {"length": "mm", "time": "s", "mass": "kg"},
    }

    for quantity, name in (("length", "m"), ("mass", "t")):
        before = drawn(page)
        units.get_by_label(quantity).select_option(name)
        wait_for_drawing(page, before)
    expect(page.get_by_text("stiffness k (kN/m)", exact=True)).to_be_visible()
    for quantity in ("length", "time", "mass"):
        before = drawn(page)
        units.get_by_label(quantity).select_option("")
        if quantity == "mass":
            wait_for_drawing(page, before)
    assert "units" not in study_in(page)["oscillator"]


def test_impacts_of_a_motion_without_a_period_are_shown_over_time(page: Page, address: str) -> None:
    study = copy.deepcopy(METRIC) | {"run": {"t_end": 8}}
    study["oscillator"]["stops"][0]["at"] = "-0.2"
    study["forcing"] = {"record": {"t": [0, 1, 3], "f": [0, 1, -1]}}
    opened(page, address, study)
    impacts = page.locator('.explore .plot[data-y^="speed before the impact"]')
    assert impacts.get_attribute("data-x") == "time t (s)"
    expect(impacts).not_to_contain_text("no impacts")

    opened(page, address, METRIC)
    assert impacts.get_attribute("data-x") == "cycle (t / period) mod 1"


def test_a_diagram_over_a_value_of_a_table() -> None:
    path = "oscillator.stops.0.restitution.values.2"
    options = OPTIONS | {"path": path, "low": 0.5, "high": 0.7}
    frames = list(answer_job(PageRequest(1, "diagram", METRIC, options), RunningRequest()))
    header, arrays = read_frame(frames[-1])
    assert header["path"] == path
    assert np.isfinite(arrays["x"]).all()


@pytest.mark.parametrize(
    ("section", "given"),
    [
        ({}, "stroboscopic"),
        ({"section": "cycle", "cycle": 0.25}, {"cycle": 0.25}),
        ({"section": "place", "at": 0.4, "direction": "down"}, {"at": 0.4, "direction": "down"}),
        ({"section": "impacts"}, "impacts"),
    ],
)
def test_the_points_of_a_diagram_are_those_of_its_section(
    section: dict[str, Any], given: Any
) -> None:
    request = PageRequest(1, "diagram", METRIC, OPTIONS | section)
    study = study_of_view(request)

    frames = list(answer_job(request, RunningRequest()))
    header, arrays = read_frame(frames[-1])

    force = study.forcing
    direct = pc.bifurcation_diagram(
        study.oscillator,
        force,
        over={"forcing.omega": np.linspace(2.4, 2.6, 4)},
        section=given,
        start=("0.5", 0),
        follow=(),
        points=8,
    )
    names = [name for name in ("x", "v", "cycle", "v_after") if name in direct]
    assert header["failed"] == 0
    for name in names:
        expected = direct[name].values[0].ravel().astype(np.float32)
        np.testing.assert_allclose(arrays[name], expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("follow", ["forward", "backward", "both"])
def test_a_diagram_follows_the_motion_up_and_down(follow: str) -> None:
    request = PageRequest(1, "diagram", METRIC, OPTIONS | {"follow": follow, "values": 70})
    study = study_of_view(request)
    frames = list(answer_job(request, RunningRequest()))
    header, arrays = read_frame(frames[-1])

    branches = ("forward", "backward") if follow == "both" else (follow,)
    direct = pc.bifurcation_diagram(
        study.oscillator,
        study.forcing,
        over={"forcing.omega": np.linspace(2.4, 2.6, 70)},
        start=("0.5", 0),
        follow=branches,  # type: ignore[arg-type]
        points=8,
    )
    assert len(frames) == 1
    assert header["failed"] == 0
    for suffix, branch in zip(("", "_backward"), branches, strict=False):
        expected = direct.x.sel(branch=branch).values.ravel()
        np.testing.assert_allclose(arrays[f"x{suffix}"], expected, rtol=1e-5, atol=1e-5)
    assert ("x_backward" in arrays) == (follow == "both")


def test_a_free_motion_has_a_diagram_at_a_place() -> None:
    tables = copy.deepcopy(METRIC) | {"forcing": {}, "run": {"t_end": 10}}
    tables["oscillator"] |= {"damping": "-0.05"}
    tables["oscillator"]["stops"][0]["at"] = "-0.2"
    options = OPTIONS | {"path": "oscillator.damping", "low": -0.06, "high": -0.05}

    at_place = PageRequest(1, "diagram", tables, options | {"section": "place", "at": 0.3})
    header, arrays = read_frame(list(answer_job(at_place, RunningRequest()))[-1])
    assert header["failed"] == 0
    assert "v" in arrays
    with pytest.raises(BadRequest, match="a diagram needs a periodic force: add a harmonic"):
        study_of_view(PageRequest(1, "diagram", tables, options))
    with pytest.raises(BadRequest, match="section is none of strobes, cycle, place, impacts"):
        study_of_view(PageRequest(1, "diagram", METRIC, OPTIONS | {"section": "poincare"}))


def test_a_section_is_set_computed_and_kept_in_the_link(page: Page, address: str) -> None:
    opened(page, address, METRIC)
    view = view_of(page, "Diagram")
    field(view, "points at").select_option("place")
    fill(view, "x =", "0.4")
    field(view, "passed").select_option("down")
    fill(view, "values", "16")
    fill(view, "points at each", "8")
    compute(view)

    assert view.locator(".plot").first.get_attribute("data-y") == "v at x = 0.4, down (mm/s)"
    link = link_of(page)
    state = json.loads(base64.urlsafe_b64decode(link.split("#", 1)[1] + "=="))
    kept = state["diagram"]
    assert (kept["section"], kept["at"], kept["direction"]) == ("place", 0.4, "down")
    page.goto("about:blank")
    page.goto(link)
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    assert view.locator(".plot").first.get_attribute("data-y") == "v at x = 0.4, down (mm/s)"
    expect(field(view, "of").locator("option")).to_have_text(["velocity", "cycle"])
