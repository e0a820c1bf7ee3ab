"""The command ``percuss run``: all studies are read, then run and reported one after the other."""

from __future__ import annotations

import json
import shlex
import signal
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from percuss.errors import OutputError, ParameterError, PercussError, StudyError
from percuss.version import __version__

if TYPE_CHECKING:
    # A second of import, which --help does not need.
    from percuss.cli.terminal import ProgressBar
    from percuss.studies.running import StudyResult
    from percuss.studies.study import Study

BAD_INPUT, INTERRUPTED, SIGNALLED = 2, 130, 128
# The name and the version of the form of a line of --json, as run.schema.json describes it.
FORM = "percuss-run-1"


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The options of ``percuss run``."""

    out: Path | None = None
    force: bool = False
    store: Path | None = None
    engine: str = "threads"
    certify: int | None = None
    part: str | None = None
    changes: tuple[str, ...] = ()
    is_check: bool = False
    is_quiet: bool = False
    is_json: bool = False


def run_studies(given: Sequence[Path], options: RunOptions) -> int:
    """Run studies, and return the exit status.

    All are read before the first one runs: where one has faults, none does.

    Raises
    ------
    PercussError
        If the options do not fit the studies.
    """
    files = [file for name in given for file in _matching(name)]
    jobs = _Jobs(files, options)
    read = [(file, jobs.read(file)) for file in files]
    if any(study is None for _, study in read):
        return BAD_INPUT
    status = 0
    for file, study in read:
        assert study is not None  # read above
        status = jobs.check(file, study) if options.is_check else jobs.run(file, study) or status
        if status > SIGNALLED:
            break
    return status


def _matching(name: Path) -> list[Path]:
    """Return the files that a pattern stands for, where the shell has left it as it is."""
    text = str(name)
    if any(letter in text for letter in "*?[") and not name.exists():
        root = Path(name.anchor)
        return sorted(root.glob(str(name.relative_to(root)) if name.anchor else text)) or [name]
    return [name]


class _Jobs:
    """The studies of one command."""

    def __init__(self, files: Sequence[Path], options: RunOptions) -> None:
        from percuss.execution import ArrayPart

        self._options = options
        self._part = None if options.part is None else ArrayPart.of(options.part)
        self._has_several = len(files) > 1
        if self._has_several and options.store is not None:
            reason = f"one store for {len(files)} studies; run them one by one, or without a store"
            raise ParameterError("store", str(options.store), reason)
        twice = [stem for stem, n in Counter(file.stem for file in files).items() if n > 1]
        if twice:
            reason = "of this name there are several, whose results would lie in one folder"
            raise ParameterError("study", twice[0], f"{reason}; run them one by one with --out")

    def read(self, file: Path) -> Study | None:
        """Return the study of a file; None after its faults were printed."""
        from percuss.studies.reading import load_study
        from percuss.studies.tables import Certify

        try:
            study = load_study(file, changes=self._options.changes)
        except StudyError as error:
            self._print_error(file, error, "faulty", faults=error.faults)
            return None
        digits = self._options.certify
        return study if digits is None else replace(study, certify=Certify(digits))

    def check(self, file: Path, study: Study) -> int:
        """Report a study that has no faults, without running it."""
        from percuss.studies.running import output_files

        files = () if self._part is not None else output_files(study, self._folder(file))
        if self._options.is_json:
            self._print(file, study, status="valid", files=[str(each) for each in files])
        elif not self._options.is_quiet:
            names = ", ".join(each.name for each in files) or "no files"
            title = f" {study.title!r}," if study.title else ""
            typer.echo(f"{file}: valid,{title} of kind {study.kind}; would write {names}")
        return 0

    def run(self, file: Path, study: Study) -> int:
        """Run a study and report it; return its exit status."""
        from percuss.cli.terminal import ProgressBar, print_report
        from percuss.studies.running import run_study

        options, folder = self._options, self._folder(file)
        bar = ProgressBar(
            study.question.doing,
            of_chunks=study.question.is_ensemble,
            name=self._name(file),
            is_quiet=options.is_quiet,
        )
        with self._printed_errors(file, study) as errors, bar as progress:
            result = run_study(
                study,
                folder,
                command=self._command(file),
                force=options.force,
                store=options.store,
                engine=options.engine,
                part=self._part,
                progress=progress,
                on_write=progress.writing,
            )
        if errors:
            return BAD_INPUT
        if options.is_json:
            self._print_result(file, study, result)
        elif not options.is_quiet:
            print_report(study, result)
        return 0 if result.is_whole else self._interrupted(bar)

    def _interrupted(self, bar: ProgressBar) -> int:
        if self._options.store is not None:
            ended = "ended by SIGTERM" if bar.signal == signal.SIGTERM else "interrupted"
            typer.echo(f"{ended}; the same command goes on with {self._options.store}", err=True)
        return SIGNALLED + bar.signal if bar.signal else INTERRUPTED

    def _folder(self, file: Path) -> Path:
        """Return the folder for the results of a study, one for each of several."""
        own = Path(file.stem)
        if self._options.out is None:
            return own
        return self._options.out / own if self._has_several else self._options.out

    def _name(self, file: Path) -> str:
        part = "" if self._part is None else f"part {self._part}"
        return ", ".join(filter(None, [str(file) if self._has_several else "", part]))

    def _command(self, file: Path) -> str:
        """Return the command that repeats this run alone, for the record in its results."""
        options = self._options
        out = self._folder(file) if options.out is not None else None
        given: Mapping[str, object] = {
            "out": out,
            "force": options.force,
            "store": options.store,
            "engine": None if options.engine == "threads" else options.engine,
            "certify": options.certify,
        }
        words = ["percuss", "run", str(file)]
        for name, value in given.items():
            if value is True:
                words.append(f"--{name}")
            elif value not in (None, False):
                words += [f"--{name}", str(value)]
        for change in options.changes:
            words += ["--set", change]
        return shlex.join(words)

    @contextmanager
    def _printed_errors(self, file: Path, study: Study) -> Iterator[list[PercussError]]:
        """Print the error of one of several studies, and let the others run."""
        errors: list[PercussError] = []
        try:
            yield errors
        except PercussError as error:
            errors.append(error)
            self._print_error(file, error, "failed", study)

    def _print_error(
        self,
        file: Path,
        error: PercussError,
        status: str,
        study: Study | None = None,
        faults: Sequence[Any] = (),
    ) -> None:
        message = str(error)
        if isinstance(error, OutputError):
            folder = self._folder(file)
            advice = f"--force replaces the results in {folder}, --out writes into another folder"
            message = message.replace("force=True replaces it", advice)
        typer.echo(message, err=True)
        if self._options.is_json:
            self._print(
                file, study, status=status, error=message, faults=[_fault(each) for each in faults]
            )

    def _print_result(self, file: Path, study: Study, result: StudyResult) -> None:
        self._print(
            file,
            study,
            status="done" if result.is_whole else "interrupted",
            report=dict(result.report),
            files=[str(each) for each in result.files],
            seconds=result.seconds,
        )

    def _print(self, file: Path, study: Study | None, **more: object) -> None:
        """Print a line of JSON, as run.schema.json describes it."""
        store = self._options.store
        line = {
            "form": FORM,
            "percuss": __version__,
            "study": str(file),
            "kind": None if study is None else study.kind,
            "title": "" if study is None else study.title,
            "store": None if store is None else str(store),
            "part": None if self._part is None else str(self._part),
            "report": {},
            "files": [],
            "seconds": None,
            "error": None,
            "faults": [],
            **more,
        }
        typer.echo(json.dumps(line, ensure_ascii=False))


def _fault(fault: Any) -> dict[str, object]:
    """Return a fault of a study file as JSON has it; one without a place is its sentence."""
    names = ("file", "line", "path", "value", "reason")
    if not hasattr(fault, "reason"):
        return dict(zip(names, (None, None, "", "", str(fault)), strict=True))
    return {name: getattr(fault, name) for name in names}
