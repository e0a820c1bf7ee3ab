"""A study file that is dropped on the page, changes taken back, and two settings compared."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from tests.web.frames import read_frame
from tests.web.hands import box_of, drawn, set_box, view_of, wait_for_drawing

from percuss.errors import ParameterError
from percuss.studies import parse_study, template_text
from percuss.studies.link import link_of
from percuss.web.request import BadRequest, PageRequest
from percuss.web.study_file import answer_study_file

FREQUENCY = "forcing.harmonics.0.omega"


def request(toml: Any) -> PageRequest:
    return PageRequest(1, "study_file", {}, {"toml": toml})


@pytest.mark.parametrize("template", ["impact", "diagram", "response", "basins"])
def test_a_study_file_gives_its_link(template: str) -> None:
    text = template_text(template)
    header, _ = read_frame(answer_study_file(request(text)))
    assert header["link"] == link_of(parse_study(text))


def test_what_is_no_study_of_the_page_is_told() -> None:
    text = template_text("impact").replace("stiffness", "stiffnes")
    with pytest.raises(BadRequest, match=r"line \d+: oscillator\.stiffnes: unknown key"):
        answer_study_file(request(text))
    with pytest.raises(BadRequest, match="and 4 more"):
        answer_study_file(request("\n".join(f"[table{i}]" for i in range(8))))
    with pytest.raises(BadRequest, match="not a text"):
        answer_study_file(request(3))
    with pytest.raises(ParameterError, match="not on the page"):
        answer_study_file(request(template_text("orbit")))


def drop(page: Page, name: str, text: str) -> None:
    data = page.evaluate_handle(
        """([name, text]) => {
          const data = new DataTransfer();
          data.items.add(new File([text], name));
          return data;
        }""",
        [name, text],
    )
    page.locator("form.panel").dispatch_event("drop", {"dataTransfer": data})


def test_a_study_is_dropped_on_the_page(page: Page) -> None:
    drop(page, "mine.toml", template_text("impact").replace("stiffness", "stiffnes"))
    dialog = page.get_by_role("dialog", name="Faults of the file")
    expect(dialog).to_contain_text("oscillator.stiffnes: unknown key")
    dialog.get_by_role("button", name="Close").click()
    expect(dialog).to_have_count(0)

    text = template_text("impact").replace("omega = ", "omega = 0.5 #")
    before = drawn(page)
    drop(page, "mine.toml", text)
    wait_for_drawing(page, before)
    expect(box_of(page, FREQUENCY)).to_have_value("0.5")
    drop(page, "diagram.TOML", template_text("diagram"))
    expect(page.locator("section[aria-label=Diagram]")).to_be_visible()


def test_a_workbench_that_ended_takes_no_files(page: Page) -> None:
    page.evaluate("async () => (await import('/static/js/page.js')).begin()")
    page.wait_for_selector(".explore[data-drawn]")
    before = drawn(page)
    drop(page, "mine.toml", template_text("impact").replace("omega = ", "omega = 0.5 #"))
    wait_for_drawing(page, before)
    expect(box_of(page, FREQUENCY)).to_have_value("0.5")


def test_a_study_is_opened_from_the_gallery(page: Page, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(template_text("impact").replace("omega = ", "omega = 0.75 #"), encoding="utf-8")
    view_of(page, "Gallery").locator("input[type=file]").set_input_files(file)

    expect(box_of(page, FREQUENCY)).to_have_value("0.75")
    expect(page.locator(".explore")).to_be_visible()


def test_changes_are_taken_back_and_made_again(page: Page) -> None:
    first = box_of(page, FREQUENCY).input_value()
    for value in ("2.5", "2.6"):
        before = drawn(page)
        set_box(page, FREQUENCY, value)
        wait_for_drawing(page, before)
        page.wait_for_timeout(850)
    page.locator("h1").click()
    page.keyboard.press("Control+z")
    expect(box_of(page, FREQUENCY)).to_have_value("2.5")
    page.get_by_role("button", name="Undo").click()
    expect(box_of(page, FREQUENCY)).to_have_value(first)
    page.get_by_role("button", name="Undo").click()
    expect(page.locator(".toast")).to_have_text("nothing to undo")
    page.keyboard.press("Control+Shift+z")
    page.keyboard.press("Control+Shift+z")
    expect(box_of(page, FREQUENCY)).to_have_value("2.6")
    page.keyboard.press("Control+z")
    expect(box_of(page, FREQUENCY)).to_have_value("2.5")


def test_a_motion_is_kept_behind_the_next_ones(page: Page) -> None:
    motion = page.locator(".explore .plot").first
    keep = motion.get_by_role("button", name="keep")
    keep.click()
    before = drawn(page)
    set_box(page, FREQUENCY, "2.5")
    wait_for_drawing(page, before)

    expect(motion).to_contain_text("pale: the kept motion, omega = 2.8")
    motion.get_by_role("button", name="forget").click()
    expect(motion).not_to_contain_text("pale: the kept motion")
