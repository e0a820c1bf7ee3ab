"""A server of the page on loopback, a browser, and studies to ask it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Error, Page, ViewportSize
from tests.web.frames import motion_tables
from tests.web.hands import wait_for_server
from tests.web.serving import served

from percuss.web.app import create_app

SIZE: ViewportSize = {"width": 1366, "height": 850}


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    """Address of a running server, without a report."""
    with served(create_app()) as address:
        yield address


@pytest.fixture(scope="session")
def tab(browser: Browser) -> Iterator[Page]:
    """One tab for all tests: a new one takes longer than most of them."""
    context = browser.new_context(viewport=SIZE)
    yield context.new_page()
    context.close()


# Begins the workbench anew where a test has left the page whole, which takes a third of the time of
# a load.
BEGIN = """async () => {
  if (!globalThis.isWhole) return false;
  delete globalThis.isWhole;
  const { begin } = await import('/static/js/page.js');
  // At once: the workbench that ends may write its own link while this waits.
  history.replaceState(null, '', '/');
  scrollTo(0, 0);
  begin();
  return !document.querySelector('.explore').hidden;
}"""

# What nobody looks at is not painted, a quarter of the browser's time; all else of the page stays
# as it is.
UNPAINTED = "document.documentElement.style.opacity = '0'"


@pytest.fixture
def page(tab: Page, address: str, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The page, begun, its first motion drawn; any error of a script fails the test.

    A test that changes the window itself goes elsewhere with it at its end.
    """
    errors: list[str] = []

    def hear(said: ConsoleMessage) -> None:
        if said.type == "error":
            errors.append(said.text)

    def fail(error: Error) -> None:
        errors.append(str(error))

    tab.set_viewport_size(SIZE)
    tab.on("pageerror", fail)
    tab.on("console", hear)
    if not tab.evaluate(BEGIN):
        tab.goto("about:blank")
        tab.goto(f"http://{address}/")
    tab.evaluate(UNPAINTED)
    wait_for_server(tab)
    failed = request.session.testsfailed
    yield tab
    if request.session.testsfailed == failed and errors == []:
        tab.evaluate("globalThis.isWhole = document.querySelector('.explore[data-drawn]') !== null")
    tab.remove_listener("pageerror", fail)
    tab.remove_listener("console", hear)
    assert errors == []


@pytest.fixture
def study() -> dict[str, Any]:
    """The tables of a motion."""
    return motion_tables(periods=40)
