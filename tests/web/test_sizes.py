"""The page in windows of all sizes and in both colours."""

from __future__ import annotations

import re
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from tests.web.hands import WAIT, compute, fill, set_box, slider_of, view_of


@pytest.mark.parametrize(
    ("width", "height"),
    [
        (375, 720),
        (1366, 768),
        pytest.param(768, 1024, marks=pytest.mark.nightly),
        pytest.param(3840, 2160, marks=pytest.mark.nightly),
    ],
)
def test_nothing_is_cut_off_at_any_size(tab: Page, address: str, width: int, height: int) -> None:
    opened = tab.context.new_page()
    opened.set_viewport_size({"width": width, "height": height})
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    for view in ("explore", "diagram", "basins", "fit", "design", "structure", "paper", "gallery"):
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


def test_the_menu_of_files_is_in_sight_on_a_phone(page: Page) -> None:
    page.set_viewport_size({"width": 375, "height": 720})
    menu = page.locator("details.menu")
    menu.locator("summary").click()
    expect(menu.locator("[data-file=toml]")).to_be_visible()
    box = menu.locator("> div").bounding_box()
    assert box is not None
    assert 0 <= box["x"] <= box["x"] + box["width"] <= 375
    menu.locator("summary").press("Escape")


def test_on_paper_the_boxes_show_their_numbers_and_no_button_is_left(page: Page) -> None:
    page.set_viewport_size({"width": 794, "height": 1123})
    set_box(page, "oscillator.damping", "0.0625")
    page.emulate_media(media="print")
    cut = page.evaluate(
        """() => [...document.querySelectorAll('.explore .row input[type=text]')]
          .filter((it) => it.scrollWidth > it.clientWidth).map((it) => it.value)"""
    )
    left = page.evaluate(
        "() => [...document.querySelectorAll('button')].filter((it) => it.offsetParent).map((it) => it.textContent)"
    )
    page.emulate_media(media="screen")
    assert cut == []
    assert left == []


def luminance(colour: str) -> float:
    parts = [int(part) / 255.0 for part in re.findall(r"\d+", colour)[:3]]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out_in_both_colours_and_the_first_click_changes_them(
    tab: Page, address: str, scheme: Any
) -> None:
    opened = tab.context.new_page()
    opened.emulate_media(color_scheme=scheme)
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
    root = opened.locator("#percuss")
    expect(root).to_have_attribute("data-theme", scheme)
    opened.get_by_role("button", name="Light or dark").click()
    expect(root).not_to_have_attribute("data-theme", scheme)
    opened.close()


def test_plots_stay_in_sight_of_the_sliders_on_a_phone(page: Page) -> None:
    page.set_viewport_size({"width": 375, "height": 720})
    slider = slider_of(page, "run.periods")
    slider.scroll_into_view_if_needed()
    slider_box = slider.bounding_box()
    plot_box = page.locator(".explore .plot").first.bounding_box()
    assert slider_box is not None
    assert plot_box is not None

    assert plot_box["y"] >= 0
    assert plot_box["y"] + plot_box["height"] <= slider_box["y"] < 720
    # So does the verdict, in a line above them.
    line = page.locator(".explore .summary")
    line_box = line.bounding_box()
    assert line_box is not None
    assert 0 <= line_box["y"] <= plot_box["y"] - line_box["height"] + 1
    expect(line).to_contain_text("(2, 4), stable")


def test_the_help_opens_at_its_title_on_a_phone(page: Page) -> None:
    page.set_viewport_size({"width": 375, "height": 720})
    page.get_by_role("button", name="Help").click()
    assert page.locator("dialog").evaluate("it => it.scrollTop") == 0
    expect(page.locator("dialog h2")).to_be_in_viewport()
    expect(page.locator("dialog")).to_contain_text("Eigenset")


def test_what_comes_and_goes_does_not_move_the_page(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "64")
    compute(view)
    plot = view.locator(".plot").first
    before = plot.bounding_box()
    page.locator("[data-view=explore]").click()
    set_box(page, "oscillator.damping", "0.06")
    cards = page.locator(".facts").bounding_box()
    page.evaluate("document.querySelector('.banner').hidden = false")
    assert page.locator(".facts").bounding_box() == cards
    expect(page.locator(".banner")).to_contain_text("percuss serve")
    view_of(page, "Diagram")
    expect(view.locator(".stale-note")).to_be_visible()
    assert plot.bounding_box() == before


# How high the letters of an axis are, as the plot draws them.
LETTERS = """() => {
  const plot = document.querySelector('.explore .plot .uplot canvas');
  return Number.parseFloat(plot.getContext('2d').font.match(/([\\d.]+)px/)[1]);
}"""


def test_letters_of_a_plot_grow_with_the_window(page: Page) -> None:
    small = page.evaluate(LETTERS)
    page.set_viewport_size({"width": 3840, "height": 2160})
    page.wait_for_timeout(500)
    assert page.evaluate(LETTERS) >= 1.5 * small
    page.set_viewport_size({"width": 1366, "height": 850})
    page.wait_for_timeout(500)

    assert page.evaluate(LETTERS) == small
