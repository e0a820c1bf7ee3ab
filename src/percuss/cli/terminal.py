"""The output of a command in the terminal: a bar while it runs, then its results."""

from __future__ import annotations

import signal
import threading
import time
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from percuss.progress import PATIENCE, RENEWED_IN_A_LOG
from percuss.wording import counted

if TYPE_CHECKING:
    # A second of import, and each command prints only one of them.
    from percuss.paper.claim import Claim
    from percuss.paper.result import PaperResult
    from percuss.paper.statement import VerdictKind
    from percuss.studies.running import StudyResult
    from percuss.studies.study import Study

STARTING = "starting (the first run compiles the engine)"
RUNNING = "simulating"
INTERRUPTED = "interrupted; writing what was done (Ctrl-C again drops it)"
TERMINATED = "ended by SIGTERM; writing what was done (once more drops it)"
WRITING = "SIGTERM has come while the results are written; once more drops them"
COLOURS: dict[VerdictKind, str] = {
    "holds": "green",
    "corrected": "yellow",
    "fails": "red",
    "undecided": "magenta",
}
# So many records, and no more, are printed with their claims whatever their verdicts.
FEW = 12
# The width of the usual names.
WIDTH = len("special points") + 2


class Terminated(KeyboardInterrupt):
    """SIGTERM, as a queue or `kill` sends it, where Ctrl-C would raise KeyboardInterrupt."""


