"""The pictures of the workbench in docs/howto/workbench.md: drives `percuss serve` in Chromium.

Needs playwright and Chromium beside the extra `web`. The report of the paper is shown where one
is given:

    python examples/workbench_screenshots.py --out docs/images --report demo/paper
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import Locator, Page, ViewportSize, expect, sync_playwright

SIZE: ViewportSize = {"width": 1280, "height": 760}
PHONE: ViewportSize = {"width": 375, "height": 720}
WAIT = 240_000
# A picture in the documents is not larger [bytes].
MOST = 200_000


def main() -> None:
    """Take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--out", type=Path, default=Path("docs/images"))
    parser.add_argument("--report", type=Path)
    parser.add_argument("--only", nargs="*", choices=tuple(SHOWN), help="some of the pictures")
    given = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        sys.exit("no chromium is found")
    command = [sys.executable, "-m", "percuss", "serve", "--port", "0", "--no-open"]
    if given.report is not None:
        command += ["--report", str(given.report)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        address = server.stdout.readline().split()[3]
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=chromium, args=["--no-sandbox", "--disable-gpu"]
            )
            page = browser.new_page(viewport=SIZE)
            page.goto(address)
            page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
            for name, show in SHOWN.items():
                if name == "paper" and given.report is None:
                    continue
                if given.only is not None and name not in given.only:
                    continue
                page.set_viewport_size(SIZE)
                _light(page)
                show(page)
                _save(page, given.out / f"workbench_{name}.png")
            browser.close()
    finally:
        server.terminate()
        server.wait(20)


def _save(page: Page, file: Path) -> None:
    page.mouse.move(0, 0)
    page.wait_for_timeout(1500)
    page.screenshot(path=file)
    # The page has few colours.
    Image.open(file).convert("RGB").quantize(96, dither=Image.Dither.NONE).save(file, optimize=True)
    size = file.stat().st_size
    print(f"{file}: {size:,} bytes")
    assert size < MOST, "too large for the documents"


def _view(page: Page, name: str) -> Locator:
    page.locator(f"[data-view={name}]").click()
    return page.locator(f"section[aria-label={name.title()}]")


def _open(page: Page, preset: str) -> None:
    _view(page, "gallery")
    page.locator(f"[data-name={preset}]").click()
    page.wait_for_timeout(1000)


def _field(view: Locator, label: str) -> Locator:
    return view.locator(f'.settings label:has(> span:text-is("{label}")) :is(input, select)')


def _compute(view: Locator, settings: dict[str, str]) -> None:
    for label, value in settings.items():
        _field(view, label).fill(value)
        _field(view, label).blur()
    view.get_by_role("button", name="Compute", exact=True).click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)


def _explore(page: Page) -> None:
    _open(page, "fig06_above")
    row = page.locator(".row", has=page.locator("#p-start-v0"))
    row.get_by_role("button", name="range of the slider").click()
    row.get_by_role("button", name="finer").click()

    # Among the impacts of the beginning.
    time = page.locator(".explore").get_by_label("time of the picture")
    for _ in range(12):
        time.press("ArrowRight")
    time.blur()
    page.evaluate("scrollTo(0, 0)")


def _panel(page: Page) -> None:
    """A mass in SI units, a shaker whose force follows its frequency, and a record."""
    _open(page, "fig06_above")
    page.set_viewport_size({**SIZE, "height": 960})
    panel = page.locator("form.panel")
    panel.get_by_role("button", name="give it a mass").click()
    units = panel.get_by_role("group", name="units")
    for quantity, name in (("length", "mm"), ("time", "s"), ("mass", "t")):
        units.get_by_label(quantity).select_option(name)
    panel.get_by_label("name of a new parameter").fill("w")
    panel.get_by_role("button", name="add a parameter").click()
    for path, value in (
        ("parameters-w", "2.8"),
        ("forcing-harmonics-0-omega", "w"),
        ("forcing-harmonics-0-amplitude", "0.15*w**2"),
    ):
        page.locator(f"#p-{path}").fill(value)
        page.locator(f"#p-{path}").blur()
    table = "t,f\n" + "".join(f"{t},{f}\n" for t, f in ((0, 0), (5, 1), (6, -1), (20, 0), (40, 0)))
    panel.locator("input[type=file]").set_input_files(
        {"name": "gust.csv", "mimeType": "text/csv", "buffer": table.encode()}
    )
    panel.get_by_role("button", name="use it").click()
    page.wait_for_timeout(1500)


