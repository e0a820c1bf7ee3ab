"""What goes wrong in a command, as lines on the error stream and an exit status."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from percuss.errors import OutputError, PercussError

BAD_INPUT = 2
INTERRUPTED = 130


@contextmanager
def faults_on_stderr(
    written: str = "nothing was written", instead: str = "--force replaces it"
) -> Iterator[None]:
    """Turn what percuss raises into one line a fault and the exit status 2.

    `instead` says what to do where a file exists already.
    """
    try:
        with warnings.catch_warnings():
            # A sentence; where in the code it stands is no business of a command's.
            warnings.showwarning = lambda message, *_: typer.echo(f"warning: {message}", err=True)
            yield
    except PercussError as error:
        message = str(error)
        if isinstance(error, OutputError):
            message = message.replace("force=True replaces it", instead)
        typer.echo(message, err=True)
        raise typer.Exit(BAD_INPUT) from error
    except KeyboardInterrupt as error:
        typer.echo(f"interrupted; {written}", err=True)
        raise typer.Exit(INTERRUPTED) from error
