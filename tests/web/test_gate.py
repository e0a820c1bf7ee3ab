"""Who may ask the server what, how much, and for how long."""

from __future__ import annotations

import contextlib
import json
import socket
import time
from collections.abc import Iterator
from typing import Any

import pytest
import websockets
from tests.web.serving import served
from tests.web.test_server import fetched, talk

from percuss.web import connections, gate
from percuss.web.app import create_app
from percuss.web.serve import addresses_of, is_loopback

LOCAL = ("127.0.0.1", "localhost", "[::1]")
TOKEN = "0123456789abcdef"


@pytest.fixture(scope="module")
def guarded() -> Iterator[str]:
    """Address of a server that asks for a token."""
    with served(create_app(token=TOKEN)) as address:
        yield address


@contextlib.contextmanager
def raw(address: str, data: bytes = b"") -> Iterator[socket.socket]:
    host, port = address.split(":")
    with socket.create_connection((host, int(port)), timeout=240) as it:
        it.sendall(data)
        yield it


def answer_of(it: socket.socket) -> bytes:
    """Return all that comes until the server closes."""
    parts = []
    with contextlib.suppress(ConnectionError):
        while part := it.recv(65536):
            parts.append(part)
    return b"".join(parts)


@pytest.mark.parametrize("path", ["/api/file/toml", "/api/file/png", "/api/report"])
@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://["},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_no_post_of_another_page_is_answered(
    address: str, study: dict[str, Any], path: str, headers: dict[str, str]
) -> None:
    body = json.dumps({"kind": "motion", "study": study}).encode()
    status, _, said = fetched(address, path, body, headers)

    assert status == 403
    assert "another server" in json.loads(said)["fault"]


def test_a_post_of_the_page_itself_is_answered(address: str, study: dict[str, Any]) -> None:
    body = json.dumps({"kind": "motion", "study": study}).encode()
    ours = {"Origin": f"http://{address}", "Sec-Fetch-Site": "same-origin"}

    assert fetched(address, "/api/file/toml", body, ours)[0] == 200


def test_sockets_of_other_sites_are_refused_by_their_headers(address: str) -> None:
    with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
        talk(address, ["{}"], additional_headers={"Sec-Fetch-Site": "cross-site"})


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("localhost:80", 200),
        ("127.0.0.1", 200),
        ("[::1]:9", 200),
        ("evil.example", 400),
        ("127.0.0.1.evil.example", 400),
        ("[", 400),
    ],
)
def test_names_of_others_that_lead_here_get_nothing(host: str, status: int) -> None:
    with served(create_app(hosts=LOCAL)) as address:
        assert fetched(address, "/api/presets", None, {"Host": host})[0] == status


def test_a_body_is_counted_as_it_comes_whatever_is_said_of_its_length(address: str) -> None:
    head = (
        b"POST /api/file/py HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\n"
        b"Transfer-Encoding: chunked\r\n\r\n"
    )
    chunk = b"8000\r\n" + b" " * 0x8000 + b"\r\n"
    with raw(address, head) as it:
        n_sent = 0
        with contextlib.suppress(ConnectionError):
            while n_sent < 2000:
                it.sendall(chunk)
                n_sent += 1
        answer = answer_of(it)
    # Some lie in the buffers between; of 65 MB no more than that is taken.
    assert n_sent < 2000
    assert answer == b"" or b" 413 " in answer.splitlines()[0]


def test_a_body_that_is_said_to_be_too_long_is_not_read(address: str) -> None:
    head = b"POST /api/file/py HTTP/1.1\r\nHost: x\r\nContent-Length: 1000001\r\n\r\n"
    with raw(address, head) as it:
        answer = answer_of(it)
    assert b" 413 " in answer.splitlines()[0]
    assert b"a request of 1000001 bytes; 1000000 are the most" in answer


def test_a_body_that_does_not_come_is_not_waited_for(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate, "PATIENCE", 0.3)
    head = b"POST /api/file/py HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\n\r\n"
    with raw(address, head) as it:
        assert b" 408 " in answer_of(it).splitlines()[0]


def test_a_head_that_does_not_come_is_not_waited_for(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "PATIENCE", 0.3)
    began = time.monotonic()
    with raw(address, b"GET / HTTP/1.1\r\nHost: x\r\n") as it:
        assert answer_of(it) == b""
    assert 0.2 < time.monotonic() - began < 10.0


