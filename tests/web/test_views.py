"""The long views in a real browser: diagrams, response charts, basins and the paper."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect
from tests.web.hands import (
    WAIT,
    box_of,
    compute,
    drag,
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


def test_a_diagram_grows_and_a_click_opens_its_motion(page: Page) -> None:
    view = view_of(page, "Diagram")
    expect(view.locator(".empty").first).to_contain_text("Compute")
    compute(view)
    expect(view.locator(".legend")).to_contain_text("204,800 points")
    before = drawn(page)
    page.mouse.click(*middle(view.locator(".u-over").first, 0.25))
    wait_for_drawing(page, before)

    expect(page.locator("section[aria-label=Explore]")).to_be_visible()
    omega = float(box_of(page, "forcing.harmonics.0.omega").input_value())
    assert omega == pytest.approx(1.68 + (3.92 - 1.68) / 4, abs=0.01)


def test_a_zoom_into_a_diagram_is_computed_more_finely(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "100")
    compute(view)
    finer = view.get_by_role("button", name="Compute what is shown")
    expect(finer).to_be_hidden()
    over = view.locator(".u-over").first
    drag(page, middle(over, 0.25), middle(over, 0.5, 0.51))
    finer.click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)

    low, high = (float(field(view, name).input_value()) for name in ("from", "to"))
    assert low == pytest.approx(2.24, abs=0.01)
    assert high == pytest.approx(2.80, abs=0.01)
    expect(finer).to_be_hidden()


def test_a_diagram_can_be_cancelled(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "8000")
    view.get_by_role("button", name="Compute", exact=True).click()
    view.get_by_role("button", name="Cancel").click()

    expect(view.locator(".status")).to_have_text("cancelled")
    # And another one can be computed after it.
    fill(view, "values", "64")
    compute(view)


def test_a_computation_goes_on_while_another_view_is_seen(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "4000")
    view.get_by_role("button", name="Compute", exact=True).click()
    page.locator("[data-view=explore]").click()
    set_box(page, "start.v0", "0.6")
    view_of(page, "Diagram")

    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    # Its points begin at the start that was set.
    expect(view.locator(".stale-note")).to_contain_text("The start has been changed")
    page.locator("[data-view=explore]").click()
    set_box(page, "oscillator.damping", "0.06")
    view_of(page, "Diagram")
    expect(view.locator(".stale-note")).to_contain_text("The motion has been changed")


COMPUTE_BOTH = """() => {
  for (const view of ['Diagram', 'Basins']) {
    const buttons = [...document.querySelectorAll(`section[aria-label=${view}] button`)];
    buttons.find((it) => it.textContent === 'Compute').click();
  }
}"""


def test_a_computation_that_another_one_replaces_says_so(page: Page) -> None:
    fill(view_of(page, "Basins"), "starts along a side", "16")
    view = view_of(page, "Diagram")
    fill(view, "values", "8000")
    # In one task of the page: a click from outside may come when the first is done.
    page.evaluate(COMPUTE_BOTH)

    expect(view.locator(".status")).to_contain_text("another computation")
    expect(view.get_by_role("button", name="Cancel")).to_be_hidden()


def test_a_chart_of_two_parameters_names_its_colours_and_a_click_opens_a_cell(page: Page) -> None:
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("sweep")
    for label, text in (
        ("from", "2.2"), ("to", "3"), ("and from", "0.3"), ("and to", "1"),
        ("cells along a side", "16"),
    ):  # fmt: skip
        fill(view, label, text)
    compute(view)
    legend = view.locator(".legend")
    for name in ("period 1", "period 2", "chaotic", "click a cell"):
        expect(legend).to_contain_text(name)
    over = view.locator(".u-over").first
    place = middle(over, 3.5 / 16, 4.5 / 16)
    page.mouse.move(*place)
    # The middle of the cell, and what stands in it.
    readout = view.locator(".readout").first
    expect(readout).to_contain_text("omega = 2.375, restitution = 0.803125: ")
    assert readout.inner_text().rsplit(": ", 1)[1] in legend.inner_text()
    expect(view.locator(".beside")).to_contain_text("Motion at omega = 2.375, restitution = 0.8031")
    link = link_of(page)
    before = drawn(page)
    page.mouse.click(*place)
    wait_for_drawing(page, before)

    expect(box_of(page, "forcing.harmonics.0.omega")).to_have_value("2.375")
    expect(box_of(page, "oscillator.stops.0.restitution")).to_have_value("0.803125")
    page.goto("about:blank")
    page.goto(link)
    expect(legend).to_contain_text("chaotic", timeout=WAIT)
    expect(field(view, "and to")).to_have_value("1")


def test_another_colour_of_a_chart_is_computed_and_a_part_of_it_too(page: Page) -> None:
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("sweep")
    fill(view, "cells along a side", "16")
    for of, name in (
        ("largest_lyapunov_exponent", "largest Lyapunov exponent = "),
        ("peak_impact_velocity", "peak impact velocity = "),
    ):
        field(view, "of").select_option(of)
        compute(view)
        expect(view.locator(".legend li").first).to_contain_text(name)
    over = view.locator(".u-over").first
    drag(page, middle(over, 0.25, 0.25), middle(over, 0.5, 0.75))
    view.get_by_role("button", name="Compute what is shown").click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    ends = [float(field(view, name).input_value()) for name in ("and from", "and to")]
    assert ends == pytest.approx([0.25, 0.75], abs=0.01)


CHART_AND_CANCEL = """() => {
  const buttons = [...document.querySelectorAll('section[aria-label=Diagram] button')];
  for (const name of ['Compute', 'Cancel']) buttons.find((it) => it.textContent === name).click();
}"""


def test_a_chart_can_be_cancelled(page: Page) -> None:
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("sweep")
    fill(view, "cells along a side", "256")
    page.evaluate(CHART_AND_CANCEL)
    expect(view.locator(".status")).to_have_text("cancelled")
    fill(view, "cells along a side", "16")
    compute(view)
    expect(view.locator(".legend")).to_contain_text("period 1")


def test_a_chart_that_the_page_does_not_compute_says_so(page: Page) -> None:
    before = drawn(page)
    set_box(page, "forcing.constant", "1/10 + 1/10")
    wait_for_drawing(page, before)
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("sweep")
    view.get_by_role("button", name="Compute", exact=True).click()
    expect(view.locator(".status")).to_contain_text("under one harmonic")


def test_a_response_chart_names_its_families_and_a_click_opens_an_orbit(page: Page) -> None:
    open_preset(page, "coco")
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("response")
    for label, text in (
        ("from", "1"), ("to", "1.2"), ("impacts up to", "1"), ("periods up to", "1"),
    ):  # fmt: skip
        fill(view, label, text)
    compute(view)
    expect(view.locator(".legend")).to_contain_text("(1, 1)")
    # Along the middle of the picture one of the places lies on the branch.
    over = view.locator(".u-over").first
    place, text = None, ""
    for k in range(1, 30):
        place = middle(over, 0.5, k / 30)
        page.mouse.move(*place)
        text = view.locator(".readout").first.inner_text()
        if "(1, 1) stable" in text:
            break
    assert "(1, 1) stable" in text
    assert place is not None
    before = drawn(page)
    page.mouse.click(*place)
    wait_for_drawing(page, before)

    expect(page.locator(".facts .card").nth(1)).to_contain_text("periodic")
    expect(page.locator(".explore .fault").first).to_be_empty()


def test_basins_name_attractors_and_a_click_starts_there(page: Page) -> None:
    view = view_of(page, "Basins")
    fill(view, "x to", "2")
    fill(view, "starts along a side", "64")
    compute(view)
    expect(view.locator(".legend li").first).to_contain_text("%")
    expect(view.locator(".legend")).to_contain_text("inside a wall")
    x_low, v_low, v_high = (
        float(field(view, name).input_value()) for name in ("x from", "v from", "v to")
    )
    over = view.locator(".u-over").first
    page.mouse.click(*middle(over, 0.9))
    expect(page.locator(".toast")).to_contain_text("inside a wall")
    before = drawn(page)
    page.mouse.click(*middle(over, 0.25, 0.25))
    wait_for_drawing(page, before)

    x0, v0 = (float(box_of(page, path).input_value()) for path in ("start.x0", "start.v0"))
    assert x0 == pytest.approx(x_low + (2 - x_low) / 4, abs=0.05)
    assert v0 == pytest.approx(v_high + (v_low - v_high) / 4, abs=0.05)


def test_another_motion_begins_with_settings_of_its_own(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "100")
    compute(view)
    open_preset(page, "fig06_above")
    view_of(page, "Diagram")

    # Around omega = 3.
    assert [field(view, name).input_value() for name in ("from", "to")] == ["1.8", "4.2"]
    expect(view.locator(".empty").first).to_be_visible()
    expect(view.locator(".status")).to_be_empty()
    expect(view.locator(".stale-note")).to_be_hidden()


def test_basins_begin_where_the_motion_is(page: Page) -> None:
    view = view_of(page, "Basins")

    # Up to the wall, and not beyond it.
    assert float(field(view, "x to").input_value()) == 0.2
    assert -3 < float(field(view, "x from").input_value()) < -1


def test_settings_of_the_long_views_are_in_the_link(page: Page, address: str) -> None:
    view = view_of(page, "Diagram")
    field(view, "over").select_option("oscillator.stops.0.restitution")
    fill(view, "from", "0.25")
    basins = view_of(page, "Basins")
    fill(basins, "v to", "3.5")
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)
    page.wait_for_selector("section[aria-label=Basins]:not([hidden])", timeout=WAIT)

    assert field(basins, "v to").input_value() == "3.5"
    view_of(page, "Diagram")
    assert field(view, "from").input_value() == "0.25"
    assert field(view, "over").input_value() == "oscillator.stops.0.restitution"
    # A link that is put into the address of an open page, too.
    page.evaluate("location.hash = ''")
    page.goto(f"http://{address}/")
    page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    page.evaluate("link => { location.hash = new URL(link).hash; }", link)
    expect(basins).to_be_visible()
    assert field(basins, "v to").input_value() == "3.5"


def test_a_narrow_part_of_basins_is_computed_in_its_own_ends(page: Page) -> None:
    view = view_of(page, "Basins")
    fill(view, "starts along a side", "32")
    field(view, "saddles and manifolds").uncheck()
    for name, end in (("x from", "0.1"), ("x to", "0.1000001")):
        fill(view, name, end)
    compute(view)
    over = view.locator(".u-over").first
    drag(page, middle(over, 0.25, 0.25), middle(over, 0.75, 0.75))
    view.get_by_role("button", name="Compute what is shown").click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)

    ends = [float(field(view, name).input_value()) for name in ("x from", "x to")]
    assert ends == pytest.approx([0.100000025, 0.100000075], abs=2e-9)


def test_what_is_in_the_middle_of_a_picture_is_opened_by_the_keys(page: Page) -> None:
    view = view_of(page, "Diagram")
    fill(view, "values", "101")
    fill(view, "points at each", "8")
    compute(view)
    canvas = view.locator(".plot .canvas").first
    assert "Enter opens the middle" in (canvas.get_attribute("aria-label") or "")
    before = drawn(page)
    canvas.focus()
    page.keyboard.press("+")
    page.keyboard.press("Enter")
    wait_for_drawing(page, before)

    expect(page.locator("section[aria-label=Explore]")).to_be_visible()
    omega = float(box_of(page, "forcing.harmonics.0.omega").input_value())
    assert omega == pytest.approx((1.68 + 3.92) / 2, abs=0.03)
