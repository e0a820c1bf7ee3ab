"""Processes that tests begin: Ctrl-C reaches them, and nothing of them is left when a test ends."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

# Whatever hangs ends here, and fails [s].
LONGEST = 240.0


def listen_to_ctrl_c() -> None:
    """Make this process and those that it begins hear Ctrl-C.

    A shell begins background jobs, those of nohup too, deaf to it, and deafness is inherited. A
    handler is not: what is begun has the default again.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def begun(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Give a process in a group of its own, with pipes for its words; its group ends with it."""
    process = subprocess.Popen(
        command, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options,
    )  # fmt: skip
    try:
        yield process
    finally:
        _end_group(process)
        process.communicate()


def finished(
    command: Sequence[str], *, text: str | None = None, timeout: float = LONGEST, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Return a process that has ended, and its words."""
    stdin = None if text is None else subprocess.PIPE
    with begun(command, stdin=stdin, **options) as process:
        out, err = process.communicate(text, timeout=timeout)
    return subprocess.CompletedProcess(list(command), process.returncode, out, err)


def interrupt(process: subprocess.Popen[str]) -> None:
    """Press Ctrl-C, as a terminal does: for a process and all that it has begun."""
    os.killpg(process.pid, signal.SIGINT)


def _end_group(process: subprocess.Popen[str]) -> None:
    # A group lives as long as one of it does, also after the process that it is named after.
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
