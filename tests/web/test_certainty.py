"""Saddles, proofs and verdicts on the page, in a real browser."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.web.hands import WAIT, compute, field, fill, link_of, middle, set_box, view_of
from tests.web.serving import served

from percuss.web import proof, saddles
from percuss.web.app import create_app

# How many pixels of a plot are black, as manifolds are.
BLACK = """() => {
  const canvas = document.querySelector('section[aria-label=Basins] canvas');
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  let n = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 250 && data[i] + data[i + 1] + data[i + 2] < 130) n += 1;
  return n;
}"""


def test_saddles_and_their_manifolds_are_drawn_and_switched(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A machine that does much else finds them all, too.
    monkeypatch.setattr(saddles, "PATIENCE", 600.0)
    view = view_of(page, "Basins")
    fill(view, "starts along a side", "48")
    compute(view)
    expect(view.locator("[data-saddles]")).to_contain_text("(1, 2), (1, 2)", timeout=WAIT)
    drawn = page.evaluate(BLACK)
    switch = view.get_by_label("saddles and manifolds")
    switch.uncheck()
    expect(view.locator("[data-saddles]")).to_have_count(0)
    assert page.evaluate(BLACK) < 0.5 * drawn
    switch.check()
    expect(view.locator("[data-saddles]")).to_contain_text("(1, 2), (1, 2)", timeout=WAIT)

    assert page.evaluate(BLACK) == drawn
    # It is in the link.
    switch.uncheck()
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)
    expect(switch).not_to_be_checked()


def test_families_of_a_response_chart_come_one_by_one(page: Page) -> None:
    view = view_of(page, "Diagram")
    field(view, "kind").select_option("response")
    for label, text in (
        ("from", "2.7"), ("to", "2.9"), ("impacts up to", "1"), ("periods up to", "2"),
    ):  # fmt: skip
        fill(view, label, text)
    view.get_by_role("button", name="Compute", exact=True).click()
    # There are families while the search goes on.
    expect(view.locator(".legend")).to_contain_text("the first families", timeout=WAIT)
    expect(view.locator(".legend .swatch").first).to_be_visible()
    assert "done" not in view.locator(".status").inner_text()
    view.get_by_role("button", name="Cancel").click()

    expect(view.locator(".status")).to_have_text("cancelled")


def test_a_run_is_certified_and_another_one_is_not(page: Page) -> None:
    pytest.importorskip("flint")
    strip = page.locator("section[aria-label='Certify this run']")
    expect(strip).to_be_hidden()
    page.get_by_role("button", name="certify …").click()
    strip.get_by_label("Certify this run to").fill("25")
    strip.get_by_role("button", name="Certify", exact=True).click()
    expect(strip.locator(".status")).to_have_text("proven", timeout=WAIT)
    rows = strip.locator(".proof-rows")
    expect(rows).to_contain_text("32 impacts up to t = ")
    expect(rows).to_contain_text("25 asked for")
    expect(rows).to_contain_text("double precision has all 32 impacts")
    link = link_of(page)

    set_box(page, "start.v0", "0.51")
    expect(rows).to_be_empty()
    expect(strip.locator(".status")).to_be_empty()
    # The link asks for the same proof.
    page.goto("about:blank")
    page.goto(link)
    expect(strip.locator(".status")).to_have_text("proven", timeout=WAIT)
    assert strip.get_by_label("Certify this run to").input_value() == "25"
    page.locator("summary", has_text="Files").click()
    expect(page.locator("[data-file='certified.csv']")).to_be_visible()


def test_chaos_is_proven_on_the_page(page: Page) -> None:
    pytest.importorskip("flint")
    set_box(page, "oscillator.damping", "0")
    set_box(page, "oscillator.stops.0.at", "0")
    page.get_by_role("button", name="certify …").click()
    strip = page.locator("section[aria-label='Certify this run']")
    strip.get_by_role("button", name="Prove chaos").click()
    expect(strip.locator(".status")).to_have_text("proven", timeout=WAIT)
    rows = strip.locator(".proof-rows")
    expect(rows).to_contain_text("Topological entropy")
    expect(rows).to_contain_text("for every order of loops of 1 and ")

    # Of another system nothing is said.
    set_box(page, "forcing.harmonics.0.omega", "2.5")
    expect(rows).to_be_empty()
    strip.get_by_role("button", name="Prove chaos").click()
    expect(strip.locator(".status")).to_have_text("not proven", timeout=WAIT)
    expect(rows).to_contain_text("no saddle with one impact a period was found")

    strip.get_by_role("button", name="Prove all orbits").click()
    expect(strip.locator(".status")).to_have_text("proven", timeout=WAIT)
    expect(rows).to_contain_text("1 orbit with 1 impact in 1 forcing period")
    set_box(page, "oscillator.stops.0.restitution", "0.6")
    set_box(page, "forcing.harmonics.0.omega", "2.2")
    strip.get_by_role("button", name="Prove basins").click()
    expect(strip.locator(".status")).to_have_text("proven in part", timeout=WAIT)
    expect(rows).to_contain_text("1 impact in 1 period")


def test_a_proof_is_cancelled_and_one_that_ends_early_is_marked(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("flint")
    monkeypatch.setattr(proof, "PATIENCE", 1.0)
    set_box(page, "oscillator.damping", "0")
    set_box(page, "oscillator.stops.0.at", "0")
    set_box(page, "run.periods", "20000")
    page.get_by_role("button", name="certify …").click()
    strip = page.locator("section[aria-label='Certify this run']")
    strip.get_by_role("button", name="Certify", exact=True).click()
    strip.get_by_role("button", name="Cancel").click()
    expect(strip.locator(".status")).to_have_text("cancelled")
    strip.get_by_role("button", name="Certify", exact=True).click()
    expect(strip.locator(".status")).to_contain_text("stopped after 1 s", timeout=WAIT)

    expect(strip.locator(".proof-rows")).to_contain_text("interrupted")
    expect(page.locator(".explore .plot .key").first).to_contain_text("green line")


def test_a_cursor_in_one_plot_is_marked_in_all(page: Page) -> None:
    over = page.locator(".explore .u-over")
    dots = page.locator(".explore .u-over .dot")
    time = page.locator(".explore .drawing .readout")
    for k in (0, 1, 2):
        expect(time).to_have_text("t = 0")
        # No impact is before the start.
        expect(dots.nth(2)).to_be_hidden()
        # Some place where the plot has its points.
        page.mouse.move(*middle(over.nth(k), 0.4, 0.4))
        page.mouse.move(*middle(over.nth(k), 0.41, 0.41))
        expect(time).not_to_have_text("t = 0")
        for shown in (0, 1, 2):
            expect(dots.nth(shown)).to_be_visible()
        page.mouse.move(2, 2)


def test_colours_are_those_of_the_system_until_they_are_chosen(page: Page) -> None:
    root, button = page.locator("#percuss"), page.get_by_role("button", name="Light or dark")
    page.emulate_media(color_scheme="dark")
    expect(root).to_have_attribute("data-theme", "dark")
    page.emulate_media(color_scheme="light")
    expect(root).to_have_attribute("data-theme", "light")
    grid = "getComputedStyle(document.querySelector('.plot')).getPropertyValue('--grid')"
    light = page.evaluate(grid)
    # The first choice is the one that is seen.
    button.click()
    expect(root).to_have_attribute("data-theme", "dark")
    assert page.evaluate(grid) != light
    button.click()
    page.emulate_media(color_scheme="dark")
    expect(root).to_have_attribute("data-theme", "light")
    assert page.evaluate(grid) == light
    # And back to the system, whichever that is by now.
    page.emulate_media(color_scheme="light")
    button.click()
    page.emulate_media(color_scheme="light")
    expect(root).to_have_attribute("data-theme", "light")


REPORT = """<!doctype html><title>r</title><article id="eq1"><h3>(1)</h3></article>
<div style="height:3000px"></div><article id="eq2"><h3>(2)</h3></article>"""


@pytest.fixture
def with_report(tmp_path: Path) -> Iterator[str]:
    """Address of a page that shows a report."""
    (tmp_path / "index.html").write_text(REPORT, encoding="utf-8")
    rows = [
        {"id": f"eq{k}", "reference": f"({k})", "claim": f"It is {k}.", "verdict": "holds", "grade": grade}
        for k, grade in ((1, "certified"), (2, "measured"))
    ]  # fmt: skip
    (tmp_path / "claims.json").write_text(json.dumps({"records": rows}), encoding="utf-8")
    with served(create_app(report=tmp_path)) as address:
        yield f"http://{address}/"


def test_verdicts_of_the_paper_say_how_certain_they_are(browser: Browser, with_report: str) -> None:
    page = browser.new_page()
    page.goto(with_report)
    page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    page.locator("[data-view=paper]").click()
    summary = page.locator(".verdicts summary")
    expect(summary).to_contain_text("1 certified")
    expect(summary).to_contain_text("1 measured")
    summary.click()
    expect(page.locator(".verdicts li").first).to_contain_text("It is 1.")
    frame = page.frame_locator("iframe[title='Report of the paper']")
    expect(frame.locator("#eq1")).to_be_in_viewport()
    page.locator("[data-claim=eq2]").click()
    expect(frame.locator("#eq2")).to_be_in_viewport(timeout=WAIT)
    page.locator("[data-figure=fig10]").click()
    expect(page.locator("section[aria-label=Explore]")).to_be_visible()
    page.close()
