"""The commands for stores of many motions: how far one has come, and what it holds."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from percuss.cli.faults import faults_on_stderr
from percuss.errors import ParameterError

StorePath = Annotated[Path, typer.Argument(help="The folder of a store, such as run.zarr.")]


def status(store: StorePath) -> None:
    """Show how much of a store is done, at what rate, and how long the rest takes.

    Of a folder with several stores each is shown by itself.
    """
    with faults_on_stderr():
        from percuss.ensembles import status_of_store
        from percuss.ensembles.stored import stores_in

        for i, one in enumerate(stores_in(store)):
            if i > 0:
                typer.echo("")
            for name, text in _rows(one, status_of_store(one)).items():
                typer.echo(f"{name:<12}{text}")


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
        from percuss.io.netcdf import DATA

        savers = {".nc": save_netcdf, ".csv": save_csv}
        if file.suffix not in savers:
            raise ParameterError("file", str(file), "neither .nc (NetCDF) nor .csv")
        found = load_store(store)
        command = shlex.join(["percuss", "export", str(store), str(file)])
        savers[file.suffix](found, file, command=command, force=force)
        part = "" if found.attrs["complete"] else ", of which a part is not done yet"
        typer.echo(f"wrote {file}: {_size(found)}{part}")
        if file.suffix == ".nc":
            typer.echo(
                "percuss.load_netcdf reads it; for other programs the data lie in the group "
                f"/{DATA}: xarray.open_dataset({str(file)!r}, group={DATA!r})"
            )


def _size(found: Any) -> str:
    return " x ".join(f"{length:,} {name}" for name, length in found.sizes.items())


def _rows(store: Path, status: dict[str, Any]) -> dict[str, str]:
    """Return what is shown, by its name."""
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
