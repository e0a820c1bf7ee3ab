"""The pages of the report: the article, what goes beyond it, and the coverage of the article."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from string import Template

from percuss.paper.article import article_source
from percuss.paper.claim import Claim
from percuss.paper.figure_files import versions
from percuss.paper.report.chain import chain
from percuss.paper.report.coverage import coverage_page
from percuss.paper.report.filters import RecordEntry, counts, failures, records, summary
from percuss.paper.report.frame import framed, part
from percuss.paper.report.front import findings
from percuss.paper.report.pictures import figure_element, is_of_article
from percuss.paper.report.prose import prose
from percuss.paper.report.tables import printed_tables, table_anchors
from percuss.paper.result import PaperResult
from percuss.paper.sections import SECTIONS
from percuss.paper.statement import Scope

TITLE = "Periodic motions and resonances of impact oscillators, recomputed"
# What the page of the article shows only with the records and figures that it needs.
EXPLAINED = ("eq35-constant", "fig10", "fig11")


def pages(result: PaperResult) -> dict[str, str]:
    """Return all pages of the report, by the names of their files.

    Parameters
    ----------
    result
        What came out of the run; its figures are read from their files.

    Returns
    -------
    dict
        HTML without any reference to the network.
    """
    return {
        "index.html": page(result),
        "beyond.html": beyond_page(result),
        "coverage.html": coverage_page(result.claims),
    }


def page(result: PaperResult) -> str:
    """Return the page on the article as HTML."""
    entries = _entries(result, "article")
    claims = [claim for claim, _ in entries]
    source = article_source()
    has_explorer = any(item.name in EXPLAINED for item in result.items)
    parts = {
        "findings": findings(result.claims, result.figures),
        "chain": chain(result.claims),
        "explorer": part("explorer.html") if has_explorer else "",
        "records": records(entries),
        "tables": printed_tables(claims),
        "figures": _figures(result, of_article=True),
    }
    body = Template(part("index.html")).substitute(
        parts,
        warning=_warning(result),
        counts=counts(entries),
        summary=summary(entries),
        failures=failures(entries),
        beyond=_beyond(_entries(result, "beyond")),
        contents=_contents(parts, claims),
        extraction=escape(source.extraction),
        rule=escape(source.rule),
    )
    scripts = (part("page.js"), *([part("explorer.js")] if has_explorer else []))
    return framed(TITLE, body, scripts, _made(result))


def beyond_page(result: PaperResult) -> str:
    """Return the page on what goes beyond the article as HTML."""
    entries = _entries(result, "beyond")
    body = (
        "<p>These statements are not the article's. They say how far its results carry: how fast a "
        "stiff bilinear oscillator tends to the impact oscillator, which other frequencies "
        "resonate, and what losses leave of the resonances. They have counts of their own.</p>"
        f"{counts(entries)}{records(entries)}{_figures(result, of_article=False)}"
    )
    return framed("Beyond the article", body, (part("page.js"),), _made(result))


def _entries(result: PaperResult, scope: Scope) -> list[RecordEntry]:
    """Return the records of a scope in the order of the report, each with its section."""
    return [
        (result.claims[item.name], item.section)
        for item in result.items
        if item.kind == "statement"
        and item.name in result.claims
        and result.claims[item.name].scope == scope
    ]


def _warning(result: PaperResult) -> str:
    if not result.missing:
        return ""
    rows = "".join(
        f"<li><strong>{escape(item.name)}</strong>: {escape(reason)}</li>"
        for item, reason in result.missing.items()
    )
    return (
        f'<div class="warning"><strong>Missing: {len(result.missing)} of {len(result.items)} '
        f"figures and statements.</strong><ul>{rows}</ul></div>"
    )


def _beyond(entries: list[RecordEntry]) -> str:
    """Return the statements that stand on the other page; their anchors are here, too."""
    if not entries:
        return ""
    rows = "".join(
        f'<li id="{escape(claim.id)}"><a href="beyond.html#{escape(claim.id)}">'
        f"{prose(claim.claim)}</a></li>"
        for claim, _ in entries
    )
    noun = "statement goes" if len(entries) == 1 else "statements go"
    return (
        f"<details><summary>{len(entries)} {noun} beyond the article and stand on a page of their "
        f"own.</summary><ul>{rows}</ul></details>"
    )


def _contents(parts: dict[str, str], claims: Sequence[Claim]) -> str:
    titles = {
        "findings": "What was found",
        "reading": "How to read this",
        "chain": "The derivation, line by line",
        "explorer": "Try it: the phase decides",
        "records": "The records",
    }
    entries = [(name, title) for name, title in titles.items() if parts.get(name, "reading")]
    entries += table_anchors(claims)
    entries += [("figures", "The figures")] if parts["figures"] else []
    return "".join(f'<li><a href="#{name}">{prose(title)}</a></li>' for name, title in entries)


def _figures(result: PaperResult, *, of_article: bool) -> str:
    """Return the figures by section, each section with a paragraph on what it is about."""
    parts = []
    for section in SECTIONS:
        shown = "".join(
            figure_element(result.figures[item.name])
            for item in result.items
            if item.section == section.name
            and item.kind == "figure"
            and item.name in result.figures
            and is_of_article(item.name) == of_article
        )
        if shown:
            parts.append(
                f'<h3 class="section">{escape(section.title)}</h3><p>{prose(section.about)}</p>'
                f'<div class="figures">{shown}</div>'
            )
    if not parts:
        return ""
    return f'<section id="figures"><h2>The figures</h2>{"".join(parts)}</section>'


def _made(result: PaperResult) -> str:
    command = escape(result.command or "percuss paper")
    used = escape(", ".join(f"{name} {number}" for name, number in versions().items()))
    return (
        f"<p>Written by <code>{command}</code> in {result.seconds:.0f} s with {used}. Each figure "
        "comes as SVG and PNG, its data as NetCDF and CSV, with the parameters, the versions and "
        "the command inside.</p>"
    )
