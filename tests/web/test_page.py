"""The page in a real browser: each view, each preset, links, keyboard, sizes, colours."""

from __future__ import annotations

import json
import re
import socket
import threading
import time
from pathlib import Path
from typing import Any

import pytest
import uvicorn
from playwright.sync_api import Browser, Download, Page, expect

from percuss.web.app import create_app
from percuss.web.presets import presets

WAIT = 30_000


def drawn(page: Page) -> str:
    return page.locator(".explore").get_attribute("data-drawn") or ""


def wait_for_drawing(page: Page, before: str) -> None:
    page.wait_for_function(
        "before => document.querySelector('.explore').dataset.drawn !== before", arg=before
    )


def set_box(page: Page, path: str, text: str) -> None:
    page.locator(f"#p-{path.replace('.', '-')}").fill(text)


def open_preset(page: Page, name: str) -> None:
    before = drawn(page)
    page.locator("[data-view=gallery]").click()
    page.locator(f"[data-name={name}]").click()
    wait_for_drawing(page, before)


def fact(page: Page, k: int) -> str:
    return page.locator(".facts .card").nth(k).inner_text()


def pixels(page: Page, k: int = 0) -> list[int]:
    """Return a few numbers that change with what a plot shows."""
    found = page.evaluate(
        """k => {
          const canvas = document.querySelectorAll('.explore .plot canvas')[k];
          const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
          const sums = new Array(16).fill(0);
          for (let i = 3; i < data.length; i += 4) sums[Math.floor(i * 16 / data.length)] += data[i];
          return sums;
        }""",
        k,
    )
    return list(found)


def test_all_four_plots_follow_a_slider(page: Page) -> None:
    before = [pixels(page, k) for k in range(4)]
    mark = drawn(page)
    slider = page.locator(".row", has=page.locator("#p-forcing-harmonics-0-omega")).locator(
        "[type=range]"
    )
    slider.focus()
    for _ in range(40):
        page.keyboard.press("ArrowRight")
    wait_for_drawing(page, mark)
    page.wait_for_timeout(300)

    assert float(page.locator("#p-forcing-harmonics-0-omega").input_value()) > 2.8
    after = [pixels(page, k) for k in range(4)]
    assert all(a != b for a, b in zip(before, after, strict=True))


def test_a_wrong_value_shows_a_sentence_beside_its_field_and_goes_away(page: Page) -> None:
    row = page.locator(".row", has=page.locator("#p-oscillator-damping"))
    set_box(page, "oscillator.damping", "-0.2")
    expect(row.locator(".fault")).to_contain_text("negative")
    expect(page.locator("#p-oscillator-damping")).to_have_attribute("aria-invalid", "true")

    set_box(page, "oscillator.damping", "1/20")
    expect(row.locator(".fault")).to_be_empty()


def test_a_link_opens_the_same_picture(page: Page, browser: Browser) -> None:
    open_preset(page, "gear_rattle")
    set_box(page, "forcing.constant", "0.41")
    page.wait_for_timeout(500)
    link = page.url
    other = browser.new_page(viewport={"width": 1366, "height": 850})
    other.goto(link)
    other.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    other.wait_for_timeout(600)

    assert other.locator("#p-forcing-constant").input_value() == "0.41"
    assert pixels(other) == pixels(page)
    other.close()


def test_a_broken_link_begins_with_the_first_motion(browser: Browser, address: str) -> None:
    opened = browser.new_page()
    opened.goto(f"http://{address}/#no-such-thing")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)

    assert opened.locator("#p-forcing-harmonics-0-omega").input_value() == "2.8"
    opened.close()


@pytest.mark.parametrize("name", [preset.name for preset in presets()])
def test_each_preset_opens(page: Page, name: str) -> None:
    if name == "first_impacts":
        open_preset(page, "coco")
    open_preset(page, name)

    expect(page.locator(".explore .fault").first).to_be_empty()
    assert sum(pixels(page)) > 0
    assert "impact" in fact(page, 0) or "crossing" in fact(page, 0)


