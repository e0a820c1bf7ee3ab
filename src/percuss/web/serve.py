"""The workbench served on this machine."""

from __future__ import annotations

import ipaddress
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.errors import MissingExtraError, OutputError
from percuss.model.exact import whole
from percuss.web.gate import TOKEN

if TYPE_CHECKING:
    import uvicorn
    from starlette.applications import Starlette

LAST_PORT = 2**16 - 1
LOCAL = "127.0.0.1"
# Names of this machine for itself; any other would be DNS rebinding by a foreign page.
LOCAL_NAMES = ("127.0.0.1", "localhost", "[::1]")
# Addresses that stand for all of this machine: they can be listened at, not opened.
ANY = {"0.0.0.0": socket.AF_INET, "": socket.AF_INET, "::": socket.AF_INET6}


def serve(
    host: str = LOCAL,
    port: int = 8765,
    *,
    report: Path | None = None,
    link: str = "",
    open_page: bool = True,
    say: Callable[[str], None] = print,
) -> None:
    """Serve the workbench until Ctrl-C.

    Parameters
    ----------
    host
        Address to listen at; other machines reach only addresses of the network.
    port
        Port to listen at; 0 for any that is free.
    report
        Folder of a report of `percuss paper`, or None.
    link
        What the page begins with, at the address ``/study``: the fragment of a link, as
        `percuss.studies.link.link_of` returns it; empty for its first motion.
    open_page
        Whether to open the page in a browser.
    say
        Called with lines for the user: the addresses.

    Raises
    ------
    MissingExtraError
        If starlette or uvicorn is missing.
    ParameterError
        If there is no such port.
    OutputError
        If the port is taken, or there is no such report.
    """
    try:
        from percuss.web.app import create_app
    except ImportError as error:
        raise MissingExtraError("the page needs starlette and uvicorn", "web") from error
    port = whole("port", port, 0, LAST_PORT)
    if report is not None and not (report / "index.html").is_file():
        raise OutputError(report, "holds no report; write one with percuss paper --out")
    listening = _listening(host, port)
    # Only users of this machine reach a loopback address; elsewhere a token is required.
    token = None if is_loopback(host) else secrets.token_urlsafe(24)
    hosts = (*LOCAL_NAMES, _in_address(host)) if token is None else ("*",)
    server = server_of(create_app(report=report, link=link, hosts=hosts, token=token))
    # A link with a record is too long for a terminal.
    path = "study" if link else ""
    addresses = addresses_of(host, listening.getsockname()[1], token, path)
    say(f"percuss is at {addresses[0]} (Ctrl-C ends it)")
    for other in addresses[1:]:
        say(f"on this machine also at {other}")
    if open_page:
        opening = threading.Timer(0.5, webbrowser.open, [addresses[-1]])
        opening.daemon = True
        opening.start()
    with listening:
        server.run([listening])


def is_loopback(host: str) -> bool:
    """Return whether an address is reached from this machine alone.

    Examples
    --------
    >>> [is_loopback(host) for host in ("127.0.0.1", "localhost", "::1", "0.0.0.0", "10.0.0.2")]
    [True, True, True, False, False]
    """
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def addresses_of(host: str, port: int, token: str | None, path: str = "") -> list[str]:
    """Return the addresses to open: the one for other machines first.

    Examples
    --------
    >>> addresses_of("127.0.0.1", 8765, None)
    ['http://127.0.0.1:8765/']
    >>> addresses_of("0.0.0.0", 8765, "abc")[-1]
    'http://127.0.0.1:8765/?token=abc'
    >>> addresses_of("127.0.0.1", 8765, None, "study")
    ['http://127.0.0.1:8765/study']
    """
    names = [host]
    if host in ANY:
        local = "::1" if ":" in host else LOCAL
        names = [own_address(ANY[host]) or socket.gethostname(), local]
    rest = path + (f"?{TOKEN}={token}" if token else "")
    return [f"http://{_in_address(name)}:{port}/{rest}" for name in names]


def own_address(family: socket.AddressFamily) -> str | None:
    """Return the address of this machine in its network, None where it has none."""
    far = "192.0.2.1" if family is socket.AF_INET else "2001:db8::1"
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as asking:
            # Nothing is sent: the system only chooses the route.
            asking.connect((far, 9))
            return str(asking.getsockname()[0])
    except OSError:
        return None


def _in_address(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def server_of(app: Starlette) -> uvicorn.Server:
    """Return a server with time limits on requests that ends its tasks at once on shutdown."""
    import uvicorn

    from percuss.web.connections import BoundedProtocol

    class Server(uvicorn.Server):
        """Cancels all tasks as soon as it shuts down."""

        async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
            app.state.schedulers.close()
            await super().shutdown(sockets)

    config = uvicorn.Config(
        app,
        http=BoundedProtocol,
        log_level="warning",
        ws_max_size=1 << 20,
        # Floats compress badly, and a slider would wait for it.
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
    )
    return Server(config)


def _listening(host: str, port: int) -> socket.socket:
    """Return a listening socket, before the address is shown."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
        # A browser may connect at once, and waits until the server runs.
        listening.listen()
    # An invalid name raises no OSError.
    except (OSError, UnicodeError, ValueError) as error:
        listening.close()
        words = getattr(error, "strerror", None) or str(error)
        reason = f"cannot listen there ({words.lower()})"
        raise OutputError(f"{host}:{port}", f"{reason}; choose another with --port") from error
    return listening
