"""Notebooks run by a kernel of their own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import nbformat
from nbclient import NotebookClient
from tests.loops import run


def executed(cells: Iterable[str]) -> list[Any]:
    """Return the cells of a notebook with what they show."""
    notebook = nbformat.v4.new_notebook(  # type: ignore[no-untyped-call]
        cells=[nbformat.v4.new_code_cell(text) for text in cells]  # type: ignore[no-untyped-call]
    )
    run(NotebookClient(notebook, timeout=300).async_execute(), wait=600)
    return list(notebook.cells)
