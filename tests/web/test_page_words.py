"""What the page says beside its pictures, in a real browser."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect
from tests.web.hands import box_of, compute, fact, field, fill, open_preset, set_box, view_of


def test_chaos_says_how_fast_neighbours_part_and_which_part_is_seen(page: Page) -> None:
    expect(view_of(page, "Gallery")).to_contain_text("Motions to begin with")
    open_preset(page, "chaos")
    times = page.locator(".facts .card").nth(1)
    expect(times).to_contain_text("chaotic")
    expect(times).to_contain_text("largest exponent +0.1")
    expect(page.locator(".plot:has(.canvas) strong").nth(1)).to_contain_text("Phase portrait, t = ")
    set_box(page, "run.periods", "20")
    expect(page.locator(".plot:has(.canvas) strong").nth(1)).to_have_text("Phase portrait")
    # A motion on its way is none.
    open_preset(page, "first_impacts")
    set_box(page, "run.periods", "14")
    expect(times).to_contain_text("not settled yet")
    expect(times).to_contain_text("largest exponent −0.09")  # noqa: RUF001
    assert "followed to its end" in fact(page, 0)


def test_files_say_how_they_are_read(page: Page) -> None:
    page.locator("summary", has_text="Files").click()
    menu = page.locator(".menu")
    expect(menu).to_contain_text("pandas.read_csv(name)")
    expect(menu).to_contain_text("open_datatree")


def test_a_share_of_all_starts_tells_what_the_number_of_starts_allows(page: Page) -> None:
    said = page.evaluate(
        """async () => {
          const { shareText } = await import('/static/js/basin_picture.js');
          return [shareText({ fraction: 1, error: 0 }, 65536), shareText({ fraction: 0.5, error: 0.002 }, 65536), shareText({ fraction: 1, error: 0 }, 256)];
        }"""
    )
    # By the rule of three: with 3 / n at 95 %.
    assert said == ["> 99.995 %", "50.00 ± 0.20 %", "> 98 %"]


def test_stops_are_counted_from_one_and_only_where_there_are_several(page: Page) -> None:
    titles = page.locator(".panel legend")
    assert "Wall" in titles.all_inner_texts()
    page.get_by_role("button", name="add a wall").click()
    expect(titles.filter(has_text="Wall 2")).to_have_count(1)
    assert "Wall 0" not in page.locator("form.panel").inner_text()
    expect(page.get_by_label("Model")).to_have_value("own")
    expect(box_of(page, "oscillator.stops.1.at")).to_be_visible()


def test_the_hint_of_a_diagram_is_of_the_picture_that_is_shown(page: Page) -> None:
    view = view_of(page, "Diagram")
    hint = view.locator("p.hint").last
    field(view, "kind").select_option("sweep")
    expect(hint).to_contain_text("Each cell is a motion")
    field(view, "kind").select_option("diagram")
    fill(view, "values", "40")
    fill(view, "points at each", "8")
    compute(view)
    field(view, "kind").select_option("sweep")
    expect(hint).to_contain_text("one point is an orbit of one period")
    fill(view, "cells along a side", "16")
    compute(view)
    expect(hint).to_contain_text("Each cell is a motion")


def test_a_picture_is_described_in_words_under_the_name_that_it_has(page: Page) -> None:
    names = page.locator(".explore .plot .canvas").evaluate_all(
        "all => all.map((it) => it.ariaLabel)"
    )
    titles = page.locator(".explore .plot:has(.canvas) strong").all_inner_texts()
    assert [name.split(":")[0] for name in names] == titles
    assert names[0].startswith("Displacement: displacement x from ")
    assert " over time t from 0 to " in names[0]
    view = view_of(page, "Design")
    plot = view.locator(".plot .canvas").last
    expect(plot).to_have_attribute("aria-label", re.compile("^Phase portrait: Search shows it;"))
    # The two ends of a range are called the same for each parameter.
    view.locator("[data-free='oscillator.stops.0.at']").check()
    row = view.get_by_role("group", name="Wall: at")
    expect(row.get_by_role("textbox", name="from")).to_be_visible()


def test_what_changes_all_the_time_is_not_read_out(page: Page) -> None:
    lives = page.locator(".explore .readout").evaluate_all("all => all.map((it) => it.ariaLive)")
    assert set(lives) == {"off"}
    view = view_of(page, "Diagram")
    status = view.locator(".status")
    status.evaluate(
        """it => {
          globalThis.heard = [];
          const hear = () => it.ariaLive === "off" || globalThis.heard.push(it.textContent);
          new MutationObserver(hear).observe(it, { childList: true, characterData: true, subtree: true });
        }"""
    )
    compute(view)
    heard = page.evaluate("globalThis.heard")
    assert heard[0] == "computing …"
    assert all(said.startswith("done in ") for said in heard[1:])
    assert len(heard) > 1