def test_the_velocity_at_which_n3_leaves_the_eigenset_is_found_with_the_mouse(page: Page) -> None:
    open_preset(page, "fig06_above")
    assert "on the eigenset" in fact(page, 1)
    slider = page.locator(".row", has=page.locator("#p-start-v0")).locator("[type=range]")
    box = slider.bounding_box()
    assert box is not None
    left = None
    y = box["y"] + box["height"] / 2
    low, high = box["x"], box["x"] + box["width"]
    at = low + (0.51 + 3.0) / 6.0 * (high - low)
    page.mouse.move(at, y)
    page.mouse.down()
    for step in range(1, 40):
        page.mouse.move(at - 0.5 * step, y)
        page.wait_for_timeout(60)
        if "on the eigenset" not in fact(page, 1):
            left = float(page.locator("#p-start-v0").input_value())
            break
    page.mouse.up()

    assert left is not None
    # A slider of 120 pixels has steps of some 0.03; the boundary is at 1/2.
    assert 0.40 < left < 0.5


def test_a_diagram_grows_and_a_click_opens_its_motion(page: Page) -> None:
    page.locator("[data-view=diagram]").click()
    view = page.locator("section[aria-label=Diagram]")
    view.get_by_role("button", name="Compute").click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    expect(view.locator(".hint")).to_contain_text("points")
    before = drawn(page)
    over = view.locator(".u-over").bounding_box()
    assert over is not None
    page.mouse.click(over["x"] + over["width"] / 4, over["y"] + over["height"] / 2)
    wait_for_drawing(page, before)

    expect(page.locator("section[aria-label=Explore]")).to_be_visible()
    omega = float(page.locator("#p-forcing-harmonics-0-omega").input_value())
    assert omega == pytest.approx(1.68 + (3.92 - 1.68) / 4, abs=0.01)


def test_a_diagram_can_be_cancelled(page: Page) -> None:
    page.locator("[data-view=diagram]").click()
    view = page.locator("section[aria-label=Diagram]")
    view.locator("label", has_text="values").locator("input").fill("8000")
    view.locator("label", has_text="values").locator("input").blur()
    view.get_by_role("button", name="Compute").click()
    view.get_by_role("button", name="Cancel").click()

    expect(view.locator(".status")).to_have_text("cancelled")
    # And another one can be computed after it.
    view.locator("label", has_text="values").locator("input").fill("64")
    view.locator("label", has_text="values").locator("input").blur()
    view.get_by_role("button", name="Compute").click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)


def test_basins_name_attractors_and_a_click_starts_there(page: Page) -> None:
    page.locator("[data-view=basins]").click()
    view = page.locator("section[aria-label=Basins]")
    side = view.locator("label", has_text="starts along a side").locator("input")
    side.fill("64")
    side.blur()
    view.get_by_role("button", name="Compute").click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    expect(view.locator(".legend li").first).to_contain_text("%")
    over = view.locator(".u-over").bounding_box()
    assert over is not None
    before = drawn(page)
    page.mouse.click(over["x"] + over["width"] / 4, over["y"] + over["height"] / 4)
    wait_for_drawing(page, before)

    assert float(page.locator("#p-start-x0").input_value()) == pytest.approx(-1.0, abs=0.05)
    assert float(page.locator("#p-start-v0").input_value()) == pytest.approx(1.0, abs=0.05)


def test_keys_zoom_a_plot_and_bring_it_back(page: Page) -> None:
    whole = pixels(page)
    plot = page.locator(".explore .plot .canvas").first
    plot.focus()
    page.keyboard.press("+")
    page.keyboard.press("+")
    page.wait_for_timeout(400)
    assert pixels(page) != whole
    page.keyboard.press("0")
    page.wait_for_timeout(400)

    assert pixels(page) == whole


