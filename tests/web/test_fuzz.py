"""Mutants of what the page sends: each gets an answer or a sentence, and none breaks the server."""

from __future__ import annotations

import asyncio
import contextlib
import copy
import json
import logging
import math
import random
import time
from typing import Any

import pytest
import websockets
from tests.loops import run
from tests.web.frames import read_frame

from percuss.web.presets import presets
from percuss.web.session import FAILED

# Where the library warns that motions have no answer, the page's answer says so itself.
pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

# Nothing may be silent for so long [s], on a machine that does much else; what goes on longer than
# the second time is cancelled, and a picture longer than the third is not waited for.
SILENCE, ENOUGH, PICTURE = 60.0, 1.0, 10.0
# Characters that one message may have, at the most.
LONGEST = 2**20
OPTIONS: dict[str, dict[str, Any]] = {
    "explore": {"points": 200, "window": [1.0, 2.0]},
    "thumb": {"points": 100},
    "beside": {"points": 100},
    "facts": {},
    "certify": {"digits": 12},
    "saddles": {},
    "diagram": {"path": "forcing.omega", "low": 2.5, "high": 2.9, "values": 8, "points": 4},
    "response": {
        "path": "forcing.omega", "low": 2.5, "high": 2.6, "max_impacts": 1, "max_periods": 1,
    },
    "basins": {"x_low": -1, "x_high": 0.1, "v_low": -1, "v_high": 1, "starts": 16},
}  # fmt: skip
# Those that take a moment come more often.
KINDS = ["explore"] * 6 + ["thumb"] * 2 + ["diagram"] * 3 + [*OPTIONS]
FILES = ("png", "svg", "csv", "nc", "toml", "py", "exe", "")
VALUES: list[Any] = [
    None, True, False, 0, -0.0, 1, -1, 0.5, 3, 1e-12, 1e-300, 5e-324, 1e12, 1e308, -1e308, 2**53,
    2**63, 2**64, 10**400, math.nan, math.inf, -math.inf, "", " ", "0", "-1", "1/3", "1/0", "0/0",
    "pi", "-pi/2", "nan", "inf", "1e999", "1e-999", "1e12", "1e99999999", "9" * 5000, "x" * 5000,
    "1/" + "7" * 300, "2.8 ", "\x00", "\ud800", "ω", "__class__", "../..", "stops", [], [0], [[]],
    {}, {"": 0}, {"type": "wall"}, [{}] * 20, "forcing.omega", "oscillator.stops.0.at",
    "oscillator.stops.99.at", "start.x0", "run.periods", "below", "above", "soft", "cancel", "job",
]  # fmt: skip
KEYS = [
    "id", "kind", "queue", "study", "path", "low", "high", "values", "points", "starts", "table",
    "digits", "window", "manifolds", "x_low", "v_high", "oscillator", "forcing", "start", "run",
    "stiffness", "damping", "stops", "type", "at", "side", "restitution", "harmonics", "amplitude",
    "omega", "phase", "constant", "period", "x0", "v0", "t0", "t_end", "periods", "max_impacts",
    "certify", "save", "__proto__", "", "ω",
]  # fmt: skip


def request(chance: random.Random) -> dict[str, Any]:
    """Return a valid request."""
    kind = chance.choice(KINDS)
    study = copy.deepcopy(chance.choice(presets()).tables)
    if "periods" in study["run"]:
        study["run"]["periods"] = chance.choice([1, 3, 10])
    return {"id": 7, "kind": kind, "study": study, **OPTIONS[kind]}


def places(value: Any) -> list[tuple[Any, Any]]:
    """Return all places in a nested value, as containers and keys."""
    here = []
    rows = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in list(rows):
        here.append((value, key))
        if isinstance(part, dict | list):
            here += places(part)
    return here


def mutated(whole: dict[str, Any], chance: random.Random) -> str | bytes:
    """Return a message with one to four mistakes."""
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        container, key = chance.choice(places(whole) or [(whole, "id")])
        kind = chance.randrange(7)
        if kind < 3:
            container[key] = copy.deepcopy(chance.choice(VALUES))
        elif kind == 3:
            del container[key]
        elif kind == 4 and isinstance(container, dict):
            container[chance.choice(KEYS)] = container.pop(key)
        elif kind == 5 and isinstance(container, dict):
            container[chance.choice(KEYS)] = copy.deepcopy(chance.choice(VALUES))
        elif isinstance(container, list):
            container.extend(copy.deepcopy(container[:1]) * chance.choice([1, 30, 200]))
        else:
            container[key] = [copy.deepcopy(container[key])]
    text = json.dumps(whole)
    way = chance.randrange(12)
    if way == 0:
        at = chance.randrange(len(text))
        text = text[:at] + chance.choice(['"', "{", "[", "}", "\\", "\x00", "é", "1e5"]) + text[at:]
    elif way == 1:
        text = text[: chance.randrange(len(text))]
    elif way == 2:
        depth = chance.choice([10, 1000, 30_000])
        text = chance.choice(
            ["[" * depth, '{"id":' * depth, f'{{"study": {"[" * depth}{"]" * depth}}}']
        )
    elif way == 3:
        return bytes(chance.randrange(256) for _ in range(chance.choice([0, 1, 7, 300, 70_000])))
    return text


def wordless(header: dict[str, Any]) -> bool:
    """Return whether a refusal lacks a sentence, or hides a fault of the program."""
    reasons = [fault.get("reason", "") for fault in header["faults"]]
    return not reasons or any(not reason.strip() or reason == FAILED for reason in reasons)


