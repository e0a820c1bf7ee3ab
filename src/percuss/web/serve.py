"""Opening the workbench on this machine."""

from __future__ import annotations

import socket
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path

from percuss.errors import MissingExtraError, OutputError
from percuss.model.exact import whole

__all__ = ["LOCAL", "serve"]

LAST_PORT = 2**16 - 1
LOCAL = "127.0.0.1"
# Names of this machine for itself; others would be pages that pretend to be it.
LOCAL_NAMES = ("127.0.0.1", "localhost", "[::1]")


def serve(
    host: str = LOCAL,
    port: int = 8765,
    *,
    report: Path | None = None,
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
    open_page
        Whether to open the page in a browser.
    say
        Where the address is told.

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
        import uvicorn

        from percuss.web.app import create_app
    except ImportError as error:
        raise MissingExtraError("the page needs starlette and uvicorn", "web") from error
    port = whole("port", port, 0, LAST_PORT)
    if report is not None and not (report / "index.html").is_file():
        raise OutputError(report, "holds no report; write one with percuss paper --out")
    listening = _listening(host, port)
    hosts = LOCAL_NAMES if host in (*LOCAL_NAMES, "::1") else ("*",)
    config = uvicorn.Config(
        create_app(report=report, hosts=hosts),
        log_level="warning",
        ws_max_size=1 << 20,
        # Numbers hardly shrink, and a slider would wait for it.
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=2,
    )
    name = f"[{host}]" if ":" in host else host
    address = f"http://{name}:{listening.getsockname()[1]}/"
    say(f"percuss is at {address} (Ctrl-C ends it)")
    if open_page:
        threading.Timer(0.5, webbrowser.open, [address]).start()
    with listening:
        uvicorn.Server(config).run([listening])


def _listening(host: str, port: int) -> socket.socket:
    """Return a socket at the address, before anything is told."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
        # Whoever hears the address may come at once, and waits until the page is there.
        listening.listen()
    # A name that cannot be one is no OSError.
    except (OSError, UnicodeError, ValueError) as error:
        listening.close()
        words = getattr(error, "strerror", None) or str(error)
        reason = f"cannot listen there ({words.lower()})"
        raise OutputError(f"{host}:{port}", f"{reason}; choose another with --port") from error
    return listening
