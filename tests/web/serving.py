"""A server of the page in a thread of the test."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Iterator

from starlette.applications import Starlette
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from percuss.web.serve import server_of


class Kept:
    """Lets a browser keep scripts and styles: no test changes them, and each load asks for fifty."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start" and scope["path"].startswith("/static/"):
                rest = [row for row in message["headers"] if row[0] != b"cache-control"]
                message["headers"] = [*rest, (b"cache-control", b"max-age=3600, immutable")]
            await send(message)

        await self.app(scope, receive, sent)


@contextlib.contextmanager
def served(app: Starlette) -> Iterator[str]:
    """Serve an application on a free port of the loopback; give its host and port."""
    app.add_middleware(Kept)
    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    server = server_of(app)
    thread = threading.Thread(target=server.run, args=([listening],), daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    try:
        yield f"127.0.0.1:{listening.getsockname()[1]}"
    finally:
        server.should_exit = True
        thread.join(timeout=120)
        listening.close()
