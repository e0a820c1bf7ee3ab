"""Watching a long run: a bar after two seconds, and Ctrl-C that keeps what is done."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

# A run that is over sooner needs no bar [s].
PATIENCE = 2.0
STARTING = "starting (the first run compiles the engine)"
RUNNING = "simulating"


class Watch:
    """The progress of a run, as `simulate` reports it.

    Inside the ``with`` block the first Ctrl-C ends the run where it is, and the second one ends
    the program.

    Parameters
    ----------
    doing
        What is being done, before the bar.
    """

    def __init__(self, doing: str = RUNNING) -> None:
        self._doing = doing
        # By a clock of its own: the first run of all compiles the engine and reports nothing yet.
        self._timer = threading.Timer(PATIENCE, self._show)
        self._timer.daemon = True
        self._bar: Progress | None = None
        self._task: Any = None
        self._handler: Any = None
        self.is_stopped = False

    def __call__(self, done: float, total: float) -> bool:
        """Note the progress, and return whether to go on."""
        if self._bar is not None:
            self._bar.update(self._task, description=self._doing, completed=done, total=total)
        return not self.is_stopped

    def _show(self) -> None:
        bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = bar.add_task(STARTING, total=None)
        bar.start()
        self._bar = bar

    def __enter__(self) -> Self:
        self._handler = signal.signal(signal.SIGINT, self._stop)
        self._timer.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        signal.signal(signal.SIGINT, self._handler)
        self._timer.cancel()
        self._timer.join()
        if self._bar is not None:
            self._bar.stop()

    def _stop(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self.is_stopped = True
        signal.signal(signal.SIGINT, self._handler)
