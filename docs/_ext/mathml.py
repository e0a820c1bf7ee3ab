"""Formulas as MathML, which browsers draw by themselves: no script, no network, no TeX."""

from __future__ import annotations

from typing import Any, Literal

from docutils import nodes
from formulas import mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator


def visit_inline(writer: HTML5Translator, node: nodes.Element) -> None:
    """Write a formula in a line."""
    writer.body.append(_written(node, "inline"))
    raise nodes.SkipNode


def visit_block(writer: HTML5Translator, node: nodes.Element) -> None:
    """Write a formula of its own."""
    writer.body.append('<div class="math">' + _written(node, "block") + "</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Make the renderer known."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _written(node: nodes.Element, display: Literal["inline", "block"]) -> str:
    try:
        return mathml(node.astext(), display)
    except Exception as error:  # noqa: BLE001  the converter has errors of many kinds
        message = "formula not written: %s: %s"
        logging.getLogger(__name__).warning(message, node.astext(), error, location=node)
        return ""
