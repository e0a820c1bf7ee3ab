"""Files, links and notes belong to the picture that is shown, in a real browser."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect
from tests.web.hands import (
    WAIT,
    box_of,
    compute,
    drawn,
    field,
    fill,
    link_of,
    middle,
    open_preset,
    set_box,
    view_of,
    wait_for_drawing,
)


def study_toml(page: Page) -> dict[str, Any]:
    page.locator("summary", has_text="Files").click()
    with page.expect_download(timeout=WAIT) as waiting:
        page.locator("[data-file=toml]").click()
    return tomllib.loads(waiting.value.path().read_text("utf-8"))


def chart(page: Page, low: str = "1") -> Locator:
    """Compute a response chart of few families."""
    open_preset(page, "coco")
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("response")
    fill(view, "from", low)
    for label, text in (("to", "1.2"), ("impacts up to", "1"), ("periods up to", "1")):
        fill(view, label, text)
    compute(view)
    return view


def place_where(page: Page, view: Locator, words: str, n: int = 40) -> tuple[float, float]:
    """Return a place in the middle of the plot whose read-out holds some words."""
    over = view.locator(".u-over").first
    for k in range(1, n):
        place = middle(over, 0.5, k / n)
        page.mouse.move(*place)
        if words in view.locator(".readout").first.inner_text():
            return place
    raise AssertionError(f"no read-out holds {words!r}")


def squares(view: Locator) -> list[tuple[dict[str, Any], tuple[float, float]]]:
    """Return the squares of a chart, and their places in pixels of the window."""
    marks = json.loads(view.locator(".plot").first.get_attribute("data-marks") or "[]")
    ends = json.loads(view.locator(".canvas").first.get_attribute("data-limits") or "{}")
    share = {
        axis: lambda it, axis=axis: (it[axis] - ends[axis][0]) / (ends[axis][1] - ends[axis][0])
        for axis in ("x", "y")
    }
    over = view.locator(".u-over").first
    return [(it, middle(over, share["x"](it), 1.0 - share["y"](it))) for it in marks]


def test_a_diagram_stays_what_it_was_computed_from(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "100")
    compute(view)
    first = study_toml(page)
    before = drawn(page)
    page.mouse.click(*middle(view.locator(".u-over").first, 0.25))
    wait_for_drawing(page, before)
    clicked = box_of(page, "start.v0").input_value()
    assert clicked != "0.5"
    view_of(page, "Diagram")
    expect(view.locator(".stale-note")).to_contain_text("The start has been changed since")

    assert study_toml(page) == first
    assert str(first["diagram"]["starts"][0][1]) == "0.5"
    # The link shows the picture too, and Explore where it was.
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    assert study_toml(page) == first
    assert box_of(page, "start.v0").input_value() == clicked


def test_an_orbit_that_is_opened_shows_its_start_time(page: Page) -> None:
    view = chart(page)
    before = drawn(page)
    page.mouse.click(*place_where(page, view, "(1, 1) stable"))
    wait_for_drawing(page, before)

    t0 = box_of(page, "start.t0")
    expect(t0).to_be_visible()
    assert float(t0.input_value()) != 0.0
    view_of(page, "Diagram")
    # No family depends on a start.
    expect(view.locator(".stale-note")).to_be_hidden()
    field(view, "kind").select_option("diagram")
    fill(view, "values", "64")
    compute(view)
    label = f"x at t = {float(t0.input_value()):.4g} + whole periods"
    expect(view.locator(".plot").first).to_have_attribute("data-y", label)


def test_a_square_is_read_and_opened_at_its_own_value(page: Page) -> None:
    view = chart(page, low="0.7")
    mark, (x, y) = squares(view)[0]
    page.mouse.move(x + 3, y + 2)
    expect(view.locator(".readout").first).to_contain_text(f"{mark['kind']} at omega = ")
    before = drawn(page)
    page.mouse.click(x + 3, y + 2)
    wait_for_drawing(page, before)

    omega = float(box_of(page, "forcing.harmonics.0.omega").input_value())
    assert omega == pytest.approx(mark["x"], rel=1e-11)


def test_fields_of_a_diagram_say_what_is_wrong(page: Page) -> None:
    view = view_of(page, "Diagram")
    low = field(view, "from")
    begin = view.get_by_role("button", name="Compute", exact=True)
    for label, text, words in (
        ("from", "", "a number is missing"),
        ("from", "abc", "not a number"),
        ("from", "9", "not above 9"),
        ("values", "2.5", "a whole number from 2 to 8192"),
    ):
        fill(view, label, text)
        expect(view.locator(".settings")).to_contain_text(words)
        begin.click()
        expect(view.locator(".status")).to_contain_text("see the marked field")
        expect(view.locator(".status")).to_have_class("status fault")
        fill(view, label, "2" if label == "from" else "100")
    fill(view, "from", "pi/2")
    compute(view)
    over = study_toml(page)["over"]["forcing.harmonics.0.omega"]
    assert over["from"] == pytest.approx(1.5708, rel=1e-4)

    # What the server refuses stands beside the end of the range that it is of.
    fill(view, "from", "-1")
    begin.click()
    expect(low.locator("xpath=..").locator(".fault")).to_contain_text("not positive")
    assert low.input_value() == "-1"


def test_a_computation_that_fails_leaves_the_note(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "64")
    compute(view)
    page.locator("[data-view=explore]").click()
    set_box(page, "oscillator.damping", "x")
    view_of(page, "Diagram")
    expect(view.locator(".stale-note")).to_be_visible()
    view.get_by_role("button", name="Compute", exact=True).click()

    expect(view.locator(".status")).to_contain_text("not a number")
    expect(view.locator(".stale-note")).to_be_visible()


def test_a_diagram_goes_over_the_start_where_all_depends_on_it(page: Page) -> None:
    open_preset(page, "fig10")
    view = view_of(page, "Diagram")
    field(view, "over").select_option("start.v0")
    fill(view, "values", "64")
    compute(view)
    expect(view.locator(".legend")).to_contain_text("points")
    # Orbits do not depend on it.
    field(view, "kind").select_option("response")
    names = field(view, "over").locator("option").all_inner_texts()
    assert not any(name.startswith("Start") for name in names)


def test_the_bar_of_basins_says_what_the_text_says(page: Page) -> None:
    view = view_of(page, "Basins")
    fill(view, "starts along a side", "1024")
    view.get_by_role("button", name="Compute", exact=True).click()
    said = page.evaluate(
        """async () => {
          const [bar, status] = ['progress', '.status'].map((it) => document.querySelector(`section[aria-label=Basins] ${it}`));
          const rows = [];
          while (!status.textContent.startsWith('done') && rows.length < 40) {
            const share = /^(\\d+) %/.exec(status.textContent);
            if (share) rows.push([Number(share[1]), Math.round(100 * bar.value)]);
            await new Promise((then) => setTimeout(then, 20));
          }
          // At once: a fast page may be done before a click from outside.
          const buttons = [...document.querySelectorAll('section[aria-label=Basins] button')];
          buttons.find((it) => it.textContent === 'Cancel' && !it.hidden)?.click();
          return rows;
        }"""
    )
    assert len(said) > 0
    assert all(text == bar for text, bar in said)
