"""What a user does to the page, and what there is to be seen."""

from __future__ import annotations

import base64
import json

from playwright.sync_api import Locator, Page, expect

# How long something is waited for that will come [ms].
WAIT = 240_000
# The page is asked again after so long [ms]: by itself at each frame, which draws frames for that.
AGAIN = 40


def follow_link(page: Page, address: str, state: object) -> None:
    """Go to a link of a state, and wait until its motion is drawn."""
    text = base64.urlsafe_b64encode(json.dumps(state).encode()).decode().rstrip("=")
    page.goto("about:blank")
    page.goto(f"http://{address}/#{text}")
    page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)


def drawn(page: Page) -> str:
    return page.locator(".explore").get_attribute("data-drawn") or ""


def wait_for_drawing(page: Page, before: str) -> None:
    page.wait_for_function(
        "before => document.querySelector('.explore').dataset.drawn !== before",
        arg=before,
        polling=AGAIN,
    )
    wait_for_server(page)


def wait_for_server(page: Page) -> None:
    """Wait until a motion is drawn, and for what the server tells of it."""
    page.wait_for_function(
        """() => {
          const card = document.querySelector('.facts .card:nth-child(2)');
          return document.querySelector('.explore[data-drawn]') !== null
            && !card.classList.contains('stale') && card.querySelector('dd').textContent !== '…';
        }""",
        timeout=WAIT,
        polling=AGAIN,
    )


def set_box(page: Page, path: str, text: str) -> None:
    page.locator(f"#p-{path.replace('.', '-')}").fill(text)


def open_preset(page: Page, name: str) -> None:
    before = drawn(page)
    page.locator("[data-view=gallery]").click()
    page.locator(f"[data-name={name}]").click()
    wait_for_drawing(page, before)


def link_of(page: Page) -> str:
    """Return the address once it holds all that was set."""
    page.wait_for_timeout(400)
    page.wait_for_function("() => document.querySelector('[data-linking]') === null")
    return page.url


def fact(page: Page, k: int) -> str:
    return page.locator(".facts .card").nth(k).inner_text()


def pixels(page: Page, k: int = 0) -> list[int]:
    """Return a few numbers that change with what a plot shows."""
    found = page.evaluate(
        """k => {
          const canvas = document.querySelectorAll('.explore .plot canvas')[k];
          const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
          const sums = new Array(16).fill(0);
          for (let i = 3; i < data.length; i += 4) sums[Math.floor(i * 16 / data.length)] += data[i];
          return sums;
        }""",
        k,
    )
    return list(found)


def box_of(page: Page, path: str) -> Locator:
    return page.locator(f"#p-{path.replace('.', '-')}")


def row_of(page: Page, path: str) -> Locator:
    return page.locator(".row", has=box_of(page, path))


def slider_of(page: Page, path: str) -> Locator:
    return row_of(page, path).locator("[type=range]")


def view_of(page: Page, name: str) -> Locator:
    """Go to a view by its tab."""
    page.locator(f"[data-view={name.lower()}]").click()
    return page.locator(f"section[aria-label={name}]")


def field(view: Locator, label: str) -> Locator:
    return view.locator(f'.settings label:has(> span:text-is("{label}")) :is(input, select)')


def fill(view: Locator, label: str, text: str) -> None:
    box = field(view, label)
    box.fill(text)
    box.blur()


def compute(view: Locator) -> None:
    """Compute, and wait for the end."""
    view.get_by_role("button", name="Compute", exact=True).click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)


def middle(area: Locator, across: float = 0.5, down: float = 0.5) -> tuple[float, float]:
    """Return a place in an element, in pixels of the window."""
    box = area.bounding_box()
    assert box is not None
    return box["x"] + across * box["width"], box["y"] + down * box["height"]


def drag(page: Page, begin: tuple[float, float], end: tuple[float, float], steps: int = 5) -> None:
    page.mouse.move(*begin)
    page.mouse.down()
    page.mouse.move(*end, steps=steps)
    page.mouse.up()


def limits(page: Page, k: int = 0) -> dict[str, list[float]]:
    """Return what a plot shows: the ends of x and of y."""
    found: dict[str, list[float]] = page.evaluate(
        "k => JSON.parse(document.querySelectorAll('.explore .plot .canvas')[k].dataset.limits)", k
    )
    return found
