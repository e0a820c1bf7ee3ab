"""Ctrl-C ends the server, whatever is in work."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import websockets
from tests.loops import run

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")

# Two seconds are promised; the rest is for a machine that does much else. What is in work would
# take longer by far [s].
SLOW = 60.0


@contextlib.contextmanager
def serving(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A server in a process of its own, in which Ctrl-C means what it does in a terminal."""
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);"
        "from percuss.cli.app import main; main()"
    )
    command = [sys.executable, "-c", code, "serve", "--port", "0", "--no-open"]
    with (tmp_path / "log").open("w", encoding="utf-8") as log:
        process = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
            env={**os.environ, "TMPDIR": str(tmp_path)},
            start_new_session=True,
        )
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        assert "http://" in line, (tmp_path / "log").read_text("utf-8")
        yield process, line.split("http://")[1].split("/")[0]
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        process.stdout.close()


def post(study: dict[str, Any], extension: str, **request: Any) -> bytes:
    body = json.dumps({"study": study, **request}).encode()
    head = f"POST /api/file/{extension} HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n\r\n"
    return head.encode() + body


def test_ctrl_c_ends_the_server_whatever_is_in_work(tmp_path: Path, study: dict[str, Any]) -> None:
    long = {**study, "oscillator": {**study["oscillator"], "damping": "0.0001"}}
    basins = {"x_low": -1, "x_high": 0.2, "v_low": -1, "v_high": 1, "starts": 1024}
    diagram = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "points": 240, "values": 8192}
    requests = [
        {"id": 1, "kind": "explore", "study": long},
        {"id": 2, "kind": "facts", "study": long},
        {"id": 3, "kind": "diagram", "study": long, **diagram},
        {"id": 4, "kind": "certify", "study": long, "digits": 50},
        {"id": 5, "kind": "saddles", "study": long},
    ]

    async def begin(address: str, process: subprocess.Popen[str]) -> float:
        host, port = address.split(":")
        _, file = await asyncio.open_connection(host, int(port))
        file.write(post(long, "png", kind="basins", **basins))
        _, report = await asyncio.open_connection(host, int(port))
        report.write(b"POST /api/report HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n")
        _, half_open = await asyncio.open_connection(host, int(port))
        half_open.write(b"GET / HTTP/1.1\r\n")
        async with websockets.connect(f"ws://{address}/api/socket", max_size=None) as it:
            for request in requests:
                await it.send(json.dumps(request))
            await it.recv()
            await asyncio.sleep(1.0)
            began = time.monotonic()
            process.send_signal(signal.SIGINT)
            while process.poll() is None:
                await asyncio.sleep(0.02)
            seconds = time.monotonic() - began
        for writer in (file, report, half_open):
            writer.close()
            with contextlib.suppress(ConnectionError):
                await writer.wait_closed()
        return seconds

    with serving(tmp_path) as (process, address):
        seconds = run(begin(address, process))
        assert seconds < SLOW
    log = (tmp_path / "log").read_text("utf-8")
    assert "Traceback" not in log
    assert "interrupted" in log
    # Nothing is left behind.
    assert [it.name for it in tmp_path.iterdir()] == ["log"]


def test_ctrl_c_ends_the_server_while_it_compiles(tmp_path: Path) -> None:
    with serving(tmp_path) as (process, _):
        time.sleep(0.3)
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        process.wait(2 * SLOW)
        assert time.monotonic() - began < SLOW
    assert "Traceback" not in (tmp_path / "log").read_text("utf-8")
