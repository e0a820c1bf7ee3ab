"""A statement in the report: formula, verdict, evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from percuss.paper.claim import Claim
from percuss.paper.report.formulas import formula_svg
from percuss.paper.report.prose import prose
from percuss.paper.statement import Check, Finding

__all__ = ["badge", "checks_table", "claim_article", "grade_mark", "mark", "number"]

BADGES = {
    "holds": "holds",
    "corrected": "corrected",
    "fails": "fails",
    "undecided": "undecided",
}
# Of what should be zero, few digits tell anything.
SMALL = 1e-6
# Longer tables are folded.
ROWS = 10


def badge(claim: Claim) -> str:
    """Return the verdict in a word or two, coloured."""
    return f'<span class="badge {claim.kind}">{BADGES[claim.kind]}</span>'


def grade_mark(claim: Claim) -> str:
    """Return what the verdict rests on, in a word."""
    return f'<span class="grade {claim.grade}">{claim.grade}</span>'


def number(value: float, digits: int = 12) -> str:
    """Return a number as the report shows it.

    Examples
    --------
    >>> number(1 / 3), number(1.2345678901234e-7), number(2.0), number(float("nan"))
    ('0.333333333333', '1.23e-07', '2', 'none')
    """
    if not math.isfinite(value):
        return "none" if math.isnan(value) else "infinite"
    if abs(value) < SMALL:
        digits = min(digits, 3)
    words = f"{abs(value):.{digits}g}"
    return f"\u2212{words}" if value < 0 else words


def claim_article(claim: Claim) -> str:
    """Return a statement with its verdict, its evidence and how it was examined."""
    finding = claim.finding
    formula = ""
    if claim.formula:
        formula = f'<div class="formula-box">{formula_svg(claim.formula)}</div>'
    remark = f"<p>{prose(finding.remark)}</p>" if finding.remark else ""
    word = "Proof" if claim.grade == "derived" else "Derivation"
    marks = f'<span class="marks">{badge(claim)}{grade_mark(claim)}</span>'
    theory = f" {word}: <code>{escape(claim.theory)}</code>." if claim.theory else ""
    return (
        f'<article id="{escape(claim.id)}"><header><h3><span class="reference">'
        f"{escape(claim.reference)}</span> {prose(claim.claim)}</h3>{marks}</header>"
        f"{formula}{_verdict(claim)}{remark}"
        f"{checks_table(finding)}"
        f'<p class="small facts">{escape(_sentence(claim.method))} Certainty: '
        f"{escape(_sentence(claim.certainty))}{theory}</p></article>"
    )


def _verdict(claim: Claim) -> str:
    """Return what the verdict says beyond its badge."""
    if claim.kind == "corrected":
        words = f"<b>Correction.</b> {prose(_sentence(claim.finding.correction))}"
    elif claim.kind == "undecided":
        words = prose(_sentence(claim.verdict))
    else:
        return ""
    return f'<p class="verdict {claim.kind}"><span>{words}</span></p>'


def _sentence(text: str) -> str:
    """Return a text with a capital and a full stop."""
    stripped = text.strip().rstrip(".")
    # A symbol stays as it is.
    first = stripped.split(" ", 1)[0]
    begun = stripped[:1].upper() + stripped[1:] if first.isalpha() and len(first) > 2 else stripped
    return f"{begun}." if stripped else ""


def checks_table(finding: Finding) -> str:
    """Return the comparisons as a table, folded where it is long."""
    groups = {"As printed": finding.printed, "Corrected": finding.corrected}
    body = "".join(_group(title, checks) for title, checks in groups.items() if checks)
    if not body:
        return ""
    table = f'<div class="scroll"><table class="evidence">{body}</table></div>'
    every = (*finding.printed, *finding.corrected)
    if len(every) <= ROWS:
        return table
    agree = ", ".join(
        f"{title.lower()} {sum(check.passed for check in checks)} of {len(checks)}"
        for title, checks in groups.items()
        if checks
    )
    return f"<details><summary>Comparisons that agree: {agree}</summary>{table}</details>"


def _group(title: str, checks: Sequence[Check]) -> str:
    """Return the rows of one form of a statement; both forms share their columns."""
    heads = "".join(
        f'<th class="number">{word}</th>' for word in ("measured", "expected", "difference")
    )
    return (
        f'<tbody><tr><th>{title}</th>{heads}<th class="number">allowed</th><th></th></tr>'
        f"{''.join(map(_row, checks))}</tbody>"
    )


def mark(check: Check) -> str:
    """Return a tick where measured and expected agree, else a cross."""
    word, sign = ("holds", "\u2713") if check.passed else ("fails", "\u2717")
    return f'<span class="{word}">{sign}</span>'


def _row(check: Check) -> str:
    cells = (
        number(check.measured),
        number(check.expected),
        number(check.difference, 2),
        number(check.tolerance, 2),
    )
    certain = '<span class="certain" title="proven in ball arithmetic">certified</span>'
    note = f" {certain}" if check.is_certain else ""
    numbers = "".join(f'<td class="number">{cell}</td>' for cell in cells)
    return (
        f'<tr><td>{prose(check.what)}{note}</td>{numbers}<td class="mark">{mark(check)}</td></tr>'
    )
