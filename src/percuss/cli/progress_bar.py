"""Watching a long run: a bar or lines after two seconds, and Ctrl-C that keeps what is done."""

from __future__ import annotations

import signal
import threading
import time
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from percuss.progress import PATIENCE, RENEWED_IN_A_LOG

STARTING = "starting (the first run compiles the engine)"
RUNNING = "simulating"
INTERRUPTED = "interrupted; writing what was done (Ctrl-C again drops it)"


class ProgressBar:
    """The progress of a run, as `simulate` reports it.

    Inside the ``with`` block the first Ctrl-C ends the run where it is, and the second one ends
    the program; once the results are being written, the first one does.

    In a terminal the progress is a bar; where the error stream is a pipe or a file, lines, the
    first one after two seconds and then one every ten, whatever the run reports.

    Parameters
    ----------
    doing
        What is being done, before the bar.
    of_chunks
        Whether it is done in chunks, which see to Ctrl-C themselves: those at work are kept.
    """

    def __init__(self, doing: str = RUNNING, *, of_chunks: bool = False) -> None:
        self._doing = doing
        self._of_chunks = of_chunks
        # By a clock of its own: the first run of all compiles the engine and reports nothing yet.
        self._clock = threading.Thread(target=self._show, name="percuss-watch", daemon=True)
        self._is_over = threading.Event()
        self._began = time.monotonic()
        self._done, self._total = 0.0, 0.0
        self._bar: Progress | None = None
        self._console = Console(stderr=True, highlight=False, soft_wrap=True)
        self._has_begun = self._has_said = False
        self._task: Any = None
        self._handler: Any = None
        self.is_stopped = False

    def __call__(self, done: float, total: float) -> bool:
        """Note the progress, and return whether to go on."""
        self._has_begun = True
        self._done, self._total = done, total
        if self._bar is not None:
            self._bar.update(self._task, description=self._doing, completed=done, total=total)
        return not self.is_stopped

    def writing(self, file: Path) -> None:
        """Show that the run is over and that a file is being written."""
        # What is written is dropped by the Ctrl-C of before.
        signal.signal(signal.SIGINT, self._handler)
        if self.is_stopped and not self._has_said:
            self._has_said = True
            self._console.print(INTERRUPTED)
        self._has_begun = True
        self._doing, self._total = f"writing {file.name}", 0.0
        if self._bar is not None:
            self._bar.reset(self._task, total=None, description=self._doing)

    def _show(self) -> None:
        if self._is_over.wait(PATIENCE):
            return
        if self._console.is_terminal:
            self._show_bar()
            return
        while True:
            self._console.print(self._line(), markup=False)
            if self._is_over.wait(RENEWED_IN_A_LOG):
                return

    def _line(self) -> str:
        """Return how far the run is, in a line of a log."""
        share = f" {min(1.0, self._done / self._total):6.1%}," if self._total > 0.0 else ","
        doing = self._doing if self._has_begun else STARTING
        return f"{doing}{share} {time.monotonic() - self._began:.0f} s so far"

    def _show_bar(self) -> None:
        bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
        )
        self._task = bar.add_task(self._doing if self._has_begun else STARTING, total=None)
        bar.start()
        self._bar = bar

    def __enter__(self) -> Self:
        self._handler = signal.getsignal(signal.SIGINT)
        if not self._of_chunks:
            signal.signal(signal.SIGINT, self._stop)
        self._clock.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        signal.signal(signal.SIGINT, self._handler)
        self._is_over.set()
        self._clock.join()
        if self._bar is not None:
            self._bar.stop()

    def _stop(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self.is_stopped = True
        signal.signal(signal.SIGINT, self._handler)
