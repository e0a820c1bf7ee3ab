"""The command for the page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from percuss.cli.faults import faults_on_stderr


def serve(
    *,
    host: Annotated[
        str, typer.Option("--host", help="Address to listen at; the default is this machine only.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", "-p", help="Port; 0: any that is free.")] = 8765,
    report: Annotated[
        Path | None, typer.Option("--report", help="Folder of a report of percuss paper.")
    ] = None,
    no_open: Annotated[bool, typer.Option("--no-open", help="Open no browser.")] = False,
) -> None:
    """Open the workbench: sliders, diagrams and basins in the browser."""
    with faults_on_stderr("the page is closed"):
        from percuss.web.serve import serve as serve_page

        serve_page(host, port, report=report, open_page=not no_open, say=_say)


def _say(text: str) -> None:
    # At once, also into a pipe: whoever started the page waits for its address.
    print(text, flush=True)  # noqa: T201
