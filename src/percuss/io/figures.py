"""Pictures as files, with the record of their run in the metadata."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

from percuss.errors import OutputError
from percuss.io.files import OutputFiles
from percuss.io.record import PNG_KEYWORD, Record, make_record


class SavableFigure(Protocol):
    """A figure of matplotlib, which this layer does not import."""

    def savefig(self, fname: Path, **kwargs: Any) -> None:
        """Write the figure to a file."""


def save_figure(
    figure: SavableFigure,
    path: Path | str,
    *,
    run: Any,
    study: str | None = None,
    command: str | None = None,
    force: bool = False,
    dpi: float = 200.0,
) -> None:
    """Save a figure as PNG or SVG with the record of its run in the metadata.

    Parameters
    ----------
    figure
        A figure of matplotlib.
    path
        The file; its suffix, ``.png`` or ``.svg``, is the format.
    run
        The run in the picture, or another result that can be saved.
    study, command
        As in `percuss.io.make_record`.
    force
        Whether a file of that name may be replaced.
    dpi
        Pixels per inch of a PNG and of the rasterised parts of an SVG.

    Raises
    ------
    OutputError
        If the format is another one, the file exists and `force` is false, or the file cannot be
        written.
    """
    if Path(path).suffix.lower() not in (".png", ".svg"):
        raise OutputError(path, "neither .png nor .svg; choose one of these formats")
    with OutputFiles(path, force=force) as files:
        write_figure(
            figure,
            files[path],
            Path(path).suffix,
            make_record(run, study=study, command=command),
            dpi=dpi,
        )


def write_figure(
    figure: SavableFigure, path: Path, suffix: str, record: Record, *, dpi: float = 200.0
) -> None:
    """Write a picture in the format of `suffix` under the name `path`."""
    creator = f"percuss {dict(record.versions)['percuss']}"
    if suffix.lower() == ".png":
        metadata = {PNG_KEYWORD: record.text(), "Software": creator, "Creation Time": record.date}
    else:
        metadata = {"Description": record.text(), "Creator": creator, "Date": record.date}
    figure.savefig(path, format=suffix.lower()[1:], dpi=dpi, metadata=metadata)
