"""The server: static files, files of answers, and a socket for everything else."""

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
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from percuss.errors import PercussError
from percuss.web.downloads import FORMATS, QUICK, File, file_of
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.gate import Gate
from percuss.web.jobs import answer_job
from percuss.web.page_data import page_data
from percuss.web.presets import presets
from percuss.web.report_job import ReportJob
from percuss.web.request import BadRequest, PageRequest, RunningRequest, read_request
from percuss.web.scheduler import Task
from percuss.web.session import FAILED, Schedulers, Session
from percuss.web.view_study import VIEWS

log = logging.getLogger("percuss.web")

# Open pages at once; a client that does not read a frame in this time is disconnected [s].
MOST_CLIENTS = 512
PATIENCE = 30.0
# Files that one machine may request at once.
MOST_FILES = 8
# The page loads everything from this server, and runs no inline script; WebAssembly is no eval.
POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
    "frame-src 'self'"
)
# The report has its pictures and style inline; its inline scripts are allowed by their hashes.
REPORT_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'self'; script-src {scripts}"
)


def create_app(
    *,
    report: Path | None = None,
    link: str = "",
    hosts: tuple[str, ...] = ("*",),
    token: str | None = None,
) -> Starlette:
    """Return the workbench as an ASGI application.

    Parameters
    ----------
    report
        Folder of a report that `percuss paper` wrote, to be shown under "Paper"; or None.
    link
        Fragment of a link that the address ``/study`` leads to.
    hosts
        Names under which the server answers.
    token
        Token that the address or a cookie must hold; None where anybody may ask.

    Returns
    -------
    Starlette
        The application.
    """
    routes: list[BaseRoute] = [
        Route("/", _index),
        Route("/study", lambda _: RedirectResponse(f"/#{link}", 303)),
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
    schedulers = app.state.schedulers = Schedulers.create()
    schedulers.short.submit(_warm_up)
    schedulers.long.submit(_warm_up_diagrams)
    try:
        yield
    finally:
        schedulers.close()
        app.state.report.close()


def _warm_up(_task: Task) -> None:
    """Compile or load the kernels of one motion before the first page asks."""
    first = presets()[0].tables
    answer_explore(PageRequest(0, "explore", first, {}))
    answer_facts(PageRequest(0, "facts", first, {}))


def _warm_up_diagrams(_task: Task) -> None:
    """Compile or load the kernels of many motions."""
    options = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "values": 8, "points": 4}
    request = PageRequest(0, "diagram", presets()[0].tables, options)
    for _ in answer_job(request, RunningRequest()):
        pass


class SafeHeaders:
    """Middleware that adds security headers: only scripts of this server run, none is framed.

    Parameters
    ----------
    app
        The application behind it.
    scripts
        Texts of the scripts that the report may run.
    """

    def __init__(self, app: ASGIApp, scripts: Sequence[str] = ()) -> None:
        self.app = app
        self.scripts = scripts

    @property
    def report_policy(self) -> str:
        """The policy for the report; read anew, since the report may have just been written."""
        digests = [hashlib.sha256(script.encode()).digest() for script in self.scripts]
        sources = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
        return REPORT_POLICY.format(scripts=sources or "'none'")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, and add the headers to its response."""
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
    return JSONResponse(page_data(job.folder if job.is_there else None))


async def _report_job(request: Request) -> Response:
    """Return the state of the report; POST starts it."""
    job: ReportJob = request.app.state.report
    if request.method == "POST":
        job.start()
    return JSONResponse(job.state())


async def _file(request: Request) -> Response:
    extension = request.path_params["extension"]
    if extension not in FORMATS:
        raise HTTPException(404, f"{extension[:20]} is no format of files")
    client = request.client.host if request.client else ""
    waiting: Counter[str] = request.app.state.n_files
    if waiting[client] >= MOST_FILES:
        raise HTTPException(429, f"{MOST_FILES} files are being written for you; wait for one")
    waiting[client] += 1
    try:
        page_request = read_request(await request.body(), ("motion", "mechanism", *VIEWS))
        file = await _file_while_connected(request, page_request, extension)
    except (BadRequest, PercussError) as error:
        raise HTTPException(422, str(error)) from error
    except Exception as error:
        # Logged here, and sent without its details.
        _report(error)
        raise HTTPException(422, FAILED) from error
    except asyncio.CancelledError as error:
        raise HTTPException(503, "the server ends") from error
    finally:
        waiting[client] -= 1
        if waiting[client] <= 0:
            del waiting[client]
    headers = {"content-disposition": f'attachment; filename="{file.name}"'}
    return Response(file.data, media_type=file.media_type, headers=headers)


async def _file_while_connected(
    request: Request, page_request: PageRequest, extension: str
) -> File:
    """Return a file; its computation is cancelled when the client disconnects."""
    schedulers: Schedulers = request.app.state.schedulers
    running = RunningRequest()

    def compute(task: Task) -> File:
        with running.in_task(task):
            return file_of(page_request, extension, running)

    scheduler = schedulers.facts if extension in QUICK else schedulers.long
    file = asyncio.wrap_future(scheduler.submit(compute))
    disconnected = asyncio.ensure_future(request.receive())
    both: list[asyncio.Future[Any]] = [file, disconnected]
    try:
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        if not file.done():
            raise BadRequest("the client has disconnected")
        return file.result()
    finally:
        running.is_cancelled = True
        disconnected.cancel()
        file.cancel()


async def _socket(socket: WebSocket) -> None:
    app = socket.app
    if app.state.n_clients >= MOST_CLIENTS:
        await socket.close(1008)
        return
    app.state.n_clients += 1
    session = Session(_sender(socket), app.state.schedulers, _report)
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
