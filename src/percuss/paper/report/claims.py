"""A record in the report: verdict and formulas in sight, all else opens."""

from __future__ import annotations

from html import escape

from percuss.paper.article import Passage, passages_of
from percuss.paper.claim import Claim
from percuss.paper.evidence import Deduction
from percuss.paper.report.evidence_table import agreeing_range, evidence_table, number
from percuss.paper.report.formulas import formula_svg
from percuss.paper.report.prose import prose, sentence
from percuss.studies.link import link_of
from percuss.studies.reading import parse_study

DOCUMENTATION = "docs/theory"
# What can be done with a study: computed, and opened in the workbench.
VERBS = ("run", "serve")


def badge(claim: Claim) -> str:
    """Return the verdict in a word, coloured."""
    return f'<span class="badge {claim.kind}">{claim.kind}</span>'


def grade_mark(claim: Claim) -> str:
    """Return what the verdict rests on, in a word."""
    return f'<span class="ground {claim.grade}">{claim.grade}</span>'


def formula_pair(printed: str, right: str, name: str = "", *, is_printed: bool = True) -> str:
    """Return a formula of the article, and the right one beside it where there is one.

    Parameters
    ----------
    printed, right
        Mathtext without dollar signs; empty where there is none.
    name
        What stands before the words above the first.
    is_printed
        Whether the article prints the formula; else it puts words of the article into symbols.
    """
    if not printed:
        return ""
    words = "as printed" if is_printed else "as stated, in our symbols"
    above = f"{escape(name)} {words}" if name else words
    cells = [(above, printed, "printed"), ("right", right, "right")]
    boxes = "".join(
        f'<div class="{kind}"><span class="small">{words}</span>'
        f'<div class="formula-box">{formula_svg(formula)}</div></div>'
        for words, formula, kind in cells
        if formula
    )
    return f'<div class="pair">{boxes}</div>' if right else f'<div class="single">{boxes}</div>'


def record_details(claim: Claim, section: str) -> str:
    """Return a record: a line with its claim and its verdict, which opens to all the rest.

    Parameters
    ----------
    claim
        The record.
    section
        Name of its section of the report.

    Returns
    -------
    str
        A ``details`` element whose attributes are what the table of records filters by.
    """
    words = f"{claim.id} {claim.reference} {claim.claim} {claim.finding.correction}".lower()
    return (
        f'<details class="record {claim.kind}" id="{escape(claim.id)}" '
        f'data-verdict="{claim.kind}" data-section="{escape(section)}" '
        f'data-evidence="{claim.grade}" data-text="{escape(words, quote=True)}">'
        f'<summary><span class="reference">{escape(claim.reference)}</span>'
        f'<span class="claim">{prose(claim.claim)}</span>'
        f'<span class="marks">{badge(claim)} {grade_mark(claim)}</span>'
        f"{_formulas(claim)}{_verdict(claim)}</summary>"
        f'<div class="inside">{_quotations(claim)}{_remark(claim)}'
        f"<h4>Evidence</h4>{evidence_table(claim.finding)}{_method(claim)}{_code(claim)}"
        f"{_study(claim)}</div></details>"
    )


def _formulas(claim: Claim) -> str:
    """Return the formulas of a record; what the article does not say has no words above it."""
    if claim.scope == "beyond":
        return f'<div class="single">{formula_svg(claim.formula)}</div>' if claim.formula else ""
    return formula_pair(claim.formula, claim.right_formula, is_printed=claim.is_printed)


def _verdict(claim: Claim) -> str:
    """Return what the verdict says beyond its badge: the correction, or what is true instead."""
    if claim.kind == "holds":
        return ""
    if claim.kind == "corrected":
        words, text = "Correction", sentence(claim.finding.correction)
    elif claim.kind == "undecided":
        words, text = "Open", sentence(claim.verdict)
    else:
        words, text = "Against it", _against(claim)
    said = f'<p class="verdict {claim.kind}"><b>{words}:</b> {prose(text)}</p>'
    instead = claim.finding.instead if claim.kind == "fails" else ""
    return said + (
        f'<p class="verdict"><b>Instead:</b> {prose(sentence(instead))}</p>' if instead else ""
    )


def _against(claim: Claim) -> str:
    """Return the first evidence that contradicts a statement."""
    item = next(item for item in claim.finding.printed if item.outcome == "differs")
    if isinstance(item, Deduction):
        return sentence(item.what)
    return f"{item.what}: {number(item.value, 6)} instead of {agreeing_range(item)}."


def _quotations(claim: Claim) -> str:
    quoted = "".join(
        f"<blockquote><p>{escape(passage.quote)}</p>{read_as(passage)}"
        f"<footer>{_place(passage.section)}, p. {passage.page}</footer></blockquote>"
        for passage in passages_of(claim.id)
    )
    return f"<h4>The article</h4>{quoted}" if quoted else ""


def read_as(passage: Passage) -> str:
    """Return how a passage reads whose lines the text has in disorder."""
    return (
        f'<p class="reading"><b>Read:</b> {prose(passage.reading)}</p>' if passage.reading else ""
    )


def _place(section: str) -> str:
    if section == "abstract":
        return "Abstract"
    return "Appendix A" if section == "A" else f"Section {section}"


def _remark(claim: Claim) -> str:
    remark = claim.finding.remark
    return f'<p class="remark">{prose(remark)}</p>' if remark else ""


def _method(claim: Claim) -> str:
    word = "Proof" if claim.grade == "deduced" else "Derivation"
    theory = (
        f" {word}: page <em>{escape(claim.theory.removesuffix('.md'))}</em> of the documentation "
        f"(<code>{DOCUMENTATION}/{escape(claim.theory)}</code>)."
        if claim.theory
        else ""
    )
    return f"<h4>Method</h4><p>{prose(sentence(claim.method))}{theory}</p>"


def _code(claim: Claim) -> str:
    name = f"<code>{escape(claim.code.name)}</code>"
    if not claim.code.text:
        return f'<p class="small">Computed by {name}.</p>'
    return (
        f'<details class="code"><summary>Computed by {name}</summary>'
        f'<pre tabindex="0">{escape(claim.code.text)}</pre></details>'
    )


def _study(claim: Claim) -> str:
    """Return the study of a record: its link to the workbench, its commands, and its text.

    The link leads to the workbench that shows the report (page.js); of a report on disk the
    second command opens one.
    """
    text, file = claim.finding.study, escape(claim.study_file)
    if not text:
        return ""
    link = link_of(parse_study(text, claim.study_file))
    commands = "".join(f'<code class="command">percuss {verb} {file}</code>' for verb in VERBS)
    return (
        f"<h4>Try it</h4><p>"
        f'<a class="workbench" href="../#{link}" target="_top" hidden>Open in the workbench</a> '
        f"{commands}</p>"
        f'<details class="code"><summary>The study <code>{file}</code></summary>'
        f'<p class="small"><a href="{file}">The file</a></p>'
        f'<pre tabindex="0">{escape(text)}</pre></details>'
    )
