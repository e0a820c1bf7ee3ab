"""The workbench as static files: in a browser that has no network, from a folder or a web host."""

from __future__ import annotations

import functools
import http.server
import json
import math
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect
from tests.web.frames import read_frame
from tests.web.hands import WAIT, box_of, compute, field, fill, link_of, set_box, view_of
from typer.testing import CliRunner

from percuss.cli.app import app
from percuss.execution import Execution
from percuss.web.explore import answer_explore, followed
from percuss.web.presets import presets
from percuss.web.request import PageRequest, study_of
from percuss.web.site import SITE_FILES, write_site
from percuss.web.view_study import study_of_view

# The numbers of a basin by what they are called.
WINDOW = {"x_low": "x from", "x_high": "x to", "v_low": "v from", "v_high": "v to"}
# Hears each motion that is drawn, as the view is given it.
LISTEN = """() => {
  const view = document.querySelector('.explore');
  globalThis.drawnMotions = 0;
  view.addEventListener('drawn', () => { globalThis.drawnMotions += 1; });
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("site")
    write_site(place)
    return place


@pytest.fixture(scope="module")
def offline(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(offline=True, viewport={"width": 1366, "height": 850})
    yield context
    context.close()


@pytest.fixture
def site(offline: BrowserContext, folder: Path) -> Iterator[Page]:
    """The site from its folder, its first motion drawn; any error of a script fails the test."""
    page = offline.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    page.goto((folder / "index.html").as_uri())
    page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    yield page
    page.close()
    assert errors == []


def test_a_folder_is_written_once(folder: Path) -> None:
    assert sorted(file.name for file in folder.iterdir()) == sorted(SITE_FILES)
    assert sum(file.stat().st_size for file in folder.iterdir()) < 15_000_000
    # Nothing is loaded from elsewhere.
    assert "/static/" not in (folder / "index.html").read_text()
    refused = CliRunner().invoke(app, ["site", "--out", str(folder)])
    assert refused.exit_code == 2
    assert "not empty; --force writes into it" in refused.output
    written = CliRunner().invoke(app, ["site", "--out", str(folder), "--force"])
    assert written.exit_code == 0
    assert "index.html" in written.output


def test_motions_are_those_of_percuss_without_a_network(site: Page) -> None:
    header, _ = read_frame(answer_explore(PageRequest(1, "explore", presets()[0].tables, {})))
    card = site.locator(".facts .card").first
    expect(card).to_contain_text(f"{header['n_impacts']} impacts")
    site.evaluate(LISTEN)
    set_box(site, "forcing.harmonics.0.omega", "2.7")
    site.wait_for_function("globalThis.drawnMotions > 0", timeout=WAIT)
    tables = json.loads(json.dumps(presets()[0].tables))
    tables["forcing"]["harmonics"][0]["omega"] = "2.7"
    header, _ = read_frame(answer_explore(PageRequest(1, "explore", tables, {})))
    expect(card).to_contain_text(f"{header['n_impacts']} impacts")


def test_the_exponent_of_a_motion_is_told_without_a_server(site: Page) -> None:
    times = site.locator(".facts .card").nth(1)
    expect(times).to_contain_text("not chaotic")
    site.locator("[data-view=gallery]").click()
    site.locator("[data-name=chaos]").click()
    expect(times).to_contain_text("largest exponent +0.1")
    # A motion that needs Python has none here.
    set_box(site, "forcing.harmonics.0.omega", "2.8 + 1/10 - 1/10")
    expect(times).to_contain_text("not told here")


# How many pixels of a picture in the gallery have the colour of a wall, and of a soft stop.
STOPS = """(name) => {
  const canvas = document.querySelector(`[data-name=${name}] canvas`);
  const style = getComputedStyle(canvas);
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  return ['--wall', '--stop'].map((colour) => {
    const wanted = [1, 3, 5].map((k) => parseInt(style.getPropertyValue(colour).trim().slice(k, k + 2), 16));
    return Array.from({ length: data.length / 4 }, (_, i) => wanted.every((part, k) => data[4 * i + k] === part) && data[4 * i + 3] === 255).filter((it) => it).length;
  });
}"""


def test_the_pictures_of_the_gallery_show_stops(site: Page) -> None:
    site.locator("[data-view=gallery]").click()
    site.wait_for_function(f"({STOPS})('two_attractors')[0] > 0", timeout=WAIT)
    for name, has in (("coco", [True, False]), ("gear_rattle", [False, True])):
        assert [count > 200 for count in site.evaluate(STOPS, name)] == has, name


def test_each_motion_of_the_gallery_opens(site: Page) -> None:
    site.locator("[data-view=gallery]").click()
    site.wait_for_function(
        "document.querySelectorAll('.preset canvas').length > 0 &&"
        "[...document.querySelectorAll('.preset canvas')].every((it) =>"
        " it.getContext('2d').getImageData(0, 0, it.width, it.height).data.some((x) => x))",
        timeout=WAIT,
    )
    site.locator("[data-name=chatter]").click()
    expect(site.locator(".explore")).to_be_visible()
    expect(site.locator(".facts")).to_contain_text("contact")


def test_links_hold_all_that_is_set(site: Page, offline: BrowserContext) -> None:
    set_box(site, "start.v0", "0.75")
    other = offline.new_page()
    other.goto(link_of(site))
    other.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    expect(box_of(other, "start.v0")).to_have_value("0.75")
    other.close()


def test_diagrams_are_computed_without_a_server(site: Page) -> None:
    view = view_of(site, "Diagram")
    fill(view, "values", "24")
    fill(view, "points at each", "6")
    compute(view)
    expect(view.locator(".legend")).to_contain_text("144 points")


def test_charts_of_two_parameters_are_computed_without_a_server(site: Page) -> None:
    view = view_of(site, "Diagram")
    field(view, "kind").select_option("sweep")
    fill(view, "cells along a side", "16")
    compute(view)
    expect(view.locator(".legend")).to_contain_text("period 1")
    # A motion of two harmonics is Python's.
    site.locator("[data-view=explore]").click()
    site.get_by_role("button", name="add a harmonic").click()
    view_of(site, "Diagram")
    view.get_by_role("button", name="Compute", exact=True).click()
    expect(view.locator(".status").first).to_contain_text("this chart needs pc.sweep")


def test_basins_are_computed_without_a_server(site: Page) -> None:
    site.locator("[data-view=gallery]").click()
    site.locator("[data-name=two_attractors]").click()
    view = view_of(site, "Basins")
    fill(view, "starts along a side", "96")
    compute(view)
    tables = next(row.tables for row in presets() if row.name == "two_attractors")
    window = {name: float(field(view, label).input_value()) for name, label in WINDOW.items()}
    asked = study_of_view(PageRequest(1, "basins", tables, window | {"starts": 96}))
    data = asked.question.answer(asked, Execution())
    columns = (data.name.values, data.fraction.values, data.fraction_error.values)
    for name, share, error in zip(*columns, strict=True):
        row = view.locator(".legend li", has_text=f"periodic {name}")
        # The error has two digits, and the share as many decimals.
        places = 1 - math.floor(math.log10(100 * error))
        expect(row).to_contain_text(f"{100 * share:.{places}f} ± {100 * error:.{places}f} %")
    # Their saddles are Python's.
    expect(view.locator(".legend")).to_contain_text("percuss serve")


def test_a_basin_that_is_cancelled_makes_way(site: Page) -> None:
    view = view_of(site, "Basins")
    fill(view, "starts along a side", "1024")
    view.get_by_role("button", name="Compute", exact=True).click()
    expect(view.locator(".status").first).to_contain_text("%", timeout=WAIT)
    view.get_by_role("button", name="Cancel").click()
    expect(view.locator(".status").first).to_have_text("cancelled")
    fill(view, "starts along a side", "32")
    compute(view)
    expect(view.locator(".legend")).to_contain_text("periodic")


def test_the_rest_says_what_it_needs(site: Page) -> None:
    view = view_of(site, "Diagram")
    field(view, "kind").select_option("response")
    view.get_by_role("button", name="Compute", exact=True).click()
    expect(view.locator(".status").first).to_contain_text("percuss serve")


def test_the_figures_of_the_paper_open_without_a_server(site: Page) -> None:
    paper = view_of(site, "Paper")
    expect(paper).to_contain_text("percuss site --report report")
    assert paper.get_by_role("button", name="Compute").count() == 0
    paper.locator("[data-figure=fig9]").click()
    expect(site.locator(".explore")).to_be_visible()
    expect(box_of(site, "start.v0")).to_have_value("0.139")


def test_a_report_goes_with_the_site(offline: BrowserContext, tmp_path: Path) -> None:
    report = tmp_path / "made"
    place = tmp_path / "site"
    refused = CliRunner().invoke(app, ["site", "--out", str(place), "--report", str(report)])
    assert refused.exit_code == 2
    assert "holds no report" in refused.output
    assert not place.exists()
    report.mkdir()
    (report / "index.html").write_text("<h1>All verdicts</h1>", encoding="utf-8")
    written = CliRunner().invoke(app, ["site", "--out", str(place), "--report", str(report)])
    assert written.exit_code == 0
    page = offline.new_page()
    page.goto((place / "index.html").as_uri())
    page.locator("[data-view=paper]").click()
    shown = page.frame_locator("section[aria-label=Paper] iframe")
    expect(shown.get_by_role("heading")).to_have_text("All verdicts")
    page.close()


def test_a_link_whose_motion_needs_python_says_so(site: Page, offline: BrowserContext) -> None:
    set_box(site, "forcing.harmonics.0.omega", "2.8 + 1/10")
    other = offline.new_page()
    other.goto(link_of(site))
    expect(other.locator(".stage > .fault").first).to_contain_text("percuss serve")
    outcome = other.locator(".facts .card").first
    expect(outcome).to_contain_text("no motion")
    # Longer than the page waits until it says that the engine is compiled.
    other.wait_for_timeout(2500)
    expect(outcome).to_contain_text("no motion")
    other.close()


def test_the_tour_promises_no_card_that_is_not_there(site: Page) -> None:
    site.get_by_role("button", name="Tour", exact=True).click()
    tour = site.locator(".tour")
    expect(tour).to_contain_text("1 of 5")
    expect(tour).not_to_contain_text("(1, 1)")


def test_a_web_host_serves_it(browser: Browser, folder: Path) -> None:
    handler = functools.partial(_Quiet, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{server.server_port}/")
        page.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
        page.close()
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        pass


def test_the_bits_of_a_motion_in_the_browser_are_those_of_python(page: Page) -> None:
    tables = [json.loads(json.dumps(row.tables)) for row in presets()]
    found = page.evaluate(
        """async (studies) => {
          const { loadKernels } = await import('/static/js/kernels.js');
          const { follow } = await import('/static/js/local_motion.js');
          const { readStudy } = await import('/static/js/local_study.js');
          const kernels = await loadKernels(await (await fetch('/static/kernels.wasm')).arrayBuffer());
          return studies.map((study) => {
            kernels.clear();
            return [...new BigInt64Array(follow(kernels, readStudy(study, kernels)).rows.events.buffer)].map(String);
          });
        }""",
        tables,
    )
    for row, bits in zip(presets(), found, strict=True):
        events, _ = followed(study_of(row.tables)).run.record
        assert np.array(bits, dtype=np.int64).tobytes() == events.tobytes()


def test_a_folder_that_a_site_cannot_be_written_to_is_one_sentence(tmp_path: Path) -> None:
    report = tmp_path / "paper"
    report.mkdir()
    (report / "index.html").write_text("mine", encoding="utf-8")
    told = {
        ("--out", str(report)): "the folder is not empty; --force writes into it",
        ("--out", str(report / "index.html")): "is a file, not a folder",
        # Its own first page would replace that of the report.
        ("--out", str(report), "--force", "--report", str(report)): "lies in the report",
        ("--out", str(report / "site"), "--report", str(report)): "lies in the report",
    }
    for arguments, words in told.items():
        result = CliRunner().invoke(app, ["site", *arguments])
        assert result.exit_code == 2
        assert words in result.stderr
        assert result.stderr.count("\n") == 1
    assert (report / "index.html").read_text(encoding="utf-8") == "mine"


def test_a_site_is_written_about_the_report_that_lies_in_it(tmp_path: Path) -> None:
    report = tmp_path / "report"
    report.mkdir()
    (report / "index.html").write_text("mine", encoding="utf-8")

    assert report / "index.html" in write_site(tmp_path, report=report, force=True)
    assert (report / "index.html").read_text(encoding="utf-8") == "mine"
