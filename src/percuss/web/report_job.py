"""The report on the paper, computed once in a process of its own while the page is open."""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path

from percuss.web.page_data import scripts_of

# How the report is written, but for the folder; and how long it may take [s].
COMMAND = (sys.executable, "-m", "percuss", "paper", "--out")
PATIENCE = 600.0


class ReportJob:
    """A report that exists, or can be computed.

    Parameters
    ----------
    given
        Folder of a report, or None.

    Attributes
    ----------
    folder
        Where the report is, or will be.
    scripts
        The texts of its scripts, once it is there.

    Examples
    --------
    >>> job = ReportJob()
    >>> job.is_there, job.state()["state"]
    (False, 'none')
    >>> job.close()
    """

    def __init__(self, given: Path | None = None) -> None:
        # The folder is created when the report is started.
        own = Path(tempfile.gettempdir()) / f"percuss-report-{secrets.token_hex(8)}"
        self._own = None if given is not None else own
        self.folder = own / "report" if given is None else given
        self.scripts: list[str] = [] if given is None else scripts_of(given)
        self.is_there = given is not None
        self._process: subprocess.Popen[bytes] | None = None
        self._began = 0.0
        self._failure = ""
        self._lock = threading.Lock()

    def start(self) -> None:
        """Start the process, unless it runs or the report exists."""
        with self._lock:
            if self.is_there or self._process is not None:
                return
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.parent.mkdir(mode=0o700, exist_ok=True)
            self._began, self._failure = time.monotonic(), ""
            self._process = subprocess.Popen(
                [*COMMAND, str(self.folder)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                # A session of its own: its whole group of processes can be killed.
                start_new_session=True,
            )

    def state(self) -> dict[str, object]:
        """Return `state`, "none", "working", "done" or "failed", with its seconds or reason."""
        with self._lock:
            self._poll()
            if self._process is not None:
                seconds = round(time.monotonic() - self._began)
                return {"state": "working", "seconds": seconds}
            if self.is_there:
                return {"state": "done"}
            return {"state": "failed" if self._failure else "none", "reason": self._failure}

    def close(self) -> None:
        """Kill the process, and remove what it has written."""
        with self._lock:
            if self._process is not None:
                _kill(self._process)
                self._process = None
            if self._own is not None:
                shutil.rmtree(self._own, ignore_errors=True)

    def _poll(self) -> None:
        """Note whether the process has ended, and kill it when its time is up."""
        process = self._process
        if process is None:
            return
        if process.poll() is None and time.monotonic() - self._began > PATIENCE:
            _kill(process)
        if process.poll() is None:
            return
        self._process = None
        # The exit code says whether verdicts contradict the paper; the report exists either way.
        if (self.folder / "index.html").is_file():
            self.scripts.extend(scripts_of(self.folder))
            self.is_there = True
        else:
            self._failure = "percuss paper wrote no report; the terminal tells why"


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and those that it has started."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()
