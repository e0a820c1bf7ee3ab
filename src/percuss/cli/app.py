"""The commands and their options; each loads what it needs when it is called."""

from __future__ import annotations

import io
import shlex
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from percuss.cli.faults import INTERRUPTED, faults_on_stderr
from percuss.cli.page import serve
from percuss.cli.stores import export, status
from percuss.errors import OutputError
from percuss.studies.templates import template_names, template_text, template_title
from percuss.version import __version__

app = typer.Typer(
    name="percuss",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        # A title may hold letters that the terminal's code page lacks: they are replaced.
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="replace")
    app(prog_name="percuss")


def _print_version(is_wanted: bool) -> None:
    if is_wanted:
        typer.echo(f"percuss {__version__}")
        raise typer.Exit


@app.callback()
def percuss(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show the version and exit.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Exact motion of oscillators that hit stops, soft or rigid."""


@app.command()
def run(
    study: Annotated[
        Path,
        typer.Argument(help="A study file (TOML), or a file of an earlier run, to repeat it."),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Folder for the results; default: the study's name."),
    ] = None,
    *,
    force: Annotated[
        bool, typer.Option("--force", "-f", help="Replace the files of an earlier run.")
    ] = False,
    store: Annotated[
        Path | None,
        typer.Option(
            "--store",
            help="Zarr store of a study of many motions: interrupted, the same command goes on.",
        ),
    ] = None,
    engine: Annotated[
        str,
        typer.Option("--engine", help="threads, processes or a Dask scheduler's tcp://host:port."),
    ] = "threads",
    certify: Annotated[
        int | None,
        typer.Option(
            "--certify",
            metavar="DIGITS",
            help="Prove the motion, the orbit or the special points of a branch to these digits.",
        ),
    ] = None,
) -> None:
    """Run a study and write NetCDF, CSV and pictures."""
    folder = Path(study.stem) if out is None else out
    instead = f"--force replaces the results in {folder}, --out writes into another folder"
    with faults_on_stderr(instead=instead):
        from percuss.cli.progress_bar import ProgressBar
        from percuss.cli.report import print_report
        from percuss.studies.reading import load_study
        from percuss.studies.study import Certify

        given = {"out": out, "force": force, "store": store, "engine": engine, "certify": certify}
        command = _command(study, given)
        asked = load_study(study)
        if certify is not None:
            asked = replace(asked, certify=Certify(certify))
        # Only now: what draws and saves takes a second to import.
        from percuss.studies.running import run_study

        with ProgressBar(asked.question.doing, of_chunks=asked.question.is_ensemble) as watch:
            result = run_study(
                asked,
                folder,
                command=command,
                force=force,
                store=store,
                engine=engine,
                progress=watch,
                on_write=watch.writing,
            )
        print_report(asked, result)
        if not result.is_whole and store is not None:
            typer.echo(f"interrupted; the same command goes on with {store}", err=True)
    if not result.is_whole:
        raise typer.Exit(INTERRUPTED)


def _command(study: Path, given: Mapping[str, object]) -> str:
    """Return the command line of a run, as it is kept with its results."""
    options: list[str] = []
    for name, value in given.items():
        if value is True:
            options.append(f"--{name}")
        elif value not in (None, False) and (name, value) != ("engine", "threads"):
            options += [f"--{name}", str(value)]
    return shlex.join(["percuss", "run", str(study), *options])


@app.command()
def paper(
    *,
    only: Annotated[
        str | None,
        typer.Option("--only", help="Figures and statements, as fig6,table2,eq12; default: all."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the report.")] = Path(
        "percuss-paper"
    ),
    force: Annotated[
        bool, typer.Option("--force", "-f", help="Write into a folder that is not empty.")
    ] = False,
) -> None:
    """Recompute Dyskin, Pasternak & Pelinovsky (2012) and judge it, statement by statement."""
    with faults_on_stderr(f"the finished figures are in {out}, without a report"):
        from percuss.cli.progress_bar import ProgressBar
        from percuss.cli.verdicts import print_verdicts
        from percuss.paper.run import run_paper

        options = ["--only", only] if only is not None else []
        options += ["--out", str(out), *(["--force"] if force else [])]
        command = shlex.join(["percuss", "paper", *options])
        with ProgressBar("recomputing the paper") as watch:
            result = run_paper(out, only=only, command=command, force=force, progress=watch)
        print_verdicts(result)
    if result.is_interrupted:
        raise typer.Exit(INTERRUPTED)
    if result.missing:
        raise typer.Exit(1)


@app.command()
def new(
    path: Annotated[Path, typer.Argument(help="The file to write.")] = Path("study.toml"),
    *,
    template: Annotated[
        str,
        typer.Option(
            "--template",
            "-t",
            help=f"What to begin with: {', '.join(template_names())}; or a kind of study.",
        ),
    ] = "impact",
    show_list: Annotated[
        bool, typer.Option("--list", "-l", help="List the templates and write nothing.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", "-f", help="Replace the file.")] = False,
) -> None:
    """Write a commented study file to begin with."""
    with faults_on_stderr():
        from percuss.io.files import OutputFiles

        if show_list:
            for name in template_names():
                typer.echo(f"{name:<12}{template_title(name)}")
            return
        text = template_text(template)
        if not path.parent.is_dir():
            raise OutputError(path.parent, "no such folder; make it first")
        with OutputFiles(path, force=force) as files:
            files[path].write_text(text, encoding="utf-8")
        typer.echo(f"wrote {path}; run it with: percuss run {shlex.quote(str(path))}")


app.command()(status)
app.command()(export)
app.command()(serve)