def _certify(page: Page) -> None:
    _open(page, "first_impacts")
    for path, value in (("oscillator-damping", "0"), ("oscillator-stops-0-at", "0")):
        page.locator(f"#p-{path}").fill(value)
    page.locator("#p-run-periods").fill("150")
    page.get_by_role("button", name="certify …").click()
    strip = page.locator("section[aria-label='Certify this run']")
    strip.get_by_role("button", name="Certify", exact=True).click()
    strip.locator(".proof-rows dt").first.wait_for(timeout=WAIT)


def _dark(page: Page) -> None:
    _open(page, "first_impacts")
    page.get_by_role("button", name="Light or dark").click()
    page.wait_for_timeout(3600)


def _light(page: Page) -> None:
    """Return to the colours of the system, wherever the picture before left them."""
    while page.locator("#percuss").get_attribute("data-theme") != "light":
        page.get_by_role("button", name="Light or dark").click()
        page.wait_for_timeout(3600)


def _diagram(page: Page) -> None:
    view = _view(page, "diagram")
    _compute(view, {"from": "2.2", "to": "2.95", "values": "2400"})
    _point(page, view, 0.86, 0.42)


def _response(page: Page) -> None:
    _open(page, "coco")
    view = _view(page, "diagram")
    _field(view, "kind").select_option("response")
    _compute(view, {"from": "0.5", "to": "1.5"})
    _point(page, view, 0.5, 0.5)


def _point(page: Page, view: Locator, across: float, down: float) -> None:
    """Show the motion at a place of a diagram."""
    box = view.locator(".u-over").first.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + across * box["width"], box["y"] + down * box["height"])
    page.wait_for_timeout(1500)


def _basins(page: Page) -> None:
    _open(page, "first_impacts")
    view = _view(page, "basins")
    _compute(view, {"x from": "-2", "v from": "-2", "v to": "2"})
    # Both saddles, and no sentence that looks for more.
    view.locator("[data-saddles='2']").wait_for(timeout=WAIT)
    expect(view.locator(".legend")).not_to_contain_text("looking", timeout=WAIT)


def _gallery(page: Page) -> None:
    _view(page, "gallery")
    page.wait_for_timeout(4000)


def _design(page: Page) -> None:
    _open(page, "first_impacts")
    page.locator("#p-forcing-harmonics-0-omega").fill("2")
    page.locator("#p-forcing-harmonics-0-omega").blur()
    page.set_viewport_size({**SIZE, "height": 1000})
    view = _view(page, "design")
    _field(view, "goal").select_option("largest")
    for path in ("stops.0.at", "damping"):
        view.locator(f"[data-free='oscillator.{path}']").check()
    view.get_by_role("button", name="add a limit").click()
    view.locator(".limits select").select_option("grazing_margin")
    view.locator(".limits input").first.fill("0.1")
    view.locator(".limits input").first.blur()
    view.get_by_role("button", name="Search").click()
    expect(view.locator(".status")).to_contain_text("done", timeout=WAIT)


def _structure(page: Page) -> None:
    _view(page, "gallery")
    page.set_viewport_size({**SIZE, "height": 980})
    page.locator("[data-mechanism=impact_pair]").click()
    page.wait_for_selector(".structure[data-drawn]", timeout=WAIT)
    page.wait_for_timeout(3000)


def _paper(page: Page) -> None:
    _view(page, "paper")
    page.wait_for_timeout(3000)


def _phone(page: Page) -> None:
    _open(page, "chatter")
    page.set_viewport_size(PHONE)


SHOWN = {
    "explore": _explore,
    "panel": _panel,
    "certify": _certify,
    "dark": _dark,
    "diagram": _diagram,
    "response": _response,
    "basins": _basins,
    "design": _design,
    "structure": _structure,
    "gallery": _gallery,
    "paper": _paper,
    "phone": _phone,
}


if __name__ == "__main__":
    main()
