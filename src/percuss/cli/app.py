"""The commands and their options; each imports what it needs when it is called."""

from __future__ import annotations

import io
import os
import shlex
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from percuss.errors import OutputError, ParameterError, PercussError
from percuss.studies.templates import template_names, template_text, template_title
from percuss.version import __version__

BAD_INPUT = 2
# As shells have it: 128 and the number of the signal.
INTERRUPTED, TERMINATED = 130, 143

TEMPLATE_HELP = f"What to begin with: {', '.join(template_names())}; or a kind of study."

StudyFiles = Annotated[
    list[Path],
    typer.Argument(
        metavar="STUDY...", help="Study files (TOML), or files of earlier runs, to repeat them."
    ),
]
FolderOption = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="Folder for the results; default: the study's name."),
]
StoreOption = Annotated[
    Path | None,
    typer.Option(
        "--store",
        help="Store of a study of many motions, or file of a fit: interrupted, the same command goes on.",
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
PartOption = Annotated[
    str | None,
    typer.Option(
        "--part",
        metavar="I/N",
        help="Compute part I of N into STORE.parts, for a job array; then: percuss merge STORE.",
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help="A value in place of that of the file, as oscillator.damping=0.1; may be repeated.",
    ),
]
CheckOption = Annotated[
    bool, typer.Option("--check", help="Read the studies, list their faults, and run nothing.")
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Show faults and warnings only.")]
VerboseOption = Annotated[
    bool, typer.Option("--verbose", "-v", help="Log each step, as Python's logging has it.")
]
JsonOption = Annotated[
    bool,
    typer.Option("--json", help="Print a line of JSON a study; percuss schema run describes it."),
]
StorePath = Annotated[Path, typer.Argument(help="The folder of a store, such as run.zarr.")]

app = typer.Typer(
    name="percuss",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main() -> None:
    """Run the command line."""
    # A program that was begun without a stream writes into nothing.
    sys.stdout, sys.stderr = sys.stdout or _nothing(), sys.stderr or _nothing()
    for stream in (sys.stdout, sys.stderr):
        # Letters of a title that the code page of the terminal lacks are replaced.
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="replace")
    try:
        app(prog_name="percuss")
    except OSError as error:
        words = (error.strerror or str(error)).lower()
        if isinstance(error.filename, str | bytes | os.PathLike):
            sys.exit(f"{os.fsdecode(error.filename)}: {words}")
        # Of the stream, to which nothing more is written.
        with _nothing() as nothing:
            os.dup2(nothing.fileno(), 1)
        sys.exit(f"the output cannot be written: {words}")


def _nothing() -> TextIO:
    return Path(os.devnull).open("w", encoding="utf-8")


@contextmanager
def faults_on_stderr(written: str = "nothing was written") -> Iterator[None]:
    """Turn the errors of percuss into one line a fault and the exit status 2."""
    try:
        with warnings.catch_warnings():
            # The sentence alone, without the place in the code.
            warnings.showwarning = lambda message, *_: typer.echo(f"warning: {message}", err=True)
            yield
    except PercussError as error:
        message = str(error)
        if isinstance(error, OutputError):
            message = message.replace("force=True", "--force")
        typer.echo(message, err=True)
        raise typer.Exit(BAD_INPUT) from error
    except KeyboardInterrupt as error:
        by_term = type(error) is not KeyboardInterrupt
        typer.echo(f"{'ended by SIGTERM' if by_term else 'interrupted'}; {written}", err=True)
        raise typer.Exit(TERMINATED if by_term else INTERRUPTED) from error


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
    studies: StudyFiles,
    out: FolderOption = None,
    *,
    force: Annotated[
        bool, typer.Option("--force", "-f", help="Replace the files of an earlier run.")
    ] = False,
    changes: SetOption = None,
    store: StoreOption = None,
    part: PartOption = None,
    engine: EngineOption = "threads",
    certify: DigitsOption = None,
    check: CheckOption = False,
    quiet: QuietOption = False,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run studies and write NetCDF, CSV and pictures, each into a folder of its name."""
    with faults_on_stderr():
        from percuss.cli.run_studies import RunOptions, run_studies

        _log_to_stderr(is_verbose=verbose)
        options = RunOptions(
            out, force, store, engine, certify, part, tuple(changes or ()), check, quiet, as_json
        )
        status = run_studies(studies, options)
    raise typer.Exit(status)


@app.command()
def prove(
    study: Annotated[
        Path,
        typer.Argument(metavar="STUDY", help="A study of a motion, an orbit, a branch or basins."),
    ],
    *,
    chaos: Annotated[
        bool,
        typer.Option("--chaos", help="Prove that motions of the study's system are chaotic."),
    ] = False,
    orbits: Annotated[
        tuple[int, int] | None,
        typer.Option(
            "--list",
            metavar="IMPACTS PERIODS",
            help="Find all orbits of the study's system with so many impacts in so many periods.",
        ),
    ] = None,
    speeds: Annotated[
        tuple[str, str] | None,
        typer.Option(
            metavar="LEAST GREATEST",
            help="With --list: speeds after impacts; default: about those of the orbits found.",
        ),
    ] = None,
    point: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER",
            help="Prove this special point of the study's branch by itself, the first is 1.",
        ),
    ] = None,
    digits: Annotated[int, typer.Option("--digits", help="Digits of the enclosures.")] = 15,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="The file; default: STUDY.certificate.json."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", "-f", help="Replace the file.")] = False,
    changes: SetOption = None,
    quiet: QuietOption = False,
) -> None:
    """Prove a study's motion, orbit, branch or basins, chaos or all orbits, and write a certificate.

    Others can check it: tools/check_certificate of the sources does so without percuss.
    """
    with faults_on_stderr():
        from percuss.cli.terminal import ProgressBar
        from percuss.io import check_output, save_certificate
        from percuss.studies.proving import proven
        from percuss.studies.reading import load_study

        file = out if out is not None else study.with_suffix(".certificate.json")
        check_output([file], force=force)
        with ProgressBar("proving", is_quiet=quiet) as progress:
            given = load_study(study, changes=tuple(changes or ()))
            asked: dict[str, Any] = {"orbits": orbits, "speeds": speeds, "point": point}
            result = proven(given, digits, progress, chaos=chaos, **asked)
            # Of what was not proven to its end there is no certificate.
            progress.raise_if_stopped()
        typer.echo(result)
        save_certificate(result, file, force=force)
        checked = f"python tools/check_certificate {shlex.quote(str(file))}"
        typer.echo(f"wrote {file}; check it with: {checked}")


def _log_to_stderr(*, is_verbose: bool) -> None:
    """Show warnings of the library as its sentences, and where wanted each step with its time."""
    import logging

    logger = logging.getLogger("percuss")
    handler = logging.StreamHandler()
    form = "%(asctime)s %(levelname)s %(name)s: %(message)s" if is_verbose else "%(message)s"
    handler.setFormatter(logging.Formatter(form))
    # In one process, as tests have it, there may be one of an earlier call.
    logger.handlers[:] = [handler]
    logger.setLevel(logging.INFO if is_verbose else logging.WARNING)


@app.command()
def merge(
    store: Annotated[Path, typer.Argument(help="The store that was given to all parts.")],
    *,
    quiet: QuietOption = False,
) -> None:
    """Put the parts of a job array together into one store."""
    with faults_on_stderr("the same command goes on"):
        from percuss.cli.terminal import ProgressBar
        from percuss.ensembles import merge_parts

        with ProgressBar("merging", of_chunks=True, is_quiet=quiet) as progress:
            n_points = merge_parts(store, progress=progress)
        if not quiet:
            typer.echo(
                f"merged {n_points:,} points into {store}; percuss run STUDY --store "
                f"{shlex.quote(str(store))} writes the results, and {store}.parts is not needed "
                "any more"
            )


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
        raise typer.Exit(128 + progress.signal if progress.signal else INTERRUPTED)
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
            names = template_names()
            width = max(map(len, names)) + 2
            for name in names:
                typer.echo(f"{name:<{width}}{template_title(name)}")
            return
        text = template_text(template)
        if not path.parent.is_dir():
            raise OutputError(path.parent, "no such folder; make it first")
        with OutputFiles(path, force=force) as files:
            files[path].write_text(text, encoding="utf-8")
        typer.echo(f"wrote {path}; run it with: percuss run {shlex.quote(str(path))}")
        if path.name != template and path.name in template_names():
            other = f"percuss new {path.name}.toml -t {path.name}"
            typer.echo(f"it is of the template {template}; that of {path.name}: {other}")


@app.command()
def status(store: StorePath) -> None:
    """Show how much of a store is done, at what rate, and how long the rest takes.

    Of a folder with several stores each is shown by itself; of a store whose parts are not merged
    yet all parts together.
    """
    with faults_on_stderr():
        from percuss.ensembles import status_of_store
        from percuss.ensembles.stored import stores_in
        from percuss.execution import folder_of_parts

        if not store.exists() and folder_of_parts(store).exists():
            for name, text in _rows_of_parts(store).items():
                typer.echo(f"{name:<12}{text}")
            return
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


def _rows_of_parts(store: Path) -> dict[str, str]:
    """Return how far the parts of a job array are, by the names of the lines."""
    from percuss.ensembles import status_of_store
    from percuss.ensembles.array_parts import parts_of_array
    from percuss.execution import folder_of_parts

    parts = parts_of_array(store)
    states = [status_of_store(part) for part in parts]
    count = int(parts[0].stem.rpartition("-")[2])
    complete = sum(state["points_done"] == state["points"] for state in states)
    done, total = (sum(state[name] for state in states) for name in ("points_done", "points"))
    return {
        "store": f"{folder_of_parts(store)}, which percuss merge {shlex.quote(str(store))} puts "
        "together",
        "parts": f"{len(parts):,} of {count:,} are there, {complete:,} of them complete",
        "done": f"{done / total:.1%}: {done:,} of {total:,} points of these",
        "impacts": f"{sum(state['n_impacts'] for state in states):,}",
    }


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
        typer.Argument(
            help="A study to begin with: a motion, diagram, response, basins, fit, design or sweep "
            "over two parameters."
        ),
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
    report: Annotated[
        Path | None, typer.Option("--report", help="Folder of a report of percuss paper.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", "-f", help="Write into a folder that is not empty.")
    ] = False,
) -> None:
    """Write the workbench as static files, which need no server: for a web host or a stick."""
    with faults_on_stderr("nothing is written"):
        from percuss.web.site import write_site

        files = write_site(out, report=report, force=force)
        size = sum(file.stat().st_size for file in files)
        _say(f"{files[0]} ({size / 1e6:.1f} MB with all that belongs to it); open it in a browser")


@app.command()
def schema(
    name: Annotated[
        str, typer.Argument(help="study: of study files, for editors; run: of percuss run --json.")
    ] = "study",
) -> None:
    """Print the JSON schema of study files, or of the lines of percuss run --json."""
    with faults_on_stderr():
        if name == "study":
            import json

            from percuss.studies.schema import study_schema

            typer.echo(json.dumps(study_schema(), indent=2, ensure_ascii=False))
        elif name == "run":
            from importlib import resources

            file = resources.files("percuss.cli") / "schemas" / "run.schema.json"
            typer.echo(file.read_text(encoding="utf-8"), nl=False)
        else:
            raise ParameterError("name", name, 'neither "study" nor "run"')


@app.command()
def doctor(
    *,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Show versions, cores, caches and optional packages, and how to install what is missing."""
    from percuss.cli.doctor import facts

    rows = facts()
    if as_json:
        import json

        typer.echo(json.dumps(rows, ensure_ascii=False, indent=2))
        return
    for name, text in rows.items():
        typer.echo(f"{name:<12}{text}")


@app.command()
def cite(
    *,
    bibtex: Annotated[bool, typer.Option("--bibtex", help="As an entry of BibTeX.")] = False,
) -> None:
    """Show how to cite percuss."""
    from percuss.cli.citation import bibtex_entry, citation

    typer.echo(bibtex_entry() if bibtex else citation())


def _say(text: str) -> None:
    # Without delay, also into a pipe: the program that starts the page waits for its address.
    print(text, flush=True)  # noqa: T201
