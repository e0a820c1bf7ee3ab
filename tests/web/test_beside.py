"""A diagram that follows the sliders, and the motion at the pointer beside it."""

from __future__ import annotations

import copy
import json
import re

import numpy as np
from playwright.sync_api import Locator, Page, expect
from tests.web.hands import (
    WAIT,
    compute,
    field,
    fill,
    link_of,
    middle,
    slider_of,
    view_of,
)

import percuss as pc
from percuss.web.presets import presets
from percuss.web.request import study_of

LIVE = "live: it follows the sliders"


def diagram_of(page: Page) -> Locator:
    """Compute a small diagram, and return its view."""
    view = view_of(page, "Diagram")
    fill(view, "values", "64")
    fill(view, "points at each", "16")
    compute(view)
    return view


def point_at(page: Page, view: Locator, across: float, down: float) -> str:
    """Move the pointer over the diagram; return the caption of the motion there."""
    page.mouse.move(*middle(view.locator(".sides > .plot .u-over"), across, down))
    caption = view.locator(".beside figcaption strong").first
    expect(caption).to_contain_text("Motion at omega =", timeout=WAIT)
    return caption.inner_text()


def shown(view: Locator, k: int) -> dict[str, list[float]]:
    limits = view.locator(".beside .canvas").nth(k).get_attribute("data-limits")
    assert limits is not None
    found: dict[str, list[float]] = json.loads(limits)
    return found


def test_beside_a_diagram_is_the_motion_at_the_pointer(page: Page) -> None:
    view = diagram_of(page)
    omega = float(point_at(page, view, 0.8, 0.3).rpartition("=")[2])
    page.wait_for_timeout(300)
    tables = copy.deepcopy(presets()[0].tables)
    tables["forcing"]["harmonics"][0]["omega"] = omega
    study = study_of(tables)
    period = 2.0 * np.pi / omega
    run = pc.simulate(study.oscillator, study.forcing, **tables["start"], t_end=212 * period)
    late, _ = run(np.linspace(200 * period, run.t_end, 4000))
    low, high = shown(view, 1)["y"]
    size = float(np.ptp(late))
    assert low <= late.min() < low + 0.15 * size
    assert high - 0.15 * size < late.max() <= high
    other = point_at(page, view, 0.3, 0.3)
    assert float(other.rpartition("=")[2]) < omega


def test_a_live_diagram_follows_a_slider_beside_it(page: Page) -> None:
    view = diagram_of(page)
    view.get_by_label(LIVE).check()
    slider = slider_of(page, "oscillator.stops.0.at")
    expect(view.locator("aside .panel")).to_be_visible()
    before = view.locator(".legend").inner_text()
    assert "1,024 points" in before
    limits = view.locator(".sides > .plot .canvas").get_attribute("data-limits")
    slider.focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    expect(view.locator(".status")).to_have_text(re.compile(r"live: \d+ ms|done in"))
    expect(view.locator(".status")).to_contain_text("done in", timeout=WAIT)
    # All values and points are computed at the end, of the motion that is set.
    expect(view.locator(".stale-note")).to_be_hidden()
    assert "1,024 points" in view.locator(".legend").inner_text()
    assert view.locator(".sides > .plot .canvas").get_attribute("data-limits") != limits
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)
    expect(view.get_by_label(LIVE)).to_be_checked()
    expect(view.locator("aside .panel")).to_be_visible()


def test_the_sliders_are_where_a_live_diagram_is_seen(page: Page) -> None:
    view = diagram_of(page)
    view.get_by_label(LIVE).check()
    view_of(page, "Explore")
    expect(page.locator(".explore aside .panel")).to_be_visible()
    view_of(page, "Diagram")
    expect(view.locator("aside .panel")).to_be_visible()
    view.get_by_label(LIVE).uncheck()
    expect(view.locator("aside")).to_be_hidden()
    field(view, "kind").select_option(label="response chart")
    expect(view.get_by_label(LIVE)).to_have_count(0)


def test_what_a_live_diagram_cannot_have_is_said(page: Page) -> None:
    view = diagram_of(page)
    view.get_by_label(LIVE).check()
    box = view.locator("#p-oscillator-stops-0-restitution")
    box.fill("1.5")
    expect(view.locator(".status.fault")).to_contain_text("restitution", timeout=WAIT)
    box.fill("0.6")
    expect(view.locator(".status")).to_contain_text("done in", timeout=WAIT)
