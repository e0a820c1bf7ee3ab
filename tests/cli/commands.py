"""The command line, called as a user does."""

from __future__ import annotations

from typer.testing import CliRunner

from percuss.cli import app


def percuss(*arguments: str) -> tuple[int, str, str]:
    """Return the status of a command and what it writes; any fault is told in a sentence."""
    result = CliRunner().invoke(app, list(arguments))
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result.exit_code, result.stdout, result.stderr
