"""Access to the workbench: who may ask, and how much, by one rule for pages, files and sockets."""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Sequence
from urllib.parse import parse_qsl, urlencode, urlsplit

from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from percuss.web.request import MOST_RECORD_BYTES

# What the token is called in an address.
TOKEN = "token"
# A body may take so long to come [s].
PATIENCE = 10.0
READING = ("GET", "HEAD", "OPTIONS")


class Gate:
    """Middleware that refuses requests of other sites, without the token, or with large bodies.

    A request that names its origin (`Origin`, `Sec-Fetch-Site`) must come from a page of this
    server; programs other than browsers name none, and may ask.

    Parameters
    ----------
    app
        The application behind it.
    hosts
        Names under which the server answers; "*" for any. A name of another site may resolve to
        this machine (DNS rebinding).
    token
        Token that the address or a cookie must hold, or None.
    """

    def __init__(
        self, app: ASGIApp, hosts: Sequence[str] = ("*",), token: str | None = None
    ) -> None:
        self.app = app
        self.hosts = hosts
        self.token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer with the reason why not."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        fault = self._fault(connection)
        if scope["type"] == "websocket":
            if fault is None:
                await self.app(scope, receive, send)
            else:
                await send({"type": "websocket.close", "code": 1008, "reason": fault[1]})
            return
        body = b""
        if fault is None:
            try:
                async with asyncio.timeout(PATIENCE):
                    body = await _body(connection, receive)
            except TimeoutError:
                fault = 408, f"the request took longer than {PATIENCE:g} s"
            except _TooLargeError as error:
                fault = 413, str(error)
        if fault is not None:
            # The rest of the body is not read.
            headers = {"connection": "close"}
            answer = JSONResponse({"fault": fault[1]}, fault[0], headers)
            await answer(scope, receive, send)
        elif (
            self.token is not None and scope["method"] == "GET" and TOKEN in connection.query_params
        ):
            await self._welcome(connection)(scope, receive, send)
        else:
            await self.app(scope, _replay(body, receive), send)

    def _fault(self, connection: HTTPConnection) -> tuple[int, str] | None:
        """Return status and reason of a refusal; None where the request is allowed."""
        host = connection.headers.get("host", "")
        if "*" not in self.hosts and _name(host) not in {_name(name) for name in self.hosts}:
            return 400, f"host = {host!r:.80}: not a name of this server"
        acts = connection.scope["type"] == "websocket" or connection.scope["method"] not in READING
        origin, site = (connection.headers.get(name) for name in ("origin", "sec-fetch-site"))
        is_ours = origin is None or _netloc(origin) == host.lower()
        if acts and not (is_ours and site in (None, "same-origin", "none")):
            return 403, "a page of another server asks"
        if self.token is not None and not self._has_token(connection, self.token):
            return 403, "open the address that percuss serve has printed: it holds a token"
        return None

    def _has_token(self, connection: HTTPConnection, token: str) -> bool:
        given = connection.query_params.get(TOKEN) or connection.cookies.get(
            _cookie(connection), ""
        )
        # The time of the comparison does not depend on how much of the token is right.
        return hmac.compare_digest(given.encode(), token.encode())

    def _welcome(self, connection: HTTPConnection) -> RedirectResponse:
        """Set the token as a cookie, and redirect to the address without it."""
        assert self.token is not None
        rest = [pair for pair in parse_qsl(connection.url.query) if pair[0] != TOKEN]
        path = "/" + connection.url.path.lstrip("/")
        answer = RedirectResponse(f"{path}?{urlencode(rest)}" if rest else path, 303)
        answer.set_cookie(_cookie(connection), self.token, httponly=True, samesite="strict")
        return answer


class _TooLargeError(Exception):
    """A body beyond the limit."""


async def _body(connection: HTTPConnection, receive: Receive) -> bytes:
    """Return the body of a request, counted as it arrives: its header may be wrong."""
    length = connection.headers.get("content-length", "")
    if length.isdecimal() and len(length) < 20 and int(length) > MOST_RECORD_BYTES:
        raise _TooLargeError(f"a request of {length} bytes; {MOST_RECORD_BYTES} are the most")
    body = bytearray()
    more = True
    while more:
        message = await receive()
        if message["type"] != "http.request":
            break
        body += message.get("body", b"")
        if len(body) > MOST_RECORD_BYTES:
            raise _TooLargeError(
                f"a request of more than {MOST_RECORD_BYTES} bytes, which are the most"
            )
        more = message.get("more_body", False)
    return bytes(body)


def _replay(body: bytes, receive: Receive) -> Receive:
    """Return a `receive` that gives a body again, and then what comes after it."""
    waiting: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

    async def replay() -> Message:
        return waiting.pop() if waiting else await receive()

    return replay


def _cookie(connection: HTTPConnection) -> str:
    # A cookie belongs to a host, whatever the port: the name holds the port.
    server = connection.scope.get("server")
    return f"percuss-{server[1] if server else 0}"


def _name(host: str) -> str:
    """Return a name without its port.

    Examples
    --------
    >>> _name("[::1]:8765"), _name("localhost:80"), _name("127.0.0.1"), _name("[")
    ('::1', 'localhost', '127.0.0.1', '')
    """
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _netloc(origin: str) -> str:
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return ""
