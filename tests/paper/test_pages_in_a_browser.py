"""The pages of the report in a browser: filters, keyboard, phone, print, the figure that moves."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image
from playwright.sync_api import Browser, Page, expect
from tests.paper.test_report import CORRECTED, FAILS, HOLDS, OPEN, result

from percuss.motion.half_harmonic import half_harmonic_impact
from percuss.paper.claim import Claim
from percuss.paper.collection import Item
from percuss.paper.figure_files import Drawn
from percuss.paper.report.page import pages

PHONE = {"width": 375, "height": 800}
# As many records and figures as the article has.
RECORDS, FIGURES = 110, 16
LONG = r"V_{k+2} = V_k + \frac{\pi}{2}\,\frac{\frac{\pi}{2}\cos^2 t_k + \sin 2t_k}{V_k}"
OVERFLOWING = """
[...document.querySelectorAll("body *")].filter((element) => {
  const { right, width } = element.getBoundingClientRect();
  return width && right > innerWidth + 1 && !element.closest(".scroll, .formula-box, pre, svg");
}).map((element) => element.outerHTML.slice(0, 80))
"""


def claims() -> list[Claim]:
    """Return records of all verdicts, as many as the article has, with long formulas."""
    of_each = [replace(claim, formula=LONG) for claim in (HOLDS, FAILS, CORRECTED, OPEN)]
    kinds = [of_each[0]] * 8 + [of_each[1], of_each[2], of_each[3]]
    return [
        replace(kinds[k % len(kinds)], id=f"record{k}", claim=f"Statement {k} on V_k. " * 4)
        for k in range(RECORDS)
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of the size of the article's."""
    out = tmp_path_factory.mktemp("report")
    files = tuple(out / f"fig10{suffix}" for suffix in (".svg", ".png", ".nc", ".csv"))
    files[0].write_text("x" * 1_000_000)
    image.imsave(files[1], np.ones((900, 700, 3)))
    names = [f"fig{k}" for k in range(1, FIGURES + 1)]
    items = [Item("figure", name, "family_figures", "impact-times") for name in names]
    whole = result(out, *claims())
    whole = replace(
        whole,
        items=(*whole.items, *items),
        figures={name: Drawn(name, f"title of {name}", "Caption. " * 40, files) for name in names},
    )
    for name, text in pages(whole).items():
        (out / name).write_text(text, encoding="utf-8")
    return out


@pytest.fixture
def tab(browser: Browser, folder: Path) -> Iterator[Page]:
    """The page on the article, which must throw no error."""
    errors: list[str] = []
    with browser.new_context() as context:
        opened = context.new_page()
        opened.on("pageerror", lambda error: errors.append(str(error)))
        opened.goto((folder / "index.html").as_uri())
        yield opened
    assert errors == []


def shown(tab: Page) -> int:
    return tab.locator("details.record:visible").count()


def test_counts_lead_to_the_records_that_they_count(tab: Page) -> None:
    assert shown(tab) == RECORDS
    link = tab.locator('.counts a[href*="fails"]')
    number = int(link.locator("b").inner_text())
    link.click()

    assert 0 < number < RECORDS
    assert shown(tab) == number
    expect(tab.locator("form.filter output")).to_have_text(f"{number} of {RECORDS}")
    assert "verdict=fails" in tab.url
    # The address alone shows the same.
    tab.reload()
    assert shown(tab) == number
    tab.go_back()
    assert shown(tab) == RECORDS


def test_records_are_filtered_by_verdict_evidence_and_text(tab: Page) -> None:
    tab.locator("select[name=verdict]").select_option("corrected")
    some = shown(tab)
    tab.locator("select[name=evidence]").select_option("deduced")
    assert shown(tab) == 0
    tab.locator("select[name=evidence]").select_option("measured")
    assert shown(tab) == some
    tab.locator("select[name=verdict]").select_option("")
    tab.locator("input[name=text]").fill("STATEMENT 77 ")
    assert shown(tab) == 1


def test_a_link_to_a_record_opens_it_even_where_it_is_filtered_out(tab: Page) -> None:
    tab.locator("select[name=verdict]").select_option("fails")
    tab.evaluate("location.hash = '#record0'")

    record = tab.locator("#record0")
    expect(record).to_have_attribute("open", "")
    expect(record.locator(".inside")).to_be_visible()
    expect(record).to_be_in_viewport()


