"""The page in a real browser: one motion, presets, links, files."""

from __future__ import annotations

import json
import socket
import threading
import time
from pathlib import Path

import uvicorn
from playwright.sync_api import Browser, Download, Page, Worker, expect
from tests.web.hands import (
    WAIT,
    box_of,
    drawn,
    fact,
    follow_link,
    link_of,
    open_preset,
    pixels,
    row_of,
    set_box,
    slider_of,
    view_of,
    wait_for_drawing,
    wait_for_server,
)

from percuss.web.app import create_app
from percuss.web.presets import presets


def test_all_four_plots_follow_a_slider(page: Page) -> None:
    before = [pixels(page, k) for k in range(4)]
    mark = drawn(page)
    slider_of(page, "forcing.harmonics.0.omega").focus()
    for _ in range(40):
        page.keyboard.press("ArrowRight")
    wait_for_drawing(page, mark)
    page.wait_for_timeout(300)

    assert float(page.locator("#p-forcing-harmonics-0-omega").input_value()) > 2.8
    after = [pixels(page, k) for k in range(4)]
    assert all(a != b for a, b in zip(before, after, strict=True))


def test_a_wrong_value_shows_a_sentence_beside_its_field_and_goes_away(page: Page) -> None:
    path = "oscillator.stops.0.restitution"
    row = row_of(page, path)
    set_box(page, path, "1.2")
    expect(row.locator(".fault")).to_contain_text("outside [0, 1]")
    expect(page.locator(f"#p-{path.replace('.', '-')}")).to_have_attribute("aria-invalid", "true")

    set_box(page, path, "4/5")
    expect(row.locator(".fault")).to_be_empty()


def test_a_link_opens_the_same_picture(page: Page) -> None:
    open_preset(page, "gear_rattle")
    set_box(page, "forcing.constant", "0.41")
    link = link_of(page)
    other = page.context.new_page()
    other.goto(link)
    other.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    other.wait_for_timeout(600)

    assert other.locator("#p-forcing-constant").input_value() == "0.41"
    assert pixels(other) == pixels(page)
    other.close()


def test_a_broken_link_begins_with_the_first_motion(tab: Page, address: str) -> None:
    opened = tab.context.new_page()
    opened.goto(f"http://{address}/#no-such-thing")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)

    assert opened.locator("#p-forcing-harmonics-0-omega").input_value() == "2.8"
    opened.close()


def test_each_preset_opens(page: Page) -> None:
    # The first one is shown already.
    for name in [*[preset.name for preset in presets()][1:], "first_impacts"]:
        open_preset(page, name)

        expect(page.locator(".explore .fault").first).to_be_empty()
        assert sum(pixels(page)) > 0, name
        assert "impact" in fact(page, 0) or "into a stop" in fact(page, 0), name


def test_each_model_is_chosen_and_moves(page: Page) -> None:
    model = page.get_by_label("Model", exact=True)
    for kind in ("bilinear", "backlash", "ball", "impact"):
        before = drawn(page)
        model.select_option(kind)
        wait_for_drawing(page, before)

        expect(page.locator(".explore .fault").first).to_be_empty()
        expect(model).to_have_value(kind)
        assert sum(pixels(page)) > 0, kind
    page.get_by_role("button", name="add a soft stop").click()
    expect(model).to_have_value("own")


RESTITUTION = "oscillator.stops.0.restitution"


def test_back_returns_to_the_motion_before(page: Page) -> None:
    open_preset(page, "chatter")
    expect(box_of(page, RESTITUTION)).to_have_value("0.5")
    open_preset(page, "fig10")
    expect(box_of(page, RESTITUTION)).to_have_value("1")
    page.go_back()
    expect(page.locator("section[aria-label=Gallery]")).to_be_visible()
    page.go_back()

    expect(page.locator("section[aria-label=Explore]")).to_be_visible()
    expect(box_of(page, RESTITUTION)).to_have_value("0.5")