def is_cancel(message: str | bytes) -> bool:
    try:
        return bool(json.loads(message).get("kind") == "cancel")
    except (ValueError, AttributeError, RecursionError):
        return False


async def messages(address: str, seed: int, seconds: float, count: int) -> list[str]:
    """Send mutants over one socket, one after another; return what is wrong with the answers."""
    chance = random.Random(seed)
    wrong = []
    until = time.monotonic() + seconds
    url = f"ws://{address}/api/socket"
    for n in range(count):
        # A new socket now and then: answers to what was cancelled are left behind with the old.
        if n % 20 == 0:
            socket = await websockets.connect(url, max_size=None, compression=None)
        message = mutated(request(chance), chance)
        # What is too long for a message is refused by closing the socket (code 1009).
        too_long = len(message) > LONGEST
        await socket.send(message)
        began = time.monotonic()
        while not is_cancel(message):
            try:
                data = await asyncio.wait_for(socket.recv(), SILENCE)
            except websockets.ConnectionClosedError as error:
                if not (too_long and error.rcvd is not None and error.rcvd.code == 1009):
                    wrong.append(f"seed {seed}, mutant {n}: {error}: {message!r:.2000}")
                socket = await websockets.connect(url, max_size=None, compression=None)
                break
            except TimeoutError:
                wrong.append(f"seed {seed}, mutant {n}: silent: {message!r:.2000}")
                await socket.close()
                socket = await websockets.connect(url, max_size=None, compression=None)
                break
            assert isinstance(data, bytes)
            header, _ = read_frame(data)
            if header["kind"] == "fault" and wordless(header):
                wrong.append(f"seed {seed}, mutant {n}: {header['faults']}: {message!r:.2000}")
            is_last = header["kind"] == "fault" or header.get("done", True) is not False
            if header["kind"] != "progress" and is_last:
                break
            if time.monotonic() - began > ENOUGH:
                await socket.close()
                socket = await websockets.connect(url, max_size=None, compression=None)
                break
        if time.monotonic() > until:
            break
        if n % 20 == 19:
            await socket.close()
    await socket.close()
    return wrong


async def files(address: str, seed: int, seconds: float, count: int) -> list[str]:
    """Ask for files with mutants; return what is wrong with the answers."""
    chance = random.Random(seed)
    wrong = []
    host, port = address.split(":")
    until = time.monotonic() + seconds
    for n in range(count):
        asked = request(chance)
        asked["kind"] = chance.choice(["motion", asked["kind"]])
        body = mutated(asked, chance)
        data = body if isinstance(body, bytes) else body.encode("utf-8", "surrogatepass")
        name = chance.choice(FILES)
        reader, writer = await asyncio.open_connection(host, int(port))
        head = f"POST /api/file/{name} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n"
        writer.write(f"{head}Content-Length: {len(data)}\r\n\r\n".encode() + data)
        try:
            answer = await asyncio.wait_for(reader.read(), PICTURE)
        except TimeoutError:
            # A picture may take a minute; what has gone is not made to its end.
            answer = b"HTTP/1.1 200 "
        except ConnectionError:
            # Too long to be taken, and closed while it came.
            answer = b"HTTP/1.1 200 " if len(data) > 65_536 else b""
        writer.close()
        with contextlib.suppress(ConnectionError):
            await writer.wait_closed()
        status = answer.split(b" ", 2)[1:2]
        said = answer.partition(b"\r\n\r\n")[2]
        if status not in ([b"200"], [b"404"], [b"413"], [b"422"]):
            wrong.append(f"seed {seed}, file {n}: {answer!r:.300}: {name} {body!r:.2000}")
        elif status != [b"200"]:
            fault = json.loads(said)["fault"]
            if not fault.strip() or fault == FAILED:
                wrong.append(f"seed {seed}, file {n}: {fault}: {name} {body!r:.2000}")
        if time.monotonic() > until:
            break
    return wrong


async def warm(address: str) -> None:
    """Have each kind of request answered once: compiling must not count as silence of a mutant.

    With the system whose chart takes the least time.
    """
    quick = next(preset for preset in presets() if preset.name == "coco")
    async with websockets.connect(f"ws://{address}/api/socket", max_size=None) as socket:
        for kind, more in OPTIONS.items():
            study = copy.deepcopy(quick.tables)
            await socket.send(json.dumps({"id": 7, "kind": kind, "study": study, **more}))
            header: dict[str, Any] = {"kind": "progress"}
            while header["kind"] == "progress" or header.get("done", True) is False:
                data = await socket.recv()
                assert isinstance(data, bytes)
                header, _ = read_frame(data)


def check(caplog: pytest.LogCaptureFixture, address: str, *works: Any) -> None:
    async def all_of_them() -> list[str]:
        await warm(address)
        return [row for rows in await asyncio.gather(*works) for row in rows]

    with caplog.at_level(logging.WARNING):
        wrong = run(all_of_them(), 3600.0)
    assert wrong == []
    assert [it.getMessage() for it in caplog.records if it.exc_info] == []


def test_mutants_of_messages_and_files_are_answered_or_refused_in_words(
    address: str, caplog: pytest.LogCaptureFixture
) -> None:
    works = (messages(address, 1, 2.0, 100), files(address, 2, 2.0, 30))
    check(caplog, address, *works)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(10))
def test_ten_thousand_mutants_are_answered_or_refused_in_words(
    address: str, caplog: pytest.LogCaptureFixture, seed: int
) -> None:
    works = (
        messages(address, 100 + seed, math.inf, 800),
        files(address, 200 + seed, math.inf, 200),
    )
    check(caplog, address, *works)