def test_a_head_that_comes_byte_by_byte_is_not_waited_for_longer(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "PATIENCE", 0.5)
    n_sent = 0
    with raw(address, b"GET / HTTP/1.1\r\n") as it, contextlib.suppress(ConnectionError):
        for _ in range(100):
            it.sendall(b"x")
            time.sleep(0.05)
            n_sent += 1
    assert n_sent < 100


def is_closed(it: socket.socket) -> bool:
    it.setblocking(False)
    try:
        return it.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionError:
        return True


def test_of_many_half_open_requests_the_newest_are_held(address: str) -> None:
    count = connections.MOST_HALF_OPEN + 40
    with contextlib.ExitStack() as stack:
        held = [stack.enter_context(raw(address, b"GET / HTTP/1.1\r\n")) for _ in range(count)]
        # Others are answered meanwhile.
        assert fetched(address, "/api/presets")[0] == 200
        end = time.monotonic() + 60.0
        while (n_closed := sum(map(is_closed, held))) < 40:
            assert time.monotonic() < end, n_closed
            time.sleep(0.05)


def test_nothing_is_answered_without_the_token(guarded: str, study: dict[str, Any]) -> None:
    body = json.dumps({"kind": "motion", "study": study}).encode()
    for path, data in (
        ("/", None),
        ("/api/presets", None),
        ("/static/js/main.js", None),
        ("/report/index.html", None),
        ("/api/file/toml", body),
        ("/?token=" + TOKEN[:-1], None),
        ("/?token=%C3%A9", None),
    ):
        assert fetched(guarded, path, data)[0] == 403, path
    with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
        talk(guarded, ["{}"])


def test_the_token_of_the_address_becomes_a_cookie_that_opens_all(
    guarded: str, study: dict[str, Any]
) -> None:
    with raw(
        guarded, f"GET /?token={TOKEN}&a=1 HTTP/1.0\r\nHost: {guarded}\r\n\r\n".encode()
    ) as it:
        head = answer_of(it).decode().lower()
    assert " 303 " in head.splitlines()[0]
    assert "location: /?a=1" in head
    cookie = next(line for line in head.splitlines() if line.startswith("set-cookie: "))
    assert "httponly" in cookie
    assert "samesite=strict" in cookie

    given = {"Cookie": cookie.removeprefix("set-cookie: ").split(";")[0]}
    body = json.dumps({"kind": "motion", "study": study}).encode()
    assert fetched(guarded, "/", None, given)[0] == 200
    assert fetched(guarded, "/api/file/toml", body, given)[0] == 200
    (header,) = talk(
        guarded, [json.dumps({"kind": "explore", "study": study})], additional_headers=given
    )
    assert header["kind"] == "explore"


@pytest.mark.parametrize("path", ["//evil.example", "/%2Fevil.example", "/\\evil.example"])
def test_the_token_leads_to_this_server_alone(guarded: str, path: str) -> None:
    with raw(guarded, f"GET {path}?token={TOKEN} HTTP/1.0\r\nHost: x\r\n\r\n".encode()) as it:
        head = answer_of(it).decode().lower()
    location = [line for line in head.splitlines() if line.startswith("location: ")]
    assert all(line.removeprefix("location: ")[:2] not in ("//", "/\\") for line in location)


def test_a_study_has_a_short_address_that_asks_for_the_token() -> None:
    with served(create_app(link="abc", token=TOKEN)) as address:
        heads = []
        for path, cookie in (("/study", ""), (f"/study?token={TOKEN}", ""), ("/study", TOKEN)):
            name = f"percuss-{address.split(':')[1]}"
            request = f"GET {path} HTTP/1.0\r\nHost: {address}\r\nCookie: {name}={cookie}\r\n\r\n"
            with raw(address, request.encode()) as it:
                heads.append(answer_of(it).decode().lower())
    assert " 403 " in heads[0].splitlines()[0]
    assert "location: /study\r\n" in heads[1]
    assert "location: /#abc\r\n" in heads[2]


def test_the_address_that_is_printed_can_be_opened() -> None:
    assert addresses_of("127.0.0.1", 80, None) == ["http://127.0.0.1:80/"]
    for host in ("0.0.0.0", "::"):
        first, local = addresses_of(host, 80, "x")
        assert "0.0.0.0" not in first
        assert "[::]" not in first
        assert first.endswith(":80/?token=x")
        assert local in ("http://127.0.0.1:80/?token=x", "http://[::1]:80/?token=x")
    assert not is_loopback("0.0.0.0")
    assert is_loopback("127.0.0.2")
