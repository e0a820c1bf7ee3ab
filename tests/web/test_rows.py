"""Sliders and boxes of the panel in a real browser: all digits, sound ranges, free vibration."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect
from tests.web.hands import (
    box_of,
    drag,
    drawn,
    fact,
    middle,
    row_of,
    set_box,
    slider_of,
    wait_for_drawing,
)

STIFFNESS = "oscillator.stiffness"
DAMPING = "oscillator.damping"


@pytest.mark.parametrize("width", [375, 1366])
def test_a_box_shows_all_digits(page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 800})
    row, box = row_of(page, "start.v0"), box_of(page, "start.v0")
    slider = slider_of(page, "start.v0")
    for text in ("0.4999", "0.499999", "0.499999999992", "0.49999999999200000012345"):
        set_box(page, "start.v0", text)
        box.blur()
        inner, seen = box.evaluate("it => [it.scrollWidth, it.clientWidth]")
        assert inner <= seen, text
        around = slider.bounding_box()
        assert around is not None
        assert around["width"] >= 90
    set_box(page, "start.v0", "0.4999999")
    row.get_by_role("button", name="range of the slider").click()
    for _ in range(8):
        row.get_by_role("button", name="finer").click()
        for name in ("slider from", "slider to"):
            end = row.get_by_label(name)
            # What is left beside the digits is for the arrows of the box.
            letters = len(end.input_value())
            needed = end.evaluate(
                """(it, n) => { const pen = document.createElement('canvas').getContext('2d');
                pen.font = getComputedStyle(it).font; return pen.measureText('0'.repeat(n)).width; }""",
                letters,
            )
            assert end.evaluate("it => it.clientWidth") >= needed + 10
    for _ in range(4):
        row.get_by_role("button", name="finer").click()
    expect(row.locator(".ends .note")).to_contain_text("no finer")


def test_the_slider_keeps_its_place_while_it_is_held(page: Page) -> None:
    row = row_of(page, "start.v0")
    row.get_by_role("button", name="range of the slider").click()
    for _ in range(4):
        row.get_by_role("button", name="finer").click()
    slider = slider_of(page, "start.v0")
    before = slider.bounding_box()
    begin = middle(slider)
    page.mouse.move(*begin)
    page.mouse.down()
    seen = []
    for step in range(1, 12):
        page.mouse.move(begin[0] + step, begin[1])
        seen.append(slider.bounding_box())
    page.mouse.up()

    assert all(it == before for it in seen)


def test_what_is_refused_does_not_move_the_ends_of_a_slider(page: Page) -> None:
    for path, text in ((STIFFNESS, "1e400"), (DAMPING, "-1e400")):
        row = row_of(page, path)
        row.get_by_role("button", name="range of the slider").click()
        ends = [row.get_by_label(name) for name in ("slider from", "slider to")]
        before = [it.input_value() for it in ends]
        good = box_of(page, path).input_value()
        set_box(page, path, text)
        expect(row.locator(".fault")).not_to_be_empty()
        assert [it.input_value() for it in ends] == before
        row.get_by_role("button", name="finer").click()
        assert all(it.input_value() for it in ends)
        box_of(page, path).blur()
        row.get_by_role("button", name="reset").click()
        expect(box_of(page, path)).to_have_value(good)
        expect(row.locator(".fault")).to_be_empty()
        assert [it.input_value() for it in ends] == before
    slider = slider_of(page, STIFFNESS)
    drag(page, middle(slider), middle(slider, 0.6))
    assert 1.0 < float(box_of(page, STIFFNESS).input_value()) < 4.0
    # One that is taken does.
    set_box(page, DAMPING, "3")
    expect(row_of(page, DAMPING).get_by_label("slider to")).to_have_value("4.5")


def test_without_harmonics_the_motion_is_free(page: Page) -> None:
    before = drawn(page)
    group = page.locator("fieldset", has=page.locator("legend", has_text="Harmonic"))
    group.get_by_role("button", name="remove").click()
    wait_for_drawing(page, before)

    expect(page.locator(".explore .fault").first).to_be_empty()
    expect(page.locator(".stage > .fault")).to_be_empty()
    # Sixty periods of 2 pi / 2.8.
    expect(box_of(page, "run.t_end")).to_have_value("135")
    assert page.get_by_label("Model").input_value() == "impact"
    assert "followed to its end" in fact(page, 0)


def test_the_side_of_a_stop_is_a_choice(page: Page) -> None:
    side = page.get_by_label("side of Wall")
    assert side.input_value() == "above"
    assert side.locator("option").all_inner_texts() == ["below the motion", "above the motion"]
    side.select_option("below")
    expect(page.locator(".explore .fault", has_text="below the wall")).to_have_count(1)
    assert "SoftStop" not in page.locator(".explore form.panel").inner_text()
