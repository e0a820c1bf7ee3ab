"""The report of the paper is computed on demand, once, and shown."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect
from tests.web.hands import WAIT
from tests.web.serving import served
from tests.web.test_server import fetched

from percuss.web import report_job
from percuss.web.app import create_app
from percuss.web.report_job import ReportJob

WRITES = """
import pathlib, sys, time
folder = pathlib.Path(sys.argv[1])
time.sleep(0.5)
folder.mkdir()
(folder / "index.html").write_text("<p>the report</p><script>document.title = 'it ran'</script>")
(folder / "claims.json").write_text("[]")
"""


@pytest.fixture
def own_address(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    monkeypatch.setattr(report_job, "COMMAND", (sys.executable, "-c", WRITES))
    with served(create_app()) as address:
        yield address


def ended(job: ReportJob) -> dict[str, object]:
    end = time.monotonic() + 240.0
    while job.state()["state"] == "working" and time.monotonic() < end:
        time.sleep(0.02)
    return job.state()


def test_it_is_computed_once_and_removed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_job, "COMMAND", (sys.executable, "-c", WRITES))
    job = ReportJob()
    assert job.state()["state"] == "none"
    job.start()
    process = job._process
    job.start()
    assert job._process is process
    assert job.state()["state"] == "working"
    assert ended(job)["state"] == "done"
    assert job.scripts == ["document.title = 'it ran'"]
    job.start()
    assert job.state()["state"] == "done"
    folder: Path = job.folder
    job.close()
    assert not folder.exists()


def test_one_that_fails_says_so_and_can_begin_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_job, "COMMAND", (sys.executable, "-c", "raise SystemExit(2)"))
    job = ReportJob()
    job.start()
    state = ended(job)
    assert state["state"] == "failed"
    assert "no report" in str(state["reason"])
    monkeypatch.setattr(report_job, "COMMAND", (sys.executable, "-c", WRITES))
    job.start()
    assert ended(job)["state"] == "done"
    job.close()


def test_one_that_takes_too_long_and_one_of_a_server_that_ends_are_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        report_job, "COMMAND", (sys.executable, "-c", "import time; time.sleep(99)")
    )
    job = ReportJob()
    job.start()
    process = job._process
    assert process is not None
    job.close()
    assert process.poll() is not None
    monkeypatch.setattr(report_job, "PATIENCE", 0.0)
    late = ReportJob()
    late.start()
    assert ended(late)["state"] == "failed"
    late.close()


def test_the_page_computes_the_report_and_shows_it(browser: Browser, own_address: str) -> None:
    assert fetched(own_address, "/report/")[0] == 404
    origin = {"origin": "http://elsewhere.example"}
    assert fetched(own_address, "/api/report", b"", origin)[0] == 403
    opened = browser.new_page()
    opened.goto(f"http://{own_address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    opened.locator("[data-view=paper]").click()
    paper = opened.locator("section[aria-label=Paper]")
    expect(paper).to_contain_text("Journal of Sound and Vibration 331 (2012)")
    expect(paper.locator("[data-figure=fig6]")).to_be_visible()
    paper.get_by_role("button", name="Compute it now").click()
    frame = opened.frame_locator("iframe")
    expect(frame.locator("p")).to_have_text("the report", timeout=WAIT)

    status, headers, _ = fetched(own_address, "/report/")
    assert status == 200
    assert "sha256-" in headers["content-security-policy"]
    opened.close()


def test_the_command_is_that_of_the_package() -> None:
    assert Path(report_job.COMMAND[0]).name.startswith("python")
    assert report_job.COMMAND[1:] == ("-m", "percuss", "paper", "--out")
