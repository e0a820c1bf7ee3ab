"""The commands and their options; each imports what it needs when it is called."""

from __future__ import annotations

import io
import shlex
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from percuss.errors import OutputError, ParameterError, PercussError
from percuss.studies.templates import template_names, template_text, template_title
from percuss.version import __version__

BAD_INPUT = 2
INTERRUPTED = 130

TEMPLATE_HELP = f"What to begin with: {', '.join(template_names())}; or a kind of study."

StudyFile = Annotated[
    Path,
    typer.Argument(help="A study file (TOML), or a file of an earlier run, to repeat it."),
]
FolderOption = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="Folder for the results; default: the study's name."),
]
StoreOption = Annotated[
    Path | None,
    typer.Option(
        "--store",
        help="Zarr store of a study of many motions: interrupted, the same command goes on.",
    ),
]
EngineOption = Annotated[
    str,
    typer.Option("--engine", help="threads, processes or a Dask scheduler's tcp://host:port."),
]
DigitsOption = Annotated[
    int | None,
    typer.Option(
        "--certify",
        metavar="DIGITS",
        help="Prove the motion, the orbit or the special points of a branch to these digits.",
    ),
]
StorePath = Annotated[Path, typer.Argument(help="The folder of a store, such as run.zarr.")]

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
        # Letters of a title that the code page of the terminal lacks are replaced.
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="replace")
    app(prog_name="percuss")


@contextmanager
def faults_on_stderr(
    written: str = "nothing was written", instead: str = "--force replaces it"
) -> Iterator[None]:
    """Turn the errors of percuss into one line a fault and the exit status 2.

    `instead` is the advice where a file exists already.
    """
    try:
        with warnings.catch_warnings():
            # The sentence alone, without the place in the code.
            warnings.showwarning = lambda message, *_: typer.echo(f"warning: {message}", err=True)
            yield
    except PercussError as error:
        message = str(error)
        if isinstance(error, OutputError):
            message = message.replace("force=True replaces it", instead)
        typer.echo(message, err=True)
        raise typer.Exit(BAD_INPUT) from error
    except KeyboardInterrupt as error:
        typer.echo(f"interrupted; {written}", err=True)
        raise typer.Exit(INTERRUPTED) from error


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
    study: StudyFile,
    out: FolderOption = None,
    *,
    force: Annotated[
        bool, typer.Option("--force", "-f", help="Replace the files of an earlier run.")
    ] = False,
    store: StoreOption = None,
    engine: EngineOption = "threads",
    certify: DigitsOption = None,
) -> None:
    """Run a study and write NetCDF, CSV and pictures."""
    folder = Path(study.stem) if out is None else out
    instead = f"--force replaces the results in {folder}, --out writes into another folder"
    with faults_on_stderr(instead=instead):
        from percuss.cli.terminal import ProgressBar, print_report
        from percuss.studies.reading import load_study
        from percuss.studies.tables import Certify

        given = {"out": out, "force": force, "store": store, "engine": engine, "certify": certify}
        command = _command(study, given)
        asked = load_study(study)
        if certify is not None:
            asked = replace(asked, certify=Certify(certify))
        # Only now: drawing and saving take a second to import.
        from percuss.studies.running import run_study

        with ProgressBar(asked.question.doing, of_chunks=asked.question.is_ensemble) as progress:
            result = run_study(
                asked,
                folder,
                command=command,
                force=force,
                store=store,
                engine=engine,
                progress=progress,
                on_write=progress.writing,
            )
        print_report(asked, result)
        if not result.is_whole and store is not None:
            typer.echo(f"interrupted; the same command goes on with {store}", err=True)
    if not result.is_whole:
        raise typer.Exit(INTERRUPTED)


def _command(study: Path, given: Mapping[str, object]) -> str:
    """Return the command line of a run, for the record in its results."""
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
    """Recompute Dyskin, Pasternak & Pelinovsky (2012) and judge it, statement by statement.

    Its records have studies, such as studies/eq27.toml, for percuss run and percuss serve.
    """
    with faults_on_stderr(f"the finished figures are in {out}, without a report"):
        from percuss.cli.terminal import ProgressBar, print_verdicts
        from percuss.paper.run import run_paper

        options = ["--only", only] if only is not None else []
        options += ["--out", str(out), *(["--force"] if force else [])]
        command = shlex.join(["percuss", "paper", *options])
        with ProgressBar("recomputing the paper") as progress:
            result = run_paper(out, only=only, command=command, force=force, progress=progress)
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
            help=TEMPLATE_HELP,
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


