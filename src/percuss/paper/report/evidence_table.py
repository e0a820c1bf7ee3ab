"""The evidence on a statement as a table: numbers in rows, deductions step by step."""

from __future__ import annotations

import math
from collections.abc import Sequence

from percuss.paper.evidence import Comparison, Deduction, Enclosure, Evidence
from percuss.paper.report.formulas import formula_svg
from percuss.paper.report.prose import prose
from percuss.paper.statement import Finding

# Of what should be zero, few digits tell anything.
SMALL = 1e-6
# Longer tables are folded.
ROWS = 10
# What carried out a step of a deduction.
BY = {
    "algebra": "algebra, by SymPy",
    "balls": "ball arithmetic",
    "theorem": "theorem",
    "argument": "argued in words",
}


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


def evidence_table(finding: Finding) -> str:
    """Return the evidence as a table, folded where it is long."""
    groups = {"As stated": finding.printed, "Corrected": finding.corrected}
    body = "".join(_group(title, checks) for title, checks in groups.items() if checks)
    if not body:
        return ""
    table = f'<div class="scroll"><table class="evidence">{body}</table></div>'
    if len(finding.printed) + len(finding.corrected) <= ROWS:
        return table
    agree = ", ".join(
        f"{title.lower()} {sum(check.outcome == 'agrees' for check in checks)} of {len(checks)}"
        for title, checks in groups.items()
        if checks
    )
    return f"<details><summary>Comparisons that agree: {agree}</summary>{table}</details>"


def _group(title: str, items: Sequence[Evidence]) -> str:
    """Return the rows of one form of a statement; both forms share their columns."""
    words = ("value", "± error", "agrees within")
    heads = "".join(f'<th class="number" scope="col">{word}</th>' for word in words)
    rows = "".join(map(_row, items))
    return f'<tbody><tr><th scope="col">{title}</th>{heads}<th></th></tr>{rows}</tbody>'


def mark(item: Evidence) -> str:
    """Return a tick where an item agrees, a cross where it differs, else a question mark."""
    sign, said = {
        "agrees": ("\u2713", "holds"),
        "differs": ("\u2717", "fails"),
        "open": ("?", "undecided"),
    }[item.outcome]
    word = "left open" if item.outcome == "open" else item.outcome
    return f'<span class="{said}" role="img" aria-label="{word}" title="{word}">{sign}</span>'


def expected(item: Comparison) -> float:
    """Return the number that a comparison expects: the printed one, or the end of its range."""
    if item.expected is not None:
        return item.expected
    return item.low if math.isfinite(item.low) else item.high


def agreeing_range(item: Comparison) -> str:
    """Return the range that agrees: a number and how far off it may be, or its ends."""
    if item.expected is not None:
        allowed = item.high - item.expected
        return number(item.expected) + (f" \u00b1 {number(allowed, 2)}" if allowed else "")
    if math.isinf(item.high):
        return f"\u2265 {number(item.low)}"
    if math.isinf(item.low):
        return f"\u2264 {number(item.high)}"
    return f"{number(item.low)} to {number(item.high)}"


def _row(item: Evidence) -> str:
    if isinstance(item, Deduction):
        return _steps(item)
    is_certified = isinstance(item, Enclosure)
    kind = "certified" if is_certified else "measured"
    cells = (number(item.value), _error(item), agreeing_range(item))
    numbers = "".join(f'<td class="number">{cell}</td>' for cell in cells)
    return (
        f'<tr><td>{prose(item.what)} <span class="ground {kind}">{kind}</span></td>'
        f'{numbers}<td class="mark">{mark(item)}</td></tr>'
    )


def _error(item: Comparison) -> str:
    """Return the error of a number, or that it is a count."""
    if isinstance(item, Enclosure):
        return f"\u00b1 {number(item.radius, 2)}"
    return "a count" if item.is_count else f"\u00b1 {number(item.error, 2)}"


def _steps(item: Deduction) -> str:
    """Return a deduction, its steps in order, each with what carried it out."""
    steps = "".join(
        f"<li>{prose(step.text)} {formula_svg(step.formula) if step.formula else ''}"
        f'<span class="small">{BY[step.by]}{"" if step.holds else ": does not come out"}</span>'
        "</li>"
        for step in item.steps
    )
    return (
        f'<tr class="steps"><td colspan="4">{prose(item.what)} '
        f'<span class="ground deduced">deduced</span><ol>{steps}</ol></td>'
        f'<td class="mark">{mark(item)}</td></tr>'
    )
