"""The server: static files, files of a motion, and a socket for everything that moves."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import logging
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from percuss.errors import PercussError
from percuss.web.asked import ASKED
from percuss.web.downloads import FORMATS, QUICK, File, file_of
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.front import facts_of_page
from percuss.web.gate import Gate
from percuss.web.handle import Handle
from percuss.web.jobs import answer_job
from percuss.web.presets import presets
from percuss.web.question import BadQuestion, PageQuestion, read_question
from percuss.web.report_job import ReportJob
from percuss.web.session import FAILED, Pools, Session
from percuss.web.turns import Turn

__all__ = ["create_app"]

log = logging.getLogger("percuss.web")

# Open pages at once; a frame that a client does not take in this time ends its connection [s].
MOST_CLIENTS = 512
PATIENCE = 30.0
# Files that one machine may wait for at once.
MOST_FILES = 8
# The page brings everything itself, and runs no text as code.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
    "frame-src 'self'"
)
# The report holds its pictures and its style in itself; its scripts are named by their hashes.
REPORT_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'self'; script-src {scripts}"
)


def create_app(
    *, report: Path | None = None, hosts: tuple[str, ...] = ("*",), token: str | None = None
) -> Starlette:
    """Return the workbench as an ASGI application.

    Parameters
    ----------
    report
        Folder of a report that `percuss paper` wrote, to be shown under "Paper"; or None.
    hosts
        Names under which it answers.
    token
        What an address or a cookie has to hold; None where anybody may ask.

    Returns
    -------
    Starlette
        The application.
    """
    routes: list[BaseRoute] = [
        Route("/", _index),
        Route("/api/presets", _presets),
        Route("/api/report", _report_job, methods=["GET", "POST"]),
        Route("/api/file/{extension}", _file, methods=["POST"]),
        WebSocketRoute("/api/socket", _socket),
        Mount("/static", StaticFiles(packages=[("percuss.web", "static")])),
    ]
    job = ReportJob(report)
    files = StaticFiles(directory=job.folder, html=True, check_dir=False)

    async def report_files(scope: Scope, receive: Receive, send: Send) -> None:
        answer = files if job.is_there else JSONResponse({"fault": "no report"}, status_code=404)
        await answer(scope, receive, send)

    routes.append(Mount("/report", report_files))
    app = Starlette(
        routes=routes,
        middleware=[
            Middleware(SafeHeaders, scripts=job.scripts),
            Middleware(Gate, hosts=hosts, token=token),
        ],
        exception_handlers={HTTPException: _refused},
        lifespan=_lifespan,
    )
    app.state.report = job
    app.state.n_clients = 0
    app.state.n_files = Counter()
    return app


@asynccontextmanager
async def _lifespan(app: Starlette) -> AsyncIterator[None]:
    pools = app.state.pools = Pools.made()
    pools.short.submit(_warm_up)
    pools.long.submit(_warm_up_diagrams)
    try:
        yield
    finally:
        pools.close()
        app.state.report.close()


def _warm_up(_turn: Turn) -> None:
    """Compile or load the engine before the first page asks."""
    first = presets()[0].tables
    answer_explore(PageQuestion(0, "explore", first, {}))
    answer_facts(PageQuestion(0, "facts", first, {}))


def _warm_up_diagrams(_turn: Turn) -> None:
    """Do the same for many motions at once."""
    asked = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "values": 8, "points": 4}
    for _ in answer_job(PageQuestion(0, "diagram", presets()[0].tables, asked), Handle()):
        pass


class SafeHeaders:
    """Adds the headers that keep a browser from running or sending what is not the page's.

    Parameters
    ----------
    app
        What answers.
    scripts
        Texts of the scripts that the report may run.
    """

    def __init__(self, app: ASGIApp, scripts: Sequence[str] = ()) -> None:
        self.app = app
        self.scripts = scripts

    @property
    def report_policy(self) -> str:
        """The policy for the report; it may have been written just now."""
        hashes = [base64.b64encode(hashlib.sha256(it.encode()).digest()) for it in self.scripts]
        named = " ".join(f"'sha256-{it.decode()}'" for it in hashes)
        return REPORT_POLICY.format(scripts=named or "'none'")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, with the headers."""
        is_report = scope.get("path", "").startswith("/report")
        policy = self.report_policy if is_report else POLICY
        headers = {
            b"content-security-policy": policy.encode(),
            b"x-content-type-options": b"nosniff",
            b"referrer-policy": b"no-referrer",
            b"cache-control": b"no-cache",
        }

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), *headers.items()]
            await send(message)

        await self.app(scope, receive, with_headers)