class ProgressBar:
    """The progress of a study, as `simulate`, `sweep` and all other long calls report it.

    Inside the ``with`` block the first Ctrl-C ends the run where it is, and the second one ends
    the program; once the results are being written, the first one does. So does SIGTERM, which
    lets files that are being written be finished the first time.

    In a terminal the progress is a bar; where the error stream is a pipe or a file, lines, the
    first one after two seconds and then one every ten, whatever the run reports.

    Parameters
    ----------
    doing
        The work in progress, in words before the bar.
    of_chunks
        Whether it is done in chunks, whose engines handle Ctrl-C themselves.
    name
        What is at work, before each line and bar: one of several studies, or a part of one.
    is_quiet
        Whether nothing is shown but what signals do.

    Attributes
    ----------
    is_stopped
        Whether a signal has asked to stop.
    signal
        The signal that came first, 0 without any.
    """

    def __init__(
        self,
        doing: str = RUNNING,
        *,
        of_chunks: bool = False,
        name: str = "",
        is_quiet: bool = False,
    ) -> None:
        self._name = f"{name}: " if name else ""
        self._is_quiet = is_quiet
        self._doing = doing
        self._of_chunks = of_chunks
        # A thread of its own: the first run compiles the kernels and reports nothing yet.
        self._clock = threading.Thread(target=self._show, name="percuss-progress", daemon=True)
        self._is_over = threading.Event()
        self._began = time.monotonic()
        self._done, self._total = 0.0, 0.0
        self._bar: Progress | None = None
        self._console = Console(stderr=True, highlight=False, soft_wrap=True)
        self._has_begun = self._has_said = False
        self._task: Any = None
        self._handlers: dict[int, Any] = {}
        self._is_writing = False
        self.is_stopped = False
        self.signal = 0

    def __call__(self, done: float, total: float) -> bool:
        """Take the progress, and return whether to go on."""
        self._has_begun = True
        self._done, self._total = done, total
        if self._bar is not None:
            self._bar.update(self._task, description=self._what(), completed=done, total=total)
        return not self.is_stopped

    def raise_if_stopped(self) -> None:
        """Raise what a signal has left to the end of the work; nothing without any."""
        if self.is_stopped:
            raise _interruption(self.signal)

    def writing(self, file: Path) -> None:
        """Show that the run is over and that a file is being written."""
        self._is_writing = True
        if self.is_stopped and not self._has_said:
            self._has_said = True
            self._console.print(TERMINATED if self.signal == signal.SIGTERM else INTERRUPTED)
        self._has_begun = True
        self._doing, self._total = f"writing {file.name}", 0.0
        if self._bar is not None:
            self._bar.reset(self._task, total=None, description=self._what())

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
        """Return the progress of the run as a line of a log."""
        share = f" {min(1.0, self._done / self._total):6.1%}," if self._total > 0.0 else ","
        return f"{self._what()}{share} {time.monotonic() - self._began:.0f} s so far"

    def _what(self) -> str:
        """Return what is at work, and on what."""
        return self._name + (self._doing if self._has_begun else STARTING)

    def _show_bar(self) -> None:
        bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
        )
        self._task = bar.add_task(self._what(), total=None)
        bar.start()
        self._bar = bar

    def __enter__(self) -> Self:
        # Only the main thread hears signals.
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                handler = signal.getsignal(number)
                # Chunks leave a process deaf to Ctrl-C, as shells begin it in the background.
                if not (self._of_chunks and handler is signal.SIG_IGN):
                    self._handlers[number] = handler
                    signal.signal(number, self._hear)
        if not self._is_quiet:
            self._clock.start()
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._is_over.set()
        if not self._is_quiet:
            self._clock.join()
        if self._bar is not None:
            self._bar.stop()

    def _hear(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        is_first, self.signal = self.signal == 0, self.signal or number
        if self._is_writing and is_first and number == signal.SIGTERM:
            self._console.print(WRITING)
        elif self._is_writing or self._of_chunks or not is_first:
            raise _interruption(number)
        else:
            self.is_stopped = True


def _interruption(number: int) -> type[KeyboardInterrupt]:
    return Terminated if number == signal.SIGTERM else KeyboardInterrupt


def print_report(study: Study, result: StudyResult) -> None:
    """Print the results of a study, the time it took and the files."""
    # Those of a part of a job array come when all are merged, those of a store at its end.
    come_later = not result.files and ("part" in result.report or not result.is_whole)
    files = {"files": "\n".join(map(str, result.files)) or "none"}
    rows = {
        **result.report,
        "computed": f"in {result.seconds:.3g} s",
        **({} if come_later else files),
    }
    # Text, not markup: a path may hold square brackets. No wrapping: it may be copied.
    console = Console(highlight=False, soft_wrap=True)
    if study.title:
        console.print(Text(study.title, style="bold"))
    width = max(WIDTH, *(len(name) + 2 for name in rows))
    for name, words in rows.items():
        lines = words.replace("\n", f"\n{' ' * width}")
        console.print(Text.assemble((name.ljust(width), "dim"), lines))


def print_verdicts(result: PaperResult) -> None:
    """Print the counts, the findings, what fails, and last the page of the report."""
    console = Console(highlight=False)
    claims = [
        result.claims[item.name]
        for item in result.items
        if item.kind == "statement" and item.name in result.claims
    ]
    if result.figures:
        names = (item.name for item in result.items if item.kind == "figure")
        drawn = ", ".join(name for name in names if name in result.figures)
        console.print(f"{counted(len(result.figures), 'figure')}: {drawn}", soft_wrap=True)
    if claims:
        count = Counter(claim.kind for claim in claims)
        words = ", ".join(f"{count[kind]} {kind}" for kind in COLOURS)
        console.print(f"{counted(len(claims), 'statement')}: {words}")
    _print_findings(console, result)
    _print_claims(console, claims)
    for item, reason in result.missing.items():
        console.print(Text.assemble((f"missing {item.name}: ", "red"), reason), soft_wrap=True)
    # Text, not markup, and unbroken: a path may be copied.
    line = f"{result.folder / 'index.html'} and claims.json, in {result.seconds:.0f} s"
    console.print(Text(line), soft_wrap=True)


def _print_findings(console: Console, result: PaperResult) -> None:
    """Print what was found, each in a line."""
    from percuss.paper.findings import headlines_of

    headlines = headlines_of(result.claims)
    if headlines:
        console.print(Text("What was found", style="bold"))
    for headline in headlines:
        console.print(Text(f"  {headline.title}"), soft_wrap=True)


def _print_claims(console: Console, claims: list[Claim]) -> None:
    """Print the claims that fail or are undecided; all of them where few were asked for."""
    shown = claims
    if len(claims) > FEW:
        shown = [claim for claim in claims if claim.kind in ("fails", "undecided")]
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column("where", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("claim")
    for claim in shown:
        verdict = Text(f"{claim.kind}, {claim.grade}", style=COLOURS[claim.kind])
        table.add_row(Text(claim.reference), verdict, Text(claim.claim))
    if shown:
        console.print(table)
