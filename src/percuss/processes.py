"""Processes of this and other machines: their names, and whether they still run."""

from __future__ import annotations

import os
import socket
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

# Fields of /proc/PID/stat behind the name of the command: the state, and the begin in clock ticks.
STATE, BEGAN = 0, 19
# A process that has ended and whose parent has not noticed.
ENDED = "ZX"


@dataclass(frozen=True, slots=True)
class ProcessName:
    """What tells one process from all others, on any machine and at any time.

    Attributes
    ----------
    host
        Name of the machine.
    machine
        What tells this boot of it, and this container on it, from others of that name; empty
        where the system does not tell.
    pid
        Number of the process.
    began
        When the process began, in the clock of its machine; empty where the system does not tell.
    """

    host: str
    machine: str
    pid: int
    began: str

    def is_here(self) -> bool:
        """Return whether it is a process of this machine, whose numbers mean the same."""
        own = this_process()
        return (self.host, self.machine) == (own.host, own.machine)

    def may_run(self) -> bool:
        """Return whether a process of this machine may still run: its number may be another's."""
        if not is_running(self.pid):
            return False
        state, began = _state(self.pid)
        return state not in ENDED and (not self.began or not began or began == self.began)


def this_process() -> ProcessName:
    """Return the name of the calling process.

    Examples
    --------
    >>> this_process().is_here(), this_process().may_run()
    (True, True)
    """
    pid = os.getpid()
    return ProcessName(socket.gethostname(), _machine(), pid, _state(pid)[1])


def is_running(pid: int) -> bool:
    """Return whether a process of this number may be running on this machine."""
    if os.name != "posix":
        # On Windows the signal would end it.
        return True
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


@cache
def _machine() -> str:
    """Return what tells this boot and this container from others, as Linux has it."""
    with suppress(OSError):
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return f"{boot} {Path('/proc/self/ns/pid').readlink()}"
    return ""


def _state(pid: int) -> tuple[str, str]:
    """Return the state of a process and when it began, as Linux has them; "R" and "" elsewhere."""
    with suppress(OSError, IndexError):
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
        # The name of the command may hold blanks and brackets.
        fields = text.rpartition(")")[2].split()
        return fields[STATE], fields[BEGAN]
    return "R", ""
