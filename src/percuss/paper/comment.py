"""The report in the form of a comment to a journal, comment.pdf, set by Typst.

Nothing is found out here: each sentence on a record, each number and each formula comes from the
claims of the run.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from datetime import UTC, datetime
from html import unescape
from importlib import resources

import typst

from percuss.paper.article import article_source, passages
from percuss.paper.chain import BREAK, LINES, ChainLine
from percuss.paper.claim import Claim
from percuss.paper.dependence import falls_with
from percuss.paper.evidence import Deduction, Enclosure, Evidence
from percuss.paper.figure_files import Drawn, versions
from percuss.paper.findings import errors_of_their_own
from percuss.paper.report.evidence_table import number
from percuss.paper.report.formulas import formula_svg, outlines
from percuss.paper.report.prose import prose
from percuss.paper.result import PaperResult

# Those that show what is corrected and what fails.
FIGURES = ("fig11", "fig12", "fig6")
# The verdicts, and what opens the section on each.
SECTIONS = {
    "holds": "",
    "corrected": "These statements hold with another sign, term, number or condition.",
    "fails": "No change of a sign, a term, a number or a condition makes these statements hold: what "
    "is true says something else.",
    "undecided": "",
}
QUESTION = (
    "studies x'' + x = f(t) on x > 0 with elastic impacts at x = 0: which sets of impact times a "
    "periodic force can have, when the motion is periodic, and when a force makes it grow without "
    "bound. We ask of each of its statements whether it is right."
)
ONE_RULE = "Formulas are judged by this rule alike."
METHOD = (
    "Between impacts the motion is known in closed form, and the next impact is the first root of "
    "a function with known bounds on its derivatives, so that no impact is missed. A verdict rests "
    "on one of three kinds of evidence. Deduced: a chain of identities and inequalities, carried "
    "out by computer algebra and ball arithmetic, and of known theorems and arguments in words "
    "that the report marks as such. Certified: numbers enclosed in ball arithmetic. Measured: "
    "numbers in floating point with their errors. A statement holds if all evidence agrees with "
    "it; it is corrected if some differs, and all agrees with a form in which a sign, a term, a "
    "number or a condition is another; it fails if some differs and no such form agrees; it is "
    "undecided if the evidence leaves it open."
)
CHAIN = (
    "Section 5 derives (35) from (27). Each printed line was held against the right ones before "
    "it by computer algebra. A slip that no later line rests on does no harm; the derivation "
    "breaks where one does."
)
CODE = (
    "All of this is computed by one command, percuss paper, which writes this comment, a page with "
    "the evidence of each record, the data of each figure, and claims.json."
)
# Of a number; the report has all of them.
DIGITS = 6
# A run of prose: how it is set ("", "i", "sub", "sup", "code"), and its text.
ProseRun = tuple[str, str]


def comment_pdf(result: PaperResult) -> bytes:
    """Return the comment on the article as a PDF.

    Parameters
    ----------
    result
        What came out of the run; the pictures are read from its files.

    Returns
    -------
    bytes
        The PDF: question, source and method, what holds, what is corrected and how, what fails,
        what goes beyond the article, data and code.
    """
    pdf = typst.compile(template(), format="pdf", sys_inputs={"data": comment_data(result)})
    assert isinstance(pdf, bytes)
    return pdf


def template() -> bytes:
    """Return the comment without its data, in Typst."""
    return resources.files("percuss.paper").joinpath("comment.typ").read_bytes()


def comment_data(result: PaperResult) -> str:
    """Return what the template sets, as JSON."""
    return json.dumps(_data(result), ensure_ascii=False)


def _data(result: PaperResult) -> dict[str, object]:
    names = [item.name for item in result.items if item.kind == "statement"]
    claims = [result.claims[name] for name in names if name in result.claims]
    article = [claim for claim in claims if claim.scope == "article"]
    beyond = [claim for claim in claims if claim.scope == "beyond"]
    of_kind: dict[str, list[Claim]] = {
        kind: [claim for claim in article if claim.kind == kind] for kind in SECTIONS
    }
    source, made = article_source(), versions()
    right = sum(claim.kind == "holds" for claim in beyond)
    about_holding = f"These {len(of_kind['holds'])} statements hold as printed."
    about_beyond = (
        "The same computations gave statements that the article does not make. "
        f"{right} of {len(beyond)} hold."
    )
    pictures = [result.figures[name] for name in FIGURES if name in result.figures]
    return {
        "title": "Comment on “Periodic motions and resonances of impact oscillators”",
        "author": f"percuss {made['percuss']}",
        "date": datetime.now(UTC).strftime("%d %B %Y").lstrip("0"),
        "abstract": _runs(
            _abstract(
                {kind: len(of_one_kind) for kind, of_one_kind in of_kind.items()},
                len(errors_of_their_own(article)),
            )
        ),
        "question": _runs(f"{source.citation}, {QUESTION}"),
        "method": [_runs(f"{source.extraction} {source.rule} {ONE_RULE}"), _runs(METHOD)],
        "holds": {"about": _runs(about_holding), "rows": list(map(_row, of_kind["holds"]))},
        **{
            kind: {"about": _runs(about), "records": list(map(_record, of_kind[kind]))}
            for kind, about in SECTIONS.items()
            if kind != "holds"
        },
        "chain": _chain(result.claims),
        "figures": [
            {
                "png": list(_picture(drawn)),
                "caption": _runs(f"{_figure(drawn.name)} of the article. {drawn.caption}"),
            }
            for drawn in pictures
        ],
        "beyond": {"about": _runs(about_beyond), "rows": list(map(_row, beyond))},
        "code": [
            _runs(
                f"{CODE} It was made with "
                f"{', '.join(f'{name} {number}' for name, number in made.items())}, in "
                f"{result.seconds:.0f} s."
            ),
        ],
    }


def _abstract(counts: dict[str, int], own: int) -> str:
    examined = sum(bool(passage.records) for passage in passages())
    return (
        "We recomputed every formula, number, figure and statement of the article that can be "
        f"examined: {examined} of its {len(passages())} sentences, formulas, captions and tables, "
        f"in {sum(counts.values())} records. {counts['holds']} hold as printed, "
        f"{counts['corrected']} with a correction, {counts['fails']} fail, and "
        f"{counts['undecided']} are left undecided. Behind those that do not hold as printed stand "
        f"{own} errors; the others repeat one of these, on which the article rests them. Each "
        "verdict follows from numbers with their errors, from enclosures in ball arithmetic, or from deductions that are carried out "
        "whenever the report is made."
    )


def _chain(claims: Mapping[str, Claim]) -> dict[str, object]:
    """Return the derivation (27) to (35), without rows where no line of it was examined."""
    lines = [line for line in LINES if line.record in claims]
    fallen = [
        claims[record].reference
        for line in lines
        if line.is_break
        for record in falls_with(line.record)
        # The derivation as a whole is what is spoken of.
        if record in claims and record != "chain"
    ]
    rests = f" On ({BREAK}) rest {', '.join(dict.fromkeys(fallen))}." if fallen else ""
    return {
        "about": _runs(CHAIN + rests),
        "rows": [_chain_row(line) for line in lines],
    }


def _chain_row(line: ChainLine) -> dict[str, object]:
    formula = line.formula
    return {
        "number": f"({formula.number})",
        "step": _runs(line.step),
        "printed": _pictures(formula.tex()),
        "right": [] if formula.right is None else _pictures(formula.tex(right=True)),
        "follows": line.follows,
        "breaks": line.is_break,
        "survives": _runs(line.survives),
    }


def _row(claim: Claim) -> dict[str, object]:
    return {
        "reference": claim.reference[:1].upper() + claim.reference[1:],
        "claim": _runs(claim.claim),
        "grade": claim.grade,
        "kind": claim.kind,
    }


def _record(claim: Claim) -> dict[str, object]:
    return {
        **_row(claim),
        # The forms of a line of the derivation stand in its table.
        "in_table": claim.id in {line.record for line in LINES},
        "printed": _pictures(claim.formula),
        "right": _pictures(claim.right_formula),
        "printed_as": "printed" if claim.is_printed else "stated",
        "correction": _runs(claim.finding.correction),
        "instead": _runs(claim.finding.instead),
        "open": _runs(claim.finding.undecided),
        "evidence": _runs(_decisive(claim)),
    }


def _decisive(claim: Claim) -> str:
    """Return the evidence that decides, in a sentence."""
    printed, corrected = claim.finding.printed, claim.finding.corrected
    against = [item for item in printed if item.outcome != "agrees"] or list(printed)
    said = [_said(item) for item in (*against[:1], *corrected[:1])]
    rest = len(printed) + len(corrected) - len(said)
    more = f" ({rest} more in the report)" if rest > 0 else ""
    return "; ".join(said) + more + "."


def _said(item: Evidence) -> str:
    if isinstance(item, Deduction):
        count = len(item.steps)
        return f"{item.what}, in {count} step{'s' if count > 1 else ''}"
    value = _with_error(item.value, item.radius if isinstance(item, Enclosure) else item.error)
    if item.expected is not None:
        wanted = _with_error(item.expected, item.high - item.expected)
        return f"{item.what}: {value}, where {wanted} is stated"
    low, high = number(item.low, DIGITS), number(item.high, DIGITS)
    if math.isinf(item.high):
        return f"{item.what}: {value}, where {low} or more agrees"
    if math.isinf(item.low):
        return f"{item.what}: {value}, where {high} or less agrees"
    return f"{item.what}: {value}, where {low} to {high} agrees"


def _with_error(value: float, error: float) -> str:
    """Return a number, with its error where that is seen in its digits.

    Examples
    --------
    >>> _with_error(0.1633816749, 2.5e-15), _with_error(0.61, 0.005)
    ('0.163382', '0.61 +- 0.005')
    """
    shown = number(value, DIGITS)
    return shown if error <= 10.0**-DIGITS * abs(value) else f"{shown} +- {number(error, 2)}"


def _figure(name: str) -> str:
    """Return the name of a figure as the article has it.

    Examples
    --------
    >>> _figure("fig11")
    'Figure 11'
    """
    return name.replace("fig", "Figure ")


def _runs(text: str) -> list[ProseRun]:
    """Return a sentence as runs of text, each with how it is set.

    Examples
    --------
    >>> _runs("V_k of x''")
    [('i', 'V'), ('sub', 'k'), ('', ' of x″')]
    """
    parts = re.split(r"<(i|sub|sup|code)>(.*?)</\1>", prose(text))
    runs: list[ProseRun] = []
    for i in range(0, len(parts), 3):
        if parts[i]:
            runs.append(("", unescape(parts[i])))
        if i + 2 < len(parts):
            runs.append((parts[i + 1], unescape(parts[i + 2])))
    return runs


def _pictures(formula: str) -> list[dict[str, object]]:
    """Return a formula as SVG files, one for each line, with the width in units of the text."""
    pictures: list[dict[str, object]] = []
    for svg in re.findall(r"<svg.*?</svg>", formula_svg(formula)):
        width, height = (
            float(size) for size in re.findall(r"(?:width|height):([0-9.]+)em", svg)[:2]
        )
        head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}em" height="{height}em" '
        plain = re.sub(r' style="[^"]*"| class="[^"]*"| role="[^"]*"| aria-label="[^"]*"', "", svg)
        # The outlines stand in the file itself: there is no page around it.
        alone = plain.replace(">", f">{outlines(svg)}", 1)
        pictures.append({"svg": alone.replace("<svg ", head, 1), "width": width})
    return pictures


def _picture(drawn: Drawn) -> bytes:
    (file,) = (file for file in drawn.files if file.suffix == ".png")
    return file.read_bytes()
