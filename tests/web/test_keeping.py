"""Files of every view, and links that hold all that is seen, in a real browser."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect
from tests.web.hands import (
    WAIT,
    compute,
    drag,
    field,
    fill,
    limits,
    link_of,
    middle,
    open_preset,
    view_of,
    wait_for_drawing,
)

from percuss.studies import load_study


def view_with(page: Page, kind: str) -> Locator:
    """Go to the view of a kind of request, with little to compute."""
    view = view_of(page, "Basins" if kind == "basins" else "Diagram")
    if kind == "response":
        field(view, "kind").select_option("response")
        for label, text in (("from", "3"), ("to", "3.05"), ("impacts up to", "1")):
            fill(view, label, text)
    elif kind == "diagram":
        fill(view, "values", "100")
    else:
        fill(view, "starts along a side", "48")
        # They take a moment in each picture, and have tests of their own.
        view.get_by_label("saddles and manifolds").uncheck()
    return view


def offered(page: Page) -> list[str]:
    page.locator("summary", has_text="Files").click()
    page.wait_for_selector("[data-file=toml]")
    found: list[str] = page.evaluate(
        "[...document.querySelectorAll('[data-file]')].map((it) => it.dataset.file)"
    )
    return found


def download(page: Page, name: str, target: Path) -> Path:
    if not page.locator(f"[data-file='{name}']").is_visible():
        page.locator("summary", has_text="Files").click()
    with page.expect_download(timeout=2 * WAIT) as waiting:
        page.locator(f"[data-file='{name}']").click()
    waiting.value.save_as(target / waiting.value.suggested_filename)
    return target / waiting.value.suggested_filename


@pytest.mark.parametrize(
    ("kind", "tables"),
    [
        ("diagram", ["diagram.csv"]),
        ("response", ["response.csv", "special_points.csv"]),
        ("basins", ["basins.csv", "attractors.csv"]),
    ],
)
def test_the_long_views_give_pictures_tables_and_their_study(
    page: Page, tmp_path: Path, kind: str, tables: list[str]
) -> None:
    view = view_with(page, kind)
    if kind != "response":
        # What is computed comes out of what is kept, the rest is computed for the file.
        compute(view)

    assert offered(page) == ["toml", "py", "png", "svg", *tables, "nc"]
    target = download(page, "toml", tmp_path)
    assert load_study(target).kind == kind
    assert 'damping = "0.05"' in target.read_text()
    if kind == "response":
        return
    begins = {"png": b"\x89PNG", "svg": b"<?xml", "nc": b"\x89HDF"}
    headers = {"diagram.csv": b"branch,", "basins.csv": b"start.", "attractors.csv": b"attractor,"}
    begins |= {name: headers[name] for name in tables}
    for name, begin in begins.items():
        file = download(page, name, tmp_path)
        assert file.stem == (kind if name in ("png", "svg", "nc") else name.removesuffix(".csv"))
        assert file.read_bytes().startswith(begin)


def test_a_motion_with_soft_stops_has_a_table_of_crossings(page: Page, tmp_path: Path) -> None:
    assert "crossings.csv" not in offered(page)
    page.keyboard.press("Escape")
    open_preset(page, "gear_rattle")

    assert "crossings.csv" in offered(page)
    text = download(page, "crossings.csv", tmp_path).read_text()
    assert len([line for line in text.splitlines() if not line.startswith("#")]) > 10


def test_a_link_holds_the_zoom_of_each_plot(page: Page) -> None:
    for k in (0, 1):
        over = page.locator(".explore .u-over").nth(k)
        drag(page, middle(over, 0.25, 0.25), middle(over, 0.5, 0.6))
    link = link_of(page)
    before = [limits(page, k) for k in range(4)]
    page.goto("about:blank")
    page.goto(link)
    page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    page.wait_for_timeout(300)

    for k in range(4):
        after = limits(page, k)
        for axis in ("x", "y"):
            assert after[axis] == pytest.approx(before[k][axis], rel=1e-6)
    # All of the motion is half as long again: it was zoomed indeed.
    page.locator(".explore .plot .canvas").first.focus()
    page.keyboard.press("0")
    page.wait_for_timeout(300)
    assert limits(page)["x"][1] > 1.5 * before[0]["x"][1]
    # And another motion is shown as a whole.
    open_preset(page, "fig10")
    assert "zooms" not in state_of(page.url) or state_of(page.url)["zooms"] == {}


def state_of(link: str) -> dict[str, Any]:
    text = link.split("#")[1]
    found: dict[str, Any] = json.loads(base64.urlsafe_b64decode(text + "=" * (-len(text) % 4)))
    return found


@pytest.mark.parametrize("kind", ["diagram", "basins"])
def test_a_link_to_a_picture_that_was_computed_shows_it(page: Page, kind: str) -> None:
    view = view_with(page, kind)
    compute(view)
    over = view.locator(".u-over").first
    drag(page, middle(over, 0.25, 0.25), middle(over, 0.5, 0.6))
    link = link_of(page)
    seen = view.locator(".canvas").first.get_attribute("data-limits")
    page.goto("about:blank")
    page.goto(link)
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)

    found = json.loads(view.locator(".canvas").first.get_attribute("data-limits") or "")
    for axis, ends in json.loads(seen or "").items():
        assert found[axis] == pytest.approx(ends, rel=1e-6)
    # What is set and not computed waits for its button.
    fill(view, "values" if kind == "diagram" else "starts along a side", "64")
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)
    expect(view).to_be_visible(timeout=WAIT)
    page.wait_for_timeout(600)
    expect(view.locator(".status")).to_be_empty()


def test_back_to_a_diagram_does_not_compute_it_again(page: Page) -> None:
    view = view_with(page, "diagram")
    compute(view)
    before = page.locator(".explore").get_attribute("data-drawn") or ""
    page.mouse.click(*middle(view.locator(".u-over").first, 0.25))
    wait_for_drawing(page, before)
    page.evaluate(
        "document.querySelector('section[aria-label=Diagram] .status').textContent = 'kept'"
    )
    page.go_back()

    expect(view).to_be_visible()
    page.wait_for_timeout(400)
    expect(view.locator(".status")).to_have_text("kept")