def test_dragging_zooms_and_hovering_reads_out(page: Page) -> None:
    over = page.locator(".explore .u-over").first.bounding_box()
    assert over is not None
    y = over["y"] + over["height"] / 2
    page.mouse.move(over["x"] + 50, y)
    expect(page.locator(".readout").first).to_contain_text("t = ")
    page.mouse.down()
    page.mouse.move(over["x"] + 150, y, steps=4)
    page.mouse.up()
    page.wait_for_timeout(400)
    page.mouse.move(over["x"] + over["width"] / 2, y)
    text = page.locator(".readout").first.inner_text()

    t = float(re.search(r"t = ([-\d.e]+)", text)[1])  # type: ignore[index]
    share = 100.0 / over["width"]
    assert t == pytest.approx((50 / over["width"] + share / 2) * 134.64, rel=0.05)


def test_everything_is_reached_by_keys_alone(page: Page) -> None:
    seen: set[str] = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        seen.add(
            page.evaluate(
                "document.activeElement.id || document.activeElement.dataset.view"
                " || document.activeElement.textContent.slice(0, 20)"
            )
        )
    assert {"p-oscillator-damping", "p-start-v0", "diagram", "gallery", "Copy link"} <= seen


@pytest.mark.parametrize(("width", "height"), [(375, 720), (768, 1024), (1366, 768), (3840, 2160)])
def test_nothing_is_cut_off_at_any_size(
    browser: Browser, address: str, width: int, height: int
) -> None:
    opened = browser.new_page(viewport={"width": width, "height": height})
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    for view in ("explore", "diagram", "basins", "paper", "gallery"):
        opened.locator(f"[data-view={view}]").click()
        opened.wait_for_timeout(150)
        assert opened.evaluate("document.documentElement.scrollWidth") <= width
        wide = opened.evaluate(
            """() => [...document.querySelectorAll('section:not([hidden]) :is(button, label, dd, dt, legend)')]
              .filter((it) => it.offsetParent && it.scrollWidth > it.clientWidth + 1 && getComputedStyle(it).display !== 'inline')
              .map((it) => it.textContent)"""
        )
        assert wide == []
    opened.close()


def luminance(colour: str) -> float:
    parts = [int(part) / 255.0 for part in re.findall(r"\d+", colour)[:3]]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out_in_both_colours(browser: Browser, address: str, scheme: Any) -> None:
    opened = browser.new_page(color_scheme=scheme)
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    colours = opened.evaluate(
        """() => ['.panel legend', '.row label', '.card dt', '.card dd', 'nav button[aria-selected=true]'].map((name) => {
          let it = document.querySelector(name);
          const ink = getComputedStyle(it).color;
          while (getComputedStyle(it).backgroundColor === 'rgba(0, 0, 0, 0)') it = it.parentElement;
          return [name, ink, getComputedStyle(it).backgroundColor];
        })"""
    )
    for name, ink, paper in colours:
        low, high = sorted([luminance(ink), luminance(paper)])
        assert (high + 0.05) / (low + 0.05) >= 4.5, name
    is_dark = luminance(colours[0][2]) < 0.2
    assert is_dark == (scheme == "dark")
    opened.close()


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


def test_the_scripts_are_small() -> None:
    folder = Path(__file__).parents[2] / "src" / "percuss" / "web" / "static"
    assert sum(file.stat().st_size for file in folder.rglob("*.js")) < 300_000


def test_the_state_of_the_link_is_the_study(page: Page) -> None:
    page.wait_for_timeout(300)
    set_box(page, "start.v0", "0.7")
    page.wait_for_timeout(400)
    state = page.evaluate(
        "JSON.parse(atob(location.hash.slice(1).replaceAll('-', '+').replaceAll('_', '/')))"
    )
    assert state["study"]["start"]["v0"] == "0.7"
    assert json.dumps(state["view"]) == '"explore"'
