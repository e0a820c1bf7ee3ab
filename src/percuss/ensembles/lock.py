"""The lock of a store at work: one process writes a store at a time.

The lock is a file in the folder of the store that names its process. It is made in one step, and
removed at the end. That of a process which was killed is recognised: on the same machine by the
number and the begin of the process, from other machines by the time of the file, which a process at
work renews.
"""

from __future__ import annotations

import json
import logging
import os
import threading
import time
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

from percuss.errors import OutputError
from percuss.processes import ProcessName, this_process
from percuss.progress import duration_text

LOG = logging.getLogger(__name__)

LOCK = "percuss.lock"
# A process at work renews its lock this often [s].
RENEWED = 10.0
# A lock of another machine that was not renewed for so long is that of a killed process [s]. Two
# processes that write one store, of which one was only asleep, write the same bits.
SILENT = 300.0


class StoreLock:
    """The lock of a store, held from `acquire` to `release`.

    Parameters
    ----------
    path
        The folder of the store.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = path / LOCK
        self._content = ""
        self._renewed = 0.0

    def acquire(self) -> None:
        """Take the lock.

        Raises
        ------
        OutputError
            If another process holds it.
        """
        about = asdict(this_process()) | {"thread": threading.get_ident(), "since": time.time()}
        content = json.dumps(about)
        part = self._path / f"{LOCK}.{os.getpid()}.{threading.get_ident()}.part"
        try:
            part.write_text(content, encoding="utf-8")
            while not self._is_made(part, content):
                # Of a folder that other machines share the server's clock alone counts.
                self._check_stale(part.stat().st_mtime)
        finally:
            part.unlink(missing_ok=True)
        self._content, self._renewed = content, time.monotonic()

    def renew(self) -> None:
        """Show other machines, now and then, that this process is at work."""
        now = time.monotonic()
        if self._content and now - self._renewed > RENEWED:
            self._renewed = now
            with suppress(OSError):
                os.utime(self._file)

    def release(self) -> None:
        """Give the lock back; nothing where it is not held."""
        if self._content and self._read() == self._content:
            self._file.unlink(missing_ok=True)
        self._content = ""

    def _is_made(self, part: Path, content: str) -> bool:
        """Make the lock in one step; return False where there is one."""
        try:
            os.link(part, self._file)
        except FileExistsError:
            return False
        except OSError:
            # A file system without links.
            try:
                with self._file.open("x", encoding="utf-8") as file:
                    file.write(content)
            except FileExistsError:
                return False
        return True

    def _read(self) -> str:
        with suppress(OSError, ValueError):
            return self._file.read_text(encoding="utf-8")
        return ""

    def _check_stale(self, now: float) -> None:
        """Remove the lock if its process has been killed, else raise an `OutputError`."""
        content = self._read()
        try:
            silence = now - self._file.stat().st_mtime
        except FileNotFoundError:
            # It has just been given back.
            return
        owner, since = _owner_of(content)
        if owner is not None and owner.is_here() and os.name == "posix":
            is_stale = not owner.may_run()
        else:
            is_stale = silence > SILENT
        if not is_stale:
            raise OutputError(self._path, _at_work(owner, since, silence))
        self._remove(content)
        who = "another process" if owner is None else f"process {owner.pid} on {owner.host}"
        LOG.info("%s: %s has left its lock behind; it is removed", self._path, who)

    def _remove(self, content: str) -> None:
        """Remove a lock of this content, and no other that has taken its place meanwhile."""
        aside = self._path / f"{LOCK}.{os.getpid()}.{threading.get_ident()}.stale.part"
        try:
            self._file.rename(aside)
        except FileNotFoundError:
            return
        if aside.read_text(encoding="utf-8") != content:
            with suppress(OSError):
                os.link(aside, self._file)
        aside.unlink(missing_ok=True)


def _owner_of(content: str) -> tuple[ProcessName | None, float]:
    """Return the process that a lock names and when it took it; None where it was cut off."""
    try:
        about = json.loads(content)
        names = ProcessName.__dataclass_fields__
        return ProcessName(**{name: about[name] for name in names}), float(about["since"])
    except (ValueError, TypeError, KeyError):
        return None, time.time()


def _at_work(owner: ProcessName | None, since: float, silence: float) -> str:
    who = "another process"
    if owner is not None:
        own = " (this one)" if owner == this_process() else ""
        who = f"process {owner.pid}{own} on {owner.host}"
    ago = duration_text(max(0.0, time.time() - since))
    heard = ""
    if owner is None or not owner.is_here():
        heard = (
            f", last heard of {duration_text(max(0.0, silence))} ago (after "
            f"{duration_text(SILENT)} it counts as gone)"
        )
    return (
        f"{who} has been writing it for {ago}{heard}; one process writes a store at a time: wait "
        "for that one or end it, or choose another name"
    )