def test_all_of_it_can_be_read_without_scripts(browser: Browser, folder: Path) -> None:
    with browser.new_context(java_script_enabled=False) as context:
        tab = context.new_page()
        tab.goto((folder / "index.html").as_uri())

        assert shown(tab) == RECORDS
        expect(tab.locator("form.filter")).to_be_hidden()
        record = tab.locator("#record3")
        record.locator("> summary").click()
        expect(record.locator(".inside")).to_be_visible()
        expect(tab.locator("#explorer noscript")).to_have_count(1)


def test_the_keyboard_reaches_the_contents_and_opens_a_record(tab: Page) -> None:
    tab.keyboard.press("Tab")
    skip = tab.locator(".skip")
    expect(skip).to_be_focused()
    expect(skip).to_be_in_viewport()
    assert skip.evaluate("e => getComputedStyle(e).outlineStyle") == "solid"
    record = tab.locator("#record5")
    record.locator("> summary").focus()
    tab.keyboard.press("Enter")
    expect(record).to_have_attribute("open", "")


@pytest.mark.parametrize("name", ["index.html", "beyond.html", "coverage.html"])
def test_nothing_is_wider_than_a_phone(name: str, browser: Browser, folder: Path) -> None:
    with browser.new_context(viewport=PHONE) as context:  # type: ignore[arg-type]
        tab = context.new_page()
        tab.goto((folder / name).as_uri())
        tab.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))")

        assert tab.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
        assert tab.evaluate(OVERFLOWING) == []


def test_it_is_dark_where_the_system_is(tab: Page) -> None:
    colour = "getComputedStyle(document.body).backgroundColor"
    light = tab.evaluate(colour)
    tab.emulate_media(color_scheme="dark")

    assert sum(map(int, re.findall(r"\d+", light))) > 700
    assert sum(map(int, re.findall(r"\d+", tab.evaluate(colour)))) < 150


def test_on_paper_it_has_fewer_than_25_pages_and_none_is_wasted(tab: Page) -> None:
    tab.locator("#record3 > summary").click()
    printed = tab.pdf(format="A4")

    count = len(re.findall(rb"/Type\s*/Page\b", printed))
    assert 4 < count < 25
    tab.emulate_media(media="print")
    expect(tab.locator("#record3 .inside")).to_be_hidden()
    expect(tab.locator("#record4 .badge")).to_be_visible()
    # What is printed fills its pages: an A4 page has 269 mm of text, at 96 dots an inch.
    tab.set_viewport_size({"width": 688, "height": 1017})
    height = tab.evaluate("document.documentElement.scrollHeight")
    assert count < 1.35 * height / 1017 + 2


def slide(tab: Page, name: str, value: float) -> None:
    move = "(e, value) => { e.value = value; e.dispatchEvent(new Event('input')); }"
    tab.locator(f"#{name}").evaluate(move, value)


@pytest.mark.parametrize(("velocity", "factor"), [(1.0, 0.6923), (10.0, 0.2994)])
def test_the_figure_shows_the_factors_of_the_theory(
    velocity: float, factor: float, tab: Page
) -> None:
    """As in docs/theory/half-harmonic.md, from the phase 0."""
    slide(tab, "velocity", velocity)

    assert float(tab.locator("#factor").inner_text()) == pytest.approx(factor, abs=1e-4)
    psi = float(tab.locator("#psi").inner_text())
    assert math.sqrt(math.sin(2.0 * psi) / 2.0) == pytest.approx(factor, abs=2e-4)
    assert tab.locator("#portrait polyline").count() == 12


@pytest.mark.parametrize(("phase", "velocity"), [(2.0, 3.0), (4.5, 0.5), (0.7, 7.0)])
def test_the_figure_flies_as_the_engine_does(phase: float, velocity: float, tab: Page) -> None:
    slide(tab, "phase", phase)
    slide(tab, "velocity", velocity)

    t, v = phase, velocity
    for _ in range(400):
        t, v = half_harmonic_impact(t, v)
    assert float(tab.locator("#late").inner_text()) == pytest.approx(t % math.pi, abs=1e-4)
    assert float(tab.locator("#ratio").inner_text()) == pytest.approx(v / math.sqrt(t), abs=1e-4)


def test_the_sliders_are_moved_by_keys(tab: Page) -> None:
    before = tab.locator("#psi").inner_text()
    tab.locator("#phase").focus()
    for _ in range(5):
        tab.keyboard.press("ArrowRight")

    expect(tab.locator("#phase-out")).to_have_text("0.05")
    assert tab.locator("#psi").inner_text() != before
