"""The whole of `percuss paper`: compute, judge, draw, write the report."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from percuss.errors import OutputError
from percuss.io.files import OutputFiles, check_output, check_output_folder
from percuss.paper.claim import Claim, examine
from percuss.paper.collection import Item, choose, figure_named, statement_with_id
from percuss.paper.figure_files import Drawn, draw_figure
from percuss.paper.processes import in_processes
from percuss.paper.records import SCHEMA_FILE, records_text, schema_text
from percuss.paper.result import INTERRUPTED, PaperResult
from percuss.progress import Progress, Report

PROCESSES = 2
# Fewer items are done before a second process has started.
FEWEST_FOR_PROCESSES = 8


@dataclass(frozen=True)
class _Answer:
    """What a process hands back: one of the three."""

    item: Item
    claim: Claim | None = None
    drawn: Drawn | None = None
    failure: str = ""


@dataclass
class _Gathered:
    """What has been done so far."""

    claims: dict[str, Claim] = field(default_factory=dict)
    figures: dict[str, Drawn] = field(default_factory=dict)
    failures: dict[Item, str] = field(default_factory=dict)

    def add(self, answer: _Answer) -> None:
        if answer.claim is not None:
            self.claims[answer.item.name] = answer.claim
        elif answer.drawn is not None:
            self.figures[answer.item.name] = answer.drawn
        else:
            self.failures[answer.item] = answer.failure

    def __len__(self) -> int:
        return len(self.claims) + len(self.figures) + len(self.failures)


def run_paper(
    folder: Path | str,
    *,
    only: str | None = None,
    command: str = "",
    force: bool = False,
    progress: Report = None,
    processes: int | None = None,
) -> PaperResult:
    """Recompute the paper, or a part of it, and write the report.

    Parameters
    ----------
    folder
        Where to write: index.html, beyond.html, coverage.html, comment.pdf, claims.json with its
        schema, four files a figure, and studies/ID.toml of each record that has a study.
    only
        Names of figures and statements, separated by commas; default: all.
    command
        The command, for the record in each file.
    force
        Whether a folder that is not empty may be written to; files of other names stay.
    progress
        As in `percuss.simulate`. What is stopped leaves the finished figures, and the report says
        what is missing.
    processes
        Number of processes; default: two where there are two cores and much to do.

    Returns
    -------
    PaperResult
        The claims with their verdicts, the figures, and what is missing.

    Raises
    ------
    ParameterError
        If a name is unknown.
    OutputError
        If the folder is not empty and `force` is false, or cannot be written to.
    """
    chosen = choose(only)
    out = Path(folder)
    _check_folder(out, force=force)
    began = time.perf_counter()
    done = _Gathered()
    counted = Progress(progress, len(chosen), "statements and figures")

    def go_on() -> bool:
        return counted.reach(len(done))

    for answer in _answers(
        chosen, partial(_work, out, command), _processes(processes, chosen), go_on
    ):
        done.add(answer)
    missing = {
        item: done.failures.get(item, INTERRUPTED)
        for item in chosen
        if item.name not in (done.claims if item.kind == "statement" else done.figures)
    }
    seconds = time.perf_counter() - began
    result = PaperResult(out, chosen, done.claims, done.figures, missing, command, seconds)
    _write_report(result)
    return result


def _check_folder(folder: Path, *, force: bool) -> None:
    check_output_folder(folder, force=force)
    check_output([folder / "index.html", folder / "claims.json"], force=True)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(folder, f"the folder cannot be written: {reason}") from error


def _processes(asked: int | None, chosen: Sequence[Item]) -> int:
    if asked is not None:
        return asked
    return min(PROCESSES, os.cpu_count() or 1) if len(chosen) >= FEWEST_FOR_PROCESSES else 1


def _answers(
    chosen: Sequence[Item],
    work: Callable[[Item], _Answer],
    processes: int,
    go_on: Callable[[], bool],
) -> Iterator[_Answer]:
    if processes > 1:
        yield from in_processes(work, chosen, processes, go_on, _failed)
        return
    for item in chosen:
        if not go_on():
            return
        yield work(item)
    go_on()


def _failed(item: Item, reason: str) -> _Answer:
    return _Answer(item, failure=reason)


def _work(folder: Path, command: str, item: Item) -> _Answer:
    """Do one item; what goes wrong is part of the answer, so that the others are done."""
    try:
        if item.kind == "figure":
            return _Answer(item, drawn=draw_figure(figure_named(item), folder, command))
        return _Answer(item, claim=examine(statement_with_id(item)))
    except OutputError:
        raise
    except Exception as error:  # noqa: BLE001  the report says it
        return _failed(item, f"{type(error).__name__}: {error}")


def _write_report(result: PaperResult) -> None:
    from percuss.paper.comment import comment_pdf
    from percuss.paper.report.page import pages

    in_order = [item.name for item in result.items if item.kind == "statement"]
    claims = [result.claims[name] for name in in_order if name in result.claims]
    texts: dict[str, str | bytes] = {
        **pages(result),
        "comment.pdf": comment_pdf(result),
        "claims.json": records_text(claims),
        SCHEMA_FILE: schema_text(),
        **{claim.study_file: claim.study_text() for claim in claims if claim.study_file},
    }
    paths = [result.folder / name for name in texts]
    with OutputFiles(*paths, force=True) as files:
        for path, text in zip(paths, texts.values(), strict=True):
            files[path].write_bytes(text if isinstance(text, bytes) else text.encode())
