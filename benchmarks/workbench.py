"""The page: from a slider to its pictures in a browser, a big diagram, and two hundred clients.

Needs Chromium and playwright, and the extra `web`. All cores are used: the server, the browser and
the load share them.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import websockets
from tests.web.frames import motion_tables

from benchmarks.report import Report
from benchmarks.timing import REPEATS

CLIENTS, MOVES_A_SECOND, SECONDS = 200, 5, 60
# Of the clients, those whose motions take as long as they may, one after another.
HOSTILE, HOSTILE_SECONDS = 10, 20
SLIDER_MOVES = 120
# The first of these that is there.
BROWSERS = ("chromium", "chromium-browser", "chromium-headless-shell")
STUDY = motion_tables(periods=60)


def run(report: Report) -> None:
    """Time the page in a browser, then under load."""
    cores = os.cpu_count() or 1
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, range(cores))
    report.section(
        "The workbench",
        "Server, browser and load share the cores. A slider moves, and all four plots are redrawn; "
        f"then {CLIENTS} clients move {MOVES_A_SECOND} sliders a second for {SECONDS} s.",
    )
    server = _Server()
    try:
        _in_browser(report, server.address)
        _under_load(report, server)
    finally:
        server.end()


class _Server:
    """`percuss serve` in a process of its own."""

    def __init__(self) -> None:
        command = [sys.executable, "-m", "percuss", "serve", "--port", "0", "--no-open"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        self.address = line.split("http://")[1].split("/")[0]

    def memory(self) -> float:
        """Return the resident memory [MB]."""
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        line = next(row for row in status.splitlines() if row.startswith("VmRSS"))
        return int(line.split()[1]) / 1024.0

    def end(self) -> None:
        self.process.terminate()
        self.process.wait(20)


def _in_browser(report: Report, address: str) -> None:
    from playwright.sync_api import sync_playwright

    chromium = next(filter(None, map(shutil.which, BROWSERS)), None)
    if chromium is None:
        report.line("slider to four plots", "no chromium here")
        return
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium,
            args=["--no-sandbox", "--disable-gpu", "--disable-background-networking"],
        )
        page = browser.new_page(viewport={"width": 1366, "height": 850})
        page.goto(f"http://{address}/")
        page.wait_for_selector(".explore[data-drawn]", timeout=120_000)
        page.wait_for_timeout(2000)
        began = time.perf_counter()
        page.reload()
        page.wait_for_selector(".explore[data-drawn]")
        report.below(
            "page usable (loaded, first motion drawn)", time.perf_counter() - began, 1.0, "s"
        )
        times = page.evaluate(_MOVE_SLIDER, SLIDER_MOVES)
        assert len(times) == SLIDER_MOVES
        drawn, painted = (sorted(column) for column in zip(*times, strict=True))
        for what, found, (middle, most) in (
            ("four plots", drawn, (16.0, 33.0)),
            ("a frame of the browser with them", painted, (40.0, 80.0)),
        ):
            report.below(f"slider to {what}, median", statistics.median(found), middle, "ms")
            report.below(f"slider to {what}, 95 %", found[int(0.95 * len(found))], most, "ms")
        for values, points, most in ((256, 64, 60.0), (1600, 128, 500.0)):
            found = statistics.median(_diagrams(page, values, points))
            report.below(f"diagram of {values} x {points}", found, most, "ms")
        for label in ("the first", "again"):
            seconds, first, points = _diagram(page)
            assert points == 1_000_000, points
            report.below(f"diagram of 1e6 points, {label}: complete", seconds, 3.0, "s")
            report.line("  its first level", f"{first:.2f} s")
        basins, saddles = _basins(page)
        report.below("basins, 256 x 256", basins, 2.0, "s")
        report.line("  saddles and their manifolds after that", f"{saddles:.2f} s")
        report.line("32 impacts certified to 12 digits", f"{_certified(page):.2f} s")
        browser.close()


# Moves the slider, waits until the four plots are drawn and until the browser has painted them,
# which it does once a frame, and so on.
_MOVE_SLIDER = """async (moves) => {
  const box = document.querySelector('#p-forcing-harmonics-0-omega');
  const slider = box.parentElement.querySelector('input[type=range]');
  const view = document.querySelector('.explore');
  const times = [];
  for (let k = 0; k < moves; k += 1) {
    slider.value = String(400 + k);
    const began = performance.now();
    const drawn = new Promise((resolve) => view.addEventListener('drawn', resolve, { once: true }));
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    await drawn;
    const all = performance.now() - began;
    await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
    times.push([all, performance.now() - began]);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
  return times;
}"""


# Computes the diagram; the view says when it is done.
_COMPUTE = """async () => {
  const view = document.querySelector('section[aria-label=Diagram]');
  const status = view.querySelector('.status');
  const button = [...view.querySelectorAll('button')].find((it) => it.textContent === 'Compute');
  status.textContent = '';
  const began = performance.now();
  button.click();
  await new Promise((resolve) => {
    new MutationObserver(() => status.textContent.startsWith('done') && resolve())
      .observe(status, { childList: true, characterData: true, subtree: true });
  });
  return performance.now() - began;
}"""


def _diagrams(page: Any, values: int, points: int) -> list[float]:
    """Return how long diagrams of so many values and points take, without the first [ms]."""
    _ask_for(page, values, points)
    return [page.evaluate(_COMPUTE) for _ in range(REPEATS + 1)][1:]


def _ask_for(page: Any, values: int, points: int) -> None:
    page.click("[data-view=diagram]")
    view = page.locator("section[aria-label=Diagram]")
    for label, value in (("values", values), ("points at each", points)):
        field = view.locator("label", has_text=label).locator("input")
        field.fill(str(value))
        field.blur()


def _diagram(page: Any) -> tuple[float, float, int]:
    """Return seconds to the whole diagram and to its first level, and its points."""
    _ask_for(page, 2000, 500)
    view = page.locator("section[aria-label=Diagram]")
    began = time.perf_counter()
    page.evaluate("document.querySelector('section[aria-label=Diagram] .legend').textContent = ''")
    view.get_by_role("button", name="Compute").click()
    hint = "document.querySelector('section[aria-label=Diagram] .legend').textContent"
    page.wait_for_function(f"() => {hint}.includes('points')", timeout=60_000)
    first = time.perf_counter() - began
    status = "document.querySelector('section[aria-label=Diagram] .status').textContent"
    page.wait_for_function(f"() => {status}.startsWith('done')", timeout=60_000)
    seconds = time.perf_counter() - began
    points = int(page.evaluate(hint).split(" ")[0].replace(",", ""))
    return seconds, first, points


def _basins(page: Any) -> tuple[float, float]:
    """Return seconds to the whole basins, and from there to the last manifold."""
    page.click("[data-view=basins]")
    view = page.locator("section[aria-label=Basins]")
    began = time.perf_counter()
    view.get_by_role("button", name="Compute", exact=True).click()
    status = "document.querySelector('section[aria-label=Basins] .status').textContent"
    page.wait_for_function(f"() => {status}.startsWith('done')", timeout=120_000)
    basins = time.perf_counter()
    legend = "document.querySelector('section[aria-label=Basins] .legend')"
    found = f"{legend}.querySelector('[data-saddles]')"
    still = f"{legend}.textContent.includes('looking')"
    page.wait_for_function(f"() => {found} && !{still}", timeout=60_000)
    return basins - began, time.perf_counter() - basins


def _certified(page: Any) -> float:
    """Return seconds to a proof of the first motion."""
    page.click("[data-view=gallery]")
    page.click("[data-name=first_impacts]")
    page.get_by_role("button", name="certify …").click()
    strip = page.locator("section[aria-label='Certify this run']")
    began = time.perf_counter()
    strip.get_by_role("button", name="Certify", exact=True).click()
    strip.get_by_text("32 impacts up to").wait_for(timeout=60_000)
    return time.perf_counter() - began


def _under_load(report: Report, server: _Server) -> None:
    asyncio.run(_load(server.address, 20, 5.0))
    before = server.memory()
    delays, asked = asyncio.run(_load(server.address, CLIENTS, SECONDS))
    after = server.memory()
    delays.sort()
    report.line("moves, and answers", f"{asked:,}, {len(delays):,}")
    report.line("answer to the newest move, median", f"{statistics.median(delays):.3f} s")
    report.below("the same, 95 %", delays[int(0.95 * len(delays))], 1.0, "s")
    report.line("between two answers to a client", f"{CLIENTS * SECONDS / len(delays):.2f} s")
    report.line("memory of the server before, after", f"{before:.0f}, {after:.0f} MB")
    # 200 sockets and their frames; not what 60,000 moves would hold if they were kept.
    assert after < before + 150.0, (before, after)
    hostile, _ = asyncio.run(_load(server.address, CLIENTS, HOSTILE_SECONDS, HOSTILE))
    hostile.sort()
    label = f"with {HOSTILE} of {CLIENTS} clients hostile: the others' 95 %"
    report.below(label, hostile[int(0.95 * len(hostile))], 1.0, "s")


async def _load(
    address: str, clients: int, seconds: float, n_hostile: int = 0
) -> tuple[list[float], int]:
    """Let clients move sliders; return the delays of the answers and how many moves there were.

    Of the clients, some are hostile: each asks for an endless motion after another.
    """
    delays: list[float] = []
    counts = [0]

    async def hostile() -> None:
        study = json.loads(json.dumps(STUDY))
        study["forcing"]["harmonics"][0]["omega"] = "1e-12"
        url = f"ws://{address}/api/socket"
        async with websockets.connect(url, max_size=None, compression=None) as socket:
            end = time.perf_counter() + seconds
            while time.perf_counter() < end:
                await socket.send(json.dumps({"id": 1, "kind": "explore", "study": study}))
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(socket.recv(), 2.0)

    async def client(k: int) -> None:
        study = json.loads(json.dumps(STUDY))
        sent: dict[int, float] = {}
        answered = [0]
        url = f"ws://{address}/api/socket"
        async with websockets.connect(url, max_size=None, compression=None) as socket:

            async def listen() -> None:
                async for data in socket:
                    now = time.perf_counter()
                    assert isinstance(data, bytes)
                    size = int.from_bytes(data[:4], "little")
                    header = json.loads(data[4 : 4 + size])
                    if header["kind"] == "progress":
                        # Told where an answer takes long, as beside other clients.
                        continue
                    assert header["kind"] == "explore", header
                    delays.append(now - sent[header["id"]])
                    answered[0] = header["id"]

            listening = asyncio.create_task(listen())
            await asyncio.sleep((k % 97) / 97.0 / MOVES_A_SECOND)
            end = time.perf_counter() + seconds
            number = 0
            while time.perf_counter() < end:
                number += 1
                study["forcing"]["harmonics"][0]["omega"] = (
                    f"{2.0 + 0.001 * ((7 * number + k) % 900):.3f}"
                )
                sent[number] = time.perf_counter()
                text = {"id": number, "kind": "explore", "study": study, "points": 4000}
                await socket.send(json.dumps(text))
                counts[0] += 1
                await asyncio.sleep(1.0 / MOVES_A_SECOND)
            await asyncio.sleep(2.0)
            # The last move is answered, whatever was left out before.
            assert answered[0] == number
            listening.cancel()

    honest = clients - n_hostile
    await asyncio.gather(
        *(client(k) for k in range(honest)), *(hostile() for _ in range(n_hostile))
    )
    return delays, counts[0]
