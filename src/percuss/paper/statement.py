"""A statement of the paper, and the verdict that its evidence leads to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from percuss.paper.evidence import Deduction, Enclosure, Evidence
from percuss.paper.formula import Formula

Grade = Literal["deduced", "certified", "measured"]
Scope = Literal["article", "beyond"]
VerdictKind = Literal["holds", "corrected", "fails", "undecided"]


@dataclass(frozen=True)
class Finding:
    """What was found out about a statement.

    Parameters
    ----------
    printed
        Evidence on the statement as the article prints it.
    corrected
        Evidence on a corrected form, where the printed one fails.
    correction
        The corrected form in words and symbols, completing "holds with the correction ...".
    undecided
        Why nothing can be said, where this is so; empty otherwise.
    instead
        What is true in place of a statement that fails, in words and symbols.
    remark
        What else the reader should know.
    study
        A study in TOML that shows what was computed with: a motion, a diagram, a response; empty
        where the statement speaks of none.
    """

    printed: tuple[Evidence, ...]
    corrected: tuple[Evidence, ...] = ()
    correction: str = ""
    undecided: str = ""
    instead: str = ""
    remark: str = ""
    study: str = ""


@dataclass(frozen=True)
class Statement:
    """A formula, number or sentence of the article, and how to find out whether it is right.

    Parameters
    ----------
    id
        Short name, unique: "eq12", "table1-m5", "chaos-fig6b".
    reference
        Where the article has it: "(12)", "table 1", "fig 14", "section 5".
    claim
        What it says, in words.
    method
        How it is examined.
    find
        Computes the evidence.
    formula
        The numbered formula, or mathtext without dollar signs; empty where words are enough.
    theory
        File of docs/theory with the derivation; empty where there is none.
    scope
        Whether the article says it, or percuss does.
    """

    id: str
    reference: str
    claim: str
    method: str
    find: Callable[[], Finding]
    formula: Formula | str = ""
    theory: str = ""
    scope: Scope = "article"

    @property
    def is_printed(self) -> bool:
        """Whether its formula is one that the article prints."""
        return isinstance(self.formula, Formula) and bool(self.formula.shown)


def verdict_kind(finding: Finding) -> VerdictKind:
    """Return the verdict in a word, which follows from the evidence and from nothing else.

    Parameters
    ----------
    finding
        The evidence.

    Returns
    -------
    str
        "holds" if all evidence on the printed form agrees; "corrected" if some of it differs and
        all agrees with a form in which a sign, a term, a number or a condition is another;
        "fails" if some differs and no such form agrees, so that what is true says something else;
        else "undecided".

    Examples
    --------
    >>> from percuss.paper.evidence import compare
    >>> verdict_kind(Finding(printed=(compare("sum", 2.5, 2.0),)))
    'fails'
    """
    outcomes = {item.outcome for item in finding.printed}
    if finding.undecided or "differs" not in outcomes:
        return "holds" if outcomes == {"agrees"} and not finding.undecided else "undecided"
    return "corrected" if finding.corrected and _all_agree(finding.corrected) else "fails"


def judge(finding: Finding) -> str:
    """Return the verdict in a sentence.

    Parameters
    ----------
    finding
        The evidence.

    Returns
    -------
    str
        "holds", "holds with the correction ...", "fails", or "undecided because ...".

    Examples
    --------
    >>> from percuss.paper.evidence import compare
    >>> judge(Finding((compare("sum", 2.5, 2.0),), (compare("sum", 2.5, 2.5),), "5/2 for 2"))
    'holds with the correction 5/2 for 2'
    """
    kind = verdict_kind(finding)
    if kind == "corrected":
        return f"holds with the correction {finding.correction}"
    if kind != "undecided":
        return kind
    left_open = "; ".join(item.what for item in finding.printed if item.outcome == "open")
    reason = finding.undecided or f"the evidence leaves open: {left_open or 'nothing was computed'}"
    return f"undecided because {reason}"


def grade(finding: Finding) -> Grade:
    """Return what the verdict rests on.

    Parameters
    ----------
    finding
        The evidence.

    Returns
    -------
    str
        "deduced" where a deduction reaches the verdict; "certified" where every number that the
        verdict needs is certified; "measured" otherwise. Of a form that fails one certain
        disagreement is enough. Numbers speak of the cases that were computed, whatever their
        grade; only a deduction reaches further.

    Examples
    --------
    >>> from percuss.paper.evidence import compare
    >>> certain = compare("pi", 3.1415926, 3.0, 0.2, radius=1e-6)
    >>> grade(Finding((certain,)))
    'certified'
    >>> grade(Finding((certain, compare("sum", 2.0, 2.0))))
    'measured'
    """
    kind = verdict_kind(finding)
    if kind == "undecided":
        return "measured"
    if kind == "holds":
        return _grade_of(finding.printed)
    refuted = _grade_of_refutation(finding.printed)
    if kind == "fails":
        return refuted
    weakest: Sequence[Grade] = ("measured", "certified", "deduced")
    return min(refuted, _grade_of(finding.corrected), key=weakest.index)


def _grade_of(items: Sequence[Evidence]) -> Grade:
    """Return what a form that holds rests on; numbers beside a deduction illustrate it."""
    if any(isinstance(item, Deduction) for item in items):
        return "deduced"
    return "certified" if all(isinstance(item, Enclosure) for item in items) else "measured"


def _grade_of_refutation(items: Sequence[Evidence]) -> Grade:
    against = [item for item in items if item.outcome == "differs"]
    if any(isinstance(item, Deduction) for item in against):
        return "deduced"
    return "certified" if any(isinstance(item, Enclosure) for item in against) else "measured"


def _all_agree(items: Sequence[Evidence]) -> bool:
    return all(item.outcome == "agrees" for item in items)
