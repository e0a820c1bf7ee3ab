"""Settings of all tests, and the one browser that those of pages share."""

from __future__ import annotations

import gc
import os
import shutil
import sys
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from playwright.sync_api import Browser, expect, sync_playwright
from tests.children import listen_to_ctrl_c

# Of examples that are drawn some by day, all at night. The first call of a kernel compiles it,
# which breaks any deadline of an example.
settings.register_profile("day", deadline=None, derandomize=True, max_examples=40)
settings.register_profile("night", deadline=None, derandomize=True)
settings.load_profile("day")

listen_to_ctrl_c()

LONG_TESTS = Path(__file__).with_name("long_tests.txt")

# How long a page is waited for [ms]: by itself 5 s, which a machine that does much else needs.
expect.set_options(timeout=60_000)


def pytest_configure(config: pytest.Config) -> None:
    """Draw all examples where the tests of the night run."""
    if not config.option.markexpr.startswith("not nightly"):
        settings.load_profile("night")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect without the garbage collector, which takes a quarter of the time and finds nothing.

    What then is there stays to the end, and is not looked through again.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        # percuss.kernels.compile asks at each kernel whether anything is frozen. To count it, all
        # of it is walked through, which takes a twentieth of a second.
        n_frozen = gc.get_freeze_count()
        pytest.MonkeyPatch().setattr(gc, "get_freeze_count", lambda: n_frozen)
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that tests/long_tests.txt names: they run at night. Those of pages begin.

    They wait for a browser more than half of their time: one worker begins with them while others
    compute, and they do not all stand at the end.
    """
    items.sort(key=lambda item: "tests/web/" not in item.nodeid)
    long = {line for line in LONG_TESTS.read_text(encoding="utf-8").splitlines() if line[0] != "#"}
    for item in items:
        case = item.nodeid.removeprefix("tests/")
        if case in long or case.partition("[")[0] in long:
            item.add_marker("nightly")


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    """Close the pictures of a test: of more than twenty that are open matplotlib warns."""
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


def pytest_xdist_auto_num_workers() -> int:
    """Two workers more than there are cores.

    Tests wait for browsers, processes and clocks a third of their time.
    """
    return 2 + (os.cpu_count() or 1)


# The first of these that is there. The one without windows takes a third less of the processor.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser")
# A browser that asks nobody anything.
ALONE = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A browser without a screen; one for all, for Playwright starts once in a thread."""
    chromium = next(filter(None, map(shutil.which, BROWSERS)), None)
    if chromium is None:
        if os.environ.get("PERCUSS_BROWSER") == "required":
            pytest.fail("no chromium is found, and PERCUSS_BROWSER says that there has to be one")
        pytest.skip("no chromium is found: pages are not tested in a browser")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium, args=list(ALONE))
        yield started
        started.close()
