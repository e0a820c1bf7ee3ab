"""Who may ask, and how much: one rule for pages, files and sockets."""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Sequence
from urllib.parse import parse_qsl, urlencode, urlsplit

from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from percuss.web.question import MOST_BYTES

__all__ = ["TOKEN", "Gate"]

# What the token is called in an address.
TOKEN = "token"
# A body may take so long to come [s].
PATIENCE = 10.0
READING = ("GET", "HEAD", "OPTIONS")


class Gate:
    """Lets through what a page of this server asks, with a body of a bounded size.

    A request that names where it comes from (`Origin`, `Sec-Fetch-Site`) has to come from here;
    programs name nothing, and may ask.

    Parameters
    ----------
    app
        What answers.
    hosts
        Names under which it answers; "*" for any. Pages of others may let their names lead here.
    token
        What an address or a cookie has to hold, or None.
    """

    def __init__(
        self, app: ASGIApp, hosts: Sequence[str] = ("*",), token: str | None = None
    ) -> None:
        self.app = app
        self.hosts = hosts
        self.token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or say in a sentence why not."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        fault = self._fault(asked)
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
                    body = await _body(asked, receive)
            except TimeoutError:
                fault = 408, f"the request took longer than {PATIENCE:g} s"
            except _TooLargeError as error:
                fault = 413, str(error)
        if fault is not None:
            # What may still be coming is not taken.
            headers = {"connection": "close"}
            answer = JSONResponse({"fault": fault[1]}, fault[0], headers)
            await answer(scope, receive, send)
        elif self.token is not None and scope["method"] == "GET" and TOKEN in asked.query_params:
            await self._welcome(asked)(scope, receive, send)
        else:
            await self.app(scope, _again(body, receive), send)

    def _fault(self, asked: HTTPConnection) -> tuple[int, str] | None:
        """Return the status and the sentence for who may not ask, None for who may."""
        host = asked.headers.get("host", "")
        if "*" not in self.hosts and _name(host) not in {_name(it) for it in self.hosts}:
            return 400, f"host = {host!r:.80}: not a name of this server"
        acts = asked.scope["type"] == "websocket" or asked.scope["method"] not in READING
        origin, site = (asked.headers.get(name) for name in ("origin", "sec-fetch-site"))
        is_ours = origin is None or _netloc(origin) == host.lower()
        if acts and not (is_ours and site in (None, "same-origin", "none")):
            return 403, "a page of another server asks"
        if self.token is not None and not self._has_token(asked, self.token):
            return 403, "open the address that percuss serve has printed: it holds a token"
        return None

    def _has_token(self, asked: HTTPConnection, token: str) -> bool:
        given = asked.query_params.get(TOKEN) or asked.cookies.get(_cookie(asked), "")
        # In a time that does not tell how much of it is right.
        return hmac.compare_digest(given.encode(), token.encode())

    def _welcome(self, asked: HTTPConnection) -> RedirectResponse:
        """Keep the token in a cookie, and lead to the address without it."""
        assert self.token is not None
        rest = [it for it in parse_qsl(asked.url.query) if it[0] != TOKEN]
        path = "/" + asked.url.path.lstrip("/")
        answer = RedirectResponse(f"{path}?{urlencode(rest)}" if rest else path, 303)
        answer.set_cookie(_cookie(asked), self.token, httponly=True, samesite="strict")
        return answer


class _TooLargeError(Exception):
    """A body that is not taken."""


async def _body(asked: HTTPConnection, receive: Receive) -> bytes:
    """Return the body of a request, counted as it comes, whatever is said of its length."""
    told = asked.headers.get("content-length", "")
    if told.isdecimal() and len(told) < 20 and int(told) > MOST_BYTES:
        raise _TooLargeError(f"a request of {told} bytes; {MOST_BYTES} are the most")
    body = bytearray()
    more = True
    while more:
        message = await receive()
        if message["type"] != "http.request":
            break
        body += message.get("body", b"")
        if len(body) > MOST_BYTES:
            raise _TooLargeError(f"a request of more than {MOST_BYTES} bytes, which are the most")
        more = message.get("more_body", False)
    return bytes(body)


def _again(body: bytes, receive: Receive) -> Receive:
    """Return what gives a body that has been read, and then what comes after it."""
    waiting: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

    async def again() -> Message:
        return waiting.pop() if waiting else await receive()

    return again


def _cookie(asked: HTTPConnection) -> str:
    # Cookies are of a host, whatever the port.
    server = asked.scope.get("server")
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
