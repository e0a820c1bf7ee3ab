"""Formulas as MathML, which browsers draw by themselves: no script, no network, no TeX."""

from __future__ import annotations

from typing import Any, Literal

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator


def mathml(text: str, display: Literal["inline", "block"]) -> str:
    r"""Return a formula as MathML.

    A command that is not known raises ValueError; the converter would show it as it stands.
    """
    found = convert(text, display=display)
    if "\\" in found:
        command = found[found.index("\\") :].split("<")[0]
        raise ValueError(f"{command} is not known to the converter")
    return found


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
    except Exception as error:  # the converter has errors of many kinds
        message = "formula not written: %s: %s"
        logging.getLogger(__name__).warning(message, node.astext(), error, location=node)
        return ""
