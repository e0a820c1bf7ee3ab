"""A figure as files: its picture as PNG and SVG, its data as NetCDF and CSV."""

from __future__ import annotations

import csv
import platform
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from percuss.ensembles.datasets import write_whole
from percuss.io.figures import write_figure
from percuss.io.files import OutputFiles
from percuss.io.record import Record
from percuss.io.study_text import toml_text
from percuss.paper.figure import Figure
from percuss.version import __version__

if TYPE_CHECKING:
    from xarray import Dataset

SUFFIXES = (".svg", ".png", ".nc", ".csv")
PACKAGES = ("numpy", "numba", "xarray", "matplotlib")


@dataclass(frozen=True)
class Drawn:
    """A figure that has been drawn and written.

    Parameters
    ----------
    name, title, caption
        Of the figure.
    files
        What was written, by `SUFFIXES`.
    """

    name: str
    title: str
    caption: str
    files: tuple[Path, ...]


def versions() -> dict[str, str]:
    """Return the versions of what computes and draws.

    Examples
    --------
    >>> list(versions())[:2]
    ['percuss', 'python']
    """
    packages = {package: metadata.version(package) for package in PACKAGES}
    return {"percuss": __version__, "python": platform.python_version(), **packages}


def draw_figure(figure: Figure, folder: Path, command: str) -> Drawn:
    """Compute and draw a figure, and write its four files together or not at all.

    Parameters
    ----------
    figure
        The figure.
    folder
        Where to write; files of the same names are replaced.
    command
        The command, which stands in each file with the versions and the parameters.

    Returns
    -------
    Drawn
        The caption and the files.
    """
    import matplotlib as mpl

    data = figure.compute()
    caption = figure.full_caption(data)
    record = _record(figure, data, command)
    paths = [folder / f"{figure.name}{suffix}" for suffix in SUFFIXES]
    # The same figure gives the same names inside its SVG.
    with mpl.rc_context({"svg.hashsalt": "percuss"}), OutputFiles(*paths, force=True) as files:
        picture = figure.draw(data)
        for path in paths[:2]:
            write_figure(picture, files[path], path.suffix, record)
            # Both pictures are laid out alike: once is enough.
            picture.set_layout_engine("none")
        _write_netcdf(figure, data, caption, files[paths[2]], record)
        _write_csv(data, files[paths[3]], record)
    return Drawn(figure.name, figure.title, caption, tuple(paths))


def _record(figure: Figure, data: Dataset, command: str) -> Record:
    """Return what each file says of itself: the figure and its parameters instead of a study."""
    names = (name for name in data.attrs if not name.startswith("study_"))
    parameters = {name: _plain(data.attrs[name]) for name in names}
    what = {"name": figure.name, "title": figure.title, **parameters}
    return Record(
        study=toml_text({"figure": what}),
        command=command,
        date=datetime.now(UTC).isoformat(timespec="seconds"),
        outcome="",
        versions=tuple(versions().items()),
    )


def _plain(value: object) -> object:
    return value.item() if isinstance(value, np.generic) else value


def _write_netcdf(figure: Figure, data: Dataset, caption: str, path: Path, record: Record) -> None:
    attributes = {
        "title": f"{figure.name}: {figure.title}",
        "caption": caption,
        "record": record.text(),
        "command": record.command,
        "date": record.date,
        **{f"{name}_version": version for name, version in record.versions},
    }
    write_whole(data.assign_attrs(attributes), path)


def _write_csv(data: Dataset, path: Path, record: Record) -> None:
    """Write every variable as a column, side by side; shorter columns end early."""
    columns = {}
    for name, variable in data.variables.items():
        values = np.atleast_1d(variable.values)
        rows = values if values.ndim > 1 else values[np.newaxis]
        for i, row in enumerate(rows):
            columns[str(name) if len(rows) == 1 else f"{name}[{i}]"] = row.tolist()
    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {line}".rstrip() + "\n" for line in record.text().splitlines())
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        table.writerows(zip_longest(*columns.values(), fillvalue=""))
