"""The list of records: counts that are links, a form that filters, failures first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import get_args

from percuss.paper.claim import Claim
from percuss.paper.findings import errors_of_their_own
from percuss.paper.report.claims import record_details
from percuss.paper.report.prose import prose, sentence
from percuss.paper.sections import SECTIONS
from percuss.paper.statement import Grade, VerdictKind

RecordEntry = tuple[Claim, str]
COUNTS: dict[VerdictKind, str] = {
    "fails": "fail",
    "corrected": "hold with a correction",
    "undecided": "are undecided",
    "holds": "hold",
}
# In a sentence.
TOLD: tuple[VerdictKind, ...] = ("holds", "corrected", "fails", "undecided")
GRADES: tuple[Grade, ...] = get_args(Grade)


def counts(entries: Sequence[RecordEntry]) -> str:
    """Return how many records have each verdict, as links to the records that have it.

    Parameters
    ----------
    entries
        Records of one scope, each with the name of its section.
    """
    if not entries:
        return ""
    number = Counter(claim.kind for claim, _ in entries)
    # What is not the article's is printed nowhere.
    printed = " as printed" if any(claim.scope == "article" for claim, _ in entries) else ""
    cells = "".join(
        f'<a href="?verdict={kind}#records"><b class="{kind}">{number[kind]}</b>'
        f"<span>{words}{printed if kind == 'holds' else ''}</span></a>"
        for kind, words in COUNTS.items()
    )
    claims = [claim for claim, _ in entries]
    grades = Counter(claim.grade for claim in claims)
    words = ", ".join(
        f'<a href="?evidence={name}#records">{grades[name]} {name}</a>'
        for name in GRADES
        if grades[name]
    )
    noun = "statement" if len(entries) == 1 else "statements"
    return (
        f'<p class="of">Of <a href="?#records">{len(entries)} {noun}</a></p>'
        f'<div class="counts">{cells}</div><p class="small">The verdicts are {words}.</p>'
    )


def summary(entries: Sequence[RecordEntry]) -> str:
    """Return in a sentence how many statements hold, and how many errors stand behind the others.

    Parameters
    ----------
    entries
        Records of the article, each with the name of its section.
    """
    claims = [claim for claim, _ in entries]
    number = Counter(claim.kind for claim in claims)
    wrong, own = number["fails"] + number["corrected"], len(errors_of_their_own(claims))
    if not wrong:
        return ""
    said = ", ".join(f"{number[kind]} {COUNTS[kind]}" for kind in TOLD if number[kind])
    errors = f"{own} independent errors" if own > 1 else "one error"
    rest = wrong - own
    more = ""
    if rest:
        which = "one repeats" if rest == 1 else f"{rest} repeat"
        more = f"; the other {which} an error in what the article derives them from"
    return (
        f"Of {len(claims)} statements {said}. Behind the {wrong} that do not hold as printed stand "
        f"{errors}{more}."
    )


def failures(entries: Sequence[RecordEntry]) -> str:
    """Return the statements that fail, each with what is true instead; empty where none does."""
    rows = "".join(
        f'<li><a href="#{escape(claim.id)}">{escape(claim.reference)}</a> '
        f"{prose(claim.claim)} <b>Instead:</b> {prose(sentence(claim.finding.instead))}</li>"
        for claim, _ in entries
        if claim.kind == "fails"
    )
    return f'<section id="failures"><h2>What fails</h2><ul>{rows}</ul></section>' if rows else ""


def records(entries: Sequence[RecordEntry]) -> str:
    """Return the records, those that fail first, with a form that filters them.

    Parameters
    ----------
    entries
        Records, each with the name of its section, in the order of the report.
    """
    if not entries:
        return ""
    order = list(COUNTS)
    ordered = sorted(entries, key=lambda entry: order.index(entry[0].kind))
    listed = "".join(record_details(claim, section) for claim, section in ordered)
    return (
        f'<section id="records"><h2>The records</h2>{_form(entries)}'
        f'<div class="records">{listed}</div></section>'
    )


def _form(entries: Sequence[RecordEntry]) -> str:
    used = {section for _, section in entries}
    sections = {row.name: row.title for row in SECTIONS if row.name in used}
    fields = (
        _select("verdict", "Verdict", {kind: kind for kind in COUNTS}),
        _select("section", "Section", sections),
        _select("evidence", "Evidence", {grade: grade for grade in GRADES}),
        '<label>Text <input type="search" name="text" placeholder="(33), eigenset, ..."></label>',
    )
    return (
        f'<form class="filter" role="search" aria-label="Records" hidden>{"".join(fields)}'
        f'<output aria-live="polite">{len(entries)} of {len(entries)}</output></form>'
    )


def _select(name: str, label: str, options: dict[str, str]) -> str:
    choices = "".join(
        f'<option value="{escape(value)}">{prose(words)}</option>'
        for value, words in options.items()
    )
    return f'<label>{label} <select name="{name}"><option value="">all</option>{choices}</select></label>'
