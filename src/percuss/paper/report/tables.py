"""Tables 1 and 2 of the paper beside what was computed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

from percuss.paper.claim import Claim
from percuss.paper.evidence import Comparison, Deduction
from percuss.paper.report.claims import badge
from percuss.paper.report.evidence_table import expected, mark, number
from percuss.paper.report.prose import prose

TITLES = {
    "table 1": "Table 1: the critical velocity V*(m) of the example",
    "table 2": "Table 2: the critical velocity V_max(n) of odd harmonics",
}
# What a comparison with a printed number is called: "V*(5) = ...", "V_max(5) = ...".
ENTRY = re.compile(r"V[*_]")


def about_table(claims: Sequence[Claim], reference: str) -> list[Claim]:
    """Return the statements about a table."""
    return [claim for claim in claims if claim.reference.lower().startswith(reference)]


def table_rows(claims: Sequence[Claim], reference: str) -> list[tuple[Comparison, Claim]]:
    """Return the comparisons with the printed entries of a table, each with its statement."""
    return [
        (check, claim)
        for claim in about_table(claims, reference)
        for check in claim.finding.printed
        if not isinstance(check, Deduction) and ENTRY.match(check.what)
    ]


def printed_tables(claims: Sequence[Claim]) -> str:
    """Return both tables as HTML: printed, computed, difference; empty without such statements."""
    return "".join(_table(claims, name, title) for name, title in TITLES.items())


def table_anchors(claims: Sequence[Claim]) -> list[tuple[str, str]]:
    """Return the anchor and the title of each table that the page shows."""
    shown = [name for name in TITLES if about_table(claims, name)]
    return [(_anchor(name), TITLES[name]) for name in shown]


def _anchor(reference: str) -> str:
    return reference.replace(" ", "-")


def _table(claims: Sequence[Claim], reference: str, title: str) -> str:
    about = about_table(claims, reference)
    if not about:
        return ""
    body = "".join(
        f"<tr><td>{prose(check.what.partition(' = ')[0])}</td>"
        f'<td class="number">{number(expected(check))}</td>'
        f'<td class="number">{check.value:.12f}</td>'
        f'<td class="number">{number(check.value - expected(check), 2)}</td>'
        f'<td class="mark">{mark(check)}</td></tr>'
        for check, _ in table_rows(claims, reference)
    )
    said = "".join(
        f'<li><a href="#{escape(claim.id)}">{prose(claim.claim)}</a> {badge(claim)} '
        f"({_agreeing(claim)})</li>"
        for claim in about
    )
    table = (
        '<div class="scroll"><table><thead><tr><td></td><th class="number">printed</th>'
        '<th class="number">computed</th><th class="number">difference</th><th></th></tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )
    return f'<h2 id="{_anchor(reference)}">{prose(title)}</h2>{table}<ul class="small">{said}</ul>'


def _agreeing(claim: Claim) -> str:
    checks = claim.finding.printed
    return (
        f"{sum(check.outcome == 'agrees' for check in checks)} of {len(checks)} comparisons agree"
    )
