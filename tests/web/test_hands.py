"""Hands on the page in a real browser: sliders, gestures, keys, menu, help."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.web.hands import (
    WAIT,
    box_of,
    drag,
    drawn,
    fact,
    limits,
    link_of,
    middle,
    open_preset,
    pixels,
    row_of,
    set_box,
    slider_of,
    wait_for_drawing,
)


def test_the_velocity_at_which_n3_leaves_the_eigenset_is_found_with_the_mouse(page: Page) -> None:
    open_preset(page, "fig06_above")
    assert "on the eigenset" in fact(page, 1)
    row = row_of(page, "start.v0")
    row.get_by_role("button", name="range of the slider").click()
    for _ in range(2):
        row.get_by_role("button", name="finer").click()
    slider = slider_of(page, "start.v0")
    at = middle(slider)
    left = None
    page.mouse.move(*at)
    page.mouse.down()
    box = box_of(page, "start.v0")
    for step in range(1, 30):
        before, value = drawn(page), box.input_value()
        page.mouse.move(at[0] - 4 * step, at[1])
        if box.input_value() != value:
            wait_for_drawing(page, before)
        if "on the eigenset" not in fact(page, 1):
            left = float(box.input_value())
            break
    page.mouse.up()

    assert left is not None
    # Four pixels of this slider are some 0.0008; the boundary is at 1/2.
    assert 0.499 < left < 0.5


def test_the_range_of_a_slider_is_in_the_link_and_goes_with_another_motion(page: Page) -> None:
    row = row_of(page, "start.v0")
    row.get_by_role("button", name="range of the slider").click()
    row.get_by_label("slider from").fill("0.4")
    row.get_by_label("slider from").blur()
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)
    page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    assert row.get_by_label("slider from").input_value() == "0.4"
    slider_of(page, "start.v0").focus()
    page.keyboard.press("Home")
    expect(box_of(page, "start.v0")).to_have_value("0.4")
    open_preset(page, "fig10")

    assert row.get_by_label("slider from").input_value() == "-3"


def test_with_shift_a_slider_moves_finely(page: Page) -> None:
    slider = slider_of(page, "start.v0")
    begin = middle(slider)
    page.keyboard.down("Shift")
    drag(page, begin, (begin[0] + 20, begin[1]))
    page.keyboard.up("Shift")
    moved = float(box_of(page, "start.v0").input_value()) - 0.5

    box = slider.bounding_box()
    assert box is not None
    # Wherever it is taken, it goes a twentieth of the way.
    assert moved == pytest.approx(6.0 * 20 / box["width"] / 20, rel=0.1)


def test_axes_stand_still_while_a_slider_is_held_and_fit_after(page: Page) -> None:
    before = limits(page)["y"]
    at = middle(slider_of(page, "forcing.harmonics.0.amplitude"), 1 / 3)
    mark = drawn(page)
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] - 20, at[1], steps=4)
    wait_for_drawing(page, mark)
    page.wait_for_timeout(300)
    held = limits(page)["y"]
    page.mouse.up()
    page.wait_for_timeout(200)
    after = limits(page)["y"]

    assert held == before
    assert after[0] > held[0] + 0.1


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


def test_arrow_keys_and_shift_drag_pan_in_both_directions(page: Page) -> None:
    (x_low, x_high), (y_low, y_high) = limits(page, 1).values()
    over = page.locator(".explore .u-over").nth(1)
    page.locator(".explore .plot .canvas").nth(1).focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowUp")
    moved = limits(page, 1)
    assert moved["x"][0] == pytest.approx(x_low + 0.1 * (x_high - x_low))
    assert moved["y"][0] == pytest.approx(y_low + 0.1 * (y_high - y_low))

    page.keyboard.press("0")
    whole = limits(page, 1)
    page.keyboard.down("Shift")
    drag(page, middle(over, 0.5, 0.5), middle(over, 0.25, 0.75))
    page.keyboard.up("Shift")
    panned = limits(page, 1)
    width, height = whole["x"][1] - whole["x"][0], whole["y"][1] - whole["y"][0]
    assert panned["x"][0] == pytest.approx(whole["x"][0] + 0.25 * width, abs=0.02 * width)
    assert panned["y"][0] == pytest.approx(whole["y"][0] + 0.25 * height, abs=0.02 * height)
    # It moves, and does not zoom.
    assert panned["x"][1] - panned["x"][0] == pytest.approx(width)


# Two fingers that part to twice their distance.
PINCH = """() => {
  const over = document.querySelector('.explore .u-over');
  const box = over.getBoundingClientRect();
  const at = (id, x) => new Touch({ identifier: id, target: over, clientX: box.left + x * box.width, clientY: box.top + box.height / 2 });
  const say = (name, touches) => over.dispatchEvent(new TouchEvent(name, { touches, bubbles: true, cancelable: true }));
  say('touchstart', [at(1, 0.4), at(2, 0.6)]);
  const isTaken = !say('touchmove', [at(1, 0.3), at(2, 0.7)]);
  say('touchend', []);
  const isLeft = say('touchstart', [at(1, 0.4)]) && say('touchmove', [at(1, 0.2)]);
  say('touchend', []);
  return [isTaken, isLeft];
}"""


def test_two_fingers_zoom_and_one_scrolls(browser: Browser, address: str) -> None:
    opened = browser.new_page(viewport={"width": 375, "height": 720}, has_touch=True)
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    whole = limits(opened)
    is_taken, is_left = opened.evaluate(PINCH)
    zoomed = limits(opened)
    opened.close()

    assert is_taken
    assert is_left
    middle_of = sum(whole["x"]) / 2
    width = whole["x"][1] - whole["x"][0]
    assert sum(zoomed["x"]) / 2 == pytest.approx(middle_of, abs=0.02 * width)
    assert zoomed["x"][1] - zoomed["x"][0] == pytest.approx(width / 2)


def test_tabs_are_one_stop_and_arrow_keys_go_between_them(page: Page) -> None:
    seen: set[str] = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        seen.add(
            page.evaluate(
                "document.activeElement.id || document.activeElement.textContent.slice(0, 20)"
            )
        )
    assert {"p-tab-explore", "p-oscillator-damping", "p-start-v0", "Copy link"} <= seen
    assert "p-tab-diagram" not in seen

    page.locator("#p-tab-explore").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#p-view-diagram")).to_be_visible()
    expect(page.locator("#p-tab-diagram")).to_be_focused()
    expect(page.locator("#p-tab-diagram")).to_have_attribute("aria-selected", "true")
    page.keyboard.press("End")
    expect(page.locator("#p-view-gallery")).to_be_visible()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#p-view-explore")).to_be_visible()


def test_the_menu_closes_by_escape_and_by_a_click_elsewhere(page: Page) -> None:
    summary, item = page.locator("summary"), page.locator("[data-file=toml]")
    summary.click()
    expect(item).to_be_visible()
    page.keyboard.press("Escape")
    expect(item).to_be_hidden()
    expect(summary).to_be_focused()
    summary.click()
    page.locator(".facts").click(position={"x": 20, "y": 20})
    expect(item).to_be_hidden()


def test_the_help_opens_by_its_key_but_not_while_typing(page: Page) -> None:
    dialog = page.locator("dialog")
    box_of(page, "start.v0").focus()
    page.keyboard.press("?")
    expect(dialog).to_be_hidden()
    set_box(page, "start.v0", "0.5")
    page.locator("#p-tab-explore").focus()
    page.keyboard.press("?")
    expect(dialog).to_be_visible()
    page.keyboard.press("Escape")
    expect(dialog).to_be_hidden()
