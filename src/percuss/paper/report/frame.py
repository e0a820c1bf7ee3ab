"""The frame of every page of the report: head, style, links to the other pages, foot."""

from __future__ import annotations

from datetime import UTC, datetime
from html import escape
from importlib import resources
from string import Template

from percuss.paper.article import article_source
from percuss.paper.figure_files import versions
from percuss.paper.report.formulas import glyphs


def part(name: str) -> str:
    """Return a file of this folder as text."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def framed(title: str, body: str, scripts: tuple[str, ...] = (), made: str = "") -> str:
    """Return a page that needs nothing from the network.

    Parameters
    ----------
    title
        Its heading, in plain words.
    body
        HTML of its contents.
    scripts
        JavaScript, each a script of its own.
    made
        HTML of a sentence on how the page was made, for its foot.
    """
    source = article_source()
    return Template(part("frame.html")).substitute(
        title=escape(title),
        style=part("page.css"),
        citation=escape(source.citation),
        doi=escape(source.doi),
        version=escape(versions()["percuss"]),
        date=datetime.now(UTC).strftime("%d %B %Y"),
        body=f"{glyphs(body)}{body}",
        made=made,
        scripts="".join(f"<script>{script}</script>" for script in scripts),
    )
