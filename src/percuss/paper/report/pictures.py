"""Figures in the report: in full with their caption, and as small pictures."""

from __future__ import annotations

import base64
from html import escape
from io import BytesIO
from pathlib import Path

from percuss.paper.figure_files import Drawn
from percuss.paper.report.prose import prose

# A larger SVG would make the page slow on a telephone: its PNG stands there instead [bytes].
LARGEST_SVG = 260_000
# Least width of a small picture in pixels, twice what it takes on the page for fine screens, and
# its height over its width: of figures of several panels it shows the first.
THUMBNAIL = 200
FLAT = 0.62
NETCDF = ".nc"


def is_of_article(name: str) -> bool:
    """Return whether a figure is one of the article's."""
    return name.startswith("fig")


def figure_element(drawn: Drawn) -> str:
    """Return a figure with its caption and its files."""
    heading = f"Figure {drawn.name.removeprefix('fig')}. " if is_of_article(drawn.name) else ""
    links = ", ".join(f'<a href="{escape(file.name)}">{_format(file)}</a>' for file in drawn.files)
    alt = escape(f"{heading}{drawn.title}", quote=True)
    return (
        f'<figure id="figure-{escape(drawn.name)}"><img src="{_picture(drawn)}" '
        f'alt="{alt}"><figcaption><strong>{escape(heading)}{prose(drawn.title)}.</strong> '
        f'{prose(drawn.caption)} <span class="files">{links}</span></figcaption></figure>'
    )


def thumbnail(drawn: Drawn) -> str:
    """Return a small picture of the upper part of a figure as an image of the page."""
    from matplotlib import image

    full = image.imread(_file(drawn, ".png"))
    step = max(1, full.shape[1] // THUMBNAIL)
    height, width = int(FLAT * full.shape[1]) // step, full.shape[1] // step
    height = min(height, full.shape[0] // step)
    upper = full[: height * step, : width * step]
    # Each pixel is the mean of those that it replaces.
    blocks = upper.reshape(height, step, width, step, -1)
    small = BytesIO()
    image.imsave(small, blocks.mean(axis=(1, 3)), format="png")
    data = base64.b64encode(small.getvalue()).decode()
    alt = escape(f"small picture of {drawn.name}: {drawn.title}", quote=True)
    return f'<img class="thumbnail" src="data:image/png;base64,{data}" alt="{alt}">'


def _format(file: Path) -> str:
    return "NetCDF" if file.suffix == NETCDF else file.suffix[1:].upper()


def _file(drawn: Drawn, suffix: str) -> Path:
    return next(file for file in drawn.files if file.suffix == suffix)


def _picture(drawn: Drawn) -> str:
    """Return the picture as a data address: the SVG, or the PNG where that is too large."""
    svg = _file(drawn, ".svg").read_bytes()
    if len(svg) <= LARGEST_SVG:
        return f"data:image/svg+xml;base64,{base64.b64encode(svg).decode()}"
    return f"data:image/png;base64,{base64.b64encode(_file(drawn, '.png').read_bytes()).decode()}"
