"""What is seen and touched: colours of the dark, sizes for fingers, cards of an earlier motion."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from playwright.sync_api import Browser, Locator, Page, expect
from tests.web.hands import (
    compute,
    drawn,
    field,
    fill,
    open_preset,
    row_of,
    set_box,
    view_of,
    wait_for_drawing,
)
from tests.web.serving import served

from percuss.web.app import create_app

# Of a picture: how light its pixels are on the average, from 0 to 255.
_LIGHTNESS = """canvas => {
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let [sum, n] = [0, 0];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] < 255) continue;
    sum += (data[i] + data[i + 1] + data[i + 2]) / 3;
    n += 1;
  }
  return sum / n;
}"""
_SMALL = """() => [...document.querySelectorAll('button, select, input, summary, a, textarea')]
  .filter((it) => it.offsetParent !== null)
  .map((it) => [it.outerHTML.slice(0, 80), it.getBoundingClientRect()])
  .filter(([, box]) => box.width < 24 || box.height < 24)
  .map(([text, box]) => `${box.width} x ${box.height}: ${text}`)"""


@pytest.fixture
def phone(browser: Browser, address: str) -> Iterator[Page]:
    """The page on a phone."""
    context = browser.new_context(
        viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True
    )
    opened = context.new_page()
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=240_000)
    yield opened
    context.close()


def lightness(view: Locator) -> float:
    return float(view.locator(".plot canvas").first.evaluate(_LIGHTNESS))


def test_basins_do_not_glare_in_the_dark(page: Page) -> None:
    view = view_of(page, "Basins")
    fill(view, "starts along a side", "32")
    field(view, "saddles and manifolds").uncheck()
    compute(view)
    light = lightness(view)
    page.get_by_label("Light or dark").click()
    expect(page.locator("#percuss")).to_have_attribute("data-theme", "dark")
    dark = lightness(view)

    assert light > 150
    assert dark < 110


def test_the_report_has_the_colours_of_the_page(browser: Browser, tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text(
        "<style>body { background: #fff } @media (prefers-color-scheme: dark) "
        "{ body { background: #111 } }</style>text",
        encoding="utf-8",
    )
    with served(create_app(report=tmp_path)) as address:
        context = browser.new_context(color_scheme="light")
        page = context.new_page()
        page.goto(f"http://{address}/")
        view_of(page, "Paper")
        seen = []
        # Those of the system, and the other ones.
        for _ in range(2):
            page.wait_for_timeout(200)
            picture = imread(io.BytesIO(page.locator("iframe").screenshot()))
            seen.append(float(picture[..., :3].mean()))
            page.get_by_label("Light or dark").click()
        context.close()
    assert seen[0] > 0.8
    assert seen[1] < 0.25


def test_on_a_phone_a_finger_hits_everything(phone: Page) -> None:
    for name in ("Diagram", "Basins", "Structure", "Paper", "Gallery", "Explore"):
        view_of(phone, name)
        if name == "Explore":
            for it in phone.locator(".row .more").all()[:2]:
                it.click()
            phone.get_by_text("Files", exact=True).click()

        assert phone.evaluate(_SMALL) == [], name


def test_on_a_phone_the_keys_come_to_nothing_that_is_behind_the_plots(phone: Page) -> None:
    phone.locator("#p-run-periods").focus()
    behind = []
    for _ in range(30):
        phone.keyboard.press("Shift+Tab")
        behind += phone.evaluate(
            """() => {
              const it = document.activeElement;
              const { x, y, width, height } = it.getBoundingClientRect();
              const seen = document.elementFromPoint(x + width / 2, y + height / 2);
              return it.contains(seen) || seen?.contains(it) ? [] : [it.outerHTML.slice(0, 80)];
            }"""
        )

    assert behind == []


def test_a_text_to_copy_that_comes_behind_the_help_does_not_stay(page: Page) -> None:
    # As on pages over a network without TLS, which have no clipboard.
    page.evaluate(
        "Object.defineProperty(navigator, 'clipboard', { value: undefined, configurable: true })"
    )
    page.get_by_role("button", name="Copy link").click()
    expect(page.locator("textarea.copy")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.locator("textarea.copy")).to_have_count(0)
    page.evaluate(
        """() => {
          [...document.querySelectorAll('button')].find((it) => it.textContent === 'Copy as Python').click();
          [...document.querySelectorAll('button')].find((it) => it.textContent === '?').click();
        }"""
    )
    expect(page.locator("dialog[open]")).to_be_visible()
    page.wait_for_timeout(500)

    expect(page.locator("textarea.copy")).to_have_count(0)
    page.keyboard.press("Escape")
    page.evaluate("delete navigator.clipboard")


def test_lists_of_terms_hold_terms_and_descriptions_alone(page: Page) -> None:
    wrong = page.evaluate(
        """() => [...document.querySelectorAll('dl')].flatMap((list) => [...list.children].flatMap(
          (it) => (it.tagName === 'DIV' ? [...it.children] : [it]).map((part) => part.tagName),
        )).filter((tag) => tag !== 'DT' && tag !== 'DD')"""
    )

    assert wrong == []


def test_a_value_far_beyond_a_slider_widens_it_no_longer_than_it_lasts(page: Page) -> None:
    path = "start.t0"
    row = row_of(page, path)
    ends = row.locator(".ends input")
    row.locator(".more").click()
    before = [ends.nth(k).input_value() for k in (0, 1)]
    seen = drawn(page)
    set_box(page, path, "1e6")
    wait_for_drawing(page, seen)
    expect(ends.nth(1)).to_have_value("1500000")
    set_box(page, path, "2")

    for k, value in enumerate(before):
        expect(ends.nth(k)).to_have_value(value)


def test_what_is_known_of_an_earlier_motion_is_grey(page: Page) -> None:
    card = page.locator(".facts .card").nth(2)
    expect(card).not_to_have_class("card stale")
    # The server is slow to tell what it knows.
    page.evaluate(
        """() => {
          const { send } = WebSocket.prototype;
          WebSocket.prototype.send = function (text) {
            if (!text.includes('facts')) send.call(this, text);
          };
        }"""
    )
    seen = drawn(page)
    set_box(page, "forcing.harmonics.0.omega", "2.9")
    wait_for_drawing(page, seen)

    expect(card).to_have_class("card stale")
    page.goto("about:blank")


def test_what_comes_before_a_motion_has_settled_is_pale(page: Page) -> None:
    # The impacts of the second half of the run, and those of the first half.
    strong, pale = page.evaluate(
        """() => {
          const plot = [...document.querySelectorAll('.explore .plot')].find((it) => it.textContent.includes('Impacts'));
          const canvas = plot.querySelector('canvas');
          const colour = getComputedStyle(plot).getPropertyValue('--curve').trim();
          const wanted = [1, 3, 5].map((k) => Number.parseInt(colour.slice(k, k + 2), 16));
          const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
          const counts = [0, 0];
          for (let i = 0; i < data.length; i += 4) {
            if (!wanted.every((value, k) => Math.abs(value - data[i + k]) < 8)) continue;
            if (data[i + 3] > 250) counts[0] += 1;
            else if (data[i + 3] > 40 && data[i + 3] < 120) counts[1] += 1;
          }
          return counts;
        }"""
    )
    # Six impacts in a place take no more room than one, and the transient is spread.
    assert 20 < strong < pale


def lab(colour: str) -> np.ndarray:
    """Return a colour as lightness and two opponents, between which distances are as seen."""
    red_green_blue = np.array([int(part, 16) for part in re.findall("[0-9a-f]{2}", colour)]) / 255
    linear = np.where(
        red_green_blue <= 0.04045, red_green_blue / 12.92, ((red_green_blue + 0.055) / 1.055) ** 2.4
    )
    # CIE 1976, of sRGB with the white of D65.
    xyz = np.array([[0.4339, 0.3762, 0.1899], [0.2126, 0.7152, 0.0722], [0.0177, 0.1095, 0.8729]])
    x, y, z = np.cbrt(xyz @ linear)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_families_have_colours_that_can_be_told_apart(page: Page, theme: str) -> None:
    root = page.locator("#percuss")
    if root.get_attribute("data-theme") != theme:
        page.get_by_label("Light or dark").click()
        expect(root).to_have_attribute("data-theme", theme)
    colours = root.evaluate(
        """(it) => ["--curve", "--orbit", "--c3", "--c4", "--c5", "--c6"]
          .map((name) => getComputedStyle(it).getPropertyValue(name).trim())"""
    )

    # Two patches side by side differ at 2.3; thin lines apart from each other need ten times that.
    apart = {pair: np.linalg.norm(lab(pair[0]) - lab(pair[1])) for pair in combinations(colours, 2)}
    assert min(apart.values()) > 20, apart


def test_a_long_name_of_a_parameter_leaves_its_slider_free(page: Page) -> None:
    page.get_by_label("name of a new parameter").fill("amplitude_of_the_shaker_in_the_laboratory")
    page.get_by_role("button", name="add a parameter").click()
    label = page.locator(".row label", has_text="amplitude_of_the_shaker").first
    expect(label).to_be_visible()

    assert label.evaluate("(it) => it.scrollWidth <= it.clientWidth")


def test_a_motion_of_the_gallery_is_seen_from_its_beginning(page: Page) -> None:
    page.set_viewport_size({"width": 1280, "height": 500})
    open_preset(page, "moored_tower")
    assert page.evaluate("scrollY") == 0


def test_small_plots_stand_below_each_other_in_a_narrow_window(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    view = view_of(page, "Diagram")
    first, second = (plot.bounding_box() for plot in view.locator(".beside .plot").all())
    assert first is not None
    assert second is not None
    assert first["y"] + first["height"] <= second["y"]


@pytest.mark.parametrize("name", ["Explore", "Fit", "Design", "Structure"])
def test_in_a_low_window_the_plots_do_not_hide_the_form(page: Page, name: str) -> None:
    # As a window of 1280 x 1024 that is enlarged four times.
    page.set_viewport_size({"width": 320, "height": 256})
    view = view_of(page, name)
    control = view.locator("form :is(input, select):visible").last
    control.scroll_into_view_if_needed()
    seen = control.evaluate(
        """(it) => {
          const { x, y, width, height } = it.getBoundingClientRect();
          return it.contains(document.elementFromPoint(x + width / 2, y + height / 2));
        }"""
    )
    assert seen
    page.goto("about:blank")


def test_a_label_is_no_longer_than_its_plot(page: Page) -> None:
    page.set_viewport_size({"width": 683, "height": 500})
    plot = page.locator('.explore .plot[data-y="speed before the impact"]')
    expect(plot.locator(".canvas")).to_be_visible()
    page.wait_for_timeout(300)
    # The ends of the label are the outermost dark pixels of the first columns: none is at the edge.
    edges = plot.locator("canvas").evaluate(
        """(canvas) => {
          const { data, width } = canvas.getContext('2d').getImageData(0, 0, Math.round(14 * devicePixelRatio), canvas.height);
          const rows = [];
          for (let i = 3; i < data.length; i += 4) if (data[i] > 99) rows.push(Math.floor(i / 4 / width));
          return [Math.min(...rows), canvas.height - Math.max(...rows)];
        }"""
    )
    assert min(edges) > 2
    page.goto("about:blank")


@pytest.mark.parametrize("name", ["Explore", "Structure"])
def test_sliders_take_all_the_room_below_the_plots(page: Page, name: str) -> None:
    # As a window of 1366 pixels that is enlarged twice.
    page.set_viewport_size({"width": 683, "height": 700})
    view = view_of(page, name)
    panel = view.locator("form.panel")
    groups = panel.locator("fieldset")
    left = {round(group.bounding_box()["x"]) for group in groups.all()}  # type: ignore[index]

    assert len(left) == 2
    assert panel.evaluate("it => it.scrollWidth <= it.clientWidth")
    page.goto("about:blank")
