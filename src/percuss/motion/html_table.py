"""Tables of results as HTML, as notebooks show them."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Rows that are shown at either end of a longer table.
SHOWN = 5


def html_table(caption: str, columns: Mapping[str, NDArray[Any]]) -> str:
    """Return columns of equal length as an HTML table; of a long one the first and last rows.

    Parameters
    ----------
    caption
        What stands above it.
    columns
        One-dimensional arrays by their names.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> print(html_table("a < b", {"t": np.array([0.5])}))
    <table><caption>a &lt; b</caption><thead><tr><th></th><th>t</th></tr></thead>\
<tbody><tr><th>0</th><td>0.5</td></tr></tbody></table>
    """
    n = len(next(iter(columns.values())))
    rows = range(n) if n <= 2 * SHOWN + 1 else [*range(SHOWN), None, *range(n - SHOWN, n)]
    head = "".join(f"<th>{html.escape(name)}</th>" for name in ("", *columns))
    body = "".join(_row(columns, row) for row in rows)
    return (
        f"<table><caption>{html.escape(caption)}</caption>"
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    )


def _row(columns: Mapping[str, NDArray[Any]], row: int | None) -> str:
    if row is None:
        return f"<tr><th>&#8942;</th>{'<td></td>' * len(columns)}</tr>"
    cells = "".join(f"<td>{html.escape(_text(column[row]))}</td>" for column in columns.values())
    return f"<tr><th>{row}</th>{cells}</tr>"


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)