# Links to states that are none.
SHAPES: list[object] = [
    {"study": 5},
    {"study": {}},
    {"study": {"oscillator": {"stops": 3}, "forcing": {}, "start": {}, "run": {}}},
    {"study": {"oscillator": {}, "forcing": {"harmonics": [1]}, "start": {}, "run": {}}},
    [],
]


def test_a_link_of_another_shape_begins_with_the_first_motion(page: Page, address: str) -> None:
    for state in SHAPES:
        follow_link(page, address, state)

        expect(box_of(page, "forcing.harmonics.0.omega")).to_have_value("2.8")


def test_a_link_with_strange_settings_opens(page: Page, address: str) -> None:
    study = presets()[0].tables
    state = {
        "view": "__proto__",
        "study": study,
        "diagram": {"kind": "no such", "low": "x", "of": 3, "path": "elsewhere"},
        "basins": [1, 2],
        "ranges": {"start.v0": [2, 1]},
    }
    follow_link(page, address, state)
    view = view_of(page, "Diagram")

    expect(view.get_by_role("button", name="Compute", exact=True)).to_be_visible()
    assert view.locator("select").nth(1).input_value() == "forcing.harmonics.0.omega"
    # Words that every object of a script has.
    design = {"on": "toString", "outcome": "constructor", "limits": [3, {"outcome": "valueOf"}]}
    state |= {"diagram": {"kind": "constructor", "section": "toString"}, "design": design}
    follow_link(page, address, state)
    expect(view_of(page, "Design").get_by_role("button", name="Search")).to_be_visible()


def test_files_are_downloaded(page: Page, tmp_path: Path) -> None:
    found: dict[str, Download] = {}
    for extension in ("toml", "py", "png"):
        page.locator("summary", has_text="Files").click()
        with page.expect_download(timeout=WAIT) as waiting:
            page.locator(f"[data-file={extension}]").click()
        found[extension] = waiting.value
    target = tmp_path / "study.toml"
    found["toml"].save_as(target)

    from percuss.studies import load_study

    assert str(load_study(target).oscillator.damping) == "0.05"
    assert found["png"].suggested_filename == "motion.png"


def test_a_lost_connection_shows_and_comes_back(browser: Browser) -> None:
    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    port = listening.getsockname()[1]
    listening.close()

    def started() -> tuple[uvicorn.Server, threading.Thread]:
        config = uvicorn.Config(
            create_app(), port=port, log_level="error", timeout_graceful_shutdown=1
        )
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.02)
        return server, thread

    server, thread = started()
    opened = browser.new_page()
    opened.goto(f"http://127.0.0.1:{port}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    server.should_exit = True
    thread.join(20)
    expect(opened.locator(".banner")).to_be_visible(timeout=WAIT)
    server, thread = started()
    expect(opened.locator(".banner")).to_be_hidden(timeout=WAIT)
    before = drawn(opened)
    set_box(opened, "forcing.constant", "0.3")
    wait_for_drawing(opened, before)
    opened.close()
    server.should_exit = True
    thread.join(20)


def test_a_workbench_that_begins_anew_takes_the_kernels_of_the_one_before(page: Page) -> None:
    begun: list[Worker] = []

    def note(worker: Worker) -> None:
        begun.append(worker)

    page.on("worker", note)
    page.evaluate("async () => (await import('/static/js/page.js')).begin()")
    wait_for_server(page)
    page.remove_listener("worker", note)

    assert sum(pixels(page)) > 0
    assert begun == []


def test_the_scripts_are_small() -> None:
    folder = Path(__file__).parents[2] / "src" / "percuss" / "web" / "static"
    assert sum(file.stat().st_size for file in folder.rglob("*.js")) < 400_000


def test_the_state_of_the_link_is_the_study(page: Page) -> None:
    page.wait_for_timeout(300)
    set_box(page, "start.v0", "0.7")
    page.wait_for_timeout(400)
    state = page.evaluate(
        "JSON.parse(atob(location.hash.slice(1).replaceAll('-', '+').replaceAll('_', '/')))"
    )
    assert state["study"]["start"]["v0"] == "0.7"
    assert json.dumps(state["view"]) == '"explore"'