async def _refused(_request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return JSONResponse({"fault": str(error.detail)}, status_code=error.status_code)


async def _index(_request: Request) -> Response:
    return FileResponse(str(resources.files("percuss.web") / "static" / "index.html"))


async def _presets(request: Request) -> Response:
    job: ReportJob = request.app.state.report
    return JSONResponse(facts_of_page(job.folder if job.is_there else None))


async def _report_job(request: Request) -> Response:
    """Tell how far the report is; begin to compute it where a page of this server asks for it."""
    job: ReportJob = request.app.state.report
    if request.method == "POST":
        job.start()
    return JSONResponse(job.state())


async def _file(request: Request) -> Response:
    extension = request.path_params["extension"]
    if extension not in FORMATS:
        raise HTTPException(404, f"{extension[:20]} is no file to be had")
    asker = request.client.host if request.client else ""
    waiting: Counter[str] = request.app.state.n_files
    if waiting[asker] >= MOST_FILES:
        raise HTTPException(429, f"{MOST_FILES} files are being made for you; wait for one")
    waiting[asker] += 1
    try:
        question = read_question(await request.body(), ("motion", *ASKED))
        made = await _made(request, question, extension)
    except (BadQuestion, PercussError) as error:
        raise HTTPException(422, str(error)) from error
    except Exception as error:
        # Told without its details, and reported.
        _report(error)
        raise HTTPException(422, FAILED) from error
    except asyncio.CancelledError as error:
        raise HTTPException(503, "the server ends") from error
    finally:
        waiting[asker] -= 1
        if waiting[asker] <= 0:
            del waiting[asker]
    headers = {"content-disposition": f'attachment; filename="{made.name}"'}
    return Response(made.data, media_type=made.media_type, headers=headers)


async def _made(request: Request, question: PageQuestion, extension: str) -> File:
    """Make a file in its turn, for as long as whoever asked is there."""
    pools: Pools = request.app.state.pools
    handle = Handle()

    def make(turn: Turn) -> File:
        with handle.during(turn):
            return file_of(question, extension, handle)

    turns = pools.facts if extension in QUICK else pools.long
    work = asyncio.wrap_future(turns.submit(make))
    gone = asyncio.ensure_future(request.receive())
    both: list[asyncio.Future[Any]] = [work, gone]
    try:
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        if not work.done():
            raise BadQuestion("whoever asked for the file has gone")
        return work.result()
    finally:
        handle.is_stopped = True
        gone.cancel()
        work.cancel()


async def _socket(socket: WebSocket) -> None:
    app = socket.app
    if app.state.n_clients >= MOST_CLIENTS:
        await socket.close(1008)
        return
    app.state.n_clients += 1
    session = Session(_sender(socket), app.state.pools, _report)
    try:
        await socket.accept()
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                break
            await session.receive(message.get("text") or message.get("bytes") or "")
    except (WebSocketDisconnect, ConnectionError, TimeoutError):
        pass
    finally:
        await session.close()
        app.state.n_clients -= 1


def _sender(socket: WebSocket) -> Callable[[bytes], Awaitable[None]]:
    one_at_a_time = asyncio.Lock()

    async def send(data: bytes) -> None:
        async with one_at_a_time:
            await asyncio.wait_for(socket.send_bytes(data), PATIENCE)

    return send


def _report(error: BaseException) -> None:
    log.error("an answer failed", exc_info=error)