@app.command()
def status(store: StorePath) -> None:
    """Show how much of a store is done, at what rate, and how long the rest takes.

    Of a folder with several stores each is shown by itself.
    """
    with faults_on_stderr():
        from percuss.ensembles import status_of_store
        from percuss.ensembles.stored import stores_in

        for i, path in enumerate(stores_in(store)):
            if i > 0:
                typer.echo("")
            for name, text in _rows(path, status_of_store(path)).items():
                typer.echo(f"{name:<12}{text}")


@app.command()
def export(
    store: StorePath,
    file: Annotated[Path, typer.Argument(help="The file to write: .nc or .csv.")],
    *,
    force: Annotated[bool, typer.Option("--force", "-f", help="Replace the file.")] = False,
) -> None:
    """Write what a store holds, finished or not, as NetCDF or CSV."""
    with faults_on_stderr():
        from percuss.ensembles import load_store
        from percuss.io import save_csv, save_netcdf

        savers = {".nc": save_netcdf, ".csv": save_csv}
        if file.suffix not in savers:
            raise ParameterError("file", str(file), "neither .nc (NetCDF) nor .csv")
        data = load_store(store)
        command = shlex.join(["percuss", "export", str(store), str(file)])
        savers[file.suffix](data, file, command=command, force=force)
        part = "" if data.attrs["complete"] else ", of which a part is not done yet"
        typer.echo(f"wrote {file}: {_size(data)}{part}")
        if file.suffix == ".nc":
            typer.echo(f"percuss.load_netcdf and xarray.open_dataset({str(file)!r}) read it")


def _size(data: Any) -> str:
    return " x ".join(f"{length:,} {name}" for name, length in data.sizes.items())


def _rows(store: Path, status: dict[str, Any]) -> dict[str, str]:
    """Return the lines of a status by their names."""
    from percuss.progress import duration_text

    study = status["study"]
    what = ", ".join(study.get("measure", [])) or str(study["kind"]).split(",")[0]
    over = " x ".join(f"{path} ({len(values)})" for path, values in study["over"].items())
    done, total = status["points_done"], status["points"]
    rows = {
        "store": f"{store}, begun by percuss {status['version']}",
        "study": f"{what} over {over}",
        "done": f"{done / total:.1%}: {done:,} of {total:,} points, "
        f"{status['done']:,} of {status['chunks']:,} chunks",
        "impacts": f"{status['n_impacts']:,}",
    }
    if status["impacts_per_second"] is not None:
        rows["impacts"] += f", {status['impacts_per_second']:,.0f} a second"
    if done == total:
        rows["time left"] = "none, it is complete"
    elif status["seconds_left"] is not None:
        left = f"{duration_text(status['seconds_left'])} at the rate of the last chunks"
        if status["running"] is False:
            rows["not running"] = f"as it seems; the rest would take {left}"
        else:
            rows["time left"] = f"{left}, if it is running"
    if done < total and status["seconds_since"] is not None:
        rows["last chunk"] = f"{duration_text(status['seconds_since'])} ago"
    return rows


@app.command()
def serve(
    study: Annotated[
        Path | None,
        typer.Argument(help="A study to begin with: a motion, diagram, response or basins."),
    ] = None,
    *,
    host: Annotated[
        str, typer.Option("--host", help="Address to listen at; the default is this machine only.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", "-p", help="Port; 0: any that is free.")] = 8765,
    report: Annotated[
        Path | None, typer.Option("--report", help="Folder of a report of percuss paper.")
    ] = None,
    no_open: Annotated[bool, typer.Option("--no-open", help="Open no browser.")] = False,
) -> None:
    """Open the workbench: sliders, diagrams and basins in the browser."""
    with faults_on_stderr("the page is closed"):
        from percuss.studies.link import link_of
        from percuss.studies.reading import load_study
        from percuss.web.serve import serve as serve_page

        link = "" if study is None else link_of(load_study(study))
        serve_page(host, port, report=report, link=link, open_page=not no_open, say=_say)


@app.command()
def site(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the files.")] = Path("site"),
    *,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that is not empty.")
    ] = False,
) -> None:
    """Write the workbench as static files, which need no server: for a web host or a stick."""
    with faults_on_stderr("nothing is written"):
        from percuss.web.site import write_site

        files = write_site(out, force=force)
        size = sum(file.stat().st_size for file in files)
        _say(f"{files[0]} ({size / 1e6:.1f} MB with all that belongs to it); open it in a browser")


def _say(text: str) -> None:
    # Without delay, also into a pipe: the program that starts the page waits for its address.
    print(text, flush=True)  # noqa: T201
