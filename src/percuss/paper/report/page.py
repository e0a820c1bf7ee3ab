"""The report as one page that needs nothing else: formulas, figures and style are inside."""

from __future__ import annotations

import base64
from collections import Counter
from datetime import UTC, datetime
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from percuss.paper.claim import Claim, ClaimKind
from percuss.paper.figure_files import Drawn, versions
from percuss.paper.report.claims import badge, claim_article, grade_mark
from percuss.paper.report.prose import prose
from percuss.paper.report.tables import printed_tables, table_anchors
from percuss.paper.sections import SECTIONS, ReportSection
from percuss.paper.statement import Grade

if TYPE_CHECKING:
    from percuss.paper.run import PaperResult

__all__ = ["page"]

# A larger SVG would make the page slow on a telephone: its PNG stands there instead [bytes].
LARGEST_SVG = 400_000
KINDS = ("figure", "statement")
NETCDF = ".nc"
COUNTS: dict[ClaimKind, str] = {
    "holds": "hold as printed",
    "corrected": "hold with a correction",
    "fails": "fail",
    "undecided": "are undecided",
}

GRADES: tuple[Grade, ...] = ("derived", "certified", "numerical")


def page(result: PaperResult) -> str:
    """Return the report as HTML.

    Parameters
    ----------
    result
        What came out of the run; its figures are read from their files.

    Returns
    -------
    str
        One page without any reference to the network.
    """
    used = {item.section for item in result.items}
    sections = [section for section in SECTIONS if section.name in used]
    made = versions()
    template = Template(_text("page.html"))
    return template.substitute(
        style=_text("page.css"),
        version=escape(made["percuss"]),
        date=datetime.now(UTC).strftime("%d %B %Y"),
        warning=_warning(result),
        counts=_counts(list(result.claims.values())),
        contents=_contents(sections, result),
        summary=_summary(result),
        tables=printed_tables(_in_order(result)),
        sections="".join(_section(result, section) for section in sections),
        command=escape(result.command or "percuss paper"),
        seconds=f"{result.seconds:.0f} s",
        versions=escape(", ".join(f"{name} {number}" for name, number in made.items())),
    )


def _text(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def _in_order(result: PaperResult) -> list[Claim]:
    names = (item.name for item in result.items if item.kind == "statement")
    return [result.claims[name] for name in names if name in result.claims]


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


def _counts(claims: list[Claim]) -> str:
    if not claims:
        return ""
    number = Counter(claim.kind for claim in claims)
    cells = "".join(
        f'<div><b class="{kind}">{number[kind]}</b><span>{words}</span></div>'
        for kind, words in COUNTS.items()
    )
    grades = Counter(claim.grade for claim in claims)
    words = ", ".join(f"{grades[name]} {name}" for name in GRADES if grades[name])
    return (
        f'<p>Of {len(claims)} statements</p><div class="counts">{cells}</div>'
        f'<p class="small">The verdicts are {words}.</p>'
    )


def _contents(sections: list[ReportSection], result: PaperResult) -> str:
    entries = [("summary", "All verdicts")] if result.claims else []
    entries += table_anchors(_in_order(result))
    entries += [(section.name, section.title) for section in sections]
    return "".join(f'<li><a href="#{name}">{prose(title)}</a></li>' for name, title in entries)


def _summary(result: PaperResult) -> str:
    claims = _in_order(result)
    if not claims:
        return ""
    rows = "".join(
        f'<tr><td><a href="#{escape(claim.id)}">{escape(claim.reference)}</a></td>'
        f"<td>{prose(claim.claim)}</td><td>{badge(claim)} {grade_mark(claim)}</td></tr>"
        for claim in claims
    )
    return (
        '<h2 id="summary">All verdicts</h2><div class="scroll"><table class="summary"><thead><tr>'
        f"<th>Where</th><th>Claim</th><th>Verdict</th></tr></thead><tbody>{rows}</tbody></table>"
        "</div>"
    )


def _section(result: PaperResult, section: ReportSection) -> str:
    inside = [item for item in result.items if item.section == section.name]
    # A figure and a statement about it may have the same name.
    asked = {kind: [item.name for item in inside if item.kind == kind] for kind in KINDS}
    claims = [result.claims[name] for name in asked["statement"] if name in result.claims]
    figures = [result.figures[name] for name in asked["figure"] if name in result.figures]
    return (
        f'<section><h2 id="{section.name}">{escape(section.title)}</h2>'
        f"<p>{prose(section.about)}</p>"
        f"{''.join(map(claim_article, claims))}{''.join(map(_figure, figures))}</section>"
    )


def _figure(drawn: Drawn) -> str:
    number = drawn.name.removeprefix("fig")
    heading = f"Figure {number}" if drawn.name.startswith("fig") else "Beyond the paper"
    links = ", ".join(f'<a href="{escape(file.name)}">{_format(file)}</a>' for file in drawn.files)
    return (
        f'<figure id="figure-{escape(drawn.name)}"><img src="{_picture(drawn)}" '
        f'alt="{escape(f"{heading}: {drawn.title}", quote=True)}">'
        f"<figcaption><strong>{escape(heading)}. {prose(drawn.title)}.</strong> "
        f'{prose(drawn.caption)} <span class="files">{links}</span></figcaption></figure>'
    )


def _format(file: Path) -> str:
    return "NetCDF" if file.suffix == NETCDF else file.suffix[1:].upper()


def _picture(drawn: Drawn) -> str:
    """Return the picture as a data address: the SVG, or the PNG where that is too large."""
    by_suffix: dict[str, Path] = {file.suffix: file for file in drawn.files}
    svg = by_suffix[".svg"].read_bytes()
    if len(svg) <= LARGEST_SVG:
        return f"data:image/svg+xml;base64,{base64.b64encode(svg).decode()}"
    return f"data:image/png;base64,{base64.b64encode(by_suffix['.png'].read_bytes()).decode()}"
