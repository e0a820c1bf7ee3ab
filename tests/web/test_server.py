"""The server: who may ask what, and how much."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import socket
import tomllib
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import pytest
import websockets
from tests.loops import run
from tests.web.frames import read_frame

from percuss.web.app import SafeHeaders
from percuss.web.page_data import claims_of, scripts_of
from percuss.web.serve import _listening


def fetched(
    address: str, path: str, data: bytes | None = None, headers: dict[str, str] | None = None
) -> tuple[int, dict[str, str], bytes]:
    request = urllib.request.Request(f"http://{address}{path}", data, headers or {})
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.status, dict(answer.headers), answer.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


def file_of(address: str, extension: str, study: Any) -> tuple[int, dict[str, str], bytes]:
    body = json.dumps({"kind": "motion", "study": study}).encode()
    return fetched(address, f"/api/file/{extension}", body)


def test_the_page_runs_no_text_as_code(address: str) -> None:
    status, headers, body = fetched(address, "/")
    policy = headers["content-security-policy"]

    assert status == 200
    assert "script-src 'self'" in policy
    # WebAssembly runs no text.
    assert "unsafe" not in policy.replace("'wasm-unsafe-eval'", "")
    # No script and no style stands in the page itself, nor an address of another machine.
    assert b"<style" not in body
    assert b"<script>" not in body
    assert b"http" not in body.replace(b"http-equiv", b"")


@pytest.mark.parametrize("extension", ["png", "svg", "csv", "nc", "toml", "py"])
def test_files_come_out(address: str, study: dict[str, Any], extension: str) -> None:
    status, headers, body = file_of(address, extension, study)

    assert status == 200
    assert extension in headers["content-disposition"]
    begins = {"png": b"\x89PNG", "svg": b"<?xml", "nc": b"\x89HDF", "py": b"import percuss"}
    assert body.startswith(begins.get(extension, b""))
    if extension == "toml":
        assert tomllib.loads(body.decode())["oscillator"]["damping"] == "0.05"


@pytest.mark.parametrize(
    ("path", "data", "status"),
    [
        ("/api/file/exe", b"{}", 404),
        ("/api/file/..%2f..%2fpyproject.toml", b"{}", 404),
        ("/static/../app.py", None, 404),
        ("/static/%2e%2e/app.py", None, 404),
        ("/nothing", None, 404),
        ("/api/file/py", b"no json", 422),
        ("/api/file/py", b"[" * 60_000, 422),
        ("/api/file/py", b'{"kind": "motion", "study": {}}', 422),
        ("/api/file/py", b" " * 100_000, 422),
        ("/api/file/py", None, 405),
    ],
)
def test_bad_requests_are_refused_not_broken(
    address: str, path: str, data: bytes | None, status: int
) -> None:
    assert fetched(address, path, data)[0] == status


def talk(address: str, texts: list[str], **options: Any) -> list[dict[str, Any]]:
    """Return the headers of the first answer to each message."""

    async def spoken() -> list[dict[str, Any]]:
        async with websockets.connect(f"ws://{address}/api/socket", max_size=None, **options) as it:
            headers = []
            for text in texts:
                await it.send(text)
                data = await asyncio.wait_for(it.recv(), 60)
                assert isinstance(data, bytes)
                headers.append(read_frame(data)[0])
            return headers

    return run(spoken())


def test_socket_answers(address: str, study: dict[str, Any]) -> None:
    (header,) = talk(address, [json.dumps({"id": 1, "kind": "explore", "study": study})])

    assert header["kind"] == "explore"


def test_socket_survives_nonsense(address: str, study: dict[str, Any]) -> None:
    texts = ["", "{", "[]", '{"kind": 3}', '{"kind": "explore", "id": "x"}', " " * 70_000]
    headers = talk(address, [*texts, json.dumps({"id": 9, "kind": "explore", "study": study})])

    assert [header["kind"] for header in headers] == ["fault"] * len(texts) + ["explore"]


def test_pages_of_others_get_no_socket(address: str) -> None:
    with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
        talk(address, ["{}"], origin=websockets.Origin("http://elsewhere.example"))


def test_whoever_hears_the_address_may_come_at_once() -> None:
    with _listening("127.0.0.1", 0) as listening:
        socket.create_connection(listening.getsockname(), timeout=5).close()


def test_statements_of_a_report_are_told_or_none(tmp_path: Path) -> None:
    assert claims_of(tmp_path) == []
    row = {"id": "eq1", "reference": "(1)", "claim": "x", "verdict": "holds", "grade": "certified"}
    written = json.dumps({"records": [{**row, "evidence": {}}]})
    (tmp_path / "claims.json").write_text(written, encoding="utf-8")
    assert claims_of(tmp_path) == [row]
    for broken in ("[", "3", "[]", '{"records": [{"id": 1}]}', "null"):
        (tmp_path / "claims.json").write_text(broken, encoding="utf-8")
        assert claims_of(tmp_path) == []


def test_only_the_scripts_that_stand_in_the_report_run_in_it(tmp_path: Path) -> None:
    page = "<p>text</p><script>one()</script><script>\ntwo();\n</script>"
    (tmp_path / "index.html").write_text(page, encoding="utf-8")
    assert scripts_of(tmp_path) == ["one()", "\ntwo();\n"]

    async def nothing(_scope: object, _receive: object, _send: object) -> None:
        pass

    policy = SafeHeaders(nothing, scripts_of(tmp_path)).report_policy
    digest = base64.b64encode(hashlib.sha256(b"one()").digest()).decode()
    assert f"'sha256-{digest}'" in policy
    assert policy.count("sha256-") == 2
    assert "script-src 'none'" in SafeHeaders(nothing).report_policy
